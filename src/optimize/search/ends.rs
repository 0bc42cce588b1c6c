//! An end on a target, and when it is come to.
//!
//! In a duration that is known, and to a target that stands, the end is the best over the roll (`rolls`). Where the duration is sought and
//! the target moves: at a price of time the end moves with the duration, and so does the derivative of the least cost
//! (`duration`, `transversality`); in least time T is the first time at which the quickest plan to the end *at that time* takes no
//! longer, a root of `T*(T) − T`, looked for from below, since the target may come nearer and go away again.

use super::halt::Halt;
use super::illinois::Illinois;
use super::rolls::{EXPLORED, REFINED, Rolls};
use super::{Observer, PlanError, duration, solve};
use crate::Matrix3;
use crate::maneuver::aim::{Aim, Ends};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, ProblemError};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::maneuver::solution::{Outcome, Solution};
use std::time::Instant;

/// Times nearer than this, relative, are one: the plan on its grid takes longer by more, and is followed from there.
const NEAR: f64 = 1e-9;

/// Times further apart than this, relative, tell a slope: of nearer ones the best rolls differ by what they are resolved to.
const APART: f64 = 1e-4;

/// The slope of how late a plan is to an end that stands.
const STANDS: f64 = -1.0;

/// Most times that are looked at.
const MOST_TIMES: usize = 40;

/// Solves a maneuver that ends on a target.
pub(super) fn solve_to(
    problem: &Problem,
    aim: &Aim,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    let began = Instant::now();
    let searched = match problem.duration.known() {
        Some(duration) => in_time(problem, aim, duration, settings, observer),
        None if !aim.moves(&problem.environment.frame_rate()) => {
            in_time(problem, aim, 0.0, settings, observer)
        }
        None if problem.objective == Objective::Time => quickest(problem, aim, settings, observer),
        None => at_best_duration(problem, aim, settings, observer),
    };
    let solution = match searched {
        Ok(solution) => solution,
        Err(Halt::Stopped(solution)) => *solution,
        Err(Halt::Refused(error)) => return Err(error),
    };
    Ok(Solution { solve_time: began.elapsed().as_secs_f64(), ..solution })
}

/// The ends of a maneuver at a time.
fn ends_at(problem: &Problem, aim: &Aim, time: f64) -> Result<Ends, Halt> {
    let ends = problem.ends_on(aim, time);
    Ok(ends.map_err(|error| PlanError::from(ProblemError::from(error)))?)
}

