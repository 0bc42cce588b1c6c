//! The real binary in a folder of its own: what it prints, writes and returns.

use super::binary::{Folder, Run, SPEC};
use serde_json::Value;
use slewkit::files::export::PlanFile;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

#[test]
fn plan_tells_people_on_stderr_and_writes_the_file() {
    let folder = Folder::new();
    let run = folder.slew(&["plan", "spec.toml", "-o", "plan.json"]).ends(0);
    assert_eq!(run.stdout, "");
    let run = run.tells("test slew").tells("solved and verified").tells("wrote       plan.json");
    for label in ["method", "cost", "iterations", "terminal", "optimality", "limits", "verified"] {
        assert!(run.stderr.contains(&format!("\n  {label} ")), "{label}: {}", run.stderr);
    }
    assert!(!run.stderr.contains('\u{1b}'), "no colour and no progress off a terminal");
    let plan = PlanFile::read(fs::File::open(folder.path("plan.json")).unwrap()).unwrap();
    assert_eq!((plan.status.name(), plan.exit_code, plan.steps), ("solved", 0, 100));
    assert_eq!(plan.trajectory.0.time.len(), 101);
    assert!(plan.terminal.largest() <= 1e-12);
    assert_eq!(folder.names(), ["plan.json", "spec.toml"]);
}

#[test]
fn quiet_plan_with_format_prints_data_alone() {
    let folder = Folder::new();
    let json = folder.slew(&["plan", "spec.toml", "-q", "--format", "json"]).ends(0).silent();
    assert_eq!(json.json()["status"], "solved");
    let rows = folder.slew(&["plan", "spec.toml", "-q", "--format", "jsonl"]).ends(0).silent();
    assert_eq!(rows.stdout.lines().count(), 101);
    let last: Value = serde_json::from_str(rows.stdout.lines().last().unwrap()).unwrap();
    assert_eq!(last["time_s"], 10.0);
    let table = folder.slew(&["plan", "spec.toml", "-q", "--format", "csv"]).ends(0).silent();
    assert_eq!(table.stdout.lines().count(), 102);
    assert!(table.stdout.starts_with("time_s,quaternion_w,"));
}

#[test]
fn ending_of_the_output_chooses_the_format_and_format_overrules_it() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "a.csv"]).ends(0).silent();
    assert!(folder.read("a.csv").starts_with("time_s,"));
    folder.slew(&["plan", "spec.toml", "-q", "-o", "a.jsonl"]).ends(0);
    assert!(folder.read("a.jsonl").starts_with("{\"time_s\":0.0,"));
    folder.slew(&["plan", "spec.toml", "-q", "-o", "b.csv", "--format", "json"]).ends(0);
    assert_eq!(folder.json("b.csv")["exit_code"], 0);
    let stdout = folder.slew(&["plan", "spec.toml", "-q", "-o", "-"]).ends(0);
    assert_eq!(stdout.json()["exit_code"], 0);
}

#[test]
fn two_runs_differ_in_the_solve_time_alone() {
    let folder = Folder::new();
    let document = |run: Run| {
        let lines = run.stdout.lines().map(str::to_string);
        lines.filter(|line| !line.contains("\"solve_time_s\"")).collect::<Vec<_>>()
    };
    let args = ["plan", "spec.toml", "-q", "--format", "json"];
    let first = folder.slew(&args).ends(0);
    let lines = first.stdout.lines().count();
    let (first, second) = (document(first), document(folder.slew(&args)));
    assert_eq!(first.len(), lines - 1);
    assert_eq!(first, second);
}

#[test]
fn overrides_change_the_plan_and_wrong_ones_are_named() {
    let folder = Folder::new();
    let set = |text: &str| folder.slew(&["plan", "spec.toml", "-q", "--format", "json", "--set", text]);
    assert_eq!(set("maneuver.steps=50").ends(0).json()["steps"], 50);
    assert_eq!(set("solver.scheme=lie_euler").ends(0).json()["scheme"], "lie_euler");
    set("maneuver.stps=50").ends(3).tells("E0020").tells("did you mean `steps`?");
    set("maneuver.steps").ends(2).tells("--set");
}

