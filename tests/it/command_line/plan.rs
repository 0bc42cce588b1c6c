//! `slew plan`: the summary, the data, guesses, statuses.

use super::binary::{Folder, Run};
use serde_json::Value;
use slewkit_files::export::PlanFile;
use std::fs;
use std::process::Stdio;

#[test]
fn plan_tells_people_on_stderr_and_writes_the_file() {
    let folder = Folder::new();
    let run = folder.slew(&["plan", "spec.toml", "-o", "plan.json"]).ends(0);
    assert_eq!(run.stdout, "");
    let run = run.tells("test slew").tells("solved and verified").tells("wrote       plan.json");
    for label in ["slew", "cost", "arrives", "torque", "rate", "proof", "next"] {
        assert!(run.stderr.contains(&format!("\n  {label} ")), "{label}: {}", run.stderr);
    }
    assert!(!run.stderr.contains("Newton"), "for who flies it: {}", run.stderr);
    let long = folder.slew(&["plan", "spec.toml", "-v"]).ends(0);
    for label in ["slew", "method", "cost", "iterations", "terminal", "optimality", "limits", "verified"] {
        assert!(long.stderr.contains(&format!("\n  {label} ")), "{label}: {}", long.stderr);
    }
    assert!(!run.stderr.contains('\u{1b}'), "no colour and no progress off a terminal");
    let plan = PlanFile::read(fs::File::open(folder.path("plan.json")).unwrap()).unwrap();
    assert_eq!((plan.status.name(), plan.exit_code, plan.steps), ("solved", 0, 100));
    assert_eq!(plan.trajectory.0.time.len(), 101);
    assert!(plan.terminal.largest() <= 1e-12);
    assert_eq!(folder.names(), ["plan.json", "spec.toml"]);
}

#[test]
fn a_test_that_was_skipped_is_told_in_summary_and_file() {
    let folder = Folder::new();
    let skip = "solver.second_order=skipped";
    let run = folder.slew(&["plan", "spec.toml", "--set", skip, "-v", "-o", "plan.json"]).ends(0);
    run.tells("an extremal, not known to be a minimum: not tested, as requested")
        .tells("second order: not tested, as requested");
    let plan = folder.json("plan.json");
    assert_eq!((&plan["second_order"], &plan["optimality"]["tested"]), (&"not_tested".into(), &false.into()));
    assert_eq!(plan["spec"]["solver"]["second_order"], "skipped");
    let back = PlanFile::read(fs::File::open(folder.path("plan.json")).unwrap()).unwrap();
    assert!(!back.optimality.tested);
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
fn ending_of_the_output_chooses_the_format() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "a.csv"]).ends(0).silent();
    assert!(folder.read("a.csv").starts_with("time_s,"));
    folder.slew(&["plan", "spec.toml", "-q", "-o", "a.JSONL"]).ends(0);
    assert!(folder.read("a.JSONL").starts_with("{\"time_s\":0.0,"));
    // The name does not determine the format, so `--format` does.
    folder.slew(&["plan", "spec.toml", "-q", "-o", "b.dat", "--format", "json"]).ends(0);
    assert_eq!(folder.json("b.dat")["exit_code"], 0);
    for stdout in ["-", "/dev/stdout"] {
        let stdout = folder.slew(&["plan", "spec.toml", "-q", "-o", stdout]).ends(0);
        assert_eq!(stdout.json()["exit_code"], 0);
    }
}

#[test]
fn unknown_endings_and_contradictions_are_refused_before_any_work() {
    let folder = Folder::new();
    let before = folder.names();
    for (name, reason) in [
        ("plan.png", "no format has the ending .png"),
        ("plan.html", "no format has the ending .html"),
        ("plan.jsn", "no format has the ending .jsn"),
        ("plan", "plan has no ending"),
        ("json", "json has no ending"),
        ("plan.", "no format has the ending ."),
    ] {
        let run = folder.slew(&["plan", "spec.toml", "-o", name]).ends(2).tells("error[E0105]").tells(reason);
        run.tells(".jsonl, .ndjson").tells("--format NAME");
    }
    let contradiction = ["plan", "spec.toml", "-o", "plan.csv", "--format", "json"];
    folder.slew(&contradiction).ends(2).tells("E0106").tells("plan.csv ends as csv does").tells(".json");
    // The refusal is a document if a document is requested.
    let refused = folder.slew(&contradiction).json();
    assert_eq!((&refused["status"], &refused["error"]["code"]), (&"usage_error".into(), &"E0106".into()));
    assert_eq!(folder.names(), before);
}

