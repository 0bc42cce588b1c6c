//! The Hamiltonian along an extremal.
//!
//! ```text
//! H = ½ uᵀWu + λ^x·γ/m + λ^γ·(f + f_u) + λ^ζ·Ω + λ^Π·(Π × Ω + M + τ)
//! ```
//! Where field and frame do not depend on time it is constant in continuous time, limits or not; with the
//! costates of the discrete conditions, which belong to the middle of a kick up to half of it, it is so up to the
//! error of the discretisation. That error is what the chart shows.

use super::charts::{shown, time_axis};
use super::{Shown, Subject, line};
use crate::Vector3;
use crate::draw::{Axis, Chart};
use crate::lie;
use crate::maneuver::objective::Weights;
use crate::maneuver::{Objective, Scheme};
use crate::mechanics::environment::Pose;

/// The chart; none with wheels, whose momentum has a costate that a plan does not hold, in a turning frame, or without
/// costates.
pub(super) fn chart(subject: &Subject) -> Option<Shown> {
    let problem = subject.problem;
    // Where time is minimised the switching functions tell more, and the certificate of the plan tells it.
    let Objective::Effort(weights) = &problem.objective else { return None };
    let turning = problem.environment.frame_rate() != Vector3::zeros();
    if problem.actuation.wheels.is_some() || turning || subject.trajectory().costates.is_empty() {
        return None;
    }
    let values = (0..subject.input_times().len()).map(|row| value(subject, weights, row));
    let curves = vec![line("H", 0, subject.input_times(), values)];
    let chart = Chart::new("Hamiltonian", time_axis(), Axis::linear("H, cost per second"), curves);
    Some(shown(
        "hamiltonian",
        chart,
        "of the discrete costates: constant up to the error of the discretisation",
    ))
}

/// `H` at a row of inputs.
fn value(subject: &Subject, weights: &Weights, row: usize) -> f64 {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    let node = row + problem.scheme.first_input();
    let dimension = problem.dimension();
    let costates = &trajectory.costates[row * dimension..(row + 1) * dimension];
    let part = |first: usize| Vector3::from_column_slice(&costates[first..first + 3]);
    let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[node]);
    let position = trajectory.position.get(node).copied().unwrap_or_default();
    let pose = Pose { position, attitude };
    let field = problem.environment.wrench(&pose);
    let (rate, torque) = (trajectory.angular_velocity[node], trajectory.torque[row]);
    let momentum = problem.body.inertia.j() * rate;
    let (zeta, pi) = (part(dimension - 6), part(dimension - 3));
    let moving = dimension == 12;
    let linear = if moving { part(3) } else { Vector3::zeros() };

    // Half a kick leads the costate of the pose from beside the node to it.
    let half = match problem.scheme {
        Scheme::LieVerlet => 0.5 * problem.step(),
        Scheme::LieEuler => 0.0,
    };
    let gradient = problem.environment.gradient(&pose);
    let zeta = zeta + half * (gradient.rr.tr_mul(&pi) + gradient.xr.tr_mul(&linear));
    let mut value = running_cost(subject, weights, row)
        + zeta.dot(&rate)
        + pi.dot(&(momentum.cross(&rate) + field.moment + torque));
    if moving {
        let x = part(0) + half * (gradient.xx.tr_mul(&linear) + gradient.rx.tr_mul(&pi));
        value += x.dot(&trajectory.velocity[node]) + linear.dot(&(field.force + trajectory.force[row]));
    }
    value
}

/// `½ uᵀWu`.
fn running_cost(subject: &Subject, weights: &Weights, row: usize) -> f64 {
    let actuation = &subject.problem.actuation;
    let inputs = subject.trajectory().inputs(row);
    let force = weights.force(actuation);
    let (forces, torques) = inputs.split_at(force.as_ref().map_or(0, |force| force.set.count()));
    let half_square = |weight: &nalgebra::DMatrix<f64>, inputs: &[f64]| {
        let inputs = nalgebra::DVector::from_column_slice(inputs);
        0.5 * inputs.dot(&(weight * &inputs))
    };
    let of_forces = force.map_or(0.0, |force| half_square(&force.weight, forces));
    of_forces + half_square(&weights.torque(actuation).weight, torques)
}
