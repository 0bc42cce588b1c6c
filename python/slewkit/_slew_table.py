"""Slew-time tables that ``slew table`` has written."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _slewkit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: Floats, with the shape in each docstring.
Array = NDArray[np.float64]


class SlewTable:
    """Minimum times, or efforts, of all turns of one spacecraft from rest to rest.

    ::

        table = slewkit.SlewTable("slew.npz")
        seconds = table(q1, q2)
        matrix = table.matrix(attitudes)        # n × n

    Attitudes map body to reference components. Quaternions of any nonzero length have the order of
    SciPy, ``[x, y, z, w]``, unless ``scalar_first`` is given; a SciPy ``Rotation`` is an attitude
    too. The values cover only the turns: add :attr:`settling_s` where the pointing
    must settle. The value of an attitude with NaN is NaN.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Reads the file ``path``.

        Raises :class:`slewkit.FileError` if the file is not a table.
        """
        self._table = _slewkit.Table(os.fspath(path))
        self._facts: dict[str, Any] = self._table.facts()

    def __call__(self, first: ArrayLike, second: ArrayLike, *, scalar_first: bool = False) -> Any:
        """Returns the times in seconds, or the efforts, of the turns between attitudes.

        ``first`` and ``second`` have the shapes (…, 4), which are broadcast; the result has the
        shape (…), or is a number.
        """
        first, second = _quaternions(first, scalar_first), _quaternions(second, scalar_first)
        if first.ndim == 1 and second.ndim == 1:
            return self._table.one(first, second)
        return self._pairs(self._table.between, first, second)

    def bound(self, first: ArrayLike, second: ArrayLike, *, scalar_first: bool = False) -> Any:
        """Returns rigorous lower bounds of the times or efforts: no plan is below them."""
        first, second = _quaternions(first, scalar_first), _quaternions(second, scalar_first)
        found = self._pairs(self._table.bound, first, second)
        return float(found) if found.ndim == 0 else found

    def fixed_axis(
        self, first: ArrayLike, second: ArrayLike, *, scalar_first: bool = False
    ) -> Any:
        """Returns the durations in seconds of turns about fixed axes (eigenaxes) within the limits.

        Such a turn accelerates, continues at a constant rate, and decelerates. No plan of the
        table is slower. The durations are NaN for efforts and for one-sided thrusters.
        """
        first, second = _quaternions(first, scalar_first), _quaternions(second, scalar_first)
        found = self._pairs(self._table.fixed_axis, first, second)
        return float(found) if found.ndim == 0 else found

    def matrix(self, attitudes: ArrayLike, *, scalar_first: bool = False) -> Array:
        """Returns the values between all pairs of n attitudes, shape (n, n).

        Row i holds the turns from attitude i. The matrix is symmetric.
        """
        rows = _quaternions(attitudes, scalar_first)
        if rows.ndim != 2:
            raise ValueError(f"attitudes have the shape (n, 4), not {rows.shape}")
        found: Array = self._table.matrix(np.ascontiguousarray(rows).reshape(-1))
        return found.reshape(len(rows), len(rows))

    @staticmethod
    def _pairs(function: Any, first: Array, second: Array) -> Array:
        first, second = np.broadcast_arrays(first, second)
        flat = [np.ascontiguousarray(part).reshape(-1) for part in (first, second)]
        found: Array = function(*flat)
        return found.reshape(first.shape[:-1])

    @property
    def quantity(self) -> str:
        """``"time"``, in seconds, or ``"effort"``."""
        return str(self._facts["quantity"])

    @property
    def settling_s(self) -> float:
        """The time after a turn until the pointing counts, in seconds."""
        return float(self._facts["settling_s"])

    @property
    def duration_s(self) -> float:
        """The duration of the efforts in seconds; 0 for times."""
        return float(self._facts["duration_s"])

    @property
    def scales(self) -> bool:
        """Whether efforts in another duration T are ``(duration_s / T)³`` times those here."""
        return bool(self._facts["scales"])

    @property
    def errors(self) -> dict[str, float]:
        """Relative errors on ``turns`` random turns, which were also planned.

        The keys are ``median`` and ``percent_99`` of the absolute error, ``lowest`` and ``highest``,
        and ``bound``, the median of the lower bound divided by the planned value.
        """
        return dict(self._facts["errors"])

    def __repr__(self) -> str:
        planned, symmetry = self._facts["planned"], self._facts["symmetry"]
        return f"SlewTable({self.quantity}, {planned} plans, symmetry of order {symmetry})"


def _quaternions(given: Any, scalar_first: bool) -> Array:
    """Returns attitudes as an array of rows [w, x, y, z]."""
    if hasattr(given, "as_quat"):
        given, scalar_first = given.as_quat(), False
    rows = np.asarray(given, dtype=np.float64)
    if rows.ndim == 0 or rows.shape[-1] != 4:
        raise ValueError(f"quaternions have the shape (…, 4), not {rows.shape}")
    return rows if scalar_first else rows[..., [3, 0, 1, 2]]
