//! Faults of a batch are reported before the first case is planned, with their place.

use super::binary::Folder;
use std::fs;

/// A table, where the message points, the code, and part of the reason and the remedy.
const TABLES: [(&str, &str, &str, &str); 17] = [
    ("", "cases.csv:1:1", "E0116", "the file is empty"),
    ("\n\n  \n", "cases.csv:1:1", "E0116", "the file is empty"),
    ("maneuver.duration_s\n", "cases.csv:1:1", "E0116", "a header but no cases"),
    ("name,maneuver.duration\na,10\n", "cases.csv:1:6", "E0020", "did you mean `maneuver.duration_s`?"),
    ("manoeuvre.duration_s\n10\n", "cases.csv:1:1", "E0020", "unknown key `manoeuvre` in the spec"),
    ("duration_s\n10\n", "cases.csv:1:1", "E0020", "`duration_s` belongs in [maneuver]"),
    ("maneuver.duration_s,name\n10\n", "cases.csv:2:1", "E0116", "the row has 1 cells, but the header has 2"),
    ("body.inertia_kg_m2\n[1, 2, 3]\n", "cases.csv:2:1", "E0116", "needs quotes"),
    ("maneuver.duration_s\n10\n\nten\n", "cases.csv:4:1", "E0024", "`duration_s`"),
    ("name,maneuver.duration_s\na, -3\n", "cases.csv:2:4", "E0032", "a time of -3 s is impossible"),
    ("maneuver.duration_s\nnan\n", "cases.csv:2:1", "E0030", "nan"),
    ("name,maneuver.steps\na,10\nb,20\na,30\n", "cases.csv:4:1", "E0011", "two cases have the name `a`"),
    (
        "name,body.inertia_kg_m2\na,\"[1,2,3]\nb,\"[1,2]\"\n",
        "cases.csv:2:1",
        "E0116",
        "not closed on its line",
    ),
    ("body.inertia_kg_m2\n\"[1,2]\"\n", "cases.csv:2:2", "E0026", "has 2 entries, and needs 3"),
    ("end.attitude.euler_zyx_deg.3\n1\n", "cases.csv:1:1", "E0025", "has 3 elements: `3` is not one of them"),
    (
        "constraint.0.half_angle_deg\n1\n",
        "cases.csv:1:1",
        "E0025",
        "`constraint` has 0 elements: `0` is not one of them",
    ),
    ("maneuver.steps\n12.5\n", "cases.csv:2:1", "E0035", "12.5 is not a whole number"),
];

#[test]
fn tables_are_judged_whole_before_any_case() {
    let folder = Folder::new();
    for (table, place, code, reason) in TABLES {
        fs::write(folder.path("cases.csv"), table).unwrap();
        let run = folder.slew(&["batch", "spec.toml", "--cases", "cases.csv", "-o", "all.jsonl"]).ends(3);
        assert!(run.stderr.contains(reason), "{table:?}: {}", run.stderr);
        run.tells(&format!("{place}: error[{code}]"));
        assert!(!folder.path("all.jsonl").exists(), "{table:?}");
    }
    // All at once, a hundred at most.
    let many: String = (0..300).map(|row| format!("-{row}1\n")).collect();
    fs::write(folder.path("cases.csv"), format!("maneuver.duration_s\n{many}")).unwrap();
    let run = folder.slew(&["batch", "spec.toml", "--cases", "cases.csv"]).ends(3).tells("100 errors");
    assert!(run.stderr.contains("cases.csv:2:1") && run.stderr.contains("cases.csv:101:1"));
    fs::write(folder.path("cases.csv"), "maneuver.duration_s,maneuver.duration_s\n1,2\n").unwrap();
    folder.slew(&["batch", "spec.toml", "--cases", "cases.csv"]).ends(2).tells("E0011").tells("set twice");
    fs::write(folder.path("cases.csv"), "end.attitude,end.attitude.axis\n1,2\n").unwrap();
    folder.slew(&["batch", "spec.toml", "--cases", "cases.csv"]).ends(2).tells("`end.attitude` also sets");
    fs::write(folder.path("cases.csv"), [b"maneuver.duration_s\n\xff\n".as_slice()].concat()).unwrap();
    folder.slew(&["batch", "spec.toml", "--cases", "cases.csv"]).ends(3).tells("cases.csv:2:1: error[E0002]");
}

