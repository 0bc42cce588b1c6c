//! A chain evaluated at an iterate, with all its derivatives.

use super::rows::{Place, RowValue};
use super::step::{self, Opening, Step};
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::{ChainState, Model, state};
use crate::optimize::chain::rows::{LimitRow, LimitRows};
use crate::optimize::discrete::step::StepError;
use crate::optimize::methods::method::Watch;
use nalgebra::{DMatrix, DVector};

/// Chain evaluated at an iterate.
pub(crate) struct Evaluated<'a> {
    pub model: &'a Model,
    pub limits: &'a LimitRows,
    pub iterate: Iterate,
    /// Opening kick with its derivatives.
    pub opening: Opening,
    /// Defects of the opening kick (first) and of every step.
    pub defects: Vec<DVector<f64>>,
    pub steps: Vec<Step>,
    /// Terminal error with its derivative.
    pub terminal: DVector<f64>,
    pub terminal_slope: DMatrix<f64>,
    /// Values of the rows of all limits.
    pub rows: Vec<RowValue>,
    pub cost: f64,
}

impl Iterate {
    /// Evaluates the chain and all its rows at this iterate.
    pub fn evaluate<'a>(
        &self,
        model: &'a Model,
        limits: &'a LimitRows,
        watch: Watch,
    ) -> Result<Evaluated<'a>, StepError> {
        let opening = step::opening(model, self.stretch(), &self.inputs[0]);
        let mut defects = Vec::with_capacity(model.steps + 1);
        defects.push(state::difference(model, &opening.end, &self.states[0]));
        let mut steps = Vec::with_capacity(model.steps);
        for stage in 0..model.steps {
            if watch.stopped_at(stage) {
                return Err(StepError::Stopped);
            }
            let step = step::step(model, stage, &self.states[stage], &self.inputs[stage + 1])?;
            defects.push(state::difference(model, &step.end, &self.states[stage + 1]));
            steps.push(step);
        }
        let (terminal, terminal_slope) = terminal(model, &self.states[model.steps]);
        let cost = self.cost(model);
        let value = |row: &LimitRow| {
            let inputs = &self.inputs[row.stage];
            let place = Place {
                state: &self.states[row.stage],
                inputs,
                next: self.inputs.get(row.stage + 1).unwrap_or(inputs),
                arc: steps.get(row.stage).map(|step| &step.arc),
            };
            row.what.at(model, row.stage, &place)
        };
        let mut rows = Vec::with_capacity(limits.rows.len());
        for (index, row) in limits.rows.iter().enumerate() {
            if watch.stopped_at(index) {
                return Err(StepError::Stopped);
            }
            rows.push(value(row));
        }
        let finite = defects.iter().chain([&terminal]).all(|d| d.iter().all(|value| value.is_finite()));
        if !(finite && cost.is_finite()) {
            return Err(StepError::NotFinite);
        }
        let iterate = self.clone();
        Ok(Evaluated {
            model,
            limits,
            iterate,
            opening,
            defects,
            steps,
            terminal,
            terminal_slope,
            rows,
            cost,
        })
    }

    /// Returns the iterate after a step of length `by` along a direction in states and inputs.
    pub fn moved(&self, model: &Model, states: &[DVector<f64>], inputs: &[DVector<f64>], by: f64) -> Self {
        let state = |(state, z): (&ChainState, &DVector<f64>)| step::moved(model, state, &(z * by));
        let input = |(u, du): (&Vec<f64>, &DVector<f64>)| -> Vec<f64> {
            u.iter().zip(du.iter()).map(|(u, du)| u + by * du).collect()
        };
        Self {
            states: self.states.iter().zip(states).map(state).collect(),
            inputs: self.inputs.iter().zip(inputs).map(input).collect(),
        }
    }
}

impl Evaluated<'_> {
    /// Evaluates the chain at another iterate.
    pub fn elsewhere(&self, iterate: &Iterate) -> Result<Self, StepError> {
        iterate.evaluate(self.model, self.limits, Watch::NONE)
    }

    /// Returns this evaluation with smooth rows: balls are converted to half spaces.
    pub fn smooth(mut self) -> Self {
        self.rows.iter_mut().for_each(|value| *value = value.smooth());
        self
    }

    /// Returns the derivative of the state of a stage with respect to its inputs, n×m.
    pub fn input_slope(&self, stage: usize) -> &DMatrix<f64> {
        if stage == 0 { &self.opening.by_inputs } else { &self.steps[stage - 1].b }
    }

    /// Returns the largest component of the defects and of the terminal error.
    pub fn largest_defect(&self) -> f64 {
        self.defects.iter().chain([&self.terminal]).map(|d| d.amax()).fold(0.0, f64::max)
    }
}

/// Returns the terminal equations at a chain's last state and their derivative, up to the factor
/// `J_r⁻¹` of the attitude error.
fn terminal(model: &Model, state: &ChainState) -> (DVector<f64>, DMatrix<f64>) {
    let error = model.terminal_error(state);
    let mut slope = DMatrix::identity(error.len(), model.n);
    if model.wheels > 0 {
        slope.view_mut((3, 6), (3, model.wheels)).copy_from(&-&model.wheel_axes);
    }
    let given = model.given();
    (error.select_rows(&given), slope.select_rows(&given))
}
