//! Products of vectors and matrices of three rows, written out, for one [`Number`] and for several.
//!
//! The products of nalgebra are function calls unless the compiler inlines them. In the innermost
//! loops such calls take longer than the products, and they do not use the wider registers of
//! [`widest`](super::widest::widest).

use super::eight::Number;

/// A vector of three components of any [`Number`] type.
pub(crate) type Vector<T> = nalgebra::Vector3<T>;
/// A 3×3 matrix of elements of any [`Number`] type.
pub(crate) type Matrix<T> = nalgebra::Matrix3<T>;

/// Returns the product `A v`.
#[inline(always)]
pub(crate) fn apply<T: Number>(a: &Matrix<T>, v: &Vector<T>) -> Vector<T> {
    let row = |i: usize| a[(i, 0)] * v.x + a[(i, 1)] * v.y + a[(i, 2)] * v.z;
    Vector::new(row(0), row(1), row(2))
}

/// Returns the product `Aᵀ v`.
#[inline(always)]
pub(crate) fn apply_transposed<T: Number>(a: &Matrix<T>, v: &Vector<T>) -> Vector<T> {
    let column = |i: usize| a[(0, i)] * v.x + a[(1, i)] * v.y + a[(2, i)] * v.z;
    Vector::new(column(0), column(1), column(2))
}

/// Returns the product `A B`.
#[inline(always)]
pub(crate) fn product<T: Number>(a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    written(|i, j| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)])
}

/// Returns the product `A Bᵀ`.
#[inline(always)]
pub(crate) fn product_transposed<T: Number>(a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    written(|i, j| a[(i, 0)] * b[(j, 0)] + a[(i, 1)] * b[(j, 1)] + a[(i, 2)] * b[(j, 2)])
}

/// Returns the dot product `v·w`.
#[inline(always)]
pub(crate) fn dot<T: Number>(v: &Vector<T>, w: &Vector<T>) -> T {
    v.x * w.x + v.y * w.y + v.z * w.z
}

/// Returns the sum `v + w`.
#[inline(always)]
pub(crate) fn sum<T: Number>(v: &Vector<T>, w: &Vector<T>) -> Vector<T> {
    Vector::new(v.x + w.x, v.y + w.y, v.z + w.z)
}

/// Returns the difference `v − w`.
#[inline(always)]
pub(crate) fn difference<T: Number>(v: &Vector<T>, w: &Vector<T>) -> Vector<T> {
    Vector::new(v.x - w.x, v.y - w.y, v.z - w.z)
}

/// Returns the vector `a v` for a scalar `a`.
#[inline(always)]
pub(crate) fn scaled<T: Number>(a: T, v: &Vector<T>) -> Vector<T> {
    Vector::new(a * v.x, a * v.y, a * v.z)
}

/// Returns the cross product `v×w`.
#[inline(always)]
pub(crate) fn cross<T: Number>(v: &Vector<T>, w: &Vector<T>) -> Vector<T> {
    Vector::new(v.y * w.z - v.z * w.y, v.z * w.x - v.x * w.z, v.x * w.y - v.y * w.x)
}

/// Returns the product `S(v) A`, whose columns are cross products with `v`.
#[inline(always)]
pub(crate) fn crossed<T: Number>(v: &Vector<T>, a: &Matrix<T>) -> Matrix<T> {
    let of = |j: usize| cross(v, &Vector::new(a[(0, j)], a[(1, j)], a[(2, j)]));
    let columns = [of(0), of(1), of(2)];
    written(|i, j| columns[j][i])
}

/// Returns the matrix with the elements `at(i, j)`.
#[inline(always)]
pub(crate) fn written<T: Number>(at: impl Fn(usize, usize) -> T) -> Matrix<T> {
    Matrix::new(at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2), at(2, 0), at(2, 1), at(2, 2))
}

/// Returns the skew matrix `S(v)`.
#[inline(always)]
pub(crate) fn skew<T: Number>(v: &Vector<T>) -> Matrix<T> {
    let none = T::of(0.0);
    Matrix::new(none, -v.z, v.y, v.z, none, -v.x, -v.y, v.x, none)
}

/// Returns a vector that is equal in every lane.
#[inline(always)]
pub(crate) fn splat<T: Number>(v: &Vector<f64>) -> Vector<T> {
    Vector::new(T::of(v.x), T::of(v.y), T::of(v.z))
}

/// Returns a matrix that is equal in every lane.
#[inline(always)]
pub(crate) fn splat_matrix<T: Number>(a: &Matrix<f64>) -> Matrix<T> {
    written(|i, j| T::of(a[(i, j)]))
}
