//! The check that the inputs of a plan are pulses: off or at a limit, and on for at least the
//! minimum pulse width.
//!
//! It uses only the recorded rows and times.

use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;

/// Tolerance within which an input counts as at its limit or as off, relative to the limit.
pub(super) const AT_LIMIT: f64 = 1e-12;

/// Relative tolerance by which a pulse may fall short of the minimum pulse width, because the times
/// of its ends are sums of steps.
pub(super) const ROUND_OFF: f64 = 1e-9;

/// The deviation of the inputs of a plan from ideal pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Largest distance of an input from the nearest of 0 and its limits, relative to the limit;
    /// NaN if an input is NaN.
    pub between: f64,
    /// Length of the shortest pulse \[s\]; infinite if no input is ever on.
    pub shortest: f64,
}

/// The result for rows that do not fit the problem.
pub(super) const UNKNOWN: Found = Found { between: f64::NAN, shortest: f64::NAN };

/// Returns the nearest of −1, 0 and 1 to a value in units of its limit, and the distance to it.
fn side(part: f64) -> (i8, f64) {
    let off_by = [-1.0, 0.0, 1.0].map(|level: f64| (part - level).abs());
    match off_by {
        [below, off, _] if below < off => (-1, below),
        [_, off, above] if above < off => (1, above),
        [_, off, _] => (0, off),
    }
}

/// Returns the smaller number; NaN if either number is NaN.
fn smaller(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}

/// Returns the larger number; NaN if either number is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Measures the pulses in recorded rows, which must fit the problem.
pub(super) fn found(problem: &Problem, trajectory: &Trajectory) -> Found {
    let mut found = Found { between: 0.0, shortest: f64::INFINITY };
    let torque = &problem.actuation.torque;
    let Some(sizes) = &torque.limits().size else {
        return UNKNOWN;
    };
    for (input, size) in sizes.iter().enumerate() {
        // The present level of the input, and the time since which it has this level.
        let mut since: Option<(i8, f64)> = None;
        for (row, ends) in trajectory.time.windows(2).enumerate() {
            let (level, off_by) = side(trajectory.inputs(row)[input] / size);
            let one_sided = torque.limits().one_sided && level < 0;
            let off_by = if one_sided { 1.0 } else { off_by };
            found.between = larger(found.between, off_by);
            match since {
                Some((known, _)) if known == level => {}
                Some((known, from)) => {
                    if known != 0 {
                        found.shortest = smaller(found.shortest, ends[0] - from);
                    }
                    since = Some((level, ends[0]));
                }
                None => since = Some((level, ends[0])),
            }
        }
        if let (Some((level, from)), Some(end)) = (since, trajectory.time.last())
            && level != 0
        {
            found.shortest = smaller(found.shortest, end - from);
        }
    }
    found
}
