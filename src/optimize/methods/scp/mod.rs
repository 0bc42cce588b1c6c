//! Sequential convex programming (SCP) on the group.
//!
//! It plans least effort in a given duration, as the alternative that a plan of the interior point
//! can be compared with. Around a point the program of stages ([`super::interior_point::chain`]) is
//! linear in tangent vectors, and its cost is quadratic: a cone program ([`subproblem`]), with a
//! trust region on the rotation of each node, a virtual control and slacks that keep it feasible.
//! Its solution moves the point by the group's exponential. A move that gives less than it
//! promises, since the dynamics bend along it, is corrected to second order: solved once more with
//! the defects that it ended with. Near a solution the interior point ends the digits ([`method`]).
//! The duals of the subproblems are costates, to six digits where the iteration itself converges.

pub(crate) mod method;
pub(crate) mod subproblem;
mod tuning;

use crate::maneuver::solution::Outcome;
use crate::optimize::methods::PROMISED;
use crate::optimize::methods::driver::{self, Iteration};
use crate::optimize::methods::interior_point::chain::ChainProgram;
use crate::optimize::methods::interior_point::program::{Derivatives, Duals, Point, Program, Values};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::tuning::*;
use subproblem::{Failure, Move, Subproblem, Weights};

/// What the iteration may do.
#[derive(Clone, Debug)]
pub(crate) struct ScpOptions {
    /// Whether the interior point ends the digits. Without, the converged point counts as it is.
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
        // Duals follow the point: they have six digits only where its moves have nine.
        Self { polish: false, tolerance: 1e-9, cone_tolerance: 1e-10, ..Self::default() }
    }

    /// The same with `most` subproblems.
    pub fn within(self, most: usize) -> Self {
        Self { most, ..self }
    }
}

/// How the convex iteration ended.
pub(crate) struct Convex {
    pub outcome: Outcome,
    /// The last point, its multipliers, and its values.
    pub point: Point,
    pub duals: Duals,
    pub values: Values,
    /// Subproblems solved.
    pub subproblems: usize,
    /// Size of defects after each subproblem, the first before any.
    pub residuals: Vec<f64>,
    /// Wall time inside the cone solver \[s\].
    pub cone_seconds: f64,
    /// Interior-point iterations.
    pub cone_iterations: u32,
}

/// The iteration.
struct Scp<'a> {
    program: &'a ChainProgram<'a>,
    options: &'a ScpOptions,
    watch: &'a Watch<'a>,
    /// The point, and all that is evaluated there.
    point: Point,
    at: Derivatives,
    duals: Duals,
    weights: Weights,
    subproblem: Subproblem<'a>,
    residuals: Vec<f64>,
}

/// Runs the convex iteration from a point. Returns `None` where it cannot be evaluated at all.
pub(crate) fn run(
    program: &ChainProgram,
    point: Point,
    options: &ScpOptions,
    watch: &Watch,
) -> Option<Convex> {
    let shape = program.shape();
    let mut at = Derivatives::of(shape);
    let duals = Duals::of(shape);
    if !(program.derivatives(&point, &duals, &mut at) && at.values.are_finite()) {
        return None;
    }
    let violation = vec![FIRST_PRICE; program.groups()];
    let weights = Weights { defect: FIRST_PRICE, violation, radius: RADIUS.0 };
    let residuals = vec![largest_defect(&at.values)];
    let subproblem = Subproblem::new(program, options.cone_tolerance, *watch);
    let scp = Scp { program, options, watch, point, at, duals, weights, subproblem, residuals };
    if let Some(stopped) = (watch.interrupt)() {
        return Some(scp.conclude(stopped, 0));
    }
    let (scp, report) = driver::run(scp, options.most, watch.interrupt);
    Some(scp.conclude(report.outcome, report.iterations))
}

