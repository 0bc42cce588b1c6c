"""Plans are those of the program, to the bit, and mean what they say."""

import base64
import functools
import json
import pickle
import re
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import slewkit


def same(first: dict, second: dict) -> None:
    """Two plan files without the one key that differs between two runs."""
    first, second = dict(first), dict(second)
    first.pop("solve_time_s"), second.pop("solve_time_s")
    assert first == second


@pytest.mark.parametrize(
    "name",
    ["xte_20s.toml", "keep_out_medium.toml", "minimum_time_xte.toml", "unstable_pendulum.toml",
        "wheels_pyramid.toml", "orbit_turn.toml", "flies.toml"],
)
def test_a_plan_has_the_bits_of_the_programs(name, problems, slew, tmp_path):
    slew("plan", problems / name, "-o", tmp_path / "plan.json", "-q")
    of_program = json.loads((tmp_path / "plan.json").read_text())
    plan = slewkit.plan(problems / name)
    same(plan.to_dict(), of_program)
    # And so has what was written as data, and what was read back.
    plan.save(tmp_path / "own.json")
    same(json.loads((tmp_path / "own.json").read_text()), of_program)
    same(slewkit.load(tmp_path / "plan.json").to_dict(), of_program)
    rows = of_program["trajectory"]
    assert plan.time.tolist() == rows["time_s"]
    assert plan.quaternions(scalar_first=True).tolist() == rows["quaternion_wxyz"]
    assert plan.angular_velocity.tolist() == rows["angular_velocity_rad_s"]
    assert plan.input.tolist() == rows["input"]
    assert plan.torque.tolist() == rows["torque_n_m"]
    assert plan.costates.tolist() == rows["costates"]
    assert plan.position.tolist() == rows.get("position_m", [])
    assert plan.force.tolist() == rows.get("force_n", [])
    if "wheel_momentum_n_m_s" in rows:
        assert plan.wheel_momentum.tolist() == rows["wheel_momentum_n_m_s"]


def test_gains_and_covariances_are_those_of_the_file(problems):
    plan = slewkit.plan(problems / "flies.toml")
    document = plan.to_dict()
    assert plan.gains.tolist() == document["feedback"]["gains"]
    covariance = plan.covariance
    assert covariance.shape == (len(plan.time), 6, 6)
    assert np.array_equal(covariance, covariance.transpose(0, 2, 1))
    sigma = np.degrees(np.sqrt(np.diagonal(covariance[-1])[:3]))
    assert np.allclose(sigma, document["uncertainty"]["closed_loop"]["end_attitude_sigma_deg"], rtol=1e-9)
    free = slewkit.plan(problems / "xte_20s.toml")
    assert free.gains.shape == (0, 3, 6) and free.covariance.shape == (0, 6, 6)


def test_gains_of_arcs_are_those_of_the_file(problems):
    plan = slewkit.plan(problems / "minimum_time_cube_180.toml", overrides={"feedback.kind": "switching"})
    arcs = plan.to_dict()["feedback"]["arcs"]
    assert plan.arc_gains.tolist() == [arc["gain"] for arc in arcs]
    assert plan.arc_lengths.sum() == pytest.approx(plan.duration)
    poses = slewkit.plan(problems / "free_flyer.toml", overrides={"feedback.kind": "tvlqr"})
    assert poses.gains.shape == (50, 6, 12)
    assert slewkit.plan(problems / "xte_20s.toml").arc_gains.shape == (0, 6)


def test_what_is_assumed_is_that_of_the_spec(problems):
    plan = slewkit.plan(problems / "flies.toml")
    assumed = plan.uncertainty
    assert np.allclose(np.sqrt(np.diagonal(assumed["start"])), np.radians([0.3] * 3 + [0.005] * 3), rtol=1e-12)
    assert np.allclose(np.sqrt(np.diagonal(assumed["sensor_noise"])), np.radians([0.003] * 3 + [1e-4] * 3), rtol=1e-12)
    assert np.allclose(assumed["torque_noise"], 1e-8 * np.eye(3), rtol=1e-12, atol=0)
    assert assumed["parameters"]["inertia xx"] == pytest.approx(2.4, rel=1e-12)
    assert assumed["parameters"]["bias of rate z"] == pytest.approx(np.radians(1e-5), rel=1e-12)
    assert len(assumed["parameters"]) == 24
    assert slewkit.plan(problems / "xte_20s.toml").uncertainty is None


