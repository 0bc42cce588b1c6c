//! `slew simulate`, `slew check` and their refusals on specs of bodies, as a user runs them.

use super::binary::{Folder, Run};
use serde_json::Value;
use slewkit::propagate::integrator::Kind;
use std::fs;
use std::process::Stdio;

/// Two bodies far from each other and from rest.
const PAIR: &str = r#"
format = 1
name = "a pair"
[simulation]
duration_s = 4
step_s = 0.01
output_stride = 100
[gravity]
gravitational_constant_m3_kg_s2 = 1
[[bodies]]
name = "dumbbell, \"heavy\""
mass_kg = 2
shape = { kind = "dumbbell", length_m = 0.5, sphere_radius_m = 0.1 }
attitude = { axis = [0, 0, 1], angle_deg = 30 }
angular_velocity_rad_s = [0.1, -0.2, 0.3]
position_m = [1, 0, 0]
velocity_m_s = [0, 0.5, 0]
[[bodies]]
name = "ball"
shape = { kind = "sphere", radius_m = 0.2, density_kg_m3 = 30 }
attitude = { axis = [0, 0, 1], angle_deg = 0 }
angular_velocity_rad_s = [0, 0, 1]
position_m = [-1, 0, 0]
velocity_m_s = [0, -0.5, 0]
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    fs::write(folder.path("pair.toml"), PAIR).unwrap();
    folder
}

/// The same numbers in all three formats, at the spec's stride.
#[test]
fn the_formats_hold_the_same_numbers() {
    let folder = folder();
    let table = folder.slew(&["simulate", "pair.toml", "-q", "--format", "csv"]).ends(0).silent().stdout;
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(header.len(), 1 + 2 * 13 + 1 + 3 + 3 + 1);
    assert!(rows.iter().all(|row| row.len() == header.len()));
    let column =
        |name: &str| header.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}"));
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);

    let objects = folder.slew(&["simulate", "pair.toml", "-q", "--format", "jsonl"]).ends(0).stdout;
    let objects: Vec<Value> = objects.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let document = folder.slew(&["simulate", "pair.toml", "-q", "--format", "json"]).ends(0).json();
    let trajectory = &document["trajectory"];
    assert_eq!((objects.len(), trajectory["time_s"].as_array().unwrap().len()), (5, 5));
    for (index, (row, object)) in rows.iter().zip(&objects).enumerate() {
        for (name, in_line, in_document) in [
            (
                "body2_position_y_m",
                &object["bodies"][1]["position_m"][1],
                &trajectory["bodies"][1]["position_m"][index][1],
            ),
            (
                "body1_quaternion_z",
                &object["bodies"][0]["quaternion_wxyz"][3],
                &trajectory["bodies"][0]["quaternion_wxyz"][index][3],
            ),
            (
                "body1_angular_velocity_x_rad_s",
                &object["bodies"][0]["angular_velocity_rad_s"][0],
                &trajectory["bodies"][0]["angular_velocity_rad_s"][index][0],
            ),
            ("energy_j", &object["energy_j"], &trajectory["energy_j"][index]),
            (
                "linear_momentum_y_n_s",
                &object["linear_momentum_n_s"][1],
                &trajectory["linear_momentum_n_s"][index][1],
            ),
            (
                "angular_momentum_z_n_m_s",
                &object["angular_momentum_n_m_s"][2],
                &trajectory["angular_momentum_n_m_s"][index][2],
            ),
            (
                "orthogonality_error",
                &object["orthogonality_error"],
                &trajectory["orthogonality_error"][index],
            ),
        ] {
            let value = row[column(name)];
            assert_eq!((in_line.as_f64(), in_document.as_f64()), (Some(value), Some(value)), "{name}");
        }
    }
    assert_eq!(document["integrator"], "lie_verlet");
    assert_eq!((document["steps"].as_u64(), document["stride"].as_u64()), (Some(400), Some(100)));
    assert_eq!((document["order"].as_u64(), document["force_evaluations"].as_u64()), (Some(2), Some(401)));
    assert_eq!(trajectory["bodies"][0]["name"], "dumbbell, \"heavy\"");
    let momentum = &document["errors"]["angular_momentum_n_m_s"];
    assert!(momentum.as_f64().unwrap() < 1e-14, "{momentum}");
}

