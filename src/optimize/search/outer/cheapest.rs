//! Minimum time or minimum fuel within limits and constraints, and minimum fuel with forces or in
//! force fields, by the interior-point method on the chain. A free duration is an unknown
//! ([`crate::optimize::methods::interior_point`]).
//!
//! The plan has a uniform grid with its inputs at the nodes, like a minimum-effort plan. Switching
//! times in continuous time are computed from the plan by `search/limited` where possible.
//!
//! A constraint that is inactive does not change the optimum. If the cheapest plan of arcs without
//! constraints, or a symmetric one, satisfies them all in its true motion, no plan that satisfies
//! them is cheaper. It is then the result, with its arcs and its gap.
//!
//! The result is a local minimum. Whether the cheapest local minimum found is the global one is not
//! known.
//!
//! # How is the duration an unknown?
//!
//! It is a state of the chain that no step changes (`optimize/chain/model`). All other quantities
//! are in units that scale with the duration. A step of a free body then does not depend on the
//! duration; boundary states, fields and limits do, and scale as `s`, `s²` and `s³`.
//!
//! # Which initial paths are used?
//!
//! Turns about a fixed axis, bent to six sides, and their detours around the cones that they cross
//! (`search/strategies/seeds`). If a force or a field acts, also the minimum-effort extremals
//! without limits.

use crate::Vector3;
use crate::flight::{Excess, Flight};
use crate::lie;
use crate::maneuver::constraint::Constraint;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Formulation, Motion, Problem, State, Stepping};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Solution, Trajectory};
use crate::mechanics::environment::Free;
use crate::optimize::chain::model::Goal;
use crate::optimize::search::context::Context;
use crate::optimize::search::given_duration::{search_of, searched};
use crate::optimize::search::ladder::Ask;
use crate::optimize::search::record::goal::{SAME_COST, cheapest};
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::first_duration;
use crate::optimize::search::strategies::chains::{resampled, unlimited_paths};
use crate::optimize::search::strategies::{advice, seeds};
use crate::optimize::search::switching;

/// Solves a minimum-time or minimum-fuel maneuver that depends on more than torque limits, or a
/// minimum-effort maneuver with a free duration.
pub fn solve(problem: &Problem, context: &Context, known: &Trajectory) -> Solution {
    let once = |problem: &Problem| match Formulation::of(problem) {
        Formulation::Extremal => {
            let ask = Ask { advise: true, lands: context.lands(), ..Ask::of_goal(None, context.settings) };
            searched(problem, context, ask)
        }
        _ if problem.objective.switches() => solve_once(problem, context, known),
        _ => effort_sought(problem, context),
    };
    match problem.duration.at_most() {
        Some(longest) => switching::up_to(longest, problem, context, &once),
        None => once(problem),
    }
}

/// Solves for minimum effort with the optimal duration. The search is local and starts from the
/// optimal duration of an unlimited turn about a fixed axis.
fn effort_sought(problem: &Problem, context: &Context) -> Solution {
    let longest = problem.duration.at_most().unwrap_or(f64::INFINITY);
    let free = first_duration::of_effort(problem, problem.objective.time_price());
    let stated = problem.clone().with_duration(free.min(longest));
    let stated = stated.with_objective(problem.objective.with_time_price(None));
    let unsolved = Solution::unsolved(problem, context.settings.tolerance);
    let mut solution = match stated.check() {
        Err(error) => Solution { shortfall: Some(Shortfall::Unusable(error)), ..unsolved },
        Ok(()) => of_stated(&stated, problem, context, &Trajectory::default()),
    };
    solution.ladder = context.ladder.take();
    solution.solve_time = context.began.elapsed().as_secs_f64();
    solution
}

