//! The Hamiltonian along an extremal.
//!
//! ```text
//! H = L + λ^x·γ/m + λ^γ·(f + f_u) + λ^ζ·(Ω − Rᵀn) + λ^Π·(Π × Ω + M + τ)
//! ```
//!
//! L is the running cost, m the mass, R the attitude, Ω the angular velocity, and n the angular
//! velocity of the reference frame. The field exerts the force f and the moment M, and the inputs
//! exert the force f_u and the torque τ. λ are the costates of position x, linear momentum γ,
//! attitude ζ and angular momentum Π. A field does not depend on time in its own frame, so H is
//! constant in continuous time, with or without limits. It is the derivative of the optimal cost
//! with respect to the duration, and zero if the duration is free. The costates of the discrete
//! conditions are converted to costates at the nodes by half a kick. With them H is constant up to
//! the discretisation error, which the chart shows.
//!
//! Wheels store momenta h with `ḣ = −u`, and Π is then the total momentum. A plan does not contain
//! the costate of h. While no limit of the wheels is active, this costate is `Wu`, and
//!
//! ```text
//! H = ½ uᵀWu + λ^ζ·Ω + λ^Π·(Π × Ω) − uᵀWu
//! ```

use super::charts::{shown, time_axis};
use super::{Shown, Subject, line};
use crate::draw::{Axis, Chart};
use slewkit::maneuver::objective::effort;
use slewkit::maneuver::{Motion, Objective, Scheme};
use slewkit::mechanics::AxisFrame;
use slewkit::mechanics::environment::Pose;
use slewkit::{Vector3, lie};

/// Returns the chart of the Hamiltonian; `None` if [`missing`] returns a reason.
pub(super) fn chart(subject: &Subject) -> Option<Shown> {
    if missing(subject).is_some() {
        return None;
    }
    let values = (0..subject.input_times().len()).map(|row| value(subject, row));
    let curves = vec![line("H", 0, subject.input_times(), values)];
    let chart = Chart::new("Hamiltonian", time_axis(), Axis::linear("H, cost per second"), curves);
    Some(shown(
        "hamiltonian",
        chart,
        "of the discrete costates: constant up to the error of the discretisation",
    ))
}

/// Returns the reason why the chart cannot be drawn; `None` if it can.
pub(super) fn missing(subject: &Subject) -> Option<&'static str> {
    let problem = subject.problem;
    if subject.trajectory().time.len() < 2 {
        return Some("the plan has no steps: the body is already in its end attitude");
    }
    if subject.trajectory().costates.is_empty() {
        return Some("the plan has no costates");
    }
    if problem.is_shaped() {
        return Some(
            "for minimum time or fuel on equal steps, the costates belong to a cost that contains effort",
        );
    }
    let names = problem.actuation.limits().map(|limit| limit.name);
    let mut names: Vec<&str> = names.filter(|_| problem.actuation.wheels.is_some()).collect();
    names.retain(|name| subject.plan.solution.active.iter().any(|active| active.name == *name));
    if !names.is_empty() {
        return Some("a limit of the wheels is active: the plan does not hold the costates of their momenta");
    }
    let turning = problem.environment.frame_rate() != Vector3::zeros();
    if turning && problem.motion == Motion::RigidBody {
        return Some("positions in a turning frame depend on time");
    }
    None
}

/// Returns the Hamiltonian for the costates in the row `row`.
fn value(subject: &Subject, row: usize) -> f64 {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    let node = row + problem.scheme.first_input();
    let dimension = problem.dimension();
    let costates = &trajectory.costates[row * dimension..(row + 1) * dimension];
    let part = |first: usize| Vector3::from_column_slice(&costates[first..first + 3]);
    let attitude = lie::rotation_from_quaternion(&trajectory.quaternion[node]);
    let rate = trajectory.angular_velocity[node];
    let relative = rate - attitude.tr_mul(&problem.environment.frame_rate());
    let inertia = problem.body.inertia.j();
    let (zeta, pi) = (part(dimension - 6), part(dimension - 3));
    // The last node has no row of inputs if inputs are held; the row of the last step is used.
    let row = row.min(trajectory.torque.len() - 1);
    let inputs = trajectory.inputs(row);
    if let Some(wheels) = &problem.actuation.wheels {
        let count = wheels.momentum.len();
        let stored = problem.actuation.torque.output(&trajectory.wheel_momentum[node * count..][..count]);
        let momentum = inertia * rate + stored;
        return zeta.dot(&relative) + pi.dot(&momentum.cross(&rate)) - running_cost(subject, inputs);
    }
    let position = trajectory.position.get(node).copied().unwrap_or_default();
    let pose = Pose { position, attitude };
    let field = problem.environment.wrench(&pose);
    let (torque, moving) = (trajectory.torque[row], dimension == 12);
    let linear = if moving { part(3) } else { Vector3::zeros() };

    // Half a kick converts the recorded costate of the pose to the costate at the node.
    let half = match problem.scheme {
        Scheme::LieVerlet if !problem.switches() => 0.5 * problem.step(),
        Scheme::LieVerlet | Scheme::LieEuler => 0.0,
    };
    let gradient = problem.environment.gradient(&pose);
    let mut slope = gradient.rr.tr_mul(&pi) + gradient.xr.tr_mul(&linear);
    if problem.actuation.torque.frame() == AxisFrame::Reference {
        slope += pi.cross(&torque);
    }
    if problem.actuation.force.as_ref().is_some_and(|force| force.frame() == AxisFrame::Body) {
        slope += attitude.tr_mul(&trajectory.force[row]).cross(&attitude.tr_mul(&linear));
    }
    // If inputs are held over steps, the costates of a free body need no conversion; the steps may
    // have different lengths.
    let zeta = if problem.switches() { zeta } else { zeta + half * slope };
    let mut value = running_cost(subject, inputs)
        + zeta.dot(&relative)
        + pi.dot(&((inertia * rate).cross(&rate) + field.moment + torque));
    if moving {
        let x = part(0) + half * (gradient.xx.tr_mul(&linear) + gradient.rx.tr_mul(&pi));
        value += x.dot(&trajectory.velocity[node]) + linear.dot(&(field.force + trajectory.force[row]));
    }
    value
}

/// Returns the running cost for a row of inputs, in cost units per second.
fn running_cost(subject: &Subject, inputs: &[f64]) -> f64 {
    let actuation = &subject.problem.actuation;
    let weights = match &subject.problem.objective {
        Objective::Time => return 1.0,
        Objective::Fuel(fuel) => return fuel.rate(actuation, inputs),
        Objective::Effort(weights) => weights,
    };
    let force = weights.force(actuation);
    let (forces, torques) = actuation.split_costs(inputs);
    let of_forces = force.map_or(0.0, |force| effort(&force.weight, forces));
    let of_time = weights.time_price.unwrap_or(0.0);
    of_time + of_forces + effort(&weights.torque(actuation).weight, torques)
}
