//! The authority of the inputs about the axes, and how descents widen it where it is missing or small.

use crate::optimize::step::Dynamics;

/// Authority about the axes without inputs, from the first descent to the last, relative to that of the others.
pub(super) const WIDENED: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// What is added to uneven authority, from the first descent to the last, in the same unit.
const EVENED: [f64; 4] = [1e-1, 1e-2, 1e-3, 0.0];

/// How the inputs reach the axes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Authority {
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
