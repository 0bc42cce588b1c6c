"""The maneuver to plan."""

from __future__ import annotations

import json
import os
import warnings
from typing import Any, Mapping, Union

import numpy as np
from numpy.typing import NDArray

from . import _slewkit
from ._errors import Diagnostic, SpecWarning

#: A spec: a dictionary with its keys, the path of a file, or a maneuver that has been read.
SpecLike = Union[Mapping[str, Any], str, "os.PathLike[str]", "Problem"]


class Problem:
    """The maneuver of a spec, read and checked.

    ``spec`` is a dictionary with the keys of a spec file, or the path of a TOML or JSON file.
    Values are numbers, text, lists, NumPy arrays; an attitude may be a SciPy ``Rotation``, which
    maps body to reference components. The keys state the units. ``overrides`` sets keys by their
    path, as ``--set`` does: ``{"maneuver.duration_s": 90, "constraint.0.half_angle_deg": 25}``.

    Raises :class:`SpecError` with all errors, :class:`FileError` if a file cannot be read.
    """

    __slots__ = ("_maneuver",)

    def __init__(
        self, spec: Mapping[str, Any] | str | os.PathLike[str], *, overrides: Mapping[str, Any] | None = None
    ) -> None:
        self._maneuver = _slewkit.Maneuver(spec, overrides)
        for finding in self.warnings:
            warnings.warn(str(finding), SpecWarning, stacklevel=2)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, overrides: Mapping[str, Any] | None = None) -> Problem:
        """Reads a spec file: JSON if its name ends in ``.json``, else TOML."""
        return cls(os.fspath(path), overrides=overrides)

    @classmethod
    def from_dict(cls, spec: Mapping[str, Any], *, overrides: Mapping[str, Any] | None = None) -> Problem:
        """Reads a dictionary with the keys of a spec."""
        return cls(spec, overrides=overrides)

    @property
    def name(self) -> str:
        """The name of the maneuver."""
        return self._maneuver.name

    @property
    def duration(self) -> float | None:
        """Duration in seconds; ``None`` if it is free."""
        return self._maneuver.duration

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self._maneuver.steps

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Inertia about the mass center, body axes, kg·m², shape (3, 3)."""
        return np.array(self._maneuver.inertia)

    @property
    def warnings(self) -> list[Diagnostic]:
        """The warnings."""
        return [Diagnostic(**keys) for keys in self._maneuver.warnings()]

    def to_dict(self) -> dict[str, Any]:
        """Returns the maneuver in the keys of a spec, with all defaults: SI units, attitudes as
        matrices. It reads back to an equal plan."""
        document: dict[str, Any] = json.loads(self._maneuver.spec_json())
        return document

    def to_toml(self) -> str:
        """Returns the maneuver as the text of a spec file."""
        return _slewkit.to_toml(self.to_dict())

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.to_dict(),)

    def __repr__(self) -> str:
        return f"<slewkit.Problem {self.name!r}, {self.steps} steps>"


def _again(spec: dict[str, Any]) -> Problem:
    """Restores a pickled maneuver, without repeating its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SpecWarning)
        return Problem(spec)


def maneuver_of(spec: SpecLike, overrides: Mapping[str, Any] | None) -> _slewkit.Maneuver:
    """Returns the maneuver of any form of a spec."""
    if isinstance(spec, Problem):
        if not overrides:
            return spec._maneuver
        maneuver = spec._maneuver.again(overrides)
    else:
        maneuver = _slewkit.Maneuver(spec, overrides)
    for keys in maneuver.warnings():
        warnings.warn(str(Diagnostic(**keys)), SpecWarning, stacklevel=3)
    return maneuver
