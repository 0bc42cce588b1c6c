//! `slew check`, `verify`, `init` and `schema`: reports about a file without planning.

use super::binary::{Folder, Run, SPEC};
use std::fs;

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
    let wheels = "actuators.wheel=[{ axis_body = [1, 0, 0], momentum_limit_n_m_s = 2 }, { axis_body = [0, 1, \
        0] }, { axis_body = [0, 0, 1] }]";
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
    let cone = "constraint=[{ kind = \"keep_out\", boresight_body = [0, 0, 1], direction_inertial = { vector \
        = [0, 0, 1] }, half_angle_deg = 5 }]";
    folder
        .slew(&["plan", "spec.toml", "--set", cone])
        .ends(3)
        .tells("E0071")
        .tells("the boresight is 0 deg from the axis");
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
    // The witnesses compute the values that the planner found.
    let plan = folder.json("plan.json");
    let mut verified = json["verified"].clone();
    let checks = verified["checks"].as_array_mut().unwrap();
    let recorded = checks.split_off(checks.len() - 8);
    assert_eq!(verified, plan["verified"]);
    let told = [
        ("cost", "recorded cost"),
        ("duration_s", "recorded duration"),
        ("step_s", "recorded step"),
        ("turned_deg", "recorded turn"),
        ("tolerance", "recorded tolerance"),
    ];
    for (check, (key, name)) in recorded.iter().zip(told) {
        assert_eq!((check["name"].as_str(), check["passed"].as_bool()), (Some(name), Some(true)));
        let mut false_figure = plan.clone();
        false_figure[key] = (plan[key].as_f64().unwrap() * (1.0 - 1e-8)).into();
        fs::write(folder.path("false.json"), false_figure.to_string()).unwrap();
        verify("false.json", &[]).ends(7).tells(name);
    }

    // Words that contradict one another or the computed values.
    let status = "recorded status";
    for (key, word, name) in [
        ("status", "verification_failed", status),
        ("outcome", "stalled", status),
        ("second_order", "saddle", status),
        ("sense", "long", "recorded sense"),
    ] {
        let mut false_word = plan.clone();
        assert_ne!(false_word[key], word);
        false_word[key] = word.into();
        fs::write(folder.path("false.json"), false_word.to_string()).unwrap();
        verify("false.json", &[]).ends(7).tells(name);
    }
    let mut rejected = plan.clone();
    (rejected["status"], rejected["exit_code"]) = ("verification_failed".into(), 7.into());
    rejected["verified"]["checks"][0]["passed"] = false.into();
    let mut nearer = plan.clone();
    nearer["verified"]["continuous_attitude_rad"] = 1e-12.into();
    let mut exact = plan.clone();
    exact["terminal"]["attitude_rad"] = 1e-6.into();
    for false_finding in [rejected, nearer, exact] {
        fs::write(folder.path("false.json"), false_finding.to_string()).unwrap();
        verify("false.json", &[]).ends(7).tells("recorded findings");
    }
    let mut misses = plan.clone();
    misses["accuracy"]["continuous_attitude_deg"] = 1e-12.into();
    fs::write(folder.path("false.json"), misses.to_string()).unwrap();
    let run = verify("false.json", &["--format", "json"]).ends(7).tells("accuracy: ");
    assert_eq!(run.json()["recorded"][0]["key"], "accuracy");
    assert!(run.json()["not_judged"][0].as_str().unwrap().contains("optimal"));

    let piped = folder.slew_with_stdin(&["verify", "-", "--spec", "spec.toml"], &folder.read("plan.json"));
    piped.ends(0).tells("verified");
    folder.slew(&["verify", "-", "--spec", "-"]).ends(2).tells("stdin");

    let other = ["--set", "end.attitude.euler_zyx_deg=[81, -25, 40]", "--format", "json"];
    let run = verify("plan.json", &other).ends(7).tells("verification failed").tells("end.attitude.matrix");
    assert_eq!(run.json()["status"], "verification_failed");
    assert_eq!(run.json()["differences"][0]["key"], "end.attitude.matrix");

    // If no spec is given, the spec that the plan holds is used, with an equal result.
    let held = folder.slew(&["verify", "plan.json", "-q", "--format", "json"]).ends(0).silent().json();
    assert_eq!(held, json);
    let mut older = plan.clone();
    older["format"] = 1.into();
    older.as_object_mut().unwrap().remove("spec");
    fs::write(folder.path("older.json"), older.to_string()).unwrap();
    verify("older.json", &[]).ends(8).tells("E0102").tells("format 1").tells("plan again");
    folder.slew(&["verify", "older.json"]).ends(8).tells("E0102").tells("plan again");
    older["format"] = 2.into();
    fs::write(folder.path("bare.json"), older.to_string()).unwrap();
    folder.slew(&["verify", "bare.json"]).ends(8).tells("E0102").tells("--spec SPEC");
    verify("bare.json", &[]).ends(0);
    let mut wrong = plan.clone();
    wrong["spec"]["maneuver"]["duration_s"] = (-60).into();
    fs::write(folder.path("wrong.json"), wrong.to_string()).unwrap();
    folder.slew(&["verify", "wrong.json"]).ends(3).tells("E0032").tells("wrong.json, spec:");

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

