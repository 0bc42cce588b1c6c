//! The part of the limits that a plan leaves to corrections and errors in flight.

use super::constraint::{Constraint, Pointing, Rule};
use crate::Vector3;
use crate::mechanics::actuators::{ActuatorSet, Limits};

/// The difference between the limits of the craft and the limits that the plan keeps, in SI
/// units. Cones have a margin instead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reserve {
    /// The reserve of each torque input [N·m]; empty for no reserve.
    pub torque: Vec<f64>,
    /// The reserve of the norm of the torque [N·m].
    pub torque_norm: f64,
    /// The reserve of the rate of each torque input [N·m/s]; empty for no reserve.
    pub torque_rate: Vec<f64>,
    /// The reserves of limits of the angular velocity \[rad/s\], by the name of the constraint: one
    /// number for the norm, three for the components.
    pub rates: Vec<(String, Vec<f64>)>,
}

impl Reserve {
    /// Returns the reserve of the angular-velocity constraint `name`; empty for no reserve.
    pub fn rate(&self, name: &str) -> &[f64] {
        self.rates.iter().find(|(of, _)| of == name).map_or(&[], |(_, reserve)| reserve)
    }

    /// Returns the torque set with the full limits of the craft: its own limits plus the reserve.
    pub(super) fn given_back(&self, set: &ActuatorSet) -> ActuatorSet {
        let Limits { size, norm, rate, .. } = set.limits();
        let limits = Limits {
            size: size.as_ref().map(|sizes| sums(sizes, &self.torque)),
            norm: norm.map(|norm| norm + self.torque_norm),
            rate: rate.as_ref().map(|rates| sums(rates, &self.torque_rate)),
            ..set.limits().clone()
        };
        set.clone().with_limits(limits).unwrap_or_else(|_| set.clone())
    }

    /// Restores the full limit of the craft: adds the reserve to a rate limit, and removes the
    /// margin of a cone.
    pub(super) fn give_back(&self, constraint: &mut Constraint) {
        let held = self.rate(&constraint.name);
        match &mut constraint.rule {
            Rule::Pointing(pointing) => *pointing = Pointing { margin: 0.0, ..pointing.clone() },
            Rule::RateNorm(limit) => *limit += held.first().unwrap_or(&0.0),
            Rule::RateAxes(limits) if held.len() == 3 => *limits += Vector3::from_column_slice(held),
            Rule::RateAxes(_) => {}
        }
    }
}

/// Adds the reserve to each number, if a reserve exists.
fn sums(numbers: &[f64], held: &[f64]) -> Vec<f64> {
    let held = held.iter().copied().chain(std::iter::repeat(0.0));
    numbers.iter().zip(held).map(|(number, held)| number + held).collect()
}

/// Splits a limit `whole`, of which about `held` is reserved, into the part that the plan keeps
/// and the exact reserve. Sum and difference of the two have no rounding, so files may hold any
/// two of the three numbers.
pub fn split(whole: f64, held: f64) -> (f64, f64) {
    // The difference of two numbers within a factor of two is exact (Sterbenz).
    if held <= 0.5 * whole {
        let kept = whole - held;
        (kept, whole - kept)
    } else {
        (whole - held, held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn what_is_kept_and_what_is_held_make_the_limit_to_the_last_bit() {
        let mut random = Random(5);
        for _ in 0..10_000 {
            let (whole, part) = (2.0 + random.uniform(), 0.5 + 0.5 * random.uniform());
            let (kept, held) = split(whole, whole * part);
            assert!(kept + held == whole && whole - held == kept, "{whole:e} {part:e}");
            assert!((held - whole * part).abs() <= f64::EPSILON * whole);
        }
        assert_eq!(split(2.0, 0.0), (2.0, 0.0));
    }
}
