//! The pointing error of a boresight, from the covariance of the attitude.

use crate::lie::hat;
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The angle of a boresight from its planned direction, of a normal error of the attitude.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Radius {
    /// Standard deviations along the two axes of the ellipse on the sky \[rad\], the larger first.
    pub sigma: [f64; 2],
    /// The angle within which the boresight is with the probability [`Radius::LEVEL`] \[rad\]. Not
    /// `3σ`: that holds in one dimension, and `3.44σ` for a circle.
    pub within: f64,
}

impl Radius {
    /// The probability of three standard deviations of one normal number.
    pub const LEVEL: f64 = 0.9973;

    /// Directions of the sum over a quarter of the circle. The sum is periodic, and its error falls
    /// with the power of their number; thin ellipses need the most.
    const DIRECTIONS: usize = 512;

    /// Bisections to round-off.
    const BISECTIONS: usize = 60;

    /// Returns the pointing error of `boresight`, body axes, for the covariance `P` of `ζ`: the
    /// covariance of `S(b) ζ` is `S(b) P S(b)ᵀ`.
    pub fn of(boresight: &Vector3, covariance: &Matrix3) -> Self {
        let lever = hat(boresight);
        if !covariance.iter().all(|value| value.is_finite()) {
            return Self { sigma: [f64::NAN; 2], within: f64::NAN };
        }
        let eigen = (lever * covariance * lever.transpose()).symmetric_eigenvalues();
        let mut values: Vec<f64> = eigen.iter().map(|value| value.max(0.0).sqrt()).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        let sigma = [values[0], values[1]];
        Self { sigma, within: radius(sigma, Self::LEVEL) }
    }

    /// Returns the angle within which the boresight is with the probability `level`, between 0 and
    /// 1 \[rad\].
    pub fn at(&self, level: f64) -> f64 {
        radius(self.sigma, level)
    }
}

/// Returns the radius within which two independent normal numbers of deviations `sigma` are with
/// probability `level`: `(1/2π) ∫ (1 − exp(−r²/2q(φ))) dφ`, `q = σ₁² cos²φ + σ₂² sin²φ`.
fn radius(sigma: [f64; 2], level: f64) -> f64 {
    if !(sigma[0] > 0.0 && sigma[0].is_finite()) {
        return sigma[0];
    }
    let thin = sigma[1] / sigma[0];
    let inside = |r: f64| {
        let part = |index: usize| {
            let phi = 0.5 * PI * (index as f64 + 0.5) / Radius::DIRECTIONS as f64;
            let q = phi.cos().powi(2) + (thin * phi.sin()).powi(2);
            -(-0.5 * r * r / q).exp_m1()
        };
        (0..Radius::DIRECTIONS).map(part).sum::<f64>() / Radius::DIRECTIONS as f64
    };
    let (mut low, mut high) = (0.0, 8.0);
    for _ in 0..Radius::BISECTIONS {
        let middle = 0.5 * (low + high);
        if inside(middle) < level { low = middle } else { high = middle }
    }
    high * sigma[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cases are one dimension and a circle (`r² = −2 ln(1 − p)`); the reference files have
    /// ellipses in between, by Monte Carlo.
    #[test]
    fn radii_of_a_line_and_of_a_circle_are_those_of_closed_form() {
        let line = radius([2.0, 0.0], Radius::LEVEL);
        assert!((line / 2.0 - 2.999_976_992_703_4).abs() < 3e-4, "{line}");
        let circle = radius([0.5, 0.5], Radius::LEVEL);
        assert!((circle / 0.5 - (-2.0 * (1.0 - Radius::LEVEL).ln()).sqrt()).abs() < 1e-11, "{circle}");
        let of_circle = Radius { sigma: [0.5, 0.5], within: circle };
        assert_eq!(of_circle.at(Radius::LEVEL), circle);
        assert!((of_circle.at(0.5) / 0.5 - (2.0 * 2.0_f64.ln()).sqrt()).abs() < 1e-11);
        assert!(radius([f64::NAN, 0.0], 0.5).is_nan());
        assert_eq!(radius([0.0, 0.0], 0.5), 0.0);
        assert!(Radius::of(&Vector3::x(), &Matrix3::repeat(f64::NAN)).within.is_nan());
    }
}
