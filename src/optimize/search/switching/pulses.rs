//! Minimum fuel by pulses: inputs that are off or at a limit, and on for at least the minimum pulse
//! width.
//!
//! The maneuver without a minimum pulse width is solved first: its extremals provide the pulses,
//! and its cost is the reference for the cost of the pulses.

use super::{Extremals, Planned, Scaled, ended, finished, noted, rivals};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Rung, Solution, Trajectory};
use crate::maneuver::switching::{Pulses, Structure};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::switching::pulses::on_grid::{Placed, Unplaced, placed};
use crate::optimize::methods::switching::pulses::schedule::PulseRequest;
use crate::optimize::methods::switching::pulses::search;
use crate::optimize::methods::switching::scaled::input_of;
use crate::optimize::methods::switching::work::Work;

/// Relative amount by which a pulse may be shorter than the minimum pulse width because of
/// round-off.
const ROUND_OFF: f64 = 1e-10;
/// Largest number of rivals that are reported.
const RIVALS: usize = 4;

impl Extremals<'_, '_> {
    /// Returns the best plan with pulses that has a discrete optimum on the grid and is in the
    /// requested homotopy class.
    pub(super) fn pulsed(self, shortest: f64, lands: bool) -> Solution {
        if self.found.branches == 0 {
            return self.without_plan();
        }
        let Self { of, context, found: without, mut unsolved } = self;
        let Scaled { problem, extremal, units } = &of;
        let levels = 0..extremal.switching_count();
        let ask = PulseRequest {
            shortest: shortest / units.time,
            input_of: levels.map(|level| input_of(problem, level)).collect(),
            thorough: context.settings.search == Thoroughness::Thorough,
            sought: extremal.given_duration.is_none(),
        };
        context.enter(Rung::Pulses, "all", 0);
        let mut found =
            context.within(|budget| search::search(extremal, &without.limits, &ask, &Work::of(budget.watch)));
        // A free duration may have an upper bound; a given duration has none.
        let longest = problem.duration.at_most().filter(|_| ask.sought);
        let allowed = |duration: f64| longest.is_none_or(|longest| duration * units.time <= longest);
        found.best.retain(|best| allowed(best.schedule.duration));
        let outcome = if found.best.is_empty() { Outcome::Stalled } else { Outcome::Converged };
        let report = Report { outcome, iterations: found.tried, residuals: Vec::new() };
        context.note(Rung::Pulses, "all", 0, report);
        if let Some(outcome) = context.interrupt() {
            return ended(unsolved, outcome, context);
        }
        let cheapest = without.limits.iter().find(|limit| allowed(limit.duration()));
        let cheapest = cheapest.or(without.limits.first());
        let least = cheapest.map_or(f64::NAN, |limit| limit.cost(extremal) * units.cost());
        let (mut chosen, mut needed) = (None, None);
        for (index, best) in found.best.iter().enumerate() {
            context.enter(Rung::Aligned, "pulses", problem.steps);
            let on_grid = placed(extremal, best, &ask, problem.steps);
            noted(context, "pulses", problem.steps, on_grid.as_ref().ok().map(|placed| &placed.grid));
            match on_grid {
                Ok(placed) => {
                    let plan = of.pulses_planned(&placed, least).filter(|plan| of.follows(plan));
                    if let Some(plan) = plan {
                        chosen = Some((index, plan));
                        break;
                    }
                }
                Err(Unplaced::Steps(steps)) => needed = Some(steps),
                Err(Unplaced::NoOptimum) => {}
            }
        }
        let Some((index, mut plan)) = chosen else {
            unsolved.shortfall = Some(match needed {
                Some(steps) => Shortfall::FewStepsForPulses { steps },
                None if found.best.is_empty() => Shortfall::NoPulses { shortest },
                None => Shortfall::NoDiscretePulses { steps: problem.steps },
            });
            return ended(unsolved, Outcome::Stalled, context);
        };
        if lands {
            let afresh = |aimed: &Scaled| {
                let placed = placed(&aimed.extremal, &found.best[index], &ask, problem.steps).ok()?;
                aimed.pulses_planned(&placed, least)
            };
            plan = of.landed(plan, &afresh, context);
        }
        let dearer = found.best.iter().skip(index + 1).map(|best| ("pulses", best.cost * units.cost()));
        let mut rivals = rivals(dearer, plan.switching.continuous_cost, plan.solution.sense);
        rivals.truncate(RIVALS);
        finished(plan, rivals, context)
    }
}

impl Scaled<'_> {
    /// Returns the plan with pulses on the grid of the pulses. `least` is the fuel cost without a
    /// minimum pulse width.
    fn pulses_planned(&self, Placed { schedule, arcs, grid }: &Placed, least: f64) -> Option<Planned> {
        let mut plan = self.record(grid)?;
        plan.solution.start = "pulses".into();
        let switching = &mut plan.switching;
        switching.structure = Structure::Pulses;
        switching.continuous_duration_s = arcs.duration * self.units.time;
        switching.continuous_cost = schedule.cost(&self.extremal) * self.units.cost();
        // A plan with pulses is also a plan without a minimum pulse width, so it bounds the fuel
        // cost.
        let least = least.min(switching.continuous_cost);
        switching.gap = switching.continuous_cost - least;
        switching.switches = arcs.switches.len();
        switching.arcs = self.told(arcs);
        let shortest_s = shortest(&plan.solution.trajectory);
        switching.pulses = Some(Pulses { count: schedule.pulses.len(), shortest_s, cost_without: least });
        Some(plan)
    }
}

/// Updates the shortest pulse of a plan that was solved again, if the plan has pulses. Returns
/// false if a pulse is shorter than the minimum pulse width.
pub(super) fn told_again(problem: &Problem, plan: &mut Planned) -> bool {
    let (Some(pulses), Some(least)) = (&mut plan.switching.pulses, problem.shortest_pulse()) else {
        return true;
    };
    pulses.shortest_s = shortest(&plan.solution.trajectory);
    pulses.shortest_s >= least * (1.0 - ROUND_OFF)
}

/// Returns the shortest time for which an input of a recorded plan is constant and not zero \[s\].
fn shortest(trajectory: &Trajectory) -> f64 {
    let rows = trajectory.torque.len();
    let mut shortest = f64::INFINITY;
    for input in 0..trajectory.input_count {
        let at = |row: usize| trajectory.inputs(row)[input];
        let mut first = 0;
        while first < rows {
            let mut last = first;
            // Exact comparison: all rows of a pulse hold the same number.
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
