//! Statistics of many cases: proportions with confidence intervals, quantiles, and sampled
//! covariances compared with the linear prediction.

use crate::optimize::discrete::linear_plan::{Matrix6, Vector6};
use nalgebra::DMatrix;
use statrs::distribution::{Beta, ChiSquared, ContinuousCDF};

/// A proportion of cases, with its 95 % confidence interval (Clopper and Pearson 1934).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Proportion {
    /// The number of cases with the counted property.
    pub count: u64,
    /// The number of all cases, with and without the property.
    pub of: u64,
    /// Lower bound of the confidence interval, as a fraction.
    pub low: f64,
    /// Upper bound of the confidence interval, as a fraction.
    pub high: f64,
}

impl Proportion {
    /// The probability that the confidence interval does not contain the true proportion.
    const OUTSIDE: f64 = 0.05;

    /// Builds the proportion for `count` out of `of` cases.
    pub fn new(count: u64, of: u64) -> Self {
        let (k, n) = (count as f64, of as f64);
        let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        let half = 0.5 * Self::OUTSIDE;
        let low = if count == 0 { 0.0 } else { quantile(k, n - k + 1.0, half) };
        let high = if count >= of { 1.0 } else { quantile(k + 1.0, n - k, 1.0 - half) };
        Self { count, of, low, high }
    }

    /// Returns the proportion as a fraction; NaN if there are no cases.
    pub fn part(&self) -> f64 {
        if self.of == 0 { f64::NAN } else { self.count as f64 / self.of as f64 }
    }
}

/// Returns the quantile `level` of values in ascending order: the smallest value that at least the
/// fraction `level` of the values does not exceed. NaN without values.
pub fn quantile(sorted: &[f64], level: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    let index = (level * sorted.len() as f64).ceil() as usize;
    sorted.get(index.saturating_sub(1).min(last)).copied().unwrap_or(f64::NAN)
}

/// The terminal errors of many cases, compared with the linear prediction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sampled {
    /// Number of cases.
    pub cases: usize,
    /// Mean of the terminal errors `[ζ; δΩ]`, rad and rad/s.
    pub mean: Vector6,
    /// Sample covariance of the terminal errors `[ζ; δΩ]`.
    pub covariance: Matrix6,
    /// Smallest and largest eigenvalue of the sample covariance relative to the linear covariance,
    /// in the directions whose linear covariance is not zero. Both are near 1 if the motion is
    /// nearly linear. `None` if a covariance is not finite or the linear one is zero.
    pub eigenvalues: Option<[f64; 2]>,
    /// The proportion of cases inside the ellipsoid that contains 99.73 % of them according to the
    /// linear covariance.
    pub inside: Proportion,
}

/// The number of cases per block of a sum. Blocks are summed in order, so the result does not
/// depend on the number of threads.
const BLOCK: usize = 1024;

/// Threshold on eigenvalues of the scaled covariance, relative to the largest: directions with
/// smaller eigenvalues count as having no variance.
const FLAT: f64 = 1e-12;

