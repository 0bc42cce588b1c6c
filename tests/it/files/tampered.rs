//! Plan files of every kind with a figure, a word or an entry falsified: `verify` reports each,
//! except for those that it reports as not judged.

use super::good;
use evidence::Random;
use evidence::damaged::{Called, DAMAGES, Files, called};
use serde_json::{Value, json};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::export::{Judgement, NOT_JUDGED, PlanFile, Seal};
use slewkit_files::spec::Loaded;

const HEAD: &str = r#"
format = 1
name = "tampered"
epoch = "2026-11-21T07:00:00 UTC"
[names]
object = "DEMO"
reference_frame = "ICRF"
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 10 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
"#;
const TORQUES: &str = r#"
[actuators]
torque_axes_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
torque_limit_n_m = 0.2
"#;

/// Returns a maneuver of each kind of file.
fn kinds() -> Vec<(&'static str, String)> {
    let plan = |more: &str| format!("{HEAD}{more}");
    vec![
        ("effort", plan("[maneuver]\nduration_s = 60\nsteps = 12\n")),
        ("limits", plan(&format!("[maneuver]\nduration_s = 48\nsteps = 12\n{TORQUES}"))),
        ("time", plan(&format!("[maneuver]\nminimize = \"time\"\nsteps = 20\n{TORQUES}"))),
        ("fuel", plan(&format!("[maneuver]\nminimize = \"fuel\"\nduration_s = 80\nsteps = 20\n{TORQUES}"))),
        (
            "pulses",
            plan(&format!(
                "[maneuver]\nminimize = \"fuel\"\nduration_s = 80\nsteps = 20\n{TORQUES}shortest_pulse_s = 2\n"
            )),
        ),
        ("motion", plan("[maneuver]\nduration_s = 60\nsteps = 12\n[solver]\ntarget = \"motion\"\n")),
        (
            "cones",
            plan(
                r#"
[maneuver]
duration_s = 60
steps = 12
[[constraint]]
kind = "keep_out"
name = "Sun"
boresight_body = [1, 0, 0]
direction_inertial = { ra_deg = 50, dec_deg = 15 }
half_angle_deg = 20
[[constraint]]
kind = "rate_limit"
angular_velocity_limit_deg_s = 3.5
"#,
            ),
        ),
        (
            "wheels",
            plan(
                r#"
[maneuver]
duration_s = 60
steps = 12
[[actuators.wheel]]
axis_body = [1, 0, 0]
torque_limit_n_m = 0.5
momentum_limit_n_m_s = 20
[[actuators.wheel]]
axis_body = [0, 1, 0]
torque_limit_n_m = 0.5
[[actuators.wheel]]
axis_body = [0, 0, 1]
torque_limit_n_m = 0.5
momentum_n_m_s = 1
"#,
            ),
        ),
        (
            "orbit frame",
            plan(
                "[environment]\nkind = \"gravity_gradient\"\norbital_rate_rad_s = 1.1e-3\n[maneuver]\n\
                    duration_s = 300\nsteps = 12\n",
            )
            .replace("ICRF", "LVLH")
            .replace("[end]", "angular_velocity_rad_s = [0, 1e-3, 0]\n[end]")
            .replace("40] }", "40] }\nangular_velocity_rad_s = [0, 1e-3, 0]"),
        ),
        (
            "moving body",
            r#"
format = 1
[body]
inertia_kg_m2 = [2, 3, 4]
mass_kg = 2
[start]
attitude = { quaternion_wxyz = [1, 0, 0, 0] }
position_m = [100, 0, 0]
velocity_m_s = [0, 0.1, 0]
[end]
attitude = { axis = [0, 0, 1], angle_deg = 70 }
position_m = [0, 100, 0]
velocity_m_s = [-0.1, 0, 0]
[environment]
kind = "central_gravity"
gravitational_parameter_m3_s2 = 1.0
body = "second_order"
[maneuver]
duration_s = 600
steps = 12
"#
            .into(),
        ),
    ]
}

/// Returns the text of a plan file as JSON, and the spec and the plan that it was made from.
fn planned(name: &str, text: &str) -> (Value, Loaded) {
    let loaded = good(text, &[]);
    let made = plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
    assert_eq!(made.status, Status::Solved, "{name}");
    let mut bytes = Vec::new();
    let file = PlanFile::new(&loaded.problem, &loaded.settings, &made).with_identity(&loaded.identity);
    file.write(&mut bytes).unwrap();
    (serde_json::from_slice(&bytes).unwrap(), loaded)
}

/// Returns the judgement of a file by its own spec; `None` if the file is refused.
fn judged(file: &Value) -> Option<Judgement> {
    let bytes = serde_json::to_vec(file).unwrap();
    let file = PlanFile::read(&bytes[..]).ok()?;
    let own = file.spec.as_ref()?.read("plan", &[]).ok()?;
    file.judge(&own.problem, &own.settings, &own.identity, &own.closed_loop, &|| false).ok()
}

