"""Sequences of stops: the plan of the program, its legs and its arrays."""

import json

import numpy as np
import pytest

import slewkit


@pytest.fixture(scope="module")
def spec() -> dict:
    stop = {"attitude": {"axis": [1, 0, 0], "angle_deg": 50}, "hold_s": 5, "window_s": [8, 13.5]}
    return {
        "format": 1,
        "name": "two stops",
        "body": {"inertia_kg_m2": [1, 2, 2.5]},
        "actuators": {"torque_limit_n_m": 0.5},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "maneuver": {"minimize": "time", "order": "free", "steps": 40},
        "stop": [
            {"name": "far", "attitude": {"axis": [1, 0, 0], "angle_deg": 120}, "settling_s": 2},
            {"name": "near", **stop},
        ],
    }


def test_a_sequence_is_planned(spec, tmp_path):
    heard = []
    plan = slewkit.plan_sequence(spec, progress=heard.append)
    assert heard and plan.status == "solved" and plan.exit_code == 0 and plan.order_gap == 0
    assert [stop["name"] for stop in plan.stops] == ["near", "far"]
    assert plan.stops[0]["leaves_s"] == 13.0 and "best order" in plan.summary()
    assert [leg.status for leg in plan.legs] == ["solved", "solved"]
    assert plan.duration == pytest.approx(15 + plan.legs[1].duration) and "two stops" in repr(plan)
    assert np.all(np.diff(plan.time) > 0) and plan.time[-1] == plan.duration
    assert plan.quaternions().shape == (len(plan.time), 4) and plan.held_torque.shape == (len(plan.time) - 1, 3)
    # Momentum changes by the torque alone: ΔΠ in reference axes over a step of a leg.
    assert np.abs(plan.held_input).max() <= 0.5 + 1e-9 and plan.wheel_momentum.shape == (len(plan.time), 0)
    plan.save(tmp_path / "plan.json")
    document = json.loads((tmp_path / "plan.json").read_text())
    assert document["stops"] == plan.stops and len(document["legs"]) == 2
    plan.save(tmp_path / "plan.csv")
    with pytest.raises(slewkit.FileError):
        plan.save(tmp_path / "plan.csv")
    assert "Timeline" in plan.report()


def test_what_is_no_sequence_is_told(spec):
    alone = {key: spec[key] for key in spec if key != "stop"}
    alone["maneuver"] = {"minimize": "time"}
    alone["end"] = {"attitude": {"axis": [1, 0, 0], "angle_deg": 50}}
    with pytest.raises(ValueError, match="no stops"):
        slewkit.plan_sequence(alone)
    with pytest.raises(slewkit.SpecError, match="stop"):
        slewkit.plan(spec)
    with pytest.raises(slewkit.Infeasible, match="window of `near`"):
        slewkit.plan_sequence(spec, overrides={"stop.1.window_s": [0, 7]})
    with pytest.raises(slewkit.NotSolved):
        slewkit.plan_sequence(spec, overrides={"stop.1.window_s": [0, 7.6]})
    assert slewkit.check(spec) == []
