//! SCP as a method: from the path of a candidate, and its inputs and multipliers where it has them, to an
//! optimum within all limits.

use super::curvature::Multipliers;
use super::iterate::Iterate;
use super::model::{ChainState, Goal, Model};
use super::rows::LimitRows;
use super::{Convex, ScpOptions, first_iterate, run};
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings;
use crate::maneuver::shortfall::{Excess, Shortfall, Violation};
use crate::maneuver::solution::{ConvexWork, Outcome, Rung};
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Point, Units};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method, Run, Watch};
use crate::optimize::methods::scp::model::{goal, step};
use crate::optimize::methods::scp::tuning::VIOLATED;
use crate::{Matrix3, Vector3};
use nalgebra::DVector;

/// The chain of a maneuver on one grid, with the rows of its limits.
pub(crate) struct Chain {
    pub model: Model,
    pub rows: LimitRows,
}

/// The convex iteration, then Newton on the active set.
pub(crate) struct ConvexIteration<'a> {
    pub chain: &'a Chain,
    pub options: &'a ScpOptions,
}

impl Method for ConvexIteration<'_> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let Chain { model, rows } = self.chain;
        let multipliers = (!candidate.costates.is_empty()).then(|| multipliers(&candidate));
        let start = self.chain.iterate(&candidate, &budget.watch);
        let found = run(model, rows, start, multipliers, self.options, &budget.watch);
        self.chain.attempt(candidate, found)
    }
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
        let model = goal::with_goal(problem, steps, goal);
        let rows = LimitRows::of(problem, &model);
        Self { model, rows }
    }

    /// The cost of a candidate in the user's unit, without the effort where that is a share beside another.
    pub fn price(&self, candidate: &Candidate) -> f64 {
        let (iterate, model) = (iterate(candidate), &self.model);
        let cost = if model.effort_power == 0 { iterate.price(model) } else { iterate.cost(model) };
        cost / model.cost_scale
    }

    /// What this chain, which has a goal, has found, as a candidate of `planned`, the maneuver that states the duration found.
    /// Multipliers are derivatives of the user's cost.
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

    /// The worst violation of all rows at a candidate; `None` where it cannot be evaluated.
    pub fn worst_violation(&self, candidate: &Candidate) -> Option<f64> {
        let evaluated =
            self.iterate(candidate, &Watch::NONE).evaluate(&self.model, &self.rows, Watch::NONE).ok()?;
        Some(evaluated.rows.iter().map(|value| value.violation()).fold(f64::NEG_INFINITY, f64::max))
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

    /// What an iteration made of a candidate; without runs where it could not be evaluated at all.
    fn attempt(&self, candidate: Candidate, convex: Option<Convex>) -> Attempt {
        let Some(convex) = convex else {
            return Attempt { runs: Vec::new(), ..Attempt::failed(candidate, Outcome::Stalled) };
        };
        let shortfall = convex.polished.is_none().then(|| violated(&convex, &self.rows));
        let (steps, residual) = (candidate.steps(), convex.miss());
        let Convex { subproblems, residuals, .. } = convex;
        let last = residuals.last().copied().unwrap_or(f64::NAN);
        let report = Report { outcome: convex.outcome, iterations: subproblems, residuals };
        let mut runs = vec![Run { rung: None, steps, report }];
        let (outcome, cost, stationarity, iterate, multipliers) = match convex.polished {
            Some(polished) => {
                if polished.iterations > 0 {
                    let residuals = vec![last, polished.residual];
                    let (outcome, iterations) = (Outcome::Converged, polished.iterations);
                    let report = Report { outcome, iterations, residuals };
                    runs.push(Run { rung: Some(Rung::Polish), steps, report });
                }
                let (cost, residual) = (polished.cost, polished.residual);
                (Outcome::Converged, cost, residual, polished.iterate, polished.multipliers)
            }
            None => {
                let settled = convex.outcome == Outcome::Converged;
                let outcome = if settled { Outcome::Stalled } else { convex.outcome };
                (outcome, f64::NAN, f64::NAN, convex.iterate, convex.multipliers)
            }
        };
        let work = ConvexWork {
            subproblems,
            all_subproblems: subproblems,
            cone_iterations: convex.cone_iterations,
            cone_seconds: convex.cone_seconds,
        };
        let candidate = with_iterate(candidate, iterate, multipliers);
        let (swept, barrier) = (None, None);
        Attempt { candidate, outcome, cost, residual, stationarity, runs, work, swept, barrier, shortfall }
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

/// What stays violated at the last iterate.
fn violated(convex: &Convex, rows: &LimitRows) -> Shortfall {
    let cut_short_after = (convex.outcome == Outcome::IterationLimit).then_some(convex.subproblems);
    let noticed = rows.groups.iter().zip(&convex.violations).filter(|(_, violation)| **violation > VIOLATED);
    // Cones are violated by an angle, limits by a share of themselves.
    let excess = |is_angle: bool| if is_angle { Excess::Angle } else { Excess::Share };
    let violations = noticed.map(|(group, violation)| Violation {
        name: group.name.clone(),
        excess: excess(group.is_angle)(*violation),
    });
    let defect = convex.residuals.last().copied().unwrap_or(f64::NAN);
    Shortfall::Violated { cut_short_after, violations: violations.collect(), reaches_end: defect <= VIOLATED }
}
