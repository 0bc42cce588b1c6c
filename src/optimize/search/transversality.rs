//! By how much the least cost changes with the end of a maneuver: by the costate there.
//!
//! ```text
//! dV/dρ = −(μ^R·b + μ^Π·J(Ω × b)) ,      dV/dT = ℋ − μ^R·v' − μ^Π·J v'' ,      μ^R = λ^R + (h/2) K_pqᵀλ^Π ,   μ^Π = λ^Π
//! ```
//!
//! with the recorded costates λ, which have had the whole of the last kick, and μ those of the physical state.

use crate::maneuver::aim::Ends;
use crate::maneuver::problem::{EndCondition, Formulation, Motion, Problem};
use crate::maneuver::solution::Solution;
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::Pose;
use crate::{Vector3, lie};

/// Whether a plan can begin from a neighbour's.
pub(super) fn takes_a_guess(problem: &Problem) -> bool {
    Formulation::of(problem) == Formulation::Extremal
}

/// The costate `(μ^R, μ^Π)` of the physical state at the end of a plan of least effort in a given duration; `None` where what is recorded does not tell.
fn end_costate(problem: &Problem, solution: &Solution) -> Option<(Vector3, Vector3)> {
    let told = takes_a_guess(problem)
        && problem.motion == Motion::Attitude
        && problem.actuation.wheels.is_none()
        && !problem.objective.switches();
    let trajectory = &solution.trajectory;
    let (row, torque) = (trajectory.costates.last_chunk::<6>()?, trajectory.torque.last()?);
    let quaternion = trajectory.quaternion.last()?;
    let (zeta, pi) = (Vector3::from_column_slice(&row[..3]), Vector3::from_column_slice(&row[3..]));
    let attitude = lie::rotation_from_quaternion(quaternion);
    let mut pull = Vector3::zeros();
    if problem.actuation.torque.frame() == AxisFrame::Reference {
        pull += pi.cross(torque);
    }
    if !problem.environment.is_free() {
        let pose = Pose { position: Vector3::zeros(), attitude };
        pull += problem.environment.gradient(&pose).rr.tr_mul(&pi);
    }
    let half = if problem.scheme.first_input() == 0 { 0.5 * solution.step } else { 0.0 };
    told.then(|| (zeta + pull * half, pi))
}

/// `dV/dρ` of a plan to an end.
pub(super) fn slope_of_roll(problem: &Problem, ends: &Ends, solution: &Solution) -> Option<f64> {
    let (of_attitude, of_momentum) = end_costate(problem, solution)?;
    let (turn, change) = ends.along_roll(&problem.end.angular_velocity);
    let slope = -(of_attitude.dot(&turn) + of_momentum.dot(&(problem.body.inertia.j() * change)));
    slope.is_finite().then_some(slope)
}

/// What the motion of the target adds to the derivative of the least cost by the duration: `−μ^R·v' − μ^Π·J v''`.
pub(super) fn slope_of_motion(problem: &Problem, solution: &Solution) -> f64 {
    let EndCondition::Aim(aim) = &problem.end_condition else { return 0.0 };
    let (Some(time), Some(quaternion)) =
        (solution.trajectory.time.last(), solution.trajectory.quaternion.last())
    else {
        return f64::NAN;
    };
    let attitude = lie::rotation_from_quaternion(quaternion);
    let Ok(ends) = problem.ends_on(aim, *time) else {
        return f64::NAN;
    };
    let given = problem.facing(&ends, ends.nearest(&attitude));
    let Some((of_attitude, of_momentum)) = end_costate(&given, solution) else { return f64::NAN };
    let (turn, change) = ends.along_time(&given.end.attitude);
    -(of_attitude.dot(&turn) + of_momentum.dot(&(problem.body.inertia.j() * change)))
}
