//! The cost of one step: bare, linearised, swept forward, swept with sensitivities.
//!
//! Propagations and sweeps run over 1000 steps and are counted in steps (items), so the throughput
//! column reads in steps per second.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use evidence::measured;
use nalgebra::SVector;
use slewkit::maneuver::problem::Problem;
use slewkit::optimize::discrete::step::Dynamics;
use slewkit::optimize::discrete::sweep::BoundaryValueProblem;

const STEPS: usize = 1000;

fn main() {
    divan::main();
}

/// Costates of the size that a maneuver has, scaled.
fn costate<const N: usize>() -> SVector<f64, N> {
    SVector::from_fn(|row, _| 0.3 - 0.1 * row as f64)
}

#[divan::bench]
fn bare_steps_so3(bencher: Bencher) {
    let problem = measured::attitude(STEPS);
    let dynamics = Dynamics::new(&problem, STEPS);
    bencher.counter(ItemsCount::new(STEPS)).bench(|| dynamics.propagate(black_box(&problem)));
}

fn transition<const N: usize>(bencher: Bencher, problem: &Problem) {
    let (dynamics, costate) = (Dynamics::new(problem, STEPS), costate::<N>());
    bencher.bench(|| dynamics.linearize(black_box(&problem.start), black_box(&costate)));
}

#[divan::bench]
fn one_linearisation_so3(bencher: Bencher) {
    transition::<6>(bencher, &measured::attitude(STEPS));
}

#[divan::bench]
fn one_linearisation_se3(bencher: Bencher) {
    transition::<12>(bencher, &measured::rigid_body(STEPS));
}

fn sweep<const N: usize>(bencher: Bencher, problem: &Problem) {
    let (bvp, costate) = (BoundaryValueProblem::<N>::new(problem, STEPS), costate::<N>());
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| bvp.sweep(black_box(&costate)));
}

#[divan::bench]
fn sweep_so3(bencher: Bencher) {
    sweep::<6>(bencher, &measured::attitude(STEPS));
}

#[divan::bench]
fn sweep_se3(bencher: Bencher) {
    sweep::<12>(bencher, &measured::rigid_body(STEPS));
}

fn sweep_linearized<const N: usize>(bencher: Bencher, problem: &Problem) {
    let (bvp, costate) = (BoundaryValueProblem::<N>::new(problem, STEPS), costate::<N>());
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| bvp.sweep_linearized(black_box(&costate)));
}

#[divan::bench]
fn sweep_with_sensitivities_so3(bencher: Bencher) {
    sweep_linearized::<6>(bencher, &measured::attitude(STEPS));
}

#[divan::bench]
fn sweep_with_sensitivities_se3(bencher: Bencher) {
    sweep_linearized::<12>(bencher, &measured::rigid_body(STEPS));
}
