"""Flights of plans by a craft that differs from the model."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np
from numpy.typing import NDArray

from . import _slewkit
from ._commands import ProgressFunction, _told
from ._errors import OF_STATUS
from ._plan import Array, Plan, load
from ._sequence import SequencePlan


@dataclass(frozen=True, eq=False)
class Flights:
    """Many flights of one plan; SI units, body axes. Rows of arrays are cases; the row of a lost
    case is NaN."""

    #: The name of the maneuver.
    name: str
    #: Seed of the random numbers. A case depends only on the seed and the number of the case.
    seed: int
    #: Statistics, with the keys of a loop of ``slew fly --format json``: deviations with their
    #: linear prediction, quantiles, proportions of the cases with their intervals of 95 % (Clopper
    #: and Pearson).
    statistics: dict[str, Any]
    #: ``[ζ, δΩ]`` at the end, true minus planned, rad and rad/s, shape (runs, 6).
    end: Array
    #: ``[ζ, δΩ]`` at each instant at which a sequence has to be at a stop, shape (runs, instants,
    #: 6); ``statistics["stops"]`` names the instants. No instants for a single maneuver.
    stops: Array
    #: The smallest margin to each constraint along the motion, shape (runs, constraints): rad for
    #: cones, relative to the limit for rates; negative for a violation.
    room: Array
    #: The smallest margin of the commands to each torque limit along the motion, before saturation,
    #: SI, shape (runs, limits); negative for a violation. The columns are the limits that exist, in
    #: this order: magnitude of each input, norm, rate of each input.
    input_room: Array
    #: Fraction of the steps in which a limit saturated a command, shape (runs,).
    saturated: Array
    #: Constant errors of each case, shape (runs, parameters).
    parameters: Array
    #: Names of the constraints, in the order of the columns of ``room``.
    constraint_names: list[str]
    #: Names of the parameters, in the order of the columns of ``parameters``.
    parameter_names: list[str]

    @property
    def runs(self) -> int:
        """Number of cases."""
        return len(self.end)

    @property
    def lost(self) -> NDArray[np.bool_]:
        """The lost cases: they turn too fast to be propagated, or all their drawn inertias are
        impossible."""
        return np.isnan(self.end[:, 0])

    @property
    def violated(self) -> dict[str, dict[str, Any]]:
        """For each constraint the cases that violate it at any time: ``count``, ``part``, and its
        ``interval`` of 95 %."""
        return {one["name"]: one["violated"] for one in self.statistics["end"]["constraints"]}

    @property
    def sigma(self) -> Array:
        """One standard deviation of ``[ζ, δΩ]`` at the end, rad and rad/s, shape (6,)."""
        end = self.statistics["end"]
        degrees = np.asarray(end["attitude_sigma_deg"] + end["rate_sigma_deg_s"], dtype=float)
        sigma: Array = np.radians(degrees)
        return sigma

    def __repr__(self) -> str:
        return f"<slewkit.Flights of {self.name!r}: {self.runs} runs, {self.statistics['name']}>"


def closed_loop(
    plan: Plan | SequencePlan | str | os.PathLike[str] | Mapping[str, Any],
    *,
    runs: int = 1000,
    seed: int = 1,
    threads: int | None = None,
    gains: bool = True,
    overrides: Mapping[str, Any] | None = None,
    progress: ProgressFunction | None = None,
) -> Flights:
    """Flies a plan ``runs`` times by a craft that differs from the model as ``[uncertainty]`` and
    ``[plant]`` of its spec state. The numbers equal the results of ``slew fly``: with its gains, or
    in open loop with ``gains=False``.

    ``plan`` is a :class:`Plan`, a :class:`SequencePlan` (flown over all legs and holds), the plan
    file of a maneuver, or the dictionary of such a file. ``overrides`` sets keys of its spec, such as
    ``{"uncertainty.inertia.relative": 0.05}``, and does not change the plan. The number of
    ``threads``, by default the number of processors, does not change the result. Other threads run
    meanwhile.

    Raises :class:`PlanError` if the plan is not solved, has no uncertainty, or has no gains;
    :class:`SpecError`; :class:`FileError`; ValueError for impossible numbers; :class:`Interrupted`
    if ``progress`` stops it."""
    flown = plan if isinstance(plan, (Plan, SequencePlan)) else load(plan)
    text, arrays, raised = _slewkit.fly(flown._planned, runs, seed, threads, gains, overrides, _told(progress))
    if raised is not None:
        raise raised
    document = json.loads(text)
    if document["status"] == "interrupted":
        raise OF_STATUS["interrupted"]("", f"{document['name']}: interrupted")
    constraints, parameters = document["constraints"], document["parameters"]
    rows = len(arrays["saturated"])
    return Flights(
        name=document["name"],
        seed=seed,
        statistics=document["loop"],
        end=arrays["end"].reshape(rows, 6),
        stops=arrays["stops"].reshape(rows, -1, 6) if len(arrays["stops"]) else np.zeros((rows, 0, 6)),
        room=arrays["room"].reshape(rows, len(constraints)),
        input_room=arrays["input_room"].reshape(rows, -1) if len(arrays["input_room"]) else np.zeros((rows, 0)),
        saturated=arrays["saturated"],
        parameters=arrays["parameters"].reshape(rows, len(parameters)),
        constraint_names=constraints,
        parameter_names=parameters,
    )
