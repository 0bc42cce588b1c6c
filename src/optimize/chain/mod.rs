//! A maneuver as a chain of stages, with its limits as rows: what the interior point and SCP plan.
//!
//! [`model`] is the chain and [`rows`] its limits. An [`iterate`] has the states and inputs of all
//! stages; the first one follows a path ([`first_iterate`]).

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

/// The chain of a maneuver on one grid, with the rows of its limits.
pub(crate) struct Chain {
    pub model: Model,
    pub rows: LimitRows,
}

impl Chain {
    /// The chain of `problem` on `steps` steps.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        let model = Model::new(problem, steps);
        let rows = LimitRows::of(problem, &model);
        Self { model, rows }
    }

    /// The chain of a maneuver of least time or fuel.
    pub fn with_goal(problem: &Problem, steps: usize, goal: &Goal) -> Self {
        Self::with_goal_on(problem, Grid::uniform(problem.scheme, 1.0, steps), goal)
    }

    /// The same on a grid of its own.
    pub fn with_goal_on(problem: &Problem, grid: Grid, goal: &Goal) -> Self {
        let model = goal::with_goal(problem, Dynamics::on(problem, grid), goal);
        let rows = LimitRows::of(problem, &model);
        Self { model, rows }
    }

    /// The cost of a candidate in the user's unit, without the effort where that is a share beside
    /// another.
    pub fn price(&self, candidate: &Candidate) -> f64 {
        let (iterate, model) = (iterate(candidate), &self.model);
        let cost = if model.effort_power == 0 { iterate.price(model) } else { iterate.cost(model) };
        cost / model.cost_scale
    }

    /// What this chain, which has a goal, has found, as a candidate of `planned`, the maneuver that
    /// states the duration found. Multipliers are derivatives of the user's cost.
    pub fn of_given_duration(&self, found: Attempt, planned: &Problem) -> Attempt {
        let Attempt { mut candidate, .. } = found;
        let model = &self.model;
        let (units, stretch) = (Units::of(planned), candidate.grid.duration());
        // Where the body moves fast at an end the unit of length goes with the duration.
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
            // A row in the limit of the stated duration, or in the one that goes with its own.
            let grown = if row.what.is_ball() { 1.0 } else { stretch.powi(row.what.growth()) };
            *multiplier *= grown * scale;
        }
        Attempt { candidate, ..found }
    }

    /// The iterate of a candidate: as it is, or the first one along its path.
    pub fn iterate(&self, candidate: &Candidate, watch: &Watch) -> Iterate {
        if candidate.inputs.is_empty() {
            let poses: Vec<Pose> = candidate.states.iter().map(Point::pose).collect();
            let stretch = candidate.grid.duration();
            return first_iterate::along(&self.model, &self.rows, &poses, stretch, watch);
        }
        iterate(candidate)
    }

    /// A path with the momenta and inputs that it asks for, whatever the limits; without wheels.
    pub fn opened(&self, path: &Candidate) -> Candidate {
        let poses: Vec<Pose> = path.states.iter().map(Point::pose).collect();
        let Iterate { states, inputs } =
            first_iterate::along(&self.model, &LimitRows::default(), &poses, 1.0, &Watch::NONE);
        Candidate { states: states.iter().map(ChainState::point).collect(), inputs, ..path.clone() }
    }
}

/// States and inputs of a candidate that has both.
pub(crate) fn iterate(candidate: &Candidate) -> Iterate {
    let wheels = |node: usize| candidate.wheels.get(node).cloned().unwrap_or_else(|| DVector::zeros(0));
    let stretch = candidate.grid.duration();
    let state = |(node, point)| ChainState { stretch, ..ChainState::of(point, wheels(node)) };
    let states = candidate.states.iter().enumerate().map(state);
    Iterate { states: states.collect(), inputs: candidate.inputs.clone() }
}

/// Costates and multipliers of a candidate that has them.
pub(crate) fn multipliers(candidate: &Candidate) -> Multipliers {
    let (terminal, rows) = candidate.multipliers.clone();
    Multipliers { costates: candidate.costates.clone(), terminal, rows }
}

/// `candidate` with an iterate and its multipliers.
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

/// Attitude and angular velocity of the body (its axes, scaled) at every node of a candidate.
pub(crate) fn body_rates(model: &Model, candidate: &Candidate) -> impl Iterator<Item = (Matrix3, Vector3)> {
    let Iterate { states, inputs } = iterate(candidate);
    states.into_iter().zip(inputs).enumerate().map(|(stage, (state, inputs))| {
        let physical = step::physical(model, stage, &state, &inputs);
        let carried = model.wheel_momentum(&physical.wheels);
        (state.attitude, model.dynamics.j_inverse * (physical.momentum - carried))
    })
}

/// A path to begin from: poses, one per node, scaled.
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
