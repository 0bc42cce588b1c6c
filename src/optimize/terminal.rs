//! The terminal condition, in scaled units: what must hold at the end, of the state and of the costate.
//!
//! As many equations `e(y_N, μ) = 0` as the state has components, with the costate `μ` of the physical state at the
//! end, between the halves of the last kick for Lie–Verlet. Today the whole state is given:
//!
//! ```text
//! e = [x − x_d; γ − γ_d; log(R_dᵀR); Π − Π_d] ,     D_z e = blockdiag(I, I, J_r⁻¹(log R_dᵀR), I) ,     D_μ e = 0
//! ```
//!
//! Newton needs no `J_r⁻¹`: a direction that solves `D d = −e` with `D = I` solves it with `D_z e` as well, since
//! `J_r(φ) φ = φ`. A component that is left free exchanges its equation for one of transversality, `μ·v = 0` for
//! the motions v that it allows: a variant of its own here, such as that of the tests, which leaves the attitude free
//! (`e = [μ^R; Π − Π_d]`).

use crate::optimize::step::{Costate, Point, Sensitivity};
use nalgebra::{SMatrix, SVector};

/// What is given at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TerminalCondition {
    /// Attitude and momentum; position and linear momentum too where the body translates.
    State(Point),
    /// The momenta alone, and with them the position where the body translates.
    #[cfg(test)]
    AttitudeFree(Point),
}

impl TerminalCondition {
    /// Number of equations of the state alone, for one of tangent dimension `dimension`.
    pub fn count(&self, dimension: usize) -> usize {
        match self {
            Self::State(_) => dimension,
            #[cfg(test)]
            Self::AttitudeFree(_) => dimension - 3,
        }
    }

    /// `e` of state and costate at the end, in the crate's order.
    #[cfg_attr(not(test), expect(unused_variables, reason = "a given state asks nothing of the costate"))]
    pub fn value<const N: usize>(&self, end: &Point, costate: &Costate) -> SVector<f64, N> {
        match self {
            Self::State(target) => end.minus(target).to_vector(),
            #[cfg(test)]
            Self::AttitudeFree(target) => Costate { zeta: costate.zeta, ..end.minus(target) }.to_vector(),
        }
    }

    /// `D_z e Z + D_μ e Λ` for columns of the derivatives of state and costate, with `J_r⁻¹` taken for `I`.
    pub fn slope<const N: usize>(&self, columns: &Sensitivity<N>) -> SMatrix<f64, N, N> {
        match self {
            Self::State(_) => columns.state(),
            #[cfg(test)]
            Self::AttitudeFree(_) => Sensitivity { zeta: columns.costate_zeta, ..*columns }.state(),
        }
    }

    /// The state at which guesses aim.
    pub fn target(&self) -> &Point {
        match self {
            Self::State(target) => target,
            #[cfg(test)]
            Self::AttitudeFree(target) => target,
        }
    }
}
