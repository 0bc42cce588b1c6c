//! What a plan proves by itself: stationarity, rank and condition of Ψ₁₂, conjugate points.

use crate::dynamics::{Costate, Sensitivity};
use crate::extremal::{Extremal, Node};
use crate::problem::Scheme;
use crate::shooting::factor::{Factor, rank_and_condition};
use crate::solution::Optimality;
use nalgebra::{DMatrix, SMatrix, SVector};

/// First- and second-order optimality of the extremal from `costate`.
pub(crate) fn optimality<const N: usize>(extremal: &Extremal<N>, costate: &SVector<f64, N>) -> Optimality {
    let (rank, condition) = match extremal.sweep_linearized(costate) {
        Ok((_, psi)) => rank_and_condition(&psi),
        Err(_) => (0, f64::INFINITY),
    };
    Optimality {
        stationarity: stationarity(extremal, costate),
        conjugate_points: conjugate_points(extremal, costate),
        rank,
        condition,
    }
}

/// Largest residual `|λ_{k−1} − A_kᵀ λ_k|` of the costate recursion, recomputed backward by `A_kᵀ`
/// where the sweep went forward by `A_k⁻ᵀ`; relative to the largest costate.
fn stationarity<const N: usize>(extremal: &Extremal<N>, costate: &SVector<f64, N>) -> f64 {
    let mut before: Option<Node> = None;
    let (mut worst, mut size) = (0.0f64, 0.0f64);
    let swept = extremal.sweep_observed(costate, |node| {
        if let Some(before) = &before {
            let costate = node.costate.to_vector::<N>();
            let expected = before.costate.to_vector::<N>();
            match extremal.dynamics.costate_before::<N>(&before.point, &costate) {
                Ok(back) => worst = worst.max((back - expected).amax()),
                Err(_) => worst = f64::INFINITY,
            }
            size = size.max(expected.amax());
        }
        before = Some(node);
    });
    if swept.is_err() { f64::INFINITY } else { worst / size.max(1.0) }
}

/// Number of conjugate points inside the maneuver: directions in which the cost has a decrease of
/// second order within the constraints. `None` where Ψ₁₂ never has its full rank.
///
/// With `Z_k = Ψ₁₂(k)`, `Λ_k` the derivative of the costate and `Q = G Gᵀ` the inputs' authority, a
/// step meets as many conjugate points as
///
/// ```text
/// I + Gᵀ Λ_k Z_{k+1}⁻¹ G = G⁻¹ A_k Z_k Z_{k+1}⁻¹ G
/// ```
///
/// has negative eigenvalues: the discrete Riccati condition. Unlike sign changes of `det Ψ₁₂(k)` it
/// counts double points twice.
pub(crate) fn conjugate_points<const N: usize>(
    extremal: &Extremal<N>,
    costate: &SVector<f64, N>,
) -> Option<usize> {
    let dynamics = &extremal.dynamics;
    let steps = dynamics.steps;
    let half_end = dynamics.scheme == Scheme::LieVerlet;
    let mut nodes: Vec<(crate::environment::Pose, Costate)> = Vec::new();
    extremal.sweep_observed(costate, |node| nodes.push((node.point.pose(), node.costate))).ok()?;
    let mut total = 0;
    let mut regular_before = false;
    let mut ever = false;
    let mut index = 0;
    let mut last = None;
    let mut count = |index: usize, z: &SMatrix<f64, N, N>, dual: &SMatrix<f64, N, N>, share: f64| {
        let factor = Factor::new(z);
        let regular = !factor.is_singular();
        if regular && regular_before {
            let (pose, costate) = &nodes[index];
            let q = dynamics.linear_kick::<N>(pose, costate).authority::<N>() * (dynamics.h * share);
            let p = dual * factor.solve_matrix(&SMatrix::identity());
            total += negative_eigenvalues::<N>(&q, &p);
            ever = true;
        }
        regular_before = regular;
    };
    let (_, psi) = extremal
        .sweep_conjugate(costate, |columns: &Sensitivity<N>| {
            index += 1;
            if index < steps || !half_end {
                count(index, &columns.state(), &columns.costate(), 1.0);
            } else {
                last = Some(columns.costate());
            }
        })
        .ok()?;
    if let Some(dual) = last {
        count(steps, &psi, &dual, 0.5);
    }
    ever.then_some(total)
}

/// Negative eigenvalues of `I + Gᵀ P G`, `Q = G Gᵀ`.
fn negative_eigenvalues<const N: usize>(q: &SMatrix<f64, N, N>, p: &SMatrix<f64, N, N>) -> usize {
    let dynamic = DMatrix::from_fn(N, N, |row, column| q[(row, column)]);
    let Some(eigen) = dynamic.try_symmetric_eigen(f64::EPSILON, 1000) else { return 0 };
    let root =
        &eigen.eigenvectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let p = DMatrix::from_fn(N, N, |row, column| p[(row, column)]);
    let form = DMatrix::identity(N, N) + root.transpose() * p * &root;
    let form = 0.5 * (&form + form.transpose());
    if !form.iter().all(|value| value.is_finite()) {
        return 0;
    }
    match form.try_symmetric_eigen(f64::EPSILON, 1000) {
        Some(eigen) => eigen.eigenvalues.iter().filter(|value| **value < 0.0).count(),
        None => 0,
    }
}