/// Collects the path of every figure, word and list of a tree, and some paths of long lists.
fn paths(of: &Value, at: &str, found: &mut Vec<String>) {
    if !at.is_empty() {
        found.push(at.into());
    }
    match of {
        Value::Object(map) => map.iter().for_each(|(key, value)| paths(value, &format!("{at}/{key}"), found)),
        Value::Array(list) => {
            for index in [0, 1, list.len() / 2, list.len().saturating_sub(1)] {
                let path = format!("{at}/{index}");
                if let Some(value) = list.get(index)
                    && !found.contains(&path)
                {
                    paths(value, &path, found);
                }
            }
        }
        _ => {}
    }
}

/// Returns the values to which a figure, a word or a list could be falsified. A figure is changed
/// by more than round-off.
fn falsified(value: &Value) -> Vec<Value> {
    const ROUND_OFF: f64 = 1e-7;
    match value {
        Value::Bool(is) => vec![json!(!is)],
        Value::Number(number) if !number.is_f64() => {
            let count = number.as_i64().unwrap();
            vec![json!(count + 1), json!(2 * count + 3), json!(0)]
                .into_iter()
                .filter(|to| to != value)
                .collect()
        }
        Value::Number(number) => {
            let figure = number.as_f64().unwrap();
            let to = [1.01 * figure, -figure, 0.0, figure + 1e3 * (1.0 + figure.abs())];
            let mut to: Vec<Value> =
                to.into_iter().filter(|to| (to - figure).abs() > ROUND_OFF).map(|to| json!(to)).collect();
            to.push(Value::Null);
            to
        }
        Value::String(word) => vec![json!(format!("{word}x"))],
        Value::Array(list) => {
            let (mut shorter, mut longer) = (list.clone(), list.clone());
            longer.push(shorter.pop().unwrap_or(json!(1)));
            longer.extend(longer.last().cloned());
            vec![json!([]), json!(shorter), json!(longer)].into_iter().filter(|to| to != value).collect()
        }
        Value::Null => vec![json!(1.0)],
        Value::Object(_) => Vec::new(),
    }
}

/// Returns whether a key is reported as not judged, or is not a statement of a plan.
fn is_open(path: &str) -> bool {
    let names: Vec<&str> = path.split('/').skip(1).filter(|part| part.parse::<usize>().is_err()).collect();
    let key = names.join(".");
    // A spec is a request. Another limit that the plan keeps too is another request.
    const ASKED: [&str; 1] = ["spec"];
    const BOUND: [&str; 5] =
        ["spec.body", "spec.start", "spec.end", "spec.environment", "spec.maneuver.duration_s"];
    if BOUND.iter().any(|of| key.starts_with(of)) {
        return false;
    }
    let all = NOT_JUDGED.iter().chain(&ASKED);
    all.into_iter().any(|of| key == *of || key.strip_prefix(of).is_some_and(|rest| rest.starts_with('.')))
}

/// Returns a limit that is met acts at many times alike, and each of them is right.
fn is_any_of_many(file: &Value, path: &str) -> bool {
    let Some((margin, key)) = path.rsplit_once('/') else { return false };
    let scaled = file.pointer(margin).and_then(|margin| margin.get("scaled")?.as_f64());
    matches!(key, "time_s" | "at") && scaled.is_some_and(|scaled| scaled.abs() < 1e-6)
}

/// Returns whether the sign of a quaternion ±1 is changed, which is one attitude.
fn is_turn_of_nothing(file: &Value, path: &str) -> bool {
    let row = path.rsplit_once('/').and_then(|(row, _)| file.pointer(row)).and_then(Value::as_array);
    path.contains("quaternion")
        && row.is_some_and(|row| row[1..].iter().all(|part| part.as_f64() == Some(0.0)))
}

fn every_figure_is_judged(kind: &str) {
    let (_, text) = kinds().into_iter().find(|(name, _)| *name == kind).unwrap();
    let (mut file, _) = planned(kind, &text);
    // The checksum of another program is not judged: the witnesses alone must find the fault.
    file["generator"] = json!("another program");
    file.as_object_mut().unwrap().remove("checksum");
    let right = judged(&file).unwrap();
    let failed: Vec<_> = right.verification.checks.iter().filter(|check| !check.passed).collect();
    assert!(right.verification.passed(), "{kind}: {failed:?} {:?}", right.recorded);
    assert!(right.differences.is_empty() && right.recorded.is_empty(), "{kind}: {right:?}");
    let mut all = Vec::new();
    paths(&file, "", &mut all);
    let (mut passed, mut count) = (Vec::new(), 0);
    for path in all.iter().filter(|path| !is_open(path)) {
        let of_spec = path.starts_with("/spec");
        let mut to = falsified(file.pointer(path).unwrap());
        if is_turn_of_nothing(&file, path) {
            to.retain(|to| to.as_f64().is_none_or(|to| to.abs() != 1.0));
        }
        if is_any_of_many(&file, path) {
            to.retain(|to| to.as_f64().is_none_or(|to| to > 1e3));
        }
        // A key that is omitted from a spec may have its default.
        to.retain(|to| !of_spec || !to.is_null() && to != &json!([]));
        let mut tampered: Vec<(String, Value)> = to
            .into_iter()
            .map(|to| {
                let mut other = file.clone();
                *other.pointer_mut(path).unwrap() = to.clone();
                (format!("{path} = {to}"), other)
            })
            .collect();
        let (above, key) = path.rsplit_once('/').unwrap();
        let mut other = file.clone();
        if let Some(Value::Object(map)) = other.pointer_mut(above)
            && !of_spec
            && !map[key].is_null()
        {
            map.remove(key);
            tampered.push((format!("{path} left out"), other));
        }
        for (what, tampered) in tampered {
            count += 1;
            if judged(&tampered).is_some_and(|found| found.verification.passed()) {
                passed.push(what);
            }
        }
    }
    assert!(count > 300, "{kind}: {count}");
    assert!(passed.is_empty(), "{kind}: {} of {count} pass:\n{}", passed.len(), passed.join("\n"));
}

