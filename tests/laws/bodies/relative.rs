//! Two bodies in relative coordinates against the same two in the inertial frame.

use super::systems::{octahedron, poses, solid, tetrahedron};
use crate::evidence::Random;
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::invariants::Momentum;
use slewkit::mechanics::full_body::relative::*;
use slewkit::mechanics::full_body::*;
use slewkit::propagate::integrator::{System, SystemState};
use slewkit::{Matrix3, Vector3, lie};
use std::sync::Arc;

fn bodies() -> [Attractor; 2] {
    [solid(octahedron(), 2), solid(tetrahedron(), 2)]
}

fn system() -> ([Body; 2], MutualGravity) {
    (bodies().map(|body| body.body().unwrap()), MutualGravity::new(1.0, bodies().to_vec()).unwrap())
}

fn start() -> ([Pose; 2], [Momentum; 2]) {
    let mut random = Random::new(41);
    let mut momentum = || Momentum { linear: 0.3 * random.vector(), angular: 0.05 * random.vector() };
    let momenta = [momentum(), momentum()];
    let poses = poses(&mut Random::new(42), 2);
    ([poses[0], poses[1]], momenta)
}

fn close(name: &str, a: &[f64], b: &[f64], tolerance: f64) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < tolerance, "{name}: {a} {b}");
    }
}

fn compare(a: &([Pose; 2], [Momentum; 2]), b: &([Pose; 2], [Momentum; 2]), tolerance: f64) {
    for body in 0..2 {
        close("x", a.0[body].position.as_slice(), b.0[body].position.as_slice(), tolerance);
        close("R", a.0[body].attitude.as_slice(), b.0[body].attitude.as_slice(), tolerance);
        close("γ", a.1[body].linear.as_slice(), b.1[body].linear.as_slice(), tolerance);
        close("Π", a.1[body].angular.as_slice(), b.1[body].angular.as_slice(), tolerance);
    }
}

#[test]
fn reduction_and_restoration_are_inverse() {
    let (bodies, potential) = system();
    let (poses, momenta) = start();
    let two = TwoBodies::new(bodies.clone(), &potential).unwrap();
    let (relative, anchor) = two.reduce(&poses, &momenta);
    compare(&two.restore(&relative, &anchor), &(poses, momenta), 1e-15);
    let system = System::new(bodies.to_vec(), Some(Arc::new(potential.clone()))).unwrap();
    let total = system.invariants(&SystemState::new(poses.to_vec(), momenta.to_vec()));
    assert!((anchor.momentum - total.linear_momentum).amax() < 1e-15);
    // Energy and angular momentum, but for the motion of the mass center.
    let mass: f64 = bodies.iter().map(|body| body.mass.unwrap()).sum();
    let drift = 0.5 * anchor.momentum.norm_squared() / mass;
    assert!((two.energy(&relative) + drift - total.energy).abs() < 1e-14);
    let orbital = anchor.mass_center.cross(&anchor.momentum);
    let turned = anchor.attitude * two.angular_momentum(&relative) + orbital;
    assert!((turned - total.angular_momentum).amax() < 1e-14);
}

