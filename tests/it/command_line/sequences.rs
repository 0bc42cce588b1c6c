//! Specs with stops: `slew plan`, `check`, `verify`, `export`, `report` and `plot` of sequences,
//! and their refusals.

use super::binary::Folder;
use std::fs;

/// Two stops of a free body, the second one in a window.
const STOPS: &str = r#"
format = 1
name = "two stops"
epoch = "2026-11-21T07:00:00 UTC"
[names]
reference_frame = "ICRF"
center = "EARTH"
spice_id = -42
[body]
inertia_kg_m2 = [1, 2, 2.5]
[actuators]
torque_limit_n_m = 0.5
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[maneuver]
minimize = "time"
order = "free"
steps = 40
[[stop]]
name = "far"
attitude = { axis = [1, 0, 0], angle_deg = 120 }
settling_s = 2
hold_s = 10
[[stop]]
name = "near"
attitude = { axis = [1, 0, 0], angle_deg = 50 }
hold_s = 5
window_s = [8, 20]
"#;

fn planned() -> Folder {
    let folder = Folder::new();
    fs::write(folder.path("stops.toml"), STOPS).unwrap();
    folder.slew(&["plan", "stops.toml", "-q", "-o", "plan.json"]).ends(0);
    folder
}

#[test]
fn stops_are_planned_checked_and_verified() {
    let folder = planned();
    folder.slew(&["check", "stops.toml"]).ends(0).tells("2 stops, in the best order");
    let run = folder.slew(&["plan", "stops.toml", "-o", "again.json", "--report", "page.html"]).ends(0);
    run.tells("solved and verified").tells("in the best order for the legs that were found").tells("far");
    let json = folder.json("plan.json");
    assert_eq!((json["status"].as_str(), json["exit_code"].as_u64()), (Some("solved"), Some(0)));
    let names: Vec<&str> =
        json["stops"].as_array().unwrap().iter().map(|stop| stop["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["near", "far"]);
    let near = &json["stops"][0];
    // The body waits until the window opens.
    assert_eq!((near["hold_begins_s"].as_f64(), near["leaves_s"].as_f64()), (Some(8.0), Some(13.0)));
    assert_eq!(json["stops"][1]["leg_begins_s"].as_f64(), Some(13.0));
    folder.slew(&["verify", "plan.json"]).ends(0).tells("2 of 2 legs verified");
    folder.slew(&["verify", "plan.json", "--spec", "stops.toml"]).ends(0).tells("verified");
    // Equal inputs give equal files but for the time of each solve.
    let without_times = |name: &str| {
        let text = folder.read(name);
        let parts =
            text.split("\"solve_time_s\": ").map(|part| part.split_once(',').map_or(part, |(_, rest)| rest));
        parts.collect::<Vec<_>>().concat()
    };
    assert_eq!(without_times("plan.json"), without_times("again.json"));
    assert!(folder.read("page.html").contains("Timeline"));
    folder.slew(&["report", "plan.json", "-o", "later.html"]).ends(0);
    assert_eq!(folder.read("page.html"), folder.read("later.html"));
    folder.slew(&["plot", "plan.json", "-o", "pictures"]).ends(0);
    assert!(folder.read("pictures/timeline.svg").contains("<svg"));
}

#[test]
fn a_leg_of_a_sequence_is_a_plan() {
    let folder = planned();
    let legs = folder.json("plan.json")["legs"].clone();
    fs::write(folder.path("leg.json"), legs[1].to_string()).unwrap();
    folder.slew(&["verify", "leg.json"]).ends(0).tells("verified");
    folder.slew(&["export", "leg.json", "-o", "leg.aem"]).ends(0);
    // It begins when the first hold ends.
    assert!(
        folder.read("leg.aem").contains("START_TIME = 2026-11-21T07:00:13.000"),
        "{}",
        folder.read("leg.aem")
    );
}

#[test]
fn every_format_has_the_whole() {
    let folder = planned();
    for (name, start) in [
        ("plan.xml", &b"<?xml"[..]),
        ("plan.apm", b"CCSDS_APM_VERS = 2.0"),
        ("plan.a", b"stk.v."),
        ("plan.bc", b"DAF/CK  "),
        ("plan.npz", b"PK\x03\x04"),
        ("plan.mat", b"MATLAB 5.0"),
        ("plan.42", b"0.0000000000000000e0 "),
        ("plan.jsonl", b"{\"time_s\""),
    ] {
        folder.slew(&["export", "plan.json", "-o", name]).ends(0).tells("wrote");
        assert!(fs::read(folder.path(name)).unwrap().starts_with(start), "{name}");
    }
    // A segment for each leg and each rest, and an additional one where inputs switch.
    let aem = folder.slew(&["export", "plan.json", "--format", "aem"]).ends(0).stdout;
    assert!(aem.matches("META_START").count() >= 4);
    let csv = folder.slew(&["export", "plan.json", "--format", "csv"]).ends(0).stdout;
    let times: Vec<f64> =
        csv.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    let end = folder.json("plan.json")["duration_s"].as_f64().unwrap();
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]) && times.first() == Some(&0.0));
    assert_eq!(times.last(), Some(&end));
}

