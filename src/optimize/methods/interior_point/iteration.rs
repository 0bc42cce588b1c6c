//! The primal–dual interior point on programs of stages.
//!
//! Rows have slacks, elastic ones a violation `t` with a price `π` as well, and so has each terminal equation, in both directions:
//!
//! ```text
//! c − t + s = 0 ,   s z = μ ,   t (π − z) = μ            e − t⁺ + t⁻ = 0 ,   t⁺(π − ν) = μ ,   t⁻(π + ν) = μ
//! ```
//!
//! Newton, with slacks and violations eliminated:
//!
//! ```text
//! Σ = 1/(s/z + t/(π − z)) ,   ẑ = z + Σ(c + μ/z − μ/(π − z)) ,   dz = ẑ + Σ C dx − z
//! ds = μ/z − s − (s/z) dz ,   dt = (μ + t dz)/(π − z) − t
//! D = t⁺/(π − ν) + t⁻/(π + ν) ,   E dx + e − μ/(π − ν) + μ/(π + ν) = D dν
//! ```
//!
//! The right-hand side is the gradient of the Lagrangian at the present multipliers: it vanishes at the end, so that round-off of the
//! factors does not bound what is reached.
//!
//! An iteration:
//!
//! 1. Evaluate, and look whether the conditions hold.
//! 2. Factor the exact Hessian. Where its inertia is wrong, without the second derivatives of steps and rows (Gauss–Newton) while
//!    `μ` is large, and with a shift where that fails too or `μ` is small.
//! 3. Before the tail, an affine step (`μ = 0`) tells the next barrier term and the products of second order (Mehrotra 1992). In the
//!    tail the term is lowered whenever the conditions at the present one hold roughly (Fiacco and McCormick).
//! 4. A step stays within its bounds, and is taken where a filter of infeasibility and barrier cost lets it (Wächter and Biegler 2006), if
//!    need be corrected to second order or shortened. Where no part of it is let, the Hessian is shifted.
//!
//! # Why a primal–dual method with a hand-over?
//!
//! Mehrotra's rule halves the iterations, and to the very end it lets `μ` outrun the residual. Exact second derivatives with
//! Gauss–Newton as the way out of a wrong inertia take half the iterations of a shift on paths that cross cones. In the tail
//! Gauss–Newton has no curvature along faces of optima, which least time with more inputs than axes has, and creeps.

use super::program::{Derivatives, Duals, Increment, Point, Program, RowKind, Shape, Values};
use super::riccati::{Riccati, Right, Taken, Yield, add, dot};
use super::tuning::Tuning;
use crate::optimize::methods::method::Watch;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// All conditions hold.
    Converged,
    /// No acceptable step was found.
    Stalled,
    /// The limit of iterations was reached.
    Iterations,
    /// A number is not finite, or the first point has no value.
    NotFinite,
    /// The run was interrupted or reached its deadline.
    Stopped,
}

/// How a run went.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub end: End,
    pub iterations: usize,
    /// Largest residual of stationarity, of all equations, and of complementarity.
    pub dual: f64,
    pub primal: f64,
    pub complementarity: f64,
    /// The last barrier term of a row.
    pub barrier: f64,
    /// The largest violation of an elastic row, and of a terminal equation.
    pub violation: f64,
    pub miss: f64,
    /// Whether the last factors were those of the exact Hessian: then the point is a strict minimum for its barrier term.
    pub exact: bool,
}

/// Point, multipliers and work space of a run, allocated once for a shape.
pub(crate) struct Solver {
    pub point: Point,
    pub duals: Duals,
    /// Slacks, and violations of elastic rows.
    slacks: Vec<f64>,
    violations: Vec<f64>,
    /// `t⁺`, `t⁻`, and their prices.
    misses: [Vec<f64>; 2],
    prices: Vec<f64>,
    pub at: Derivatives,
    /// The trial point and its values.
    trial: Point,
    trial_values: Values,
    pub(super) riccati: Riccati,
    pub(super) sigma: Vec<f64>,
    /// `1/z` and `1/(π − z)`.
    inverses: [Vec<f64>; 2],
    pub(super) yields: Vec<Yield>,
    /// Gradients of the Lagrangian at the present multipliers, and the right-hand side.
    plain: Right,
    pub(super) right: Right,
    /// The step.
    pub(super) step: Step,
    other: Step,
    /// Products of second order: of `s z`, `t (π − z)`.
    products: [Vec<f64>; 2],
    /// What rows lack, and the same of equations, in the right-hand side.
    lacking: Values,
    filter: Vec<(f64, f64)>,
    /// The best point of the tail.
    saved: Saved,
}

/// A point with all that belongs to it.
#[derive(Default)]
struct Saved {
    point: Point,
    duals: Duals,
    slacks: Vec<f64>,
    violations: Vec<f64>,
    misses: [Vec<f64>; 2],
}

