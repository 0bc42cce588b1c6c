//! Exponential, logarithm and the trivialised derivatives of the exponential.

use super::kernels::{a, b, b_prime, c, c_prime, g, g_prime};
use super::quaternion::shepperd;
use super::skew::{hat, skew_polynomial};
use crate::{Matrix3, Vector3};

/// Returns the rotation by the vector `f` \[rad\]: `exp S(f) = I + A S(f) + B S(f)²`.
pub fn exp(f: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    Matrix3::identity() + skew_polynomial(a(t2), b(t2), f)
}

/// Returns `exp S(f) − I`, computed without cancellation: the increment of an attitude by a small
/// rotation.
pub fn exp_minus_identity(f: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    skew_polynomial(a(t2), b(t2), f)
}

/// Returns the rotation vector \[rad\] of a rotation, `|f| ≤ π`, the inverse of [`exp`].
///
/// The quaternion is computed with the largest pivot (Shepperd), and `f = 2 atan2(|v|, w) v/|v|`.
/// The usual formula `θ/(2 sin θ) (R − Rᵀ)` loses every digit near π. At π, to round-off, `f` and
/// `−f` are the same rotation; the function returns the vector whose first nonzero component is
/// positive.
pub fn log(rotation: &Matrix3) -> Vector3 {
    let [w, x, y, z] = shepperd(rotation);
    let v = Vector3::new(x, y, z);
    let norm = v.norm();
    // atan(s)/s = 1 − s²/3 rounds to 1; the norm itself may have underflowed.
    if norm < 1e-9 {
        return v * (2.0 / w);
    }
    // For a half turn the sign is chosen: w and the zero components are a few ulps of either sign.
    let round_off = 4.0 * f64::EPSILON * norm;
    let negative = if w.abs() <= round_off {
        v.iter().find(|component| component.abs() > round_off).is_some_and(|first| *first < 0.0)
    } else {
        w < 0.0
    };
    let angle = 2.0 * norm.atan2(w.abs());
    v * (if negative { -angle } else { angle } / norm)
}

/// Returns the right Jacobian `J_r(f) = I − B S(f) + C S(f)²`.
///
/// `exp S(f + δ) ≈ exp S(f) exp S(J_r δ)`; the body velocity of `exp S(f(t))` is `J_r(f) ḟ`.
pub fn right_jacobian(f: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    Matrix3::identity() + skew_polynomial(-b(t2), c(t2), f)
}

/// Returns the inverse right Jacobian `J_r⁻¹(f) = I + ½ S(f) + g S(f)²`, the derivative of [`log`]
/// at `exp S(f)`.
///
/// The matrix is singular at `|f| = 2π`.
pub fn right_jacobian_inverse(f: &Vector3) -> Matrix3 {
    Matrix3::identity() + skew_polynomial(0.5, g(f.norm_squared()), f)
}

/// Returns the left Jacobian `J_l(f) = J_r(−f) = exp(S(f)) J_r(f)`.
///
/// `exp S(f + δ) ≈ exp S(J_l δ) exp S(f)`.
pub fn left_jacobian(f: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    Matrix3::identity() + skew_polynomial(b(t2), c(t2), f)
}

/// Returns the inverse left Jacobian `J_l⁻¹(f) = I − ½ S(f) + g S(f)²`. It is singular at
/// `|f| = 2π`.
pub fn left_jacobian_inverse(f: &Vector3) -> Matrix3 {
    Matrix3::identity() + skew_polynomial(-0.5, g(f.norm_squared()), f)
}

/// Returns the derivative `D(f, v)` of `J_r(f) v` with respect to `f`, for a constant `v`.
///
/// `D = B S(v) − 2B' (f×v) fᵀ + 2C' (f×(f×v)) fᵀ + C [(f·v) I + f vᵀ − 2 v fᵀ]`
pub fn right_jacobian_directional(f: &Vector3, v: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    let fv = f.cross(v);
    let along_f = 2.0 * (c_prime(t2) * f.cross(&fv) - b_prime(t2) * fv);
    let c = c(t2);
    b(t2) * hat(v)
        + (along_f - 2.0 * c * v) * f.transpose()
        + c * (f * v.transpose())
        + c * f.dot(v) * Matrix3::identity()
}

/// Returns the derivative of `J_l⁻¹(f) v = J_r⁻ᵀ(f) v` with respect to `f`, for a constant `v`.
///
/// `½ S(v) + g [(f·v) I + f vᵀ − 2 v fᵀ] + 2g' (f×(f×v)) fᵀ`
pub fn left_jacobian_inverse_directional(f: &Vector3, v: &Vector3) -> Matrix3 {
    let t2 = f.norm_squared();
    let g = g(t2);
    let along_f = f.cross(&f.cross(v)) * (2.0 * g_prime(t2)) - v * (2.0 * g);
    0.5 * hat(v) + along_f * f.transpose() + g * (f * v.transpose()) + g * f.dot(v) * Matrix3::identity()
}