#[test]
fn a_plan_is_the_best_guess_for_itself() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    let args = ["plan", "spec.toml", "-q", "--format", "json", "--guess", "plan.json"];
    let again = folder.slew(&args).ends(0).json();
    let first = folder.json("plan.json");
    let rung = again["ladder"].as_array().unwrap().iter().find(|rung| rung["rung"] == "guess").unwrap();
    assert_eq!(rung["outcome"], "converged");
    assert!(rung["iterations"].as_u64().unwrap() <= 1, "{rung}");
    let cost = |plan: &Value| plan["cost"].as_f64().unwrap();
    assert!((cost(&again) - cost(&first)).abs() <= 1e-12 * cost(&first));
}

#[test]
fn a_guess_that_is_none_is_refused() {
    let folder = Folder::new();
    fs::write(folder.path("three.json"), "{\"format\": 1, \"costates_0\": [1, 2, 3]}").unwrap();
    let guess = |name: &str| folder.slew(&["plan", "spec.toml", "--guess", name]);
    guess("spec.toml").ends(8).tells("E0102").tells("not a plan file");
    guess("three.json").ends(8).tells("E0103").tells("3 costates, this maneuver needs 6");
    guess("missing.json").ends(8).tells("E0090").tells("missing.json");
}

#[test]
fn every_status_has_its_exit_code_and_its_name() {
    let folder = Folder::new();
    let plan = |set: &[&str]| {
        let mut args = vec!["plan", "spec.toml", "-q", "--format", "json"];
        set.iter().for_each(|text| args.extend(["--set", text]));
        folder.slew(&args)
    };
    let status = |run: &Run| {
        let json = run.json();
        assert_eq!(json["exit_code"], run.code);
        json["status"].as_str().unwrap().to_string()
    };
    assert_eq!(status(&plan(&[]).ends(0)), "solved");
    assert_eq!(status(&plan(&["body.inertia_kg_m2=[1, 2, 9]"]).ends(3)), "spec_invalid");
    assert_eq!(status(&plan(&["start.angular_velocity_deg_s=[0,0,900]"]).ends(3)), "spec_invalid");
    // One torque axis on a sphere never leaves that axis.
    let stuck = ["body.inertia_kg_m2=[1, 1, 1]", "actuators.torque_axes_body=[[0, 0, 1]]"];
    let stuck = plan(&stuck);
    assert!(matches!(stuck.code, 4 | 5), "{}", stuck.code);
    assert!(["infeasible", "not_converged"].contains(&status(&stuck).as_str()));
    assert_eq!(status(&plan(&["solver.time_limit_s=1e-9"]).ends(6)), "limit_reached");
    let strict = plan(&["solver.continuous_tolerance_deg=1e-9"]).ends(7);
    assert_eq!(status(&strict), "verification_failed");
    assert_eq!(
        folder.slew(&["plan", "nowhere.toml", "--format", "json"]).ends(8).json()["status"],
        "file_error"
    );
    folder.slew(&["plan", "spec.toml", "--no-such-flag"]).ends(2);
    folder.slew(&["plan"]).ends(2);
    folder.slew(&[]).ends(2);
}

#[test]
fn an_unsolved_plan_tells_how_it_stopped_and_what_to_try() {
    let folder = Folder::new();
    // By itself the shooting: `auto` has another road left.
    let keys = ["solver.max_iterations=1", "solver.method=\"shooting\""];
    let one = ["plan", "spec.toml", "-o", "best.json", "--set", keys[0], "--set", keys[1]];
    let run = folder.slew(&one).ends(5).tells("not converged").tells("the iteration limit was reached");
    let run = run.tells("\n  ladder ").tells("newton").tells("\n  try ").tells("solver.max_iterations");
    assert!(run.stderr.lines().count() < 60, "a crowd of runs shares a line: {}", run.stderr);
    let best = folder.json("best.json");
    assert_eq!(best["status"], "not_converged");
    assert_eq!(best["verified"], Value::Null);
    PlanFile::read(folder.read("best.json").as_bytes()).unwrap();
}

