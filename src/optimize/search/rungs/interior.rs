//! Solves by the interior point from all given paths: on a coarse grid first, then the cheapest plans on
//! the requested grid.
//!
//! A solve from a path ends in an optimum within all limits or in the least violation near the path. The
//! paths therefore need variety more than accuracy: about the fixed axis, bent to six sides, past either
//! side of each cone. On few steps each takes milliseconds. The cheapest coarse plan starts the solve on
//! the requested grid.

use crate::maneuver::objective::Fuel;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::road::Chain;
use crate::optimize::search::chains::CARRIED;
use crate::optimize::search::coarse::chain_steps;
use crate::optimize::search::detour::detours;
use crate::optimize::search::found::{Found, cheapest_first, same};
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::transfer::transfer;

/// How far the coarse costs of two plans may lie apart, relative, for both to be carried to the fine grid.
const CLOSE: f64 = 0.01;

/// Costs of one optimum on the coarse grid differ by less, relative.
const ONE: f64 = 1e-5;

/// The strategy that finds local minima of an objective, and the cheapest of them on the requested grid.
pub(super) struct Interior;

/// Returns whether the interior point plans least time or fuel: the settings request it, and fuel is the
/// sum over inputs rather than their norm.
pub(in crate::optimize::search) fn plans(problem: &Problem, settings: &Settings) -> bool {
    let actuation = &problem.actuation;
    let of_norm =
        Fuel::is_of_norm(&actuation.torque) || actuation.force.as_ref().is_some_and(Fuel::is_of_norm);
    settings.method == Method::InteriorPoint && !(problem.objective.fuel().is_some() && of_norm)
}

impl<const N: usize> Climb<N> for Interior {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.goal.as_ref().is_some_and(|goal| goal.effort.share == 0.0)
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let coarse = search.chain(chain_steps(search.problem));
        let fine = search.chain(search.problem.steps);
        let (roughly, exactly) = (Tuning::roughly(), Tuning::default());
        let is_fine = coarse.model.steps == fine.model.steps;
        let first = if is_fine { &exactly } else { &roughly };
        let detours = |path: &Candidate| detours(search.problem, path.clone());
        let seeds: Vec<Candidate> = search.ask.paths.iter().flat_map(detours).collect();
        for seed in &seeds {
            if !search.stopped() {
                found.keep(solved(search, &coarse, first, seed.clone()));
            }
        }
        found.reorder(|plans| distinct(cheapest_first(plans)));
        if !is_fine {
            carry(search, found, [&coarse, &fine], &exactly);
        }
    }
}

/// Keeps the first of all plans with the same cost; `plans` are sorted by cost.
fn distinct(plans: Vec<Attempt>) -> Vec<Attempt> {
    let mut kept = Vec::<Attempt>::new();
    for plan in plans {
        if kept.last().is_none_or(|last| plan.cost > last.cost + ONE * last.cost.abs()) {
            kept.push(plan);
        }
    }
    kept
}

/// Solves once from a candidate.
fn solved<const N: usize>(search: &Search<N>, chain: &Chain, tuning: &Tuning, from: Candidate) -> Attempt {
    search.context.attempt(Rung::InteriorPoint, &InteriorPoint { chain, tuning, polish: None }, from)
}

/// Solves the cheapest coarse plans again on the fine grid and puts them first. If a solve does not
/// converge, the next coarse plan is tried.
fn carry<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    [coarse, fine]: [&Chain; 2],
    tuning: &Tuning,
) {
    let plans = found.take_plans();
    let (mut carried, mut rivals) = (Vec::<Attempt>::new(), Vec::new());
    let mut best = None;
    for (index, plan) in plans.iter().enumerate() {
        let close = |best: f64| carried.len() < CARRIED && plan.cost <= best + CLOSE * best.abs();
        if search.stopped() || !best.is_none_or(close) {
            rivals.extend_from_slice(&plans[index..]);
            break;
        }
        let start = transfer([coarse, fine], &plan.candidate);
        let next = solved(search, fine, tuning, start);
        if !next.converged() {
            rivals.push(plan.clone());
            found.keep(next);
        } else {
            best = best.or(Some(plan.cost));
            if !carried.iter().any(|other| same::<N>(other, &next)) {
                carried.push(next);
            }
        }
    }
    if !carried.is_empty() {
        found.reorder(|_| cheapest_first(carried).into_iter().chain(rivals).collect());
    }
}
