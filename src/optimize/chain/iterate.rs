//! An iterate of a chain: the states and inputs of all stages.

use super::model::{ChainState, Model};
use crate::maneuver::objective;
use crate::optimize::chain::model::{goal, step};
use crate::optimize::discrete::step::StepError;

/// Iterate of a chain of N steps: states `y_0 … y_N` and inputs `u_0 … u_N` (Lie–Euler ignores
/// `u_0`).
#[derive(Clone, Debug)]
pub(crate) struct Iterate {
    pub states: Vec<ChainState>,
    pub inputs: Vec<Vec<f64>>,
}

impl Iterate {
    /// Returns the scaled cost of the iterate: effort `Σ κ ½ uᵀ W u`, plus the cost of fuel and
    /// time.
    pub fn cost(&self, model: &Model) -> f64 {
        let effort = |stage: usize| self.effort(model, stage);
        let effort: f64 = (model.first_input()..=model.steps).map(effort).sum();
        effort + self.price(model)
    }

    /// Returns the scaled cost of the effort of one stage.
    pub fn effort(&self, model: &Model, stage: usize) -> f64 {
        model.effort_weight(stage, self.states[stage].stretch)
            * objective::effort(&model.weight, &self.inputs[stage])
    }

    /// Returns the duration as a multiple of the duration of the problem; 1 if it is fixed.
    pub fn price(&self, model: &Model) -> f64 {
        let fuel = |stage: usize| {
            model.kick_weight(stage) * goal::fuel_rate(model, &self.inputs[stage])
                / self.states[stage].stretch
        };
        let fuel: f64 = (model.first_input()..=model.steps).map(fuel).sum();
        fuel + model.time_price * self.stretch()
    }

    /// Returns the duration in the unit of time.
    pub fn stretch(&self) -> f64 {
        self.states[0].stretch
    }

    /// Simulates the inputs from the start and returns the resulting trajectory.
    pub fn replayed(&self, model: &Model) -> Result<Self, StepError> {
        let mut states = Vec::with_capacity(model.steps + 1);
        states.push(step::opening(model, self.stretch(), &self.inputs[0]));
        for stage in 0..model.steps {
            states.push(step::step(model, stage, &states[stage], &self.inputs[stage + 1])?);
        }
        Ok(Self { states, inputs: self.inputs.clone() })
    }
}
