//! What a method is: something that improves a candidate within a budget.

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

/// A way to improve a candidate.
pub(crate) trait Method {
    /// The candidate, improved as far as method and budget go; where that stops, the best that was
    /// met.
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt;
}

/// What a method may use.
#[derive(Clone, Copy)]
pub(crate) struct Budget<'a> {
    /// Iterations of one Newton run, and subproblems of one convex run.
    pub iterations: usize,
    /// Who may end the work early, and when it ends by itself.
    pub watch: Watch<'a>,
}

/// Stages between two looks at who may stop the work.
const POLLED: usize = 256;

/// Who may end the work early, and when it ends by itself.
#[derive(Clone, Copy)]
pub(crate) struct Watch<'a> {
    pub interrupt: Interrupt<'a>,
    pub deadline: Option<Instant>,
    /// Set where somebody asks to stop, for work that cannot ask.
    pub flag: Option<&'a Arc<AtomicBool>>,
}

impl Watch<'_> {
    /// Nobody, and never.
    pub const NONE: Watch<'static> = Watch { interrupt: &|| None, deadline: None, flag: None };

    /// What is left of the time \[s\], more than nothing.
    pub fn seconds_left(&self) -> f64 {
        self.deadline.map_or(f64::INFINITY, |deadline| {
            deadline.saturating_duration_since(Instant::now()).as_secs_f64().max(1e-3)
        })
    }

    pub fn stopped(&self) -> bool {
        (self.interrupt)().is_some()
    }

    /// The same of a loop over stages, which looks at a few of them only.
    pub fn stopped_at(&self, stage: usize) -> bool {
        stage.is_multiple_of(POLLED) && self.stopped()
    }
}

/// What a method made of a candidate.
#[derive(Clone, Debug)]
pub(crate) struct Attempt {
    pub candidate: Candidate,
    pub outcome: Outcome,
    /// Its cost, scaled; infinite where it is unknown.
    pub cost: f64,
    /// How far it is from a maneuver: the largest terminal error, defect or violation.
    pub residual: f64,
    /// Largest residual of all conditions of an optimum, where the method has them all.
    pub stationarity: f64,
    /// What was run, in order.
    pub runs: Vec<Run>,
    /// What convex subproblems it took.
    pub work: ConvexWork,
    /// What the sweep of its first costate showed, where that was kept.
    pub swept: Option<Swept>,
    /// The last barrier term of an interior point; what all rows together cost by it at most, and
    /// what those that act cost by it to first order, both as parts of the cost.
    pub barrier: Option<[f64; 3]>,
    /// What an interior point leaves to a later solve of nearly the same maneuver.
    pub warm: Option<Box<Warm>>,
    /// What is missing, where it did not converge.
    pub shortfall: Option<Shortfall>,
}

/// What the sweep of a costate showed.
#[derive(Clone, Debug)]
pub(crate) struct Swept {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// The error of the terminal condition, scaled.
    pub error: DVector<f64>,
    /// Cost, scaled.
    pub cost: f64,
}

/// One run of an attempt.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Its rung, where that is not the one announced.
    pub rung: Option<Rung>,
    /// Steps of its grid.
    pub steps: usize,
    pub report: Report,
}

impl Attempt {
    /// A run that ended as `report` says, and left `candidate`.
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

    /// Returns the share of the cost that the optimum nearby has: what the barrier term adds to it
    /// is left out, to first order. No optimum costs less than nothing.
    pub fn share_of_optimum(&self) -> f64 {
        1.0 - self.barrier.map_or(0.0, |[.., excess]| excess.min(1.0))
    }

    /// Returns what the optimum nearby costs.
    pub fn foreseen(&self) -> f64 {
        self.cost * self.share_of_optimum()
    }

    /// A run that could not begin.
    pub fn failed(candidate: Candidate, outcome: Outcome) -> Self {
        Self::of(candidate, Report::failed(outcome))
    }

    pub fn converged(&self) -> bool {
        self.outcome == Outcome::Converged
    }

    /// Whether a run began at all.
    pub fn began(&self) -> bool {
        self.runs.iter().any(|run| !run.report.residuals.is_empty())
    }
}
