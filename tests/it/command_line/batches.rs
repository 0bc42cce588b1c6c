//! `slew batch`, `slew sweep`, `slew merge`: the same bytes however the work was divided or
//! interrupted.

use super::binary::{Folder, Run};
use serde_json::Value;
use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

const CASES: &str = "\
name,maneuver.duration_s,start.angular_velocity_deg_s
first,20,\"[0, 0, 0]\"
second,12.5,
,8,\"[1, 0, -2]\"
last,10,\"[0, 0, 1.5]\"
";

/// A grid that takes a second or so.
const GRID: [&str; 4] = ["sweep", "spec.toml", "--over", "maneuver.duration_s=6:30:49"];

fn with<'a>(command: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [command, more].concat()
}

/// Returns the lines of a file of results, the header first.
fn lines(folder: &Folder, name: &str) -> Vec<Value> {
    folder.read(name).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn a_table_gives_each_row_the_plan_that_set_gives() {
    let folder = Folder::new();
    fs::write(folder.path("cases.csv"), CASES).unwrap();
    let run = folder.slew(&["batch", "spec.toml", "--cases", "cases.csv", "-o", "all.jsonl"]).ends(0);
    run.tells("spec.toml, table of 4 cases").tells("all 4 solved and verified").tells("costliest   case ");
    let lines = lines(&folder, "all.jsonl");
    let header = &lines[0];
    assert_eq!(
        (&header["slew_results"], &header["cases"], &header["kind"]),
        (&1.into(), &4.into(), &"table".into())
    );
    assert_eq!(header["keys"], serde_json::json!(["maneuver.duration_s", "start.angular_velocity_deg_s"]));
    let sets: [&[&str]; 4] = [
        &["--set", "maneuver.duration_s=20", "--set", "start.angular_velocity_deg_s=[0, 0, 0]"],
        &["--set", "maneuver.duration_s=12.5"],
        &["--set", "maneuver.duration_s=8", "--set", "start.angular_velocity_deg_s=[1, 0, -2]"],
        &["--set", "maneuver.duration_s=10", "--set", "start.angular_velocity_deg_s=[0, 0, 1.5]"],
    ];
    for (index, set) in sets.into_iter().enumerate() {
        let line = &lines[index + 1];
        assert_eq!(line["case"], index + 1);
        let plan = folder.slew(&with(&["plan", "spec.toml", "-q", "--format", "json"], set)).ends(0).json();
        for key in [
            "status",
            "exit_code",
            "cost",
            "duration_s",
            "steps",
            "method",
            "iterations",
            "sense",
            "terminal",
            "second_order",
        ] {
            assert_eq!(line[key], plan[key], "case {}: {key}", index + 1);
        }
        assert_eq!(line["verified"]["passed"], true);
        assert_eq!(line["verified"]["discrete_attitude_rad"], plan["verified"]["discrete_attitude_rad"]);
    }
    let names: Vec<&Value> = lines[1..].iter().map(|line| &line["name"]).collect();
    assert_eq!(names, [&"first".into(), &"second".into(), &Value::Null, &"last".into()]);
    assert_eq!(
        lines[2]["set"],
        serde_json::json!({ "maneuver.duration_s": 12.5 }),
        "an empty cell sets nothing"
    );
    // A single case of a batch equals the plan of `slew plan`.
    let case = ["batch", "spec.toml", "--cases", "cases.csv", "--case", "3", "-o", "third.json"];
    folder.slew(&case).ends(0).tells("solved and verified");
    assert_eq!(folder.json("third.json")["cost"], lines[3]["cost"]);
    folder
        .slew(&["batch", "spec.toml", "--cases", "cases.csv", "--case", "5"])
        .ends(2)
        .tells("case 5 does not exist");
}

#[test]
fn a_folder_gives_each_spec_its_plan() {
    let folder = Folder::new();
    fs::create_dir(folder.path("specs")).unwrap();
    let spec = folder.read("spec.toml");
    fs::write(folder.path("specs/b.toml"), spec.replace("duration_s = 10", "duration_s = 14")).unwrap();
    fs::write(folder.path("specs/a.toml"), &spec).unwrap();
    fs::write(folder.path("specs/c.toml"), spec.replace("duration_s = 10", "duration_s = -14")).unwrap();
    fs::write(folder.path("specs/notes.txt"), "no spec").unwrap();
    let run =
        folder.slew(&["batch", "specs", "--set", "maneuver.steps=60", "-o", "all.jsonl", "--plans", "plans"]);
    run.ends(9).tells("2 of 3 solved").tells("1 spec invalid: case 3").tells("1 × E0032");
    let lines = lines(&folder, "all.jsonl");
    let names: Vec<&Value> = lines[1..].iter().map(|line| &line["name"]).collect();
    assert_eq!(names, ["a.toml", "b.toml", "c.toml"]);
    assert_eq!(
        (&lines[1]["steps"], &lines[1]["duration_s"], &lines[2]["duration_s"]),
        (&60.into(), &10.0.into(), &14.0.into())
    );
    let error = &lines[3]["error"];
    assert_eq!((&error["code"], &error["key"]), (&"E0032".into(), &"maneuver.duration_s".into()));
    let plan = folder.json("plans/case-2.json");
    assert_eq!(plan["cost"], lines[2]["cost"]);
    assert!(!folder.path("plans/case-3.json").exists());
    folder.slew(&["verify", "plans/case-1.json"]).ends(0);
}

#[test]
fn grids_are_in_the_order_that_help_tells() {
    let folder = Folder::new();
    let over = ["--over", "maneuver.duration_s=10:20:2", "--over", "maneuver.path=\"shortest\",long"];
    folder.slew(&with(&with(&["sweep", "spec.toml"], &over), &["-o", "all.jsonl"])).ends(0);
    let lines = lines(&folder, "all.jsonl");
    let sets: Vec<(f64, &str)> = lines[1..]
        .iter()
        .map(|line| (line["set"]["maneuver.duration_s"].as_f64().unwrap(), line["sense"].as_str().unwrap()))
        .collect();
    assert_eq!(sets, [(10.0, "short"), (10.0, "long"), (20.0, "short"), (20.0, "long")]);
    // The cost of a free slew from rest to rest falls as the cube of the time.
    let cost = |index: usize| lines[index]["cost"].as_f64().unwrap();
    assert!((cost(1) / cost(3) - 8.0).abs() < 1e-6, "{}", cost(1) / cost(3));
}

#[test]
fn threads_shards_and_stdout_give_the_same_bytes() {
    let folder = Folder::new();
    folder.slew(&with(&GRID, &["-q", "--threads", "1", "-o", "one.jsonl"])).ends(0).silent();
    let whole = folder.read("one.jsonl");
    assert_eq!(whole.lines().count(), 50);
    folder.slew(&with(&GRID, &["-q", "--threads", "7", "-o", "seven.jsonl"])).ends(0);
    assert_eq!(folder.read("seven.jsonl"), whole);
    assert_eq!(folder.slew(&with(&GRID, &["-q", "-o", "-"])).ends(0).stdout, whole);
    assert_eq!(folder.slew(&with(&GRID, &["-q"])).ends(0).stdout, "", "nobody asked for it");
    for shard in 1..=3 {
        let (shard, part) = (format!("{shard}/3"), format!("part{shard}.jsonl"));
        folder.slew(&with(&GRID, &["-q", "--shard", &shard, "-o", &part])).ends(0);
    }
    folder
        .slew(&["merge", "part3.jsonl", "part1.jsonl", "part2.jsonl", "-o", "all.jsonl"])
        .ends(0)
        .tells("49 cases");
    assert_eq!(folder.read("all.jsonl"), whole);
    // `merge` copies a file that is already complete.
    folder.slew(&["merge", "one.jsonl", "-o", "copy.jsonl"]).ends(0);
    assert_eq!(folder.read("copy.jsonl"), whole);
    // And a file that is complete is left as it is.
    folder.slew(&with(&GRID, &["-o", "one.jsonl"])).ends(0).tells("after 49 cases that were there");
    assert_eq!(folder.read("one.jsonl"), whole);
}

#[test]
fn merge_refuses_what_is_not_whole_and_names_it() {
    let folder = Folder::new();
    let grid = ["sweep", "spec.toml", "--over", "maneuver.duration_s=10:20:7", "-q"];
    let other = ["sweep", "spec.toml", "--over", "maneuver.duration_s=10:21:7", "-q"];
    for (command, shard, name) in [
        (grid, "1/3", "a"),
        (grid, "2/3", "b"),
        (grid, "3/3", "c"),
        (grid, "1/2", "half"),
        (other, "2/3", "other"),
    ] {
        folder.slew(&with(&command, &["--shard", shard, "-o", &format!("{name}.jsonl")])).ends(0);
    }
    let text = folder.read("c.jsonl");
    let cut = text.lines().take(2).collect::<Vec<_>>().join("\n") + "\n";
    fs::write(folder.path("cut.jsonl"), &cut).unwrap();
    fs::write(folder.path("torn.jsonl"), &text[..text.len() - 10]).unwrap();
    fs::write(folder.path("empty.jsonl"), "").unwrap();
    let refused = |files: &[&str], code: &str, why: &str| {
        let command = with(&with(&["merge"], files), &["-o", "all.jsonl"]);
        folder.slew(&command).ends(8).tells(&format!("error[{code}]")).tells(why);
        assert!(!folder.path("all.jsonl").exists());
    };
    refused(&["a.jsonl", "b.jsonl"], "E0117", "missing: shard 3/3");
    refused(&["a.jsonl", "b.jsonl", "b.jsonl", "c.jsonl"], "E0117", "both shard 2/3");
    refused(&["a.jsonl", "other.jsonl", "c.jsonl"], "E0117", "different batches");
    refused(&["a.jsonl", "half.jsonl"], "E0117", "shard 1/2");
    refused(&["a.jsonl", "b.jsonl", "cut.jsonl"], "E0117", "cut.jsonl lacks case 6");
    refused(&["a.jsonl", "b.jsonl", "torn.jsonl"], "E0117", "torn.jsonl lacks case 6");
    refused(&["a.jsonl", "b.jsonl", "empty.jsonl"], "E0112", "is not a file of results");
    refused(&["a.jsonl", "b.jsonl", "none.jsonl"], "E0090", "none.jsonl");
    refused(&["spec.toml"], "E0112", "is not a file of results");
    folder.slew(&["merge", "a.jsonl", "-o", "a.jsonl", "--force"]).ends(8).tells("E0100");
}

/// Runs are killed at different moments and continued: no case is lost or doubled.
#[test]
fn killed_runs_go_on_to_the_same_bytes() {
    // So many cases that there is something left after some kills.
    const LONG: [&str; 4] = ["sweep", "spec.toml", "--over", "maneuver.duration_s=6:30:799"];
    let folder = Folder::new();
    folder.slew(&with(&LONG, &["-q", "-o", "whole.jsonl"])).ends(0);
    let whole = folder.read("whole.jsonl");
    let began = Instant::now();
    let mut kills = 0;
    for attempt in 0..40_u64 {
        let args = with(&LONG, &["-q", "-o", "killed.jsonl", "--threads", "3"]);
        let mut child = folder.command(&args).stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(20 + 37 * attempt % 170));
        let ended = child.try_wait().unwrap().is_some();
        // The process cannot react to SIGKILL.
        child.kill().unwrap();
        child.wait().unwrap();
        let text = fs::read_to_string(folder.path("killed.jsonl")).unwrap_or_default();
        assert!(whole.starts_with(&text), "after {attempt} kills: {text}");
        if ended && text == whole {
            break;
        }
        kills += 1;
        // A line that was cut in the middle, as a crash of the machine may leave it.
        if text.len() > 100 && attempt % 2 == 0 {
            fs::write(folder.path("killed.jsonl"), &text[..text.len() - 7 * attempt as usize % 90]).unwrap();
        }
    }
    folder.slew(&with(&LONG, &["-q", "-o", "killed.jsonl"])).ends(0);
    assert_eq!(folder.read("killed.jsonl"), whole, "after {kills} kills in {:?}", began.elapsed());
    assert!(kills > 2, "{kills}");
}

