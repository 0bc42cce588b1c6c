//! `slew fly`, and the gains and uncertainties that a plan reports.

use super::binary::Folder;
use serde_json::Value;
use std::fs;

const FLIES: &str = include_str!("../../../problems/flies.toml");

/// Returns the spec with actuators without lag and delay.
fn at_once() -> &'static str {
    FLIES.split("[plant]").next().unwrap()
}

fn planned(spec: &str) -> Folder {
    let folder = Folder::new();
    fs::write(folder.path("spec.toml"), spec).unwrap();
    folder.slew(&["plan", "spec.toml", "-q", "-o", "plan.json"]).ends(0);
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn a_plan_tells_its_gains_its_chances_and_what_they_cost() {
    let folder = planned(FLIES);
    folder
        .slew(&["plan", "spec.toml"])
        .ends(0)
        .tells("feedback    neighbouring gains, held over the last 15 of 100 steps")
        .tells("uncertain   boresights end within")
        .tells("requested at most 0.010")
        .tells("margin      Sun");
    folder
        .slew(&["check", "spec.toml"])
        .ends(0)
        .tells("flight      [feedback], [plant], [uncertainty], for `slew fly`");
    let plan = folder.json("plan.json");
    let gains = plan["feedback"]["gains"].as_array().unwrap();
    assert_eq!((gains.len(), gains[0].as_array().unwrap().len()), (100, 3));
    assert_eq!(gains[98], gains[99]);
    let uncertain = &plan["uncertainty"];
    let [open, closed] =
        ["open_loop", "closed_loop"].map(|of| number(&uncertain[of]["pointing"][0]["within_9973_deg"]));
    assert!(open > 20.0 * closed, "{open} {closed}");
    assert_eq!(uncertain["margins"]["agreed"], true);
    let margin = number(&uncertain["margins"]["held"][0]["held"][0]);
    let sigma = number(&uncertain["closed_loop"]["chances"][0]["sigma"]);
    // Φ⁻¹(0.99).
    assert!((margin / sigma - 2.326_347_874).abs() < 1e-3, "{margin} {sigma}");
    assert!(number(&plan["cost"]) > number(&uncertain["margins"]["cost_without"]));
    // The file is judged by its own spec, with all sections.
    let judged = folder.slew(&["verify", "plan.json", "--format", "json", "-q"]).ends(0).json();
    assert_eq!(judged["differences"], serde_json::json!([]));
}

/// Flights with another seed keep a chance over the motion. Such a chance needs a larger margin
/// than the chance of an instant.
#[test]
fn the_chance_of_a_motion_is_kept_in_flight() {
    let folder = planned(FLIES);
    let of_motion = ["--set", "constraint.0.chance_over=motion", "--set", "constraint.0.chance=0.02"];
    folder
        .slew(&[&["plan", "spec.toml", "-o", "motion.json"], &of_motion[..]].concat())
        .ends(0)
        .tells("requested at most 0.020")
        .tells("of the flights");
    let plan = folder.json("motion.json");
    let margins = &plan["uncertainty"]["margins"];
    assert_eq!((&margins["agreed"], &margins["counted"][0][0]), (&true.into(), &"Sun".into()));
    let [low, high] = [0, 1].map(|end| number(&margins["counted"][0][1]["interval"][end]));
    assert!(low < 0.02 && 0.02 < high, "{margins}");
    assert_eq!(plan["spec"]["constraint"][0]["chance_over"], "motion");
    let told = folder
        .slew(&["fly", "motion.json", "--cases", "10000", "--loop", "closed", "--format", "json", "-q"])
        .ends(0)
        .json();
    let part = number(&told["loops"][0]["end"]["constraints"][0]["violated"]["part"]);
    // Both counts err: by a tenth, and by a fourteenth.
    assert!(part > 0.7 * 0.02 && part < 1.4 * 0.02, "{part}");
    folder.slew(&["report", "motion.json", "-o", "motion.html"]).ends(0);
    let page = folder.read("motion.html");
    assert!(page.contains("<dt>margin</dt>") && page.contains("Commands in flight"));
}

#[test]
fn cases_agree_with_the_linear_theory_and_are_the_same_alone() {
    let folder = planned(at_once());
    let told = folder.slew(&["fly", "plan.json", "--cases", "2000", "--format", "json", "-q"]).ends(0).json();
    assert_eq!(told["loops"].as_array().unwrap().len(), 2);
    for of in told["loops"].as_array().unwrap() {
        let end = &of["end"];
        for axis in 0..3 {
            let ratio =
                number(&end["attitude_sigma_deg"][axis]) / number(&end["attitude_sigma_linear_deg"][axis]);
            // Five standard errors of 2000 cases.
            assert!((ratio - 1.0).abs() < 0.08, "{of}");
        }
        assert!(number(&end["inside_9973"]["part"]) > 0.985, "{of}");
    }
    let cone = &told["loops"][0]["end"]["constraints"][0]["violated"];
    assert!(number(&cone["interval"][0]) < 0.015, "{cone}");
    folder.slew(&["fly", "plan.json", "--cases", "20", "-o", "cases.csv"]).ends(0).tells("20 cases flown");
    let rows: Vec<String> = folder.read("cases.csv").lines().map(String::from).collect();
    assert_eq!(rows.len(), 41);
    assert!(rows[0].starts_with("loop,case,attitude_error_x_rad,"), "{}", rows[0]);
    let cells: Vec<&str> = rows[18].split(',').collect();
    assert_eq!(cells[..2], ["closed loop", "18"]);
    // Cases count from 1, like the cases of batches.
    folder.slew(&["fly", "plan.json", "--case", "18", "-o", "one.csv"]).ends(0).tells("18, closed loop");
    folder.slew(&["fly", "plan.json", "--case", "0", "-o", "none.csv"]).ends(2);
    let last = folder.read("one.csv").lines().last().unwrap().to_string();
    let one: Vec<&str> = last.split(',').collect();
    assert_eq!(one[8..14], cells[2..8]);
    folder.slew(&["fly", "plan.json", "--cases", "20", "-o", "cases.npz"]).ends(0);
    assert!(fs::read(folder.path("cases.npz")).unwrap().starts_with(b"PK"));
}

/// Killed anywhere, on any number of threads, in one go or enlarged: the same bytes.
#[test]
fn flights_go_on_where_they_were_left() {
    let folder = planned(FLIES);
    let fly = |cases: &str, more: &[&str]| {
        let common = ["fly", "plan.json", "--force", "-o", "cases.csv", "--cases", cases];
        folder.slew(&[&common[..], more].concat())
    };
    fly("60", &["--keep", "whole.jsonl"]).ends(0);
    let (lines, table) = (folder.read("whole.jsonl"), folder.read("cases.csv"));
    assert_eq!(lines.lines().count(), 61);
    // None, within the first line, after it, within a case, after one, and all of them.
    let ends: Vec<usize> = lines.match_indices('\n').map(|(at, _)| at + 1).collect();
    for end in [0, 10, ends[0], ends[20] + 7, ends[41], lines.len()] {
        fs::write(folder.path("part.jsonl"), &lines[..end]).unwrap();
        let told = fly("60", &["--keep", "part.jsonl", "--threads", "1"]).ends(0);
        if end == ends[41] {
            told.tells("after 41 cases that were there");
        }
        assert_eq!(folder.read("part.jsonl"), lines, "cut at {end}");
        assert_eq!(folder.read("cases.csv"), table, "cut at {end}");
    }
    fly("25", &["--keep", "fewer.jsonl"]).ends(0);
    fly("60", &["--keep", "fewer.jsonl", "--threads", "3"]).ends(0);
    assert_eq!(folder.read("fewer.jsonl"), lines);
    // Refused: another seed, plan or loop, fewer cases, a line that does not belong there, and a
    // file without flights.
    let refused = |cases: &str, more: &[&str], why: &str, code: &str| {
        let before = folder.read("fewer.jsonl");
        let exit = if why.contains("more than") { 2 } else { 8 };
        fly(cases, &[&["--keep", "fewer.jsonl"], more].concat()).ends(exit).tells(code).tells(why);
        assert_eq!(folder.read("fewer.jsonl"), before);
    };
    refused("60", &["--seed", "2"], "their seed is 1, not 2", "E0112");
    refused("60", &["--loop", "open"], "not the open loop", "E0112");
    refused("60", &["--set", "uncertainty.inertia.relative=0.03"], "differ", "E0112");
    refused("59", &[], "60 cases, more than requested", "E0112");
    fs::write(folder.path("fewer.jsonl"), lines.replacen("{\"case\":8,", "{\"case\":9,", 1)).unwrap();
    refused("60", &[], "line 9 is not the expected result: it is case 9, not 8", "E0114");
    fs::write(folder.path("fewer.jsonl"), lines.replacen("\"room\":[", "\"room\":[0.5,", 1)).unwrap();
    refused("60", &[], "its numbers contradict the first line", "E0114");
    fs::write(folder.path("fewer.jsonl"), "{\"slew_flights\":9}\n").unwrap();
    refused("60", &[], "the flights have format 9", "E0112");
    fs::write(folder.path("fewer.jsonl"), FLIES).unwrap();
    refused("60", &[], "is not a file of flights", "E0112");
    fly("60", &["--keep", "fewer.csv"]).ends(2).tells("E0105");
    fly("60", &["--keep", "cases.csv.jsonl", "--threads", "0"]).ends(2).tells("E0115");
    folder.slew(&["fly", "plan.json", "--case", "3", "--keep", "x.jsonl"]).ends(2);
}

#[test]
fn what_cannot_be_flown_is_refused() {
    let folder = planned(super::binary::SPEC);
    folder.slew(&["fly", "plan.json"]).ends(8).tells("E0173").tells("uncertainty.inertia.relative=0.02");
    let uncertain = ["--set", "uncertainty.inertia.relative=0.02"];
    folder.slew(&[&["fly", "plan.json", "--cases", "2"], &uncertain[..]].concat()).ends(0).tells("open loop");
    folder
        .slew(&[&["fly", "plan.json", "--loop", "closed"], &uncertain[..]].concat())
        .ends(8)
        .tells("the plan has no gains");
    folder.slew(&["fly", "plan.json", "--cases", "1"]).ends(2);
    folder
        .slew(&[&["fly", "plan.json", "--case", "3", "-o", "x.npz"], &uncertain[..]].concat())
        .ends(2)
        .tells("E0107");
    folder.slew(&["fly", "spec.toml"]).ends(8).tells("not a plan file, but a spec");
    // A changed maneuver: the recorded plan is no plan of it.
    for set in ["body.inertia_kg_m2=[2, 3, 4]", "maneuver.duration_s=30"] {
        let args = ["fly", "plan.json", "--cases", "2", "--set", set];
        folder
            .slew(&[&args[..], &uncertain[..]].concat())
            .ends(2)
            .tells("the plan does not change in flight");
    }
    folder.slew(&["fly", "plan.json", "-o", "x.aem"]).ends(2);
    // A chance that an end has no room for.
    fs::write(folder.path("near.toml"), FLIES.replace("half_angle_deg = 20", "half_angle_deg = 40.7"))
        .unwrap();
    folder.slew(&["plan", "near.toml"]).ends(3).tells("E0172");
}

#[test]
fn gains_are_exported_with_the_plan() {
    let folder = planned(FLIES);
    folder.slew(&["export", "plan.json", "-o", "plan.flight"]).ends(0);
    let table = folder.read("plan.flight");
    assert!(table.starts_with("# slewkit flight table 2"));
    let mut rows = table.lines().filter(|line| !line.starts_with('#'));
    let head = rows.next().unwrap();
    // A held input has another name than an input that acts at a node.
    assert!(head.contains(",held_torque_x_n_m,") && head.contains(",held_input_1_n_m,"), "{head}");
    assert!(head.ends_with("gain_3_rate_y,gain_3_rate_z"));
    let plan = folder.json("plan.json");
    let cells: Vec<f64> = rows.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let first: Vec<f64> = plan["feedback"]["gains"][0][0].as_array().unwrap().iter().map(number).collect();
    assert_eq!(cells[cells.len() - 18..cells.len() - 12], first);
    folder.slew(&["export", "plan.json", "-o", "plan.npz"]).ends(0);
    let archive = fs::read(folder.path("plan.npz")).unwrap();
    assert!(archive.windows(9).any(|window| window == b"gains.npy"));
}

/// Plans of least time, of wheels, in a sought duration and to a target that moves have gains too,
/// and fly.
#[test]
fn plans_of_every_kind_fly() {
    let folder = Folder::new();
    let problems = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/");
    for (name, kind) in [
        ("minimum_time_cube_090", "tvlqr"),
        ("minimum_fuel_xte", "tvlqr"),
        ("wheels_pyramid", "tvlqr"),
        ("free_duration_xte", "neighbouring"),
        ("sun_free_roll", "neighbouring"),
        ("detumble_any_attitude", "neighbouring"),
        ("orbit_turn", "neighbouring"),
        ("two_torques", "neighbouring"),
        ("limited_box", "neighbouring"),
    ] {
        let spec = format!("{problems}{name}.toml");
        let sets = ["--set", "uncertainty.inertia.relative=0.002", "--set", "plant.authority=1.3"];
        let kind = format!("feedback.kind={kind}");
        let plan = [&["plan", &spec, "-q", "--force", "-o", "plan.json", "--set", &kind], &sets[..]].concat();
        folder.slew(&plan).ends(0);
        let told =
            folder.slew(&["fly", "plan.json", "--cases", "100", "--format", "json", "-q"]).ends(0).json();
        let of = |index: usize| number(&told["loops"][index]["end"]["angle_quantiles_deg"][1]);
        assert_eq!(told["loops"][0]["lost"], 0, "{name}");
        assert!(of(0) < 0.5 * of(1), "{name}: closed {} open {}", of(0), of(1));
    }
}

const WITHIN_LIMITS: &str = include_str!("../../../problems/flies_within_limits.toml");

/// A plan leaves a reserve of each torque for corrections, and its file has limit, chance and
/// reserve. Flights exceed the limit as often as the requested chance.
#[test]
fn torques_keep_their_chance_and_files_hold_the_reserve() {
    let folder = planned(WITHIN_LIMITS);
    folder
        .slew(&["plan", "spec.toml"])
        .ends(0)
        .tells("torque limit: 0.010 at its worst")
        .tells("requested at most 0.010")
        .tells("margin      torque limit");
    let plan = folder.json("plan.json");
    let (spec, margins) = (&plan["spec"]["actuators"], &plan["uncertainty"]["margins"]);
    assert_eq!(spec["torque_limit_n_m"], serde_json::json!([0.14, 0.068, 0.17]));
    assert_eq!(spec["torque_limit_chance"], 0.01);
    assert_eq!((&margins["agreed"], &margins["held"][0]["unit"]), (&true.into(), &"N·m".into()));
    assert_eq!(margins["held"][0]["held"], spec["torque_limit_reserve_n_m"]);
    let chance = &plan["uncertainty"]["closed_loop"]["chances"][0];
    let (sigma, room) = (number(&chance["sigma"]), number(&chance["room"]));
    // Φ⁻¹(0.99), to the accuracy of two plans.
    assert!((room / sigma - 2.326_347_874).abs() < 0.01, "{chance}");
    assert!(number(&plan["cost"]) > number(&margins["cost_without"]));
    folder.slew(&["verify", "plan.json"]).ends(0).tells("torque limit");
    // The reserve that the file holds is the plan's own: planned again without a chance, it is the
    // same plan.
    let spec = plan["spec"].to_string().replace("\"torque_limit_chance\":0.01,", "");
    assert!(!spec.contains("chance"), "{spec}");
    fs::write(folder.path("again.json"), spec).unwrap();
    folder.slew(&["plan", "again.json", "-q", "-o", "again.plan.json"]).ends(0);
    let again = number(&folder.json("again.plan.json")["cost"]);
    assert!((again / number(&plan["cost"]) - 1.0).abs() < 1e-9, "{again}");
    let told = folder
        .slew(&["fly", "plan.json", "--cases", "4000", "--loop", "closed", "--format", "json", "-q"])
        .ends(0)
        .json();
    let limit = &told["loops"][0]["end"]["limits"][0];
    assert_eq!(limit["name"], "torque limit");
    // Over the motion and any of three inputs: more than at one instant of one, less than by their
    // sum.
    let part = number(&limit["violated"]["part"]);
    assert!(part > 0.007 && part < 0.3, "{limit}");
    folder.slew(&["fly", "plan.json", "--cases", "4", "-o", "cases.csv"]).ends(0);
    assert!(
        folder.read("cases.csv").lines().next().unwrap().contains("room torque limit 1,room torque limit 2")
    );
    // More than there is.
    folder
        .slew(&["plan", "spec.toml", "--set", "uncertainty.start.attitude_deg=60"])
        .ends(3)
        .tells("E0172")
        .tells("\"torque limit\" is");
}

/// One chance of a cone and the torques, counted in flights: flights of another seed exceed any of
/// them as often.
#[test]
fn a_cone_and_the_torques_share_a_chance() {
    let shared = "chance = 0.05\nchance_of = [\"Sun\", \"torque limit\"]\n";
    let spec =
        at_once().replace("chance = 0.01\n", "").replace("torque_limit_n_m = 2", "torque_limit_n_m = 0.3");
    let spec = spec.replace("[feedback]\n", "[feedback]\nkind = \"tvlqr\"\n");
    let spec = spec.replace("[uncertainty]\n", &format!("[uncertainty]\n{shared}"));
    let folder = Folder::new();
    fs::write(folder.path("spec.toml"), spec).unwrap();
    folder
        .slew(&["plan", "spec.toml", "-o", "plan.json"])
        .ends(0)
        .tells("any of Sun, torque limit: requested at most 0.050 over the motion")
        .tells("of the flights violate Sun, torque limit");
    let plan = folder.json("plan.json");
    assert_eq!(plan["spec"]["uncertainty"]["chance_of"][1], "torque limit");
    folder
        .slew(&["fly", "plan.json", "--cases", "10000", "--loop", "closed", "-o", "cases.csv", "-q"])
        .ends(0);
    let text = folder.read("cases.csv");
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let rooms: Vec<usize> = (0..heads.len()).filter(|index| heads[*index].starts_with("room ")).collect();
    assert_eq!(rooms.len(), 4);
    let any = text.lines().skip(1).filter(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        rooms.iter().any(|index| cells[*index].parse::<f64>().unwrap() < 0.0)
    });
    let part = any.count() as f64 / 1e4;
    assert!(part > 0.75 * 0.05 && part < 1.3 * 0.05, "{part}");
}