/// Integrates the numbers of a state by the Runge–Kutta method of order four.
fn integrate<const N: usize>(
    mut y: [f64; N],
    steps: usize,
    h: f64,
    rate: impl Fn(&[f64; N]) -> [f64; N],
) -> [f64; N] {
    let along = |y: &[f64; N], k: &[f64; N], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    for _ in 0..steps {
        let k1 = rate(&y);
        let k2 = rate(&along(&y, &k1, 0.5 * h));
        let k3 = rate(&along(&y, &k2, 0.5 * h));
        let k4 = rate(&along(&y, &k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    y
}

fn vector(y: &[f64]) -> Vector3 {
    Vector3::from_column_slice(&y[..3])
}

fn matrix(y: &[f64]) -> Matrix3 {
    Matrix3::from_column_slice(&y[..9])
}

fn pack<const N: usize>(parts: &[&[f64]]) -> [f64; N] {
    parts.concat().try_into().unwrap()
}

#[test]
fn reduced_equations_move_as_the_inertial_ones() {
    let (bodies, potential) = system();
    let (poses, momenta) = start();
    let two = TwoBodies::new(bodies.clone(), &potential).unwrap();
    const STEPS: usize = 400;
    let h = 2.0 / STEPS as f64;

    // Inertial: ẋ = γ/m, γ̇ = f, Ṙ = R S(Ω), Π̇ = Π × Ω + M.
    let unpack = |y: &[f64; 36]| {
        let body = |i: usize| &y[18 * i..];
        let pose = [0, 1].map(|i| Pose { position: vector(body(i)), attitude: matrix(&body(i)[3..]) });
        let momentum =
            [0, 1].map(|i| Momentum { linear: vector(&body(i)[12..]), angular: vector(&body(i)[15..]) });
        (pose, momentum)
    };
    let all = |poses: &[Pose; 2], momenta: &[Momentum; 2]| -> [f64; 36] {
        let parts: Vec<&[f64]> = (0..2)
            .flat_map(|i| {
                let (pose, momentum) = (&poses[i], &momenta[i]);
                let translation = [pose.position.as_slice(), pose.attitude.as_slice()];
                [translation, [momentum.linear.as_slice(), momentum.angular.as_slice()]].concat()
            })
            .collect();
        pack(&parts)
    };
    let inertial = integrate(all(&poses, &momenta), STEPS, h, |y| {
        let (poses, momenta) = unpack(y);
        let mut wrenches = [Wrench::zero(); 2];
        potential.wrenches(&poses, &mut wrenches);
        let rates = [0, 1].map(|i| {
            let omega = bodies[i].inertia.j_inverse() * momenta[i].angular;
            let pose = Pose {
                position: momenta[i].linear / bodies[i].mass.unwrap(),
                attitude: poses[i].attitude * lie::hat(&omega),
            };
            let angular = momenta[i].angular.cross(&omega) + wrenches[i].moment;
            (pose, Momentum { linear: wrenches[i].force, angular })
        });
        all(&rates.map(|rate| rate.0), &rates.map(|rate| rate.1))
    });

    // The reduced motion, with the attitude of body 2.
    let (relative, anchor) = two.reduce(&poses, &momenta);
    let state = |y: &[f64; 30]| Relative {
        position: vector(y),
        attitude: matrix(&y[3..]),
        momentum: vector(&y[12..]),
        first: vector(&y[15..]),
        second: vector(&y[18..]),
    };
    let numbers = |r: &Relative, turn: &Matrix3| -> [f64; 30] {
        pack(&[
            r.position.as_slice(),
            r.attitude.as_slice(),
            r.momentum.as_slice(),
            r.first.as_slice(),
            r.second.as_slice(),
            turn.as_slice(),
        ])
    };
    let reduced = integrate(numbers(&relative, &anchor.attitude), STEPS, h, |y| {
        let state = state(y);
        let rate = two.rate(&state);
        let change = Relative {
            position: rate.position,
            attitude: lie::hat(&rate.attitude) * state.attitude,
            momentum: rate.momentum,
            first: rate.first,
            second: rate.second,
        };
        numbers(&change, &(matrix(&y[21..]) * lie::hat(&rate.axes)))
    });
    let mass: f64 = bodies.iter().map(|body| body.mass.unwrap()).sum();
    let moved = Anchor {
        attitude: matrix(&reduced[21..]),
        mass_center: anchor.mass_center + 2.0 / mass * anchor.momentum,
        ..anchor
    };
    // Both are RK4 with h = 0.005, their errors about 1e-10; the motion itself is of order one.
    let (there, then) = unpack(&inertial);
    assert!((there[0].attitude - poses[0].attitude).amax() > 0.3);
    compare(&two.restore(&state(&reduced), &moved), &(there, then), 1e-9);
    let end = state(&reduced);
    assert!((two.energy(&end) - two.energy(&relative)).abs() < 1e-9);
    let (before, after) = (two.angular_momentum(&relative), two.angular_momentum(&end));
    assert!((moved.attitude * after - anchor.attitude * before).amax() < 1e-9);
}

#[test]
fn bodies_without_mass_have_no_relative_motion() {
    let (mut bodies, potential) = system();
    bodies[1] = Body { inertia: Inertia::diagonal(Vector3::repeat(1.0)).unwrap(), mass: None };
    let error = TwoBodies::new(bodies, &potential).unwrap_err();
    assert_eq!(error.to_string(), "a body has no mass: each of several bodies needs one");
}
