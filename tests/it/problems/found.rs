//! Specs and messages in which somebody found a fault. Each has its right value from an independent
//! source. The specs stand in `tests/reference/found`; `evidence/best_known` has more, which
//! `maneuvers::best_known` plans.

use crate::command_line::binary::Folder;
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit_files::spec::{self, Override};
use std::fs;
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(evidence::ROOT).join("tests/reference/found").join(name)
}

/// Returns a folder with all of the files.
fn folder() -> Folder {
    let folder = Folder::new();
    for entry in fs::read_dir(file("")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path(path.file_name().unwrap().to_str().unwrap())).unwrap();
    }
    folder
}

/// Returns the plan of a file under `key=value`.
fn planned(name: &str, set: &[&str]) -> Plan {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    let loaded = spec::read(&file(&format!("{name}.toml")), &set).unwrap_or_else(|errors| panic!("{errors}"));
    plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap()
}

/// Plans cost no more than the costs found by other programs, given rolls, given paths and closed
/// forms. A plan may be cheaper, by as much as a better optimum of the same kind has been found to
/// be.
#[test]
fn plans_cost_what_is_known_from_elsewhere() {
    let known = [
        // CasADi and IPOPT: 60 and 120 intervals have 0.180645 and 0.180477.
        ("ends_on_the_cone", 0.18042, 1e-4),
        // The best of 18 given rolls.
        ("fuel_free_roll", 0.87160, 2e-3),
        ("time_free_roll", 4.17652, 1e-4),
        // Equal answers of 50 to 800 steps.
        ("time_wheels_rate", 18.049, 1e-3),
        ("time_box_rates", 6.0883, 1e-4),
        ("fuel_cones", 2.37622, 1e-4),
        // 2 √(J θ/u).
        ("time_tiny_angle", 2.0 * 1e-6_f64.to_radians().sqrt(), 1e-6),
        // CasADi and IPOPT: 1134.65 s; a plan of 1133.66 s has been verified.
        ("telescope_time", 1134.65, 1e-3),
        // The long way of a given attitude.
        ("spin_up_fuel", 62.843, 1e-4),
        // The momentum of the spin over the longest arm, 0.5 m.
        ("free_roll_stop_spinner", 60.0 * 30.0_f64.to_radians() / 0.5, 1e-4),
        // CasADi and IPOPT, 40 intervals: 11.2318 s, where torques change more slowly.
        ("wheels_with_torque_rate", 11.2318, 4e-3),
        // Plans on 240 and on 600 steps: 41.0325 and 41.0272 s.
        ("roll_on_the_edge", 41.03, 4e-3),
        // Plans on 200 and on 400 steps, extrapolated: 27.0469 and 27.0456 s give 27.0452 s.
        ("valley_of_wheels", 27.0452, 4e-4),
        // The turn about the axis, 1.120998 s, without the gain of 1° (5.218e-4) times 0.3.
        ("dither", 1.120823, 1e-6),
        // Plans to rates off the axis of 0.01 and 0.001 deg/s: 8.18746 and 8.18745 s. The plan found
        // has other arcs; the turn about the axis takes 8.1988 s.
        ("turn_to_a_spin", 8.18745, 2e-4),
    ];
    at_once(&known, |(name, cost, within)| {
        let found = planned(name, &[]);
        assert_eq!(found.status, Status::Solved, "{name}");
        let above = found.solution.cost / cost - 1.0;
        assert!(above.abs() < *within, "{name}: {} against {cost}", found.solution.cost);
    });
}

/// Judges each case on a thread of its own: one after the other they would end long after all other
/// tests.
fn at_once<T: Sync>(cases: &[T], judge: impl Fn(&T) + Sync) {
    std::thread::scope(|scope| {
        let judged: Vec<_> = cases.iter().map(|case| scope.spawn(|| judge(case))).collect();
        judged.into_iter().for_each(|case| case.join().unwrap());
    });
}

/// The search among three sets of cones also finds the cheapest motion, which is far from every
/// cone.
#[test]
fn cones_that_are_far_away_cost_nothing() {
    let [among, alone] = [&[][..], &["constraint=[]", "any_of=[]"]]
        .map(|set| planned("free_roll_two_of_three_trackers", set).solution.cost);
    assert!((among / alone - 1.0).abs() < 1e-6, "{among} {alone}");
}

