//! Choice of the number of steps, for a maneuver that gives none.
//!
//! A plan that lands holds its inputs over steps, and two conditions require short steps.
//!
//! - **Corrections must converge** (`optimize::landing`): they contract by the relative difference
//!   of the discrete and the true sensitivities, `O(h²)`. If they do not converge, the steps are
//!   halved.
//! - **The cost must be near the continuous optimum.** Held inputs approximate the optimal inputs u
//!   by their means ū. For a plan that meets the end the first variation vanishes, and the
//!   remaining cost is, to second order,
//!
//! ```text
//! ΔJ = ½ ∫ (u − ū)ᵀW (u − ū) dt = (h²/24) ∫ u̇ᵀW u̇ dt = (h/12) Σ_k ½ δ_kᵀW δ_k ,   δ_k = u_{k+1} − u_k
//! ```
//!
//!   The stated cost of a Lie–Verlet plan is the trapezoidal sum over its nodes, which exceeds the
//!   effort of the held means by `(h/4) Σ_k ½ δ_kᵀW δ_k`: together `h/3` (a turn from rest to rest
//!   about one axis: `ΔJ/J = 4/N²`). Plans with switching inputs state the cost of the extremal in
//!   continuous time. For minimum time and fuel on a uniform grid, where an input jumps within a
//!   step, no such formula holds: the difference from the optimum on half of the steps estimates
//!   the error, as for first order (`search/record/continuous`).
//!
//! A given number of steps is not changed. A coarser plan that lands is kept if a finer one does
//! not land, or costs more.

use crate::maneuver::objective::effort;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Method, Settings};
use crate::maneuver::solution::{ChosenSteps, Outcome, Solution};
use crate::optimize::landing;
use crate::optimize::search::outer::Inner;
use crate::optimize::search::starts::first_duration;
use crate::optimize::search::{Guess, Observer, PlanError};
use std::time::{Duration, Instant};

/// Largest relative excess of the cost over the continuous optimum: below the accuracy to which
/// torques are known.
const COST: f64 = 1e-3;

/// Factor on the number of steps: a reserve for terms of higher order on coarse grids, which the
/// estimate of the excess omits.
const RESERVE: f64 = 1.1;

/// Largest number of steps that this module chooses; a user may request more. A plan with this
/// number takes seconds.
const MOST: usize = 20_000;

/// Largest number of steps that this module chooses for plans whose error is of first order in the
/// step. Reducing the error from a hundredth to a thousandth would take ten times the steps.
const MOST_OF_FIRST_ORDER: usize = 1_000;

/// Largest rotation of a body in one step \[rad\] with which the step still approximates the motion.
/// If a body turns farther and no plan is found, the number of steps is increased.
const TURN: f64 = 0.3;

/// Solves a maneuver on as many steps as it needs, starting from [`Problem::steps`].
pub fn chosen(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
    inner: Inner,
) -> Result<Solution, PlanError> {
    let began = Instant::now();
    let mut best: Option<Solution> = None;
    let mut steps = problem.steps;
    let mut missed = f64::INFINITY;
    let mut known: Option<Guess> = None;
    while let Some(left) = remaining(settings, began) {
        // The optimum on one grid is the initial guess on a finer one.
        let plan = best.as_ref().filter(|_| known.is_some());
        let method = plan.map_or(Method::Auto, |plan| plan.method);
        let on = problem.clone().planned_by(method).with_steps(steps);
        let mut found = match inner(&on, &left, known.as_ref().or(guess), observer) {
            Err(error) if best.is_none() => return Err(error),
            // If a grid has too many steps for the method, the choice ends.
            Err(_) => break,
            Ok(found) => found,
        };
        let before = best.take();
        if let Some(before) = &before {
            found.ladder.splice(0..0, before.ladder.iter().cloned());
            if known.is_some() && found.rivals.is_empty() {
                found.rivals.clone_from(&before.rivals);
            }
        }
        if found.outcome != Outcome::Converged {
            let stalled = found.outcome == Outcome::Stalled;
            // If the finer grid has no plan, the plan on the coarser grid is kept.
            best = before.or(Some(found));
            let turning = turning(problem);
            if stalled && steps < turning {
                steps = turning;
                continue;
            }
            break;
        }
        let is_of_chain = problem.objective.switches() || found.method == Method::InteriorPoint;
        known = is_of_chain.then(|| Guess::of_solution(&found));
        let flown = found.on_grid(problem);
        let left = landing::left(&flown, &found.trajectory);
        // Halved steps at least halve the terminal error, even for a first-order scheme.
        let (lands, nearer) = (left <= landing::MET, left <= 0.5 * missed);
        missed = left;
        let estimate = cost_error(&on, &found);
        found.chosen = Some(ChosenSteps {
            began: problem.steps,
            lands,
            cost_error: estimate.as_ref().map(|estimate| estimate.error),
        });
        // The cost of a landed plan is its true cost on any grid. A plan on a finer grid that costs
        // more is another optimum.
        let kept = before.filter(|before| {
            let landed = before.chosen.is_some_and(|chosen| chosen.lands);
            landed && (!lands || before.cost < found.cost)
        });
        if let Some(before) = kept {
            best = Some(before);
            break;
        }
        best = Some(found);
        let first_order = estimate.as_ref().is_some_and(|estimate| estimate.order < 2.0);
        let for_cost = estimate.filter(|estimate| estimate.error > COST);
        let for_cost = for_cost.map(|Estimate { error, order }| {
            (steps as f64 * (error / COST).powf(order.recip()) * RESERVE).ceil() as usize
        });
        // If more steps do not reduce the terminal error, no number of steps will.
        let for_landing = (!lands && nearer).then_some(2 * steps);
        let Some(next) = for_cost.into_iter().chain(for_landing).max() else { break };
        let most = if first_order { MOST_OF_FIRST_ORDER.max(problem.steps) } else { MOST };
        if steps >= most {
            break;
        }
        steps = next.min(most);
    }
    let mut solution = match best {
        Some(solution) => solution,
        // No time is left.
        None => inner(problem, settings, guess, observer)?,
    };
    solution.solve_time = solution.solve_time.max(began.elapsed().as_secs_f64());
    Ok(solution)
}

