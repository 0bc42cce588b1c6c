//! Eight numbers at once, and what they have in common with one.
//!
//! Formulas that are written for a [`Number`] hold for one case as well as for eight cases side by side, each in its lane of
//! the vector registers (see [`widest`](super::widest)). Every lane has the bits that the number alone would have.
//!
//! # How do sweeps of minimum time become fast without unsafe code?
//!
//! The motion itself has too little equal work: three rows. But every interval of a smoothed extremal begins at its own node,
//! so eight of them are integrated side by side (`numerics/eight`; the formulas are written for a `Number`, which is one or
//! eight). Then their lanes go from node to node, one interval after the other. Two things had to be avoided, each of which
//! took back what was gained: a store to one lane of a row that is then loaded whole waits for the store, so a single lane is
//! changed by a product with a row of the identity; and a compiler that knows where such a row has its zeros takes it apart
//! into narrow pieces, so it is not told. With nodes that differ by rational vectors instead of logarithms the median case of
//! the public set takes half the time.
//!
//! Derivatives are two thirds of a sweep, and half of all sweeps end an iteration or are steps that were too long: the gaps
//! come first, and the lanes only of a path that Newton goes on from. A law on the grid is solved for in every step from the
//! costate at its end, which the nodes know nearly; and an ε that the grid cannot follow is left after a dozen iterations.
//!
//! # Eight maneuvers at once
//!
//! A trial swept eight maneuvers side by side ahead of their searches, which took each sweep that was foretold for the same
//! bits of the costate and made the others themselves. Of the instructions of a bare plan on 100 steps sweeps without
//! sensitivities are 38 %, those with them 17 %, the steps of the discrete witness 13 % (`valgrind --tool=callgrind` on
//! `throughput 200 100 1 bare`): by these shares lanes may gain. Nearly all sweeps were foretold, and yet a plan took longer
//! than alone. Sweeps without sensitivities gained much, those with them lost: alone their columns fill the registers
//! already, and eight maneuvers seldom ask for a fresh `Ψ₁₂` in the same iteration, so that most lanes went along for
//! nothing. To foretell what a search will sweep, Newton and the extrapolation are run once more for each maneuver, and what
//! the lanes hold is taken apart for each: more work than the lanes had saved. Nodes of eight maneuvers are much memory,
//! which every group asked of the system anew.
//!
//! What is left to try is the plain sweeps alone, on buffers that are kept, with a planner that hands over its sweeps itself
//! instead of being foretold. It would change little of a default plan, where descents and witnesses take the time.

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
