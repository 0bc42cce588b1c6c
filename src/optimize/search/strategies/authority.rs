//! The authority of the inputs about the axes, and how descents widen it where it is missing or
//! small.
//!
//! # How is the best way found?
//!
//! Where an axis has no input, the weight of inverse dynamics is infinite. Descents then work with
//! a little authority about every axis, lowered in steps, and the lifted Newton ends with the true
//! one. Authority that is taken away only makes a branch dearer: the lowest branch is always
//! followed next, and one that is dearer than a plan found needs no following. Uneven weights (a
//! ratio of more than a hundred) are evened and brought back in the same way, beside descents with
//! the weights as they are, because smooth starts seldom fall into the cheapest of their narrow
//! valleys. Both begin on a rough grid and go on on one twice as fine, hop from the lowest minima
//! to others near them by random bends until that finds none lower for a while, and compare what
//! they know there: on the rough grid costs are wrong by half.

use crate::optimize::discrete::step::Dynamics;

/// Authority about the axes without inputs, from the first descent to the last, relative to that of
/// the others.
pub const WIDENED: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// What is added to uneven authority, from the first descent to the last, in the same unit.
const EVENED: [f64; 4] = [1e-1, 1e-2, 1e-3, 0.0];

/// How the inputs reach the axes.
#[derive(Clone, Copy, PartialEq)]
pub enum Authority {
    Even,
    /// About some much less than about others.
    Uneven,
    /// About some not at all.
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

    /// What is added to it, from the first descent to the last.
    pub fn levels(self) -> &'static [f64] {
        match self {
            Self::Even => &[0.0],
            Self::Uneven => &EVENED,
            Self::Missing => &WIDENED,
        }
    }
}
