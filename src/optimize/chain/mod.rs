//! A maneuver as a chain of stages with rows of inequality constraints: the problem of the interior
//! point method and of SCP.
//!
//! [`model`] is the chain and [`rows`] its limits. An [`iterate`] consists of the states and inputs
//! of all stages; the first iterate follows a given path ([`first_iterate`]).

pub(crate) mod first_iterate;
pub(crate) mod iterate;
pub(crate) mod model;
pub(crate) mod rows;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod tuning;

use crate::maneuver::grid::Grid;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings;
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Dynamics, Point, Units};
use crate::optimize::methods::method::{Attempt, Watch};
use crate::{Matrix3, Vector3};
use iterate::Iterate;
use model::{ChainState, Goal, Model, goal, step};
use nalgebra::DVector;
use rows::LimitRows;

/// Lagrange multipliers of the dynamics, of the terminal condition and of the limits.
#[derive(Clone, Debug)]
pub(crate) struct Multipliers {
    /// Costates `λ_{−1} … λ_{N−1}`: multipliers of the opening kick and of every step.
    pub costates: Vec<DVector<f64>>,
    /// Multipliers `η` of the terminal conditions.
    pub terminal: DVector<f64>,
    /// Multipliers `ν ≥ 0` of the limit rows.
    pub rows: Vec<f64>,
}

/// A maneuver as a chain of stages on one grid, together with the rows of its limits.
pub(crate) struct Chain {
    pub model: Model,
    pub rows: LimitRows,
}

impl Chain {
    /// Builds the chain of a minimum-effort maneuver on a uniform grid of `steps` steps.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        let model = Model::new(problem, steps);
        let rows = LimitRows::of(problem, &model);
        Self { model, rows }
    }

    /// Builds the chain with another objective, such as time or fuel, on a uniform grid of `steps`
    /// steps.
    pub fn with_goal(problem: &Problem, steps: usize, goal: &Goal) -> Self {
        Self::with_goal_on(problem, Grid::uniform(problem.scheme, 1.0, steps), goal)
    }

    /// Builds the chain with another objective, such as time or fuel, on a given grid.
    pub fn with_goal_on(problem: &Problem, grid: Grid, goal: &Goal) -> Self {
        let model = goal::with_goal(problem, Dynamics::on(problem, grid), goal);
        let rows = LimitRows::of(problem, &model);
        Self { model, rows }
    }

    /// Returns the cost of a candidate in the user's unit. The effort is left out if it only
    /// regularises a minimum-time or minimum-fuel problem.
    pub fn price(&self, candidate: &Candidate) -> f64 {
        let (iterate, model) = (iterate(candidate), &self.model);
        let cost = if model.effort_power == 0 { iterate.price(model) } else { iterate.cost(model) };
        cost / model.cost_scale
    }

    /// Converts a result of this chain, whose duration may be free, to a candidate of `planned`,
    /// the same maneuver with the duration that was found. The multipliers become derivatives of
    /// the user's cost.
    pub fn of_given_duration(&self, found: Attempt, planned: &Problem) -> Attempt {
        let Attempt { mut candidate, .. } = found;
        let model = &self.model;
        let (units, stretch) = (Units::of(planned), candidate.grid.duration());
        // The unit of length depends on the duration if a velocity at an end determines it.
        let length = model.dynamics.units.length / units.length;
        let in_lengths = |z: &DVector<f64>, by: f64| {
            DVector::from_fn(z.len(), |row, _| if row < model.zeta() { z[row] * by } else { z[row] })
        };
        let scale = 1.0 / (model.cost_scale * units.cost);
        let size = model.duration.unwrap_or(model.n);
        candidate.grid = candidate.grid.with_duration(1.0);
        for state in &mut candidate.states {
            state.position = Sum::new(state.position.value * length);
            state.linear_momentum = Sum::new(state.linear_momentum.value * length);
        }
        for inputs in &mut candidate.inputs {
            inputs[..model.forces].iter_mut().for_each(|force| *force *= length);
        }
        for costate in &mut candidate.costates {
            *costate = in_lengths(&costate.rows(0, size).into_owned(), 1.0 / length) * scale;
        }
        let (terminal, rows) = &mut candidate.multipliers;
        *terminal = in_lengths(terminal, 1.0 / length) * scale;
        for (row, multiplier) in self.rows.rows.iter().zip(rows) {
            // A row is scaled either by the limit for the duration of the problem or by the limit
            // for the duration found.
            let grown = if row.what.is_ball() { 1.0 } else { stretch.powi(row.what.growth()) };
            *multiplier *= grown * scale;
        }
        Attempt { candidate, ..found }
    }

    /// Returns the iterate of a candidate: its states and inputs, or the first iterate along its
    /// path if it has no inputs.
    pub fn iterate(&self, candidate: &Candidate, watch: &Watch) -> Iterate {
        if candidate.inputs.is_empty() {
            let poses: Vec<Pose> = candidate.states.iter().map(Point::pose).collect();
            let stretch = candidate.grid.duration();
            return first_iterate::along(&self.model, &self.rows, &poses, stretch, watch);
        }
        iterate(candidate)
    }

    /// Completes a path to a candidate with momenta and inputs that follow it, without limits and
    /// without wheels.
    pub fn opened(&self, path: &Candidate) -> Candidate {
        let poses: Vec<Pose> = path.states.iter().map(Point::pose).collect();
        let Iterate { states, inputs } =
            first_iterate::along(&self.model, &LimitRows::default(), &poses, 1.0, &Watch::NONE);
        Candidate { states: states.iter().map(ChainState::point).collect(), inputs, ..path.clone() }
    }
}

