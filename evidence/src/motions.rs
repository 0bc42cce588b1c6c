//! The motions on which integrators are measured.

use slewkit::maneuver::problem::State;
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::full_body::{Dumbbell, Dumbbells};
use slewkit::propagate::integrator::{System, SystemState};
use slewkit::{Matrix3, Vector3, lie};
use std::sync::Arc;

/// Returns an asymmetric inertia with tilted principal axes [kg·m²].
pub fn full_inertia() -> Inertia {
    Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap()
}

/// Returns the torque-free rotation of a body with the inertia [`full_inertia`].
pub fn free_body() -> (System, SystemState) {
    let system = System::new(vec![Body { inertia: full_inertia(), mass: None }], None).unwrap();
    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), Vector3::new(0.6, -0.5, 1.0));
    let state = system.state(&[start]).unwrap();
    (system, state)
}

/// Returns the rotation about the axis of the largest moment of a body whose axes are tilted.
pub fn steady_rotation() -> (System, SystemState) {
    let axes = lie::exp(&Vector3::new(0.5, -0.4, 0.3));
    let moments = Matrix3::from_diagonal(&Vector3::new(1.0, 1.7, 2.2));
    let inertia = Inertia::new(axes * moments * axes.transpose()).unwrap();
    let system = System::new(vec![Body { inertia, mass: None }], None).unwrap();
    let start = State::attitude(Matrix3::identity(), axes * Vector3::new(0.0, 0.0, 1.3));
    let state = system.state(&[start]).unwrap();
    (system, state)
}

/// Returns two dumbbells at the separation 2.5, in dimensionless units, as in section 3.4 of the
/// survey.
pub fn dumbbells() -> (System, SystemState) {
    let pair = [(1.0, 0.5), (2.0, 1.0)];
    let pair = pair.map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length });
    let bodies = pair.iter().map(|dumbbell| dumbbell.body().unwrap()).collect();
    let system = System::new(bodies, Some(Arc::new(Dumbbells::new(1.0, &pair).unwrap()))).unwrap();
    let (d, spin) = (2.5, 4.0);
    let state = |part: f64, f: Vector3, rate: Vector3| State {
        position: Vector3::new(part * d, 0.0, 0.0),
        velocity: Vector3::new(0.0, part * (3.0_f64 / d).sqrt(), 0.0),
        attitude: lie::exp(&f),
        angular_velocity: spin * rate,
    };
    let first = state(2.0 / 3.0, Vector3::new(0.2, 0.5, 0.3), Vector3::new(0.3, -0.2, 1.0));
    let second = state(-1.0 / 3.0, Vector3::new(-0.3, 0.1, 0.8), Vector3::new(0.1, 0.4, 0.5));
    let state = system.state(&[first, second]).unwrap();
    (system, state)
}
