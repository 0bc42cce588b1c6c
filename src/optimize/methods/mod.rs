//! Methods that improve a candidate solution, and the driver of their iterations.

pub(crate) mod continuation;
pub(crate) mod descent;
pub(crate) mod driver;
pub(crate) mod interior_point;
pub(crate) mod lifted;
pub(crate) mod method;
pub(crate) mod scp;
pub(crate) mod shooting;
pub(crate) mod switching;

/// Armijo constant: the fraction of the decrease predicted by the directional derivative that a
/// line-search step must achieve.
pub(crate) const ARMIJO: f64 = 1e-4;

/// Fraction of the decrease predicted by the model that a trust-region step must achieve.
pub(crate) const PROMISED: f64 = 0.05;
