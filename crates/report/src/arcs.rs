//! The arcs of minimum-time and minimum-fuel plans, and the state of the inputs on each arc.

use super::Subject;
use crate::draw::Span;
use slewkit::maneuver::Objective;
use slewkit::maneuver::switching::{Switching, SwitchingArc};

/// Largest distance of an input from its limit, or from zero, at which it counts as being at the
/// limit or off, as a fraction of the limit.
const AT_LIMIT: f64 = 0.01;

/// Returns the arcs of a bang-bang plan: the arcs of the continuous extremal or, for a smoothed
/// control law, runs of consecutive steps on which the inputs are in the same state.
pub(super) fn arcs(subject: &Subject) -> Vec<Span> {
    let Some(switching) = &subject.plan.solution.switching else { return Vec::new() };
    let kind = |inputs: &[f64]| kind(subject, switching, inputs);
    if !switching.arcs.is_empty() {
        let arcs = switching.arcs.iter();
        let span = |arc: &SwitchingArc| {
            let label = match arc.change.iter().any(|change| *change != 0.0) {
                true => "ramp",
                false if !arc.change.is_empty() => "bang",
                false if arc.holds.is_empty() => kind(&arc.input),
                false => "along a limit",
            };
            Span { from: arc.start_s, to: arc.end_s, label: label.into() }
        };
        return arcs.map(span).collect();
    }
    let trajectory = subject.trajectory();
    let mut spans: Vec<Span> = Vec::new();
    for (step, ends) in trajectory.time.windows(2).enumerate().take(trajectory.torque.len()) {
        let label = kind(trajectory.inputs(step));
        match spans.last_mut() {
            Some(last) if last.label == label => last.to = ends[1],
            _ => spans.push(Span { from: ends[0], to: ends[1], label: label.into() }),
        }
    }
    spans
}

/// Classifies the inputs on an arc. Returns "coast" if all inputs are off, "singular" if a singular
/// input lies strictly between its limits, and "bang" in all other cases. A torque at its norm
/// limit counts as "bang", even if its direction changes.
fn kind(subject: &Subject, switching: &Switching, inputs: &[f64]) -> &'static str {
    let set = &subject.problem.actuation.torque;
    let limits = set.limits();
    let parts: Vec<f64> = match (&limits.size, limits.norm) {
        (Some(sizes), _) => inputs.iter().zip(sizes).map(|(input, size)| (input / size).abs()).collect(),
        (None, _) if inputs.is_empty() => vec![1.0],
        (None, norm) => vec![set.output(inputs).norm() / norm.unwrap_or(f64::INFINITY)],
    };
    let may_be_off = subject.problem.objective != Objective::Time || limits.one_sided;
    let off = |part: f64| may_be_off && part < AT_LIMIT;
    let within = |input: &usize| parts.get(*input).is_some_and(|part| !off(*part) && *part < 1.0 - AT_LIMIT);
    if parts.iter().all(|part| off(*part)) {
        "coast"
    } else if switching.singular_inputs.iter().any(within) {
        "singular"
    } else {
        "bang"
    }
}
