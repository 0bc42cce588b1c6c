//! Strategy for the maneuver without limits: ballistic starts, descents on paths, and the lifted
//! Newton method.
//!
//! All extremals are searched for on a coarse grid. Costs there are wrong by some percent at high
//! rates, so that their order may be wrong. Every extremal that may be the cheapest is transferred
//! to the requested grid, and compared there.
//!
//! # How is the best homotopy class found?
//!
//! An extremal of the coarse grid was lost if its cost on the requested grid differs by more than
//! 15 %, or if its nodes there deviate by a radian from its path. (With costs alone, one extremal
//! could be mistaken for another.) A descent from its path is then made on the requested grid.

use crate::lie;
use crate::maneuver::problem::Path;
use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::Node;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::search::asked::{ASTRAY, asked_for_a_sense, astray, lowest, ranked};
use crate::optimize::search::found::{Found, cheapest_first};
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::pool::Pool;
use crate::optimize::search::starts::families::{Starts, most_minima};
use crate::optimize::search::starts::{self, paths};
use crate::optimize::search::strategies::descents::{MARGIN, descents};
use crate::optimize::search::strategies::requested::{MOST_STEPS, descend_on_requested_grid};
use crate::optimize::search::strategies::shots::{finish, shoot};

/// Largest distance between corresponding nodes of one extremal on two grids \[rad\]. On the
/// coarsest grid they differ by up to 0.4 rad.
const SAME_PATH: f64 = 1.0;

/// Finds the extremals without limits: those of Newton's method from the ballistic starts, and the
/// minima of descents. If a fully actuated body rests at both ends and the short or the long way is
/// requested, Newton's method alone is used, unless the search is thorough.
pub struct Extremals;

impl<const N: usize> Climb<N> for Extremals {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        search.is_free() && !found.is_guessed()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let pool = &mut found.pool;
        ballistic(search, pool);
        let sense = asked_for_a_sense(search).is_some();
        let wide = || Starts::of(search.problem, &search.coarse, search.context.settings.search).is_wide();
        if search.problem.path == Path::Best || !is_as_asked(search, pool) || sense && wide() {
            descents(search, pool);
        }
        carry_extremals(search, found);
    }
}

/// Returns whether an extremal on the coarse grid is in the requested homotopy class.
fn is_as_asked<const N: usize>(search: &Search<N>, pool: &Pool<N>) -> bool {
    match search.problem.path {
        // The homotopy class is determined on the requested grid, at no additional cost.
        Path::Shortest | Path::Best => !pool.waiting().is_empty(),
        Path::Long | Path::AsGiven(_) => pool.waiting().iter().any(|found| astray(search, found) < ASTRAY),
    }
}

/// Shoots by Newton from the ballistic starts.
fn ballistic<const N: usize>(search: &Search<N>, pool: &mut Pool<N>) {
    for fraction in [1.0, 0.3] {
        let steps = search.coarse.dynamics.grid.steps();
        let has_arrived = |turns: &i32| pool.has_arrived(&starts::name_of(*turns));
        let turns: Vec<i32> = search.turns.iter().copied().filter(|turns| !has_arrived(turns)).collect();
        if turns.is_empty() {
            return;
        }
        match starts::ballistic(&search.coarse, &turns, fraction) {
            Ok(starts) => {
                for start in starts {
                    if !search.stopped() {
                        let _ = shoot(search, pool, Rung::Newton, start);
                    }
                }
            }
            Err(error) => {
                search.context.note(Rung::Newton, "ballistic", steps, Report::failed(outcome_of(error)));
            }
        }
    }
}

/// Transfers the extremals that may be the best to the requested grid. The other extremals remain
/// rivals.
pub fn carry_extremals<const N: usize>(search: &Search<N>, found: &mut Found<N>) {
    let waiting = ranked(search, found.pool.take_waiting());
    let enough = waiting.first().map_or(0.0, |best| best.cost * (1.0 + MARGIN));
    // Newton alone finds one extremal of a homotopy class, descents find several.
    let several = search.problem.path == Path::Best || found.pool.descended;
    let most = most_minima(search.problem);
    for extremal in waiting {
        let near = extremal.cost <= enough || search.coarse.dynamics.grid.steps() == search.problem.steps;
        let hopeful = several && near && found.plans().len() < most;
        if !search.stopped() && (hopeful || !found.is_done()) {
            let path = paths::of_extremal(&search.coarse, &extremal.candidate).ok();
            let near = |fine: &Attempt| is_near(fine, extremal.cost, path.as_ref());
            if !finish(search, found, extremal.candidate.clone(), near)
                && let Some(candidate) = path
            {
                found.pool.lose(Attempt { candidate, ..extremal });
            }
        } else {
            found.pool.rivals.push(extremal);
        }
    }
    on_requested_grid(search, found);
}

/// Descends on the requested grid from the paths that were lost on the transfer, if they may still
/// be the best.
fn on_requested_grid<const N: usize>(search: &Search<N>, found: &mut Found<N>) {
    let lost = found.pool.take_lost();
    if search.problem.steps > MOST_STEPS {
        return;
    }
    for Attempt { candidate, cost, .. } in cheapest_first(lost) {
        let least = lowest(search, found.plans());
        let beaten = cost > least * (1.0 + MARGIN) || matches!(search.problem.path, Path::AsGiven(_));
        if search.stopped() || (beaten && least.is_finite()) {
            return;
        }
        descend_on_requested_grid(search, found, paths::on_grid(&search.fine, &candidate));
    }
}

/// Returns whether a transferred extremal is the same one as on the other grid: its cost may differ
/// by some percent only. If its nodes are kept, they must be near `path`, because another extremal
/// may have a similar cost.
fn is_near(found: &Attempt, cost: f64, path: Option<&Candidate>) -> bool {
    let along = |path: &Candidate, nodes: &[Node]| {
        let (few, many) = (path.steps(), nodes.len() - 1);
        path.states.iter().enumerate().all(|(index, state)| {
            let other = &nodes[(index * many + few / 2) / few].point;
            lie::minus(&other.attitude.value, &state.attitude.value).norm() < SAME_PATH
        })
    };
    let kept = path.zip(found.swept.as_ref());
    (found.cost - cost).abs() <= MARGIN * cost && kept.is_none_or(|(path, swept)| along(path, &swept.nodes))
}
