//! Strategy for the maneuver without limits after a saddle, a result in the other homotopy class,
//! or no result.

use crate::maneuver::problem::Path;
use crate::maneuver::settings::Method;
use crate::maneuver::solution::Solution;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::search::asked::satisfies;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::record::answer::conclude;
use crate::optimize::search::starts::paths;
use crate::optimize::search::strategies::descents::descents;
use crate::optimize::search::strategies::extremals::carry_extremals;
use crate::optimize::search::strategies::requested::{MOST_STEPS, descend_on_requested_grid};

/// Largest number of successive saddles from which a descent is made.
const MOST_SADDLES: usize = 3;

/// Finds minima near a saddle, and descends from initial paths if earlier strategies did not.
pub struct Further;

impl<const N: usize> Climb<N> for Further {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        search.is_free() && !found.is_guessed()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let solution = conclude(search, found);
        let enough = search.stopped() || satisfies(search, &solution);
        found.told = Some(if enough { solution } else { look_further(search, found, solution) });
    }
}

/// Tries the remaining methods if the result on the requested grid is a saddle, is in the other
/// homotopy class, or does not exist.
fn look_further<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    mut solution: Solution,
) -> Solution {
    for _ in 0..MOST_SADDLES {
        let saddle = found.best().filter(|_| !matches!(search.problem.path, Path::AsGiven(_)));
        let Some(saddle) = saddle.map(|saddle| saddle.candidate.clone()) else { break };
        if search.stopped() || satisfies(search, &solution) || !leave(search, found, &saddle) {
            break;
        }
        solution = conclude(search, found);
    }
    if !satisfies(search, &solution) && !found.pool.descended && !search.stopped() {
        descents(search, &mut found.pool);
        carry_extremals(search, found);
        solution = conclude(search, found);
    }
    solution
}

/// Descends from a saddle on the requested grid to a minimum. Returns whether that led to another
/// extremal.
fn leave<const N: usize>(search: &Search<N>, found: &mut Found<N>, saddle: &Candidate) -> bool {
    if search.problem.steps > MOST_STEPS {
        return false;
    }
    let known = found.plans().len();
    let path = match saddle.provenance.method {
        Method::Scp | Method::InteriorPoint => Ok(paths::of_states(&search.fine, saddle)),
        _ => paths::of_extremal(&search.fine, saddle),
    };
    if let Ok(path) = path {
        descend_on_requested_grid(search, found, path);
    }
    found.plans().len() > known
}
