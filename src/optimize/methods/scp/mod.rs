//! Sequential convex programming (SCP) on the group.
//!
//! It plans least effort in a given duration, as the alternative that a plan of the interior point can be compared with. Around
//! an iterate the chain of stages and all limits ([`crate::optimize::chain`]) are linear in tangent
//! vectors, the cost is quadratic: a cone program ([`subproblem`]), with a trust region on the rotation
//! of each node, a virtual control and slacks that keep it feasible. Its solution moves the iterate by
//! the group's exponential. A move that gives less than it promises, since the dynamics bend along it, is corrected to second
//! order: solved once more with the defects that it ended with. Near a solution, Newton on the optimality conditions takes over
//! ([`polish`]): a converged point is a variational trajectory to round-off, and its multipliers are
//! costates.

pub(crate) mod method;
pub(crate) mod polish;
pub(crate) mod subproblem;
mod tuning;

use crate::maneuver::solution::Outcome;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::curvature::blocks;
use crate::optimize::chain::iterate::{Evaluated, Iterate};
use crate::optimize::chain::model::{Model, state};
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::methods::PROMISED;
use crate::optimize::methods::driver::{self, Iteration};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::scp::tuning::*;
use nalgebra::{DMatrix, DVector};
use polish::{Polished, Told, polish};
use subproblem::{Failure, Move, Subproblem, Weights};

/// What the iteration may do.
#[derive(Clone, Debug)]
pub(crate) struct ScpOptions {
    /// Whether Newton finishes the digits at all. Without, the converged iterate counts as it is.
    pub polish: bool,
    /// Whether Newton may take over before the convex iteration itself has converged.
    pub polish_early: bool,
    /// Size of a move at which the convex iteration itself counts as converged.
    pub tolerance: f64,
    /// Residual of the polished point.
    pub polish_tolerance: f64,
    /// Accuracy of the last subproblems; about 1e-9 is what the cone solver reliably gives.
    pub cone_tolerance: f64,
    /// Subproblems after which the iteration gives up.
    pub most: usize,
    /// Newton iterations after which a polish gives up.
    pub newton: usize,
}

impl Default for ScpOptions {
    fn default() -> Self {
        Self {
            polish: true,
            polish_early: true,
            tolerance: 1e-7,
            polish_tolerance: 1e-11,
            cone_tolerance: 1e-6,
            most: 60,
            newton: 60,
        }
    }
}

impl ScpOptions {
    /// The convex iteration to its own convergence, with nothing of Newton's.
    pub fn unpolished() -> Self {
        // Duals follow the iterate: they have six digits only where its moves have nine.
        let (tolerance, cone_tolerance) = (1e-9, 1e-9);
        Self { polish: false, polish_early: false, tolerance, cone_tolerance, ..Self::default() }
    }

