//! The least cost over the roll about a boresight of plans whose inputs switch, at one time.
//!
//! The least cost `V(ρ)` of a maneuver to the end of roll ρ is planned as any maneuver to a given
//! end, in continuous time. From the roll that the chain of equal steps leads to, parabolas through
//! values of V, or the golden section where they fail, lead to the nearest minimum. V is the least
//! of several extremals, so its kinks are concave and no minimum is at one.

use super::cheapest::of_arcs;
use super::context::Context;
use super::halt::Halt;
use super::tuning::SearchTuning;
use super::{Observer, without_arcs};
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::solution::{Outcome, Solution};
use std::f64::consts::PI;
use std::time::Instant;

/// Rolls nearer than this \[rad\] are one: their costs differ by its square.
const RESOLVED: f64 = 1e-5;

/// Steps of the grid on which rolls are compared, at most: arcs do not depend on it.
const COMPARED: usize = 32;

/// Most evaluations about one minimum.
const MOST_EVALUATIONS: usize = 40;

/// A plan at one roll.
#[derive(Clone)]
pub(super) struct Known {
    pub roll: f64,
    /// What it costs in continuous time, which changes smoothly with the roll as that on a grid
    /// does not.
    pub cost: f64,
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
                Ok(Some(Known { roll, cost, solution }))
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
        self.by_values(best).map(Some)
    }

    /// Returns a roll within the band.
    fn held(&self, roll: f64) -> f64 {
        if self.ends.within() >= PI { roll } else { roll.clamp(-self.ends.within(), self.ends.within()) }
    }

    /// Returns the minimum by parabolas through values, or the golden section where they fail.
    fn by_values(&mut self, from: Known) -> Result<Known, Halt> {
        const GOLDEN: f64 = 0.381_966_011_250_105;
        let value = |known: &Option<Known>| known.as_ref().map_or(f64::INFINITY, |known| known.cost);
        let mut best = from;
        // Both sides, as far as the cost goes on falling; a roll without a plan costs any price.
        let mut sides = [(best.roll, f64::INFINITY); 2];
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let mut reach = sign * self.tuning.stride;
            loop {
                let roll = self.held(best.roll + reach);
                if roll == best.roll {
                    sides[side] = (roll, f64::INFINITY);
                    break;
                }
                let found = self.at(roll)?;
                let cost = value(&found);
                match found.filter(|found| found.cost < best.cost && reach.abs() <= PI) {
                    None => {
                        sides[side] = (roll, cost);
                        break;
                    }
                    Some(found) => {
                        sides[1 - side] = (best.roll, best.cost);
                        (best, reach) = (found, 2.0 * reach);
                    }
                }
            }
            if sides[1].1 < f64::INFINITY && side == 0 {
                // The cost fell that way: the other side is known.
                break;
            }
        }
        let [mut low, mut high] = [sides[0].0, sides[1].0];
        for _ in 0..MOST_EVALUATIONS {
            if high - low <= 2.0 * RESOLVED {
                break;
            }
            let x = best.roll;
            let larger = if high - x > x - low { x + GOLDEN * (high - x) } else { x - GOLDEN * (x - low) };
            let inside = |roll: &f64| *roll > low + RESOLVED && *roll < high - RESOLVED;
            let vertex = vertex(sides[0], (x, best.cost), sides[1]).filter(inside);
            let mut roll = vertex.unwrap_or(larger);
            if (roll - x).abs() < RESOLVED {
                // The best is at the vertex: the larger part is closed in from here.
                roll = if high - x > x - low { x + 2.0 * RESOLVED } else { x - 2.0 * RESOLVED };
            }
            if !(roll > low && roll < high) {
                break;
            }
            let found = self.at(roll)?;
            let cost = value(&found);
            match found.filter(|_| cost < best.cost) {
                Some(found) => {
                    let left = (x, best.cost);
                    if roll > x {
                        (low, sides[0]) = (x, left);
                    } else {
                        (high, sides[1]) = (x, left);
                    }
                    best = found;
                }
                None if roll > x => (high, sides[1]) = (roll, (roll, cost)),
                None => (low, sides[0]) = (roll, (roll, cost)),
            }
        }
        Ok(best)
    }
}

/// The lowest point of the parabola through three points, the middle one of which is lowest.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let [left, right] = [a, c].map(|(x, y)| ((x - b.0), (y - b.1)));
    let (p, q) = (left.0 * right.1, right.0 * left.1);
    let offset = 0.5 * (right.0 * q - left.0 * p) / (q - p);
    offset.is_finite().then_some(b.0 + offset)
}
