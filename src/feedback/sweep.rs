//! Backward sweeps along the linearised steps of a plan, for any number of states and inputs
//! (`linear_plan::stage`).

use super::{Kind, NoGains};
use crate::optimize::discrete::linear_plan::Stage;
use nalgebra::{DMatrix, SMatrix};

type Square<const N: usize> = SMatrix<f64, N, N>;

/// Threshold on the singular values of `Z`, relative to the largest one. Directions with smaller
/// singular values count as uncontrollable.
const UNREACHED: f64 = 1e-11;

/// The result of a backward sweep, with the symbols of `linear_plan::stage`. `duals` holds `(h + U
/// S)⁻¹(V + BᵀP)` of each step, from which `W⁻¹Bᵀ` gives the inputs; `to_go` holds the matrix `P`
/// of the cost to go.
pub(super) struct Swept<const N: usize, const C: usize> {
    pub duals: Vec<SMatrix<f64, C, N>>,
    pub to_go: Vec<Square<N>>,
    pub frozen_from: usize,
}

/// Computes the cheapest corrections that bring the motion to the end, for `count` steps. The third
/// argument is `(Z_N, Λ_{N−1})`: the free part of the terminal states, and the terminal costates.
/// `freeze` is the fraction of the steps at the end without gains of their own.
pub(super) fn neighbouring<'a, const N: usize, const C: usize>(
    count: usize,
    stage: impl Fn(usize) -> &'a Stage<N, C>,
    (mut z, mut dual): (Square<N>, Square<N>),
    freeze: f64,
) -> Result<Swept<N, C>, NoGains> {
    let held =
        if freeze > 0.0 { Kind::LEAST_FROZEN.max((freeze * count as f64).round() as usize) } else { 0 };
    // Step N − held is the last step with gains of its own. The first step always has gains of its
    // own.
    let frozen_from = (count + 1).saturating_sub(held).clamp(1, count);
    let mut duals = vec![SMatrix::zeros(); count];
    let mut to_go = vec![Square::zeros(); count];
    for k in (0..count).rev() {
        let stage = stage(k);
        let step = stage.eliminated();
        let before = step.forward.try_inverse().ok_or(NoGains::NotFinite)?;
        z = before * (z + step.quadratic * dual);
        if k < frozen_from {
            let (inverse, all) = inverse_of(&z).ok_or(NoGains::Unreachable)?;
            if k == 0 && !all {
                return Err(NoGains::Unreachable);
            }
            let p = dual * inverse;
            duals[k] = step.per_time * (stage.by_state + stage.b.transpose() * p);
            to_go[k] = p;
        }
        dual = step.back * dual + step.curvature * z;
        let size = z.amax().max(dual.amax());
        if !(size > 0.0 && size.is_finite()) {
            return Err(NoGains::NotFinite);
        }
        z /= size;
        dual /= size;
    }
    Ok(Swept { duals, to_go, frozen_from })
}

/// Computes the linear-quadratic regulator for the running and the terminal weight of the state.
/// The terminal weight also applies at the nodes `stops`, in ascending order.
pub(super) fn regulator<'a, const N: usize, const C: usize>(
    count: usize,
    stage: impl Fn(usize) -> &'a Stage<N, C>,
    [running, end]: [Square<N>; 2],
    stops: &[usize],
) -> Swept<N, C> {
    let mut p = end;
    let mut duals = vec![SMatrix::zeros(); count];
    let mut to_go = vec![Square::zeros(); count];
    for k in (0..count).rev() {
        // The gain `K = (hW + B̄ᵀP B̄)⁻¹ B̄ᵀP A`, written for its torque:
        // `S (hI + B̄ᵀP B̄ S)⁻¹ B̄ᵀP A`.
        let &Stage { a, b, authority, length, .. } = stage(k);
        let b_p = b.transpose() * p;
        let inner = Square::<C>::from_diagonal_element(length) + b_p * b * authority;
        let dual = inner.try_inverse().unwrap_or_else(|| Square::repeat(f64::NAN)) * b_p * a;
        let closed = a - b * (authority * dual);
        p = running * length + a.transpose() * p * closed;
        if stops.binary_search(&k).is_ok() {
            p += end;
        }
        p = 0.5 * (p + p.transpose());
        duals[k] = dual;
        to_go[k] = p;
    }
    Swept { duals, to_go, frozen_from: count }
}

/// Returns `Z⁻¹`, and whether it is the full inverse. If inputs at their limits or a terminal kick
/// leave some directions uncontrolled, it is the least-squares inverse. Returns `None` if `Z` is
/// zero or not finite.
fn inverse_of<const N: usize>(z: &Square<N>) -> Option<(Square<N>, bool)> {
    if !z.iter().all(|value| value.is_finite()) {
        return None;
    }
    // If the inverse is below this size, all directions are controllable.
    if let Some(inverse) = z.try_inverse()
        && inverse.norm() * z.norm() * UNREACHED < 1.0
    {
        return Some((inverse, true));
    }
    let svd = DMatrix::from_column_slice(N, N, z.as_slice()).svd(true, true);
    let largest = svd.singular_values.max();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let all = svd.singular_values.min() >= UNREACHED * largest;
    let inverse = svd.pseudo_inverse(UNREACHED * largest).ok()?;
    Some((Square::from_column_slice(inverse.as_slice()), all))
}
