//! From an iterate to a trajectory in SI units.

use super::iterate::Iterate;
use super::model::{Model, costate_blocks};
use crate::lie;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::Trajectory;
use nalgebra::DVector;

/// The trajectory of an iterate whose defects are round-off. With wheels, the costates are those of
/// attitude and total momentum.
pub(crate) fn trajectory(
    problem: &Problem,
    model: &Model,
    iterate: &Iterate,
    costates: &[DVector<f64>],
) -> Trajectory {
    let units = &model.dynamics.units;
    let moves = problem.motion == Motion::RigidBody;
    let mut out = Trajectory { input_count: model.m, ..Trajectory::default() };
    for (stage, costate) in costates.iter().enumerate() {
        let (state, inputs) = (&iterate.states[stage], &iterate.inputs[stage]);
        let physical = model.physical(stage, state, inputs);
        let carried = model.wheel_momentum(&physical.wheels);
        let last = stage == model.steps;
        out.time.push(if last { problem.duration } else { stage as f64 * problem.step() });
        let quaternion = lie::quaternion_from_rotation(&physical.attitude);
        out.quaternion.push(lie::continued(out.quaternion.last(), quaternion));
        out.angular_velocity.push(model.dynamics.j_inverse * (physical.momentum - carried) / units.time);
        out.wheel_momentum.extend(physical.wheels.iter().map(|momentum| momentum * units.momentum()));
        if moves {
            out.position.push(physical.position * units.length);
            out.velocity.push(physical.linear_momentum * (units.length / units.time));
        }
        if stage < model.first_input() {
            continue;
        }
        out.input.extend(inputs.iter().zip(&model.input_unit).map(|(input, unit)| input * unit));
        let output = model.output(&physical, inputs);
        out.torque.push(output.moment * units.torque());
        if moves {
            out.force.push(output.force * units.force());
        }
        let costate = costate_blocks(model, &model.after_full_kick(stage, state, inputs, costate));
        if moves {
            out.costates.extend(costate.to_vector::<12>().component_mul(&units.costate()).iter());
        } else {
            out.costates.extend(costate.to_vector::<6>().component_mul(&units.costate()).iter());
        }
    }
    out
}
