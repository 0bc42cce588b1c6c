//! A bound on the rate of a body, from the momentum that its wheels can store.
//!
//! If no other torque acts, the total momentum H is conserved, so with wheels along `a_i` that hold
//! `h_i`
//!
//! ```text
//! J Ω = RᵀH − Σ a_i h_i ,    |h_i| ≤ L_i
//! |S(b) Ω| ≤ |S(b) J⁻¹| |H| + max |Σ S(b) J⁻¹ a_i h_i|
//! ```
//!
//! for every body axis b, and likewise for |Ω|. The maximum is attained at a corner of the limits.
//!
//! # Why does this bound not hold for the discrete maneuver?
//!
//! The discrete maneuver limits the momenta at the nodes only. Between two nodes, where the body
//! drifts, half a kick can take a wheel far beyond its limit, and the other half can take it back.

use super::Proof;
use super::capability::{Ends, SLACK, held, isolated, standing};
use super::demand::{Demand, ROUND_OFF, demands};
use super::outputs::Outputs;
use super::words::{about, at_least, exceeding};
use crate::Matrix3;
use crate::maneuver::problem::Problem;

/// Returns a proof that full wheels turn the body too slowly for any continuous motion; `None` if
/// nothing is proved.
pub(crate) fn proof(problem: &Problem) -> Option<Proof> {
    let wheels = problem.actuation.wheels.as_ref().filter(|_| isolated(problem))?;
    let duration = problem.duration.known().filter(|_| !problem.ends_in_any_attitude())?;
    if wheels.momentum_limit.contains(&f64::INFINITY) {
        return None;
    }
    let ends = Ends::of(problem, duration);
    let (total, _) = held(problem, &ends);
    // The angles [rad] by which the body or axis of a demand can move in the duration: from the
    // total momentum, and from the wheels.
    let allowed = |demand: &Demand| {
        let rate_of = demand.of_rate() * problem.body.inertia.j_inverse();
        let axes: Vec<_> = problem.actuation.torque.axes().iter().map(|axis| rate_of * axis).collect();
        let of_wheels = Outputs::new(&axes, wheels.momentum_limit.iter().copied()).largest();
        let carried = if total == 0.0 { 0.0 } else { total * norm(&rate_of) };
        [carried, of_wheels].map(|rate| rate * duration * (1.0 + SLACK))
    };
    let demands = demands(problem, &ends);
    let missed = demands.iter().map(|demand| (demand, allowed(demand)));
    let missed =
        missed.filter(|(demand, [carried, of_wheels])| demand.angle > carried + of_wheels + ROUND_OFF);
    let ratio = |(demand, [carried, of_wheels]): &(&Demand, [f64; 2])| demand.angle / (carried + of_wheels);
    // Among equal demands the first is reported, which is the simplest.
    let worst = |worst, other| if ratio(&other) > ratio(&worst) * (1.0 + 1e-6) { other } else { worst };
    let (demand, [carried, of_wheels]) = missed.reduce(worst)?;
    let shortest = standing(problem).then(|| duration * demand.angle / (carried + of_wheels));
    let under = shortest.map_or_else(
        || format!("no motion takes {} s", about(duration)),
        |shortest| format!("no motion is shorter than {} s", at_least(shortest)),
    );
    let [angle, allow] = exceeding(demand.angle.to_degrees(), (carried + of_wheels).to_degrees());
    let larger = if of_wheels > 0.0 && demand.angle > carried {
        let factor = at_least((demand.angle - carried) / of_wheels);
        format!(
            "; a duration of {} s needs wheel momentum limits at least {factor} times as large",
            about(duration)
        )
    } else {
        String::new()
    };
    let reason = format!(
        "{under}: {} {angle} deg, and full wheels allow at most {allow} deg in {} s{larger}",
        demand.words,
        about(duration),
    );
    Some(Proof { reason, duration_lower_bound: shortest })
}

/// Returns the largest singular value of a matrix.
fn norm(matrix: &Matrix3) -> f64 {
    crate::mechanics::body::principal_moments(&(matrix * matrix.transpose()))[2].max(0.0).sqrt()
}
