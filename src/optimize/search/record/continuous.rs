//! Estimated cost in continuous time of a plan on a uniform grid, from two grids.
//!
//! Without limits the cost of the discrete optimum converges with the square of the step. If an
//! input jumps or reaches a limit within a step, the factor of this square depends on the position
//! within the step. The optimum on half as many steps gives both the extrapolated cost (Richardson
//! extrapolation) and its uncertainty:
//!
//! ```text
//! C ≈ C(h) + (C(h) − C(2h)) / 3 ,    to about |C(h) − C(2h)|
//! ```
//!
//! Both grids may have similar errors. A plan that has landed is a motion in continuous time, and
//! the continuous optimum costs at most as much; the cost of landing is therefore part of the
//! uncertainty. Arcs in continuous time, where they are found, have the exact cost
//! (`search/limited`).

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::ContinuousCost;
use crate::optimize::chain::Chain;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::{Attempt, Method};
use crate::optimize::search::ladder::Search;
use crate::optimize::search::starts::transfer::transfer;

/// Estimates the continuous-time cost of a landed plan from the nearby optimum on half as many
/// steps; returns `None` if that optimum is not found.
pub fn estimated<const N: usize>(search: &Search<N>, plan: &Attempt) -> Option<ContinuousCost> {
    let (steps, half) = (plan.candidate.steps(), plan.candidate.steps() / 2);
    let of_interior_point = plan.candidate.provenance.method == Road::InteriorPoint;
    let asked = search.ask.lands && of_interior_point && plan.converged() && half >= Problem::MIN_STEPS;
    if !asked || search.stopped() {
        return None;
    }
    let [fine, coarse] = [steps, half].map(|steps| search.chain(steps));
    let start = transfer([&fine, &coarse], &plan.candidate);
    let tuning = Tuning::near();
    let method = InteriorPoint { family: search.ask.family, ..InteriorPoint::of(&coarse, &tuning) };
    let found = search.context.within(|budget| method.improve(start, budget));
    let cost = |chain: &Chain, plan: &Attempt| {
        let cost = match search.ask.goal {
            Some(_) => chain.price(&plan.candidate),
            None => plan.cost * search.fine.dynamics.units.cost,
        };
        cost * plan.share_of_optimum()
    };
    let [finer, coarser] = [cost(&fine, plan), cost(&coarse, &found)];
    let (change, ratio) = (finer - coarser, steps as f64 / half as f64);
    let estimate = ContinuousCost::new(finer + change / (ratio * ratio - 1.0), change.abs());
    (found.converged() && estimate.cost.is_finite()).then_some(estimate)
}