#[cfg(target_os = "linux")]
#[test]
fn interrupted_runs_keep_what_is_finished_and_tell_how_to_go_on() {
    let folder = Folder::new();
    let long =
        ["sweep", "spec.toml", "--over", "maneuver.duration_s=6:30:4999", "-o", "long.jsonl", "--progress"];
    let child = folder.command(&long).stderr(Stdio::piped()).spawn().unwrap();
    let begun = || fs::read_to_string(folder.path("long.jsonl")).is_ok_and(|text| text.lines().count() > 3);
    let waiting = Instant::now();
    while !begun() || !super::binary::catches_interrupt(child.id()) {
        assert!(waiting.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(10));
    }
    std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let run = Run::of(child.wait_with_output().unwrap(), &long).ends(130);
    run.tells("interrupted, ").tells("this command continues the run");
    let text = folder.read("long.jsonl");
    assert!(text.ends_with('\n') && text.lines().count() > 3);
    for (index, line) in text.lines().skip(1).enumerate() {
        let line: Value = serde_json::from_str(line).unwrap();
        assert_eq!((&line["case"], &line["status"]), (&(index + 1).into(), &"solved".into()));
    }
}

#[test]
fn results_of_another_batch_are_never_mixed() {
    let folder = Folder::new();
    let grid = |over: &'static str| ["sweep", "spec.toml", "--over", over, "-q", "-o", "all.jsonl"];
    let own = grid("maneuver.duration_s=10:20:3");
    folder.slew(&own).ends(0);
    let before = folder.read("all.jsonl");
    let refused = |args: &[&str], why: &str| {
        folder.slew(args).ends(8).tells("error[E0112]").tells(why);
        assert_eq!(folder.read("all.jsonl"), before);
    };
    refused(
        &grid("maneuver.duration_s=10:21:3"),
        "the spec, a key set on the command line, or a case differs",
    );
    refused(&grid("maneuver.duration_s=10:20:4"), "they cover 3 cases over maneuver.duration_s, not 4");
    refused(&with(&own, &["--set", "maneuver.steps=90"]), "differs");
    refused(&with(&own, &["--shard", "1/2"]), "they cover all cases, not shard 1/2");
    refused(&with(&own, &["--times"]), "wall times");
    let spec = folder.read("spec.toml");
    fs::write(folder.path("spec.toml"), spec.replace("2.5]", "2.6]")).unwrap();
    refused(&own, "differs");
    folder.slew(&with(&own, &["--force"])).ends(0);
    assert_ne!(folder.read("all.jsonl"), before);
    // Damage is reported with its line.
    let text = folder.read("all.jsonl");
    let mut lines: Vec<&str> = text.lines().collect();
    lines.remove(2);
    fs::write(folder.path("all.jsonl"), lines.join("\n") + "\n").unwrap();
    folder.slew(&own).ends(8).tells("error[E0114]").tells("all.jsonl, line 3").tells("it is case 3, not 2");
    fs::write(folder.path("all.jsonl"), text.replacen("\"case\":2", "\"case\":x", 1)).unwrap();
    folder.slew(&own).ends(8).tells("error[E0114]").tells("line 3");
    // The case of a truncated line is planned again, and a message reports it.
    fs::write(folder.path("all.jsonl"), &text[..text.len() - 1]).unwrap();
    let told: Vec<&str> = own.iter().copied().filter(|word| *word != "-q").collect();
    folder.slew(&told).ends(0).tells("warning[W0113]").tells("after 2 cases that were there");
    assert_eq!(folder.read("all.jsonl"), text);
    // A file that holds no results is not changed.
    fs::write(folder.path("all.jsonl"), "my notes\n").unwrap();
    folder.slew(&own).ends(8).tells("exists, but is not a file of results");
    assert_eq!(folder.read("all.jsonl"), "my notes\n");
}

