//! Refinement to full accuracy by a semismooth Newton method on the KKT conditions.
//!
//! ```text
//! κ W u_k + B_kᵀ λ_{k−1} + Σ ν ∂c/∂u = 0            λ_{k−1} = A_kᵀ λ_k + Σ ν ∂c/∂y
//! defects = 0 ,  e = 0 ,                            ν ≥ 0 ,  c ≤ 0 ,  ν c = 0
//! ```
//!
//! A row is active if `ν + ρ c > 0`: then `c = 0` is an equation, else `ν = 0`. This is Newton's
//! method on the complementarity conditions, and the primal-dual active set method; it finds the
//! active set from a nearby one. Ordered by stage the matrix is a band matrix.
//!
//! On fine grids the rows of neighbouring nodes and arcs are nearly linearly dependent, and one
//! redundant equation makes the multipliers large. The method is then stabilised by a proximal term
//! `δ` on the multipliers of rows (stabilised sequential quadratic programming: Wright 1998, Hager
//! 1999),
//!
//! ```text
//! c + C δz − δ (ν⁺ − ν) = 0 ,     a row acts where ν + c/δ > 0
//! ```
//!
//! with `δ` as large as the residual. It vanishes with the residual, so that accuracy and speed of
//! convergence are preserved.
//!
//! A row that is an equation, such as a boresight held on a cone, is always active, and its
//! multiplier may have either sign. Newton's method is applied without the proximal term first, and
//! with it if that fails.

use super::banded::Banded;
use super::evaluated::Evaluated;
use super::kkt::Kkt;
use super::rows::RowValue;
use super::step;
use crate::maneuver::solution::Outcome;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::rows::{LimitRow, LimitRows};
use crate::optimize::chain::tuning::PROXIMAL;
use crate::optimize::methods::driver::{Iteration, run};
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::shooting::newton::outcome_of;
use nalgebra::DVector;

/// Largest residual of a converged iteration.
const TOLERANCE: f64 = 1e-11;
/// Largest number of Newton steps.
const MOST: usize = 60;
/// Largest rotation of a node in one step \[rad\]; longer steps are shortened.
const LONGEST_TURN: f64 = 0.4;
/// Largest proximal term of the stabilised method.
const WIDEST: f64 = 1e-3;
/// Smallest ratio of consecutive proximal terms, so that the active set can adapt.
const SLOWLY: f64 = 0.3;
/// Iterations without progress after which the plain (first) and the stabilised (second) method
/// end.
const IDLE: [usize; 2] = [12, 25];
/// Growth of the residual beyond which Newton's method counts as diverged.
const LOST: f64 = 100.0;
/// Multipliers below this fraction of the largest one count as round-off.
const LIKELY: f64 = 1e-4;

/// Point that satisfies the KKT conditions.
#[derive(Clone)]
pub(crate) struct Polished {
    pub iterate: Iterate,
    pub multipliers: Multipliers,
    pub cost: f64,
    /// Largest residual of all conditions; that of the costates is relative to the largest costate.
    pub residual: f64,
}

/// Returns the point near an iterate that satisfies all conditions; `None` if Newton's method does
/// not converge.
pub(crate) fn newton(
    model: &Model,
    rows: &LimitRows,
    iterate: &Iterate,
    multipliers: &Multipliers,
) -> Option<Polished> {
    let newton = |stabilised: bool| {
        let at = iterate.evaluate(model, rows, Watch::NONE).ok()?.smooth();
        let (newton, report) = run(Newton::new(at, multipliers.clone(), stabilised), MOST, &|| None);
        // The best point may satisfy the conditions even if the iteration limit was reached or a
        // matrix was singular.
        let ended = [Outcome::Converged, Outcome::IterationLimit, Outcome::Singular];
        let best = Some(newton.best).filter(|_| ended.contains(&report.outcome));
        best.filter(|best| best.residual <= TOLERANCE)
    };
    newton(false).or_else(|| newton(true))
}

