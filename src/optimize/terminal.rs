//! The terminal condition, in scaled units: what must hold at the end.
//!
//! As many equations `e(y_N) = 0` as the state has components. Today the whole state is given:
//!
//! ```text
//! e = [x − x_d; γ − γ_d; log(R_dᵀR); Π − Π_d] ,     D_z e = blockdiag(I, I, J_r⁻¹(log R_dᵀR), I)
//! ```
//!
//! Newton needs no `J_r⁻¹`: a direction that solves `D d = −e` with `D = I` solves it with `D_z e` as well, since
//! `J_r(φ) φ = φ`. A component that is left free exchanges its equation for one of transversality, `μ·v = 0` for
//! the motions v that it allows, with the costate μ at the end: a variant of its own here.

use crate::optimize::step::Point;
use nalgebra::SVector;

/// What is given at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TerminalCondition {
    /// Attitude and momentum; position and linear momentum too where the body translates.
    State(Point),
}

impl TerminalCondition {
    /// Number of equations for a state of tangent dimension `dimension`.
    pub fn count(&self, dimension: usize) -> usize {
        match self {
            Self::State(_) => dimension,
        }
    }

    /// `e` of a state at the end, in the crate's order.
    pub fn value<const N: usize>(&self, end: &Point) -> SVector<f64, N> {
        match self {
            Self::State(target) => end.minus(target).to_vector(),
        }
    }

    /// The state at which guesses aim.
    pub fn target(&self) -> &Point {
        match self {
            Self::State(target) => target,
        }
    }
}