/// An orbit that the spec names as a file is a part of it.
#[test]
fn results_of_another_orbit_are_never_mixed() {
    let folder = Folder::new();
    let orbit = fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/bad_inputs/orbit/sky_circular.oem"
    ));
    let orbit = orbit.unwrap();
    fs::write(folder.path("orbit.oem"), &orbit).unwrap();
    let spec = "format = 1\nepoch = \"2026-11-21T07:00:00 UTC\"\n[orbit]\noem = \"orbit.oem\"\n[body]\n\
        inertia_kg_m2 = [120, 100, 80]\n[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
        [end]\npoint = { boresight_body = [0, 0, 1], at = \"nadir\" }\n[maneuver]\nduration_s = 60\nsteps = 20\n";
    fs::write(folder.path("orbit.toml"), spec).unwrap();
    let own = ["sweep", "orbit.toml", "--over", "maneuver.duration_s=50:60:2", "-q", "-o", "all.jsonl"];
    folder.slew(&own).ends(0);
    let before = folder.read("all.jsonl");
    folder.slew(&own).ends(0);
    fs::write(folder.path("orbit.oem"), orbit.replace("6985.362639", "6985.362638")).unwrap();
    assert_ne!(fs::read_to_string(folder.path("orbit.oem")).unwrap(), orbit);
    folder.slew(&own).ends(8).tells("error[E0112]").tells("differs");
    assert_eq!(folder.read("all.jsonl"), before);
}

#[test]
fn failed_cases_are_counted_and_end_with_nine() {
    let folder = Folder::new();
    let over = ["--over", "actuators.torque_limit_n_m=0.001,1,10", "--over", "maneuver.steps=100,3"];
    let command = with(
        &["sweep", "spec.toml", "-o", "all.jsonl", "--set", "end.angular_velocity_deg_s=[0,0,40]"],
        &over,
    );
    let run = folder.slew(&command).ends(9).tells("infeasible: case 1");
    let run = run.tells("again       slew sweep spec.toml --over actuators.");
    run.tells("--set 'end.angular_velocity_deg_s=[0,0,40]' --case 1 -o plan.json");
    let lines = lines(&folder, "all.jsonl");
    assert_eq!((&lines[1]["status"], &lines[1]["exit_code"]), (&"infeasible".into(), &4.into()));
    assert!(lines[1]["obstruction"].is_string() && lines[1].get("cost").is_none());
    let solved = |line: &&Value| line["exit_code"] == 0;
    assert!(lines[1..].iter().any(|line| solved(&line)) && lines.len() == 7);
}
