//! The rigid body: mass, inertia, and the nonstandard inertia `J_d`. The constructor checks the
//! inertia.

use crate::{Matrix3, Vector3};
use thiserror::Error;

/// Inertia of a rigid body about its reference point, body axes.
///
/// Holds `J`, the nonstandard inertia `J_d = ½ tr(J) I − J` of the variational integrators, and
/// the inverse `J⁻¹`.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertia {
    j: Matrix3,
    j_d: Matrix3,
    j_inverse: Matrix3,
    principal: Vector3,
}

/// The reason why a matrix is not an inertia.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InertiaError {
    /// An element is NaN or infinite.
    #[error("inertia has an element that is not finite")]
    NotFinite,
    /// The matrix is not symmetric within round-off.
    #[error("inertia is not symmetric: ({row},{column}) is {upper}, ({column},{row}) is {lower}")]
    NotSymmetric {
        /// Row of the element, from 1.
        row: usize,
        /// Column of the element, from 1.
        column: usize,
        /// Value at (row, column) [kg·m²].
        upper: f64,
        /// Value at (column, row) [kg·m²].
        lower: f64,
    },
    /// A principal moment is zero or negative.
    #[error("inertia is not positive definite: smallest principal moment {smallest}")]
    NotPositive {
        /// The smallest principal moment [kg·m²].
        smallest: f64,
    },
    /// No mass distribution has these principal moments: the largest exceeds the sum of the other
    /// two.
    #[error("principal moments {0}, {1}, {2} break the triangle inequality", principal[0], principal[1], principal[2])]
    Triangle {
        /// The principal moments, ascending [kg·m²].
        principal: [f64; 3],
    },
    /// The principal moments differ by more than a factor of 1e8.
    #[error("principal moments differ by a factor of {ratio:.1e}: it must be at most 1e8")]
    IllConditioned {
        /// Ratio of the largest to the smallest principal moment.
        ratio: f64,
    },
}

impl Inertia {
    /// Largest relative asymmetry that counts as round-off; it is removed by averaging.
    pub const ASYMMETRY: f64 = 1e-8;
    /// Largest accepted ratio of the principal moments.
    pub const CONDITION: f64 = 1e8;
    /// Relative tolerance on the triangle inequality: for a flat plate both sides are equal.
    pub const TRIANGLE_SLACK: f64 = 1e-9;

    /// Builds the inertia from `j` [kg·m²], which must be finite, symmetric and positive definite,
    /// and satisfy the triangle inequality.
    ///
    /// # Errors
    /// Returns an [`InertiaError`] with the numbers that violate the condition.
    pub fn new(j: Matrix3) -> Result<Self, InertiaError> {
        if !j.iter().all(|value| value.is_finite()) {
            return Err(InertiaError::NotFinite);
        }
        let size = j.amax();
        for row in 0..3 {
            for column in row + 1..3 {
                let (upper, lower) = (j[(row, column)], j[(column, row)]);
                if (upper - lower).abs() > Self::ASYMMETRY * size {
                    return Err(InertiaError::NotSymmetric {
                        row: row + 1,
                        column: column + 1,
                        upper,
                        lower,
                    });
                }
            }
        }
        let j = 0.5 * (j + j.transpose());
        let principal = principal_moments(&j);
        let [smallest, middle, largest] = [principal[0], principal[1], principal[2]];
        if smallest <= 0.0 || smallest <= 1e-15 * largest {
            return Err(InertiaError::NotPositive { smallest });
        }
        if largest > (smallest + middle) * (1.0 + Self::TRIANGLE_SLACK) {
            return Err(InertiaError::Triangle { principal: [smallest, middle, largest] });
        }
        if largest > Self::CONDITION * smallest {
            return Err(InertiaError::IllConditioned { ratio: largest / smallest });
        }
        let j_d = 0.5 * j.trace() * Matrix3::identity() - j;
        // The matrix is scaled first: the determinant of a very large or small inertia would
        // overflow or underflow.
        let j_inverse = (j / largest).try_inverse().ok_or(InertiaError::NotPositive { smallest })? / largest;
        Ok(Self { j, j_d, j_inverse, principal })
    }

    /// Builds an inertia, as [`Inertia::new`] does, from moments that are printed with few digits.
    /// If the largest principal moment exceeds the sum of the others by at most its fraction
    /// `rounding`, it is reduced to the sum, as for a flat plate. Also returns the relative
    /// reduction, or zero.
    ///
    /// # Errors
    /// Returns the errors of [`Inertia::new`].
    pub fn of_rounded(j: Matrix3, rounding: f64) -> Result<(Self, f64), InertiaError> {
        match Self::new(j) {
            Err(InertiaError::Triangle { principal: [a, b, c] }) if c - (a + b) <= rounding * c => {
                let (_, axes) = principal_axes(&(0.5 * (j + j.transpose())));
                let plate = axes * Matrix3::from_diagonal(&Vector3::new(a, b, a + b)) * axes.transpose();
                // If the body axes are principal axes, zeros and the other moments do not change.
                let plate =
                    Matrix3::from_fn(
                        |row, column| if j[(row, column)] == 0.0 { 0.0 } else { plate[(row, column)] },
                    );
                Ok((Self::new(plate)?, (c - (a + b)) / c))
            }
            other => Ok((other?, 0.0)),
        }
    }

