//! Conservation by compensated updates in long runs of 10⁶ steps (10⁷:
//! `cargo bench -p benches --bench integrators`).

use super::*;
use crate::mechanics::body::Inertia;
use crate::propagate::integrator::Quadrature;

/// Returns a steady rotation about the axis of the largest moment, for a body with tilted axes.
/// Every step has the same rounding errors.
fn steady_rotation() -> (System, SystemState) {
    let axes = lie::exp(&Vector3::new(0.5, -0.4, 0.3));
    let moments = Matrix3::from_diagonal(&Vector3::new(1.0, 1.7, 2.2));
    let body = Body { inertia: Inertia::new(axes * moments * axes.transpose()).unwrap(), mass: None };
    let system = System::new(vec![body], None).unwrap();
    let state = start(&system, &Matrix3::identity(), axes * Vector3::new(0.0, 0.0, 2.86));
    (system, state)
}

/// Returns the rise of a least-squares line over the whole run, and the standard error of the rise.
fn trend(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let t = |index: usize| (index as f64 + 0.5) / n - 0.5;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = (0..values.len()).map(|index| t(index).powi(2)).sum();
    let slope =
        values.iter().enumerate().map(|(index, value)| t(index) * (value - mean)).sum::<f64>() / square;
    let residual = |(index, value): (usize, &f64)| (value - mean - slope * t(index)).powi(2);
    let variance = values.iter().enumerate().map(residual).sum::<f64>() / (n - 2.0);
    (slope, (variance / square).sqrt())
}

#[test]
fn momentum_energy_and_orthogonality_hold_over_1e6_steps() {
    for (name, (system, state), h) in [
        ("free asymmetric", free_body(), 0.02),
        ("steady rotation", steady_rotation(), 0.02),
        ("two dumbbells", dumbbells(2.5, 4.0), 0.01),
    ] {
        let quadrature = Quadrature::Gauss;
        for (kind, steps) in [
            (Kind::LieEuler, 100_000),
            (Kind::LieEulerAdjoint, 100_000),
            (Kind::LieVerlet, 1_000_000),
            (Kind::LieVerletLagrangian, 1_000_000),
            (Kind::Galerkin { degree: 2, quadrature }, 10_000),
        ] {
            let before = system.invariants(&state);
            let mut method = method(kind, &system, &state, h);
            let mut energies = Vec::new();
            for step in 0..steps {
                method.step(&[]).unwrap();
                let now = system.invariants(method.state());
                let drift = (now.angular_momentum - before.angular_momentum).norm();
                assert!(drift <= 1e-13 * before.angular_momentum.norm(), "{kind} {name} {step}: {drift:e}");
                assert!(now.linear_momentum.norm() <= 1e-13, "{kind} {name} {step}");
                assert!(now.orthogonality <= 1e-12, "{kind} {name} {step}: {:e}", now.orthogonality);
                energies.push(now.energy - before.energy);
            }
            // Means over intervals of many periods, which scatter about a line.
            let stretches: Vec<f64> = energies
                .chunks(steps / 100)
                .map(|chunk| chunk.iter().sum::<f64>() / chunk.len() as f64)
                .collect();
            let (slope, noise) = trend(&stretches);
            println!("{name} {kind}: trend {slope:.1e} ± {noise:.1e}");
            // Rounding alone causes a random walk of √k ulps; the bounded oscillation is usually
            // far larger.
            let floor = 1e-15 * before.energy.abs() * (steps as f64).sqrt();
            assert!(slope.abs() <= 4.0 * noise + floor, "{kind} {name}: {slope:e} ± {noise:e}");
        }
    }
}

/// Tests a degree that is rarely used, over a million steps of a steady rotation, where rounding
/// errors accumulate fastest.
#[test]
fn galerkin_methods_hold_a_steady_rotation_over_1e6_steps() {
    let (system, state) = steady_rotation();
    let before = system.invariants(&state);
    for degree in [1, 2] {
        let mut method =
            method(Kind::Galerkin { degree, quadrature: Quadrature::Gauss }, &system, &state, 0.02);
        for _ in 0..1_000_000 {
            method.step(&[]).unwrap();
        }
        let now = system.invariants(method.state());
        let drift = (now.angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm();
        assert!(drift <= 1e-13 && now.orthogonality <= 1e-12, "{degree}: {drift:e} {:e}", now.orthogonality);
    }
}

/// The update without compensation, `R⁺ = R F` and `Π⁺ = FᵀΠ`, fails the requirement of the test
/// above over the same number of steps of a steady rotation.
#[test]
fn a_naive_update_does_not_hold() {
    let (system, start) = steady_rotation();
    let equation = crate::propagate::integrator::AttitudeEquation::new(&system.bodies()[0].inertia, 0.02);
    let (mut attitude, mut momentum) = (start.poses()[0].attitude, start.momenta()[0].angular);
    let spatial = attitude * momentum;
    for _ in 0..1_000_000 {
        let turn = lie::cayley(&equation.solve(&momentum).unwrap().0);
        attitude *= turn;
        momentum = turn.tr_mul(&momentum);
    }
    let orthogonality = (attitude.tr_mul(&attitude) - Matrix3::identity()).norm();
    let drift = (attitude * momentum - spatial).norm() / spatial.norm();
    println!("orthogonality {orthogonality:e}, momentum {drift:e}");
    assert!(orthogonality > 1e-12 && drift > 1e-13);
}
