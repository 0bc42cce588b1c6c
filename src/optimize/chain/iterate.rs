//! An iterate of a chain: states and inputs of all stages, and everything evaluated there.

use super::model::{ChainState, Model, Opening, Step};
use super::rows::{LimitRows, Place, RowValue};
use crate::maneuver::objective;
use crate::optimize::chain::model::{goal, state, step};
use crate::optimize::discrete::step::StepError;
use crate::optimize::methods::method::Watch;
use nalgebra::{DMatrix, DVector};

/// States `y_0 … y_N` and inputs `u_0 … u_N` (`u_0` is unused by Lie–Euler).
#[derive(Clone, Debug)]
pub(crate) struct Iterate {
    pub states: Vec<ChainState>,
    pub inputs: Vec<Vec<f64>>,
}

/// The chain at an iterate.
pub(crate) struct Evaluated<'a> {
    pub model: &'a Model,
    pub limits: &'a LimitRows,
    pub iterate: Iterate,
    /// The opening kick, and its derivatives.
    pub opening: Opening,
    /// Defects: of the opening, then of every step.
    pub defects: Vec<DVector<f64>>,
    pub steps: Vec<Step>,
    /// Terminal error and its derivative.
    pub terminal: DVector<f64>,
    pub terminal_slope: DMatrix<f64>,
    /// The rows of all limits.
    pub rows: Vec<RowValue>,
    pub cost: f64,
}

impl Iterate {
    /// The chain and all its rows at this iterate.
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
        let (terminal, terminal_slope) = model.terminal(&self.states[model.steps]);
        let cost = self.cost(model);
        let value = |row: &super::rows::LimitRow| {
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

    /// `Σ κ ½ uᵀ W u`, and what fuel and time cost.
    pub fn cost(&self, model: &Model) -> f64 {
        let effort = |stage: usize| self.effort(model, stage);
        let effort: f64 = (model.first_input()..=model.steps).map(effort).sum();
        effort + self.price(model)
    }

    /// What the inputs of a stage cost as effort.
    pub fn effort(&self, model: &Model, stage: usize) -> f64 {
        model.effort_weight(stage, self.states[stage].stretch)
            * objective::effort(&model.weight, &self.inputs[stage])
    }

    /// What fuel and time cost.
    pub fn price(&self, model: &Model) -> f64 {
        let fuel = |stage: usize| {
            model.kick_weight(stage) * goal::fuel_rate(model, &self.inputs[stage])
                / self.states[stage].stretch
        };
        let fuel: f64 = (model.first_input()..=model.steps).map(fuel).sum();
        fuel + model.time_price * self.stretch()
    }

    /// Duration in the unit of time.
    pub fn stretch(&self) -> f64 {
        self.states[0].stretch
    }

    /// The iterate moved by a direction.
    pub fn moved(&self, model: &Model, states: &[DVector<f64>], inputs: &[DVector<f64>], by: f64) -> Self {
        let state = |(state, z): (&ChainState, &DVector<f64>)| state::moved(model, state, &(z * by));
        let input = |(u, du): (&Vec<f64>, &DVector<f64>)| -> Vec<f64> {
            u.iter().zip(du.iter()).map(|(u, du)| u + by * du).collect()
        };
        Self {
            states: self.states.iter().zip(states).map(state).collect(),
            inputs: self.inputs.iter().zip(inputs).map(input).collect(),
        }
    }

    /// The trajectory that these inputs make from the start, node after node.
    pub fn replayed(&self, model: &Model) -> Result<Self, StepError> {
        let mut states = Vec::with_capacity(model.steps + 1);
        states.push(step::opening(model, self.stretch(), &self.inputs[0]).end);
        for stage in 0..model.steps {
            let step = step::step(model, stage, &states[stage], &self.inputs[stage + 1])?;
            states.push(step.end);
        }
        Ok(Self { states, inputs: self.inputs.clone() })
    }
}

impl Evaluated<'_> {
    /// Derivative of the state of a stage with respect to its inputs, n×m.
    pub fn input_slope(&self, stage: usize) -> &DMatrix<f64> {
        if stage == 0 { &self.opening.by_inputs } else { &self.steps[stage - 1].b }
    }

    /// `Σ |d|₁ + |e|₁`: what the equations of motion and the terminal conditions lack.
    pub fn infeasibility(&self) -> f64 {
        let size = |d: &DVector<f64>| d.lp_norm(1);
        self.defects.iter().map(size).sum::<f64>() + size(&self.terminal)
    }

    /// The largest component of a defect or of the terminal error.
    pub fn largest_defect(&self) -> f64 {
        self.defects.iter().chain([&self.terminal]).map(|d| d.amax()).fold(0.0, f64::max)
    }

    /// The worst violation in each group of rows, zero where all hold.
    pub fn violations(&self) -> Vec<f64> {
        let mut worst = vec![0.0f64; self.limits.groups.len()];
        for (row, value) in self.limits.rows.iter().zip(&self.rows) {
            let off = match value {
                RowValue::Half { c, .. } if row.what.is_equation() => c.abs(),
                _ => value.violation(),
            };
            worst[row.group] = worst[row.group].max(off);
        }
        worst
    }
}
