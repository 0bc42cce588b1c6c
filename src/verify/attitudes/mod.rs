//! What can be said of a motion of which only attitudes and rates are known.
//!
//! - **Ends and duration** are those of the problem, and rows cover the time between them.
//! - **Cones and rates** are judged at the rows and on the motion between them: the body turns about one axis at one rate, where the
//!   extremum of every angle has a closed form; where rates are told, also along the cubic through attitudes and rates, by a bound on
//!   how fast it turns.
//! - **Rates** are held against the attitudes ([`consistency`]).
//! - **Torque** that the rows need, by their rates and by their attitudes, is told, and held against what the actuators have.
//!
//! Inputs, cost and optimality are not there to be judged. What was looked at and could not be decided stands in
//! [`AttitudeReport::open`].

mod between;
mod consistency;
mod torque;
mod turns;

pub use turns::in_turns;

use super::Check;
use crate::maneuver::Problem;
use crate::{Matrix3, Vector3, lie};

/// Rows of attitudes, as a file tells them.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeRows<'a> {
    /// Seconds from the start of the maneuver, increasing; two at least.
    pub time: &'a [f64],
    /// From body to reference, `[w, x, y, z]`, of length 1, as many.
    pub quaternion: &'a [[f64; 4]],
    /// Angular velocity against the reference frame, body axes [rad/s]; as many, or none.
    pub rate: &'a [Vector3],
    /// Rows before which nothing may be interpolated.
    pub breaks: &'a [usize],
    /// Which rows the file tells, where others stand between them that a polynomial makes; empty: all are told. Between told rows a
    /// motion may enter a cone by the tolerance.
    pub told: &'a [bool],
    /// What the printed digits leave open.
    pub rounding: Rounding,
}

/// How far the last printed digits of a file may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Of an attitude \[rad\].
    pub attitude: f64,
    /// Of a rate [rad/s].
    pub rate: f64,
    /// Of a time \[s\].
    pub time: f64,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct AttitudeReport {
    /// Ends, duration, and rates against attitudes; errors in rad and rad/s, of the duration relative.
    pub checks: Vec<Check>,
    /// What is violated, each in words with the time at which it is so.
    pub violations: Vec<String>,
    /// The row at which each of them is, or the one before.
    pub violated_at: Vec<usize>,
    /// What cannot be decided by these rows, in words.
    pub open: Vec<String>,
    /// The largest mean torque between two rows that a free body without wheels needs to have the rates \[N·m\]; `None` for others and
    /// without rates.
    pub peak_torque_n_m: Option<f64>,
    /// The torque that such a body needs to have the attitudes: the largest, by the mean rates between rows \[N·m\].
    pub peak_torque_of_attitudes_n_m: Option<f64>,
}

impl AttitudeReport {
    fn violated(&mut self, row: usize, text: String) {
        self.violations.push(text);
        self.violated_at.push(row);
    }

    /// Whether nothing speaks against it.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed) && self.violations.is_empty()
    }
}

/// How far the duration may be off, relative: times are printed to a nanosecond by many.
const DURATION: f64 = 1e-6;
/// A rate may be off by what turns the body by the tolerance in this share of the duration.
const RATE_SHARE: f64 = 0.01;

/// The name of the check that rates are those of the attitudes.
pub const RATES_AGAINST_ATTITUDES: &str = "rates against attitudes";

/// The rows as rotations.
struct Motion<'a> {
    rows: &'a AttitudeRows<'a>,
    attitude: Vec<Matrix3>,
    /// Of the reference frame [rad/s].
    frame_rate: Vector3,
    /// How far a motion may enter a cone between rows, and attitudes be off \[rad\].
    tolerance: f64,
}

impl Motion<'_> {
    /// Number of the last row.
    fn last(&self) -> usize {
        self.attitude.len() - 1
    }

    /// The last row at a time or before it.
    fn row_at(&self, time: f64) -> usize {
        self.rows.time.partition_point(|at| *at <= time).saturating_sub(1)
    }

    /// Whether the motion from row `k` to the next may be interpolated.
    fn goes_on(&self, k: usize) -> bool {
        !self.rows.breaks.contains(&(k + 1))
    }

    /// Seconds from row `k` to the next.
    fn step(&self, k: usize) -> f64 {
        self.rows.time[k + 1] - self.rows.time[k]
    }

    /// Angular velocity against inertial space, body axes, where the file tells one.
    fn inertial(&self, k: usize) -> Option<Vector3> {
        self.rows.rate.get(k).map(|rate| rate + self.attitude[k].tr_mul(&self.frame_rate))
    }

    /// The turn from row `k` to the next, body axes \[rad\].
    fn turn(&self, k: usize) -> Vector3 {
        lie::minus(&self.attitude[k + 1], &self.attitude[k])
    }

    /// What the digits leave open of the mean rate from row `k` to the next [rad/s].
    fn mean_rate_open(&self, k: usize) -> f64 {
        let h = self.step(k);
        let open = self.rows.rounding;
        2.0 * open.attitude / h + self.turn(k).norm() * 2.0 * open.time / (h * h)
    }
}

/// Attitude and angular velocity at which a maneuver to a target may end that come nearest to the last row: the roll is the plan's to
/// choose, all of it or within a band. `None` where the end is told, or the target leaves it open at that time.
fn aimed_end(problem: &Problem, motion: &Motion<'_>, duration: f64) -> Option<(Matrix3, Vector3)> {
    let ends = problem.aim()?.ends(duration, &problem.start.attitude, &motion.frame_rate).ok()?;
    Some(ends.at(ends.nearest(&motion.attitude[motion.last()])))
}

/// Judges rows. `tolerance` \[rad\] is for the attitudes at the ends, and for how deep the cubic between rows may enter a cone.
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
        (None, None) => open.push("the duration: it is sought, and any will do".to_string()),
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
            "no attitude is told between {:.4} s and {:.4} s: nobody may interpolate from one block into the next",
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
