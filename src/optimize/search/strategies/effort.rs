//! Strategy for minimum effort with a given duration on the chain: the interior-point method, or
//! SCP if the settings request it. It is the only strategy, or the last one after shooting.

use crate::Vector3;
use crate::flight::{Excess, Flight};
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::{Method, Thoroughness};
use crate::maneuver::solution::{ConvexWork, Outcome, Solution, Trajectory};
use crate::optimize::chain::{Chain, path};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::interior_point::method::worst_violation;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::search::asked::goes_round_as_asked;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::record::answer::{conclude, write};
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::detour::detours;
use crate::optimize::search::starts::families::Starts;
use crate::optimize::search::starts::{self, paths};
use crate::optimize::search::strategies::chains::{
    along, carry, descend, optimised, relaxed, relaxed_paths, resampled,
};
use crate::optimize::search::strategies::seeds;

/// Finds the optima near all initial paths, and the cheapest of them on the requested grid. If it
/// finds no plan for a constrained maneuver, it reports its own attempt with the smallest residual;
/// for other maneuvers it reports that of shooting if shooting ran before.
pub struct Effort;

impl<const N: usize> Climb<N> for Effort {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        let rescue = search.ask.shooting && (found.is_done() || search.stopped());
        search.ask.convex && search.ask.goal.is_none() && !rescue
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        let missed = found.take_missed();
        from_seeds(search, found);
        if search.ask.shooting && !found.is_done() && !search.problem.is_constrained() {
            found.tell_missed(missed);
        }
    }
}

/// Solves from all initial paths; keeps the best plan on the requested grid, followed by its rivals
/// on the coarse one.
fn from_seeds<const N: usize>(search: &Search<N>, found: &mut Found<N>) {
    let problem = search.problem;
    if let Some(trajectory) = search.ask.along {
        let fine = search.chain(problem.steps);
        for seed in resampled(&fine, "given path", trajectory) {
            descend(search, found, &fine, seed);
        }
        return carry(search, found, &fine);
    }
    let relaxed = relaxed(problem);
    let coarse = search.chain(chain_steps(problem));
    let mut seeds = relaxed_paths(search, &relaxed, &coarse);
    if search.context.settings.method == Method::Auto
        && !problem.ends_in_any_attitude()
        && let Some(answer) = unlimited(search, &relaxed, &seeds)
    {
        found.answer = Some(made_to_land(search, answer));
        return;
    }
    if seeds.is_empty() {
        seeds.push((0.0, paths::shortest_way(&coarse.model)));
    }
    if let Some(guess) = search.ask.guess
        && let Some(seed) = guess.seed(&coarse.model)
        && as_asked(search, &seed)
    {
        descend(search, found, &coarse, seed);
    }
    // If wheels store momentum, the body moves differently. The costs without limits are then no
    // bounds, and the best plan may not be near any of these paths.
    let bounds = problem.actuation.stored_momentum() == Vector3::zeros();
    for (cost, seed) in seeds {
        let cheaper = |plan: &Attempt| plan.cost < cost && goes_round_as_asked(search, &plan.candidate);
        let hopeless = bounds && found.plans().iter().any(cheaper);
        if hopeless || search.stopped() {
            continue;
        }
        for seed in detours(problem, seed) {
            descend(search, found, &coarse, seed);
        }
    }
    match search.context.settings.search {
        Thoroughness::Quick => {}
        // The paths of SCP serve only for comparison; more of them would take seconds.
        _ if search.context.settings.method == Method::Scp => {}
        Thoroughness::Default => from_bent(search, found, &coarse),
        Thoroughness::Thorough => {
            from_bent(search, found, &coarse);
            from_paths(search, found, Starts::all(), &relaxed, &coarse);
        }
    }
    // Plans in the other homotopy class are reported only if no plan is in the requested one.
    found.reorder(|mut plans| {
        if plans.iter().any(|plan| goes_round_as_asked(search, &plan.candidate)) {
            plans.retain(|plan| goes_round_as_asked(search, &plan.candidate));
        }
        plans
    });
    carry(search, found, &coarse);
}

/// Solves from turns about a fixed axis and from coasts, both bent to several sides.
fn from_bent<const N: usize>(search: &Search<N>, found: &mut Found<N>, coarse: &Chain) {
    if search.problem.ends_in_any_attitude() {
        return;
    }
    for path in seeds::of(search, coarse.model.steps, search.context.settings.search) {
        for seed in detours(search.problem, path) {
            if search.stopped() {
                return;
            }
            descend(search, found, coarse, seed);
        }
    }
}

