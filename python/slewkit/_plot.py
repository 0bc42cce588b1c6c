"""Pictures by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ._plan import Plan


def of_plan(plan: Plan, figure: Figure | None) -> Figure:
    """Attitude, rates, inputs and costates against time."""
    import matplotlib.pyplot as pyplot

    if plan.time.size == 0:
        raise ValueError(f"the plan is {plan.status} and has no trajectory to plot")
    figure = pyplot.figure(figsize=(9, 6), layout="constrained") if figure is None else figure
    (attitude, rates), (inputs, costates) = figure.subplots(2, 2, sharex=True)
    figure.suptitle(f"{plan.name}: {plan.status.replace('_', ' ')}")

    attitude.plot(plan.time, plan.quaternions(), label=["x", "y", "z", "w"])
    attitude.set_ylabel("quaternion")
    rates.plot(plan.time, np.degrees(plan.angular_velocity), label=["x", "y", "z"])
    rates.set_ylabel("angular velocity, body [deg/s]")

    names = [str(number + 1) for number in range(plan.input.shape[1])]
    objective = (plan.spec or {}).get("maneuver", {}).get("minimize")
    if plan.inputs_are_held or objective in ("time", "fuel"):
        # Rows at the nodes of equal steps may alternate about their means, which alone act. The
        # last row is held until the end.
        held = np.vstack([plan.held_input, plan.held_input[-1:]])
        inputs.step(plan.time, held, where="post", label=names)
    else:
        inputs.plot(plan.input_time, plan.input, label=names)
    inputs.set_ylabel("input [N·m]" if plan.force.size == 0 else "input [N, N·m]")

    rows = plan.time if len(plan.costates) == len(plan.time) else plan.input_time
    names = ["ζ1", "ζ2", "ζ3", "Π1", "Π2", "Π3"]
    if plan.costates.shape[1] == 12:
        names = ["x1", "x2", "x3", "γ1", "γ2", "γ3"] + names
    scale = np.abs(plan.costates).max(axis=0)
    costates.plot(rows, plan.costates / np.where(scale > 0, scale, 1), label=names)
    costates.set_ylabel("costates / largest")

    for axes in (attitude, rates, inputs, costates):
        axes.legend(fontsize="small", ncols=2)
        axes.grid(alpha=0.3)
    for axes in (inputs, costates):
        axes.set_xlabel("time [s]")
    return figure
