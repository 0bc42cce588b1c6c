//! Tolerances for numbers in input files that were rounded when they were printed.

/// Largest deviation from unit length of a quaternion or of a row or column of a rotation matrix,
/// and largest deviation of rows from orthogonality. It corresponds to rounding to three digits.
/// Within it, the nearest rotation is used, with a warning.
pub(crate) const ROTATION: f64 = 1e-3;
/// Largest excess of the largest moment of inertia over the sum of the other two moments, as a
/// fraction of this sum. Larger moments are rejected.
pub(crate) const MOMENT: f64 = ROTATION;
/// Largest deviation for which no warning is given. It corresponds to rounding to nine digits.
pub(crate) const SILENT: f64 = 1e-9;
