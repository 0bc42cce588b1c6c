//! Specs that aim at the sky: what they mean, that what is written of them reads back to the same bits, that plans stand by
//! themselves.

use slewkit::maneuver::constraint::angle_between;
use slewkit::maneuver::{Rule, Settings};
use slewkit::{Direction, Silent, Status, Vector3, plan, verify};
use slewkit_files::spec::{self, Format, Loaded, SpecDocument};
use std::path::PathBuf;

fn shipped(name: &str) -> Loaded {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../problems/{name}.toml"));
    match spec::load(&path, Format::Toml, &[]).unwrap() {
        spec::Spec::Maneuver(loaded) => *loaded,
        spec::Spec::Simulation(_) => panic!("{name} is a maneuver"),
    }
}

/// Where the full theories, which the planner does not use, see what is aimed at.
#[test]
fn targets_are_where_the_full_theories_see_them() {
    let loaded = shipped("ground_pass");
    let heavens = loaded.heavens.as_ref().unwrap();
    let none = Vector3::zeros();
    let seen = |name: &str, time: f64| {
        let named = heavens.targets.iter().find(|named| named.name.starts_with(name)).unwrap();
        heavens.sky.seen(&named.target, time).unwrap()
    };
    let aim = loaded.problem.aim().unwrap();
    for time in [0.0, 40.0, 75.0] {
        assert!(angle_between(&aim.at.at(time, &none), &seen("ground", time)) < 2e-6);
    }
    // The start: nadir exactly, x forward, turning once a revolution.
    let start = &loaded.problem.start;
    assert!(angle_between(&(start.attitude * Vector3::z()), &seen("nadir", 0.0)) < 2e-6);
    assert!(angle_between(&(start.attitude * Vector3::x()), &seen("along", 0.0)) < 1e-4);
    let period = heavens.sky.orbit().unwrap().period().unwrap();
    assert!((start.angular_velocity.norm() * period / std::f64::consts::TAU - 1.0).abs() < 2e-3);
    let cones: Vec<_> = loaded.problem.constraints.iter().map(|constraint| &constraint.rule).collect();
    let [Rule::Pointing(sun), Rule::Pointing(earth)] = cones[..] else { panic!("two cones") };
    assert!(angle_between(&sun.directions[0].at(30.0, &none), &seen("sun", 30.0)) < 2e-5);
    assert!(matches!(earth.directions[0], Direction::Disc { .. }));
    // From 777 km the Earth is 63 degrees from its middle to its limb.
    assert!((earth.directions[0].angular_radius(0.0).to_degrees() - 63.06).abs() < 0.1);
}

/// The boresight of the plan, flown, is on the target as the full theories see it, and at its rate; the file reads back.
#[test]
fn a_plan_to_a_station_points_at_it_and_stands_without_its_orbit() {
    let loaded = shipped("ground_pass");
    let found = plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved);
    let rows = &found.solution.trajectory;
    let attitude = slewkit::lie::rotation_from_quaternion(rows.quaternion.last().unwrap());
    let heavens = loaded.heavens.as_ref().unwrap();
    let station = &heavens.targets.iter().find(|named| named.name.starts_with("ground")).unwrap().target;
    let seen = |time: f64| heavens.sky.seen(station, time).unwrap();
    assert!(angle_between(&(attitude * Vector3::z()), &seen(75.0)) < 2e-6);
    let moved = (seen(75.5) - seen(74.5)).cross(&seen(75.0)) * -1.0;
    let rate = attitude * rows.angular_velocity.last().unwrap();
    assert!((rate - moved).norm() < 2e-6, "{rate} {moved}");

    let written = SpecDocument::new(&loaded.problem, &Settings::default()).unwrap();
    let read = written.read("plan", &[]).unwrap();
    assert_eq!(read.problem.end_condition, loaded.problem.end_condition);
    assert_eq!(read.problem.constraints, loaded.problem.constraints);
    assert_eq!(read.problem.start, loaded.problem.start);
    assert!(read.heavens.is_none());
    let again = found.solution.on_grid(&read.problem);
    assert!(verify(&again, rows, 1e-12, None).passed());
}
