"""Plans as tables of pandas and datasets of xarray."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas
    import xarray

    from ._plan import Array, Plan

AXES = ["x", "y", "z"]
#: Body axes, as an attribute.
BODY = "body"
REFERENCE = "reference"
#: The names of the rows of costates, gains and covariances.
POSE = ["x_1", "x_2", "x_3", "v_1", "v_2", "v_3"]
ANGLES = ["zeta_x", "zeta_y", "zeta_z"]


def missing(package: str, method: str) -> ImportError:
    """Returns the error for a package that is not installed."""
    return ImportError(f"Plan.{method} needs {package}: `pip install slewkit[{package}]`", name=package)


def dataframe(text: bytes) -> pandas.DataFrame:
    """Reads a table of a plan."""
    try:
        import pandas
    except ImportError as error:
        raise missing("pandas", "to_dataframe") from error

    # Later versions read every number exactly, and warn of the argument.
    exactly: dict[str, Any] = {"float_precision": "round_trip"}
    late = tuple(int(part) for part in pandas.__version__.split(".")[:2]) >= (3, 1)
    table: pandas.DataFrame = pandas.read_csv(
        io.BytesIO(text), index_col="time_s", **({} if late else exactly)
    )
    return table


def dataset(plan: Plan) -> xarray.Dataset:
    """Returns the arrays of a plan with their dimensions, units and axes."""
    try:
        import xarray
    except ImportError as error:
        raise missing("xarray", "to_xarray") from error

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", plan.time, {"units": "s"})}

    def rows(array: Array) -> str:
        """Returns the dimension of the rows of a quantity of nodes or inputs."""
        if len(array) == len(plan.time):
            return "time"
        coordinates["input_time"] = ("input_time", plan.input_time, {"units": "s"})
        return "input_time"

    def add(name: str, array: Array, dimensions: dict[str, list[str]], **attributes: str) -> None:
        if array.size == 0:
            return
        first = "step_time" if name in ("held_input", "gains") else rows(array)
        if first == "step_time":
            coordinates["step_time"] = ("step_time", plan.time[:-1], {"units": "s"})
        for dimension, labels in dimensions.items():
            coordinates[dimension] = (dimension, labels)
        variables[name] = ((first, *dimensions), array, attributes)

    axis = {"axis": AXES}
    inputs = {"input_name": plan.input_names}
    wheels = {"wheel": plan.input_names[-plan.wheel_momentum.shape[1] :]}
    before = POSE if plan.position.size else []
    states = [*before, *ANGLES, *(f"rate_{axis}" for axis in AXES)]
    if plan.gains.shape[-1] == 9:
        states += [f"stored_{axis}" for axis in AXES]
    momenta = [*ANGLES, *(f"momentum_{axis}" for axis in AXES)]
    costates = [*(["x_1", "x_2", "x_3", "gamma_1", "gamma_2", "gamma_3"] if before else []), *momenta]

    add(
        "quaternion",
        plan.quaternions(),
        {"component": ["x", "y", "z", "w"]},
        long_name="attitude, Hamilton quaternion, body to reference components",
    )
    add("angular_velocity", plan.angular_velocity, axis, units="rad/s", axes=BODY)
    add("angular_momentum", plan.angular_momentum, axis, units="N m s", axes=BODY)
    add("position", plan.position, axis, units="m", axes=REFERENCE)
    add("velocity", plan.velocity, axis, units="m/s", axes=REFERENCE)
    add("torque", plan.torque, axis, units="N m", axes=BODY)
    add("force", plan.force, axis, units="N", axes=REFERENCE)
    units = "N m" if plan.force.size == 0 else "N or N m, forces first"
    add("input", plan.input, inputs, units=units, long_name="inputs of the actuators")
    add("held_input", plan.held_input, inputs, units=units, long_name="inputs that act over each step")
    add("wheel_momentum", plan.wheel_momentum, wheels, units="N m s", axes="of each wheel")
    add("costates", plan.costates, {"costate": costates}, long_name="costates, left-trivialised, SI")
    add("gains", plan.gains, {**inputs, "state": states}, long_name="gains of each step, SI")
    add(
        "covariance",
        plan.covariance,
        {"deviation": momenta, "deviation_": momenta},
        long_name="covariance of attitude and momentum, rad and N m s",
        axes=BODY,
    )
    attributes = {
        "name": plan.name,
        "status": plan.status,
        "cost": plan.cost,
        "duration_s": plan.duration,
        "steps": plan.steps,
    }
    return xarray.Dataset(variables, coordinates, attributes)