#[test]
fn a_plan_of_effort_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("effort");
}
#[test]
fn a_plan_within_limits_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("limits");
}
#[test]
fn a_plan_of_minimum_time_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("time");
}
#[test]
fn a_plan_of_minimum_fuel_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("fuel");
}
#[test]
fn a_plan_of_pulses_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("pulses");
}
#[test]
fn a_plan_that_lands_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("motion");
}
#[test]
fn a_plan_under_cones_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("cones");
}
#[test]
fn a_plan_with_wheels_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("wheels");
}
#[test]
fn a_plan_in_a_frame_that_turns_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("orbit frame");
}
#[test]
fn a_plan_of_a_moving_body_has_no_figure_that_can_be_falsified() {
    every_figure_is_judged("moving body");
}

/// Nothing calls a file verified that was damaged in one figure, also where the figure does not
/// follow from the motion: costates, gains, covariances, claims of the search.
#[test]
fn no_damaged_file_is_called_verified() {
    const CASES: usize = 4;
    let files = Files::new().unwrap();
    let right = Called { verify: true, report: true, export: true };
    for file in files.all() {
        assert_eq!(called(file), right, "{}", file["spec"]);
    }
    for (kind, damage) in DAMAGES.into_iter().enumerate() {
        for index in 0..CASES {
            let (file, what) = files.damaged(damage, &mut Random::of_case(69, kind * CASES + index));
            assert!(!called(&file).verified(), "{damage:?}: {what}");
        }
    }
}

/// The checksum covers values and not their notation.
#[test]
fn another_notation_of_the_same_file_keeps_its_checksum() {
    let (file, _) = planned("effort", &kinds()[0].1);
    let seal = |text: String| PlanFile::read(text.as_bytes()).unwrap().seal;
    let mut other = file.clone();
    other["solve_time_s"] = json!(1.0);
    for text in [file.to_string(), serde_json::to_string_pretty(&file).unwrap(), other.to_string()] {
        assert!(matches!(seal(text), Seal::Intact));
    }
    let whole = file.to_string().replace("60.0", "60").replace(":0.0,", ":-0.0,");
    assert!(whole.contains(":60,") && matches!(seal(whole), Seal::Intact));
    other["name"] = json!("changed");
    assert!(matches!(seal(other.to_string()), Seal::Broken));
    other.as_object_mut().unwrap().remove("checksum");
    assert!(matches!(seal(other.to_string()), Seal::Broken));
    // The checksum of another version is not judged.
    other["generator"] = json!("slewkit 0.0.9");
    assert!(matches!(seal(other.to_string()), Seal::Foreign));
    other["name"] = file["name"].clone();
    let found = judged(&other).unwrap();
    assert!(found.verification.passed());
    assert!(found.not_judged.iter().any(|text| text.contains("checksum")), "{:?}", found.not_judged);
}

/// Names and the epoch are no requirements: a plan that is judged by a spec with other names is
/// verified, and the differences are reported.
#[test]
fn names_and_epoch_change_no_verdict_and_are_told() {
    let (file, loaded) = planned("effort", &kinds()[0].1);
    let bytes = serde_json::to_vec(&file).unwrap();
    let read = PlanFile::read(&bytes[..]).unwrap();
    let mut other = loaded.identity.clone();
    other.epoch = None;
    let found =
        read.judge(&loaded.problem, &loaded.settings, &other, &loaded.closed_loop, &|| false).unwrap();
    assert!(found.verification.passed(), "{found:?}");
    assert_eq!(found.differences.iter().map(|found| found.key.as_str()).collect::<Vec<_>>(), ["epoch"]);
    let mut tampered = file.clone();
    tampered["verified"]["order"] = json!(3.0);
    let read = serde_json::to_vec(&tampered).unwrap();
    let found = PlanFile::read(&read[..]).unwrap();
    let found =
        found.judge(&loaded.problem, &loaded.settings, &other, &loaded.closed_loop, &|| false).unwrap();
    assert!(!found.verification.passed());
    let keys: Vec<&str> = found.recorded.iter().map(|found| found.key.as_str()).collect();
    assert!(keys.contains(&"verified.order"), "{keys:?}");
}
