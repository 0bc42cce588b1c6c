//! Driver of every iteration, Newton and SCP: `argmin`, used only in this module, or a plain loop
//! without the feature `argmin`.
//!
//! Both give bit-identical results and the same report. argmin costs less than a microsecond per
//! iteration.
//!
//! # Why is argmin behind one module?
//!
//! `methods/driver.rs` holds its `Solver` implementation; the iterations know only a trait of three
//! methods. A numerical failure is an `Outcome` in the iteration, not an `Err`, because argmin
//! drops iterate and history on `Err`. The module drives shooting, lifted Newton, SCP and the
//! polish of SCP in the same way. Whether a driver library is worth its place for four iterations
//! is a matter of opinion: it provides limits and termination, and the module can be replaced
//! without a change to the mathematics. Therefore argmin is a feature. Without it a plain loop
//! drives the same trait. A test holds both to bit-identical results and equal reports for every
//! way a run can end.

use crate::maneuver::solution::Outcome;

/// An iteration that is independent of its driver.
pub(crate) trait Iteration {
    /// Returns the norm of the residual at the current iterate.
    fn residual(&self) -> f64;
    /// Returns whether the iteration has converged.
    fn converged(&self) -> bool;
    /// Makes one step. Returns the outcome if the iteration ends with this step, at its best
    /// iterate, and `None` if it continues.
    fn advance(&mut self) -> Option<Outcome>;
}

/// Report of a run of an iteration.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Report {
    pub outcome: Outcome,
    pub iterations: usize,
    /// Residual before the first iteration and after each one.
    pub residuals: Vec<f64>,
}

impl Report {
    /// Creates the report of a run that could not start.
    pub fn failed(outcome: Outcome) -> Self {
        Self { outcome, iterations: 0, residuals: Vec::new() }
    }
}

/// Function that is polled between iterations; `Some` ends the run with this outcome.
pub(crate) type Interrupt<'a> = &'a dyn Fn() -> Option<Outcome>;

/// Runs an iteration until it ends or is interrupted, for at most `max_iterations` steps. Returns
/// the iteration in its final state, and the report of the run.
pub(crate) fn run<I: Iteration>(iteration: I, max_iterations: usize, interrupt: Interrupt) -> (I, Report) {
    let mut run = Run { residuals: vec![iteration.residual()], iteration, interrupt, outcome: None };
    let mut iterations = 0;
    if run.iteration.converged() {
        run.outcome = Some(Outcome::Converged);
    } else {
        iterations = iterate(&mut run, max_iterations);
    }
    let Run { iteration, outcome, residuals, .. } = run;
    (iteration, Report { outcome: outcome.unwrap_or(Outcome::IterationLimit), iterations, residuals })
}

/// State of a run in progress.
struct Run<'a, I> {
    iteration: I,
    interrupt: Interrupt<'a>,
    outcome: Option<Outcome>,
    residuals: Vec<f64>,
}

impl<I: Iteration> Run<'_, I> {
    /// Makes one step; returns its residual, and whether it was the last step.
    fn advance(&mut self) -> (f64, bool) {
        self.outcome = self.iteration.advance();
        let residual = self.iteration.residual();
        self.residuals.push(residual);
        if self.outcome.is_none() {
            self.outcome = (self.interrupt)();
        }
        (residual, self.outcome.is_some())
    }
}

/// Makes steps until the run ends, at most `max_iterations`; returns their number.
#[cfg(any(test, not(feature = "argmin")))]
fn in_a_loop<I: Iteration>(run: &mut Run<I>, max_iterations: usize) -> usize {
    (1..=max_iterations).find(|_| run.advance().1).unwrap_or(max_iterations)
}

#[cfg(not(feature = "argmin"))]
use in_a_loop as iterate;
#[cfg(feature = "argmin")]
use under_argmin::iterate;

#[cfg(feature = "argmin")]
mod under_argmin {
    use super::{Iteration, Run};
    use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, State, TerminationReason};

    type DriverState = IterState<(), (), (), (), (), f64>;

    struct Driver<'r, 'a, I>(&'r mut Run<'a, I>);

    impl<I: Iteration> Solver<(), DriverState> for Driver<'_, '_, I> {
        fn name(&self) -> &str {
            "slewkit"
        }

        // A numerical failure is an outcome, not an `Err`: argmin would drop iterate and history.
        fn next_iter(
            &mut self,
            _: &mut Problem<()>,
            state: DriverState,
        ) -> Result<(DriverState, Option<KV>), Error> {
            let (residual, ended) = self.0.advance();
            let state = state.cost(residual);
            let state = if ended { state.terminate_with(TerminationReason::SolverConverged) } else { state };
            Ok((state, None))
        }
    }

    /// Makes steps until the run ends, at most `max_iterations`; returns their number.
    pub(super) fn iterate<I: Iteration>(run: &mut Run<I>, max_iterations: usize) -> usize {
        let executor = Executor::new((), Driver(run))
            .configure(|state: DriverState| state.max_iters(max_iterations as u64))
            .timer(false);
        // `next_iter` never fails and there are no observers or checkpoints that could.
        let Ok(result) = executor.run() else { unreachable!("the driver returns no error") };
        result.state.get_iter() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Newton's iteration for the square root of two.
    #[derive(Clone, Debug, PartialEq)]
    struct Root {
        x: f64,
    }

    impl Iteration for Root {
        fn residual(&self) -> f64 {
            (self.x * self.x - 2.0).abs()
        }
        fn converged(&self) -> bool {
            self.residual() < 1e-14
        }
        fn advance(&mut self) -> Option<Outcome> {
            self.x -= (self.x * self.x - 2.0) / (2.0 * self.x);
            if !self.x.is_finite() {
                return Some(Outcome::Stalled);
            }
            self.converged().then_some(Outcome::Converged)
        }
    }

    /// Runs the iteration by the plain loop.
    fn plain(iteration: Root, max_iterations: usize, interrupt: Interrupt) -> (Root, Report) {
        let mut run = Run { residuals: vec![iteration.residual()], iteration, interrupt, outcome: None };
        let iterations = in_a_loop(&mut run, max_iterations);
        let outcome = run.outcome.unwrap_or(Outcome::IterationLimit);
        (run.iteration, Report { outcome, iterations, residuals: run.residuals })
    }

    /// Claim: argmin and the plain loop give bit-identical results and equal reports, however a run
    /// ends.
    #[test]
    fn argmin_and_a_plain_loop_give_the_same_bits() {
        let after = |steps: usize| {
            let asked = Cell::new(0);
            move || {
                asked.set(asked.get() + 1);
                (asked.get() == steps).then_some(Outcome::Interrupted)
            }
        };
        let ends = [
            (1.0, 50, 99, Outcome::Converged),
            (1e9, 7, 99, Outcome::IterationLimit),
            (1e9, 0, 99, Outcome::IterationLimit),
            (1e9, 50, 3, Outcome::Interrupted),
            (0.0, 50, 99, Outcome::Stalled),
        ];
        for (x, limit, steps, outcome) in ends {
            let (driven, report) = run(Root { x }, limit, &after(steps));
            let (looped, expected) = plain(Root { x }, limit, &after(steps));
            assert_eq!(report.outcome, outcome);
            assert_eq!(report.iterations, expected.iterations);
            assert_eq!(driven.x.to_bits(), looped.x.to_bits());
            let bits = |report: &Report| report.residuals.iter().map(|r| r.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&report), bits(&expected));
        }
    }
}
