//! Checks of a motion of which only attitudes and rates are known.
//!
//! - **Ends and duration** must agree with the problem, and the rows must cover the time between
//!   the ends.
//! - **Cones and rates** are judged at the rows and on the motion between them. There the body
//!   turns about one axis at one rate, and the extremum of every angle has a closed form. If
//!   the file has rates, the cubic through attitudes and rates is judged too, by a bound on its
//!   rate.
//! - **Rates** are held against the attitudes ([`consistency`]).
//! - **Torque** that the rows need, computed from their rates and from their attitudes, is
//!   reported and compared with the limits of the actuators.
//!
//! Inputs, cost and optimality are not in the file and are not judged. [`AttitudeReport::open`]
//! lists checks that could not be decided.

mod between;
mod consistency;
mod torque;
mod turns;

pub use turns::in_turns;

use super::Check;
use crate::maneuver::Problem;
use crate::{Matrix3, Vector3, lie};

/// Rows of attitudes, as read from a file.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeRows<'a> {
    /// Seconds from the start of the maneuver, increasing; two at least.
    pub time: &'a [f64],
    /// Quaternions from body to reference, `[w, x, y, z]`, of length 1, one for each time.
    pub quaternion: &'a [[f64; 4]],
    /// Angular velocity relative to the reference frame, body axes [rad/s], one for each time;
    /// empty if the file has no rates.
    pub rate: &'a [Vector3],
    /// Rows that must not be connected with the row before by interpolation.
    pub breaks: &'a [usize],
    /// For each row, whether the file states it; a polynomial gives the rows between stated rows.
    /// Empty: all are stated. Between stated rows a motion may enter a cone by the tolerance.
    pub told: &'a [bool],
    /// The rounding of the printed digits.
    pub rounding: Rounding,
}

/// The largest error of the last printed digits of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// The rounding of an attitude \[rad\].
    pub attitude: f64,
    /// The rounding of a rate [rad/s].
    pub rate: f64,
    /// The rounding of a time \[s\].
    pub time: f64,
}

/// The result of the checks.
#[derive(Clone, Debug)]
pub struct AttitudeReport {
    /// Ends, duration, and rates against attitudes; errors in rad and rad/s, of the duration
    /// relative.
    pub checks: Vec<Check>,
    /// The violations in words, each with its time.
    pub violations: Vec<String>,
    /// The row of each violation, or the row before it.
    pub violated_at: Vec<usize>,
    /// The checks that these rows cannot decide, in words.
    pub open: Vec<String>,
    /// The largest mean torque between two rows that a free body without wheels needs to have the
    /// rates \[N·m\]; `None` for others and without rates.
    pub peak_torque_n_m: Option<f64>,
    /// The largest torque that the attitudes require, from the mean rates between rows \[N·m\].
    pub peak_torque_of_attitudes_n_m: Option<f64>,
}

impl AttitudeReport {
    fn violated(&mut self, row: usize, text: String) {
        self.violations.push(text);
        self.violated_at.push(row);
    }

    /// Returns whether no check failed.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed) && self.violations.is_empty()
    }
}

/// The largest relative error of the duration: many programs print times to a nanosecond.
const DURATION: f64 = 1e-6;
/// The part of the duration that defines the allowed error of a rate: such an error turns the body
/// by the tolerance in this time.
const RATE_SHARE: f64 = 0.01;

/// The name of the check that rates are the derivatives of the attitudes.
pub const RATES_AGAINST_ATTITUDES: &str = "rates against attitudes";

/// The rows as rotations.
struct Motion<'a> {
    rows: &'a AttitudeRows<'a>,
    attitude: Vec<Matrix3>,
    /// The rate of the reference frame [rad/s].
    frame_rate: Vector3,
    /// The depth to which a motion may enter a cone between rows, and the allowed error of
    /// attitudes \[rad\].
    tolerance: f64,
}

