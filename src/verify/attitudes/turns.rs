//! The choice between alternative sets of cones over time, for maneuvers that leave it open.
//!
//! One set must hold over each whole interval between two attitudes. It is the set of the preceding
//! interval if this set holds, otherwise the set with the largest margin. If no set holds over the
//! whole interval, the interval is halved, so that two sets may follow each other within it. If no
//! set holds over a part that cannot be halved further, the set with the smallest violation is
//! used, and its violation is reported.

use super::between::target;
use super::{AttitudeRows, Motion, Rounding};
use crate::lie;
use crate::maneuver::constraint::{Alternatives, Arc, BOUNDARY_ROUNDING, Pointing, Rule, Shift, Turns};
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Trajectory;

/// Largest number of successive halvings of an interval.
const HALVINGS: u32 = 12;

/// Returns the maneuver with its alternatives resolved into time intervals (shifts), one set of
/// cones in each. The shifts come from `own`, the maneuver from which the plan was made, if its
/// shifts cover the whole time. Otherwise they are derived from the attitudes of the plan.
pub fn in_turns(problem: &Problem, own: Option<&Problem>, trajectory: &Trajectory) -> Problem {
    let end = trajectory.time.last().copied().unwrap_or(0.0);
    if let Some(turns) = own.and_then(|own| told(problem, own, end)) {
        return problem.in_turns(&turns);
    }
    let rows = AttitudeRows {
        time: &trajectory.time,
        quaternion: &trajectory.quaternion,
        rate: &[],
        breaks: &[],
        told: &[],
        rounding: Rounding::default(),
    };
    if rows.time.len() < 2 || rows.time.len() != rows.quaternion.len() {
        return problem.clone();
    }
    let attitude = rows.quaternion.iter().map(lie::rotation_from_quaternion).collect();
    let frame_rate = problem.environment.frame_rate();
    kept(problem, &Motion { rows: &rows, attitude, frame_rate, tolerance: BOUNDARY_ROUNDING })
}

/// Returns the shifts of the constraints with the same names in another maneuver; `None` if they do
/// not cover the whole time.
fn told(problem: &Problem, own: &Problem, end: f64) -> Option<Vec<Turns>> {
    let during = |problem: &Problem, name: &str| {
        let constraint = problem.constraints.iter().find(|constraint| constraint.name == name)?;
        match &constraint.rule {
            Rule::Pointing(pointing) => Some(pointing.during.given().map(<[_]>::to_vec)),
            _ => None,
        }
    };
    problem
        .alternatives
        .iter()
        .map(|of| {
            let mut shifts = Vec::new();
            for (set, members) in of.sets.iter().enumerate() {
                let first = during(own, members.first()?)??;
                for name in members {
                    if during(problem, name)?.is_some() || during(own, name)?.as_ref() != Some(&first) {
                        return None;
                    }
                }
                shifts.extend(first.into_iter().map(|[from, to]| Shift { set, from, to }));
            }
            shifts.sort_by(|one, other| one.from.total_cmp(&other.from));
            let mut covered = 0.0;
            for shift in &shifts {
                if shift.from > covered {
                    return None;
                }
                covered = shift.to.max(covered);
            }
            (covered >= end).then(|| Turns { of: of.clone(), shifts })
        })
        .collect()
}

/// Returns the maneuver with its alternatives resolved into the shifts that a motion keeps.
pub(super) fn kept(problem: &Problem, motion: &Motion<'_>) -> Problem {
    let turns: Vec<Turns> = problem
        .alternatives
        .iter()
        .map(|of| Turns { of: of.clone(), shifts: shifts(problem, of, motion) })
        .collect();
    problem.in_turns(&turns)
}

fn shifts(problem: &Problem, of: &Alternatives, motion: &Motion<'_>) -> Vec<Shift> {
    let cones = |members: &Vec<String>| -> Vec<&Pointing> {
        let constraints =
            members.iter().filter_map(|name| problem.constraints.iter().find(|one| one.name == *name));
        constraints
            .filter_map(|constraint| match &constraint.rule {
                Rule::Pointing(pointing) => Some(pointing),
                _ => None,
            })
            .collect()
    };
    let sets: Vec<Vec<&Pointing>> = of.sets.iter().map(cones).collect();
    let allowed = BOUNDARY_ROUNDING + motion.rows.rounding.attitude;
    let mut found: Vec<Shift> = Vec::new();
    for k in 0..motion.last() {
        let (begin, step) = (motion.rows.time[k], motion.step(k));
        // The last element of the stack is the earliest part.
        let mut open = vec![([0.0, 1.0], 0)];
        while let Some(([from, to], depth)) = open.pop() {
            let span = [begin + from * step, begin + to * step];
            let room = |set: usize| {
                sets[set].iter().map(|cone| room(cone, motion, k, span)).fold(f64::INFINITY, f64::min)
            };
            let present = found.last().map(|shift| shift.set);
            let set = match present.filter(|set| room(*set) >= -allowed) {
                Some(set) => set,
                None => {
                    let best = (0..sets.len())
                        .map(|set| (set, room(set)))
                        .reduce(|best, next| if next.1 > best.1 { next } else { best });
                    let Some((set, most)) = best else { return found };
                    if most < -allowed && depth < HALVINGS {
                        let middle = 0.5 * (from + to);
                        open.extend([([middle, to], depth + 1), ([from, middle], depth + 1)]);
                        continue;
                    }
                    set
                }
            };
            match found.last_mut().filter(|shift| shift.set == set) {
                Some(shift) => shift.to = span[1],
                None => found.push(Shift { set, from: span[0], to: span[1] }),
            }
        }
    }
    found
}

/// Returns the smallest distance from a cone between two times within the interval from row `k` to
/// the next one.
fn room(cone: &Pointing, motion: &Motion<'_>, k: usize, span: [f64; 2]) -> f64 {
    let during = cone.during.within(&[span]);
    let cone = Pointing { during, ..cone.clone() };
    let arc = Arc { start: motion.attitude[k], turn: motion.turn(k) };
    let (begin, step) = (motion.rows.time[k], motion.step(k));
    cone.pairs()
        .filter_map(|(boresight, direction)| {
            cone.least_room(&arc, boresight, &target(motion, direction, k), [begin, step])
        })
        .map(|(_, room)| if room.is_nan() { f64::NEG_INFINITY } else { room })
        .fold(f64::INFINITY, f64::min)
}
