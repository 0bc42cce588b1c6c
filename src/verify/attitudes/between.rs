//! Checks of cones and rate limits, at the rows of an attitude history and between them.
//!
//! If the body turns at a constant rate about a fixed axis, the angle between a boresight and a
//! direction has a closed form ([`Arc`]). This also holds in a rotating reference frame, in which
//! an inertially fixed direction turns backwards. The rate relative to the reference frame is
//! constant, `ρ = φ/h`. In a rotating frame the inertial rate follows from
//!
//! ```text
//! |ρ + A(τ)ᵀω|² = |ρ|² + |ω|² + 2 ρ·A₀ᵀω ,      (A(τ)ᵀω)ᵢ = |ω| cos ∠(A(τ) eᵢ, ω)
//! ```
//!
//! For every motion between the two attitudes the largest rate is at least the mean rate, by the
//! mean value theorem. A mean rate above the limit is therefore a violation by any motion of the
//! body.
//!
//! The cubic interpolates attitudes and rates. An angle along it changes at most at the largest
//! slope of the rotation vector plus the rate of the target. An interval is free of violations if
//! the clearance at its middle exceeds half of this change. Any other interval is halved, until the
//! change is smaller than the tolerance.

use super::{AttitudeReport, Motion};
use crate::Vector3;
use crate::lie::{self, interpolation};
use crate::maneuver::Problem;
use crate::maneuver::constraint::{
    Arc, BOUNDARY_ROUNDING, Constraint, Direction, Extreme, Pointing, Rule, Side, Target, angle_between,
    turn_between,
};
use crate::numerics::figures::{decimals, significant, told_apart};

/// Checks every constraint.
pub(super) fn judge(problem: &Problem, motion: &Motion<'_>, report: &mut AttitudeReport) {
    let mut far = Vec::new();
    for k in (0..motion.last()).filter(|k| motion.goes_on(*k)) {
        // A turn of 180°, within the printed digits, has two possible directions.
        if motion.turn(k).norm()
            > std::f64::consts::PI - motion.tolerance.max(2.0 * motion.rows.rounding.attitude)
        {
            far.push(motion.rows.time[k]);
        }
    }
    if let (Some(first), true) = (far.first(), problem.is_constrained()) {
        report.open.push(format!(
            "the path between rows that are half a turn apart, first after {first:.4} s: both \
            directions have one length"
        ));
    }
    for constraint in &problem.constraints {
        match &constraint.rule {
            Rule::Pointing(pointing) => cones(constraint, pointing, motion, report),
            Rule::RateNorm(_) | Rule::RateAxes(_) => rates(constraint, motion, report),
        }
    }
}

/// Returns the target direction for the interval from row `k` to row `k + 1`, reference axes.
pub(super) fn target(motion: &Motion<'_>, direction: &Direction, k: usize) -> Target {
    let (time, step, frame_rate) =
        (motion.rows.time[k] - motion.rows.time[0], motion.step(k), &motion.frame_rate);
    let start = direction.at(time, frame_rate);
    match direction {
        Direction::InFrame(_) => Target::fixed(start),
        Direction::Fixed(_) => Target { turn: -frame_rate * step, ..Target::fixed(start) },
        Direction::Moving(_) | Direction::Disc { .. } => {
            let [first, last] = [time, time + step].map(|time| direction.angular_radius(time));
            let turn = turn_between(&start, &direction.at(time + step, frame_rate));
            Target { start, turn, radius: first, growth: last - first }
        }
    }
}

/// The deepest point of a violation, with the times at which the violation begins and ends.
struct Inside {
    room: f64,
    angle: f64,
    time: f64,
    from: f64,
    to: f64,
}