#[test]
fn a_file_that_was_changed_is_refused() {
    let folder = planned();
    let text = folder.read("plan.json");
    for (key, from, to, told) in [
        ("a time", "\"leaves_s\":13.0", "\"leaves_s\":12.0", "recorded times of near"),
        ("a name", "\"name\":\"near\",\"leg", "\"name\":\"other\",\"leg", "is a stop of the spec"),
        ("the status", "\"late_s\": 0.0", "\"late_s\": 1.0", "recorded checksum"),
    ] {
        let changed = text.replace(from, to);
        let changed = if changed == text {
            text.replace(&from.replace(':', ": "), &to.replace(':', ": "))
        } else {
            changed
        };
        assert_ne!(changed, text, "{key}");
        fs::write(folder.path("changed.json"), changed).unwrap();
        folder.slew(&["verify", "changed.json"]).ends(7).tells(told);
        folder.slew(&["report", "changed.json", "-o", "changed.html", "--force"]).ends(7).tells("E0153");
    }
    // The plan fulfils no spec with a longer hold.
    fs::write(folder.path("longer.toml"), STOPS.replace("hold_s = 5", "hold_s = 6")).unwrap();
    folder.slew(&["verify", "plan.json", "--spec", "longer.toml"]).ends(7).tells("near");
    fs::write(folder.path("weaker.toml"), STOPS.replace("torque_limit_n_m = 0.5", "torque_limit_n_m = 0.4"))
        .unwrap();
    folder.slew(&["verify", "plan.json", "--spec", "weaker.toml"]).ends(7).tells("torque limit");
}

#[test]
fn windows_that_cannot_be_kept_are_told() {
    let folder = planned();
    let set = |window: &str| {
        ["plan".to_string(), "stops.toml".into(), "--set".into(), format!("stop.1.window_s={window}")]
    };
    let run = |window: &str| folder.slew(&set(window).iter().map(String::as_str).collect::<Vec<_>>());
    // No turn by 50° takes less than 2.6 s.
    run("[0, 7]").ends(4).tells("no plan can keep the window of `near`");
    // What the bound leaves open, the plans miss.
    run("[0, 7.6]").ends(5).tells("not converged").tells("late");
    run("[0, 40]").ends(0);
}

#[test]
fn commands_of_one_maneuver_refuse_stops() {
    let folder = planned();
    for command in [&["simulate"][..], &["compare"], &["table", "-o", "table.npz"], &["sky"]] {
        folder.slew(&[command, &["stops.toml"]].concat()).ends(3).tells("E0018");
    }
    folder.slew(&["fly", "plan.json"]).ends(8).tells("the plan has no uncertainty");
    folder.slew(&["plan", "spec.toml", "--guess", "plan.json"]).ends(8).tells("the plan is a sequence");
    folder.slew(&["plan", "stops.toml", "--guess", "plan.json"]).ends(2).tells("--guess");
    folder.slew(&["verify", "plan.json", "--spec", "spec.toml"]).ends(3).tells("has no stops");
}

