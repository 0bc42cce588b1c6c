//! Products of three rows, written out.
//!
//! The products of nalgebra are calls of their own where the compiler does not inline them. In the innermost loops they
//! then take longer than what they compute, and stay narrow under [`widest`](super::widest::widest).

use crate::{Matrix3, Vector3};

/// `A v`.
#[inline(always)]
pub(crate) fn apply(a: &Matrix3, v: &Vector3) -> Vector3 {
    let row = |i: usize| a[(i, 0)] * v.x + a[(i, 1)] * v.y + a[(i, 2)] * v.z;
    Vector3::new(row(0), row(1), row(2))
}

/// `Aᵀ v`.
#[inline(always)]
pub(crate) fn apply_transposed(a: &Matrix3, v: &Vector3) -> Vector3 {
    let column = |i: usize| a[(0, i)] * v.x + a[(1, i)] * v.y + a[(2, i)] * v.z;
    Vector3::new(column(0), column(1), column(2))
}

/// `A B`.
#[inline(always)]
pub(crate) fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    let at = |i: usize, j: usize| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)];
    written(at)
}

/// `v×w`.
#[inline(always)]
pub(crate) fn cross(v: &Vector3, w: &Vector3) -> Vector3 {
    Vector3::new(v.y * w.z - v.z * w.y, v.z * w.x - v.x * w.z, v.x * w.y - v.y * w.x)
}

/// `S(v) A`.
#[inline(always)]
pub(crate) fn crossed(v: &Vector3, a: &Matrix3) -> Matrix3 {
    let of = |j: usize| cross(v, &Vector3::new(a[(0, j)], a[(1, j)], a[(2, j)]));
    let columns = [of(0), of(1), of(2)];
    written(|i, j| columns[j][i])
}

/// The matrix of these entries.
#[inline(always)]
pub(crate) fn written(at: impl Fn(usize, usize) -> f64) -> Matrix3 {
    Matrix3::new(at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2), at(2, 0), at(2, 1), at(2, 2))
}
