//! The share of the effort in the cost of time and fuel, which alone leave choices.

/// Share of the effort in the cost while plans are compared, and the least one for the plan that is told.
pub(super) const SHARE: f64 = 1e-2;
pub(super) const LAST_SHARE: f64 = 1e-6;
/// How a share is lowered: by the first factor where that goes, or else by the square root of what failed, down to the last.
pub(super) const LOWERED: (f64, f64) = (0.1, 0.5);
/// Shares with which the requested grid is reached, the next where the one before finds nothing there.
pub(super) const FIRST_SHARES: [f64; 3] = [SHARE, 1e-1, 1.0];
/// The same where effort is counted from the inputs of a plan, which it holds together.
pub(super) const FOLLOWED: f64 = 1.0;
/// By what the share of the effort is raised where a plan of time or fuel does not settle for a shifted target.
pub(super) const EASED: f64 = 0.1;
/// Accuracy of the subproblems: multipliers tell which inputs are off, the less clearly the smaller the share.
pub(super) const SHARP: f64 = 1e-9;
