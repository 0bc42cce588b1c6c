//! `slew export` and the formats of other programs; attitudes of others; help, explanations,
//! schemas.

use super::binary::{Folder, Run};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const SET: [&str; 4] = ["--set", "epoch=2026-11-21T07:00:00 UTC", "--set", "names.spice_id=-42"];

fn planned() -> Folder {
    let folder = Folder::new();
    folder.slew(&[&["plan", "spec.toml", "-q", "-o", "plan.json"], &SET[..]].concat()).ends(0);
    folder
}

#[test]
fn every_format_is_written_by_its_ending() {
    let folder = planned();
    for (name, start) in [
        ("plan.aem", &b"CCSDS_AEM_VERS = 2.0"[..]),
        ("plan.xml", b"<?xml"),
        ("plan.apm", b"CCSDS_APM_VERS = 2.0"),
        ("plan.a", b"stk.v."),
        ("plan.bc", b"DAF/CK  "),
        ("plan.tsc", b"KPL/SCLK"),
        ("plan.tf", b"KPL/FK"),
        ("plan.npz", b"PK\x03\x04"),
        ("plan.mat", b"MATLAB 5.0"),
        ("plan.42", b"0.0000000000000000e0 "),
        ("plan.flight", b"# slewkit flight table 1"),
        ("plan.csv", b"time_s,"),
    ] {
        folder.slew(&["export", "plan.json", "-o", name]).ends(0).tells("wrote");
        assert!(fs::read(folder.path(name)).unwrap().starts_with(start), "{name}");
    }
    // The same from the planner at once.
    folder.slew(&[&["plan", "spec.toml", "-q", "-o", "at_once.42"], &SET[..]].concat()).ends(0);
    assert_eq!(folder.read("at_once.42"), folder.read("plan.42"));
    // The output has the names from the command line.
    let json =
        folder.slew(&["export", "plan.json", "--format", "json", "--set", "names.object=X"]).ends(0).json();
    assert_eq!(json["spec"]["names"]["object"], "X");
    assert_eq!(json["spec"]["epoch"], "2026-11-21T07:00:00.000 UTC");
}

#[test]
fn an_ephemeris_has_as_many_blocks_as_the_plan_has_arcs() {
    let folder = Folder::new();
    for name in ["minimum_time_xte", "minimum_fuel_norm"] {
        let spec = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let plan = format!("{name}.json");
        let json =
            folder.slew(&[&["plan", &spec, "-q", "--format", "json"], &SET[..2]].concat()).ends(0).json();
        fs::write(folder.path(&plan), json.to_string()).unwrap();
        let aem = folder.slew(&["export", &plan, "--format", "aem"]).ends(0);
        let blocks = aem.stdout.matches("META_START").count();
        let arcs = json["switching"]["arcs"].as_array().unwrap().len();
        assert!(blocks == arcs && arcs > 1, "{name}: {blocks} blocks, {arcs} arcs");
    }
}