def test_a_dictionary_means_what_a_file_means(spec, tmp_path, slew):
    text = slewkit.Problem(spec).to_toml()
    (tmp_path / "spec.toml").write_text(text)
    slew("plan", tmp_path / "spec.toml", "-o", tmp_path / "plan.json", "-q")
    of_program = json.loads((tmp_path / "plan.json").read_text())
    same(slewkit.plan(spec).to_dict(), of_program)
    same(slewkit.plan(slewkit.Problem(spec)).to_dict(), of_program)
    same(slewkit.plan(slewkit.Problem(spec).to_dict()).to_dict(), of_program)


def test_scipy_reads_the_attitudes(discrete):
    spec = discrete
    plan = slewkit.plan(spec)
    rotation = plan.rotation()
    target = Rotation.from_euler("ZYX", [30, -40, 70], degrees=True)
    assert (rotation[-1] * target.inv()).magnitude() < 1e-12
    assert np.allclose(rotation.as_matrix(), plan.rotation_matrices, atol=1e-15)
    assert (plan.quaternions()[:, 3] == plan.quaternions(scalar_first=True)[:, 0]).all()
    # Between two nodes the body turns by its rate times the step, in body axes, to second order.
    step = plan.time[1]
    turned = (rotation[:-1].inv() * rotation[1:]).as_rotvec() / step
    mean = (plan.angular_velocity[:-1] + plan.angular_velocity[1:]) / 2
    assert np.abs(turned - mean).max() < 1e-3 * np.abs(mean).max()
    # A target may be given as a rotation as well.
    spec["end"]["attitude"] = target
    assert slewkit.plan(spec).cost == pytest.approx(plan.cost, rel=1e-12)


def test_a_plan_lands_and_says_how(spec, discrete):
    plan = slewkit.plan(spec)
    target = Rotation.from_euler("ZYX", [30, -40, 70], degrees=True)
    assert (plan.rotation()[-1] * target.inv()).magnitude() < 1e-8
    assert plan.verification["continuous_attitude_rad"] < 1e-8
    landing = plan.landing
    assert landing["corrections"] == len(landing["misses"]) - 1 > 0
    assert landing["misses"][0] > 1e-5 and landing["misses"][-1] < 1e-8
    published = slewkit.plan(discrete)
    assert published.landing is None
    assert published.cost == pytest.approx(landing["cost_before"], rel=1e-12)
    assert published.cost < plan.cost
    assert published.verification["continuous_attitude_rad"] > 1e-5
    # Steps that are not given are chosen.
    assert plan.chosen_steps is None
    del spec["maneuver"]["steps"]
    chosen = slewkit.plan(spec)
    assert chosen.chosen_steps["began"] <= chosen.steps and chosen.chosen_steps["lands"]
    assert chosen.chosen_steps["cost_error"] < 1e-3


def test_the_laws_of_motion_hold_between_the_arrays(discrete):
    plan = slewkit.plan(discrete)
    momentum = plan.angular_momentum
    assert np.allclose(momentum, plan.angular_velocity * [120, 100, 80], rtol=1e-15)
    # What the torque adds to the inertial momentum; the trapezoidal sum is exact for Lie–Verlet.
    inertial = plan.rotation().apply(momentum)
    impulse = plan.rotation().apply(plan.torque) * plan.time[1]
    impulse[[0, -1]] /= 2
    assert np.allclose(inertial[-1] - inertial[0], impulse.sum(axis=0), atol=1e-10)
    # u = −W⁻¹ Bᵀ λ.
    assert np.allclose(plan.torque, -plan.costates[:, 3:], rtol=1e-14)
    effort = 0.5 * (plan.torque**2).sum(axis=1) * plan.time[1]
    effort[[0, -1]] /= 2
    assert plan.cost == pytest.approx(effort.sum(), rel=1e-13)


