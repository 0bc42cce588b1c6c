//! Landing a plan of the chain: solved again, warm from what the correction before left, towards the shifted
//! target and within constraints that are drawn in.

use super::{Aim, Next};
use crate::maneuver::problem::State;
use crate::maneuver::solution::{Landing, Trajectory};
use crate::optimize::chain::Chain;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::methods::method::Attempt;

/// A plan of the chain that lands as well as corrections could make it.
pub(crate) struct Landed {
    pub attempt: Attempt,
    pub target: State,
    pub landing: Landing,
}

/// Lands a plan of the chain where `aim` says.
///
/// `recorded` gives the plan that an attempt is, and `solve` solves again, warm, from an attempt on the chain that is
/// aimed, after a miss of such a size: `None` where either cannot. What `is_rough` is solved once more where it lands. `chain` is left aimed at what the plan that is returned was solved for.
pub(crate) fn land_chain(
    mut aim: Aim,
    chain: &mut Chain,
    first: Attempt,
    mut recorded: impl FnMut(&Chain, &Attempt) -> Option<Trajectory>,
    is_rough: &dyn Fn(&Attempt) -> bool,
    mut solve: impl FnMut(&Chain, &Attempt, f64) -> Option<Attempt>,
) -> Option<Landed> {
    let mut best: Option<Landed> = None;
    let mut attempt = first;
    // The maneuver that the present plan was solved for, and the best one, where constraints are drawn in.
    let (mut drawn, mut drawn_of_best) = (None, None);
    loop {
        let aimed = aim.target;
        let Some(plan) = recorded(chain, &attempt) else { break };
        if best.as_ref().is_some_and(|best| is_rough(&best.attempt)) {
            // What a rough plan misses says little about what the same plan does, solved to the end.
            aim.begin_again();
        }
        let next = aim.correct(&plan);
        if next == Next::GiveUp && best.is_some() {
            // The one before was the better one.
            break;
        }
        drawn_of_best.clone_from(&drawn);
        best = Some(Landed { attempt: attempt.clone(), target: aimed, landing: aim.told() });
        let goes_on = next == Next::Correct || next == Next::Landed && is_rough(&attempt);
        let Some(drawn_in) = aim.drawn_in().filter(|_| goes_on) else { break };
        chain.model.aim(&aim.target);
        if aim.changes_constraints() {
            chain.rows = LimitRows::of(&drawn_in, &chain.model);
            drawn = Some(drawn_in);
        }
        let Some(again) = solve(chain, &attempt, aim.best) else { break };
        attempt = again;
    }
    let mut best = best?;
    chain.model.aim(&best.target);
    if is_rough(&best.attempt) {
        // Corrections ended before the plan was solved to the end.
        let drawn = drawn_of_best.as_ref().unwrap_or(aim.problem());
        chain.rows = LimitRows::of(drawn, &chain.model);
        best.attempt = solve(chain, &best.attempt, 0.0).unwrap_or(best.attempt);
    }
    Some(best)
}
