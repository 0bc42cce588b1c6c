//! Mistakes of a first-time user: every hint leads on.

use super::binary::Folder;
use serde_json::Value;
use std::fs;

/// Returns the folder with the spec that `slew init` writes for a purpose.
fn begun(purpose: &str) -> Folder {
    let folder = Folder::new();
    folder.slew(&["init", "--for", purpose, "-o", "begun.toml"]).ends(0);
    folder
}

#[test]
fn a_spec_to_start_from_is_planned_as_it_is() {
    for (purpose, told) in [("wheels", "RW4"), ("time", "minimum time"), ("thrusters", "T8")] {
        let folder = begun(purpose);
        let run = folder.slew(&["plan", "begun.toml", "-v"]).ends(0).tells("solved and verified").tells(told);
        assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    }
}

/// Thrusters given by place and force appear as forces with their names in summary, page and plan
/// file.
#[test]
fn thrusters_are_shown_as_they_were_told() {
    let folder = begun("thrusters");
    let run = folder.slew(&["plan", "begun.toml", "-v", "-o", "plan.json"]).ends(0);
    let run = run.tells(" N (largest of 8); 100 % of 1");
    let run = run.tells("firings, the shortest ").tells(" N·s, minimum fuel");
    // The summary lists the thrusters by name, with times of the plan's rows: a thruster is on if
    // its input is.
    let plan = folder.json("plan.json");
    let names = plan["spec"]["names"]["inputs"].as_array().unwrap();
    let rows = plan["trajectory"]["input"].as_array().unwrap();
    for (index, name) in names.iter().enumerate() {
        let on = rows.iter().any(|row| row[index].as_f64().unwrap() > 1e-6);
        let told = run.stderr.contains(&format!("{} on ", name.as_str().unwrap()));
        assert_eq!(on, told, "{name}: {}", run.stderr);
    }
    // The sum of all impulses is the objective.
    let push = run.stderr.split("net of ").nth(1).unwrap().split(' ').next().unwrap();
    let (push, cost): (f64, f64) = (push.parse().unwrap(), plan["cost"].as_f64().unwrap());
    assert!((push / cost - 1.0).abs() < 5e-3, "{push} {cost}");
    // The plan keeps the positions of the thrusters, and is judged by them.
    let thruster = &plan["spec"]["actuators"]["thruster"][0];
    assert_eq!(thruster["position_m"], serde_json::json!([0.5, 0.0, 0.4]));
    assert_eq!(thruster["force_limit_n"], 1.0);
    let judged = folder.slew(&["verify", "plan.json", "--spec", "begun.toml"]).ends(0);
    assert!(!judged.stderr.contains("differs"), "{}", judged.stderr);
    folder.slew(&["report", "plan.json", "-o", "page.html"]).ends(0);
    let page = folder.read("page.html");
    for wanted in ["id=\"fig-firings\"", "<h2>Firings</h2>", "input, N\"", "inputs, N<"] {
        assert!(page.contains(wanted), "{wanted}");
    }
}

#[test]
fn a_direction_that_thrusters_lack_is_named() {
    let folder = begun("thrusters");
    let text = folder.read("begun.toml");
    // No thruster turns the body about y if the last four are missing.
    let few = text.split("[[actuators.thruster]]\nname = \"T5\"").next().unwrap();
    fs::write(folder.path("few.toml"), few).unwrap();
    let run =
        folder.slew(&["plan", "few.toml"]).ends(3).tells("E0029").tells("nothing turns the body about (0, ");
    assert!(!run.stderr.contains("minimise effort"), "thrusters have no effort: {}", run.stderr);
    let effort = ["--set", "maneuver.minimize=\"effort\""];
    folder.slew(&["plan", "few.toml", effort[0], effort[1]]).ends(3).tells("nothing turns the body about");
}

