"""A plan: trajectory, costates, margins, and the results of the witnesses."""

from __future__ import annotations

import base64
import html
import io
import json
import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _slewkit

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure
    from scipy.spatial.transform import Rotation

#: Floats, with the shape in each docstring.
Array = NDArray[np.float64]

class Plan:
    """A plan; SI units, body and reference axes as stated for each quantity.

    The attitude ``R`` maps body components to components in the reference frame, which is inertial
    unless the environment turns it. Arrays of nodes have ``N + 1`` rows, for ``N`` steps. Arrays of
    inputs (``input``, ``torque``, ``force``) have ``N + 1`` rows for Lie–Verlet. They have ``N``
    rows for Lie–Euler and for inputs that switch, held over steps; ``input_time`` has the time from
    which each row acts. ``held_input`` has the inputs that act over each step in every case. Arrays
    are made on first use, and belong to the caller: a change of an array does not change what the
    plan saves or reports.

    :func:`slewkit.plan` and :func:`slewkit.load` make plans. It can be pickled.
    """

    def __init__(self, planned: _slewkit.Planned) -> None:
        self._planned = planned

    # The result

    @property
    def name(self) -> str:
        """The name of the maneuver."""
        return self._planned.name

    @property
    def status(self) -> str:
        """``"solved"``, ``"infeasible"``, ``"not_converged"``, ``"limit_reached"``,
        ``"verification_failed"`` or ``"interrupted"``."""
        return self._planned.status

    @property
    def exit_code(self) -> int:
        """The exit code of ``slew plan`` for this plan."""
        return self._planned.exit_code

    @property
    def cost(self) -> float:
        """The cost: the effort ``∫ ½ uᵀWu dt`` (N²·m²·s with unit weights, for attitude only),
        the fuel, or the duration in seconds. NaN without a plan."""
        return self._planned.cost

    @property
    def duration(self) -> float:
        """Duration in seconds. NaN if it is free and no plan was found."""
        return self._planned.duration

    @property
    def steps(self) -> int:
        """Number of steps ``N``."""
        return self._planned.steps

    @property
    def solve_time(self) -> float:
        """Wall time of the solve in seconds, without the second-order test and the verification."""
        return self._planned.solve_time

    @property
    def wall_time(self) -> float:
        """Wall time within the library in seconds, verification included; NaN for a plan that was
        read."""
        return self._planned.wall_time

    @property
    def outcome(self) -> str:
        """The outcome of the solver: ``"converged"``, ``"iteration_limit"``, ``"stalled"`` and so
        on."""
        return str(self._head["outcome"])

    @property
    def verification(self) -> dict[str, Any] | None:
        """The results of the independent witnesses, with the keys of a plan file; None without a
        trajectory. Numbers that are not finite are None."""
        found: dict[str, Any] | None = self._head["verified"]
        return found

    @property
    def margins(self) -> list[dict[str, Any]]:
        """Every limit and constraint with its smallest margin, from the witnesses: ``name``,
        ``margin`` in ``unit``, negative if violated, ``time_s``, ``at``."""
        return list((self.verification or {}).get("margins", []))

    @property
    def active(self) -> list[dict[str, Any]]:
        """The active limits and constraints: ``name``, and arrays ``time_s`` and ``multiplier``,
        scaled and nonnegative."""
        return [
            {"name": one["name"], "time_s": _floats(one["time_s"]), "multiplier": _floats(one["multiplier"])}
            for one in self._head["active"]
        ]

    @property
    def switching(self) -> dict[str, Any] | None:
        """Arcs, switching times and certificate of a plan whose inputs switch, with the keys of a
        plan file: ``structure``, ``continuous_duration_s``, ``continuous_cost``, ``eigenaxis_s``,
        ``arcs``, and ``gap``, which neighbouring plans can save to first order; it does not bound
        plans on other paths. None for other plans."""
        arcs: dict[str, Any] | None = self._head.get("switching")
        return arcs

    @property
    def switching_times(self) -> Array:
        """Switching times in seconds of the continuous extremal of minimum time or fuel; empty for
        other plans."""
        arcs = (self.switching or {}).get("arcs", [])
        return _floats([arc["start_s"] for arc in arcs[1:]])

    @property
    def rivals(self) -> list[dict[str, Any]]:
        """Other extremals that were found, cheapest first."""
        return list(self._head["rivals"])

    @property
    def proof(self) -> str | None:
        """How far the plan is proved to be an optimum, from the least to the most: ``"feasible"``,
        ``"saddle"``, ``"extremal"``, ``"first_order"``, ``"minimum"``, ``"global"``. All but the
        last refer to neighbouring plans: a plan on another path may cost less. None without a
        plan."""
        found: str | None = self._head.get("proof")
        return found

    @property
    def optimality(self) -> dict[str, Any]:
        """``stationarity``, ``conjugate_points`` (0: a local minimum), ``rank`` and ``condition``
        of the sensitivities.

        If the spec skips the test, ``tested`` is present and false.
        """
        return dict(self._head["optimality"])

    @property
    def terminal_error(self) -> dict[str, float]:
        """Distance of the discrete end from the terminal conditions: ``attitude_rad``,
        ``momentum_relative``."""
        return dict(self._head["terminal"])

    @property
    def landing(self) -> dict[str, Any] | None:
        """The corrections of landing, after which the true motion under the held torques meets the
        end: ``corrections`` of the discrete target, ``misses`` before each and after the last (rad,
        or relative), ``cost_before`` of the discrete optimum, with which rivals compare. None if
        the discrete motion meets the end (``target = "discrete"``)."""
        found: dict[str, Any] | None = self._head.get("landing")
        return found

    @property
    def chosen_steps(self) -> dict[str, Any] | None:
        """The choice of the number of steps, if the spec gives none: the first number ``began``,
        whether the plan ``lands``, and ``cost_error``, the estimated relative excess of the cost
        over the optimum in continuous time. None if steps are given."""
        found: dict[str, Any] | None = self._head.get("chosen")
        return found

    @property
    def spec(self) -> dict[str, Any] | None:
        """The maneuver of the plan, with the keys of a spec."""
        held: dict[str, Any] | None = self._head["spec"]
        return held

    @property
    def accuracy(self) -> dict[str, Any] | None:
        """The accuracy of the true motion under the held torques: the miss
        ``continuous_attitude_deg``, the required ``wanted_deg``, and the approximate number of
        ``steps`` that would suffice (None if the present number does, or if no number can). None
        without a plan."""
        found: dict[str, Any] | None = self._head.get("accuracy")
        return found

    @cached_property
    def _head(self) -> dict[str, Any]:
        head: dict[str, Any] = json.loads(self._planned.head_json())
        return head

    # The trajectory

    @cached_property
    def time(self) -> Array:
        """Times of the nodes, s, shape (N + 1,)."""
        return self._column("time")

    def quaternions(self, *, scalar_first: bool = False) -> Array:
        """Attitudes at the nodes as unit quaternions, continuous along the motion, shape (N + 1,
        4): ``[x, y, z, w]`` as in SciPy, ``[w, x, y, z]`` with ``scalar_first``. Hamilton; body to
        reference components."""
        return self._wxyz if scalar_first else self._xyzw

    @cached_property
    def _xyzw(self) -> Array:
        return self._column("quaternion_xyzw", 4)

    @cached_property
    def _wxyz(self) -> Array:
        return self._column("quaternion_wxyz", 4)

    @cached_property
    def rotation_matrices(self) -> Array:
        """Attitudes at the nodes as matrices, shape (N + 1, 3, 3); ``R @ v`` maps body components
        to reference components."""
        return self._column("rotation_matrix", 3, 3)

    def rotation(self) -> Rotation:
        """Attitudes at the nodes as a SciPy ``Rotation``; ``apply`` maps body components to
        reference components."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self._xyzw)

    @cached_property
    def angular_velocity(self) -> Array:
        """Inertial angular velocity ``Ω`` at the nodes, body axes, rad/s, shape (N + 1, 3)."""
        return self._column("angular_velocity", 3)

    @cached_property
    def angular_momentum(self) -> Array:
        """Angular momentum of the body ``Π = JΩ`` at the nodes, body axes, N·m·s, shape (N + 1, 3);
        without the momentum of its wheels."""
        inertia: Array = np.array(self._planned.inertia)
        momentum: Array = self.angular_velocity @ inertia
        return momentum

    @cached_property
    def position(self) -> Array:
        """Position of the mass center at the nodes, reference axes, m, shape (N + 1, 3); (0, 3) if
        it does not move."""
        return self._column("position", 3)

    @cached_property
    def velocity(self) -> Array:
        """Velocity of the mass center at the nodes, reference axes, m/s, shape (N + 1, 3); (0, 3)
        if it does not move."""
        return self._column("velocity", 3)

    @cached_property
    def input_time(self) -> Array:
        """The time of each row of inputs, s: of its node, or of the start of the step over which
        the row is held."""
        first, held = self._planned.first_input
        return self.time[:-1] if held else self.time[first:]

    @property
    def inputs_are_held(self) -> bool:
        """Whether a row of inputs is held over the step that begins at its time, as for inputs that
        switch. Minimum time or fuel on equal steps, as with cones, rate limits or wheels, has its
        rows at nodes, as minimum effort has."""
        return self._planned.first_input[1]

    @cached_property
    def held_input(self) -> Array:
        """Inputs that act over each step, shape (N, inputs): the mean of the rows of ``input`` at
        its two nodes for Lie–Verlet, and the row of the step otherwise. Under these the body moves
        as planned."""
        rows = self.input
        return rows.copy() if len(rows) < len(self.time) else 0.5 * (rows[:-1] + rows[1:])

    @cached_property
    def input(self) -> Array:
        """Inputs of the actuators, forces before torques, N or N·m, shape (rows, inputs)."""
        return self._column("input", max(self._planned.input_count, 1))

    @cached_property
    def torque(self) -> Array:
        """Torque of all actuators, body axes, N·m, shape (rows, 3)."""
        return self._column("torque", 3)

    @cached_property
    def force(self) -> Array:
        """Force of all actuators, reference axes, N, shape (rows, 3); (0, 3) if the body only
        turns."""
        return self._column("force", 3)

    @cached_property
    def wheel_momentum(self) -> Array:
        """Momentum of each reaction wheel at the nodes, N·m·s, shape (N + 1, wheels)."""
        momenta = self._column("wheel_momentum")
        return momenta.reshape(len(self.time), -1) if momenta.size else np.empty((len(self.time), 0))

    @cached_property
    def costates(self) -> Array:
        """Costates, SI, left-trivialised, ``[ζ, δΠ]`` or ``[δx, δγ, ζ, δΠ]``, shape (rows, 6 or
        12); ``u = −W⁻¹Bᵀλ``."""
        return self._column("costates", 12 if self._planned.moves else 6)

    @cached_property
    def gains(self) -> Array:
        """Gains of each step and input, for the deviation of attitude and rate from the plan, body
        axes: ``input = held input - gains[k] @ [ζ, δΩ]``, ``ζ = log(R*ᵀR)`` in rad, rad/s; shape
        (N, inputs, 6), (0, inputs, 6) without ``[feedback]``. Neighbouring gains of wheels have
        nine columns, with the deviation of the stored momentum, body axes, N·m·s. Gains of bodies
        that translate have twelve columns, with the deviation of position and velocity before
        these, m and m/s."""
        inputs, states = self._planned.gain_shape or (max(self._planned.input_count, 1), 6)
        return self._column("gains", inputs, states)

    @cached_property
    def arc_gains(self) -> Array:
        """The derivatives of the lengths of arcs by the start, for ``[feedback] kind =
        "switching"``: from a start that differs by ``[ζ, δΩ]``, rad and rad/s, arc ``a`` has
        ``arc_lengths[a] + arc_gains[a] @ [ζ, δΩ]`` seconds; shape (arcs, 6)."""
        return self._column("arc_gains", 6)

    @cached_property
    def arc_lengths(self) -> Array:
        """The lengths of the arcs of :attr:`arc_gains` in the plan, s."""
        return self._column("arc_lengths")

    @cached_property
    def covariance(self) -> Array:
        """Covariance of ``[ζ, δΠ]`` at the nodes, rad and N·m·s, shape (N + 1, 6, 6): with gains if
        the plan has any; (0, 6, 6) without ``[uncertainty]``."""
        upper = self._column("covariance", 21)
        whole = np.zeros((len(upper), 6, 6))
        rows, columns = np.triu_indices(6)
        whole[:, rows, columns] = upper
        whole[:, columns, rows] = upper
        return whole

    @cached_property
    def uncertainty(self) -> dict[str, Any] | None:
        """The uncertainty of the spec, SI units, body axes; None without ``[uncertainty]``.

        ``start``: covariance of ``[ζ, δΩ]`` at the start, (6, 6), rad and rad/s. ``parameters``:
        one standard deviation of each constant error by name, as in :attr:`Flights.parameters`.
        ``torque_noise``: intensity of the noise of the torque, (3, 3), (N·m)²·s. ``sensor_noise``:
        covariance of the measurement of ``[ζ, δΩ]``, independent at each step, (6, 6)."""
        parameters = self._planned.uncertain_parameters
        if parameters is None:
            return None
        return {
            "start": self._column("start_covariance", 6).copy(),
            "parameters": dict(parameters),
            "torque_noise": self._column("torque_noise", 3).copy(),
            "sensor_noise": self._column("sensor_noise", 6).copy(),
        }

    def _column(self, name: str, *width: int) -> Array:
        """Returns a quantity, in the memory that the library has filled for it."""
        column = self._planned.column(name)
        assert column is not None, name
        return column.reshape(-1, *width) if width else column

    # Conversions

    def to_dict(self) -> dict[str, Any]:
        """Returns the plan file as a dictionary; ``slewkit.load`` reads it."""
        document: dict[str, Any] = json.loads(self._planned.text("json"))
        return document

    def to_dataframe(self, *, margins: bool = False) -> pandas.DataFrame:
        """Returns one row for each node with the columns of ``slew plan -o plan.csv``, indexed by
        time in seconds. Inputs are in the row of the node at which they act, NaN if the row has
        none. ``margins`` adds the margin to every limit and constraint, and the angle in degrees
        between each boresight and each direction.

        Raises ImportError without pandas."""
        from ._tables import dataframe

        return dataframe(self._planned.text("csv", margins))

    def to_xarray(self) -> xarray.Dataset:
        """Returns the arrays of the plan as one dataset, with units and axes as attributes.

        Quantities of nodes have the dimension ``time``, s. Inputs, torque, force and costates have
        it too, or ``input_time`` if they have no row for each node. ``held_input`` and ``gains``
        have ``step_time``, the start of each step. Quantities that the plan lacks are left out.

        Raises ImportError without xarray."""
        from ._tables import dataset

        return dataset(self)

    @property
    def input_names(self) -> list[str]:
        """The name of each input, and its number where the spec names none."""
        return self._planned.input_names

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        format: str | None = None,
        tick: float | None = None,
        margins: bool = False,
        overwrite: bool = False,
    ) -> None:
        """Writes a file, completely or not at all, in the format of its ending or in the named
        format: those of ``slew plan -o``, such as ``.json``, ``.csv``, ``.aem``, ``.npz``,
        ``.mat``. ``tick`` is the tick of ``.flight``, s; ``margins`` is the argument of
        :meth:`to_dataframe`, for ``.csv``.

        Raises :class:`FileError` if the file exists and ``overwrite`` is not given,
        :class:`SpecError` if the spec lacks data of the format, such as an epoch."""
        self._planned.save(os.fspath(path), format, tick, margins, overwrite)

    def report(self, path: str | os.PathLike[str] | None = None, *, euler: str = "zyx") -> str:
        """Returns the plan as one HTML page, as ``slew report`` makes it. If ``path`` is given,
        also writes the page to it and replaces an existing file. ``euler`` is the sequence of the
        Euler angles, intrinsic."""
        return written(self._planned.page(euler), path)

    def summary(self) -> str:
        """Returns the text that ``slew plan`` prints."""
        return self._planned.summary()

    def plot(self, figure: Figure | None = None) -> Figure:
        """Plots attitude, rates, inputs and costates against time, by matplotlib."""
        from ._plot import of_plan

        return of_plan(self, figure)

    def pictures(self, *, euler: str = "zyx") -> dict[str, str]:
        """Returns the pictures that ``slew plot`` draws of the plan, each as an SVG file: ``sky``,
        ``inputs``, ``rates`` and so on. ``euler`` is the argument of :meth:`report`."""
        return dict(self._planned.pictures(euler))

    def panel(
        self,
        names: Sequence[str] = ("sky", "inputs", "rates", "clearance"),
        path: str | os.PathLike[str] | None = None,
        *,
        euler: str = "zyx",
    ) -> Panel:
        """Returns the named pictures in two columns as one SVG file, as ``slew plot -o FILE.svg
        --charts`` draws them; a notebook shows it. If ``path`` is given, also writes the file and
        replaces an existing one.

        Raises ValueError for a picture that the plan does not have."""
        return Panel(written(self._planned.panel(list(names), euler), path))

    def _repr_html_(self) -> str:
        pictures = self.pictures()
        names = [name for name in ("sky", "inputs", "forces") if name in pictures]
        # Two beside each other where a cell is wide enough.
        shown = [_image(pictures[name], name, "width: 49%; min-width: min(24em, 100%)") for name in names]
        style = "font-family: monospace; white-space: pre; overflow-x: auto"
        return f'<pre style="{style}">{html.escape(self.summary())}</pre>{"".join(shown)}'

    def __repr__(self) -> str:
        return (
            f"<slewkit.Plan {self.name!r}: {self.status}, cost {self.cost:.6g}, {self.duration:.6g} s "
            f"in {self.steps} steps>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self._planned.text("json"),)


class Panel(str):
    """Pictures as the text of one SVG file, which a notebook shows."""

    def _repr_html_(self) -> str:
        # Legible on a narrow screen too, where it can be moved sideways.
        image = _image(self, "pictures of the plan", "max-width: 100%; min-width: 38em")
        return f'<div style="overflow-x: auto">{image}</div>'


def _image(svg: str, name: str, size: str) -> str:
    """Returns an SVG as an image on white, in dark notebooks too."""
    data = base64.b64encode(svg.encode()).decode()
    style = f"{size}; background: #fff; display: inline-block; margin: 0; vertical-align: top"
    return f'<img alt="{name}" style="{style}" src="data:image/svg+xml;base64,{data}">'


def _again(text: bytes) -> Plan:
    """A pickled plan."""
    return Plan(_slewkit.read_plan(text, "pickle"))


def load(plan: str | os.PathLike[str] | Mapping[str, Any]) -> Plan:
    """Reads a plan file, as :meth:`Plan.save` and ``slew plan -o plan.json`` write it, or the
    dictionary of one.

    It reads plans of any status. Raises :class:`FileError` if the file is not a plan."""
    if isinstance(plan, Mapping):
        return Plan(_slewkit.read_plan(json.dumps(dict(plan)).encode(), "dict"))
    return Plan(_slewkit.read_plan(*content(plan)))


def content(path: str | os.PathLike[str]) -> tuple[bytes, str]:
    """Returns the bytes of a file, and its name."""
    from ._errors import FileError

    name = os.fspath(path)
    try:
        with open(name, "rb") as file:
            return file.read(), name
    except OSError as error:
        raise FileError("E0090", f"cannot read {name}: {error.strerror}", "check the path") from error


def written(page: str, path: str | os.PathLike[str] | None) -> str:
    """Returns a page, and writes it to a file if one is named."""
    if path is not None:
        _slewkit.write_page(os.fspath(path), page)
    return page


def framed(page: str) -> str:
    """Returns a page within another, such as a notebook, without an effect on its styles and
    scripts."""
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: 900px; border: 0"></iframe>'


def _floats(numbers: list[Any]) -> Array:
    return np.array(numbers, dtype=float)
