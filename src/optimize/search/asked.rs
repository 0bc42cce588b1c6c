//! The way round that is asked for, and how far what was found is from it.
//!
//! # When does a saddle stand, and when the wrong way round?
//!
//! A plan by `best`, `shortest` or `long` that has a conjugate point on the requested grid is
//! descended from there, up to three times in a row; only where that finds nothing lower does the
//! saddle stand, and the summary, the status and `second_order` in the plan file say so. `shortest`
//! and `long` are each the cheapest of their sense: from rest to rest, where a body can do all,
//! that is what Newton meets first, elsewhere starts of that sense are descended from as for
//! `best`. `as_given` is taken as written, saddle or not, since a lower plan of its class may turn
//! less; only where torques about an axis are missing does a rotation of less than half a turn,
//! from rest to rest, mean no more than `shortest`. A plan that goes round in the other class of
//! rotations than was asked for is not solved: the solution says which way the nearest one goes.
//! Classes are told on the double cover, against the motion without inputs.

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

/// An extremal of one grid that ends so near its target on another \[rad\] goes the same way there.
const NEAR: f64 = 0.2;
/// How much farther from a rotation that is given all paths of the other class are than those of
/// its own: more turns than a path has.
const OTHER_CLASS: f64 = 1e6;
/// A path that is farther from the one asked for goes another way round.
pub(super) const ASTRAY: f64 = 1.0;

/// Whether a solution goes the way that was asked for, and no cheaper one is near it. A rotation
/// that is given is taken as written: that may be a saddle. So may be what is not to be tested.
pub(super) fn satisfies<const N: usize>(search: &Search<N>, solution: &Solution) -> bool {
    let untested = !search.context.settings.test_second_order;
    let minimal = untested || solution.optimality.conjugate_points == Some(0);
    let given = matches!(search.problem.path, Path::AsGiven(_));
    solution.outcome == Outcome::Converged && (minimal || given) && goes_as_asked(search, solution)
}

pub(super) fn goes_as_asked<const N: usize>(search: &Search<N>, solution: &Solution) -> bool {
    asked_sense(search).is_none_or(|sense| sense == solution.sense)
}

/// The sense that was asked for.
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

/// A solution that counts as converged only if it goes the way round that was asked for.
pub(super) fn held_to_its_way<const N: usize>(search: &Search<N>, mut solution: Solution) -> Solution {
    if solution.outcome == Outcome::Converged && !goes_as_asked(search, &solution) {
        let (short, turned_deg) = (solution.sense == Sense::Short, solution.turned_deg);
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(Shortfall::OtherWay { short, turned_deg });
    }
    solution
}

/// A solution that counts as converged only where it goes the way that was asked for, and ends
/// where it should.
pub(super) fn held_to_all<const N: usize>(search: &Search<N>, solution: Solution) -> Solution {
    held_to(search.context.settings.tolerance, held_to_its_way(search, solution))
}

/// The grid that an extremal is told on: the coarse one, unless its costates lead elsewhere there.
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

/// How a candidate goes round.
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

/// How far a path is from what was asked for: the wrong sense, or another rotation than the given.
pub(super) fn astray<const N: usize>(search: &Search<N>, found: &Attempt) -> f64 {
    let way = || way(search, &found.candidate);
    match search.problem.path {
        Path::Best => 0.0,
        Path::Shortest => f64::from(u8::from(way().sense != Sense::Short)),
        Path::Long => f64::from(u8::from(way().sense != Sense::Long)),
        // In full turns, to a thousandth; a path of the other class is another way whatever it
        // turns by.
        Path::AsGiven(rotation) => {
            let way = way();
            let other = asked_sense(search).is_some_and(|sense| sense != way.sense);
            f64::from(u8::from(other)) * OTHER_CLASS
                + ((way.rotation - rotation).norm() / TAU * 1e3).round() / 1e3
        }
    }
}

/// The nearest to what was asked for first, of these the lowest cost.
pub(super) fn ranked<const N: usize>(search: &Search<N>, found: Vec<Attempt>) -> Vec<Attempt> {
    let several = found.len() > 1;
    let mut keyed: Vec<(f64, Attempt)> =
        found.into_iter().map(|found| (if several { astray(search, &found) } else { 0.0 }, found)).collect();
    keyed.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.cost.total_cmp(&y.cost)));
    keyed.into_iter().map(|(_, found)| found).collect()
}

/// A solution that counts as converged only where its terminal error, replayed from the start, is
/// within the tolerance.
pub(super) fn held_to(tolerance: f64, mut solution: Solution) -> Solution {
    let met = solution.terminal.largest() <= tolerance;
    if solution.outcome == Outcome::Converged && !met {
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(Shortfall::Missed { error: solution.terminal.largest(), tolerance });
    }
    solution
}

/// Whether a path goes the way round that is asked for; short where there is nothing to tell the
/// senses by.
pub(super) fn goes_round_as_asked<const N: usize>(search: &Search<N>, path: &Candidate) -> bool {
    let sense = || sense_of(&search.fine, path).unwrap_or(Sense::Short);
    asked_sense(search).is_none_or(|asked| asked == sense())
}

/// The sense that is asked for, where any path of it will do.
pub(super) fn asked_for_a_sense<const N: usize>(search: &Search<N>) -> Option<Sense> {
    match search.problem.path {
        Path::Shortest => Some(Sense::Short),
        Path::Long => Some(Sense::Long),
        Path::Best | Path::AsGiven(_) => None,
    }
}

/// Whether a path is of that sense, or there is nothing to tell the senses by.
pub(super) fn is_of_the_sense<const N: usize>(search: &Search<N>, path: &Candidate) -> bool {
    let is = |asked: Sense| sense_of(&search.coarse, path).is_none_or(|sense| sense == asked);
    asked_for_a_sense(search).is_none_or(is)
}

/// The sense of a path from node to node; none where the motion without inputs cannot be followed
/// to its end.
fn sense_of<const N: usize>(bvp: &BoundaryValueProblem<N>, path: &Candidate) -> Option<Sense> {
    let mut follower = Follower::new();
    path.states.iter().for_each(|node| follower.node(&node.attitude.value, Vector3::zeros(), 0.0));
    follower.way(bvp).ok().map(|way| way.sense)
}

/// The lowest cost of some attempts that go as asked.
pub(super) fn lowest<const N: usize>(search: &Search<N>, attempts: &[Attempt]) -> f64 {
    let right = attempts.iter().filter(|attempt| astray(search, attempt) < ASTRAY);
    right.map(|attempt| attempt.cost).fold(f64::INFINITY, f64::min)
}
