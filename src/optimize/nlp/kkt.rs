//! Conditions of Karush, Kuhn and Tucker of a dense nonlinear program, and Newton on them.
//!
//! ```text
//! min f(x)  with  c(x) = 0 ,      L = f + λ·c ,      r = [ c ; ∂L/∂x ] ,      K = ∂r/∂(λ, x)
//! ```
//!
//! `λ` need not be multipliers of `c` as it stands: of a motion they are costates at the start, and
//! `∂²L/∂x∂λ` is `(∂c/∂x)ᵀ` times what carries them to the end. Where inputs follow the costates,
//! `∂c/∂λ` is not zero. Bounds that act, as other conditions that are linear in the unknowns, tie
//! them together: with `x = x₀ + G y` the conditions in `y` are `Tᵀr`, `TᵀKT`, `T = diag(1, G)`.

use crate::numerics::least_squares::shortest;
use crate::numerics::matrix_inertia::MatrixInertia;
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

/// The conditions at one point, and how they answer.
#[derive(Clone, Debug)]
pub(crate) struct KktSystem {
    /// The number of `c`, and of `λ`.
    pub conditions: usize,
    /// `r`.
    pub residual: DVector<f64>,
    /// What Newton has to take away: `r`, and what gaps of a path that it starts from carry to it.
    pub carried: DVector<f64>,
    /// `K`.
    pub jacobian: DMatrix<f64>,
}

/// Which steps Newton takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NewtonSteps {
    /// To the only solution.
    Determined,
    /// The shortest to a solution, where multipliers or unknowns are open.
    Shortest,
    /// To `c = 0` by the unknowns alone, and to multipliers that leave the least of `∂L/∂x`.
    Feasible,
}

/// Returns the step of `λ` and `x` that one of `λ` and `y` is, for `x = x₀ + G y`.
pub(crate) fn untied(g: &DMatrix<f64>, step: &DVector<f64>) -> DVector<f64> {
    let conditions = step.len() - g.ncols();
    let x = g * step.rows(conditions, g.ncols());
    DVector::from_iterator(conditions + x.len(), step.rows(0, conditions).iter().chain(&x).copied())
}

impl KktSystem {
    /// Returns the conditions in `y`, for unknowns that go with these as `x = x₀ + G y`.
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

    /// Puts a condition in place of one that vanishes with it, by its value and how it answers to
    /// `λ`, `x` and 1, for `x = x₀ + G y`.
    pub fn replace(&mut self, row: usize, value: f64, answer: &DVector<f64>, g: &DMatrix<f64>) {
        let (m, x) = (self.conditions, answer.rows(self.conditions, g.nrows()));
        (self.residual[row], self.carried[row]) = (value, value + answer[m + g.nrows()]);
        self.jacobian.view_mut((row, 0), (1, m)).tr_copy_from(&answer.rows(0, m));
        self.jacobian.view_mut((row, m), (1, g.ncols())).tr_copy_from(&g.tr_mul(&x));
    }

    /// Returns the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.residual.len() - self.conditions
    }

    /// Returns `c`.
    pub fn constraints(&self) -> DVectorView<'_, f64> {
        self.residual.rows(0, self.conditions)
    }

    /// Returns `∂L/∂x`.
    pub fn slope(&self) -> DVectorView<'_, f64> {
        self.residual.rows(self.conditions, self.unknowns())
    }

    /// Returns `∂c/∂x`.
    pub fn by_unknowns(&self) -> DMatrixView<'_, f64> {
        self.jacobian.view((0, self.conditions), (self.conditions, self.unknowns()))
    }

    /// Returns `∂²L/∂x∂λ`.
    pub fn by_multipliers(&self) -> DMatrixView<'_, f64> {
        self.jacobian.view((self.conditions, 0), (self.unknowns(), self.conditions))
    }

    /// Returns `∂²L/∂x²`.
    pub fn hessian(&self) -> DMatrixView<'_, f64> {
        let count = self.unknowns();
        self.jacobian.view((self.conditions, self.conditions), (count, count))
    }

    /// Returns how far the conditions are from being met; of steps that meet `c = 0` alone this
    /// alone.
    pub fn merit(&self, steps: NewtonSteps) -> f64 {
        if steps == NewtonSteps::Feasible { self.constraints().norm() } else { self.residual.norm() }
    }

    /// Returns a step of Newton in `λ` and `x`. Singular values below the part `none` of the
    /// largest count as zero.
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

    /// Returns whether `f` falls along some `x` that keeps `c = 0`, to second order: the point is
    /// then no minimum. Pivots below the part `none` of the largest entry count as zero.
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
