//! The last digits: semismooth Newton on the conditions of Karush, Kuhn and Tucker.
//!
//! ```text
//! κ W u_k + B_kᵀ λ_{k−1} + Σ ν ∂c/∂u = 0            λ_{k−1} = A_kᵀ λ_k + Σ ν ∂c/∂y
//! defects = 0 ,  e = 0 ,                            ν ≥ 0 ,  c ≤ 0 ,  ν c = 0
//! ```
//!
//! A row acts where `ν + ρ c > 0`: then `c = 0` is an equation, else `ν = 0`. That is Newton's method
//! on the complementarity, and the primal-dual active set method; it finds the active set by itself
//! from a near one. Ordered stage by stage the matrix is a band.
//!
//! On fine grids rows of neighbouring nodes and arcs nearly repeat each other, and an equation too many throws the
//! multipliers about. There the method is stabilised by a proximal term `δ` on the multipliers of rows (stabilised
//! sequential quadratic programming: Wright 1998, Hager 1999),
//!
//! ```text
//! c + C δz − δ (ν⁺ − ν) = 0 ,     a row acts where ν + c/δ > 0
//! ```
//!
//! with `δ` as large as the residual: it vanishes with it, so that the end is as exact and as fast.

use super::curvature::Multipliers;
use super::iterate::{Evaluated, Iterate};
use super::kkt::{Kkt, PROXIMAL};
use super::model::Model;
use super::rows::{Rows, Value};
use super::{Options, Watch};
use crate::numerics::banded::Banded;
use nalgebra::DVector;

/// Steps that turn a node by more than this \[rad\] are shortened.
const LONGEST_TURN: f64 = 0.4;
/// Largest proximal term, and the least share of it that the next one is: the set of rows must keep up.
const WIDEST: f64 = 1e-3;
const SLOWLY: f64 = 0.3;
/// Iterations without progress after which the plain and the stabilised method give up.
const IDLE: [usize; 2] = [12, 25];
/// Growth of the residual after which Newton does not come back.
const LOST: f64 = 100.0;
/// Share of the largest multiplier below which one is taken for the cone solver's round-off.
const LIKELY: f64 = 1e-4;

/// A point that meets the conditions.
pub(crate) struct Polished {
    pub iterate: Iterate,
    pub multipliers: Multipliers,
    pub cost: f64,
    /// Largest residual of all conditions, costates relative to the largest one.
    pub residual: f64,
    pub iterations: usize,
}

/// Polishes an iterate; `None` where Newton does not settle.
pub(crate) fn polish(
    model: &Model,
    rows: &Rows,
    iterate: &Iterate,
    multipliers: &Multipliers,
    options: &Options,
    watch: &Watch,
) -> Option<Polished> {
    let newton = |stabilised| newton(model, rows, iterate, multipliers, options, watch, stabilised);
    newton(false).or_else(|| newton(true))
}

/// Newton's method, plain or stabilised; `None` also where it is stopped.
fn newton(
    model: &Model,
    rows: &Rows,
    iterate: &Iterate,
    multipliers: &Multipliers,
    options: &Options,
    watch: &Watch,
    stabilised: bool,
) -> Option<Polished> {
    let tolerance = options.polish_tolerance;
    let mut iterate = iterate.clone();
    let mut multipliers = multipliers.clone();
    let mut best: Option<Polished> = None;
    let mut idle = 0;
    let mut proximal = if stabilised { WIDEST } else { PROXIMAL };
    // The last pass judges what the last step led to.
    for iteration in 0..=options.newton {
        if watch.stopped() {
            return None;
        }
        let mut evaluated = iterate.evaluate(model, rows).ok()?;
        evaluated.rows.iter_mut().for_each(|value| *value = value.smooth());
        let active = match (stabilised, iteration) {
            (false, _) => active(&evaluated, &multipliers, iteration == 0),
            (true, 0) => likely(&evaluated, &multipliers),
            (true, _) => acting(&evaluated, &multipliers, 1.0 / proximal),
        };
        for (multiplier, active) in multipliers.rows.iter_mut().zip(&active) {
            if !active {
                *multiplier = 0.0;
            }
        }
        let residuals = Residuals::of(model, rows, &iterate, &evaluated, &multipliers);
        let size = residuals.largest(&evaluated, &multipliers, &active);
        if best.as_ref().is_none_or(|best| size < best.residual) {
            let better = best.as_ref().is_none_or(|best| size < 0.5 * best.residual);
            idle = if better { 0 } else { idle + 1 };
            best = Some(Polished {
                iterate: iterate.clone(),
                multipliers: multipliers.clone(),
                cost: evaluated.cost,
                residual: size,
                iterations: iteration,
            });
        } else {
            idle += 1;
        }
        if stabilised {
            proximal = size.max(SLOWLY * proximal).clamp(PROXIMAL, WIDEST);
        }
        let floor = best.as_ref().is_some_and(|best| best.residual <= tolerance);
        let lost = !stabilised && best.as_ref().is_some_and(|best| size > LOST * best.residual);
        if (floor && idle >= 1) || size <= 1e-3 * tolerance || idle >= IDLE[usize::from(stabilised)] || lost {
            break;
        }
        let kkt = Kkt::of(model, rows, &iterate, &evaluated, &multipliers, &active, proximal);
        let Some((states, inputs, change)) =
            kkt.and_then(|kkt| direction(model, kkt, &evaluated, &residuals))
        else {
            break;
        };
        let turn = |z: &DVector<f64>| z.rows(model.zeta(), 3).norm();
        let longest = states.iter().map(turn).fold(0.0, f64::max);
        let fraction = if longest > LONGEST_TURN { LONGEST_TURN / longest } else { 1.0 };
        iterate = iterate.moved(model, &states, &inputs, fraction);
        for (costate, delta) in multipliers.costates.iter_mut().zip(&change.costates) {
            *costate += delta * fraction;
        }
        multipliers.terminal += &change.terminal * fraction;
        for (multiplier, delta) in multipliers.rows.iter_mut().zip(&change.rows) {
            *multiplier += delta * fraction;
        }
    }
    best.filter(|best| best.residual <= tolerance)
}