/// A controller measures every second step: files state it, gains are equal in pairs, and flights
/// agree with the covariance.
#[test]
fn a_slower_controller_is_planned_told_and_flown() {
    let folder = planned(&at_once().replace("[feedback]\n", "[feedback]\nevery_s = 1.2\n"));
    let plan = folder.json("plan.json");
    assert_eq!(plan["feedback"]["every_steps"], 2);
    let gains = plan["feedback"]["gains"].as_array().unwrap();
    assert_eq!((gains.len(), &gains[0], &gains[50]), (100, &gains[1], &gains[51]));
    assert_ne!(gains[1], gains[2]);
    folder.slew(&["plan", "spec.toml"]).ends(0).tells("every 1.20 s");
    let told = folder
        .slew(&["fly", "plan.json", "--cases", "2000", "--loop", "closed", "--format", "json", "-q"])
        .ends(0)
        .json();
    let end = &told["loops"][0]["end"];
    for axis in 0..3 {
        let ratio =
            number(&end["attitude_sigma_deg"][axis]) / number(&end["attitude_sigma_linear_deg"][axis]);
        assert!((ratio - 1.0).abs() < 0.08, "{end}");
    }
}

/// A covariance without correlations equals its deviations; a covariance of the inertia can be
/// given by principal errors.
#[test]
fn covariances_are_those_of_their_deviations_and_of_their_principal_errors() {
    let read = |uncertainty: &str| {
        let head = FLIES.split("[uncertainty]").next().unwrap();
        let text = format!("{head}[uncertainty]\n{uncertainty}");
        slewkit_files::spec::from_str(&text, "spec.toml", slewkit_files::spec::Format::Toml, &[])
            .unwrap()
            .closed_loop
            .uncertainty
            .unwrap()
    };
    let deviations = read("start = { attitude_deg = [1, 2, 3], angular_velocity_deg_s = 0.1 }");
    for text in [
        "start = { covariance_deg_deg_s = [1, 4, 9, 0.01, 0.01, 0.01] }",
        "start = { attitude_covariance_deg2 = [1, 4, 9], angular_velocity_covariance_deg2_s2 = [0.01, 0.01, 0.01] }",
        "start = { attitude_deg = [1, 2, 3], angular_velocity_covariance_deg2_s2 = [[0.01, 0, 0], [0, 0.01, \
            0], [0, 0, 0.01]] }",
    ] {
        let found = read(text);
        assert!((found.start - deviations.start).amax() < 1e-15, "{text}: {}", found.start);
    }
    let rows = [
        [4.0, 1.0, 0.5, 0.2, 0.0, 0.1],
        [1.0, 3.0, 0.4, 0.0, 0.1, 0.0],
        [0.5, 0.4, 2.0, 0.1, 0.0, 0.2],
        [0.2, 0.0, 0.1, 1.0, 0.3, 0.0],
        [0.0, 0.1, 0.0, 0.3, 1.0, 0.1],
        [0.1, 0.0, 0.2, 0.0, 0.1, 1.0],
    ];
    let found = read(&format!("inertia = {{ covariance_kg2_m4 = {rows:?} }}"));
    assert_eq!(found.parameters.len(), 6);
    let places = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    for (row, of) in places.iter().enumerate() {
        for (column, with) in places.iter().enumerate() {
            let part = |(_, parameter, sigma): &(
                String,
                slewkit::optimize::discrete::linear_plan::Parameter,
                f64,
            )| {
                let slewkit::optimize::discrete::linear_plan::Parameter::Inertia(delta) = parameter else {
                    panic!()
                };
                delta[*of] * delta[*with] * sigma * sigma
            };
            let sum: f64 = found.parameters.iter().map(part).sum();
            assert!((sum - rows[row][column]).abs() < 1e-12, "{row} {column}: {sum}");
        }
    }
    let correlated = read("sensor = { attitude_covariance_deg2 = [[4, 1, 0], [1, 4, 0], [0, 0, 1]] }");
    let degree = 1_f64.to_radians();
    assert!((correlated.sensor_noise[(0, 1)] / (degree * degree) - 1.0).abs() < 1e-14);
}

