"""verify, compare, simulate, check: as the program does them."""

import json

import numpy as np
import pytest

import slewkit


def test_the_witnesses_judge_as_the_program_has_them(spec, slew, tmp_path):
    plan = slewkit.plan(spec)
    plan.save(tmp_path / "plan.json")
    of_program = json.loads(slew("verify", tmp_path / "plan.json", "--format", "json", "-q").stdout)
    for judged in [slewkit.verify(plan), slewkit.verify(tmp_path / "plan.json"), slewkit.verify(plan.to_dict())]:
        assert judged.passed and judged.found == of_program["verified"] and judged.differences == []
    assert {check["name"] for check in judged.checks} >= {"discrete terminal", "order", "recorded cost"}


def test_a_plan_that_was_changed_fails(spec):
    changed = slewkit.plan(spec).to_dict()
    changed["trajectory"]["input"][50][1] *= 1 + 1e-6
    judged = slewkit.verify(changed)
    assert not judged.passed and any(not check["passed"] for check in judged.checks)
    with pytest.raises(slewkit.VerificationFailed, match="discrete terminal"):
        slewkit.verify(changed, strict=True)
    changed["trajectory"]["input"] = changed["trajectory"]["input"][:-1]
    with pytest.raises(slewkit.VerificationFailed, match="rows"):
        slewkit.verify(changed)


def test_a_plan_before_another_spec(spec):
    plan = slewkit.plan(spec)
    other = slewkit.verify(plan, overrides={"end.angular_velocity_rad_s": [0, 0, 0.01]})
    assert not other.passed and [one["key"] for one in other.differences] == ["end.angular_velocity_rad_s"]
    assert slewkit.verify(plan, spec).passed


@pytest.mark.parametrize("ending", ["aem", "csv"])
def test_attitudes_alone_are_judged_by_a_spec(spec, slew, tmp_path, ending):
    spec = {**spec, "epoch": "2026-11-21T07:00:00 UTC", "solver": {"continuous_tolerance_deg": 0.5}}
    file = tmp_path / f"plan.{ending}"
    slewkit.plan(spec).save(file)
    found = slewkit.verify(file, spec)
    (tmp_path / "spec.toml").write_text(slewkit.Problem(spec).to_toml())
    of_program = json.loads(slew("verify", file, "--spec", tmp_path / "spec.toml", "--format", "json", "-q").stdout)
    assert found.passed and found.checks == of_program["checks"] and found.violations == []
    assert found.margins == [] and found.steps + 1 == of_program["rows"]
    elsewhere = {"end.attitude": {"axis": [0, 0, 1], "angle_deg": 5}}
    assert not slewkit.verify(file, spec, overrides=elsewhere).passed
    with pytest.raises(slewkit.VerificationFailed, match="attitude at the end"):
        slewkit.verify(file, spec, overrides=elsewhere, strict=True)
    with pytest.raises(ValueError, match="give the spec"):
        slewkit.verify(file)
    file.write_text(file.read_text()[:-40])
    with pytest.raises(slewkit.FileError, match="E0151.*(cells|numbers)"):
        slewkit.verify(file, spec)


def test_integrators_side_by_side(problems, slew):
    asked = ["--integrators", "lie_verlet,explicit_midpoint", "--step", "0.2,0.1", "--horizon", "2,10"]
    of_program = json.loads(slew("compare", problems / "dzhanibekov.toml", *asked, "--format", "json", "-q").stdout)
    found = slewkit.compare_integrators(
        problems / "dzhanibekov.toml", integrators=["lie_verlet", "explicit_midpoint"], steps=[0.2, 0.1],
        horizons=[2, 10]
    )
    key = lambda run: {name: value for name, value in run.items() if "time" not in name and "seconds" not in name}
    assert [key(run) for run in found.runs] == [key(run) for run in of_program["runs"]]
    assert found.levels == of_program["levels"] and "explicit_midpoint" in str(found)
    with pytest.raises(slewkit.Interrupted):
        slewkit.compare_integrators(problems / "dzhanibekov.toml", progress=lambda told: False)
    with pytest.raises(ValueError, match="order"):
        slewkit.compare_integrators(problems / "dzhanibekov.toml", steps=[0.1, 0.2])
    with pytest.raises(ValueError, match="maneuver"):
        slewkit.compare_integrators(problems / "xte_20s.toml")