#[test]
fn margins_stand_in_tables_that_are_asked_for_them() {
    let folder = planned();
    folder.slew(&["export", "plan.json", "-o", "bare.csv"]).ends(0);
    folder.slew(&["plan", "spec.toml", "-q", "-o", "full.csv", "--margins"]).ends(0);
    let head = |name: &str| folder.read(name).lines().next().unwrap().to_string();
    let more = head("full.csv");
    assert!(more.starts_with(&head("bare.csv")), "{more}");
    assert!(!more.contains("margin"), "nothing is limited: {more}");
    let limited = ["--set", "actuators.torque_limit_n_m=50"];
    folder
        .slew(&[&["plan", "spec.toml", "-q", "-o", "limited.csv", "--margins"], &limited[..]].concat())
        .ends(0);
    assert!(head("limited.csv").ends_with(",margin_torque_limit_n_m"), "{}", head("limited.csv"));
    let before = folder.names();
    for args in [
        &["plan", "spec.toml", "-o", "a.json", "--margins"][..],
        &["export", "plan.json", "-o", "a.npz", "--margins"],
    ] {
        folder.slew(args).ends(2).tells("E0107").tells("csv");
    }
    assert_eq!(folder.names(), before);
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_program_without_parquet_says_how_to_have_it() {
    let folder = planned();
    let before = folder.names();
    let (plan, export) = (["plan", "spec.toml"], ["export", "plan.json"]);
    for args in [plan, export] {
        let run = folder.slew(&[&args[..], &["-o", "plan.parquet"]].concat()).ends(2).tells("E0144");
        run.tells("--features parquet");
    }
    assert_eq!(folder.names(), before);
    let sweep = ["sweep", "spec.toml", "--over", "maneuver.duration_s=20,30", "-q", "-o"];
    folder.slew(&[&sweep[..], &["all.parquet"]].concat()).ends(2).tells("slew merge");
    folder.slew(&[&sweep[..], &["all.jsonl"]].concat()).ends(0);
    folder.slew(&["merge", "all.jsonl", "-o", "all.parquet"]).ends(2).tells("E0144");
    assert!(!folder.path("all.parquet").exists());
}

#[test]
fn what_a_format_needs_is_asked_for_before_any_work() {
    let folder = Folder::new();
    let before = folder.names();
    for (name, code) in [("a.aem", "E0140"), ("a.bc", "E0140"), ("a.tf", "E0142")] {
        let run = folder.slew(&["plan", "spec.toml", "-o", name]).ends(3).tells(code);
        run.tells("--set");
    }
    assert_eq!(folder.names(), before);
    folder.slew(&["plan", "spec.toml", "-o", "a.flight", "--tick", "-1"]).ends(2);
    // No plan, no file.
    let infeasible = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/infeasible_cones.toml");
    folder
        .slew(&["plan", infeasible, "-o", "a.42"])
        .ends(4)
        .tells("no plan exists, and this format holds nothing else");
    assert_eq!(folder.names(), before);
    let simulated = folder.slew(&["simulate", "spec.toml", "-o", "a.aem"]).ends(2).tells("E0105");
    simulated.tells(".csv");
}

#[test]
fn attitudes_of_a_file_are_judged_against_a_spec() {
    let folder = planned();
    folder.slew(&["export", "plan.json", "-q", "-o", "plan.aem"]).ends(0);
    folder.slew(&["export", "plan.json", "-q", "-o", "plan.csv"]).ends(0);
    for name in ["plan.aem", "plan.csv"] {
        let run = folder.slew(&["verify", name, "--spec", "spec.toml", "--format", "json"]).ends(0);
        let run = run.tells("attitudes agree with the spec").tells("not judged");
        assert_eq!(run.json()["rows"], 101);
        // Another end, another duration, a cone across the path.
        let failing = |set: &str| folder.slew(&["verify", name, "--spec", "spec.toml", "--set", set]).ends(7);
        failing("end.attitude.euler_zyx_deg=[80, -25, 41]").tells("failed: attitude at the end");
        failing("maneuver.duration_s=11").tells("failed: duration");
        failing("constraint=[{ kind = \"rate_limit\", name = \"slow\", angular_velocity_limit_deg_s = 5 }]")
            .tells("slow: the rate");
    }
    folder.slew(&["verify", "plan.aem"]).ends(2).tells("--spec");
    fs::write(folder.path("wrong.aem"), "CCSDS_AEM_VERS = 2.0\nnonsense\n").unwrap();
    let run = folder.slew(&["verify", "wrong.aem", "--spec", "spec.toml"]).ends(8);
    run.tells("wrong.aem:2:1: error[E0151]").tells("not of the form KEY = value");
}

#[test]
fn attitudes_of_a_file_are_a_guess() {
    let folder = planned();
    folder.slew(&["export", "plan.json", "-q", "-o", "plan.aem"]).ends(0);
    let limited = ["--set", "actuators={ torque_limit_n_m = 0.2 }", "--set", "solver.method=scp"];
    let run = folder
        .slew(&[&["plan", "spec.toml", "--format", "json", "--guess", "plan.aem"], &limited[..]].concat())
        .ends(0);
    let ladder = run.json()["ladder"].as_array().unwrap().clone();
    assert!(ladder.iter().any(|rung| rung["start"] == "guess"), "{ladder:?}");
    folder.slew(&["plan", "spec.toml", "--guess", "plan.aem"]).ends(0).tells("W0141");
    fs::write(folder.path("cut.csv"), "time_s,quaternion_w\n0,1\n").unwrap();
    let run = folder.slew(&["plan", "spec.toml", "-o", "next.json", "--guess", "cut.csv"]).ends(8);
    run.tells("cut.csv:1:1: error[E0151]");
    assert!(!folder.names().contains(&"next.json".to_string()));
}

/// Every code that the sources have is explained, and none that they do not have.
#[test]
fn every_code_is_explained() {
    let mut codes = BTreeSet::new();
    let mut folders = ["src", "crates"].map(|part| Path::new(evidence::ROOT).join(part)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                let parts = text.split('"').skip(1).step_by(1);
                let is_code = |part: &&str| {
                    part.len() == 5
                        && part.starts_with(['E', 'W'])
                        && part[1..].bytes().all(|byte| byte.is_ascii_digit())
                };
                codes.extend(parts.filter(is_code).map(str::to_string));
            }
        }
    }
    assert!(codes.len() > 100, "{}", codes.len());
    let explanations =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/explanations.txt")).unwrap();
    let explained: BTreeSet<String> =
        explanations.split("\n\n").map(|entry| entry[..5].to_string()).collect();
    assert_eq!(codes, explained);
    assert!(explanations.split("\n\n").all(|entry| entry.trim().lines().count() >= 2));
    let folder = Folder::new();
    let run = folder.slew(&["explain", "e0123"]).ends(0);
    assert!(run.stdout.starts_with("E0123 "), "{}", run.stdout);
    folder.slew(&["explain", "E9999"]).ends(2).tells("no code E9999");
}