/// A plan of least time reports the changes of its arc lengths from another start, in tables too.
/// The program refuses this together with uncertainties, and for maneuvers without arcs.
#[test]
fn plans_that_switch_tell_how_their_arcs_answer_to_the_start() {
    let folder = Folder::new();
    let problems = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/");
    let spec = format!("{problems}minimum_time_xte.toml");
    let plan = ["plan", &spec, "--set", "feedback.kind=switching"];
    folder
        .slew(&[&plan[..], &["-o", "plan.json"]].concat())
        .ends(0)
        .tells("feedback    switching times corrected at the start, then a regulator")
        .tells("would make arc 3");
    let feedback = &folder.json("plan.json")["feedback"];
    let arcs = feedback["arcs"].as_array().unwrap();
    assert_eq!((arcs.len(), feedback["gains"].as_array().unwrap().len()), (6, 200));
    let length: f64 = arcs.iter().map(|arc| number(&arc["length_s"])).sum();
    assert!((length - 28.6304).abs() < 1e-3, "{length}");
    for (name, array) in [("plan.npz", "arc_gains.npy"), ("plan.mat", "arc_gains")] {
        folder.slew(&["export", "plan.json", "-o", name]).ends(0);
        let archive = fs::read(folder.path(name)).unwrap();
        assert!(archive.windows(array.len()).any(|window| window == array.as_bytes()), "{name}");
    }
    let uncertain = ["--set", "uncertainty.inertia.relative=0.01"];
    folder
        .slew(&[&plan[..], &uncertain].concat())
        .ends(3)
        .tells("E0171")
        .tells("their covariances and flights");
    // The margin below the limits remains for the regulator, and the arcs of the plan are at the
    // reduced limits.
    let reserve = ["--set", "actuators.torque_limit_reserve_n_m=5", "-o", "reserve.json"];
    folder.slew(&[&plan[..], &reserve].concat()).ends(0).tells("would make arc 3");
    let held = &folder.json("reserve.json")["feedback"]["arcs"];
    let longest: f64 = held.as_array().unwrap().iter().map(|arc| number(&arc["length_s"])).sum();
    // Least time at rest to rest is as the root of the torque.
    assert!((longest - length / 0.9_f64.sqrt()).abs() < 1e-3, "{longest}");
    folder
        .slew(&[&plan[..], &["--set", "feedback.every_s=1"]].concat())
        .ends(3)
        .tells("E0176")
        .tells("the duration is free");
    let effort = format!("{problems}xte_20s.toml");
    folder.slew(&["plan", &effort, "--set", "feedback.kind=switching"]).ends(3).tells("inputs do not switch");
}