def test_arrays_are_made_once_and_are_the_callers(spec):
    plan = slewkit.plan(spec)
    before = plan.to_dict()
    assert plan.torque is plan.torque and plan.torque.dtype == np.float64 and plan.torque.flags["C_CONTIGUOUS"]
    for name in ["time", "angular_velocity", "input", "torque", "costates", "rotation_matrices"]:
        array = getattr(plan, name)
        # The memory that the library has filled, seen as rows: SciPy takes no array that cannot be
        # written.
        assert array.flags.writeable and (array.base is not None or array.ndim == 1)
        array[:] = 0
    assert plan.to_dict() == before


def test_a_maneuver_of_a_dictionary_has_a_name(spec, problems):
    named = slewkit.Problem(spec).name
    spec.pop("name")
    assert (named, slewkit.Problem(spec).name) == ("a slew", "maneuver")
    assert slewkit.Problem(slewkit.Problem(spec).to_dict()).name == "maneuver"


def test_tables_have_margins_where_they_are_asked_for(spec):
    plan = slewkit.plan(spec, overrides={"actuators.torque_limit_n_m": 5})
    bare, full = plan.to_dataframe(), plan.to_dataframe(margins=True)
    assert [name for name in full.columns if name not in bare.columns] == ["margin_torque_limit_n_m"]
    assert np.allclose(full["margin_torque_limit_n_m"], 5 - np.abs(plan.input).max(axis=1), atol=1e-14)


def test_lie_euler_has_a_row_of_inputs_less(spec):
    plan = slewkit.plan(spec, overrides={"solver.scheme": "lie_euler"})
    assert len(plan.time) == 101 and len(plan.torque) == len(plan.input_time) == 100
    assert plan.input_time[0] == plan.time[1]
    table = plan.to_dataframe()
    assert np.isnan(table["input_1_n_m"].iloc[0]) and table["input_1_n_m"].iloc[1] == plan.input[0, 0]


def test_minimum_time_has_arcs_and_switching_times(problems):
    plan = slewkit.plan(problems / "minimum_time_xte.toml")
    assert plan.duration == plan.cost == plan.time[-1] < 34.3
    arcs = plan.switching["arcs"]
    assert len(plan.switching_times) == len(arcs) - 1 > 0
    assert plan.inputs_are_held and len(plan.input_time) == len(plan.input) == plan.steps
    # Every input at a limit, all the time.
    assert np.allclose(np.abs(plan.input), np.abs(plan.input[0]), rtol=1e-12)
    assert plan.switching_times.tolist() == sorted(plan.switching_times.tolist())


def test_inputs_at_the_nodes_of_equal_steps_are_not_held(problems):
    pytest.importorskip("matplotlib").use("agg")
    plan = slewkit.plan(problems / "shortest_rate.toml")
    assert not plan.inputs_are_held and len(plan.input_time) == len(plan.input) == plan.steps + 1
    assert np.array_equal(plan.held_input, 0.5 * (plan.input[:-1] + plan.input[1:]))
    # What acts is drawn: the rows may alternate about it.
    lines = plan.plot().axes[2].lines
    assert np.array_equal(np.transpose([line.get_ydata()[:-1] for line in lines]), plan.held_input)
    arcs = slewkit.plan(problems / "minimum_time_xte.toml")
    assert np.array_equal(arcs.held_input, arcs.input) and len(arcs.held_input) == arcs.steps


def test_limits_margins_and_multipliers(problems):
    plan = slewkit.plan(problems / "keep_out_medium.toml")
    assert plan.margins and all(margin["scaled"] > -1e-9 for margin in plan.margins)
    for active in plan.active:
        assert len(active["time_s"]) == len(active["multiplier"]) > 0
        assert (active["multiplier"] >= 0).all()


def test_a_plan_is_pickled_and_so_is_a_problem(spec):
    plan = slewkit.plan(spec)
    again = pickle.loads(pickle.dumps(plan))
    assert again.to_dict() == plan.to_dict()
    problem = pickle.loads(pickle.dumps(slewkit.Problem(spec)))
    same(slewkit.plan(problem).to_dict(), plan.to_dict())


