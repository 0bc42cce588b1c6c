//! The rung of the maneuver without limits: ballistic starts, descents on paths, the lifted Newton.
//!
//! All extremals are looked for on a coarse grid. Costs there are wrong by some percent at high
//! rates and then rank wrongly: every one that may be the cheapest is carried to the requested
//! grid, and compared there.
//!
//! # How is the best way found?
//!
//! An extremal of the coarse grid whose cost on the requested one differs by more than 15 %, or
//! whose nodes there are a radian off its path, was lost on the way (costs alone let one extremal
//! pass for another); its path is descended again there.

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

/// Nodes of one extremal on two grids are nearer than this \[rad\]; on the coarsest they differ by
/// up to 0.4.
const SAME_PATH: f64 = 1.0;

/// The extremals without limits: those that Newton meets from the ballistic starts, and the minima
/// that descents end at. The shorter and the longer way of a body that rests at both ends, and can
/// do all, are each what Newton meets, unless the search is to be thorough.
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

/// Whether an extremal on the coarse grid goes the way that was asked for.
fn is_as_asked<const N: usize>(search: &Search<N>, pool: &Pool<N>) -> bool {
    match search.problem.path {
        // Told on the requested grid, where it costs nothing more.
        Path::Shortest | Path::Best => !pool.waiting().is_empty(),
        Path::Long | Path::AsGiven(_) => pool.waiting().iter().any(|found| astray(search, found) < ASTRAY),
    }
}

/// Newton shooting from the ballistic starts.
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

/// Carries the extremals that may be the best to the requested grid; the others stay rivals.
pub fn carry_extremals<const N: usize>(search: &Search<N>, found: &mut Found<N>) {
    let waiting = ranked(search, found.pool.take_waiting());
    let enough = waiting.first().map_or(0.0, |best| best.cost * (1.0 + MARGIN));
    // Newton alone finds one extremal of a way round, descents find several.
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

/// The paths that were lost on the way to the requested grid, descended there where they may still
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

/// Whether what an extremal of the cost was carried to is the same one: on another grid it costs
/// some percent more or less, and where the nodes are kept they lie along its path. By its cost
/// alone another one within that could pass for it.
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
