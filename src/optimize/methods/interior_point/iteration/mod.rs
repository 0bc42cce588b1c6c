//! The primal–dual interior-point iteration on programs of stages.
//!
//! All inequality rows have slacks `s`. Elastic rows also have a violation `t` with a penalty `π`,
//! and each terminal equation has one violation for each sign:
//!
//! ```text
//! c − t + s = 0 ,      s z = μ ,         t (π − z) = μ
//! e − t⁺ + t⁻ = 0 ,    t⁺(π − ν) = μ ,   t⁻(π + ν) = μ
//! ```
//!
//! Newton's method, with slacks and violations eliminated:
//!
//! ```text
//! Σ = 1/(s/z + t/(π − z)) ,   ẑ = z + Σ(c + μ/z − μ/(π − z)) ,   dz = ẑ + Σ C dx − z
//! ds = μ/z − s − (s/z) dz ,   dt = (μ + t dz)/(π − z) − t
//! D = t⁺/(π − ν) + t⁻/(π + ν) ,   E dx + e − μ/(π − ν) + μ/(π + ν) = D dν
//! ```
//!
//! The right-hand side is the gradient of the Lagrangian at the current multipliers. It vanishes at
//! the solution, so the round-off of the factors does not limit the accuracy.
//!
//! An iteration:
//!
//! 1. Evaluate the program and test the conditions for convergence.
//! 2. Factor the exact Hessian. If its inertia is wrong and `μ` is large, omit the second
//!    derivatives of steps and rows (Gauss–Newton). If that fails too, or if `μ` is small, shift
//!    the Hessian.
//! 3. Before the final phase (the tail), an affine step (`μ = 0`) determines the next barrier
//!    parameter and the second-order products (Mehrotra 1992). In the final phase the parameter is
//!    decreased whenever the conditions for the current one hold approximately (Fiacco and
//!    McCormick).
//! 4. Limit the step by the fraction to the boundary. Accept it if a filter of infeasibility and
//!    barrier cost accepts it (Wächter and Biegler 2006), if necessary after a second-order
//!    correction or shortened. If the filter accepts no part of it, shift the Hessian.
//!
//! # Why a primal–dual method with two phases?
//!
//! Mehrotra's rule halves the number of iterations, but near the solution `μ` decreases faster than
//! the residual. Exact second derivatives, with Gauss–Newton if the inertia is wrong, take half the
//! iterations of a shift on paths that cross cones. In the final phase Gauss–Newton has no
//! curvature along faces of optima, which minimum-time problems with more inputs than axes have,
//! and converges slowly.
mod search;
mod settle;
mod step;

use super::program::{Derivatives, Duals, Point, Program, RowKind, Shape, Values};
use super::riccati::{Riccati, Right, Taken, Yield, add, dot};
use super::tuning::{STAGES, Tuning};
use crate::optimize::methods::method::Watch;
use settle::Saved;
use step::Step;

/// Reason why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// All conditions hold to the tolerance.
    Converged,
    /// No acceptable step was found.
    Stalled,
    /// The iteration limit was reached.
    Iterations,
    /// A number is not finite, or the program cannot be evaluated at the first point.
    NotFinite,
    /// The run was interrupted or reached its time limit.
    Stopped,
    /// The run converges to the known optimum with this index.
    Known(usize),
}

/// Result of a run: its end, its residuals and its violations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub end: End,
    pub iterations: usize,
    /// Largest residual of stationarity.
    pub dual: f64,
    /// Largest residual of all equations.
    pub primal: f64,
    /// Largest residual of complementarity.
    pub complementarity: f64,
    /// Barrier parameter of each row at the end of the run.
    pub barrier: f64,
    /// Largest violation of an elastic row.
    pub violation: f64,
    /// Largest violation of a terminal equation.
    pub miss: f64,
    /// True if the last factorisation was of the exact Hessian; the point is then a strict minimum
    /// of the barrier problem.
    pub exact: bool,
}

/// Solver with its point, its multipliers and its work space, allocated once for a shape.
pub(crate) struct Solver {
    pub point: Point,
    pub duals: Duals,
    /// Slacks `s` of the rows.
    slacks: Vec<f64>,
    /// Violations `t` of the elastic rows.
    violations: Vec<f64>,
    /// Violations `t⁺` and `t⁻` of the terminal equations.
    misses: [Vec<f64>; 2],
    /// Penalties of the violations of the terminal equations.
    prices: Vec<f64>,
    pub at: Derivatives,
    /// Trial point of the line search.
    trial: Point,
    /// Cost, defects and rows at the trial point.
    trial_values: Values,
    riccati: Riccati,
    sigma: Vec<f64>,
    /// Reciprocals `1/z` and `1/(π − z)` of each row.
    inverses: [Vec<f64>; 2],
    yields: Vec<Yield>,
    /// Gradients of the Lagrangian at the current multipliers.
    plain: Right,
    /// Right-hand side of the linear system.
    right: Right,
    /// Current step.
    step: Step,
    /// Copy of the current step during second-order corrections.
    other: Step,
    /// Second-order products of the pairs `s z` and `t (π − z)`.
    products: [Vec<f64>; 2],
    /// Residuals of rows and equations in the right-hand side.
    lacking: Values,
    filter: Vec<(f64, f64)>,
    /// Best point of the final phase.
    saved: Saved,
    /// Last point that satisfied the conditions of a barrier parameter.
    met: Saved,
}

