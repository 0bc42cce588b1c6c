//! Checks of a motion of which only attitudes and rates are known.
//!
//! - **Ends and duration** must agree with the problem, and the rows must cover the time between
//!   the ends.
//! - **Cones and rates** are checked at the rows and between them. Between rows the body is assumed
//!   to turn about one axis at a constant rate, for which the extremum of every angle has a closed
//!   form. If the file has rates, the cubic through attitudes and rates is also checked, by a bound
//!   on its rate.
//! - **Rates** are compared with the attitudes ([`consistency`]).
//! - **Torque**: the torques that the recorded rates and attitudes require are reported, and
//!   compared with the limits of the actuators.
//!
//! Inputs, cost and optimality are not in the file and are not checked. [`AttitudeReport::open`]
//! lists checks that could not be decided.

mod between;
mod consistency;
mod torque;
mod turns;

pub use turns::in_turns;

use super::Check;
use crate::maneuver::Problem;
use crate::{Matrix3, Vector3, lie};

/// An attitude history, as read from a file.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeRows<'a> {
    /// Times of the rows since the start of the maneuver \[s\], increasing; at least two.
    pub time: &'a [f64],
    /// Unit quaternions `[w, x, y, z]` from body to reference, one for each time.
    pub quaternion: &'a [[f64; 4]],
    /// Angular velocity relative to the reference frame, body axes [rad/s], one for each time.
    /// Empty if the file has no rates.
    pub rate: &'a [Vector3],
    /// Indices of the rows before which the motion must not be interpolated.
    pub breaks: &'a [usize],
    /// For each row, whether the file contains it; the other rows come from a polynomial. Empty if
    /// the file contains all rows. Between rows of the file a motion may enter a cone by up to the
    /// tolerance.
    pub told: &'a [bool],
    /// Rounding errors of the printed digits.
    pub rounding: Rounding,
}

/// The largest rounding errors of the numbers printed in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Rounding error of an attitude \[rad\].
    pub attitude: f64,
    /// Rounding error of a rate [rad/s].
    pub rate: f64,
    /// Rounding error of a time \[s\].
    pub time: f64,
}

/// The result of checking an attitude history.
#[derive(Clone, Debug)]
pub struct AttitudeReport {
    /// Checks of ends, duration, and rates against attitudes. The errors are in rad and rad/s, and
    /// relative for the duration.
    pub checks: Vec<Check>,
    /// The violations of constraints in words, each with its time.
    pub violations: Vec<String>,
    /// Index of the row of each violation, or of the row before it.
    pub violated_at: Vec<usize>,
    /// The checks that these rows cannot decide, in words.
    pub open: Vec<String>,
    /// Largest mean torque between two rows that the recorded rates require \[N·m\]. `None` if the
    /// file has no rates, if the body is not free, or if it has wheels.
    pub peak_torque_n_m: Option<f64>,
    /// Largest torque that the recorded attitudes require, from the mean rates between rows
    /// \[N·m\].
    pub peak_torque_of_attitudes_n_m: Option<f64>,
}

impl AttitudeReport {
    fn violated(&mut self, row: usize, text: String) {
        self.violations.push(text);
        self.violated_at.push(row);
    }

    /// Returns whether all checks passed and no constraint is violated.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed) && self.violations.is_empty()
    }
}

/// Largest accepted relative error of the duration, because many programs print times to a
/// nanosecond.
const DURATION: f64 = 1e-6;
/// Fraction of the duration in which the largest accepted error of a rate turns the body by the
/// tolerance.
const RATE_SHARE: f64 = 0.01;

/// Name of the check that the rates are the derivatives of the attitudes.
pub const RATES_AGAINST_ATTITUDES: &str = "rates against attitudes";

/// An attitude history converted to rotations.
struct Motion<'a> {
    rows: &'a AttitudeRows<'a>,
    attitude: Vec<Matrix3>,
    /// Angular velocity of the reference frame [rad/s].
    frame_rate: Vector3,
    /// Largest accepted depth of a motion in a cone between rows, and largest accepted error of
    /// attitudes \[rad\].
    tolerance: f64,
}

impl Motion<'_> {
    /// Returns the index of the last row.
    fn last(&self) -> usize {
        self.attitude.len() - 1
    }

    /// Returns the index of the last row at or before a time.
    fn row_at(&self, time: f64) -> usize {
        self.rows.time.partition_point(|at| *at <= time).saturating_sub(1)
    }

    /// Returns whether the motion from row `k` to the next one may be interpolated.
    fn goes_on(&self, k: usize) -> bool {
        !self.rows.breaks.contains(&(k + 1))
    }

    /// Returns the time from row `k` to the next one \[s\].
    fn step(&self, k: usize) -> f64 {
        self.rows.time[k + 1] - self.rows.time[k]
    }

    /// Returns the inertial angular velocity at row `k` in body axes; `None` if the file has no
    /// rates.
    fn inertial(&self, k: usize) -> Option<Vector3> {
        self.rows.rate.get(k).map(|rate| rate + self.attitude[k].tr_mul(&self.frame_rate))
    }

    /// Returns the rotation vector from row `k` to the next one, body axes \[rad\].
    fn turn(&self, k: usize) -> Vector3 {
        lie::minus(&self.attitude[k + 1], &self.attitude[k])
    }

    /// Returns the uncertainty of the mean rate from row `k` to the next one that the printed
    /// digits cause [rad/s].
    fn mean_rate_open(&self, k: usize) -> f64 {
        let h = self.step(k);
        let open = self.rows.rounding;
        2.0 * open.attitude / h + self.turn(k).norm() * 2.0 * open.time / (h * h)
    }
}

/// Returns the terminal attitude and angular velocity nearest to the last row, among all those that
/// point at the target; the plan may choose the roll, freely or within a band. `None` if the spec
/// states the terminal attitude, or if the target is not defined at that time.
fn aimed_end(problem: &Problem, motion: &Motion<'_>, duration: f64) -> Option<(Matrix3, Vector3)> {
    let ends = problem.aim()?.ends(duration, &problem.start.attitude, &motion.frame_rate).ok()?;
    Some(ends.at(ends.nearest(&motion.attitude[motion.last()])))
}

/// Checks an attitude history. `tolerance` \[rad\] bounds the attitude errors at the ends, and the
/// depth by which the cubic between rows may enter a cone.
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