def test_a_plan_is_a_guess_for_its_neighbour(discrete, tmp_path):
    spec = discrete
    plan = slewkit.plan(spec)
    harder = {"maneuver.duration_s": 50}
    by_itself = slewkit.plan(spec, overrides=harder)
    plan.save(tmp_path / "plan.json")
    for guess in [plan, tmp_path / "plan.json", str(tmp_path / "plan.json"), plan.costates[0]]:
        guessed = slewkit.plan(spec, overrides=harder, guess=guess)
        assert guessed.cost == pytest.approx(by_itself.cost, rel=1e-9)
        assert guessed.to_dict()["ladder"][0]["rung"] == "guess"


def test_every_ending_is_written(spec, tmp_path):
    spec["epoch"] = "2026-11-21T07:00:00 UTC"
    spec["names"] = {"object": "XTE", "spice_id": -125544, "reference_frame": "ICRF"}
    plan = slewkit.plan(spec)
    for ending in "json jsonl csv aem xml apm a bc tsc tf npz mat 42 flight".split():
        path = tmp_path / f"plan.{ending}"
        plan.save(path)
        assert path.stat().st_size > 100, ending
        with pytest.raises(slewkit.FileError) as caught:
            plan.save(path)
        assert caught.value.code == "E0098" and "overwrite=True" in str(caught.value)
        plan.save(path, overwrite=True)
    plan.save(tmp_path / "table.txt", format="basilisk")
    arrays = np.load(tmp_path / "plan.npz")
    assert (arrays["torque_n_m"] == plan.torque).all()
    with pytest.raises(slewkit.FileError, match="no format has the ending"):
        plan.save(tmp_path / "plan.xlsx")


def test_a_table_has_every_number(spec):
    plan = slewkit.plan(spec)
    table = plan.to_dataframe()
    assert table.index.name == "time_s" and (table.index.to_numpy() == plan.time).all()
    columns = [f"torque_{axis}_n_m" for axis in "xyz"]
    assert (table[columns].to_numpy() == plan.torque).all()


def test_something_to_look_at(spec, tmp_path):
    import matplotlib

    matplotlib.use("agg")
    plan = slewkit.plan(spec)
    page = plan.report(tmp_path / "report.html")
    assert page == (tmp_path / "report.html").read_text() and page.startswith("<!DOCTYPE html>")
    assert "solved and verified" in page
    plan.plot().savefig(tmp_path / "plan.png")
    assert (tmp_path / "plan.png").stat().st_size > 10_000
    assert "solved and verified" in plan.summary() and "solved" in repr(plan)
    # Where the true motion ends, as the plan file has it.
    assert plan.accuracy == plan.to_dict()["accuracy"]
    assert plan.accuracy is not None and plan.accuracy["continuous_attitude_deg"] < 1e-3


def pictures_in(page):
    """Returns the SVG files that stand in a page as data."""
    return [base64.b64decode(data).decode() for data in re.findall(r"data:image/svg\+xml;base64,([^\"]+)", page)]


def test_a_notebook_shows_summary_sky_and_inputs(spec, problems):
    plan = slewkit.plan(spec | {"name": "<b>a & b</b>"})
    page = plan._repr_html_()
    # It is shown without scripts, as notebooks that are not trusted are.
    assert "<script" not in page and "<iframe" not in page
    assert "&lt;b&gt;a &amp; b&lt;/b&gt;" in page and "<b>" not in page and "solved and verified" in page
    assert pictures_in(page) == [plan.pictures()[name] for name in ("sky", "inputs")]
    moving = slewkit.plan(problems / "minimum_fuel_rcs.toml")
    assert len(pictures_in(moving._repr_html_())) >= 2
    refused = slewkit.plan(spec, overrides={"maneuver.duration_s": 1, "actuators.torque_limit_n_m": 1e-3}, strict=False)
    assert "infeasible" in refused._repr_html_() and refused.time.size == 0


