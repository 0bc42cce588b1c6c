//! The pointing error of a boresight, from the covariance of the attitude.

use crate::lie::hat;
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;

/// The angle of a boresight from its planned direction, for a normally distributed attitude error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Radius {
    /// Standard deviations along the two axes of the error ellipse on the sky \[rad\], the larger
    /// first.
    pub sigma: [f64; 2],
    /// Angle \[rad\] within which the boresight lies with the probability [`Radius::LEVEL`]. This
    /// is `3σ` in one dimension only; for a circular error it is `3.44σ`.
    pub within: f64,
}

impl Radius {
    /// The probability that a normally distributed number lies within three standard deviations.
    pub const LEVEL: f64 = 0.9973;

    /// Number of directions of the quadrature over a quarter of the circle. The integrand is
    /// periodic, so the error falls exponentially with this number; thin ellipses need the most
    /// directions.
    const DIRECTIONS: usize = 512;

    /// Number of bisections, enough to reach round-off.
    const BISECTIONS: usize = 60;

    /// Returns the pointing error of `boresight` (body axes) for the covariance `P` of the attitude
    /// error `ζ`: the covariance of `S(b) ζ` is `S(b) P S(b)ᵀ`.
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

    /// Returns the angle \[rad\] within which the boresight lies with the probability `level`,
    /// between 0 and 1.
    pub fn at(&self, level: f64) -> f64 {
        radius(self.sigma, level)
    }
}

/// Returns the radius of the circle that contains two independent normal numbers of deviations
/// `sigma` with probability `level`: `(1/2π) ∫ (1 − exp(−r²/2q(φ))) dφ`,
/// `q = σ₁² cos²φ + σ₂² sin²φ`.
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

    /// Tests an error in one dimension, and a circular error, for which `r² = −2 ln(1 − p)`. The
    /// reference files have ellipses between these cases, by Monte Carlo.
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
