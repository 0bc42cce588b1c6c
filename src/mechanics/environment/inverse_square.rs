//! Attraction `−k s/|s|³` by a point, with its derivatives. The formulas hold in any axes.

use crate::{Matrix3, Vector3};

/// The attraction on a point at the position `s` relative to the attracting centre.
pub(super) struct InverseSquare {
    k: f64,
    /// Distance `|s|`.
    pub(super) r: f64,
    /// Unit vector `s/|s|`.
    pub(super) e: Vector3,
}

impl InverseSquare {
    /// Builds the attraction of strength `k` [N·m²] at the position `s` \[m\].
    pub(super) fn new(k: f64, s: &Vector3) -> Self {
        let r = s.norm();
        Self { k, r, e: s / r }
    }

    /// Returns the potential energy `−k/|s|`.
    pub(super) fn potential(&self) -> f64 {
        -self.k / self.r
    }

    /// Returns the force `φ = −k s/|s|³`.
    pub(super) fn force(&self) -> Vector3 {
        -self.k / self.r.powi(2) * self.e
    }

    /// Returns the gradient `K = ∂φ/∂s = −k (I − 3 e eᵀ)/|s|³`.
    pub(super) fn gradient(&self) -> Matrix3 {
        self.k / self.r.powi(3) * (3.0 * self.e * self.e.transpose() - Matrix3::identity())
    }

    /// Returns the contracted second derivative
    /// `L = ∂(Kc)/∂s = 3k [c eᵀ + e cᵀ + (e·c) I − 5 (e·c) e eᵀ]/|s|⁴` for a constant `c`.
    pub(super) fn curvature(&self, c: &Vector3) -> Matrix3 {
        let (e, ec) = (&self.e, self.e.dot(c));
        3.0 * self.k / self.r.powi(4)
            * (symmetric(c, e) + ec * Matrix3::identity() - 5.0 * ec * e * e.transpose())
    }
}

/// Returns the symmetric matrix `a bᵀ + b aᵀ`.
pub(super) fn symmetric(a: &Vector3, b: &Vector3) -> Matrix3 {
    let ab = a * b.transpose();
    ab + ab.transpose()
}
