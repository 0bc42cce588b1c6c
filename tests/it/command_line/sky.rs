//! The summary and the pictures of a plan to a target in the sky, and the light that `slew sky`
//! reports.

use super::binary::Folder;
use super::page::{data, picture, problem};
use slewkit_files::spec::{self, Format, Spec};
use std::fs;
use std::path::Path;

/// A spec whose orbit is a file.
const BY_FILE: &str = "format = 1\nepoch = \"2026-11-21T07:00:00 UTC\"\n[orbit]\noem = \"orbit.oem\"\n\
    [body]\ninertia_kg_m2 = [120, 100, 80]\n[start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
    [end]\npoint = { boresight_body = [0, 0, 1], at = \"nadir\" }\n[maneuver]\nduration_s = 60\nsteps = 50\n";

#[test]
fn a_report_of_a_pass_shows_what_stands_around() {
    let folder = Folder::new();
    let spec = problem("ground_pass");
    folder
        .slew(&["plan", &spec, "-o", "plan.json", "--report", "report.html", "--set", "maneuver.steps=100"])
        .ends(0)
        .tells("target      ground -4.9, -95.3, 854.5 km, 63.8 deg high, turns at 0.504 deg/s;")
        .tells("aimed at 0 s: 35.5 deg off");
    // The file has all of it: a report needs no orbit.
    folder.slew(&["report", "plan.json", "-o", "again.html"]).ends(0);
    assert_eq!(folder.read("report.html"), folder.read("again.html"));
    let page = folder.read("report.html");
    assert!(page.contains("<figure id=\"fig-ground\">") && page.contains("below the spacecraft"));
    let data = data(&page);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let Spec::Maneuver(loaded) = spec::load(Path::new(&spec), Format::Toml, &[]).unwrap() else { panic!() };
    let heavens = loaded.heavens.unwrap();
    let target = |name: &str| {
        let found = heavens.targets.iter().find(|named| named.name.starts_with(name)).unwrap();
        found.target.clone()
    };
    // Where the full theories see them, at both ends; from 777 km the Earth is 63 degrees from its
    // middle to its limb.
    for key in ["sky", "around"] {
        let discs = picture(&data, key)["discs"].as_array().unwrap();
        for (kind, name) in [("earth", "nadir"), ("sun", "sun"), ("target", "ground")] {
            let disc = discs.iter().find(|disc| disc["kind"] == kind).unwrap();
            let way = disc["way"].as_array().unwrap();
            for (at, time) in [(&way[0], 0.0), (&way[way.len() - 1], 75.0)] {
                let seen = heavens.sky.seen(&target(name), time).unwrap();
                let off = (0..3).map(|row| (number(&at[row]) - seen[row]).abs()).fold(0.0, f64::max);
                assert!(off < 3e-5, "{key} {kind} at {time}: {off:.1e}");
                let radius = number(&at[3]).to_degrees();
                let wanted = if kind == "earth" {
                    63.06
                } else if kind == "sun" {
                    0.27
                } else {
                    0.0
                };
                assert!((radius - wanted).abs() < 0.1, "{kind} {radius}");
            }
        }
    }
    // The boresight ends where the station is, half a kilometre above the ellipsoid.
    let scenery = loaded.identity.scenery.unwrap();
    let seen = heavens.sky.seen(&target("ground"), 75.0).unwrap();
    let [latitude, longitude] = scenery.on_ground(&seen, 75.0).unwrap();
    assert!((latitude + 4.9).abs() < 0.005 && (longitude + 95.3).abs() < 0.005, "{latitude} {longitude}");
    assert_eq!(scenery.on_ground(&-seen, 75.0), None);
    let [range, elevation] = scenery.station_at(75.0).unwrap();
    assert!((range / heavens.sky.range(&target("ground"), 75.0).unwrap() - 1.0).abs() < 1e-6);
    let wanted = slewkit_sky::elevation(&heavens.sky, -4.9, -95.3, 500.0, 75.0).unwrap();
    assert!((elevation - wanted).abs() < 1e-6, "{elevation} {wanted}");
}

/// A report without a sky has no scenery.
#[test]
fn a_report_without_a_sky_has_no_map_of_it() {
    let folder = Folder::new();
    folder
        .slew(&["plan", &problem("keep_out_small"), "-q", "-o", "plan.json", "--report", "page.html"])
        .ends(0);
    let page = folder.read("page.html");
    assert!(!page.contains("fig-around") && !page.contains("fig-ground"));
    assert!(picture(&data(&page), "sky")["discs"].as_array().unwrap().is_empty());
}

#[test]
fn an_orbit_that_a_spec_names_is_never_replaced() {
    let folder = Folder::new();
    let orbit = format!("{}/../../tests/bad_inputs/orbit/sky_circular.oem", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(orbit).unwrap();
    fs::write(folder.path("orbit.oem"), &text).unwrap();
    fs::write(folder.path("pass.toml"), BY_FILE).unwrap();
    folder.slew(&["plan", "pass.toml", "-q", "-o", "plan.json"]).ends(0);
    let refused = |args: &[&str]| {
        folder.slew(args).ends(8).tells("E0100");
        assert_eq!(folder.read("orbit.oem"), text);
    };
    refused(&["plan", "pass.toml", "-q", "-o", "orbit.oem", "--format", "json", "--force"]);
    refused(&[
        "sweep",
        "pass.toml",
        "--over",
        "maneuver.duration_s=60:70:2",
        "--plans",
        "orbit.oem",
        "--force",
    ]);
    fs::create_dir(folder.path("specs")).unwrap();
    fs::write(folder.path("specs/pass.toml"), BY_FILE.replace("orbit.oem", "../orbit.csv")).unwrap();
    fs::write(folder.path("page.toml"), BY_FILE.replace("orbit.oem", "orbit.html")).unwrap();
    for name in ["orbit.csv", "orbit.html"] {
        fs::write(folder.path(name), &text).unwrap();
    }
    folder.slew(&["batch", "specs", "-q", "-o", "orbit.csv", "--force"]).ends(8).tells("E0100");
    folder.slew(&["compare", "page.toml", "--report", "orbit.html", "--force"]).ends(8).tells("E0100");
    for name in ["orbit.csv", "orbit.html"] {
        assert_eq!(folder.read(name), text);
    }
}

/// A batch over a folder of specs does not mix them either.
#[test]
fn results_of_specs_with_another_orbit_are_never_mixed() {
    let folder = Folder::new();
    let orbit = format!("{}/../../tests/bad_inputs/orbit/sky_circular.oem", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(orbit).unwrap();
    fs::create_dir(folder.path("specs")).unwrap();
    fs::write(folder.path("specs/pass.toml"), BY_FILE).unwrap();
    fs::write(folder.path("specs/orbit.oem"), &text).unwrap();
    let own = ["batch", "specs", "-q", "-o", "all.jsonl"];
    folder.slew(&own).ends(0);
    folder.slew(&own).ends(0);
    fs::write(folder.path("specs/orbit.oem"), text.replace("6985.362639", "6985.362638")).unwrap();
    folder.slew(&own).ends(8).tells("error[E0112]");
}

#[test]
fn light_is_told_and_taken_as_asked() {
    let folder = Folder::new();
    let spec = problem("ground_pass");
    let plain = folder.slew(&["sky", &spec, "--format", "json"]).ends(0).json();
    let seen = ["--set", "light_time=\"one_way\"", "--set", "aberration=\"satellite\""];
    let told = folder.slew(&[&["sky", &spec, "--format", "json"], &seen[..]].concat()).ends(0).json();
    assert_eq!((&plain["aberration"], &told["aberration"]), (&false.into(), &true.into()));
    let ends = |told: &serde_json::Value, name: &str| -> [f64; 3] {
        let all = told["targets"].as_array().unwrap();
        let line = all.iter().find(|line| line["target"].as_str().unwrap().starts_with(name)).unwrap();
        let at = |index: usize| line["ra_dec_deg"][1][index].as_f64().unwrap();
        [at(0), at(1), line["by_light_arcsec"][1].as_f64().unwrap()]
    };
    for (name, least, most) in [("ground", 3.0, 7.0), ("sun", 10.0, 27.0), ("nadir", 0.0, 1e-9)] {
        let ([ra, dec, by], [seen_ra, seen_dec, _]) = (ends(&plain, name), ends(&told, name));
        let across = (seen_ra - ra) * dec.to_radians().cos();
        let moved = across.hypot(seen_dec - dec) * 3600.0;
        assert!((least..=most).contains(&by) && (moved - by).abs() < 0.02, "{name}: {moved} {by}");
    }
    assert!(folder.slew(&["sky", &spec]).ends(0).stdout.contains("directions  geometric"));
}

#[test]
fn a_target_of_several_constraints_stands_once() {
    let folder = Folder::new();
    let cone = |boresight: &str, direction: &str| {
        format!(
            "[[constraint]]\nkind = \"keep_out\"\nboresight_body = {boresight}\n\
             direction = \"{direction}\"\nhalf_angle_deg = 30\n"
        )
    };
    let spec = "format = 1\nepoch = \"2026-11-21T07:00:00 UTC\"\n[body]\ninertia_kg_m2 = [120, 100, 80]\n\
        [start]\nattitude = { axis = [0, 0, 1], angle_deg = 0 }\n\
        [end]\nattitude = { axis = [0, 0, 1], angle_deg = 10 }\n[maneuver]\nduration_s = 60\n";
    let cones = [cone("[1, 0, 0]", "sun"), cone("[0, 0, 1]", "sun"), cone("[0, 0, 1]", "moon")].concat();
    fs::write(folder.path("spec.toml"), format!("{spec}{cones}")).unwrap();
    let run = folder.slew(&["sky", "spec.toml"]).ends(0);
    for target in ["sun ", "moon "] {
        let lines = run.stdout.lines().filter(|line| line.starts_with(target)).count();
        assert_eq!(lines, 1, "{target}: {}", run.stdout);
    }
}