    /// The same with `most` subproblems, and no more Newton iterations than that.
    pub fn within(self, most: usize) -> Self {
        Self { most, newton: self.newton.min(most), ..self }
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
    /// The point that meets all conditions: to round-off, or as it is where no polish was asked for.
    pub polished: Option<Polished>,
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
    /// Size of the last move, of none before the first.
    length: f64,
    polished: Option<Polished>,
    residuals: Vec<f64>,
}

/// Runs the convex iteration from an iterate. `None` where it cannot be evaluated at all.
pub(crate) fn run(
    model: &Model,
    rows: &LimitRows,
    start: Iterate,
    multipliers: Option<Multipliers>,
    options: &ScpOptions,
    watch: &Watch,
) -> Option<Convex> {
    // What is stopped here still has this iterate to tell of.
    let at = Evaluated { watch: *watch, ..start.evaluate(model, rows, Watch::NONE).ok()? };
    let weights =
        Weights { defect: FIRST_PRICE, violation: vec![FIRST_PRICE; rows.groups.len()], radius: RADIUS.0 };
    let residuals = vec![at.largest_defect()];
    let subproblem = Subproblem::new(model, rows, options.cone_tolerance, *watch);
    let (length, polished) = (f64::INFINITY, None);
    let scp = Scp { options, watch, at, multipliers, weights, subproblem, length, polished, residuals };
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
        let curvature = self.curvature();
        self.subproblem.tolerance = self.accuracy();
        let step = match self.subproblem.solve(&self.at, &curvature, &self.weights, None) {
            Ok(step) => step,
            Err(Failure::Time) => return Some(Outcome::TimeLimit),
            Err(Failure::Stopped) => return Some(Outcome::Interrupted),
            Err(Failure::Numerical) => {
                // Shorter steps and no curvature are the better conditioned subproblem.
                self.weights.radius *= NARROWED_BLINDLY;
                self.multipliers = None;
                return self.motionless();
            }
        };
        let mut tried = self.tried(step);
        if tried.ratio < CORRECTED
            && (self.watch.interrupt)().is_none()
            && let Some(first) = &tried.candidate
            && let Ok(corrected) = self.subproblem.solve(&self.at, &curvature, &self.weights, Some(first))
        {
            let predicted = tried.step.predicted;
            let corrected = self.tried(Move { predicted, ..corrected });
            if corrected.ratio > tried.ratio {
                tried = corrected;
            }
        }
        let Tried { step, candidate, ratio } = tried;
        let length = longest(self.at.model, &step);
        self.length = length;
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
        // A move by a rough subproblem settles nothing, however short.
        let exact = self.subproblem.tolerance <= self.options.cone_tolerance;
        let settled = accepted && exact && length <= self.options.tolerance.max(1e-9) && feasible;
        let near = accepted && feasible && !bounded && length < NEAR;
        if !self.options.polish {
            let multipliers = self.multipliers.as_ref().filter(|_| settled);
            self.polished = multipliers.and_then(|found| polish::as_it_is(&self.at, found));
        } else if (near && self.options.polish_early) || settled {
            self.try_polish(settled);
        }
        if settled || self.polished.is_some() {
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
        let noise = self.subproblem.tolerance * (1.0 + self.at.cost.abs());
        let ratio = (actual + noise) / (step.predicted.max(0.0) + noise);
        Tried { step, candidate, ratio }
    }

    /// Accuracy asked of the next subproblem. Where Newton ends the digits the first moves need not be more exact than they
    /// are long.
    fn accuracy(&self) -> f64 {
        let least = self.options.cone_tolerance;
        if !self.options.polish {
            return least;
        }
        (ACCURACY.0 * self.length).min(ACCURACY.1).max(least)
    }

    /// Slacks and defects above this count as violated.
    fn violated(&self) -> f64 {
        VIOLATED.max(self.subproblem.tolerance)
    }

    /// Stalled, where the trust region lets nothing move.
    fn motionless(&self) -> Option<Outcome> {
        (self.weights.radius < RADIUS.2).then_some(Outcome::Stalled)
    }

    /// The convex part of the Lagrangian's second derivatives; zero before there are multipliers.
    fn curvature(&self) -> Vec<DMatrix<f64>> {
        let multipliers = self.multipliers.as_ref();
        match multipliers.and_then(|multipliers| blocks(&self.at, multipliers).ok()) {
            Some(blocks) => blocks.iter().map(|block| convexified(&block.state)).collect(),
            None => vec![DMatrix::zeros(self.at.model.n, self.at.model.n); self.at.model.steps + 1],
        }
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

    fn try_polish(&mut self, settled: bool) {
        let (at, Some(multipliers)) = (&self.at, &self.multipliers) else { return };
        let (options, watch) = (self.options, self.watch);
        let told = if settled {
            Told::Settled
        } else if self.length > SMALL {
            Told::Vaguely
        } else {
            Told::Roughly
        };
        let polished = polish(at.model, at.limits, &at.iterate, multipliers, options, told, watch);
        // Newton may run to a costlier stationary point; the convex iteration knows better.
        let slack = DEARER * at.cost.abs() + self.weights.defect * at.infeasibility();
        self.polished = polished.filter(|polished| polished.cost <= at.cost + slack);
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
            polished: self.polished,
            cone_seconds: self.subproblem.seconds,
            cone_iterations: self.subproblem.iterations,
        }
    }
}

/// The largest rotation of a node in a move \[rad\].
fn longest(model: &Model, step: &Move) -> f64 {
    step.states.iter().map(|z| state::length(model, z)).fold(0.0, f64::max)
}

/// The nearest positive semidefinite matrix to the symmetric part; zero where it cannot be found.
fn convexified(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let symmetric = 0.5 * (matrix + matrix.transpose());
    let count = symmetric.nrows();
    match nalgebra::SymmetricEigen::try_new(symmetric, f64::EPSILON, 1000) {
        Some(eigen) => {
            let values = eigen.eigenvalues.map(|value| value.max(0.0));
            &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose()
        }
        None => DMatrix::zeros(count, count),
    }
}

#[cfg(test)]
mod tests;
