//! Limited inputs: from the extremals without limits to those within them.
//!
//! The ladder first solves the maneuver as if nothing were limited. From each extremal that it finds,
//! cheapest first, Newton goes on with the saturated control law: the shooting, then the lifted one, and
//! where both fail the limits are drawn in from where they do not act, unless the convex road comes next.
//! Tighter limits make an extremal dearer: one that is dearer without them than the best within them is
//! left out.

use super::continuation::{self, Wider};
use super::ladder::{Found, Search};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method;
use crate::maneuver::solution::{Outcome, Rung};
use crate::optimize::methods::driver::{Iteration, run};
use crate::optimize::methods::shooting::newton::{Newton, outcome_of};
use crate::optimize::methods::shooting::refine::failed;
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::SVector;

/// Limits that many times as large do not act.
const LIMITLESS: f64 = 1e12;
/// An extremal that demands so many times what the least demanding one does gets Newton's tries alone.
const HOPELESS: f64 = 2.0;
/// Most steps of the grid of the later rungs: the lifted Newton keeps matrices of every step.
const MOST_STEPS: usize = 1000;
/// How often the limits are drawn in anew from where that stopped.
const RESTARTS: usize = 4;
/// Tolerance of the lifted Newton, which the shooting polishes.
const LIFTED_TOLERANCE: f64 = 1e-10;

/// An extremal without limits and what it demands of them.
struct Unlimited<'a, const N: usize> {
    found: &'a Found<N>,
    /// How many times as large the limits would have to be.
    demand: f64,
}

impl<const N: usize> Search<'_, '_, N> {
    /// All starts under limits.
    pub fn climb_limited(&mut self, turns: &[i32]) {
        let actuation = self.problem.actuation.without_limits();
        let free = Problem { actuation, ..self.problem.clone() };
        let mut search = Search::<N>::new(&free, self.context, turns);
        search.climb(turns);
        search.rank();
        let limitless = self.fine.relaxed(LIMITLESS);
        let demand = |found: &Found<N>| limitless.demand(&found.costate).map(|demand| LIMITLESS * demand);
        let unlimited: Vec<Unlimited<N>> = search
            .found
            .iter()
            .filter_map(|found| demand(found).map(|demand| Unlimited { found, demand }).ok())
            .collect();
        let least = unlimited.iter().map(|start| start.demand).fold(f64::INFINITY, f64::min);
        // Drawing limits in takes many solves; the convex road takes fewer.
        let alone = self.context.settings.method == Method::Shooting;
        let mut nearest: Option<(String, Wider<N>)> = None;
        for start in &unlimited {
            let Found { start: name, costate, cost, iterations, .. } = start.found;
            let beaten = self.found.iter().any(|best| best.cost <= *cost);
            if self.stopped() || beaten {
                break;
            }
            let hopeless = start.demand > HOPELESS * least;
            if self.saturated(Rung::Saturated, name, *costate, *iterations) || hopeless || self.stopped() {
                continue;
            }
            let grid = self.later_grid();
            if self.lifted_saturated(&grid, start.found) || !alone || self.stopped() {
                continue;
            }
            let from = Wider { costate: *costate, factor: start.demand };
            let reached = self.draw_in(&grid, name, from, *iterations);
            if nearest.as_ref().is_none_or(|(_, nearest)| reached.factor < nearest.factor) {
                nearest = Some((name.clone(), reached));
            }
        }
        if let Some((name, wider)) = nearest.filter(|_| self.found.is_empty()) {
            self.insist(&name, wider);
        }
    }

    /// Newton with the saturated law on the requested grid.
    fn saturated(&mut self, rung: Rung, start: &str, costate: SVector<f64, N>, spent: usize) -> bool {
        let (steps, settings) = (self.problem.steps, self.context.settings);
        self.context.enter(rung, start, steps);
        let newton = match Newton::new(&self.fine, settings.tolerance, costate, None) {
            Ok(newton) => newton,
            Err(error) => {
                self.context.note(steps, &failed(outcome_of(error)));
                return false;
            }
        };
        let (newton, report) = run(newton, settings.max_iterations, &|| self.context.interrupt());
        self.context.note(steps, &report);
        let (outcome, iterations) = (report.outcome, spent + report.iterations);
        self.keep(start, newton.costate, newton.end.cost, newton.residual(), outcome, iterations);
        outcome == Outcome::Converged
    }

    /// The grid of the later rungs: the requested one, or a coarser one whose costates start Newton there.
    fn later_grid(&self) -> BoundaryValueProblem<N> {
        if self.problem.steps <= MOST_STEPS {
            self.fine.clone()
        } else {
            BoundaryValueProblem::new(self.problem, MOST_STEPS)
        }
    }

    /// Lifted Newton with the saturated law, from the nodes of the extremal without limits.
    fn lifted_saturated(&mut self, grid: &BoundaryValueProblem<N>, free: &Found<N>) -> bool {
        let steps = grid.dynamics.grid.steps();
        self.context.enter(Rung::Lifted, &free.start, steps);
        let nodes = continuation::nodes_of(&grid.relaxed(LIMITLESS), &free.costate);
        let limit = self.context.settings.max_iterations;
        let (nodes, report) = continuation::lifted(grid, nodes, LIFTED_TOLERANCE, limit, self.context);
        self.context.note(steps, &report);
        let spent = free.iterations + report.iterations;
        nodes.is_some_and(|nodes| self.saturated(Rung::Lifted, &free.start, nodes.costates[0], spent))
    }

    /// Continuation in the limits from wider ones; how far it went.
    fn draw_in(
        &mut self,
        grid: &BoundaryValueProblem<N>,
        start: &str,
        from: Wider<N>,
        spent: usize,
    ) -> Wider<N> {
        let steps = grid.dynamics.grid.steps();
        self.context.enter(Rung::Limits, start, steps);
        let (mut reached, report) = continuation::in_limits(grid, &from, self.context);
        self.context.note(steps, &report);
        if reached.factor <= 1.0
            && !self.saturated(Rung::Limits, start, reached.costate, spent + report.iterations)
        {
            // The coarser grid has an extremal where Newton on the requested one found none.
            reached = from;
        }
        reached
    }

    /// Draws the limits in by ever shorter steps, and says how far that went.
    fn insist(&mut self, start: &str, mut wider: Wider<N>) {
        let grid = self.later_grid();
        for _ in 0..RESTARTS {
            if self.stopped() || !self.found.is_empty() {
                return;
            }
            let next = self.draw_in(&grid, start, wider, 0);
            let moved = next.factor < wider.factor;
            wider = next;
            if !moved {
                break;
            }
        }
        if self.found.is_empty() {
            self.shortfall = Some(format!(
                "the limits of the inputs are too tight for this search: it found a plan within limits {:.4} times \
                 as large",
                wider.factor
            ));
        }
    }
}