/// A refused duration comes with a longer one, for which a plan exists. The shortest durations are
/// 13.0900 s, in which full wheels turn the body by a right angle at 0.12 rad/s, and 25.509 and
/// 61.3875 s, which IPOPT finds from ten starts.
#[test]
fn what_is_too_short_is_told_with_a_duration_that_does() {
    at_once(&[("pyramid_too_short", 13.08996), ("infeasible_try", 34.69)], |(name, least)| {
        let found = planned(name, &[]);
        assert_eq!(found.status, Status::Infeasible, "{name}");
        let bound = found.solution.infeasible.unwrap().duration_lower_bound.unwrap();
        assert!((bound / least - 1.0).abs() < 1e-4, "{name}: {bound}");
        let longer = found.solution.longer.unwrap();
        assert!((1.0..2.0).contains(&(longer / bound)), "{name}: {longer}");
        let found = planned(name, &[&format!("maneuver.duration_s={longer}")]);
        assert_eq!(found.status, Status::Solved, "{name} in {longer} s");
    });
    at_once(&[("three_of_four", 25.509), ("three_wheels_60", 61.387)], |(name, least)| {
        let found = planned(name, &[]);
        assert_eq!(found.status, Status::NotConverged, "{name}");
        let longer = found.solution.longer.unwrap();
        assert!((1.0..1.3).contains(&(longer / least)), "{name}: {longer}");
        let found = planned(name, &[&format!("maneuver.duration_s={longer}")]);
        assert_eq!(found.status, Status::Solved, "{name} in {longer} s");
    });
    assert_eq!(planned("three_wheels_60", &["maneuver.duration_s=62"]).status, Status::Solved);
    assert_eq!(planned("pyramid_too_short", &["maneuver.duration_s=13.095"]).status, Status::Solved);
}

/// A body with a full pitch wheel nutates; its plan lands on the chosen number of steps. Coarse
/// grids resolve the nutation too. Among the other cases, one nutates at 0.47 rad/s, and one by 96
/// rad in all.
#[test]
fn a_biased_body_lands_on_the_steps_that_are_chosen() {
    for name in ["biased_wheel", "nutating_fast", "nutating_far"] {
        assert_eq!(planned(name, &[]).status, Status::Solved, "{name}");
    }
}

/// No shortest duration is reported for a maneuver without limits, whose plans can be arbitrarily
/// quick. No plan of it exists on so few steps.
#[test]
fn without_limits_no_duration_is_the_shortest() {
    let found = planned("nutating_fast", &["maneuver.steps=24"]);
    assert_eq!(found.solution.shortest, None);
}

/// A pass over a station costs no more with a free roll at its end than with a given one.
#[test]
fn a_free_roll_at_the_end_of_a_pass_is_no_dearer_than_a_given_one() {
    let given = "end.second={axis_body=[0,-1,0],at=\"anti_sun\"}";
    let [free, given] = [&[][..], &[given]].map(|set| planned("free_roll_tracked_pass", set));
    assert_eq!([free.status, given.status], [Status::Solved; 2]);
    assert!(free.solution.cost <= given.solution.cost, "{} {}", free.solution.cost, given.solution.cost);
}

/// Only the means of the rows act on the body. The motion under these means ends at the target, and
/// they are zero while a wheel is full.
#[test]
fn the_torque_of_a_full_wheel_is_zero() {
    let loaded = spec::read(&file("full_wheel.toml"), &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let found = plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved);
    let rows = &found.solution.trajectory;
    let missed = evidence::held::missed(&loaded.problem, rows).unwrap();
    assert!(missed < 1e-6, "{missed:e}");
    let (mut full, mut largest) = (0, 0.0_f64);
    for step in 0..rows.time.len() - 1 {
        let is_full = |node: usize| rows.wheel_momentum[3 * node + 2].abs() > 0.015 * (1.0 - 1e-6);
        if is_full(step) && is_full(step + 1) {
            full += 1;
            largest = largest.max(0.5 * (rows.inputs(step)[2] + rows.inputs(step + 1)[2]).abs());
        }
    }
    assert!(full > 10 && largest < 1e-6 * 0.002, "{full} {largest:e}");
}

