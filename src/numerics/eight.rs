//! Eight numbers at once, with the operations of one number.
//!
//! A formula that is written for a [`Number`] computes either one case, or eight cases side by
//! side, each in its lane of the vector registers (see [`widest`](super::widest)). Every lane has
//! the same bits as a computation with one number.
//!
//! # How do sweeps of minimum time become fast without unsafe code?
//!
//! The motion itself has only three equal rows, too few for lanes. But every interval of a smoothed
//! extremal begins at its own node, so eight intervals are integrated side by side
//! (`numerics/eight`; the formulas use a `Number`, which is one number or eight). Then their lanes
//! pass from node to node, one interval after the other. Two effects had to be avoided, each of
//! which removed the gain. A store to one lane of a row that is then loaded as a whole delays the
//! load, so a single lane is changed by a product with a row of the identity. A compiler that knows
//! the zeros of such a row splits it into narrow pieces, so the zeros are hidden from the compiler.
//! The median case of the public set takes half the time if the differences of nodes are rational
//! vectors instead of logarithms.
//!
//! Derivatives take two thirds of a sweep, and half of all sweeps end an iteration or are rejected
//! steps. The gaps are therefore computed first, and the derivatives in lanes only for a path from
//! which Newton continues. The control law on the grid is solved in every step from the costate at
//! its end, which the nodes know approximately. If the grid cannot follow an ε, this ε is abandoned
//! after a dozen iterations.
//!
//! # Eight maneuvers at once
//!
//! An experiment swept eight maneuvers side by side before their searches. A search used each
//! predicted sweep whose costate had the same bits, and computed the other sweeps itself. The
//! instructions of a bare plan on 100 steps are 38 % sweeps without sensitivities, 17 % sweeps with
//! sensitivities, and 13 % steps of the discrete witness (`valgrind --tool=callgrind` on
//! `throughput 200 100 1 bare`), so lanes could gain. Nearly all sweeps were predicted, and yet a
//! plan took longer than alone. Sweeps without sensitivities gained much, but sweeps with
//! sensitivities lost. The columns of one sweep already fill the registers, and eight maneuvers
//! seldom need a new `Ψ₁₂` in the same iteration, so most lanes computed unused values. The
//! prediction repeats Newton and the extrapolation for each maneuver, and the lanes must be
//! separated for each maneuver: more work than the lanes saved. The nodes of eight maneuvers need
//! much memory, which every group requested from the system again.
//!
//! A remaining option is to use lanes for plain sweeps only, on buffers that are kept, with a
//! planner that supplies its sweeps itself. It would change little for a default plan, where
//! descents and witnesses take the time.

use nalgebra::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number, or several numbers on which the same operations are performed.
pub(crate) trait Number:
    Scalar
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Returns the number with this value in every lane.
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

/// Eight numbers, one for each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eight(pub [f64; 8]);

impl Eight {
    /// The number of lanes.
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
