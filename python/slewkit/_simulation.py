"""Motions without optimisation."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np

from . import _slewkit
from ._commands import ProgressFunction, _told
from ._errors import Interrupted, NotFinite
from ._plan import Array, framed, written
from ._problem import Problem, SpecLike, maneuver_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Body:
    """The motion of one body; a row for each time of the simulation."""

    #: The name of the body.
    name: str
    #: Whether the body has a position.
    moves: bool
    _wxyz: Array = field(repr=False)
    #: Angular velocity, inertial, body axes, rad/s, shape (rows, 3).
    angular_velocity: Array = field(repr=False)
    #: Position of the mass center, reference axes, m, shape (rows, 3); zero if it does not move.
    position: Array = field(repr=False)
    #: Velocity of the mass center, reference axes, m/s, shape (rows, 3).
    velocity: Array = field(repr=False)

    def quaternions(self, *, scalar_first: bool = False) -> Array:
        """Attitudes, body to reference components, continuous, shape (rows, 4): ``[x, y, z, w]``,
        or ``[w, x, y, z]`` with ``scalar_first``."""
        return self._wxyz if scalar_first else np.roll(self._wxyz, -1, axis=1)

    def rotation(self) -> Rotation:
        """Attitudes as a SciPy ``Rotation``."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.quaternions())


@dataclass(frozen=True)
class Simulation:
    """A motion, with the errors of its conserved quantities; SI units."""

    #: The name of the simulation.
    name: str
    #: ``"simulated"``, or the reason of an early end: ``"interrupted"``, ``"not_finite"``.
    status: str
    #: The integrator.
    integrator: str
    #: Requested duration, s.
    duration: float
    #: Requested number of steps.
    steps: int
    #: Steps from one row to the next.
    stride: int
    #: Times of the rows, s, shape (rows,).
    time: Array = field(repr=False)
    #: The bodies.
    bodies: list[Body]
    #: Energy, J, shape (rows,).
    energy: Array = field(repr=False)
    #: Linear momentum, inertial axes, N·s, shape (rows, 3).
    linear_momentum: Array = field(repr=False)
    #: Angular momentum, inertial axes, N·m·s, shape (rows, 3).
    angular_momentum: Array = field(repr=False)
    #: ``‖I − RᵀR‖``, shape (rows,).
    orthogonality: Array = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Returns the document of ``slew simulate --format json``, without the work of the
        method."""
        rows: dict[str, Any] = {"time_s": self.time.tolist()}
        each = [_keys(body) for body in self.bodies]
        if len(each) == 1:
            rows.update(each[0])
        else:
            rows["bodies"] = [{"name": body.name, **keys} for body, keys in zip(self.bodies, each)]
        rows["energy_j"] = self.energy.tolist()
        if any(body.moves for body in self.bodies):
            rows["linear_momentum_n_s"] = self.linear_momentum.tolist()
        rows["angular_momentum_n_m_s"] = self.angular_momentum.tolist()
        rows["orthogonality_error"] = self.orthogonality.tolist()
        return {
            "status": self.status,
            "name": self.name,
            "integrator": self.integrator,
            "duration_s": self.duration,
            "steps": self.steps,
            "step_s": self.duration / self.steps,
            "stride": self.stride,
            "trajectory": rows,
        }

    def report(self, path: str | os.PathLike[str] | None = None, *, euler: str = "zyx") -> str:
        """Returns the motion as one HTML page, as ``slew report`` makes it; also writes it to
        ``path``, if given."""
        return written(_slewkit.simulation_report(json.dumps(self.to_dict()), euler), path)

    def _repr_html_(self) -> str:
        return framed(self.report())


def _keys(body: Body) -> dict[str, Any]:
    """Returns one body with the keys of a file."""
    keys = {
        "quaternion_wxyz": body.quaternions(scalar_first=True).tolist(),
        "angular_velocity_rad_s": body.angular_velocity.tolist(),
    }
    if body.moves:
        keys["position_m"], keys["velocity_m_s"] = body.position.tolist(), body.velocity.tolist()
    return keys


def simulate(
    spec: SpecLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    steps: int | None = None,
    stride: int | None = None,
    integrator: str | None = None,
    inputs: Sequence[float] | None = None,
    progress: ProgressFunction | None = None,
) -> Simulation:
    """Propagates the bodies of a spec from their start, as ``slew simulate`` does.

    A maneuver is propagated from its start over its duration, under ``inputs`` held throughout
    (forces before torques), by default none. ``steps``, ``stride`` (steps from one row to the next)
    and ``integrator`` (``"lie_verlet"``, ``"verner98"`` and so on) replace the values of the spec.

    Raises :class:`SpecError`, :class:`FileError`, :class:`Interrupted` if the progress function
    stops it, :class:`NotFinite`. The attribute ``simulation`` of the last two has the rows so far.
    Ctrl-C raises KeyboardInterrupt, with the rows so far in its attribute ``simulation``.
    """
    if isinstance(spec, Problem):
        given: Any = maneuver_of(spec, overrides)
    else:
        given = spec
    held = None if inputs is None else np.asarray(inputs, dtype=float).ravel().tolist()
    found, raised = _slewkit.simulate(given, overrides, steps, stride, integrator, held, _told(progress))

    def rows(array: Array, width: int) -> Array:
        return array.reshape(-1, width)

    bodies = [
        Body(
            body["name"],
            body["moves"],
            rows(body["quaternion_wxyz"], 4),
            rows(body["angular_velocity"], 3),
            rows(body["position"], 3),
            rows(body["velocity"], 3),
        )
        for body in found["bodies"]
    ]
    simulation = Simulation(
        name=found["name"],
        status=found["status"],
        integrator=found["integrator"],
        duration=found["duration_s"],
        steps=found["steps"],
        stride=found["stride"],
        time=found["time"],
        bodies=bodies,
        energy=found["energy"],
        linear_momentum=rows(found["linear_momentum"], 3),
        angular_momentum=rows(found["angular_momentum"], 3),
        orthogonality=found["orthogonality"],
    )
    if raised is not None:
        raised.simulation = simulation  # type: ignore[attr-defined]
        raise raised
    if simulation.status == "interrupted":
        stopped = Interrupted("", f"{simulation.name}: interrupted")
        stopped.simulation = simulation
        raise stopped
    if simulation.status == "not_finite":
        overflow = NotFinite("", f"{simulation.name}: {found['reason']}")
        overflow.simulation = simulation
        raise overflow
    return simulation
