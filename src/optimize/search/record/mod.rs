//! Record of a candidate on the requested grid: the trajectory in SI units, cost, terminal error,
//! homotopy class and active limits, for every method.

pub mod answer;
pub mod continuous;
pub mod first_order;
pub mod goal;
pub mod landed;

use crate::Vector3;
use crate::maneuver::grid::Grid;
use crate::maneuver::objective::Weighted;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::{ActiveConstraint, TerminalError, Trajectory};
use crate::mechanics::actuators::LimitKind;
use crate::optimize::chain::model::costate_blocks;
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::{LimitRows, What};
use crate::optimize::chain::{Chain, iterate};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::control_law::ControlLaw;
use crate::optimize::discrete::step::{Costate, Dynamics, Point, StepError};
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Node};
use crate::optimize::methods::method::Swept;
use crate::optimize::search::way::{Follower, Way};
use nalgebra::SVector;

/// Record of a candidate: its trajectory and its properties.
pub(crate) struct Recorded {
    pub trajectory: Trajectory,
    /// Cost of the candidate, scaled.
    pub cost: f64,
    pub terminal: TerminalError,
    pub way: Way,
    pub active: Vec<ActiveConstraint>,
}

/// Records every node of an extremal. If its nodes were not kept, the extremal is swept once more.
pub(crate) fn extremal<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
    swept: Option<&Swept>,
) -> Result<Recorded, StepError> {
    let mut recorder = Recorder::<N>::new(problem, &bvp.dynamics);
    let unit = bvp.dynamics.units.cost / bvp.dynamics.units.time;
    let weights = problem.objective.weights();
    let force = weights.force(&problem.actuation);
    let mut force = force.map(|force| Optimal::of(problem, force, true, unit));
    let mut torque = Optimal::of(problem, weights.torque(&problem.actuation), false, unit);
    let mut record = |node: &Node| recorder.sweep_node(node, force.as_mut(), &mut torque);
    let (error, cost) = match swept {
        Some(Swept { nodes, error, cost }) => {
            nodes.iter().for_each(record);
            (terminal_error(error.as_slice()), *cost)
        }
        None => {
            let end = bvp.sweep_observed(costate, |node| record(&node))?;
            (terminal_error(end.error.as_slice()), end.cost)
        }
    };
    let way = recorder.follower.way_or_short(bvp);
    let active = force.into_iter().chain([torque]).map(|set| set.active);
    Ok(Recorded {
        trajectory: recorder.trajectory,
        cost,
        terminal: error,
        way,
        active: active.filter(|active| !active.time_s.is_empty()).collect(),
    })
}

/// Replays the inputs of a candidate of the chain from the start and records every node. With
/// wheels, the recorded costates are those of attitude and total momentum.
pub(crate) fn chain<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    chain: &Chain,
    candidate: &Candidate,
) -> Result<Recorded, StepError> {
    let Chain { model, rows } = chain;
    let units = &model.dynamics.units;
    let iterate = iterate(candidate).replayed(model)?;
    let mut recorder = Recorder::<N>::new(problem, &model.dynamics);
    for (stage, costate) in candidate.costates.iter().enumerate() {
        let (state, inputs) = (&iterate.states[stage], &iterate.inputs[stage]);
        let physical = step::physical(model, stage, state, inputs);
        let mut point = physical.point();
        point.momentum.value -= model.wheel_momentum(&physical.wheels);
        recorder.state(stage, &point);
        let wheels = physical.wheels.iter().map(|momentum| momentum * units.momentum());
        recorder.trajectory.wheel_momentum.extend(wheels);
        if stage < model.first_input() {
            continue;
        }
        let input = inputs.iter().zip(&model.input_unit).map(|(input, unit)| input * unit);
        recorder.trajectory.input.extend(input);
        let output = step::output(model, &physical, inputs);
        let costate = costate_blocks(model, &step::after_full_kick(model, stage, state, inputs, costate));
        recorder.costate(&costate);
        recorder.outputs(output.force * units.force(), output.moment * units.torque());
    }
    let error = model.terminal_error(&iterate.states[model.steps]);
    Ok(Recorded {
        trajectory: recorder.trajectory,
        cost: iterate.cost(model),
        terminal: terminal_error(error.as_slice()),
        way: recorder.follower.way_or_short(bvp),
        active: active(problem, rows, &candidate.multipliers.1),
    })
}

/// Returns the active limits, with the times and the multipliers of their active rows.
fn active(problem: &Problem, rows: &LimitRows, multipliers: &[f64]) -> Vec<ActiveConstraint> {
    let of_group = |group: usize| {
        let acting = rows.rows.iter().zip(multipliers);
        let acting = acting.filter(move |(row, multiplier)| {
            let pulls = if row.what.is_equation() { **multiplier != 0.0 } else { **multiplier > 0.0 };
            row.group == group && !matches!(row.what, What::Push { .. }) && pulls
        });
        acting.map(|(row, multiplier)| (row.stage as f64 * problem.step(), *multiplier)).unzip()
    };
    let groups = rows.groups.iter().enumerate().map(|(group, named)| {
        let (time_s, multiplier) = of_group(group);
        ActiveConstraint { name: named.name.clone(), time_s, multiplier }
    });
    groups.filter(|active| !active.time_s.is_empty()).collect()
}

/// Writes a trajectory, node by node.
struct Recorder<'a, const N: usize> {
    problem: &'a Problem,
    dynamics: &'a Dynamics,
    /// Grid of the trajectory in SI units.
    grid: Grid,
    trajectory: Trajectory,
    follower: Follower,
}

