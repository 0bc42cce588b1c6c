//! The terminal condition on state and costate, in scaled units.
//!
//! It has as many equations `e(y_N, μ) = 0` as the state has components. `μ` is the costate of the
//! physical state at the end; for Lie–Verlet it belongs between the halves of the last kick. If the
//! whole state is given:
//!
//! ```text
//! e = [x − x_d; γ − γ_d; log(R_dᵀR); Π − Π_d] ,     D_z e = blockdiag(I, I, J_r⁻¹(log R_dᵀR), I) ,     D_μ e = 0
//! ```
//!
//! Newton needs no `J_r⁻¹`: a direction that solves `D d = −e` with `D = I` solves it with `D_z e`
//! as well, since `J_r(φ) φ = φ`. A component that is left free exchanges its equation for a
//! transversality condition, `μ·v = 0` for the motions v that it allows; each such case is a
//! variant of its own here. For a free terminal attitude `e = [x − x_d; γ − γ_d; μ^R; Π − Π_d]`.

use crate::maneuver::problem::EndCondition;
use crate::optimize::discrete::step::{Costate, Point, Sensitivity};
use nalgebra::{SMatrix, SVector};

/// Terminal condition: the components of the state that are prescribed at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TerminalCondition {
    /// The complete state: attitude and momentum, and position and linear momentum if the body
    /// translates.
    State(Point),
    /// All components except the attitude, which is free.
    AttitudeFree(Point),
}

impl TerminalCondition {
    /// Builds the terminal condition of a maneuver with end state `point`; a free component of
    /// `point` is ignored.
    pub fn of(condition: &EndCondition, point: Point) -> Self {
        match condition {
            // The end on a target is planned for one roll angle at a time, so the whole state is
            // given.
            EndCondition::State | EndCondition::Aim(_) | EndCondition::Met(_) => Self::State(point),
            EndCondition::AnyAttitude => Self::AttitudeFree(point),
        }
    }

    /// Returns a terminal condition of the same kind for another end state.
    pub fn aimed(&self, point: Point) -> Self {
        match self {
            Self::State(_) => Self::State(point),
            Self::AttitudeFree(_) => Self::AttitudeFree(point),
        }
    }

    /// Returns whether component `row` of a state of dimension `dimension` is prescribed.
    fn gives(&self, row: usize, dimension: usize) -> bool {
        let attitude = dimension - 6..dimension - 3;
        matches!(self, Self::State(_)) || !attitude.contains(&row)
    }

    /// Returns the indices of the prescribed components of a state of dimension `dimension`, in the
    /// order x, γ, ζ, Π.
    pub fn given(&self, dimension: usize) -> Vec<usize> {
        (0..dimension).filter(|row| self.gives(*row, dimension)).collect()
    }

    /// Computes the residual `e` of the state and costate at the end, in the order x, γ, ζ, Π.
    pub fn value<const N: usize>(&self, end: &Point, costate: &Costate) -> SVector<f64, N> {
        match self {
            Self::State(target) => end.minus(target).to_vector(),
            Self::AttitudeFree(target) => Costate { zeta: costate.zeta, ..end.minus(target) }.to_vector(),
        }
    }

    /// Computes `D_z e Z + D_μ e Λ` for the columns `Z` and `Λ` of derivatives of state and
    /// costate, with `J_r⁻¹` replaced by `I`.
    pub fn slope<const N: usize>(&self, columns: &Sensitivity<N>) -> SMatrix<f64, N, N> {
        match self {
            Self::State(_) => columns.state(),
            Self::AttitudeFree(_) => Sensitivity { zeta: columns.costate_zeta, ..*columns }.state(),
        }
    }

    /// Returns the end state at which initial guesses are aimed.
    pub fn target(&self) -> &Point {
        match self {
            Self::State(target) => target,
            Self::AttitudeFree(target) => target,
        }
    }
}
