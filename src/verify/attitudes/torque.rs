//! The torques that a free body without wheels needs for the recorded rates and for the recorded
//! attitudes.
//!
//! The momentum in inertial axes changes by the impulse of the torque, so the rates at two rows
//! give the mean torque between them. The attitudes give mean rates between rows, which are
//! assigned to the middle of each interval; their differences give mean torques.

use super::{AttitudeReport, Motion};
use crate::maneuver::Problem;
use crate::maneuver::infeasible::strongest;
use crate::numerics::figures::{significant, told_apart};
use crate::{Vector3, lie};

/// Relative excess of the mean torque from rates over the actuator limits that is accepted. A plan
/// that keeps its limits to round-off, printed with many digits, has such an excess.
const SLACK: f64 = 1e-6;

/// Reports the required torque, and the times at which it exceeds the limits.
pub(super) fn judge(problem: &Problem, motion: &Motion<'_>, report: &mut AttitudeReport) {
    let alone = problem.environment.is_free() && problem.actuation.wheels.is_none();
    if !alone {
        return;
    }
    let j = problem.body.inertia.j();
    let largest = problem.body.inertia.principal()[2];
    let strongest = strongest(&problem.actuation.torque);
    let (rows, last) = (motion.rows, motion.last());
    if !rows.rate.is_empty() {
        let momentum = |k: usize| motion.attitude[k] * (j * rows.rate[k]);
        let (mut peak, mut most) = (0.0_f64, None::<(f64, usize)>);
        for k in (0..last).filter(|k| motion.goes_on(*k)) {
            let h = motion.step(k);
            let mean = (momentum(k + 1) - momentum(k)).norm() / h;
            peak = peak.max(mean);
            let turned = rows.rate[k].norm().max(rows.rate[k + 1].norm());
            let open = 2.0 * largest * (rows.rounding.rate + rows.rounding.attitude * turned) / h;
            let timed = mean * 2.0 * rows.rounding.time / h;
            let above = mean - open - timed - strongest * (1.0 + SLACK);
            if above > most.map_or(0.0, |(above, _)| above) {
                most = Some((above, k));
            }
        }
        report.peak_torque_n_m = Some(peak);
        if let Some((_, k)) = most {
            let h = motion.step(k);
            let mean = (momentum(k + 1) - momentum(k)).norm() / h;
            let [mean, most] = told_apart([mean, strongest], 6, significant);
            let text = format!(
                "torque: the rates need a mean torque of {mean} N·m between {:.4} s and {:.4} s, and \
                the actuators give at most {most} N·m",
                rows.time[k],
                rows.time[k + 1],
            );
            report.violated(k, text);
        }
    }
    // The inertial momentum in the middle of an interval, from its mean rate.
    let middle = |k: usize| {
        let (turn, h) = (motion.turn(k), motion.step(k));
        motion.attitude[k] * lie::exp(&(0.5 * turn)) * (j * (turn / h))
    };
    // The inertial momentum at an end, where the body has the given rate.
    let end = |k: usize, rate: &Vector3| motion.attitude[k] * (j * rate);
    let mut peak = None::<f64>;
    let mut meet = |change: Vector3, time: f64| {
        let torque = change.norm() / time;
        peak = Some(peak.map_or(torque, |peak: f64| peak.max(torque)));
    };
    for k in (1..last).filter(|k| motion.goes_on(k - 1) && motion.goes_on(*k)) {
        meet(middle(k) - middle(k - 1), 0.5 * (motion.step(k - 1) + motion.step(k)));
    }
    if motion.goes_on(0) && motion.goes_on(last - 1) {
        meet(middle(0) - end(0, &problem.start.angular_velocity), 0.5 * motion.step(0));
        meet(end(last, &problem.end.angular_velocity) - middle(last - 1), 0.5 * motion.step(last - 1));
    }
    report.peak_torque_of_attitudes_n_m = peak;
}
