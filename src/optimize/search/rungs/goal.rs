//! The rung of time, of fuel, and of a duration that is sought: SCP along the paths that are given.

use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Effort;
use crate::optimize::methods::scp::road::{Chain, ConvexIteration};
use crate::optimize::search::by_arcs::ByArcs;
use crate::optimize::search::chains::{CARRIED, CLOSE, carried_to, descend, grids_between};
use crate::optimize::search::coarse::chain_steps;
use crate::optimize::search::detour::detours;
use crate::optimize::search::found::{Found, cheapest_first, same};
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::limited::Told;
use crate::optimize::search::shares::{FIRST_SHARES, FOLLOWED, SHARE};
use crate::optimize::search::transfer::transfer;
use std::sync::Arc;

/// The local minima of a goal, the cheapest on the requested grid.
pub(super) struct OfGoal;

impl<const N: usize> Climb<N> for OfGoal {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.goal.is_some()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let coarse = coarse_minima(search, found);
        if !by_arcs(search, found, &coarse) {
            carry_with_effort(search, found, &coarse);
        }
    }
}

/// The plan of the requested grid by way of the arcs that one of a coarser grid leads to, of the coarsest that leads to some. Whether
/// there is one.
fn by_arcs<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) -> bool {
    let (few, many) = (coarse.model.steps, search.problem.steps);
    let Some(maneuver) = ByArcs::of(search).filter(|_| few < many && found.is_done()) else { return false };
    // Each four times as fine as the one before: all of them together take less than the requested one.
    let mut grids: Vec<usize> = grids_between(few, many).into_iter().rev().skip(1).step_by(2).collect();
    grids.push(few);
    while let Some(steps) = grids.pop().filter(|_| !search.stopped()) {
        let problem = search.problem.clone().with_steps(steps);
        let coarser = search.of(&problem, Ask { lands: false, ..search.ask.clone() });
        let mut branch = found.branched();
        carry_with_effort(&coarser, &mut branch, coarse);
        let told = cheapest_told(&coarser, &mut branch, &maneuver);
        let planned = told.and_then(|(told, rivals)| {
            let (plan, effort) = maneuver.planned(search, &mut branch, &told)?;
            found.reorder(|_| std::iter::once(plan).chain(rivals).collect());
            (found.effort, found.arcs) = (Some(effort), Some(told.switching));
            Some(())
        });
        found.add_work_of(&branch);
        if planned.is_some() {
            return true;
        }
    }
    false
}

/// The cheapest in continuous time of the exact arcs that the plans on the grid of a search lead to whose costs are close, and the other
/// plans; `None` where the cheapest of the grid leads to none.
fn cheapest_told<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    maneuver: &ByArcs,
) -> Option<(Told, Vec<Attempt>)> {
    let search = &search.with_effort(found.effort.clone());
    let chain = search.chain(search.problem.steps);
    let mut plans = found.take_plans();
    let on_grid = plans.iter().take_while(|plan| plan.candidate.steps() == chain.model.steps);
    let prices: Vec<f64> = on_grid.map(|plan| chain.price(&plan.candidate)).take(CARRIED).collect();
    let mut best: Option<(usize, Told)> = None;
    for (index, price) in prices.iter().enumerate() {
        if *price > prices[0] * (1.0 + CLOSE) {
            break;
        }
        let told = maneuver.told(search, found, plans[index].clone());
        match (told, &best) {
            (None, None) => return None,
            (Some(told), None) => best = Some((index, told)),
            (Some(told), Some((_, other))) if told.cost() < other.cost() => best = Some((index, told)),
            _ => {}
        }
    }
    let (index, told) = best?;
    plans.remove(index);
    Some((told, plans))
}