#[test]
fn the_summary_tells_the_method_and_what_it_kept() {
    let folder = folder();
    let run = folder.slew(&["simulate", "pair.toml", "-o", "-"]).ends(0).tells("4.000 s in 400 steps");
    assert_eq!(run.json()["steps"], 400, "data were asked for");
    assert_eq!(folder.slew(&["simulate", "pair.toml"]).ends(0).stdout, "", "nobody asked for data");
    let run = folder.slew(&["simulate", "pair.toml", "--format", "text"]).ends(0);
    assert_eq!(run.stdout, "", "text alone was asked for");
    let run =
        run.tells("order 2, explicit, symplectic, keeps momenta, keeps rotations, 1 force evaluation a step");
    run.tells("401 force evaluations")
        .tells("rotations   at the rows off by at most")
        .tells("ball: quaternion_wxyz");
    let other =
        ["simulate", "pair.toml", "--integrator", "explicit_midpoint", "--steps", "40", "--stride", "7"];
    let run = folder.slew(&other).ends(0).tells("order 2, explicit, 2 force evaluations a step");
    run.tells("80 force evaluations");
}

/// One way through: every integrator on a maneuver and on bodies, alike to its order.
#[test]
fn every_integrator_can_be_asked_for_by_name() {
    let folder = folder();
    for kind in Kind::all() {
        let name = kind.name();
        let spin = "start.angular_velocity_deg_s=[5, 36, 3]";
        let args = ["simulate", "spec.toml", "--integrator", name, "--format", "jsonl", "-q", "--set", spin];
        let last = |run: Run| -> Value { serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap() };
        let maneuver = last(folder.slew(&args).ends(0));
        let rate = maneuver["angular_velocity_rad_s"][1].as_f64().unwrap();
        let bodies = last(
            folder.slew(&["simulate", "pair.toml", "--integrator", name, "--format", "jsonl", "-q"]).ends(0),
        );
        let place = bodies["bodies"][0]["position_m"][0].as_f64().unwrap();
        // The exact rate was computed by DOP853 of SciPy at 1e-13.
        assert!((rate - EXACT_RATE).abs() < 2e-2, "{name}: {rate}");
        assert!((place - EXACT_PLACE).abs() < 2e-2, "{name}: {place}");
        if kind.facts().order >= 4 {
            assert!((rate - EXACT_RATE).abs() < 1e-6, "{name}: {rate}");
            assert!((place - EXACT_PLACE).abs() < 1e-6, "{name}: {place}");
        }
    }
    folder.slew(&["simulate", "spec.toml", "--integrator", "leapfrog"]).ends(2).tells("lie_verlet");
}

const EXACT_RATE: f64 = 0.5679614955718211;
const EXACT_PLACE: f64 = 0.3122043220968179;

#[test]
fn check_tells_what_would_be_simulated() {
    let folder = folder();
    let run = folder
        .slew(&["check", "pair.toml", "--format", "json"])
        .ends(0)
        .tells("400 steps of 0.0100 s, 5 rows");
    let run = run.tells("ball: 1.00531 kg, principal moments");
    let report = run.json();
    assert_eq!((&report["status"], &report["rows"]), (&"valid".into(), &5.into()));
    assert_eq!(report["bodies"][1]["name"], "ball");
    let args = [
        "check",
        "pair.toml",
        "--set",
        "bodies.1.mass_kg=2",
        "--set",
        "simulation.stpes=4",
        "--format",
        "json",
    ];
    let report = folder.slew(&args).ends(3).tells("E0028").tells("did you mean `steps`").json();
    assert_eq!(report["diagnostics"][0]["key"], "bodies.1.mass_kg");
}

