//! The cheapest plan for an objective other than effort with a given duration: time, fuel, or
//! effort with a free duration.

use crate::maneuver::problem::State;
use crate::maneuver::solution::{ContinuousCost, ContinuousGap, Landing, Solution};
use crate::optimize::landing::Landed;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::asked::held_to_all;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::record::answer::{rival_of_cost, write_aimed};
use crate::optimize::search::record::continuous::estimated;
use crate::optimize::search::record::first_order::gap;
use crate::optimize::search::record::landed::{can_be_flown, landed_with_goal};

/// Relative cost difference below which two plans are the same.
pub const SAME_COST: f64 = 1e-6;

/// The cheapest plan that a search with an objective found.
pub struct Cheapest {
    /// Duration of the plan \[s\].
    pub duration: f64,
    /// Cost of the plan in the user's unit.
    pub cost: f64,
    /// The plan, in the units of a chain with the plan's duration.
    pub attempt: Attempt,
    /// Other local minima, each with its cost. They cost more than the plan, and some are on a
    /// coarse grid.
    pub rivals: Vec<(Attempt, f64)>,
    /// Estimated cost in continuous time.
    pub continuous: Option<ContinuousCost>,
    /// Cost that could be saved, to first order, if the inputs switched between the nodes.
    pub gap: Option<ContinuousGap>,
    /// Discrete target of the landing, and its description; `None` if landing is not required.
    pub landed: Option<(State, Landing)>,
}

impl Cheapest {
    /// Converts the plan to a solution.
    pub fn written<const N: usize>(self, search: &Search<N>, found: &Found<N>) -> Solution {
        let Self { duration, cost, attempt, rivals, continuous, gap, landed } = self;
        let of_duration = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.is_duration());
        let planned = search.problem.clone().with_duration(duration);
        let written = search.of(&planned, search.ask.clone());
        let mut solution = Solution::unsolved(&planned, search.context.settings.tolerance);
        let target = landed.as_ref().map(|(target, _)| target);
        write_aimed(&written, &found.work, &mut solution, &attempt, target, &attempt);
        if let Some((_, landing)) = landed {
            solution.landing = Some(landing);
        }
        if let Some(work) = &mut solution.interior {
            work.continuous = continuous;
            work.continuous_gap = gap;
        }
        // For minimum time the cost is exactly the duration.
        solution.cost = if of_duration { duration } else { cost };
        solution.widen_by_landing();
        solution.rivals = rivals.iter().map(|(rival, cost)| rival_of_cost(&written, rival, *cost)).collect();
        held_to_all(&written, solution)
    }

    /// Completes an optimum: lands it if required, and estimates its cost in continuous time.
    fn of<const N: usize>(search: &Search<N>, mut plan: Attempt) -> Self {
        let stated = search.problem.seconds();
        let chain = search.chain(search.problem.steps);
        let of_duration = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.is_duration());
        let duration = |plan: &Attempt| stated * plan.candidate.grid.duration();
        let before = if of_duration { duration(&plan) } else { chain.price(&plan.candidate) };
        let before = before * plan.share_of_optimum();
        let (continuous, landed) = (estimated(search, &plan), landed_with_goal(search, &plan));
        let gap = gap(search, &plan, landed.as_ref().map(|landed| &landed.landing));
        let landed = landed.map(|Landed { attempt, target, landing }| {
            plan = attempt;
            (target, Landing { cost_before: before, ..landing })
        });
        let (duration, cost) = (duration(&plan), chain.price(&plan.candidate));
        let attempt = chain.of_given_duration(plan, &search.problem.clone().with_duration(duration));
        Self { duration, cost, attempt, rivals: Vec::new(), continuous, gap, landed }
    }
}

/// Runs a search for an objective. Returns its results, and the cheapest local minimum that the
/// true motion can follow.
pub fn cheapest<const N: usize>(search: &Search<N>) -> (Found<N>, Option<Cheapest>) {
    let mut found = search.climb();
    let mut plans = found.take_plans();
    let requested = |plan: &Attempt| plan.candidate.steps() == search.problem.steps;
    let flies = |plan: &Attempt| requested(plan) && can_be_flown(search, plan);
    if let Some(flown) = plans.iter().position(flies) {
        let first = plans.remove(flown);
        plans.insert(0, first);
    }
    let mut plans = plans.into_iter();
    let first = plans.next().filter(requested);
    let cheapest = first.map(|first| {
        let price = |rival: Attempt| {
            let cost = search.chain(rival.candidate.steps()).price(&rival.candidate);
            (rival, cost)
        };
        Cheapest { rivals: plans.map(price).collect(), ..Cheapest::of(search, first) }
    });
    (found, cheapest)
}
