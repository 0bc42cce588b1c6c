//! Nodes for the lifted Newton: a smooth path between the boundary states and its inverse dynamics.
//!
//! Attitude `R_0 exp S(a(t))` with a cubic `a` that meets both rates, position a cubic; the torques
//! that this motion needs give `λ^Π = −(B W⁻¹Bᵀ)⁻¹ τ`, and the continuous costate equation
//! `λ̇^Π = −J⁻¹λ^R − Ω × λ^Π − J⁻¹(λ^Π × Π)` gives `λ^R`.

use super::starts::wound;
use crate::Vector3;
use crate::lie;
use crate::mechanics::environment::Wrench;
use crate::numerics::compensated::Sum;
use crate::optimize::methods::lifted::Nodes;
use crate::optimize::step::{Costate, Point, StepError};
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;
use std::f64::consts::{PI, TAU};

/// Cubic through `(0, a0, v0)` and `(1, a1, v1)`: value and slope at `t`.
fn cubic(t: f64, a0: &Vector3, v0: &Vector3, a1: &Vector3, v1: &Vector3) -> (Vector3, Vector3) {
    let (t2, t3) = (t * t, t * t * t);
    let value = a0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + v0 * (t3 - 2.0 * t2 + t)
        + a1 * (3.0 * t2 - 2.0 * t3)
        + v1 * (t3 - t2);
    let slope =
        (a1 - a0) * (6.0 * t - 6.0 * t2) + v0 * (3.0 * t2 - 4.0 * t + 1.0) + v1 * (3.0 * t2 - 2.0 * t);
    (value, slope)
}

/// Nodes along the path of `turns` more turns than the shortest rotation from start to target, bent by
/// `bump` \[rad\] in its middle.
pub(crate) fn nodes<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    turns: i32,
    bump: &Vector3,
) -> Result<Nodes<N>, StepError> {
    let short = lie::minus(&bvp.terminal.target().attitude.value, &bvp.start.attitude.value);
    along(bvp, &wound(&short, turns), bump)
}

/// Nodes along the path with the rotation vector `rotation` from the start, its body axes.
fn along<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    rotation: &Vector3,
    bump: &Vector3,
) -> Result<Nodes<N>, StepError> {
    let dynamics = &bvp.dynamics;
    let (start, target) = (&bvp.start, bvp.terminal.target());
    let grid = &dynamics.grid;
    let frame = dynamics.frame_rate();
    let rate =
        |point: &Point| dynamics.j_inverse * point.momentum.value - point.attitude.value.tr_mul(&frame);
    // Near a full turn J_r⁻¹ is singular; the slope there is only a guess.
    let away = (rotation.norm() - TAU).abs() > 0.5;
    let end_slope = if away { lie::right_jacobian_inverse(rotation) * rate(target) } else { rate(target) };
    let zero = Vector3::zeros();
    let mut points = Vec::with_capacity(grid.steps() + 1);
    for index in 0..=grid.steps() {
        let t = grid.after(index);
        let (mut a, mut slope) = cubic(t, &zero, &rate(start), rotation, &end_slope);
        // sin² leaves both ends and their rates as they are.
        a += bump * (PI * t).sin().powi(2);
        slope += bump * (PI * (TAU * t).sin());
        let attitude = start.attitude.value * lie::exp(&a);
        let omega = lie::right_jacobian(&a) * slope + attitude.tr_mul(&frame);
        let (position, velocity) = cubic(
            t,
            &start.position.value,
            &start.linear_momentum.value,
            &target.position.value,
            &target.linear_momentum.value,
        );
        points.push(Point {
            position: Sum::new(position),
            linear_momentum: Sum::new(velocity),
            attitude: Sum::new(attitude),
            momentum: Sum::new(dynamics.j * omega),
        });
    }
    let costates = inverse_dynamics(bvp, &points)?;
    Ok(Nodes { points, costates })
}

/// Costates `λ_{−1} … λ_{N−1}` of the torques and forces that a motion needs.
fn inverse_dynamics<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    points: &[Point],
) -> Result<Vec<SVector<f64, N>>, StepError> {
    let dynamics = &bvp.dynamics;
    let grid = &dynamics.grid;
    let inverse = dynamics.inverse_authority();
    let duals: Vec<(Vector3, Vector3)> = points
        .windows(2)
        .enumerate()
        .map(|(step, pair)| {
            let h = grid.full_kick(step + 1);
            let mut drifted = pair[0];
            // Π' of the free step is FᵀΠ with the path's own relative attitude.
            let f = pair[0].attitude.value.tr_mul(&dynamics.unturned(step, &pair[1].attitude.value));
            drifted.momentum = Sum::new(f.tr_mul(&pair[0].momentum.value));
            drifted.attitude = pair[1].attitude;
            drifted.position = pair[1].position;
            dynamics.bare_kick::<N>(&mut drifted, h, &Wrench::zero());
            let needed = Wrench {
                force: (pair[1].linear_momentum.value - drifted.linear_momentum.value) / h,
                moment: (pair[1].momentum.value - drifted.momentum.value) / h,
            };
            inverse.dual(&pair[1].attitude.value, &needed)
        })
        .collect();
    let mut costates = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        // Dual k belongs to node k+1; the first node takes that of the second.
        let here = index.saturating_sub(1).min(duals.len() - 1);
        let next = (here + 1).min(duals.len() - 1);
        let before = if next == here { here.saturating_sub(1) } else { here };
        let span = grid.between((before + 1).min(next), next + 1);
        let (gamma, pi) = duals[here];
        let gamma_slope = (duals[next].0 - duals[before].0) / span;
        let pi_slope = (duals[next].1 - duals[before].1) / span;
        let momentum = point.momentum.value;
        let omega = dynamics.j_inverse * momentum;
        let zeta = -(dynamics.j * (pi_slope + omega.cross(&pi))) - pi.cross(&momentum);
        let costate: SVector<f64, N> = Costate { x: -gamma_slope, gamma, zeta, pi }.to_vector();
        if !costate.iter().all(|value| value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        costates.push(costate);
    }
    Ok(costates)
}
