//! Minimum time and fuel: the search for the best extremal, and the discrete optimum on the grid of the plan.

mod pulses;

use super::context::Context;
use crate::lie::{self, continued};
use crate::maneuver::duration::Duration;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Path, Problem};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{
    Landing, Optimality, Outcome, Rival, Rung, Sense, Solution, TerminalError, Trajectory,
};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::mechanics::drift_equation;
use crate::numerics::figures::rounded_up;
use crate::optimize::landing::{Aim, Next};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::switching::arcs::Arcs;
use crate::optimize::methods::switching::branches::Ask;
use crate::optimize::methods::switching::discretize::{LEAST_STEPS, arcs_on_grid, smooth_on_grid};
use crate::optimize::methods::switching::eigenaxis;
use crate::optimize::methods::switching::extremal::{Extremal, Law};
use crate::optimize::methods::switching::grid_step::Torque;
use crate::optimize::methods::switching::limit::{Found, Limit};
use crate::optimize::methods::switching::on_grid::{NO_LENGTH, OnGrid};
use crate::optimize::methods::switching::pulses::on_grid::{again, arcs_placed};
use crate::optimize::methods::switching::scaled::{Units, input_of, inputs, scaled, shared};
use crate::optimize::methods::switching::search::search;
use crate::optimize::methods::switching::smooth::Smoothed;
use crate::{Matrix3, Vector3};

/// Attitudes this near, and rates in the unit of time, are the same.
const SAME: f64 = 1e-14;

/// Costs that differ by this part are those of two extremals.
const DISTINCT: f64 = 1e-6;

/// A plan of arcs on the grid costs more than its extremal by this part at most, as a rule: what `O(h²)` is on some ten steps an arc.
pub(super) const OF_THE_GRID: f64 = 1e-3;

/// Multiples of the shortest duration that are tried for one of least fuel.
const STRETCHES: [f64; 3] = [1.02, 1.1, 1.5];

/// An input of a smoothed plan stays within its limits where it is within this part of them, on this part of the steps.
const WITHIN: f64 = 0.9;
const FOR: f64 = 1.0 / 12.0;

/// Arcs shorter than this part of the duration are none.
const NO_ARC: f64 = 1e-10;

/// Solves a maneuver of minimum time or fuel. It must have been checked.
///
/// Up to a longest duration the plan takes all of the time or, where a second has a price or the body moves at an end, the
/// duration at which the Hamiltonian vanishes.
pub(super) fn solve(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, true)
}

/// The same as a path to begin from, which need not land.
pub(super) fn solve_discrete(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, true, false)
}

/// The same by the smoothed law alone, to compare.
pub(super) fn solve_smoothed(problem: &Problem, context: &Context) -> Solution {
    solve_by(problem, context, false, false)
}

/// With arcs at the limits, or without.
fn solve_by(problem: &Problem, context: &Context, arcs: bool, lands: bool) -> Solution {
    let once = |problem: &Problem| solve_once(problem, context, arcs, lands);
    match problem.duration.at_most() {
        Some(longest) => up_to(longest, problem, context, &once),
        None => once(problem),
    }
}

/// Least effort or fuel up to a longest duration: all of it or, where a second has a price or the body cannot wait, the
/// duration sought, whichever is cheaper. `once` solves for a given duration, or for one that is sought.
pub(super) fn up_to(
    longest: f64,
    problem: &Problem,
    context: &Context,
    once: &dyn Fn(&Problem) -> Solution,
) -> Solution {
    let price = problem.objective.given_time_price().unwrap_or(0.0);
    let of = |time_price| problem.objective.with_time_price(time_price);
    let mut all = once(&problem.clone().with_duration(longest).with_objective(of(None)));
    all.pay_for_time(price * longest);
    if context.interrupt().is_some() || problem.can_wait() && price == 0.0 {
        return all;
    }
    let sought = problem.clone().with_duration_at_most(longest).with_objective(of(Some(price)));
    let sought = once(&sought);
    let is_plan = |solution: &Solution| solution.outcome == Outcome::Converged;
    let stopped = matches!(sought.outcome, Outcome::Interrupted | Outcome::TimeLimit);
    // The grid's own duration too: it is off the continuous one by the square of the step.
    let within = sought.trajectory.time.last().is_some_and(|duration| *duration <= longest);
    let cheaper = is_plan(&sought) && within && !(is_plan(&all) && all.cost <= sought.cost);
    let chosen = if cheaper || stopped && !is_plan(&all) { sought } else { all };
    Solution { solve_time: context.began.elapsed().as_secs_f64(), ..chosen }
}

