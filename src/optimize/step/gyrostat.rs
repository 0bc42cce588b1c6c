//! The drift of a gyrostat: a body with spinning wheels, whose momenta are constant on the drift.
//!
//! With the wheels' angles cyclic, the discrete Lagrangian gains `2 c·μ`: `c` is the Cayley vector of
//! the relative attitude `F`, `μ` the sum of the wheels' momenta, body axes. Its momentum is
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

use super::{Dynamics, StepError};
use crate::lie::{cayley, hat};
use crate::mechanics::drift_equation::{inverse3, solve3};
use crate::{Matrix3, Vector3};

/// Newton starts within a few percent of the solution; the plain body's equation needs 2 or 3.
const MAX_ITERATIONS: usize = 15;
/// A correction below this, squared, is round-off.
const LAST_CORRECTION: f64 = 2e-9;

/// One drift of a gyrostat and its derivatives.
pub(crate) struct GyrostatDrift {
    /// Relative attitude `F`.
    pub f: Matrix3,
    /// Total momentum after, `Fᵀ H`.
    pub momentum_after: Vector3,
    /// `ξ = by_momentum δH + by_wheels δμ`, where `δF = F S(ξ)`.
    pub by_momentum: Matrix3,
    /// See [`GyrostatDrift::by_momentum`].
    pub by_wheels: Matrix3,
}

impl Dynamics {
    /// The drift over step `step` with total momentum `momentum` and wheel momentum `wheels`, body axes, scaled.
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
            f,
            momentum_after: f.tr_mul(momentum),
            by_momentum: -turn * (outer - hat(&c)),
            by_wheels: turn * outer * cc,
        })
    }
}

/// `∂G/∂c`, with `mu = hμ`.
fn slope(j: &Matrix3, g: &Vector3, mu: &Vector3, c: &Vector3) -> Matrix3 {
    let (gc, mc, cc) = (g.dot(c), mu.dot(c), 1.0 + c.norm_squared());
    hat(g) + c * g.transpose() - 2.0 * j - (mu + c * mc) * (2.0 * c.transpose()) - c * mu.transpose() * cc
        + Matrix3::from_diagonal_element(gc - mc * cc)
}
