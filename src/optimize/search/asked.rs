//! The requested homotopy class, and the deviation of a result from it.
//!
//! # When is a saddle or the other homotopy class a result?
//!
//! A plan for `best`, `shortest` or `long` that has a conjugate point on the requested grid is
//! descended from, up to three times in a row. Only if that finds nothing cheaper is the saddle
//! returned, and the summary, the status and `second_order` in the plan file report it. `shortest`
//! and `long` are each the cheapest plan of their class. From rest to rest, for a fully actuated
//! body, that is the first result of Newton; otherwise starts of that class are descended from as
//! for `best`. `as_given` is used as written, saddle or not, since a cheaper plan of its class may
//! turn less. Only if torques about an axis are missing does a rotation of less than half a turn,
//! from rest to rest, mean no more than `shortest`. A plan in the other homotopy class than
//! requested does not count as solved; the solution states the class of the nearest plan. Classes
//! are determined on the double cover, relative to the motion without inputs.

use crate::Vector3;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Sense, Solution};
use crate::optimize::chain::body_rates;
use crate::optimize::chain::model::Model;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::way::{Follower, Way};
use std::f64::consts::TAU;

/// Largest attitude error at the end of the coarse grid \[rad\] with which the costates of a fine
/// extremal are taken to lead to the same homotopy class on the coarse grid.
const NEAR: f64 = 0.2;
/// Deviation that is added if a path is in the other homotopy class than the requested one: larger
/// than the number of full turns of any path.
const OTHER_CLASS: f64 = 1e6;
/// Deviation from which a path does not count as the requested one.
pub(super) const ASTRAY: f64 = 1.0;

/// Returns whether a solution converged, is in the requested homotopy class and has no conjugate
/// point. Conjugate points are accepted if a rotation is given, or if the second-order test is
/// disabled.
pub(super) fn satisfies<const N: usize>(search: &Search<N>, solution: &Solution) -> bool {
    let untested = !search.context.settings.test_second_order;
    let minimal = untested || solution.optimality.conjugate_points == Some(0);
    let given = matches!(search.problem.path, Path::AsGiven(_));
    solution.outcome == Outcome::Converged && (minimal || given) && goes_as_asked(search, solution)
}

pub(super) fn goes_as_asked<const N: usize>(search: &Search<N>, solution: &Solution) -> bool {
    asked_sense(search).is_none_or(|sense| sense == solution.sense)
}

/// Returns the requested homotopy class; `None` if the best path of any class is requested.
pub(super) fn asked_sense<const N: usize>(search: &Search<N>) -> Option<Sense> {
    match search.problem.path {
        Path::Best => None,
        Path::Shortest => Some(Sense::Short),
        Path::Long => Some(Sense::Long),
        Path::AsGiven(rotation) => {
            let path = Follower::begun(&search.problem.start.attitude).turned_by(&rotation);
            path.way(&search.coarse).ok().map(|way| way.sense)
        }
    }
}

/// Marks a solution as stalled if it is not in the requested homotopy class.
pub(super) fn held_to_its_way<const N: usize>(search: &Search<N>, mut solution: Solution) -> Solution {
    if solution.outcome == Outcome::Converged && !goes_as_asked(search, &solution) {
        let (short, turned_deg) = (solution.sense == Sense::Short, solution.turned_deg);
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(Shortfall::OtherWay { short, turned_deg });
    }
    solution
}

/// Marks a solution as stalled if it is not in the requested homotopy class or if its terminal
/// error exceeds the tolerance.
pub(super) fn held_to_all<const N: usize>(search: &Search<N>, solution: Solution) -> Solution {
    held_to(search.context.settings.tolerance, held_to_its_way(search, solution))
}

/// Returns the grid on which the homotopy class of an extremal is determined: the coarse grid,
/// unless the costates of a fine extremal miss the target on it.
pub(super) fn told_on<'s, 'a, const N: usize>(
    search: &'s Search<'a, '_, N>,
    candidate: &Candidate,
) -> &'s BoundaryValueProblem<'a, N> {
    let [coarse, fine] = [&search.coarse, &search.fine].map(|bvp| bvp.dynamics.grid.steps());
    let is_fine = candidate.steps() == fine && fine != coarse;
    let near = || {
        Follower::of(&search.coarse, &candidate.costate()).is_ok_and(|path| path.miss(&search.coarse) < NEAR)
    };
    if is_fine && !near() { &search.fine } else { &search.coarse }
}

