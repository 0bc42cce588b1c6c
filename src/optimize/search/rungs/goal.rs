//! The rung of time, of fuel, and of a duration that is sought: SCP along the paths that are given.

use crate::optimize::candidate::Candidate;
use crate::optimize::methods::scp::road::Chain;
use crate::optimize::search::chains::{carry, descend};
use crate::optimize::search::coarse::chain_steps;
use crate::optimize::search::detour::detours;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::shares::{FIRST_SHARES, SHARE};

/// The local minima of a goal, the cheapest on the requested grid.
pub(super) struct OfGoal;

impl<const N: usize> Climb<N> for OfGoal {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.goal.is_some()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let coarse = coarse_minima(search, found);
        carry_with_effort(search, found, &coarse);
    }
}

/// The local minima that SCP finds along paths on its coarse grid, with as much effort in the cost as that takes, and
/// that grid's chain: where forces turn with the body, or a field changes with its place, costs of fuel alone bend less
/// than the dynamics do.
fn coarse_minima<const N: usize>(search: &Search<N>, found: &mut Found<N>) -> Chain {
    let mut coarse = search.chain(chain_steps(search.problem));
    let frame_rate = coarse.model.dynamics.frame_rate();
    let detours = |path: &Candidate| detours(search.problem, &frame_rate, path.clone());
    let seeds: Vec<Candidate> = search.ask.paths.iter().flat_map(detours).collect();
    for share in shares(search, found) {
        found.share = Some(share);
        let search = search.with_effort(found.share);
        coarse = search.chain(coarse.model.steps);
        for seed in &seeds {
            if !search.stopped() {
                descend(&search, found, &coarse, seed.clone());
            }
        }
        if found.is_done() || search.stopped() {
            break;
        }
    }
    coarse
}

/// Shares to try one after the other, from the one that there is; of effort alone that one.
fn shares<const N: usize>(search: &Search<N>, found: &Found<N>) -> Vec<f64> {
    let goal = search.ask.goal.as_ref();
    let least = found.share.or(goal.map(|goal| goal.share)).unwrap_or(SHARE);
    let several = goal.is_some_and(|goal| goal.objective.switches());
    let from_least = FIRST_SHARES.into_iter().filter(|share| *share >= least);
    from_least.take(if several { FIRST_SHARES.len() } else { 1 }).collect()
}

/// Carries the cheapest to the requested grid, with as much effort in the cost as that takes: along arcs on which a
/// constraint acts rows of neighbouring nodes nearly repeat each other.
fn carry_with_effort<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    let plans = found.plans().to_vec();
    for share in shares(search, found) {
        found.share = Some(share);
        found.reorder(|_| plans.clone());
        carry(&search.with_effort(found.share), found, coarse);
        if found.is_done() || search.stopped() {
            return;
        }
    }
}
