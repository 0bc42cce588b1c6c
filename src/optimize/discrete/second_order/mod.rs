//! Optimality tests of an extremal: stationarity, rank and condition of Ψ₁₂, conjugate points.
//!
//! # How are conjugate points counted?
//!
//! With `Z_k = Ψ₁₂(k)`, `Λ_k` the derivative of the costate and `Q = GGᵀ` the authority of the
//! inputs, `P = Λ Z⁻¹` solves the discrete Riccati equation, and a step meets as many conjugate
//! points as `I + GᵀPG` has negative eigenvalues. The determinant of `Z_k` changes sign at a simple
//! conjugate point but not at a double one, and bodies with symmetry have double ones. A plan
//! without conjugate points is a local minimum of the discrete problem; this proves nothing about
//! the global minimum.
//!
//! Near the start `Z` is singular, and these steps are not counted. If `Z` is singular at the end,
//! or anywhere after it had an inverse, the inertia of the accessory problem is counted instead,
//! which requires no inverse of `Z`. A zero eigenvalue of its last pivot has one of two causes.
//! Either the inputs cannot reach the direction, which the rank of `W = Σ Φ Q Φᵀ` shows. Or the
//! cost is constant to second order along the direction: the minimum is one of a circle of equal
//! minima, which a symmetry causes (`problems/pendulum_two_torques_spin.toml`, half a turn about an
//! axis without a torque). The sign of such an eigenvalue is round-off. If the cost decreases in no
//! other direction, the result is `None`: it is undecided whether the extremal is a minimum or a
//! saddle.

mod accessory;
mod kernel;

use crate::Matrix3;
use crate::maneuver::solution::Optimality;
use crate::numerics::factor::rank_and_condition;
use crate::optimize::discrete::step::Costate;
use crate::optimize::discrete::step::inputs::InputMatrices;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, Step};
use nalgebra::{SMatrix, SVector};

/// Tests first- and second-order optimality of the extremal that starts with `costate`.
pub(crate) fn optimality<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Optimality {
    let mut stationarity = Stationarity::new(bvp, costate);
    let mut counter = Counter::new(bvp);
    let limited = bvp.dynamics.is_limited();
    let swept = bvp.sweep_conjugate(costate, |step| {
        stationarity.step(step);
        if !limited {
            counter.step(step);
        }
    });
    let psi = swept.ok().map(|(_, psi)| psi);
    let (rank, condition) = psi.as_ref().map_or((0, f64::INFINITY), rank_and_condition);
    Optimality {
        tested: true,
        stationarity: stationarity.close(),
        conjugate_points: match &psi {
            Some(psi) if !limited && rank == N => counter.close(psi),
            _ => None,
        }
        .or_else(|| accessory::conjugate_points(bvp, costate)),
        rank,
        condition,
    }
}

/// Accumulates the stationarity residual of a sweep: the largest `|λ_{k−1} − A_kᵀ λ_k|` of the
/// costate recursion, relative to the largest costate. The sweep computed the costates forward by
/// `A_k⁻ᵀ`; the residual recomputes them backward by `A_kᵀ`. Under limits the largest projection
/// residual of the inputs, relative to the largest output, is included.
struct Stationarity<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    steps: usize,
    worst: f64,
    size: f64,
    worst_input: f64,
    largest_output: f64,
}

impl<'a, const N: usize> Stationarity<'a, N> {
    fn new(bvp: &'a BoundaryValueProblem<'a, N>, costate: &SVector<f64, N>) -> Self {
        let mut new = Self { bvp, steps: 0, worst: 0.0, size: 0.0, worst_input: 0.0, largest_output: 0.0 };
        if bvp.dynamics.is_limited() {
            let (pose, costate) = (bvp.start.pose(), Costate::from_vector(costate));
            let effort = bvp.dynamics.kick::<N>(&pose, &costate).effort;
            new.inputs(bvp.dynamics.input_residual(&pose, &costate), effort);
        }
        new
    }

    fn inputs(&mut self, residual: f64, effort: f64) {
        self.worst_input = self.worst_input.max(residual);
        self.largest_output = self.largest_output.max(effort.sqrt());
    }

    fn step(&mut self, step: &Step<N>) {
        let dynamics = &self.bvp.dynamics;
        let (mut point, mut costate) = (self.bvp.start, step.after);
        // Backward: undo the gradient of the kick, then apply `A0ᵀ` of the drift.
        step.kick.apply::<N>(&mut point, &mut costate, 0.0, -step.weight);
        let back = dynamics.drift_costate_back::<N>(&step.drift, &costate).to_vector::<N>();
        let expected = step.before.to_vector::<N>();
        self.worst = self.worst.max((back - expected).amax());
        self.size = self.size.max(expected.amax());
        if dynamics.is_limited() {
            self.inputs(dynamics.input_residual(&step.pose, &step.after), step.kick.effort);
        }
        self.steps += 1;
    }