#[test]
fn data_go_to_stdout_only_where_that_is_asked_for() {
    let folder = Folder::new();
    let to = |stdout: Stdio, stderr: Stdio, more: &[&str]| {
        let args = [&["plan", "spec.toml"], more].concat();
        let status = folder.command(&args).stdout(stdout).stderr(stderr).status().unwrap();
        assert_eq!(status.code(), Some(0));
    };
    let file = |name: &str| fs::File::create(folder.path(name)).unwrap();
    // The plan is written to stdout, a separate file, if it is requested.
    for (name, asked) in [("dash", ["-o", "-"]), ("format", ["--format", "json"])] {
        to(file(name).into(), file("summary.txt").into(), &asked);
        assert_eq!(folder.json(name)["status"], "solved");
        assert!(folder.read("summary.txt").contains("solved and verified"));
    }
    // The log of a script does not get numbers that were not requested.
    to(file("unasked.json").into(), file("summary.txt").into(), &[]);
    assert_eq!(folder.read("unasked.json"), "");
    // A script that reads stdout and stderr from one file gets the summary alone.
    let both = file("both.txt");
    to(both.try_clone().unwrap().into(), both.into(), &[]);
    assert!(folder.read("both.txt").contains("solved and verified"));
    assert!(!folder.read("both.txt").contains("quaternion_wxyz"));
    // Only text was requested.
    to(file("none.json").into(), Stdio::null(), &["--format", "text"]);
    assert_eq!(folder.read("none.json"), "");
    // A pipe gets no output by default, and with `-o` only the file is written.
    assert_eq!(folder.slew(&["plan", "spec.toml"]).ends(0).stdout, "");
    assert_eq!(folder.slew(&["plan", "spec.toml", "-o", "other.json"]).ends(0).stdout, "");
    // A failure has its reason in place of the plan.
    let failed =
        folder.slew(&["plan", "spec.toml", "--format", "json", "--set", "maneuver.duration_s=-1"]).ends(3);
    assert_eq!(failed.json()["status"], "spec_invalid");
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
    let discrete = ["--set", "solver.target=discrete"];
    folder.slew(&[&["plan", "spec.toml", "-q", "-o", "plan.json"], &discrete[..]].concat()).ends(0);
    let args = ["plan", "spec.toml", "-q", "--format", "json", "--guess", "plan.json"];
    let args = [&args[..], &discrete].concat();
    let again = folder.slew(&args).ends(0).json();
    let first = folder.json("plan.json");
    let rung = again["ladder"].as_array().unwrap().iter().find(|rung| rung["rung"] == "guess").unwrap();
    assert_eq!(rung["outcome"], "converged");
    assert!(rung["iterations"].as_u64().unwrap() <= 1, "{rung}");
    let cost = |plan: &Value| plan["cost"].as_f64().unwrap();
    assert!((cost(&again) - cost(&first)).abs() <= 1e-12 * cost(&first));
}

/// A guess is an additional start of the search. A costly guess only changes the list of other
/// plans, unless it is the only start.
#[test]
fn a_guess_never_replaces_the_search_unasked() {
    let cost = |plan: &Value| plan["cost"].as_f64().unwrap();
    let torques = "actuators={ torque_axes_body = [[1,0,0],[0,1,0],[0,0,1]], torque_limit_n_m = 5 }";
    for limits in [&[][..], &["--set", torques]] {
        let folder = Folder::new();
        let plan = |more: &[&str]| {
            let args = ["plan", "spec.toml", "-q", "--format", "json", "--set", "maneuver.steps=60"];
            folder.slew(&[&args[..], limits, more].concat()).ends(0).json()
        };
        let best = plan(&[]);
        let long = plan(&["--set", "maneuver.path=long"]);
        assert!(cost(&long) > 1.5 * cost(&best));
        fs::write(folder.path("long.json"), long.to_string()).unwrap();
        let guessed = plan(&["--guess", "long.json"]);
        assert!((cost(&guessed) - cost(&best)).abs() <= 1e-9 * cost(&best), "{}", cost(&guessed));
        let ways = |plan: &Value| {
            let rivals = plan["rivals"].as_array().unwrap().clone();
            rivals.iter().filter(|rival| rival["sense"] == "long").count()
        };
        assert!(ways(&guessed) >= 1, "{}", guessed["rivals"]);
        let alone = plan(&["--guess", "long.json", "--guess-alone"]);
        assert!((cost(&alone) - cost(&long)).abs() <= 1e-6 * cost(&long), "{}", cost(&alone));
        // The best plan helps the search where it is the guess.
        fs::write(folder.path("best.json"), best.to_string()).unwrap();
        let again = plan(&["--guess", "best.json"]);
        assert!((cost(&again) - cost(&best)).abs() <= 1e-9 * cost(&best), "{}", cost(&again));
        folder.slew(&["plan", "spec.toml", "--guess-alone"]).ends(2);
    }
}