impl Saved {
    fn copy(
        &mut self,
        point: &Point,
        duals: &Duals,
        [slacks, violations]: [&Vec<f64>; 2],
        misses: &[Vec<f64>; 2],
    ) {
        self.point.clone_from(point);
        self.duals.clone_from(duals);
        self.slacks.clone_from(slacks);
        self.violations.clone_from(violations);
        self.misses.clone_from(misses);
    }
}

/// A step of all unknowns.
#[derive(Clone, Debug, Default)]
pub(super) struct Step {
    pub(super) point: Increment,
    pub(super) duals: Duals,
    slacks: Vec<f64>,
    violations: Vec<f64>,
    misses: [Vec<f64>; 2],
}

impl Step {
    fn of(shape: &Shape) -> Self {
        let (rows, ends) = (shape.rows(), shape.terminal);
        Self {
            point: Increment::of(shape),
            duals: Duals::of(shape),
            slacks: vec![0.0; rows],
            violations: vec![0.0; rows],
            misses: [vec![0.0; ends], vec![0.0; ends]],
        }
    }
}

/// State of the iteration besides its point.
struct State {
    barrier: f64,
    tail: bool,
    /// The last shift, and the least that the line search asks for.
    shift: f64,
    least_shift: f64,
    exact: bool,
    /// The least error of the tail, and of the last barrier term.
    best: f64,
    best_at_last: f64,
    idle: usize,
}

/// Residuals of the conditions.
#[derive(Clone, Copy, Debug, Default)]
struct Residuals {
    dual: f64,
    primal: f64,
    complementarity: f64,
    /// Largest difference between a complementarity product and the barrier term.
    off: f64,
    mean: f64,
}

impl Residuals {
    fn largest(&self) -> f64 {
        nan_max(nan_max(self.dual, self.primal), self.complementarity)
    }
}

impl Solver {
    pub fn of(shape: &Shape) -> Self {
        let (rows, ends) = (shape.rows(), shape.terminal);
        let zeros = |size: usize| vec![0.0; size];
        Self {
            point: Point::of(shape),
            duals: Duals::of(shape),
            slacks: zeros(rows),
            violations: zeros(rows),
            misses: [zeros(ends), zeros(ends)],
            prices: zeros(ends),
            at: Derivatives::of(shape),
            trial: Point::of(shape),
            trial_values: Values::of(shape),
            riccati: Riccati::of(shape),
            sigma: zeros(rows),
            inverses: [zeros(rows), zeros(rows)],
            yields: vec![Yield::default(); ends],
            plain: Right::of(shape),
            right: Right::of(shape),
            step: Step::of(shape),
            other: Step::of(shape),
            products: [zeros(rows), zeros(rows)],
            lacking: Values::of(shape),
            filter: Vec::new(),
            saved: Saved::default(),
        }
    }

