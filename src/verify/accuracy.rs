//! The miss of the motion under the recorded torques, and the number of steps that would suffice.

use super::Verification;
use crate::maneuver::Problem;
use serde::{Deserialize, Serialize};

/// The default accuracy that the continuous motion should have, in degrees.
pub const DEFAULT_ACCURACY_DEG: f64 = 0.01;

/// The miss of the end attitude by the motion under the recorded torques.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Accuracy {
    /// The miss in degrees; not finite if the witness did not reach the end.
    pub continuous_attitude_deg: f64,
    /// The required accuracy in degrees: the continuous tolerance of the spec, else
    /// [`DEFAULT_ACCURACY_DEG`].
    pub wanted_deg: f64,
    /// The approximate number of steps that reaches the accuracy; `None` if the present number
    /// does, or if no number can.
    pub steps: Option<usize>,
}

impl Accuracy {
    /// The factor on the number of steps, because the order is measured to some percent.
    const RESERVE: f64 = 1.15;

    /// Computes the miss of a verified plan; `wanted` \[rad\] is the continuous tolerance, if one
    /// is given.
    ///
    /// Estimates the steps. The miss falls as a power of the step: the measured order of
    /// convergence, or the order of the scheme if none was measured. Steps have two digits.
    pub fn of(found: &Verification, problem: &Problem, wanted: Option<f64>) -> Self {
        let missed = found.continuous_attitude_rad.to_degrees();
        let wanted_deg = wanted.map_or(DEFAULT_ACCURACY_DEG, f64::to_degrees);
        let scheme = f64::from(problem.scheme.order());
        // Beyond the order of the scheme it is luck that need not last.
        let order = found.order.unwrap_or(scheme).clamp(0.5 * scheme, scheme);
        let needed = problem.steps as f64 * (missed / wanted_deg).powf(order.recip()) * Self::RESERVE;
        let short = missed > wanted_deg && needed < Problem::MAX_STEPS as f64;
        Self { continuous_attitude_deg: missed, wanted_deg, steps: short.then(|| rounded(needed)) }
    }
}

/// Returns a number of steps, rounded up to two digits.
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