/// In a given duration, or in the best one of all.
fn solve_once(problem: &Problem, context: &Context, arcs: bool, lands: bool) -> Solution {
    let tolerance = context.settings.tolerance;
    let mut solution = Solution { method: Method::Shooting, ..Solution::unsolved(problem, tolerance) };
    let Some((extremal, units)) = scaled(problem) else {
        solution.outcome = Outcome::NotFinite;
        return solution;
    };
    let apart = lie::log(&extremal.end_attitude).norm() + (extremal.end_rate - extremal.start_rate).norm();
    let stays = match problem.path {
        Path::Long => false,
        Path::AsGiven(rotation) => rotation.norm() < SAME,
        Path::Best | Path::Shortest => true,
    };
    if apart < SAME && stays {
        let resting = problem.start.angular_velocity.norm() * units.time < SAME;
        match extremal.given_duration {
            None => return at_rest(problem, solution, 0),
            Some(_) if resting => return at_rest(problem, solution, problem.steps),
            Some(_) => {}
        }
    }
    let ask = Ask { path: problem.path, thoroughness: context.settings.search, arcs };
    context.enter(Rung::Smoothed, "best", 0);
    let found = search(&extremal, &ask, &|| context.interrupt().is_some());
    let report = |outcome, iterations| Report { outcome, iterations, residuals: Vec::new() };
    let smoothed = if found.branches == 0 { Outcome::Stalled } else { Outcome::Converged };
    context.note(Rung::Smoothed, "all", 0, report(smoothed, found.sweeps));
    if found.branches > 0 {
        let polished = if found.limits.is_empty() { Outcome::Stalled } else { Outcome::Converged };
        context.note(Rung::Switches, "all", 0, report(polished, found.newtons));
    }
    if let Some(outcome) = context.interrupt() {
        return ended(solution, outcome, context);
    }
    if let Some(shortest) = problem.shortest_pulse() {
        return pulses::solve(problem, (&extremal, &units), &found, shortest, context, solution, lands);
    }
    let (mut chosen, mut chosen_limit) = (None, None);
    // A bound of what is sought; what is given has none.
    let longest = problem.duration.at_most().filter(|_| extremal.given_duration.is_none());
    let allowed = |limit: &&Limit| longest.is_none_or(|longest| limit.duration() * units.time <= longest);
    for limit in found.limits.iter().filter(allowed) {
        // Extremals come cheapest first: the next is of use where the plan of the last is dearer than its grid accounts for.
        let beats = |plan: &Planned| limit.cost(&extremal) * units.cost() < plan.cost * (1.0 - OF_THE_GRID);
        if !chosen.as_ref().is_none_or(beats) || context.interrupt().is_some() {
            break;
        }
        context.enter(Rung::Aligned, limit.name(), problem.steps);
        let plan = cheapest(problem, &extremal, &units, limit);
        let outcome = if plan.is_some() { Outcome::Converged } else { Outcome::Stalled };
        let iterations = plan.as_ref().map_or(0, |plan| plan.iterations);
        let residuals = plan.iter().map(|plan| plan.residual).collect();
        context.note(Rung::Aligned, limit.name(), problem.steps, Report { outcome, iterations, residuals });
        if let Some(plan) = plan
            && follows(problem, &plan)
            && chosen.as_ref().is_none_or(|best: &Planned| plan.cost < best.cost)
        {
            (chosen, chosen_limit) = (Some(plan), Some(limit));
        }
    }
    let Some(mut plan) = chosen else {
        let arcs = found.limits.iter().find_map(|limit| limit.arcs.as_ref());
        let arcs = arcs.map(|(arcs, _)| arcs.switches.len() + 1);
        if !shortest_told(problem, &found, context, &mut solution) {
            solution.shortfall = Some(match arcs {
                Some(arcs) if arcs * LEAST_STEPS > problem.steps => {
                    Shortfall::FewSteps { arcs, steps: arcs * LEAST_STEPS }
                }
                _ if found.branches == 0 => Shortfall::NoSmoothedExtremal,
                _ => Shortfall::NoDiscreteOptimum { steps: problem.steps },
            });
        }
        return ended(solution, Outcome::Stalled, context);
    };
    if lands && context.lands() {
        let afresh = |aimed: &Extremal| cheapest(problem, aimed, &units, chosen_limit?);
        plan = landed(problem, &extremal, &units, plan, &afresh);
    }
    if problem.objective.fuel().is_none() {
        let eigenaxis = found.eigenaxis.or_else(|| eigenaxis::duration(&extremal));
        plan.switching.eigenaxis_s = eigenaxis.map(|duration| duration * units.time);
    }
    solution.rivals = rivals(&extremal, &found.limits, &plan, &units);
    finished(solution, plan, context)
}

