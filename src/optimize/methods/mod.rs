//! The methods that improve a candidate, and what drives their iterations.

pub(crate) mod continuation;
pub(crate) mod descent;
pub(crate) mod driver;
pub(crate) mod interior_point;
pub(crate) mod lifted;
pub(crate) mod method;
pub(crate) mod scp;
pub(crate) mod shooting;
pub(crate) mod switching;

/// Part of the decrease that the slope promises which a step of a line search must bring (Armijo).
pub(crate) const ARMIJO: f64 = 1e-4;

/// Part of the decrease that a model promises which a step within its trust region must bring.
pub(crate) const PROMISED: f64 = 0.05;