    /// Solves from [`Solver::point`] without known multipliers. The result is in `point` and `duals`.
    pub fn run(&mut self, program: &impl Program, tuning: &Tuning, watch: &Watch) -> Run {
        let shape = program.shape();
        let weight = 100.0 / shape.stages as f64;
        let first = tuning.first * weight;
        let mut state = State {
            barrier: first,
            tail: false,
            shift: 0.0,
            least_shift: 0.0,
            exact: false,
            best: f64::INFINITY,
            best_at_last: f64::INFINITY,
            idle: 0,
        };
        let mut run = Run {
            end: End::NotFinite,
            iterations: 0,
            dual: f64::INFINITY,
            primal: f64::INFINITY,
            complementarity: f64::INFINITY,
            barrier: first,
            violation: f64::INFINITY,
            miss: f64::INFINITY,
            exact: false,
        };
        self.filter.clear();
        if !(program.values(&self.point, &mut self.at.values) && self.at.values.are_finite()) {
            return run;
        }
        self.begin(program, tuning, first);
        let last = tuning.last * weight;
        for iteration in 0..=tuning.iterations {
            run.iterations = iteration;
            if watch.stopped() {
                run.end = End::Stopped;
                break;
            }
            if !program.derivatives(&self.point, &self.duals, &mut self.at) {
                run.end = End::NotFinite;
                break;
            }
            self.gradients(shape);
            let residuals = self.residuals(shape, tuning, state.barrier);
            (run.dual, run.primal) = (residuals.dual, residuals.primal);
            (run.complementarity, run.barrier, run.exact) =
                (residuals.complementarity, state.barrier, state.exact);
            if !residuals.largest().is_finite() {
                run.end = End::NotFinite;
                break;
            }
            let at_last = state.barrier <= last * (1.0 + 1e-9);
            let near = residuals.dual.max(residuals.primal) <= tuning.tolerance;
            if near
                && (residuals.complementarity <= tuning.tolerance && residuals.mean <= 2.0 * last
                    || at_last && residuals.off <= tuning.lowered_at * state.barrier)
            {
                run.end = End::Converged;
                break;
            }
            let error = nan_max(nan_max(residuals.dual, residuals.primal), residuals.complementarity);
            if state.tail && error < state.best {
                state.best = error;
                self.saved.copy(&self.point, &self.duals, [&self.slacks, &self.violations], &self.misses);
            }
            if std::env::var("IPLOG").is_ok() {
                eprintln!(
                    "{iteration} mu {:.1e} dual {:.1e} primal {:.1e} comp {:.1e} off {:.1e} mean {:.1e} shift {:.1e} {:.1e} tail {} exact {}",
                    state.barrier,
                    residuals.dual,
                    residuals.primal,
                    residuals.complementarity,
                    residuals.off,
                    residuals.mean,
                    state.shift,
                    state.least_shift,
                    state.tail,
                    state.exact
                );
            }
            if at_last {
                let error = residuals.dual.max(residuals.primal).max(residuals.off);
                state.idle = if error < 0.9 * state.best_at_last { 0 } else { state.idle + 1 };
                state.best_at_last = state.best_at_last.min(error);
                if state.idle > tuning.patience {
                    run.end = End::Stalled;
                    break;
                }
            }
            if iteration == tuning.iterations {
                run.end = End::Iterations;
                break;
            }
            if !state.tail
                && state.barrier <= tuning.tail * weight
                && residuals.mean <= tuning.tail_mean * weight
            {
                state.tail = true;
                self.filter.clear();
            }
            if state.tail {
                let mut off = residuals.dual.max(residuals.primal).max(residuals.off);
                while state.barrier > last && off <= tuning.lowered_at * state.barrier / weight {
                    let of_hundred = state.barrier / weight;
                    let next = (tuning.lowered.0 * of_hundred).min(of_hundred.powf(tuning.lowered.1));
                    state.barrier = (next * weight).max(last);
                    self.filter.clear();
                    let again = self.residuals(shape, tuning, state.barrier);
                    off = again.dual.max(again.primal).max(again.off);
                }
            }
            if !self.iterate(program, tuning, &mut state, residuals.mean, watch) {
                run.end = if watch.stopped() { End::Stopped } else { End::Stalled };
                break;
            }
        }
        if matches!(run.end, End::Stalled | End::Iterations) && state.best <= tuning.accepted {
            self.settle(program, tuning, last, &mut run);
        }
        run.violation = self.violations.iter().fold(0.0, |worst, value| nan_max(worst, *value));
        run.miss = self.at.values.terminal.iter().fold(0.0, |worst, value| nan_max(worst, value.abs()));
        run
    }

