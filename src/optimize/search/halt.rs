//! Reason why a search over durations or rolls, which solves a maneuver repeatedly, ends at once.

use crate::maneuver::solution::Solution;
use crate::optimize::search::PlanError;

/// Reason why a repeated search ends at once.
pub(super) enum Halt {
    Refused(PlanError),
    /// A solve was interrupted or reached the time limit; its solution.
    Stopped(Box<Solution>),
}

impl From<PlanError> for Halt {
    fn from(error: PlanError) -> Self {
        Self::Refused(error)
    }
}
