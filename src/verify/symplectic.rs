//! The symplectic witness: the held torque through a variational integrator of order 6, 8 or 12.
//!
//! ```text
//! curves of degree s in the natural chart, action at s Gauss points, steps of at most 0.2 rad
//! ```
//! It integrates Hamilton's principle where the continuous witness integrates the equations of motion, in a
//! rotation vector where that has a quaternion, and solves for what that evaluates. Of the planner's code it
//! uses none, and of the field force and moment alone.

use super::WitnessError;
use super::motion::{Inputs, Phase};
use crate::mechanics::body::Body;
use crate::mechanics::environment::Pose;
use crate::propagate::integrator::{
    Galerkin, Integrator, Momentum, Quadrature, StepError, System, SystemState,
};
use crate::propagate::plant::{HeldLoad, Output, Plant};
use std::sync::Arc;

/// Largest turn of a step [rad]. Steps of the plan are divided until it holds.
const LARGEST_TURN: f64 = 0.2;

/// Most parts of a step of the plan, and most steps in all: a few seconds.
const MOST_PARTS: f64 = 1e4;
const MOST_STEPS: f64 = 4e6;

/// The degree whose error over a maneuver of steps of this turn is round-off.
fn degree(turn: f64) -> usize {
    match turn {
        ..=3e-3 => 3,
        ..=2e-2 => 4,
        _ => 6,
    }
}

/// End of the held plan, whose angular velocity is nowhere much above `peak_rate` [rad/s]; `None` for what the
/// witness cannot judge: wheels, steps too many, or a field so stiff that its iteration does not converge.
pub(super) fn end(
    plant: &Plant,
    inputs: &Inputs,
    start: &Phase,
    peak_rate: f64,
) -> Result<Option<Phase>, WitnessError> {
    let problem = plant.problem;
    let turn = problem.step() * peak_rate;
    let parts = (turn / LARGEST_TURN).ceil().max(1.0);
    // Written so that a NaN ends here.
    let bearable = parts <= MOST_PARTS && parts * problem.steps as f64 <= MOST_STEPS;
    if problem.actuation.wheels.is_some() || !bearable {
        return Ok(None);
    }
    let mass = problem.body.mass.filter(|_| plant.moves);
    let body = Body { inertia: problem.body.inertia.clone(), mass };
    let load = Arc::new(HeldLoad::new(problem, Output::none()));
    let unusable = |_| WitnessError::NotFinite { time: 0.0 };
    let system = System::new(vec![body], Some(load.clone())).map_err(unusable)?;
    let system = system.with_frame_rate(plant.frame_rate());
    let pose = Pose { position: start.position, attitude: start.attitude };
    let momentum = Momentum { linear: start.linear_momentum, angular: start.momentum };
    let state = SystemState::new(vec![pose], vec![momentum]);
    system.check(&state).map_err(unusable)?;
    let step = problem.step() / parts;
    let mut method = Galerkin::new(&system, &state, step, degree(turn / parts), Quadrature::Gauss);
    for k in 0..problem.steps {
        load.hold(inputs.held(k));
        let time = k as f64 * problem.step();
        for _ in 0..parts as usize {
            match method.step(&[]) {
                Ok(()) => {}
                Err(StepError::NotFinite) => return Err(WitnessError::NotFinite { time }),
                // Steps too long for its iteration, which are not too long for the plan.
                Err(_) => return Ok(None),
            }
        }
    }
    let (pose, momentum) = (method.state().poses()[0], method.state().momenta()[0]);
    Ok(Some(Phase {
        position: pose.position,
        linear_momentum: momentum.linear,
        attitude: pose.attitude,
        momentum: momentum.angular,
        stored: start.stored,
    }))
}
