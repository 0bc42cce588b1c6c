//! Compensated sums, which add many small increments without loss of accuracy.

use nalgebra::SMatrix;

/// A compensated sum of vectors.
pub(crate) type Sum3 = Sum<3, 1>;
/// A compensated sum of 3×3 matrices.
pub(crate) type SumMatrix = Sum<3, 3>;

/// A compensated (Kahan) sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sum<const R: usize, const C: usize> {
    /// The sum so far.
    pub value: SMatrix<f64, R, C>,
    /// The compensation: the amount that rounding has added in excess.
    excess: SMatrix<f64, R, C>,
}

impl<const R: usize, const C: usize> Sum<R, C> {
    pub fn new(value: SMatrix<f64, R, C>) -> Self {
        Self { value, excess: SMatrix::zeros() }
    }

    #[inline(always)]
    pub fn add(&mut self, increment: &SMatrix<f64, R, C>) {
        compensated_add(&mut self.value, &mut self.excess, increment);
    }
}

/// Adds `increment` to the sum `value`, to which rounding has so far added `excess` too much
/// (Kahan).
#[inline(always)]
pub(crate) fn compensated_add<const R: usize, const C: usize>(
    value: &mut SMatrix<f64, R, C>,
    excess: &mut SMatrix<f64, R, C>,
    increment: &SMatrix<f64, R, C>,
) {
    let increment = increment - *excess;
    let sum = *value + increment;
    *excess = (sum - *value) - increment;
    *value = sum;
}
