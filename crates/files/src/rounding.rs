//! Tolerances for numbers in input files that were rounded when they were printed.

/// Largest deviation of a quaternion, or of a row or column of a rotation matrix, from unit length,
/// and of the rows from orthogonality: rounding to three digits. Within this tolerance the nearest
/// rotation is used, with a warning.
pub(crate) const ROTATION: f64 = 1e-3;
/// Largest relative excess of the largest moment of inertia over the sum of the other two.
pub(crate) const MOMENT: f64 = ROTATION;
/// Deviation up to which no warning is given: rounding to nine digits.
pub(crate) const SILENT: f64 = 1e-9;
