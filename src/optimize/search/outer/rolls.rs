//! The least cost over the roll about a boresight of plans whose inputs switch, at one time.
//!
//! The least cost `V(ρ)` of a maneuver to the end of roll ρ is planned as any maneuver to a given
//! end, in continuous time. Its slope is the costate at the end about the boresight. From the roll
//! that the chain of equal steps leads to, strides downhill and the root of the slope between the
//! last two lead to the nearest minimum. All extremals of that roll are followed so: V is the least
//! of them, its kinks are concave, and no minimum is at one.

use crate::Vector3;
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Outcome, Solution};
use crate::optimize::search::context::Context;
use crate::optimize::search::halt::Halt;
use crate::optimize::search::outer::illinois::Illinois;
use crate::optimize::search::switching;
use crate::optimize::search::switching::followed::Followed;
use std::f64::consts::PI;

/// Part of the cost that is none: where extremals are followed, and of pulses, each of which is
/// planned as a whole.
const GAINED: f64 = 1e-10;
const GAINED_BY_PULSES: f64 = 1e-6;

/// Relative difference of costs up to which two ends, or two extremals of one end, may change
/// places between equal steps and continuous time, or from one roll to another.
pub const CLOSE: f64 = 0.02;

/// Most evaluations about one minimum.
const MOST_EVALUATIONS: usize = 8;

/// What a plan to one roll costs.
#[derive(Clone, Copy)]
pub struct Known {
    pub roll: f64,
    /// In continuous time, where it changes smoothly with the roll as it does not on a grid.
    pub cost: f64,
    /// The derivative of that by the roll.
    slope: f64,
}

/// Plans to ends of one time, roll after roll.
pub struct Rolls<'a, 'c> {
    pub problem: &'a Problem,
    pub ends: &'a Ends,
    pub context: &'a Context<'c>,
}

impl Rolls<'_, '_> {
    /// Returns the minimum downhill of a roll; `None` where that roll has no plan.
    pub fn lowest(&self, from: f64) -> Result<Option<Known>, Halt> {
        if self.problem.shortest_pulse().is_some() {
            let Some(first) = self.planned(from)? else { return Ok(None) };
            return self.downhill(first, GAINED_BY_PULSES, &mut |roll| self.planned(roll)).map(Some);
        }
        let extremals = Followed::all(&self.facing(from), self.context, CLOSE)?;
        let mut best: Option<Known> = None;
        for mut near in extremals {
            let first = self.known(from, near.cost, &near.costates);
            let mut at = |roll: f64| {
                let Some(led) = near.led(&self.facing(roll), self.context) else { return Ok(None) };
                near = led;
                Ok(Some(self.known(roll, near.cost, &near.costates)))
            };
            let lowest = self.downhill(first, GAINED, &mut at)?;
            if best.is_none_or(|best| lowest.cost < best.cost) {
                best = Some(lowest);
            }
        }
        Ok(best)
    }

    /// Returns the maneuver to the end of a roll.
    fn facing(&self, roll: f64) -> Problem {
        self.problem.facing(self.ends, roll)
    }

    /// Returns what is known of a plan by the costates of attitude and momentum at its end.
    fn known(&self, roll: f64, cost: f64, [turn, momentum]: &[Vector3; 2]) -> Known {
        let (by_turn, by_rate) = self.ends.along_roll(&self.facing(roll).end.angular_velocity);
        let by_momentum = self.problem.body.inertia.j() * by_rate;
        Known { roll, cost, slope: -turn.dot(&by_turn) - momentum.dot(&by_momentum) }
    }

    /// Plans the pulses to a roll; `None` where there is no plan.
    fn planned(&self, roll: f64) -> Result<Option<Known>, Halt> {
        let solution = switching::solve_discrete(&self.facing(roll), self.context);
        match solution.outcome {
            Outcome::Converged => {
                let continuous = solution.switching.as_ref().map(|found| found.continuous_cost);
                let cost = continuous.unwrap_or(solution.cost);
                Ok(costates_at_end(&solution).map(|costates| self.known(roll, cost, &costates)))
            }
            Outcome::TimeLimit | Outcome::Interrupted => Err(Halt::Stopped(Box::new(solution))),
            _ => Ok(None),
        }
    }

    /// Returns a roll within the band.
    fn held(&self, roll: f64) -> f64 {
        if self.ends.within() >= PI { roll } else { roll.clamp(-self.ends.within(), self.ends.within()) }
    }

    /// Returns the minimum downhill of a plan: the root of the slope.
    fn downhill(
        &self,
        from: Known,
        gained: f64,
        at: &mut dyn FnMut(f64) -> Result<Option<Known>, Halt>,
    ) -> Result<Known, Halt> {
        let (mut best, mut reach, mut beyond) = (from, self.context.tuning.stride, None);
        for _ in 0..MOST_EVALUATIONS {
            let roll = self.held(best.roll - reach * best.slope.signum());
            if roll == best.roll || reach > PI {
                break;
            }
            match at(roll)? {
                Some(found) if found.slope * best.slope < 0.0 => {
                    beyond = Some(found);
                    break;
                }
                Some(found) if found.cost < best.cost => (best, reach) = (found, 2.0 * reach),
                // Another extremal is the cheapest there, or none.
                _ => reach *= 0.25,
            }
        }
        let Some(mut beyond) = beyond else { return Ok(best) };
        let (mut low, mut illinois) = (best, Illinois::new([best.slope, beyond.slope]));
        for _ in 0..MOST_EVALUATIONS {
            let roll = low.roll + illinois.part() * (beyond.roll - low.roll);
            // By its slope the best is the lowest.
            if (best.slope * (roll - best.roll)).abs() <= gained * best.cost {
                break;
            }
            let Some(next) = at(roll)? else { break };
            let moved = usize::from(next.slope * low.slope < 0.0);
            illinois.moved(moved, next.slope);
            *[&mut low, &mut beyond][moved] = next;
            let cheaper = if low.cost < beyond.cost { low } else { beyond };
            if cheaper.cost < best.cost {
                best = cheaper;
            }
        }
        Ok(best)
    }
}

/// Returns the costates of the attitude and of the momentum at the end of a plan.
fn costates_at_end(plan: &Solution) -> Option<[Vector3; 2]> {
    let costates = &plan.trajectory.costates;
    let first = costates.len().checked_sub(6)?;
    Some([first, first + 3].map(|first| Vector3::from_column_slice(&costates[first..first + 3])))
}
