//! A maneuver with a known duration, from its search to its solution.

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

/// Solves a maneuver with a known duration, or proves that it is infeasible. `ask` states the
/// methods that may be used.
pub(super) fn searched(problem: &Problem, context: &Context, ask: Ask) -> Solution {
    let of_motion = || if context.lands() { infeasible::of_motion(problem) } else { None };
    if let Some(proof) = infeasible::proof(problem).or_else(of_motion) {
        let unsolved = Solution::unsolved(problem, context.settings.tolerance);
        // A duration at the bound of the infeasibility proof may be too short; that of a turn about
        // a fixed axis suffices.
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

/// Creates a search with all strategies.
pub(super) fn search_of<'a, 'c, const N: usize>(
    problem: &'a Problem,
    context: &'a Context<'c>,
    ask: Ask<'a>,
) -> Search<'a, 'c, N> {
    Search::new(problem, context, ask, strategies::ladder())
}

/// Runs the strategies, and returns the solution with the record of their runs.
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

/// Solves by Newton shooting from the guess alone, on the requested grid, without other strategies.
pub(super) fn polished<const N: usize>(search: &Search<N>) -> Solution {
    let mut found = Found::default();
    if let Some(guess) = search.ask.guess {
        shoot_from(search, &mut found, &guess.costates, starts::GUESS);
    }
    Solution { ladder: search.context.ladder.take(), ..conclude(search, &mut found) }
}

/// Returns the maneuver with a more specific request: the shortest path in place of an equivalent
/// given rotation, or a likely terminal attitude in place of a free one. `None` if neither applies.
fn known_end(problem: &Problem) -> Option<Problem> {
    if problem.ends_in_any_attitude() {
        let mut likely = problem.clone();
        likely.end.attitude = any_attitude::likely_end(problem);
        return Some(likely);
    }
    turns_the_shortest_way(problem).then(|| problem.clone().with_path(Path::Shortest))
}

/// Difference between an angle and half a turn \[rad\] below which round-off decides the homotopy
/// class of a rotation.
const HALF_TURN: f64 = 1e-3;

/// Returns whether the given rotation is the shortest one between two states at rest and cannot be
/// followed exactly because torques about some axis are missing. The rotation then determines only
/// the homotopy class.
fn turns_the_shortest_way(problem: &Problem) -> bool {
    let Path::AsGiven(rotation) = problem.path else { return false };
    let still = [&problem.start, &problem.end].map(|state| state.angular_velocity == Vector3::zeros());
    let free = matches!(problem.environment.describe(), Description::Free);
    let missing = problem.actuation.torque.rank().0 < 3;
    free && missing && still == [true; 2] && rotation.norm() < PI - HALF_TURN
}

/// Confirms a solution of the chain by shooting from its dual variables: tests whether it is an
/// extremal, and its second order. If the terminal error of the solution exceeds the tolerance, the
/// result of shooting replaces the solution.
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
