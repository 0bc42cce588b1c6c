//! The check that recorded rates are the derivatives of the recorded attitudes.
//!
//! Consider rows `h` apart with the turn `φ`. The rotation vector has the slopes `h Ω₀` and
//! `J_r⁻¹(φ) h Ω₁`. Half their sum misses `φ` by `O(h³)` for a smooth motion, and by `O(h²)`
//! where its acceleration jumps. The sum of the misses over all rows is `D(h)`, over every second
//! row `D(2h)`. Right rates have `D(h)/D(2h)` about ¼, or ½. Rates in another unit, of another
//! sign, or zero rates have the ratio 1, because their miss does not depend on the distance of
//! the rows. The limit is between the two, `√½`.
//!
//! A mean rate between the rates of its ends is also right, as in a scheme of first order. Only
//! the miss beyond this range counts, `E(h)`. If it stays within the tolerance, the rates fit. If
//! it does not and falls with the distance, the rows are too far apart to decide.

use super::{AttitudeReport, Motion, RATES_AGAINST_ATTITUDES};
use crate::numerics::figures::error;
use crate::verify::Check;
use crate::{Vector3, lie};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The miss over one stretch, and the miss beyond the range of the rates at its ends \[rad\].
struct Missed {
    all: f64,
    beyond: f64,
}

/// Returns the miss over `h` seconds with this turn between rows `from` and `to`.
fn missed(motion: &Motion<'_>, from: usize, to: usize, turn: &Vector3) -> Missed {
    let (rows, open) = (motion.rows, motion.rows.rounding);
    let h = rows.time[to] - rows.time[from];
    let ends = [h * rows.rate[from], lie::right_jacobian_inverse(turn) * (h * rows.rate[to])];
    let printed = 2.0 * open.attitude + h * open.rate + 2.0 * open.time * turn.norm() / h;
    let all = ((turn - 0.5 * (ends[0] + ends[1])).norm() - printed).max(0.0);
    Missed { all, beyond: (all - 0.5 * (ends[1] - ends[0]).norm()).max(0.0) }
}

/// Adds the check, or reports it as open.
pub(super) fn judge(motion: &Motion<'_>, report: &mut AttitudeReport) {
    if motion.rows.rate.is_empty() {
        return;
    }
    let (mut single, mut double, mut beyond, mut lone) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..motion.last() {
        if !motion.goes_on(k) {
            continue;
        }
        let turn = motion.turn(k);
        let here = missed(motion, k, k + 1, &turn);
        let has_next = k + 1 < motion.last() && motion.goes_on(k + 1);
        let has_before = k > 0 && motion.goes_on(k - 1);
        if has_next || has_before {
            single += here.all;
            beyond += here.beyond;
        } else {
            lone += here.beyond;
        }
        // Beyond half a turn the rows do not determine the motion of the body.
        if has_next && turn.norm() + motion.turn(k + 1).norm() < PI {
            let both = lie::minus(&motion.attitude[k + 2], &motion.attitude[k]);
            double += 0.5 * missed(motion, k, k + 2, &both).all;
        }
    }
    let apart = single <= FRAC_1_SQRT_2 * double;
    let within = beyond <= motion.tolerance;
    if within || apart || double == 0.0 {
        let undecided = if within { lone } else { beyond + lone };
        if undecided > motion.tolerance {
            report.open.push(format!(
                "whether the rates are the derivatives of the attitudes: integrated over the rows \
                they miss by {} rad, and the rows are too far apart to decide",
                error(undecided)
            ));
        }
        let value = if within { beyond } else { 0.0 };
        report.checks.push(checked(value, motion.tolerance));
    } else {
        report.checks.push(checked(beyond, motion.tolerance));
    }
}

fn checked(value: f64, limit: f64) -> Check {
    Check { name: RATES_AGAINST_ATTITUDES.into(), value, limit, passed: value <= limit }
}
