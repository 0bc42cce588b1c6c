//! The KKT conditions of a dense nonlinear program, and Newton's method on them.
//!
//! ```text
//! min f(x)  with  c(x) = 0 ,      L = f + λ·c ,      r = [ c ; ∂L/∂x ] ,      K = ∂r/∂(λ, x)
//! ```
//!
//! `λ` need not be the multipliers of `c` as stated. For a motion they are the costates at the
//! start, and `∂²L/∂x∂λ` is `(∂c/∂x)ᵀ` times the matrix that propagates costates to the end. If
//! inputs depend on the costates, `∂c/∂λ` is not zero. Active bounds, like all conditions that are
//! linear in the unknowns, make some unknowns depend on others: with `x = x₀ + G y` the conditions
//! in `y` are `Tᵀr`, `TᵀKT`, `T = diag(1, G)`.

use crate::numerics::least_squares::shortest;
use crate::numerics::matrix_inertia::MatrixInertia;
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

/// KKT conditions at one point, and their Jacobian.
#[derive(Clone, Debug)]
pub(crate) struct KktSystem {
    /// Number of conditions `c`, which is also the number of multipliers `λ`.
    pub conditions: usize,
    /// Residual `r` of the KKT conditions.
    pub residual: DVector<f64>,
    /// Right-hand side of Newton's method, with opposite sign: the residual `r`, plus the
    /// propagated defects of the path that is corrected.
    pub carried: DVector<f64>,
    /// Jacobian `K` of the residual.
    pub jacobian: DMatrix<f64>,
}

/// Kind of Newton step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NewtonSteps {
    /// Step to the unique solution.
    Determined,
    /// Shortest step to a solution if multipliers or unknowns are not unique.
    Shortest,
    /// Step to `c = 0` by the unknowns alone, with multipliers that minimise `|∂L/∂x|`.
    Feasible,
}

/// Converts a step in `λ` and `y` to a step in `λ` and `x`, for `x = x₀ + G y`.
pub(crate) fn untied(g: &DMatrix<f64>, step: &DVector<f64>) -> DVector<f64> {
    let conditions = step.len() - g.ncols();
    let x = g * step.rows(conditions, g.ncols());
    DVector::from_iterator(conditions + x.len(), step.rows(0, conditions).iter().chain(&x).copied())
}

impl KktSystem {
    /// Returns the conditions in `λ` and `y`, for unknowns `x = x₀ + G y`.
    pub fn tied(&self, g: &DMatrix<f64>) -> Self {
        let m = self.conditions;
        let mut t = DMatrix::zeros(m + g.nrows(), m + g.ncols());
        t.view_mut((0, 0), (m, m)).fill_with_identity();
        t.view_mut((m, m), g.shape()).copy_from(g);
        Self {
            conditions: m,
            residual: t.tr_mul(&self.residual),
            carried: t.tr_mul(&self.carried),
            jacobian: t.tr_mul(&self.jacobian) * t,
        }
    }

    /// Replaces the condition in `row` by another one that vanishes with it. `value` is its value,
    /// and `answer` contains its derivatives with respect to `λ` and `x`, and its propagated
    /// defect; `x = x₀ + G y`.
    pub fn replace(&mut self, row: usize, value: f64, answer: &DVector<f64>, g: &DMatrix<f64>) {
        let (m, x) = (self.conditions, answer.rows(self.conditions, g.nrows()));
        (self.residual[row], self.carried[row]) = (value, value + answer[m + g.nrows()]);
        self.jacobian.view_mut((row, 0), (1, m)).tr_copy_from(&answer.rows(0, m));
        self.jacobian.view_mut((row, m), (1, g.ncols())).tr_copy_from(&g.tr_mul(&x));
    }

    /// Returns the number of unknowns `x`.
    pub fn unknowns(&self) -> usize {
        self.residual.len() - self.conditions
    }

    /// Returns the values of the conditions `c`.
    pub fn constraints(&self) -> DVectorView<'_, f64> {
        self.residual.rows(0, self.conditions)
    }

    /// Returns the gradient `∂L/∂x`.
    pub fn slope(&self) -> DVectorView<'_, f64> {
        self.residual.rows(self.conditions, self.unknowns())
    }

    /// Returns the Jacobian `∂c/∂x`.
    pub fn by_unknowns(&self) -> DMatrixView<'_, f64> {
        self.jacobian.view((0, self.conditions), (self.conditions, self.unknowns()))
    }

    /// Returns the mixed derivative `∂²L/∂x∂λ`.
    pub fn by_multipliers(&self) -> DMatrixView<'_, f64> {
        self.jacobian.view((self.conditions, 0), (self.unknowns(), self.conditions))
    }

    /// Returns the Hessian `∂²L/∂x²`.
    pub fn hessian(&self) -> DMatrixView<'_, f64> {
        let count = self.unknowns();
        self.jacobian.view((self.conditions, self.conditions), (count, count))
    }

    /// Returns the norm of the KKT residual; for [`NewtonSteps::Feasible`], the norm of the
    /// conditions `c` only.
    pub fn merit(&self, steps: NewtonSteps) -> f64 {
        if steps == NewtonSteps::Feasible { self.constraints().norm() } else { self.residual.norm() }
    }

    /// Computes a Newton step in `λ` and `x`; `None` if the system is singular. Singular values
    /// below `none` times the largest count as zero.
    pub fn newton_step(&self, steps: NewtonSteps, none: f64) -> Option<DVector<f64>> {
        let right = -&self.carried;
        match steps {
            NewtonSteps::Determined => self.jacobian.clone().lu().solve(&right),
            NewtonSteps::Shortest => shortest(&self.jacobian, &right, none),
            NewtonSteps::Feasible => {
                let (m, n) = (self.conditions, self.unknowns());
                let x = shortest(&self.by_unknowns().into_owned(), &right.rows(0, m).into_owned(), none)?;
                let left = right.rows(m, n) - self.hessian() * &x;
                let multipliers = shortest(&self.by_multipliers().into_owned(), &left, none)?;
                Some(DVector::from_iterator(m + n, multipliers.iter().chain(&x).copied()))
            }
        }
    }

    /// Returns whether `f` decreases to second order along a direction that keeps `c = 0`, so that
    /// the point is not a minimum. Pivots below `none` times the largest entry count as zero.
    pub fn falls(&self, none: f64) -> bool {
        let (m, n) = (self.conditions, self.unknowns());
        let mut matrix = DMatrix::zeros(n + m, n + m);
        matrix.view_mut((0, 0), (n, n)).copy_from(&(0.5 * (self.hessian() + self.hessian().transpose())));
        matrix.view_mut((n, 0), (m, n)).copy_from(&self.by_unknowns());
        matrix.view_mut((0, n), (n, m)).copy_from(&self.by_unknowns().transpose());
        let least = none * matrix.amax();
        MatrixInertia::of(matrix, least).negative > m
    }
}
