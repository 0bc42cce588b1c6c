//! From a coarse grid to the requested one by way of the arcs of continuous time.
//!
//! A plan on few steps tells the order of arcs as well as one on many does, and what Newton makes of their lengths has nothing to do with
//! any grid. Where such arcs satisfy the maximum principle ([`crate::optimize::methods::limited`]) their motion at the nodes of the
//! requested grid is a path along which one or two subproblems are enough, with so little of the effort in the cost that it does not feel
//! it. What is lowered share by share on the requested grid instead takes many, and along arcs of a fine grid may not come to an end.

use super::found::Found;
use super::goal::{Cheapest, lightened, sharp};
use super::ladder::Search;
use super::limited::Told;
use super::shares::{FOLLOWED, LAST_SHARE};
use crate::maneuver::duration::Duration;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Outcome, Rung};
use crate::maneuver::switching::Switching;
use crate::mechanics::environment::Pose;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::limited::exchange::EXACT;
use crate::optimize::methods::limited::motion::Maneuver;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::model::Effort;
use crate::optimize::methods::scp::road::{Chain, ConvexIteration, path};
use std::sync::Arc;

/// The maneuver of a search for which arcs are known in continuous time.
pub(super) struct ByArcs {
    problem: Problem,
    maneuver: Maneuver,
}

impl ByArcs {
    /// `None` where arcs of this kind do not describe it.
    pub fn of<const N: usize>(search: &Search<N>) -> Option<Self> {
        let objective = search.ask.goal.as_ref()?.objective.clone();
        let sought = objective.counts_time();
        let mut problem = search.problem.clone().with_objective(objective);
        if sought {
            problem = problem.with_duration(Duration::SOUGHT);
        }
        let maneuver = Maneuver::of(&problem)?;
        Some(Self { problem, maneuver })
    }

    /// The exact arcs that a plan on the grid of a search leads to.
    pub fn told<const N: usize>(
        &self,
        search: &Search<N>,
        found: &mut Found<N>,
        plan: Attempt,
    ) -> Option<Told> {
        let (plan, goal, _) = lightened(search, found, plan)?;
        let plan = Cheapest::of(search, (plan, goal)).written(search, found);
        if plan.outcome != Outcome::Converged {
            return None;
        }
        let arcs = Told::of(&self.maneuver, &self.problem, search.context, &plan)?;
        let Switching { singular_inputs, gap, continuous_cost, .. } = &arcs.switching;
        let exact = singular_inputs.is_empty() && *gap <= EXACT * continuous_cost;
        exact.then_some(arcs)
    }

    /// The plan of the requested grid that is next to the arcs of one that began as `origin` says, and the effort in its cost: the least
    /// share of it or, where that decides too little, what inputs change from those that it comes to.
    pub fn planned<const N: usize>(
        &self,
        search: &Search<N>,
        found: &mut Found<N>,
        arcs: &Told,
        origin: &str,
    ) -> Option<(Attempt, Effort)> {
        let mut effort = Effort::of_share(LAST_SHARE);
        let mut from = None;
        loop {
            let chain = search.with_effort(Some(effort.clone())).chain(search.problem.steps);
            let start = from.take().or_else(|| self.along(search, &chain, arcs, origin))?;
            let convex = ConvexIteration { chain: &chain, options: &sharp(search) };
            let next = search.context.attempt(Rung::Scp, &convex, start);
            found.add_work(&next);
            if next.converged() {
                return arcs.are_of(chain.price(&next.candidate)).then_some((next, effort));
            }
            if effort.about.is_some() || search.stopped() || !next.began() {
                return None;
            }
            effort = Effort { share: FOLLOWED, about: Some(Arc::new(next.candidate.inputs.clone())) };
            from = Some(next.candidate);
        }
    }

    /// The path of arcs on the grid of a chain.
    fn along<const N: usize>(
        &self,
        search: &Search<N>,
        chain: &Chain,
        arcs: &Told,
        origin: &str,
    ) -> Option<Candidate> {
        let length = chain.model.dynamics.units.length;
        let sought = chain.model.duration.is_some();
        let stretch =
            if sought { arcs.switching.continuous_duration_s / search.problem.seconds() } else { 1.0 };
        let poses = arcs.poses(&self.maneuver, chain.model.steps)?;
        let poses = poses.into_iter().map(|pose| Pose { position: pose.position / length, ..pose });
        Some(path(origin, &chain.model.dynamics.grid.with_duration(stretch), poses))
    }
}