/// An iterate that no Newton touches, with the residual that it has. Multipliers that are an interior
/// point's round-off are cut to zero.
pub(super) fn as_it_is(
    model: &Model,
    rows: &Rows,
    iterate: &Iterate,
    multipliers: &Multipliers,
) -> Option<Polished> {
    let mut multipliers = multipliers.clone();
    let mut evaluated = iterate.evaluate(model, rows).ok()?;
    evaluated.rows.iter_mut().for_each(|value| *value = value.smooth());
    let active = active(&evaluated, &multipliers, true);
    for (multiplier, _) in multipliers.rows.iter_mut().zip(&active).filter(|(_, active)| !**active) {
        *multiplier = 0.0;
    }
    let residuals = Residuals::of(model, rows, iterate, &evaluated, &multipliers);
    let residual = residuals.largest(&evaluated, &multipliers, &active);
    Some(Polished { iterate: iterate.clone(), multipliers, cost: evaluated.cost, residual, iterations: 0 })
}

/// Which rows act. At first those with a multiplier that is not round-off.
fn active(evaluated: &Evaluated, multipliers: &Multipliers, first: bool) -> Vec<bool> {
    let largest = multipliers.rows.iter().fold(0.0f64, |largest, value| largest.max(*value));
    let rho = largest.max(1e-3);
    if !first {
        return acting(evaluated, multipliers, rho);
    }
    let acts = |(value, multiplier): (&Value, &f64)| match value {
        Value::Half { c, .. } => multiplier + 0.1 * rho * c > 0.0 && *multiplier > 1e-6 * rho || *c > 1e-9,
        _ => false,
    };
    evaluated.rows.iter().zip(&multipliers.rows).map(acts).collect()
}

/// Rows with `ν + ρ c > 0`.
fn acting(evaluated: &Evaluated, multipliers: &Multipliers, rho: f64) -> Vec<bool> {
    let acts = |(value, multiplier): (&Value, &f64)| match value {
        Value::Half { c, .. } => multiplier + rho * c > 0.0,
        _ => false,
    };
    evaluated.rows.iter().zip(&multipliers.rows).map(acts).collect()
}

/// Rows whose multiplier is not small beside the largest.
fn likely(evaluated: &Evaluated, multipliers: &Multipliers) -> Vec<bool> {
    let largest = multipliers.rows.iter().fold(0.0f64, |largest, value| largest.max(*value));
    let acts = |(value, multiplier): (&Value, &f64)| {
        matches!(value, Value::Half { .. }) && *multiplier > LIKELY * largest
    };
    evaluated.rows.iter().zip(&multipliers.rows).map(acts).collect()
}

/// Residuals of stationarity, by stage.
struct Residuals {
    inputs: Vec<DVector<f64>>,
    states: Vec<DVector<f64>>,
    /// Scale of the costates.
    scale: f64,
}

