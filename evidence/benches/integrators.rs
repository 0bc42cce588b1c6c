//! The cost of a step of each integrator, of the implicit equation by three methods, and the
//! conservation over long runs.
//!
//! `cargo bench -p benches --bench integrators` measures one step of every method on the free
//! asymmetric body and on two dumbbells, then the implicit equation, then conservation over 10⁶ and
//! 10⁷ steps. If `--bench` is missing (as when `cargo test` calls it), everything runs once and
//! briefly. Times are the fastest of many batches, because other work on the machine moves a
//! median.

use evidence::motions::{dumbbells, free_body, full_inertia, steady_rotation};
use slewkit::propagate::integrator::{AttitudeEquation, ErrorControl, Kind};
use slewkit::{Matrix3, Vector3, lie};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let benching = std::env::args().any(|argument| argument == "--bench");
    let seconds = if benching { 0.3 } else { 0.0 };
    steps(seconds);
    implicit(seconds);
    naive(seconds, if benching { 1_000_000 } else { 1000 });
    conservation(if benching { &[1_000_000, 10_000_000] } else { &[1000] });
}

/// Returns the shortest time of a batch in some seconds, in ns per item.
fn fastest(seconds: f64, items: u32, mut batch: impl FnMut()) -> f64 {
    let (mut best, whole) = (f64::INFINITY, Instant::now());
    loop {
        let began = Instant::now();
        batch();
        best = best.min(began.elapsed().as_secs_f64());
        if whole.elapsed().as_secs_f64() >= seconds {
            return best * 1e9 / f64::from(items);
        }
    }
}

fn steps(seconds: f64) {
    const STEPS: u32 = 200;
    println!("one step, ns, evaluations and iterations a step\n");
    println!("{:24} {:>30} {:>30}", "", "free body, h = 0.01", "two dumbbells, h = 0.01");
    for kind in Kind::all() {
        let mut line = format!("{:24}", kind.name());
        for (system, state) in [free_body(), dumbbells()] {
            let mut method = kind.start(&system, &state, 0.01, &ErrorControl::default()).unwrap();
            let time = fastest(seconds, STEPS, || (0..STEPS).for_each(|_| method.step(&[]).unwrap()));
            let work = method.work();
            let per = |count: u64| count as f64 / work.steps as f64;
            line += &format!(
                " {:>12.1} {:>8.2} {:>8.2}",
                time,
                per(work.force_evaluations),
                per(work.iterations)
            );
        }
        println!("{line}");
    }
}

fn implicit(seconds: f64) {
    const ITEMS: u32 = 1000;
    println!("\nthe implicit equation, full inertia: ns (iterations)\n");
    println!(
        "{:>10} {:>18} {:>18} {:>18} {:>8} {:>8}",
        "angle, rad", "exponential", "Cayley, Newton", "Cayley, ours", "exp/cay", "exp/ours"
    );
    for angle in [1e-3, 0.02, 0.05, 0.1, 0.2, 0.3, 0.6, 1.0] {
        let equation = AttitudeEquation::new(&full_inertia(), 1.0);
        let momenta: Vec<Vector3> = (0..ITEMS)
            .map(|index| {
                let t = f64::from(index);
                let direction = Vector3::new((1.3 * t).sin(), (0.7 * t + 1.0).cos(), (2.1 * t).sin());
                full_inertia().j() * (direction.normalize() * angle)
            })
            .collect();
        let run = |solve: &dyn Fn(&Vector3) -> Option<(Vector3, u32)>| {
            let mut iterations = 0;
            let time = fastest(seconds, ITEMS, || {
                iterations = 0;
                // Each waits for the one before, as steps do.
                let mut shift = 0.0;
                for momentum in &momenta {
                    let Some((root, count)) = black_box(solve(&(momentum + Vector3::repeat(shift)))) else {
                        continue;
                    };
                    shift = root.x * 1e-300;
                    iterations += count;
                }
            });
            (time, f64::from(iterations) / f64::from(ITEMS))
        };
        let exponential = run(&|momentum| equation.exponential(momentum));
        let newton = run(&|momentum| equation.newton(momentum));
        let ours = run(&|momentum| equation.solve(momentum));
        let cell = |(time, iterations): (f64, f64)| format!("{time:.1} ({iterations:.2})");
        println!(
            "{angle:>10} {:>18} {:>18} {:>18} {:>8.2} {:>8.2}",
            cell(exponential),
            cell(newton),
            cell(ours),
            exponential.0 / newton.0,
            exponential.0 / ours.0
        );
    }
}

