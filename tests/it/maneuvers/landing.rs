//! Plans that land: under their torques, held over the steps, the true motion meets the end.

use slewkit::maneuver::{Problem, Settings, Target};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit_files::export::PlanFile;
use slewkit_files::spec;
use std::path::Path;

/// Of each kind one: a free turn, moving ends, forces, a field, a rate limit, a cone, wheels.
const ON_EQUAL_STEPS: [&str; 7] = [
    "rest_120",
    "moving_ends",
    "free_flyer",
    "orbit_turn",
    "limited_rate",
    "keep_out_small",
    "wheels_pyramid",
];
/// Least time and least fuel, on arcs with steps of their own.
const SWITCHING: [&str; 2] = ["minimum_time_xte", "minimum_fuel_xte"];

/// A shipped maneuver, and how it is planned with this target.
fn shipped(name: &str, target: Target) -> (Problem, Settings) {
    let path = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let loaded = spec::read(Path::new(&path), &[]).unwrap();
    // The limit on the true motion is that of the target.
    let settings = Settings { target, continuous_tolerance: None, ..loaded.settings };
    (loaded.problem, settings)
}

fn planned(problem: &Problem, settings: &Settings) -> Plan {
    plan(problem, settings, None, &mut Silent).unwrap()
}

/// By Euler's equations in a quaternion under the held inputs, which share nothing with planner, correction or witnesses.
#[test]
fn the_true_motion_of_a_plan_that_lands_meets_the_end() {
    for name in ON_EQUAL_STEPS {
        let (problem, settings) = shipped(name, Target::Motion);
        let plan = planned(&problem, &settings);
        assert_eq!(plan.status, Status::Solved, "{name}");
        let missed = evidence::held::missed(&problem, &plan.solution.trajectory).unwrap();
        let (discrete, _) = shipped(name, Target::Discrete);
        let before = planned(&discrete, &Settings { target: Target::Discrete, ..settings });
        let before = evidence::held::missed(&discrete, &before.solution.trajectory).unwrap();
        println!("{name:20} {before:.1e} rad off without, {missed:.1e} with");
        assert!(missed < Settings::CONTINUOUS_TOLERANCE, "{name}: {missed} rad, {before} without");
    }
}

#[test]
fn plans_that_switch_land_by_the_witness() {
    for name in SWITCHING {
        let (problem, settings) = shipped(name, Target::Motion);
        let plan = planned(&problem, &settings);
        assert_eq!(plan.status, Status::Solved, "{name}");
        let missed = plan.verification.unwrap().continuous_attitude_rad;
        assert!(missed < Settings::CONTINUOUS_TOLERANCE, "{name}: {missed} rad");
    }
}

/// The shifted target is in the file, so that the discrete witness judges against it; without it the plan would miss.
#[test]
fn the_file_of_a_plan_that_lands_is_verified_by_itself() {
    for name in ["rest_120", "free_flyer", "minimum_fuel_xte"] {
        let (problem, settings) = shipped(name, Target::Motion);
        let plan = planned(&problem, &settings);
        let mut text = Vec::new();
        PlanFile::new(&problem, &settings, &plan).write(&mut text).unwrap();
        let file = PlanFile::read(text.as_slice()).unwrap();
        let judged = file
            .judge(&problem, &settings, &slewkit_files::identity::Identity::default(), &|| false)
            .unwrap();
        let failed: Vec<_> = judged.verification.checks.iter().filter(|check| !check.passed).collect();
        assert!(judged.verification.passed(), "{name}: {failed:?}");
        let mut unaimed = file.trajectory.0.into_owned();
        assert!(unaimed.target.take().is_some(), "{name}");
        let found = slewkit::verify::verify(&problem, &unaimed, settings.tolerance, None);
        assert!(!found.passed(), "{name}");
    }
}