def test_pictures_are_those_of_the_program(spec, slew, tmp_path):
    plan = slewkit.plan(spec)
    plan.save(tmp_path / "plan.json")
    slew("plot", tmp_path / "plan.json", "-o", tmp_path / "figures")
    drawn = {path.stem: path.read_text(encoding="utf-8") for path in (tmp_path / "figures").glob("*.svg")}
    assert plan.pictures() == drawn and {"sky", "inputs", "rates"} <= set(drawn)
    slew("plot", tmp_path / "plan.json", "-o", tmp_path / "both.svg", "--charts", "sky,rates")
    panel = plan.panel(["sky", "rates"], tmp_path / "written.svg")
    assert panel == (tmp_path / "both.svg").read_text(encoding="utf-8")
    assert panel == (tmp_path / "written.svg").read_text(encoding="utf-8")
    assert pictures_in(panel._repr_html_()) == [panel]
    with pytest.raises(ValueError, match='no picture "clearance"; its pictures are sky, inputs'):
        plan.panel(["sky", "clearance"])


def test_an_unknown_sequence_of_euler_angles_is_refused(spec):
    plan = slewkit.plan(spec)
    simulation = slewkit.simulate(spec, stride=50)
    panel = functools.partial(plan.panel, ["euler"])
    for drawn in (plan.report, plan.pictures, panel, simulation.report):
        assert drawn(euler="xyz") != drawn(euler="zyx")
        for wrong in ("", "z", "abc", "zyxz", "zyé"):
            with pytest.raises(ValueError, match="the sequences are xyz, xzy"):
                drawn(euler=wrong)


def test_a_dataset_has_every_array_with_units_and_axes(spec, problems):
    pytest.importorskip("xarray")
    plan = slewkit.plan(problems / "wheels_pyramid.toml")
    data = plan.to_xarray()
    assert np.array_equal(data.time, plan.time) and data.attrs["status"] == "solved"
    for name in ("angular_velocity", "angular_momentum", "torque", "input", "wheel_momentum", "costates"):
        assert np.array_equal(data[name], getattr(plan, name)), name
        assert data[name].dims[0] == "time"
    assert np.array_equal(data.quaternion, plan.quaternions())
    assert np.array_equal(data.held_input, plan.held_input) and np.array_equal(data.step_time, plan.time[:-1])
    assert data.torque.attrs == {"units": "N m", "axes": "body"}
    assert np.array_equal(data.torque.sel(axis="y"), plan.torque[:, 1])
    assert list(data.wheel.values) == list(data.input_name.values) == plan.input_names == ["+x", "+y", "-x", "-y"]
    # What the plan lacks is left out.
    assert not {"position", "velocity", "force", "gains", "covariance"} & set(data.variables)


def test_datasets_of_every_kind_of_plan(spec, problems):
    pytest.importorskip("xarray")
    arcs = slewkit.plan(problems / "minimum_time_xte.toml").to_xarray()
    assert arcs.input.dims == ("input_time", "input_name") and arcs.held_input.dims[0] == "step_time"
    euler = slewkit.plan(spec, overrides={"solver.scheme": "lie_euler"})
    data = euler.to_xarray()
    assert data.torque.dims == ("input_time", "axis") and np.array_equal(data.input_time, euler.input_time)
    moving = slewkit.plan(problems / "minimum_fuel_rcs.toml")
    data = moving.to_xarray()
    assert np.array_equal(data.position, moving.position) and np.array_equal(data.force, moving.force)
    assert list(data.costate.values[:2]) == ["x_1", "x_2"] and len(data.costate) == 12
    flies = slewkit.plan(problems / "flies.toml")
    data = flies.to_xarray()
    assert np.array_equal(data.gains, flies.gains) and np.array_equal(data.covariance, flies.covariance)
    assert data.covariance.sel(deviation="zeta_x", deviation_="zeta_x")[-1] == flies.covariance[-1, 0, 0]
    refused = slewkit.plan(spec, overrides={"maneuver.duration_s": 1, "actuators.torque_limit_n_m": 1e-3}, strict=False)
    assert refused.to_xarray().attrs["status"] == "infeasible" and refused.to_xarray().time.size == 0


@pytest.mark.parametrize("package, method", [("pandas", "to_dataframe"), ("xarray", "to_xarray")])
def test_a_package_that_is_missing_is_named_with_its_command(spec, monkeypatch, package, method):
    plan = slewkit.plan(spec)
    # An import of a module that is None fails as that of one that is not installed.
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"Plan\.{method} needs {package}: `pip install slewkit\[{package}\]`"):
        getattr(plan, method)()
