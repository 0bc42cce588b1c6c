//! `argmin` drives every iteration of the crate, here and nowhere else.

use crate::maneuver::solution::Outcome;
use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, State, TerminationReason};

/// An iteration that knows nothing of its driver.
pub(crate) trait Iteration {
    /// Norm of the residual at the present iterate.
    fn residual(&self) -> f64;
    /// Whether there is nothing left to do.
    fn converged(&self) -> bool;
    /// One step; `Some` when the iteration ends, at its best iterate.
    fn advance(&mut self) -> Option<Outcome>;
}

/// How a run went.
#[derive(Clone, Debug)]
pub(crate) struct Report {
    pub outcome: Outcome,
    pub iterations: usize,
    /// Residual before the first and after every iteration.
    pub residuals: Vec<f64>,
}

/// Asked between iterations; `Some` ends the run.
pub(crate) type Interrupt<'a> = &'a dyn Fn() -> Option<Outcome>;

struct Driver<'a, I> {
    iteration: I,
    interrupt: Interrupt<'a>,
    outcome: Option<Outcome>,
    residuals: Vec<f64>,
}

type DriverState = IterState<(), (), (), (), (), f64>;

impl<I: Iteration> Solver<(), DriverState> for Driver<'_, I> {
    fn name(&self) -> &str {
        "slewkit"
    }

    // A numerical failure is an outcome, not an `Err`: argmin would drop iterate and history.
    fn next_iter(
        &mut self,
        _: &mut Problem<()>,
        state: DriverState,
    ) -> Result<(DriverState, Option<KV>), Error> {
        self.outcome = self.iteration.advance();
        let residual = self.iteration.residual();
        self.residuals.push(residual);
        if self.outcome.is_none() {
            self.outcome = (self.interrupt)();
        }
        let state = state.cost(residual);
        let ended = self.outcome.is_some();
        Ok((if ended { state.terminate_with(TerminationReason::SolverConverged) } else { state }, None))
    }
}

/// Runs an iteration to its end or for `max_iterations`.
pub(crate) fn run<I: Iteration>(iteration: I, max_iterations: usize, interrupt: Interrupt) -> (I, Report) {
    let residuals = vec![iteration.residual()];
    if iteration.converged() {
        return (iteration, Report { outcome: Outcome::Converged, iterations: 0, residuals });
    }
    let driver = Driver { iteration, interrupt, outcome: None, residuals };
    let executor = Executor::new((), driver)
        .configure(|state: DriverState| state.max_iters(max_iterations as u64))
        .timer(false);
    // `next_iter` never fails and there are no observers or checkpoints that could.
    let Ok(result) = executor.run() else { unreachable!("the driver returns no error") };
    let (iterations, driver) = (result.state.get_iter() as usize, result.solver);
    let outcome = driver.outcome.unwrap_or(Outcome::IterationLimit);
    (driver.iteration, Report { outcome, iterations, residuals: driver.residuals })
}
