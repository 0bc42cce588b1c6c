//! Standard input, output files, pipes, terminals and signals.

use super::binary::{Folder, Run, SPEC};
use slewkit_files::export::PlanFile;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

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
fn quiet_runs_say_that_they_failed() {
    let folder = Folder::new();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0).silent();
    let longer = ["verify", "plan.json", "-q", "--spec", "spec.toml", "--set", "maneuver.duration_s=11"];
    let limit = "actuators.torque_limit_n_m=0.01";
    let too_short = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/found/three_of_four.toml");
    for (words, code, status) in [
        (&["plan", "spec.toml", "-q", "--set", limit][..], 4, "infeasible (exit code 4)"),
        (&["plan", too_short, "-q"], 5, "not_converged (exit code 5)"),
        (&longer, 7, "(exit code 7)"),
    ] {
        let run = folder.slew(words).ends(code).tells(status).tells("run it without --quiet for the reason");
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
}

/// A name that a spreadsheet would take for a formula is a text in every table.
#[test]
fn no_cell_of_a_table_is_a_formula() {
    let folder = Folder::new();
    let named = SPEC.replace("test slew", "=1+1");
    fs::write(folder.path("named.toml"), &named).unwrap();
    let cases = "name,maneuver.duration_s\n\"=HYPERLINK(\"\"a\"\",1)\",20\n@SUM(A1),12\n+1-1,9\n";
    fs::write(folder.path("cases.csv"), cases).unwrap();
    folder.slew(&["batch", "named.toml", "--cases", "cases.csv", "-q", "-o", "all.csv"]).ends(0);
    folder.slew(&["plan", "named.toml", "-q", "-o", "plan.json"]).ends(0);
    folder.slew(&["export", "plan.json", "-o", "plan.csv"]).ends(0);
    for name in ["all.csv", "plan.csv"] {
        let table = folder.read(name);
        let begins = |cell: &str| {
            let cell = cell.trim_start_matches('"');
            cell.starts_with(['=', '@', '+', '-']) && cell.parse::<f64>().is_err()
        };
        assert!(!table.lines().flat_map(|line| line.split(',')).any(begins), "{name}: {table}");
    }
    assert!(folder.read("all.csv").contains("'=HYPERLINK"));
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
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = folder.command(&["--help"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    Run::of(output, &["--help"]).ends(8);
    // The limit on the size of files refuses further output; its signal would kill the program by
    // default.
    let limited = "ulimit -f 8; exec \"$0\" plan spec.toml -o plan.json --set maneuver.steps=2000";
    let args = ["-c", limited, env!("CARGO_BIN_EXE_slew")];
    let output = Command::new("bash").args(args).current_dir(folder.path("")).output().unwrap();
    Run::of(output, &args).ends(8).tells("E0097").tells("no part is kept");
    assert_eq!(folder.names(), ["spec.toml"]);
}

/// Commands that only write handle signals that end a process too, so that they remove their
/// temporary files.
#[cfg(target_os = "linux")]
#[test]
fn commands_that_only_write_sweep_up_when_they_are_ended() {
    let folder = Folder::new();
    let commands: [&[&str]; 3] = [
        &["export", "-", "-o", "table.csv"],
        &["report", "-", "-o", "page.html"],
        &["plot", "-", "-o", "p.svg"],
    ];
    for args in commands.into_iter().filter(|_| !super::binary::is_ignored("-TERM")) {
        // The plan does not come: there is time to be ended in.
        let mut command = folder.command(args);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let unfinished = child.stdin.take();
        let began = std::time::Instant::now();
        while !super::binary::catches(child.id(), "-TERM") {
            assert!(began.elapsed().as_secs() < 60, "{args:?}: SIGTERM is not taken over");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        Run::of(child.wait_with_output().unwrap(), args).ends(130);
        drop(unfinished);
        assert_eq!(folder.names(), ["spec.toml"]);
    }
}

/// A user who may start a few threads, but fewer than processors exist.
#[cfg(target_os = "linux")]
#[test]
fn too_few_threads_are_enough() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    fs::set_permissions(folder.path(""), fs::Permissions::from_mode(0o777)).unwrap();
    let line = "ulimit -u \"$1\"; exec \"$0\" plan spec.toml -q --format json --set maneuver.steps=2000";
    let run = |threads: &str| {
        // The limit does not hold for root.
        let user = ["--reuid", "64990", "--regid", "64990", "--clear-groups", "bash", "-c", line];
        let slew = env!("CARGO_BIN_EXE_slew");
        let output =
            Command::new("setpriv").args(user).args([slew, threads]).current_dir(folder.path("")).output();
        output.ok().map(|output| Run::of(output, &[threads]))
    };
    // Only root can become another user, and not every user can read the binary.
    if run("unlimited").is_none_or(|run| run.code != 0) {
        eprintln!("skipped: no other user to be");
        return;
    }
    for threads in ["1", "2", "3", "4", "5", "6"] {
        let run = run(threads).unwrap().ends(0);
        assert_eq!(run.json()["status"], "solved", "{threads} threads");
    }
}

#[test]
fn no_terminal_obeys_what_was_typed() {
    let folder = Folder::new();
    for typed in ["b\u{202e}ad", "b\u{1b}[2Jad"] {
        for args in [&["plan", "spec.toml", "--format", typed][..], &["plan", &format!("--{typed}")]] {
            let run = folder.slew(args).ends(2).tells("ad");
            assert!(!run.stderr.contains(['\u{202e}', '\u{1b}']), "{:?}", run.stderr);
        }
    }
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_protected_files_stay() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    fs::create_dir(folder.path("archive")).unwrap();
    fs::write(folder.path("archive/old.json"), "old").unwrap();
    symlink("archive/old.json", folder.path("latest.json")).unwrap();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "latest.json", "--force"]).ends(0).silent();
    assert!(fs::symlink_metadata(folder.path("latest.json")).unwrap().is_symlink());
    assert_eq!(folder.json("archive/old.json")["status"], "solved");
    symlink("nowhere.json", folder.path("dangling.json")).unwrap();
    // A link to a missing file is refused with --force and without.
    for force in [&["--force"][..], &[]] {
        folder.slew(&[&["plan", "spec.toml", "-o", "dangling.json"], force].concat()).ends(8).tells("E0099");
    }

    fs::write(folder.path("kept.json"), "kept").unwrap();
    let mut permissions = fs::metadata(folder.path("kept.json")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("kept.json"), permissions).unwrap();
    folder
        .slew(&["plan", "spec.toml", "-o", "kept.json", "--force"])
        .ends(8)
        .tells("E0096")
        .tells("protected");
    folder.slew(&["plan", "spec.toml", "-o", "kept.json"]).ends(8).tells("E0096");
    assert_eq!(folder.read("kept.json"), "kept");
}

