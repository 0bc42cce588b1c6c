//! The matrices of one step, `A_k`, `H_k` and `Q`, for solvers that eliminate node by node.

use super::drift::Drift;
use super::{Costate, Dynamics, Point, Sensitivity, StepError};
use crate::maneuver::problem::State;
use nalgebra::{SMatrix, SVector};

/// One linearised step, N×N, scaled units.
///
/// ```text
/// z⁺ = A z − Q δλ ,     δλ_before = Aᵀ δλ + H z
/// ```
///
/// with `λ` the costate of the step. `A = K A0`, `H = h A0ᵀ K_qq A0 + H_free` (theory of the
/// survey's section 4.2, 4.3). If the axes of the inputs rotate with the body, `A` contains the
/// derivative of the optimal inputs.
#[derive(Clone, Debug)]
pub struct Linearization<const N: usize> {
    /// Derivative of the step with respect to the state, `A_k`.
    pub a: SMatrix<f64, N, N>,
    /// Curvature of the step, `H_k = ∂(A_kᵀ λ)/∂y` at fixed `λ`.
    pub h: SMatrix<f64, N, N>,
    /// Input authority of the step, `Q = h B W⁻¹ Bᵀ` in the momentum blocks.
    pub q: SMatrix<f64, N, N>,
}

/// Result of one step under a given costate: the end state, the costate before the step, and the
/// matrices.
pub(crate) struct Transition<const N: usize> {
    /// The state after the step.
    pub end: Point,
    /// Costate `λ_{k−1}` before the step, computed from `λ_k`.
    pub costate_before: SVector<f64, N>,
    /// Linearisation of the step.
    pub linear: Linearization<N>,
}

impl Dynamics {
    /// Computes step `step` of the grid from `start` under the costate `λ_k` of that step, with its
    /// linearisation.
    pub(crate) fn transition<const N: usize>(
        &self,
        step: usize,
        start: &Point,
        costate: &SVector<f64, N>,
    ) -> Result<Transition<N>, StepError> {
        let weight = self.grid.full_kick(step + 1);
        let (drift, end, between) = self.halves(step, start, costate, weight)?;
        let linear_kick = self.linear_kick::<N>(&end.pose(), &Costate::from_vector(costate));
        let linear = self.matrices::<N>(&drift, &between, &linear_kick, weight);
        let costate_before = self.drift_costate_back::<N>(&drift, &between).to_vector();
        Ok(Transition { end, costate_before, linear })
    }

    /// Computes the drift of a step, the state after its kick, and the costate between drift and
    /// kick.
    fn halves<const N: usize>(
        &self,
        step: usize,
        start: &Point,
        costate: &SVector<f64, N>,
        weight: f64,
    ) -> Result<(Drift, Point, Costate), StepError> {
        let (mut end, mut costate) = (*start, Costate::from_vector(costate));
        let drift = self.drift::<N>(step, &mut end)?;
        self.kick::<N>(&end.pose(), &costate).apply::<N>(&mut end, &mut costate, weight, -weight);
        Ok((drift, end, costate))
    }

    /// Linearises the first step from a boundary state (SI) under the costate `λ_k` of that step
    /// (scaled).
    ///
    /// # Errors
    /// [`StepError`] if the implicit equation has no solution.
    pub fn linearize<const N: usize>(
        &self,
        start: &State,
        costate: &SVector<f64, N>,
    ) -> Result<Linearization<N>, StepError> {
        Ok(self.transition(0, &self.point(start), costate)?.linear)
    }

    /// Computes `A`, `H`, `Q` from the drift and the kick of a step; `after` is the costate between
    /// drift and kick, `weight` the weight of the kick.
    fn matrices<const N: usize>(
        &self,
        drift: &Drift,
        after: &Costate,
        kick: &super::kick::LinearKick,
        weight: f64,
    ) -> Linearization<N> {
        let linear = self.linear_drift(drift, &self.drift_matrix(drift), after);
        let mut columns = Sensitivity::<N>::of_state();
        let free = linear.curvature(&columns).costate();
        linear.advance(&mut columns);
        let mut curvature = kick.curvature(&columns);
        linear.transpose(&mut curvature);
        let h = free + curvature.costate() * weight;
        let mut moved = Sensitivity::zero();
        (moved.x, moved.gamma, moved.zeta, moved.pi) = (columns.x, columns.gamma, columns.zeta, columns.pi);
        kick.apply(&mut moved, weight, 0.0);
        Linearization { a: moved.state(), h, q: kick.authority() * weight }
    }
}
