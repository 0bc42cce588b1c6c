//! Advice for a maneuver without a plan: a duration for which a plan exists.

use crate::maneuver::infeasible;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Solution};
use crate::numerics::figures::rounded_up;
use crate::optimize::chain::Chain;
use crate::optimize::search::asked::goes_round_as_asked;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Ask, Search};
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::detour::detours;
use crate::optimize::search::strategies::chains::{descend, relaxed, relaxed_paths};

/// Durations tried for the advice, as multiples of the shortest duration found. Near the shortest
/// duration it is hard to find a plan without a guess.
const STRETCHES: [f64; 8] = [1.0, 1.01, 1.03, 1.1, 1.25, 1.5, 2.0, 3.0];

/// Adds to an unsolved maneuver a duration for which a plan was found. If there was none, adds a
/// duration that suffices for a turn about a fixed axis.
pub fn advise<const N: usize>(search: &Search<N>, shortest: Option<f64>, solution: &mut Solution) {
    // A search that was stopped early does not show that the maneuver has no plan.
    let searched = !matches!(solution.outcome, Outcome::Converged | Outcome::IterationLimit);
    if searched
        && !search.stopped()
        && let Some(missing) = solution.shortfall.take()
    {
        let longer = longer(search, shortest);
        solution.longer = longer.or_else(|| infeasible::sufficient(search.problem));
        solution.shortest = shortest;
        solution.shortfall = Some(Shortfall::InOtherTime {
            missing: Box::new(missing),
            asked: search.problem.seconds(),
            shortest,
            longer,
        });
    }
}

/// Returns a longer duration \[s\], rounded to four digits, for which a plan is found on a coarse
/// grid without a guess: `shortest`, or slightly more. `None` if no plan is found. The duration is
/// advice and not a proof, because the search is local.
fn longer<const N: usize>(search: &Search<N>, shortest: Option<f64>) -> Option<f64> {
    let found = |duration: &f64| {
        let problem = search.problem.clone().lasting(*duration);
        // Trials for advice are removed from the record of this maneuver.
        let noted = search.context.ladder.borrow().len();
        let found = problem.check().is_ok()
            && finds_any(&search.of(&problem, Ask::of_goal(None, search.context.settings)));
        search.context.ladder.borrow_mut().truncate(noted);
        found
    };
    let from = shortest.unwrap_or(0.0).max(search.problem.seconds());
    let durations = STRETCHES.into_iter().map(|stretch| rounded_up(stretch * from));
    durations
        .filter(|duration| *duration > search.problem.seconds())
        .find(|longer| !search.stopped() && found(longer))
}

/// Returns whether a plan in the requested homotopy class is found on the coarse grid.
fn finds_any<const N: usize>(search: &Search<N>) -> bool {
    let mut found = Found::default();
    let coarse = Chain::new(search.problem, chain_steps(search.problem));
    for (_, seed) in relaxed_paths(search, &relaxed(search.problem), &coarse) {
        for seed in detours(search.problem, seed) {
            if search.stopped() {
                return false;
            }
            descend(search, &mut found, &coarse, seed);
            if found.plans().last().is_some_and(|plan| goes_round_as_asked(search, &plan.candidate)) {
                return true;
            }
        }
    }
    false
}
