//! The rotations that the ends require, and whether torque, rate and time suffice.
//!
//! The [envelope](super::envelope) bounds every arc k. A maneuver with steps of length h therefore
//! has
//!
//! ```text
//! turn       |log R_0ᵀR_N|                        ≤ Σ min(φ_k, h ω)
//! path of b  from R_0 b to R_N b on the sphere
//!            ≤ Σ min(φ_k, h ω_b, (φ_k/sin φ_k) h min(|Π_k| |S(b)J⁻¹|, v_k |S(b)J^−½|))
//! ```
//!
//! for any body axis b. The second line holds because, without wheels,
//! `h²|Π|² = sin²φ (e·Je)² + 4 sin²(φ/2) |e×Je|² ≥ sin²φ |Je|²`, because `sin φ √(e·Je) ≤ h v`, and
//! because b moves by `|b×e| φ`, where `φ/sin φ` grows with φ. The axes b are the principal axes,
//! and the boresights, which may have to pass around a cone.

use super::Proof;
use super::capability::{Ends, SLACK, fastest, means, motion, standing};
use super::detour::Detour;
use super::envelope::{Arc, Means, Motion, envelope};
use super::words::{about, at_least, at_most, direction, exceeding};
use crate::lie::{self, hat};
use crate::maneuver::constraint::{Direction, Rule, Side};
use crate::maneuver::problem::{Problem, Scheme};
use crate::mechanics::body::principal_moments;
use crate::{Matrix3, Vector3};
use nalgebra::SymmetricEigen;

/// The angle by which a demand must exceed a bound to prove anything \[rad\]: round-off of the
/// sums.
pub(super) const ROUND_OFF: f64 = 1e-9;

/// The largest factor on a limit that is tried as a remedy.
const MUCH: f64 = 100.0;

/// The largest factor on the duration that is tried in the search for a sufficient duration.
const LONG: f64 = 1e6;

/// The largest number of pairs of boresights and cones that are checked.
const MAX_CONES: usize = 1000;

/// A required turn of the body, or a required path of a body axis.
pub(super) struct Demand {
    /// The demand in words: "the body must turn by", …
    pub words: String,
    /// The required angle \[rad\].
    pub angle: f64,
    /// The body axis that must move; `None` for the whole body.
    axis: Option<Lever>,
    /// Largest speed that the rate limits allow [rad/s].
    fastest: f64,
    /// The keep-out cone that lengthens the path of the axis.
    cone: Option<Detour>,
}

/// Factors in the bound on the rate of a body axis b.
struct Lever {
    /// The skew matrix `S(b)` of the axis.
    cross: Matrix3,
    /// Bound on the rate per unit of `|Π|`: `|S(b)J⁻¹|`.
    by_momentum: f64,
    /// Bound on the rate per unit of `√(Π·J⁻¹Π)`: `|S(b)J^−½|`.
    by_speed: f64,
}

/// A problem and its demands, evaluated for different limits and durations.
struct Case<'a> {
    problem: &'a Problem,
    motion: Motion,
    demands: Vec<Demand>,
}

pub(super) fn proof(problem: &Problem) -> Option<Proof> {
    let means = means(problem);
    if problem.constraints.is_empty() && means.torque_is_unlimited() {
        return None;
    }
    let case = Case::new(problem);
    let worst = case.worst(&means, problem.seconds())?;
    Some(case.explain(&means, worst))
}

impl<'a> Case<'a> {
    fn new(problem: &'a Problem) -> Self {
        let ends = Ends::of(problem, problem.seconds());
        Self { problem, motion: motion(problem, &ends), demands: demands(problem, &ends) }
    }

    /// Returns the demand with the largest deficit, and the angle \[rad\] that the limits allow for
    /// it; `None` if all demands can be met.
    fn worst(&self, means: &Means, duration: f64) -> Option<(&Demand, f64)> {
        let no_rate = self.demands.iter().all(|demand| demand.fastest == f64::INFINITY);
        if no_rate && means.torque_is_unlimited() {
            return None;
        }
        let steps = self.problem.steps;
        let step = duration / steps as f64;
        // The sums of Lie–Verlet are never below the integrals of the continuous motion.
        let verlet = envelope(&self.motion, means, Scheme::LieVerlet, steps, duration);
        let euler = (self.problem.scheme == Scheme::LieEuler)
            .then(|| envelope(&self.motion, means, Scheme::LieEuler, steps, duration));
        let allowed = |demand: &Demand| {
            let sum =
                |arcs: &Vec<Arc>| arcs.iter().map(|arc| self.way(demand, means, step, arc)).sum::<f64>();
            euler.iter().map(sum).fold(sum(&verlet), f64::max)
        };
        let missed = self.demands.iter().map(|demand| (demand, allowed(demand)));
        let missed = missed.filter(|(demand, allowed)| demand.angle > allowed + ROUND_OFF);
        // Among equal demands the first is reported, which is the simplest.
        let ratio = |(demand, allowed): &(&Demand, f64)| demand.angle / allowed;
        missed.reduce(|worst, other| if ratio(&other) > ratio(&worst) * (1.0 + 1e-6) { other } else { worst })
    }

