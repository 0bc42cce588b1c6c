//! The rung of limited inputs: from the extremals without limits to those within them.
//!
//! The ladder first solves the maneuver as if nothing were limited. From each extremal that it finds,
//! cheapest first, Newton goes on with the saturated control law: the shooting, then the lifted one, and
//! where both fail the limits are drawn in from where they do not act, unless the interior point comes next.
//! Tighter limits make an extremal costlier: one that is costlier without them than the best within them is
//! left out.

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::search::asked::ranked;
use crate::optimize::search::continuation::{self, Wider};
use crate::optimize::search::descents::LIFTED_TOLERANCE;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::shots::shoot_fine;

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

/// All starts under limits.
pub(super) struct Saturated;

impl<const N: usize> Climb<N> for Saturated {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        search.ask.shooting && !found.is_guessed() && search.fine.dynamics.is_limited()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let unlimited = unlimited_extremals(search);
        let least = unlimited.iter().map(|start| start.demand).fold(f64::INFINITY, f64::min);
        // Drawing limits in takes many solves; the interior point takes fewer.
        let alone = search.context.settings.method == Method::Shooting;
        let mut nearest: Option<(String, Wider<N>)> = None;
        for Unlimited { found: wide, demand } in &unlimited {
            let free = &wide.candidate;
            let beaten = found.plans().iter().any(|best| best.cost <= wide.cost);
            if search.stopped() || beaten {
                break;
            }
            if *demand <= 1.0 && wide.converged() && free.steps() == search.problem.steps {
                // No limit acts on it: it is an extremal within them as it is.
                found.keep(wide.clone());
                continue;
            }
            let hopeless = *demand > HOPELESS * least;
            if shoot_fine(search, found, Rung::Saturated, free.clone()).is_some()
                || hopeless
                || search.stopped()
            {
                continue;
            }
            let grid = later_grid(search);
            if lifted_saturated(search, found, &grid, free) || !alone || search.stopped() {
                continue;
            }
            let from = Wider { costate: free.costate(), factor: *demand };
            let reached = draw_in(search, found, &grid, free, from);
            if nearest.as_ref().is_none_or(|(_, nearest)| reached.factor < nearest.factor) {
                nearest = Some((free.provenance.start.clone(), reached));
            }
        }
        if let Some((name, wider)) = nearest.filter(|_| !found.is_done()) {
            insist(search, found, &name, wider);
        }
    }
}

/// The extremals without limits, cheapest first.
fn unlimited_extremals<const N: usize>(search: &Search<N>) -> Vec<Unlimited> {
    let actuation = search.problem.actuation.without_limits();
    let free = Problem { actuation, ..search.problem.clone() };
    let ask = Ask { guess: None, convex: false, ..search.ask.clone() };
    let limitless = search.fine.relaxed(LIMITLESS);
    let search = search.of(&free, ask);
    let mut found = search.climb();
    let extremals = ranked(&search, found.take_plans());
    let demand =
        |found: &Attempt| limitless.demand(&found.candidate.costate()).map(|demand| LIMITLESS * demand);
    let unlimited = extremals.into_iter().chain(found.pool.rivals);
    unlimited.filter_map(|found| demand(&found).ok().map(|demand| Unlimited { found, demand })).collect()
}

/// The grid of the later rungs: the requested one, or a coarser one whose costates start Newton there.
fn later_grid<'a, const N: usize>(search: &Search<'a, '_, N>) -> BoundaryValueProblem<'a, N> {
    if search.problem.steps <= MOST_STEPS {
        search.fine.clone()
    } else {
        BoundaryValueProblem::new(search.problem, MOST_STEPS).heard_by(search.context)
    }
}

/// Lifted Newton with the saturated law, from the nodes of the extremal without limits.
fn lifted_saturated<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    grid: &BoundaryValueProblem<N>,
    free: &Candidate,
) -> bool {
    let start = free.clone().on_grid(&grid.dynamics.grid);
    let attempt = match continuation::nodes_of(&grid.relaxed(LIMITLESS), &free.costate()) {
        Ok(nodes) => {
            let newton = LiftedNewton { bvp: grid, tolerance: LIFTED_TOLERANCE, patience: 1 };
            search.context.attempt(Rung::Lifted, &newton, nodes.into_candidate(start))
        }
        Err(error) => {
            let report = Report::failed(outcome_of(error));
            search.context.note(Rung::Lifted, &start.provenance.start, start.steps(), report.clone());
            Attempt::of(start, report)
        }
    };
    attempt.converged() && shoot_fine(search, found, Rung::Lifted, attempt.candidate).is_some()
}

/// Continuation in the limits from wider ones; how far it went.
fn draw_in<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    grid: &BoundaryValueProblem<N>,
    start: &Candidate,
    from: Wider<N>,
) -> Wider<N> {
    let (steps, name) = (grid.dynamics.grid.steps(), &start.provenance.start);
    search.context.enter(Rung::Limits, name, steps);
    let (reached, report) = continuation::in_limits(grid, &from, &|| search.context.interrupt());
    search.context.note(Rung::Limits, name, steps, report.clone());
    let mut candidate = start.clone().with_costate(&reached.costate);
    candidate.provenance.iterations += report.iterations;
    if reached.factor <= 1.0 && shoot_fine(search, found, Rung::Limits, candidate).is_none() {
        // The coarser grid has an extremal where Newton on the requested one found none.
        return from;
    }
    reached
}

/// Draws the limits in by ever shorter steps, and says how far that went.
fn insist<const N: usize>(search: &Search<N>, found: &mut Found<N>, start: &str, mut wider: Wider<N>) {
    let grid = later_grid(search);
    for _ in 0..RESTARTS {
        if search.stopped() || found.is_done() {
            return;
        }
        let start = Candidate::of_costate(start, &grid.dynamics.grid, &wider.costate);
        let next = draw_in(search, found, &grid, &start, wider);
        let moved = next.factor < wider.factor;
        wider = next;
        if !moved {
            break;
        }
    }
    if !found.is_done() {
        found.shortfall = Some(Shortfall::TightLimits { factor: wider.factor });
    }
}