/// Solves for a given duration, or for the optimal one.
fn solve_once(problem: &Problem, context: &Context, known: &Trajectory) -> Solution {
    let unsolved = Solution::unsolved(problem, context.settings.tolerance);
    let mut bare = bare(problem);
    // Only a free body without translation has a bang-bang plan. In a rotating frame or in a force
    // field, the plan of that free body is an initial path.
    let free = problem.is_free_turn();
    let open = problem.ends_in_any_attitude();
    if open {
        bare.end.attitude = bare.start.attitude;
    }
    // With a free terminal attitude no bang-bang plan is computed, unless the body already has the
    // terminal rate.
    let arrived = problem.start.angular_velocity == problem.end.angular_velocity;
    let mut within = None;
    // A bang-bang plan is the result if it satisfies all constraints, or if the body is already at
    // the end.
    let unconstrained =
        problem.motion == Motion::Attitude && (!open || arrived) && may_be_unconstrained(problem);
    let there = arrived && !open && problem.start.attitude == problem.end.attitude && free;
    let quick = if unconstrained {
        let bare = without_field(bare);
        let found = switching::solve_unconstrained(&bare, context, &|plan| keeps_all(problem, plan));
        within = found.within;
        let solved = found.cheapest.outcome == Outcome::Converged;
        if solved { found.cheapest } else { unsolved.clone() }
    } else if there {
        switching::solve_discrete(&bare, context)
    } else {
        unsolved.clone()
    };
    *context.ladder.borrow_mut() = if free { quick.ladder.clone() } else { Vec::new() };
    if free && quick.trajectory.time.len() == 1 {
        // The body is already at its terminal state.
        let stored = problem.actuation.wheels.iter().flat_map(|wheels| wheels.momentum.clone()).collect();
        let trajectory = Trajectory { wheel_momentum: stored, ..quick.trajectory };
        return Solution { trajectory, ..quick };
    }
    // A plan with more constraints cannot be cheaper than the cheapest plan without them.
    let is_cheapest = |plan: &Solution| {
        let cost = plan.landing.as_ref().map_or(plan.cost, |landing| landing.cost_before);
        cost <= quick.cost * (1.0 + SAME_COST) && !switching::is_dear(plan)
    };
    if let Some(answer) = within.take_if(|plan| is_cheapest(plan)) {
        return answer;
    }
    let sought = problem.duration.known().is_none();
    let stated = quick.trajectory.time.last().copied().filter(|_| sought && free);
    let path = if known.time.len() > 1 { known } else { &quick.trajectory };
    let duration = stated.or(problem.duration.known()).unwrap_or_else(|| first_duration::of_time(problem));
    let stated = Problem { objective: Objective::default(), ..problem.clone().with_duration(duration) };
    // The problem is checked with its own objective, because effort has fewer requirements than
    // time and fuel.
    let mut solution = match (problem.clone().lasting(duration).check(), context.interrupt()) {
        (_, Some(stopped)) => Solution { outcome: stopped, ..unsolved },
        (Err(error), _) => Solution { shortfall: Some(Shortfall::Unusable(error)), ..unsolved },
        (Ok(()), None) => of_stated(&stated, problem, context, path),
    };
    if let Some(within) = within
        && !(solution.outcome == Outcome::Converged && solution.cost <= within.cost)
    {
        solution = within;
    }
    solution.ladder = context.ladder.take();
    solution.solve_time = context.began.elapsed().as_secs_f64();
    solution
}

/// Returns the maneuver without its constraints and without rate limits of its inputs.
fn bare(problem: &Problem) -> Problem {
    Problem {
        constraints: Vec::new(),
        actuation: problem.actuation.of_jumping_inputs(),
        stepping: Stepping::Formulated,
        ..problem.clone()
    }
}

/// Returns whether the maneuver without its constraints has bang-bang plans, one of which may also
/// solve the maneuver.
fn may_be_unconstrained(problem: &Problem) -> bool {
    problem.stepping == Stepping::Formulated && problem.clone().planned_on_arcs().switches()
}

