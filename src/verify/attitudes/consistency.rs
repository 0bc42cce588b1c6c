//! The check that recorded rates are the derivatives of the recorded attitudes.
//!
//! Consider two rows `h` apart with the turn `φ`. The rotation vector has the slopes `h Ω₀` and
//! `J_r⁻¹(φ) h Ω₁` at the rows. Half their sum differs from `φ` by `O(h³)` for a smooth motion, and
//! by `O(h²)` where the acceleration jumps. `D(h)` is the sum of these differences over all rows,
//! and `D(2h)` the sum over every second row. Correct rates have a ratio `D(h)/D(2h)` of about ¼ or
//! ½. Rates in a wrong unit, with a wrong sign, or equal to zero have the ratio 1, because their
//! difference does not depend on the spacing of the rows. The limit `√½` lies between.
//!
//! A mean rate between the rates of its two rows is also correct, as in a scheme of first order.
//! Only the difference beyond this range, `E(h)`, counts. If it is within the tolerance, the rates
//! are consistent. If it exceeds the tolerance but falls with the spacing, the rows are too far
//! apart to decide.

use super::{AttitudeReport, Motion, RATES_AGAINST_ATTITUDES};
use crate::numerics::figures::error;
use crate::verify::Check;
use crate::{Vector3, lie};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The difference between turn and mean rate over an interval, and its part beyond the range of the
/// rates at the two rows \[rad\].
struct Missed {
    all: f64,
    beyond: f64,
}

/// Returns the difference between turn and mean rate over the interval between rows `from` and
/// `to`, beyond the error of the printed digits. The body turns by the rotation vector `turn`
/// \[rad\].
fn missed(motion: &Motion<'_>, from: usize, to: usize, turn: &Vector3) -> Missed {
    let (rows, open) = (motion.rows, motion.rows.rounding);
    let h = rows.time[to] - rows.time[from];
    let ends = [h * rows.rate[from], lie::right_jacobian_inverse(turn) * (h * rows.rate[to])];
    let printed = 2.0 * open.attitude + h * open.rate + 2.0 * open.time * turn.norm() / h;
    let all = ((turn - 0.5 * (ends[0] + ends[1])).norm() - printed).max(0.0);
    Missed { all, beyond: (all - 0.5 * (ends[1] - ends[0]).norm()).max(0.0) }
}

/// Adds the check to the report, or reports that it cannot be decided.
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
        // For turns beyond 180° the rows do not determine the motion of the body.
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