/// Measures `R⁺ = R F` and `Π⁺ = FᵀΠ` without compensation, with the equation of the library.
fn naive(seconds: f64, steps: u32) {
    const BATCH: u32 = 200;
    println!(
        "\nnaive and compensated updates after {steps} steps of 0.02 s: drift of momentum, RᵀR, ns a step\n"
    );
    println!("{:16} {:>30} {:>30}", "", "naive", "compensated");
    for (name, (system, start)) in [("free asymmetric", free_body()), ("steady rotation", steady_rotation())]
    {
        let equation = AttitudeEquation::new(&system.bodies()[0].inertia, 0.02);
        let (attitude, momentum) = (start.poses()[0].attitude, start.momenta()[0].angular);
        let spatial = attitude * momentum;
        let drift = |attitude: &Matrix3, momentum: &Vector3| {
            let orthogonality = (attitude.tr_mul(attitude) - Matrix3::identity()).norm();
            ((attitude * momentum - spatial).norm() / spatial.norm(), orthogonality)
        };
        let step = |(attitude, momentum): (Matrix3, Vector3)| {
            let turn = lie::cayley(&equation.solve(&momentum).unwrap().0);
            (attitude * turn, turn.tr_mul(&momentum))
        };
        let end = (0..steps).fold((attitude, momentum), |state, _| step(state));
        let (lost, off) = drift(&end.0, &end.1);
        let mut state = (attitude, momentum);
        let time = fastest(seconds, BATCH, || (0..BATCH).for_each(|_| state = step(black_box(state))));
        let cell = |lost: f64, off: f64, time: f64| format!("{lost:.1e} {off:.1e} {time:.1}");
        let naive = cell(lost, off, time);
        let mut method = Kind::LieVerlet.start(&system, &start, 0.02, &ErrorControl::default()).unwrap();
        (0..steps).for_each(|_| method.step(&[]).unwrap());
        let (pose, momenta) = (method.state().poses()[0], method.state().momenta()[0]);
        let (lost, off) = drift(&pose.attitude, &momenta.angular);
        let time = fastest(seconds, BATCH, || (0..BATCH).for_each(|_| method.step(&[]).unwrap()));
        println!("{name:16} {naive:>30} {:>30}", cell(lost, off, time));
    }
}

/// Returns the least-squares slope of the values over 0…1, and its standard error.
fn trend(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let t = |index: usize| index as f64 / n - 0.5 + 0.5 / n;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = (0..values.len()).map(|index| t(index).powi(2)).sum();
    let slope =
        values.iter().enumerate().map(|(index, value)| t(index) * (value - mean)).sum::<f64>() / square;
    let residual = |(index, value): (usize, &f64)| (value - mean - slope * t(index)).powi(2);
    let variance = values.iter().enumerate().map(residual).sum::<f64>() / (n - 2.0);
    (slope, (variance / square).sqrt())
}

fn conservation(horizons: &[u64]) {
    println!(
        "\nconservation, largest over the run; the trend of the energy is its rise over the whole run\n"
    );
    println!(
        "{:16} {:24} {:>9} {:>12} {:>12} {:>12} {:>24}",
        "case", "method", "steps", "momentum", "orthogonal", "energy", "trend of the energy"
    );
    let quadrature = slewkit::propagate::integrator::Quadrature::Gauss;
    let kinds = [
        Kind::LieEuler,
        Kind::LieVerlet,
        Kind::LieVerletLagrangian,
        Kind::Galerkin { degree: 2, quadrature },
    ];
    for (name, (system, state), step) in [
        ("free asymmetric", free_body(), 0.02),
        ("steady rotation", steady_rotation(), 0.02),
        ("two dumbbells", dumbbells(), 0.01),
    ] {
        for (kind, steps) in kinds.iter().flat_map(|kind| horizons.iter().map(move |steps| (*kind, *steps))) {
            let before = system.invariants(&state);
            let mut method = kind.start(&system, &state, step, &ErrorControl::default()).unwrap();
            let (mut momentum, mut orthogonality, mut energy) = (0.0_f64, 0.0_f64, 0.0_f64);
            let samples = steps.min(1000);
            let mut energies = Vec::with_capacity(samples as usize);
            for _ in 0..samples {
                // The mean over a stretch: the bounded oscillation would hide a trend.
                let stretch = steps / samples;
                let mut sum = 0.0;
                for _ in 0..stretch {
                    method.step(&[]).unwrap();
                    let now = system.invariants(method.state());
                    let drift = now.angular_momentum - before.angular_momentum;
                    momentum = momentum.max(drift.norm() / before.angular_momentum.norm());
                    orthogonality = orthogonality.max(now.orthogonality);
                    let error = (now.energy - before.energy) / before.energy.abs();
                    energy = energy.max(error.abs());
                    sum += error;
                }
                energies.push(sum / stretch as f64);
            }
            let (slope, noise) = trend(&energies);
            println!(
                "{name:16} {:24} {steps:>9} {momentum:>12.1e} {orthogonality:>12.1e} {energy:>12.1e} {:>24}",
                kind.name(),
                format!("{slope:.1e} ± {noise:.1e}")
            );
        }
    }
}
