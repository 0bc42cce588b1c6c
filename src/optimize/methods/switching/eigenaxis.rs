//! The shortest turn about a fixed axis, for comparison.
//!
//! On the way `R = exp(θ n)` the torque is `J n θ¨ + θ'² n×Jn`. With `p = θ'²/2` the limits of the inputs bound
//! `dp/dθ = θ¨`, from above while the body is brought up to speed and from below while it is stopped.

use super::extremal::{Extremal, Law};
use super::tuning::limits::EIGENAXIS_PARTS;
use crate::{Matrix3, Vector3, lie};

/// Duration of the turn about the eigenaxis from rest to rest under the limits, scaled; `None` where the body does not
/// rest at both ends or where inputs can stand for each other, so that limits and torque are not one to one.
pub(crate) fn duration(extremal: &Extremal) -> Option<f64> {
    let phi = lie::log(&extremal.end_attitude);
    let angle = phi.norm();
    if extremal.start_rate.norm() + extremal.end_rate.norm() > 0.0 || angle < 1e-12 {
        return None;
    }
    let n = phi / angle;
    let (push, turn) = (extremal.j * n, n.cross(&(extremal.j * n)));
    // Least and largest acceleration at p.
    let bounds: Box<dyn Fn(f64) -> Option<(f64, f64)>> = match &extremal.law {
        Law::Inputs(axes) if axes.len() == 3 => {
            let inverse = Matrix3::from_columns(&[axes[0], axes[1], axes[2]]).try_inverse()?;
            let (a, b, middle) = (inverse * push, inverse * turn, inverse * extremal.middle);
            let per = a.map(|a| 1.0 / a);
            Box::new(move |p| within(&per, &(2.0 * p * b - middle)))
        }
        Law::Inputs(_) => return None,
        Law::Norm(limit) => {
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
            // Where the limits leave no acceleration the speed stays.
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

/// The accelerations `x` for which every `|x/c + b| ≤ 1`.
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
