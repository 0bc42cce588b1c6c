//! Sums of many small increments with compensated round-off.

use nalgebra::SMatrix;

/// A running sum in two doubles per element: the value, and the part that rounding removed.
///
/// A million naive updates lose up to 1e-10 in a steady rotation, where all rounding errors have
/// one sign. This sum loses only the rounding of the increments themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compensated<const R: usize, const C: usize> {
    value: SMatrix<f64, R, C>,
    rest: SMatrix<f64, R, C>,
}

impl<const R: usize, const C: usize> Compensated<R, C> {
    pub(crate) fn new(value: SMatrix<f64, R, C>) -> Self {
        Self { value, rest: SMatrix::zeros() }
    }

    pub(crate) fn value(&self) -> &SMatrix<f64, R, C> {
        &self.value
    }

    /// Adds an increment by Knuth's error-free sum, and then moves the accumulated rest into the
    /// value.
    pub(crate) fn add(&mut self, increment: &SMatrix<f64, R, C>) {
        let sum = self.value + increment;
        let added = sum - self.value;
        self.rest += (self.value - (sum - added)) + (increment - added);
        self.value = sum + self.rest;
        self.rest -= self.value - sum;
    }
}