#[test]
fn senseless_arguments_are_refused() {
    let folder = Folder::new();
    fs::write(folder.path("cases.csv"), "maneuver.duration_s\n10\n").unwrap();
    fs::create_dir(folder.path("empty")).unwrap();
    let batch =
        |more: &[&str]| folder.slew(&[&["batch", "spec.toml", "--cases", "cases.csv"], more].concat());
    for (shard, why) in [
        ("5/4", "shard 5 of 4 does not exist"),
        ("0/4", "shards count from 1"),
        ("1/0", "the number of shards is 0"),
        ("0/0", "the number of shards is 0"),
        ("x", "does not have the form i/n"),
        ("1/1000000", "too many"),
    ] {
        batch(&["--shard", shard]).ends(2).tells("error[E0111]").tells(why);
    }
    for threads in ["0", "1000000000"] {
        batch(&["--threads", threads]).ends(2).tells("error[E0115]");
    }
    batch(&["-o", "no/such/folder.jsonl"]).ends(8).tells("error[E0095]");
    batch(&["-o", "empty"]).ends(8).tells("error[E0099]");
    batch(&["--set", "maneuver.step=3"]).ends(9).tells("1 spec invalid");
    folder.slew(&["batch", "spec.toml"]).ends(2).tells("a batch needs more than one spec");
    folder.slew(&["batch", "empty"]).ends(8).tells("error[E0116]").tells("holds no spec");
    folder.slew(&["batch", "nowhere"]).ends(2);
    folder.slew(&["batch", "nowhere.toml", "--cases", "cases.csv"]).ends(8).tells("error[E0015]");
    folder.slew(&["batch", "spec.toml", "--cases", "nowhere.csv"]).ends(8).tells("error[E0090]");
    folder.slew(&["batch", "spec.toml", "--cases", "empty"]).ends(8);
    folder.slew(&["batch", "spec.toml", "--cases", "-"]).ends(2).tells("read twice");
    for (over, code, why) in [
        ("maneuver.duration_s", "E0110", "has no `=`"),
        ("maneuver.duration_s=20:200:0", "E0110", "has no values"),
        ("maneuver.duration_s=20:200:1", "E0110", "one value cannot be both"),
        ("maneuver.duration_s=a:200:3", "E0110", "does not begin with two numbers"),
        ("maneuver.duration_s=1:2:99999999999", "E0034", "the limit is 10000000"),
    ] {
        folder
            .slew(&["sweep", "spec.toml", "--over", over])
            .ends(2)
            .tells(&format!("error[{code}]"))
            .tells(why);
    }
    folder.slew(&["sweep", "spec.toml", "--over", "maneuver.duraton_s=1:2:3"]).ends(3).tells("did you mean");
    folder
        .slew(&["sweep", "spec.toml", "--over", "maneuver.duration_s=-1:2:3"])
        .ends(3)
        .tells("error[E0032]");
    folder.slew(&["sweep", "spec.toml", "--over", "maneuver.steps=10:21:3"]).ends(3).tells("error[E0035]");
    folder.slew(&["sweep", "spec.toml"]).ends(2);
    let grid = ["--over", "maneuver.duration_s=1:2:5000", "--over", "solver.tolerance=1e-9:1e-8:5000"];
    folder.slew(&[&["sweep", "spec.toml"], grid.as_slice()].concat()).ends(2).tells("25000000 cases");
}

#[test]
fn a_file_in_use_or_write_protected_is_refused() {
    let folder = Folder::new();
    let command = ["sweep", "spec.toml", "--over", "maneuver.duration_s=10:20:3", "-q", "-o", "all.jsonl"];
    let held = fs::File::create(folder.path("all.jsonl")).unwrap();
    held.lock().unwrap();
    folder.slew(&command).ends(8).tells("error[E0118]").tells("another process");
    drop(held);
    let mut permissions = fs::metadata(folder.path("all.jsonl")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("all.jsonl"), permissions).unwrap();
    folder.slew(&command).ends(8).tells("error[E0096]").tells("write-protected");
}

/// The system refuses output beyond a limit of the file size, like a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_what_is_finished() {
    let folder = Folder::new();
    let over = "maneuver.duration_s=10:20:30";
    folder.slew(&["sweep", "spec.toml", "--over", over, "-q", "-o", "whole.jsonl"]).ends(0);
    let slew = env!("CARGO_BIN_EXE_slew");
    let limited = format!("ulimit -f 4; exec {slew} sweep spec.toml --over {over} -q -o all.jsonl");
    let mut shell = std::process::Command::new("bash");
    let output = shell.args(["-c", &limited]).current_dir(folder.path(".")).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(8), "{told}");
    assert!(told.contains("error[E0097]") && told.contains("finished cases are kept"), "{told}");
    let kept = folder.read("all.jsonl");
    assert!(
        kept.ends_with('\n') && kept.lines().count() > 2 && folder.read("whole.jsonl").starts_with(&kept)
    );
    folder.slew(&["sweep", "spec.toml", "--over", over, "-q", "-o", "all.jsonl"]).ends(0);
    assert_eq!(folder.read("all.jsonl"), folder.read("whole.jsonl"));
}