/// The plan to the best of the ends of one time.
fn in_time(
    problem: &Problem,
    aim: &Aim,
    time: f64,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, Halt> {
    let ends = ends_at(problem, aim, time)?;
    let mut rolls = Rolls::new(problem, ends, settings, observer);
    let minima = rolls.minima(problem.steps.min(EXPLORED))?;
    rolls.planned(minima, settings)
}

/// Least effort at a price of time or up to a longest duration, to a target that moves.
fn at_best_duration(
    problem: &Problem,
    aim: &Aim,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, Halt> {
    let discrete = Settings { target: Target::Discrete, ..settings.clone() };
    let mut given = |problem: &Problem, settings: &Settings, observer: &mut dyn Observer| {
        solve_to(problem, aim, settings, observer)
    };
    // How long it may take is guessed from where the target is at first.
    let likely = problem.facing(&ends_at(problem, aim, 0.0)?, 0.0);
    let likely = Problem { end_condition: problem.end_condition.clone(), ..likely };
    let found = duration::solve(&likely, &discrete, observer, &mut given)?;
    let Some(best) = found.trajectory.time.last().copied() else { return Ok(found) };
    if found.outcome != Outcome::Converged || settings.target == Target::Discrete {
        return Ok(found);
    }
    let priced = problem.objective.time_price() * best;
    let mut landed = in_time(&problem.clone().lasting(best), aim, best, settings, observer)?;
    let stationarity = landed.optimality.stationarity.max(found.optimality.stationarity);
    landed.pay_for_time(priced);
    landed.optimality.stationarity = stationarity;
    Ok(landed)
}

/// Least time to a target that moves.
fn quickest(
    problem: &Problem,
    aim: &Aim,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, Halt> {
    let began = Instant::now();
    let remaining = || settings.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
    let quick = Settings { search: Thoroughness::Quick, ..settings.clone() };
    // The attitude at the best roll moves with the time, and little: after the first time it is followed.
    let mut best: Option<Matrix3> = None;
    let mut last: Option<Solution> = None;
    let mut seen: Vec<Late> = Vec::new();
    let mut late = |time: f64, observer: &mut dyn Observer| -> Result<Option<f64>, Halt> {
        let settings = Settings { time_limit: remaining(), ..quick.clone() };
        let ends = ends_at(problem, aim, time)?;
        let mut rolls = Rolls::new(problem, ends, &settings, observer);
        let steps = problem.steps.min(EXPLORED);
        let found = match best.map(|attitude| ends.nearest(&attitude)) {
            None => rolls.minima(steps)?.into_iter().next(),
            Some(near) => match rolls.at(near, steps, None)? {
                Some(near) => Some(rolls.lowest(near, REFINED, steps)?),
                None => rolls.minima(steps)?.into_iter().next(),
            },
        };
        let Some(found) = found else {
            last = rolls.unsolved.take().map(|solution| *solution);
            return Ok(None);
        };
        best = Some(ends.at(found.roll).0);
        let delay = takes(problem, &found.solution) - time;
        seen.push([time, delay]);
        Ok(Some(delay))
    };
    let Some([from, to]) = first_reached(&mut |time| late(time, observer))? else {
        let unsolved = last.unwrap_or_else(|| Solution::unsolved(problem, settings.tolerance));
        return Ok(Solution { outcome: Outcome::Stalled, infeasible: None, ..unsolved });
    };
    let time = root(from, to, NEAR, &mut |time| late(time, observer))?;
    let settings = Settings { time_limit: remaining(), ..settings.clone() };
    let attitude = best.unwrap_or(problem.end.attitude);
    let meeting = problem.meeting(aim, &attitude, time, slope_near(&seen)).map_err(ProblemError::from);
    Ok(solve(&meeting.map_err(PlanError::from)?, &settings, None, observer)?)
}

/// How long a plan takes \[s\]: that of inputs that switch in continuous time, which does not depend on the grid.
fn takes(problem: &Problem, solution: &Solution) -> f64 {
    let told = solution.switching.as_ref().filter(|_| solution.on_grid(problem).switches());
    let continuous = told.map(|found| found.continuous_duration_s);
    let recorded = || solution.trajectory.time.last().copied();
    continuous.filter(|duration| duration.is_finite()).or_else(recorded).unwrap_or(f64::NAN)
}

/// A time, and how late a plan is that is to end then \[s\].
type Late = [f64; 2];

/// The first interval at whose start a plan takes longer than there is time and at whose end it does not, with how late it is
/// at either.
fn first_reached(late: &mut dyn FnMut(f64) -> Result<Option<f64>, Halt>) -> Result<Option<[Late; 2]>, Halt> {
    let mut time = 0.0;
    let Some(mut delay) = late(time)? else { return Ok(None) };
    for _ in 0..MOST_TIMES {
        // By the time that the plan would take the target is elsewhere.
        let next = time + delay;
        let Some(then) = late(next)? else { return Ok(None) };
        if then <= 0.0 {
            return Ok(Some([[time, delay], [next, then]]));
        }
        (time, delay) = (next, then);
    }
    Ok(None)
}

/// How what was seen last to be late changes with the time, against the last that was seen apart from it; as of an end that stands where
/// there is none.
fn slope_near(seen: &[Late]) -> f64 {
    let Some([time, late]) = seen.last() else { return STANDS };
    let apart = seen.iter().rev().find(|[other, _]| (time - other).abs() > APART * time);
    let slope = apart.map(|[other, was]| (late - was) / (time - other));
    slope.filter(|slope| *slope < 0.0).unwrap_or(STANDS)
}

/// A root between two times, to a relative width.
fn root(
    mut low: Late,
    mut high: Late,
    width: f64,
    late: &mut dyn FnMut(f64) -> Result<Option<f64>, Halt>,
) -> Result<f64, Halt> {
    let mut illinois = Illinois::new([low[1], high[1]]);
    for _ in 0..MOST_TIMES {
        let next = low[0] + illinois.part() * (high[0] - low[0]);
        if !(next > low[0] && next < high[0]) || high[0] - low[0] <= width * high[0] {
            break;
        }
        let Some(delay) = late(next)? else { break };
        if delay.abs() <= width * next {
            return Ok(next);
        }
        let moved = usize::from(delay <= 0.0);
        illinois.moved(moved, delay);
        *[&mut low, &mut high][moved] = [next, delay];
    }
    Ok(high[0])
}
