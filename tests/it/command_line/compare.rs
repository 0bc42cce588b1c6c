//! `slew compare`: methods and integrators side by side.

use super::binary::Folder;
use serde_json::Value;
use std::fs;

/// Returns a comparison as a document, without the lines that hold a time.
fn comparison(folder: &Folder, args: &[&str]) -> (Value, Vec<String>) {
    let mut all = vec!["compare", "spec.toml", "-q", "--format", "json"];
    all.extend(args);
    let run = folder.slew(&all).ends(0).silent();
    let mut document = run.json();
    let mut times = Vec::new();
    // Every key that holds a time is called so.
    fn strip(value: &mut Value, path: &str, times: &mut Vec<String>) {
        match value {
            Value::Object(map) => {
                if map.remove("solve_time_s").is_some() {
                    times.push(path.to_string());
                }
                map.iter_mut().for_each(|(key, value)| strip(value, &format!("{path}.{key}"), times));
            }
            Value::Array(list) => list.iter_mut().for_each(|value| strip(value, path, times)),
            _ => {}
        }
    }
    strip(&mut document, "", &mut times);
    (document, times)
}

#[test]
fn compare_sets_the_methods_side_by_side() {
    let folder = Folder::new();
    let run = folder.slew(&["compare", "spec.toml"]).ends(0).tells("test slew").tells("the methods agree");
    assert_eq!(run.stdout, "");
    let run = run.tells("shooting  ").tells("scp + polish").tells("costs").tells("Newton step");
    assert!(!run.stderr.contains('\u{1b}'), "no colour and no progress off a terminal");
    let (document, times) = comparison(&folder, &[]);
    assert_eq!(document["compares"], "methods");
    assert_eq!((document["status"].as_str(), document["exit_code"].as_u64()), (Some("solved"), Some(0)));
    assert_eq!(document["steps"], 100);
    let methods = document["methods"].as_array().unwrap();
    let names: Vec<_> = methods.iter().map(|run| run["method"].as_str().unwrap()).collect();
    assert_eq!(names, ["shooting", "scp", "scp_polish"]);
    let costs: Vec<f64> = methods.iter().map(|run| run["cost"].as_f64().unwrap()).collect();
    assert!(costs.iter().all(|cost| (cost / costs[0] - 1.0).abs() < 1e-9), "{costs:?}");
    assert_eq!(methods[1]["status"], "converged");
    assert!(methods[2]["terminal"]["attitude_rad"].as_f64().unwrap() < 1e-12);
    let agreement = &document["agreement"];
    assert_eq!(agreement["verdict"], "agree");
    assert!(agreement["duals_before_polish"].as_f64().unwrap() < 1e-6);
    assert!(agreement["from_duals"]["newton_steps"].as_u64().unwrap() <= 2);
    // The comparison has the costs of the plan.
    let plan = folder.slew(&["plan", "spec.toml", "-q", "--format", "json"]).ends(0).json();
    assert_eq!(plan["landing"]["cost_before"], methods[0]["cost"]);
    // Times apart, two runs are equal.
    assert_eq!(times, [".methods"; 3]);
    assert_eq!(comparison(&folder, &[]).0, document);
}

#[test]
fn compare_refuses_what_it_cannot_do_and_ends_as_a_plan_does() {
    let folder = Folder::new();
    folder.slew(&["compare"]).ends(2);
    folder.slew(&["compare", "nowhere.toml"]).ends(8).tells("nowhere.toml");
    folder.slew(&["compare", "spec.toml", "--set", "maneuver.stps=5"]).ends(3).tells("E0020");
    folder.slew(&["compare", "spec.toml", "--format", "csv"]).ends(2);
    folder.slew(&["compare", "spec.toml", "--bound-steps", "4"]).ends(2).tells("--bound");
    for steps in ["1", "61", "many"] {
        folder.slew(&["compare", "spec.toml", "--bound", "--bound-steps", steps]).ends(2);
    }
    let late = ["compare", "spec.toml", "--format", "json", "--set", "solver.time_limit_s=1e-9"];
    let run = folder.slew(&late).ends(6).tells("limit reached");
    assert_eq!(run.json()["exit_code"], 6);
    assert!(folder.slew(&["compare", "--help"]).ends(0).stdout.contains("7 when their costs"));
}

