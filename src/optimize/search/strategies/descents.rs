//! Descents on paths: minima on the coarse grid, which are converted to extremals there.
//!
//! # How is the best homotopy class found?
//!
//! The lifted Newton method also transfers a minimum of an unstable body, for which single shooting
//! amplifies errors. The coarse grid resolves how fast a field may swing the body, and not only the
//! requested turn: on 32 steps the cheapest plan of a stiff pendulum does not exist. No number of
//! starts proves that the lowest cost found is the global minimum; how often it is the best known
//! one is measured (`cargo run --release -p evidence -- families`).

use crate::Vector3;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Dynamics;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::descent::Descent;
use crate::optimize::methods::lifted::LiftedNewton;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::asked::{is_of_the_sense, lowest};
use crate::optimize::search::ladder::Search;
use crate::optimize::search::pool::Pool;
use crate::optimize::search::starts::coarse::rough_grid;
use crate::optimize::search::starts::families::{Starts, most_minima};
use crate::optimize::search::starts::paths;
use crate::optimize::search::strategies::authority::Authority;
use crate::optimize::search::strategies::minima::{Minima, SAME_MINIMUM};
use crate::optimize::search::strategies::shots::shoot;

/// Tolerance of the lifted Newton method, whose result shooting polishes.
pub const LIFTED_TOLERANCE: f64 = 1e-10;
/// Predicted relative decrease of the cost at which a descent on the coarse grid ends.
const DESCENT_TOLERANCE: f64 = 1e-9;
/// Relative excess over the cheapest cost on the coarse grid up to which a minimum may become the
/// cheapest on the requested grid.
pub const MARGIN: f64 = 0.15;
/// Number of starts without a lower minimum after which a search that has done half of its starts
/// ends, unless it is thorough.
const IDLE: usize = 20;
/// Relative cost difference below which a minimum and an extremal on one grid belong to the same
/// branch.
pub const SAME_BRANCH: f64 = 1e-4;
/// Relative cost difference below which a minimum and an extremal belong to the same branch when
/// the last additional authority is removed.
pub const NARROW: f64 = 0.02;
/// Largest number of times that the authority of a minimum is reduced, summed over all minima and
/// levels.
const MOST_BRANCHES: usize = 100;
/// Number of the lowest minima from which paths with additional turns and hops start.
const LOWEST: usize = 4;
/// Sizes of the random bends of a hop \[rad\].
const HOPS_BY: [f64; 2] = [0.4, 1.0];
/// Largest total number of hops, as a multiple of the number of successive unsuccessful hops after
/// which the search ends.
const MOST_HOPS: usize = 10;
/// Largest number of minima to which turns about the axis of the smallest moment are added.
const MOST_TWISTED: usize = 40;
/// Largest number of paths on which the lifted Newton method is tried directly.
const MOST_LIFTED: usize = 2;
/// Relative excess over the cheapest cost on the coarse grid up to which a minimum on a rougher
/// grid is followed.
const ROUGH_MARGIN: f64 = 0.5;

/// Descends from all starts, and converts the cheapest minima to extremals on the coarse grid.
pub fn descents<const N: usize>(search: &Search<N>, pool: &mut Pool<N>) {
    pool.descended = true;
    let coarse = search.coarse.clone();
    let starts = Starts::of(search.problem, &coarse, search.context.settings.search);
    let authority = Authority::of(&coarse.dynamics);
    let given = matches!(search.problem.path, Path::AsGiven(_));
    let nothing = lowest(search, pool.waiting()).is_infinite();
    if given || nothing || authority == Authority::Missing {
        lift(search, pool, &coarse, starts.paths(&coarse));
    }
    let mut minima = Minima::default();
    if authority == Authority::Even {
        minima = minima_from(search, pool, &coarse, &starts, 0);
    } else {
        let rough = search.fine.on_steps(rough_grid(search.problem, &coarse)).heard_by(search.context);
        let last = authority.levels().len() - 1;
        let wide = authority == Authority::Missing || starts.hops > 0;
        let levels = [(0, wide), (last, authority == Authority::Uneven)];
        let mut open = Vec::new();
        for (level, _) in levels.into_iter().filter(|(_, wanted)| *wanted) {
            let minima = minima_from(search, pool, &rough, &starts, level).0;
            open.extend(minima.into_iter().map(|minimum| (level, minimum)));
        }
        narrow(search, pool, &coarse, open, &mut minima);
    }
    let margin = if given { f64::INFINITY } else { MARGIN };
    let enough = minima.0.first().map_or(f64::INFINITY, |best| best.cost * (1.0 + margin));
    let most = most_minima(search.problem);
    for minimum in minima.0.into_iter().take_while(|minimum| minimum.cost <= enough).take(most) {
        if !search.stopped() {
            arrive(search, pool, &coarse, minimum);
        }
    }
}