    /// Returns the largest angle \[rad\] that the body or body axis of a demand can move along
    /// `arc`, in a step of length `step` \[s\].
    fn way(&self, demand: &Demand, means: &Means, step: f64, arc: &Arc) -> f64 {
        let mut way = arc.turn.min(step * demand.fastest * means.rate_growth);
        if let Some(Lever { by_momentum, by_speed, .. }) = demand.axis {
            let bent = if arc.turn > 0.0 { arc.turn / arc.turn.sin() } else { 1.0 };
            let momentum = if self.motion.wheels.is_some() { f64::INFINITY } else { arc.momentum };
            let by_speed = (arc.speed + arc.share / self.motion.moments[0].sqrt()) * by_speed;
            way = way.min(bent * step * by_speed.min(momentum * by_momentum));
        }
        way
    }

    /// Returns whether every demand can be met.
    fn possible(&self, means: &Means, duration: f64) -> bool {
        self.worst(means, duration).is_none()
    }
}

// ---- the requirements of the ends
// ------------------------------------------------------------------

impl Demand {
    /// Returns the matrix whose product with the angular velocity is the rate of the moving part:
    /// the identity for the whole body, or `S(b)` for a body axis b.
    pub fn of_rate(&self) -> Matrix3 {
        self.axis.as_ref().map_or_else(Matrix3::identity, |lever| lever.cross)
    }
}

pub(super) fn demands(problem: &Problem, ends: &Ends) -> Vec<Demand> {
    let [start, end] = &ends.attitude;
    let angle = lie::minus(end, start).norm();
    let words = "the body must turn by".into();
    let mut demands = vec![Demand { words, angle, axis: None, fastest: fastest(problem, None), cone: None }];
    let of_axis = |axis: &Vector3, angle: f64, words: String, cone: Option<Detour>| {
        let axis_lever = Some(Lever::of(problem, axis));
        Demand { words, angle, axis: axis_lever, fastest: fastest(problem, Some(axis)), cone }
    };
    let principal =
        SymmetricEigen::try_new(problem.body.inertia.j() / problem.body.inertia.mean(), 1e-15, 1000);
    for axis in principal.iter().flat_map(|eigen| eigen.eigenvectors.column_iter()) {
        let axis = axis.normalize();
        let angle = crate::maneuver::constraint::angle_between(&(start * axis), &(end * axis));
        demands.push(of_axis(&axis, angle, format!("the body axis {} must move by", direction(&axis)), None));
    }
    for (boresight, detour) in detours(problem, ends).take(MAX_CONES) {
        let words = format!("a boresight must pass around \"{}\" by", detour.name);
        demands.push(of_axis(&boresight, detour.length(detour.half_angle), words, Some(detour)));
    }
    demands
}

/// Returns each boresight with the detour around each keep-out cone whose axis is fixed in inertial
/// space.
fn detours(problem: &Problem, ends: &Ends) -> impl Iterator<Item = (Vector3, Detour)> {
    let [start, end] = ends.attitude;
    let turning = !standing(problem);
    let cones = problem.constraints.iter().filter_map(|constraint| match &constraint.rule {
        Rule::Pointing(pointing) if pointing.side == Side::KeepOut && pointing.during.given().is_none() => {
            Some((&constraint.name, pointing))
        }
        _ => None,
    });
    cones.flat_map(move |(name, pointing)| {
        let standing = pointing.pairs().filter_map(move |(b, w)| match w {
            Direction::Fixed(vector) => Some((b, vector)),
            Direction::InFrame(vector) => (!turning).then_some((b, vector)),
            Direction::Moving(_) | Direction::Disc { .. } => None,
        });
        standing.map(move |(b, vector)| {
            let half_angle = pointing.effective_half_angle() - SLACK;
            (*b, Detour::new(name, half_angle, vector, &(start * b), &(end * b)))
        })
    })
}

impl Lever {
    fn of(problem: &Problem, axis: &Vector3) -> Self {
        let (cross, j_inverse) = (hat(axis), problem.body.inertia.j_inverse());
        let largest = |square: Matrix3| principal_moments(&square)[2].max(0.0).sqrt();
        let by_momentum = cross * j_inverse;
        Self {
            cross,
            by_momentum: largest(by_momentum * by_momentum.transpose()),
            by_speed: largest(cross * j_inverse * cross.transpose()),
        }
    }
}

// ---- the proof in words
// ----------------------------------------------------------------------------------------