    /// Returns to the best point of a run that cannot go on, as along the valley of a saddle, and makes its equations hold to round-off by
    /// Newton steps with a Hessian that is positive. The point is a solution where its other residuals stay small.
    fn settle(&mut self, program: &impl Program, tuning: &Tuning, barrier: f64, run: &mut Run) {
        let shape = program.shape();
        let saved = std::mem::take(&mut self.saved);
        (self.point, self.duals) = (saved.point, saved.duals);
        (self.slacks, self.violations, self.misses) = (saved.slacks, saved.violations, saved.misses);
        let part = tuning.to_boundary;
        for step in 0..=tuning.settling {
            if !program.derivatives(&self.point, &self.duals, &mut self.at) {
                return;
            }
            let residuals = self.residuals(shape, tuning, barrier);
            (run.dual, run.primal) = (residuals.dual, residuals.primal);
            (run.complementarity, run.barrier, run.exact) =
                (residuals.complementarity, residuals.mean, false);
            let error = nan_max(nan_max(run.dual, run.primal), run.complementarity);
            let miss = self.at.values.terminal.iter().fold(0.0, |worst, value| nan_max(worst, value.abs()));
            if error <= tuning.accepted && nan_max(run.primal, miss) <= tuning.round_off {
                run.end = End::Converged;
                return;
            }
            self.weigh(shape, tuning);
            let taken = Taken { curved: false, shift: 1.0 };
            if step == tuning.settling
                || !self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken)
            {
                return;
            }
            self.products.iter_mut().for_each(|products| products.fill(0.0));
            self.lack(shape);
            self.direction(shape, barrier);
            let (primal, dual) = self.to_boundary(shape, tuning, part);
            program.moved(&self.point, &self.step.point, primal, &mut self.trial);
            self.take(shape, tuning, barrier, primal, dual);
        }
    }

    /// Sets the first slacks and multipliers.
    fn begin(&mut self, program: &impl Program, tuning: &Tuning, barrier: f64) {
        self.duals.costates.fill(0.0);
        self.duals.terminal.fill(0.0);
        for (row, (kind, c)) in program.shape().kinds.iter().zip(&self.at.values.rows).enumerate() {
            let (slack, multiplier) = match kind {
                RowKind::Equation => (0.0, 0.0),
                RowKind::Hard => {
                    let slack = (-c).max(tuning.slack);
                    (slack, barrier / slack)
                }
                RowKind::Elastic => {
                    let slack = (-c).max(tuning.slack);
                    (slack, (barrier / slack).min(0.5 * tuning.price))
                }
            };
            (self.slacks[row], self.duals.rows[row]) = (slack, multiplier);
            let elastic = *kind == RowKind::Elastic;
            let least = barrier / (tuning.price - multiplier);
            self.violations[row] = if elastic { (c + slack).max(least) } else { 0.0 };
        }
        program.terminal_prices(&mut self.prices);
        for price in &mut self.prices {
            *price *= tuning.terminal_price;
        }
        for (index, (e, price)) in self.at.values.terminal.iter().zip(&self.prices).enumerate() {
            let least = barrier / price;
            self.misses[0][index] = e.max(0.0) + least;
            self.misses[1][index] = (-e).max(0.0) + least;
        }
    }

    /// Returns the residual of a row, `c − t + s`.
    fn row_lacks(&self, kind: RowKind, row: usize, c: f64) -> f64 {
        match kind {
            RowKind::Equation => c,
            RowKind::Hard => c + self.slacks[row],
            RowKind::Elastic => c - self.violations[row] + self.slacks[row],
        }
    }

    /// Returns all residuals, from the gradients of the Lagrangian.
    fn residuals(&self, shape: &Shape, tuning: &Tuning, barrier: f64) -> Residuals {
        let largest = |values: &[f64]| values.iter().fold(0.0, |worst, value| nan_max(worst, value.abs()));
        let mean = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let count = self.duals.costates.len() + self.duals.rows.len() + self.duals.terminal.len();
        let sum = mean(&self.duals.costates) + mean(&self.duals.rows) + mean(&self.duals.terminal);
        let dual_scale = (sum / count as f64 / tuning.large).max(1.0);
        let mut found = Residuals {
            dual: nan_max(
                nan_max(largest(&self.plain.gradients), largest(&self.plain.last)),
                largest(&self.plain.start),
            ) / dual_scale,
            primal: largest(&self.at.values.defects),
            ..Residuals::default()
        };
        let (mut total, mut pairs) = (0.0, 0usize);
        let mut product = |product: f64| {
            found.complementarity = nan_max(found.complementarity, product.abs() / dual_scale);
            found.off = nan_max(found.off, (product - barrier).abs() / dual_scale);
            (total, pairs) = (total + product, pairs + 1);
        };
        for (row, kind) in shape.kinds.iter().enumerate() {
            if *kind != RowKind::Equation {
                product(self.slacks[row] * self.duals.rows[row]);
            }
            if *kind == RowKind::Elastic {
                product(self.violations[row] * (tuning.price - self.duals.rows[row]));
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let nu = self.duals.terminal[index];
            product(self.misses[0][index] * (price - nu));
            product(self.misses[1][index] * (price + nu));
        }
        for (row, kind) in shape.kinds.iter().enumerate() {
            found.primal = nan_max(found.primal, self.row_lacks(*kind, row, self.at.values.rows[row]).abs());
        }
        for (index, e) in self.at.values.terminal.iter().enumerate() {
            found.primal = nan_max(found.primal, (e - self.misses[0][index] + self.misses[1][index]).abs());
        }
        found.mean = total / pairs.max(1) as f64;
        found
    }

    /// Computes the gradient of the Lagrangian at the present multipliers, without `ẑ − z`.
    fn gradients(&mut self, shape: &Shape) {
        let (n, m, z) = (shape.n, shape.m, shape.z());
        for stage in 0..shape.stages {
            let gradient = &mut self.plain.gradients[stage * z..][..z];
            gradient.copy_from_slice(&self.at.gradients[stage * z..][..z]);
            let next = &self.duals.costates[(stage + 1) * n..][..n];
            for (to, column) in gradient.iter_mut().zip(self.at.steps[stage * n * z..].chunks_exact(n)) {
                *to += dot(column, next);
            }
            add(&mut gradient[m..], -1.0, &self.duals.costates[stage * n..][..n]);
            for row in shape.rows_of(stage) {
                let slopes = shape.slopes_of(row);
                let multiplier = self.duals.rows[row];
                for (place, value) in shape.unknowns[slopes.clone()].iter().zip(&self.at.slopes[slopes]) {
                    gradient[usize::from(*place)] += multiplier * value;
                }
            }
        }
        let last = &mut self.plain.last;
        last.copy_from_slice(&self.at.last_gradient);
        for (slope, nu) in self.at.terminal_slopes.chunks_exact(n).zip(&self.duals.terminal) {
            add(last, *nu, slope);
        }
        add(last, -1.0, &self.duals.costates[shape.stages * n..]);
        for (to, start) in self.plain.start.iter_mut().zip(self.at.start_slopes.chunks_exact(n)) {
            *to = dot(start, &self.duals.costates[..n]);
        }
    }

    /// Computes and takes one step; returns `false` if no step can be found or the watch ends the run.
    fn iterate(
        &mut self,
        program: &impl Program,
        tuning: &Tuning,
        state: &mut State,
        mean: f64,
        watch: &Watch,
    ) -> bool {
        let shape = program.shape();
        let weight = 100.0 / shape.stages as f64;
        self.weigh(shape, tuning);
        let curved_only = state.tail;
        let mut taken = Taken { curved: true, shift: state.least_shift };
        state.exact = state.least_shift == 0.0;
        if !self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken) {
            state.exact = false;
            let mut found = false;
            if !curved_only {
                taken.curved = false;
                found = self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken);
            }
            let mut shift = if state.shift > 0.0 {
                (state.shift * tuning.shift.decay).max(1e-20)
            } else {
                tuning.shift.first
            };
            let mut growth = if state.shift > 0.0 { tuning.shift.growth } else { tuning.shift.growth_first };
            while !found {
                taken = Taken { curved: true, shift: shift.max(state.least_shift) };
                if taken.shift > tuning.shift.largest || !taken.shift.is_finite() || watch.stopped() {
                    return false;
                }
                found = self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken);
                if found {
                    state.shift = taken.shift;
                }
                shift = taken.shift * growth;
                growth = tuning.shift.growth;
            }
        }
        self.products.iter_mut().for_each(|products| products.fill(0.0));
        self.lack(shape);
        if !state.tail {
            self.direction(shape, 0.0);
            let (primal, dual) = self.to_boundary(shape, tuning, 1.0);
            let after = self.mean_after(shape, tuning, primal, dual);
            let share = (after / mean).clamp(0.0, 1.0).powi(3);
            let least = 0.1 * tuning.tail * weight;
            state.barrier = (share * mean).max(least).max(tuning.last * weight);
            if primal.min(dual) > tuning.corrected_from {
                self.second_order_products(shape, tuning.corrected_to * mean.max(0.0));
            }
            self.filter.clear();
        }
        self.direction(shape, state.barrier);
        if !self.search(program, tuning, state, watch) {
            let (first, growth) = tuning.shift_of_search;
            state.least_shift = first.max(4.0 * state.shift).max(growth * state.least_shift);
            self.filter.clear();
            return state.least_shift <= tuning.shift.largest;
        }
        state.least_shift *= 0.1;
        if state.least_shift < 0.5 * tuning.shift_of_search.0 * 1e-3 {
            state.least_shift = 0.0;
        }
        true
    }

    /// Computes `Σ` of the rows and `D` of the terminal equations.
    pub(super) fn weigh(&mut self, shape: &Shape, tuning: &Tuning) {
        for (row, kind) in shape.kinds.iter().enumerate() {
            let (s, z, t) = (self.slacks[row], self.duals.rows[row], self.violations[row]);
            let [of_slack, of_violation] = [1.0 / z, 1.0 / (tuning.price - z)];
            (self.inverses[0][row], self.inverses[1][row]) = (of_slack, of_violation);
            self.sigma[row] = match kind {
                RowKind::Equation => 1.0 / tuning.proximal,
                RowKind::Hard => z / s,
                RowKind::Elastic => 1.0 / (s * of_slack + t * of_violation),
            };
        }
        for (index, (given, price)) in self.yields.iter_mut().zip(&self.prices).enumerate() {
            let nu = self.duals.terminal[index];
            given.by = self.misses[0][index] / (price - nu) + self.misses[1][index] / (price + nu);
            given.rho = tuning.rho.min(0.5 / given.by);
        }
    }

    /// Computes the residuals of equations and rows at the present point.
    fn lack(&mut self, shape: &Shape) {
        self.lacking.defects.copy_from_slice(&self.at.values.defects);
        for (row, kind) in shape.kinds.iter().enumerate() {
            self.lacking.rows[row] = self.row_lacks(*kind, row, self.at.values.rows[row]);
        }
        for (index, e) in self.at.values.terminal.iter().enumerate() {
            self.lacking.terminal[index] = e - self.misses[0][index] + self.misses[1][index];
        }
    }

    /// Computes the step for a barrier term from the residuals and the second-order products.
    fn direction(&mut self, shape: &Shape, barrier: f64) {
        let (z_size, n) = (shape.z(), shape.n);
        self.right.gradients.copy_from_slice(&self.plain.gradients);
        self.right.last.copy_from_slice(&self.plain.last);
        self.right.start.copy_from_slice(&self.plain.start);
        // ẑ − z.
        for stage in 0..shape.stages {
            let gradient = &mut self.right.gradients[stage * z_size..][..z_size];
            for row in shape.rows_of(stage) {
                let (s, t, lacking) = (self.slacks[row], self.violations[row], self.lacking.rows[row]);
                let [of_slack, of_violation] =
                    [0, 1].map(|of| (barrier - self.products[of][row]) * self.inverses[of][row]);
                let asked = self.sigma[row]
                    * match shape.kinds[row] {
                        RowKind::Equation => lacking,
                        RowKind::Hard => lacking - s + of_slack,
                        RowKind::Elastic => lacking + t - s + of_slack - of_violation,
                    };
                self.step.duals.rows[row] = asked;
                let slopes = shape.slopes_of(row);
                for (place, value) in shape.unknowns[slopes.clone()].iter().zip(&self.at.slopes[slopes]) {
                    gradient[usize::from(*place)] += asked * value;
                }
            }
        }
        self.right.defects.copy_from_slice(&self.lacking.defects);
        for (index, price) in self.prices.iter().enumerate() {
            let nu = self.duals.terminal[index];
            self.right.terminal[index] = self.lacking.terminal[index] + self.misses[0][index]
                - self.misses[1][index]
                - barrier / (price - nu)
                + barrier / (price + nu);
        }
        let step = &mut self.step;
        self.riccati.solve(
            &self.at,
            &self.right,
            &mut step.point,
            &mut step.duals.costates,
            &mut step.duals.terminal,
        );
        for stage in 0..shape.stages {
            let (du, dx) =
                (&step.point.inputs[stage * shape.m..][..shape.m], &step.point.states[stage * n..][..n]);
            for row in shape.rows_of(stage) {
                let slopes = shape.slopes_of(row);
                let mut change = 0.0;
                for (place, value) in shape.unknowns[slopes.clone()].iter().zip(&self.at.slopes[slopes]) {
                    let place = usize::from(*place);
                    change += value * if place < shape.m { du[place] } else { dx[place - shape.m] };
                }
                let (s, t) = (self.slacks[row], self.violations[row]);
                let dz = step.duals.rows[row] + self.sigma[row] * change;
                step.duals.rows[row] = dz;
                if shape.kinds[row] != RowKind::Equation {
                    let product = barrier - self.products[0][row] - s * dz;
                    step.slacks[row] = product * self.inverses[0][row] - s;
                }
                if shape.kinds[row] == RowKind::Elastic {
                    let product = barrier - self.products[1][row] + t * dz;
                    step.violations[row] = product * self.inverses[1][row] - t;
                }
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let (nu, dnu) = (self.duals.terminal[index], step.duals.terminal[index]);
            let [above, below] = [self.misses[0][index], self.misses[1][index]];
            step.misses[0][index] = (barrier + above * dnu) / (price - nu) - above;
            step.misses[1][index] = (barrier - below * dnu) / (price + nu) - below;
        }
    }

    /// Returns the largest parts of the primal and the dual step that leave `1 − part` of every distance
    /// to a bound.
    fn to_boundary(&self, shape: &Shape, tuning: &Tuning, part: f64) -> (f64, f64) {
        let (mut primal, mut dual) = (1.0f64, 1.0f64);
        let limit = |least: &mut f64, value: f64, change: f64| {
            if change < 0.0 {
                *least = least.min(-part * value / change);
            }
        };
        for (row, kind) in shape.kinds.iter().enumerate() {
            if *kind == RowKind::Equation {
                continue;
            }
            let (z, dz) = (self.duals.rows[row], self.step.duals.rows[row]);
            limit(&mut primal, self.slacks[row], self.step.slacks[row]);
            limit(&mut dual, z, dz);
            if *kind == RowKind::Elastic {
                limit(&mut primal, self.violations[row], self.step.violations[row]);
                limit(&mut dual, tuning.price - z, -dz);
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let (nu, dnu) = (self.duals.terminal[index], self.step.duals.terminal[index]);
            limit(&mut primal, self.misses[0][index], self.step.misses[0][index]);
            limit(&mut primal, self.misses[1][index], self.step.misses[1][index]);
            limit(&mut primal, price - nu, -dnu);
            limit(&mut primal, price + nu, dnu);
        }
        (primal, dual)
    }

    /// Returns the mean complementarity after a step.
    fn mean_after(&self, shape: &Shape, tuning: &Tuning, primal: f64, dual: f64) -> f64 {
        let (mut total, mut pairs) = (0.0, 0usize);
        for (row, kind) in shape.kinds.iter().enumerate() {
            let z = self.duals.rows[row] + dual * self.step.duals.rows[row];
            if *kind != RowKind::Equation {
                total += (self.slacks[row] + primal * self.step.slacks[row]) * z;
                pairs += 1;
            }
            if *kind == RowKind::Elastic {
                let t = self.violations[row] + primal * self.step.violations[row];
                total += t * (tuning.price - z);
                pairs += 1;
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            let nu = self.duals.terminal[index] + primal * self.step.duals.terminal[index];
            total += (self.misses[0][index] + primal * self.step.misses[0][index]) * (price - nu);
            total += (self.misses[1][index] + primal * self.step.misses[1][index]) * (price + nu);
            pairs += 2;
        }
        total / pairs.max(1) as f64
    }

    /// Computes the second-order products of the affine step, at most `most` each.
    fn second_order_products(&mut self, shape: &Shape, most: f64) {
        for (row, kind) in shape.kinds.iter().enumerate() {
            let dz = self.step.duals.rows[row];
            if *kind != RowKind::Equation {
                self.products[0][row] = (self.step.slacks[row] * dz).clamp(-most, most);
            }
            if *kind == RowKind::Elastic {
                self.products[1][row] = (-self.step.violations[row] * dz).clamp(-most, most);
            }
        }
    }

    /// Returns infeasibility and barrier cost of `values`, with the slacks after `part` of the step.
    fn measure(
        &self,
        shape: &Shape,
        tuning: &Tuning,
        barrier: f64,
        values: &Values,
        part: f64,
    ) -> (f64, f64) {
        let mut infeasible: f64 = values.defects.iter().map(|value| value.abs()).sum();
        let mut cost = values.cost;
        let mut logs = 0.0;
        // Products of many factors, so that few logarithms are taken.
        let mut factor = 1.0f64;
        let mut log = |value: f64| {
            // Two negative slacks have a positive product, so each one is tested.
            factor *= if value > 0.0 { value } else { f64::NAN };
            if !(1e-100..1e100).contains(&factor) {
                logs += factor.ln();
                factor = 1.0;
            }
        };
        for (row, kind) in shape.kinds.iter().enumerate() {
            let c = values.rows[row];
            if *kind == RowKind::Equation {
                infeasible += c.abs();
                continue;
            }
            let s = self.slacks[row] + part * self.step.slacks[row];
            let mut lacking = c + s;
            log(s);
            if *kind == RowKind::Elastic {
                let t = self.violations[row] + part * self.step.violations[row];
                lacking -= t;
                cost += tuning.price * t;
                log(t);
            }
            infeasible += lacking.abs();
        }
        for (index, (e, price)) in values.terminal.iter().zip(&self.prices).enumerate() {
            let [above, below] =
                [0, 1].map(|side| self.misses[side][index] + part * self.step.misses[side][index]);
            infeasible += (e - above + below).abs();
            cost += price * (above + below);
            log(above);
            log(below);
        }
        logs += factor.ln();
        (infeasible, cost - barrier * logs)
    }

    /// Returns the slope of the barrier cost along the step.
    fn slope(&self, shape: &Shape, tuning: &Tuning, barrier: f64) -> f64 {
        let (m, z, n) = (shape.m, shape.z(), shape.n);
        let mut slope = 0.0;
        for stage in 0..shape.stages {
            let gradient = &self.at.gradients[stage * z..][..z];
            slope += dot(&gradient[..m], &self.step.point.inputs[stage * m..][..m]);
            slope += dot(&gradient[m..], &self.step.point.states[stage * n..][..n]);
        }
        slope += dot(&self.at.last_gradient, &self.step.point.states[shape.stages * n..]);
        for (row, kind) in shape.kinds.iter().enumerate() {
            if *kind != RowKind::Equation {
                slope -= barrier * self.step.slacks[row] / self.slacks[row];
            }
            if *kind == RowKind::Elastic {
                let (t, dt) = (self.violations[row], self.step.violations[row]);
                slope += (tuning.price - barrier / t) * dt;
            }
        }
        for (index, price) in self.prices.iter().enumerate() {
            for side in 0..2 {
                slope += (price - barrier / self.misses[side][index]) * self.step.misses[side][index];
            }
        }
        slope
    }

    /// Returns whether no entry of the filter dominates a point.
    fn lets(&self, infeasible: f64, cost: f64) -> bool {
        self.filter.iter().all(|(known, known_cost)| infeasible <= *known || cost <= *known_cost)
    }

    /// Takes the step or a part of it that the filter accepts; returns `false` if it accepts none or the
    /// watch ends the run.
    fn search(&mut self, program: &impl Program, tuning: &Tuning, state: &mut State, watch: &Watch) -> bool {
        let shape = program.shape();
        let barrier = state.barrier;
        let part = tuning.to_boundary.max(1.0 - barrier);
        let (mut primal, mut dual) = self.to_boundary(shape, tuning, part);
        primal = primal.min(program.longest(&self.step.point));
        if !(primal > 0.0 && dual > 0.0) {
            return false;
        }
        let (infeasible, cost) = {
            let values = std::mem::take(&mut self.at.values);
            let measured = self.measure(shape, tuning, barrier, &values, 0.0);
            self.at.values = values;
            measured
        };
        let slope = self.slope(shape, tuning, barrier);
        if !slope.is_finite() {
            return false;
        }
        let round_off = 10.0 * f64::EPSILON * cost.abs().max(1.0);
        let small = 1e-4 * infeasible.max(1.0);
        let mut longest = primal;
        for halving in 0..=tuning.halvings {
            if watch.stopped() {
                return false;
            }
            let mut corrections = if halving == 0 { tuning.second_order } else { 0 };
            loop {
                program.moved(&self.point, &self.step.point, primal, &mut self.trial);
                let known =
                    program.values(&self.trial, &mut self.trial_values) && self.trial_values.are_finite();
                let (next, next_cost) = if known {
                    self.measure(shape, tuning, barrier, &self.trial_values, primal)
                } else {
                    (f64::INFINITY, f64::INFINITY)
                };
                let usable = next.is_finite() && next_cost.is_finite();
                let descends = slope < 0.0
                    && primal * (-slope).powf(tuning.switch.0) > infeasible.powf(tuning.switch.1)
                    && infeasible <= small;
                let sufficient = if descends {
                    next_cost - cost - round_off <= tuning.armijo * primal * slope
                } else {
                    next <= (1.0 - tuning.less_infeasible) * infeasible.max(1e-14)
                        || next_cost - round_off <= cost - tuning.less_costly * infeasible
                };
                // Near the end Newton knows better than sums of round-off.
                let floor = state.tail
                    && next <= tuning.feasible
                    && next_cost - cost <= tuning.level * cost.abs().max(1.0);
                if usable && (floor || sufficient && self.lets(next, next_cost - round_off)) {
                    if !descends && !floor {
                        if self.filter.len() == tuning.filter {
                            self.filter.remove(0);
                        }
                        self.filter.push((
                            (1.0 - tuning.less_infeasible) * infeasible,
                            cost - tuning.less_costly * infeasible,
                        ));
                    }
                    self.take(shape, tuning, barrier, primal, dual);
                    return true;
                }
                if corrections == 0 || !known || next < infeasible {
                    break;
                }
                // Corrected to second order.
                if corrections == tuning.second_order {
                    std::mem::swap(&mut self.other, &mut self.step);
                    self.step.clone_from_step(&self.other);
                }
                corrections -= 1;
                self.add_lacking(shape, primal);
                self.direction(shape, barrier);
                let corrected = self.to_boundary(shape, tuning, part);
                primal = corrected.0.min(program.longest(&self.step.point));
                dual = corrected.1;
                if primal.is_nan() || primal <= 0.0 {
                    break;
                }
            }
            if halving == 0 && corrections < tuning.second_order {
                // Back to the step itself.
                std::mem::swap(&mut self.other, &mut self.step);
                self.lack(shape);
                let bounds = self.to_boundary(shape, tuning, part);
                dual = bounds.1;
            }
            longest *= 0.5;
            primal = longest;
        }
        false
    }

    /// Adds the residuals of the trial point to `part` of the present ones.
    fn add_lacking(&mut self, shape: &Shape, part: f64) {
        for (lacking, value) in self.lacking.defects.iter_mut().zip(&self.trial_values.defects) {
            *lacking = part * *lacking + value;
        }
        for (row, kind) in shape.kinds.iter().enumerate() {
            let value = self.trial_values.rows[row];
            let slack = self.slacks[row] + part * self.step.slacks[row];
            let violation = self.violations[row] + part * self.step.violations[row];
            let at_trial = match kind {
                RowKind::Equation => value,
                RowKind::Hard => value + slack,
                RowKind::Elastic => value - violation + slack,
            };
            self.lacking.rows[row] = part * self.lacking.rows[row] + at_trial;
        }
        for (index, e) in self.trial_values.terminal.iter().enumerate() {
            let [above, below] =
                [0, 1].map(|side| self.misses[side][index] + part * self.step.misses[side][index]);
            self.lacking.terminal[index] = part * self.lacking.terminal[index] + e - above + below;
        }
    }

    /// Moves to the trial point.
    fn take(&mut self, shape: &Shape, tuning: &Tuning, barrier: f64, primal: f64, dual: f64) {
        std::mem::swap(&mut self.point, &mut self.trial);
        add(&mut self.slacks, primal, &self.step.slacks);
        add(&mut self.violations, primal, &self.step.violations);
        add(&mut self.misses[0], primal, &self.step.misses[0]);
        add(&mut self.misses[1], primal, &self.step.misses[1]);
        add(&mut self.duals.costates, primal, &self.step.duals.costates);
        add(&mut self.duals.terminal, primal, &self.step.duals.terminal);
        for (row, kind) in shape.kinds.iter().enumerate() {
            let change = self.step.duals.rows[row];
            let z = &mut self.duals.rows[row];
            if *kind == RowKind::Equation {
                *z += primal * change;
                continue;
            }
            *z += dual * change;
            let asked = barrier / self.slacks[row];
            *z = z.max(asked / tuning.kept).min(asked * tuning.kept);
            if *kind == RowKind::Elastic {
                *z = z.min(tuning.price * (1.0 - 1e-15));
            }
        }
    }
}

impl Step {
    /// Copies another step without allocating.
    fn clone_from_step(&mut self, other: &Self) {
        self.point.states.copy_from_slice(&other.point.states);
        self.point.inputs.copy_from_slice(&other.point.inputs);
        self.duals.costates.copy_from_slice(&other.duals.costates);
        self.duals.terminal.copy_from_slice(&other.duals.terminal);
        self.duals.rows.copy_from_slice(&other.duals.rows);
        self.slacks.copy_from_slice(&other.slacks);
        self.violations.copy_from_slice(&other.violations);
        self.misses[0].copy_from_slice(&other.misses[0]);
        self.misses[1].copy_from_slice(&other.misses[1]);
    }
}

/// Returns the larger of two numbers, or NaN where one of them is NaN (`f64::max` would drop it).
fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