def test_methods_side_by_side(spec, slew, tmp_path):
    found = slewkit.compare(spec)
    assert found.status == "solved" and [method["method"] for method in found.methods] == ["shooting", "scp",
        "scp_polish"]
    (tmp_path / "spec.toml").write_text(slewkit.Problem(spec).to_toml())
    of_program = json.loads(slew("compare", tmp_path / "spec.toml", "--format", "json", "-q").stdout)
    assert [method["cost"] for method in found.methods] == [method["cost"] for method in of_program["methods"]]
    assert found.agreement == of_program["agreement"]


@pytest.mark.parametrize("name", ["dumbbells.toml", "dzhanibekov.toml", "wheels_pyramid.toml", "xte_20s.toml"])
def test_a_simulation_has_the_rows_of_the_programs(name, problems, slew):
    arguments = ["--steps", 3000, "--stride", 300]
    of_program = json.loads(slew("simulate", problems / name, *arguments, "--format", "json", "-q").stdout)
    found = slewkit.simulate(problems / name, steps=3000, stride=300)
    document = found.to_dict()
    rows = dict(of_program["trajectory"])
    rows.pop("wheel_momentum_n_m_s", None)
    assert document["trajectory"] == rows
    assert all(document[key] == of_program[key] for key in ["status", "name", "integrator", "steps", "step_s",
        "stride"])
    assert len(found.time) == 11 and found.orthogonality.max() < 1e-12
    assert "</html>" in found.report()


def test_a_simulation_keeps_its_momentum(spec):
    spec["start"]["angular_velocity_rad_s"] = [0.1, 2e-3, 0]
    found = slewkit.simulate(spec, steps=1000)
    body = found.bodies[0]
    assert np.ptp(found.angular_momentum, axis=0).max() < 1e-12
    inertial = body.rotation().apply(body.angular_velocity * [120, 100, 80])
    assert np.allclose(inertial, found.angular_momentum, atol=1e-12)
    # A torque about z for a minute, from rest.
    spec["start"]["angular_velocity_rad_s"] = [0, 0, 0]
    turned = slewkit.simulate(slewkit.Problem(spec), inputs=[0, 0, 0.02])
    assert turned.bodies[0].angular_velocity[-1] == pytest.approx([0, 0, 0.02 * 60 / 80], rel=1e-12)


def test_a_simulation_is_stopped_and_refused(problems, spec):
    with pytest.raises(slewkit.Interrupted) as caught:
        slewkit.simulate(problems / "dumbbells.toml", steps=100_000, progress=lambda progress: False)
    assert caught.value.simulation.status == "interrupted" and len(caught.value.simulation.time) < 1000
    with pytest.raises(ValueError, match="integrator"):
        slewkit.simulate(spec, integrator="lie_verle")
    with pytest.raises(ValueError, match="finite"):
        slewkit.simulate(spec, inputs=[0, np.nan, 0])
    with pytest.raises(ValueError, match="inputs"):
        slewkit.simulate(problems / "dumbbells.toml", inputs=[0, 0, 0])
    with pytest.raises(slewkit.SpecError, match="simulation"):
        slewkit.plan(problems / "dumbbells.toml")


def test_a_spec_is_checked(problems, spec):
    assert slewkit.check(spec) == slewkit.check(slewkit.Problem(spec)) == []
    assert slewkit.check(problems / "dumbbells.toml") == []
    assert slewkit.check(spec, overrides={"maneuver.steps": 0})[0].key == "maneuver.steps"
