//! Sequential convex programming (SCP) on the group.
//!
//! It plans least effort in a given duration, as the alternative that a plan of the interior point can be compared with. Around
//! an iterate the chain of stages and all limits ([`crate::optimize::chain`]) are linear in tangent
//! vectors, the cost is quadratic: a cone program ([`subproblem`]), with a trust region on the rotation
//! of each node, a virtual control and slacks that keep it feasible. Its solution moves the iterate by
//! the group's exponential. A move that gives less than it promises, since the dynamics bend along it, is corrected to second
//! order: solved once more with the defects that it ended with. Near a solution the interior point
//! ends the digits ([`method`]). The duals of the subproblems are costates, to six digits where the
//! iteration itself converges.

pub(crate) mod method;
pub(crate) mod subproblem;
mod tuning;

use crate::maneuver::solution::Outcome;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::iterate::{Evaluated, Iterate};
use crate::optimize::chain::model::{Model, state};
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::methods::PROMISED;
use crate::optimize::methods::driver::{self, Iteration};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::tuning::*;
use nalgebra::DVector;
use subproblem::{Failure, Move, Subproblem, Weights};

/// What the iteration may do.
#[derive(Clone, Debug)]
pub(crate) struct ScpOptions {
    /// Whether the interior point ends the digits. Without, the converged iterate counts as it is.
    pub polish: bool,
    /// Size of a move at which the iteration counts as converged \[rad\].
    pub tolerance: f64,
    /// Accuracy of the subproblems; about 1e-9 is what the cone solver reliably gives.
    pub cone_tolerance: f64,
    /// Subproblems after which the iteration gives up.
    pub most: usize,
}

impl Default for ScpOptions {
    fn default() -> Self {
        Self { polish: true, tolerance: 1e-2, cone_tolerance: 1e-6, most: 60 }
    }
}

impl ScpOptions {
    /// The convex iteration to its own convergence.
    pub fn unpolished() -> Self {
        // Duals follow the iterate: they have six digits only where its moves have nine.
        Self { polish: false, tolerance: 1e-9, cone_tolerance: 1e-9, ..Self::default() }
    }

    /// The same with `most` subproblems.
    pub fn within(self, most: usize) -> Self {
        Self { most, ..self }
    }
}

/// How the convex iteration ended.
pub(crate) struct Convex {
    pub outcome: Outcome,
    /// The last iterate, and its multipliers.
    pub iterate: Iterate,
    pub multipliers: Multipliers,
    /// Subproblems solved.
    pub subproblems: usize,
    /// Size of defects after each subproblem, the first before any.
    pub residuals: Vec<f64>,
    /// The largest violations left, per group of rows.
    pub violations: Vec<f64>,
    /// Wall time inside the cone solver \[s\].
    pub cone_seconds: f64,
    /// Interior-point iterations.
    pub cone_iterations: u32,
}

impl Convex {
    /// How far the last iterate is from a maneuver: the largest defect or violation.
    pub fn miss(&self) -> f64 {
        let defect = self.residuals.last().copied().unwrap_or(f64::INFINITY);
        self.violations.iter().fold(defect, |miss, violation| miss.max(*violation))
    }
}

/// The iteration.
struct Scp<'a> {
    options: &'a ScpOptions,
    watch: &'a Watch<'a>,
    /// The iterate, and all that is evaluated there.
    at: Evaluated<'a>,
    multipliers: Option<Multipliers>,
    weights: Weights,
    subproblem: Subproblem<'a>,
    residuals: Vec<f64>,
}

/// Runs the convex iteration from an iterate. `None` where it cannot be evaluated at all.
pub(crate) fn run(
    model: &Model,
    rows: &LimitRows,
    start: Iterate,
    options: &ScpOptions,
    watch: &Watch,
) -> Option<Convex> {
    // What is stopped here still has this iterate to tell of.
    let at = start.evaluate(model, rows, Watch::NONE).ok()?;
    let weights =
        Weights { defect: FIRST_PRICE, violation: vec![FIRST_PRICE; rows.groups.len()], radius: RADIUS.0 };
    let residuals = vec![at.largest_defect()];
    let subproblem = Subproblem::new(model, rows, options.cone_tolerance, *watch);
    let multipliers = None;
    let scp = Scp { options, watch, at, multipliers, weights, subproblem, residuals };
    if let Some(stopped) = (watch.interrupt)() {
        return Some(scp.conclude(stopped, 0));
    }
    let (scp, report) = driver::run(scp, options.most, watch.interrupt);
    Some(scp.conclude(report.outcome, report.iterations))
}