#[test]
fn plan_files_fit_their_schema() {
    let folder = planned();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "none.json", "--set", "solver.time_limit_s=1e-9"]);
    let schema = folder.slew(&["schema", "plan"]).ends(0).json();
    let names = |value: &serde_json::Value| -> BTreeSet<String> {
        value.as_object().unwrap().keys().cloned().collect()
    };
    let required = |value: &serde_json::Value| -> BTreeSet<String> {
        value["required"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().into()).collect()
    };
    for name in ["plan.json", "none.json"] {
        let plan = folder.json(name);
        let properties = &schema["properties"];
        assert_eq!(
            names(&plan).difference(&names(properties)).count(),
            0,
            "{name}: a key without description"
        );
        assert_eq!(
            required(&schema).difference(&names(&plan)).count(),
            0,
            "{name}: a required key is missing"
        );
        let (found, described) = (&plan["trajectory"], &properties["trajectory"]);
        assert_eq!(names(found).difference(&names(&described["properties"])).count(), 0, "{name}");
        assert_eq!(required(described).difference(&names(found)).count(), 0, "{name}");
    }
}

#[test]
fn help_has_topics_and_commands_and_there_is_a_manual() {
    let folder = Folder::new();
    let replay = folder.slew(&["help", "replay"]).ends(0).stdout;
    assert!(replay.contains("0.5 * (torque[k] + torque[k+1])") && replay.contains("solve_ivp"));
    assert!(folder.slew(&["help", "plan"]).ends(0).stdout.contains("--guess"));
    assert!(folder.slew(&["help"]).ends(0).stdout.contains("export"));
    folder.slew(&["help", "nothing"]).ends(2).tells("replay");
    assert!(folder.slew(&["man"]).ends(0).stdout.contains(".TH slew 1"));
    assert!(folder.slew(&["man", "plan"]).ends(0).stdout.contains("slew\\-plan"));
    folder.slew(&["man", "nothing"]).ends(2).tells("export");
}

