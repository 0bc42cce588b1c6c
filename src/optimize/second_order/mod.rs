//! What a plan proves by itself: stationarity, rank and condition of Ψ₁₂, conjugate points.

mod accessory;

use crate::maneuver::solution::Optimality;
use crate::numerics::factor::{Factor, rank_and_condition};
use crate::optimize::step::Sensitivity;
use crate::optimize::sweep::{BoundaryValueProblem, Node};
use nalgebra::{SMatrix, SVector};

/// First- and second-order optimality of the extremal from `costate`.
pub(crate) fn optimality<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Optimality {
    let psi = bvp.sweep_linearized(costate).ok().map(|(_, psi)| psi);
    let (rank, condition) = psi.as_ref().map_or((0, f64::INFINITY), rank_and_condition);
    Optimality {
        stationarity: stationarity(bvp, costate),
        conjugate_points: match &psi {
            Some(psi) if !bvp.dynamics.is_limited() => conjugate_points_of(bvp, costate, psi),
            _ => conjugate_points(bvp, costate),
        },
        rank,
        condition,
    }
}

/// Largest residual `|λ_{k−1} − A_kᵀ λ_k|` of the costate recursion, recomputed backward by `A_kᵀ`
/// where the sweep went forward by `A_k⁻ᵀ`, relative to the largest costate; under limits also the largest
/// projection residual of the inputs, relative to the largest they give.
fn stationarity<const N: usize>(bvp: &BoundaryValueProblem<N>, costate: &SVector<f64, N>) -> f64 {
    let dynamics = &bvp.dynamics;
    let mut before: Option<Node> = None;
    let (mut worst, mut size) = (0.0f64, 0.0f64);
    let (mut worst_input, mut largest_output) = (0.0f64, 0.0f64);
    let swept = bvp.sweep_observed(costate, |node| {
        if let Some(before) = &before {
            let costate = node.costate.to_vector::<N>();
            let expected = before.costate.to_vector::<N>();
            match dynamics.costate_before::<N>(before.index, &before.point, &costate) {
                Ok(back) => worst = worst.max((back - expected).amax()),
                Err(_) => worst = f64::INFINITY,
            }
            size = size.max(expected.amax());
        }
        if dynamics.is_limited() {
            let (pose, costate) = (node.point.pose(), &node.costate);
            worst_input = worst_input.max(dynamics.input_residual(&pose, costate));
            let kick = dynamics.kick::<N>(&pose, costate);
            largest_output = largest_output.max(kick.effort.sqrt());
        }
        before = Some(node);
    });
    let costates = worst / size.max(1.0);
    let inputs = worst_input / largest_output.max(1.0);
    if swept.is_err() { f64::INFINITY } else { costates.max(inputs) }
}

/// Number of conjugate points inside the maneuver: directions in which the cost has a decrease of
/// second order within the constraints. `None` where Ψ₁₂ never reaches its rank before the end.
///
/// With `Z_k = Ψ₁₂(k)`, `Λ_k` the derivative of the costate and `Q = G Gᵀ` the inputs' authority, a
/// step meets as many conjugate points as
///
/// ```text
/// I + Gᵀ Λ_k Z_{k+1}⁻¹ G = G⁻¹ A_k Z_k Z_{k+1}⁻¹ G
/// ```
///
/// has negative eigenvalues: the discrete Riccati condition. Unlike sign changes of `det Ψ₁₂(k)` it
/// counts double points twice. Under a symmetry the inverse is the one within the rank: what the
/// inputs reach, the range of G, lies in it.
pub(crate) fn conjugate_points<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
) -> Option<usize> {
    if bvp.dynamics.is_limited() {
        return accessory::conjugate_points(bvp, costate);
    }
    let (_, psi) = bvp.sweep_linearized(costate).ok()?;
    conjugate_points_of(bvp, costate, &psi)
}

/// The same without limits, from Ψ₁₂ at the end.
fn conjugate_points_of<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
    psi: &SMatrix<f64, N, N>,
) -> Option<usize> {
    let dynamics = &bvp.dynamics;
    let grid = &dynamics.grid;
    let (steps, half_end) = (grid.steps(), grid.has_half_kicks());
    let root = dynamics.input_root();
    let full = rank_and_condition(psi).0;
    let mut counter = Counter { full, regular: false, ever: false, total: 0 };
    let mut index = 0;
    let mut last = None;
    bvp.sweep_conjugate(costate, |attitude, columns: &Sensitivity<N>| {
        index += 1;
        if index < steps || !half_end {
            let g = root.at::<N>(attitude) * grid.full_kick(index).sqrt();
            counter.meet(&columns.state(), &columns.costate(), &g);
        } else {
            last = Some((*attitude, columns.costate()));
        }
    })
    .ok()?;
    if let Some((attitude, dual)) = last {
        // The closing half kick of Lie–Verlet has half the authority.
        let g = root.at::<N>(&attitude) * grid.kick(steps).sqrt();
        counter.meet(psi, &dual, &g);
    }
    counter.ever.then_some(counter.total)
}

/// Counts conjugate points node by node.
struct Counter {
    /// Rank of Ψ₁₂ at the end.
    full: usize,
    /// Whether the node before had it.
    regular: bool,
    /// Whether two nodes in a row ever had it.
    ever: bool,
    total: usize,
}

impl Counter {
    fn meet<const N: usize>(
        &mut self,
        z: &SMatrix<f64, N, N>,
        dual: &SMatrix<f64, N, N>,
        g: &SMatrix<f64, N, N>,
    ) {
        let factor = Factor::new(z);
        // Near the start Ψ₁₂(k) is short of rank by construction, or too ill-conditioned to tell.
        let regular =
            if self.full == N { !factor.is_singular() } else { rank_and_condition(z).0 == self.full };
        if regular && self.regular {
            let form = SMatrix::identity() + g.tr_mul(&(dual * factor.solve_matrix(g)));
            self.total += negative_pivots(&form);
            self.ever = true;
        }
        self.regular = regular;
    }
}

/// Negative eigenvalues of a symmetric matrix: the negative pivots of `L D Lᵀ` (Sylvester's law).
fn negative_pivots<const N: usize>(form: &SMatrix<f64, N, N>) -> usize {
    let mut a = (form + form.transpose()) * 0.5;
    let mut negative = 0;
    for pivot in 0..N {
        let d = a[(pivot, pivot)];
        negative += usize::from(d < 0.0);
        for row in pivot + 1..N {
            let factor = a[(row, pivot)] / d;
            for column in pivot + 1..N {
                a[(row, column)] -= factor * a[(pivot, column)];
            }
        }
    }
    negative
}

#[cfg(test)]
mod tests;