#[test]
fn all_errors_of_a_spec_are_reported_at_once() {
    let folder = Folder::new();
    folder.slew(&["check", "spec.toml"]).ends(0).tells("valid");
    let wrong = SPEC.replace("[1, 2, 2.5]", "[1, 2, 9]").replace("duration_s = 10", "duration_s = -1");
    fs::write(folder.path("wrong.toml"), wrong).unwrap();
    let run =
        folder.slew(&["check", "wrong.toml"]).ends(3).tells("wrong.toml:5:").tells("E0042").tells("E0032");
    assert_eq!(run.stdout, "");
    let json = folder.slew(&["check", "wrong.toml", "--format", "json"]).ends(3).json();
    let codes: Vec<_> = json["diagnostics"].as_array().unwrap().iter().map(|d| d["code"].clone()).collect();
    assert_eq!(codes, ["E0042", "E0032"]);
    let json = folder.slew(&["check", "spec.toml", "-q", "--format", "json"]).ends(0).silent().json();
    assert_eq!((json["status"].as_str(), json["steps"].as_u64()), (Some("valid"), Some(100)));
}

#[test]
fn check_lists_limits_and_constraints() {
    let folder = Folder::new();
    let rate = "constraint=[{ kind = \"rate_limit\", name = \"slow \\u001b[31m\", angular_velocity_limit_deg_s = 9 }]";
    let wheels = "actuators.wheel=[{ axis_body = [1, 0, 0], momentum_limit_n_m_s = 2 }, { axis_body = [0, 1, 0] }, { axis_body = [0, 0, 1] }]";
    let check = ["check", "spec.toml", "--format", "json", "--set", rate, "--set"];
    let args = [&check[..], &["actuators.torque_limit_n_m=1"]].concat();
    let run =
        folder.slew(&args).ends(0).tells("limits      torque limit\n").tells("constraints slow \\u{1b}[31m");
    assert_eq!(run.json()["limits"], serde_json::json!(["torque limit"]));
    let run = folder.slew(&[&check[..], &[wheels]].concat()).ends(0);
    let run = run.tells("inputs      3, each the torque of a reaction wheel").tells("wheel momentum limit");
    assert_eq!(
        (run.json()["wheels"].as_u64(), run.json()["constraints"][0].as_str()),
        (Some(3), Some("slow \u{1b}[31m"))
    );
    let cone = "constraint=[{ kind = \"keep_out\", boresight_body = [0, 0, 1], direction_inertial = { vector = [0, 0, 1] }, half_angle_deg = 5 }]";
    folder
        .slew(&["plan", "spec.toml", "--set", cone])
        .ends(3)
        .tells("E0071")
        .tells("the boresight is 0 deg from the axis");
}

