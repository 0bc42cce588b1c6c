//! The least cost over the roll about a boresight, at one time.
//!
//! The least cost `V(ρ)` of a maneuver to the end of roll ρ is planned as any maneuver to a given end, with all its starts,
//! senses, limits and cones; the envelope of these is what is minimised here. Where its slope is told (`transversality`), a root at
//! which it rises is a minimum over the roll and, since the plan is one for its roll, a minimum on the manifold of ends; where V has
//! several, they are rivals. V is the least of several extremals, so its kinks are concave and no minimum is at one. Where
//! costates do not tell the slope (time and fuel, wheels), parabolas through values are minimised. Over a band the ends of it count
//! as minima where the slope leads out of it.

use super::PlanError;
use super::halt::Halt;
use super::illinois::Illinois;
use super::transversality::{slope_of_roll, takes_a_guess};
use super::{Guess, Observer, solve};
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::{Motion, Problem, Stepping};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Rival, Solution};
use std::f64::consts::PI;
use std::time::Instant;

/// Rolls that are looked at over a whole turn: time against minima that are missed
/// (`cargo run --release -p evidence -- rolls`).
const ROLLS: usize = 12;

/// The fewest parts of a band: one narrower than a few of these may hold two minima all the same.
const FEWEST: usize = 6;

/// A slope below this part of the cost per radian is none: what the tolerance of the costates leaves of it.
const STATIONARY: f64 = 1e-12;

/// The same on a coarser grid than the plan's, whose minimum is only looked for from there.
const NEARLY: f64 = 1e-4;

/// By how much of its cost a plan on a coarse grid must be cheaper to be another one.
const CHEAPER: f64 = 0.02;

/// Rolls nearer than this \[rad\] are one where values tell the minimum: their costs differ by its square.
const RESOLVED: f64 = 1e-5;

/// Minima nearer than this \[rad\] are one, found from two sides.
const SAME: f64 = 1e-3;

/// Steps of the grids on which rolls are compared at first, at most.
pub(super) const EXPLORED: usize = 32;

/// First stride from the minimum of another grid or time \[rad\]: of second order in the step.
pub(super) const REFINED: f64 = 0.05;

/// Most evaluations about one minimum.
const MOST_EVALUATIONS: usize = 40;

/// A plan at one roll.
#[derive(Clone)]
pub(super) struct Known {
    pub roll: f64,
    /// Of its grid, as it was asked for: a plan whose inputs switch may have one more.
    steps: usize,
    pub solution: Solution,
    /// `dV/dρ`; `None` where costates do not tell.
    slope: Option<f64>,
}

/// Plans to ends of one time, roll after roll.
pub(super) struct Rolls<'a> {
    problem: &'a Problem,
    ends: Ends,
    settings: Settings,
    observer: &'a mut dyn Observer,
    began: Instant,
    /// A roll that has no plan, with what came of it.
    pub unsolved: Option<Box<Solution>>,
    refused: Option<PlanError>,
}

impl<'a> Rolls<'a> {
    pub fn new(
        problem: &'a Problem,
        ends: Ends,
        settings: &Settings,
        observer: &'a mut dyn Observer,
    ) -> Self {
        // Rolls are compared by their discrete optima; the plan of the best lands.
        let settings = Settings { target: Target::Discrete, test_second_order: false, ..settings.clone() };
        Self { problem, ends, settings, observer, began: Instant::now(), unsolved: None, refused: None }
    }

