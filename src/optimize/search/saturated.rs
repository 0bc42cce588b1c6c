//! Limited inputs: from the extremals without limits to those within them.
//!
//! The ladder first solves the maneuver as if nothing were limited. From each extremal that it finds,
//! cheapest first, Newton goes on with the saturated control law: the shooting, then the lifted one, and
//! where both fail the limits are drawn in from where they do not act, unless SCP comes next.
//! Tighter limits make an extremal costlier: one that is costlier without them than the best within them is
//! left out.

use super::continuation::{self, Wider};
use super::free::LIFTED_TOLERANCE;
use super::ladder::{Ask, Search};
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::Rung;
use crate::optimize::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::sweep::BoundaryValueProblem;

/// Limits that many times as large do not act.
const LIMITLESS: f64 = 1e12;
/// An extremal that demands so many times what the least demanding one does gets Newton's tries alone.
const HOPELESS: f64 = 2.0;
/// Most steps of the grid of the later rungs: the lifted Newton keeps matrices of every step.
const MOST_STEPS: usize = 1000;
/// How often the limits are drawn in anew from where that stopped.
const RESTARTS: usize = 4;
/// An extremal without limits and what it demands of them.
struct Unlimited {
    found: Attempt,
    /// How many times as large the limits would have to be.
    demand: f64,
}

impl<'a, const N: usize> Search<'a, '_, N> {
    /// All starts under limits.
    pub(super) fn saturated(&mut self) {
        let unlimited = self.unlimited_extremals();
        let least = unlimited.iter().map(|start| start.demand).fold(f64::INFINITY, f64::min);
        // Drawing limits in takes many solves; SCP takes fewer.
        let alone = self.context.settings.method == Method::Shooting;
        let mut nearest: Option<(String, Wider<N>)> = None;
        for Unlimited { found, demand } in &unlimited {
            let free = &found.candidate;
            let beaten = self.found.iter().any(|best| best.cost <= found.cost);
            if self.stopped() || beaten {
                break;
            }
            if *demand <= 1.0 && found.converged() && free.steps() == self.problem.steps {
                // No limit acts on it: it is an extremal within them as it is.
                self.keep(found.clone());
                continue;
            }
            let hopeless = *demand > HOPELESS * least;
            if self.shoot_fine(Rung::Saturated, free.clone()).is_some() || hopeless || self.stopped() {
                continue;
            }
            let grid = self.later_grid();
            if self.lifted_saturated(&grid, free) || !alone || self.stopped() {
                continue;
            }
            let from = Wider { costate: free.costate(), factor: *demand };
            let reached = self.draw_in(&grid, free, from);
            if nearest.as_ref().is_none_or(|(_, nearest)| reached.factor < nearest.factor) {
                nearest = Some((free.provenance.start.clone(), reached));
            }
        }
        if let Some((name, wider)) = nearest.filter(|_| self.found.is_empty()) {
            self.insist(&name, wider);
        }
    }

    /// The extremals without limits, cheapest first.
    fn unlimited_extremals(&mut self) -> Vec<Unlimited> {
        let actuation = self.problem.actuation.without_limits();
        let free = Problem { actuation, ..self.problem.clone() };
        let ask = Ask { guess: None, convex: false, ..self.ask.clone() };
        let mut search = Search::<N>::new(&free, self.context, ask);
        search.climb_far();
        search.rank();
        let limitless = self.fine.relaxed(LIMITLESS);
        let demand =
            |found: &Attempt| limitless.demand(&found.candidate.costate()).map(|demand| LIMITLESS * demand);
        let unlimited = search.found.into_iter().chain(search.rivals);
        unlimited.filter_map(|found| demand(&found).ok().map(|demand| Unlimited { found, demand })).collect()
    }

    /// The grid of the later rungs: the requested one, or a coarser one whose costates start Newton there.
    fn later_grid(&self) -> BoundaryValueProblem<'a, N> {
        if self.problem.steps <= MOST_STEPS {
            self.fine.clone()
        } else {
            BoundaryValueProblem::new(self.problem, MOST_STEPS).heard_by(self.context)
        }
    }

    /// Lifted Newton with the saturated law, from the nodes of the extremal without limits.
    fn lifted_saturated(&mut self, grid: &BoundaryValueProblem<N>, free: &Candidate) -> bool {
        let start = free.clone().on_grid(&grid.dynamics.grid);
        let attempt = match continuation::nodes_of(&grid.relaxed(LIMITLESS), &free.costate()) {
            Ok(nodes) => {
                let newton = LiftedNewton { bvp: grid, tolerance: LIFTED_TOLERANCE, patience: 1 };
                self.attempt(Rung::Lifted, &newton, nodes.into_candidate(start))
            }
            Err(error) => {
                let report = Report::failed(outcome_of(error));
                self.context.note(Rung::Lifted, &start.provenance.start, start.steps(), report.clone());
                Attempt::of(start, report)
            }
        };
        attempt.converged() && self.shoot_fine(Rung::Lifted, attempt.candidate).is_some()
    }

    /// Continuation in the limits from wider ones; how far it went.
    fn draw_in(&mut self, grid: &BoundaryValueProblem<N>, start: &Candidate, from: Wider<N>) -> Wider<N> {
        let (steps, name) = (grid.dynamics.grid.steps(), &start.provenance.start);
        self.context.enter(Rung::Limits, name, steps);
        let (reached, report) = continuation::in_limits(grid, &from, &|| self.context.interrupt());
        self.context.note(Rung::Limits, name, steps, report.clone());
        let mut candidate = start.clone().with_costate(&reached.costate);
        candidate.provenance.iterations += report.iterations;
        if reached.factor <= 1.0 && self.shoot_fine(Rung::Limits, candidate).is_none() {
            // The coarser grid has an extremal where Newton on the requested one found none.
            return from;
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
            let start = Candidate::of_costate(start, &grid.dynamics.grid, &wider.costate);
            let next = self.draw_in(&grid, &start, wider);
            let moved = next.factor < wider.factor;
            wider = next;
            if !moved {
                break;
            }
        }
        if self.found.is_empty() {
            self.shortfall = Some(Shortfall::TightLimits { factor: wider.factor });
        }
    }
}
