//! Tests of the integration methods against reference values, conservation laws and each other.

mod agreement;
mod conservation;
mod frames_and_inputs;
mod galerkin;
mod implicit;
mod laws;
mod orders;
mod reference;

use super::{ErrorControl, Input, Integrator, Kind, System, SystemState};
use crate::maneuver::problem::State;
use crate::mechanics::body::Body;
use crate::mechanics::environment::{UniformGravity, Wrench};
use crate::mechanics::full_body::{Dumbbell, Dumbbells};
use crate::testing::{full_inertia, matrix, reference, vector};
use crate::{Matrix3, Vector3, lie};
use std::sync::Arc;

fn attitude_body() -> Body {
    Body { inertia: full_inertia(), mass: None }
}

/// Returns the free asymmetric body of the reference files, with its start.
fn free_body() -> (System, SystemState) {
    let system = System::new(vec![attitude_body()], None).unwrap();
    let state = start(&system, &lie::exp(&Vector3::new(0.4, -0.3, 0.5)), Vector3::new(1.0, -0.6, 0.8));
    (system, state)
}

/// Returns the 3D pendulum of the reference files, with its start.
fn pendulum() -> (System, SystemState) {
    let field = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    let system = System::single(attitude_body(), Arc::new(field)).unwrap();
    let state = start(&system, &lie::exp(&Vector3::new(0.4, -0.3, 0.5)), Vector3::new(1.0, -0.6, 0.8));
    (system, state)
}

fn start(system: &System, attitude: &Matrix3, momentum: Vector3) -> SystemState {
    let rate = system.bodies()[0].inertia.j_inverse() * momentum;
    system.state(&[State::attitude(*attitude, rate)]).unwrap()
}

/// Returns two dumbbells at the distance `d`, with spins scaled by `spin`.
fn dumbbells(d: f64, spin: f64) -> (System, SystemState) {
    let pair = [(1.0, 0.5), (2.0, 1.0)];
    let pair = pair.map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length });
    let bodies = pair.iter().map(|dumbbell| dumbbell.body().unwrap()).collect();
    let system = System::new(bodies, Some(Arc::new(Dumbbells::new(1.0, &pair).unwrap()))).unwrap();
    let speed = (3.0 / d).sqrt();
    let state = |part: f64, f: Vector3, rate: Vector3| State {
        position: Vector3::new(part * d, 0.0, 0.0),
        velocity: Vector3::new(0.0, part * speed, 0.0),
        attitude: lie::exp(&f),
        angular_velocity: spin * rate,
    };
    let first = state(2.0 / 3.0, Vector3::new(0.2, 0.5, 0.3), Vector3::new(0.3, -0.2, 1.0));
    let second = state(-1.0 / 3.0, Vector3::new(-0.3, 0.1, 0.8), Vector3::new(0.1, 0.4, 0.5));
    let state = system.state(&[first, second]).unwrap();
    (system, state)
}

fn method(kind: Kind, system: &System, state: &SystemState, step: f64) -> Box<dyn Integrator> {
    kind.start(system, state, step, &ErrorControl::default()).unwrap()
}

/// Returns the largest difference between two states in poses and momenta.
fn distance(a: &SystemState, b: &SystemState) -> f64 {
    let mut worst = 0.0;
    let mut see = |difference: f64| {
        assert!(difference.is_finite());
        worst = if difference > worst { difference } else { worst };
    };
    for (a, b) in a.poses().iter().zip(b.poses()) {
        see((a.position - b.position).amax());
        see((a.attitude - b.attitude).amax());
    }
    for (a, b) in a.momenta().iter().zip(b.momenta()) {
        see((a.linear - b.linear).amax());
        see((a.angular - b.angular).amax());
    }
    worst
}
