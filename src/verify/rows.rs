//! The recorded rows of a plan: whether they fit the problem, and whether they are the motion.

use super::WitnessError;
use super::discrete::Discrete;
use super::plant::{Inputs, Output, Phase, Plant, Scale};
use crate::problem::{Motion, Problem};
use crate::solution::Trajectory;
use crate::{Vector3, lie};

/// How many recorded numbers are NaN or infinite.
pub(super) fn not_finite(trajectory: &Trajectory) -> usize {
    let Trajectory { angular_velocity, position, velocity, torque, force, .. } = trajectory;
    let vectors = [angular_velocity, position, velocity, torque, force].into_iter().flatten().flatten();
    let quaternions = trajectory.quaternion.iter().flatten();
    let scalars = trajectory.time.iter().chain(&trajectory.input).chain(&trajectory.costates);
    vectors.chain(quaternions).chain(scalars).filter(|value| !value.is_finite()).count()
}

/// Whether every row is there, and no other.
pub(super) fn fit(problem: &Problem, trajectory: &Trajectory) -> Result<(), WitnessError> {
    let nodes = problem.steps + 1;
    let outputs = problem.scheme.input_rows(problem.steps);
    let moves = problem.motion == Motion::RigidBody;
    let on_se3 = |rows: usize| if moves { rows } else { 0 };
    let inputs = problem.actuation.count();
    let expected = [
        ("inputs in a row", trajectory.input_count, inputs),
        ("input numbers", trajectory.input.len(), outputs * inputs),
        ("times", trajectory.time.len(), nodes),
        ("quaternions", trajectory.quaternion.len(), nodes),
        ("angular velocities", trajectory.angular_velocity.len(), nodes),
        ("positions", trajectory.position.len(), on_se3(nodes)),
        ("velocities", trajectory.velocity.len(), on_se3(nodes)),
        ("torques", trajectory.torque.len(), outputs),
        ("forces", trajectory.force.len(), on_se3(outputs)),
    ];
    match expected.into_iter().find(|(_, found, expected)| found != expected) {
        Some((what, found, expected)) => Err(WitnessError::Rows { what, found, expected }),
        None => Ok(()),
    }
}

/// What one run of the discrete witness over the plan finds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finding {
    pub(super) end: Phase,
    /// Largest scaled difference between recorded and found; NaN if any is NaN.
    pub(super) recorded: f64,
    pub(super) peak_torque: f64,
    pub(super) peak_rate: f64,
}

/// Larger of the two; NaN if either is, unlike `f64::max`.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Propagates the plan and compares it row by row. The rows must fit.
pub(super) fn compare(
    plant: &Plant,
    inputs: &Inputs,
    trajectory: &Trajectory,
) -> Result<Finding, WitnessError> {
    let problem = plant.problem;
    let scale = Scale::of(problem);
    let (torque_unit, force_unit) = scale.loads();
    let start = Phase::of(problem, &problem.start);
    let mut body = Discrete::new(plant, &start, problem.scheme, problem.step());
    let mut found = Finding { end: start, recorded: 0.0, peak_torque: 0.0, peak_rate: 0.0 };
    let first_output = problem.steps + 1 - problem.scheme.input_rows(problem.steps);
    for node in 0..=problem.steps {
        if node > 0 {
            let (from, to) = inputs.ends(node - 1);
            body.advance(&from, &to)?;
        }
        let phase = body.phase();
        let rate = phase.angular_velocity(problem);
        found.peak_rate = larger(found.peak_rate, rate.norm());
        let time = (trajectory.time[node] - body.time()).abs() / scale.time;
        let states = state_difference(plant, trajectory, node, &phase, &scale);
        found.recorded = larger(larger(found.recorded, states), time);
        if node >= first_output {
            let row = node - first_output;
            let output: Output = inputs.row(row);
            found.peak_torque = larger(found.peak_torque, output.torque.norm());
            let acting = plant.actuators(&phase.attitude, &output);
            let torque = (trajectory.torque[row] - acting.moment).norm() / torque_unit;
            found.recorded = larger(found.recorded, torque);
            if plant.moves {
                let force = (trajectory.force[row] - acting.force).norm() / force_unit;
                found.recorded = larger(found.recorded, force);
            }
        }
    }
    found.end = body.phase();
    Ok(found)
}

/// Scaled difference of the recorded state from `phase`.
fn state_difference(
    plant: &Plant,
    trajectory: &Trajectory,
    node: usize,
    phase: &Phase,
    scale: &Scale,
) -> f64 {
    let problem = plant.problem;
    let rate: Vector3 = trajectory.angular_velocity[node];
    let q = trajectory.quaternion[node];
    let size = q.iter().map(|part| part * part).sum::<f64>().sqrt();
    let recorded = Phase {
        position: trajectory.position.get(node).copied().unwrap_or_else(Vector3::zeros),
        linear_momentum: trajectory
            .velocity
            .get(node)
            .map_or_else(Vector3::zeros, |velocity| velocity * problem.body.mass.unwrap_or(0.0)),
        attitude: lie::rotation_from_quaternion(&q),
        momentum: problem.body.inertia.j() * rate,
    };
    larger(scale.distance(&recorded, phase, problem.motion).largest(), (size - 1.0).abs())
}

/// The trajectory that the discrete witness finds for the inputs of a plan, without costates.
///
/// `inputs` are the rows of [`Trajectory::input`], one after the other.
///
/// # Errors
/// A [`WitnessError`] when the problem is unusable, the rows do not fit it, or a step has no solution.
pub fn replay(problem: &Problem, inputs: &[f64]) -> Result<Trajectory, WitnessError> {
    problem.check()?;
    let plant = Plant::new(problem).judgeable()?;
    let count = problem.actuation.count();
    let expected = problem.scheme.input_rows(problem.steps) * count;
    if inputs.len() != expected {
        return Err(WitnessError::Rows { what: "input numbers", found: inputs.len(), expected });
    }
    let rows = Inputs::new(problem, inputs);
    let start = Phase::of(problem, &problem.start);
    let mut body = Discrete::new(&plant, &start, problem.scheme, problem.step());
    let mut quaternion = lie::quaternion_from_rotation(&start.attitude);
    let mut found = Trajectory { input: inputs.to_vec(), input_count: count, ..Trajectory::default() };
    let first_output = problem.steps + 1 - problem.scheme.input_rows(problem.steps);
    for node in 0..=problem.steps {
        if node > 0 {
            let (from, to) = rows.ends(node - 1);
            body.advance(&from, &to)?;
        }
        let phase = body.phase();
        quaternion = same_sign(lie::quaternion_from_rotation(&phase.attitude), &quaternion);
        found.time.push(body.time());
        found.quaternion.push(quaternion);
        found.angular_velocity.push(phase.angular_velocity(problem));
        if plant.moves {
            found.position.push(phase.position);
            found.velocity.push(phase.velocity(problem));
        }
        if node >= first_output {
            let acting = plant.actuators(&phase.attitude, &rows.row(node - first_output));
            found.torque.push(acting.moment);
            if plant.moves {
                found.force.push(acting.force);
            }
        }
    }
    Ok(found)
}

/// Of `q` and `−q` the one nearer to `last`.
pub(crate) fn same_sign(q: [f64; 4], last: &[f64; 4]) -> [f64; 4] {
    let dot: f64 = q.iter().zip(last).map(|(a, b)| a * b).sum();
    if dot < 0.0 { q.map(|part| -part) } else { q }
}