#[test]
fn what_is_only_for_the_other_kind_of_spec_is_refused() {
    let folder = folder();
    for command in
        [&["plan", "pair.toml", "-o", "plan.json"][..], &["verify", "none.json", "--spec", "pair.toml"]]
    {
        folder.slew(command).ends(3).tells("E0018").tells("slew simulate");
    }
    folder.slew(&["simulate", "pair.toml", "--inputs", "1,2,3"]).ends(2).tells("no actuators");
    let wheel =
        "actuators.wheel=[{ axis_body = [1, 0, 0] }, { axis_body = [0, 1, 0] }, { axis_body = [0, 0, 1] }]";
    let wheels = |name| folder.slew(&["simulate", "spec.toml", "--set", wheel, "--integrator", name]);
    wheels("rkmk4").ends(2).tells("reaction wheels").tells("verner98");
    wheels("lie_verlet").ends(0);
    wheels("verner98").ends(0);
    assert_eq!(folder.names(), ["pair.toml", "spec.toml"]);
}

#[test]
fn the_template_of_a_simulation_runs() {
    let folder = Folder::new();
    folder.slew(&["init", "--simulation", "-o", "bodies.toml"]).ends(0);
    folder.slew(&["check", "bodies.toml"]).ends(0).tells("valid");
    folder.slew(&["simulate", "bodies.toml", "-o", "motion.csv"]).ends(0).tells("wrote");
    assert_eq!(folder.read("motion.csv").lines().count(), 102);
    folder.slew(&["simulate", "bodies.toml", "-o", "motion.csv"]).ends(8).tells("E0098");
}

/// A motion that cannot continue reports the place and the reason, and leaves no file.
#[test]
fn a_collision_leaves_no_file() {
    let folder = folder();
    let fall = [
        "simulate",
        "pair.toml",
        "-o",
        "fall.csv",
        "--set",
        "bodies.0.velocity_m_s=[0,0,0]",
        "--set",
        "bodies.1.velocity_m_s=[0,0,0]",
        "--set",
        "bodies.0.shape={ kind = \"sphere\", radius_m = 0.1 }",
        "--integrator",
        "dop853",
    ];
    folder.slew(&fall).ends(5).tells("E0122").tells("at t = ");
    assert_eq!(folder.names(), ["pair.toml", "spec.toml"]);
}

/// Error control divides steps that are far too long, and accepts no others.
#[test]
fn error_control_divides_a_step_that_overflows() {
    let folder = folder();
    for (spec, steps, integrator) in [
        ("dzhanibekov", "1", "rkf78_adaptive"),
        ("dzhanibekov", "1", "verner98"),
        ("heavy_top", "1", "rkf78_adaptive"),
        ("heavy_top", "10", "verner98"),
        ("heavy_top", "10", "dop853"),
    ] {
        let path = format!("{}/../../problems/{spec}.toml", env!("CARGO_MANIFEST_DIR"));
        let args =
            ["simulate", &path, "--steps", steps, "--integrator", integrator, "-o", "motion.json", "--force"];
        folder.slew(&args).ends(0);
        let motion: serde_json::Value = serde_json::from_str(&folder.read("motion.json")).unwrap();
        let energy = motion["trajectory"]["energy_j"].as_array().unwrap();
        let (first, last) = (energy[0].as_f64().unwrap(), energy.last().unwrap().as_f64().unwrap());
        assert!((last - first).abs() < 1e-6 * first.abs(), "{spec} by {integrator}: {first} J to {last} J");
    }
}

/// A motion that leaves the finite numbers has its own end; the rows before that stay, and no
/// other.
#[test]
fn a_simulation_that_is_no_longer_finite_keeps_the_rows_before() {
    let folder = folder();
    let path = format!("{}/../../problems/dzhanibekov.toml", env!("CARGO_MANIFEST_DIR"));
    let run = |file: &str, steps: &str, integrator: &str| {
        let args =
            ["simulate", &path, "--steps", steps, "--stride", "1", "--integrator", integrator, "-o", file];
        folder.slew(&args).ends(9).tells("E0123").tells("no longer finite after").tells("at t = ");
        folder.read(file)
    };
    // The state overflows, or only its energy does.
    for (steps, integrator) in [("10", "explicit_midpoint"), ("1", "implicit_midpoint")] {
        let csv = run(&format!("{integrator}.csv"), steps, integrator);
        let rows: Vec<&str> = csv.lines().skip(1).collect();
        assert!(!rows.is_empty());
        for value in rows.iter().flat_map(|row| row.split(',')) {
            assert!(value.parse::<f64>().unwrap().is_finite(), "{integrator}: {value}");
        }
        let json = run(&format!("{integrator}.json"), steps, integrator);
        let document: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(document["status"], "not_finite");
        assert_eq!(document["exit_code"], 9);
        assert_eq!(document["steps_made"], rows.len() - 1);
        assert_eq!(document["trajectory"]["time_s"].as_array().unwrap().len(), rows.len());
    }
}

