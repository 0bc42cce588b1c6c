//! Landing of a plan of the chain: the chain is solved again for the shifted target and the
//! tightened constraints, with a warm start from the previous correction.

use super::{Aim, Next};
use crate::maneuver::problem::State;
use crate::maneuver::solution::{Landing, Trajectory};
use crate::optimize::chain::Chain;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::methods::method::Attempt;

/// Plan of the chain whose true motion has the smallest miss that the corrections reached.
pub(crate) struct Landed {
    pub attempt: Attempt,
    pub target: State,
    pub landing: Landing,
}

/// Lands a plan of the chain, starting from the attempt `first` and the target in `aim`.
///
/// `recorded` converts an attempt to a plan. `solve` solves the chain for the current target with a
/// warm start from an attempt; its last argument is the size of the miss. Each of the two returns
/// `None` if it fails. On return `chain` has the target for which the returned plan was solved.
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
            // The previous attempt had the smaller miss.
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
