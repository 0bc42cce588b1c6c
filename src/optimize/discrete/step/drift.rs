//! The drift: one step of the free rigid body, its lift to the costates, and their derivatives.
//!
//! With `E = tr(F J_d) I − F J_d` and `B = h Fᵀ E⁻¹` (4.8–4.17),
//!
//! ```text
//! z'  = A0 z        A0   = [[Fᵀ, B], [0, C]]                 C = Fᵀ + S(Π') B
//! λ'  = A0⁻ᵀ λ      A0⁻ᵀ = [[Fᵀ, 0], [−B, Fᵀ + B S(Π)]]
//! δλ' = A0⁻ᵀ (δλ − H z),    H z = ∂(A0ᵀ λ')/∂y z at fixed λ'
//! ```
//!
//! `H` has only momentum columns: with `(μ, p) = λ'`, `q = μ + p × Π'`, `h w = Bᵀ q`,
//!
//! ```text
//! H12 = −F S(μ) B
//! H22 = −F S(p) B + Bᵀ [ S(p) C + (−S(q) + Fᵀ(h w) Π'ᵀ + Fᵀ J_d S(Fᵀ w)) B ]
//! ```
//!
//! The translation drifts by `x' = x + h γ`, `λ^γ' = λ^γ − h λ^x`.

use super::{Costate, Dynamics, Point, Sensitivity, StepError, lanes::Rows};
use crate::lie::{cayley_minus_identity, hat};
use crate::mechanics::drift_equation::{inverse3, solve, solve3};
use crate::{Matrix3, Vector3};
use nalgebra::SMatrix;

/// Result of a drift, as needed by its linearisation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drift {
    /// Length of the step, scaled.
    pub h: f64,
    /// Relative attitude `F` of the step.
    pub f: Matrix3,
    /// Momentum `Π` before the drift.
    pub momentum: Vector3,
    /// Momentum `Π' = FᵀΠ` after the drift.
    pub momentum_after: Vector3,
}

/// Matrices of a linearised drift, defined in the module header.
pub(crate) struct LinearDrift {
    h: f64,
    f: Matrix3,
    pub f_t: Matrix3,
    pub b: Matrix3,
    pub c: Matrix3,
    /// Transposed inverse `C⁻ᵀ = Fᵀ + B S(Π)`.
    pub c_inverse_t: Matrix3,
    pub h12: Matrix3,
    pub h22: Matrix3,
}

impl Dynamics {
    /// Moves `point` by the drift of step `step` of the grid.
    #[inline(always)]
    pub(crate) fn drift<const N: usize>(&self, step: usize, point: &mut Point) -> Result<Drift, StepError> {
        let h = self.grid.step(step);
        let momentum = point.momentum.value;
        let Some(c) = solve(&self.j, &self.j_inverse, &(h * momentum)) else {
            let finite = momentum.iter().all(|value| value.is_finite());
            return Err(if finite { StepError::TooLong } else { StepError::NotFinite });
        };
        let turn = cayley_minus_identity(&c);
        point.momentum.add(&(turn.transpose() * momentum));
        point.attitude.add(&(point.attitude.value * turn));
        if let Some(frame_turn) = self.frame_turn(step) {
            point.attitude.add(&(frame_turn * point.attitude.value));
        }
        if N == 12 {
            point.position.add(&(h * point.linear_momentum.value));
        }
        let f = turn + Matrix3::identity();
        Ok(Drift { h, f, momentum, momentum_after: point.momentum.value })
    }

    /// Computes `E = tr(F J_d) I − F J_d` of a drift.
    #[inline(always)]
    pub(crate) fn drift_matrix(&self, drift: &Drift) -> Matrix3 {
        drift.matrix(&self.j_d)
    }

    /// Computes `B = h Fᵀ E⁻¹` of a drift, so that `ξ = B δΠ` is the rotation due to a momentum
    /// change δΠ.
    pub(crate) fn drift_block(&self, drift: &Drift, e: &Matrix3) -> Matrix3 {
        drift.f.transpose() * inverse3(e) * drift.h
    }

    /// Maps a costate backward over a drift, `λ = A0ᵀ λ'`.
    pub(crate) fn drift_costate_back<const N: usize>(&self, drift: &Drift, after: &Costate) -> Costate {
        let e = self.drift_matrix(drift);
        let b_t = self.drift_block(drift, &e).transpose();
        let mut before = *after;
        before.zeta = drift.f * after.zeta;
        before.pi = drift.f * after.pi + b_t * (after.zeta + after.pi.cross(&drift.momentum_after));
        if N == 12 {
            before.gamma += drift.h * after.x;
        }
        before
    }