impl Sampled {
    /// Compares the terminal errors `[ζ; δΩ]` of many cases with the predicted covariance `linear`.
    pub fn of(ends: &[Vector6], linear: &Matrix6) -> Self {
        let n = ends.len() as f64;
        let summed = |of: &dyn Fn(&Vector6) -> Matrix6| -> Matrix6 {
            ends.chunks(BLOCK).map(|block| block.iter().map(of).sum::<Matrix6>()).sum()
        };
        let mean: Vector6 =
            ends.chunks(BLOCK).map(|block| block.iter().sum::<Vector6>()).sum::<Vector6>() / n;
        let covariance = summed(&|end| (end - mean) * (end - mean).transpose()) / (n - 1.0).max(1.0);
        if !linear.iter().chain(&covariance).all(|value| value.is_finite()) {
            let inside = Proportion::new(0, ends.len() as u64);
            return Self { cases: ends.len(), mean, covariance, eigenvalues: None, inside };
        }
        // First scale to unit variances, because errors in rad and in rad/s differ in magnitude.
        let scale =
            linear.diagonal().map(|variance| if variance > 0.0 { variance.sqrt().recip() } else { 0.0 });
        let scaled = Matrix6::from_diagonal(&scale) * linear * Matrix6::from_diagonal(&scale);
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let kept: Vec<usize> = (0..6).filter(|index| eigen.eigenvalues[*index] > FLAT * largest).collect();
        let whitened = DMatrix::from_fn(kept.len(), 6, |row, column| {
            eigen.eigenvectors[(column, kept[row])] * scale[column] / eigen.eigenvalues[kept[row]].sqrt()
        });
        let covariance_all = DMatrix::from_column_slice(6, 6, covariance.as_slice());
        let ratios = (!kept.is_empty() && largest > 0.0)
            .then(|| (&whitened * covariance_all * whitened.transpose()).symmetric_eigenvalues());
        let limit = ChiSquared::new(kept.len().max(1) as f64).map_or(f64::NAN, |chi| chi.inverse_cdf(LEVEL));
        let inside = ends
            .iter()
            .filter(|end| {
                (&whitened * DMatrix::from_column_slice(6, 1, end.as_slice())).norm_squared() <= limit
            })
            .count();
        Self {
            cases: ends.len(),
            mean,
            covariance,
            // With few cases some eigenvalues are zero, or negative by round-off.
            eigenvalues: ratios.map(|ratios| [ratios.min().max(0.0), ratios.max()]),
            inside: Proportion::new(inside as u64, ends.len() as u64),
        }
    }

    /// Returns the sample standard deviations of attitude \[rad\] and rate [rad/s], each along the
    /// three body axes.
    pub fn sigma(&self) -> Vector6 {
        // `max` would turn NaN into zero.
        self.covariance.diagonal().map(|variance| if variance < 0.0 { 0.0 } else { variance.sqrt() })
    }
}

/// The probability that the ellipsoid of [`Sampled::inside`] should contain.
const LEVEL: f64 = 0.9973;

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values: 22 of 1000 at 95 % as published (R: binom.test), and closed forms if no
    /// case or all cases count.
    #[test]
    fn intervals_are_those_of_clopper_and_pearson() {
        let none = Proportion::new(0, 100_000);
        assert!((none.high - (1.0 - 0.025_f64.powf(1e-5))).abs() < 1e-9 * none.high && none.low == 0.0);
        let all = Proportion::new(50, 50);
        assert!((all.low - 0.025_f64.powf(1.0 / 50.0)).abs() < 1e-9 && all.high == 1.0);
        // From tests/reference/closed_loop/cl02: 22211 of 100,000 cases.
        let found = Proportion::new(22_211, 100_000);
        assert!((found.low - 0.219_536_818_221_151_04).abs() < 1e-9, "{found:?}");
        assert!((found.high - 0.224_699_308_913_425_82).abs() < 1e-9, "{found:?}");
        assert!(Proportion::new(0, 0).part().is_nan());
    }

    #[test]
    fn what_is_not_finite_ends_and_stays_so() {
        let ends = [Vector6::repeat(f64::NAN), Vector6::zeros()];
        let found = Sampled::of(&ends, &Matrix6::identity());
        assert!(found.sigma().iter().all(|value| value.is_nan()) && found.eigenvalues.is_none());
        assert_eq!(Sampled::of(&[], &Matrix6::identity()).cases, 0);
        assert!(Sampled::of(&ends[1..], &Matrix6::repeat(f64::INFINITY)).eigenvalues.is_none());
    }

    #[test]
    fn quantiles_are_order_statistics() {
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(quantile(&sorted, 0.5), 50.0);
        assert_eq!(quantile(&sorted, 0.9973), 100.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