impl Motion<'_> {
    /// Returns the number of the last row.
    fn last(&self) -> usize {
        self.attitude.len() - 1
    }

    /// Returns the last row at a time or before it.
    fn row_at(&self, time: f64) -> usize {
        self.rows.time.partition_point(|at| *at <= time).saturating_sub(1)
    }

    /// Returns whether the motion from row `k` to the next may be interpolated.
    fn goes_on(&self, k: usize) -> bool {
        !self.rows.breaks.contains(&(k + 1))
    }

    /// Returns the seconds from row `k` to the next.
    fn step(&self, k: usize) -> f64 {
        self.rows.time[k + 1] - self.rows.time[k]
    }

    /// Returns the inertial angular velocity in body axes, if the file has rates.
    fn inertial(&self, k: usize) -> Option<Vector3> {
        self.rows.rate.get(k).map(|rate| rate + self.attitude[k].tr_mul(&self.frame_rate))
    }

    /// Returns the turn from row `k` to the next, body axes \[rad\].
    fn turn(&self, k: usize) -> Vector3 {
        lie::minus(&self.attitude[k + 1], &self.attitude[k])
    }

    /// Returns the uncertainty of the mean rate from row `k` to the next, due to the printed
    /// digits [rad/s].
    fn mean_rate_open(&self, k: usize) -> f64 {
        let h = self.step(k);
        let open = self.rows.rounding;
        2.0 * open.attitude / h + self.turn(k).norm() * 2.0 * open.time / (h * h)
    }
}

/// Returns the attitude and the angular velocity, among all ends on the target, that come nearest
/// to the last row: the plan chooses the roll, free or within a band. `None` if the spec states the
/// end, or if the target does not define it at that time.
fn aimed_end(problem: &Problem, motion: &Motion<'_>, duration: f64) -> Option<(Matrix3, Vector3)> {
    let ends = problem.aim()?.ends(duration, &problem.start.attitude, &motion.frame_rate).ok()?;
    Some(ends.at(ends.nearest(&motion.attitude[motion.last()])))
}

/// Judges rows. `tolerance` \[rad\] is for the attitudes at the ends, and for how deep the cubic
/// between rows may enter a cone.
pub fn judge_attitudes(problem: &Problem, rows: &AttitudeRows<'_>, tolerance: f64) -> AttitudeReport {
    let frame_rate = problem.environment.frame_rate();
    let attitude = rows.quaternion.iter().map(lie::rotation_from_quaternion).collect();
    let motion = Motion { rows, attitude, frame_rate, tolerance };
    let turned;
    let problem = if problem.alternatives.is_empty() {
        problem
    } else {
        turned = turns::kept(problem, &motion);
        &turned
    };
    let last = motion.last();
    let time = rows.time;
    let check = |name: &str, value: f64, limit: f64| Check {
        name: name.into(),
        value,
        limit,
        passed: value <= limit,
    };
    let told = time[last] - time[0];
    let duration = problem.duration.known().unwrap_or(told);
    let limit = DURATION + rows.rounding.time / duration;
    let (mut checks, mut open) = (Vec::new(), Vec::new());
    match (problem.duration.known(), problem.duration.at_most()) {
        (Some(duration), _) => checks.push(check("duration", (told - duration).abs() / duration, limit)),
        (None, Some(longest)) => checks.push(check("longest duration", told / longest - 1.0, limit)),
        (None, None) => open.push("the duration: it is free, so any duration is valid".to_string()),
    }
    let aimed = aimed_end(problem, &motion, told);
    let end = aimed.unwrap_or((problem.end.attitude, problem.end.angular_velocity));
    let start = (problem.start.attitude, problem.start.angular_velocity);
    for (name, k, (attitude, angular_velocity)) in [("start", 0, start), ("end", last, end)] {
        if k == 0 || !problem.ends_in_any_attitude() {
            let angle = lie::minus(&motion.attitude[k], &attitude).norm();
            checks.push(check(&format!("attitude at the {name}"), angle, tolerance));
        }
        if let Some(rate) = motion.inertial(k) {
            let limit = tolerance / (RATE_SHARE * duration);
            checks.push(check(&format!("rate at the {name}"), (rate - angular_velocity).norm(), limit));
        }
    }
    let mut report = AttitudeReport {
        checks,
        violations: Vec::new(),
        violated_at: Vec::new(),
        open,
        peak_torque_n_m: None,
        peak_torque_of_attitudes_n_m: None,
    };
    for k in (0..last).filter(|k| !motion.goes_on(*k)) {
        let text = format!(
            "no attitude is given between {:.4} s and {:.4} s: interpolation between blocks is not allowed",
            time[k],
            time[k + 1]
        );
        report.violated(k, text);
    }
    between::judge(problem, &motion, &mut report);
    consistency::judge(&motion, &mut report);
    torque::judge(problem, &motion, &mut report);
    report
}
