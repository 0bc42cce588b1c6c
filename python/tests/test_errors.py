"""What goes wrong is told: where, why, and what to do."""

import pickle

import numpy as np
import pytest

import slewkit


def test_all_errors_of_a_dictionary_at_once_with_their_keys(spec):
    spec["body"]["inertia_kg_m2"] = [[1.0, 0, 0], [0, np.nan, 0], [0, 0, 1]]
    spec["maneuver"]["duration_s"] = -3
    spec["maneuver"]["stepz"] = 10
    with pytest.raises(slewkit.SpecError) as caught:
        slewkit.plan(spec)
    error = caught.value
    assert isinstance(error, ValueError) and error.exit_code == 3
    keys = {one.key for one in error.diagnostics}
    assert any(key.startswith("body.inertia_kg_m2") for key in keys), keys
    assert {"maneuver.duration_s", "maneuver.stepz"} <= keys
    typo = next(one for one in error.diagnostics if one.key == "maneuver.stepz")
    assert typo.file == "dict" and typo.line > 1 and typo.code.startswith("E") and "steps" in typo.remedy
    assert "error[" in str(error) and "maneuver.stepz" not in typo.remedy
    again = pickle.loads(pickle.dumps(error))
    assert again.diagnostics == error.diagnostics and str(again) == str(error)
    # The same without an exception.
    assert slewkit.check(spec) == error.diagnostics
    assert slewkit.check({"format": 1})[0].severity == "error"


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, float("nan"), np.float32("nan")])
def test_no_number_that_is_not_finite_passes(spec, number):
    for path in [("body", "inertia_kg_m2"), ("maneuver", "duration_s"), ("end", "attitude")]:
        changed = {**spec, path[0]: {**spec[path[0]]}}
        value = {"axis": [0, 0, 1], "angle_deg": number} if path[1] == "attitude" else number
        changed[path[0]][path[1]] = [1, 1, number] if path[1].startswith("inertia") else value
        with pytest.raises(slewkit.SpecError) as caught:
            slewkit.plan(changed)
        assert any(one.key.startswith(".".join(path)) for one in caught.value.diagnostics)


def test_what_has_no_notation_is_named(spec):
    spec["maneuver"]["steps"] = None
    with pytest.raises(TypeError, match="maneuver.steps: None has no notation in a spec; remove the key"):
        slewkit.plan(spec)
    spec["maneuver"]["steps"] = object()
    with pytest.raises(TypeError, match="maneuver.steps"):
        slewkit.plan(spec)
    with pytest.raises(TypeError, match="the keys of a spec are text"):
        slewkit.plan({1: 2})


def test_a_dictionary_that_holds_itself_or_is_huge(spec):
    spec["body"]["self"] = spec["body"]
    with pytest.raises(slewkit.SpecError):
        slewkit.plan(spec)
    twice = []
    twice += [twice, twice]
    spec["body"] = {"inertia_kg_m2": twice}
    with pytest.raises(slewkit.SpecError):
        slewkit.plan(spec)
    spec["body"] = {"inertia_kg_m2": np.ones((400, 400))}
    with pytest.raises(slewkit.SpecError):
        slewkit.plan(spec)


def test_texts_are_quoted(spec):
    spec["name"] = 'quotes " and \\ and \n lines \u2028 [tables] = 1'
    spec["odd key.\n"] = {"a b": 1}
    keys = {one.key for one in slewkit.check(spec)}
    assert len(keys) == 1 and next(iter(keys)).startswith("odd key.")
    del spec["odd key.\n"]
    assert slewkit.Problem(spec).name == spec["name"]


def test_files_that_cannot_be_used(tmp_path, spec):
    with pytest.raises(slewkit.FileError) as caught:
        slewkit.plan(tmp_path / "none.toml")
    assert isinstance(caught.value, OSError) and caught.value.code == "E0015" and caught.value.exit_code == 8
    with pytest.raises(slewkit.FileError):
        slewkit.load(tmp_path / "none.json")
    (tmp_path / "plan.json").write_text("{}")
    with pytest.raises(slewkit.FileError, match="not a plan file"):
        slewkit.load(tmp_path / "plan.json")
    with pytest.raises(slewkit.FileError, match="not a plan file"):
        slewkit.load({"format": 2})
    with pytest.raises(slewkit.SpecError, match="epoch"):
        slewkit.plan(spec).save(tmp_path / "plan.aem")
    assert not (tmp_path / "plan.aem").exists()
    with pytest.raises(slewkit.FileError):
        slewkit.plan(spec).save(tmp_path / "no folder" / "plan.json")