/// Zeniths by the package `oem`, by `sgp4` and Skyfield, and by Kepler's orbit \[deg\].
#[test]
fn directions_are_those_of_other_programs() {
    let folder = folder();
    for (name, [ra, dec], within) in [
        ("hermite_four_rows", [2.88126, 3.62885], 1e-4),
        ("hermite_quarter_hours", [18.1293, 21.4344], 1e-3),
        ("tle_blank_type", [266.76341, 60.65800], 1e-4),
        ("tle_with_name", [228.52569, -73.81085], 1e-4),
        ("omm", [228.52569, -73.81085], 1e-4),
        ("omm_as_tle", [228.52569, -73.81085], 1e-4),
    ] {
        let run = folder.slew(&["sky", &format!("{name}.toml"), "-q", "--format", "json"]).ends(0);
        let found = &run.json()["targets"][0]["ra_dec_deg"][0];
        for (index, known) in [ra, dec].into_iter().enumerate() {
            let off = found[index].as_f64().unwrap() - known;
            assert!(off.abs() < within, "{name}: {found}");
        }
    }
}

/// Specs and files that are refused, warned of, or not judged, each with its reason.
#[test]
fn what_is_wrong_with_a_file_is_said() {
    let folder = folder();
    let cone = "constraint=[{kind=\"keep_out\",boresight_body=[1,0,0],direction_inertial={ra_deg=0,dec_deg=0},\
        half_angle_deg=9}]";
    let rows: [(&[&str], i32, &str); 22] = [
        (&["sky", "hourly.toml"], 3, "rows 3600 s apart are not enough for this orbit"),
        (&["plan", "metres.toml"], 3, "are these metres?"),
        (
            &["check", "typing_error.toml"],
            0,
            "typing_error.oem: line 20: this row contradicts its neighbours",
        ),
        (&["sky", "two_orbits_at_once.toml"], 3, "both cover the maneuver"),
        (
            &["verify", "bow.aem", "--spec", "bow.toml"],
            7,
            "camera off the Moon: the boresight enters the cone by 1.63",
        ),
        (
            &["verify", "degree_above_rows.aem", "--spec", "turn.toml"],
            0,
            "INTERPOLATION_DEGREE 7 needs 8 rows",
        ),
        (&["verify", "combined.xml", "--spec", "turn.toml"], 0, "attitudes agree with the spec"),
        (&["verify", "sample.a", "--spec", "turn.toml"], 0, "attitudes agree with the spec"),
        (&["check", "packed.toml"], 3, "unpack it first"),
        (&["check", "tle_blanks_collapsed.toml"], 3, "line 1 has 63 characters instead of 69"),
        (&["check", "tle_checksum.toml"], 3, "the checksum is 3, but its digits give 9"),
        (&["check", "tle_with_name.toml"], 0, "valid"),
        (&["check", "old_elements.toml"], 3, "the satellite may be anywhere on its orbit"),
        (
            &["check", "aimed_end_in_the_limb.toml"],
            3,
            "aimed_end_in_the_limb.toml:8:13: error[E0071]: the end violates",
        ),
        (
            &["check", "turn.toml", "--set", "end.attitude.angle_deg=3", "--set", cone],
            3,
            "--set end.attitude.angle_deg=3\n",
        ),
        // The switches of the plan's grid are some steps away from the switches in continuous time.
        (&["plan", "free_roll_stop_spinner.toml", "-q", "-o", "stop.json"], 0, ""),
        (&["verify", "stop.json"], 0, "verified"),
        (&["plan", "flight_two_rows.toml", "-q", "-o", "plan.json"], 0, ""),
        (
            &["export", "plan.json", "--format", "flight", "--tick", "20", "-o", "plan.flight"],
            0,
            "plan.flight",
        ),
        (
            &["plan", "spin_on_target.toml", "--set", "end.angular_velocity_deg_s=[0,3,30]"],
            3,
            "5.711 deg from the axis",
        ),
        (
            &["plan", "spin_on_target.toml", "--set", "end.roll_rate_deg_s=30"],
            3,
            "both `angular_velocity_deg_s` and `roll_rate_deg_s`",
        ),
        (
            &[
                "check",
                "wheels_with_torque_rate.toml",
                "--set",
                "actuators.torque_rate_limit_n_m_per_s=[1,1,1]",
            ],
            3,
            "has values for 3 axes, but the maneuver has 4",
        ),
    ];
    for (words, code, told) in rows {
        folder.slew(words).ends(code).tells(told);
    }
    let flight = folder.read("plan.flight");
    assert!(flight.contains("none of 2 rows can be left out"), "{}", &flight[..900]);
}
