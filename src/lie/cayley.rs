//! The Cayley map of SO(3), a chart without square roots or trigonometry.
//!
//! `cay(f) = (I + S(f))(I − S(f))⁻¹ = I + 2 (S(f) + S(f)²)/(1 + |f|²) = exp S(2 atan|f| f/|f|)`

use super::quaternion::shepperd;
use super::skew::skew_polynomial;
use crate::{Matrix3, Vector3};

/// Returns the rotation `cay(f)` with Cayley vector `f = tan(θ/2) axis`.
pub fn cayley(f: &Vector3) -> Matrix3 {
    Matrix3::identity() + cayley_minus_identity(f)
}

/// Returns `cay(f) − I = 2 (S(f) + S(f)²)/(1 + |f|²)`, computed without cancellation.
///
/// A step adds this increment to the attitude. A subtraction of `I` from `cay(f)` would be accurate
/// only relative to 1, not relative to the increment.
#[inline]
pub fn cayley_minus_identity(f: &Vector3) -> Matrix3 {
    let a = 2.0 / (1.0 + f.norm_squared());
    skew_polynomial(a, a, f)
}

/// Returns the Cayley vector of a rotation, the inverse of [`cayley`]: `v/w` of its quaternion.
///
/// It equals `vee(F − Fᵀ)/(1 + tr F)`, which cancels near a half turn. The result is not finite at
/// a half turn.
pub fn cayley_inverse(rotation: &Matrix3) -> Vector3 {
    let [w, x, y, z] = shepperd(rotation);
    Vector3::new(x, y, z) / w
}
