//! Cost of the slew about a fixed axis, with which the cost of a plan is compared.
//!
//! A free body that turns about a fixed axis e with the angle θ(t), ω = θ̇, needs the torque
//! `Je ω̇ + (e × Je) ω²`. Its effort is `½ ∫ (a ω̇² + b ω⁴) dt` with `a = |Je|²` and
//! `b = |e × Je|²` in the norm `A = (B W⁻¹ Bᵀ)⁻¹`: the mixed term is the derivative of `ω³/3`,
//! which vanishes from rest to rest. The function minimises over all θ(t) with the requested angle
//! and duration. Let `ω = θ f(t/T)/T`: the minimum is `θ²/(2T³) min ∫ (a f'² + bθ² f⁴)` over f that
//! are 0 at both ends and have the mean 1. The problem is convex.

use slewkit::lie;
use slewkit::maneuver::{Motion, Objective, Problem, Solution};
use slewkit::mechanics::AxisFrame;

/// Number of nodes with which f is discretised. The relative error of the integral is about 1e-5,
/// the inverse square of this number.
const NODES: usize = 256;

/// Largest number of Newton steps. The problem is a convex polynomial of degree four, for which
/// about five steps suffice.
const MOST_STEPS: usize = 60;

/// Product of rate and duration below which a body counts as at rest \[rad\].
const REST: f64 = 1e-9;

/// Returns the minimum cost of the shorter turn about a fixed axis, in the duration of the plan,
/// with the objective of the plan and without limits. Returns `None` in these cases, for which the
/// cost is not known:
/// - the body is in a force field
/// - a rate at the start or the end is not zero
/// - the objective is fuel
/// - wheels store momentum
pub(super) fn cost(problem: &Problem, solution: &Solution) -> Option<f64> {
    if let Some(duration) = solution.switching.as_ref().and_then(|switching| switching.eigenaxis_s) {
        return Some(duration);
    }
    let Objective::Effort(weights) = &problem.objective else { return None };
    let duration = solution.duration(problem);
    let rests =
        [&problem.start, &problem.end].iter().all(|state| state.angular_velocity.norm() * duration <= REST);
    let still = problem.environment.frame_rate().norm() == 0.0 && problem.environment.is_free();
    if problem.motion != Motion::Attitude
        || problem.ends_in_any_attitude()
        || !still
        || !rests
        || problem.actuation.stored_momentum().norm() > 0.0
    {
        return None;
    }
    if problem.actuation.torque.frame() != AxisFrame::Body {
        return None;
    }
    let turn = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = turn.norm();
    if angle <= REST {
        return None;
    }
    let inverse = weights.torque(&problem.actuation).authority.try_inverse()?;
    let axis = turn / angle;
    let along = problem.body.inertia.j() * axis;
    let across = match &problem.actuation.wheels {
        // The total momentum stays zero, so the gyroscopic torque vanishes.
        Some(_) => axis * 0.0,
        None => axis.cross(&along),
    };
    let (a, b) = (along.dot(&(inverse * along)), across.dot(&(inverse * across)));
    let least = profile(b * angle * angle / a)?;
    let effort = 0.5 * angle * angle * a * least / duration.powi(3);
    let cost = effort + weights.time_price.unwrap_or(0.0) * duration;
    cost.is_finite().then_some(cost)
}

