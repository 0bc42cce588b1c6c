//! The time that a maneuver takes: given, sought, or found.

/// The time `T` that a maneuver takes.
///
/// What a second costs beside effort or fuel stands in the [`Objective`](crate::Objective): a price belongs to what is
/// minimised, and the cost of a plan still has it when the duration is found.
///
/// ```
/// use slewkit::Duration;
///
/// assert_eq!(Duration::from(60.0), Duration::Given(60.0));
/// assert_eq!(Duration::Given(60.0).known(), Some(60.0));
/// assert_eq!(Duration::SOUGHT.known(), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Duration {
    /// `T` \[s\].
    Given(f64),
    /// The plan's to choose: the least of minimum time, or the best for effort or fuel where a second has a price or the
    /// duration a bound.
    Sought {
        /// The longest duration \[s\]: where nothing prices a second, the best one up to it is sought.
        at_most: Option<f64>,
    },
    /// One that was sought, of a plan that has found it.
    Found {
        /// `T` \[s\].
        duration: f64,
        /// The longest duration \[s\] that was allowed.
        at_most: Option<f64>,
    },
}

impl Duration {
    /// The plan's to choose, without a bound.
    pub const SOUGHT: Self = Self::Sought { at_most: None };

    /// `T` \[s\], given or found; `None` while it is sought.
    pub fn known(self) -> Option<f64> {
        match self {
            Self::Given(duration) | Self::Found { duration, .. } => Some(duration),
            Self::Sought { .. } => None,
        }
    }

    /// The longest duration \[s\] of one that is the plan's to choose, where it has a bound.
    pub fn at_most(self) -> Option<f64> {
        match self {
            Self::Given(_) => None,
            Self::Sought { at_most } | Self::Found { at_most, .. } => at_most,
        }
    }

    /// One of `duration` \[s\]: given where it was given, found where it was sought.
    pub(crate) fn lasting(self, duration: f64) -> Self {
        match self {
            Self::Given(_) => Self::Given(duration),
            Self::Sought { at_most } | Self::Found { at_most, .. } => Self::Found { duration, at_most },
        }
    }
}

impl From<f64> for Duration {
    /// A given duration \[s\].
    fn from(duration: f64) -> Self {
        Self::Given(duration)
    }
}
