//! The terminal condition, in scaled units: what must hold at the end, of the state and of the
//! costate.
//!
//! As many equations `e(y_N, μ) = 0` as the state has components, with the costate `μ` of the
//! physical state at the end, between the halves of the last kick for Lie–Verlet. Where the whole
//! state is given:
//!
//! ```text
//! e = [x − x_d; γ − γ_d; log(R_dᵀR); Π − Π_d] ,     D_z e = blockdiag(I, I, J_r⁻¹(log R_dᵀR), I) ,     D_μ e = 0
//! ```
//!
//! Newton needs no `J_r⁻¹`: a direction that solves `D d = −e` with `D = I` solves it with `D_z e`
//! as well, since `J_r(φ) φ = φ`. A component that is left free exchanges its equation for one of
//! transversality, `μ·v = 0` for the motions v that it allows: a variant of its own here. Where any
//! attitude will do, `e = [x − x_d; γ − γ_d; μ^R; Π − Π_d]`.

use crate::maneuver::problem::EndCondition;
use crate::optimize::discrete::step::{Costate, Point, Sensitivity};
use nalgebra::{SMatrix, SVector};

/// What is given at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TerminalCondition {
    /// Attitude and momentum; position and linear momentum too where the body translates.
    State(Point),
    /// All but the attitude.
    AttitudeFree(Point),
}

impl TerminalCondition {
    /// That of a maneuver whose end is `point`, as far as it is given.
    pub fn of(condition: &EndCondition, point: Point) -> Self {
        match condition {
            // An end on a target is planned roll by roll.
            EndCondition::State | EndCondition::Aim(_) | EndCondition::Met(_) => Self::State(point),
            EndCondition::AnyAttitude => Self::AttitudeFree(point),
        }
    }

    /// The condition of another end.
    pub fn aimed(&self, point: Point) -> Self {
        match self {
            Self::State(_) => Self::State(point),
            Self::AttitudeFree(_) => Self::AttitudeFree(point),
        }
    }

    /// Whether component `row` of a state of dimension `dimension` is given.
    fn gives(&self, row: usize, dimension: usize) -> bool {
        let attitude = dimension - 6..dimension - 3;
        matches!(self, Self::State(_)) || !attitude.contains(&row)
    }

    /// Which components of a state of dimension `dimension` are given, in the crate's order.
    pub fn given(&self, dimension: usize) -> Vec<usize> {
        (0..dimension).filter(|row| self.gives(*row, dimension)).collect()
    }

    /// `e` of state and costate at the end, in the crate's order.
    pub fn value<const N: usize>(&self, end: &Point, costate: &Costate) -> SVector<f64, N> {
        match self {
            Self::State(target) => end.minus(target).to_vector(),
            Self::AttitudeFree(target) => Costate { zeta: costate.zeta, ..end.minus(target) }.to_vector(),
        }
    }

    /// `D_z e Z + D_μ e Λ` for columns of the derivatives of state and costate, with `J_r⁻¹` taken
    /// for `I`.
    pub fn slope<const N: usize>(&self, columns: &Sensitivity<N>) -> SMatrix<f64, N, N> {
        match self {
            Self::State(_) => columns.state(),
            Self::AttitudeFree(_) => Sensitivity { zeta: columns.costate_zeta, ..*columns }.state(),
        }
    }

    /// The state at which guesses aim.
    pub fn target(&self) -> &Point {
        match self {
            Self::State(target) => target,
            Self::AttitudeFree(target) => target,
        }
    }
}
