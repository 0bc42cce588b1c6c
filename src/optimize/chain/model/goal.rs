//! The objectives of a chain other than effort: time and fuel, and their scales.

use super::Model;
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::ActuatorSet;
use crate::optimize::chain::tuning::{FUEL_PRICE, TIME_PRICE};
use crate::optimize::discrete::step::Dynamics;

/// Objective of a chain other than minimum effort.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// Objective: time, fuel, or effort with a time weight. The duration is free if time has a
    /// weight.
    pub objective: Objective,
}

impl Goal {
    /// Returns the objective for a fixed duration; `None` if the objective is time alone.
    pub fn in_given_duration(&self) -> Option<Self> {
        let fuel = self.objective.fuel()?;
        Some(Self { objective: Objective::Fuel(Fuel { time_price: None, ..fuel.clone() }) })
    }
}

/// Prices of fuel in a chain, scaled.
#[derive(Clone, Debug)]
pub(crate) struct FuelPrice {
    /// Price of each input. If fuel is charged by the norm of the forces or torques, each of their
    /// inputs has the price of the norm.
    pub inputs: Vec<f64>,
    /// Whether fuel is charged as `c |B u|` instead of `Σ c_j |u_j|`, for the torques (index 0) and
    /// for the forces (index 1).
    pub of_norm: [bool; 2],
}

impl FuelPrice {
    /// Returns whether fuel is charged by the norm of the forces (if `forces`) or of the torques.
    pub fn is_of_norm(&self, forces: bool) -> bool {
        self.of_norm[usize::from(forces)]
    }
}

/// Builds the chain of a maneuver with another objective. For minimum time or fuel the cost is the
/// scaled cost of time and fuel.
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

/// Returns the fuel cost of each input, held at one scaled unit for the duration of the problem, in
/// the user's unit.
fn fuel_prices(model: &Model, fuel: &Fuel) -> Vec<f64> {
    let price = |input: usize| match input.checked_sub(model.forces) {
        Some(torque) => fuel.price(torque),
        None => fuel.force_price(input),
    };
    (0..model.m).map(|input| price(input) * model.input_unit[input] * model.dynamics.units.time).collect()
}

/// Returns the scaled fuel cost per unit of time under `inputs`.
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
