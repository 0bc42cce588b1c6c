//! Eight numbers at once, and what they have in common with one.
//!
//! Formulas that are written for a [`Number`] hold for one case as well as for eight cases side by side, each in its lane of
//! the vector registers (see [`widest`](super::widest)). Every lane has the bits that the number alone would have.

use nalgebra::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number, or several that go the same way.
pub(crate) trait Number:
    Scalar
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// This value, in every lane.
    fn of(value: f64) -> Self;

    fn sqrt(self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// Eight numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eight(pub [f64; 8]);

impl Eight {
    /// How many they are.
    pub const LANES: usize = 8;

    #[inline(always)]
    pub fn from_fn(mut of: impl FnMut(usize) -> f64) -> Self {
        let mut eight = [0.0; 8];
        for (lane, slot) in eight.iter_mut().enumerate() {
            *slot = of(lane);
        }
        Self(eight)
    }
}

impl Number for Eight {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self([value; 8])
    }

    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for lane in &mut self.0 {
            *lane = lane.sqrt();
        }
        self
    }
}

impl Add for Eight {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for l in 0..8 {
            self.0[l] += other.0[l];
        }
        self
    }
}

impl Sub for Eight {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for l in 0..8 {
            self.0[l] -= other.0[l];
        }
        self
    }
}

impl Mul for Eight {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for l in 0..8 {
            self.0[l] *= other.0[l];
        }
        self
    }
}

impl Div for Eight {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        for l in 0..8 {
            self.0[l] /= other.0[l];
        }
        self
    }
}

impl Neg for Eight {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for lane in &mut self.0 {
            *lane = -*lane;
        }
        self
    }
}
