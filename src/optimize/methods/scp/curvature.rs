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

use super::iterate::Evaluated;
use super::model::{ChainState, Model};
use super::rows::{Place, RowValue};
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
pub(crate) fn blocks(at: &Evaluated, multipliers: &Multipliers) -> Result<Vec<Block>, StepError> {
    let blocks = (0..=at.model.steps).map(|stage| block(at, multipliers, stage));
    let mut blocks = blocks.collect::<Result<Vec<_>, _>>()?;
    if let Some(duration) = at.model.duration {
        let last = at.model.steps;
        let states = [&at.iterate.states[0], &at.iterate.states[last]];
        let bends = at.model.bends_of_ends(states, &multipliers.costates[0], &multipliers.terminal);
        blocks[0].state[(duration, duration)] += bends[0] + at.model.time_price * at.iterate.stretch();
        blocks[last].state[(duration, duration)] += bends[1];
        if at.model.effort_power != 0 {
            for (stage, block) in blocks.iter_mut().enumerate() {
                bend_of_effort(at, duration, stage, block);
            }
        }
    }
    Ok(blocks)
}

/// Second derivatives of `κ ½ uᵀWu s^p` by `ln s`, and by it and the inputs.
fn bend_of_effort(at: &Evaluated, duration: usize, stage: usize, block: &mut Block) {
    let (model, iterate) = (at.model, &at.iterate);
    let power = f64::from(model.effort_power);
    block.state[(duration, duration)] += power * power * iterate.effort(model, stage);
    let weight = power * model.effort_weight(stage, iterate.states[stage].stretch);
    let slope = &model.weight * DVector::from_column_slice(&iterate.inputs[stage]) * weight;
    let mixed = block.mixed.get_or_insert_with(|| DMatrix::zeros(model.n, model.m));
    let mut row = mixed.row_mut(duration);
    row += slope.transpose();
}

fn block(at: &Evaluated, multipliers: &Multipliers, stage: usize) -> Result<Block, StepError> {
    let Evaluated { model, limits, iterate, .. } = at;
    let (n, m) = (model.n, model.m);
    let (state, inputs) = (&iterate.states[stage], &iterate.inputs[stage]);
    let next = iterate.inputs.get(stage + 1);
    let acts = |index: &usize| {
        let multiplier = multipliers.rows[*index];
        limits.rows[*index].what.is_curved(model)
            && (multiplier > 0.0 || limits.rows[*index].what.is_kink() && multiplier < 0.0)
            && !matches!(at.rows[*index], RowValue::Idle)
    };
    let acting: Vec<usize> = limits.range(stage).filter(acts).collect();
    // Gradient of the step's part by the state, and that of the rows' part by state and inputs.
    let of_step = |z: &DVector<f64>, next: &[f64]| -> Result<DVector<f64>, StepError> {
        let step = model.step(stage, &model.moved(state, z), next)?;
        Ok(step.a.tr_mul(&multipliers.costates[stage + 1]))
    };
    let of_rows = |z: &DVector<f64>, inputs: &[f64]| -> Result<DVector<f64>, StepError> {
        let moved = model.moved(state, z);
        let step = next.map(|next| model.step(stage, &moved, next)).transpose()?;
        let next = next.map_or(inputs, |next| next);
        let place = Place { state: &moved, inputs, next, step: step.as_ref() };
        let mut gradient = DVector::zeros(n + m);
        for index in &acting {
            let value = limits.rows[*index].what.at(model, stage, &place).smooth();
            let (state, inputs) = match value {
                RowValue::Half { state, inputs, .. } => (state, inputs),
                RowValue::Kink { state, inputs, .. } => (state, Some(inputs)),
                RowValue::Ball { .. } | RowValue::Idle => continue,
            };
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
        if model.inputs_turn() {
            let turned = differences(n, m, |column, by| of_step(&zero, &shifted(next, column, by)))?;
            block.next = Some(turned / (2.0 * STEP));
        }
    }
    if !acting.is_empty() {
        let by_state = differences(n + m, n, |column, by| of_rows(&along(column, by), inputs))?;
        spread += by_state.rows(0, n);
        let by_inputs = differences(n + m, m, |column, by| of_rows(&zero, &shifted(inputs, column, by)))?;
        let by_inputs = by_inputs / (2.0 * STEP);
        block.mixed = Some(by_inputs.rows(0, n).into_owned());
        block.inputs = Some(by_inputs.rows(n, m).into_owned());
    }
    block.state += spread / (2.0 * STEP);
    Ok(block)
}

/// What a gradient of `rows` components gains from a step back to a step ahead along each of `columns` unknowns.
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

/// The step's part by the planner's own `H_k`, where that applies: no wheels, and inputs whose axes stand
/// still in the coordinates of the momenta.
fn closed_form(
    at: &Evaluated,
    multipliers: &Multipliers,
    stage: usize,
) -> Result<Option<DMatrix<f64>>, StepError> {
    let model = at.model;
    if model.wheels > 0 || model.inputs_turn() || model.duration.is_some() {
        return Ok(None);
    }
    let costate = &multipliers.costates[stage + 1];
    let state = &at.iterate.states[stage];
    if model.n == 12 {
        of_step::<12>(model, stage, state, costate).map(Some)
    } else {
        of_step::<6>(model, stage, state, costate).map(Some)
    }
}

fn of_step<const N: usize>(
    model: &Model,
    stage: usize,
    state: &ChainState,
    costate: &DVector<f64>,
) -> Result<DMatrix<f64>, StepError> {
    let costate = SVector::<f64, N>::from_column_slice(costate.as_slice());
    let weight = model.kick_weight(stage + 1);
    let step = model.dynamics.transition_by(stage, &state.point(), &costate, weight)?;
    Ok(DMatrix::from_column_slice(N, N, step.linear.h.as_slice()))
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
