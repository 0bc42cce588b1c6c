//! Wheels exchange momentum with the body and keep the total: what they hold in the end is known.
//!
//! Where nothing else turns the body `R(JΩ + μ)`, `μ = Σ a_i h_i`, is conserved, in the discrete maneuver as
//! in the continuous one. The terminal attitude and rate therefore leave one `μ_N` only. It must be one that
//! the momentum limits allow, `|h_i| ≤ L_i`, and one that the torque limits reach, `|h_i − h_i0| ≤ T ū_i`.

use super::Proof;
use super::capability::{Ends, SLACK, isolated};
use super::outputs::Outputs;
use super::words::{at_least, at_most};
use crate::Vector3;
use crate::maneuver::problem::Problem;

pub(super) fn proof(problem: &Problem) -> Option<Proof> {
    let wheels = problem.actuation.wheels.as_ref().filter(|_| isolated(problem))?;
    let torque = &problem.actuation.torque;
    let ends = Ends::of(problem, problem.duration);
    let stored = problem.actuation.stored_momentum();
    let total = ends.attitude[0] * (ends.momentum[0] + stored);
    let end = ends.attitude[1].tr_mul(&total) - ends.momentum[1];

    let limits = wheels.momentum_limit.iter().copied();
    let (factor, direction) = Outputs::new(torque.axes(), limits).shortfall(&end);
    if factor > 1.0 + SLACK {
        return Some(too_much(&end, &direction, factor).into());
    }
    let size = torque.limits().size.as_ref()?;
    let impulse = Outputs::new(torque.axes(), size.iter().map(|limit| limit * problem.duration));
    let (factor, direction) = impulse.shortfall(&(end - stored));
    (factor > 1.0 + SLACK && factor.is_finite()).then(|| {
        let shortest = factor * problem.duration;
        let change = direction.dot(&(end - stored));
        // In a turning frame another duration is another target.
        let standing = problem.environment.frame_rate() == Vector3::zeros();
        let reason = format!(
            "no plan {} with these wheel torques: along the body axis {} the wheels have to take up {} N·m·s, the \
             torques can do {} N·m·s; it takes wheel torque limits at least {} times as large",
            if standing { format!("under {} s", at_least(shortest)) } else { "in that time".into() },
            show(&direction),
            at_least(change),
            at_most(change / factor),
            at_least(factor)
        );
        Proof { reason, duration_lower_bound: standing.then_some(shortest) }
    })
}

fn too_much(end: &Vector3, direction: &Vector3, factor: f64) -> String {
    let needed = direction.dot(end);
    let axis = show(direction);
    if factor.is_finite() {
        format!(
            "the wheels have to hold {} N·m·s along the body axis {axis} at the end, because the total momentum \
             is conserved, and can store {} N·m·s there: it takes wheel momentum limits at least {} times as \
             large",
            at_least(needed),
            at_most(needed / factor),
            at_least(factor)
        )
    } else {
        format!(
            "the wheels have to hold {} N·m·s along the body axis {axis} at the end, because the total momentum \
             is conserved, and no wheel turns about it",
            at_least(needed)
        )
    }
}

fn show(axis: &Vector3) -> String {
    let [x, y, z] = [axis.x, axis.y, axis.z].map(|part| (part * 1e4).round() / 1e4 + 0.0);
    format!("({x}, {y}, {z})")
}
