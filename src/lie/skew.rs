//! Skew matrices and their polynomials.

use crate::{Matrix3, Vector3};

/// Returns the skew matrix `S(a)`, with `S(a) b = a × b`.
pub fn hat(a: &Vector3) -> Matrix3 {
    a.cross_matrix()
}

/// Returns the vector of the skew part of a matrix, the inverse of [`hat`]:
/// `½ [m₃₂ − m₂₃, m₁₃ − m₃₁, m₂₁ − m₁₂]`.
pub fn vee(m: &Matrix3) -> Vector3 {
    0.5 * twice_vee(m)
}

/// Returns `vee(M − Mᵀ)`, twice the vector of the skew part.
pub(super) fn twice_vee(m: &Matrix3) -> Vector3 {
    Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
}

/// Returns `a S(f) + b S(f)²`, without the subtraction in `S(f)² = f fᵀ − |f|² I`.
#[inline]
pub(crate) fn skew_polynomial(a: f64, b: f64, f: &Vector3) -> Matrix3 {
    let (x, y, z) = (f.x, f.y, f.z);
    let (bxy, bxz, byz) = (b * x * y, b * x * z, b * y * z);
    let (ax, ay, az) = (a * x, a * y, a * z);
    #[rustfmt::skip]
    let polynomial = Matrix3::new(
        -b * (y * y + z * z), bxy - az,             bxz + ay,
        bxy + az,             -b * (x * x + z * z), byz - ax,
        bxz - ay,             byz + ax,             -b * (x * x + y * y),
    );
    polynomial
}
