//! Every number of the convex iteration that the theory does not give, by what it decides.
//!
//! Costs are of order ten, rotations in radians, residuals and violations relative. What the
//! numbers trade is counted by `cargo run --release -p evidence -- families` (whether a plan under
//! constraints is found, and its cost), and in time by
//! `cargo bench -p benches --bench constrained`.

/// First and largest trust radius \[rad\]; below the smallest nothing moves.
pub(super) const RADIUS: (f64, f64, f64) = (0.7, 2.0, 1e-7);
/// What the radius is multiplied by after a move that kept its promise and was as long as it may
/// be, after one that kept little of it (twice after one that cannot be computed), and what is left of
/// a move that was refused.
pub(super) const WIDENED: f64 = 2.5;
pub(super) const NARROWED: f64 = 0.5;
pub(super) const REFUSED: f64 = 0.3;
/// Share of the promised decrease that makes the radius grow, and below which it shrinks.
pub(super) const GOOD: f64 = 0.7;
pub(super) const POOR: f64 = 0.25;
/// A move is as long as it may be from this part of the radius on.
pub(super) const BOUNDED: f64 = 0.99;
/// Below this share a move is tried once more, with the defects that it ends with made up for.
pub(super) const CORRECTED: f64 = 0.5;

/// Slacks and defects above this, scaled, count as violated, unless the cone solver was asked for
/// less; those below it are not worth words.
pub(super) const VIOLATED: f64 = 1e-6;
/// First and highest price of a unit of defect or violation.
pub(super) const FIRST_PRICE: f64 = 100.0;
pub(super) const DEAREST: f64 = 1e5;
/// A price over what it was where its unit stays violated, and over the multipliers elsewhere.
pub(super) const RAISED: f64 = 5.0;
pub(super) const ABOVE_MULTIPLIERS: f64 = 2.0;
/// A promised decrease below this share of what the violation costs is none.
pub(super) const FUTILE: f64 = 1e-2;

/// The end of the digits may lead to a cost above that of the convex iteration by this part: more
/// is another optimum.
pub(super) const DEARER: f64 = 0.02;
/// Barrier term at which the digits end: the cost is off by it for each row that acts.
pub(super) const LAST_BARRIER: f64 = 1e-14;
/// Unknowns from which the cone solver works on a thread of its own: it looks at nobody while it is
/// made, nor within an iteration. With fewer that is over soon.
pub(super) const LARGE: usize = 20_000;
