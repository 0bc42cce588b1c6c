//! What an iteration on everyday maneuvers costs, part by part. Prints, and asserts nothing.

use super::chain::ChainProgram;
use super::everyday_tests::{Kind, chain_of, everyday, start_of};
use super::iteration::Solver;
use super::program::{Derivatives, Duals, Increment, Point, Program, Shape, Values};
use super::riccati::Taken;
use super::tuning::Tuning;
use crate::optimize::methods::method::Watch;
use crate::testing::Random;
use std::cell::Cell;
use std::time::Instant;

/// A program whose calls are timed.
struct Timed<'a> {
    program: &'a ChainProgram<'a>,
    /// Seconds and calls: of values, of derivatives, of moves.
    spent: Cell<[(f64, usize); 3]>,
}

impl Timed<'_> {
    fn timed<T>(&self, part: usize, of: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let out = of();
        let mut spent = self.spent.get();
        spent[part].0 += begun.elapsed().as_secs_f64();
        spent[part].1 += 1;
        self.spent.set(spent);
        out
    }
}

impl Program for Timed<'_> {
    fn shape(&self) -> &Shape {
        self.program.shape()
    }
    fn values(&self, at: &Point, out: &mut Values) -> bool {
        self.timed(0, || self.program.values(at, out))
    }
    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool {
        self.timed(1, || self.program.derivatives(at, duals, out))
    }
    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point) {
        self.timed(2, || self.program.moved(at, by, part, out))
    }
    fn at_barrier(&self, barrier: f64) {
        self.program.at_barrier(barrier)
    }
    fn longest(&self, at: &Point, by: &Increment) -> f64 {
        self.program.longest(at, by)
    }
    fn terminal_prices(&self, out: &mut [f64]) {
        self.program.terminal_prices(out)
    }
}

/// Runs of each case, of which the fastest counts.
const RUNS: usize = 7;
const CASES: usize = 8;

#[test]
#[ignore = "prints times: cargo test --release -p slewkit --lib -- --ignored --nocapture interior_point::timing"]
fn an_iteration_is_timed() {
    for steps in [25, 100] {
        for (name, tuning) in [("1e-8", rough()), ("1e-11", Tuning::default())] {
            for kind in [Kind::Time, Kind::Rate, Kind::Cone, Kind::Effort] {
                let mut random = Random(kind as u64 + 1);
                let cases = (0..CASES).map(|_| timed(&everyday(&mut random, kind), kind, steps, &tuning));
                let cases: Vec<[f64; 9]> = cases.collect();
                let median = |part: usize| {
                    let mut values: Vec<f64> = cases.iter().map(|case| case[part]).collect();
                    values.sort_by(f64::total_cmp);
                    values[CASES / 2]
                };
                println!(
                    "{steps:4} {name:5} {kind:?}: {:.0} it, {:.2} ms; µs a stage: iteration {:.2}, values {:.2} \
                     (x {:.2} an iteration), derivatives {:.2}, moved {:.2}, factor {:.2}, solve {:.2}",
                    median(0),
                    median(1) * 1e3,
                    median(2) * 1e6,
                    median(3) * 1e6,
                    median(4),
                    median(5) * 1e6,
                    median(6) * 1e6,
                    median(7) * 1e6,
                    median(8) * 1e6,
                );
            }
        }
    }
}

fn rough() -> Tuning {
    Tuning { tolerance: 1e-8, last: 1e-8, ..Tuning::default() }
}

fn timed(problem: &crate::maneuver::problem::Problem, kind: Kind, steps: usize, tuning: &Tuning) -> [f64; 9] {
    let problem = problem.clone().with_steps(steps);
    let chain = chain_of(&problem, kind);
    let (model, rows) = (&chain.model, &chain.rows);
    let start = start_of(&chain, tuning);
    let program = ChainProgram::of(model, rows, None, &start, tuning);
    let shape = program.shape();
    let timed = Timed { program: &program, spent: Cell::default() };
    let mut solver = Solver::of(shape);
    let mut best = [f64::INFINITY; 9];
    for _ in 0..RUNS {
        program.point(&start, &mut solver.point);
        timed.spent.set(Default::default());
        let begun = Instant::now();
        let run = solver.run(&timed, tuning, &Watch::NONE);
        let total = begun.elapsed().as_secs_f64();
        let iterations = run.iterations.max(1) as f64;
        let stages = shape.stages as f64;
        let spent = timed.spent.get();
        let each = |part: usize| spent[part].0 / spent[part].1.max(1) as f64 / stages;
        let (factor, solve) = solver.time_algebra(shape, tuning);
        let now = [
            iterations,
            total,
            total / iterations / stages,
            each(0),
            spent[0].1 as f64 / iterations,
            each(1),
            each(2),
            factor / stages,
            solve / stages,
        ];
        for (best, now) in best.iter_mut().zip(now) {
            *best = best.min(now);
        }
    }
    best
}

impl Solver {
    /// Seconds of a factorisation and of a solution at the present point.
    fn time_algebra(&mut self, shape: &Shape, tuning: &Tuning) -> (f64, f64) {
        self.weigh(shape, tuning);
        let begun = Instant::now();
        let taken = Taken { curved: true, shift: 0.0 };
        let _ = self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken);
        let factor = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let step = &mut self.step;
        self.riccati.solve(
            &self.at,
            &self.right,
            &mut step.point,
            &mut step.duals.costates,
            &mut step.duals.terminal,
        );
        (factor, begun.elapsed().as_secs_f64())
    }
}
