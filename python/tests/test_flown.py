"""Flights are those of the program, to the bit, and say what their arrays say."""

import csv
import json

import numpy as np
import pytest

import slewkit


@pytest.fixture(scope="module")
def plan():
    from conftest import ROOT

    return slewkit.plan(ROOT / "problems/flies.toml")


def test_flights_are_those_of_the_program(plan, slew, tmp_path):
    plan.save(tmp_path / "plan.json")
    fly = ("fly", tmp_path / "plan.json", "--cases", 50, "--seed", 4, "-q")
    slew(*fly, "-o", tmp_path / "cases.csv")
    slew(*fly, "-o", tmp_path / "cases.json")
    with open(tmp_path / "cases.csv") as file:
        rows = list(csv.reader(file))
    of_program = json.loads((tmp_path / "cases.json").read_text())
    for index, gains in enumerate([True, False]):
        flights = slewkit.closed_loop(plan, runs=50, seed=4, threads=1 + index, gains=gains)
        own = rows[1 + 50 * index : 51 + 50 * index]
        numbers = np.array([[float(cell) for cell in row[2:]] for row in own])
        assert np.array_equal(flights.end, numbers[:, :6])
        assert np.array_equal(flights.room, numbers[:, 6:7]) and flights.constraint_names == ["Sun"]
        assert np.array_equal(flights.input_room, numbers[:, 7:10])
        assert rows[0][9:13] == ["room torque limit 1", "room torque limit 2", "room torque limit 3", "saturated"]
        assert np.array_equal(flights.saturated, numbers[:, 10])
        assert np.array_equal(flights.parameters, numbers[:, 12:])
        assert flights.parameter_names == rows[0][14:] == list(plan.uncertainty["parameters"])
        assert flights.statistics == of_program["loops"][index]
        assert not flights.lost.any() and flights.runs == 50
    # And of a plan that was written.
    again = slewkit.closed_loop(tmp_path / "plan.json", runs=50, seed=4)
    assert np.array_equal(again.end, slewkit.closed_loop(plan, runs=50, seed=4).end)


def test_counts_and_deviations_are_those_of_the_arrays(plan):
    flights = slewkit.closed_loop(plan, runs=2000)
    violated = flights.violated["Sun"]
    assert violated["count"] == (flights.room[:, 0] < 0).sum()
    assert violated["interval"][0] <= violated["part"] == violated["count"] / 2000 <= violated["interval"][1]
    assert np.allclose(flights.sigma, flights.end.std(axis=0, ddof=1), rtol=1e-9)
    # Draws have the deviations that are assumed: five standard errors.
    assumed = np.array(list(plan.uncertainty["parameters"].values()))
    assert np.allclose(flights.parameters.std(axis=0), assumed, rtol=5 / np.sqrt(2 * 2000))
    # Gains hold what would miss by degrees; twice the error of the inertia is more.
    open_loop = slewkit.closed_loop(plan, runs=500, gains=False)
    assert open_loop.sigma[:3].max() > 10 * flights.sigma[:3].max()
    worse = slewkit.closed_loop(plan, runs=500, gains=False, overrides={"uncertainty.inertia.relative": 0.06})
    assert worse.sigma[:3].max() > 1.2 * open_loop.sigma[:3].max()


def test_what_cannot_be_flown_is_refused(plan, problems):
    free = slewkit.plan(problems / "xte_20s.toml")
    with pytest.raises(slewkit.PlanError) as refused:
        slewkit.closed_loop(free)
    assert refused.value.code == "E0173" and "uncertainty" in str(refused.value)
    uncertain = {"uncertainty.inertia.relative": 0.02}
    with pytest.raises(slewkit.PlanError, match="no gains"):
        slewkit.closed_loop(free, overrides=uncertain)
    assert slewkit.closed_loop(free, runs=2, gains=False, overrides=uncertain).runs == 2
    for wrong in [{"runs": 1}, {"runs": 10**9}, {"threads": 0}]:
        with pytest.raises(ValueError):
            slewkit.closed_loop(plan, **wrong)
    with pytest.raises(slewkit.SpecError):
        slewkit.closed_loop(plan, overrides={"uncertainty.inertia.relative": -1})
    with pytest.raises(slewkit.Interrupted):
        slewkit.closed_loop(plan, runs=1_000_000, progress=lambda told: told.stage != "flights")


def test_a_sequence_is_flown_over_all_its_stops(slew, tmp_path):
    spec = {
        "format": 1,
        "name": "two stops",
        "body": {"inertia_kg_m2": [1, 2, 2.5]},
        "actuators": {"torque_limit_n_m": 0.5, "torque_limit_reserve_n_m": 0.1},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "maneuver": {"minimize": "time", "steps": 40},
        "stop": [
            {"name": "near", "attitude": {"axis": [1, 0, 0], "angle_deg": 50}, "hold_s": 8},
            {"name": "far", "attitude": {"axis": [1, 0, 0], "angle_deg": 120}},
        ],
        "uncertainty": {"inertia": {"relative": 0.02}},
        "feedback": {"kind": "tvlqr"},
    }
    plan = slewkit.plan_sequence(spec)
    flights = slewkit.closed_loop(plan, runs=60, seed=3)
    assert flights.stops.shape == (60, 3, 6)
    instants = [(one["stop"], one["event"]) for one in flights.statistics["stops"]]
    assert instants == [("near", "hold begins"), ("near", "hold ends"), ("far", "hold begins")]
    assert np.array_equal(flights.stops[:, 2], flights.end)
    turn = np.linalg.norm(flights.stops[:, :, :3], axis=2)
    assert np.median(turn[:, 1]) < 0.1 * np.median(turn[:, 0])
    plan.save(tmp_path / "plan.json")
    slew("fly", tmp_path / "plan.json", "--cases", 60, "--seed", 3, "-q", "-o", tmp_path / "cases.json")
    of_program = json.loads((tmp_path / "cases.json").read_text())
    assert flights.statistics == of_program["loops"][0]
