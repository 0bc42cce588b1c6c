//! The drift of a gyrostat: a body with spinning wheels, whose momenta are constant on the drift.
//!
//! The wheel angles are cyclic, and the discrete Lagrangian gains `2 c·μ`: `c` is the Cayley vector
//! of the relative attitude `F`, `μ` the sum of the wheels' momenta, body axes. Its momentum is
//! `(I + S(c) + c cᵀ) μ` on the left and `Fᵀ` times that on the right. With `H` the total momentum,
//!
//! ```text
//! h S(H − (I + S(c) + c cᵀ) μ) = F J_d − J_d Fᵀ ,    R⁺ = R F ,    H⁺ = Fᵀ H
//! ```
//!
//! so the total momentum is conserved in space to round-off. In Cayley form, `g = hH`:
//!
//! ```text
//! G(c) = g + g×c + (g·c) c − 2Jc − h (1 + |c|²)(μ + (μ·c) c) = 0
//! ```
//!
//! With `λ = (λ^ζ, λ^H, λ^μ)` after the drift and `q = λ^ζ + λ^H × H⁺`, the costate before it is
//!
//! ```text
//! F λ^ζ ,   ξ_Hᵀ q + F λ^H ,   ξ_μᵀ q + λ^μ        ξ = T(c) δc ,  T = 2/(1 + |c|²) (I − S(c)) ,     ξ_xᵀ q = G_xᵀ w ,  G_cᵀ w = −Tᵀ q
//! ```
//!
//! so that its derivatives are those of the scalar `w·G`, of `Tᵀ`, and of `q`.

use super::{Costate, Dynamics, StepError};
use crate::lie::{cayley, hat};
use crate::mechanics::drift_equation::{inverse3, solve3};
use crate::{Matrix3, Vector3};
use nalgebra::SMatrix;

/// Largest number of Newton iterations. The initial guess is within a few percent of the solution,
/// and the equation of a body without wheels takes 2 or 3 iterations.
const MAX_ITERATIONS: usize = 15;
/// Newton correction below which the iteration ends: its square is below round-off.
const LAST_CORRECTION: f64 = 2e-9;

/// One drift of a gyrostat and its derivatives.
pub(crate) struct GyrostatDrift {
    /// Cayley vector `c` of the relative attitude.
    c: Vector3,
    /// Relative attitude `F`.
    pub f: Matrix3,
    /// Total momentum after the drift, `Fᵀ H`.
    pub momentum_after: Vector3,
    /// Derivative with respect to the total momentum: `ξ = by_momentum δH + by_wheels δμ`, where
    /// `δF = F S(ξ)`.
    pub by_momentum: Matrix3,
    /// Derivative of `ξ` with respect to the wheel momentum; see [`GyrostatDrift::by_momentum`].
    pub by_wheels: Matrix3,
}

impl Dynamics {
    /// Computes the drift over step `step` with total momentum `momentum` and wheel momentum
    /// `wheels`, body axes, scaled.
    pub(crate) fn gyrostat_drift(
        &self,
        step: usize,
        momentum: &Vector3,
        wheels: &Vector3,
    ) -> Result<GyrostatDrift, StepError> {
        let (h, j) = (self.grid.step(step), &self.j);
        let (g, mu) = (momentum * h, wheels * h);
        let mut c = 0.5 * (self.j_inverse * (g - mu));
        let mut converged = false;
        for _ in 0..MAX_ITERATIONS {
            let (gc, mc, cc) = (g.dot(&c), mu.dot(&c), 1.0 + c.norm_squared());
            let residual = g + g.cross(&c) + c * gc - 2.0 * (j * c) - (mu + c * mc) * cc;
            let correction = -solve3(&slope(j, &g, &mu, &c), &residual);
            c += correction;
            if correction.amax() <= LAST_CORRECTION {
                converged = true;
                break;
            }
        }
        if !(converged && c.norm_squared() < 1.0) {
            let finite = momentum.iter().chain(wheels.iter()).all(|value| value.is_finite());
            return Err(if finite { StepError::TooLong } else { StepError::NotFinite });
        }
        let f = cayley(&c);
        let cc = 1.0 + c.norm_squared();
        let outer = Matrix3::identity() + c * c.transpose();
        // ξ = 2/(1 + |c|²) (I − S(c)) δc.
        let turn = (Matrix3::identity() - hat(&c)) * (2.0 / cc) * inverse3(&slope(j, &g, &mu, &c)) * h;
        Ok(GyrostatDrift {
            c,
            f,
            momentum_after: f.tr_mul(momentum),
            by_momentum: -turn * (outer - hat(&c)),
            by_wheels: turn * outer * cc,
        })
    }
}

