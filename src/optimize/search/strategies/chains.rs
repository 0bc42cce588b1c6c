//! Maneuvers within limits: every initial path is improved on a coarse grid, and the cheapest plans
//! again on the requested grid.
//!
//! # Which method is used for a limited maneuver?
//!
//! If only the inputs are limited, by size or by norm, and the objective is effort, shooting is
//! tried first. From each extremal without limits Newton continues with the saturated law
//! (`control_law/saturated`), which costs only a clamp in the kick. It brings costates to round-off
//! and gives the number of conjugate points. This number comes from the inertia of the accessory
//! problem, because the sensitivity matrix loses rank while all inputs are at their limits. If
//! shooting finds no plan, and for all other limits and objectives, the interior-point method is
//! used ([`crate::optimize::methods::interior_point`]), or SCP if the settings request it.
//!
//! For effort, the maneuver without limits is solved first, by shooting, for each homotopy class.
//! If the cheapest of these plans satisfies every limit, it is the result. Otherwise each of these
//! paths, and its detours to either side of every cone that it crosses, is an initial path. Limits
//! only increase the cost of a maneuver. A class whose path without limits costs more than a plan
//! already found is therefore not tried, unless wheels store momentum at the start: without wheels
//! the body would move differently. The path of a guess is one more initial path, the first.

use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings;
use crate::maneuver::solution::{Rung, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::chain::{Chain, path};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Dynamics, Point};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::method::ConvexIteration;
use crate::optimize::search::asked;
use crate::optimize::search::found::{Found, cheapest_first, same};
use crate::optimize::search::ladder::Search;
use crate::optimize::search::record::landed::can_be_flown;
use crate::optimize::search::starts::transfer::transfer;
use crate::optimize::search::starts::{any_attitude, paths};

/// Returns the extremals of the maneuver without limits, as paths on a coarse grid.
pub fn unlimited_paths<const N: usize>(search: &Search<N>, coarse: &Chain) -> Vec<Candidate> {
    let seeds = relaxed_paths(search, &relaxed(search.problem), coarse);
    if seeds.is_empty() {
        return vec![paths::shortest_way(&coarse.model)];
    }
    seeds.into_iter().map(|(_, seed)| seed).collect()
}

/// Returns the extremals of the relaxed maneuver with their scaled costs, the cheapest first.
/// Limits only increase these costs.
pub fn relaxed_paths<const N: usize>(
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

/// Solves from an initial path to a reduced accuracy, unless a stop is requested, and keeps the
/// result.
pub fn descend<const N: usize>(search: &Search<N>, found: &mut Found<N>, chain: &Chain, seed: Candidate) {
    if search.stopped() {
        return;
    }
    let tuning = Tuning::roughly();
    let method = InteriorPoint { known: found.plans(), ..InteriorPoint::of(chain, &tuning) };
    let attempt = improved(search, &method, seed);
    found.keep(attempt);
}

/// Improves a candidate until convergence by the interior-point method, or by SCP if the settings
/// request it.
pub fn optimised<const N: usize>(search: &Search<N>, chain: &Chain, from: Candidate) -> Attempt {
    improved(search, &InteriorPoint::of(chain, &Tuning::default()), from)
}

/// Improves the path of a motion that is nearly a plan. Returns `None` if the motion has no path.
pub fn optimised_along<const N: usize>(
    search: &Search<N>,
    chain: &Chain,
    motion: &Trajectory,
) -> Option<Attempt> {
    let mut path = resampled(chain, "known", motion).pop()?;
    if chain.model.duration.is_some() {
        path.grid = path.grid.with_duration(search.context.tuning.slowed);
    }
    Some(optimised(search, chain, path))
}

/// Improves a candidate near an optimum: first with settings for a nearby optimum, then with the
/// default ones.
pub fn optimised_near<const N: usize>(search: &Search<N>, chain: &Chain, from: Candidate) -> Attempt {
    let near = improved(search, &InteriorPoint::of(chain, &Tuning::near()), from.clone());
    if near.converged() { near } else { optimised(search, chain, from) }
}

/// Improves a candidate by the interior-point method `method`, or by SCP if the settings request
/// it.
fn improved<const N: usize>(search: &Search<N>, method: &InteriorPoint, from: Candidate) -> Attempt {
    // SCP does not support other objectives, such as a free duration for advice.
    if search.context.settings.method == settings::Method::Scp && search.ask.goal.is_none() {
        let chain = method.chain;
        let options = if chain.model.steps == search.problem.steps {
            &search.ask.last
        } else {
            &ScpOptions::default().within(search.context.settings.max_iterations)
        };
        return search.context.attempt(Rung::Scp, &ConvexIteration { chain, options }, from);
    }
    let method = InteriorPoint { family: search.ask.family, ..*method };
    search.context.attempt(Rung::InteriorPoint, &method, from)
}

/// Solves the cheapest coarse plans again on the requested grid, sorts the results by cost and puts
/// them before the others. If a solve does not converge, the next coarse plan is tried.
pub fn carry<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    let (close, carried_at_most) = (search.context.tuning.close, search.context.tuning.carried);
    found.reorder(|plans| distinct(plans, search.context.tuning.one));
    let same_grid = coarse.model.steps == search.problem.steps;
    if same_grid && search.context.settings.method == settings::Method::Scp {
        return;
    }
    let coarse_plans = found.take_plans();
    let fine = search.chain(search.problem.steps);
    let (mut carried, mut rivals) = (Vec::<Attempt>::new(), Vec::new());
    let mut best = f64::INFINITY;
    for (index, plan) in coarse_plans.iter().enumerate() {
        // The order of costs may differ on the fine grid.
        let least = carried.iter().map(|plan| plan.cost).fold(f64::INFINITY, f64::min);
        let hopeful = carried.is_empty() || plan.cost <= (best + close * best.abs()).max(least);
        if search.stopped() || !hopeful || carried.len() == carried_at_most {
            rivals.extend_from_slice(&coarse_plans[index..]);
            break;
        }
        let start =
            if same_grid { plan.candidate.clone() } else { transfer([coarse, &fine], &plan.candidate) };
        let next = optimised_near(search, &fine, start);
        if !next.converged() || !can_be_flown(search, &next) {
            rivals.push(plan.clone());
            found.keep(next);
            continue;
        }
        found.add_work(&next);
        best = best.min(plan.cost);
        if !carried.iter().any(|other| same::<N>(other, &next)) {
            carried.push(next);
        }
    }
    if !carried.is_empty() {
        found.reorder(|_| cheapest_first(carried).into_iter().chain(rivals).collect());
    } else if same_grid && search.stopped() {
        // A stopped search keeps its results so far.
        found.reorder(|_| rivals);
    }
}

