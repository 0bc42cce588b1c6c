//! The plan that is written, made to land (`optimize::landing`), by the method that found it.

use super::ladder::Search;
use super::record;
use super::shares::{EASED, SHARE, SHARP};
use crate::maneuver::settings::Method as Road;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::landing::{Aim, Landed, land_chain, land_costate};
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::{Attempt, Budget, Method, Swept};
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::model::{Effort, Goal};
use crate::optimize::methods::scp::road::{ActiveSetNewton, Chain, ConvexIteration};
use nalgebra::{DVector, SVector};

/// Steps, as a multiple of those of the coarse grid, from whose sensitivity corrections begin.
const BEGUN_ON: usize = 2;

/// An attempt on the requested grid, made to land; `None` where that is not asked for or cannot begin.
pub(super) fn landed<const N: usize>(search: &Search<N>, attempt: &Attempt) -> Option<Landed> {
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
    let options = &search.ask.last;
    let interior = candidate.provenance.method == Road::InteriorPoint;
    land_chain(Aim::of(search.problem), &mut chain, attempt.clone(), record, |chain, attempt| {
        let again = interior
            .then(|| search.context.within(|budget| within_limits(chain, attempt, Some(options), budget)));
        again.flatten().or_else(|| warm(search, chain, attempt, options))
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

/// Solves again on a chain that is aimed a little elsewhere: by Newton on the active set or, where that does not settle, by
/// the convex iteration.
fn warm<const N: usize>(
    search: &Search<N>,
    chain: &Chain,
    attempt: &Attempt,
    options: &ScpOptions,
) -> Option<Attempt> {
    let provenance = attempt.candidate.provenance.clone();
    let solved = |method: &dyn Fn(Candidate) -> Attempt| {
        let again = method(attempt.candidate.clone());
        again.converged().then(|| Attempt {
            candidate: Candidate { provenance: provenance.clone(), ..again.candidate },
            runs: attempt.runs.clone(),
            work: attempt.work,
            ..again
        })
    };
    let newton = ActiveSetNewton { chain, options };
    let convex = ConvexIteration { chain, options };
    search.context.within(|budget| {
        solved(&|candidate| newton.improve(candidate, budget))
            .or_else(|| solved(&|candidate| convex.improve(candidate, budget)))
    })
}

/// Solves again by the interior point on a chain with a slightly different target. Where several plans
/// have the least cost it finds their centre, which moves continuously with the target.
fn within_limits(
    chain: &Chain,
    attempt: &Attempt,
    polish: Option<&ScpOptions>,
    budget: &Budget,
) -> Option<Attempt> {
    let tuning = Tuning::default();
    let again = InteriorPoint { chain, tuning: &tuning, polish }.improve(attempt.candidate.clone(), budget);
    let provenance = attempt.candidate.provenance.clone();
    again.converged().then(|| Attempt {
        candidate: Candidate { provenance, ..again.candidate },
        runs: attempt.runs.clone(),
        work: attempt.work,
        ..again
    })
}

/// A plan of a chain with a goal, whose duration may be sought, made to land, and the share of the effort in its cost.
pub(super) fn landed_with_goal<const N: usize>(
    search: &Search<N>,
    found: &Attempt,
    goal: &Goal,
) -> Option<(Landed, f64)> {
    if !found.converged() || search.stopped() {
        return None;
    }
    let aim = Aim::asked(search.problem, search.context.settings).filter(|_| search.ask.lands)?;
    let (problem, steps) = (search.problem, search.problem.steps);
    let mut chain = Chain::with_goal(problem, steps, goal);
    let record = |chain: &Chain, attempt: &Attempt| {
        let duration = problem.seconds() * attempt.candidate.grid.duration();
        let planned = problem.clone().lasting(duration);
        let given = chain.of_given_duration(attempt.clone(), &planned);
        let of_duration = match goal.in_given_duration() {
            None => Chain::new(&planned, steps),
            Some(goal) => Chain::with_goal(&planned, steps, &goal),
        };
        let bvp = BoundaryValueProblem::<N>::new(&planned, steps);
        Some(record::chain(&planned, &bvp, &of_duration, &given.candidate).ok()?.trajectory)
    };
    // Multipliers tell which inputs are off, the less clearly the smaller the share.
    let options = ScpOptions { cone_tolerance: SHARP, ..search.ask.last.clone() };
    let mut least = goal.effort.share;
    let solve = |chain: &Chain, attempt: &Attempt| {
        if found.candidate.provenance.method == Road::InteriorPoint {
            return search.context.within(|budget| within_limits(chain, attempt, None, budget));
        }
        let sharp = warm(search, chain, attempt, &options);
        if sharp.is_some() || !goal.objective.switches() {
            return sharp;
        }
        // Other limits act for the new target: with more of the effort in the cost they are found, and with less again kept.
        let mut eased = goal.effort.share;
        while eased < SHARE && !search.stopped() {
            eased = (eased / EASED).min(SHARE);
            let effort = Effort { share: eased, ..goal.effort.clone() };
            let goal = Goal { effort, ..goal.clone() };
            let mut easier = Chain { rows: chain.rows.clone(), ..Chain::with_goal(problem, steps, &goal) };
            easier.model.aim_with(&chain.model);
            if let Some(found) = warm(search, &easier, attempt, &options) {
                return warm(search, chain, &found, &options).or_else(|| {
                    least = least.max(eased);
                    Some(found)
                });
            }
        }
        None
    };
    let landed = land_chain(aim, &mut chain, found.clone(), record, solve);
    landed.map(|landed| (landed, least))
}
