//! Numbers with their derivatives with respect to L parameters, and the little linear algebra that one step of a grid takes.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are calls of their own, and narrow in widened code"
)]

use crate::{Matrix3, Vector3};
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
    #[inline(always)]
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; L] }
    }

    /// A function of this number whose value and derivative are given.
    #[inline(always)]
    pub fn chain(&self, value: f64, slope: f64) -> Self {
        let mut gradient = self.gradient;
        for slot in &mut gradient {
            *slot *= slope;
        }
        Self { value, gradient }
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
        let mut gradient = self.gradient;
        for l in 0..L {
            gradient[l] += other.gradient[l];
        }
        Self { value: self.value + other.value, gradient }
    }
}

impl<const L: usize> Sub for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let mut gradient = self.gradient;
        for l in 0..L {
            gradient[l] -= other.gradient[l];
        }
        Self { value: self.value - other.value, gradient }
    }
}

impl<const L: usize> Mul for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut gradient = [0.0; L];
        for l in 0..L {
            gradient[l] = other.value * self.gradient[l] + self.value * other.gradient[l];
        }
        Self { value: self.value * other.value, gradient }
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
    #[inline(always)]
    pub fn constant(value: &Vector3) -> Self {
        Self([Dual::constant(value.x), Dual::constant(value.y), Dual::constant(value.z)])
    }

    /// The parameters `first`, `first + 1`, `first + 2`.
    #[inline(always)]
    pub fn parameters(value: &Vector3, first: usize) -> Self {
        let mut vector = Self::constant(value);
        for axis in 0..3 {
            vector.0[axis].gradient[first + axis] = 1.0;
        }
        vector
    }

    #[inline(always)]
    pub fn value(&self) -> Vector3 {
        Vector3::new(self.0[0].value, self.0[1].value, self.0[2].value)
    }

    /// This gradient with another value.
    #[inline(always)]
    pub fn with_value(mut self, value: &Vector3) -> Self {
        for (axis, part) in self.0.iter_mut().enumerate() {
            part.value = value[axis];
        }
        self
    }

    /// One column of the derivative.
    #[inline(always)]
    pub fn column(&self, lane: usize) -> Vector3 {
        Vector3::new(self.0[0].gradient[lane], self.0[1].gradient[lane], self.0[2].gradient[lane])
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
        let [x, y, z] = self.0;
        Self([x * *factor, y * *factor, z * *factor])
    }

    #[inline(always)]
    pub fn scale(&self, factor: f64) -> Self {
        let [x, y, z] = &self.0;
        Self([x.scale(factor), y.scale(factor), z.scale(factor)])
    }

    /// `A v` for a constant matrix.
    #[inline(always)]
    pub fn under(&self, matrix: &Matrix3) -> Self {
        let [x, y, z] = &self.0;
        let mut out = [Dual::constant(0.0); 3];
        for (row, sum) in out.iter_mut().enumerate() {
            let (a, b, c) = (matrix[(row, 0)], matrix[(row, 1)], matrix[(row, 2)]);
            sum.value = a * x.value + b * y.value + c * z.value;
            for l in 0..L {
                sum.gradient[l] = a * x.gradient[l] + b * y.gradient[l] + c * z.gradient[l];
            }
        }
        Self(out)
    }
}

impl<const L: usize> Add for Dual3<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }
}

impl<const L: usize> Sub for Dual3<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }
}