#[test]
fn a_sought_duration_says_nothing_of_how_long_to_follow() {
    let folder = folder();
    for name in ["shortest_wheels", "minimum_time_xte", "free_duration_xte"] {
        let spec = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let run = folder.slew(&["simulate", &spec, "--steps", "20", "--format", "csv"]).ends(3);
        assert!(run.tells("E0121").tells("maneuver.duration_s").stdout.is_empty());
        // The remedy of the message solves the problem.
        let given = ["--set", "maneuver.minimize=effort", "--set", "maneuver.duration_s=60"];
        let free = name.starts_with("free");
        folder.slew(&[&["simulate", &spec, "--steps", "20"][..], &given].concat()).ends(3 * i32::from(free));
    }
}

/// After Ctrl-C, or another request to end, the rows so far are kept, and the reached state is the
/// last of them.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_simulation_keeps_its_rows() {
    use std::io::{BufRead, BufReader, Read};
    let folder = folder();
    let send = |child: &std::process::Child, signal: &str| {
        let began = std::time::Instant::now();
        while !super::binary::catches(child.id(), signal) {
            assert!(began.elapsed().as_secs() < 60, "{signal} is not taken over");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let kill = |signal: &str| {
            std::process::Command::new("kill").args([signal, &child.id().to_string()]).status()
        };
        assert!(kill(signal).unwrap().success());
    };
    let interrupt = |child: &std::process::Child| send(child, "-INT");
    // A stride that is not reached: the last row is the state at the interruption.
    let long = ["--steps", "1000000000", "--stride", "500000000"];
    for (signal, file) in [("-INT", "long.csv"), ("-TERM", "long.json"), ("-HUP", "long.jsonl")] {
        if super::binary::is_ignored(signal) {
            continue;
        }
        let mut args = vec!["simulate", "pair.toml", "-o", file];
        args.extend(long);
        let child = folder.command(&args).stderr(Stdio::piped()).spawn().unwrap();
        send(&child, signal);
        let run = Run::of(child.wait_with_output().unwrap(), &args).ends(130);
        run.tells("interrupted after").tells("of 1000000000 steps, at t = ").tells("wrote");
        assert_eq!(folder.names(), [file, "pair.toml", "spec.toml"]);
        let text = folder.read(file);
        assert!(text.ends_with('\n'));
        if file == "long.json" {
            let document = folder.json(file);
            assert_eq!((&document["status"], &document["exit_code"]), (&"interrupted".into(), &130.into()));
            let times = document["trajectory"]["time_s"].as_array().unwrap();
            let reached = document["steps_made"].as_f64().unwrap() * document["step_s"].as_f64().unwrap();
            assert_eq!(times.len(), 2);
            assert!((times[1].as_f64().unwrap() - reached).abs() < 1e-12 && reached > 0.0, "{times:?}");
        } else {
            let rows = 2 + usize::from(file == "long.csv");
            assert_eq!(text.lines().count(), rows, "{text}");
        }
        fs::remove_file(folder.path(file)).unwrap();
    }
    let long = ["--steps", "1000000000", "--stride", "1000"];
    let mut args = vec!["simulate", "pair.toml", "--format", "jsonl"];
    args.extend(long);
    let mut child = folder.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let mut first = String::new();
    reader.read_line(&mut first).unwrap();
    interrupt(&child);
    let mut rest = String::new();
    reader.read_to_string(&mut rest).unwrap();
    let run = Run::of(child.wait_with_output().unwrap(), &args).ends(130).tells("interrupted after");
    assert!(rest.ends_with('\n'), "{:?}", &rest[rest.len().saturating_sub(80)..]);
    for line in rest.lines() {
        serde_json::from_str::<Value>(line).unwrap_or_else(|error| panic!("{error}: {line}"));
    }
    drop(run);
}

