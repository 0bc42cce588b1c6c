//! Result of a search: the best plan that was found, converted to a solution.

use crate::lie;
use crate::maneuver::problem::State;
use crate::maneuver::settings::Method as Road;
use crate::maneuver::solution::{
    ConvexWork, InteriorWork, Landing, Optimality, Outcome, Rival, Rung, Solution, Trajectory,
};
use crate::numerics::parallel;
use crate::optimize::chain::{iterate, multipliers};
use crate::optimize::discrete::second_order;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::landing::Landed;
use crate::optimize::methods::interior_point::chain::conditions::Conditions;
use crate::optimize::methods::method::{Attempt, Watch};
use crate::optimize::methods::shooting::newton::outcome_of;
use crate::optimize::search::asked;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::record::continuous::estimated;
use crate::optimize::search::record::first_order::gap;
use crate::optimize::search::record::landed::landed;
use crate::optimize::search::record::{self, Recorded};
use crate::optimize::search::way::Way;

/// Number of steps from which running the second-order test on a second thread saves time.
const WORTH_A_THREAD: usize = 400;

/// Chooses the best result, and converts it to a solution.
pub fn conclude<const N: usize>(search: &Search<N>, found: &mut Found<N>) -> Solution {
    if let Some(told) = found.told.take() {
        return told;
    }
    let solve_time = search.context.began.elapsed().as_secs_f64();
    let mut solution = match found.answer.take() {
        Some(answer) => answer,
        None => chosen(search, found),
    };
    solution.solve_time = solve_time;
    if let Some(stopped) = search.context.interrupt()
        && solution.outcome != Outcome::Converged
    {
        solution.outcome = stopped;
    }
    solution
}

/// Returns the best plan that was found, with its rivals; if no plan was found, returns the attempt
/// with the smallest residual.
fn chosen<const N: usize>(search: &Search<N>, found: &mut Found<N>) -> Solution {
    let unsolved = Solution::unsolved(search.problem, search.context.settings.tolerance);
    // Plans of chains are already sorted: the best is on the requested grid, and its rivals are on
    // the coarse grid.
    let ranked = |plan: &Attempt| plan.candidate.provenance.method.is_on_equal_steps();
    let elsewhere = |plan: &Attempt| plan.candidate.steps() != search.problem.steps;
    let own = !search.is_free() || found.is_guessed() || found.plans().iter().any(elsewhere);
    if !(own && found.plans().iter().any(ranked)) {
        found.reorder(|plans| asked::ranked(search, plans));
    }
    let rivals = found.plans().iter().skip(1).chain(&found.pool.rivals).map(|plan| rival(search, plan));
    // A plan that cannot be replayed from its start is not a rival.
    let rivals = rivals.filter(|rival| rival.turned_deg.is_finite() && rival.cost.is_finite()).collect();

    let own = if search.context.settings.method == Road::Scp { Road::Scp } else { Road::InteriorPoint };
    let method = if search.ask.shooting { Road::Shooting } else { own };
    let mut solution = Solution { method, rivals, ..unsolved };
    if let Some(chosen) = found.best().or(found.missed()) {
        write(search, &found.work, &mut solution, chosen);
    } else if search.context.ladder.borrow().iter().any(|rung| rung.outcome == Outcome::IterationLimit) {
        solution.outcome = Outcome::IterationLimit;
    }
    solution
}

/// Returns the description of a rival, with a cost in the unit of the file.
pub fn rival_of_cost<const N: usize>(search: &Search<N>, plan: &Attempt, cost: f64) -> Rival {
    Rival { cost, ..rival(search, plan) }
}

fn rival<const N: usize>(search: &Search<N>, rival: &Attempt) -> Rival {
    let candidate = &rival.candidate;
    let Way { sense, turned_deg, .. } = asked::way(search, candidate);
    let conjugate_points = match candidate.provenance.method {
        _ if !search.context.settings.test_second_order => None,
        Road::Scp | Road::InteriorPoint => None,
        _ => second_order::conjugate_points(asked::told_on(search, candidate), &candidate.costate::<N>()),
    };
    let (start, cost) = (candidate.provenance.start.clone(), rival.cost * search.fine.dynamics.units.cost);
    Rival { start, sense, cost, conjugate_points, turned_deg }
}

/// Converts an attempt to a solution, after landing it if required.
pub fn write<const N: usize>(
    search: &Search<N>,
    work: &ConvexWork,
    solution: &mut Solution,
    attempt: &Attempt,
) {
    match landed(search, attempt) {
        Some(Landed { attempt: landed, target, landing }) => {
            write_aimed(search, work, solution, &landed, Some(&target), attempt);
            let cost_before = attempt.cost * search.fine.dynamics.units.cost;
            solution.landing = Some(Landing { cost_before, ..landing });
        }
        None => write_aimed(search, work, solution, attempt, None, attempt),
    }
    if let Some(work) = &mut solution.interior {
        work.continuous = estimated(search, attempt);
        work.continuous_gap = gap(search, attempt, solution.landing.as_ref());
    }
    solution.widen_by_landing();
}

