//! What can be said of a motion of which only attitudes and rates are known.
//!
//! Ends, duration, cones and rates can be judged at the rows and half way between them; inputs, cost and optimality
//! are not there to be judged. Half way the body is taken to have turned about one axis at one rate.

use super::Check;
use crate::maneuver::Problem;
use crate::{Vector3, lie};

/// What was found.
#[derive(Clone, Debug)]
pub struct AttitudeReport {
    /// Ends and duration; errors in rad and rad/s, of the duration relative.
    pub checks: Vec<Check>,
    /// Constraints that are violated, each in words with the time at which it is first.
    pub violations: Vec<String>,
    /// The largest mean torque between two rows that the motion of a free body without wheels needs \[N·m\]; `None`
    /// for others and without rates.
    pub peak_torque_n_m: Option<f64>,
}

impl AttitudeReport {
    /// Whether nothing speaks against it.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed) && self.violations.is_empty()
    }
}

/// How far the duration may be off, relative: times are printed to a nanosecond by many.
const DURATION: f64 = 1e-6;
/// A rate may be off by what turns the body by the tolerance in this share of the duration.
const RATE_SHARE: f64 = 0.01;

/// Judges rows of times from zero \[s\], quaternions `[w, x, y, z]` of length 1 and, if there are any, angular
/// velocities against the reference frame in body axes [rad/s]. `tolerance` \[rad\] is for the attitudes at the ends.
///
/// The arrays are of equal length, of two rows at least.
pub fn judge_attitudes(
    problem: &Problem,
    time: &[f64],
    quaternion: &[[f64; 4]],
    rate: &[Vector3],
    tolerance: f64,
) -> AttitudeReport {
    let frame_rate = problem.environment.frame_rate();
    let attitude = |k: usize| lie::rotation_from_quaternion(&quaternion[k]);
    // Inertial, as the conventions of the crate have it.
    let inertial = |k: usize| rate.get(k).map(|rate| rate + attitude(k).tr_mul(&frame_rate));
    let last = time.len() - 1;
    let check = |name: &str, value: f64, limit: f64| Check {
        name: name.into(),
        value,
        limit,
        passed: value <= limit,
    };
    let off = (time[last] - problem.duration).abs() / problem.duration;
    let mut checks = vec![check("duration", off, DURATION)];
    for (name, k, end) in [("start", 0, &problem.start), ("end", last, &problem.end)] {
        let angle = lie::minus(&attitude(k), &end.attitude).norm();
        checks.push(check(&format!("attitude at the {name}"), angle, tolerance));
        if let Some(rate) = inertial(k) {
            let limit = tolerance / (RATE_SHARE * problem.duration);
            checks.push(check(&format!("rate at the {name}"), (rate - end.angular_velocity).norm(), limit));
        }
    }
    let mut violations: Vec<String> = Vec::new();
    for constraint in &problem.constraints {
        let nodes = (0..=last).map(|k| (time[k], attitude(k), inertial(k)));
        let halves = (0..last).map(|k| {
            let (a, b) = (attitude(k), attitude(k + 1));
            let middle = a * lie::exp(&(0.5 * lie::minus(&b, &a)));
            let rate = inertial(k).zip(inertial(k + 1)).map(|(a, b)| 0.5 * (a + b));
            (0.5 * (time[k] + time[k + 1]), middle, rate)
        });
        // Without rates a limit of the rate is not judged: at rest none is violated.
        let mut found: Vec<(f64, String)> = nodes
            .chain(halves)
            .filter_map(|(time, attitude, rate)| {
                let text = constraint.violation(&attitude, &rate.unwrap_or_default(), time, &frame_rate)?;
                Some((time, text))
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((time, text)) = found.first() {
            let (count, name) = (found.len(), &constraint.name);
            violations.push(format!(
                "{name}: {text} at {time:.4} s, and so at {count} of {} moments",
                2 * last + 1
            ));
        }
    }
    let alone = problem.environment.is_free() && problem.actuation.wheels.is_none();
    let peak_torque_n_m = (alone && !rate.is_empty()).then(|| {
        let momentum = |k: usize| attitude(k) * (problem.body.inertia.j() * rate[k]);
        let mean = |k: usize| (momentum(k + 1) - momentum(k)).norm() / (time[k + 1] - time[k]);
        (0..last).map(mean).fold(0.0, f64::max)
    });
    AttitudeReport { checks, violations, peak_torque_n_m }
}
