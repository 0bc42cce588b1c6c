//! The duration of a maneuver: given, free, or found.

/// The duration `T` of a maneuver.
///
/// The price of time, the cost per second of duration, is part of the
/// [`Objective`](crate::Objective): the cost of a plan includes it even after the duration is
/// found.
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
    /// A given duration `T` \[s\].
    Given(f64),
    /// A free duration that the plan chooses: the minimum time, or the best duration for effort or
    /// fuel if time has a price or the duration has a bound.
    Sought {
        /// The longest allowed duration \[s\]; `None` for no bound. If time has no price, the plan
        /// has the best duration up to this bound.
        at_most: Option<f64>,
    },
    /// A free duration that a plan has found.
    Found {
        /// The duration `T` that was found \[s\].
        duration: f64,
        /// The longest allowed duration \[s\]; `None` for no bound.
        at_most: Option<f64>,
    },
}

impl Duration {
    /// A free duration without a bound.
    pub const SOUGHT: Self = Self::Sought { at_most: None };

    /// Returns the duration `T` \[s\], given or found; `None` while the duration is free.
    pub fn known(self) -> Option<f64> {
        match self {
            Self::Given(duration) | Self::Found { duration, .. } => Some(duration),
            Self::Sought { .. } => None,
        }
    }

    /// Returns the bound \[s\] of a free or found duration; `None` if it has none or was given.
    pub fn at_most(self) -> Option<f64> {
        match self {
            Self::Given(_) => None,
            Self::Sought { at_most } | Self::Found { at_most, .. } => at_most,
        }
    }

    /// Returns this duration with the value `duration` \[s\]: given if it was given, found if it
    /// was free.
    pub(crate) fn lasting(self, duration: f64) -> Self {
        match self {
            Self::Given(_) => Self::Given(duration),
            Self::Sought { at_most } | Self::Found { at_most, .. } => Self::Found { duration, at_most },
        }
    }
}

impl From<f64> for Duration {
    /// Builds a given duration \[s\].
    fn from(duration: f64) -> Self {
        Self::Given(duration)
    }
}