/// Returns `min ∫ (f'² + k f⁴)` over all f on the unit interval that are 0 at both ends and have
/// the mean 1, by Newton's method on a grid.
fn profile(k: f64) -> Option<f64> {
    let h = 1.0 / NODES as f64;
    let inner = NODES - 1;
    let at = |f: &[f64], index: usize| if index == 0 || index > inner { 0.0 } else { f[index - 1] };
    let value = |f: &[f64]| {
        (0..=inner).map(|i| (at(f, i + 1) - at(f, i)).powi(2) / h + k * h * at(f, i).powi(4)).sum::<f64>()
    };
    let mut f: Vec<f64> = (1..=inner).map(|i| i as f64 * h).map(|s| 6.0 * s * (1.0 - s)).collect();
    let mean = h * f.iter().sum::<f64>();
    f.iter_mut().for_each(|value| *value /= mean);
    let mut reached = value(&f);
    for _ in 0..MOST_STEPS {
        let gradient: Vec<f64> = (1..=inner)
            .map(|i| {
                2.0 * (2.0 * at(&f, i) - at(&f, i - 1) - at(&f, i + 1)) / h + 4.0 * k * h * at(&f, i).powi(3)
            })
            .collect();
        let diagonal: Vec<f64> = f.iter().map(|value| 4.0 / h + 12.0 * k * h * value * value).collect();
        let (down, ones) =
            (thomas(&diagonal, -2.0 / h, &gradient), thomas(&diagonal, -2.0 / h, &vec![1.0; inner]));
        // The Newton step leaves the mean of f unchanged.
        let multiplier = down.iter().sum::<f64>() / ones.iter().sum::<f64>();
        let step: Vec<f64> = down.iter().zip(&ones).map(|(down, one)| multiplier * one - down).collect();
        let mut length = 1.0;
        let next = loop {
            let tried: Vec<f64> = f.iter().zip(&step).map(|(f, step)| f + length * step).collect();
            let found = value(&tried);
            if found < reached {
                break Some((tried, found));
            }
            length *= 0.5;
            if length < 1e-6 {
                break None;
            }
        };
        // If no shorter step reduces the value, f is the minimum up to round-off.
        let Some((tried, found)) = next else { break };
        let gained = reached - found;
        (f, reached) = (tried, found);
        if gained <= 1e-12 * reached {
            break;
        }
    }
    reached.is_finite().then_some(reached)
}

/// Solves the tridiagonal system with the diagonal `diagonal`, the constant `beside` in both
/// off-diagonals, and the right-hand side `right` (Thomas algorithm).
fn thomas(diagonal: &[f64], beside: f64, right: &[f64]) -> Vec<f64> {
    let count = diagonal.len();
    let (mut over, mut found) = (vec![0.0; count], vec![0.0; count]);
    for i in 0..count {
        let (before, left) = if i == 0 { (0.0, 0.0) } else { (over[i - 1], found[i - 1]) };
        let side = if i == 0 { 0.0 } else { beside };
        let pivot = diagonal[i] - side * before;
        over[i] = beside / pivot;
        found[i] = (right[i] - side * left) / pivot;
    }
    for i in (0..count.saturating_sub(1)).rev() {
        found[i] -= over[i] * found[i + 1];
    }
    found
}

#[cfg(test)]
mod tests {
    use super::profile;

    /// Without the gyroscopic torque, the optimal profile is f = 6s(1−s), with the value 12. With
    /// this torque, the minimum lies between the sum of the two separate minima and the value of
    /// this profile, in which k ∫ f⁴ = k 6⁴ B(5, 5).
    #[test]
    fn the_least_turn_has_the_closed_form_of_a_cubic_and_its_bounds() {
        // The value on the grid of step h is 12/(1 − h²), because the sum of s(1 − s) h is (1 −
        // h²)/6.
        let h2 = (super::NODES as f64).powi(-2);
        assert!((profile(0.0).unwrap() * (1.0 - h2) / 12.0 - 1.0).abs() < 1e-9);
        for k in [0.01, 1.0, 30.0, 1e4] {
            let least = profile(k).unwrap();
            let cubic = 12.0 + k * 1296.0 / 630.0;
            assert!(12.0_f64.max(k) < least && least < cubic * (1.0 + 2.0 * h2), "{k}: {least} of {cubic}");
        }
        // If the gyroscopic torque dominates, the rate is nearly constant. The minimum is then at
        // most the cost of a profile with ramps of length w, which has a closed form.
        let (k, w) = (1e4_f64, 0.02_f64);
        let level = 1.0 / (1.0 - w);
        let ramps = 2.0 * level.powi(2) / w + k * level.powi(4) * (1.0 - 1.6 * w);
        assert!(profile(k).unwrap() < ramps);
    }
}
