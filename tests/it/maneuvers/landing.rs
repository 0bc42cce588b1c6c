//! Plans that land: under their torques, held over the steps, the true motion meets the end.

use evidence::everyday::{Kind, maneuver};
use slewkit::maneuver::{Problem, Settings, State, Target};
use slewkit::mechanics::{Body, Inertia};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::export::PlanFile;
use slewkit_files::spec::{self, Format};
use std::path::Path;

/// The maneuvers, one of each kind: a free turn, moving ends, forces, a field, a rate limit, a
/// cone, wheels.
const ON_EQUAL_STEPS: [&str; 7] = [
    "rest_120",
    "moving_ends",
    "free_flyer",
    "orbit_turn",
    "limited_rate",
    "keep_out_small",
    "wheels_pyramid",
];
/// Least time and least fuel, on arcs with their own steps.
const SWITCHING: [&str; 2] = ["minimum_time_xte", "minimum_fuel_xte"];

/// Returns a shipped maneuver, and how it is planned with this target.
fn shipped(name: &str, target: Target) -> (Problem, Settings) {
    let path = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let loaded = spec::read(Path::new(&path), &[]).unwrap();
    // The limit on the true motion is the default of the target.
    let settings = Settings { target, continuous_tolerance: None, ..loaded.settings };
    (loaded.problem, settings)
}

fn planned(problem: &Problem, settings: &Settings) -> Plan {
    plan(problem, settings, None, &mut Silent).unwrap()
}

/// Four wheels turn a body in many ways in about the least time, a valley of plans whose costs
/// differ by 1e-8. The plan and each correction stay at one point of it, and the motion lands.
#[test]
fn plans_land_in_valleys_of_nearly_equal_ones() {
    for case in [23, 25, 34] {
        let found = planned(&maneuver(Kind::Time, 1, case), &Settings::default());
        assert_eq!(found.status, Status::Solved, "case {case}");
    }
}

/// The same where a rate is limited: a correction that ends at another barrier term ends at another
/// point of the valley, and the miss does not decrease.
#[test]
fn corrections_along_a_valley_hold_the_barrier_term() {
    let found = planned(&maneuver(Kind::Rate, 1, 77), &Settings::default());
    assert_eq!(found.status, Status::Solved);
    let misses = found.solution.landing.unwrap().misses;
    assert!(misses.last().unwrap() < &1e-6, "{misses:?}");
}

/// A wheel that holds 20 N·m·s makes the body nutate by 0.2 rad/s: the flow by which a plan lands
/// follows that, on the steps that are chosen and on 120.
#[test]
fn a_plan_lands_while_the_body_nutates() {
    let loaded = spec::from_str(crate::files::BIASED, "biased", Format::Toml, &[]).unwrap();
    for problem in [loaded.problem.clone(), loaded.problem.clone().with_steps(120)] {
        let plan = planned(&problem, &loaded.settings);
        let missed = evidence::held::missed(&problem, &plan.solution.trajectory);
        println!("{} steps: {missed:?} rad off", plan.solution.steps);
        assert_eq!(plan.status, Status::Solved, "{:?}", plan.verification.map(|found| found.checks));
    }
}

/// Integrates Euler's equations with a quaternion under the held inputs, by code that planner,
/// correction and witnesses do not use.
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

/// The shifted target is in the file, so that the discrete witness judges against it; without it
/// the plan would miss.
#[test]
fn the_file_of_a_plan_that_lands_is_verified_by_itself() {
    for name in ["rest_120", "free_flyer", "minimum_fuel_xte"] {
        let (problem, settings) = shipped(name, Target::Motion);
        let plan = planned(&problem, &settings);
        let mut text = Vec::new();
        PlanFile::new(&problem, &settings, &plan).write(&mut text).unwrap();
        let file = PlanFile::read(text.as_slice()).unwrap();
        let judged =
            file.judge(&problem, &settings, &Default::default(), &Default::default(), &|| false).unwrap();
        let failed: Vec<_> = judged.verification.checks.iter().filter(|check| !check.passed).collect();
        assert!(judged.verification.passed(), "{name}: {failed:?}");
        let mut unaimed = file.trajectory.0.into_owned();
        assert!(unaimed.target.take().is_some(), "{name}");
        let found = slewkit::verify::verify(&problem, &unaimed, settings.tolerance, None);
        assert!(!found.passed(), "{name}");
    }
}