#[test]
fn no_output_is_an_input_and_no_plan_file_is_replaced_unasked() {
    let folder = Folder::new();
    let table = "maneuver.duration_s\n10\n12\n";
    fs::write(folder.path("cases.csv"), table).unwrap();
    let spec = folder.read("spec.toml");
    let batch =
        |more: &[&str]| folder.slew(&[&["batch", "spec.toml", "--cases", "cases.csv", "-q"], more].concat());
    batch(&["-o", "cases.csv", "--force"]).ends(8).tells("E0100").tells("is also an input");
    let over = ["--over", "maneuver.duration_s=10,12"];
    folder
        .slew(&[&["sweep", "spec.toml", "-o", "spec.toml", "--force"], &over[..]].concat())
        .ends(8)
        .tells("E0100");
    assert_eq!((folder.read("cases.csv"), folder.read("spec.toml")), (table.into(), spec.clone()));
    // A folder of specs is no folder of their plans, and a file there is not the batch's own.
    fs::create_dir(folder.path("specs")).unwrap();
    fs::write(folder.path("specs/case-1.toml"), &spec).unwrap();
    folder.slew(&["batch", "specs", "--plans", "specs", "-q"]).ends(8).tells("E0100");
    fs::create_dir(folder.path("plans")).unwrap();
    fs::write(folder.path("plans/case-2.json"), "mine").unwrap();
    batch(&["--plans", "plans"]).ends(8).tells("E0098").tells("case-2.json");
    assert_eq!(folder.read("plans/case-2.json"), "mine");
    batch(&["--plans", "plans", "--force"]).ends(0);
    assert!(folder.read("plans/case-2.json").contains("\"status\": \"solved\""));
    // A continued run replaces the line that a kill truncated.
    batch(&["-o", "all.jsonl", "--plans", "more"]).ends(0);
    let half: Vec<String> =
        folder.read("all.jsonl").lines().take(2).map(|line| format!("{line}\n")).collect();
    fs::write(folder.path("all.jsonl"), half.concat()).unwrap();
    batch(&["-o", "all.jsonl", "--plans", "more"]).ends(0);
}

/// The table of a run that is under way is changed as soon as that has its first result.
#[test]
fn a_table_that_changes_meanwhile_is_told() {
    let folder = Folder::new();
    // Rows of 30 signs, so that few of them are more than a buffer of the reader.
    let rows = |duration: u32, count: usize| {
        format!("maneuver.duration_s\n{}", format!("{duration}.{:026}\n", 0).repeat(count))
    };
    for (count, after) in [(400, 400), (400, 300), (400, 500)] {
        fs::write(folder.path("cases.csv"), rows(60, count)).unwrap();
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_slew"));
        run.args(["batch", "spec.toml", "--cases", "cases.csv", "-o", "all.jsonl", "--force", "-q"]);
        run.args(["--set", "maneuver.steps=8"]).current_dir(folder.path("."));
        let run = run.stderr(std::process::Stdio::piped()).spawn().unwrap();
        while fs::read_to_string(folder.path("all.jsonl")).map_or(0, |text| text.lines().count()) < 2 {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        fs::write(folder.path("cases.csv"), rows(90, after)).unwrap();
        let output = run.wait_with_output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{told}");
        assert!(told.contains("the table changed while its cases were planned"), "{told}");
        fs::remove_file(folder.path("all.jsonl")).unwrap();
    }
}

#[test]
fn the_command_that_plans_a_case_again_does_so() {
    let folder = Folder::new();
    fs::rename(folder.path("spec.toml"), folder.path("spec.txt")).unwrap();
    let sweep = ["sweep", "spec.txt", "--input", "toml", "--over", "maneuver.duration_s=10,12"];
    folder
        .slew(&sweep)
        .ends(0)
        .tells("slew sweep spec.txt --over maneuver.duration_s=10,12 --input toml --case 1");
    folder.slew(&[&sweep[..], &["--case", "1", "-o", "plan.json"]].concat()).ends(0);
}