/// A plan whose true motion meets the end as nearly as corrections bring it: solved again, warm or else `afresh`, for the extremal
/// that ends where the discrete motion has to.
fn landed(
    problem: &Problem,
    extremal: &Extremal,
    units: &Units,
    first: Planned,
    afresh: &dyn Fn(&Extremal) -> Option<Planned>,
) -> Planned {
    let mut aim = Aim::of(problem);
    let cost_before = first.cost;
    let (mut plan, mut target, mut best) = (first, problem.end, None);
    loop {
        let next = aim.correct(&plan.trajectory);
        if next == Next::GiveUp && best.is_some() {
            break;
        }
        plan.trajectory.target = Some(target);
        plan.landing = Some(Landing { cost_before, ..aim.told() });
        if next != Next::Correct {
            return plan;
        }
        target = aim.target;
        let aimed = Extremal {
            end_attitude: problem.start.attitude.tr_mul(&target.attitude),
            end_rate: units.time * target.angular_velocity,
            ..extremal.clone()
        };
        let warm = again(&plan.grid, &aimed).and_then(|grid| {
            let mut warm = record(problem, &aimed, units, &grid)?;
            let Switching { beside_optimum, .. } = warm.switching;
            warm.switching = Switching { beside_optimum, ..plan.switching.clone() };
            let kept = pulses::told_again(problem, &mut warm);
            warm.start.clone_from(&plan.start);
            kept.then_some(warm)
        });
        let Some(solved) = warm.or_else(|| afresh(&aimed)) else {
            return plan;
        };
        best = Some(std::mem::replace(&mut plan, solved));
    }
    best.unwrap_or(plan)
}

/// The solution that a plan on its grid is.
fn finished(mut solution: Solution, plan: Planned, context: &Context) -> Solution {
    solution.steps = plan.trajectory.time.len() - 1;
    solution.step = plan.duration / solution.steps as f64;
    solution.cost = plan.cost;
    solution.iterations = plan.iterations;
    solution.terminal = plan.terminal;
    solution.optimality =
        Optimality { tested: true, stationarity: plan.residual, rank: 6, ..Optimality::UNTESTED };
    solution.sense = plan.sense;
    solution.turned_deg = plan.turned_deg;
    solution.start = plan.start;
    solution.trajectory = plan.trajectory;
    solution.landing = plan.landing;
    solution.switching = Some(plan.switching);
    let outcome =
        if solution.terminal.largest() <= solution.tolerance { Outcome::Converged } else { Outcome::Stalled };
    ended(solution, outcome, context)
}

/// Tells the shortest duration, where that of a maneuver of fuel is too short.
fn shortest_told(problem: &Problem, found: &Found, context: &Context, solution: &mut Solution) -> bool {
    let quickest = problem.objective.fuel().and_then(|_| too_short(problem, found, context));
    let Some((shortest, longer)) = quickest else { return false };
    (solution.shortest, solution.longer) = (Some(shortest), longer);
    solution.shortfall = Some(Shortfall::TooShort { asked: problem.seconds(), shortest });
    true
}