fn cones(constraint: &Constraint, pointing: &Pointing, motion: &Motion<'_>, report: &mut AttitudeReport) {
    let allowed = BOUNDARY_ROUNDING + motion.rows.rounding.attitude;
    let mut inside: Option<Inside> = None;
    // Depth and time of the deepest violation by the cubic where the motion at a constant rate has
    // none.
    let mut curved = (0.0_f64, 0.0);
    for k in (0..motion.last()).filter(|k| motion.goes_on(*k)) {
        let (begin, step) = (motion.rows.time[k], motion.step(k));
        let arc = Arc { start: motion.attitude[k], turn: motion.turn(k) };
        for (boresight, direction) in pointing.pairs() {
            let target = target(motion, direction, k);
            let room = |part: f64| {
                let acts = pointing.during.contains(begin + part * step);
                let angle = arc.angle(boresight, &target, part);
                if acts { pointing.room_beside(angle, target.radius_at(part)) } else { f64::INFINITY }
            };
            let Some((worst, deepest)) = pointing.least_room(&arc, boresight, &target, [begin, step]) else {
                continue;
            };
            // The attitude at a stated row is exact except for its digits.
            let at_row = |(part, row): &(f64, usize)| motion.rows.told[*row] && room(*part) < -allowed;
            let (between, told) = if motion.rows.told.is_empty() {
                (0.0, None)
            } else {
                (motion.tolerance, [(0.0, k), (1.0, k + 1)].into_iter().find(at_row))
            };
            let deep = deepest.is_nan() || deepest < -allowed - between;
            let violated = match told {
                _ if deep => Some((worst.part, worst.angle, deepest)),
                Some((part, _)) => Some((part, arc.angle(boresight, &target, part), room(part))),
                None => None,
            };
            if let Some((part, angle, depth)) = violated {
                let edge = |from: f64, to: f64| begin + step * border(&room, from, to);
                let found = Inside {
                    room: depth,
                    angle,
                    time: begin + step * part,
                    from: edge(part, 0.0),
                    to: edge(part, 1.0),
                };
                inside = Some(match inside {
                    None => found,
                    Some(old) => {
                        let (from, to) = (old.from.min(found.from), old.to.max(found.to));
                        let deeper = if found.room < old.room { found } else { old };
                        Inside { from, to, ..deeper }
                    }
                });
            } else if let Some(depth) = along_cubic(pointing, boresight, &target, motion, k)
                && depth.0 > curved.0
            {
                curved = (depth.0, begin + step * depth.1);
            }
        }
    }
    let name = &constraint.name;
    // Angles are printed with six decimals, so that round-off is not shown.
    let degrees = |angle: f64| decimals(angle.to_degrees(), 6);
    if let Some(Inside { room, angle, time, from, to }) = inside {
        let side = if pointing.side == Side::KeepOut { "enters" } else { "leaves" };
        let text = format!(
            "{name}: the boresight {side} the cone by {} deg at {time:.4} s ({} deg from the axis), between \
                {from:.4} s and {to:.4} s",
            degrees(-room),
            degrees(angle)
        );
        report.violated(motion.row_at(time), text);
    } else if curved.0 > motion.tolerance {
        report.open.push(format!(
            "{name} between rows: the rates give a motion {} deg beyond the rim at {:.4} s, and a \
            constant rate from row to row does not; the rows are too far apart to decide",
            degrees(curved.0),
            curved.1
        ));
    }
}

/// Returns the point between `violated` and an end of an arc at which the violation ends; `end` if
/// the violation extends to it.
fn border(room: &dyn Fn(f64) -> f64, violated: f64, end: f64) -> f64 {
    if room(end) < 0.0 {
        return end;
    }
    let (mut bad, mut good) = (violated, end);
    // Fifty bisections exhaust the digits of a double.
    for _ in 0..50 {
        let middle = 0.5 * (bad + good);
        if room(middle) < 0.0 { bad = middle } else { good = middle }
    }
    bad
}

