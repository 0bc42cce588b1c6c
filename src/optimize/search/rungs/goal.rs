//! The rung of time, of fuel, and of a duration that is sought: SCP along the paths that are given.

use crate::maneuver::solution::Rung;
use crate::maneuver::switching::Switching;
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
use crate::optimize::search::goal::sharpened;
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::shares::{FIRST_SHARES, FOLLOWED, SHARE};
use crate::optimize::search::transfer::transfer;
use std::sync::Arc;

/// The local minima of a goal, the cheapest on the requested grid.
pub(super) struct OfGoal;

impl<const N: usize> Climb<N> for OfGoal {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.goal.as_ref().is_some_and(|goal| goal.effort.share > 0.0 || !goal.objective.switches())
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let coarse = coarse_minima(search, found);
        carry_to_requested(search, found, &coarse);
    }
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

/// A plan of the requested grid.
struct Carried {
    plan: Attempt,
    /// What it costs without the effort beside that.
    price: f64,
    /// The effort in its cost.
    effort: Effort,
    /// The arcs that have led to it.
    arcs: Option<Switching>,
}

impl Carried {
    /// What less of the effort in its cost may gain.
    fn to_gain<const N: usize>(&self, search: &Search<N>) -> f64 {
        let search = search.with_effort(Some(self.effort.clone()));
        search.chain(self.plan.candidate.steps()).to_gain(&self.plan.candidate)
    }

    /// With as little of the effort in its cost as goes.
    fn cheapened<const N: usize>(self, search: &Search<N>, found: &mut Found<N>) -> Self {
        let search = search.with_effort(Some(self.effort.clone()));
        match sharpened(&search, found, self.plan.clone()) {
            Some((plan, goal)) => {
                let price = search.chain(plan.candidate.steps()).price(&plan.candidate);
                Self { plan, price, effort: goal.effort, ..self }
            }
            None => self,
        }
    }
}

/// Carries the cheapest to the requested grid: by way of their arcs, or else with as much effort in the cost of each as that takes before
/// a dearer one is tried. Leaves the effort of the first.
fn carry_to_requested<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    found.reorder(cheapest_first);
    let few = coarse.model.steps;
    if few == search.problem.steps {
        return;
    }
    let maneuver = ByArcs::of(search);
    let plans = found.take_plans();
    let (mut carried, mut rivals) = (Vec::<Carried>::new(), Vec::new());
    let mut best_coarse = None;
    for (index, plan) in plans.iter().enumerate() {
        // On the fine grid the order of costs may be another.
        let close = |best: f64| carried.len() < CARRIED && plan.cost <= best + CLOSE * best.abs();
        if search.stopped() || !best_coarse.is_none_or(close) {
            rivals.extend_from_slice(&plans[index..]);
            break;
        }
        let by_arcs = maneuver.as_ref().and_then(|maneuver| by_arcs(search, found, maneuver, few, plan));
        match by_arcs.or_else(|| with_effort(search, found, few, plan)) {
            Some(fine) if carried.iter().any(|other| same::<N>(&other.plan, &fine.plan)) => {}
            Some(fine) => {
                best_coarse = best_coarse.or(Some(plan.cost));
                carried.push(fine);
            }
            None => rivals.push(plan.clone()),
        }
    }
    // What arcs lead to has hardly any effort in its cost: what may be cheaper without its own is compared with that as such.
    let told = carried.iter().filter(|fine| fine.arcs.is_some()).map(|fine| fine.price);
    let told = told.fold(f64::INFINITY, f64::min);
    let sharp = |fine: Carried| {
        // What was followed has been made cheap.
        let is_cheap = fine.arcs.is_some() || fine.effort.about.is_some();
        let to_gain = if is_cheap { 0.0 } else { fine.to_gain(search) };
        if fine.price >= told && fine.price - to_gain < told { fine.cheapened(search, found) } else { fine }
    };
    carried = carried.into_iter().map(sharp).collect();
    carried.sort_by(|a, b| a.price.total_cmp(&b.price));
    if let Some(first) = carried.first_mut() {
        (found.effort, found.arcs) = (Some(first.effort.clone()), first.arcs.take());
        found.reorder(|_| carried.into_iter().map(|fine| fine.plan).chain(rivals).collect());
    }
}

/// A coarse plan on the requested grid by way of the exact arcs that it leads to, or that it does on a grid between: the coarsest of
/// those that are each four times as fine as the one before, so that all of them together take less than the requested one.
fn by_arcs<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    maneuver: &ByArcs,
    few: usize,
    plan: &Attempt,
) -> Option<Carried> {
    let least = found.effort.clone();
    let mut grids: Vec<usize> =
        grids_between(few, search.problem.steps).into_iter().rev().skip(1).step_by(2).collect();
    grids.push(few);
    while let Some(steps) = grids.pop().filter(|_| !search.stopped()) {
        let problem = search.problem.clone().with_steps(steps);
        let between = search.of(&problem, Ask { lands: false, ..search.ask.clone() });
        let (reached, effort) = if steps == few {
            (plan.clone(), least.clone())
        } else {
            let Carried { plan, effort, .. } = with_effort(&between, found, few, plan)?;
            (plan, Some(effort))
        };
        let Some(told) = maneuver.told(&between.with_effort(effort), found, reached) else { continue };
        let origin = &plan.candidate.provenance.start;
        if let Some((plan, effort)) = maneuver.planned(search, found, &told, origin) {
            let price = search.chain(search.problem.steps).price(&plan.candidate);
            return Some(Carried { plan, price, effort, arcs: Some(told.switching) });
        }
    }
    None
}

/// A coarse plan on the requested grid with as much effort in its cost as that takes: along arcs on which a constraint acts rows of
/// neighbouring nodes nearly repeat each other.
fn with_effort<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    few: usize,
    plan: &Attempt,
) -> Option<Carried> {
    let shares = shares(search, found);
    let of_share = |share: &f64, found: &mut Found<N>| {
        let effort = Effort::of_share(*share);
        let search = &search.with_effort(Some(effort.clone()));
        let grids = [few, search.problem.steps].map(|steps| search.chain(steps));
        let eased =
            if *share == shares[0] { Some(plan.clone()) } else { eased(search, found, &grids[0], plan) };
        let plan = carried_to(search, found, [&grids[0], &grids[1]], &eased?)?;
        let price = grids[1].price(&plan.candidate);
        Some(Carried { plan, price, effort, arcs: None })
    };
    let fine = of_share(&shares[0], found);
    // What costs effort alone is not counted from anything.
    let switches = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.switches());
    if fine.is_some() || !switches || search.stopped() {
        return fine;
    }
    let followed = followed(search, found, few, shares[0], plan);
    followed.or_else(|| shares[1..].iter().find_map(|share| of_share(share, found)))
}

/// The plan of the requested grid that is near a coarse one, by way of grids twice as fine each: on each of them effort is counted from
/// the inputs of the plan on the one before. Where several limits act along arcs that keeps a plan together that no share of the effort
/// leads to; what it costs then is little more than the coarse one.
fn followed<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    few: usize,
    share: f64,
    plan: &Attempt,
) -> Option<Carried> {
    let options = ScpOptions::default().within(search.context.settings.max_iterations);
    let mut from = search.with_effort(Some(Effort::of_share(share))).chain(few);
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
    Some(
        Carried { price: from.price(&reached.candidate), plan: reached, effort, arcs: None }
            .cheapened(search, found),
    )
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