/// A reader that closes the pipe ends the run, without a message.
#[test]
fn a_reader_that_has_gone_is_told_nothing() {
    use std::io::{BufRead, BufReader};
    let folder = folder();
    let args = ["simulate", "pair.toml", "--format", "csv", "--steps", "100000000", "--stride", "10"];
    let mut child = folder.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.starts_with("time_s,"));
    Run::of(child.wait_with_output().unwrap(), &args).ends(0).silent();
}

/// For bodies that hardly turn, the round-off of the moments, relative to the momenta, exceeds the
/// allowed remainder of an iteration.
#[test]
fn the_implicit_midpoint_rule_ends_where_the_motion_is_mild() {
    let folder = Folder::new();
    fs::write(folder.path("mild.toml"), MILD).unwrap();
    for step in ["0.2", "0.1", "0.05"] {
        let step = format!("simulation.step_s={step}");
        let args = ["simulate", "mild.toml", "--integrator", "implicit_midpoint", "--set", &step, "--format"];
        let document = folder.slew(&[&args[..], &["json"]].concat()).ends(0).json();
        let (evaluations, steps) = (document["force_evaluations"].as_f64(), document["steps"].as_f64());
        assert!(evaluations.unwrap() < 15.0 * steps.unwrap(), "{evaluations:?} in {steps:?} steps");
        let error = document["errors"]["energy_j"].as_f64().unwrap();
        assert!(error < 2e-4, "{error:e}");
    }
}

const MILD: &str = r#"
format = 1
[simulation]
duration_s = 30
step_s = 0.1
[gravity]
gravitational_constant_m3_kg_s2 = 1
[[bodies]]
name = "A"
mass_kg = 1
shape = { kind = "dumbbell", length_m = 0.5, sphere_radius_m = 0.1 }
position_m = [-2, 0, 0]
velocity_m_s = [0, -0.7, 0]
attitude = { axis = [0, 0, 1], angle_deg = 30 }
[[bodies]]
name = "B"
mass_kg = 2
shape = { kind = "cuboid", edges_m = [1, 0.5, 0.3] }
position_m = [1, 0, 0]
velocity_m_s = [0, 0.35, 0]
attitude = { axis = [1, 0, 0], angle_deg = 90 }
"#;

/// Only symmetries of the forces conserve quantities, and only conserved quantities can drift.
#[test]
fn only_what_is_conserved_has_an_error() {
    let folder = Folder::new();
    let gravity = "environment={ kind = \"uniform_gravity\", mass_kg = 1, gravity_m_s2 = 9.81, direction = [0, 0, 1], \
                   pivot_to_mass_center_m = [0, 0, 0.3] }";
    let gradient = "environment={ kind = \"gravity_gradient\", orbital_rate_rad_s = 0.1 }";
    let spin = "start.angular_velocity_deg_s=[5, 36, 3]";
    let errors = |more: &[&str]| {
        let args = [&["simulate", "spec.toml", "--format", "json", "--set", spin], more].concat();
        let run = folder.slew(&args).ends(0);
        (run.json()["errors"].clone(), run)
    };
    let small = |value: &Value| value.as_f64().is_some_and(|value| value < 1e-13);
    let (free, run) = errors(&[]);
    run.tells("keeps momenta").tells("at the rows off by at most");
    assert!(small(&free["angular_momentum_n_m_s"]) && free["axis"].is_null(), "{free}");
    let (top, run) = errors(&["--set", gravity]);
    run.tells("angular, about [0, 0, 1.00000]");
    assert!(
        small(&top["angular_momentum_about_axis_n_m_s"]) && top["angular_momentum_n_m_s"].is_null(),
        "{top}"
    );
    assert_eq!(top["axis"], serde_json::json!([0.0, 0.0, 1.0]));
    let (orbit, run) = errors(&["--set", gradient, "--set", "end.angular_velocity_deg_s=[0, 0, 0]"]);
    run.tells("N·m·s at the start; not conserved");
    assert!(orbit["angular_momentum_n_m_s"].is_null() && orbit["axis"].is_null(), "{orbit}");
    assert!(orbit["energy_j"].is_number());
    let (driven, _) = errors(&["--inputs", "0,0,0.1"]);
    assert!(driven["energy_j"].is_null() && driven["angular_momentum_n_m_s"].is_null(), "{driven}");
}