/// State of Newton's method, plain or stabilised.
struct Newton<'a> {
    at: Evaluated<'a>,
    multipliers: Multipliers,
    active: Vec<bool>,
    residuals: Residuals,
    /// Largest residual of all conditions.
    size: f64,
    best: Polished,
    stabilised: bool,
    proximal: f64,
    /// Number of iterations without progress.
    idle: usize,
}

impl<'a> Newton<'a> {
    fn new(at: Evaluated<'a>, mut multipliers: Multipliers, stabilised: bool) -> Self {
        let active = if stabilised { likely(&at, &multipliers) } else { active(&at, &multipliers) };
        multipliers.drop_idle(&active);
        let residuals = Residuals::of(&at, &multipliers);
        let size = residuals.largest(&at, &multipliers, &active);
        let best = polished(&at, &multipliers, size);
        let widest = widest(stabilised);
        let proximal = next_proximal(size, widest, widest);
        let idle = 0;
        Self { at, multipliers, active, residuals, size, best, stabilised, proximal, idle }
    }

    /// Computes a Newton step, shortened if it rotates a node too far.
    fn step(&self) -> Option<(Iterate, Multipliers)> {
        let Self { at, multipliers, residuals, .. } = self;
        let kkt = Kkt::of(at, multipliers, &self.active, self.proximal)?;
        let (states, inputs, change) = direction(at, kkt, residuals)?;
        let longest = states.iter().map(|z| step::length(at.model, z)).fold(0.0, f64::max);
        let fraction = if longest > LONGEST_TURN { LONGEST_TURN / longest } else { 1.0 };
        Some((
            at.iterate.moved(at.model, &states, &inputs, fraction),
            multipliers.clone().moved(&change, fraction),
        ))
    }

    /// Evaluates the conditions after a step, and keeps the best point.
    fn judge(&mut self) {
        let rho = largest_multiplier(&self.multipliers).max(1e-3);
        let rho = if self.stabilised { 1.0 / self.proximal } else { rho };
        self.active = acting(&self.at, &self.multipliers, rho);
        self.multipliers.drop_idle(&self.active);
        self.residuals = Residuals::of(&self.at, &self.multipliers);
        self.size = self.residuals.largest(&self.at, &self.multipliers, &self.active);
        let better = self.size < 0.5 * self.best.residual;
        self.idle = if better { 0 } else { self.idle + 1 };
        if self.size < self.best.residual {
            self.best = polished(&self.at, &self.multipliers, self.size);
        }
        self.proximal = next_proximal(self.size, self.proximal, widest(self.stabilised));
    }
}

impl Iteration for Newton<'_> {
    fn residual(&self) -> f64 {
        self.size
    }

    /// Returns whether the iteration should end: it has converged, makes no more progress, or
    /// diverges.
    fn converged(&self) -> bool {
        let floor = self.best.residual <= TOLERANCE;
        let lost = !self.stabilised && self.size > LOST * self.best.residual;
        (floor && self.idle >= 1)
            || self.size <= 1e-3 * TOLERANCE
            || self.idle >= IDLE[usize::from(self.stabilised)]
            || lost
    }

    fn advance(&mut self) -> Option<Outcome> {
        let Some((iterate, multipliers)) = self.step() else { return Some(Outcome::Singular) };
        match self.at.elsewhere(&iterate) {
            Ok(evaluated) => self.at = evaluated.smooth(),
            Err(error) => return Some(outcome_of(error)),
        }
        self.multipliers = multipliers;
        self.judge();
        self.converged().then_some(Outcome::Converged)
    }
}

/// Returns the largest proximal term of the plain or the stabilised method.
fn widest(stabilised: bool) -> f64 {
    if stabilised { WIDEST } else { PROXIMAL }
}

