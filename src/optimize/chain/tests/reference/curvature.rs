//! Second derivatives of the Lagrangian, stage by stage.
//!
//! ```text
//! L = Σ κ ½uᵀWu + Σ λ_k·(step_k − y_{k+1}) + η·e + Σ ν c
//! ```
//!
//! All parts are central differences of exact gradients, taken along the group, accurate to nine
//! digits. The duration is fixed.

use super::evaluated::Evaluated;
use super::rows::{Place, RowValue};
use super::step;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::rows::What;
use crate::optimize::discrete::step::StepError;
use nalgebra::{DMatrix, DVector};

/// Step of the differences; states and inputs are of order one.
const STEP: f64 = 1e-5;

/// Second derivatives of one stage's part of the Lagrangian.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Second derivative with respect to the state, n×n.
    pub state: DMatrix<f64>,
    /// Mixed derivative of the rows with respect to the state and the inputs of one stage, n×m.
    pub mixed: Option<DMatrix<f64>>,
    /// Second derivative of the rows with respect to the inputs of one stage, m×m.
    pub inputs: Option<DMatrix<f64>>,
    /// Mixed derivative of the step with respect to the state and the inputs of the next stage,
    /// n×m.
    pub next: Option<DMatrix<f64>>,
}

/// Computes the second derivatives of all stages.
pub(crate) fn blocks(at: &Evaluated, multipliers: &Multipliers) -> Result<Vec<Block>, StepError> {
    (0..=at.model.steps).map(|stage| block(at, multipliers, stage)).collect()
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
    // Gradient of the step's part with respect to the state, and of the rows' part with respect to
    // state and inputs.
    let of_step = |z: &DVector<f64>, next: &[f64]| -> Result<DVector<f64>, StepError> {
        let step = step::step(model, stage, &step::moved(model, state, z), next)?;
        Ok(step.a.tr_mul(&multipliers.costates[stage + 1]))
    };
    let on_arc = acting.iter().any(|index| limits.rows[*index].what.is_of_arc());
    let of_rows = |z: &DVector<f64>, inputs: &[f64]| -> Result<DVector<f64>, StepError> {
        let moved = step::moved(model, state, z);
        let arc = if on_arc {
            Some(step::step(model, stage, &moved, next.map_or(inputs, |next| next))?.arc)
        } else {
            None
        };
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
        spread += differences(n, n, |column, by| of_step(&along(column, by), next))?;
        let by_next = differences(n, m, |column, by| of_step(&zero, &shifted(next, column, by)))?;
        block.next = Some(by_next / (2.0 * STEP));
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

/// Computes the central differences, not divided by the step, of a gradient with `rows` components
/// along each of `columns` unknowns.
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
