//! Minimum cost over the roll about a boresight, for plans with switching inputs at a fixed arrival
//! time.
//!
//! The minimum cost `V(ρ)` of a maneuver to the terminal attitude of roll ρ is that of a plan to a
//! given end, in continuous time. Its derivative is the terminal costate about the boresight.
//! Starting from the roll of the plan on a uniform grid, steps in the direction of descent and a
//! root of the derivative between the last two lead to the nearest minimum. All extremals at the
//! initial roll are followed in this way. V is their lower envelope; its kinks are concave, so that
//! no minimum is at a kink.

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

/// Relative decrease of the cost below which extremals are not followed further.
const GAINED: f64 = 1e-10;
/// Relative decrease of the cost below which plans with pulses are not computed at further rolls,
/// because each takes a whole search.
const GAINED_BY_PULSES: f64 = 1e-6;

/// Relative cost difference up to which two terminal states, or two extremals to one terminal
/// state, may exchange their order between a uniform grid and continuous time, or between two
/// rolls.
pub const CLOSE: f64 = 0.02;

/// Largest number of cost evaluations for one minimum.
const MOST_EVALUATIONS: usize = 8;

/// Cost of a plan to one roll, and its derivative with respect to the roll.
#[derive(Clone, Copy)]
pub struct Known {
    pub roll: f64,
    /// Cost in continuous time. It changes smoothly with the roll, which the cost on a grid does
    /// not.
    pub cost: f64,
    /// Derivative of the cost with respect to the roll \[cost per rad\].
    slope: f64,
}

/// Plans to the rolls of a target at one arrival time.
pub struct Rolls<'a, 'c> {
    pub problem: &'a Problem,
    pub ends: &'a Ends,
    pub context: &'a Context<'c>,
}

impl Rolls<'_, '_> {
    /// Returns the local minimum in the direction of descent from the roll `from`; `None` if this
    /// roll has no plan.
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

    /// Returns the maneuver to the terminal attitude of a roll.
    fn facing(&self, roll: f64) -> Problem {
        self.problem.facing(self.ends, roll)
    }

    /// Returns the cost and its derivative from the costates of attitude and momentum at the end.
    fn known(&self, roll: f64, cost: f64, [turn, momentum]: &[Vector3; 2]) -> Known {
        let (by_turn, by_rate) = self.ends.along_roll(&self.facing(roll).end.angular_velocity);
        let by_momentum = self.problem.body.inertia.j() * by_rate;
        Known { roll, cost, slope: -turn.dot(&by_turn) - momentum.dot(&by_momentum) }
    }

    /// Computes the plan with pulses to a roll; `None` if no plan exists.
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

    /// Returns the nearest roll within the allowed band.
    fn held(&self, roll: f64) -> f64 {
        if self.ends.within() >= PI { roll } else { roll.clamp(-self.ends.within(), self.ends.within()) }
    }

    /// Returns the minimum in the direction of descent from a plan: the root of the derivative.
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
                // Another extremal is the cheapest at the new roll, or no plan exists.
                _ => reach *= 0.25,
            }
        }
        let Some(mut beyond) = beyond else { return Ok(best) };
        let (mut low, mut illinois) = (best, Illinois::new([best.slope, beyond.slope]));
        for _ in 0..MOST_EVALUATIONS {
            let roll = low.roll + illinois.part() * (beyond.roll - low.roll);
            // The derivative predicts no further gain.
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

/// Returns the costates of attitude and momentum at the end of a plan.
fn costates_at_end(plan: &Solution) -> Option<[Vector3; 2]> {
    let costates = &plan.trajectory.costates;
    let first = costates.len().checked_sub(6)?;
    Some([first, first + 3].map(|first| Vector3::from_column_slice(&costates[first..first + 3])))
}
