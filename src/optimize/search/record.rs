//! From the sweep's scaled nodes to a trajectory in SI units.

use crate::lie;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::{ActiveConstraint, Sense, TerminalError, Trajectory};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, LimitKind};
use crate::optimize::control_law::ControlLaw;
use crate::optimize::step::{Point, StepError};
use crate::optimize::sweep::{BoundaryValueProblem, End, Node};
use crate::{Matrix3, Vector3};
use nalgebra::{DVector, SVector};

/// A recorded sweep.
pub(crate) struct Recorded<const N: usize> {
    pub end: End<N>,
    pub trajectory: Trajectory,
    pub active: Vec<ActiveConstraint>,
    pub way: Way,
}

/// How a path goes round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Its sense.
    pub sense: Sense,
    /// `∫|Ω|dt` \[deg\].
    pub turned_deg: f64,
    /// `∫Ω dt`, body axes \[rad\]: the rotation vector, where the axis is fixed.
    pub rotation: Vector3,
}

/// Sweeps once more and records every node.
pub(crate) fn record<const N: usize>(
    problem: &Problem,
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Result<Recorded<N>, StepError> {
    let mut recorder = Recorder::<N>::new(problem, bvp);
    let end = bvp.sweep_observed(costate, |node| recorder.push(&node))?;
    let way = way_round(bvp, costate)?;
    let limits = [recorder.force_limit, recorder.torque_limit].into_iter().flatten();
    let active = limits.map(|limit| limit.active).filter(|active| !active.time_s.is_empty()).collect();
    Ok(Recorded { end, trajectory: recorder.trajectory, active, way })
}

struct Recorder<'a, const N: usize> {
    problem: &'a Problem,
    bvp: &'a BoundaryValueProblem<N>,
    /// The grid in SI units.
    grid: Grid,
    trajectory: Trajectory,
    force_limit: Option<Limit>,
    torque_limit: Option<Limit>,
}

/// The limit of a channel: its law, SI units, and where it acts.
struct Limit {
    law: ControlLaw,
    active: ActiveConstraint,
    /// Unit of the multipliers: cost over time.
    unit: f64,
}

impl Limit {
    fn of(problem: &Problem, channel: Option<&ActuatorSet>, of_force: bool, unit: f64) -> Option<Self> {
        let channel = channel?;
        let law = ControlLaw::of(channel)?;
        let kind = if channel.limits().norm.is_some() { LimitKind::Norm } else { LimitKind::Size };
        let name = problem.actuation.limit_name(kind, of_force).into();
        let active = ActiveConstraint { name, time_s: Vec::new(), multiplier: Vec::new() };
        Some(Self { law, active, unit })
    }

    /// The inputs for a costate, in the axes of the channel, at time `time`.
    fn inputs(&mut self, channel: &ActuatorSet, costate: &Vector3, time: f64) -> DVector<f64> {
        let multiplier = self.law.multipliers(costate).iter().sum::<f64>() / self.unit;
        if multiplier > 0.0 {
            self.active.time_s.push(time);
            self.active.multiplier.push(multiplier);
        }
        self.law.inputs(channel, costate)
    }
}

impl<'a, const N: usize> Recorder<'a, N> {
    fn new(problem: &'a Problem, bvp: &'a BoundaryValueProblem<N>) -> Self {
        let grid = bvp.dynamics.grid.with_duration(problem.duration);
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
        };
        let Actuation { force, torque, .. } = &problem.actuation;
        let unit = bvp.dynamics.units.cost / bvp.dynamics.units.time;
        let force_limit = Limit::of(problem, force.as_ref(), true, unit);
        let torque_limit = Limit::of(problem, Some(torque), false, unit);
        Self { problem, bvp, grid, trajectory, force_limit, torque_limit }
    }

    fn push(&mut self, node: &Node) {
        let Self { problem, bvp, grid, trajectory, force_limit, torque_limit } = self;
        let dynamics = &bvp.dynamics;
        let units = &dynamics.units;
        let point = node.physical();
        let r = &point.attitude.value;
        let time = grid.time(node.index);
        trajectory.time.push(time);
        let quaternion = lie::continued(trajectory.quaternion.last(), lie::quaternion_from_rotation(r));
        trajectory.quaternion.push(quaternion);
        trajectory.angular_velocity.push(dynamics.j_inverse * point.momentum.value / units.time);
        if problem.motion == Motion::RigidBody {
            trajectory.position.push(point.position.value * units.length);
            trajectory.velocity.push(point.linear_momentum.value * (units.length / units.time));
        }
        if node.index < grid.first_input() {
            return;
        }
        let scale = units.costate::<N>();
        let costate = node.costate.to_vector::<N>().component_mul(&scale);
        trajectory.costates.extend(costate.iter());
        let lambda = |row: usize| Vector3::new(costate[row], costate[row + 1], costate[row + 2]);
        if problem.motion == Motion::RigidBody {
            let force = problem.actuation.force.as_ref().map_or_else(Vector3::zeros, |channel| {
                let in_axes = match channel.frame() {
                    AxisFrame::Reference => lambda(3),
                    AxisFrame::Body => r.tr_mul(&lambda(3)),
                };
                let output = push_inputs(trajectory, channel, force_limit.as_mut(), &in_axes, time);
                if channel.frame() == AxisFrame::Body { r * output } else { output }
            });
            trajectory.force.push(force);
        }
        let channel = &problem.actuation.torque;
        let in_axes = match channel.frame() {
            AxisFrame::Body => lambda(N - 3),
            AxisFrame::Reference => r * lambda(N - 3),
        };
        let output = push_inputs(trajectory, channel, torque_limit.as_mut(), &in_axes, time);
        let torque = if channel.frame() == AxisFrame::Reference { r.tr_mul(&output) } else { output };
        trajectory.torque.push(torque);
    }
}

