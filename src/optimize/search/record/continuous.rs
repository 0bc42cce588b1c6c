//! What a plan on equal steps costs in continuous time: an estimate from two grids.
//!
//! Without limits the cost of the discrete optimum converges with the square of the step. Where an
//! input jumps or meets a limit within a step, the factor of this square depends on where within.
//! The optimum on half as many steps gives both:
//!
//! ```text
//! C ≈ C(h) + (C(h) − C(2h)) / 3 ,    to about |C(h) − C(2h)|
//! ```
//!
//! Both grids may be off alike. A plan that has landed is a motion in continuous time, so the
//! optimum there costs no more than it: what landing costs counts as an error too. Arcs in
//! continuous time, where they are found, have the cost itself (`search/limited`).

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::ContinuousCost;
use crate::optimize::chain::Chain;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::{Attempt, Method};
use crate::optimize::search::ladder::Search;
use crate::optimize::search::starts::transfer::transfer;

/// Estimates the cost of a plan that lands from the optimum near it on half as many steps. Returns
/// `None` if there is none.
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