    fn close(&self) -> f64 {
        let costates = self.worst / self.size.max(1.0);
        let inputs = self.worst_input / self.largest_output.max(1.0);
        let complete = self.steps == self.bvp.dynamics.grid.steps();
        if complete { costates.max(inputs) } else { f64::INFINITY }
    }
}

/// Counts the conjugate points inside the maneuver: the independent directions within the
/// constraints in which the cost decreases to second order. Returns `None` if no such direction
/// exists but the cost is constant to second order along some direction. That is a conjugate point
/// exactly at the end, as on a circle of equally costly paths.
///
/// With `Z_k = Ψ₁₂(k)`, `Λ_k` the derivative of the costate and `Q = G Gᵀ` the inputs' authority, a
/// step meets as many conjugate points as
///
/// ```text
/// I + Gᵀ Λ_k Z_{k+1}⁻¹ G = G⁻¹ A_k Z_k Z_{k+1}⁻¹ G
/// ```
///
/// has negative eigenvalues: the discrete Riccati condition. Unlike sign changes of `det Ψ₁₂(k)` it
/// counts double points twice. If `Ψ₁₂(k)` becomes singular after it had an inverse, or is singular
/// at the end, round-off would decide, and the inertia of the accessory problem is counted instead.
pub(crate) fn conjugate_points<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Option<usize> {
    if bvp.dynamics.is_limited() {
        return accessory::conjugate_points(bvp, costate);
    }
    let mut counter = Counter::new(bvp);
    let (_, psi) = bvp.sweep_conjugate(costate, |step| counter.step(step)).ok()?;
    let full = rank_and_condition(&psi).0 == N;
    let counted = if full { counter.close(&psi) } else { None };
    counted.or_else(|| accessory::conjugate_points(bvp, costate))
}

/// Counter of conjugate points over the nodes of a sweep.
struct Counter<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    root: InputMatrices,
    /// Whether the sensitivity Ψ₁₂ was invertible at the previous node.
    regular: bool,
    /// Whether the sensitivity Ψ₁₂ was invertible at two consecutive nodes at least once.
    ever: bool,
    /// Whether the sensitivity Ψ₁₂ became singular again at a later node.
    lost: bool,
    total: usize,
    /// Attitude and derivatives of the costate at the closing half kick of Lie–Verlet.
    last: Option<(Matrix3, SMatrix<f64, N, N>)>,
}

impl<'a, const N: usize> Counter<'a, N> {
    fn new(bvp: &'a BoundaryValueProblem<'a, N>) -> Self {
        let root = bvp.dynamics.input_root();
        Self { bvp, root, regular: false, ever: false, lost: false, total: 0, last: None }
    }

    fn step(&mut self, step: &Step<N>) {
        let grid = &self.bvp.dynamics.grid;
        let Step { index, pose, columns, .. } = step;
        if *index == grid.steps() && grid.has_half_kicks() {
            self.last = Some((pose.attitude, columns.costate()));
            return;
        }
        let root = self.root.at(&pose.attitude).map(|root| root * grid.full_kick(*index).sqrt());
        self.meet(&columns.state(), &columns.costate(), &root);
    }

    /// Returns the number of conjugate points; `None` if a step could not be counted because Ψ₁₂
    /// was singular on the way or at the end.
    fn close(mut self, psi: &SMatrix<f64, N, N>) -> Option<usize> {
        if let Some((attitude, dual)) = self.last.take() {
            // The closing half kick has half the authority.
            let grid = &self.bvp.dynamics.grid;
            let root = self.root.at(&attitude).map(|root| root * grid.kick(grid.steps()).sqrt());
            self.meet(psi, &dual, &root);
        }
        (self.ever && !self.lost).then_some(self.total)
    }

    fn meet(&mut self, z: &SMatrix<f64, N, N>, dual: &SMatrix<f64, N, N>, root: &[Matrix3; 2]) {
        // Near the start Ψ₁₂(k) is rank-deficient by construction, or too ill-conditioned for a
        // decision.
        let met = kernel::negative(z, dual, root);
        if let Some(negative) = met
            && self.regular
        {
            self.total += negative;
            self.ever = true;
        }
        self.lost |= self.ever && met.is_none();
        self.regular = met.is_some();
    }
}

#[cfg(test)]
mod tests;