/// The local minima that SCP finds along paths on its coarse grid, with as much effort in the cost as that takes, and
/// that grid's chain: where forces turn with the body, or a field changes with its place, costs of fuel alone bend less
/// than the dynamics do.
fn coarse_minima<const N: usize>(search: &Search<N>, found: &mut Found<N>) -> Chain {
    let mut coarse = search.chain(chain_steps(search.problem));
    let detours = |path: &Candidate| detours(search.problem, path.clone());
    let seeds: Vec<Candidate> = search.ask.paths.iter().flat_map(detours).collect();
    for share in shares(search, found) {
        found.effort = Some(Effort::of_share(share));
        let search = search.with_effort(found.effort.clone());
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
    let least = found.effort.as_ref().or(goal.map(|goal| &goal.effort)).map_or(SHARE, |effort| effort.share);
    let several = goal.is_some_and(|goal| goal.objective.switches());
    let from_least = FIRST_SHARES.into_iter().filter(|share| *share >= least);
    from_least.take(if several { FIRST_SHARES.len() } else { 1 }).collect()
}

/// Carries the cheapest to the requested grid, each with as much effort in its cost as that takes before a dearer one is tried:
/// along arcs on which a constraint acts rows of neighbouring nodes nearly repeat each other. Leaves the share of the first.
fn carry_with_effort<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    let (few, many) = (coarse.model.steps, search.problem.steps);
    if few == many {
        let price = |plan: &Attempt| coarse.price(&plan.candidate);
        found.reorder(|mut plans| {
            plans.sort_by(|a, b| price(a).total_cmp(&price(b)));
            plans
        });
        return;
    }
    found.reorder(cheapest_first);
    let shares = shares(search, found);
    let switches = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.switches());
    let plans = found.take_plans();
    let (mut carried, mut rivals) = (Vec::<(f64, Effort, Attempt)>::new(), Vec::new());
    let mut best_coarse = None;
    for (index, plan) in plans.iter().enumerate() {
        // On the fine grid the order of costs may be another.
        let close = |best: f64| carried.len() < CARRIED && plan.cost <= best + CLOSE * best.abs();
        if search.stopped() || !best_coarse.is_none_or(close) {
            rivals.extend_from_slice(&plans[index..]);
            break;
        }
        let fine = shares.iter().find_map(|share| {
            found.effort = Some(Effort::of_share(*share));
            let search = &search.with_effort(found.effort.clone());
            let grids = [search.chain(few), search.chain(many)];
            let eased =
                if *share == shares[0] { Some(plan.clone()) } else { eased(search, found, &grids[0], plan) };
            let fine = carried_to(search, found, [&grids[0], &grids[1]], &eased?)?;
            Some((grids[1].price(&fine.candidate), Effort::of_share(*share), fine))
        });
        let fine = match fine {
            // What costs effort alone is not counted from anything.
            None if switches => followed(search, found, shares[0], plan),
            fine => fine,
        };
        match fine {
            Some((.., fine)) if carried.iter().any(|(.., other)| same::<N>(other, &fine)) => {}
            Some(fine) => {
                best_coarse = best_coarse.or(Some(plan.cost));
                carried.push(fine);
            }
            None => rivals.push(plan.clone()),
        }
    }
    carried.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, effort, _)) = carried.first() {
        found.effort = Some(effort.clone());
        found.reorder(|_| carried.into_iter().map(|(.., fine)| fine).chain(rivals).collect());
    }
}

/// The plan of the requested grid that is near a coarse one, by way of grids twice as fine each: on each of them effort is counted from
/// the inputs of the plan on the one before. Where several limits act along arcs that keeps a plan together that no share of the effort
/// leads to; what it costs then is little more than the coarse one.
fn followed<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    share: f64,
    plan: &Attempt,
) -> Option<(f64, Effort, Attempt)> {
    let options = ScpOptions::default().within(search.context.settings.max_iterations);
    let mut from = search.with_effort(Some(Effort::of_share(share))).chain(plan.candidate.steps());
    let mut reached = plan.clone();
    let mut effort = Effort::of_share(share);
    let between = grids_between(from.model.steps, search.problem.steps);
    for steps in between.into_iter().chain([search.problem.steps]) {
        let start = transfer([&from, &search.chain(steps)], &reached.candidate);
        effort = Effort { share: FOLLOWED, about: Some(Arc::new(start.inputs.clone())) };
        let chain = search.with_effort(Some(effort.clone())).chain(steps);
        let convex = ConvexIteration { chain: &chain, options: &options };
        let next = search.context.attempt(Rung::Scp, &convex, start);
        found.add_work(&next);
        if !next.converged() || search.stopped() {
            return None;
        }
        (from, reached) = (chain, next);
    }
    Some((from.price(&reached.candidate), effort, reached))
}

/// A plan of the coarse grid as it is with the share of effort that the goal has now.
fn eased<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    coarse: &Chain,
    plan: &Attempt,
) -> Option<Attempt> {
    let options = ScpOptions::default().within(search.context.settings.max_iterations);
    let convex = ConvexIteration { chain: coarse, options: &options };
    let eased = search.context.attempt(Rung::Scp, &convex, plan.candidate.clone());
    found.add_work(&eased);
    eased.converged().then_some(eased)
}