impl Iteration for Scp<'_> {
    fn residual(&self) -> f64 {
        self.at.largest_defect()
    }

    /// An iterate alone does not tell: the move of a subproblem does.
    fn converged(&self) -> bool {
        false
    }

    /// One subproblem.
    fn advance(&mut self) -> Option<Outcome> {
        let step = match self.subproblem.solve(&self.at, &self.weights, None) {
            Ok(step) => step,
            Err(Failure::Time) => return Some(Outcome::TimeLimit),
            Err(Failure::Stopped) => return Some(Outcome::Interrupted),
            Err(Failure::Numerical) => {
                // Shorter steps are the better conditioned subproblem.
                self.weights.radius *= NARROWED_BLINDLY;
                return self.motionless();
            }
        };
        let mut tried = self.tried(step);
        if tried.ratio < CORRECTED
            && (self.watch.interrupt)().is_none()
            && let Some(first) = &tried.candidate
            && let Ok(corrected) = self.subproblem.solve(&self.at, &self.weights, Some(first))
        {
            let predicted = tried.step.predicted;
            let corrected = self.tried(Move { predicted, ..corrected });
            if corrected.ratio > tried.ratio {
                tried = corrected;
            }
        }
        let Tried { step, candidate, ratio } = tried;
        let length = longest(self.at.model, &step);
        let bounded = length >= BOUNDED * self.weights.radius;
        let accepted = ratio >= PROMISED;
        let lacking = step.slacks.iter().fold(self.lacking(&step), |worst, slack| worst.max(*slack));
        let feasible = lacking <= self.violated();
        let dearest = self.reprice(&step);
        if accepted {
            if let Some(candidate) = candidate {
                self.at = candidate;
            }
            self.multipliers = Some(step.multipliers.clone());
            if ratio >= GOOD && bounded {
                self.weights.radius = (WIDENED * self.weights.radius).min(RADIUS.1);
            } else if ratio < POOR {
                self.weights.radius *= NARROWED;
            }
        } else {
            self.weights.radius = REFUSED * self.weights.radius.min(length);
        }
        self.residuals.push(self.at.largest_defect());
        if accepted && length <= self.options.tolerance && feasible {
            return Some(Outcome::Converged);
        }
        // At the highest price, what is still violated stays so: a local optimum of the violation.
        if dearest && !feasible && step.predicted <= FUTILE * lacking * DEAREST {
            return Some(Outcome::Stalled);
        }
        self.motionless()
    }
}

/// A move, where it leads, and how much of what it promises comes true.
struct Tried<'a> {
    step: Move,
    /// None where it cannot be evaluated.
    candidate: Option<Evaluated<'a>>,
    ratio: f64,
}

impl<'a> Scp<'a> {
    fn tried(&self, step: Move) -> Tried<'a> {
        let (model, limits) = (self.at.model, self.at.limits);
        let candidate = self.at.iterate.moved(model, &step.states, &step.inputs, 1.0);
        let candidate = candidate.evaluate(model, limits, *self.watch).ok();
        let before = self.merit(&self.at);
        let actual = candidate.as_ref().map_or(f64::NEG_INFINITY, |candidate| before - self.merit(candidate));
        // Below the cone solver's accuracy no ratio means anything: such moves are taken.
        let noise = self.options.cone_tolerance * (1.0 + self.at.cost.abs());
        let ratio = (actual + noise) / (step.predicted.max(0.0) + noise);
        Tried { step, candidate, ratio }
    }

    /// Slacks and defects above this count as violated.
    fn violated(&self) -> f64 {
        VIOLATED.max(self.options.cone_tolerance)
    }

    /// Stalled, where the trust region lets nothing move.
    fn motionless(&self) -> Option<Outcome> {
        (self.weights.radius < RADIUS.2).then_some(Outcome::Stalled)
    }

    /// Cost and priced violations.
    fn merit(&self, at: &Evaluated) -> f64 {
        let violations = at.violations();
        let priced: f64 = violations
            .iter()
            .zip(&self.weights.violation)
            .map(|(violation, weight)| violation * weight)
            .sum();
        at.cost + self.weights.defect * at.infeasibility() + priced
    }

    /// Keeps the prices above the multipliers, so that the merit function is exact.
    /// Tells whether all that is violated is at the highest price.
    fn reprice(&mut self, step: &Move) -> bool {
        let violated = self.violated();
        let dearest = (self.lacking(step) <= violated || self.weights.defect >= DEAREST)
            && step.slacks.iter().zip(&self.weights.violation).all(|(s, w)| *s <= violated || *w >= DEAREST);
        let costates = step.multipliers.costates.iter().map(|costate| costate.amax());
        let largest = costates.fold(step.multipliers.terminal.amax(), f64::max);
        let mut sums = vec![0.0; self.weights.violation.len()];
        for (row, multiplier) in self.at.limits.rows.iter().zip(&step.multipliers.rows) {
            sums[row.group] += multiplier.abs();
        }
        for ((weight, sum), slack) in self.weights.violation.iter_mut().zip(sums).zip(&step.slacks) {
            // A slack in use has its full price as multiplier: a higher price may remove it.
            let wanted = if *slack > violated { RAISED * *weight } else { ABOVE_MULTIPLIERS * sum };
            *weight = weight.max(wanted).min(DEAREST);
        }
        let wanted = if self.lacking(step) > violated {
            RAISED * self.weights.defect
        } else {
            ABOVE_MULTIPLIERS * largest
        };
        self.weights.defect = self.weights.defect.max(wanted).min(DEAREST);
        dearest
    }

    /// Size of the defects that a move leaves.
    fn lacking(&self, step: &Move) -> f64 {
        step.left * self.at.largest_defect()
    }

    fn conclude(self, outcome: Outcome, subproblems: usize) -> Convex {
        let Evaluated { model, limits, .. } = self.at;
        let zeros = || Multipliers {
            costates: vec![DVector::zeros(model.n); model.steps + 1],
            terminal: DVector::zeros(model.terminal_count()),
            rows: vec![0.0; limits.rows.len()],
        };
        Convex {
            outcome,
            violations: self.at.violations(),
            multipliers: self.multipliers.unwrap_or_else(zeros),
            iterate: self.at.iterate,
            subproblems,
            residuals: self.residuals,
            cone_seconds: self.subproblem.seconds,
            cone_iterations: self.subproblem.iterations,
        }
    }
}

/// The largest rotation of a node in a move \[rad\].
fn longest(model: &Model, step: &Move) -> f64 {
    step.states.iter().map(|z| state::length(model, z)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
