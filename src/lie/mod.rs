//! Kernels of the rotation group SO(3).

use crate::{Matrix3, Vector3};

/// Skew matrix `S(a)`, `S(a) b = a × b`.
pub fn hat(a: &Vector3) -> Matrix3 {
    a.cross_matrix()
}
