//! Strategy that starts from a plan with a shorter duration, if none was found for the given
//! duration.

use crate::maneuver::constraint::{Constraint, Rule};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::Outcome;
use crate::optimize::chain::model::Goal;
use crate::optimize::chain::path;
use crate::optimize::discrete::step::Point;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::record::goal::{Cheapest, cheapest};
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::transfer::Interpolant;
use crate::optimize::search::strategies::chains::{carry, descend, unlimited_paths};

/// Solves from the plan with the shortest duration that is found. A plan that is quicker than
/// required is near a path that the other strategies have missed.
pub struct Shortest;

impl<const N: usize> Climb<N> for Shortest {
    /// Applies if no plan was found, the search was not stopped early, and a shortest duration
    /// exists.
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        let cut_short = found.missed().is_some_and(|missed| missed.outcome == Outcome::IterationLimit);
        let searched = !found.is_done() && found.answer.is_none() && !cut_short && !search.stopped();
        searched && search.ask.convex && search.ask.advise && has_a_shortest_duration(search.problem)
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let goal = Goal { objective: Objective::Time };
        let of_time = Ask::of_goal(Some(goal), search.context.settings);
        let trial = search.of(search.problem, of_time.clone());
        let paths = unlimited_paths(&trial, &trial.chain(chain_steps(search.problem)));
        let (_, quickest) = cheapest(&search.of(search.problem, Ask { paths: &paths, ..of_time }));
        let Some(Cheapest { duration, attempt, .. }) = quickest else { return };
        found.shortest = Some(duration);
        if duration > search.problem.seconds() {
            return;
        }
        let coarse = search.chain(chain_steps(search.problem));
        let nodes = Interpolant::of(attempt.candidate.states.iter().map(Point::pose).collect());
        let poses = nodes.on(coarse.model.steps);
        let missed = found.take_missed();
        descend(search, found, &coarse, path("shortest", &coarse.model.dynamics.grid, poses.into_iter()));
        carry(search, found, &coarse);
        let missed = missed.or(found.take_missed());
        found.tell_missed(missed);
    }
}

/// Returns whether a maneuver has a shortest duration: cones do not impose one, nor do wheels
/// without limits.
fn has_a_shortest_duration(problem: &Problem) -> bool {
    let slowed = |constraint: &Constraint| !matches!(constraint.rule, Rule::Pointing(_));
    problem.constraints.iter().any(slowed)
        || problem.actuation.limits().any(|limit| limit.bounds.iter().any(|bound| bound.is_finite()))
}