/// Costs of maneuvers whose optimum in continuous time other methods give, as stated in their
/// files. The number of steps is chosen if the spec gives none.
const IN_CONTINUOUS_TIME: [(&str, f64); 10] = [
    ("moving_ends", 6.448306071999),
    ("free_duration_xte", 16031.2331182),
    ("free_duration_orbit", 5.571968271e-4),
    ("longest_duration", 4.020990754e-7),
    ("shortest_keep_out", 4.014917),
    ("minimum_fuel_120", 2.84330240427),
    ("minimum_fuel_norm_moving", 2.744248248),
    ("minimum_fuel_pulses", 3.5577572056),
    ("minimum_time_xte", 28.630407),
    ("minimum_time_norm", 4.34061536066),
];

#[test]
fn on_chosen_steps_the_cost_stands_within_a_thousandth_of_its_optimum_in_continuous_time() {
    for (name, optimum) in IN_CONTINUOUS_TIME {
        let path = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap();
        let bare: Vec<&str> = text.lines().filter(|line| !line.starts_with("step")).collect();
        let loaded = spec::from_str(&bare.join("\n"), name, Format::Toml, &[]).unwrap();
        assert!(loaded.problem.chooses_steps, "{name}");
        let found = planned(&loaded.problem, &loaded.settings);
        assert_eq!(found.status, Status::Solved, "{name}");
        let solution = &found.solution;
        let apart = solution.cost / optimum - 1.0;
        println!("{name:26} {:>5} steps {apart:+.1e} {:?}", solution.steps, solution.chosen);
        assert!(apart.abs() < 1e-3, "{name}: {} against {optimum}", solution.cost);
        assert!(solution.chosen.is_some_and(|chosen| chosen.lands), "{name}");
    }
}

/// Half a turn with the rate of a full turn: a hundred steps are too few for the required accuracy
/// of the cost, and more are used. The estimate behind this choice assumes a turn about one axis,
/// for which torques are linear in time: the trapezoidal sum is above the optimum by `ΔJ/J = 4/N²`.
#[test]
fn more_steps_are_taken_where_the_cost_asks_for_them() {
    let (mut problem, settings) = shipped("rest_120", Target::Motion);
    (problem.steps, problem.chooses_steps) = (10, true);
    let found = planned(&problem, &settings).solution;
    let chosen = found.chosen.unwrap();
    assert!(found.steps > 30 && chosen.began == 10 && chosen.lands, "{} {chosen:?}", found.steps);
    assert!(chosen.cost_error.unwrap() < 1e-3);
    // About one axis from rest to rest: J = 6 j² θ²/T³.
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 2.0, 2.0)).unwrap(), mass: None };
    let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, 1.0)));
    let mut turn = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 3.0);
    turn.steps = 80;
    let found = planned(&turn, &settings).solution;
    assert_eq!(found.steps, 80);
    assert!((found.cost / (6.0 * 4.0 / 27.0) - 1.0 - 4.0 / 6400.0).abs() < 4e-5, "{}", found.cost);
    let error = found.chosen.unwrap().cost_error.unwrap();
    assert!((error * 6400.0 - 4.0).abs() < 0.2, "{error}");
    let given = planned(&turn.with_steps(10), &settings).solution;
    assert_eq!((given.steps, given.chosen), (10, None));
}

/// The rows of a plan that lands are the true motion: they end where the maneuver ends, and a
/// changed row is reported.
#[test]
fn the_true_motion_is_on_record() {
    for name in ["rest_120", "free_flyer", "orbit_turn", "minimum_time_xte", "wheels_pyramid"] {
        let (problem, settings) = shipped(name, Target::Motion);
        let plan = planned(&problem, &settings);
        let problem = plan.solution.on_grid(&problem);
        let mut trajectory = plan.solution.trajectory.clone();
        let last = trajectory.quaternion.len() - 1;
        let end = lie::rotation_from_quaternion(&trajectory.quaternion[last]);
        assert!(lie::minus(&end, &problem.end.attitude).norm() < 1e-8, "{name}");
        let rate = trajectory.angular_velocity[last] - problem.end.angular_velocity;
        assert!(rate.norm() * trajectory.time[last] < 1e-8, "{name}");
        let tolerance = settings.continuous_limit();
        assert!(slewkit::verify::verify(&problem, &trajectory, 1e-12, tolerance).passed(), "{name}");
        // Another end is reported, though the discrete motion meets its own target.
        let mut elsewhere = problem.clone();
        elsewhere.end.angular_velocity.z += 1e-3 / trajectory.time[last];
        assert!(!slewkit::verify::verify(&elsewhere, &trajectory, 1e-12, tolerance).passed(), "{name}");
        trajectory.angular_velocity[last / 2] *= 1.0 + 1e-4;
        let found = slewkit::verify::verify(&problem, &trajectory, 1e-12, tolerance);
        let failed: Vec<&str> =
            found.checks.iter().filter(|check| !check.passed).map(|check| check.name.as_str()).collect();
        assert!(failed.contains(&"recorded motion"), "{name}: {failed:?}");
    }
}
