//! Numbers with their derivatives with respect to L parameters, and the little linear algebra that one step of a grid takes.

use crate::{Matrix3, Vector3};
use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

/// A number and its gradient.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual<const L: usize> {
    pub value: f64,
    pub gradient: [f64; L],
}

/// A vector of such numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual3<const L: usize>(pub [Dual<L>; 3]);

impl<const L: usize> Dual<L> {
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; L] }
    }

    /// A function of this number whose value and derivative are given.
    #[inline(always)]
    pub fn chain(&self, value: f64, slope: f64) -> Self {
        Self { value, gradient: from_fn(|l| slope * self.gradient[l]) }
    }

    #[inline(always)]
    pub fn recip(&self) -> Self {
        let value = 1.0 / self.value;
        self.chain(value, -value * value)
    }

    #[inline(always)]
    pub fn scale(&self, factor: f64) -> Self {
        self.chain(factor * self.value, factor)
    }
}

impl<const L: usize> Add for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, gradient: from_fn(|l| self.gradient[l] + other.gradient[l]) }
    }
}

impl<const L: usize> Sub for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, gradient: from_fn(|l| self.gradient[l] - other.gradient[l]) }
    }
}

impl<const L: usize> Mul for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // Leibniz.
        let gradient =
            self.chain(0.0, other.value) + Self { value: 0.0, gradient: other.gradient }.scale(self.value);
        Self { value: self.value * other.value, ..gradient }
    }
}

impl<const L: usize> Neg for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.scale(-1.0)
    }
}

impl<const L: usize> Dual3<L> {
    pub fn constant(value: &Vector3) -> Self {
        Self(from_fn(|axis| Dual::constant(value[axis])))
    }

    /// The parameters `first`, `first + 1`, `first + 2`.
    pub fn parameters(value: &Vector3, first: usize) -> Self {
        let mut vector = Self::constant(value);
        for axis in 0..3 {
            vector.0[axis].gradient[first + axis] = 1.0;
        }
        vector
    }

    pub fn value(&self) -> Vector3 {
        Vector3::from_fn(|axis, _| self.0[axis].value)
    }

    /// One column of the derivative.
    pub fn column(&self, lane: usize) -> Vector3 {
        Vector3::from_fn(|axis, _| self.0[axis].gradient[lane])
    }

    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Dual<L> {
        let (a, b) = (&self.0, &other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[inline(always)]
    pub fn cross(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    #[inline(always)]
    pub fn times(&self, factor: &Dual<L>) -> Self {
        Self(from_fn(|axis| self.0[axis] * *factor))
    }

    #[inline(always)]
    pub fn scale(&self, factor: f64) -> Self {
        Self(from_fn(|axis| self.0[axis].scale(factor)))
    }

    /// `A v` for a constant matrix.
    #[inline(always)]
    pub fn under(&self, matrix: &Matrix3) -> Self {
        Self(from_fn(|row| {
            self.0[0].scale(matrix[(row, 0)])
                + self.0[1].scale(matrix[(row, 1)])
                + self.0[2].scale(matrix[(row, 2)])
        }))
    }
}

impl<const L: usize> Add for Dual3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|axis| self.0[axis] + other.0[axis]))
    }
}

impl<const L: usize> Sub for Dual3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|axis| self.0[axis] - other.0[axis]))
    }
}