/// Descends from all starts with the authority of a level, and returns the minima.
fn minima_from<const N: usize>(
    search: &Search<N>,
    pool: &Pool<N>,
    coarse: &BoundaryValueProblem<N>,
    starts: &Starts,
    level: usize,
) -> Minima {
    let wide = descends_on(&coarse.dynamics, level);
    let mut minima = Minima::default();
    let known = pool.waiting().iter().filter_map(|found| {
        let path = paths::of_extremal(&search.coarse, &found.candidate).ok()?;
        Some(if path.steps() == coarse.dynamics.grid.steps() { path } else { paths::on_grid(coarse, &path) })
    });
    let all = known.chain(starts.paths(coarse)).filter(|path| is_of_the_sense(search, path));
    let all: Vec<Candidate> = all.collect();
    let most = all.len();
    let patient = search.context.settings.search == Thoroughness::Thorough || starts.hops > 0;
    let mut idle = 0;
    for (done, start) in all.into_iter().enumerate() {
        if search.stopped() || (!patient && idle >= IDLE && 2 * done >= most) {
            break;
        }
        let minimum = descended(search, coarse, &wide, start, DESCENT_TOLERANCE, &minima.0);
        let place = is_of_the_sense(search, &minimum.candidate).then(|| minima.add(minimum)).flatten();
        idle = if place == Some(0) { 0 } else { idle + 1 };
    }
    if let Some(axis) = &starts.twist {
        twist(search, coarse, &wide, &mut minima, axis);
    }
    hop(search, coarse, &wide, &mut minima, starts.hops);
    minima
}

/// Descends from the lowest minima with one turn more and one turn fewer about the axis of the
/// smallest moment of inertia, until all of the lowest have been tried.
fn twist<const N: usize>(
    search: &Search<N>,
    coarse: &BoundaryValueProblem<N>,
    wide: &Dynamics,
    minima: &mut Minima,
    axis: &Vector3,
) {
    let mut tried: Vec<f64> = Vec::new();
    while tried.len() < MOST_TWISTED && !search.stopped() {
        let is_tried = |cost: f64| tried.iter().any(|other| (other - cost).abs() <= SAME_MINIMUM * cost);
        let next = minima.0.iter().take(LOWEST).find(|minimum| !is_tried(minimum.cost));
        let Some(from) = next else { return };
        tried.push(from.cost);
        let starts = [1, -1].map(|turns| paths::twisted(coarse, &from.candidate, axis, turns));
        for start in starts {
            let minimum = descended(search, coarse, wide, start, DESCENT_TOLERANCE, &minima.0);
            if is_of_the_sense(search, &minimum.candidate) {
                minima.add(minimum);
            }
        }
    }
}

/// Hops from the lowest minima to others near them by random bends and further descents. If there
/// are many minima, the lowest are close together, and are found sooner from one another than from
/// distant starts.
fn hop<const N: usize>(
    search: &Search<N>,
    coarse: &BoundaryValueProblem<N>,
    wide: &Dynamics,
    minima: &mut Minima,
    patience: usize,
) {
    let mut bends = paths::Bends::new();
    let (mut idle, mut hops) = (0, 0);
    while idle < patience && hops < MOST_HOPS * patience && !search.stopped() {
        let Some(from) = minima.0.get(hops % LOWEST.min(minima.0.len().max(1))) else { return };
        let by = HOPS_BY[hops / LOWEST % HOPS_BY.len()];
        let start = paths::bent_at_random(coarse, &from.candidate, &mut bends, by);
        let minimum = descended(search, coarse, wide, start, DESCENT_TOLERANCE, &minima.0);
        let place = is_of_the_sense(search, &minimum.candidate).then(|| minima.add(minimum)).flatten();
        idle = if place.is_some_and(|place| place < LOWEST) { 0 } else { idle + 1 };
        hops += 1;
    }
}

/// Finds extremals by the lifted Newton method from the first of the paths, including saddles.
fn lift<const N: usize>(
    search: &Search<N>,
    pool: &mut Pool<N>,
    coarse: &BoundaryValueProblem<N>,
    paths: Vec<Candidate>,
) {
    let (start, target) = (&coarse.start, coarse.terminal.target());
    let level = if coarse.dynamics.has_all_axes() { usize::MAX } else { 0 };
    let dynamics = descends_on(&coarse.dynamics, level);
    let (tolerance, known) = (0.0, &[][..]);
    let descent = Descent { dynamics: &dynamics, start, target, translates: N == 12, tolerance, known };
    for path in paths.into_iter().take(MOST_LIFTED) {
        if search.stopped() {
            return;
        }
        if let Some(nodes) = descent.lifted(path) {
            let _ = lift_nodes(search, pool, coarse, nodes);
        }
    }
}

/// Returns the dynamics that descents use at a level of additional authority.
pub fn descends_on(dynamics: &Dynamics, level: usize) -> Dynamics {
    let levels = Authority::of(dynamics).levels();
    match levels[level.min(levels.len() - 1)] {
        0.0 => dynamics.clone(),
        more => dynamics.widened(more),
    }
}

