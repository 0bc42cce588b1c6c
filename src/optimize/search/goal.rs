//! The cheapest plan of a goal: of what the ladder finds, with as little of the effort in its cost as goes.

use super::chains::carried_to;
use super::coarse::chain_steps;
use super::found::Found;
use super::ladder::Search;
use super::landed::landed_with_goal;
use super::shares::{LAST_SHARE, LOWERED, SHARP};
use crate::maneuver::problem::State;
use crate::maneuver::solution::{Landing, Rung};
use crate::optimize::landing::Landed;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::Goal;
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration};

/// Costs of one plan with two shares of the effort differ by less, relative: by the larger share, from the one to the other.
const NEAR: [f64; 2] = [0.01, 0.1];
/// Costs that differ by less than this part are those of one plan.
pub(super) const SAME_COST: f64 = 1e-6;
/// Most subproblems from one share to the next.
const FEW: usize = 12;

/// The cheapest plan that was found.
pub(super) struct Cheapest {
    /// Its duration \[s\].
    pub duration: f64,
    /// Its cost in the unit of the user.
    pub cost: f64,
    /// The plan, as the chain of that duration takes it.
    pub attempt: Attempt,
    /// The share of the effort in its cost.
    pub share: f64,
    /// Dearer ones, each a local minimum, on a coarse grid, with their costs.
    pub rivals: Vec<(Attempt, f64)>,
    /// The target at which it lands, where that was asked for.
    pub landed: Option<(State, Landing)>,
}

/// The cheapest of the local minima that SCP finds along the paths of a search with a goal, and what else it knows.
pub(super) fn cheapest<const N: usize>(search: &Search<N>) -> (Found<N>, Option<Cheapest>) {
    let mut found = search.climb();
    let cheapest = made_cheap(&search.with_effort(found.share), &mut found);
    (found, cheapest)
}

/// The cheapest of what was found, with as little of the effort in its cost as goes, and made to land where that is asked for.
fn made_cheap<const N: usize>(search: &Search<N>, found: &mut Found<N>) -> Option<Cheapest> {
    let stated = search.problem.seconds();
    let mut plans = found.take_plans().into_iter();
    let first = plans.next().filter(|first| first.candidate.steps() == search.problem.steps)?;
    let (mut first, mut share) = sharpened(search, found, first);
    let before = search.chain(search.problem.steps).price(&first.candidate);
    let of_duration = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.is_duration());
    let before = if of_duration { stated * first.candidate.grid.duration() } else { before };
    let landed = landed_with_goal(search, &first, share).map(|(landed, least)| {
        let Landed { attempt, target, landing } = landed;
        let landing = Landing { cost_before: before, ..landing };
        (first, share) = (attempt, least);
        (target, landing)
    });
    let duration = stated * first.candidate.grid.duration();
    let chain = search.chain(search.problem.steps);
    let cost = chain.price(&first.candidate);
    let attempt = chain.of_given_duration(first, &search.problem.clone().with_duration(duration));
    let coarse = search.chain(chain_steps(search.problem));
    let price = |rival: Attempt| {
        let own = [&chain, &coarse].into_iter().find(|chain| chain.model.steps == rival.candidate.steps())?;
        let cost = own.price(&rival.candidate);
        Some((rival, cost))
    };
    Some(Cheapest { duration, cost, attempt, share, rivals: plans.filter_map(price).collect(), landed })
}

/// A plan with less and less effort in its cost, as far as that goes, and its share: on its own grid first, and where that ends
/// early on one of half as many steps, from which a smaller share is carried back.
fn sharpened<const N: usize>(search: &Search<N>, found: &mut Found<N>, plan: Attempt) -> (Attempt, f64) {
    let steps = plan.candidate.steps();
    let (plan, share, left) = lowered(search, found, plan);
    let half = steps.div_ceil(2);
    if share <= LAST_SHARE || left <= SAME_COST || half < chain_steps(search.problem) || search.stopped() {
        return (plan, share);
    }
    match sharpened_on(half, &search.with_effort(Some(share)), found, &plan) {
        Some((back, less)) => {
            let (back, less, _) = lowered(&search.with_effort(Some(less)), found, back);
            (back, less)
        }
        None => (plan, share),
    }
}

/// A cheaper plan with less effort in its cost on the same grid, by way of a coarser one.
fn sharpened_on<const N: usize>(
    steps: usize,
    search: &Search<N>,
    found: &mut Found<N>,
    plan: &Attempt,
) -> Option<(Attempt, f64)> {
    let share = search.ask.goal.as_ref()?.share;
    let grids = [plan.candidate.steps(), steps].map(|steps| search.chain(steps));
    let coarse = carried_to(search, found, [&grids[0], &grids[1]], plan)?;
    let (coarse, less) = sharpened(search, found, coarse);
    if less >= share {
        return None;
    }
    let search = search.with_effort(Some(less));
    let grids = grids.map(|chain| search.chain(chain.model.steps));
    let back = carried_to(&search, found, [&grids[1], &grids[0]], &coarse)?;
    let cheaper = grids[0].price(&back.candidate) < grids[0].price(&plan.candidate);
    cheaper.then_some((back, less))
}

/// A plan with less and less effort in its cost on its grid, the share with which that ends, and what a smaller one would gain at
/// most, relative. Other limits begin to act from share to share: a convex subproblem finds them sooner than Newton does, and
/// the sooner the fewer.
///
/// With a share ε the optimum is dearer by `O(ε²)`: what the last step to a smaller one has gained tells what is left. Where that is
/// too little for another plan, a step that fails is not tried again.
fn lowered<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    mut plan: Attempt,
) -> (Attempt, f64, f64) {
    let options = ScpOptions { cone_tolerance: SHARP, ..search.ask.last.clone().within(FEW) };
    let Some(goal) = search.ask.goal.clone().filter(|goal| goal.objective.switches()) else {
        return (plan, 0.0, 0.0);
    };
    let (mut last, mut factor, mut left) = (goal.share, LOWERED.0, f64::INFINITY);
    while last > LAST_SHARE && factor <= LOWERED.1 && !search.stopped() {
        let share = (last * factor).max(LAST_SHARE);
        let chain = Chain::with_goal(search.problem, plan.candidate.steps(), &Goal { share, ..goal.clone() });
        let newton = ActiveSetNewton { chain: &chain, options: &options };
        let convex = ConvexIteration { chain: &chain, options: &options };
        let before = chain.price(&plan.candidate);
        let near = last.clamp(NEAR[0], NEAR[1]);
        let change = |next: &Attempt| (before - chain.price(&next.candidate)).abs() / before;
        let is_near = |next: &Attempt| next.converged() && change(next) <= near;
        let quick = search.context.tried(Rung::Scp, &newton, plan.candidate.clone());
        let next = if is_near(&quick) {
            search.context.noted(Rung::Scp, quick)
        } else {
            search.context.attempt(Rung::Scp, &convex, plan.candidate.clone())
        };
        found.add_work(&next);
        if is_near(&next) {
            left = change(&next) / ((last / share).powi(2) - 1.0);
            (plan, last, factor) = (next, share, (factor * factor).max(LOWERED.0));
        } else if left <= SAME_COST {
            break;
        } else {
            factor = factor.sqrt();
        }
    }
    (plan, last, left)
}