/// Returns the homotopy class of a candidate, with its angle and rotation vector; the short class
/// and NaN if they cannot be determined.
pub(super) fn way<const N: usize>(search: &Search<N>, candidate: &Candidate) -> Way {
    let way = match candidate.provenance.method {
        Road::Scp | Road::InteriorPoint => {
            let mut path = Follower::new();
            let model = Model::new(search.problem, candidate.steps());
            for (attitude, rate) in body_rates(&model, candidate) {
                path.node(&attitude, rate, model.h);
            }
            Ok(path.way_or_short(&search.fine))
        }
        _ => {
            let bvp = told_on(search, candidate);
            Follower::of(bvp, &candidate.costate()).map(|path| path.way_or_short(bvp))
        }
    };
    let (turned_deg, rotation) = (f64::NAN, Vector3::repeat(f64::NAN));
    way.unwrap_or(Way { sense: Sense::Short, turned_deg, rotation })
}

/// Returns the deviation of a path from the request: 1 for the other homotopy class than the
/// requested one. If a rotation is given, returns the distance to it in full turns.
pub(super) fn astray<const N: usize>(search: &Search<N>, found: &Attempt) -> f64 {
    let way = || way(search, &found.candidate);
    match search.problem.path {
        Path::Best => 0.0,
        Path::Shortest => f64::from(u8::from(way().sense != Sense::Short)),
        Path::Long => f64::from(u8::from(way().sense != Sense::Long)),
        // In full turns, rounded to a thousandth. A path of the other class deviates more than any
        // other.
        Path::AsGiven(rotation) => {
            let way = way();
            let other = asked_sense(search).is_some_and(|sense| sense != way.sense);
            f64::from(u8::from(other)) * OTHER_CLASS
                + ((way.rotation - rotation).norm() / TAU * 1e3).round() / 1e3
        }
    }
}

/// Sorts attempts by their deviation from the request, then by cost.
pub(super) fn ranked<const N: usize>(search: &Search<N>, found: Vec<Attempt>) -> Vec<Attempt> {
    let several = found.len() > 1;
    let mut keyed: Vec<(f64, Attempt)> =
        found.into_iter().map(|found| (if several { astray(search, &found) } else { 0.0 }, found)).collect();
    keyed.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cost.total_cmp(&y.cost)));
    keyed.into_iter().map(|(_, found)| found).collect()
}

/// Marks a solution as stalled if its terminal error, replayed from the start, exceeds the
/// tolerance.
pub(super) fn held_to(tolerance: f64, mut solution: Solution) -> Solution {
    let met = solution.terminal.largest() <= tolerance;
    if solution.outcome == Outcome::Converged && !met {
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(Shortfall::Missed { error: solution.terminal.largest(), tolerance });
    }
    solution
}

/// Returns whether a path is in the requested homotopy class. A path whose class cannot be
/// determined counts as short.
pub(super) fn goes_round_as_asked<const N: usize>(search: &Search<N>, path: &Candidate) -> bool {
    let sense = || sense_of(&search.fine, path).unwrap_or(Sense::Short);
    asked_sense(search).is_none_or(|asked| asked == sense())
}

/// Returns the requested homotopy class if any path in the class is acceptable; `None` if the best
/// path or a given rotation is requested.
pub(super) fn asked_for_a_sense<const N: usize>(search: &Search<N>) -> Option<Sense> {
    match search.problem.path {
        Path::Shortest => Some(Sense::Short),
        Path::Long => Some(Sense::Long),
        Path::Best | Path::AsGiven(_) => None,
    }
}

/// Returns `true` if a path is in the requested homotopy class, if its class cannot be determined,
/// or if no class is requested.
pub(super) fn is_of_the_sense<const N: usize>(search: &Search<N>, path: &Candidate) -> bool {
    let is = |asked: Sense| sense_of(&search.coarse, path).is_none_or(|sense| sense == asked);
    asked_for_a_sense(search).is_none_or(is)
}

/// Returns the homotopy class of a path given by its nodes; `None` if the motion without inputs
/// cannot be computed to its end.
fn sense_of<const N: usize>(bvp: &BoundaryValueProblem<N>, path: &Candidate) -> Option<Sense> {
    let mut follower = Follower::new();
    path.states.iter().for_each(|node| follower.node(&node.attitude.value, Vector3::zeros(), 0.0));
    follower.way(bvp).ok().map(|way| way.sense)
}

/// Returns the lowest cost of the attempts that match the request.
pub(super) fn lowest<const N: usize>(search: &Search<N>, attempts: &[Attempt]) -> f64 {
    let right = attempts.iter().filter(|attempt| astray(search, attempt) < ASTRAY);
    right.map(|attempt| attempt.cost).fold(f64::INFINITY, f64::min)
}