#[test]
fn compare_sets_least_time_fuel_and_effort_side_by_side() {
    let folder = Folder::new();
    let limits = ["--set", "actuators.torque_limit_n_m=0.6"];
    let run = folder.slew(&[&["compare", "spec.toml", "--objectives"][..], &limits].concat()).ends(0);
    run.tells("objectives compared").tells("time").tells("fuel").tells("effort");
    let args = ["compare", "spec.toml", "--objectives", "-q", "--format", "json"];
    let document = folder.slew(&[&args[..], &limits].concat()).ends(0).json();
    assert_eq!((&document["compares"], &document["status"]), (&"objectives".into(), &"solved".into()));
    let row = |row: usize, key: &str| document["objectives"][row][key].as_f64().unwrap();
    assert!(row(0, "duration_s") < row(1, "duration_s"));
    assert!(row(1, "fuel") < row(2, "fuel") && row(2, "effort") < row(1, "effort"));
    // A maneuver of minimum time has other methods before them.
    let time = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/minimum_time_cube_090.toml");
    let run = folder.slew(&["compare", time]).ends(0);
    run.tells("objectives compared")
        .tells("1.5 times the shortest")
        .tells("switching times")
        .tells("interior point");
    fs::write(folder.path("pair.toml"), DUMBBELLS).unwrap();
    folder.slew(&["compare", "spec.toml", "--objectives", "--bound"]).ends(2).tells("--bound");
    folder.slew(&["compare", "pair.toml", "--objectives"]).ends(2).tells("simulation");
}

#[cfg(not(feature = "sdp"))]
#[test]
fn a_bound_that_this_build_cannot_give_says_how_to_build_one_that_can() {
    let folder = Folder::new();
    // The missing feature is reported even before the spec is read.
    let args = ["compare", "nowhere.toml", "--bound", "--format", "json"];
    let run = folder.slew(&args).ends(2).tells("--features sdp").tells("libopenblas-dev");
    assert_eq!(run.json()["status"], "usage_error");
}

#[cfg(feature = "sdp")]
#[test]
fn a_bound_states_its_grid_and_its_gap() {
    let folder = Folder::new();
    let args = ["compare", "spec.toml", "--bound", "--bound-steps", "4"];
    folder.slew(&args).ends(0).tells("4 Lie–Verlet steps, another discrete problem").tells("gap ");
    let (document, times) = comparison(&folder, &["--bound", "--bound-steps", "4"]);
    assert_eq!(times.last().unwrap(), ".bound");
    let bound = &document["bound"];
    assert_eq!((bound["steps"].as_u64(), bound["same_grid"].as_bool()), (Some(4), Some(false)));
    let number = |key: &str| bound[key].as_f64().unwrap();
    assert!(number("lower_bound") <= number("cost"));
    assert!((number("gap") - (1.0 - number("lower_bound") / number("cost"))).abs() < 1e-12);
    // A maneuver that no bound covers is reported, and the comparison does not fail.
    let two = ["actuators.torque_axes_body=[[1,0,0],[0,1,0]]", "maneuver.duration_s=30"];
    let args = ["compare", "spec.toml", "--bound", "--format", "json", "--set", two[0], "--set", two[1]];
    let run = folder.slew(&args).tells("no lower bound");
    assert!(run.json()["bound"]["reason"].as_str().unwrap().contains("two axes"), "{}", run.stdout);
}

/// Two dumbbells for a second.
const DUMBBELLS: &str = r#"format = 1
name = "pair"
[simulation]
duration_s = 16
step_s = 0.02
[gravity]
gravitational_constant_m3_kg_s2 = 1
[[bodies]]
name = "a"
mass_kg = 1
shape = { kind = "dumbbell", length_m = 0.5, sphere_radius_m = 0.1 }
attitude = { rotation_vector_rad = [0.2, 0.5, 0.3] }
angular_velocity_rad_s = [1.2, -0.8, 4]
position_m = [-1.6, 0, 0]
velocity_m_s = [0, -0.73, 0]
[[bodies]]
name = "b"
mass_kg = 2
shape = { kind = "dumbbell", length_m = 1, sphere_radius_m = 0.2 }
attitude = { rotation_vector_rad = [-0.3, 0.1, 0.8] }
angular_velocity_rad_s = [0.4, 1.6, 2]
position_m = [0.8, 0, 0]
velocity_m_s = [0, 0.365, 0]
"#;

