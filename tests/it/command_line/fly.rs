//! `slew fly`, and what a plan tells of gains and of what is uncertain.

use super::binary::Folder;
use serde_json::Value;
use std::fs;

const FLIES: &str = r#"
format = 1
name = "flies"
[body]
inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]]
[actuators]
torque_limit_n_m = 2
[start]
attitude = { axis = [0, 0, 1], angle_deg = 0 }
[end]
attitude = { euler_zyx_deg = [80, -25, 40] }
[maneuver]
duration_s = 60
steps = 100
[[constraint]]
kind = "keep_out"
name = "Sun"
boresight_body = [1, 0, 0]
direction_inertial = { ra_deg = 45, dec_deg = 2 }
half_angle_deg = 20
chance = 0.01
[feedback]
[uncertainty]
start = { attitude_deg = 0.3, angular_velocity_deg_s = 0.005 }
inertia = { relative = 0.02, products_kg_m2 = 0.5 }
alignment = { actuators_deg = 0.3, sensor_deg = 0.02 }
actuators = { scale = 0.02, constant_n_m = 1e-4, noise_n_m_sqrt_s = 1e-4 }
sensor = { attitude_deg = 0.003, angular_velocity_deg_s = 1e-4, scale = 1e-3, bias_deg_s = 1e-5 }
"#;

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
        .tells("asked at most 0.010")
        .tells("margin      Sun");
    let plan = folder.json("plan.json");
    let gains = plan["feedback"]["gains"].as_array().unwrap();
    assert_eq!((gains.len(), gains[0].as_array().unwrap().len()), (100, 3));
    assert_eq!(gains[98], gains[99]);
    let uncertain = &plan["uncertainty"];
    let [open, closed] =
        ["open_loop", "closed_loop"].map(|of| number(&uncertain[of]["pointing"][0]["within_9973_deg"]));
    assert!(open > 20.0 * closed, "{open} {closed}");
    assert_eq!(uncertain["margins"]["agreed"], true);
    let margin = number(&uncertain["margins"]["margins_deg"][0][1]);
    let sigma = number(&uncertain["closed_loop"]["chances"][0]["sigma_deg"]);
    // Φ⁻¹(0.99).
    assert!((margin / sigma - 2.326_347_874).abs() < 1e-3, "{margin} {sigma}");
    assert!(number(&plan["cost"]) > number(&uncertain["margins"]["cost_without"]));
    // The file is judged by what it holds, sections and all.
    folder.slew(&["verify", "plan.json"]).ends(0);
}

#[test]
fn cases_agree_with_the_linear_theory_and_are_the_same_alone() {
    let folder = planned(FLIES);
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
    assert_eq!(cells[..2], ["closed loop", "17"]);
    folder.slew(&["fly", "plan.json", "--case", "17", "-o", "one.csv"]).ends(0).tells("17, closed loop");
    let last = folder.read("one.csv").lines().last().unwrap().to_string();
    let one: Vec<&str> = last.split(',').collect();
    assert_eq!(one[8..14], cells[2..8]);
    folder.slew(&["fly", "plan.json", "--cases", "20", "-o", "cases.npz"]).ends(0);
    assert!(fs::read(folder.path("cases.npz")).unwrap().starts_with(b"PK"));
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
    folder.slew(&["fly", "spec.toml"]).ends(8);
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
    assert!(rows.next().unwrap().ends_with("gain_3_rate_y,gain_3_rate_z"));
    let plan = folder.json("plan.json");
    let cells: Vec<f64> = rows.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let first: Vec<f64> = plan["feedback"]["gains"][0][0].as_array().unwrap().iter().map(number).collect();
    assert_eq!(cells[cells.len() - 18..cells.len() - 12], first);
    folder.slew(&["export", "plan.json", "-o", "plan.npz"]).ends(0);
    let archive = fs::read(folder.path("plan.npz")).unwrap();
    assert!(archive.windows(9).any(|window| window == b"gains.npy"));
}

/// Plans of least time, of wheels, in a sought duration and to a target that moves have gains too, and fly.
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