#[test]
fn bodies_that_run_through_each_other_are_told_of() {
    let folder = folder();
    let rest = ["--set", "bodies.0.velocity_m_s=[0,0.02,0]", "--set", "bodies.1.velocity_m_s=[0,-0.02,0]"];
    // The stride steps over the moment.
    let args = [&["simulate", "pair.toml", "--format", "json", "--stride", "400"], &rest[..]].concat();
    let run = folder.slew(&args).ends(0).tells("W0134").tells("ball came closer than their sizes at t = ");
    let encounter = &run.json()["encounter"];
    let (time, distance) = (encounter["time_s"].as_f64().unwrap(), encounter["distance_m"].as_f64().unwrap());
    assert!((0.1..4.0).contains(&time) && distance < 0.55, "{encounter}");
    assert_eq!(encounter["bodies"][1], "ball");
    let calm = folder.slew(&["simulate", "pair.toml", "--format", "json"]).ends(0);
    assert!(!calm.stderr.contains("W0134") && calm.json()["encounter"].is_null());
}

/// Held inputs of wheels: the momenta have columns, and a momentum beyond a limit gets a warning.
#[test]
fn wheels_have_columns_and_limits() {
    let folder = Folder::new();
    let wheel = |axis: &str| {
        format!(
            "{{ axis_body = {axis}, torque_limit_n_m = 0.35, momentum_limit_n_m_s = 2, momentum_n_m_s = 0.5 }}"
        )
    };
    let axes = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"].map(wheel).join(", ");
    let wheels = format!("actuators.wheel=[{axes}]");
    let args = ["simulate", "spec.toml", "--set", &wheels, "--format", "csv", "--inputs"];
    let run = folder.slew(&[&args[..], &["0.5,0,-0.1"]].concat()).ends(0).tells("W0135");
    run.tells("input 1 is 0.5000 N·m, above its wheel torque limit of 0.3500 N·m");
    let run = folder.slew(&[&args[..], &["0.5,0,-0.1"]].concat()).ends(0);
    let run = run.tells("wheel 1 exceeds its momentum limit of 2.000 N·m·s from t = 5.000 s on");
    assert!(!run.stderr.contains("wheel 3"), "{}", run.stderr);
    let names: Vec<_> = run.stdout.lines().next().unwrap().split(',').collect();
    let last: Vec<f64> =
        run.stdout.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    for (wheel, momentum) in [(1, 0.5 - 5.0), (2, 0.5), (3, 0.5 + 1.0)] {
        let name = format!("wheel_momentum_{wheel}_n_m_s");
        let column = names.iter().position(|column| *column == name).unwrap();
        assert!((last[column] - momentum).abs() < 1e-12, "{name}: {}", last[column]);
    }
    // The total momentum is constant: the body gains the momentum that the wheels lose.
    let quiet = folder.slew(&[&args[..], &["0,0,0"]].concat()).ends(0);
    assert!(!quiet.stderr.contains("W0135"));
}

