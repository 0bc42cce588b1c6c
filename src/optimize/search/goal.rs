//! The cheapest plan of a goal: of what the ladder finds, with as little of the effort in its cost as goes.

use super::answer::{rival_of_cost, write_aimed};
use super::asked::held_to_all;
use super::found::Found;
use super::ladder::Search;
use super::landed::landed_with_goal;
use super::shares::{LAST_SHARE, LOWERED, SHARP};
use crate::maneuver::problem::State;
use crate::maneuver::solution::{ConvexWork, Landing, Rung, Solution};
use crate::maneuver::switching::Switching;
use crate::optimize::landing::Landed;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::{Effort, Goal};
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration};
use std::sync::Arc;

/// Costs of one plan with two shares of the effort differ by less, relative: by the larger share, from the one to the other.
const NEAR: [f64; 2] = [0.01, 0.1];
/// Costs that differ by less than this part are those of one plan.
pub(super) const SAME_COST: f64 = 1e-6;
/// Most subproblems from one share to the next.
const FEW: usize = 12;
/// Least part of the inputs of a plan from which effort is counted.
const LEAST_PART: f64 = 0.1;
/// Most problems whose effort is counted from the plan of the one before: costs that fall end sooner.
const MOST_ROUNDS: usize = 60;

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
    /// The arcs that have led to it.
    pub arcs: Option<Switching>,
}

impl Cheapest {
    /// All that is told of it.
    pub fn written<const N: usize>(self, search: &Search<N>, found: &Found<N>) -> Solution {
        let Self { duration, cost, attempt, share, rivals, landed, arcs } = self;
        let of_duration = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.is_duration());
        let planned = search.problem.clone().with_duration(duration);
        let written = search.of(&planned, search.with_effort(found.effort.clone()).ask);
        let work = ConvexWork { effort_share: share, ..found.work };
        let mut solution = Solution::unsolved(&planned, search.context.settings.tolerance);
        match landed {
            Some((target, landing)) => {
                write_aimed(&written, &work, &mut solution, &attempt, Some(&target), &attempt);
                solution.landing = Some(landing);
            }
            None => write_aimed(&written, &work, &mut solution, &attempt, None, &attempt),
        }
        // A duration to the last bit.
        solution.cost = if of_duration { duration } else { cost };
        solution.rivals = rivals.iter().map(|(rival, cost)| rival_of_cost(&written, rival, *cost)).collect();
        solution.switching = arcs;
        held_to_all(&written, solution)
    }
}

/// The cheapest of the local minima that SCP finds along the paths of a search with a goal, and what else it knows.
pub(super) fn cheapest<const N: usize>(search: &Search<N>) -> (Found<N>, Option<Cheapest>) {
    let mut found = search.climb();
    let mut plans = found.take_plans().into_iter();
    let first = plans.next().filter(|first| first.candidate.steps() == search.problem.steps);
    let cheapest = first.and_then(|first| {
        let search = &search.with_effort(found.effort.clone());
        let price = |rival: Attempt| {
            let cost = search.chain(rival.candidate.steps()).price(&rival.candidate);
            (rival, cost)
        };
        let cheapest = made_cheap(search, &mut found, first)?;
        Some(Cheapest { rivals: plans.map(price).collect(), arcs: found.arcs.take(), ..cheapest })
    });
    (found, cheapest)
}

/// A plan of the grid of a search with as little of the effort in its cost as goes, and made to land where that is asked for.
fn made_cheap<const N: usize>(search: &Search<N>, found: &mut Found<N>, plan: Attempt) -> Option<Cheapest> {
    Some(Cheapest::of(search, sharpened(search, found, plan)?))
}

impl Cheapest {
    /// The optimum of a goal, made to land where that is asked for.
    pub fn of<const N: usize>(search: &Search<N>, (mut first, goal): (Attempt, Goal)) -> Self {
        let stated = search.problem.seconds();
        let mut share = if goal.objective.switches() { told_share(&goal, &first) } else { 0.0 };
        let before = search.chain(search.problem.steps).price(&first.candidate);
        let of_duration = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.is_duration());
        let before = if of_duration { stated * first.candidate.grid.duration() } else { before };
        let landed = landed_with_goal(search, &first, &goal).map(|(landed, eased)| {
            let Landed { attempt, target, landing } = landed;
            let landing = Landing { cost_before: before, ..landing };
            first = attempt;
            share = if eased > goal.effort.share { eased } else { share };
            (target, landing)
        });
        let duration = stated * first.candidate.grid.duration();
        let chain = search.chain(search.problem.steps);
        let cost = chain.price(&first.candidate);
        let attempt = chain.of_given_duration(first, &search.problem.clone().with_duration(duration));
        Self { duration, cost, attempt, share, rivals: Vec::new(), landed, arcs: None }
    }
}

/// A plan with as little of the effort in its cost as goes, and the goal whose optimum it is.
pub(super) fn sharpened<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    plan: Attempt,
) -> Option<(Attempt, Goal)> {
    let (plan, goal, left) = lightened(search, found, plan)?;
    Some(if left <= SAME_COST { (plan, goal) } else { settled(search, found, plan, goal) })
}

