//! Reason why a search over durations or rolls, which solves a maneuver repeatedly, ends at once.

use crate::maneuver::solution::Solution;
use crate::optimize::search::PlanError;

/// Reason why a repeated search ends early.
pub(super) enum Halt {
    Refused(PlanError),
    /// The solve that was interrupted, or ran out of time.
    Stopped(Box<Solution>),
}

impl From<PlanError> for Halt {
    fn from(error: PlanError) -> Self {
        Self::Refused(error)
    }
}