impl Case<'_> {
    fn explain(&self, means: &Means, (demand, allowed): (&Demand, f64)) -> Proof {
        let problem = self.problem;
        let duration = problem.seconds();
        let longer = || least(LONG, |factor| self.possible(means, factor * duration));
        let shortest = standing(problem).then(longer).flatten().map(|factor| factor * duration);
        let under = shortest.map_or_else(
            || format!("no plan takes {} s", about(duration)),
            |shortest| format!("no plan is shorter than {} s", at_least(shortest)),
        );
        let [angle, allow] = exceeding(demand.angle.to_degrees(), allowed.to_degrees());
        let mut reason = format!(
            "{under}{}: {} {angle} deg, and {} s allow at most {allow} deg",
            self.given(means),
            demand.words,
            about(duration),
        );
        let needed = self.needed(means, demand, allowed);
        if !needed.is_empty() {
            reason.push_str(&format!("; a duration of {} s needs {}", about(duration), needed.join(" or ")));
        }
        Proof { reason, duration_lower_bound: shortest }
    }

    /// Returns the given limits in words, such as " with 0.3 N·m at 4 deg/s".
    fn given(&self, means: &Means) -> String {
        let mut text = String::new();
        let torque = &self.problem.actuation.torque;
        if means.torque.is_finite() {
            let together = match (torque.limits().norm, torque.count()) {
                (Some(norm), _) if means.torque >= norm => "",
                (_, 1) => "",
                _ => " at most from all inputs at their limits",
            };
            text.push_str(&format!(" with {} N·m{together}", about(means.torque)));
            if means.field > 0.0 {
                text.push_str(&format!(" and {} N·m of the field", about(means.field)));
            }
        }
        if means.slope.is_finite() {
            text.push_str(&format!(" that change by at most {} N·m/s", about(means.slope)));
        }
        if means.storage.is_finite() {
            text.push_str(&format!(" from wheels that store {} N·m·s", about(means.storage)));
        }
        let rate = fastest(self.problem, None);
        if rate.is_finite() {
            text.push_str(&format!(" at {} deg/s", about(rate.to_degrees())));
        }
        text
    }

    /// Returns the remedies for the given duration in words: each limit that would suffice if it
    /// alone were enlarged.
    fn needed(&self, means: &Means, demand: &Demand, allowed: f64) -> Vec<String> {
        let mut needed = vec![];
        for (name, limit, grow) in GROWN {
            let limit = limit(means);
            let possible = |factor| self.possible(&grow(*means, factor), self.problem.seconds());
            let factor = if limit.is_finite() { least(MUCH, possible) } else { None };
            let Some(factor) = factor else { continue };
            // If only the norm of the torque is limited, the limit is stated in N·m.
            needed.push(if name == TORQUE && self.problem.actuation.torque.limits().size.is_none() {
                format!("at least {} N·m", at_least(factor * limit))
            } else {
                format!("{name} limits at least {} times as large", at_least(factor))
            });
        }
        needed.extend(smaller_cone(demand, allowed));
        needed
    }
}

const TORQUE: &str = "torque";

/// The kinds of limits: name, value, and the bounds with this limit multiplied by a factor.
#[allow(clippy::type_complexity)]
const GROWN: [(&str, fn(&Means) -> f64, fn(Means, f64) -> Means); 4] = [
    (TORQUE, |means| means.torque, |means, factor| Means { torque: factor * means.torque, ..means }),
    ("torque rate", |means| means.slope, |means, factor| Means { slope: factor * means.slope, ..means }),
    (
        "wheel momentum",
        |means| means.storage,
        |means, factor| Means { storage: factor * means.storage, ..means },
    ),
    ("rate", |means| means.rate, |means, factor| Means { rate_growth: factor, ..means }),
];

/// Returns in words the largest half angle of the demand's keep-out cone with which the path of the
/// body axis is at most `allowed` \[rad\] long. Returns `None` if the demand has no cone, or if no
/// half angle suffices.
fn smaller_cone(demand: &Demand, allowed: f64) -> Option<String> {
    let detour = demand.cone.as_ref()?;
    let fits = |half_angle: f64| detour.length(half_angle) <= allowed + ROUND_OFF;
    let (mut fit, mut misfit) = (0.0, detour.half_angle);
    if !fits(fit) {
        return None;
    }
    for _ in 0..40 {
        let middle = 0.5 * (fit + misfit);
        *(if fits(middle) { &mut fit } else { &mut misfit }) = middle;
    }
    Some(format!("a half angle of at most {} deg, margin included", at_most(misfit.to_degrees())))
}

/// Returns the smallest factor above 1 for which `possible` holds, rounded down to six digits.
/// Returns `None` if `possible` does not hold for any tried factor up to `much`.
fn least(much: f64, possible: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut low, mut high) = (1.0, 2.0);
    while !possible(high) {
        (low, high) = (high, 2.0 * high);
        if high > much {
            return None;
        }
    }
    // Six digits suffice, because four are shown.
    while high - low > 1e-6 * low {
        let middle = 0.5 * (low + high);
        *(if possible(middle) { &mut high } else { &mut low }) = middle;
    }
    Some(low)
}