/// Bodies that translate have gains of twelve states, forces first; torques fixed in the reference
/// frame have gains as well, and both may be measured at every so many steps. Nothing is known of
/// their covariance.
#[test]
fn plans_of_poses_have_gains_and_no_covariance() {
    let folder = Folder::new();
    let problems = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/");
    let spec = format!("{problems}free_flyer.toml");
    folder
        .slew(&["plan", &spec, "-o", "plan.json", "--set", "feedback.kind=neighbouring"])
        .ends(0)
        .tells("feedback    neighbouring gains of the pose, held");
    let plan = folder.json("plan.json");
    let first = plan["feedback"]["gains"][0].as_array().unwrap();
    assert!(first.len() >= 6 && first.iter().all(|row| row.as_array().unwrap().len() == 12));
    let slower = ["plan", &spec, "-o", "slower.json", "--set", "feedback.every_s=0.2"];
    folder.slew(&slower).ends(0).tells("of the pose every 0.200 s, held");
    let slower = &folder.json("slower.json")["feedback"];
    assert_eq!(slower["every_steps"], 5);
    assert!(slower["gains"][0] == slower["gains"][4] && slower["gains"][4] != slower["gains"][5]);
    folder.slew(&["export", "plan.json", "-o", "plan.flight"]).ends(0);
    assert!(fs::read_to_string(folder.path("plan.flight")).unwrap().contains("gain_1_position_x"));
    let uncertain = ["--set", "uncertainty.inertia.relative=0.01"];
    folder.slew(&[&["plan", &spec][..], &uncertain].concat()).ends(3).tells("E0170");
}

