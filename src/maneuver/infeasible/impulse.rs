//! A required change of momentum and a required distance, for which torque or force and time do
//! not suffice.
//!
//! The kicks of a maneuver have the sum `|R_N Π_N − R_0 Π_0| ≤ T (ū + m̄)` for a body without
//! wheels, and `|γ_N − γ_0| ≤ T F̄` for a body on which only its own forces act. For the latter,
//! with the weights `w_j` of the kicks and `x_{k+1} = x_k + h γ_k/m`,
//!
//! ```text
//! m |x_N − x_0 − T (ẋ_0 + ẋ_N)/2| = h² |Σ w_j (N/2 − j) f_j| ≤ F̄ h² Σ w_j |N/2 − j| = F̄ T²/4
//! ```
//! (`h²F̄/4` more for an odd N), as in continuous time. All sums hold for the discrete maneuver
//! and for the continuous one.

use super::Proof;
use super::capability::{Ends, SLACK, means, standing, strongest};
use super::words::{about, at_least, exceeding};
use crate::Vector3;
use crate::maneuver::problem::{Motion, Problem};

pub(super) fn proof(problem: &Problem) -> Option<Proof> {
    angular(problem).or_else(|| linear(problem))
}

/// Builds the proof that a maneuver with a limit of `limit` is infeasible, in units of `unit`. The
/// same duration would need a limit `factor` times as large. If `needed` \[s\] is given, no shorter
/// plan exists with all other values unchanged. `what` states the missing impulse or distance.
fn missed(
    problem: &Problem,
    limit: f64,
    unit: &str,
    what: String,
    needed: Option<f64>,
    factor: f64,
) -> Proof {
    let duration = about(problem.seconds());
    let under = needed.map_or_else(
        || format!("takes {duration} s"),
        |needed| format!("is shorter than {} s", at_least(needed)),
    );
    let reason = format!(
        "no plan {under} with {} {unit}: {what}; a duration of {duration} s needs at least {} {unit}",
        about(limit),
        exceeding(limit * factor, limit)[0]
    );
    Proof { reason, duration_lower_bound: needed }
}

fn angular(problem: &Problem) -> Option<Proof> {
    let means = means(problem);
    let limit = means.torque + means.field;
    if problem.actuation.wheels.is_some() || !limit.is_finite() {
        return None;
    }
    let ends = Ends::of(problem, problem.seconds());
    let change = if problem.ends_in_any_attitude() {
        // A free end attitude can make both momenta parallel.
        (ends.momentum[1].norm() - ends.momentum[0].norm()).abs()
    } else {
        (ends.spatial_momentum(1) - ends.spatial_momentum(0)).norm()
    };
    let allowed = limit * problem.seconds();
    (change > allowed * (1.0 + SLACK)).then(|| {
        let [needed, possible] = exceeding(change, allowed);
        let what = format!(
            "the angular momentum must change by {needed} N·m·s, and at most {possible} N·m·s are possible"
        );
        let shortest = Some(change / limit).filter(|_| standing(problem));
        missed(problem, limit, "N·m", what, shortest, change / allowed)
    })
}

fn linear(problem: &Problem) -> Option<Proof> {
    let limit = problem.actuation.force.as_ref().map(strongest)? * (1.0 + SLACK);
    let mass = problem.body.mass?;
    if problem.motion != Motion::RigidBody || !problem.environment.is_free() || !limit.is_finite() {
        return None;
    }
    let (start, end, duration) = (&problem.start, &problem.end, problem.seconds());
    let change = mass * (end.velocity - start.velocity).norm();
    let allowed = limit * duration;
    if change > allowed * (1.0 + SLACK) {
        let [needed, possible] = exceeding(change / mass, allowed / mass);
        let what =
            format!("the velocity must change by {needed} m/s, and at most {possible} m/s are possible");
        return Some(missed(problem, limit, "N", what, Some(change / limit), change / allowed));
    }
    let mean = 0.5 * (start.velocity + end.velocity);
    let way = end.position - start.position - duration * mean;
    let sum = problem.steps.pow(2).div_ceil(4) as f64 * problem.step() * problem.step();
    let allowed = limit * sum / mass;
    (way.norm() > allowed * (1.0 + SLACK)).then(|| {
        let drift = if mean == Vector3::zeros() { "" } else { " beyond the mean of the terminal velocities" };
        let [needed, possible] = exceeding(way.norm(), allowed);
        let what = format!("the body must move {needed} m{drift}, and at most {possible} m are possible");
        // From rest to rest the required distance does not depend on the duration.
        let shortest = (mean == Vector3::zeros()).then(|| duration * (way.norm() / allowed).sqrt());
        missed(problem, limit, "N", what, shortest, way.norm() / allowed)
    })
}