/// A plan with a share of the effort in its cost that is as small as goes, the goal whose optimum it is, and what a smaller one would gain
/// at most, relative.
pub(super) fn lightened<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    plan: Attempt,
) -> Option<(Attempt, Goal, f64)> {
    let goal = search.ask.goal.clone()?;
    if !goal.objective.switches() {
        return Some((plan, goal, 0.0));
    }
    if goal.effort.about.is_some() {
        return Some((plan, goal, f64::INFINITY));
    }
    let (plan, share, left) = lowered(search, found, plan, &goal);
    Some((plan, Goal { effort: Effort::of_share(share), ..goal }, left))
}

/// A plan whose effort is counted from its own inputs, again and again, where its share can be lowered no further.
///
/// That is the proximal point method (Rockafellar, *Monotone Operators and the Proximal Point Algorithm*, SIAM J. Control and
/// Optimization 14(5), 1976): every problem has the curvature of the share, none costs more than the one before, and where inputs
/// change no more, effort is no part of the cost. Where that is too much at once effort is counted from a part of its inputs.
fn settled<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    mut plan: Attempt,
    mut goal: Goal,
) -> (Attempt, Goal) {
    let options = sharp(search);
    let mut part = 1.0;
    for _ in 0..MOST_ROUNDS {
        if search.stopped() {
            break;
        }
        let from = plan.candidate.inputs.iter().map(|inputs| inputs.iter().map(|u| part * u).collect());
        let effort = Effort { about: Some(Arc::new(from.collect())), ..goal.effort };
        let about = Goal { effort, ..goal.clone() };
        let chain = Chain::with_goal(search.problem, plan.candidate.steps(), &about);
        let before = chain.price(&plan.candidate);
        let cheaper = |next: &Attempt| next.converged() && chain.price(&next.candidate) <= before;
        match improved(search, found, (&chain, &options), &plan, &cheaper) {
            Some(next) => {
                let gained = 1.0 - chain.price(&next.candidate) / before;
                (plan, goal) = (next, about);
                if part == 1.0 && gained <= SAME_COST {
                    break;
                }
                part = f64::min(2.0 * part, 1.0);
            }
            None if part > LEAST_PART => part *= 0.5,
            None => break,
        }
    }
    (plan, goal)
}

/// What is told of the share of the effort in the cost of a plan: that of the change of its inputs, where effort is counted from others.
fn told_share(goal: &Goal, plan: &Attempt) -> f64 {
    let Effort { share, about: Some(about) } = &goal.effort else { return goal.effort.share };
    let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(f64::abs).fold(0.0, f64::max);
    let inputs = &plan.candidate.inputs;
    let mut changes = inputs.iter().flatten().zip(about.iter().flatten()).map(|(u, r)| u - r);
    let part = largest(&mut changes) / largest(&mut inputs.iter().flatten().copied()).max(f64::MIN_POSITIVE);
    share * part.min(1.0)
}

/// How a plan of the requested grid is improved: multipliers tell which inputs are off, the less clearly the smaller the share.
pub(super) fn sharp<const N: usize>(search: &Search<N>) -> ScpOptions {
    ScpOptions { cone_tolerance: SHARP, ..search.ask.last.clone().within(FEW) }
}

/// What Newton or, where that does not do, the convex iteration makes of a plan, if it `is_one`.
fn improved<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    (chain, options): (&Chain, &ScpOptions),
    plan: &Attempt,
    is_one: &dyn Fn(&Attempt) -> bool,
) -> Option<Attempt> {
    let newton = ActiveSetNewton { chain, options };
    let quick = search.context.tried(Rung::Scp, &newton, plan.candidate.clone());
    let next = if is_one(&quick) {
        search.context.noted(Rung::Scp, quick)
    } else {
        let convex = ConvexIteration { chain, options };
        search.context.attempt(Rung::Scp, &convex, plan.candidate.clone())
    };
    found.add_work(&next);
    is_one(&next).then_some(next)
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
    goal: &Goal,
) -> (Attempt, f64, f64) {
    let options = sharp(search);
    let (mut last, mut factor, mut left) = (goal.effort.share, LOWERED.0, f64::INFINITY);
    while last > LAST_SHARE && factor <= LOWERED.1 && !search.stopped() {
        let share = (last * factor).max(LAST_SHARE);
        let chain = Chain::with_goal(
            search.problem,
            plan.candidate.steps(),
            &Goal { effort: Effort::of_share(share), ..goal.clone() },
        );
        let before = chain.price(&plan.candidate);
        let near = last.clamp(NEAR[0], NEAR[1]);
        let change = |next: &Attempt| (before - chain.price(&next.candidate)).abs() / before;
        let is_near = |next: &Attempt| next.converged() && change(next) <= near;
        match improved(search, found, (&chain, &options), &plan, &is_near) {
            Some(next) => {
                left = change(&next) / ((last / share).powi(2) - 1.0);
                (plan, last, factor) = (next, share, (factor * factor).max(LOWERED.0));
            }
            None if left <= SAME_COST => break,
            None => factor = factor.sqrt(),
        }
    }
    (plan, last, if last > LAST_SHARE { left } else { 0.0 })
}
