//! Landing of the recorded plan (`optimize::landing`), by the method that found it.

use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::Outcome;
use crate::optimize::chain::Chain;
use crate::optimize::chain::model::Goal;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::landing::{Aim, Landed, land_chain, land_costate, left};
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::{STAGES, Tuning};
use crate::optimize::methods::method::{Attempt, Method, Swept};
use crate::optimize::search::ladder::Search;
use crate::optimize::search::record::{self, Recorded};
use nalgebra::{DVector, SVector};

/// Number of steps of the grid whose sensitivity starts the corrections, as a multiple of the
/// number of steps of the coarse grid.
const BEGUN_ON: usize = 2;

/// Lands an attempt on the requested grid; returns `None` if landing is not required or cannot
/// begin.
pub fn landed<const N: usize>(search: &Search<N>, attempt: &Attempt) -> Option<Landed> {
    let candidate = &attempt.candidate;
    let ready = search.ask.lands && attempt.converged() && candidate.steps() == search.problem.steps;
    if !ready || search.stopped() {
        return None;
    }
    if !candidate.provenance.method.is_on_equal_steps() {
        return costate_landed(search, attempt, &candidate.costate());
    }
    let mut chain = search.chain_of_given_duration(candidate.steps());
    let record = |chain: &Chain, attempt: &Attempt| {
        Some(record::chain(search.problem, &search.fine, chain, &attempt.candidate).ok()?.trajectory)
    };
    land_chain(Aim::of(search.problem), &mut chain, attempt.clone(), record, |chain, attempt, miss| {
        again(search, chain, attempt, miss)
    })
}

fn costate_landed<const N: usize>(
    search: &Search<N>,
    attempt: &Attempt,
    costate: &SVector<f64, N>,
) -> Option<Landed> {
    let steps = (BEGUN_ON * search.coarse.dynamics.grid.steps()).min(search.problem.steps);
    let coarse = search.fine.on_steps(steps);
    let found = land_costate(search.problem, &search.fine, &coarse, costate, &|| search.stopped())?;
    let error = found.nodes.last()?.physical().minus(&found.target).to_vector::<N>();
    let swept =
        Swept { nodes: found.nodes, error: DVector::from_column_slice(error.as_slice()), cost: found.cost };
    let candidate = Candidate {
        provenance: attempt.candidate.provenance.clone(),
        ..attempt.candidate.clone().with_costate(&found.costate)
    };
    let attempt = Attempt { candidate, cost: found.cost, swept: Some(swept), ..attempt.clone() };
    Some(Landed { attempt, target: found.state, landing: found.landing })
}

/// Solves a chain again for a slightly different target, with a warm start from `attempt`. `miss`
/// is the size of the last miss.
///
/// If several plans have the minimum cost, the interior-point method finds their centre, which
/// moves continuously with the target.
fn again<const N: usize>(search: &Search<N>, chain: &Chain, attempt: &Attempt, miss: f64) -> Option<Attempt> {
    let candidate = &attempt.candidate;
    let next = search.context.within(|budget| {
        // The target has moved little: nearby warm starts are tried first, then more distant ones.
        let mut last = Attempt::failed(candidate.clone(), Outcome::Stalled);
        let warm = attempt.warm.as_deref();
        // Along a valley of nearly equal plans only the barrier parameter selects one plan. An
        // unchanged parameter keeps the plan unchanged.
        let held = attempt.barrier.map_or(0.0, |[barrier, ..]| barrier * chain.model.steps as f64 / STAGES);
        for (tuning, warm) in
            [(Tuning::beside(miss).down_to(held), warm), (Tuning::near(), None), (Tuning::default(), None)]
        {
            last = InteriorPoint { warm, ..InteriorPoint::of(chain, &tuning) }
                .improve(candidate.clone(), budget);
            if last.converged() {
                break;
            }
        }
        last
    });
    let provenance = attempt.candidate.provenance.clone();
    next.converged().then(|| Attempt {
        candidate: Candidate { provenance, ..next.candidate },
        runs: attempt.runs.clone(),
        work: attempt.work,
        ..next
    })
}

/// Records a plan of a chain for an objective. Returns the record and the maneuver with the plan's
/// duration; `None` if the plan cannot be replayed.
fn recorded<const N: usize>(
    search: &Search<N>,
    goal: &Goal,
    chain: &Chain,
    attempt: &Attempt,
) -> Option<(Problem, Recorded)> {
    let (problem, steps) = (search.problem, attempt.candidate.steps());
    let duration = problem.seconds() * attempt.candidate.grid.duration();
    let planned = problem.clone().lasting(duration);
    let given = chain.of_given_duration(attempt.clone(), &planned);
    let of_duration = match goal.in_given_duration() {
        None => Chain::new(&planned, steps),
        Some(goal) => Chain::with_goal(&planned, steps, &goal),
    };
    let bvp = BoundaryValueProblem::<N>::new(&planned, steps);
    let found = record::chain(&planned, &bvp, &of_duration, &given.candidate).ok()?;
    Some((planned, found))
}

/// Returns whether a plan, replayed from the start, meets the end, and whether its true motion ends
/// nearby. On few steps a discrete motion may pass the centre of a force field at low cost, which
/// no true motion can do.
pub fn can_be_flown<const N: usize>(search: &Search<N>, attempt: &Attempt) -> bool {
    let passes = search.problem.motion == Motion::RigidBody && !search.problem.environment.is_free();
    // The end of the plan is one of a family of terminal states, not the terminal state of the
    // maneuver.
    let checked = passes && search.ask.family.is_none();
    let Some(goal) = search.ask.goal.as_ref().filter(|_| checked) else { return true };
    let chain = search.chain(attempt.candidate.steps());
    recorded(search, goal, &chain, attempt).is_some_and(|(planned, found)| {
        found.terminal.largest() <= search.context.settings.tolerance
            && left(&planned, &found.trajectory) <= search.context.tuning.far
    })
}

/// Lands a plan of a chain for an objective; the duration may be free.
pub fn landed_with_goal<const N: usize>(search: &Search<N>, found: &Attempt) -> Option<Landed> {
    if !found.converged() || search.stopped() {
        return None;
    }
    let goal = search.ask.goal.as_ref()?;
    let aim = Aim::asked(search.problem, search.context.settings).filter(|_| search.ask.lands)?;
    let (problem, steps) = (search.problem, search.problem.steps);
    let mut chain = Chain::with_goal(problem, steps, goal);
    let record =
        |chain: &Chain, attempt: &Attempt| Some(recorded(search, goal, chain, attempt)?.1.trajectory);
    land_chain(aim, &mut chain, found.clone(), record, |chain, attempt, miss| {
        again(search, chain, attempt, miss)
    })
}