#[test]
fn tables_of_results_are_what_their_names_say() {
    let folder = Folder::new();
    let sweep = ["sweep", "spec.toml", "--over", "maneuver.duration_s=8,10,12"];
    let with = |more: &[&str]| folder.slew(&[&sweep[..], more].concat());
    with(&["-o", "s.jsonl"]).ends(0).tells("cheapest    case 3").tells("costliest   case 1");
    with(&["-o", "s.csv"]).ends(0);
    folder.slew(&["merge", "s.jsonl", "-o", "r.csv"]).ends(0);
    assert_eq!(folder.read("s.csv"), folder.read("r.csv"));
    // A table as any program reads it: as many cells in each row as in the head, and the numbers of
    // the results.
    let text = folder.read("s.csv");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 4);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let lines = folder.read("s.jsonl");
    for (row, line) in rows[1..].iter().zip(lines.lines().skip(1)) {
        let result: Value = serde_json::from_str(line).unwrap();
        assert_eq!(row[column("cost")].parse::<f64>().unwrap(), result["cost"].as_f64().unwrap());
        assert_eq!(row[column("objective")], "effort");
        let duration: f64 = row[column("maneuver.duration_s")].parse().unwrap();
        assert_eq!(duration, result["duration_s"].as_f64().unwrap());
    }
    for name in ["r.foo", "r", "r.json"] {
        with(&["-o", name]).ends(2).tells("E0105").tells(".csv");
        folder.slew(&["merge", "s.jsonl", "-o", name]).ends(2).tells("E0105");
        assert!(!folder.path(name).exists());
    }
    with(&["-o", "part.csv", "--shard", "1/3"]).ends(2).tells("E0107").tells("slew merge");
}

#[test]
fn costs_of_several_objectives_are_kept_apart() {
    let folder = Folder::new();
    let limit = ["--set", "actuators.torque_limit_n_m=0.5"];
    let over = ["--over", "maneuver.minimize=\"effort\",\"fuel\""];
    let run =
        folder.slew(&["sweep", "spec.toml", limit[0], limit[1], over[0], over[1], "-o", "s.jsonl"]).ends(0);
    run.tells("effort: median").tells("fuel: median").tells(", effort ").tells(", fuel ");
}

#[test]
fn rest_in_orbit_is_a_word() {
    let folder = Folder::new();
    let spec = r#"
format = 1
[body]
inertia_kg_m2 = [100, 80, 60]
[environment]
kind = "gravity_gradient"
orbital_rate_rad_s = 0.001
[start]
attitude = { axis = [1, 0, 0], angle_deg = 30 }
angular_velocity = "at rest in LVLH"
[end]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
angular_velocity = "at rest in LVLH"
[maneuver]
duration_s = 200
steps = 50
"#;
    fs::write(folder.path("orbit.toml"), spec).unwrap();
    folder.slew(&["plan", "orbit.toml", "-q", "-o", "plan.json"]).ends(0);
    // Ω = orbital rate · Rᵀ e₂, and Rᵀ e₂ of a turn by 30° about x is (0, cos 30°, −sin 30°).
    let plan = folder.json("plan.json");
    let rate = |end: &str, axis: usize| plan["spec"][end]["angular_velocity_rad_s"][axis].as_f64().unwrap();
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    for (end, wanted) in [("start", [0.0, 1e-3 * cos, -1e-3 * sin]), ("end", [0.0, 1e-3, 0.0])] {
        for (axis, wanted) in wanted.into_iter().enumerate() {
            assert!((rate(end, axis) - wanted).abs() < 1e-15, "{end} {axis}");
        }
    }
    // Against axes with z to nadir the same attitudes are other numbers: half a turn about the
    // velocity, after which (1, 0, 0) by 210° stands where (1, 0, 0) by 30° did.
    let nadir = spec
        .replace(
            "orbital_rate_rad_s = 0.001\n",
            "orbital_rate_rad_s = 0.001\nlvlh_axes = \"velocity_antinormal_nadir\"\n",
        )
        .replace("angle_deg = 30", "angle_deg = 210")
        .replace("axis = [0, 0, 1], angle_deg = 0", "axis = [1, 0, 0], angle_deg = 180");
    fs::write(folder.path("nadir.toml"), nadir).unwrap();
    folder.slew(&["plan", "nadir.toml", "-q", "-o", "nadir.json"]).ends(0);
    let other = folder.json("nadir.json");
    for end in ["start", "end"] {
        let matrix = |plan: &Value, row: usize, column: usize| {
            plan["spec"][end]["attitude"]["matrix"][row][column].as_f64().unwrap()
        };
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            assert!((matrix(&plan, row, column) - matrix(&other, row, column)).abs() < 1e-15, "{end}");
        }
    }
    let (cost, same) = (plan["cost"].as_f64().unwrap(), other["cost"].as_f64().unwrap());
    assert!((cost / same - 1.0).abs() < 1e-9, "{cost} {same}");
    let bare = spec.replace("angular_velocity = \"at rest in LVLH\"\n", "");
    fs::write(folder.path("bare.toml"), &bare).unwrap();
    folder.slew(&["plan", "bare.toml"]).ends(3).tells("\"at rest in LVLH\"").tells("nadir");
    let nowhere =
        "[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\nangular_velocity = \"at rest in LVLH\"";
    let spec =
        folder.read("spec.toml").replace("[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }", nowhere);
    fs::write(folder.path("nowhere.toml"), spec).unwrap();
    folder.slew(&["plan", "nowhere.toml"]).ends(3).tells("E0028").tells("gravity_gradient");
}