/// Converts an attempt to a solution. Its discrete target may differ from the terminal state of the
/// maneuver.
///
/// For an extremal of shooting, the optimality is that of `optimum`, the discrete optimum before
/// landing: a shift by `O(h²)` splits a circle of equal minima into a minimum and a saddle, and
/// neither belongs to the maneuver.
pub fn write_aimed<const N: usize>(
    search: &Search<N>,
    work: &ConvexWork,
    solution: &mut Solution,
    attempt: &Attempt,
    target: Option<&State>,
    optimum: &Attempt,
) {
    let aimed = target.map(|target| search.fine.aimed(target));
    let fine = aimed.as_ref().unwrap_or(&search.fine);
    let candidate = &attempt.candidate;
    let provenance = &candidate.provenance;
    solution.outcome = attempt.outcome;
    solution.method = provenance.method;
    solution.start = provenance.start.clone();
    solution.iterations = provenance.iterations;
    if let Some(shortfall) = &attempt.shortfall {
        solution.shortfall = Some(shortfall.clone());
    }
    if candidate.steps() != search.problem.steps {
        return;
    }
    let chain = provenance.method.is_on_equal_steps().then(|| {
        let mut chain = search.chain_of_given_duration(candidate.steps());
        if let Some(target) = target {
            chain.model.aim(target);
        }
        chain
    });
    let (recorded, optimality) = match &chain {
        Some(chain) => (record::chain(search.problem, fine, chain, candidate), None),
        None => recorded(search, fine, attempt, optimum),
    };
    let recorded = match recorded {
        Ok(recorded) => recorded,
        // A plan that cannot be replayed is not a plan, even if its conditions are satisfied.
        Err(error) => {
            if attempt.converged() {
                solution.outcome = outcome_of(error);
            }
            return;
        }
    };
    solution.cost = recorded.cost * fine.dynamics.units.cost;
    solution.terminal = recorded.terminal;
    solution.sense = recorded.way.sense;
    solution.turned_deg = recorded.way.turned_deg;
    // For a free terminal attitude, the target is the end of the discrete motion.
    let reached = recorded.trajectory.quaternion.last().filter(|_| search.problem.ends_in_any_attitude());
    let reached = reached.map(lie::rotation_from_quaternion);
    let target = target.map(|target| State { attitude: reached.unwrap_or(target.attitude), ..*target });
    solution.trajectory = Trajectory { target, ..recorded.trajectory };
    match &chain {
        None => {
            solution.active = recorded.active;
            solution.optimality = match optimality {
                Some(optimality) => optimality,
                None if search.context.settings.test_second_order => {
                    second_order::optimality(&search.fine, &optimum.candidate.costate())
                }
                None => Optimality::UNTESTED,
            };
        }
        Some(chain) if attempt.converged() => {
            solution.active = recorded.active;
            match attempt.barrier {
                Some([mu, gap, _]) if provenance.method == Road::InteriorPoint => {
                    let ladder = search.context.ladder.borrow();
                    let starts = ladder.iter().filter(|run| run.rung == Rung::InteriorPoint).count();
                    let iterations = provenance.iterations;
                    solution.interior =
                        Some(InteriorWork { iterations, starts, mu, gap, ..InteriorWork::default() });
                }
                _ => solution.convex = Some(ConvexWork { subproblems: provenance.subproblems, ..*work }),
            }
            // The second-order test is that of the minimum-effort problem, for the duration found.
            let effort = search.ask.goal.as_ref().is_none_or(|goal| !goal.objective.switches());
            let tested = search.context.settings.test_second_order;
            solution.optimality = search.context.within(|budget| {
                let (iterate, multipliers) = (iterate(candidate), multipliers(candidate));
                let watch = Watch { deadline: None, ..budget.watch };
                Optimality {
                    tested,
                    stationarity: attempt.stationarity,
                    conjugate_points: (effort && tested)
                        .then(|| Conditions::of(chain, &iterate, &multipliers, &watch)?.descents())
                        .flatten(),
                    rank: chain.model.terminal_count(),
                    condition: f64::NAN,
                }
            });
        }
        Some(_) => {}
    }
}

/// Records an extremal; tests its second order in a parallel thread if that saves time.
fn recorded<const N: usize>(
    search: &Search<N>,
    fine: &BoundaryValueProblem<N>,
    attempt: &Attempt,
    optimum: &Attempt,
) -> (Result<Recorded, StepError>, Option<Optimality>) {
    let (problem, stopped) = (search.problem, search.stopped());
    let (costate, swept) = (attempt.candidate.costate(), attempt.swept.as_ref());
    if stopped || !fine.is_kept_after_stop() {
        // After a stop request, the best iterate is still recorded.
        let undisturbed = (stopped && fine.is_kept_after_stop()).then(|| fine.undisturbed());
        return (record::extremal(problem, undisturbed.as_ref().unwrap_or(fine), &costate, swept), None);
    }
    let pays = problem.steps >= WORTH_A_THREAD && parallel::threads() > 1;
    if !pays || !search.context.settings.test_second_order {
        return (record::extremal(problem, fine, &costate, swept), None);
    }
    let (dynamics, start, terminal) = fine.parts();
    let record = || {
        let fine = BoundaryValueProblem::<N>::of_parts(dynamics, start, terminal);
        record::extremal(problem, &fine, &costate, swept)
    };
    let tested = optimum.candidate.costate();
    let test = || second_order::optimality(&search.fine, &tested);
    let (optimality, recorded) = parallel::both(test, record, || {
        search.stopped();
    });
    (recorded, Some(optimality))
}