/// The shortest duration of a maneuver of given duration that no extremal of fuel was found for, where that is longer,
/// and a duration for which one was found.
fn too_short(problem: &Problem, found: &Found, context: &Context) -> Option<(f64, Option<f64>)> {
    if found.branches > 0 || problem.seeks_duration() {
        return None;
    }
    let ask = Ask { path: problem.path, thoroughness: context.settings.search, arcs: true };
    let search = |problem: &Problem| {
        let (extremal, units) = scaled(problem)?;
        let found = search(&extremal, &ask, &|| context.interrupt().is_some());
        found.limits.first().map(|limit| limit.duration() * units.time)
    };
    let shortest =
        search(&Problem { objective: Objective::Time, duration: Duration::SOUGHT, ..problem.clone() })?;
    if shortest <= problem.seconds() {
        return None;
    }
    let mut durations = STRETCHES.into_iter().map(|stretch| rounded_up(stretch * shortest));
    let longer = durations.find(|duration| search(&problem.clone().with_duration(*duration)).is_some());
    Some((shortest, longer))
}

/// The dearer extremals, each cost once: mirror images cost the same.
fn rivals(extremal: &Extremal, limits: &[Limit], plan: &Planned, units: &Units) -> Vec<Rival> {
    let mut rivals: Vec<Rival> = Vec::new();
    let mut last = plan.switching.continuous_cost;
    for limit in limits {
        let cost = limit.cost(extremal) * units.cost();
        if cost > last * (1.0 + DISTINCT) {
            let (start, sense) = (limit.name().into(), plan.sense);
            rivals.push(Rival { start, sense, cost, conjugate_points: None, turned_deg: f64::NAN });
            last = cost;
        }
    }
    rivals
}

fn ended(solution: Solution, outcome: Outcome, context: &Context) -> Solution {
    let (ladder, solve_time) = (context.ladder.take(), context.began.elapsed().as_secs_f64());
    Solution { outcome, ladder, solve_time, ..solution }
}

/// The body is where it should be: no time and no steps, or as many of a given duration without any input.
fn at_rest(problem: &Problem, solution: Solution, steps: usize) -> Solution {
    let (nodes, count) = (steps + 1, problem.actuation.count());
    let (duration, step) = if steps == 0 { (0.0, 0.0) } else { (problem.seconds(), problem.step()) };
    let time = |node: usize| if node == steps { duration } else { node as f64 * step };
    let trajectory = Trajectory {
        time: (0..nodes).map(time).collect(),
        quaternion: vec![lie::quaternion_from_rotation(&problem.start.attitude); nodes],
        angular_velocity: vec![problem.start.angular_velocity; nodes],
        input_count: count,
        input: vec![0.0; steps * count],
        torque: vec![Vector3::zeros(); steps],
        costates: vec![0.0; 6 * nodes],
        ..Trajectory::default()
    };
    let switching = Switching {
        structure: Structure::Rest,
        continuous_duration_s: duration,
        continuous_cost: 0.0,
        gap: 0.0,
        eigenaxis_s: None,
        switches: 0,
        singular_inputs: Vec::new(),
        smoothing: None,
        beside_optimum: false,
        arcs: Vec::new(),
        pulses: None,
    };
    Solution {
        outcome: Outcome::Converged,
        steps,
        step,
        cost: 0.0,
        terminal: TerminalError::default(),
        optimality: Optimality {
            tested: true,
            stationarity: 0.0,
            conjugate_points: None,
            rank: 6,
            condition: 1.0,
        },
        turned_deg: 0.0,
        start: "rest".into(),
        trajectory,
        switching: Some(switching),
        ..solution
    }
}

/// A plan on its grid.
struct Planned {
    cost: f64,
    duration: f64,
    residual: f64,
    iterations: usize,
    terminal: TerminalError,
    sense: Sense,
    turned_deg: f64,
    start: String,
    trajectory: Trajectory,
    switching: Switching,
    /// Continuous quaternion from the start, at the end.
    sheet: [f64; 4],
    grid: OnGrid,
    landing: Option<Landing>,
}

