//! What is taken as the rounding of printed numbers, once for every file that is read.

/// How far the length of a quaternion, or of a row or column of a rotation matrix, may be from 1, and such rows from being orthogonal:
/// three digits were printed. The nearest rotation is taken, with a warning.
pub(crate) const ROTATION: f64 = 1e-3;
/// As much the largest moment of inertia may exceed the sum of the others, relative to itself.
pub(crate) const MOMENT: f64 = ROTATION;
/// What needs no warning: nine digits.
pub(crate) const SILENT: f64 = 1e-9;
