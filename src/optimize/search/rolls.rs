//! The least cost over the roll about a boresight of plans whose inputs switch, at one time.
//!
//! The least cost `V(ρ)` of a maneuver to the end of roll ρ is planned as any maneuver to a given
//! end, in continuous time. Its slope is the costate at the end about the boresight. From the roll that
//! the chain of equal steps leads to, strides downhill and the root of the slope between the last two
//! lead to the nearest minimum. V is the least of several extremals, so its kinks are concave and no
//! minimum is at one.

use super::cheapest::of_arcs;
use super::context::Context;
use super::halt::Halt;
use super::illinois::Illinois;
use super::tuning::SearchTuning;
use super::{Observer, without_arcs};
use crate::Vector3;
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::{Outcome, Solution};
use std::f64::consts::PI;
use std::time::Instant;

/// Part of the cost that is none.
const GAINED: f64 = 1e-6;

/// Steps of the grid on which rolls are compared, at most: arcs do not depend on it.
const COMPARED: usize = 32;

/// Most evaluations about one minimum.
const MOST_EVALUATIONS: usize = 8;

/// A plan at one roll.
#[derive(Clone)]
pub(super) struct Known {
    pub roll: f64,
    /// What it costs in continuous time, which changes smoothly with the roll as that on a grid
    /// does not.
    pub cost: f64,
    /// The derivative of that.
    slope: f64,
    pub solution: Solution,
}

/// Plans to ends of one time, roll after roll.
pub(super) struct Rolls<'a> {
    problem: Problem,
    ends: Ends,
    settings: Settings,
    tuning: SearchTuning,
    observer: &'a mut dyn Observer,
    began: Instant,
}

impl<'a> Rolls<'a> {
    pub fn new(problem: &Problem, ends: Ends, settings: &Settings, observer: &'a mut dyn Observer) -> Self {
        // Rolls are compared by their discrete optima; the plan of the best lands.
        let settings = Settings { target: Target::Discrete, test_second_order: false, ..settings.clone() };
        let problem = problem.clone().with_steps(problem.steps.min(COMPARED));
        Self { problem, ends, settings, tuning: SearchTuning::default(), observer, began: Instant::now() }
    }

    /// Returns the plan at a roll; `None` where there is none.
    pub fn at(&mut self, roll: f64) -> Result<Option<Known>, Halt> {
        let problem = self.problem.facing(&self.ends, roll);
        if problem.check().is_err() {
            // Cones leave nothing of some rolls.
            return Ok(None);
        }
        let remaining = self.settings.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()));
        let settings = Settings { time_limit: remaining, ..self.settings.clone() };
        // Arcs do not depend on a grid, so that none is searched where they tell the cost.
        let arcs = of_arcs(&problem, &Context::new(&settings, self.observer));
        let solution = match arcs {
            Some(arcs) => arcs,
            None => without_arcs(&problem, &settings, None, self.observer)?,
        };
        match solution.outcome {
            Outcome::Converged => {
                let continuous = solution.switching.as_ref().map(|found| found.continuous_cost);
                let cost = continuous.unwrap_or(solution.cost);
                Ok(Some(Known { roll, cost, slope: slope(&problem, &self.ends, &solution), solution }))
            }
            Outcome::TimeLimit | Outcome::Interrupted => Err(Halt::Stopped(Box::new(solution))),
            _ => Ok(None),
        }
    }

    /// Returns the plan at the minimum downhill of a roll; `None` where that roll has no plan.
    pub fn lowest(&mut self, from: f64) -> Result<Option<Known>, Halt> {
        let Some(mut best) = self.at(from)? else { return Ok(None) };
        if !self.ends.has_roll() {
            return Ok(Some(best));
        }
        for beside in self.tuning.beside {
            let roll = self.held(from + beside);
            if let Some(found) = self.at(roll)?.filter(|found| found.cost < best.cost) {
                best = found;
            }
        }
        self.downhill(best).map(Some)
    }

    /// Returns a roll within the band.
    fn held(&self, roll: f64) -> f64 {
        if self.ends.within() >= PI { roll } else { roll.clamp(-self.ends.within(), self.ends.within()) }
    }

    /// Returns the minimum downhill of a plan: the root of the slope.
    fn downhill(&mut self, from: Known) -> Result<Known, Halt> {
        let (mut best, mut reach, mut beyond) = (from, self.tuning.stride, None);
        for _ in 0..MOST_EVALUATIONS {
            let roll = self.held(best.roll - reach * best.slope.signum());
            if roll == best.roll || reach > PI {
                break;
            }
            match self.at(roll)? {
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
        let (mut low, mut illinois) = (best.clone(), Illinois::new([best.slope, beyond.slope]));
        for _ in 0..MOST_EVALUATIONS {
            let roll = low.roll + illinois.part() * (beyond.roll - low.roll);
            // By its slope the best is the lowest.
            if (best.slope * (roll - best.roll)).abs() <= GAINED * best.cost {
                break;
            }
            let Some(next) = self.at(roll)? else { break };
            let moved = usize::from(next.slope * low.slope < 0.0);
            illinois.moved(moved, next.slope);
            *[&mut low, &mut beyond][moved] = next;
            let cheaper = if low.cost < beyond.cost { &low } else { &beyond };
            if cheaper.cost < best.cost {
                best = cheaper.clone();
            }
        }
        Ok(best)
    }
}

/// Returns the derivative of the cost of a plan by the roll of its end, which the costates there are.
fn slope(problem: &Problem, ends: &Ends, plan: &Solution) -> f64 {
    let costates = &plan.trajectory.costates;
    let [turn, momentum] = [6, 3].map(|back| {
        let first = costates.len().checked_sub(back);
        first.map_or(Vector3::repeat(f64::NAN), |first| {
            Vector3::from_column_slice(&costates[first..first + 3])
        })
    });
    let (by_turn, by_rate) = ends.along_roll(&problem.end.angular_velocity);
    -turn.dot(&by_turn) - momentum.dot(&(problem.body.inertia.j() * by_rate))
}
