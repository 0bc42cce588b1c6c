//! Tests of the flow: comparison with the flow of the witness, which shares no code with it, and
//! the observed order of convergence as the parts become shorter.

use super::*;
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::Wheels;
use crate::mechanics::environment::{CentralGravity, GravityGradient, PointMass};
use crate::propagate::plant::{Output, Plant};
use crate::testing::{Random, attitude_only, moving_ends};
use crate::verify::continuous_flow;

/// Returns random held inputs over steps of unequal lengths.
fn held(random: &mut Random, problem: &Problem, steps: usize) -> Vec<(Held, f64)> {
    let mean = problem.seconds() / steps as f64;
    let mut vector = || random.vector3();
    let outputs: Vec<Held> = (0..steps)
        .map(|_| Held { force: vector(), torque: 2.0 * vector(), outside: Vector3::zeros() })
        .collect();
    outputs.into_iter().enumerate().map(|(k, held)| (held, mean * (0.7 + 0.6 * (k % 2) as f64))).collect()
}

/// Returns the scaled difference between the terminal states of the flow and of the witness.
fn apart(problem: &Problem, steps: &[(Held, f64)]) -> f64 {
    let mut flight = Flight::new(problem);
    flight.settle(steps);
    let found = flight.fly(steps, None).unwrap();
    let outputs = steps.iter().map(|(held, h)| (Output { force: held.force, torque: held.torque }, *h));
    let witness = continuous_flow(&Plant::new(problem), outputs);
    flight.apart(&found, &witness, steps)
}

/// The flow reaches the same terminal state as the flow of the witness. The cases are free bodies
/// and bodies in force fields, torques and forces in body and reference axes, a rotating frame, and
/// a turn of a few radians on coarse and fine steps.
#[test]
fn the_flow_is_that_of_the_witness() {
    let mut random = Random(41);
    let gradient = |problem: &Problem| GravityGradient::new(0.4, &problem.body.inertia).unwrap();
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        for steps in [7, 100, 900] {
            for _ in 0..4 {
                let moving = moving_ends(&mut random, frame);
                let turning = attitude_only(moving.clone());
                let in_frame = turning.clone().with_environment(gradient(&turning));
                let field =
                    CentralGravity::new(vec![PointMass { parameter: 1.3, position: Vector3::zeros() }])
                        .unwrap();
                let falling = moving.clone().with_environment(field);
                for problem in [&moving, &turning, &in_frame, &falling] {
                    let steps = held(&mut random, problem, steps);
                    let apart = apart(problem, &steps);
                    assert!(apart < 2e-9, "{apart:.1e} on {} steps", steps.len());
                }
            }
        }
    }
}

/// The flow agrees with the flow of the witness even if the momentum of wheels makes a body nutate
/// ten times as fast as it turns. The nutation rate agrees with the linear equations.
#[test]
fn a_body_that_nutates_is_followed() {
    let mut random = Random(43);
    for steps in [40, 100, 900] {
        for momentum in [0.0, 5.0, 30.0] {
            let mut problem = attitude_only(moving_ends(&mut random, AxisFrame::Body));
            problem.actuation.torque = ActuatorSet::three_axes(AxisFrame::Body);
            let stored = momentum * random.vector3();
            problem.actuation.wheels = Some(Wheels {
                momentum: stored.iter().copied().collect(),
                momentum_limit: vec![f64::INFINITY; 3],
            });
            let (j, nutation) = (&problem.body.inertia, problem.body.inertia.nutation(&stored));
            let linear = j.j_inverse() * stored.cross_matrix();
            let squared = -0.5 * (linear * linear).trace();
            assert!((nutation * nutation - squared).abs() <= 1e-12 * squared, "{nutation} {squared}");
            let steps = held(&mut random, &problem, steps);
            let apart = apart(&problem, &steps);
            assert!(apart < 2e-9, "{apart:.1e} on {} steps with {momentum} N m s", steps.len());
        }
    }
}

/// Claim: both Runge–Kutta tableaux have the order that they state.
#[test]
fn tableaux_have_their_orders() {
    let mut random = Random(3);
    let problem = attitude_only(moving_ends(&mut random, AxisFrame::Body));
    let (flight, held) = (
        Flight::new(&problem),
        Held { force: Vector3::zeros(), torque: random.vector3(), outside: Vector3::zeros() },
    );
    let end = |order: usize, parts: usize| {
        let mut body = flight.start;
        let h = 2.0 / parts as f64;
        for _ in 0..parts {
            match order {
                4 => flight.advance::<false, 4>(&FOURTH, 0.0, h, &held, &mut body),
                _ => flight.advance::<false, 7>(&SIXTH, 0.0, h, &held, &mut body),
            }
        }
        (body.attitude, body.momentum)
    };
    let exact = end(6, 2048);
    for (order, parts) in [(4, [64, 128]), (6, [24, 48])] {
        let errors = parts.map(|parts| {
            let (attitude, momentum) = end(order, parts);
            (attitude - exact.0).norm() + (momentum - exact.1).norm()
        });
        let slope = (errors[0] / errors[1]).log2();
        assert!((slope - order as f64).abs() < 0.3, "order {order}: {slope}, {errors:?}");
    }
}
