//! Strategy for minimum time, minimum fuel and a free duration: the interior-point method along the
//! given paths.
//!
//! A solve from a path ends in an optimum within all limits, or in the smallest violation near the
//! path. The paths therefore need variety more than accuracy: turns about the fixed axis, bent to
//! six sides, past either side of each cone. On few steps each solve takes milliseconds. The
//! cheapest coarse plan is the initial guess on the requested grid.

use crate::optimize::methods::method::Attempt;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::detour::detours;
use crate::optimize::search::strategies::chains::{carry, descend, optimised_along};

/// Finds local minima of an objective on a coarse grid, and solves the cheapest of them on the
/// requested grid.
pub struct Interior;

impl<const N: usize> Climb<N> for Interior {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.goal.is_some()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        if let Some(motion) = search.ask.along {
            let fine = search.chain(search.problem.steps);
            if let Some(attempt) = optimised_along(search, &fine, motion) {
                found.keep(attempt);
            }
            return;
        }
        let coarse = search.chain(chain_steps(search.problem));
        for path in search.ask.paths {
            for seed in detours(search.problem, path.clone()) {
                descend(search, found, &coarse, seed);
            }
        }
        let duration = |plan: &Attempt| plan.candidate.grid.duration() * search.problem.seconds();
        let within = |plan: &Attempt| duration(plan) <= search.ask.longest;
        found.reorder(|plans| plans.into_iter().filter(within).collect());
        carry(search, found, &coarse);
    }
}
