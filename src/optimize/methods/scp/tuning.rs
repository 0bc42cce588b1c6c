//! Constants of the convex iteration that the theory does not determine.
//!
//! Costs are of order ten, rotations in radians, residuals and violations relative. Their effect is
//! measured by `cargo run --release -p evidence -- families` (whether a plan under constraints is
//! found, and its cost), and in time by `cargo bench -p benches --bench constrained`.

/// Initial, largest and smallest trust radius \[rad\]; below the smallest the iteration stalls.
pub(super) const RADIUS: (f64, f64, f64) = (0.7, 2.0, 1e-7);
/// Factor on the trust radius after a move whose length equals the radius and whose ratio of actual
/// to predicted decrease is good.
pub(super) const WIDENED: f64 = 2.5;
/// Factor on the trust radius after a move with a poor ratio of actual to predicted decrease. It is
/// applied twice if the subproblem fails.
pub(super) const NARROWED: f64 = 0.5;
/// Ratio of the trust radius after a rejected move to the length of that move.
pub(super) const REFUSED: f64 = 0.3;
/// Ratio of actual to predicted decrease from which on the trust radius grows after a move that it
/// limits.
pub(super) const GOOD: f64 = 0.7;
/// Ratio of actual to predicted decrease below which the trust radius shrinks.
pub(super) const POOR: f64 = 0.25;
/// A move of at least this fraction of the trust radius counts as limited by the trust region.
pub(super) const BOUNDED: f64 = 0.99;
/// Ratio of actual to predicted decrease below which a move gets a second-order correction.
pub(super) const CORRECTED: f64 = 0.5;

/// Scaled threshold above which slacks and defects count as violated, unless the cone solver has a
/// larger tolerance. Smaller violations are not reported.
pub(super) const VIOLATED: f64 = 1e-6;
/// Initial penalty per unit of defect or violation.
pub(super) const FIRST_PRICE: f64 = 100.0;
/// Largest penalty per unit of defect or violation.
pub(super) const DEAREST: f64 = 1e5;
/// Factor on the penalty of a quantity that remains violated.
pub(super) const RAISED: f64 = 5.0;
/// Ratio of the penalty of a quantity that is not violated to its multiplier.
pub(super) const ABOVE_MULTIPLIERS: f64 = 2.0;
/// Predicted decrease, as a fraction of the penalised violation, that counts as zero.
pub(super) const FUTILE: f64 = 1e-2;

/// Largest relative increase of the cost when the interior-point method refines the result of the
/// convex iteration. A larger increase means that it found a different optimum.
pub(super) const DEARER: f64 = 0.02;
/// Final barrier parameter of the refinement: the cost error is this value for each active row.
pub(super) const LAST_BARRIER: f64 = 1e-14;
/// Smallest number of unknowns at which the cone solver runs on a separate thread. The solver
/// cannot be stopped during its setup nor within an iteration; for smaller problems these are
/// short.
pub(super) const LARGE: usize = 20_000;
