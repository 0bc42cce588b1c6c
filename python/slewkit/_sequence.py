"""The plan of a sequence of stops."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import Any, Mapping

import numpy as np
from numpy.typing import NDArray

from . import _slewkit
from ._commands import ProgressFunction, _told
from ._errors import OF_STATUS
from ._plan import Plan, written

#: Floats, with the shape in each docstring.
Array = NDArray[np.float64]


class SequencePlan:
    """The plan of a spec with stops; SI units, times from the start of the sequence.

    ``legs`` has a :class:`Plan` for each stop, whose times begin at zero. The arrays of this class cover
    the whole sequence: K + 1 nodes of all legs and rests, and K steps, over which inputs are held.

    :func:`slewkit.plan_sequence` returns a sequence plan.
    """

    def __init__(self, planned: _slewkit.PlannedSequence) -> None:
        self._planned = planned

    @cached_property
    def record(self) -> dict[str, Any]:
        """The keys and values of the plan file except its legs."""
        record: dict[str, Any] = json.loads(self._planned.record_json())
        return record

    @property
    def name(self) -> str:
        """The name of the sequence."""
        return str(self.record["name"])

    @property
    def status(self) -> str:
        """The status of the first leg that is not solved, or ``"solved"``."""
        return str(self.record["status"])

    @property
    def exit_code(self) -> int:
        """The exit code of ``slew plan`` for this plan."""
        return int(self.record["exit_code"])

    @property
    def cost(self) -> float:
        """The cost of all legs: effort, fuel, or their duration in seconds."""
        return float(self.record["cost"])

    @property
    def duration(self) -> float:
        """The end of the last hold in seconds."""
        return float(self.record["duration_s"])

    @property
    def stops(self) -> list[dict[str, Any]]:
        """The stops in the order in which they are visited: ``name``, ``leg_begins_s``,
        ``arrives_s``, ``hold_begins_s``, ``leaves_s``, ``late_s``."""
        return list(self.record["stops"])

    @property
    def order_gap(self) -> float | None:
        """Upper bound on the relative gain of another order; None if the order is given."""
        gap = self.record.get("order_gap")
        return None if gap is None else float(gap)

    @cached_property
    def legs(self) -> list[Plan]:
        """The plan of each leg, in the order of the stops."""
        return [Plan(leg) for leg in self._planned.legs()]

    @cached_property
    def holds(self) -> list[Plan | None]:
        """The motion during the hold at each stop if a target or a cone moves; None if the body
        rests. It is determined by the target, not optimised."""
        return [None if hold is None else Plan(hold) for hold in self._planned.holds()]

    @cached_property
    def time(self) -> Array:
        """Times of the nodes, s, shape (K + 1,)."""
        return self._column("time")

    def quaternions(self, *, scalar_first: bool = False) -> Array:
        """Attitudes at the nodes as unit quaternions, continuous, shape (K + 1, 4): ``[x, y, z,
        w]`` as in SciPy, ``[w, x, y, z]`` with ``scalar_first``; body to reference components."""
        rows = self._column("quaternion_wxyz", 4)
        return rows if scalar_first else rows[:, [1, 2, 3, 0]]

    @cached_property
    def angular_velocity(self) -> Array:
        """Angular velocity at the nodes, body axes, rad/s, shape (K + 1, 3)."""
        return self._column("angular_velocity", 3)

    @cached_property
    def held_torque(self) -> Array:
        """Torque of all actuators over each step, body axes, N·m, shape (K, 3)."""
        return self._column("held_torque", 3)

    @cached_property
    def held_input(self) -> Array:
        """Inputs over each step, N·m, shape (K, inputs)."""
        return self._column("held_input", max(self._planned.input_count, 1))

    @cached_property
    def wheel_momentum(self) -> Array:
        """Momentum of each reaction wheel at the nodes, N·m·s, shape (K + 1, wheels)."""
        momenta = self._column("wheel_momentum")
        return momenta.reshape(len(self.time), -1) if momenta.size else np.empty((len(self.time), 0))

    def _column(self, name: str, *width: int) -> Array:
        column = self._planned.column(name)
        assert column is not None, name
        return column.reshape(-1, *width) if width else column

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes a file, completely or not at all, in the format of its ending: ``.json``,
        ``.csv``, ``.aem``, ``.npz`` and so on, with a segment for each leg and each rest.

        Raises :class:`FileError` if the file exists and ``overwrite`` is not given."""
        self._planned.save(os.fspath(path), overwrite)

    def report(self, path: str | os.PathLike[str] | None = None, *, euler: str = "zyx") -> str:
        """Returns the plan as one HTML page, and writes it to ``path`` if that is given."""
        return written(self._planned.page(euler), path)

    def summary(self) -> str:
        """Returns the text that ``slew plan`` prints."""
        return self._planned.summary()

    def __repr__(self) -> str:
        return f"<slewkit.SequencePlan {self.name!r}, {self.status}, {len(self.stops)} stops, {self.duration:.6g} s>"


def plan_sequence(
    spec: Mapping[str, Any] | str | os.PathLike[str],
    *,
    overrides: Mapping[str, Any] | None = None,
    progress: ProgressFunction | None = None,
    strict: bool = True,
) -> SequencePlan:
    """Plans a spec with stops. The result is identical to that of ``slew plan``.

    ``spec`` is a dictionary with the keys of a spec, or the path of a spec file; it has
    ``[[stop]]``. Raises the same exceptions as :func:`slewkit.plan`. With ``strict=False`` a plan whose legs are
    not all solved is returned too.
    """
    planned, raised = _slewkit.plan_sequence(spec, overrides, _told(progress))
    found = SequencePlan(planned)
    if raised is not None:
        raise raised
    if strict and found.exit_code != 0:
        raise OF_STATUS[found.status]("", f"{found.name}: {found.status.replace('_', ' ')}")
    return found
