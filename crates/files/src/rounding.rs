//! The rounding of printed numbers that all readers accept.

/// The largest deviation from 1 of the length of a quaternion, or of a row or column of a
/// rotation matrix, and of such rows from being orthogonal: three printed digits. The nearest
/// rotation is used, with a warning.
pub(crate) const ROTATION: f64 = 1e-3;
/// The largest relative excess of the largest moment of inertia over the sum of the others.
pub(crate) const MOMENT: f64 = ROTATION;
/// The deviation that needs no warning: nine digits.
pub(crate) const SILENT: f64 = 1e-9;