    /// Builds a diagonal inertia from its moments [kg·m²].
    ///
    /// # Errors
    /// Returns the errors of [`Inertia::new`].
    pub fn diagonal(moments: Vector3) -> Result<Self, InertiaError> {
        Self::new(Matrix3::from_diagonal(&moments))
    }

    /// Returns the inertia `J` [kg·m²], 3×3, symmetric.
    pub fn j(&self) -> &Matrix3 {
        &self.j
    }

    /// Returns the nonstandard inertia `J_d = ½ tr(J) I − J` [kg·m²], 3×3.
    pub fn j_d(&self) -> &Matrix3 {
        &self.j_d
    }

    /// Returns `J⁻¹` [1/(kg·m²)], 3×3.
    pub fn j_inverse(&self) -> &Matrix3 {
        &self.j_inverse
    }

    /// Returns the principal moments, ascending [kg·m²].
    pub fn principal(&self) -> &Vector3 {
        &self.principal
    }

    /// Returns the axis of the smallest principal moment: a unit vector in body axes, of either
    /// sign.
    pub(crate) fn least_axis(&self) -> Vector3 {
        principal_axes(&self.j).1.column(0).into_owned()
    }

    /// Returns the mean principal moment `tr(J)/3` [kg·m²], the unit of inertia inside the solvers.
    pub fn mean(&self) -> f64 {
        self.j.trace() / 3.0
    }

    /// Returns the nutation rate \[rad/s\] of a body that hardly turns while its wheels hold the
    /// momentum `stored`, body axes: `h/√(J₁J₂)` for a momentum h about the third principal axis.
    pub fn nutation(&self, stored: &Vector3) -> f64 {
        // Ω̇ = J⁻¹(μ × Ω) has the eigenvalues 0 and ±i √(μᵀJμ/det J).
        let [first, second, third] = [self.principal[0], self.principal[1], self.principal[2]];
        (stored.dot(&(self.j * stored)) / third / second / first).max(0.0).sqrt()
    }

    /// Returns whether the body is a flat plate or a rod: the smallest eigenvalue of `J_d` is below
    /// 1e-3 of the largest.
    ///
    /// The implicit equation of a step then needs steps of half the usual bound.
    pub fn is_degenerate(&self) -> bool {
        let half_trace = 0.5 * self.j.trace();
        half_trace - self.principal[2] < 1e-3 * (half_trace - self.principal[0])
    }
}

/// A rigid body: inertia about its reference point, and mass if the body also translates.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Inertia about the mass centre (about the pivot for a pendulum), body axes.
    pub inertia: Inertia,
    /// Mass \[kg\]; `None` if only the attitude moves.
    pub mass: Option<f64>,
}

/// Returns the eigenvalues of a symmetric 3×3 matrix, ascending, by Jacobi rotations.
///
/// nalgebra's eigenvalue routines do not terminate for some inputs; a fixed number of sweeps does.
pub(crate) fn principal_moments(matrix: &Matrix3) -> Vector3 {
    principal_axes(matrix).0
}

/// Returns the eigenvalues of a symmetric 3×3 matrix, ascending, and its eigenvectors as the
/// columns of a right-handed rotation matrix.
pub(crate) fn principal_axes(matrix: &Matrix3) -> (Vector3, Matrix3) {
    let scale = matrix.amax();
    if scale == 0.0 || !scale.is_finite() {
        return (Vector3::repeat(if scale == 0.0 { 0.0 } else { f64::NAN }), Matrix3::identity());
    }
    let (mut a, mut axes) = (matrix / scale, Matrix3::identity());
    // The convergence is quadratic: six sweeps reach round-off for any symmetric 3×3 matrix, and
    // twelve leave a margin.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[(p, q)].abs() < 1e-300 {
                continue;
            }
            let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
            let mut g = Matrix3::identity();
            g[(p, p)] = c;
            g[(q, q)] = c;
            g[(p, q)] = s;
            g[(q, p)] = -s;
            a = g.transpose() * a * g;
            axes *= g;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
    let values = Vector3::from(order.map(|i| a[(i, i)])) * scale;
    let mut axes = Matrix3::from_columns(&order.map(|i| axes.column(i).into_owned()));
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2));
    }
    (values, axes)
}
