//! The methods against reference values, their laws and each other.

mod agreement;
mod reference;

use super::{Input, Integrator, Kind, Settings, System, SystemState};
use crate::body::{Body, Inertia};
use crate::environment::{Pose, UniformGravity, Wrench};
use crate::full_body::Potential;
use crate::problem::State;
use crate::testing::{full_inertia, matrix, reference, vector};
use crate::{Matrix3, Vector3, lie};
use std::sync::Arc;

/// Point masses under Newton's gravity, G = 1, summed over all pairs of different bodies.
#[derive(Debug)]
struct Points {
    /// Mass and place in body axes of each point of each body.
    bodies: Vec<Vec<(f64, Vector3)>>,
}

impl Points {
    /// Calls `each(i, j, ρ_p, m_p m_q, y_p − y_q)` for every pair of points of different bodies.
    fn pairs(&self, poses: &[Pose], mut each: impl FnMut(usize, Vector3, f64, Vector3)) {
        for (i, (a, pose_a)) in self.bodies.iter().zip(poses).enumerate() {
            for (j, (b, pose_b)) in self.bodies.iter().zip(poses).enumerate() {
                if i == j {
                    continue;
                }
                for (mass_a, place_a) in a {
                    for (mass_b, place_b) in b {
                        let d = pose_a.position + pose_a.attitude * place_a
                            - pose_b.position
                            - pose_b.attitude * place_b;
                        each(i, *place_a, mass_a * mass_b, d);
                    }
                }
            }
        }
    }
}

impl Potential for Points {
    fn energy(&self, poses: &[Pose]) -> f64 {
        let mut energy = 0.0;
        self.pairs(poses, |_, _, masses, d| energy -= 0.5 * masses / d.norm());
        energy
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        wrenches.fill(Wrench::zero());
        self.pairs(poses, |i, place, masses, d| {
            let force = d * (-masses / d.norm().powi(3));
            wrenches[i].force += force;
            wrenches[i].moment += place.cross(&poses[i].attitude.tr_mul(&force));
        });
    }
}

fn attitude_body() -> Body {
    Body { inertia: full_inertia(), mass: None }
}

/// The free asymmetric body of the reference files.
fn free_body() -> (System, SystemState) {
    let system = System::new(vec![attitude_body()], None).unwrap();
    let state = start(&system, &lie::exp(&Vector3::new(0.4, -0.3, 0.5)), Vector3::new(1.0, -0.6, 0.8));
    (system, state)
}

/// The 3D pendulum of the reference files.
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

/// The two dumbbells of theory.md 5.1: separation `d`, spins scaled by `spin`.
fn dumbbells(d: f64, spin: f64) -> (System, SystemState) {
    let mut bodies = Vec::new();
    let mut points = Vec::new();
    for (mass, length) in [(1.0, 0.5), (2.0, 1.0)] {
        let along: f64 = 0.4 * mass * (0.2_f64 * length).powi(2);
        let across = along + 0.25 * mass * length * length;
        let inertia = Inertia::diagonal(Vector3::new(along, across, across)).unwrap();
        bodies.push(Body { inertia, mass: Some(mass) });
        let end = Vector3::new(0.5 * length, 0.0, 0.0);
        points.push(vec![(0.5 * mass, end), (0.5 * mass, -end)]);
    }
    let system = System::new(bodies, Some(Arc::new(Points { bodies: points }))).unwrap();
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
    kind.start(system, state, step, &Settings::default()).unwrap()
}

/// Largest difference of poses and momenta.
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