fn push_inputs(
    trajectory: &mut Trajectory,
    channel: &ActuatorSet,
    limit: Option<&mut Limit>,
    costate: &Vector3,
    time: f64,
) -> Vector3 {
    let inputs = match limit {
        Some(limit) => limit.inputs(channel, costate, time),
        None => channel.optimal_inputs(costate),
    };
    trajectory.input.extend(inputs.iter());
    channel.output(inputs.as_slice())
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// How the path from `costate` goes round.
///
/// The lifted (continuous) quaternions of the path and of the ballistic motion start equal. The path is
/// short if it ends on the sheet that the ballistic motion reaches by the shortest rotation to target.
pub(crate) fn way_round<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Result<Way, StepError> {
    let path = lift(bvp, costate)?;
    let sense = sense(bvp, &path.end.attitude.value, &path.quaternion)?;
    Ok(Way { sense, turned_deg: path.turned.to_degrees(), rotation: path.rotation })
}

/// The sense of a path given by its attitudes, node after node.
pub(crate) fn sense_of<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    attitudes: &[Matrix3],
) -> Result<Sense, StepError> {
    let mut quaternion = None;
    for attitude in attitudes {
        quaternion = Some(lie::continued(quaternion.as_ref(), lie::quaternion_from_rotation(attitude)));
    }
    let end = attitudes.last().copied().unwrap_or_else(Matrix3::identity);
    sense(bvp, &end, &quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]))
}

/// Which sheet of the double cover a path ends on, against the ballistic motion.
fn sense<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    end: &Matrix3,
    lifted: &[f64; 4],
) -> Result<Sense, StepError> {
    let ballistic = lift(bvp, &SVector::zeros())?;
    let from = &ballistic.end.attitude.value;
    let rest = lie::log(&from.tr_mul(end));
    // Short steps along the shortest rotation carry the ballistic sheet to the end of the path.
    let parts = 16;
    let mut carried = ballistic.quaternion;
    for index in 1..=parts {
        let attitude = from * lie::exp(&(rest * (f64::from(index) / f64::from(parts))));
        carried = lie::continued(Some(&carried), lie::quaternion_from_rotation(&attitude));
    }
    Ok(if dot(&carried, lifted) >= 0.0 { Sense::Short } else { Sense::Long })
}

/// A sweep followed on the double cover.
struct Lift {
    quaternion: [f64; 4],
    end: Point,
    turned: f64,
    rotation: Vector3,
}

fn lift<const N: usize>(bvp: &BoundaryValueProblem<N>, costate: &SVector<f64, N>) -> Result<Lift, StepError> {
    let dynamics = &bvp.dynamics;
    let mut quaternion = None;
    let mut end = bvp.start;
    let (mut turned, mut rotation) = (0.0, Vector3::zeros());
    bvp.sweep_observed(costate, |node| {
        let point = node.physical();
        let attitude = lie::quaternion_from_rotation(&point.attitude.value);
        quaternion = Some(lie::continued(quaternion.as_ref(), attitude));
        let rate = |point: &Point| dynamics.j_inverse * point.momentum.value;
        if node.index > 0 {
            let (now, before) = (rate(&point), rate(&end));
            let half = 0.5 * dynamics.grid.step(node.index - 1);
            turned += half * (now.norm() + before.norm());
            rotation += (now + before) * half;
        }
        end = point;
    })?;
    Ok(Lift { quaternion: quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]), end, turned, rotation })
}

/// The terminal error in the terms of a solution.
pub(crate) fn terminal_error<const N: usize>(error: &SVector<f64, N>) -> TerminalError {
    let norm = |row: usize| error.fixed_rows::<3>(row).norm();
    let translation = N == 12;
    TerminalError {
        attitude_rad: norm(N - 6),
        momentum_relative: norm(N - 3),
        position_relative: translation.then(|| norm(0)),
        linear_momentum_relative: translation.then(|| norm(3)),
    }
}