/// A guess for a maneuver with a free roll is an additional start at the final roll of the guess.
/// As the only start it leads to the plan at that roll.
#[test]
fn a_guess_is_taken_for_an_end_on_a_target() {
    let cost = |plan: &Value| plan["cost"].as_f64().unwrap();
    let folder = Folder::new();
    let spec = "format = 1\nbody.inertia_kg_m2 = [12, 10, 8]\nstart.attitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
        maneuver = { duration_s = 20, steps = 60 }\n";
    let end =
        "end = { point = { boresight_body = [0, 0, 1], ra_deg = 60, dec_deg = 20 }, rate = \"zero\" }\n";
    fs::write(folder.path("free.toml"), format!("{spec}{end}")).unwrap();
    let plan = |more: &[&str]| {
        let args = ["plan", "free.toml", "-q", "--format", "json"];
        folder.slew(&[&args[..], more].concat()).ends(0).json()
    };
    let best = plan(&[]);
    fs::write(folder.path("best.json"), best.to_string()).unwrap();
    let again = plan(&["--guess", "best.json"]);
    assert!((cost(&again) - cost(&best)).abs() <= 1e-9 * cost(&best), "{}", cost(&again));
    let other = plan(&["--set", "body.inertia_kg_m2=[12,11,8]"]);
    assert!((cost(&other) - cost(&best)).abs() > 1e-4 * cost(&best));
    fs::write(folder.path("other.json"), other.to_string()).unwrap();
    let beside = plan(&["--guess", "other.json"]);
    assert!((cost(&beside) - cost(&best)).abs() <= 1e-9 * cost(&best), "{}", cost(&beside));
    // The roll of the other plan is nearly the best.
    let alone = cost(&plan(&["--guess", "other.json", "--guess-alone"])) / cost(&best);
    assert!((1.0..1.02).contains(&alone), "{alone}");
    // Nothing begins from a guess where inputs switch.
    let sought = ["plan", "free.toml", "--guess", "best.json", "--set", "maneuver.minimize=fuel"];
    let limits = "actuators={ torque_axes_body = [[1,0,0],[0,1,0],[0,0,1]], torque_limit_n_m = 5 }";
    folder.slew(&[&sought[..], &["--set", limits]].concat()).ends(3).tells("does not use a guess");
}

#[test]
fn a_guess_that_is_none_is_refused() {
    let folder = Folder::new();
    fs::write(folder.path("three.json"), "{\"format\": 1, \"costates_0\": [1, 2, 3]}").unwrap();
    let guess = |name: &str| folder.slew(&["plan", "spec.toml", "--guess", name]);
    guess("spec.toml").ends(8).tells("spec.toml:2:1: error[E0151]").tells("no column `time_s`");
    fs::write(folder.path("two.json"), "{\"format\": 1}").unwrap();
    guess("two.json").ends(8).tells("E0102").tells("not a plan file");
    guess("three.json").ends(8).tells("E0103").tells("3 costates, and this maneuver needs 6");
    let path = "{\"format\": 2, \"costates_0\": [0, 0, 0, 0, 0, 0], \"trajectory\": {\"quaternion_wxyz\": \
        [[0, 0, 0, 0]]}}";
    fs::write(folder.path("path.json"), path).unwrap();
    guess("path.json").ends(8).tells("E0103").tells("unit quaternions").tells("another plan");
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
    // Only the shooting is allowed here: `auto` would have another method left.
    let keys = ["solver.max_iterations=1", "solver.method=\"shooting\"", "maneuver.path=\"long\""];
    let one = ["plan", "spec.toml", "-o", "best.json", "--set", keys[0], "--set", keys[1], "--set", keys[2]];
    let run = folder.slew(&one).ends(5).tells("not converged").tells("the iteration limit was reached");
    let run = run.tells("attempts, which -v lists").tells("\n  try ").tells("solver.max_iterations");
    assert!(run.stderr.lines().count() < 20, "{}", run.stderr);
    let run = folder.slew(&[&one[..], &["-v", "--force"]].concat()).ends(5);
    let run = run.tells("\n  attempts ").tells("newton").tells("\n  try ").tells("solver.max_iterations");
    assert!(run.stderr.lines().count() < 60, "a crowd of runs shares a line: {}", run.stderr);
    let best = folder.json("best.json");
    assert_eq!(best["status"], "not_converged");
    assert_eq!(best["verified"], Value::Null);
    PlanFile::read(folder.read("best.json").as_bytes()).unwrap();
}

