//! Second derivatives of the Lagrangian, stage by stage.
//!
//! ```text
//! L = Σ κ ½uᵀWu + Σ λ_k·(step_k − y_{k+1}) + η·e + Σ ν c
//! ```
//!
//! A step's part is the planner's own `H_k`, and that of inputs whose axes turn: where a drift ends turned by `ζ' = T z`, they
//! give
//!
//! ```text
//! κ (λ^Π·Rᵀτ + λ^γ·R f) ,    gradient  g = κ (λ^Π × Rᵀτ + f × Rᵀλ^γ) ,    its own  M = κ (S(λ^Π) S(Rᵀτ) + S(f) S(Rᵀλ^γ))
//! ```
//!
//! so that `H` is that of a costate with `λ^ζ + g`, and `Tᵀ M T`. The parts of the rows and of wheels are central differences
//! of exact gradients, taken along the group: a Newton matrix with nine correct digits costs no accuracy, since that comes from
//! the residual, and one procedure serves them all. The duration is given.
//!
//! # Why finite differences in the curvature of rows?
//!
//! The Newton matrix decides how fast the iteration converges, not where. Residuals and gradients are exact; second
//! derivatives of rows and of wheels are central differences of those gradients, good to nine digits. Written out they would be pages of formulas for one iteration less. Steps are another matter: their
//! differences took most of the time that Newton takes on a flight with body-fixed thrust, and what inputs that turn add to
//! the planner's own `H_k` is one 3×3 matrix (`chain/curvature`).

use super::Multipliers;
use super::iterate::Evaluated;
use super::model::{ChainState, Model, costate_blocks};
use super::rows::{Place, RowValue, What};
use crate::lie::hat;
use crate::optimize::chain::model::{state, step};
use crate::optimize::chain::tuning::STEP;
use crate::optimize::discrete::step::StepError;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix3xX, SMatrix, SVector};

/// Second derivatives of one stage's part of the Lagrangian.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// By state and state, n×n.
    pub state: DMatrix<f64>,
    /// By state and inputs of the same stage, n×m, of the rows.
    pub mixed: Option<DMatrix<f64>>,
    /// By inputs and inputs of the same stage, m×m, of the rows.
    pub inputs: Option<DMatrix<f64>>,
    /// By state and inputs of the next stage, n×m, of the step.
    pub next: Option<DMatrix<f64>>,
}

/// The second derivatives of all stages.
pub(crate) fn blocks(at: &Evaluated, multipliers: &Multipliers) -> Result<Vec<Block>, StepError> {
    let of_stage = |stage: usize| {
        if at.watch.stopped_at(stage) {
            return Err(StepError::Stopped);
        }
        block(at, multipliers, stage)
    };
    (0..=at.model.steps).map(of_stage).collect()
}

fn block(at: &Evaluated, multipliers: &Multipliers, stage: usize) -> Result<Block, StepError> {
    let Evaluated { model, limits, iterate, .. } = at;
    let (n, m) = (model.n, model.m);
    let (state, inputs) = (&iterate.states[stage], &iterate.inputs[stage]);
    let next = iterate.inputs.get(stage + 1);
    let acts = |index: &usize| {
        let multiplier = multipliers.rows[*index];
        limits.rows[*index].what.is_curved()
            && (multiplier > 0.0 || limits.rows[*index].what.is_equation() && multiplier < 0.0)
            && !matches!(at.rows[*index], RowValue::Idle)
    };
    let acting: Vec<usize> = limits.range(stage).filter(acts).collect();
    // Gradient of the step's part by the state, and that of the rows' part by state and inputs.
    let of_step = |z: &DVector<f64>, next: &[f64]| -> Result<DVector<f64>, StepError> {
        let step = step::step(model, stage, &state::moved(model, state, z), next)?;
        Ok(step.a.tr_mul(&multipliers.costates[stage + 1]))
    };
    let on_arc = acting.iter().any(|index| limits.rows[*index].what.is_of_arc());
    let of_rows = |z: &DVector<f64>, inputs: &[f64]| -> Result<DVector<f64>, StepError> {
        let moved = state::moved(model, state, z);
        let arc = if on_arc { Some(step::arc(model, stage, &moved)?) } else { None };
        let next = next.map_or(inputs, |next| next);
        let place = Place { state: &moved, inputs, next, arc: arc.as_ref() };
        let mut gradient = DVector::zeros(n + m);
        for index in &acting {
            let value = limits.rows[*index].what.at(model, stage, &place).smooth();
            let RowValue::Half { state, inputs, .. } = value else { continue };
            for (slope, first) in [(state, 0), (inputs, n)] {
                let Some(slope) = slope else { continue };
                let mut part = gradient.rows_mut(first, slope.len());
                part += slope * multipliers.rows[*index];
            }
        }
        Ok(gradient)
    };
    let zero = DVector::zeros(n);
    let along = |column: usize, by: f64| {
        let mut z = zero.clone();
        z[column] = by;
        z
    };
    let shifted = |values: &[f64], column: usize, by: f64| {
        let mut out = values.to_vec();
        out[column] += by;
        out
    };
    let mut block = Block { state: DMatrix::zeros(n, n), mixed: None, inputs: None, next: None };
    let mut spread = DMatrix::zeros(n, n);
    if let Some(next) = next {
        match closed_form(at, multipliers, stage)? {
            Some(known) => block.state = known,
            None => spread += differences(n, n, |column, by| of_step(&along(column, by), next))?,
        }
        block.next = by_turning_inputs(at, multipliers, stage);
    }
    if !acting.is_empty() {
        let of_inputs = acting.iter().all(|index| matches!(limits.rows[*index].what, What::InputNorm { .. }));
        if !of_inputs {
            let by_state = differences(n + m, n, |column, by| of_rows(&along(column, by), inputs))?;
            spread += by_state.rows(0, n);
        }
        let by_inputs = differences(n + m, m, |column, by| of_rows(&zero, &shifted(inputs, column, by)))?;
        let by_inputs = by_inputs / (2.0 * STEP);
        block.mixed = Some(by_inputs.rows(0, n).into_owned());
        block.inputs = Some(by_inputs.rows(n, m).into_owned());
    }
    block.state += spread / (2.0 * STEP);
    Ok(block)
}

