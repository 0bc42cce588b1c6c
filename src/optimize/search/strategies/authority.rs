//! Authority of the inputs about the axes, and how descents widen it where it is missing or small.
//!
//! # How is the best homotopy class found?
//!
//! If an axis has no input, the weight of inverse dynamics is infinite. Descents then use a small
//! authority about every axis, which is reduced in steps, and the lifted Newton method ends with
//! the true one. A reduction of the authority only increases the cost of a branch. The lowest
//! branch is therefore always followed next, and a branch that costs more than a plan already found
//! is not followed. Uneven weights (a ratio of more than a hundred) are equalised and restored in
//! the same way, in addition to descents with the given weights, because smooth starts seldom reach
//! the cheapest of their narrow valleys. Both begin on a rough grid and continue on one that is
//! twice as fine. They hop from the lowest minima to others near them by random bends until that
//! finds no lower one for some time, and then compare the minima: on the rough grid costs are wrong
//! by up to half.

use crate::optimize::discrete::step::Dynamics;

/// Authorities about the axes without inputs, from the first descent to the last, relative to the
/// authority about the other axes.
pub const WIDENED: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// Authorities added to uneven ones, from the first descent to the last, relative to the mean
/// authority.
const EVENED: [f64; 4] = [1e-1, 1e-2, 1e-3, 0.0];

/// Distribution of the control authority over the axes.
#[derive(Clone, Copy, PartialEq)]
pub enum Authority {
    Even,
    /// Authority that is much smaller about some axes than about others.
    Uneven,
    /// Authority that is zero about some axes.
    Missing,
}

impl Authority {
    pub fn of(dynamics: &Dynamics) -> Self {
        if !dynamics.has_all_axes() {
            Self::Missing
        } else if dynamics.is_stiff() {
            Self::Uneven
        } else {
            Self::Even
        }
    }

    /// Returns the authorities that are added, from the first descent to the last.
    pub fn levels(self) -> &'static [f64] {
        match self {
            Self::Even => &[0.0],
            Self::Uneven => &EVENED,
            Self::Missing => &WIDENED,
        }
    }
}