/// Two stops, the first one held, with an uncertain inertia.
const STOPS: &str = r#"
format = 1
name = "two stops"
[body]
inertia_kg_m2 = [1, 2, 2.5]
[actuators]
torque_limit_n_m = 0.5
torque_limit_reserve_n_m = 0.1
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[maneuver]
minimize = "time"
steps = 40
[[stop]]
name = "near"
attitude = { axis = [1, 0, 0], angle_deg = 50 }
hold_s = 8
[[stop]]
name = "far"
attitude = { axis = [1, 0, 0], angle_deg = 120 }
settling_s = 2
[[constraint]]
kind = "rate_limit"
angular_velocity_limit_deg_s = 30
margin_deg_s = 5
[uncertainty]
inertia = { relative = 0.02 }
[feedback]
"#;

/// A sequence is flown over all legs and holds: each stop has its errors, which gains make small, and
/// which the end of the hold has less of. The plan keeps the reserves of its limits.
#[test]
fn a_sequence_flies_over_all_its_stops() {
    let folder = planned(STOPS);
    folder.slew(&["check", "spec.toml"]).ends(0).tells("flight      [feedback], [uncertainty]");
    let plan = folder.json("plan.json");
    for leg in plan["legs"].as_array().unwrap() {
        let verified = &leg["verified"];
        assert!(number(&verified["peak_rate_rad_s"]) < 25.001_f64.to_radians(), "{verified}");
        assert!(number(&verified["peak_torque_n_m"]) < 0.4001 * 3_f64.sqrt(), "{verified}");
    }
    let run = folder.slew(&["fly", "plan.json", "--cases", "300", "--format", "json", "-q"]).ends(0).json();
    for (one, closed) in run["loops"].as_array().unwrap().iter().zip([true, false]) {
        let stops = one["stops"].as_array().unwrap();
        let of = |mark: &Value| {
            (mark["stop"].as_str().unwrap().to_string(), mark["event"].as_str().unwrap().to_string())
        };
        let marks: Vec<_> = stops.iter().map(of).collect();
        let told = |stop: &str, event: &str| (stop.to_string(), event.to_string());
        assert_eq!(
            marks,
            [told("near", "hold begins"), told("near", "hold ends"), told("far", "hold begins")]
        );
        let off = |index: usize| number(&stops[index]["angle_quantiles_deg"][0]);
        assert!(if closed { off(0) < 0.1 && off(1) < 0.1 * off(0) } else { off(0) > 0.2 }, "{stops:?}");
        // The last instant is the end.
        assert_eq!(stops[2]["angle_quantiles_deg"], one["end"]["angle_quantiles_deg"]);
    }
    let fly = |cases: &str| folder.slew(&["fly", "plan.json", "--cases", cases, "--keep", "k.jsonl"]).ends(0);
    fly("20");
    fly("40").tells("after 20 cases").tells("near, hold ends at");
    folder.slew(&["fly", "plan.json", "--cases", "40", "-q", "-o", "cases.csv"]).ends(0);
    let head = folder.read("cases.csv");
    assert!(head.lines().next().unwrap().contains("\"attitude_error near, hold begins_rad\""), "{head}");
    folder.slew(&["fly", "plan.json", "--case", "3", "-o", "one.csv"]).ends(0).tells("case        3");
    folder.slew(&["verify", "plan.json"]).ends(0);
    // A first stop at the start has a leg of no duration.
    fs::write(folder.path("here.toml"), STOPS.replace("angle_deg = 50", "angle_deg = 0")).unwrap();
    folder.slew(&["plan", "here.toml", "-q", "-o", "here.json"]).ends(0);
    folder.slew(&["fly", "here.json", "--cases", "10"]).ends(0).tells("far, hold begins at");
    let mut tampered = folder.json("here.json");
    tampered["legs"][0]["trajectory"]["quaternion_wxyz"] = Value::Array(Vec::new());
    fs::write(folder.path("tampered.json"), tampered.to_string()).unwrap();
    folder.slew(&["fly", "tampered.json"]).ends(8);
    fs::write(folder.path("long.toml"), STOPS.replace("hold_s = 8", "hold_s = 1e6")).unwrap();
    folder.slew(&["plan", "long.toml", "-q", "-o", "long.json"]).ends(0);
    folder.slew(&["fly", "long.json"]).ends(8).tells("E0170").tells("shorter holds");
}