/// A plan that misses its end reports the miss and the number of steps that would suffice, and
/// these steps suffice.
#[test]
fn the_steps_that_are_named_reach_the_accuracy() {
    let folder = Folder::new();
    let coarse = [
        "--set",
        "maneuver.steps=20",
        "--set",
        "end.angular_velocity_deg_s=[8, -3, 5]",
        "--set",
        "solver.target=discrete",
    ];
    let plan = |more: &[&str]| -> Run {
        folder.slew(&[&["plan", "spec.toml", "-v", "--format", "json"], &coarse[..], more].concat())
    };
    for scheme in ["lie_verlet", "lie_euler"] {
        let scheme = format!("solver.scheme={scheme}");
        let first =
            plan(&["--set", &scheme]).ends(0).tells("deg off the target; ").tells(" steps would suffice");
        let accuracy = first.json()["accuracy"].clone();
        assert!(accuracy["continuous_attitude_deg"].as_f64().unwrap() > 0.01);
        let steps = accuracy["steps"].as_u64().unwrap();
        let first = first.tells(&format!("--set maneuver.steps={steps}"));
        drop(first);
        let finer = plan(&["--set", &scheme, "--set", &format!("maneuver.steps={steps}")]).ends(0).json();
        let reached = finer["accuracy"]["continuous_attitude_deg"].as_f64().unwrap();
        assert!(reached < 0.01 && reached > 0.001, "{scheme}: {steps} steps reach {reached} deg");
        assert!(finer["accuracy"]["steps"].is_null());
    }
}

#[test]
fn an_export_needs_a_file_or_a_format() {
    let folder = planned();
    folder.slew(&["export", "plan.json"]).ends(2).tells("-o plan.aem");
    folder.slew(&["export", "plan.json", "--format", "csv"]).ends(0);
}

/// A plan file of an infeasible maneuver has a reason and no motion.
#[test]
fn a_file_without_a_motion_is_refused_as_such() {
    let folder = Folder::new();
    let infeasible = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/infeasible_cones.toml");
    folder.slew(&["plan", infeasible, "-q", "-o", "none.json"]).ends(4);
    let why = "the solve ended without a plan";
    folder.slew(&["export", "none.json", "-o", "none.csv"]).ends(8).tells(why).tells("slew report");
    folder.slew(&["verify", "none.json"]).ends(7).tells(why).tells("slew report");
}

/// A body that is already where it should be has a plan of one moment, which formats of motions
/// cannot represent.
#[test]
fn plans_of_no_time_are_refused_by_formats_of_motions() {
    let folder = Folder::new();
    let spec = "format = 1\nepoch = \"2026-11-21T07:00:00 UTC\"\n[body]\ninertia_kg_m2 = [1, 2, 2.9]\n\
        [actuators]\ntorque_limit_n_m = 1\n\
        [start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n[end]\nattitude = { axis = [0, 0, 1], \
        angle_deg = 0 }\n\
        [maneuver]\nminimize = \"time\"\n[names]\nobject = \"X\"\nspice_id = -1000\nreference_frame = \"J2000\"\n";
    fs::write(folder.path("there.toml"), spec).unwrap();
    folder.slew(&["plan", "there.toml", "-q", "-o", "there.json"]).ends(0);
    for ending in ["aem", "apm", "a", "npz", "mat", "xml", "bc", "flight", "42"] {
        let name = format!("there.{ending}");
        folder
            .slew(&["export", "there.json", "-o", &name])
            .ends(3)
            .tells("E0143")
            .tells("duration of the plan is zero");
        assert!(!folder.path(&name).exists(), "{name}");
    }
    folder.slew(&["export", "there.json", "-o", "there.csv"]).ends(0);
}