/// Descends from a path, with dynamics that may have more authority than those of `bvp`. The
/// descent ends early if it approaches one of the `known` minima of these dynamics.
pub fn descended<const N: usize>(
    search: &Search<N>,
    bvp: &BoundaryValueProblem<N>,
    dynamics: &Dynamics,
    start: Candidate,
    tolerance: f64,
    known: &[Attempt],
) -> Attempt {
    let (start_point, target) = (&bvp.start, bvp.terminal.target());
    let translates = N == 12;
    let descent = Descent { dynamics, start: start_point, target, translates, tolerance, known };
    search.context.attempt(Rung::Descent, &descent, start)
}

/// Converts a minimum on the coarse grid to its extremal there: by shooting, or by the lifted
/// Newton method if shooting fails, as for unstable bodies.
fn arrive<const N: usize>(
    search: &Search<N>,
    pool: &mut Pool<N>,
    coarse: &BoundaryValueProblem<N>,
    minimum: Attempt,
) {
    let near = |cost: f64| (cost - minimum.cost).abs() <= SAME_BRANCH * minimum.cost;
    let (path, rung) = (&minimum.candidate, Rung::Descent);
    if !shoot(search, pool, rung, path.clone()).is_some_and(near)
        && !lift_nodes(search, pool, coarse, path.clone()).is_some_and(near)
    {
        pool.lose(minimum);
    }
}

/// Follows minima with widened authority to the true authority, always the lowest first. A
/// reduction of the authority only increases the cost of a branch; a branch that costs more than a
/// plan already found is therefore not followed. Minima on a rougher grid are first transferred to
/// the coarse one. If every axis has some authority, the resulting minima are added to `ended`.
fn narrow<const N: usize>(
    search: &Search<N>,
    pool: &mut Pool<N>,
    coarse: &BoundaryValueProblem<N>,
    mut open: Vec<(usize, Attempt)>,
    ended: &mut Minima,
) {
    let authority = Authority::of(&coarse.dynamics);
    let last = authority.levels().len() - 1;
    let given = matches!(search.problem.path, Path::AsGiven(_));
    for _ in 0..MOST_BRANCHES {
        let next = open.iter().enumerate().min_by(|(_, (_, a)), (_, (_, b))| a.cost.total_cmp(&b.cost));
        let Some(next) = next.map(|(index, _)| index) else { return };
        if search.stopped() {
            return;
        }
        let (level, minimum) = open.swap_remove(next);
        let rough = minimum.candidate.steps() != coarse.dynamics.grid.steps();
        let margin = if rough { ROUGH_MARGIN } else { MARGIN };
        let found =
            ended.0.first().map_or(f64::INFINITY, |best| best.cost).min(lowest(search, pool.waiting()));
        if !given && minimum.cost > found * (1.0 + margin) {
            continue;
        }
        // With little authority left to remove, the true extremal is within Newton's region of
        // convergence.
        let near = |cost: f64| (cost - minimum.cost).abs() <= NARROW * cost;
        if authority == Authority::Missing
            && !rough
            && level > 0
            && lift_nodes(search, pool, coarse, minimum.candidate.clone()).is_some_and(near)
        {
            continue;
        }
        if level == last && !rough {
            // A valley that is too long for one descent is followed further on the requested grid.
            if authority == Authority::Missing || !minimum.converged() {
                pool.lose(minimum);
            } else {
                ended.add(minimum);
            }
            continue;
        }
        let (level, start) = if rough {
            (level, paths::on_grid(coarse, &minimum.candidate))
        } else {
            (level + 1, minimum.candidate)
        };
        let wide = descends_on(&coarse.dynamics, level);
        let next = descended(search, coarse, &wide, start, DESCENT_TOLERANCE, &[]);
        let same = |(at, other): &(usize, Attempt)| {
            *at == level
                && other.candidate.steps() == next.candidate.steps()
                && (other.cost - next.cost).abs() <= SAME_MINIMUM * next.cost
        };
        if !open.iter().any(same) && next.cost.is_finite() && is_of_the_sense(search, &next.candidate) {
            open.push((level, next));
        }
    }
}

/// Applies the lifted Newton method to the states and costates of all nodes, then shooting. Returns
/// the cost of the extremal; `None` if one of the two methods does not converge.
fn lift_nodes<const N: usize>(
    search: &Search<N>,
    pool: &mut Pool<N>,
    coarse: &BoundaryValueProblem<N>,
    nodes: Candidate,
) -> Option<f64> {
    let newton = LiftedNewton { bvp: coarse, tolerance: LIFTED_TOLERANCE, patience: 1 };
    let lifted = search.context.attempt(Rung::Lifted, &newton, nodes);
    if lifted.converged() { shoot(search, pool, Rung::Lifted, lifted.candidate) } else { None }
}
