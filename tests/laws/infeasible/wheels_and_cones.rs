//! Proofs by the capacity of wheels and by cones in the way.

use super::*;
use slewkit::maneuver::Settings;
use slewkit::plan::{Silent, Status, plan};

// ---- wheels
// -----------------------------------------------------------------------------------------

fn three_wheels(momentum: [f64; 3], limit: f64, torque: f64) -> Actuation {
    let limits = Limits { size: Some(vec![torque; 3]), ..Limits::default() };
    let channel = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let wheels = Wheels { momentum: momentum.to_vec(), momentum_limit: vec![limit; 3] };
    Actuation { wheels: Some(wheels), ..Actuation::torques(channel) }
}

/// After a turn by 90° about x the y wheel must hold the momentum of the z wheel, and the body must
/// end at rest.
#[test]
fn momentum_that_the_wheels_cannot_hold_in_the_end_is_named() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let mut actuation = three_wheels([0.0, 0.0, 4.0], 5.0, 1.0);
    let mut problem = rest_to_rest(body, rotation, 60.0, actuation.clone());
    assert_eq!(proof(&problem), None);
    actuation.wheels.as_mut().unwrap().momentum_limit = vec![5.0, 2.5, 5.0];
    problem.actuation = actuation;
    let found = denied(&problem);
    assert!(found.reason.contains("hold 4 N·m·s along the body axis (0, 1, 0)"), "{found}");
    assert!(found.reason.contains("store 2.5") && found.reason.contains("at least 1.6 times"), "{found}");
    // Two wheels, and momentum about the third axis at the end.
    let channel = ActuatorSet::new(vec![Vector3::x(), Vector3::z()], AxisFrame::Body).unwrap();
    let wheels = Wheels { momentum: vec![0.0, 4.0], momentum_limit: vec![f64::INFINITY; 2] };
    problem.actuation = Actuation { wheels: Some(wheels), ..Actuation::torques(channel) };
    let found = denied(&problem);
    assert!(found.reason.contains("no wheel turns about it"), "{found}");
}

/// Full wheels turn no faster than their momentum: `T ≥ θ J/h`, here of the axis of the smallest
/// moment, with the corner of three wheels; and no faster than the torque takes to fill and to
/// empty them.
#[test]
fn wheels_turn_the_body_no_faster_than_they_store() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(2.0, 0.0, 0.0);
    let corner = 3.0_f64.sqrt();
    let problem =
        rest_to_rest(body.clone(), rotation, 30.0, three_wheels([0.0; 3], 0.05, 0.02)).with_steps(2000);
    let (capacity, torque) = (0.05 * corner, 0.02 * corner);
    // Two ramps of the torque at the ends, full wheels between.
    let reason = shortest(&problem, 2.0 * 2.0 / capacity + capacity / torque, 1e-2);
    assert!(reason.contains("wheel momentum limits at least"), "{reason}");
    let problem = rest_to_rest(body, rotation, 2.0, three_wheels([0.0; 3], 50.0, 0.1)).with_steps(400);
    let reason = shortest(&problem, 2.0 * (2.0 * 2.0 / (0.1 * corner)).sqrt(), 1e-3);
    assert!(reason.contains("torque limits at least"), "{reason}");
}

/// A half turn about x brings 4 N·m·s of the z wheel to −z: 8 N·m·s in 8 s with 1 N·m, no faster.
#[test]
fn wheels_take_up_momentum_no_faster_than_their_torques() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(std::f64::consts::PI, 0.0, 0.0);
    let problem = rest_to_rest(body, rotation, 6.0, three_wheels([0.0, 0.0, 4.0], 5.0, 1.0));
    let found = denied(&problem);
    assert!((found.duration_lower_bound.unwrap() - 8.0).abs() < 1e-5, "{found}");
    assert!(found.reason.contains("absorb 8 N·m·s"), "{found}");
}

/// A gyrostat accelerates and decelerates about one axis against the momentum of its wheel, in long
/// steps. It turns farther than without the wheel, and exactly as far as the bound, for the body
/// and for each of its other axes.
#[test]
fn a_gyrostat_about_one_axis_attains_its_bound() {
    for scheme in SCHEMES {
        let steps = 8;
        let start = State::at_rest(Matrix3::identity());
        let mut problem = Problem::attitude(body(2.0 * Matrix3::identity()), start, start, 8.0)
            .with_steps(steps)
            .with_scheme(scheme)
            .with_actuation(three_wheels([-0.5, 0.0, 0.0], f64::INFINITY, 0.1));
        let axis = vec![Vector3::x()];
        let limits = Limits { size: Some(vec![0.1]), ..Limits::default() };
        problem.actuation.torque =
            ActuatorSet::new(axis, AxisFrame::Body).unwrap().with_limits(limits).unwrap();
        problem.actuation.wheels = Some(Wheels { momentum: vec![-0.5], momentum_limit: vec![f64::INFINITY] });
        let inputs: Vec<f64> = match scheme {
            Scheme::LieEuler => (0..8).map(|k| if k < 4 { 0.1 } else { -0.1 }).collect(),
            Scheme::LieVerlet => {
                (0..9).map(|k| [0.1, 0.0, -0.1][usize::from(k >= 4) + usize::from(k > 4)]).collect()
            }
        };
        let (problem, plan) = aimed(problem, &inputs).unwrap();
        assert!(plan.angular_velocity.last().unwrap().norm() < 1e-14);
        assert_eq!(proof(&problem), None, "{scheme:?}");
        let mut weak = problem.clone();
        let limits = Limits { size: Some(vec![0.0999]), ..Limits::default() };
        weak.actuation.torque = weak.actuation.torque.with_limits(limits).unwrap();
        assert!(proof(&weak).is_some(), "{scheme:?}");
    }
}