impl Residuals {
    fn of(
        model: &Model,
        rows: &Rows,
        iterate: &Iterate,
        evaluated: &Evaluated,
        multipliers: &Multipliers,
    ) -> Self {
        let first = model.first_input();
        let mut inputs = Vec::with_capacity(model.steps + 1);
        let mut states = Vec::with_capacity(model.steps + 1);
        for stage in 0..=model.steps {
            let costate = &multipliers.costates[stage];
            let slope = if stage == 0 { &evaluated.opening_slope } else { &evaluated.steps[stage - 1].b };
            let u = DVector::from_column_slice(&iterate.inputs[stage]);
            let weight = model.kick_weight(stage);
            inputs.push(if stage >= first {
                &model.weight * u * weight + slope.tr_mul(costate)
            } else {
                DVector::zeros(model.m)
            });
            states.push(if stage < model.steps {
                evaluated.steps[stage].a.tr_mul(&multipliers.costates[stage + 1]) - costate
            } else {
                evaluated.terminal_slope.tr_mul(&multipliers.terminal) - costate
            });
        }
        for ((row, value), multiplier) in rows.rows.iter().zip(&evaluated.rows).zip(&multipliers.rows) {
            let Value::Half { state, inputs: by_inputs, next, .. } = value else { continue };
            if *multiplier == 0.0 {
                continue;
            }
            if let Some(slope) = state {
                states[row.stage] += slope * *multiplier;
            }
            if let Some(slope) = by_inputs {
                inputs[row.stage] += slope * *multiplier;
            }
            if let Some(slope) = next {
                inputs[row.stage + 1] += slope * *multiplier;
            }
        }
        let scale = multipliers.costates.iter().map(|costate| costate.amax()).fold(1.0, f64::max);
        Self { inputs, states, scale }
    }

    /// The largest residual of the equations that the set makes, whatever the signs say.
    fn of_equations(&self, evaluated: &Evaluated, active: &[bool]) -> f64 {
        let norm = |list: &[DVector<f64>]| list.iter().map(|value| value.amax()).fold(0.0, f64::max);
        let steps = self.inputs.len() as f64;
        let mut largest = (norm(&self.inputs) * steps).max(norm(&self.states)) / self.scale;
        largest = largest.max(evaluated.largest_defect());
        for (value, _) in evaluated.rows.iter().zip(active).filter(|(_, active)| **active) {
            if let Value::Half { c, .. } = value {
                largest = largest.max(c.abs());
            }
        }
        if largest.is_nan() { f64::INFINITY } else { largest }
    }

    /// The same, with rows that are violated or pull.
    fn largest(&self, evaluated: &Evaluated, multipliers: &Multipliers, active: &[bool]) -> f64 {
        let mut largest = self.of_equations(evaluated, active);
        for ((value, multiplier), active) in evaluated.rows.iter().zip(&multipliers.rows).zip(active) {
            let Value::Half { c, .. } = value else { continue };
            if !active {
                largest = largest.max(*c);
            }
            largest = largest.max(-multiplier / self.scale);
        }
        if largest.is_nan() { f64::INFINITY } else { largest }
    }
}

/// The Newton direction: changes of states, inputs and multipliers.
#[allow(clippy::type_complexity)]
fn direction(
    model: &Model,
    Kkt { layout, entries }: Kkt,
    evaluated: &Evaluated,
    residuals: &Residuals,
) -> Option<(Vec<DVector<f64>>, Vec<DVector<f64>>, Multipliers)> {
    let (n, m) = (model.n, model.m);
    let t = layout.terminal;
    let mut right = vec![0.0; layout.size];
    for stage in 0..=model.steps {
        let (l, u, z) = (layout.costate[stage], layout.inputs[stage], layout.states[stage]);
        for i in 0..n {
            right[l + i] = -evaluated.defects[stage][i];
            right[z + i] = -residuals.states[stage][i];
        }
        for j in 0..m {
            right[u + j] = -residuals.inputs[stage][j];
        }
    }
    for i in 0..model.terminal_count() {
        right[t + i] = -evaluated.terminal[i];
    }
    for (place, value) in layout.rows.iter().zip(&evaluated.rows) {
        if let (Some(place), Value::Half { c, .. }) = (place, value) {
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
    for (row, column, value) in entries {
        if value != 0.0 {
            band.add(row, column, value);
        }
    }
    if !band.solve(&mut right) {
        return None;
    }
    let part = |at: usize, count: usize| DVector::from_column_slice(&right[at..at + count]);
    let states = layout.states.iter().map(|at| part(*at, n)).collect();
    let inputs = layout.inputs.iter().map(|at| part(*at, m)).collect();
    let change = Multipliers {
        costates: layout.costate.iter().map(|at| part(*at, n)).collect(),
        terminal: part(t, model.terminal_count()),
        rows: layout.rows.iter().map(|at| at.map_or(0.0, |at| right[at])).collect(),
    };
    Some((states, inputs, change))
}
