//! The least cost over a free roll along branches of extremals.
//!
//! The extremals to the ends of all rolls are branches over ρ, which close after two turns: after one the end is reached the other way
//! round. Where Newton takes a neighbour's costates, a branch is followed for a tenth of a search at each roll, and a few searches
//! find the branches. A minimum lies where the slope along a branch turns upwards, also between rolls at which another branch is
//! cheaper, which values at rolls alone would miss. Where costates do not tell the slope, each of [`ROLLS`] rolls is searched.

use super::{Known, ROLLS, Rolls, SAME, apart};
use crate::maneuver::solution::Outcome;
use crate::optimize::search::halt::Halt;
use crate::optimize::search::transversality::slope_of_roll;
use crate::optimize::search::{Guess, polish};
use std::f64::consts::PI;

/// Rolls at which everything is searched for: time against branches that are missed
/// (`cargo run --release -p evidence --bin rolls`).
const SEARCHED: usize = 3;

/// A branch is known where another passes with this difference of costs, relative.
const SAME_BRANCH: f64 = 1e-7;

/// Minima above the best by more than this part are not looked for any closer: of what the cubic between two rolls may be off.
const HOPELESS: f64 = 0.03;

/// The minima along the branches that searches at a few rolls find, the cheapest first; none where costates do not tell.
pub(super) fn minima(rolls: &mut Rolls<'_>, steps: usize) -> Result<Vec<Known>, Halt> {
    let spacing = 2.0 * PI / ROLLS as f64;
    let mut branches: Vec<Vec<Known>> = Vec::new();
    for seed in 0..SEARCHED {
        let roll = -PI + spacing * (ROLLS / SEARCHED * seed) as f64;
        let Some(found) = rolls.at(roll, steps, None)? else { continue };
        if found.slope.is_none() {
            return Ok(Vec::new());
        }
        let known = branches.iter().flatten().any(|other| is_same(other, &found));
        if !known {
            let mut branch = followed(rolls, &found, -spacing, steps)?;
            branch.reverse();
            let closed = branch.len() == 2 * ROLLS;
            branch.push(found.clone());
            if !closed {
                branch.extend(followed(rolls, &found, spacing, steps)?);
            }
            branches.push(branch);
        }
    }
    // Where the slope turns upwards between neighbours, with the cost there by the cubic through both.
    let mut valleys: Vec<(f64, Known)> = Vec::new();
    for pair in branches.iter().flat_map(|branch| branch.windows(2)) {
        if let [Some(left), Some(right)] = [pair[0].slope, pair[1].slope]
            && left <= 0.0
            && right > 0.0
        {
            let width = pair[1].roll - pair[0].roll;
            let (lowest, part) =
                bottom([pair[0].solution.cost, pair[1].solution.cost], [left * width, right * width]);
            valleys.push((lowest, pair[usize::from(part > 0.5)].clone()));
        }
    }
    valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
    let hopeless = valleys.first().map_or(f64::INFINITY, |(cost, _)| cost + HOPELESS * cost.abs());
    let mut minima: Vec<Known> = Vec::new();
    for (cost, near) in valleys {
        if cost > hopeless {
            break;
        }
        let found = rolls.lowest(near, 0.5 * spacing, steps)?;
        let turns = (found.roll / (2.0 * PI)).round();
        minima.push(Known { roll: found.roll - 2.0 * PI * turns, ..found });
    }
    minima.sort_by(|a, b| a.solution.cost.total_cmp(&b.solution.cost));
    minima.dedup_by(|b, a| is_same(a, b));
    Ok(minima)
}

/// The neighbours of an extremal along its branch, in steps of `spacing` \[rad\]: two turns of them, or as far as Newton goes.
fn followed(rolls: &mut Rolls<'_>, from: &Known, spacing: f64, steps: usize) -> Result<Vec<Known>, Halt> {
    let mut branch: Vec<Known> = Vec::new();
    for index in 1..=2 * ROLLS {
        let near = branch.last().unwrap_or(from);
        let problem = rolls.problem.facing(&rolls.ends, near.roll + spacing).with_steps(steps);
        if problem.check().is_err() {
            break;
        }
        let guess = Guess::of(&near.solution, &problem);
        let solution = polish(&problem, &rolls.settings, &guess.costates, rolls.observer)?;
        match solution.outcome {
            Outcome::Converged => {}
            Outcome::TimeLimit | Outcome::Interrupted => return Err(Halt::Stopped(Box::new(solution))),
            _ => break,
        }
        let slope = slope_of_roll(&problem, &rolls.ends, &solution);
        let roll = from.roll + spacing * index as f64;
        branch.push(Known { roll, steps, solution, slope });
    }
    Ok(branch)
}

/// Whether two plans are one: at rolls of one attitude, at one cost.
fn is_same(a: &Known, b: &Known) -> bool {
    let costs = (a.solution.cost - b.solution.cost).abs();
    apart(a.roll, b.roll) < SAME && costs <= SAME_BRANCH * a.solution.cost.abs()
}

/// The least value of the cubic with these values and slopes at 0 and 1, of which the first slope is downward and the second upward,
/// and where it is.
fn bottom([a, b]: [f64; 2], [left, right]: [f64; 2]) -> (f64, f64) {
    let at = |x: f64| {
        let (y, s) = (1.0 - x, x * (1.0 - x));
        a * y * y * (1.0 + 2.0 * x) + b * x * x * (1.0 + 2.0 * y) + left * s * y - right * s * x
    };
    let slope = |x: f64| {
        6.0 * (b - a) * x * (1.0 - x) + left * (1.0 - x) * (1.0 - 3.0 * x) + right * x * (3.0 * x - 2.0)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if slope(middle) < 0.0 { low = middle } else { high = middle }
    }
    (at(0.5 * (low + high)), 0.5 * (low + high))
}
