//! A cold-start solve against one bare propagation of as many steps, side by side in one process.
//!
//! The maneuver is the free asymmetric body, three axes, rest to rest, the shorter way, to 1e-12.
//! Both use the library's own step. They run in turns, and the ratio is the median over the pairs,
//! so that a drifting clock affects both. Then the whole default plan of another body is timed,
//! with best homotopy class, second order and all witnesses, in alternation with a plan that does
//! not land. `cargo bench -p benches --bench ratio`; without `--bench` (as `cargo test` calls it)
//! only the smallest grid runs, once.

use evidence::measured;
use slewkit::maneuver::{Outcome, Problem, Settings, Solution, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::optimize::discrete::step::Dynamics;
use slewkit::optimize::search::solve;
use slewkit::plan::{Silent, Status, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};
use std::hint::black_box;
use std::time::Instant;

/// Steps, and pairs that are measured there.
const GRIDS: [(usize, usize); 4] = [(1000, 401), (10_000, 101), (100_000, 21), (1_000_000, 5)];

/// The same for the whole default plan.
const PLANS: [(usize, usize); 4] = [(100, 401), (1000, 201), (10_000, 41), (1_000_000, 3)];

fn main() {
    let benching = std::env::args().any(|argument| argument == "--bench");
    let grids = if benching { &GRIDS[..] } else { &[(1000, 1)] };
    println!("cold-start solve against bare propagation, free asymmetric body, rest to rest, to 1e-12\n");
    println!(
        "{:>9} {:>12} {:>9} {:>12} {:>9} {:>8} {:>11} {:>11} {:>11} {:>9}",
        "steps",
        "bare",
        "ns/step",
        "solve",
        "ns/step",
        "ratio",
        "2nd order",
        "witnesses",
        "whole",
        "terminal"
    );
    let measured: Vec<Measured> = grids
        .iter()
        .map(|&(steps, pairs)| {
            let measured = Measured::new(steps, pairs);
            println!("{}", row(&measured));
            measured
        })
        .collect();
    if let Some(peak) = peak_memory() {
        let (largest, _) = grids[grids.len() - 1];
        println!("\npeak memory up to {largest} steps, trajectory and verification included: {peak}");
    }
    println!("\nspread of the ratio over the pairs, 5 %, median, 95 %:");
    for Measured { steps, low, ratio, high, .. } in &measured {
        println!("{steps:>9} steps: {low:.2} … {ratio:.2} … {high:.2}");
    }
    whole_plans(benching);
    println!(
        "discrete: the plan whose discrete motion meets the end; then whole over discrete, and what landing \
            takes a correction"
    );
    println!("\nsolve: the solver alone, all grids and starts. 2nd order: writing the trajectory down and");
    println!("the tests of stationarity, rank and conjugate points. witnesses: both of the verification.");
}

/// Times the plan that a user gets by default: J = diag(1, 2, 3), 120° about (1, 2, 3) in 4 s from
/// rest to rest.
fn whole_plans(benching: bool) {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0)).unwrap(), mass: None };
    let turn = Vector3::new(1.0, 2.0, 3.0).normalize() * 120.0_f64.to_radians();
    let (start, end) = (State::at_rest(Matrix3::identity()), State::at_rest(lie::exp(&turn)));
    println!("\nwhole default plan (best, second order, all witnesses), {} threads:", threads());
    println!(
        "{:>9} {:>12} {:>12} {:>8} {:>12} {:>8} {:>12}",
        "steps", "bare", "whole", "ratio", "discrete", "ratio", "correction"
    );
    let grids = if benching { &PLANS[..] } else { &PLANS[..1] };
    for &(steps, pairs) in grids {
        let problem = Problem::attitude(body.clone(), start, end, 4.0).with_steps(steps);
        let dynamics = Dynamics::new(&problem, steps);
        let (mut bares, mut wholes, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        let (mut discretes, mut landings, mut corrections) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..if benching { pairs } else { 1 } {
            let (_, bare) = timed(|| dynamics.propagate(black_box(&problem)).unwrap());
            let planned = |settings: Settings| {
                let (found, time) =
                    timed(|| plan(black_box(&problem), &settings, None, &mut Silent).unwrap());
                assert_eq!(found.status, Status::Solved);
                (found, time)
            };
            let (found, whole) = planned(Settings::default());
            let (_, discrete) = planned(Settings::discrete());
            bares.push(bare);
            wholes.push(whole);
            ratios.push(whole / bare);
            discretes.push(discrete);
            landings.push(whole / discrete);
            let count = found.solution.landing.map_or(1, |landing| landing.corrections.max(1));
            corrections.push((whole - discrete) / count as f64);
        }
        let [bare, whole, discrete] =
            [&mut bares, &mut wholes, &mut discretes].map(|times| quantile(times, 0.5) * 1e3);
        let [ratio, landing] = [&mut ratios, &mut landings].map(|ratios| quantile(ratios, 0.5));
        let correction = quantile(&mut corrections, 0.5) * 1e6;
        println!(
            "{steps:>9} {bare:>9.4} ms {whole:>9.3} ms {ratio:>8.1} {discrete:>9.3} ms {landing:>8.2} \
                {correction:>9.1} us"
        );
    }
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Times [s] of one grid, medians over the pairs.
struct Measured {
    steps: usize,
    bare: f64,
    solve: f64,
    ratio: f64,
    low: f64,
    high: f64,
    proof: f64,
    verification: f64,
    terminal: f64,
}

impl Measured {
    fn new(steps: usize, pairs: usize) -> Self {
        let problem = measured::attitude(steps);
        let dynamics = Dynamics::new(&problem, steps);
        let settings = Settings::default();
        let (mut bares, mut solves, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
        let (mut proofs, mut verifications) = (Vec::new(), Vec::new());
        let mut terminal: f64 = 0.0;
        for index in 0..pairs {
            let (_, bare) = timed(|| dynamics.propagate(black_box(&problem)).unwrap());
            let (solution, whole): (Solution, f64) =
                timed(|| solve(black_box(&problem), &settings, None, &mut Silent).unwrap());
            assert_eq!(solution.outcome, Outcome::Converged);
            terminal = terminal.max(solution.terminal.largest());
            assert!(terminal <= 1e-12);
            bares.push(bare);
            solves.push(solution.solve_time);
            ratios.push(solution.solve_time / bare);
            proofs.push(whole - solution.solve_time);
            // The witnesses take far longer than the solve, and their time is constant: a few
            // runs suffice.
            if index < 5 {
                let (verification, time) =
                    timed(|| verify(&problem, &solution.trajectory, settings.tolerance, None));
                assert!(verification.passed(), "{:?}", verification.checks);
                verifications.push(time);
            }
        }
        Self {
            steps,
            bare: quantile(&mut bares, 0.5),
            solve: quantile(&mut solves, 0.5),
            low: quantile(&mut ratios, 0.05),
            ratio: quantile(&mut ratios, 0.5),
            high: quantile(&mut ratios, 0.95),
            proof: quantile(&mut proofs, 0.5),
            verification: quantile(&mut verifications, 0.5),
            terminal,
        }
    }
}

fn row(measured: &Measured) -> String {
    let Measured { steps, bare, solve, ratio, proof, verification, terminal, .. } = measured;
    let (milli, nano) = (|time: f64| format!("{:.3} ms", time * 1e3), 1e9 / *steps as f64);
    format!(
        "{steps:>9} {:>12} {:>9.1} {:>12} {:>9.1} {ratio:>8.2} {:>11} {:>11} {:>11} {terminal:>9.1e}",
        milli(*bare),
        bare * nano,
        milli(*solve),
        solve * nano,
        milli(*proof),
        milli(*verification),
        milli(solve + proof + verification),
    )
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = Instant::now();
    let result = black_box(work());
    (result, began.elapsed().as_secs_f64())
}

fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

/// Returns the peak memory of the process, if the system reports it.
fn peak_memory() -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(format!("{:.0} MB", kilobytes / 1024.0))
}