/// Returns the next proximal term: the residual, within bounds.
fn next_proximal(residual: f64, last: f64, widest: f64) -> f64 {
    residual.max(SLOWLY * last).clamp(PROXIMAL, widest)
}

fn polished(at: &Evaluated, multipliers: &Multipliers, residual: f64) -> Polished {
    let (iterate, multipliers) = (at.iterate.clone(), multipliers.clone());
    Polished { iterate, multipliers, cost: at.cost, residual }
}

impl Multipliers {
    /// Sets the multipliers of inactive rows to zero.
    fn drop_idle(&mut self, active: &[bool]) {
        for (multiplier, active) in self.rows.iter_mut().zip(active) {
            if !active {
                *multiplier = 0.0;
            }
        }
    }

    fn moved(mut self, change: &Self, fraction: f64) -> Self {
        for (costate, delta) in self.costates.iter_mut().zip(&change.costates) {
            *costate += delta * fraction;
        }
        self.terminal += &change.terminal * fraction;
        for (multiplier, delta) in self.rows.iter_mut().zip(&change.rows) {
            *multiplier += delta * fraction;
        }
        self
    }
}

fn largest_multiplier(multipliers: &Multipliers) -> f64 {
    multipliers.rows.iter().fold(0.0f64, |largest, value| largest.max(*value))
}

/// Returns the rows whose value and multiplier `acts` accepts, and all equations.
fn rows_that(at: &Evaluated, multipliers: &Multipliers, acts: impl Fn(f64, f64) -> bool) -> Vec<bool> {
    let half = |((value, multiplier), row): ((&RowValue, &f64), &LimitRow)| match value {
        RowValue::Half { c, .. } => row.what.is_equation() || acts(*c, *multiplier),
        _ => false,
    };
    at.rows.iter().zip(&multipliers.rows).zip(&at.limits.rows).map(half).collect()
}

/// Returns the initial active set: rows that are violated, or whose multiplier exceeds round-off.
fn active(at: &Evaluated, multipliers: &Multipliers) -> Vec<bool> {
    let rho = largest_multiplier(multipliers).max(1e-3);
    rows_that(at, multipliers, |c, multiplier| {
        multiplier + 0.1 * rho * c > 0.0 && multiplier > 1e-6 * rho || c > 1e-9
    })
}

/// Returns the rows with `ν + ρ c > 0`.
fn acting(at: &Evaluated, multipliers: &Multipliers, rho: f64) -> Vec<bool> {
    rows_that(at, multipliers, |c, multiplier| multiplier + rho * c > 0.0)
}

/// Returns the rows whose multiplier exceeds round-off relative to the largest multiplier.
fn likely(at: &Evaluated, multipliers: &Multipliers) -> Vec<bool> {
    let largest = largest_multiplier(multipliers);
    rows_that(at, multipliers, |_, multiplier| multiplier > LIKELY * largest)
}

/// Stationarity residuals of each stage.
struct Residuals {
    inputs: Vec<DVector<f64>>,
    states: Vec<DVector<f64>>,
    /// Largest costate, used to scale the residuals.
    scale: f64,
}

impl Residuals {
    fn of(at: &Evaluated, multipliers: &Multipliers) -> Self {
        let model = at.model;
        let by_inputs = |stage: usize| {
            if stage < model.first_input() {
                return DVector::zeros(model.m);
            }
            let u = DVector::from_column_slice(&at.iterate.inputs[stage]);
            let costate = &multipliers.costates[stage];
            &model.weight * u * model.kick_weight(stage) + at.input_slope(stage).tr_mul(costate)
        };
        let by_state = |stage: usize| {
            let carried = match at.steps.get(stage) {
                Some(step) => step.a.tr_mul(&multipliers.costates[stage + 1]),
                None => at.terminal_slope.tr_mul(&multipliers.terminal),
            };
            carried - &multipliers.costates[stage]
        };
        let mut inputs: Vec<_> = (0..=model.steps).map(by_inputs).collect();
        let mut states: Vec<_> = (0..=model.steps).map(by_state).collect();
        for ((row, value), multiplier) in at.limits.rows.iter().zip(&at.rows).zip(&multipliers.rows) {
            let [state, by_inputs, next] = value.slopes();
            if *multiplier == 0.0 {
                continue;
            }
            if let Some(slope) = state {
                states[row.stage] += slope * *multiplier;
            }
            for (slope, stage) in [(by_inputs, row.stage), (next, row.stage + 1)] {
                if let Some(slope) = slope {
                    inputs[stage] += slope * *multiplier;
                }
            }
        }
        let scale = multipliers.costates.iter().map(|costate| costate.amax()).fold(1.0, f64::max);
        Self { inputs, states, scale }
    }