/// A solid whose mass center is not its origin, faces with four corners, and an invalid solid.
#[test]
fn check_tells_what_a_shape_of_faces_comes_to() {
    let folder = folder();
    let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n";
    let sides = ["f 4 3 2 1", "f 5 6 7 8", "f 1 2 6 5", "f 2 3 7 6", "f 3 4 8 7", "f 4 1 5 8"];
    let cube = |sides: &[&str]| {
        fs::write(folder.path("cube.obj"), format!("{corners}{}\n", sides.join("\n"))).unwrap()
    };
    cube(&sides);
    let shape = "bodies.1.shape={ kind = \"polyhedron\", obj = \"cube.obj\", density_kg_m3 = 3 }";
    let check = || folder.slew(&["check", "pair.toml", "--set", shape, "--format", "json"]);
    let run = check().ends(0).tells("12 faces, 8.00000 m³, mass center [1.00000, 1.00000, 1.00000] m");
    let body = run.json()["bodies"][1].clone();
    assert!((body["volume_m3"].as_f64().unwrap() - 8.0).abs() < 1e-12, "{body}");
    for axis in 0..3 {
        assert!((body["mass_center_m"][axis].as_f64().unwrap() - 1.0).abs() < 1e-12, "{body}");
        assert!((body["inertia_kg_m2"][axis][axis].as_f64().unwrap() - 16.0).abs() < 1e-12, "{body}");
    }
    cube(&[&sides[..5], &["f 4 1 5 99"]].concat());
    check().ends(3).tells("face 6 names vertex 99");
    cube(&sides[..5]);
    check().ends(3).tells("no second face joins face 1 at");
}

#[test]
fn shapes_that_overlap_or_take_long_are_warned_of() {
    let folder = folder();
    let fat = "bodies.0.shape.sphere_radius_m=0.4";
    folder.slew(&["check", "pair.toml", "--set", fat]).ends(0).tells("W0136").tells("the spheres overlap");
    let solid = |body: usize| {
        format!(
            "bodies.{body}.shape={{ kind = \"octahedron\", semi_axes_m = [0.1, 0.2, 0.3], gauss_order = 8 }}"
        )
    };
    let mass = "bodies.1.mass_kg=1";
    let (first, second) = (solid(0), solid(1));
    let run = folder.slew(&["check", "pair.toml", "--set", &first, "--set", &second, "--set", mass]).ends(0);
    assert!(!run.stderr.contains("W0137"), "{}", run.stderr);
    // A grid on a cube: 12 n² faces.
    fs::write(folder.path("cube.obj"), grid_on_a_cube(10)).unwrap();
    let solid = |body: usize| {
        format!("bodies.{body}.shape={{ kind = \"polyhedron\", obj = \"cube.obj\", obj_unit_m = 0.1 }}")
    };
    let (first, second) = (solid(0), solid(1));
    let run = folder.slew(&["check", "pair.toml", "--set", &first, "--set", &second, "--set", mass]).ends(0);
    run.tells("W0137").tells("ball 1200").tells("second_order");
}

fn grid_on_a_cube(n: usize) -> String {
    let mut text = String::new();
    let mut corner = |place: [usize; 3]| text += &format!("v {} {} {}\n", place[0], place[1], place[2]);
    for axis in 0..3 {
        for side in [0, n] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut around = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                if side == 0 {
                    around.reverse();
                }
                for [i, j] in around {
                    let mut place = [0; 3];
                    (place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3]) = (side, i, j);
                    corner(place);
                }
            }
        }
    }
    for face in 0..6 * n * n {
        text += &format!("f {} {} {} {}\n", 4 * face + 1, 4 * face + 2, 4 * face + 3, 4 * face + 4);
    }
    text
}

/// A body that hardly turns: the round-off of its moments must not drive the error control.
#[test]
fn the_default_tolerance_is_within_reach() {
    let folder = Folder::new();
    fs::write(folder.path("mild.toml"), MILD).unwrap();
    for name in ["rkf78_adaptive", "dop853", "verner98"] {
        let args = ["simulate", "mild.toml", "--format", "json", "--integrator", name];
        let document = folder.slew(&args).ends(0).json();
        let evaluations = document["force_evaluations"].as_u64().unwrap();
        assert!(evaluations < 25_000, "{name}: {evaluations}");
        assert!(document["errors"]["energy_j"].as_f64().unwrap() < 1e-13, "{name}");
    }
    let finer = ["simulate", "mild.toml", "--set", "simulation.tolerance=1e-15"];
    folder.slew(&finer).ends(3).tells("E0031").tells("round-off");
}