/// Returns the plans sorted by the estimated costs of their optima. Of plans whose costs differ by
/// less than the relative difference `one`, the first is kept.
pub fn distinct(mut plans: Vec<Attempt>, one: f64) -> Vec<Attempt> {
    plans.sort_by(|a, b| a.foreseen().total_cmp(&b.foreseen()).then(a.cost.total_cmp(&b.cost)));
    let mut kept = Vec::<Attempt>::new();
    for plan in plans {
        if kept.last().is_none_or(|last| plan.foreseen() > last.foreseen() + one * last.cost.abs()) {
            kept.push(plan);
        }
    }
    kept
}

/// Returns the maneuver without limits, constraints and wheels.
pub fn relaxed(problem: &Problem) -> Problem {
    let mut relaxed = problem.clone();
    relaxed.constraints.clear();
    relaxed.actuation = problem.actuation.without_limits();
    relaxed
}

/// Returns the path of a recorded trajectory.
pub fn along(start: &str, trajectory: &Trajectory, dynamics: &Dynamics) -> Candidate {
    let pose = |(index, quaternion): (usize, &[f64; 4])| Pose {
        position: trajectory.position.get(index).map_or(Vector3::zeros(), |x| x / dynamics.units.length),
        attitude: lie::project_to_rotation(&lie::rotation_from_quaternion(quaternion)),
    };
    path(start, &dynamics.grid, trajectory.quaternion.iter().enumerate().map(pose))
}

/// Returns the path of the plan without constraints, resampled on the grid of a chain; empty if no
/// such plan exists.
pub fn resampled(chain: &Chain, objective: &str, quick: &Trajectory) -> Vec<Candidate> {
    let Some(duration) = quick.time.last() else { return Vec::new() };
    let grid = &chain.model.dynamics.grid;
    let pose = |node: usize| {
        let time = duration * grid.time(node);
        let after = quick.time.partition_point(|at| *at <= time).clamp(1, quick.time.len() - 1);
        let [from, to] = [after - 1, after].map(|row| lie::rotation_from_quaternion(&quick.quaternion[row]));
        let part = (time - quick.time[after - 1]) / (quick.time[after] - quick.time[after - 1]);
        let part = part.clamp(0.0, 1.0);
        let turn = lie::minus(&to, &from) * part;
        let position = match &quick.position[..] {
            [] => chain.model.start.position,
            places => places[after - 1].lerp(&places[after], part) / chain.model.dynamics.units.length,
        };
        Pose { position, attitude: from * lie::exp(&turn) }
    };
    vec![path(&format!("minimum {objective}"), grid, (0..=grid.steps()).map(pose))]
}