def test_what_is_proved_infeasible(spec):
    spec["actuators"] = {"torque_limit_n_m": 1e-3}
    with pytest.raises(slewkit.Infeasible) as caught:
        slewkit.plan(spec)
    error = caught.value
    assert error.exit_code == 4 and error.plan.status == "infeasible" and len(error.reason) > 40
    # The whole proof, of which the summary shows a part in each line.
    words = " ".join(error.plan.summary().split())
    assert "60 s allow at most" in error.reason and error.reason.partition("infeasible: ")[2] in words
    assert np.isnan(error.plan.cost) and error.plan.time.shape == (0,) and error.plan.verification is None
    assert error.plan.to_dict()["shortest_duration_s"] > 60
    assert slewkit.plan(spec, strict=False).status == "infeasible"
    again = pickle.loads(pickle.dumps(error))
    assert again.plan.status == "infeasible" and again.reason == error.reason
    assert "No plan exists" in error.plan.report()


def test_what_is_not_solved_has_the_best_iterate(spec):
    hard = {"solver.max_iterations": 1, "solver.method": "shooting", "maneuver.path": "long"}
    with pytest.raises(slewkit.NotSolved, match="the iteration limit was reached") as caught:
        slewkit.plan(spec, overrides=hard)
    assert caught.value.exit_code == 5 and caught.value.plan.status == "not_converged"
    assert caught.value.plan.to_dict()["ladder"]


def test_what_is_not_verified(spec):
    with pytest.raises(slewkit.VerificationFailed) as caught:
        slewkit.plan(spec, overrides={"solver.continuous_tolerance_deg": 1e-9})
    assert caught.value.exit_code == 7 and caught.value.plan.time.size == 101
    assert "continuous terminal" in caught.value.reason


def test_a_time_limit(problems):
    with pytest.raises(slewkit.LimitReached) as caught:
        slewkit.plan(problems / "keep_out_medium.toml", overrides={"solver.time_limit_s": 1e-4})
    assert caught.value.exit_code == 6


def test_overrides_and_their_mistakes(spec):
    assert slewkit.plan(spec, overrides={"maneuver.duration_s": 90.5}).duration == 90.5
    # A problem is overridden in the words of its spec, and once more.
    problem = slewkit.Problem(spec, overrides={"maneuver.duration_s": 90})
    turned = slewkit.plan(problem, overrides={"end.attitude.euler_zyx_deg": [0, 0, 45]})
    assert turned.duration == 90 and turned.rotation()[-1].magnitude() == pytest.approx(np.pi / 4, abs=1e-9)
    assert slewkit.simulate(problem, overrides={"maneuver.duration_s": 30}).duration == 30
    with pytest.raises(slewkit.SpecError) as caught:
        slewkit.plan(spec, overrides={"maneuver.durations": 90})
    assert caught.value.diagnostics[0].file == "command line"
    with pytest.raises(ValueError, match="not a key path"):
        slewkit.plan(spec, overrides={"maneuver..steps": 90})
    with pytest.raises(slewkit.SpecError):
        slewkit.plan(spec, overrides={"maneuver.duration_s": np.nan})


def test_warnings_are_warned_of(spec):
    spec["end"]["attitude"] = {"quaternion_wxyz": [0.7071, 0, 0, 0.7071]}
    with pytest.warns(slewkit.SpecWarning, match="W0"):
        problem = slewkit.Problem(spec)
    assert problem.warnings[0].severity == "warning"


def test_a_guess_of_another_kind(spec):
    with pytest.raises(slewkit.FileError) as caught:
        slewkit.plan(spec, guess=[1.0, 2.0])
    assert caught.value.code == "E0103"
    with pytest.raises(slewkit.FileError):
        slewkit.plan(spec, guess=[np.nan] * 6)


def test_a_maneuver_that_reads_well_and_cannot_be(spec):
    spec["start"]["angular_velocity_rad_s"] = [0, 0, 40]
    with pytest.raises(slewkit.SpecError) as caught:
        slewkit.plan(spec)
    assert caught.value.diagnostics
