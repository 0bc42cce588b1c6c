//! The two maneuvers that benchmarks measure: a three-axis rest-to-rest slew of an asymmetric body,
//! and this slew together with a displacement.

use slewkit::maneuver::problem::{Path, Problem, State};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::{Matrix3, Vector3, lie};

/// Returns an asymmetric body with tilted principal axes, and a target attitude: a turn by 2 rad
/// about an axis that is not principal.
fn body_and_target() -> (Body, Matrix3) {
    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap();
    let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
    (Body { inertia, mass: Some(1.3) }, lie::exp(&(axis * 2.0)))
}

/// Returns the rest-to-rest slew of a free body with three torques in 2 s, the short way.
pub fn attitude(steps: usize) -> Problem {
    let (body, target) = body_and_target();
    Problem::attitude(body, State::at_rest(Matrix3::identity()), State::at_rest(target), 2.0)
        .with_steps(steps)
        .with_path(Path::Shortest)
}

/// Returns the maneuver with three forces and a displacement.
pub fn rigid_body(steps: usize) -> Problem {
    let (body, target) = body_and_target();
    let mut end = State::at_rest(target);
    end.position = Vector3::new(0.7, -0.4, 0.2);
    Problem::rigid_body(body, State::at_rest(Matrix3::identity()), end, 2.0)
        .with_steps(steps)
        .with_path(Path::Shortest)
}
