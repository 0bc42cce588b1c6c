//! Momenta of wheels at the end. Wheels exchange momentum with the body and conserve the total, so
//! their momentum at the end is known.
//!
//! If no other torque acts on the body, `R(JΩ + μ)`, `μ = Σ a_i h_i`, is conserved, in the
//! discrete maneuver and in the continuous one. The terminal attitude and rate therefore
//! determine `μ_N`. The momentum limits must allow it, `|h_i| ≤ L_i`, and the torque limits must
//! reach it, `|h_i − h_i0| ≤ T ū_i`.

use super::Proof;
use super::capability::{Ends, SLACK, held, isolated, standing};
use super::outputs::Outputs;
use super::words::{at_least, direction, exceeding};
use crate::Vector3;
use crate::maneuver::problem::Problem;

pub(super) fn proof(problem: &Problem) -> Option<Proof> {
    problem.actuation.wheels.as_ref().filter(|_| isolated(problem))?;
    if let Some(proof) = storable(problem) {
        return Some(proof);
    }
    let torque = &problem.actuation.torque;
    let (_, [stored, end]) = held(problem, &Ends::of(problem, problem.seconds()));
    let size = torque.limits().size.as_ref()?;
    let impulse = Outputs::new(torque.axes(), size.iter().map(|limit| limit * problem.seconds()));
    let (factor, axis) = impulse.shortfall(&(end - stored));
    (factor > 1.0 + SLACK && factor.is_finite()).then(|| {
        let shortest = Some(factor * problem.seconds()).filter(|_| standing(problem));
        let change = axis.dot(&(end - stored));
        let under = shortest.map_or_else(
            || "takes that time".into(),
            |shortest| format!("is shorter than {} s", at_least(shortest)),
        );
        let [needed, possible] = exceeding(change, change / factor);
        let reason = format!(
            "no plan {under} with these wheel torques: along the body axis {} the wheels must \
            absorb {needed} N·m·s, and their torques allow {possible} N·m·s; wheel torque limits \
            must be at least {} times as large",
            direction(&axis),
            at_least(factor)
        );
        Proof { reason, duration_lower_bound: shortest }
    })
}

/// Returns the proof that the wheels cannot store the momentum that they must have at the end, for
/// any duration.
pub(super) fn storable(problem: &Problem) -> Option<Proof> {
    let wheels = problem.actuation.wheels.as_ref().filter(|_| isolated(problem))?;
    let limits = wheels.momentum_limit.iter().copied();
    let outputs = Outputs::new(problem.actuation.torque.axes(), limits);
    if problem.ends_in_any_attitude() {
        return in_any_attitude(problem, &outputs);
    }
    // If the reference frame turns, the terminal attitude depends on the duration.
    let duration = problem.duration.known().or_else(|| standing(problem).then_some(0.0))?;
    let (_, [_, end]) = held(problem, &Ends::of(problem, duration));
    let (factor, axis) = outputs.shortfall(&end);
    (factor > 1.0 + SLACK).then(|| too_much(&end, &axis, factor).into())
}

/// Returns the proof that the wheels cannot store enough momentum for a maneuver that may end in
/// any attitude, from `|μ| = |RᵀH − JΩ| ≥ ||H| − |JΩ||`.
fn in_any_attitude(problem: &Problem, outputs: &Outputs) -> Option<Proof> {
    let j = problem.body.inertia.j();
    let total = (j * problem.start.angular_velocity + problem.actuation.stored_momentum()).norm();
    let least = (total - (j * problem.end.angular_velocity).norm()).abs();
    let most = outputs.largest();
    (least > most * (1.0 + SLACK)).then(|| {
        let [needed, possible] = exceeding(least, most);
        let reason = format!(
            "the wheels must hold {needed} N·m·s at the end in any attitude, because the total momentum is \
            conserved, and can store {possible} N·m·s at most: wheel momentum limits must be at least {} \
            times as large",
            at_least(least / most)
        );
        reason.into()
    })
}

fn too_much(end: &Vector3, axis: &Vector3, factor: f64) -> String {
    let [needed, possible] = exceeding(axis.dot(end), axis.dot(end) / factor);
    let lacking = if factor.is_finite() {
        format!(
            "can store {possible} N·m·s there: wheel momentum limits must be at least {} times as large",
            at_least(factor)
        )
    } else {
        "no wheel turns about it".into()
    };
    format!(
        "the wheels must hold {needed} N·m·s along the body axis {} at the end, because the total \
        momentum is conserved, and {lacking}",
        direction(axis)
    )
}