/// The discrete optimum of the best arcs where they have room on the grid, or the nearest to it; otherwise that of the next looser
/// ones, or of the smoothed law if it is cheaper.
fn cheapest(problem: &Problem, extremal: &Extremal, units: &Units, limit: &Limit) -> Option<Planned> {
    let aligned = |limit: &Limit| {
        let (arcs, _) = limit.arcs.as_ref()?;
        // The discrete optimum may lack a pulse of the continuous one, or have its pulses in another order.
        let grid = arcs_on_grid(extremal, arcs, problem.steps)
            .or_else(|| arcs_placed(extremal, arcs, problem.steps))?;
        planned(problem, extremal, units, limit, grid, None)
    };
    if let Some(plan) = aligned(limit) {
        return Some(plan);
    }
    let looser = limit.loosened().find_map(|limit| aligned(&limit));
    let smooth = || {
        let least = limit.smooth.epsilon;
        let from = |smooth: &Smoothed| smooth_on_grid(extremal, smooth, least, problem.steps);
        let (grid, epsilon) = from(&limit.smooth).or_else(|| from(&limit.branch))?;
        // Of the arcs that it takes the place of it is none.
        let limit = Limit { arcs: None, ..limit.clone() };
        planned(problem, extremal, units, &limit, grid, Some(epsilon))
    };
    let cheaper = |a: &Planned, b: &Planned| a.cost.total_cmp(&b.cost);
    looser.into_iter().chain(smooth()).min_by(cheaper)
}

/// What a limit is on its grid; with ε where the inputs are smoothed there.
fn planned(
    problem: &Problem,
    extremal: &Extremal,
    units: &Units,
    limit: &Limit,
    grid: OnGrid,
    smoothing: Option<f64>,
) -> Option<Planned> {
    let arcs = limit.arcs.as_ref();
    let mut recorded = record(problem, extremal, units, &grid)?;
    recorded.switching.smoothing = smoothing;
    recorded.switching.continuous_duration_s = limit.duration() * units.time;
    recorded.switching.continuous_cost = limit.cost(extremal) * units.cost();
    recorded.start = limit.name().into();
    let switching = &mut recorded.switching;
    if let Some((arcs, certificate)) = arcs {
        let exact = limit.is_exact(extremal);
        switching.structure = match (exact, problem.objective.fuel()) {
            (true, None) => Structure::BangBang,
            (true, Some(_)) => Structure::BangOffBang,
            (false, _) => Structure::TruncatedChattering,
        };
        switching.gap = certificate.gap * units.cost();
        switching.switches = arcs.switches.len();
        if !exact && !extremal.axes().is_empty() {
            let inputs = certificate.singular().into_iter().map(|level| input_of(problem, level));
            switching.singular_inputs = inputs.collect();
            switching.singular_inputs.dedup();
        }
        switching.arcs = told(problem, extremal, units, arcs);
    } else {
        // A sum of terms that are not negative but for round-off.
        let gap = limit.smooth.gap(extremal) * units.cost();
        switching.gap = if gap < 0.0 { 0.0 } else { gap };
        let norm = matches!(extremal.law, Law::Norm(_)) && !extremal.counts_fuel();
        switching.structure = if norm { Structure::Norm } else { Structure::Singular };
    }
    Some(recorded)
}

/// Arcs with the inputs of the maneuver, in seconds. Inputs that switch together do so at one time: what round-off leaves
/// between them is no arc.
fn told(problem: &Problem, extremal: &Extremal, units: &Units, arcs: &Arcs) -> Vec<SwitchingArc> {
    let least = NO_ARC * arcs.duration * units.time;
    let arc = |(_, start, end, signs): (_, f64, f64, Vec<f64>)| {
        let input = match (extremal.axes(), extremal.on_arc(&signs).held()) {
            (_, None) => Vec::new(),
            ([], Some(_)) => vec![0.0; problem.actuation.count()],
            (_, Some(_)) => inputs(problem, &signs),
        };
        SwitchingArc { start_s: start * units.time, end_s: end * units.time, input }
    };
    let mut told: Vec<SwitchingArc> = arcs.arcs().into_iter().map(arc).collect();
    told.retain(|arc| arc.end_s - arc.start_s > least);
    for index in 1..told.len() {
        told[index].start_s = told[index - 1].end_s;
    }
    told
}

/// Terminal errors above this, half of the default tolerance, are taken for those of the last digits of recorded times.
const OF_THE_CLOCK: f64 = 5e-13;