impl Iteration for Scp<'_> {
    fn residual(&self) -> f64 {
        largest_defect(&self.at.values)
    }

    /// A point alone does not tell: the move of a subproblem does.
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
                self.weights.radius *= NARROWED * NARROWED;
                return self.motionless();
            }
        };
        let mut tried = self.tried(step);
        if tried.ratio < CORRECTED
            && (self.watch.interrupt)().is_none()
            && let Some((_, first)) = &tried.reached
            && let Ok(corrected) = self.subproblem.solve(&self.at, &self.weights, Some(first))
        {
            let predicted = tried.step.predicted;
            let corrected = self.tried(Move { predicted, ..corrected });
            if corrected.ratio > tried.ratio {
                tried = corrected;
            }
        }
        let Tried { step, reached, ratio } = tried;
        let length = self.subproblem.longest(&step);
        let bounded = length >= BOUNDED * self.weights.radius;
        let lacking = step.slacks.iter().fold(self.lacking(&step), |worst, slack| worst.max(*slack));
        let feasible = lacking <= self.violated();
        let dearest = self.reprice(&step);
        let reached = reached.filter(|_| ratio >= PROMISED);
        let accepted = reached.is_some();
        if let Some((point, _)) = reached {
            self.point = point;
            if !self.program.derivatives(&self.point, &Duals::of(self.program.shape()), &mut self.at) {
                return Some(Outcome::NotFinite);
            }
            self.duals = step.duals;
            if ratio >= GOOD && bounded {
                self.weights.radius = (WIDENED * self.weights.radius).min(RADIUS.1);
            } else if ratio < POOR {
                self.weights.radius *= NARROWED;
            }
        } else {
            self.weights.radius = REFUSED * self.weights.radius.min(length);
        }
        self.residuals.push(largest_defect(&self.at.values));
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
struct Tried {
    step: Move,
    /// `None` where it cannot be evaluated.
    reached: Option<(Point, Values)>,
    ratio: f64,
}

impl Scp<'_> {
    fn tried(&self, step: Move) -> Tried {
        let shape = self.program.shape();
        let (mut point, mut values) = (Point::of(shape), Values::of(shape));
        self.program.moved(&self.point, &step.increment, 1.0, &mut point);
        let exists = self.program.values(&point, &mut values) && values.are_finite();
        let before = self.merit(&self.at.values);
        let actual = if exists { before - self.merit(&values) } else { f64::NEG_INFINITY };
        // Below the cone solver's accuracy no ratio means anything: such moves are taken.
        let noise = self.options.cone_tolerance * (1.0 + self.at.values.cost.abs());
        let ratio = (actual + noise) / (step.predicted.max(0.0) + noise);
        Tried { step, reached: exists.then_some((point, values)), ratio }
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
    fn merit(&self, values: &Values) -> f64 {
        let violations = self.program.violations(values);
        let priced: f64 = violations.iter().zip(&self.weights.violation).map(|(v, weight)| v * weight).sum();
        values.cost + self.weights.defect * infeasibility(values) + priced
    }

    /// Keeps the prices above the multipliers, so that the merit function is exact.
    /// Tells whether all that is violated is at the highest price.
    fn reprice(&mut self, step: &Move) -> bool {
        let violated = self.violated();
        let dearest = (self.lacking(step) <= violated || self.weights.defect >= DEAREST)
            && step.slacks.iter().zip(&self.weights.violation).all(|(s, w)| *s <= violated || *w >= DEAREST);
        let all = step.duals.costates.iter().chain(&step.duals.terminal);
        let largest = all.fold(0.0, |largest: f64, costate| largest.max(costate.abs()));
        let mut sums = vec![0.0; self.weights.violation.len()];
        for (row, multiplier) in step.duals.rows.iter().enumerate() {
            sums[self.program.group_of(row)] += multiplier.abs();
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
        step.left * largest_defect(&self.at.values)
    }

    fn conclude(self, outcome: Outcome, subproblems: usize) -> Convex {
        Convex {
            outcome,
            point: self.point,
            duals: self.duals,
            values: self.at.values,
            subproblems,
            residuals: self.residuals,
            cone_seconds: self.subproblem.seconds,
            cone_iterations: self.subproblem.iterations,
        }
    }
}

/// `Σ |d|₁ + |e|₁`: what the equations of motion and the terminal conditions lack.
fn infeasibility(values: &Values) -> f64 {
    values.defects.iter().chain(&values.terminal).map(|d| d.abs()).sum()
}

/// The largest component of a defect or of the terminal error.
pub(super) fn largest_defect(values: &Values) -> f64 {
    values.defects.iter().chain(&values.terminal).fold(0.0, |largest, d| largest.max(d.abs()))
}

#[cfg(test)]
mod tests;