#[test]
fn a_plan_under_constraints_tells_margins_and_is_verified_from_its_file() {
    let folder = Folder::new();
    let cone = "constraint=[{ kind = \"keep_out\", name = \"Sun\", boresight_body = [1, 0, 0], \
        direction_inertial = { ra_deg = 45, dec_deg = 2 }, half_angle_deg = 20 }]";
    let limit = "actuators.torque_norm_limit_n_m=0.17";
    let set =
        ["--set", cone, "--set", limit, "--set", "maneuver.steps=50", "--set", "solver.target=discrete"];
    let plan = |more: &[&str]| folder.slew(&[&["plan", "spec.toml"], &set[..], more].concat());
    let run = plan(&["-v", "-o", "plan.json"])
        .ends(0)
        .tells("solved and verified")
        .tells("method      interior point, ");
    let run = run
        .tells("torque norm limit  active at ")
        .tells("Sun                active at ")
        .tells("margin 0 N·m at ");
    // The true motion is beyond by the error of the discretisation, in all summaries.
    let run = run.tells("clearance   Sun: 0.015 deg too near").tells("margin -0.0148 deg at ");
    let run = run.tells("between nodes").tells("; the discrete motion keeps the limit");
    assert!(!run.stderr.contains("violated"), "{}", run.stderr);
    let json = folder.json("plan.json");
    assert_eq!(json["method"], "interior_point");
    let names = |list: &Value| {
        let names = list.as_array().unwrap().iter();
        names.map(|entry| entry["name"].as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    assert_eq!(names(&json["active"]), ["torque norm limit", "Sun"]);
    assert_eq!(names(&json["verified"]["margins"]), ["torque norm limit", "Sun"]);
    assert!(json["verified"]["margins"][1]["scaled"].as_f64().unwrap() > -1e-9);
    assert_eq!(json["spec"]["constraint"][0]["kind"], "keep_out");
    assert_eq!(json["spec"]["actuators"]["torque_norm_limit_n_m"], 0.17);

    let verify = |set: &[&str]| folder.slew(&[&["verify", "plan.json", "--spec", "spec.toml"], set].concat());
    // The witness finds the active limits by itself, and ignores the plan's own statement.
    let run =
        verify(&set).ends(0).tells("verified").tells("limit  active, ").tells("Sun                active, ");
    let run = run.tells("; the discrete motion keeps the limit");
    assert!(!run.stderr.contains("differs"), "{}", run.stderr);
    // The plan for a wider cone would have to pass further out, and the plan without limits was not
    // requested.
    let wider = ["--set", cone, "--set", limit, "--set", "constraint.0.half_angle_deg=21"];
    verify(&wider).ends(7).tells("constraint.0.half_angle_rad").tells("violated, margin -1.01 deg");
    verify(&["--set", "solver.target=discrete"])
        .ends(0)
        .tells("differs     constraint")
        .tells("differs     actuators.torque_norm_limit_n_m");
    // The plan is judged by the spec that it holds, including the limits.
    let run = folder.slew(&["verify", "plan.json"]).ends(0).tells("torque norm limit  active, ");
    assert!(!run.stderr.contains("differs"), "{}", run.stderr);
    folder.slew(&["verify", "plan.json", "--set", "constraint.0.half_angle_deg=21"]).ends(3).tells("E0028");
    let wider = ["verify", "plan.json", "--set", "constraint.0.half_angle_rad=0.37"];
    folder.slew(&wider).ends(7).tells("constraint.0.half_angle_rad").tells("violated");

    // Two runs differ in the solve time alone.
    plan(&["-q", "-o", "again.json"]).ends(0);
    let (first, second) = (folder.read("plan.json"), folder.read("again.json"));
    let differ: Vec<_> = first.lines().zip(second.lines()).filter(|(a, b)| a != b).collect();
    assert!(differ.len() == 1 && differ[0].0.contains("solve_time_s"), "{differ:?}");

    let shooting = [&set[..], &["--set", "solver.method=shooting"]].concat();
    folder.slew(&[&["plan", "spec.toml"], &shooting[..]].concat()).ends(3).tells("E0066");
}

/// A discrete plan on three steps exists for a maneuver that is proved infeasible on twenty: the
/// motion that it stands for misses the end by almost a third of the angle turned.
#[test]
fn a_plan_that_stands_for_no_motion_is_not_called_verified() {
    let spec = r#"
        format = 1
        [body]
        inertia_kg_m2 = [[91.23008666346507, -8.856986061694387, 0.23316141476670132],
            [-8.856986061694387, 110.094389301059, -9.236401958094167],
            [0.23316141476670132, -9.236401958094167, 98.67552403547592]]
        [start]
        attitude = { matrix = [[0.20977484915288902, -0.9142255029437846, -0.3466788750848061],
            [0.5644046540846169, 0.40275403888743755, -0.7205807176211977],
            [0.7983995861161918, -0.04450745922921695, 0.6004807964976507]] }
        [end]
        attitude = { matrix = [[0.5112486547148268, -0.6858752946301061, -0.5178801920023054],
            [0.31015654143803406, 0.7092186231758383, -0.633097041806203],
            [0.801515896820192, 0.16304608169665755, 0.5753157762376154]] }
        [maneuver]
        duration_s = 60
        steps = 3
        [actuators]
        torque_norm_limit_n_m = 0.07694597158929378
        [[constraint]]
        kind = "rate_limit"
        angular_velocity_limit_rad_s = 0.008324535202165556
    "#;
    let folder = Folder::new();
    fs::write(folder.path("short.toml"), spec).unwrap();
    let run = folder.slew(&["plan", "short.toml", "--format", "json"]).ends(7);
    let run = run.tells("continuous terminal").tells("use more steps").tells("--set maneuver.steps=");
    assert_eq!(run.json()["status"], "verification_failed");
    // The tolerance of the user applies, and a proof is found on steps that are short enough.
    let accepted = ["plan", "short.toml", "--set", "solver.continuous_tolerance_deg=10"];
    folder.slew(&accepted).ends(0);
    folder.slew(&["plan", "short.toml", "--set", "maneuver.steps=20"]).ends(4);
}

#[test]
fn a_solved_plan_that_is_coarse_or_idle_says_so() {
    let folder = Folder::new();
    let discrete = ["plan", "spec.toml", "--set", "solver.target=discrete"];
    let plan = |set: &[&str]| folder.slew(&[&discrete, set, &["-v"]].concat()).ends(0);
    assert!(!plan(&["--set", "maneuver.steps=500"]).stderr.contains("\n  try "));
    plan(&["--set", "maneuver.steps=5"])
        .tells(" deg)")
        .tells("\n  try         slew plan spec.toml --set solver.target=discrete --set maneuver.steps=")
        .tells("   # ends within 0.01 deg");
    // So coarse that it stands for no motion: a third of the angle turned.
    folder
        .slew(&[&discrete[..], &["-v", "--set", "maneuver.steps=3"]].concat())
        .ends(7)
        .tells(" deg)")
        .tells("\n  try         slew plan spec.toml --set solver.target=discrete --set maneuver.steps=");
    // Where no limit acts the shooting's plan stands, but its rivals may break limits that nobody
    // held them to.
    assert!(plan(&[]).stderr.contains("\n  rival "));
    let wide = "constraint=[{ kind = \"keep_in\", boresight_body = [1, 0, 0], direction_inertial = { ra_deg \
        = 45, dec_deg = 2 }, half_angle_deg = 80 }]";
    let run = plan(&["--set", wide]).tells("6 costates, no limit active");
    assert!(!run.stderr.contains("\n  rival "), "{}", run.stderr);
    let data = folder.slew(&["plan", "spec.toml", "-o", "plan.txt", "--format", "text"]);
    data.ends(2).tells("--format text");
    assert!(!folder.path("plan.txt").exists());
}

#[test]
fn a_plan_that_is_not_found_names_what_could_do() {
    let folder = Folder::new();
    // The plan goes to stdout, and the text for people to stderr.
    let plan = |limit: &str| folder.slew(&["plan", "spec.toml", "--set", limit, "--format", "json"]);
    let run = plan("actuators.torque_norm_limit_n_m=0.05").ends(4);
    let proved = run.json();
    assert!(proved["shortest_duration_s"].as_f64().unwrap() > 10.0);
    assert_eq!(proved["optimality"]["stationarity"], Value::Null);
    let run = run.tells("   # enough time for a fixed axis; no plan is shorter than ");
    assert!(!run.stderr.contains("method"), "{}", run.stderr);
    // Not enough torque, and not provably so.
    let limit = "actuators.torque_norm_limit_n_m=0.13";
    let run = plan(limit).ends(5);
    let longer = run.json()["longer_s"].as_f64().unwrap();
    assert!(longer > 10.0 && longer < 20.0, "{longer}");
    let advice =
        format!("slew plan spec.toml --set {limit} --set maneuver.duration_s={longer}   # more time\n");
    run.tells(&advice);
    let longer = format!("maneuver.duration_s={longer}");
    folder.slew(&["plan", "spec.toml", "--set", limit, "--set", &longer]).ends(0);
}

#[test]
fn wheels_show_in_summary_and_tables() {
    let folder = Folder::new();
    let wheels = "actuators.wheel=[{ name = \"roll\", axis_body = [1, 0, 0], momentum_limit_n_m_s = 5, \
        momentum_n_m_s = 0.5 }, { axis_body = [0, 1, 0] }, { axis_body = [0, 0, 1] }]";
    let plan = |more: &[&str]| folder.slew(&[&["plan", "spec.toml", "--set", wheels], more].concat());
    let run =
        plan(&["-v", "-o", "plan.json"]).ends(0).tells("peak wheel momentum ").tells("\n  momentum    roll ");
    let named = |line: &str| line.contains("wheel momentum limit  margin ") && line.ends_with(", roll");
    assert!(run.stderr.lines().any(named), "{}", run.stderr);
    let told = folder.slew(&["verify", "plan.json"]).ends(0);
    assert!(told.stderr.lines().any(named), "{}", told.stderr);
    let json = folder.json("plan.json");
    assert_eq!(json["trajectory"]["wheel_momentum_n_m_s"][0], serde_json::json!([0.5, 0.0, 0.0]));
    assert_eq!(json["trajectory"]["wheel_momentum_n_m_s"].as_array().unwrap().len(), 101);
    let table = plan(&["-q", "--format", "csv"]).ends(0);
    assert!(table.stdout.lines().next().unwrap().contains("wheel_momentum_wheel 3_n_m_s"));
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

/// The steps are far too long for a body that falls over: every method ends with a message, and no
/// answer has a cost without a value.
#[test]
fn steps_that_are_far_too_long_end_in_words() {
    let folder = Folder::new();
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/unstable_pendulum_long.toml");
    let roads: [&[&str]; 4] = [
        &["plan"],
        &["plan", "--set", "solver.method=scp"],
        &["plan", "--set", "actuators.torque_rate_limit_n_m_per_s=1"],
        &["compare"],
    ];
    for steps in ["2", "10", "12"] {
        for road in roads {
            let steps = format!("maneuver.steps={steps}");
            let args = [road, &[spec, "--format", "json", "--set", &steps]].concat();
            let run = folder.slew(&args);
            assert!(
                [0, 4, 5, 6, 7].contains(&run.code) && !run.stderr.contains("panicked"),
                "{args:?}: {}",
                run.stderr
            );
            // A number that is not finite is null in JSON; the trajectory may have stopped before
            // its end.
            let json = run.json();
            assert!(run.code != 0 || road[0] == "compare" || json["cost"].is_f64(), "{args:?}");
        }
    }
}

/// A station that yaws by 90° in the frame of its orbit: on the hundred steps with which the choice
/// begins the true motion of the discrete optimum ends a hundred degrees off. Everything that is
/// written is on the grid that was chosen.
#[test]
fn a_plan_on_chosen_steps_lands_and_is_written_on_its_own_grid() {
    let folder = Folder::new();
    let spec = r#"
        format = 1
        [body]
        inertia_kg_m2 = [[128e6, 3e6, -5e6], [3e6, 107e6, 1e6], [-5e6, 1e6, 201e6]]
        [start]
        attitude = { axis = [0, 0, 1], angle_deg = 0 }
        angular_velocity_rad_s = [0, 0.0011, 0]
        [end]
        attitude = { axis = [0, 0, 1], angle_deg = 90 }
        angular_velocity_rad_s = [0.0011, 0, 0]
        [environment]
        kind = "gravity_gradient"
        orbital_rate_rad_s = 0.0011
        [maneuver]
        duration_s = 5400
    "#;
    fs::write(folder.path("station.toml"), spec).unwrap();
    let run =
        folder.slew(&["plan", "station.toml", "-v", "-o", "plan.json"]).ends(0).tells("solved and verified");
    run.tells("\n  landing ").tells("\n  steps ").tells(" chosen, from 100 upwards: the true motion lands");
    let plan = folder.json("plan.json");
    let steps = plan["steps"].as_u64().unwrap();
    assert!(steps > 100 && plan["spec"]["maneuver"]["steps"].as_u64() == Some(steps));
    assert!(plan["verified"]["continuous_attitude_rad"].as_f64().unwrap() < 1e-6);
    folder.slew(&["verify", "plan.json"]).ends(0).tells("verified");
    folder.slew(&["verify", "plan.json", "--spec", "station.toml"]).ends(0).tells("verified");
    folder.slew(&["export", "plan.json", "-q", "-o", "rows.csv"]).ends(0);
    assert_eq!(
        folder.read("rows.csv").lines().filter(|line| !line.starts_with('#')).count() as u64,
        steps + 2
    );
    let again =
        ["plan", "station.toml", "-q", "--set", &format!("maneuver.steps={steps}"), "-o", "given.json"];
    folder.slew(&again).ends(0);
    let given = folder.json("given.json");
    assert!(given.get("chosen").is_none() && given["cost"] == plan["cost"]);
}

/// Infeasible specs give a reason and a command to type, within a screen.
#[test]
fn summaries_of_what_is_infeasible_fit_a_screen() {
    let folder = Folder::new();
    for name in ["infeasible_cones", "infeasible_rate", "infeasible_torque", "infeasible_wheels"] {
        let path = format!("problems/{name}.toml");
        let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems");
        fs::create_dir_all(folder.path("problems")).unwrap();
        fs::copy(format!("{shipped}/{name}.toml"), folder.path(&path)).unwrap();
        let run =
            folder.slew(&["plan", &path]).ends(4).tells("infeasible").tells("\n  because ").tells("\n  try ");
        assert!(run.stderr.lines().count() <= 12, "{}", run.stderr);
        for line in run.stderr.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }
}

/// A command to try is one that a shell takes, on one line or two.
#[test]
fn a_long_command_to_try_goes_on_in_the_next_line() {
    let folder = Folder::new();
    let long = "a_spec_with_a_name_that_is_as_long_as_a_line.toml";
    fs::copy(folder.path("spec.toml"), folder.path(long)).unwrap();
    let set = ["--set", "actuators.torque_limit_n_m=0.01"];
    let run = folder.slew(&["plan", long, set[0], set[1]]).ends(4);
    let told = run.stderr.split("try         ").nth(1).unwrap();
    let words: Vec<&str> =
        told.split('#').next().unwrap().split_whitespace().filter(|word| *word != "\\").collect();
    assert_eq!(words[..3], ["slew", "plan", long]);
    // The command runs with the duration that it states, which need not suffice.
    let again = folder.slew(&[&words[1..], &["--format", "json"]].concat());
    assert!([0, 5].contains(&again.code), "{}", again.stderr);
    let advised = words.iter().find_map(|word| word.strip_prefix("maneuver.duration_s=")).unwrap();
    assert_eq!(again.json()["duration_s"].as_f64(), advised.parse().ok());
}

/// Returns the state of a row of a trajectory as keys of a spec, turned by an angle about the
/// body's first axis.
fn started(plan: &Value, row: usize, turn: f64) -> [String; 4] {
    let trajectory = &plan["trajectory"];
    let number = |key: &str, index: usize| trajectory[key][row][index].as_f64().unwrap();
    let [w, x, y, z] = std::array::from_fn(|index| number("quaternion_wxyz", index));
    let (s, c) = (0.5 * turn).sin_cos();
    let turned = [w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s];
    let rate: [f64; 3] = std::array::from_fn(|index| number("angular_velocity_rad_s", index));
    [
        "--set".into(),
        format!("start.attitude={{ quaternion_wxyz = {turned:?} }}"),
        "--set".into(),
        format!("start.angular_velocity_rad_s={rate:?}"),
    ]
}

/// Claim: the rest of a plan file is planned again from a state near it in a few steps, by the
/// witnesses, with the cost of a cold search; and the file that this writes can be replanned in
/// turn.
#[test]
fn what_is_left_of_a_plan_is_planned_again() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    let first = folder.json("plan.json");
    let duration = first["trajectory"]["time_s"].as_array().unwrap().last().unwrap().as_f64().unwrap();
    let steps = first["steps"].as_u64().unwrap() as usize;
    let row = steps * 2 / 5;
    let at = first["trajectory"]["time_s"][row].as_f64().unwrap().to_string();
    let set = started(&first, row, 0.01);
    let set: Vec<&str> = set.iter().map(String::as_str).collect();
    let warm =
        [&["plan", "spec.toml", "--warm", "plan.json", "--at", &at, "-o", "rest.json"], &set[..]].concat();
    folder.slew(&warm).ends(0).tells("Newton step").tells(&format!("from plan.json at {at} s"));
    let rest = folder.json("rest.json");
    assert_eq!((rest["steps"].as_u64().unwrap() as usize, &rest["start"]), (steps - row, &"warm".into()));
    let left = duration - first["trajectory"]["time_s"][row].as_f64().unwrap();
    assert!((rest["spec"]["maneuver"]["duration_s"].as_f64().unwrap() - left).abs() < 1e-9);
    folder.slew(&["verify", "rest.json"]).ends(0);

    let (left, steps) = (format!("maneuver.duration_s={left}"), format!("maneuver.steps={}", steps - row));
    let cold = ["plan", "spec.toml", "-q", "--format", "json", "--set", &left, "--set", &steps];
    let cold = folder.slew(&[&cold[..], &set].concat()).ends(0).json();
    let cost = |plan: &Value| plan["cost"].as_f64().unwrap();
    assert!((cost(&rest) / cost(&cold) - 1.0).abs() < 1e-9, "{} {}", cost(&rest), cost(&cold));

    let set = started(&rest, 3, -0.005);
    let set: Vec<&str> = set.iter().map(String::as_str).collect();
    let at = rest["trajectory"]["time_s"][3].as_f64().unwrap().to_string();
    let again =
        [&["plan", "spec.toml", "-q", "--format", "json", "--warm", "rest.json", "--at", &at], &set[..]];
    let again = [&again.concat()[..], &["--set", &left, "--set", &steps]].concat();
    assert_eq!(folder.slew(&again).ends(0).json()["start"], "warm");
}

#[test]
fn a_plan_is_left_where_it_is_too_far_away() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    let far = "start.angular_velocity_deg_s=[150, -170, 160]";
    let args = ["plan", "spec.toml", "--warm", "plan.json", "-o", "far.json", "--set", far];
    let run = folder.slew(&args);
    let run = run.tells("plan.json at 0 s was not used, because").tells("new search");
    assert!(!run.stderr.contains("Newton steps from"), "{}", run.stderr);
    assert_ne!(folder.json("far.json")["start"], "warm");
}

#[test]
fn plans_that_nothing_can_be_begun_from_are_refused() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    let warm = |more: &[&str]| folder.slew(&[&["plan", "spec.toml", "--warm", "plan.json"], more].concat());
    warm(&["--guess", "plan.json"]).ends(2).tells("--guess");
    folder.slew(&["plan", "spec.toml", "--at", "1"]).ends(2).tells("--warm");
    warm(&["--at", "noon"]).ends(2).tells("--at");
    for at in ["-1", "9.9", "1e9", "nan"] {
        warm(&["--at", at]).ends(2).tells("--at").tells("choose a time from 0 to");
    }
    warm(&["--set", "body.inertia_kg_m2=[2, 3, 4]"]).ends(8).tells("E0103").tells("another body");
    warm(&["--set", "maneuver.duration_s=11"])
        .ends(8)
        .tells("E0103")
        .tells("has a duration of 11 s")
        .tells("duration_s");
    warm(&["--set", "maneuver.steps=77"]).ends(8).tells("E0103").tells("77 steps");
    warm(&["--set", "solver.scheme=lie_euler"]).ends(8).tells("E0103").tells("another scheme");
    let missing = folder.slew(&["plan", "spec.toml", "--warm", "missing.json"]);
    missing.ends(8).tells("E0090").tells("missing.json");
    let none = folder.slew(&["plan", "spec.toml", "--warm", "spec.toml"]);
    none.ends(8).tells("E0102");

    let time = folder.slew(&["init", "--for", "time", "-o", "time.toml"]);
    time.ends(0);
    folder.slew(&["plan", "time.toml", "-q", "-o", "time.json"]).ends(0);
    let switching = folder.slew(&["plan", "time.toml", "--warm", "time.json"]);
    switching.ends(8).tells("E0103").tells("switching inputs").tells("without --warm");
}
