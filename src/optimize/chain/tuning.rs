//! Constants of the chain that the theory does not determine: scales of the objectives, and
//! thresholds of the second-order test.

/// Scaled cost of the problem's duration in a minimum-time problem.
pub(super) const TIME_PRICE: f64 = 100.0;
/// Scaled cost of a unit of impulse of the most expensive input in a minimum-fuel problem. A turn
/// through about a radian takes a few units of impulse.
pub(super) const FUEL_PRICE: f64 = 10.0;

/// Proximal term on the multipliers. It keeps the matrix nonsingular if rows are linearly
/// dependent, or if a symmetry makes a terminal condition redundant, and it does not change the
/// solution.
pub(crate) const PROXIMAL: f64 = 1e-11;

/// Smallest curvature that counts as nonzero, relative to the curvature of the effort. It is far
/// above round-off.
pub(crate) const CURVATURE: f64 = 1e-6;
/// Distance of a row's value from its bound below which the row counts as active, relative to the
/// limit.
pub(crate) const MET: f64 = 1e-9;
/// Largest number of operations of the second-order test, which grows as the cube of the number of
/// unknowns per stage. Above it the test is omitted.
pub(crate) const MOST_WORK: f64 = 1e11;
