//! The terminal attitude error of the motion under the recorded torques, and the number of steps
//! that would reach the required accuracy.

use super::Verification;
use crate::maneuver::Problem;
use serde::{Deserialize, Serialize};

/// Default accuracy of the terminal attitude of the continuous motion \[deg\].
pub const DEFAULT_ACCURACY_DEG: f64 = 0.01;

/// The terminal attitude error of the continuous motion under the recorded torques.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Accuracy {
    /// Terminal attitude error \[deg\]; not finite if the witness did not reach the end.
    pub continuous_attitude_deg: f64,
    /// Required accuracy \[deg\]: the continuous tolerance of the spec, or [`DEFAULT_ACCURACY_DEG`]
    /// if the spec has none.
    pub wanted_deg: f64,
    /// Approximate number of steps that reaches the accuracy. `None` if the present number
    /// suffices, or if no allowed number does.
    pub steps: Option<usize>,
}

impl Accuracy {
    /// Factor on the estimated number of steps, because the order is measured only to a few per
    /// cent.
    const RESERVE: f64 = 1.15;

    /// Computes the terminal attitude error of a verified plan, and estimates the number of steps
    /// that would reach the required accuracy. `wanted` \[rad\] is the continuous tolerance, if the
    /// spec gives one.
    ///
    /// The error falls as a power of the step. The exponent is the measured order of convergence,
    /// or the order of the scheme if none was measured. The number of steps is rounded up to two
    /// digits.
    pub fn of(found: &Verification, problem: &Problem, wanted: Option<f64>) -> Self {
        let missed = found.continuous_attitude_rad.to_degrees();
        let wanted_deg = wanted.map_or(DEFAULT_ACCURACY_DEG, f64::to_degrees);
        let scheme = f64::from(problem.scheme.order());
        // A measured order above the order of the scheme is accidental and may not persist on finer
        // grids.
        let order = found.order.unwrap_or(scheme).clamp(0.5 * scheme, scheme);
        let needed = problem.steps as f64 * (missed / wanted_deg).powf(order.recip()) * Self::RESERVE;
        let short = missed > wanted_deg && needed < Problem::MAX_STEPS as f64;
        Self { continuous_attitude_deg: missed, wanted_deg, steps: short.then(|| rounded(needed)) }
    }
}

/// Rounds a number of steps up to two significant digits.
fn rounded(steps: f64) -> usize {
    let unit = 10_f64.powf(steps.log10().floor() - 1.0).max(1.0);
    ((steps / unit).ceil() * unit) as usize
}

#[cfg(test)]
mod tests {
    #[test]
    fn steps_are_rounded_up_to_two_digits() {
        for (steps, expected) in [(7.2, 8), (99.5, 100), (101.0, 110), (1234.0, 1300), (86_401.0, 87_000)] {
            assert_eq!(super::rounded(steps), expected, "{steps}");
        }
    }
}
