//! Every number of the chain that the theory does not give: what goals cost, and the matrix of the
//! second order.

/// What the stated duration costs where time is all that counts.
pub(super) const TIME_PRICE: f64 = 100.0;
/// What a unit of impulse of the dearest input costs where fuel counts: a turn by about a radian
/// takes a few units.
pub(super) const FUEL_PRICE: f64 = 10.0;

/// Proximal term on the multipliers: keeps the matrix regular where rows repeat each other, or a
/// symmetry makes a terminal condition follow from the others, and vanishes from the solution.
pub(crate) const PROXIMAL: f64 = 1e-11;

/// Least curvature that counts, as a part of the curvature of the effort: far above round-off.
pub(crate) const CURVATURE: f64 = 1e-6;
/// A row nearer to its bound than this is met.
pub(crate) const MET: f64 = 1e-9;
/// Elimination takes the cube of the unknowns of each stage; beyond this many operations it is left
/// out.
pub(crate) const MOST_WORK: f64 = 1e11;
