//! Interface of a method: it improves a candidate within a budget.

use super::driver::{Interrupt, Report};
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{ConvexWork, Outcome, Rung};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::Node;
use crate::optimize::methods::interior_point::chain::warm::Warm;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A method that improves a candidate.
pub(crate) trait Method {
    /// Improves the candidate as far as the method and the budget allow, and returns the best one
    /// found.
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt;
}

/// Limits of the work of a method.
#[derive(Clone, Copy)]
pub(crate) struct Budget<'a> {
    /// Largest number of iterations of one Newton run, and of subproblems of one convex run.
    pub iterations: usize,
    /// Means to stop work early: stop requests and the deadline.
    pub watch: Watch<'a>,
}

/// Number of stages between two checks for a stop request.
const POLLED: usize = 256;

/// Means to stop work early: stop requests and the deadline.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a> {
    pub interrupt: Interrupt<'a>,
    pub deadline: Option<Instant>,
    /// Flag that is set when a stop is requested, for code that cannot call `interrupt`.
    pub flag: Option<&'a Arc<AtomicBool>>,
}

impl Watch<'_> {
    /// A watch that never stops the work.
    pub const NONE: Watch<'static> = Watch { interrupt: &|| None, deadline: None, flag: None };

    /// Returns the remaining time \[s\], at least 1 ms; infinite without a deadline.
    pub fn seconds_left(&self) -> f64 {
        self.deadline.map_or(f64::INFINITY, |deadline| {
            deadline.saturating_duration_since(Instant::now()).as_secs_f64().max(1e-3)
        })
    }

    pub fn stopped(&self) -> bool {
        (self.interrupt)().is_some()
    }

    /// Returns whether a stop is requested, for a loop over stages; polls only at every 256th
    /// stage.
    pub fn stopped_at(&self, stage: usize) -> bool {
        stage.is_multiple_of(POLLED) && self.stopped()
    }
}

/// Result of a method for one candidate.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub candidate: Candidate,
    pub outcome: Outcome,
    /// Cost of the candidate, scaled; infinite if it is unknown.
    pub cost: f64,
    /// Distance from a valid maneuver: the largest terminal error, defect or constraint violation.
    pub residual: f64,
    /// Largest residual of all optimality conditions; not a number if the method does not compute
    /// all of them.
    pub stationarity: f64,
    /// Runs of iterations that the method made, in order.
    pub runs: Vec<Run>,
    /// Work spent on convex subproblems.
    pub work: ConvexWork,
    /// Sweep from the initial costate, with all its nodes; `None` if the nodes were not kept.
    pub swept: Option<Swept>,
    /// Barrier of an interior-point method: the last barrier parameter; an upper bound on the cost
    /// that the barrier adds for all rows; and the cost that it adds for the active rows, to first
    /// order. The last two are fractions of the cost.
    pub barrier: Option<[f64; 3]>,
    /// Warm start that an interior-point method leaves to a later solve of nearly the same
    /// maneuver.
    pub warm: Option<Box<Warm>>,
    /// What the candidate lacks to be a solution; `None` if the method converged or does not report
    /// it.
    pub shortfall: Option<Shortfall>,
}

/// Result of the sweep from a costate.
#[derive(Clone, Debug)]
pub(crate) struct Swept {
    /// All nodes of the sweep.
    pub nodes: Vec<Node>,
    /// Error of the terminal condition, scaled.
    pub error: DVector<f64>,
    /// Cost of the sweep, scaled.
    pub cost: f64,
}

/// One run of an iteration within an attempt.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Strategy of the run; `None` if it is the strategy with which the search started the method.
    pub rung: Option<Rung>,
    /// Number of steps of the grid of the run.
    pub steps: usize,
    pub report: Report,
}

impl Attempt {
    /// Creates an attempt from the report of one run and the candidate that the run left.
    pub fn of(candidate: Candidate, report: Report) -> Self {
        let outcome = report.outcome;
        let runs = vec![Run { rung: None, steps: candidate.steps(), report }];
        let (cost, residual, stationarity) = (f64::INFINITY, f64::INFINITY, f64::NAN);
        let work = ConvexWork::default();
        Self {
            candidate,
            outcome,
            cost,
            residual,
            stationarity,
            runs,
            work,
            swept: None,
            barrier: None,
            warm: None,
            shortfall: None,
        }
    }

    /// Returns the estimated ratio of the optimal cost to the cost of this attempt, from 0 to 1.
    /// The difference is the cost that the barrier adds for the active rows, to first order.
    pub fn share_of_optimum(&self) -> f64 {
        1.0 - self.barrier.map_or(0.0, |[.., excess]| excess.min(1.0))
    }

    /// Returns the cost of the attempt without the cost that the barrier adds: an estimate of the
    /// cost of the nearby optimum.
    pub fn foreseen(&self) -> f64 {
        self.cost * self.share_of_optimum()
    }

    /// Creates the result of a method that could not start.
    pub fn failed(candidate: Candidate, outcome: Outcome) -> Self {
        Self::of(candidate, Report::failed(outcome))
    }

    pub fn converged(&self) -> bool {
        self.outcome == Outcome::Converged
    }

    /// Returns whether at least one run started its iteration.
    pub fn began(&self) -> bool {
        self.runs.iter().any(|run| !run.report.residuals.is_empty())
    }
}