// ---- cones
// ------------------------------------------------------------------------------------------

/// A cone in the way makes the way longer. The boresight z moves from 60° on one side of a cone of
/// 50° about the middle to 60° on the other.
#[test]
fn a_cone_in_the_way_needs_time() {
    let sphere = Body { inertia: Inertia::diagonal(Vector3::repeat(2.0)).unwrap(), mass: None };
    let rotation = Vector3::new(120.0_f64.to_radians(), 0.0, 0.0);
    let axis = lie::exp(&(0.5 * rotation)) * Vector3::z();
    let cone = |degrees: f64| {
        let direction = Direction::Fixed(axis);
        let half_angle = degrees.to_radians();
        let (boresights, directions) = (vec![Vector3::z()], vec![direction]);
        let rule = Rule::Pointing(Pointing::new(Side::KeepOut, boresights, directions, half_angle));
        Constraint { name: "sun".into(), rule }
    };
    let direct = 2.0 * (rotation.norm() * 2.0 / 0.3_f64).sqrt();
    let problem = rest_to_rest(sphere, rotation, 1.02 * direct, norm_limit(0.3)).with_steps(400);
    assert_eq!(proof(&problem), None);
    let beta = 50.0_f64.to_radians();
    let tangent = (60.0_f64.to_radians().cos() / beta.cos()).acos();
    let contact = (beta.tan() / 60.0_f64.to_radians().tan()).acos();
    let way = 2.0 * tangent + beta.sin() * (std::f64::consts::PI - 2.0 * contact);
    let with = problem.clone().with_constraint(cone(50.0));
    let reason = shortest(&with, 2.0 * (way * 2.0 / 0.3_f64).sqrt(), 1e-3);
    assert!(reason.contains("around \"sun\""), "{reason}");
    let most: f64 = text_between(&reason, "a half angle of at most ", " deg").parse().unwrap();
    // The named cone is on the border itself.
    assert!(proof(&problem.clone().with_constraint(cone(most - 0.05))).is_none(), "{reason}");
    assert!(proof(&problem.with_constraint(cone(most + 0.05))).is_some(), "{reason}");
}

/// A boresight must stay near the zenith of an orbit, and away from a star that the zenith passes.
/// No attitude satisfies both at that moment, although both ends do.
#[test]
fn cones_that_meet_on_the_way_are_named_both() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rate = 1e-3;
    let field = GravityGradient::new(rate, &body.inertia).unwrap();
    let start = State::attitude(Matrix3::identity(), Vector3::new(0.0, rate, 0.0));
    let duration = 2000.0;
    let star = lie::exp(&Vector3::new(0.0, 1.0, 0.0)) * Vector3::z();
    let cone = |name: &str, side, direction, degrees: f64| {
        let (boresights, half_angle) = (vec![Vector3::z()], degrees.to_radians());
        let directions = vec![direction];
        let rule = Rule::Pointing(Pointing::new(side, boresights, directions, half_angle));
        Constraint { name: name.into(), rule }
    };
    let problem = |keep_in: f64, keep_out: f64| {
        Problem::attitude(body.clone(), start, start, duration)
            .with_environment(field.clone())
            .with_constraint(cone("zenith", Side::KeepIn, Direction::InFrame(Vector3::z()), keep_in))
            .with_constraint(cone("star", Side::KeepOut, Direction::Fixed(star), keep_out))
    };
    assert_eq!(proof(&problem(30.0, 29.0)), None);
    let found = denied(&problem(20.0, 30.0));
    assert!(found.reason.contains("\"zenith\" and \"star\""), "{found}");
    assert!(found.reason.contains("t = 1000 s") && found.reason.contains("10 deg"), "{found}");
}

/// The momentum of a tumble is conserved for any attitude at the end and any duration.
#[test]
fn wheels_too_small_for_a_tumble_are_named_for_any_end_and_any_duration() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(20.0, 30.0, 40.0)).unwrap(), mass: None };
    let start = State::attitude(Matrix3::identity(), Vector3::new(0.1, 0.1, 0.1));
    let end = State::at_rest(Matrix3::identity());
    // The body holds 5.385 N·m·s, and a corner of the wheels √3 times their limit.
    let total = 29.0_f64.sqrt();
    let maneuvers = |limit: f64| {
        let given = Problem::attitude(body.clone(), start, end, 60.0);
        let quickest = Problem::minimum_time(body.clone(), start, end);
        [given.with_any_attitude_at_end(), quickest.clone().with_any_attitude_at_end(), quickest]
            .map(|problem| problem.with_actuation(three_wheels([0.0; 3], limit, 0.5)).with_steps(60))
    };
    let planned = |problem: &Problem| plan(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    for problem in maneuvers(0.99 * total / 3.0_f64.sqrt()) {
        let found = planned(&problem);
        assert_eq!(found.status, Status::Infeasible, "{:?}", problem.objective);
        let reason = found.solution.infeasible.unwrap().reason;
        assert!(reason.contains("because the total momentum is conserved"), "{reason}");
    }
    // Wheels that can store it are not denied.
    for problem in maneuvers(1.05 * total).into_iter().take(2) {
        assert_ne!(planned(&problem).status, Status::Infeasible);
    }
}