/// Solves from the paths from which descents of the relaxed maneuver start, including bent and
/// random ones: optima within limits need not be near any extremal without limits.
fn from_paths<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    starts: Starts,
    relaxed: &Problem,
    coarse: &Chain,
) {
    let grid = &coarse.model.dynamics.grid;
    let bvp = BoundaryValueProblem::<N>::new(relaxed, coarse.model.steps);
    for start in starts.paths(&bvp) {
        let seed = path(&start.provenance.start, grid, start.states.iter().map(Point::pose));
        for seed in detours(search.problem, seed) {
            if search.stopped() {
                return;
            }
            descend(search, found, coarse, seed);
        }
    }
}

/// Returns the solution of the problem without limits: by shooting, or also by the chain if torques
/// about an axis are missing, where shooting may fail.
fn shot<const N: usize>(search: &Search<N>, relaxed: &Problem) -> Solution {
    let convex = search.problem.is_constrained() && !search.fine.dynamics.has_all_axes();
    let ask = Ask { convex, last: ScpOptions::default(), ..search.ask.of_relaxed() };
    let search = search.of(relaxed, ask);
    conclude(&search, &mut search.climb())
}

/// Returns the relaxed solution if it satisfies every limit.
fn unlimited<const N: usize>(
    search: &Search<N>,
    relaxed: &Problem,
    seeds: &[(f64, Candidate)],
) -> Option<Solution> {
    let problem = search.problem;
    let (_, seed) = seeds.first().filter(|_| problem.actuation.wheels.is_none())?;
    // If only one path can be the best, a clear violation on the coarse grid makes the fine solve
    // unnecessary.
    let coarse = Chain::new(problem, seed.steps());
    if search.fine.dynamics.has_all_axes()
        && worst_violation(&coarse, &coarse.opened(seed))? > search.context.tuning.clear_violation
    {
        return None;
    }
    let solution = shot(search, relaxed);
    if solution.outcome != Outcome::Converged {
        return None;
    }
    let fine = Chain::new(problem, problem.steps);
    let path = along("short", &solution.trajectory, &fine.model.dynamics);
    let first = fine.model.first_input();
    let mut candidate = fine.opened(&path);
    for stage in first..=problem.steps {
        let inputs = solution.trajectory.inputs(stage - first);
        candidate.inputs[stage] =
            inputs.iter().zip(&fine.model.input_unit).map(|(u, unit)| u / unit).collect();
    }
    if worst_violation(&fine, &candidate)? > 0.0 {
        return None;
    }
    // The rivals are those of the relaxed maneuver, and may violate limits.
    Some(Solution { rivals: Vec::new(), ..solution })
}

/// Returns whether a guess is in the requested homotopy class. If a rotation is given, any guess
/// may lead to it, and the result is `true`.
fn as_asked<const N: usize>(search: &Search<N>, seed: &Candidate) -> bool {
    matches!(search.problem.path, Path::AsGiven(_)) || goes_round_as_asked(search, seed)
}

/// Lands the solution of a search without limits. If its true motion violates a constraint, the
/// maneuver is planned again along this path.
fn made_to_land<const N: usize>(search: &Search<N>, answer: Solution) -> Solution {
    if !search.ask.lands || answer.outcome != Outcome::Converged || search.stopped() {
        return answer;
    }
    let Ok(costate) = starts::given(search.problem, &search.fine, answer.costates_0(search.problem)) else {
        return answer;
    };
    let candidate = Candidate::of_costate(&answer.start, &search.fine.dynamics.grid, &costate);
    let report = Report { outcome: Outcome::Converged, iterations: answer.iterations, residuals: Vec::new() };
    let mut written = answer.clone();
    write(search, &ConvexWork::default(), &mut written, &Attempt::of(candidate, report));
    written.iterations = answer.iterations;
    if let Some(landing) = &mut written.landing {
        landing.cost_before = answer.cost;
    }
    if written.landing.is_none() || !exceeds(search, &written.trajectory) {
        return written;
    }
    let steps = search.problem.steps;
    let chain = Chain::new(search.problem, steps);
    let path = chain.opened(&along(&answer.start, &answer.trajectory, &chain.model.dynamics));
    let kept = optimised(search, &chain, path);
    if kept.converged() {
        let mut kept_within = answer.clone();
        write(search, &ConvexWork::default(), &mut kept_within, &kept);
        kept_within.iterations = answer.iterations;
        return kept_within;
    }
    written
}

/// Returns whether the true motion of a plan violates a constraint.
fn exceeds<const N: usize>(search: &Search<N>, plan: &Trajectory) -> bool {
    let Some(mut excess) = Excess::of(search.problem) else { return false };
    let steps = Flight::of_plan(search.problem, plan);
    let mut flight = Flight::new(search.problem);
    flight.settle(&steps);
    flight.fly(&steps, Some(&mut excess)).is_none() || excess.worst.iter().any(|worst| *worst > 0.0)
}