/// Returns the smallest number of steps for which a body that spins at the start or the end turns
/// by at most [`TURN`] in a step.
fn turning(problem: &Problem) -> usize {
    let rates = [&problem.start, &problem.end].map(|end| end.angular_velocity.norm());
    let seconds = problem.duration.known().unwrap_or_else(|| first_duration::of_time(problem));
    let steps = rates[0].max(rates[1]) * seconds / TURN;
    if steps < MOST_OF_FIRST_ORDER as f64 { steps.ceil() as usize } else { MOST_OF_FIRST_ORDER }
}

/// Returns the settings with the remaining time; `None` if no time is left.
fn remaining(settings: &Settings, began: Instant) -> Option<Settings> {
    let Some(limit) = settings.time_limit else { return Some(settings.clone()) };
    let left = limit.saturating_sub(began.elapsed());
    (left > Duration::ZERO).then(|| Settings { time_limit: Some(left), ..settings.clone() })
}

/// Estimated relative excess of the cost over the continuous optimum, and its order in the step.
struct Estimate {
    error: f64,
    order: f64,
}

/// Estimates the excess of the cost; `None` if that is impossible, as for a plan of zero cost.
fn cost_error(problem: &Problem, found: &Solution) -> Option<Estimate> {
    let estimate =
        if let Some(switching) = found.switching.as_ref().filter(|_| found.on_grid(problem).switches()) {
            // Both values include the cost of the duration if time has a weight.
            let (discrete, continuous) = if problem.objective.is_duration() {
                (found.duration(problem), switching.continuous_duration_s)
            } else {
                (found.cost, switching.continuous_cost)
            };
            Estimate { error: ((discrete - continuous) / continuous).abs(), order: 2.0 }
        } else if problem.objective.switches() {
            let continuous = found.interior.as_ref()?.continuous?;
            Estimate { error: (continuous.error / found.cost).abs(), order: 1.0 }
        } else {
            Estimate { error: held_above(problem, found) / found.cost, order: 2.0 }
        };
    estimate.error.is_finite().then_some(estimate)
}

/// Returns `(h/12) Σ ½ δᵀW δ`, the excess of the cost of held inputs, or four times that if the
/// stated cost is a trapezoidal sum.
fn held_above(problem: &Problem, found: &Solution) -> f64 {
    let weights = problem.objective.weights();
    let (torque, force) = (weights.torque(&problem.actuation), weights.force(&problem.actuation));
    let plan = &found.trajectory;
    let rows = plan.input.len() / plan.input_count.max(1);
    let above = |row: usize| {
        let change: Vec<f64> =
            plan.inputs(row + 1).iter().zip(plan.inputs(row)).map(|(b, a)| b - a).collect();
        let (forces, torques) = problem.actuation.split_costs(&change);
        effort(&torque.weight, torques) + force.as_ref().map_or(0.0, |force| effort(&force.weight, forces))
    };
    let part = if problem.scheme.first_input() == 0 { 3.0 } else { 12.0 };
    found.step / part * (0..rows.saturating_sub(1)).map(above).sum::<f64>()
}
