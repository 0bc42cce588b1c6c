//! Second derivatives of the Lagrangian, stage by stage.
//!
//! ```text
//! L = Σ κ ½uᵀWu + Σ λ_k·(step_k − y_{k+1}) + η·e + Σ ν c
//! ```
//!
//! A step's part is the planner's own `H_k`. The parts of the rows, of the wheels and of inputs whose axes
//! turn are central differences of exact gradients, taken along the group: a Newton matrix with nine
//! correct digits costs no accuracy, since that comes from the residual, and one procedure serves them
//! all.

use super::iterate::{Evaluated, Iterate};
use super::model::Model;
use super::rows::{Place, Rows, Value};
use crate::optimize::step::StepError;
use nalgebra::{DMatrix, DVector, SVector};

/// Step of the differences: states and inputs are of order one.
const STEP: f64 = 1e-5;

/// Multipliers of everything.
#[derive(Clone, Debug)]
pub(crate) struct Multipliers {
    /// `λ_{−1} … λ_{N−1}`: of the opening and of every step.
    pub costates: Vec<DVector<f64>>,
    /// `η` of the terminal conditions.
    pub terminal: DVector<f64>,
    /// `ν ≥ 0` of the rows.
    pub rows: Vec<f64>,
}

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
pub(crate) fn blocks(
    model: &Model,
    rows: &Rows,
    iterate: &Iterate,
    evaluated: &Evaluated,
    multipliers: &Multipliers,
) -> Result<Vec<Block>, StepError> {
    let mut first = 0;
    let mut out = Vec::with_capacity(model.steps + 1);
    for stage in 0..=model.steps {
        let end = first + rows.rows[first..].iter().take_while(|row| row.stage == stage).count();
        let acting: Vec<usize> = (first..end)
            .filter(|index| rows.rows[*index].what.is_curved() && multipliers.rows[*index] > 0.0)
            .filter(|index| !matches!(evaluated.rows[*index], Value::Idle))
            .collect();
        first = end;
        out.push(block(model, rows, iterate, multipliers, stage, &acting)?);
    }
    Ok(out)
}

fn block(
    model: &Model,
    rows: &Rows,
    iterate: &Iterate,
    multipliers: &Multipliers,
    stage: usize,
    acting: &[usize],
) -> Result<Block, StepError> {
    let (n, m) = (model.n, model.m);
    let state = &iterate.states[stage];
    let inputs = &iterate.inputs[stage];
    let steps_on = stage < model.steps;
    // Gradients of the step's part and of the rows' part.
    let step_gradient = |z: &DVector<f64>, next: &[f64]| -> Result<DVector<f64>, StepError> {
        if !steps_on {
            return Ok(DVector::zeros(n));
        }
        let step = model.step(stage, &model.moved(state, z), next)?;
        Ok(step.a.tr_mul(&multipliers.costates[stage + 1]))
    };
    let row_gradient =
        |z: &DVector<f64>, inputs: &[f64]| -> Result<(DVector<f64>, DVector<f64>), StepError> {
            let (mut by_state, mut by_inputs) = (DVector::zeros(n), DVector::zeros(m));
            let moved = model.moved(state, z);
            let next = if steps_on { &iterate.inputs[stage + 1] } else { inputs };
            let step = if steps_on { Some(model.step(stage, &moved, next)?) } else { None };
            let (zero, none) = (crate::Vector3::zeros(), nalgebra::Matrix3xX::zeros(n));
            let place = Place {
                state: &moved,
                inputs,
                next,
                arc: step.as_ref().map_or(&zero, |step| &step.arc),
                arc_slope: step.as_ref().map_or(&none, |step| &step.arc_slope),
            };
            for index in acting {
                let value = rows.rows[*index].what.at(model, stage, &place).smooth();
                if let Value::Half { state, inputs, .. } = value {
                    let multiplier = multipliers.rows[*index];
                    if let Some(slope) = state {
                        by_state += slope * multiplier;
                    }
                    if let Some(slope) = inputs {
                        by_inputs += slope * multiplier;
                    }
                }
            }
            Ok((by_state, by_inputs))
        };
    let mut block = Block { state: DMatrix::zeros(n, n), mixed: None, inputs: None, next: None };
    let known = if steps_on { closed_form(model, iterate, multipliers, stage)? } else { None };
    let zero = DVector::zeros(n);
    let shifted = |values: &[f64], index: usize, by: f64| {
        let mut out = values.to_vec();
        out[index] += by;
        out
    };
    let by_difference = known.is_none();
    if let Some(known) = known {
        block.state = known;
    }
    for column in 0..n {
        if !by_difference && acting.is_empty() {
            break;
        }
        let mut z = DVector::zeros(n);
        z[column] = STEP;
        let mut slope = DVector::zeros(n);
        if by_difference {
            let next = if steps_on { &iterate.inputs[stage + 1][..] } else { &[] };
            slope += step_gradient(&z, next)? - step_gradient(&-&z, next)?;
        }
        if !acting.is_empty() {
            slope += row_gradient(&z, inputs)?.0 - row_gradient(&-&z, inputs)?.0;
        }
        let mut own = block.state.column_mut(column);
        own += slope / (2.0 * STEP);
    }
    if !acting.is_empty() {
        let (mut mixed, mut square) = (DMatrix::zeros(n, m), DMatrix::zeros(m, m));
        for column in 0..m {
            let up = row_gradient(&zero, &shifted(inputs, column, STEP))?;
            let down = row_gradient(&zero, &shifted(inputs, column, -STEP))?;
            mixed.set_column(column, &((up.0 - down.0) / (2.0 * STEP)));
            square.set_column(column, &((up.1 - down.1) / (2.0 * STEP)));
        }
        (block.mixed, block.inputs) = (Some(mixed), Some(square));
    }
    if steps_on && model.inputs_turn() {
        let next = &iterate.inputs[stage + 1];
        let mut matrix = DMatrix::zeros(n, m);
        for column in 0..m {
            let up = step_gradient(&zero, &shifted(next, column, STEP))?;
            let down = step_gradient(&zero, &shifted(next, column, -STEP))?;
            matrix.set_column(column, &((up - down) / (2.0 * STEP)));
        }
        block.next = Some(matrix);
    }
    Ok(block)
}

/// The step's part by the planner's own `H_k`, where that applies: no wheels, and inputs whose axes stand
/// still in the coordinates of the momenta.
fn closed_form(
    model: &Model,
    iterate: &Iterate,
    multipliers: &Multipliers,
    stage: usize,
) -> Result<Option<DMatrix<f64>>, StepError> {
    if model.wheels > 0 || model.inputs_turn() {
        return Ok(None);
    }
    let (point, weight) = (iterate.states[stage].point(), model.kick_weight(stage + 1));
    let costate = multipliers.costates[stage + 1].as_slice();
    let n = model.n;
    Ok(Some(if n == 12 {
        let costate = SVector::<f64, 12>::from_column_slice(costate);
        let matrix = model.dynamics.curvature_of_step(stage, &point, &costate, weight)?;
        DMatrix::from_column_slice(n, n, matrix.as_slice())
    } else {
        let costate = SVector::<f64, 6>::from_column_slice(costate);
        let matrix = model.dynamics.curvature_of_step(stage, &point, &costate, weight)?;
        DMatrix::from_column_slice(n, n, matrix.as_slice())
    }))
}

/// The nearest positive semidefinite matrix to the symmetric part; zero where it cannot be found.
pub(crate) fn convexified(matrix: &DMatrix<f64>) -> DMatrix<f64> {
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