    /// The least cost at a roll; `guess` is that of a neighbour.
    pub fn at(&mut self, roll: f64, steps: usize, guess: Option<&Known>) -> Result<Option<Known>, Halt> {
        let problem = self.problem.facing(&self.ends, roll).with_steps(steps);
        if let Err(error) = problem.check() {
            // Cones leave nothing of some rolls.
            self.refused.get_or_insert(error.into());
            return Ok(None);
        }
        let remaining = self.settings.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()));
        let settings = Settings { time_limit: remaining, ..self.settings.clone() };
        let taken = takes_a_guess(&problem);
        let costates = guess.filter(|_| taken).map(|known| Guess::of(&known.solution, &problem));
        let solution = match &costates {
            Some(guess) if problem.motion == Motion::Attitude && shoots(&problem) => {
                let polished = super::polish(&problem, &settings, &guess.costates, self.observer)?;
                if polished.outcome == Outcome::Converged {
                    polished
                } else {
                    solve(&problem, &settings, Some(guess), self.observer)?
                }
            }
            guess => solve(&problem, &settings, guess.as_ref(), self.observer)?,
        };
        match solution.outcome {
            Outcome::Converged => {}
            Outcome::TimeLimit | Outcome::Interrupted => return Err(Halt::Stopped(Box::new(solution))),
            _ => {
                self.unsolved.get_or_insert(Box::new(solution));
                return Ok(None);
            }
        }
        let slope = if self.ends.has_roll() { slope_of_roll(&problem, &self.ends, &solution) } else { None };
        Ok(Some(Known { roll, steps, solution, slope }))
    }

    /// The minima over the roll on `steps` steps, the cheapest first.
    pub fn minima(&mut self, steps: usize) -> Result<Vec<Known>, Halt> {
        if !self.ends.has_roll() {
            return Ok(self.at(0.0, steps, None)?.into_iter().collect());
        }
        let (within, around) = (self.ends.within(), self.ends.within() >= PI);
        let count = ((ROLLS as f64 * within / PI).ceil() as usize).max(FEWEST);
        let spacing = 2.0 * within / count as f64;
        // All around the last is the first once more.
        let last = if around { count } else { count + 1 };
        let mut seen = Vec::with_capacity(last);
        for index in 0..last {
            seen.push(self.at(-within + spacing * index as f64, steps, None)?);
        }
        let cost = |index: usize| seen[index].as_ref().map_or(f64::INFINITY, |known| known.solution.cost);
        let mut minima = Vec::new();
        for (index, middle) in seen.iter().enumerate() {
            let Some(middle) = middle else { continue };
            let before = if index > 0 { Some(index - 1) } else { around.then_some(last - 1) };
            let after = if index + 1 < last { Some(index + 1) } else { around.then_some(0) };
            let lowest = [before, after].into_iter().flatten().all(|beside| cost(index) <= cost(beside));
            if lowest {
                minima.push(self.lowest(middle.clone(), spacing, steps)?);
            }
        }
        minima.sort_by(|a, b| a.solution.cost.total_cmp(&b.solution.cost));
        minima.dedup_by(|b, a| apart(a.roll, b.roll) < SAME);
        Ok(minima)
    }

    /// The minimum downhill of a plan, looked for in steps of `stride` \[rad\] at first.
    pub fn lowest(&mut self, from: Known, stride: f64, steps: usize) -> Result<Known, Halt> {
        let from = if from.steps == steps {
            from
        } else {
            // Another grid has another cost, and another slope.
            match self.at(from.roll, steps, Some(&from))? {
                Some(from) => from,
                None => return Ok(from),
            }
        };
        if !self.ends.has_roll() {
            return Ok(from);
        }
        if from.slope.is_some()
            && let Some(found) = self.stationary(from.clone(), stride, steps)?
        {
            return Ok(found);
        }
        self.by_values(from, stride, steps)
    }

    /// A roll within the band.
    fn held(&self, roll: f64) -> f64 {
        if self.ends.within() >= PI { roll } else { roll.clamp(-self.ends.within(), self.ends.within()) }
    }

    /// By the root of the slope; `None` where a roll on the way has no plan or no slope.
    fn stationary(&mut self, from: Known, stride: f64, steps: usize) -> Result<Option<Known>, Halt> {
        let slope = |known: &Known| known.slope.unwrap_or(f64::NAN);
        let least = if steps == self.problem.steps { STATIONARY } else { NEARLY };
        let settled = |known: &Known| slope(known).abs() <= least * known.solution.cost.abs();
        if settled(&from) {
            return Ok(Some(from));
        }
        let down = slope(&from) < 0.0;
        // From neighbour to neighbour, so that costates stay within the reach of Newton, until the slope turns.
        let (mut near, mut reach) = (from, if down { stride } else { -stride });
        let mut far = loop {
            let roll = self.held(near.roll + reach);
            if roll == near.roll {
                // At the edge of the band, and the slope leads out of it.
                return Ok(Some(near));
            }
            let Some(next) = self.at(roll, steps, Some(&near))? else { return Ok(None) };
            if slope(&next).is_nan() || reach.abs() > PI {
                return Ok(None);
            }
            if (slope(&next) < 0.0) != down {
                break next;
            }
            (near, reach) = (next, 2.0 * reach);
        };
        let mut illinois = Illinois::new([slope(&near), slope(&far)]);
        for _ in 0..MOST_EVALUATIONS {
            let part = illinois.part();
            let roll = near.roll + part * (far.roll - near.roll);
            let inside = roll > near.roll.min(far.roll) && roll < near.roll.max(far.roll);
            if !inside {
                break;
            }
            let closest = if part < 0.5 { &near } else { &far };
            let Some(next) = self.at(roll, steps, Some(closest))? else { return Ok(None) };
            if settled(&next) {
                return Ok(Some(next));
            }
            let moved = usize::from((slope(&next) < 0.0) != down);
            illinois.moved(moved, slope(&next));
            *[&mut near, &mut far][moved] = next;
        }
        let better = if slope(&near).abs() < slope(&far).abs() { near } else { far };
        Ok(Some(better))
    }

    /// By parabolas through values, or the golden section where they fail.
    fn by_values(&mut self, from: Known, stride: f64, steps: usize) -> Result<Known, Halt> {
        const GOLDEN: f64 = 0.381_966_011_250_105;
        let value = |known: &Option<Known>| known.as_ref().map_or(f64::INFINITY, |known| known.solution.cost);
        let mut best = from;
        // Both sides, as far as the cost goes on falling; a roll without a plan costs any price.
        let mut sides = [(best.roll, f64::INFINITY); 2];
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let mut reach = sign * stride;
            loop {
                let roll = self.held(best.roll + reach);
                if roll == best.roll {
                    sides[side] = (roll, f64::INFINITY);
                    break;
                }
                let found = self.at(roll, steps, Some(&best))?;
                let cost = value(&found);
                match found.filter(|found| found.solution.cost < best.solution.cost && reach.abs() <= PI) {
                    None => {
                        sides[side] = (roll, cost);
                        break;
                    }
                    Some(found) => {
                        sides[1 - side] = (best.roll, best.solution.cost);
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
            let vertex = vertex(sides[0], (x, best.solution.cost), sides[1]).filter(inside);
            let mut roll = vertex.unwrap_or(larger);
            if (roll - x).abs() < RESOLVED {
                // The best is at the vertex: the larger part is closed in from here.
                roll = if high - x > x - low { x + 2.0 * RESOLVED } else { x - 2.0 * RESOLVED };
            }
            if !(roll > low && roll < high) {
                break;
            }
            let found = self.at(roll, steps, Some(&best))?;
            let cost = value(&found);
            match found.filter(|_| cost < best.solution.cost) {
                Some(found) => {
                    let left = (x, best.solution.cost);
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

    /// The plan at the best of some minima, on the grid and with the target that is asked for.
    pub fn planned(&mut self, minima: Vec<Known>, settings: &Settings) -> Result<Solution, Halt> {
        let minima = self.on_steps(minima, self.problem.steps)?;
        let Some(best) = minima.first().cloned() else { return self.without_plan() };
        let (mut best, mut problem) = (best, self.problem.clone());
        let mut chosen = None;
        for _ in 0..2 {
            // Steps that are chosen are those of the plan at the best roll so far.
            if best.steps != problem.steps {
                best = self.lowest(best, REFINED, problem.steps)?;
            }
            let remaining = settings.time_limit.map(|limit| limit.saturating_sub(self.began.elapsed()));
            let settings = Settings { time_limit: remaining, ..settings.clone() };
            let given = problem.facing(&self.ends, best.roll);
            let guess = takes_a_guess(&given).then(|| Guess::of(&best.solution, &given));
            let found = solve(&given, &settings, guess.as_ref(), self.observer)?;
            let again =
                problem.chooses_steps && found.outcome == Outcome::Converged && found.steps != problem.steps;
            let chosen_before = chosen.take();
            chosen = found.chosen.or(chosen_before);
            if again {
                problem = problem.with_steps(found.steps);
                continue;
            }
            let found = Solution { chosen, ..found };
            let found =
                if guess.is_some() { self.beside_others(found, &given, &best, &settings)? } else { found };
            return Ok(with_rivals(found, &best, &minima));
        }
        let given = problem.facing(&self.ends, best.roll);
        let found = solve(&given, settings, None, self.observer)?;
        Ok(with_rivals(Solution { chosen, ..found }, &best, &minima))
    }

    /// A plan that was found from a guess, with its rivals at the same roll, which a search on a coarse grid finds; or the plan without a
    /// guess, where that search finds one which is cheaper by more than grids differ.
    fn beside_others(
        &mut self,
        mut found: Solution,
        given: &Problem,
        best: &Known,
        settings: &Settings,
    ) -> Result<Solution, Halt> {
        if found.outcome != Outcome::Converged {
            return Ok(found);
        }
        let searched = match self.at(best.roll, given.steps.min(EXPLORED), None) {
            Ok(searched) => searched,
            // The plan is there: what stops now stops the search for others alone.
            Err(Halt::Stopped(_)) => return Ok(found),
            Err(refused) => return Err(refused),
        };
        let Some(Known { solution: other, .. }) = searched else { return Ok(found) };
        if other.cost < best.solution.cost * (1.0 - CHEAPER) {
            let whole = solve(given, settings, None, self.observer)?;
            if whole.outcome == Outcome::Converged && whole.cost < found.cost {
                return Ok(whole);
            }
        }
        found.rivals = other.rivals;
        Ok(found)
    }

    /// The minima on another grid: what a coarse one errs by may be more than what they differ by.
    fn on_steps(&mut self, minima: Vec<Known>, steps: usize) -> Result<Vec<Known>, Halt> {
        if minima.iter().all(|known| known.steps == steps) {
            return Ok(minima);
        }
        let mut carried = Vec::with_capacity(minima.len());
        for known in minima {
            carried.push(self.lowest(known, REFINED, steps)?);
        }
        // A minimum whose roll has no plan on that grid is none.
        carried.retain(|known| known.steps == steps);
        carried.sort_by(|a, b| a.solution.cost.total_cmp(&b.solution.cost));
        Ok(carried)
    }

    /// What there is to tell where no roll has a plan.
    fn without_plan(&mut self) -> Result<Solution, Halt> {
        match (self.unsolved.take(), self.refused.take()) {
            (Some(solution), _) => {
                // What is proved of one roll is not of the others.
                let reason = solution.infeasible.map(|proof| Shortfall::Told(proof.reason));
                let shortfall = solution.shortfall.or(reason);
                Ok(Solution { outcome: Outcome::Stalled, infeasible: None, shortfall, ..*solution })
            }
            (None, Some(error)) => Err(error.into()),
            (None, None) => Ok(Solution::unsolved(self.problem, self.settings.tolerance)),
        }
    }
}

/// A plan with the other minima over the roll beside it, and how far its cost is from stationary.
fn with_rivals(mut found: Solution, best: &Known, minima: &[Known]) -> Solution {
    let cost_of = |known: &Known| known.solution.cost;
    // At the edge of a band the slope leads out of it.
    let inside = |slope: &f64| {
        slope.abs() <= NEARLY * cost_of(best).abs() && found.optimality.stationarity.is_finite()
    };
    if let Some(slope) = best.slope.filter(inside) {
        let relative = slope.abs() / cost_of(best).abs().max(f64::MIN_POSITIVE);
        found.optimality.stationarity = found.optimality.stationarity.max(relative);
    }
    // The first of them is the one from which the best was found.
    let others = minima.iter().skip(1);
    found.rivals.extend(others.map(|known| {
        let start = format!("roll {:+.1} deg", known.roll.to_degrees());
        Rival::new(&start, known.solution.sense, cost_of(known), known.solution.turned_deg)
    }));
    found.rivals.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// Whether the shooting plans a maneuver, and a neighbour's costates may be all that it needs.
fn shoots(problem: &Problem) -> bool {
    super::check_for_shooting(problem).is_ok() && problem.stepping != Stepping::Equal
}

/// The lowest point of the parabola through three points, the middle one of which is lowest.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let [left, right] = [a, c].map(|(x, y)| ((x - b.0), (y - b.1)));
    let (p, q) = (left.0 * right.1, right.0 * left.1);
    let offset = 0.5 * (right.0 * q - left.0 * p) / (q - p);
    offset.is_finite().then_some(b.0 + offset)
}

/// The angle between two rolls.
fn apart(a: f64, b: f64) -> f64 {
    let turns = (a - b) / (2.0 * PI);
    2.0 * PI * (turns - turns.round()).abs()
}
