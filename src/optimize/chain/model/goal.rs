//! What a chain minimises beside or in place of the effort: time, fuel, and their scales.

use super::Model;
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::chain::tuning::{FUEL_PRICE, TIME_PRICE};
use crate::optimize::discrete::step::Dynamics;

/// What a chain minimises in place of the effort.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// Time or fuel, or effort with a price of time. The duration is sought where time counts.
    pub objective: Objective,
}

impl Goal {
    /// Returns the same goal for the duration that a plan has; none where time alone counts.
    pub fn in_given_duration(&self) -> Option<Self> {
        let fuel = self.objective.fuel()?;
        Some(Self { objective: Objective::Fuel(Fuel { time_price: None, ..fuel.clone() }) })
    }
}

/// What fuel costs in a chain.
#[derive(Clone, Debug)]
pub(crate) struct FuelPrice {
    /// Of each input; of a set that is counted by its norm each has the price of that.
    pub inputs: Vec<f64>,
    /// Whether it is `c |B u|` instead of `Σ c_j |u_j|`: of the torques, and of the forces.
    pub of_norm: [bool; 2],
}

impl FuelPrice {
    /// Whether forces or torques are counted by their norm.
    pub fn is_of_norm(&self, forces: bool) -> bool {
        self.of_norm[usize::from(forces)]
    }
}

/// Builds the chain of a maneuver with a goal. Of least time or fuel its cost is what these cost,
/// scaled.
pub fn with_goal(problem: &Problem, dynamics: Dynamics, goal: &Goal) -> Model {
    let mut model = Model::of(problem, dynamics);
    let (stated, time_price) = (model.dynamics.units.time, goal.objective.time_price());
    if goal.objective.counts_time() {
        model.duration = Some(model.n);
        model.n += 1;
    }
    if !goal.objective.switches() {
        model.cost_scale = 1.0 / model.dynamics.units.cost;
        model.time_price = model.cost_scale * time_price * stated;
        model.effort_power = -3;
        return model;
    }
    let prices = goal.objective.fuel().map(|fuel| fuel_prices(&model, fuel));
    let dearest = prices.iter().flatten().copied().fold(0.0, f64::max);
    model.cost_scale = TIME_PRICE / (TIME_PRICE / FUEL_PRICE * dearest + time_price * stated);
    model.time_price = model.cost_scale * time_price * stated;
    model.fuel = prices.map(|prices| FuelPrice {
        inputs: prices.iter().map(|price| price * model.cost_scale).collect(),
        of_norm: [Fuel::is_of_norm(&model.torque), model.force.as_ref().is_some_and(Fuel::is_of_norm)],
    });
    model.weight.fill(0.0);
    model
}

/// What a unit of each input costs over the stated duration, in the user's unit.
fn fuel_prices(model: &Model, fuel: &Fuel) -> Vec<f64> {
    let price = |input: usize| match input.checked_sub(model.forces) {
        Some(torque) => fuel.price(torque),
        None => fuel.force_price(input),
    };
    (0..model.m).map(|input| price(input) * model.input_unit[input] * model.dynamics.units.time).collect()
}

/// What fuel costs in a unit of time under `inputs`.
pub fn fuel_rate(model: &Model, inputs: &[f64]) -> f64 {
    let Some(fuel) = &model.fuel else { return 0.0 };
    let (forces, torques) = inputs.split_at(model.forces);
    let (of_forces, of_torques) = fuel.inputs.split_at(model.forces);
    let burnt = |set: &ActuatorSet, of_norm: bool, prices: &[f64], inputs: &[f64]| -> f64 {
        if of_norm {
            return prices[0] * set.output(inputs).norm();
        }
        prices.iter().zip(inputs).map(|(price, u)| price * u.abs()).sum()
    };
    let force = model.force.as_ref();
    force.map_or(0.0, |set| burnt(set, fuel.is_of_norm(true), of_forces, forces))
        + burnt(&model.torque, fuel.is_of_norm(false), of_torques, torques)
}