/// Optimal inputs of one actuator set in SI units, and the record of the set's active limit.
struct Optimal<'a> {
    inputs: Weighted<'a>,
    law: ControlLaw,
    active: ActiveConstraint,
    /// Unit of the multipliers, cost per unit of time.
    unit: f64,
}

impl<'a> Optimal<'a> {
    fn of(problem: &Problem, inputs: Weighted<'a>, of_force: bool, unit: f64) -> Self {
        let kind = if inputs.set.limits().norm.is_some() { LimitKind::Norm } else { LimitKind::Size };
        let name = problem.actuation.limit_name(kind, of_force).into();
        let active = ActiveConstraint { name, time_s: Vec::new(), multiplier: Vec::new() };
        Self { law: ControlLaw::of(&inputs), inputs, active, unit }
    }

    /// Records the optimal inputs for a costate in the axes of the set. Returns the force or torque
    /// that they produce, in the same axes.
    fn push(&mut self, trajectory: &mut Trajectory, costate: &Vector3) -> Vector3 {
        let multiplier = self.law.multipliers(costate).iter().sum::<f64>() / self.unit;
        if multiplier > 0.0 {
            self.active.time_s.push(trajectory.time.last().copied().unwrap_or(0.0));
            self.active.multiplier.push(multiplier);
        }
        let before = trajectory.input.len();
        self.law.push_inputs(&self.inputs, costate, &mut trajectory.input);
        self.inputs.set.output(&trajectory.input[before..])
    }
}

impl<'a, const N: usize> Recorder<'a, N> {
    fn new(problem: &'a Problem, dynamics: &'a Dynamics) -> Self {
        let grid = dynamics.grid.with_duration(problem.seconds());
        let (rows, input_rows) = (grid.steps() + 1, grid.input_rows());
        let input_count = problem.actuation.count();
        let translation = if problem.motion == Motion::RigidBody { rows } else { 0 };
        let trajectory = Trajectory {
            time: Vec::with_capacity(rows),
            quaternion: Vec::with_capacity(rows),
            angular_velocity: Vec::with_capacity(rows),
            position: Vec::with_capacity(translation),
            velocity: Vec::with_capacity(translation),
            input: Vec::with_capacity(input_rows * input_count),
            input_count,
            torque: Vec::with_capacity(input_rows),
            force: Vec::with_capacity(translation.min(input_rows)),
            wheel_momentum: Vec::new(),
            costates: Vec::with_capacity(input_rows * N),
            target: None,
        };
        Self { problem, dynamics, grid, trajectory, follower: Follower::new() }
    }

    fn moves(&self) -> bool {
        self.problem.motion == Motion::RigidBody
    }

    /// Records a physical state. The recorded momentum is that of the body without the wheels.
    fn state(&mut self, node: usize, point: &Point) {
        let (trajectory, units) = (&mut self.trajectory, &self.dynamics.units);
        trajectory.time.push(self.grid.time(node));
        let rate = self.dynamics.j_inverse * point.momentum.value;
        trajectory.angular_velocity.push(rate / units.time);
        let before = self.dynamics.grid.step(node.saturating_sub(1));
        self.follower.node(&point.attitude.value, rate, before);
        trajectory.quaternion.push(self.follower.lifted());
        if self.problem.motion == Motion::RigidBody {
            trajectory.position.push(point.position.value * units.length);
            trajectory.velocity.push(point.linear_momentum.value * (units.length / units.time));
        }
    }

    /// Records a costate; returns it in SI units.
    fn costate(&mut self, costate: &Costate) -> SVector<f64, N> {
        let costate = costate.to_vector::<N>().component_mul(&self.dynamics.units.costate());
        self.trajectory.costates.extend_from_slice(costate.as_slice());
        costate
    }

    /// Records the force (reference frame) and the torque (body axes) of the actuators, SI units.
    fn outputs(&mut self, force: Vector3, torque: Vector3) {
        self.trajectory.torque.push(torque);
        if self.moves() {
            self.trajectory.force.push(force);
        }
    }

    /// Records a node of the sweep, with the inputs that the control law gives there.
    fn sweep_node(&mut self, node: &Node, force: Option<&mut Optimal>, torque: &mut Optimal) {
        let point = node.physical();
        self.state(node.index, &point);
        if node.index < self.grid.first_input() {
            return;
        }
        let costate = self.costate(&node.costate);
        let lambda = |row: usize| Vector3::new(costate[row], costate[row + 1], costate[row + 2]);
        let r = &point.attitude.value;
        let force = match force {
            Some(force) if self.moves() => {
                let frame = force.inputs.set.frame();
                let output = force.push(&mut self.trajectory, &frame.of_reference(r, &lambda(3)));
                frame.to_reference(r, &output)
            }
            _ => Vector3::zeros(),
        };
        let frame = torque.inputs.set.frame();
        let output = torque.push(&mut self.trajectory, &frame.of_body(r, &lambda(N - 3)));
        self.outputs(force, frame.to_body(r, &output));
    }
}

/// Converts a terminal error to the form of a solution. `error` has 6 components on SO(3) or 12 on
/// SE(3), followed by those of the wheels.
fn terminal_error(error: &[f64]) -> TerminalError {
    let norm = |row: usize| Vector3::from_column_slice(&error[row..row + 3]).norm();
    let translation = error.len() == 12;
    let attitude = if translation { 6 } else { 0 };
    TerminalError {
        attitude_rad: norm(attitude),
        momentum_relative: norm(attitude + 3),
        position_relative: translation.then(|| norm(0)),
        linear_momentum_relative: translation.then(|| norm(3)),
    }
}