/// Replays a plan from the start and records every node.
///
/// In a long duration a burn is so short that the last digits of the recorded times are a part of it that matters: then inputs are
/// recorded that give the impulse of the plan in the time that is recorded, and are off their limits by these digits.
fn record(problem: &Problem, extremal: &Extremal, units: &Units, grid: &OnGrid) -> Option<Planned> {
    let plain = replayed(problem, extremal, units, grid, false)?;
    // Pulses are off or at a limit, to the last bit.
    if plain.terminal.largest() <= OF_THE_CLOCK || problem.shortest_pulse().is_some() {
        return Some(plain);
    }
    let exact = replayed(problem, extremal, units, grid, true)?;
    Some(if exact.terminal.largest() < plain.terminal.largest() { exact } else { plain })
}

/// The same with the inputs of the plan, or with its impulses.
fn replayed(
    problem: &Problem,
    extremal: &Extremal,
    units: &Units,
    grid: &OnGrid,
    impulses: bool,
) -> Option<Planned> {
    let start = &problem.start.attitude;
    let least = NO_LENGTH * grid.duration();
    let kept: Vec<usize> =
        (0..grid.steps.len()).filter(|k| grid.step_length(&grid.steps[*k]) > least).collect();
    let count = problem.actuation.count();
    let mut trajectory = Trajectory { input_count: count, ..Trajectory::default() };
    let (mut r, mut pi) = (Matrix3::identity(), extremal.j * extremal.start_rate);
    let (mut m_e, mut quaternion) = ((grid.m, grid.nodes[0].e), None);
    let (mut sheet, mut clock) = ([1.0, 0.0, 0.0, 0.0], 0.0);
    let (mut within, mut cost) = (vec![0_usize; count], 0.0);
    let rate = |row: &[f64]| problem.objective.fuel().map_or(1.0, |fuel| fuel.rate(&problem.actuation, row));
    let (j, turning) = (extremal.j, extremal.axes().is_empty());
    for index in 0..=kept.len() {
        let attitude = start * r;
        let next = continued(quaternion.as_ref(), lie::quaternion_from_rotation(&attitude));
        quaternion = Some(next);
        trajectory.time.push(clock * units.time);
        trajectory.quaternion.push(next);
        trajectory.angular_velocity.push(extremal.j_inverse * pi / units.time);
        let (zeta, e) = m_e;
        trajectory.costates.extend((zeta * units.cost()).iter());
        trajectory.costates.extend((e * (units.cost() / units.momentum())).iter());
        let Some(k) = kept.get(index).copied() else { break };
        let step = &grid.steps[k];
        let row = match (grid.signs.get(step.arc), step.torque) {
            (Some(signs), _) if !turning => inputs(problem, signs),
            (None, Torque::Smooth(epsilon)) if !extremal.axes().is_empty() => {
                let mean = 0.5 * (grid.nodes[k].e + grid.nodes[k + 1].e);
                let levels = extremal.inputs(&mean, epsilon);
                for (level, value) in levels.iter().enumerate() {
                    within[input_of(problem, level)] += usize::from(value.abs() < WITHIN);
                }
                inputs(problem, &levels)
            }
            _ => shared(problem, units, &grid.torques[k])?,
        };
        let length = grid.step_length(step);
        // The step as the witnesses will take it: of the length that the recorded times give.
        clock += length;
        let h = (clock * units.time - trajectory.time[index]) / units.time;
        let row: Vec<f64> =
            if impulses { row.iter().map(|input| input * (length / h)).collect() } else { row };
        cost += if impulses { h } else { length } * units.time * rate(&row);
        let torque = problem.actuation.torque.output(&row);
        trajectory.input.extend(&row);
        trajectory.torque.push(torque);
        let torque = torque / units.torque;
        let kicked = pi + 0.5 * h * torque;
        let c = drift_equation::solve(&j, &extremal.j_inverse, &(h * kicked))?;
        let f = lie::cayley(&c);
        let turn = lie::quaternion_from_rotation(&f);
        sheet = product(&sheet, &if turn[0] < 0.0 { turn.map(|part| -part) } else { turn });
        r *= f;
        pi = f.tr_mul(&kicked) + 0.5 * h * torque;
        let node = &grid.nodes[k + 1];
        m_e = (node.r.tr_mul(&grid.m), node.e);
    }
    // `∫|Ω|dt` of the nodes, as everywhere.
    let rate = |node: usize| trajectory.angular_velocity[node].norm();
    let of_step = |k: usize| 0.5 * (trajectory.time[k + 1] - trajectory.time[k]) * (rate(k) + rate(k + 1));
    let turned = (0..kept.len()).map(of_step).sum::<f64>();
    let miss = lie::log(&extremal.end_attitude.tr_mul(&r)).norm();
    let scaled_duration = grid.duration();
    let mean = j.trace() / 3.0;
    let momentum = (pi - j * extremal.end_rate).norm() * scaled_duration / mean;
    let steps = kept.len() as f64;
    let singular_inputs = (0..count).filter(|input| within[*input] as f64 > FOR * steps).collect();
    let switching = Switching {
        structure: Structure::BangBang,
        continuous_duration_s: f64::NAN,
        continuous_cost: f64::NAN,
        gap: f64::NAN,
        eigenaxis_s: None,
        switches: 0,
        singular_inputs,
        smoothing: None,
        beside_optimum: grid.beside_optimum,
        arcs: Vec::new(),
        pulses: None,
    };
    let duration = *trajectory.time.last()?;
    Some(Planned {
        // The clock of the last node is what the duration is everywhere.
        cost: if problem.objective.fuel().is_some() { cost } else { duration },
        duration,
        residual: grid.residual,
        iterations: grid.iterations,
        terminal: TerminalError {
            attitude_rad: miss,
            momentum_relative: momentum,
            position_relative: None,
            linear_momentum_relative: None,
        },
        sense: sense(extremal, scaled_duration, &sheet),
        turned_deg: turned.to_degrees(),
        start: String::new(),
        trajectory,
        switching,
        sheet,
        grid: grid.clone(),
        landing: None,
    })
}

