//! Landing a plan of the chain: solved again, warm from what the correction before left, towards
//! the shifted target and within constraints that are drawn in.

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
/// `recorded` gives the plan that an attempt is, and `solve` solves again, warm, from an attempt on
/// the chain that is aimed, after a miss of such a size: `None` where either cannot. `chain` is
/// left aimed at what the plan that is returned was solved for.
pub(crate) fn land_chain(
    mut aim: Aim,
    chain: &mut Chain,
    first: Attempt,
    mut recorded: impl FnMut(&Chain, &Attempt) -> Option<Trajectory>,
    mut solve: impl FnMut(&Chain, &Attempt, f64) -> Option<Attempt>,
) -> Option<Landed> {
    let mut best: Option<Landed> = None;
    let mut attempt = first;
    loop {
        let aimed = aim.target;
        let Some(plan) = recorded(chain, &attempt) else { break };
        let next = aim.correct(&plan);
        if next == Next::GiveUp && best.is_some() {
            // The one before was the better one.
            break;
        }
        best = Some(Landed { attempt: attempt.clone(), target: aimed, landing: aim.told() });
        let Some(drawn_in) = aim.drawn_in().filter(|_| next == Next::Correct) else { break };
        chain.model.aim(&aim.target);
        if aim.changes_constraints() {
            chain.rows = LimitRows::of(&drawn_in, &chain.model);
        }
        let Some(again) = solve(chain, &attempt, aim.best) else { break };
        attempt = again;
    }
    let best = best?;
    chain.model.aim(&best.target);
    Some(best)
}
