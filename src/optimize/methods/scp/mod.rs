//! Sequential convex programming (SCP) on the rotation group.
//!
//! It minimises effort in a fixed duration, as an alternative with which a plan of the
//! interior-point method can be compared. The program of stages ([`super::interior_point::chain`])
//! is linearised about a point in tangent vectors, and its cost is quadratic. The result is a cone
//! program ([`subproblem`]), with a trust region on the rotation of each node, and a virtual
//! control and slacks that keep it feasible. Its solution moves the point by the exponential map of
//! the group. If the actual decrease of a move is less than predicted, because the dynamics are
//! nonlinear, the move gets a second-order correction: the subproblem is solved once more with the
//! resulting defects. Near a solution the interior-point method refines the plan to full accuracy
//! ([`method`]). The duals of the subproblems are costates, accurate to six digits if the iteration
//! itself converges.

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

/// Options of the convex iteration.
#[derive(Clone, Debug)]
pub(crate) struct ScpOptions {
    /// True if the interior-point method refines the converged point; false if the point is
    /// returned unchanged.
    pub polish: bool,
    /// Largest rotation of a move at which the iteration counts as converged \[rad\].
    pub tolerance: f64,
    /// Accuracy of the subproblems; the cone solver reliably reaches about 1e-9.
    pub cone_tolerance: f64,
    /// Largest number of subproblems.
    pub most: usize,
}

impl Default for ScpOptions {
    fn default() -> Self {
        Self { polish: true, tolerance: 1e-2, cone_tolerance: 1e-6, most: 60 }
    }
}

impl ScpOptions {
    /// Returns options with which the convex iteration runs to convergence, without refinement by
    /// the interior-point method.
    pub fn unpolished() -> Self {
        // Duals are less accurate than the point: they have six digits only if its moves have nine.
        Self { polish: false, tolerance: 1e-9, cone_tolerance: 1e-10, ..Self::default() }
    }

    /// Returns these options with at most `most` subproblems.
    pub fn within(self, most: usize) -> Self {
        Self { most, ..self }
    }
}

/// Result of the convex iteration.
pub(crate) struct Convex {
    pub outcome: Outcome,
    /// Last point of the iteration.
    pub point: Point,
    /// Lagrange multipliers at the last point.
    pub duals: Duals,
    /// Cost, defects and rows at the last point.
    pub values: Values,
    /// Number of subproblems solved.
    pub subproblems: usize,
    /// Largest defect after each subproblem; the first entry is the defect at the start.
    pub residuals: Vec<f64>,
    /// Wall-clock time in the cone solver \[s\].
    pub cone_seconds: f64,
    /// Number of iterations of the cone solver, over all subproblems.
    pub cone_iterations: u32,
}

/// State of the convex iteration.
struct Scp<'a> {
    program: &'a ChainProgram<'a>,
    options: &'a ScpOptions,
    watch: &'a Watch<'a>,
    /// Current point, with its derivatives and multipliers.
    point: Point,
    at: Derivatives,
    duals: Duals,
    weights: Weights,
    subproblem: Subproblem<'a>,
    residuals: Vec<f64>,
}

/// Runs the convex iteration from a point. Returns `None` if the program cannot be evaluated at the
/// point.
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

    /// Always returns false: convergence is decided by the size of a move, in `advance`, not by a
    /// point.
    fn converged(&self) -> bool {
        false
    }

    /// Solves one subproblem and accepts or rejects its move.
    fn advance(&mut self) -> Option<Outcome> {
        let step = match self.subproblem.solve(&self.at, &self.weights, None) {
            Ok(step) => step,
            Err(Failure::Time) => return Some(Outcome::TimeLimit),
            Err(Failure::Stopped) => return Some(Outcome::Interrupted),
            Err(Failure::Numerical) => {
                // A subproblem with a smaller trust region is better conditioned.
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
        // At the highest penalty a remaining violation does not decrease: a local minimum of the
        // violation.
        if dearest && !feasible && step.predicted <= FUTILE * lacking * DEAREST {
            return Some(Outcome::Stalled);
        }
        self.motionless()
    }
}

/// A move with its resulting point, and the ratio of actual to predicted decrease of the merit
/// function.
struct Tried {
    step: Move,
    /// Resulting point; `None` if it cannot be evaluated.
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
        // Below the accuracy of the cone solver the ratio is meaningless: such moves are accepted.
        let noise = self.options.cone_tolerance * (1.0 + self.at.values.cost.abs());
        let ratio = (actual + noise) / (step.predicted.max(0.0) + noise);
        Tried { step, reached: exists.then_some((point, values)), ratio }
    }

    /// Returns the threshold above which slacks and defects count as violated.
    fn violated(&self) -> f64 {
        VIOLATED.max(self.options.cone_tolerance)
    }

    /// Returns `Stalled` if the trust region has become too small for any move.
    fn motionless(&self) -> Option<Outcome> {
        (self.weights.radius < RADIUS.2).then_some(Outcome::Stalled)
    }

    /// Returns the value of the merit function: the cost plus the penalised violations.
    fn merit(&self, values: &Values) -> f64 {
        let violations = self.program.violations(values);
        let priced: f64 = violations.iter().zip(&self.weights.violation).map(|(v, weight)| v * weight).sum();
        values.cost + self.weights.defect * infeasibility(values) + priced
    }

    /// Keeps the penalties above the multipliers, so that the merit function is exact. Returns
    /// whether all violated quantities already have the highest penalty.
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
            // The multiplier of a positive slack equals its penalty: a higher penalty may reduce
            // the slack.
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

    /// Returns the largest defect or terminal error that a move leaves, to first order.
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

/// Returns `Σ |d|₁ + |e|₁`, the residuals of dynamics and terminal conditions.
fn infeasibility(values: &Values) -> f64 {
    values.defects.iter().chain(&values.terminal).map(|d| d.abs()).sum()
}

/// Returns the largest component of the defects and of the terminal error.
pub(super) fn largest_defect(values: &Values) -> f64 {
    values.defects.iter().chain(&values.terminal).fold(0.0, |largest, d| largest.max(d.abs()))
}

#[cfg(test)]
mod tests;
