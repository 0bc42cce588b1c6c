//! Descents on the requested grid, and the use of their nodes.
//!
//! # How is the best homotopy class found?
//!
//! On the requested grid an extremal may satisfy all conditions at its nodes and still not be
//! reproduced from λ₋₁, because round-off of the costates grows along the path. The nodes are then
//! the plan: the chain uses their path, which is optimal already, and records states, inputs and
//! multipliers of every step. If the lifted Newton method stalls because the removal of the last
//! authority makes the problem nearly singular, the interior-point method continues from the path
//! of the minimum.

use crate::maneuver::solution::{Outcome, Rung};
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::strategies::authority::WIDENED;
use crate::optimize::search::strategies::chains::optimised_near;
use crate::optimize::search::strategies::descents::{
    LIFTED_TOLERANCE, NARROW, SAME_BRANCH, descended, descends_on,
};
use crate::optimize::search::strategies::shots::shoot_fine;

/// Predicted relative decrease of the cost below which a descent on the requested grid ends.
const FINE_TOLERANCE: f64 = 1e-14;
/// Factor on the iterations of the lifted Newton method on the requested grid. The valley from the
/// last additional authority to none is long.
const PATIENCE: usize = 4;
/// Levels of additional authority (indices of `WIDENED`) through which a path passes on the
/// requested grid.
const LAST_LEVELS: [usize; 3] = [2, 3, WIDENED.len() - 1];
/// Largest number of steps of a descent or a lifted Newton iteration on the requested grid, which
/// keep the matrices of every step.
pub const MOST_STEPS: usize = 20_000;

/// Descends from a path on the requested grid to a minimum, and solves for its extremal.
pub fn descend_on_requested_grid<const N: usize>(search: &Search<N>, found: &mut Found<N>, path: Candidate) {
    let fine = search.fine.clone();
    let all = fine.dynamics.has_all_axes();
    let levels = if all { &[usize::MAX][..] } else { &LAST_LEVELS };
    let mut minimum = Attempt::failed(path, Outcome::Stalled);
    for level in levels {
        let wide = descends_on(&fine.dynamics, *level);
        minimum = descended(search, &fine, &wide, minimum.candidate, FINE_TOLERANCE, &[]);
    }
    let within = if all { SAME_BRANCH } else { NARROW };
    let near = |cost: f64| (cost - minimum.cost).abs() <= within * minimum.cost;
    if all && shoot_fine(search, found, Rung::Descent, minimum.candidate.clone()).is_some_and(near) {
        return;
    }
    let newton = LiftedNewton { bvp: &fine, tolerance: LIFTED_TOLERANCE, patience: PATIENCE };
    let lifted = search.context.attempt(Rung::Lifted, &newton, minimum.candidate.clone());
    if lifted.converged() {
        if !shoot_fine(search, found, Rung::Lifted, lifted.candidate.clone()).is_some_and(near) {
            replay(search, found, &lifted.candidate);
        }
    } else if !all {
        // Without the last additional authority, a singular problem stops a Newton method on all
        // nodes, but not the interior-point method.
        replay(search, found, &minimum.candidate);
    }
}

/// Adds a plan of the chain, which holds the states of all nodes. It serves for an extremal of the
/// requested grid that shooting cannot reproduce from its start, because round-off of the costates
/// grows along the path, and for other paths there.
fn replay<const N: usize>(search: &Search<N>, found: &mut Found<N>, nodes: &Candidate) {
    if search.ask.convex && !search.stopped() {
        let chain = search.chain(search.problem.steps);
        let name = &nodes.provenance.start;
        let nodes = path(name, &chain.model.dynamics.grid, nodes.states.iter().map(Point::pose));
        found.keep(optimised_near(search, &chain, nodes));
    }
}
