//! Rungs under limits and constraints: SCP, from seeds that the shooting and geometry give, on a coarse grid first.
//!
//! The relaxed maneuver, without limits, is solved by shooting for each sense. Where the best of those
//! meets every limit it is the answer. Otherwise each relaxed path, and its detours around the cones it
//! crosses, seeds a convex iteration on a coarse grid; the cheapest is carried to the requested grid.
//!
//! # Which road does a limited maneuver take?
//!
//! Where only the inputs are limited, by size or by norm, the shooting goes first: from each extremal without limits, Newton
//! goes on with the saturated law (`control_law/saturated`), which costs nothing but a clamp in the kick, and brings costates
//! to round-off and a count of conjugate points. That count comes from the inertia of the accessory problem, because the
//! sensitivity matrix loses rank while all inputs are at their limits. Where the shooting finds nothing, and for all other
//! limits, SCP is taken.
//!
//! There the maneuver without limits is solved first, by shooting, for each sense. If the cheapest of those meets every limit
//! it is the answer. Otherwise each of these paths, and its detours to either side of every cone that it crosses, is a seed of
//! the convex iteration (`scp/`) on a coarse grid. The cheapest result is carried to the requested grid in one leap by Newton
//! alone where that works; where it does not, over grids twice or four times finer each, with the convex iteration behind
//! Newton. The path between the coarse nodes is smooth, and inputs at their limits are those that the interpolated costates
//! ask for. Because limits only make a maneuver costlier, a sense whose path without limits costs more than what is already
//! found is not tried, unless wheels store momentum at the start: without it the body would move otherwise. A guess brings its
//! path as one more seed, the first.

use super::any_attitude;
use super::asked;
use super::coarse::chain_steps;
use super::detour::detours;
use super::found::{Found, cheapest_first, same};
use super::ladder::{Ask, Search};
use super::paths;
use super::transfer::transfer;
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings;
use crate::maneuver::solution::{Rung, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::discrete::candidate::{Candidate, Provenance};
use crate::optimize::discrete::step::{Dynamics, Point};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration, path};

/// Costs of one plan on two grids differ by less, relative.
const NEAR: f64 = 0.05;
/// How far the coarse costs of two plans may lie apart, relative, for both to be carried to the fine grid, and how many are.
pub(super) const CLOSE: f64 = 0.02;
pub(super) const CARRIED: usize = 3;

/// What carries a solution to a finer grid.
#[derive(Clone, Copy)]
enum Road {
    /// Newton's method, which finds the active set of a near grid by itself as a rule.
    Newton,
    /// The convex iteration.
    Convex,
}

/// The extremals of the maneuver without limits, as paths on a coarse grid.
pub(super) fn unlimited_paths<const N: usize>(search: &Search<N>, coarse: &Chain) -> Vec<Candidate> {
    let seeds = relaxed_paths(search, &relaxed(search.problem), coarse);
    if seeds.is_empty() {
        return vec![paths::shortest_way(&coarse.model)];
    }
    seeds.into_iter().map(|(_, seed)| seed).collect()
}

/// Plans of least effort within all limits along paths on the coarse grid, cheapest first: states and inputs to begin
/// from.
pub(super) fn effort_paths<const N: usize>(search: &Search<N>, paths: &[Candidate]) -> Vec<Candidate> {
    let search = search.of(search.problem, Ask::of_goal(None, search.context.settings));
    let mut found = Found::default();
    let coarse = search.chain(chain_steps(search.problem));
    for path in paths {
        for seed in detours(search.problem, path.clone()) {
            if !search.stopped() {
                descend(&search, &mut found, &coarse, seed);
            }
        }
    }
    let of_effort = |Attempt { candidate, .. }: Attempt| Candidate {
        costates: Vec::new(),
        multipliers: Default::default(),
        provenance: Provenance {
            start: format!("least effort, {}", candidate.provenance.start),
            ..candidate.provenance
        },
        ..candidate
    };
    cheapest_first(found.take_plans()).into_iter().map(of_effort).collect()
}

/// The extremals of the relaxed maneuver, with their scaled costs, cheapest first: limits only make them costlier.
pub(super) fn relaxed_paths<const N: usize>(
    search: &Search<N>,
    relaxed: &Problem,
    coarse: &Chain,
) -> Vec<(f64, Candidate)> {
    if search.problem.ends_in_any_attitude() {
        let paths = any_attitude::paths(search.problem, &coarse.model, search.context.settings.search);
        return paths.into_iter().map(|path| (0.0, path)).collect();
    }
    let asked = relaxed.clone().with_steps(coarse.model.steps);
    let search = search.of(&asked, search.ask.of_relaxed());
    let mut found = search.climb();
    let extremals = asked::ranked(&search, found.take_plans());
    let seed = |found: &Attempt, bvp: &BoundaryValueProblem<N>| {
        let extremal = paths::of_extremal(bvp, &found.candidate).ok()?;
        let poses = paths::on_grid(&search.fine, &extremal).states;
        let name = &found.candidate.provenance.start;
        Some((found.cost, path(name, &search.fine.dynamics.grid, poses.iter().map(Point::pose))))
    };
    let best = extremals.iter().filter_map(|found| seed(found, &search.fine));
    let rivals = found.pool.rivals.iter().filter_map(|rival| seed(rival, &search.coarse));
    let mut seeds: Vec<(f64, Candidate)> = best.chain(rivals).collect();
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    seeds
}

/// One convex iteration from a seed.
pub(super) fn descend<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    chain: &Chain,
    seed: Candidate,
) {
    let options = options(search, chain);
    found.keep(optimised(search, chain, &options, seed));
}

