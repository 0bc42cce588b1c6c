//! Minimum fuel by pulses: inputs that are off or at a limit, and on for a shortest time at least.
//!
//! The same maneuver without a shortest pulse is solved first: its extremals are what pulses are made of, and what their cost is told
//! against.

use super::{Aim, Planned, ended, finished, follows, landed, noted, record, rivals, shortest_told, told};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Rung, Solution, Trajectory};
use crate::maneuver::switching::{Pulses, Structure};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::switching::extremal::Extremal;
use crate::optimize::methods::switching::limit::Found;
use crate::optimize::methods::switching::pulses::on_grid::{Placed, Unplaced, placed};
use crate::optimize::methods::switching::pulses::schedule::Ask;
use crate::optimize::methods::switching::pulses::search;
use crate::optimize::methods::switching::scaled::{Units, input_of};
use crate::optimize::search::context::Context;

/// A pulse shorter by this part is as long as it has to be.
const ROUND_OFF: f64 = 1e-10;
/// How many dearer schedules are told.
const RIVALS: usize = 4;

/// The best pulses that have a place on the grid and go the way that is asked for.
pub(super) fn solve(
    problem: &Problem,
    (extremal, units): (&Extremal, &Units),
    without: &Found,
    shortest: f64,
    context: &Context,
    mut solution: Solution,
    lands: bool,
) -> Solution {
    if without.branches == 0 {
        if !shortest_told(problem, without, context, &mut solution) {
            solution.shortfall = Some(Shortfall::NoSmoothedExtremal);
        }
        return ended(solution, Outcome::Stalled, context);
    }
    let levels = 0..extremal.switching_count();
    let ask = Ask {
        shortest: shortest / units.time,
        input_of: levels.map(|level| input_of(problem, level)).collect(),
        thorough: context.settings.search == Thoroughness::Thorough,
        sought: extremal.given_duration.is_none(),
    };
    context.enter(Rung::Pulses, "all", 0);
    let mut found = search::search(extremal, &without.limits, &ask, &|| context.interrupt().is_some());
    // A bound of what is sought; what is given has none.
    let longest = problem.duration.at_most().filter(|_| ask.sought);
    let allowed = |duration: f64| longest.is_none_or(|longest| duration * units.time <= longest);
    found.best.retain(|best| allowed(best.schedule.duration));
    let outcome = if found.best.is_empty() { Outcome::Stalled } else { Outcome::Converged };
    context.note(Rung::Pulses, "all", 0, Report { outcome, iterations: found.tried, residuals: Vec::new() });
    if let Some(outcome) = context.interrupt() {
        return ended(solution, outcome, context);
    }
    let cheapest = without.limits.iter().find(|limit| allowed(limit.duration())).or(without.limits.first());
    let least = cheapest.map_or(f64::NAN, |limit| limit.cost(extremal) * units.cost());
    let (mut chosen, mut needed) = (None, None);
    for (index, best) in found.best.iter().enumerate() {
        context.enter(Rung::Aligned, "pulses", problem.steps);
        let on_grid = placed(extremal, best, &ask, problem.steps);
        let grid = on_grid.as_ref().ok().map(|placed| (placed.grid.iterations, placed.grid.residual));
        noted(context, "pulses", problem.steps, grid);
        match on_grid {
            Ok(placed) => {
                let plan = planned(problem, extremal, units, &placed, least);
                if let Some(plan) = plan.filter(|plan| follows(problem, plan)) {
                    chosen = Some((index, plan));
                    break;
                }
            }
            Err(Unplaced::Steps(steps)) => needed = Some(steps),
            Err(Unplaced::NoOptimum) => {}
        }
    }
    let Some((index, mut plan)) = chosen else {
        solution.shortfall = Some(match needed {
            Some(steps) => Shortfall::FewStepsForPulses { steps },
            None if found.best.is_empty() => Shortfall::NoPulses { shortest },
            None => Shortfall::NoDiscretePulses { steps: problem.steps },
        });
        return ended(solution, Outcome::Stalled, context);
    };
    if let Some(aim) = Aim::asked(problem, context.settings).filter(|_| lands) {
        let afresh = |aimed: &Extremal| {
            let placed = placed(aimed, &found.best[index], &ask, problem.steps).ok()?;
            planned(problem, aimed, units, &placed, least)
        };
        plan = landed(aim, extremal, units, plan, &afresh, &|| context.interrupt().is_some());
    }
    let dearer = found.best.iter().skip(index + 1).map(|best| ("pulses", best.cost * units.cost()));
    solution.rivals = rivals(dearer, plan.switching.continuous_cost, plan.sense);
    solution.rivals.truncate(RIVALS);
    finished(solution, plan, context)
}

/// Pulses on their grid as a plan; `least` is what fuel costs without a shortest pulse.
fn planned(
    problem: &Problem,
    extremal: &Extremal,
    units: &Units,
    placed: &Placed,
    least: f64,
) -> Option<Planned> {
    let Placed { schedule, arcs, grid } = placed;
    let mut plan = record(problem, extremal, units, grid)?;
    plan.start = "pulses".into();
    let switching = &mut plan.switching;
    switching.structure = Structure::Pulses;
    switching.continuous_duration_s = arcs.duration * units.time;
    switching.continuous_cost = schedule.cost(extremal) * units.cost();
    // Pulses are a plan without a shortest one too.
    let least = least.min(switching.continuous_cost);
    switching.gap = switching.continuous_cost - least;
    switching.switches = arcs.switches.len();
    switching.arcs = told(problem, extremal, units, arcs);
    let shortest_s = shortest(&plan.trajectory);
    switching.pulses = Some(Pulses { count: schedule.pulses.len(), shortest_s, cost_without: least });
    Some(plan)
}

/// Tells the shortest pulse of a plan that was solved again, where it has pulses; false where one is shorter than it may be.
pub(super) fn told_again(problem: &Problem, plan: &mut Planned) -> bool {
    let (Some(pulses), Some(least)) = (&mut plan.switching.pulses, problem.shortest_pulse()) else {
        return true;
    };
    pulses.shortest_s = shortest(&plan.trajectory);
    pulses.shortest_s >= least * (1.0 - ROUND_OFF)
}

/// The shortest time for which an input of a recorded plan is on without a change \[s\].
fn shortest(trajectory: &Trajectory) -> f64 {
    let rows = trajectory.torque.len();
    let mut shortest = f64::INFINITY;
    for input in 0..trajectory.input_count {
        let at = |row: usize| trajectory.inputs(row)[input];
        let mut first = 0;
        while first < rows {
            let mut last = first;
            // Exactly: on a pulse all rows hold one number.
            #[expect(clippy::float_cmp, reason = "rows of one pulse are copies of one number")]
            while last + 1 < rows && at(last + 1) == at(first) {
                last += 1;
            }
            if at(first) != 0.0 {
                shortest = shortest.min(trajectory.time[last + 1] - trajectory.time[first]);
            }
            first = last + 1;
        }
    }
    shortest
}