/// The files that a killed program has left are removed; a running program keeps its own files.
#[test]
fn old_temporary_files_are_swept() {
    let folder = Folder::new();
    let (old, new) = (folder.path(".slew-Abc123"), folder.path(".slew-Def456"));
    fs::write(&old, "half").unwrap();
    fs::write(&new, "half").unwrap();
    fs::write(folder.path(".slew-notes"), "mine").unwrap();
    let two_days_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(2 * 86_400);
    for path in [&old, &folder.path(".slew-notes")] {
        fs::File::options().write(true).open(path).unwrap().set_modified(two_days_ago).unwrap();
    }
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    assert_eq!(folder.names(), [".slew-Def456", ".slew-notes", "plan.json", "spec.toml"]);
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
    let hidden = ["\\u2028", "\\u2029", "\\u202E", "\\u200B", "\\u061C", "\\uFEFF", "\\U000E0041"];
    fs::write(folder.path("bidi.toml"), SPEC.replace("test slew", &hidden.join("x"))).unwrap();
    let run = folder.slew(&["plan", "bidi.toml"]).ends(0).tells("u{2028}").tells("u{e0041}");
    assert!(
        run.stderr.chars().all(|c| !"\u{2028}\u{2029}\u{202e}\u{200b}\u{61c}\u{feff}\u{e0041}".contains(c))
    );
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
        "maneuver.steps=20000",
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