/// A file states the duration that a search has found, and its figures are judged like the figures
/// of other plans.
#[test]
fn verify_judges_a_plan_of_minimum_time() {
    let folder = Folder::new();
    let spec = SPEC.replace("duration_s = 10", "minimize = \"time\"") + "[actuators]\ntorque_limit_n_m = 1\n";
    fs::write(folder.path("fast.toml"), spec).unwrap();
    folder.slew(&["plan", "fast.toml", "-q", "-o", "fast.json"]).ends(0);
    folder.slew(&["verify", "fast.json"]).ends(0).tells("verified");
    let plan = folder.json("fast.json");
    for (key, name) in
        [("duration_s", "recorded duration"), ("step_s", "recorded step"), ("turned_deg", "turn")]
    {
        let mut false_figure = plan.clone();
        false_figure[key] = (plan[key].as_f64().unwrap() * (1.0 - 1e-8)).into();
        fs::write(folder.path("false.json"), false_figure.to_string()).unwrap();
        folder.slew(&["verify", "false.json"]).ends(7).tells(name);
    }
}

/// Arcs near plans of equal steps: of a flight, by wheels, in a field, past a cone, along a
/// singular arc, and with ramps. The statements of a file about them are judged, and a false figure
/// is found.
#[test]
fn verify_judges_arcs_beside_plans_of_equal_steps() {
    let folder = Folder::new();
    for (name, structure) in [
        ("minimum_fuel_thrust", "bang_off_bang"),
        ("minimum_fuel_wheels", "bang_off_bang"),
        ("minimum_time_orbit", "bang_bang"),
        ("minimum_fuel_keep_out", "bang_off_bang"),
        ("minimum_fuel_rcs", "singular"),
        ("shortest_torque_rate", "along_limits"),
    ] {
        let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/");
        folder.slew(&["plan", &format!("{spec}{name}.toml"), "-q", "--force", "-o", "arcs.json"]).ends(0);
        folder.slew(&["verify", "arcs.json"]).ends(0).tells("verified");
        let mut plan = folder.json("arcs.json");
        assert_eq!(plan["switching"]["structure"], structure, "{name}");
        let told = plan["switching"]["continuous_cost"].as_f64().unwrap();
        assert!((told / plan["cost"].as_f64().unwrap() - 1.0).abs() < 1e-2, "{name}");
        plan["switching"]["continuous_cost"] = (told * (1.0 - 1e-4)).into();
        fs::write(folder.path("false.json"), plan.to_string()).unwrap();
        folder.slew(&["verify", "false.json"]).ends(7).tells("switching.continuous_cost");
        // Ramps that go the other way.
        let mut plan = folder.json("arcs.json");
        for arc in plan["switching"]["arcs"].as_array_mut().unwrap() {
            for change in arc.get_mut("change").and_then(|change| change.as_array_mut()).into_iter().flatten()
            {
                *change = (-change.as_f64().unwrap()).into();
            }
        }
        let slow = name == "shortest_torque_rate";
        fs::write(folder.path("false.json"), plan.to_string()).unwrap();
        let judged = folder.slew(&["verify", "false.json"]).ends(if slow { 7 } else { 0 });
        judged.tells(if slow { "switching.arcs" } else { "verified" });
    }
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

#[test]
fn a_spec_tells_what_memory_its_plan_takes() {
    let folder = Folder::new();
    let rate = "constraint=[{ kind = \"rate_limit\", angular_velocity_limit_deg_s = 9 }]";
    let free =
        folder.slew(&["check", "spec.toml", "--format", "json"]).ends(0).tells("memory      about").json();
    let limited = folder.slew(&["check", "spec.toml", "--format", "json", "--set", rate]).ends(0).json();
    let scp = ["check", "spec.toml", "--format", "json", "--set", rate, "--set", "solver.method=scp"];
    let scp = folder.slew(&scp).ends(0).json();
    // The shooting may be followed by the interior point.
    let boxed = ["check", "spec.toml", "--format", "json", "--set", "actuators.torque_limit_n_m=100"];
    let boxed = folder.slew(&boxed).ends(0).tells(", up to ").json();
    let bytes = |json: &serde_json::Value, key: &str| json[key].as_f64().unwrap();
    assert_eq!(bytes(&free, "memory_bytes").to_bits(), bytes(&free, "memory_bytes_at_most").to_bits());
    assert!(bytes(&limited, "memory_bytes") > bytes(&free, "memory_bytes"));
    assert!(bytes(&limited, "memory_bytes_at_most") >= bytes(&limited, "memory_bytes"));
    assert!(bytes(&boxed, "memory_bytes_at_most") > bytes(&boxed, "memory_bytes"));
    assert!(bytes(&scp, "memory_bytes_at_most") > bytes(&limited, "memory_bytes_at_most"));
}

/// The limit is 150 MB. A plan that needs more is refused before it begins. A plan that may need
/// more gets a warning. A plan that runs out of memory unexpectedly ends with the code that the
/// help promises.
#[cfg(target_os = "linux")]
#[test]
fn what_does_not_fit_into_memory_ends_with_6() {
    let folder = Folder::new();
    let within = |args: &str| {
        let line = format!("ulimit -v 150000; exec {} {args}", env!("CARGO_BIN_EXE_slew"));
        let mut command = std::process::Command::new("sh");
        command.args(["-c", &line]).current_dir(folder.path("."));
        Run::of(command.output().unwrap(), &[args])
    };
    within("plan spec.toml").ends(0);
    let refused = within("plan spec.toml --format json --set maneuver.steps=1000000").ends(6);
    assert_eq!(refused.tells("E0125").json()["status"], "limit_reached");
    within("check spec.toml --set maneuver.steps=1000000").ends(0).tells("W0142").tells("`maneuver.steps`");
    // The reader cannot know the length of a file.
    let huge = format!("{{\"trajectory\": {{\"time_s\": [{}0]}}}}", "0,".repeat(20_000_000));
    fs::write(folder.path("huge.json"), huge).unwrap();
    within("verify huge.json").ends(6).tells("memory allocation of");
}