fn product(a: &[f64; 4], b: &[f64; 4]) -> [f64; 4] {
    let (v, w) = (Vector3::new(a[1], a[2], a[3]), Vector3::new(b[1], b[2], b[3]));
    let u = a[0] * w + b[0] * v + v.cross(&w);
    [a[0] * b[0] - v.dot(&w), u.x, u.y, u.z]
}

fn unit_quaternion(vector: &Vector3) -> [f64; 4] {
    let half = 0.5 * vector.norm();
    let sinc = if half > 1e-9 { half.sin() / half } else { 1.0 };
    let v = 0.5 * sinc * vector;
    [half.cos(), v.x, v.y, v.z]
}

/// Short if the path ends on the sheet that the motion without inputs reaches by the shortest rotation to the end.
fn sense(extremal: &Extremal, duration: f64, sheet: &[f64; 4]) -> Sense {
    const STEPS: usize = 256;
    let h = duration / STEPS as f64;
    let mut pi = extremal.j * extremal.start_rate;
    let (mut free, mut r) = ([1.0, 0.0, 0.0, 0.0], Matrix3::identity());
    for _ in 0..STEPS {
        let Some(c) = drift_equation::solve(&extremal.j, &extremal.j_inverse, &(h * pi)) else { break };
        let f = lie::cayley(&c);
        free = product(&free, &unit_quaternion(&lie::log(&f)));
        (r, pi) = (r * f, f.tr_mul(&pi));
    }
    let rest = lie::log(&r.tr_mul(&extremal.end_attitude));
    let expected = product(&free, &unit_quaternion(&rest));
    let same = expected.iter().zip(sheet).map(|(a, b)| a * b).sum::<f64>() > 0.0;
    if same { Sense::Short } else { Sense::Long }
}

/// Whether a plan goes the way that is asked for.
fn follows(problem: &Problem, plan: &Planned) -> bool {
    match problem.path {
        Path::Best => true,
        Path::Shortest => plan.sense == Sense::Short,
        Path::Long => plan.sense == Sense::Long,
        Path::AsGiven(vector) => {
            let given = unit_quaternion(&vector);
            given.iter().zip(&plan.sheet).map(|(a, b)| a * b).sum::<f64>() > 0.0
        }
    }
}
