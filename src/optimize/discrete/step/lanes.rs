//! Sensitivity blocks of three rows, with one vector lane per column.
//!
//! A 3×L block stored by rows, so that a 3×3 matrix acts on all L columns with the same scalar
//! coefficients: the compiler puts the columns into the lanes of its vector registers.

use crate::Matrix3;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// A 3×L block of columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rows<const L: usize>(pub [[f64; L]; 3]);

impl<const L: usize> Rows<L> {
    /// Returns a block of zeros.
    pub fn zero() -> Self {
        Self([[0.0; L]; 3])
    }

    /// Returns rows `offset … offset+2` of the L×L identity.
    pub fn identity_at(offset: usize) -> Self {
        let mut rows = Self::zero();
        for (i, row) in rows.0.iter_mut().enumerate() {
            row[offset + i] = 1.0;
        }
        rows
    }
}

impl<const L: usize> Mul<&Rows<L>> for &Matrix3 {
    type Output = Rows<L>;
    #[inline(always)]
    fn mul(self, rows: &Rows<L>) -> Rows<L> {
        let [x, y, z] = &rows.0;
        let mut out = Rows::zero();
        for (i, row) in out.0.iter_mut().enumerate() {
            let (a, b, c) = (self[(i, 0)], self[(i, 1)], self[(i, 2)]);
            for l in 0..L {
                row[l] = a * x[l] + b * y[l] + c * z[l];
            }
        }
        out
    }
}

impl<const L: usize> Mul<Rows<L>> for f64 {
    type Output = Rows<L>;
    #[inline(always)]
    fn mul(self, mut rows: Rows<L>) -> Rows<L> {
        rows.0.iter_mut().flatten().for_each(|value| *value *= self);
        rows
    }
}

impl<const L: usize> AddAssign for Rows<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for (row, increment) in self.0.iter_mut().zip(&other.0) {
            for l in 0..L {
                row[l] += increment[l];
            }
        }
    }
}

impl<const L: usize> SubAssign for Rows<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for (row, decrement) in self.0.iter_mut().zip(&other.0) {
            for l in 0..L {
                row[l] -= decrement[l];
            }
        }
    }
}

impl<const L: usize> Add for Rows<L> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const L: usize> Sub for Rows<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self -= other;
        self
    }
}