/// Improves a candidate by the interior point if the settings request it, else by the convex iteration.
fn optimised<const N: usize>(
    search: &Search<N>,
    chain: &Chain,
    options: &ScpOptions,
    from: Candidate,
) -> Attempt {
    if search.context.settings.method != settings::Method::InteriorPoint {
        return search.context.attempt(Rung::Scp, &ConvexIteration { chain, options }, from);
    }
    let tuning = Tuning::default();
    let polish = Some(options).filter(|options| options.polish);
    search.context.attempt(Rung::InteriorPoint, &InteriorPoint { chain, tuning: &tuning, polish }, from)
}

/// How the iteration ends on the grid of a chain.
fn options<const N: usize>(search: &Search<N>, chain: &Chain) -> ScpOptions {
    if chain.model.steps == search.problem.steps {
        search.ask.last.clone()
    } else {
        ScpOptions::default().within(search.context.settings.max_iterations)
    }
}

/// Carries the cheapest to the requested grid.
pub(super) fn carry<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    found.reorder(cheapest_first);
    if coarse.model.steps == search.problem.steps {
        return;
    }
    let coarse_plans = found.take_plans();
    let fine = search.chain(search.problem.steps);
    let (mut carried, mut rivals) = (Vec::<Attempt>::new(), Vec::new());
    for (index, cheapest) in coarse_plans.iter().enumerate() {
        // On the fine grid the order of costs may be another.
        let close = |first: &Attempt| {
            carried.len() < CARRIED && cheapest.cost <= first.cost + CLOSE * first.cost.abs()
        };
        if search.stopped() || !carried.first().is_none_or(close) {
            rivals.extend_from_slice(&coarse_plans[index..]);
            break;
        }
        match carried_to(search, found, [coarse, &fine], cheapest) {
            Some(attempt) if carried.iter().any(|other| same::<N>(other, &attempt)) => {}
            Some(attempt) => carried.push(attempt),
            None => rivals.push(cheapest.clone()),
        }
    }
    if !carried.is_empty() {
        found.reorder(|_| cheapest_first(carried).into_iter().chain(rivals).collect());
    }
}

/// A coarse solution carried to the fine grid: in one leap where Newton alone does that, or else over grids between, by Newton's
/// method to one that is four times or twice as fine, or by the convex iteration to the next or the one after it.
pub(super) fn carried_to<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    [coarse, fine]: [&Chain; 2],
    plan: &Attempt,
) -> Option<Attempt> {
    let grids = grids_between(coarse.model.steps, fine.model.steps);
    let (last, mut next) = (grids.len(), 0);
    let mut reached: Option<(Chain, Attempt)> = None;
    while !search.stopped() {
        let (from, plan) = reached.as_ref().map_or((coarse, plan), |(chain, plan)| (chain, plan));
        let mut to = |leap: usize, road: Road| match grids.get(leap) {
            None => Some((None, refine(search, found, [from, fine], plan, road)?)),
            Some(steps) => {
                let chain = search.chain(*steps);
                let refined = refine(search, found, [from, &chain], plan, road)?;
                Some((Some((leap, chain)), refined))
            }
        };
        // In one leap at first.
        let furthest = if next == 0 { last } else { next + 1 };
        let mut leaps = [furthest, next + 1, next].map(|leap| leap.min(last)).to_vec();
        leaps.dedup();
        let newton = leaps.into_iter().find_map(|leap| to(leap, Road::Newton));
        // What a grid does not let by another may.
        let mut convex = (next..=last.min(next + 1)).filter_map(|leap| to(leap, Road::Convex));
        let (between, refined) = newton.or_else(|| convex.next())?;
        let Some((leap, chain)) = between else { return Some(refined) };
        (reached, next) = (Some((chain, refined)), leap + 1);
    }
    None
}

/// A coarse solution carried to a finer grid.
fn refine<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    [coarse, fine]: [&Chain; 2],
    plan: &Attempt,
    road: Road,
) -> Option<Attempt> {
    let start = transfer([coarse, fine], &plan.candidate);
    let options = &options(search, fine);
    let attempt = match road {
        Road::Newton if !options.polish => return None,
        Road::Newton => {
            let newton = ActiveSetNewton { chain: fine, options };
            let tried = search.context.tried(Rung::Scp, &newton, start);
            let near = (tried.cost - plan.cost).abs() <= NEAR * plan.cost;
            search.context.noted(Rung::Scp, near.then_some(tried)?)
        }
        Road::Convex => optimised(search, fine, options, start),
    };
    if attempt.converged() {
        found.add_work(&attempt);
        return Some(attempt);
    }
    found.keep(attempt);
    None
}

/// The maneuver without limits, constraints and wheels.
pub(super) fn relaxed(problem: &Problem) -> Problem {
    let mut relaxed = problem.clone();
    relaxed.constraints.clear();
    relaxed.actuation = problem.actuation.without_limits();
    relaxed
}

/// Grids between, each twice as fine as the one before: the nodes of one are nodes of the next wherever the requested number
/// divides, so that what acts at a node acts there again.
pub(super) fn grids_between(coarse: usize, fine: usize) -> Vec<usize> {
    let parts = std::iter::successors(Some(2_usize), |parts| parts.checked_mul(2));
    let mut grids: Vec<usize> =
        parts.map(|parts| fine.div_ceil(parts)).take_while(|steps| *steps >= 2 * coarse).collect();
    grids.reverse();
    grids
}

/// The path of a recorded trajectory.
pub(super) fn along(start: &str, trajectory: &Trajectory, dynamics: &Dynamics) -> Candidate {
    let pose = |(index, quaternion): (usize, &[f64; 4])| Pose {
        position: trajectory.position.get(index).map_or(Vector3::zeros(), |x| x / dynamics.units.length),
        attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(quaternion)),
    };
    path(start, &dynamics.grid, trajectory.quaternion.iter().enumerate().map(pose))
}