/// Returns whether a bang-bang plan satisfies all constraints of a maneuver: in its discrete motion
/// at the nodes, and in its true motion at all times.
fn keeps_all(problem: &Problem, plan: &Solution) -> bool {
    let planned = plan.on_grid(&problem.clone().planned_on_arcs());
    if plan.outcome != Outcome::Converged {
        return false;
    }
    let found = &plan.trajectory;
    let frame_rate = planned.environment.frame_rate();
    let at_nodes = found.quaternion.iter().zip(&found.angular_velocity).zip(&found.time);
    let keeps = |((quaternion, rate), time): ((&[f64; 4], &Vector3), &f64)| {
        let attitude = lie::rotation_from_quaternion(quaternion);
        let violated =
            |rule: &Constraint| rule.violation(&attitude, rate, Some(*time), &frame_rate).is_some();
        !planned.constraints.iter().any(violated)
    };
    let Some(mut excess) = Excess::of(&planned) else { return true };
    let steps = Flight::of_plan(&planned, found);
    let flown = Flight::new(&planned).fly(&steps, Some(&mut excess));
    at_nodes.into_iter().all(keeps) && flown.is_some() && excess.worst.iter().all(|worst| *worst <= 0.0)
}

/// Returns the rotation-only maneuver of a free body, with the boundary rates relative to the
/// reference frame.
fn without_field(problem: Problem) -> Problem {
    let rate = problem.environment.frame_rate();
    let relative = |state: &State| State {
        angular_velocity: state.angular_velocity - state.attitude.tr_mul(&rate),
        ..*state
    };
    let (start, end) = (relative(&problem.start), relative(&problem.end));
    Problem { start, end, ..problem }.with_environment(Free)
}

/// Solves a minimum-time or minimum-fuel maneuver, or a minimum-effort one with a free duration.
/// The duration of `stated` is the unit of time.
fn of_stated(stated: &Problem, problem: &Problem, context: &Context, quick: &Trajectory) -> Solution {
    match stated.motion {
        Motion::Attitude => of_dimension::<6>(stated, problem, context, quick),
        Motion::RigidBody => of_dimension::<12>(stated, problem, context, quick),
    }
}

/// Solves the maneuver with tangent vectors of dimension `N`.
fn of_dimension<const N: usize>(
    stated: &Problem,
    problem: &Problem,
    context: &Context,
    quick: &Trajectory,
) -> Solution {
    let objective = &problem.objective;
    let goal = Goal { objective: objective.clone() };
    let advise = !objective.counts_time();
    let lands = context.lands() || stated.met().is_some();
    let longest = problem.duration.at_most().unwrap_or(f64::INFINITY);
    let ask = Ask { advise, lands, longest, ..Ask::of_goal(Some(goal), context.settings) };
    let search = search_of::<N>(stated, context, ask.clone());
    let coarse = search.chain(chain_steps(stated));
    let mut paths = resampled(&coarse, objective.name(), quick);
    if !stated.ends_in_any_attitude() {
        let turns = seeds::of(&search, coarse.model.steps, context.settings.search);
        paths.extend(turns);
    }
    if stated.ends_in_any_attitude() || !stated.is_free_turn() {
        paths.extend(unlimited_paths(&search, &coarse));
    }
    let search = search.of(stated, Ask { paths: &paths, ..ask });
    let (found, cheapest) = cheapest(&search);
    let Some(cheapest) = cheapest else {
        // A plan that did not converge may have a duration that no plan has.
        let missed = found.missed();
        let mut unsolved = Solution {
            method: Method::InteriorPoint,
            outcome: context.interrupt().or(missed.map(|missed| missed.outcome)).unwrap_or(Outcome::Stalled),
            shortfall: missed.and_then(|missed| missed.shortfall.clone()),
            ..Solution::unsolved(stated, context.settings.tolerance)
        };
        if advise {
            advice::advise(&search, found.shortest, &mut unsolved);
        }
        return unsolved;
    };
    cheapest.written(&search, &found)
}