/// Nadir, which is followed, and a star; one of two star trackers is off the Sun.
const FOLLOWED: &str = r#"
format = 1
name = "a pass"
epoch = "2026-11-21T07:00:00 UTC"
[orbit]
semi_major_axis_m = 7000e3
eccentricity = 0.001
inclination_deg = 98
raan_deg = 40
argument_of_perigee_deg = 0
true_anomaly_deg = 30
[names]
reference_frame = "ICRF"
center = "EARTH"
spice_id = -42
[body]
inertia_kg_m2 = [1, 2, 2.5]
[actuators]
torque_limit_n_m = 0.5
[start]
point = { boresight_body = [0, 0, 1], ra_deg = 60, dec_deg = -30 }
second = { axis_body = [1, 0, 0], vector = [0, 0, 1] }
[maneuver]
minimize = "time"
steps = 40
[[stop]]
name = "nadir"
point = { boresight_body = [0, 0, 1], at = "nadir" }
hold_s = 60
[[stop]]
name = "star"
point = { boresight_body = [0, 0, 1], ra_deg = 60, dec_deg = -30 }
hold_s = 10
[[constraint]]
name = "tracker A"
kind = "keep_out"
boresight_body = [1, 0, 0]
direction = "sun"
half_angle_deg = 25
[[constraint]]
name = "tracker B"
kind = "keep_out"
boresight_body = [-1, 0, 0]
direction = "sun"
half_angle_deg = 25
[[any_of]]
name = "trackers"
set = [{ constraints = ["tracker A"] }, { constraints = ["tracker B"] }]
"#;

#[test]
fn a_target_that_moves_is_followed_and_judged() {
    let folder = Folder::new();
    fs::write(folder.path("pass.toml"), FOLLOWED).unwrap();
    let run = folder.slew(&["plan", "pass.toml", "-o", "plan.json", "--report", "page.html"]).ends(0);
    run.tells("solved and verified").tells("s at stops");
    folder.slew(&["verify", "plan.json"]).ends(0).tells("2 of 2 holds verified");
    folder.slew(&["verify", "plan.json", "--spec", "pass.toml"]).ends(0);
    folder.slew(&["export", "plan.json", "-o", "plan.aem"]).ends(0);
    let json = folder.json("plan.json");
    let hold = &json["holds"][0];
    assert_eq!(hold["proof"].as_str(), Some("feasible"));
    // The body turns with its orbit, 0.0617 deg/s, and with it alone.
    let rates = hold["trajectory"]["angular_velocity_rad_s"].as_array().unwrap();
    for rate in rates {
        let size: f64 = rate.as_array().unwrap().iter().map(|part| part.as_f64().unwrap().powi(2)).sum();
        assert!((size.sqrt().to_degrees() - 0.0617).abs() < 5e-4, "{size}");
    }
    // Another target, or a longer hold, is not what the plan has.
    let other = FOLLOWED.replace("at = \"nadir\"", "at = \"along_track\"");
    fs::write(folder.path("other.toml"), other).unwrap();
    folder.slew(&["verify", "plan.json", "--spec", "other.toml"]).ends(7).tells("rad from the target");
    let longer = FOLLOWED.replace("hold_s = 60", "hold_s = 70");
    fs::write(folder.path("longer.toml"), longer).unwrap();
    folder.slew(&["verify", "plan.json", "--spec", "longer.toml"]).ends(7).tells("end of the hold at nadir");
    // A rate of the hold that is no longer that of its attitudes.
    let mut text = fs::read_to_string(folder.path("plan.json")).unwrap();
    let after = |from: usize, what: &str| from + text[from..].find(what).unwrap() + what.len();
    let digit = after(after(after(0, "\"holds\""), "\"angular_velocity_rad_s\""), ".");
    text.replace_range(digit..digit + 1, if &text[digit..=digit] == "5" { "6" } else { "5" });
    fs::write(folder.path("damaged.json"), text).unwrap();
    folder.slew(&["verify", "damaged.json"]).ends(7).tells("hold at nadir");
}