#[test]
fn what_is_plain_is_understood() {
    let folder = Folder::new();
    // Three numbers are a direction.
    let cone = |direction: &str| {
        format!(
            "constraint=[{{ kind = \"keep_out\", name = \"Sun\", boresight_body = [1, 0, 0], \
                direction_inertial = {direction}, half_angle_deg = 10 }}]"
        )
    };
    let planned = |set: &str, name: &str| {
        folder.slew(&["plan", "spec.toml", "-q", "--set", set, "-o", name]).ends(0);
        let mut spec = folder.json(name)["spec"].clone();
        spec["name"] = Value::Null;
        spec
    };
    assert_eq!(planned(&cone("[0, 0, 1]"), "a.json"), planned(&cone("{ vector = [0, 0, 1] }"), "b.json"));
    // 321 is zyx.
    let text = folder.read("spec.toml");
    fs::write(folder.path("letters.toml"), &text).unwrap();
    fs::write(folder.path("numbers.toml"), text.replace("euler_zyx_deg", "euler_321_deg")).unwrap();
    for name in ["letters", "numbers"] {
        folder.slew(&["plan", &format!("{name}.toml"), "-q", "-o", &format!("{name}.json")]).ends(0);
    }
    assert_eq!(folder.json("letters.json")["spec"]["end"], folder.json("numbers.json")["spec"]["end"]);
    // A plan file is not a spec, and the message names the command that accepts it.
    folder.slew(&["plan", "letters.json"]).ends(3).tells("E0018").tells("a plan file").tells("slew verify");
    // All codes, of which each is explained.
    let codes = folder.slew(&["explain"]).ends(0).stdout;
    assert!(codes.lines().count() > 50);
    for line in [codes.lines().next().unwrap(), codes.lines().last().unwrap()] {
        let (code, title) = line.split_once(' ').unwrap();
        assert!(folder.slew(&["explain", code]).ends(0).stdout.contains(title));
    }
}

#[test]
fn the_page_of_what_is_infeasible_says_what_would_do() {
    let folder = Folder::new();
    let set = ["--set", "actuators.torque_limit_n_m=0.01"];
    let run = folder.slew(&["plan", "spec.toml", set[0], set[1], "--report", "page.html"]).ends(4);
    let longer = run.stderr.split("maneuver.duration_s=").nth(1).unwrap();
    let longer: String = longer.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    let page = folder.read("page.html");
    assert!(
        page.contains("<dt>would do</dt>") && page.contains(&format!("duration_s = {longer}")),
        "{longer}"
    );
}