/// Returns the iterate of a candidate that has states and inputs.
pub(crate) fn iterate(candidate: &Candidate) -> Iterate {
    let wheels = |node: usize| candidate.wheels.get(node).cloned().unwrap_or_else(|| DVector::zeros(0));
    let stretch = candidate.grid.duration();
    let state = |(node, point)| ChainState { stretch, ..ChainState::of(point, wheels(node)) };
    let states = candidate.states.iter().enumerate().map(state);
    Iterate { states: states.collect(), inputs: candidate.inputs.clone() }
}

/// Returns the multipliers of a candidate that has costates and multipliers.
pub(crate) fn multipliers(candidate: &Candidate) -> Multipliers {
    let (terminal, rows) = candidate.multipliers.clone();
    Multipliers { costates: candidate.costates.clone(), terminal, rows }
}

/// Returns `candidate` with the states and inputs of an iterate and with its multipliers.
pub(crate) fn with_iterate(candidate: Candidate, iterate: Iterate, multipliers: Multipliers) -> Candidate {
    let wheels = iterate.states.iter().filter(|state| !state.wheels.is_empty());
    Candidate {
        grid: candidate.grid.with_duration(iterate.stretch()),
        states: iterate.states.iter().map(ChainState::point).collect(),
        wheels: wheels.map(|state| state.wheels.clone()).collect(),
        inputs: iterate.inputs,
        costates: multipliers.costates,
        multipliers: (multipliers.terminal, multipliers.rows),
        ..candidate
    }
}

/// Returns the attitude and the angular velocity of the body (body axes, scaled) at every node of a
/// candidate.
pub(crate) fn body_rates(model: &Model, candidate: &Candidate) -> impl Iterator<Item = (Matrix3, Vector3)> {
    let Iterate { states, inputs } = iterate(candidate);
    states.into_iter().zip(inputs).enumerate().map(|(stage, (state, inputs))| {
        let physical = step::physical(model, stage, &state, &inputs);
        let carried = model.wheel_momentum(&physical.wheels);
        (state.attitude, model.dynamics.j_inverse * (physical.momentum - carried))
    })
}

/// Builds a candidate from the poses of an initial path, one scaled pose per node. `start` names
/// the path.
pub(crate) fn path(start: &str, grid: &Grid, poses: impl Iterator<Item = Pose>) -> Candidate {
    let zero = Sum::new(Vector3::zeros());
    let point = |pose: Pose| Point {
        position: Sum::new(pose.position),
        linear_momentum: zero,
        attitude: Sum::new(pose.attitude),
        momentum: zero,
    };
    let states = poses.map(point).collect();
    Candidate { states, ..Candidate::empty(settings::Method::Scp, start, grid.clone()) }
}