#[test]
fn a_plan_under_constraints_tells_margins_and_is_verified_from_its_file() {
    let folder = Folder::new();
    let cone = "constraint=[{ kind = \"keep_out\", name = \"Sun\", boresight_body = [1, 0, 0], direction_inertial = { ra_deg = 45, dec_deg = 2 }, half_angle_deg = 20 }]";
    let limit = "actuators.torque_norm_limit_n_m=0.17";
    let set = ["--set", cone, "--set", limit, "--set", "maneuver.steps=50"];
    let plan = |more: &[&str]| folder.slew(&[&["plan", "spec.toml"], &set[..], more].concat());
    let run = plan(&["-o", "plan.json"]).ends(0).tells("solved and verified").tells("method      SCP: ");
    let run = run
        .tells("torque norm limit  active at ")
        .tells("Sun                active at ")
        .tells("margin 0 deg at ");
    let run = run.tells("between nodes");
    assert!(!run.stderr.contains("violated"), "{}", run.stderr);
    let json = folder.json("plan.json");
    assert_eq!(json["method"], "scp");
    let names = |list: &Value| {
        let names = list.as_array().unwrap().iter();
        names.map(|entry| entry["name"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    assert_eq!(names(&json["active"]), ["torque norm limit", "Sun"]);
    assert_eq!(names(&json["verified"]["margins"]), ["torque norm limit", "Sun"]);
    assert!(json["verified"]["margins"][1]["scaled"].as_f64().unwrap() > -1e-9);
    assert_eq!(json["problem"]["constraints"][0]["kind"], "keep_out");
    assert_eq!(json["problem"]["torque"]["norm_limit"], 0.17);

    let verify = |set: &[&str]| folder.slew(&[&["verify", "plan.json", "--spec", "spec.toml"], set].concat());
    // Which limits act the witness sees by itself, and the plan's own word on it counts for nothing.
    let run =
        verify(&set).ends(0).tells("verified").tells("limit  active, ").tells("Sun                active, ");
    let run = run.tells("; the continuous motion is ");
    assert!(!run.stderr.contains("differs"), "{}", run.stderr);
    // The plan of a wider cone would have to pass further out, and without limits it was not asked for.
    let wider = ["--set", cone, "--set", limit, "--set", "constraint.0.half_angle_deg=21"];
    verify(&wider).ends(7).tells("constraints.0.half_angle_rad").tells("violated, margin -1.00 deg");
    verify(&[]).ends(0).tells("differs     constraints").tells("differs     torque.norm_limit");

    // Two runs differ in the solve time alone.
    plan(&["-q", "-o", "again.json"]).ends(0);
    let (first, second) = (folder.read("plan.json"), folder.read("again.json"));
    let differ: Vec<_> = first.lines().zip(second.lines()).filter(|(a, b)| a != b).collect();
    assert!(differ.len() == 1 && differ[0].0.contains("solve_time_s"), "{differ:?}");

    let shooting = [&set[..], &["--set", "solver.method=shooting"]].concat();
    folder.slew(&[&["plan", "spec.toml"], &shooting[..]].concat()).ends(3).tells("E0066");
}

#[test]
fn a_solved_plan_that_is_coarse_or_idle_says_so() {
    let folder = Folder::new();
    let plan = |set: &[&str]| folder.slew(&[&["plan", "spec.toml"], set].concat()).ends(0);
    assert!(!plan(&["--set", "maneuver.steps=50"]).stderr.contains("\n  try "));
    plan(&["--set", "maneuver.steps=3"])
        .tells(" deg)")
        .tells("\n  try         slew plan spec.toml --set maneuver.steps=6   # more steps");
    // Where no limit acts the shooting's plan stands, but its rivals may break limits that nobody held them to.
    assert!(plan(&[]).stderr.contains("\n  rival "));
    let wide = "constraint=[{ kind = \"keep_in\", boresight_body = [1, 0, 0], direction_inertial = { ra_deg = 45, dec_deg = 2 }, half_angle_deg = 80 }]";
    let run = plan(&["--set", wide]).tells("6 costates, no limit active");
    assert!(!run.stderr.contains("\n  rival "), "{}", run.stderr);
    let data = folder.slew(&["plan", "spec.toml", "-o", "plan.txt", "--format", "text"]);
    data.ends(2).tells("--format text");
    assert!(!folder.path("plan.txt").exists());
}

#[test]
fn a_plan_that_is_not_found_names_what_could_do() {
    let folder = Folder::new();
    let plan = |limit: &str| {
        let set = ["--set", limit, "-q", "--format", "json"];
        folder.slew(&[&["plan", "spec.toml"], &set[..]].concat())
    };
    let proved = plan("actuators.torque_norm_limit_n_m=0.05").ends(4).json();
    assert!(proved["shortest_duration_s"].as_f64().unwrap() > 10.0);
    assert_eq!(proved["optimality"]["stationarity"], Value::Null);
    let run = folder.slew(&["plan", "spec.toml", "--set", "actuators.torque_norm_limit_n_m=0.05"]).ends(4);
    let run = run.tells("   # more time; no plan takes less than ");
    assert!(!run.stderr.contains("method"), "{}", run.stderr);
    // Not enough torque, and not provably so.
    let limit = "actuators.torque_norm_limit_n_m=0.13";
    let missed = plan(limit).ends(5).json();
    let longer = missed["longer_s"].as_f64().unwrap();
    assert!(longer > 10.0 && longer < 20.0, "{longer}");
    let advice =
        format!("slew plan spec.toml --set {limit} --set maneuver.duration_s={longer}   # more time\n");
    folder.slew(&["plan", "spec.toml", "--set", limit]).ends(5).tells(&advice);
    let longer = format!("maneuver.duration_s={longer}");
    folder.slew(&["plan", "spec.toml", "--set", limit, "--set", &longer]).ends(0);
}

#[test]
fn wheels_show_in_summary_and_tables() {
    let folder = Folder::new();
    let wheels = "actuators.wheel=[{ axis_body = [1, 0, 0], momentum_limit_n_m_s = 5, momentum_n_m_s = 0.5 }, { axis_body = [0, 1, 0] }, { axis_body = [0, 0, 1] }]";
    let plan = |more: &[&str]| folder.slew(&[&["plan", "spec.toml", "--set", wheels], more].concat());
    let run = plan(&["-o", "plan.json"]).ends(0).tells("peak wheel momentum ");
    run.tells("wheel momentum limit  margin ");
    let json = folder.json("plan.json");
    assert_eq!(json["trajectory"]["wheel_momentum_n_m_s"][0], serde_json::json!([0.5, 0.0, 0.0]));
    assert_eq!(json["trajectory"]["wheel_momentum_n_m_s"].as_array().unwrap().len(), 101);
    let table = plan(&["-q", "--format", "csv"]).ends(0);
    assert!(table.stdout.lines().next().unwrap().contains("wheel_momentum_3_n_m_s"));
    folder.slew(&["verify", "plan.json", "--spec", "spec.toml", "--set", wheels]).ends(0);
    let run = folder.slew(&["verify", "plan.json", "--spec", "spec.toml"]);
    run.ends(7).tells("E0103").tells("wheel_momentum_n_m_s");
}

#[test]
fn warnings_are_told_and_do_not_stop_the_plan() {
    let folder = Folder::new();
    // 1.57 degrees: radians, perhaps.
    let set = ["--set", "end.attitude={axis = [0, 0, 1], angle_deg = 1.5707963267948966}"];
    let run = |args: &[&str]| folder.slew(&[args, &set].concat());
    run(&["plan", "spec.toml"]).ends(0).tells("warning[W0058]").tells("solved and verified");
    run(&["plan", "spec.toml", "--quiet"]).ends(0).silent();
    let json = run(&["check", "spec.toml", "--format", "json"]).ends(0).tells("valid, 1 warning").json();
    assert_eq!(json["diagnostics"][0]["code"], "W0058");
}

#[test]
fn spec_comes_from_stdin_in_either_notation() {
    let folder = Folder::new();
    let toml = folder.slew_with_stdin(&["plan", "-", "-q", "--format", "json"], SPEC).ends(0).json();
    let json = r#"{"format": 1, "name": "test slew", "body": {"inertia_kg_m2": [1, 2, 2.5]},
        "start": {"attitude": {"axis": [0, 0, 1], "angle_deg": 0}},
        "end": {"attitude": {"euler_zyx_deg": [80, -25, 40]}},
        "maneuver": {"duration_s": 10, "steps": 100}}"#;
    let args = ["plan", "-", "-q", "--format", "json", "--input", "json"];
    let json = folder.slew_with_stdin(&args, json).ends(0).json();
    assert_eq!(toml["trajectory"], json["trajectory"]);
    folder.slew_with_stdin(&["check", "-"], "").ends(3).tells("E0001").tells("stdin:1:1");
}

#[test]
fn outputs_are_never_replaced_unasked() {
    let folder = Folder::new();
    fs::write(folder.path("plan.json"), "mine").unwrap();
    // Refused before the spec is even read.
    folder.slew(&["plan", "nowhere.toml", "-o", "plan.json"]).ends(8).tells("E0098").tells("--force");
    assert_eq!(folder.read("plan.json"), "mine");
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--force"]).ends(0).silent();
    assert_eq!(folder.json("plan.json")["status"], "solved");
    folder.slew(&["plan", "spec.toml", "-o", "spec.toml", "--force"]).ends(8).tells("E0100");
    folder.slew(&["simulate", "spec.toml", "-o", "./spec.toml", "--force"]).ends(8).tells("E0100");
    assert_eq!(folder.read("spec.toml"), SPEC);
    folder.slew(&["plan", "spec.toml", "-o", "missing/plan.json"]).ends(8).tells("E0095");
    folder.slew(&["plan", "spec.toml", "-o", "CON"]).ends(8).tells("E0099");
    folder.slew(&["init", "-o", "plan.json"]).ends(8).tells("E0098");
    assert_eq!(folder.names(), ["plan.json", "spec.toml"]);
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let folder = Folder::new();
    let quick: [&[&str]; 5] = [
        &["plan", "spec.toml", "--format", "jsonl", "--set", "maneuver.steps=5000"],
        &["simulate", "spec.toml", "--format", "csv", "--steps", "5000"],
        &["schema"],
        &["completions", "bash"],
        &["convert", "axis = [0, 0, 1], angle_deg = 90"],
    ];
    for args in quick {
        let mut child = folder.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::with_capacity(16, child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        // The pipe is closed now, with most of the data unread.
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{args:?}: {stderr}");
        assert!(!line.is_empty() && !stderr.contains("panic") && !stderr.contains("error"), "{stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let folder = Folder::new();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = folder.command(&["schema"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    Run::of(output, &["schema"]).ends(8).tells("E0097");
}

#[test]
fn verify_judges_a_plan_file_by_its_spec() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json", "--set", "maneuver.steps=80"]).ends(0);
    let verify = |plan: &str, more: &[&str]| {
        let mut args = vec!["verify", plan, "--spec", "spec.toml"];
        args.extend(more);
        folder.slew(&args)
    };
    // The grid is the plan's own.
    let run = verify("plan.json", &[]).ends(0).tells("verified");
    assert!(!run.stderr.contains("differs"), "{}", run.stderr);
    let json = verify("plan.json", &["-q", "--format", "json"]).ends(0).silent().json();
    assert_eq!((json["status"].as_str(), json["steps"].as_u64()), (Some("solved"), Some(80)));
    // The witnesses find what the planner found.
    let plan = folder.json("plan.json");
    let mut verified = json["verified"].clone();
    let cost = verified["checks"].as_array_mut().unwrap().pop().unwrap();
    assert_eq!((&verified, cost["name"].as_str()), (&plan["verified"], Some("recorded cost")));
    let mut cheap = plan.clone();
    cheap["cost"] = (plan["cost"].as_f64().unwrap() * (1.0 - 1e-8)).into();
    fs::write(folder.path("cheap.json"), cheap.to_string()).unwrap();
    verify("cheap.json", &[]).ends(7).tells("recorded cost");

    let piped = folder.slew_with_stdin(&["verify", "-", "--spec", "spec.toml"], &folder.read("plan.json"));
    piped.ends(0).tells("verified");
    folder.slew(&["verify", "-", "--spec", "-"]).ends(2).tells("stdin");

    let other = ["--set", "end.attitude.euler_zyx_deg=[81, -25, 40]", "--format", "json"];
    let run = verify("plan.json", &other).ends(7).tells("verification failed").tells("end.matrix");
    assert_eq!(run.json()["status"], "verification_failed");
    assert_eq!(run.json()["differences"][0]["key"], "end.matrix");

    let mut forged = plan.clone();
    forged["trajectory"]["input"][40][0] = 0.123.into();
    fs::write(folder.path("forged.json"), forged.to_string()).unwrap();
    verify("forged.json", &[]).ends(7).tells("failed");
    let mut short = plan.clone();
    short["trajectory"]["torque_n_m"].as_array_mut().unwrap().pop();
    fs::write(folder.path("short.json"), short.to_string()).unwrap();
    verify("short.json", &["--format", "json"]).ends(7).tells("E0103").tells("torque_n_m");
    fs::write(folder.path("torn.json"), &plan.to_string()[..5000]).unwrap();
    verify("torn.json", &[]).ends(8).tells("E0102");
    verify("missing.json", &[]).ends(8).tells("E0090");
}

#[test]
fn simulate_follows_a_spinning_body_for_a_turn() {
    let folder = Folder::new();
    // 36 deg/s about a principal axis: one turn in ten seconds.
    let spin = ["--set", "start.angular_velocity_deg_s=[0, 0, 36]"];
    let simulate = |more: &[&str]| {
        let mut args = vec!["simulate", "spec.toml"];
        args.extend(spin);
        args.extend(more);
        folder.slew(&args)
    };
    let json = simulate(&["--format", "json", "--integrator", "verner98"]).ends(0).tells("energy").json();
    let q: [f64; 4] = serde_json::from_value(json["trajectory"]["quaternion_wxyz"][100].clone()).unwrap();
    assert!((q[0] + 1.0).abs() < 1e-13 && q[3].abs() < 1e-12, "a full turn changes the sign: {q:?}");
    let half: [f64; 4] = serde_json::from_value(json["trajectory"]["quaternion_wxyz"][50].clone()).unwrap();
    assert!((half[3] - 1.0).abs() < 1e-13, "{half:?}");

    let table = simulate(&["-q", "--format", "csv", "--steps", "1000", "--stride", "250"]).ends(0).silent();
    let times: Vec<&str> = table.stdout.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(times, ["0.0", "2.5", "5.0", "7.5", "10.0"]);
    let columns = table.stdout.lines().map(|line| line.split(',').count()).collect::<Vec<_>>();
    assert_eq!(columns, [13; 6]);

    let pushed = simulate(&["-q", "--format", "jsonl", "--inputs", "0,0,0.1"]).ends(0);
    let last: Value = serde_json::from_str(pushed.stdout.lines().last().unwrap()).unwrap();
    let momentum = last["angular_momentum_n_m_s"][2].as_f64().unwrap();
    assert!((momentum - (2.5 * 36_f64.to_radians() + 1.0)).abs() < 1e-12, "{momentum}");
    simulate(&["--inputs", "0,0"]).ends(2).tells("--inputs");
    simulate(&["--inputs", "0,0,nan"]).ends(2).tells("finite");
    simulate(&["--steps", "0"]).ends(2);
    simulate(&["--steps", "1000000000", "--format", "json"]).ends(2).tells("--stride");
    simulate(&["--steps", "2", "-o", "none.csv"]).ends(5).tells("raise `--steps`");
    assert_eq!(folder.names(), ["spec.toml"]);
}

#[test]
fn convert_gives_every_notation_and_each_reads_back() {
    let folder = Folder::new();
    let attitudes = [
        "euler_zyx_deg = [10, 20, 150]",
        "quaternion_xyzw = [0.5, -0.5, 0.5, 0.5]",
        "{ axis = [1, 2, 3], angle_deg = -170 }",
        "attitude = { euler_xyz_deg = [0, 90, 30] }",
        "axis = [0, 0, 1], angle_deg = 180",
        "matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]",
        "rotation_vector_rad = [1e-9, 0, 0]",
        "euler_zxz_deg = [30, 180, 40]",
    ];
    let wxyz = |text: &str| {
        let run = folder.slew(&["convert", text, "--format", "json", "-q"]).ends(0);
        serde_json::from_value::<[f64; 4]>(run.json()["quaternion_wxyz"].clone()).unwrap()
    };
    for text in attitudes {
        let run = folder.slew(&["convert", text]).ends(0).silent();
        let wanted = wxyz(text);
        let mut lines: Vec<&str> = run.stdout.lines().collect();
        assert_eq!(lines.len(), 18, "{}", run.stdout);
        let part = |name: &str, lines: &mut Vec<&str>| {
            let at = lines.iter().position(|line| line.starts_with(name)).unwrap();
            lines.remove(at).to_string()
        };
        let (axis, angle) = (part("axis", &mut lines), part("angle_deg", &mut lines));
        let pair = format!("{axis}, {angle}");
        lines.push(&pair);
        for line in lines {
            let found = wxyz(line);
            let dot: f64 = wanted.iter().zip(found).map(|(a, b)| a * b).sum();
            let apart =
                wanted.iter().zip(found).map(|(a, b)| (a * dot.signum() - b).abs()).fold(0.0, f64::max);
            // Sixteen digits of an angle near 180 deg are 3e-16 of a turn; two conversions.
            assert!(apart < 4e-15, "{text} as {line}: {wanted:?}, {found:?}");
        }
    }
}

#[test]
fn convert_explains_what_is_wrong_with_an_attitude() {
    let folder = Folder::new();
    folder.slew(&["convert", "quaternion = [1, 0, 0, 0]"]).ends(3).tells("attitude:1:").tells("E0052");
    folder.slew(&["convert", "euler_zyx_deg = [10, 20]"]).ends(3).tells("E0026");
    folder.slew_with_stdin(&["convert", "-"], "axis = [0, 0, 1], angle_deg = 90\n").ends(0);
}

#[test]
fn texts_to_start_from_work() {
    let folder = Folder::new();
    folder.slew(&["init", "-o", "first.toml"]).ends(0).tells("first.toml");
    folder.slew(&["plan", "first.toml", "-q"]).ends(0).silent();
    assert_eq!(folder.slew(&["init"]).ends(0).stdout, folder.read("first.toml"));
    let schema = folder.slew(&["schema"]).ends(0).json();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(folder.slew(&["completions", shell]).ends(0).stdout.contains("simulate"), "{shell}");
    }
    folder.slew(&["completions", "tcsh"]).ends(2);
    assert!(folder.slew(&["--help"]).ends(0).stdout.contains("Exit codes"));
    assert!(folder.slew(&["--version"]).ends(0).stdout.starts_with("slew 0."));
}

/// A comparison as a document, without the lines that hold a time.
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
    // The costs of the comparison are those of a plan.
    let plan = folder.slew(&["plan", "spec.toml", "-q", "--format", "json"]).ends(0).json();
    assert_eq!(plan["cost"], methods[0]["cost"]);
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

#[cfg(not(feature = "sdp"))]
#[test]
fn a_bound_that_this_build_cannot_give_says_how_to_build_one_that_can() {
    let folder = Folder::new();
    // Before the spec is even read.
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
    // What no bound covers is told, and is no failure of the comparison.
    let two = ["actuators.torque_axes_body=[[1,0,0],[0,1,0]]", "maneuver.duration_s=30"];
    let args = ["compare", "spec.toml", "--bound", "--format", "json", "--set", two[0], "--set", two[1]];
    let run = folder.slew(&args).tells("no lower bound");
    assert!(run.json()["bound"]["reason"].as_str().unwrap().contains("two axes"), "{}", run.stdout);
}

#[test]
fn what_the_user_wrote_does_not_steer_the_terminal() {
    let folder = Folder::new();
    let spec = SPEC.replace("test slew", "\\u001B]0;owned\\u0007");
    fs::write(folder.path("esc.toml"), spec).unwrap();
    let run = folder.slew(&["plan", "esc.toml", "-o", "p.json"]);
    assert!(!run.stderr.contains('\u{1b}') && !run.stderr.contains('\u{7}'), "{:?}", run.stderr);
    assert!(run.stderr.contains("owned"), "{}", run.stderr);
    let run = folder.slew(&["plan", "spec.toml", "-o", "\u{1b}[31m.json"]).ends(8).tells("E0099");
    assert!(!run.stderr.contains('\u{1b}'), "{:?}", run.stderr);
    let run = folder.slew(&["verify", "\u{1b}[31m.json", "--spec", "spec.toml"]).ends(8).tells("E0090");
    assert!(!run.stderr.contains('\u{1b}'), "{:?}", run.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_plan_keeps_its_best_result() {
    let folder = Folder::new();
    // Far too fast for the step: minutes of ladder.
    let args = [
        "plan",
        "spec.toml",
        "-o",
        "best.json",
        "--set",
        "maneuver.steps=100000",
        "--set",
        "end.angular_velocity_deg_s=[0, 0, 90000]",
    ];
    let child = folder.command(&args).stderr(Stdio::piped()).spawn().unwrap();
    while !super::binary::catches_interrupt(child.id()) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let run = Run::of(child.wait_with_output().unwrap(), &args).ends(130).tells("interrupted");
    assert!(run.stderr.contains("wrote"), "{}", run.stderr);
    let best = PlanFile::read(folder.read("best.json").as_bytes()).unwrap();
    assert_eq!((best.status.name(), best.exit_code), ("interrupted", 130));
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
    assert_eq!(drawn.len(), 9);
    let picture = fs::read_to_string(folder.path("figures/trajectories.svg")).unwrap();
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n") && picture.contains(">b</text>"));
    // Figures that exist stay, and nothing is run.
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
    // What is for simulations is told before any file is looked at.
    fs::create_dir(folder.path("drawn")).unwrap();
    fs::write(folder.path("drawn/trajectories.svg"), "mine").unwrap();
    let args = ["compare", "spec.toml", "--figures", "drawn"];
    folder.slew(&args).ends(2).tells("this one is of a maneuver");
    compare(&["--force"]).ends(2);
    folder.slew(&["compare", "spec.toml", "--step", "0.1"]).ends(2).tells("this one is of a maneuver");
}