impl Dynamics {
    /// Computes the derivative of the costate before a drift with respect to `[ζ, δH, δμ]`, for a
    /// fixed costate `after` of attitude and total momentum after it.
    pub(crate) fn gyrostat_curvature(
        &self,
        step: usize,
        drift: &GyrostatDrift,
        [momentum, wheels]: [&Vector3; 2],
        after: &Costate,
    ) -> SMatrix<f64, 9, 9> {
        let (h, c, j) = (self.grid.step(step), &drift.c, &self.j);
        let (g, mu) = (momentum * h, wheels * h);
        let (identity, cc) = (Matrix3::identity(), 1.0 + c.norm_squared());
        let q = after.zeta + after.pi.cross(&drift.momentum_after);
        let before = inverse3(&slope(j, &g, &mu, c));
        let t = (identity - hat(c)) * (2.0 / cc);
        let w = -(before.transpose() * t.tr_mul(&q));
        // Second derivatives of w·G with respect to c, H and μ.
        let (mc, wc) = (mu.dot(c), w.dot(c));
        let both = mu * wc + w * mc;
        let lean = w + c * wc;
        let twice = |a: &Vector3, b: &Vector3| a * b.transpose() + b * a.transpose();
        let by_c = twice(&g, &w)
            - identity * (2.0 * (w.dot(&mu) + mc * wc))
            - twice(c, &both) * 2.0
            - twice(&mu, &w) * cc;
        let leaning = identity * wc + c * w.transpose();
        let of = [leaning - hat(&w), -(lean * c.transpose() * 2.0 + leaning * cc)];
        let outer = identity + c * c.transpose();
        let slopes = [outer - hat(c), -(outer * cc)];
        let bend = -(q + c.cross(&q)) * c.transpose() * (4.0 / (cc * cc)) - hat(&q) * (2.0 / cc);
        let turns = [drift.by_momentum, drift.by_wheels];
        let f_t = drift.f.transpose();
        let mut out = SMatrix::<f64, 9, 9>::zeros();
        for (column, (turn, (slope_of, mixed))) in turns.iter().zip(slopes.iter().zip(&of)).enumerate() {
            let moved = -(before * slope_of) * h;
            // H⁺ changes by Fᵀ δH + H⁺ × ξ.
            let own = if column == 0 { f_t } else { Matrix3::zeros() };
            let q_by = hat(&after.pi) * (own + hat(&drift.momentum_after) * turn);
            let w_by = -(before.transpose()
                * (bend * moved + t.tr_mul(&q_by) + by_c * moved + mixed.transpose() * h));
            let at = 3 * (column + 1);
            for (row, (slope_of, mixed)) in slopes.iter().zip(&of).enumerate() {
                let mut block = (mixed * moved + slope_of.transpose() * w_by) * h;
                if row == 0 {
                    block -= drift.f * hat(&after.pi) * turn;
                }
                out.fixed_view_mut::<3, 3>(3 * (row + 1), at).copy_from(&block);
            }
            let of_attitude = -(drift.f * hat(&after.zeta) * turn);
            out.fixed_view_mut::<3, 3>(0, at).copy_from(&of_attitude);
        }
        out
    }
}

/// Computes `∂G/∂c`, with `mu = hμ`.
fn slope(j: &Matrix3, g: &Vector3, mu: &Vector3, c: &Vector3) -> Matrix3 {
    let (gc, mc, cc) = (g.dot(c), mu.dot(c), 1.0 + c.norm_squared());
    hat(g) + c * g.transpose() - 2.0 * j - (mu + c * mc) * (2.0 * c.transpose()) - c * mu.transpose() * cc
        + Matrix3::from_diagonal_element(gc - mc * cc)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maneuver::grid::Grid;
    use crate::testing::{Random, attitude_only, moving_ends};

    /// Compares the derivative of the costate before a drift, `[F λ^ζ ; ξ_Hᵀ q + F λ^H ; ξ_μᵀ q]`,
    /// with its central differences.
    #[test]
    fn the_curvature_is_the_derivative_of_the_costate_before_the_drift() {
        let mut random = Random(4);
        let problem = attitude_only(moving_ends(&mut random, crate::mechanics::actuators::AxisFrame::Body));
        let dynamics = Dynamics::on(&problem, Grid::uniform(problem.scheme, 1.0, 4));
        for _ in 0..20 {
            let (momentum, wheels) = (0.5 * random.vector3(), 0.3 * random.vector3());
            let zero = Vector3::zeros();
            let after = Costate { x: zero, gamma: zero, zeta: random.vector3(), pi: random.vector3() };
            let before = |momentum: &Vector3, wheels: &Vector3| {
                let drift = dynamics.gyrostat_drift(1, momentum, wheels).unwrap();
                let q = after.zeta + after.pi.cross(&drift.momentum_after);
                let blocks = [
                    drift.f * after.zeta,
                    drift.by_momentum.tr_mul(&q) + drift.f * after.pi,
                    drift.by_wheels.tr_mul(&q),
                ];
                SMatrix::<f64, 9, 1>::from_fn(|row, _| blocks[row / 3][row % 3])
            };
            let drift = dynamics.gyrostat_drift(1, &momentum, &wheels).unwrap();
            let found = dynamics.gyrostat_curvature(1, &drift, [&momentum, &wheels], &after);
            let step = 1e-5;
            for column in 0..6 {
                let mut by = [zero; 2];
                by[column / 3][column % 3] = step;
                let plus = before(&(momentum + by[0]), &(wheels + by[1]));
                let minus = before(&(momentum - by[0]), &(wheels - by[1]));
                let apart = ((plus - minus) / (2.0 * step) - found.column(3 + column)).amax();
                assert!(apart < 1e-8, "{column}: {apart:e}");
            }
        }
    }
}