/// A sweep over the window of a stop: each case is the plan that `--set` gives, in its own order.
#[test]
fn batches_take_sequences() {
    let folder = Folder::new();
    fs::write(folder.path("stops.toml"), STOPS).unwrap();
    let over = "stop.1.window_s=[8,20],[25,60],[0,5.5]";
    let run = folder.slew(&["sweep", "stops.toml", "--over", over, "-o", "all.jsonl", "--plans", "plans"]);
    run.ends(9).tells("2 of 3 solved");
    let results: Vec<serde_json::Value> =
        folder.read("all.jsonl").lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(results[0]["stops"], serde_json::json!(["near", "far"]));
    assert_eq!(results[1]["stops"], serde_json::json!(["far", "near"]));
    for (index, window) in ["[8,20]", "[25,60]"].into_iter().enumerate() {
        let set = format!("stop.1.window_s={window}");
        let plan = folder.slew(&["plan", "stops.toml", "-q", "--format", "json", "--set", &set]).ends(0);
        let (plan, result) = (plan.json(), &results[index]);
        for key in ["status", "exit_code", "cost", "duration_s", "late_s"] {
            assert_eq!(plan[key], result[key], "{key}");
        }
        assert_eq!(result["verified"]["passed"], true);
        let kept = folder.json(&format!("plans/case-{}.json", index + 1));
        assert_eq!(kept["checksum"], plan["checksum"]);
    }
    // The second stop cannot hold before its window closes.
    assert_eq!(
        (results[2]["status"].as_str(), results[2]["exit_code"].as_u64()),
        (Some("infeasible"), Some(4))
    );
    assert!(results[2]["obstruction"].as_str().unwrap().starts_with("no plan can keep the window"));
    folder.slew(&["merge", "all.jsonl", "-o", "all.csv"]).ends(0);
    assert!(folder.read("all.csv").contains("\"[\"\"near\"\",\"\"far\"\"]\""));
}