/// State of the iteration other than its point.
struct State {
    barrier: f64,
    tail: bool,
    /// Final barrier parameter.
    last: f64,
    /// Last barrier parameter whose conditions were satisfied.
    met: f64,
    /// Last shift of the Hessian by the inertia correction.
    shift: f64,
    /// Smallest shift of the Hessian that the line search requires.
    least_shift: f64,
    exact: bool,
    /// Smallest residual of the KKT conditions in the final phase.
    best: f64,
    /// Smallest residual of the KKT conditions at the final barrier parameter.
    best_at_last: f64,
    idle: usize,
    /// Smallest mean complementarity and infeasibility before the final phase that counted as
    /// progress.
    least: [f64; 2],
    /// Mean complementarity at the last point.
    mean: f64,
}

/// Residuals of the KKT conditions.
#[derive(Clone, Copy, Debug, Default)]
struct Residuals {
    dual: f64,
    primal: f64,
    complementarity: f64,
    /// Largest difference between a complementarity product and the barrier parameter.
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
            saved: Saved::of(shape),
            met: Saved::of(shape),
        }
    }

    /// Solves from [`Solver::point`] without a warm start. The result is in `point` and `duals`.
    pub fn run(&mut self, program: &impl Program, tuning: &Tuning, watch: &Watch) -> Run {
        self.solve(program, tuning, watch, Self::begin)
    }

    /// Solves with a warm start from `point` and `duals`, which belong to nearly the same program.
    pub fn resume(&mut self, program: &impl Program, tuning: &Tuning, watch: &Watch) -> Run {
        self.solve(program, tuning, watch, Self::centre)
    }

    /// Solves from a point; `begin` sets its slacks and multipliers for the initial barrier
    /// parameter.
    fn solve<P: Program>(
        &mut self,
        program: &P,
        tuning: &Tuning,
        watch: &Watch,
        begin: impl FnOnce(&mut Self, &P, &Tuning, f64),
    ) -> Run {
        let shape = program.shape();
        let weight = STAGES / shape.stages as f64;
        let first = tuning.first * weight;
        let mut state = State {
            barrier: first,
            tail: false,
            last: tuning.last * weight,
            met: f64::INFINITY,
            shift: 0.0,
            least_shift: 0.0,
            exact: false,
            best: f64::INFINITY,
            best_at_last: f64::INFINITY,
            idle: 0,
            least: [f64::INFINITY; 2],
            mean: first,
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
        self.filter.reserve(tuning.filter);
        program.at_barrier(first);
        if !(program.values(&self.point, &mut self.at.values) && self.at.values.are_finite()) {
            return run;
        }
        begin(self, program, tuning, first);
        for iteration in 0..=tuning.iterations {
            run.iterations = iteration;
            if watch.stopped() {
                run.end = End::Stopped;
                break;
            }
            program.at_barrier(state.barrier.max(state.mean));
            if !program.derivatives(&self.point, &self.duals, &mut self.at) {
                run.end = End::NotFinite;
                break;
            }
            self.gradients(shape);
            let residuals = self.residuals(shape, tuning, state.barrier);
            (run.dual, run.primal) = (residuals.dual, residuals.primal);
            (run.complementarity, run.barrier, run.exact) =
                (residuals.complementarity, state.barrier, state.exact);
            state.mean = residuals.mean;
            if !residuals.largest().is_finite() {
                run.end = End::NotFinite;
                break;
            }
            if state.tail && residuals.largest() < state.best {
                state.best = residuals.largest();
                self.saved.copy(&self.point, &self.duals, [&self.slacks, &self.violations], &self.misses);
            }
            let last = state.last;
            let at_last = state.barrier <= last * (1.0 + 1e-9);
            let asked = if shape.rows() == 0 { tuning.tolerance_without_rows } else { tuning.tolerance };
            let near = residuals.dual.max(residuals.primal) <= asked;
            if near
                && (residuals.complementarity <= tuning.tolerance && residuals.mean <= 2.0 * last
                    || at_last && residuals.off <= tuning.lowered_at * state.barrier)
            {
                run.end = End::Converged;
                break;
            }
            if residuals.primal <= tuning.judged
                && residuals.mean <= tuning.known_from * weight
                && let Some(known) = program.known(&self.point, self.excess(shape))
            {
                run.end = End::Known(known);
                break;
            }
            if !state.tail {
                let now = [residuals.mean, residuals.primal];
                let gains = now.iter().zip(&state.least).any(|(now, least)| *now <= 0.5 * least);
                if gains {
                    state.least = [0, 1].map(|of| now[of].min(state.least[of]));
                }
                state.idle = if gains { 0 } else { state.idle + 1 };
                if state.idle > tuning.search_patience {
                    run.end = End::Stalled;
                    break;
                }
            }
            if at_last {
                let error = residuals.dual.max(residuals.primal).max(residuals.off);
                state.idle = if error < tuning.gain * state.best_at_last { 0 } else { state.idle + 1 };
                state.best_at_last = state.best_at_last.min(error);
                let acceptable = state.best <= tuning.acceptable;
                let patience = if acceptable { tuning.acceptable_patience } else { tuning.patience };
                if state.idle > patience {
                    if self.recovers(program, tuning, &mut state, &mut run, watch) {
                        continue;
                    }
                    break;
                }
            }
            if iteration == tuning.iterations {
                run.end = End::Iterations;
                break;
            }
            if !state.tail
                && state.barrier <= tuning.tail * weight
                && residuals.mean <= tuning.lowered_at * tuning.tail * weight
            {
                state.tail = true;
                state.idle = 0;
                self.filter.clear();
            }
            if state.tail {
                let mut off = residuals.dual.max(residuals.primal).max(residuals.off);
                while state.barrier > last && off <= tuning.lowered_at * state.barrier / weight {
                    if state.barrier < state.met {
                        state.met = state.barrier;
                        let rows = [&self.slacks, &self.violations];
                        self.met.copy(&self.point, &self.duals, rows, &self.misses);
                    }
                    let of_hundred = state.barrier / weight;
                    let next = (tuning.lowered.0 * of_hundred).min(of_hundred.powf(tuning.lowered.1));
                    let next = next * weight;
                    state.barrier = if next <= tuning.snapped * last { last } else { next };
                    self.filter.clear();
                    let again = self.residuals(shape, tuning, state.barrier);
                    off = again.dual.max(again.primal).max(again.off);
                }
            }
            if !self.iterate(program, tuning, &mut state, residuals.mean, watch) {
                if watch.stopped() {
                    run.end = End::Stopped;
                } else if self.recovers(program, tuning, &mut state, &mut run, watch) {
                    continue;
                }
                break;
            }
        }
        if run.end == End::Iterations && state.best <= tuning.acceptable {
            self.settle(program, tuning, state.last, &mut run, watch);
        }
        run.violation = self.violations.iter().fold(0.0, |worst, value| nan_max(worst, *value));
        run.miss = self.at.values.terminal.iter().fold(0.0, |worst, value| nan_max(worst, value.abs()));
        run
    }

    /// Estimates the excess of the cost over the optimum that the barrier causes, to first order:
    /// the sum of the complementarity products of the active rows.
    pub fn excess(&self, shape: &Shape) -> f64 {
        let stages = shape.stages as f64;
        let acts = |row: &usize| stages * self.duals.rows[*row] > self.slacks[*row];
        (0..shape.rows()).filter(acts).map(|row| self.slacks[row] * self.duals.rows[row]).sum()
    }

    /// Sets the initial slacks and multipliers of a cold start.
    fn begin<P: Program>(&mut self, program: &P, tuning: &Tuning, barrier: f64) {
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
        self.set_prices(program, tuning);
        for (index, (e, price)) in self.at.values.terminal.iter().zip(&self.prices).enumerate() {
            let least = barrier / price;
            self.misses[0][index] = e.max(0.0) + least;
            self.misses[1][index] = (-e).max(0.0) + least;
        }
    }

    /// Sets slacks and violations for a warm start, so that all complementarity products equal the
    /// barrier parameter. An active row keeps its multiplier, which determines its slack; an
    /// inactive row keeps its slack, which determines its multiplier.
    fn centre<P: Program>(&mut self, program: &P, tuning: &Tuning, barrier: f64) {
        let stages = program.shape().stages as f64;
        let [least_slack, least] = [(barrier * stages).sqrt(), (barrier / stages).sqrt()];
        for (row, (kind, c)) in program.shape().kinds.iter().zip(&self.at.values.rows).enumerate() {
            let (z, room) = (self.duals.rows[row], (-c).max(0.0));
            if *kind == RowKind::Equation {
                (self.slacks[row], self.violations[row]) = (0.0, 0.0);
                continue;
            }
            let slack = if z * stages > room { barrier / z.max(least) } else { room.max(least_slack) };
            let elastic = *kind == RowKind::Elastic;
            let most = if elastic { tuning.known_price * tuning.price } else { f64::INFINITY };
            let multiplier = (barrier / slack).min(most);
            (self.slacks[row], self.duals.rows[row]) = (slack, multiplier);
            self.violations[row] = if elastic { barrier / (tuning.price - multiplier) } else { 0.0 };
        }
        self.set_prices(program, tuning);
        for (index, price) in self.prices.iter().enumerate() {
            let most = tuning.known_price * price;
            let nu = self.duals.terminal[index].clamp(-most, most);
            self.duals.terminal[index] = nu;
            self.misses[0][index] = barrier / (price - nu);
            self.misses[1][index] = barrier / (price + nu);
        }
    }

    /// Sets the penalties of the terminal equations.
    fn set_prices(&mut self, program: &impl Program, tuning: &Tuning) {
        program.terminal_prices(&mut self.prices);
        for price in &mut self.prices {
            *price *= tuning.terminal_price;
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

    /// Computes all residuals from the gradients of the Lagrangian.
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

    /// Computes the gradient of the Lagrangian at the current multipliers, without the term
    /// `ẑ − z`.
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

    /// Returns to the last point that satisfied the conditions of a barrier parameter, if that
    /// parameter is small, and makes it the final one. The central path ends there: a valley of
    /// nearly equal plans has no minimum for smaller parameters. If that parameter is larger and
    /// the run is `stalled`, the final parameter becomes the geometric mean of the current and the
    /// last such parameter, provided it is small. Returns `false` if no such point exists.
    fn back(&mut self, tuning: &Tuning, weight: f64, state: &mut State, stalled: bool) -> bool {
        let small = tuning.tolerable * weight;
        let between = (state.barrier * state.met).sqrt();
        let next = if state.met <= small { state.met } else { between };
        if state.barrier >= state.met || next > small || next == between && !stalled {
            return false;
        }
        (state.barrier, state.last) = (next, next);
        let rows = [&mut self.slacks, &mut self.violations];
        self.met.restore(&mut self.point, &mut self.duals, rows, &mut self.misses);
        self.filter.clear();
        (state.best, state.best_at_last, state.idle) = (f64::INFINITY, f64::INFINITY, 0);
        true
    }

    /// Ends a stalled run at its best point, if that is a solution to the acceptable residual.
    /// Otherwise returns whether the run continues with a larger final barrier parameter.
    fn recovers<P: Program>(
        &mut self,
        program: &P,
        tuning: &Tuning,
        state: &mut State,
        run: &mut Run,
        watch: &Watch,
    ) -> bool {
        run.end = End::Stalled;
        if state.best <= tuning.acceptable {
            self.settle(program, tuning, state.last, run, watch);
        }
        let weight = STAGES / program.shape().stages as f64;
        run.end == End::Stalled && self.back(tuning, weight, state, true)
    }

    /// Computes and takes one step; returns `false` if no acceptable step exists or the watch ends
    /// the run.
    fn iterate(
        &mut self,
        program: &impl Program,
        tuning: &Tuning,
        state: &mut State,
        mean: f64,
        watch: &Watch,
    ) -> bool {
        let shape = program.shape();
        let weight = STAGES / shape.stages as f64;
        self.weigh(shape, tuning);
        let curved_only = state.tail;
        let mut taken = Taken { curved: true, shift: state.least_shift };
        state.exact = state.least_shift == 0.0;
        if !self.riccati.factor(shape, &self.at, &self.sigma, &self.yields, taken) {
            let retreats = state.last > tuning.last * weight;
            if self.back(tuning, weight, state, retreats) {
                return true;
            }
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
            let least = tuning.proposed * tuning.tail * weight;
            state.barrier = (share * mean).max(least).max(tuning.last * weight);
            if primal.min(dual) > tuning.corrected_from {
                self.second_order_products(shape, tuning.corrected_to * mean.max(0.0));
            }
            self.filter.clear();
        }
        self.direction(shape, state.barrier);
        if !self.search(program, tuning, state, watch) {
            let of_search = &tuning.shift_of_search;
            let over = of_search.over * state.shift;
            state.least_shift = of_search.first.max(over).max(of_search.growth * state.least_shift);
            self.filter.clear();
            return state.least_shift <= tuning.shift.largest;
        }
        state.least_shift /= tuning.shift_of_search.growth;
        if state.least_shift < tuning.shift_of_search.least {
            state.least_shift = 0.0;
        }
        true
    }
}

/// Returns the larger of two numbers, or NaN if one of them is NaN (`f64::max` would drop it).
pub(super) fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