/// Returns the depth of the deepest violation by the cubic between row `k` and the next one, and
/// its position; `None` if the depth is within the tolerance.
fn along_cubic(
    pointing: &Pointing,
    boresight: &Vector3,
    target: &Target,
    motion: &Motion<'_>,
    k: usize,
) -> Option<(f64, f64)> {
    let row = |k: usize| {
        let rate = *motion.rows.rate.get(k)?;
        Some(interpolation::Row { attitude: motion.attitude[k], rate })
    };
    let (first, second) = (row(k)?, row(k + 1)?);
    let cubic = interpolation::Cubic::between(&first, &second, motion.step(k));
    let speed = cubic.steepest() + target.travel();
    let room = |part: f64| {
        if !pointing.during.contains(motion.rows.time[k] + part * motion.step(k)) {
            return f64::INFINITY;
        }
        let pointed = first.attitude * lie::exp(&cubic.at(part).0) * boresight;
        pointing.room_beside(angle_between(&pointed, &target.at(part)), target.radius_at(part))
    };
    let mut found: Option<(f64, f64)> = None;
    let mut open = vec![(0.0, 1.0)];
    while let Some((from, to)) = open.pop() {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let here = room(middle);
        let deepest = found.map_or(motion.tolerance, |(depth, _)| depth);
        if -here > deepest || here.is_nan() {
            found = Some((-here, middle));
        }
        // An interval is dropped if its violation cannot be deeper than the known one by more than
        // the tolerance.
        if speed * half - here > deepest + motion.tolerance && speed * half > 0.5 * motion.tolerance {
            open.extend([(from, middle), (middle, to)]);
        }
    }
    found
}

fn rates(constraint: &Constraint, motion: &Motion<'_>, report: &mut AttitudeReport) {
    let (last, rows) = (motion.last(), motion.rows);
    let open = rows.rounding.rate;
    // The largest excess over a rate limit: excess, rate, limit, axis and time.
    let mut worst: Option<(f64, f64, f64, &str, f64)> = None;
    let mut meet = |value: f64, limit: f64, axis: &'static str, open: f64, time: f64| {
        let above = value - limit * (1.0 + BOUNDARY_ROUNDING) - open;
        if above > worst.map_or(0.0, |worst| worst.0) || above.is_nan() {
            worst = Some((above, value, limit, axis, time));
        }
    };
    const AXES: [&str; 3] = [" about x", " about y", " about z"];
    for k in 0..=last {
        if let Some(rate) = motion.inertial(k) {
            match &constraint.rule {
                Rule::RateNorm(limit) => meet(rate.norm(), *limit, "", open, rows.time[k]),
                Rule::RateAxes(limits) => {
                    (0..3).for_each(|axis| {
                        meet(rate[axis].abs(), limits[axis], AXES[axis], open, rows.time[k])
                    });
                }
                Rule::Pointing(_) => {}
            }
        }
        if k == last || !motion.goes_on(k) {
            continue;
        }
        let (turn, h) = (motion.turn(k), motion.step(k));
        let (mean, open, time) = (turn / h, motion.mean_rate_open(k), rows.time[k] + 0.5 * h);
        match &constraint.rule {
            Rule::RateNorm(limit) => {
                // The component along the turn is constant during it.
                let value = (mean + motion.attitude[k].tr_mul(&motion.frame_rate)).norm();
                meet(value, *limit, "", open, time);
            }
            Rule::RateAxes(limits) => {
                let arc = Arc { start: motion.attitude[k], turn };
                let frame = motion.frame_rate.norm();
                for axis in 0..3 {
                    let mut value = mean[axis].abs();
                    if frame > 0.0 {
                        let target = Target::fixed(motion.frame_rate / frame);
                        let along = |which| {
                            let part = arc.extreme(&Vector3::ith(axis, 1.0), &target, which);
                            (mean[axis] + frame * part.angle.cos()).abs()
                        };
                        value = along(Extreme::Nearest).max(along(Extreme::Farthest));
                    }
                    meet(value, limits[axis], AXES[axis], open, time);
                }
            }
            Rule::Pointing(_) => {}
        }
    }
    if let Some((_, value, limit, axis, time)) = worst {
        let [value, limit] = told_apart([value, limit].map(f64::to_degrees), 6, significant);
        let text = format!(
            "{}: the rate{axis} is {value} deg/s at {time:.4} s, the limit is {limit} deg/s",
            constraint.name
        );
        report.violated(motion.row_at(time), text);
    } else if rows.rate.is_empty() {
        report
            .open
            .push(format!("{} beyond the mean rates between rows: the file has no rates", constraint.name));
    }
}
