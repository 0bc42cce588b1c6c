//! A maneuver in a duration that is known, from its search to its solution.

use crate::Vector3;
use crate::maneuver::infeasible;
use crate::maneuver::problem::{Motion, Path, Problem};
use crate::maneuver::solution::{Optimality, Outcome, Solution};
use crate::mechanics::Description;
use crate::optimize::search::asked;
use crate::optimize::search::context::Context;
use crate::optimize::search::found::{Found, SAME_COST};
use crate::optimize::search::ladder::{Ask, Search};
use crate::optimize::search::record::answer::{conclude, write};
use crate::optimize::search::starts::{self, any_attitude};
use crate::optimize::search::strategies::shots::shoot_from;
use crate::optimize::search::strategies::{self, advice};
use std::f64::consts::PI;

/// The answer of a search, or the proof that there is none.
pub(super) fn searched(problem: &Problem, context: &Context, ask: Ask) -> Solution {
    let of_motion = || if context.lands() { infeasible::of_motion(problem) } else { None };
    if let Some(proof) = infeasible::proof(problem).or_else(of_motion) {
        let unsolved = Solution::unsolved(problem, context.settings.tolerance);
        // The bound of a proof need not suffice; a turn about a fixed axis does.
        let longer = ask.advise.then(|| infeasible::sufficient(problem)).flatten();
        return Solution { outcome: Outcome::Infeasible, infeasible: Some(proof), longer, ..unsolved };
    }
    let known = known_end(problem);
    let problem = known.as_ref().unwrap_or(problem);
    match problem.motion {
        Motion::Attitude => answer(&search_of::<6>(problem, context, ask)),
        Motion::RigidBody => answer(&search_of::<12>(problem, context, ask)),
    }
}

/// A search with the ladder of all rungs.
pub(super) fn search_of<'a, 'c, const N: usize>(
    problem: &'a Problem,
    context: &'a Context<'c>,
    ask: Ask<'a>,
) -> Search<'a, 'c, N> {
    Search::new(problem, context, ask, strategies::ladder())
}

/// Climbs the ladder, and writes the solution with all that was tried.
fn answer<const N: usize>(search: &Search<N>) -> Solution {
    let mut found = search.climb();
    let solution = conclude(search, &mut found);
    let mut solution = asked::held_to_its_way(search, solution);
    if solution.method.is_on_equal_steps() {
        if search.ask.shooting {
            solution = confirm(search, solution);
        }
        if search.ask.last.polish {
            solution = asked::held_to(search.context.settings.tolerance, solution);
        }
        if search.ask.advise {
            advice::advise(search, found.shortest, &mut solution);
        }
    }
    Solution { ladder: search.context.ladder.take(), ..solution }
}

/// Newton from the guess alone, on the requested grid, with no ladder behind it.
pub(super) fn polished<const N: usize>(search: &Search<N>) -> Solution {
    let mut found = Found::default();
    if let Some(guess) = search.ask.guess {
        shoot_from(search, &mut found, &guess.costates, starts::GUESS);
    }
    Solution { ladder: search.context.ladder.take(), ..conclude(search, &mut found) }
}

/// A maneuver whose end tells more than what is written: the shortest way where a rotation stands
/// for one, or the likely attitude where any will do.
fn known_end(problem: &Problem) -> Option<Problem> {
    if problem.ends_in_any_attitude() {
        let mut likely = problem.clone();
        likely.end.attitude = any_attitude::likely_end(problem);
        return Some(likely);
    }
    turns_the_shortest_way(problem).then(|| problem.clone().with_path(Path::Shortest))
}

/// Rotations that are nearer to half a turn than this go either way round by their last bits
/// \[rad\].
const HALF_TURN: f64 = 1e-3;

/// Whether the rotation that is given is that of the shortest way between two states at rest, and
/// cannot be followed as it is written, since torques about some axis are missing: then all that it
/// tells is the sense.
fn turns_the_shortest_way(problem: &Problem) -> bool {
    let Path::AsGiven(rotation) = problem.path else { return false };
    let still = [&problem.start, &problem.end].map(|state| state.angular_velocity == Vector3::zeros());
    let free = matches!(problem.environment.describe(), Description::Free);
    let missing = problem.actuation.torque.rank().0 < 3;
    free && missing && still == [true; 2] && rotation.norm() < PI - HALF_TURN
}

/// The shooting's word on an answer on the chain, started from its duals: whether it is an
/// extremal, and of which second order. Where its terminal error is above the tolerance, the
/// shooting's own answer.
fn confirm<const N: usize>(search: &Search<N>, solution: Solution) -> Solution {
    if solution.outcome != Outcome::Converged || search.stopped() {
        return solution;
    }
    let duals = solution.costates_0(search.problem).to_vec();
    if duals.is_empty() {
        return solution;
    }
    let mut found = Found::default();
    shoot_from(search, &mut found, &duals, "duals");
    let Some(shot) = found.best() else { return solution };
    let unsolved = Solution::unsolved(search.problem, search.context.settings.tolerance);
    let mut confirmed = Solution { solve_time: search.context.began.elapsed().as_secs_f64(), ..unsolved };
    write(search, &found.work, &mut confirmed, shot);
    if (confirmed.cost - solution.cost).abs() > SAME_COST * solution.cost.abs() {
        return solution;
    }
    if solution.terminal.largest() > search.context.settings.tolerance {
        let Solution { convex, interior, rivals, .. } = solution;
        return Solution { convex, interior, rivals, ..confirmed };
    }
    let stationarity = solution.optimality.stationarity.max(confirmed.optimality.stationarity);
    let optimality = Optimality { stationarity, ..confirmed.optimality };
    Solution { optimality, solve_time: confirmed.solve_time, ..solution }
}