/// A telescope and a star tracker, which has the only cone; wheels; a window by dates.
const OBSERVED: &str = r#"
format = 1
name = "observations"
epoch = "2026-11-21T07:00:00 UTC"
[body]
inertia_kg_m2 = [20, 18, 12]
[actuators]
wheel = [
    { name = "A", axis_body = [1, 0, 0], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
    { name = "B", axis_body = [0, 1, 0], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
    { name = "C", axis_body = [0, 0, 1], torque_limit_n_m = 0.2, momentum_limit_n_m_s = 2 },
]
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[maneuver]
minimize = "time"
steps = 40
[[stop]]
name = "Crab"
point = { boresight_body = [0, 0, 1], boresight_name = "telescope", ra_deg = 83.633, dec_deg = 22.014 }
second = { axis_body = [1, 0, 0], vector = [0, 0, 1] }
hold_s = 10
WINDOW
[[stop]]
name = "Vela"
point = { boresight_body = [0, 0, 1], boresight_name = "telescope", ra_deg = 128.836, dec_deg = -45.176 }
second = { axis_body = [1, 0, 0], vector = [0, 0, 1] }
[[constraint]]
kind = "keep_out"
name = "star tracker off the Sun and its corona"
boresight_body = [0, -1, 0]
direction = { vector = [-1, -0.3, 0] }
half_angle_deg = 20
"#;

/// Returns the numbers that a summary has under a label.
fn numbers_of(text: &str, label: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.trim_start().starts_with(label));
    let line = line.unwrap_or_else(|| panic!("no {label} in {text}"));
    line.split([' ', ';']).filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_sequence_is_summarised_as_one_maneuver_is() {
    let folder = Folder::new();
    let spec =
        OBSERVED.replace("WINDOW", "window = [\"2026-11-21T07:01:00 UTC\", \"2026-11-21T07:02:00 UTC\"]");
    fs::write(folder.path("dates.toml"), &spec).unwrap();
    let run = folder.slew(&["plan", "dates.toml", "-o", "plan.json", "--report", "page.html"]).ends(0);
    let run = run.tells("slew report plan.json -o plan.html").tells("each leg is a local minimum to");
    // The peaks of the wheels are those of the file.
    let json = folder.json("plan.json");
    let peak = |key: &str, wheel: usize| {
        let legs = json["legs"].as_array().unwrap();
        let parts = legs.iter().chain(json["holds"].as_array().into_iter().flatten());
        let rows = parts.flat_map(|part| part["trajectory"][key].as_array().into_iter().flatten());
        rows.map(|row| row[wheel].as_f64().unwrap().abs()).fold(0.0, f64::max)
    };
    for (label, key, limit) in [("wheels", "input", 0.2), ("momentum", "wheel_momentum_n_m_s", 2.0)] {
        let told = numbers_of(&run.stderr, label);
        let [a, b, c, part, of] = told[..] else { panic!("{label}: {told:?}") };
        let peaks = [0, 1, 2].map(|wheel| peak(key, wheel));
        for (told, found) in [a, b, c].into_iter().zip(peaks) {
            assert!((told - found).abs() <= 6e-3 * found, "{label}: {told} {found}");
        }
        let largest = peaks.into_iter().fold(0.0, f64::max);
        assert!((part - 100.0 * largest / limit).abs() < 0.6 && of == limit, "{label}: {part} {of}");
    }
    // The terminal breaks the line, the page does not.
    let clearance = "star tracker off the Sun and its corona: 0.0534 deg, on the leg to Vela";
    assert!(!run.stderr.contains(clearance), "{}", run.stderr);
    let page = folder.read("page.html");
    assert!(page.contains(&format!("<dd>{clearance}</dd>")));
    // The target of each stop is on the track of the telescope, although only the star tracker has a
    // cone.
    let data = super::page::data(&page);
    let sky = super::page::picture(&data, "sky");
    let names: Vec<&str> =
        sky["tracks"].as_array().unwrap().iter().map(|track| track["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["telescope", "boresight −y"]);
    for (name, [ra, dec]) in [("1", [83.633_f64, 22.014_f64]), ("2", [128.836, -45.176])] {
        let marks = sky["marks"].as_array().unwrap();
        let mark = marks.iter().find(|mark| mark["name"] == name).unwrap();
        let at: Vec<f64> = mark["at"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let (ra, dec) = (ra.to_radians(), dec.to_radians());
        let wanted = [dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin()];
        let off: f64 = at.iter().zip(wanted).map(|(a, b)| (a - b).powi(2)).sum();
        assert!(off.sqrt() < 1e-6, "{name}: {at:?}");
    }
    folder.slew(&["report", "plan.json", "-o", "later.html"]).ends(0);
    assert_eq!(page, folder.read("later.html"));
}

#[test]
fn dates_of_windows_are_seconds_from_the_epoch() {
    let folder = Folder::new();
    let stops = |window: &str| {
        fs::write(folder.path("stops.toml"), OBSERVED.replace("WINDOW", window)).unwrap();
        folder.slew(&["plan", "stops.toml", "-o", "plan.json", "--force", "-q"]).ends(0);
        folder.json("plan.json")["stops"].clone()
    };
    // TAI is 37 s ahead of UTC.
    for (dates, seconds, begins) in [
        (
            r#"window = ["2026-11-21T07:01:00 UTC", "2026-11-21T07:02:17.5 TAI"]"#,
            "window_s = [60, 100.5]",
            60.0,
        ),
        (r#"start = "2026-11-21T07:01:00.25 UTC""#, "start_s = 60.25", 60.25),
    ] {
        let (dated, counted) = (stops(dates), stops(seconds));
        assert_eq!(dated, counted, "{dates}");
        assert_eq!(dated[0]["hold_begins_s"].as_f64(), Some(begins));
    }
}