    /// Returns the largest residual: of stationarity, of the equations of the active rows, of
    /// violated rows, and of negative multipliers.
    fn largest(&self, at: &Evaluated, multipliers: &Multipliers, active: &[bool]) -> f64 {
        let norm = |list: &[DVector<f64>]| list.iter().map(|value| value.amax()).fold(0.0, f64::max);
        let steps = self.inputs.len() as f64;
        let mut largest = (norm(&self.inputs) * steps).max(norm(&self.states)) / self.scale;
        if largest.is_nan() {
            return f64::INFINITY;
        }
        largest = largest.max(at.largest_defect());
        let rows = at.rows.iter().zip(&multipliers.rows).zip(&at.limits.rows);
        for (((value, multiplier), row), active) in rows.zip(active) {
            let RowValue::Half { c, .. } = value else { continue };
            let pull = if row.what.is_equation() { 0.0 } else { -multiplier / self.scale };
            largest = largest.max(if *active { c.abs() } else { *c }).max(pull);
        }
        largest
    }
}

/// Computes the Newton direction: changes of states, inputs and multipliers.
#[allow(clippy::type_complexity)]
fn direction(
    at: &Evaluated,
    Kkt { layout, entries }: Kkt,
    residuals: &Residuals,
) -> Option<(Vec<DVector<f64>>, Vec<DVector<f64>>, Multipliers)> {
    let (n, m) = (at.model.n, at.model.m);
    let mut right = vec![0.0; layout.size];
    let mut put = |first: usize, lacking: &DVector<f64>| {
        right[first..].iter_mut().zip(lacking.iter()).for_each(|(right, value)| *right = -value);
    };
    let places = [&layout.costate, &layout.inputs, &layout.states];
    for (places, lacking) in places.into_iter().zip([&at.defects, &residuals.inputs, &residuals.states]) {
        places.iter().zip(lacking).for_each(|(place, lacking)| put(*place, lacking));
    }
    put(layout.terminal, &at.terminal);
    for (place, value) in layout.rows.iter().zip(&at.rows) {
        if let (Some(place), RowValue::Half { c, .. }) = (place, value) {
            right[*place] = -c;
        }
    }
    let half = entries
        .iter()
        .filter(|(_, _, value)| *value != 0.0)
        .map(|(row, column, _)| row.abs_diff(*column))
        .max()
        .unwrap_or(0);
    let mut band = Banded::new(layout.size, half);
    for (row, column, value) in entries.into_iter().filter(|(_, _, value)| *value != 0.0) {
        band.add(row, column, value);
    }
    if !band.solve(&mut right) {
        return None;
    }
    let part = |at: usize, count: usize| DVector::from_column_slice(&right[at..at + count]);
    let states = layout.states.iter().map(|at| part(*at, n)).collect();
    let inputs = layout.inputs.iter().map(|at| part(*at, m)).collect();
    let change = Multipliers {
        costates: layout.costate.iter().map(|at| part(*at, n)).collect(),
        terminal: part(layout.terminal, at.model.terminal_count()),
        rows: layout.rows.iter().map(|at| at.map_or(0.0, |at| right[at])).collect(),
    };
    Some((states, inputs, change))
}