    /// Linearises a drift. `after` is the costate after the drift.
    #[inline(always)]
    pub(crate) fn linear_drift(&self, drift: &Drift, e: &Matrix3, after: &Costate) -> LinearDrift {
        drift.linear(&self.j_d, e, after)
    }
}

impl Drift {
    /// Computes `E = tr(F J_d) I − F J_d`.
    #[inline(always)]
    pub(crate) fn matrix(&self, j_d: &Matrix3) -> Matrix3 {
        let f_j_d = self.f * j_d;
        Matrix3::from_diagonal_element(f_j_d.trace()) - f_j_d
    }

    /// Maps a costate forward over the drift, `λ' = A0⁻ᵀ λ`.
    #[inline(always)]
    pub(crate) fn costate<const N: usize>(&self, e: &Matrix3, costate: &Costate) -> Costate {
        let lever = self.momentum.cross(&costate.pi) - costate.zeta;
        let mut after = *costate;
        after.zeta = self.f.tr_mul(&costate.zeta);
        after.pi = self.f.tr_mul(&(costate.pi + solve3(e, &lever) * self.h));
        if N == 12 {
            after.gamma -= self.h * costate.x;
        }
        after
    }

    /// Linearises the drift. `after` is the costate after the drift.
    #[inline(always)]
    pub(crate) fn linear(&self, j_d: &Matrix3, e: &Matrix3, after: &Costate) -> LinearDrift {
        let f = self.f;
        let f_t = f.transpose();
        let b = f_t * inverse3(e) * self.h;
        let b_t = b.transpose();
        let c = f_t + hat(&self.momentum_after) * b;
        let c_inverse_t = f_t + b * hat(&self.momentum);
        let (mu, p) = (after.zeta, after.pi);
        let q = mu + p.cross(&self.momentum_after);
        let h_w = b_t * q;
        let f_t_w = f_t * h_w / self.h;
        let f_s_p = f * hat(&p);
        let inner = f_t * (j_d * hat(&f_t_w) + h_w * self.momentum_after.transpose()) - hat(&q);
        LinearDrift {
            h: self.h,
            f,
            f_t,
            b,
            c,
            c_inverse_t,
            h12: -f * hat(&mu) * b,
            h22: b_t * (hat(&p) * c + inner * b) - f_s_p * b,
        }
    }
}

impl LinearDrift {
    /// Returns `A0` and `H` as matrices.
    pub fn matrices<const N: usize>(&self) -> [SMatrix<f64, N, N>; 2] {
        let mut columns = Sensitivity::<N>::of_state();
        let curvature = self.curvature(&columns).costate();
        self.advance(&mut columns);
        [columns.state(), curvature]
    }

    /// Maps state and costate derivatives over the drift: `z' = A0 z`, `δλ' = A0⁻ᵀ (δλ − H z)`.
    #[inline(always)]
    pub fn advance<const N: usize>(&self, columns: &mut Sensitivity<N>) {
        let zeta = columns.costate_zeta - &self.h12 * &columns.pi;
        let pi = columns.costate_pi - &self.h22 * &columns.pi;
        columns.costate_zeta = &self.f_t * &zeta;
        columns.costate_pi = &self.c_inverse_t * &pi - &self.b * &zeta;
        columns.zeta = &self.f_t * &columns.zeta + &self.b * &columns.pi;
        columns.pi = &self.c * &columns.pi;
        if N == 12 {
            columns.costate_gamma -= self.h * columns.costate_x;
            columns.x += self.h * columns.gamma;
        }
    }

    /// Computes `H z` of the drift alone from the state part of `columns`; the result is in the
    /// costate part.
    pub fn curvature<const N: usize>(&self, columns: &Sensitivity<N>) -> Sensitivity<N> {
        let mut out = Sensitivity::zero();
        out.costate_zeta = &self.h12 * &columns.pi;
        out.costate_pi = &self.h22 * &columns.pi;
        out
    }

    /// Applies `A0ᵀ` to the costate part of `columns`.
    pub fn transpose<const N: usize>(&self, columns: &mut Sensitivity<N>) {
        let (zeta, pi): (Rows<N>, Rows<N>) = (columns.costate_zeta, columns.costate_pi);
        columns.costate_zeta = &self.f * &zeta;
        columns.costate_pi = &self.b.transpose() * &zeta + &self.c.transpose() * &pi;
        if N == 12 {
            columns.costate_gamma += self.h * columns.costate_x;
        }
    }
}