#[test]
fn compare_sets_integrators_side_by_side_and_draws_them() {
    let folder = Folder::new();
    fs::write(folder.path("pair.toml"), DUMBBELLS).unwrap();
    // The folder is made.
    let args = ["compare", "pair.toml", "--figures", "figures", "--format", "json"];
    let run = folder.slew(&args).ends(0).tells("pair").tells("at equal mean energy error");
    let document = run.json();
    assert_eq!(document["compares"], "integrators");
    assert_eq!(document["status"], "solved");
    let names = ["lie_verlet", "crouch_grossman_2", "explicit_midpoint", "implicit_midpoint"];
    assert_eq!(document["integrators"], serde_json::json!(names));
    let runs = document["runs"].as_array().unwrap();
    let horizons = document["horizons_s"].as_array().unwrap().len();
    assert_eq!(runs.len(), 4 * 7 * horizons);
    for run in runs {
        assert!(run["energy_error_mean"].as_f64().unwrap() < 1.0 && run["failure"].is_null(), "{run}");
        let evaluations = run["force_evaluations"].as_f64().unwrap() / run["steps"].as_f64().unwrap();
        let expected = match run["method"].as_str().unwrap() {
            "lie_verlet" => 1.0..2.1,
            "implicit_midpoint" => 4.0..50.0,
            _ => 2.0..2.1,
        };
        assert!(expected.contains(&evaluations), "{run}");
    }
    assert!(document["equal_error"].as_array().unwrap().len() >= 4 * horizons);
    let drawn: Vec<_> = fs::read_dir(folder.path("figures")).unwrap().collect();
    assert_eq!(drawn.len(), 10);
    let picture = fs::read_to_string(folder.path("figures/trajectories.svg")).unwrap();
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n") && picture.contains(">b</text>"));
    // Existing figures are kept, and no method is run.
    folder.slew(&args[..4]).ends(8).tells("E0098").tells("--force");
    fs::write(folder.path("figures/work_precision.svg"), "mine").unwrap();
    let few = ["--integrators", "lie_verlet,rkf78", "--step", "0.2,0.1", "--horizon", "2", "--error", "1e-5"];
    let run = folder.slew(&[&args[..], &["--force"], &few].concat()).ends(0);
    let document = run.json();
    assert_eq!(document["runs"].as_array().unwrap().len(), 4);
    assert_eq!(document["equal_error"][1]["method"], "rkf78");
    assert_ne!(fs::read_to_string(folder.path("figures/work_precision.svg")).unwrap(), "mine");
}

#[test]
fn compare_refuses_studies_that_make_no_sense() {
    let folder = Folder::new();
    fs::write(folder.path("pair.toml"), DUMBBELLS).unwrap();
    let compare = |more: &[&str]| folder.slew(&[&["compare", "pair.toml"], more].concat());
    compare(&["--bound"]).ends(2);
    compare(&["--integrators", "euler"]).ends(2).tells("lie_verlet");
    compare(&["--step", "0.3", "--horizon", "4"]).ends(2).tells("does not divide the horizon");
    compare(&["--step", "nan"]).ends(2);
    compare(&["--error", "0"]).ends(2);
    compare(&["--horizon", "2,1"]).ends(2).tells("rising order");
    compare(&["--step", "1e-9"]).ends(2).tells("too many").tells("1e-9 s");
    compare(&["--figures", "pair.toml"]).ends(8).tells("E0095").tells("is a file");
    let twice =
        ["--integrators", "lie_verlet,lie_verlet", "--step", "0.1", "--horizon", "1", "--format", "json"];
    let document = compare(&twice).ends(0).tells("mean and largest |E").json();
    assert_eq!(document["integrators"], serde_json::json!(["lie_verlet"]));
    // An option of simulations is refused before any file is read.
    fs::create_dir(folder.path("drawn")).unwrap();
    fs::write(folder.path("drawn/trajectories.svg"), "mine").unwrap();
    let args = ["compare", "spec.toml", "--figures", "drawn"];
    folder.slew(&args).ends(2).tells("this spec is a maneuver");
    compare(&["--force"]).ends(2);
    folder.slew(&["compare", "spec.toml", "--step", "0.1"]).ends(2).tells("this spec is a maneuver");
}