/// What a gradient of `rows` components gains from a step back to a step ahead along each of so many unknowns.
fn differences(
    rows: usize,
    columns: usize,
    gradient: impl Fn(usize, f64) -> Result<DVector<f64>, StepError>,
) -> Result<DMatrix<f64>, StepError> {
    let mut out = DMatrix::zeros(rows, columns);
    for column in 0..columns {
        out.set_column(column, &(gradient(column, STEP)? - gradient(column, -STEP)?));
    }
    Ok(out)
}

/// The step's part in closed form, where that applies: without wheels.
fn closed_form(
    at: &Evaluated,
    multipliers: &Multipliers,
    stage: usize,
) -> Result<Option<DMatrix<f64>>, StepError> {
    let model = at.model;
    if model.wheels > 0 {
        return Ok(None);
    }
    let (zeta, arrived) = (model.zeta(), Arrived::of(at, multipliers, stage));
    let (slope, bend) = arrived.of_turning_inputs(&at.iterate.inputs[stage + 1]);
    let mut costate = multipliers.costates[stage + 1].clone();
    let mut part = costate.rows_mut(zeta, 3);
    part += slope;
    let state = &at.iterate.states[stage];
    let mut found = DMatrix::zeros(model.n, model.n);
    if zeta == 6 {
        found.view_mut((0, 0), (12, 12)).copy_from(&of_step::<12>(model, stage, state, &costate)?);
    } else {
        found.view_mut((0, 0), (6, 6)).copy_from(&of_step::<6>(model, stage, state, &costate)?);
    }
    if bend != Matrix3::zeros() {
        let turn = at.steps[stage].a.rows(zeta, 3);
        found += turn.tr_mul(&(bend * turn));
    }
    Ok(Some(found))
}

fn of_step<const N: usize>(
    model: &Model,
    stage: usize,
    state: &ChainState,
    costate: &DVector<f64>,
) -> Result<SMatrix<f64, N, N>, StepError> {
    let costate = SVector::<f64, N>::from_column_slice(&costate.as_slice()[..N]);
    let weight = model.kick_weight(stage + 1);
    Ok(model.unforced.transition_by(stage, &state.point(), &costate, weight)?.linear.h)
}

/// The step's part by state and inputs: of inputs whose axes turn.
fn by_turning_inputs(at: &Evaluated, multipliers: &Multipliers, stage: usize) -> Option<DMatrix<f64>> {
    let model = at.model;
    let arrived = Arrived::of(at, multipliers, stage);
    let mut slopes = Matrix3xX::zeros(model.m);
    for (axes, first, forces) in [true, false].into_iter().filter_map(|forces| arrived.turning(forces)) {
        for (index, axis) in axes.iter().enumerate() {
            slopes.set_column(first + index, &arrived.slope(axis, forces));
        }
    }
    let turn = at.steps[stage].a.rows(model.zeta(), 3);
    (slopes.amax() > 0.0).then(|| turn.tr_mul(&slopes))
}

/// Where a drift ends, with the costate after the kick there.
struct Arrived<'a> {
    model: &'a Model,
    attitude: Matrix3,
    /// `κ λ^Π`, and `κ Rᵀλ^γ`.
    pi: Vector3,
    gamma: Vector3,
}

impl<'a> Arrived<'a> {
    fn of(at: &Evaluated<'a>, multipliers: &Multipliers, stage: usize) -> Self {
        let (model, attitude) = (at.model, at.steps[stage].end.attitude);
        let costate = costate_blocks(model, &multipliers.costates[stage + 1]);
        let weight = model.kick_weight(stage + 1);
        Self { model, attitude, pi: costate.pi * weight, gamma: attitude.tr_mul(&costate.gamma) * weight }
    }

    /// Forces or torques whose axes turn: these, where they begin among all inputs, and which of the two they are.
    fn turning(&self, forces: bool) -> Option<(&'a [Vector3], usize, bool)> {
        self.model.turning(forces).map(|(axes, first)| (axes, first, forces))
    }

    /// The gradient of what a force `f`, body axes, or a torque, reference axes, gives.
    fn slope(&self, given: &Vector3, forces: bool) -> Vector3 {
        if forces { given.cross(&self.gamma) } else { self.pi.cross(&self.attitude.tr_mul(given)) }
    }

    /// `g` and `M`.
    fn of_turning_inputs(&self, inputs: &[f64]) -> (Vector3, Matrix3) {
        let (mut slope, mut bend) = (Vector3::zeros(), Matrix3::zeros());
        for (axes, first, forces) in [true, false].into_iter().filter_map(|forces| self.turning(forces)) {
            let given: Vector3 = axes.iter().zip(&inputs[first..]).map(|(axis, input)| axis * *input).sum();
            slope += self.slope(&given, forces);
            bend += if forces {
                hat(&given) * hat(&self.gamma)
            } else {
                hat(&self.pi) * hat(&self.attitude.tr_mul(&given))
            };
        }
        (slope, bend)
    }
}