/// Exported plans pass the check of their attitudes, also with a free roll, and with two trackers
/// of which one must see.
#[test]
fn attitudes_that_are_written_agree_with_their_spec() {
    let folder = Folder::new();
    let problem = |name: &str| format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let (sun, trackers) = (problem("sun_free_roll"), problem("two_trackers"));
    let epoch = ["--set", "epoch=2026-11-21T07:00:00 UTC"];
    folder.slew(&["plan", &sun, "-q", "-o", "sun.json"]).ends(0);
    folder.slew(&[&["plan", &trackers, "-q", "-o", "trackers.json"], &epoch[..]].concat()).ends(0);
    for (spec, plan) in [(&sun, "sun"), (&trackers, "trackers")] {
        let file = |ending: &str| format!("{plan}.{ending}");
        folder.slew(&["verify", &file("json"), "--spec", spec]).ends(0).tells("verified");
        for ending in ["aem", "a", "csv"] {
            folder.slew(&["export", &file("json"), "-q", "-o", &file(ending)]).ends(0).silent();
            folder.slew(&["verify", &file(ending), "--spec", spec]).ends(0).tells("attitudes agree");
        }
    }
    let kernel = ["--set", "names.spice_id=-42"];
    folder.slew(&[&["export", "sun.json", "-q", "-o", "sun.bc"], &kernel[..]].concat()).ends(0);
    folder.slew(&["verify", "sun.bc", "--spec", &sun]).ends(0).tells("attitudes agree");
    // Turned about the boresight all along the start is another, turned about another axis the end
    // is.
    let other = ["verify", "trackers.aem", "--spec", &trackers, "--set", "constraint.0.half_angle_deg=38"];
    folder
        .slew(&[&other[..], &["--set", "constraint.1.half_angle_deg=38"]].concat())
        .ends(7)
        .tells("tracker");
    let other = ["verify", "sun.aem", "--spec", &sun, "--set", "end.point.boresight_body=[-1, 0.02, 0]"];
    folder.slew(&other).ends(7).tells("attitude at the end");
}

/// Damaged plan files are drawn and exported with the verdict that they failed, and with the exit
/// code of failed plans.
#[test]
fn what_the_witnesses_refuse_is_never_told_as_verified() {
    let folder = planned();
    let good = folder.slew(&["plan", "spec.toml", "-q", "--format", "json"]).ends(0).json();
    for (key, damage) in [("torque_n_m", 1e300), ("quaternion_wxyz", 1.0), ("time_s", 0.0), ("input", 1e-3)] {
        let mut plan = good.clone();
        let list = plan["trajectory"][key].as_array_mut();
        let Some(list) = list else { continue };
        let first = list[0].clone();
        for entry in list.iter_mut() {
            match entry.as_array_mut() {
                _ if key == "quaternion_wxyz" => *entry = first.clone(),
                Some(parts) => parts[0] = damage.into(),
                None => *entry = damage.into(),
            }
        }
        fs::write(folder.path("wrong.json"), plan.to_string()).unwrap();
        let verified = folder.slew(&["verify", "wrong.json", "-q"]);
        assert!([7, 8].contains(&verified.code), "{key}: {}", verified.code);
        let page = folder.slew(&["report", "wrong.json", "-q", "--force", "-o", "wrong.html"]);
        assert!([7, 8].contains(&page.code), "{key}: {}", page.code);
        if page.code == 7 {
            page.tells("E0153");
            assert!(!folder.read("wrong.html").contains("solved and verified"), "{key}");
        }
        let export = folder.slew(&["export", "wrong.json", "--format", "json"]);
        assert!([7, 8].contains(&export.code), "{key}: {}", export.code);
        assert!(!export.stdout.contains("\"status\": \"solved\""), "{key}");
    }
    // One line reports the failure if no other output reports it.
    let short = ["plan", "spec.toml", "-q", "--set", "maneuver.duration_s=1e-3"];
    let torque =
        ["--set", "actuators={ torque_axes_body = [[1,0,0],[0,1,0],[0,0,1]], torque_limit_n_m = 1e-9 }"];
    folder.slew(&[&short[..], &torque].concat()).ends(4).tells("exit code 4");
}
