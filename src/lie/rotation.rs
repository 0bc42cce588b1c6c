//! A rotation as one value, with composition and differences.
//!
//! # Which functions use a `Rotation`, and which a matrix?
//!
//! Public constructors take a `Rotation`, into which every rotation of nalgebra converts. The
//! solvers use matrices, because they update an attitude as a compensated sum of increments of its
//! nine elements, which is a rotation only to round-off. `State`, `Pose` and derived values
//! therefore hold the matrix, and `lie::minus` is the difference ⊖ of matrices. A matrix converts
//! to a `Rotation` without a check. The check is made later, where its message can name the end of
//! the maneuver or the body (`Problem::check`, `System::check`).

use super::{exp, log, quaternion_from_rotation, rotation_from_quaternion};
use crate::{Matrix3, Vector3};
use nalgebra::{Rotation3, UnitQuaternion};
use std::ops::Mul;
use thiserror::Error;

/// Returns `a ⊖ b = log(bᵀ a)` \[rad\]: the rotation vector from `b` to `a`, with
/// `b exp S(a ⊖ b) = a`, in the body axes of `b`. Its length is the angle between the two
/// rotations, at most π.
pub fn minus(a: &Matrix3, b: &Matrix3) -> Vector3 {
    log(&b.tr_mul(a))
}

/// Returns the Frobenius norm `‖I − RᵀR‖`.
pub(crate) fn orthogonality(rotation: &Matrix3) -> f64 {
    (rotation.tr_mul(rotation) - Matrix3::identity()).norm()
}

/// A rotation `R` ∈ SO(3), an orthogonal matrix of determinant 1. As an attitude it maps body
/// vectors to reference vectors.
///
/// Every constructor of this crate that takes an attitude accepts any type that converts to a
/// `Rotation`: the unit quaternions and rotations of nalgebra, and matrices.
///
/// ```
/// use nalgebra::{Rotation3, UnitQuaternion};
/// use slewkit::{Matrix3, Rotation, State, Vector3};
///
/// let turn = UnitQuaternion::from_euler_angles(0.1, -0.4, 2.0);
/// let from_quaternion = State::attitude(turn, Vector3::new(0.0, 0.0, 0.1));
/// let from_rotation = State::at_rest(Rotation3::from(turn));
/// let from_matrix = State::at_rest(Matrix3::identity());
///
/// let (a, b) = (Rotation::from(from_quaternion.attitude), Rotation::from(from_rotation.attitude));
/// assert!(a.minus(&b).norm() < 1e-15);
/// let way = a.minus(&from_matrix.attitude.into());
/// assert!((way.norm() - turn.angle()).abs() < 1e-15);
/// ```
///
/// A matrix converts to a rotation without a check. Later,
/// [`Problem::check`](crate::maneuver::problem::Problem::check) and
/// [`System::check`](crate::propagate::integrator::System::check) reject a matrix that is not a
/// rotation. [`Rotation::new`] checks the matrix at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    matrix: Matrix3,
}

/// The matrix is not a rotation.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "the matrix is not a rotation: it differs from an orthogonal matrix of determinant 1 by \
    {defect:.1e}"
)]
pub struct NotARotation {
    /// The value of [`Rotation::defect`]; NaN if an element is not finite.
    pub defect: f64,
}

impl Rotation {
    /// The largest accepted defect of a rotation matrix. It also applies to the boundary states of
    /// a maneuver.
    pub const DEFECT: f64 = 1e-12;

    /// Builds a rotation from a matrix, and checks it.
    ///
    /// # Errors
    /// Returns [`NotARotation`] if the defect of the matrix exceeds [`Rotation::DEFECT`].
    pub fn new(matrix: Matrix3) -> Result<Self, NotARotation> {
        let defect = Self { matrix }.defect();
        if defect <= Self::DEFECT { Ok(Self { matrix }) } else { Err(NotARotation { defect }) }
    }

    /// Returns the identity.
    pub fn identity() -> Self {
        Self { matrix: Matrix3::identity() }
    }

    /// Builds the rotation by a rotation vector \[rad\] of any length.
    pub fn exp(vector: &Vector3) -> Self {
        Self { matrix: exp(vector) }
    }

    /// Returns the rotation vector \[rad\], whose length is at most π; see [`log`].
    pub fn log(&self) -> Vector3 {
        log(&self.matrix)
    }

    /// Builds the rotation of a Hamilton quaternion `[w, x, y, z]` of any nonzero length. The zero
    /// quaternion gives NaN.
    pub fn from_quaternion(quaternion: &[f64; 4]) -> Self {
        Self { matrix: rotation_from_quaternion(quaternion) }
    }

    /// Returns the unit quaternion `[w, x, y, z]` whose largest component is positive.
    pub fn quaternion(&self) -> [f64; 4] {
        quaternion_from_rotation(&self.matrix)
    }

    /// Returns the matrix, shape (3, 3).
    pub fn matrix(&self) -> &Matrix3 {
        &self.matrix
    }

    /// Returns the inverse rotation, `R⁻¹ = Rᵀ`.
    pub fn inverse(&self) -> Self {
        Self { matrix: self.matrix.transpose() }
    }

    /// Returns `R ⊖ other = log(otherᵀ R)` \[rad\]: the rotation vector from `other` to this
    /// rotation, in the body axes of the attitude `other`.
    pub fn minus(&self, other: &Self) -> Vector3 {
        minus(&self.matrix, &other.matrix)
    }

    /// Returns the defect of the matrix as a rotation: `‖I − RᵀR‖` (Frobenius), 2 for a
    /// reflection, NaN if a number is not finite.
    pub fn defect(&self) -> f64 {
        let reflects = self.matrix.determinant() < 0.0;
        if reflects { 2.0 } else { orthogonality(&self.matrix) }
    }
}

/// The product of rotations: `other` is applied first, then this rotation.
impl Mul for Rotation {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { matrix: self.matrix * other.matrix }
    }
}

/// Converts a matrix without a check; see [`Rotation`].
impl From<Matrix3> for Rotation {
    fn from(matrix: Matrix3) -> Self {
        Self { matrix }
    }
}

impl From<Rotation3<f64>> for Rotation {
    fn from(rotation: Rotation3<f64>) -> Self {
        Self { matrix: rotation.into_inner() }
    }
}

impl From<UnitQuaternion<f64>> for Rotation {
    fn from(quaternion: UnitQuaternion<f64>) -> Self {
        Self::from_quaternion(&[quaternion.w, quaternion.i, quaternion.j, quaternion.k])
    }
}

impl From<Rotation> for Matrix3 {
    fn from(rotation: Rotation) -> Self {
        rotation.matrix
    }
}

impl From<Rotation> for Rotation3<f64> {
    fn from(rotation: Rotation) -> Self {
        Self::from_matrix_unchecked(rotation.matrix)
    }
}

impl From<Rotation> for UnitQuaternion<f64> {
    fn from(rotation: Rotation) -> Self {
        let [w, x, y, z] = rotation.quaternion();
        Self::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
    }
}
