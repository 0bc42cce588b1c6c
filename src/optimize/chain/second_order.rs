//! The second-order test under limits and constraints.
//!
//! A point that meets the first-order conditions is a strict local minimum where the Hessian of the
//! Lagrangian is positive definite on all directions that dynamics, terminal conditions and acting rows
//! leave. The matrix of the conditions of Karush, Kuhn and Tucker has as many negative eigenvalues as there
//! are such equations and, beyond that, independent directions in which the cost decreases; its `−ε` keeps
//! that true where equations follow from each other. Eliminated stage by stage,
//!
//! ```text
//! S_0 = D_0 ,     S_{k+1} = D_{k+1} − E_kᵀ S_k⁻¹ E_k
//! ```
//!
//! with its blocks `D_k` of the stages and `E_k` between neighbours, the negative eigenvalues of all `S_k`
//! add up (Haynsworth 1968).
//!
//! What counts is the curvature relative to the effort: the test is made for `∇²L ∓ CURVATURE · effort`,
//! so that neither a symmetry nor round-off decides. A row whose multiplier is nothing may act or not. For a
//! minimum it must not be needed; for a decrease it must hold along the direction.
//!
//! # Is a constrained plan a minimum?
//!
//! The inertia of the matrix of Karush, Kuhn and Tucker tells: with as many negative eigenvalues as active equations the
//! Lagrangian is convex along all feasible directions, a strict local minimum; each one more is a way down. It is counted
//! stage by stage on the band (`chain/second_order`), at curvatures slightly raised and lowered; where the two differ the plan
//! says that it is not decided.

use super::Multipliers;
use super::iterate::Iterate;
use super::kkt::{Kkt, KktLayout};
use super::model::Model;
use super::rows::{LimitRows, RowValue};
use crate::numerics::matrix_inertia::MatrixInertia;
use crate::optimize::chain::tuning::*;
use crate::optimize::methods::method::Watch;
use nalgebra::DMatrix;

/// The number of independent directions in which the cost decreases at a polished point; 0: a strict local
/// minimum. `None` where the second derivatives do not decide, there are too many unknowns, or it is stopped.
pub(crate) fn descents(
    model: &Model,
    rows: &LimitRows,
    iterate: &Iterate,
    multipliers: &Multipliers,
    watch: &Watch,
) -> Option<usize> {
    let largest_block = (2 * model.n + model.m + rows.rows.len() / model.steps) as f64;
    if largest_block.powi(3) * model.steps as f64 > MOST_WORK {
        return None;
    }
    let evaluated = iterate.evaluate(model, rows, *watch).ok()?.smooth();
    let largest = multipliers.rows.iter().fold(0.0f64, |largest, value| largest.max(*value));
    let values = || evaluated.rows.iter().zip(&multipliers.rows);
    let is_equation = |row: usize| {
        rows.rows[row].what.is_equation() && matches!(evaluated.rows[row], RowValue::Half { .. })
    };
    let sure: Vec<bool> = values()
        .enumerate()
        .map(|(row, (_, multiplier))| is_equation(row) || *multiplier > SURE * largest)
        .collect();
    let possible: Vec<bool> = values()
        .zip(&sure)
        .map(|((value, _), sure)| *sure || matches!(value, RowValue::Half { c, .. } if *c >= -MET))
        .collect();
    let count = |active: &[bool], shift: f64| -> Option<usize> {
        let kkt = Kkt::of(&evaluated, multipliers, active, PROXIMAL)?;
        let negative = Stages::of(model, &kkt, shift)?.negative(watch)?;
        let acting = active.iter().filter(|active| **active).count();
        negative.checked_sub((model.steps + 1) * model.n + acting + model.terminal_count())
    };
    if count(&sure, -CURVATURE)? == 0 {
        return Some(0);
    }
    count(&possible, CURVATURE).filter(|decreasing| *decreasing > 0)
}

/// The symmetric blocks of the matrix.
struct Stages {
    diagonal: Vec<DMatrix<f64>>,
    /// Between a stage and the next.
    beside: Vec<DMatrix<f64>>,
}

impl Stages {
    /// The blocks, the Hessian with `shift` times the effort added. `None` if the matrix were no chain.
    fn of(model: &Model, kkt: &Kkt, shift: f64) -> Option<Self> {
        let Kkt { layout, entries } = kkt;
        let stages = model.steps + 1;
        let first = |stage: usize| if stage < stages { layout.costate[stage] } else { layout.size };
        let size = |stage: usize| first(stage + 1) - first(stage);
        let mut diagonal: Vec<_> =
            (0..stages).map(|stage| DMatrix::zeros(size(stage), size(stage))).collect();
        let mut beside: Vec<_> =
            (1..stages).map(|stage| DMatrix::zeros(size(stage - 1), size(stage))).collect();
        for (row, column, value) in entries.iter().copied().chain(effort(model, layout, shift)) {
            let stage = layout.costate.partition_point(|start| *start <= row) - 1;
            let other = layout.costate.partition_point(|start| *start <= column) - 1;
            let (i, j) = (row - first(stage), column - first(other));
            match other.checked_sub(stage) {
                // Halves of an element and of its mirror image: the symmetric part.
                Some(0) => {
                    diagonal[stage][(i, j)] += 0.5 * value;
                    diagonal[stage][(j, i)] += 0.5 * value;
                }
                Some(1) => beside[stage][(i, j)] += value,
                Some(_) => return None,
                None => {}
            }
        }
        Some(Self { diagonal, beside })
    }

    /// Number of negative eigenvalues; `None` where a block cannot be eliminated.
    fn negative(self, watch: &Watch) -> Option<usize> {
        let mut negative = 0;
        let mut blocks = self.diagonal.into_iter();
        let mut schur = blocks.next()?;
        for (stage, (block, beside)) in blocks.zip(self.beside).enumerate() {
            if watch.stopped_at(stage) {
                return None;
            }
            negative += MatrixInertia::of(schur.clone(), 0.0).negative;
            let eliminated = schur.lu().solve(&beside)?;
            let next = block - beside.tr_mul(&eliminated);
            schur = 0.5 * (&next + next.transpose());
            if !schur.iter().all(|value| value.is_finite()) {
                return None;
            }
        }
        Some(negative + MatrixInertia::of(schur, 0.0).negative)
    }
}

/// `shift · κ W` of all inputs, as elements.
fn effort<'a>(
    model: &'a Model,
    layout: &'a KktLayout,
    shift: f64,
) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
    let of_stage = move |stage: usize| {
        let (at, weight) = (layout.inputs[stage], model.kick_weight(stage) * shift);
        let element = move |i: usize, j: usize| (at + i, at + j, model.weight[(i, j)] * weight);
        (0..model.m).flat_map(move |i| (0..model.m).map(move |j| element(i, j)))
    };
    (0..=model.steps).flat_map(of_stage)
}

#[cfg(test)]
mod tests;
