//! Minimum time of a turn about the eigenaxis, for comparison, and a test whether the long way may
//! be as quick as the short way.
//!
//! On the path `R = exp(θ n)` the torque is `J n θ¨ + θ'² n×Jn`. With `p = θ'²/2` the limits of the
//! inputs bound `dp/dθ = θ¨`, from above during acceleration and from below during deceleration.

use super::extremal::{Extremal, TorqueLimit};
use super::tuning::SAME;
use super::tuning::limits::EIGENAXIS_PARTS;
use crate::{Matrix3, Vector3, lie};
use std::f64::consts::TAU;

/// Returns the duration (scaled) of the rest-to-rest turn about the eigenaxis under the limits.
/// Returns `None` if the body does not rest at both ends, if there is no turn, or if individual
/// limits apply to other than three inputs, so that inputs and torque do not determine each other.
pub(crate) fn duration(extremal: &Extremal) -> Option<f64> {
    let phi = lie::log(&extremal.end_attitude);
    let angle = phi.norm();
    if extremal.start_rate.norm() + extremal.end_rate.norm() > 0.0 || angle < 1e-12 {
        return None;
    }
    let n = phi / angle;
    let (push, turn) = (extremal.j * n, n.cross(&(extremal.j * n)));
    // Bounds of the acceleration at p.
    let bounds: Box<dyn Fn(f64) -> Option<(f64, f64)>> = match &extremal.law {
        TorqueLimit::Inputs(axes) if axes.len() == 3 => {
            let inverse = Matrix3::from_columns(&[axes[0], axes[1], axes[2]]).try_inverse()?;
            let (a, b, middle) = (inverse * push, inverse * turn, inverse * extremal.middle);
            let per = a.map(|a| 1.0 / a);
            Box::new(move |p| within(&per, &(2.0 * p * b - middle)))
        }
        TorqueLimit::Inputs(_) => return None,
        TorqueLimit::Norm(limit) => {
            let (limit, push, turn) = (*limit, push.norm(), turn.norm());
            Box::new(move |p| {
                let left = limit * limit - (2.0 * p * turn).powi(2);
                (left > 0.0).then(|| (-left.sqrt() / push, left.sqrt() / push))
            })
        }
    };
    let step = angle / EIGENAXIS_PARTS as f64;
    let grown = |up: bool| -> Option<Vec<f64>> {
        let slope = |p: f64| bounds(p).map(|(least, most)| if up { most } else { -least });
        let mut p = vec![0.0];
        for _ in 0..EIGENAXIS_PARTS {
            let at = p[p.len() - 1];
            // Where the limits allow no acceleration, the speed stays constant.
            let first = slope(at).unwrap_or(0.0);
            let next = at + step * slope((at + 0.5 * step * first).max(0.0)).unwrap_or(0.0).max(0.0);
            p.push(next);
        }
        (p[1] > 0.0).then_some(p)
    };
    let (up, down) = (grown(true)?, grown(false)?);
    let speed = |index: usize| (2.0 * up[index].min(down[EIGENAXIS_PARTS - index])).sqrt();
    Some((0..EIGENAXIS_PARTS).map(|index| 2.0 * step / (speed(index) + speed(index + 1))).sum())
}

/// Returns whether the turn by `2π − |phi|` may be as quick as the turn by the rotation vector
/// `phi`, or cost as little. Both times grow with the angle divided by the acceleration (or its
/// square root), and the long way may use the axis of the largest acceleration.
pub(super) fn other_way_may_be_shorter(extremal: &Extremal, phi: &Vector3) -> bool {
    let angle = phi.norm();
    let Some(axis) = phi.try_normalize(0.0) else { return false };
    let (along, largest) = accelerations(extremal, &axis);
    (TAU - angle) * along < angle * largest
}

/// Returns the acceleration that the inputs can give about `axis` alone, with the body at rest, and
/// the largest about any axis. Symmetric limits allow a zonotope of accelerations, whose faces have
/// the normals `bᵢ × bⱼ`. If all inputs are in one plane, the first value is zero, also about axes
/// in the plane; both homotopy classes are tried then.
pub(super) fn accelerations(extremal: &Extremal, axis: &Vector3) -> (f64, f64) {
    let b: Vec<Vector3> = match &extremal.law {
        TorqueLimit::Inputs(axes) => axes.iter().map(|a| extremal.j_inverse * a).collect(),
        TorqueLimit::Norm(limit) => {
            let least = extremal.j.symmetric_eigenvalues().min();
            return (limit / (extremal.j * axis).norm(), limit / least);
        }
    };
    let (mut along, mut largest) = (f64::INFINITY, 0.0_f64);
    for (i, j) in (0..b.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
        // Parallel inputs do not span a face.
        let Some(normal) = b[i].cross(&b[j]).try_normalize(SAME * b[i].norm() * b[j].norm()) else {
            continue;
        };
        let others = || b.iter().enumerate().filter(|(k, _)| ![i, j].contains(k)).map(|(_, b)| b);
        let support: f64 = others().map(|b| b.dot(&normal).abs()).sum();
        along = along.min(support / normal.dot(axis).abs().max(f64::MIN_POSITIVE));
        let middle: Vector3 = others().map(|b| b * b.dot(&normal).signum()).sum();
        for corner in [b[i] + b[j], b[i] - b[j], b[j] - b[i], -b[i] - b[j]] {
            largest = largest.max((middle + corner).norm());
        }
    }
    (along, largest)
}

/// Returns the interval of accelerations `x` for which every `|x/c + b| ≤ 1`; `None` if it is
/// empty.
fn within(c: &Vector3, b: &Vector3) -> Option<(f64, f64)> {
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for (c, b) in c.iter().zip(b) {
        if c.abs() > 1e12 {
            if b.abs() > 1.0 {
                return None;
            }
            continue;
        }
        let (middle, reach) = (-b * c, c.abs());
        least = least.max(middle - reach);
        most = most.min(middle + reach);
    }
    (least < most).then_some((least, most))
}
