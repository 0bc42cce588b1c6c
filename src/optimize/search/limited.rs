//! A plan within limits in continuous time: its cost and its arcs.
//!
//! The plan is a discrete optimum on a uniform grid. The error of its cost is `O(h²)`, with a
//! factor that depends on the positions of the switches between the nodes. On a grid with a node at
//! every event the error has an expansion in even powers of the step, because Lie–Verlet is
//! symmetric and its chain is variational. The plan is therefore optimised again on three such
//! grids, each with three times as many steps as the previous one ([`grids`]). Its cost and the
//! times of its events are extrapolated (Richardson extrapolation):
//!
//! ```text
//! C(h) = C + a h² + b h⁴ + … ,    C' = C(h/3) + (C(h/3) − C(h))/8 ,    C = C'(h/3) + (C'(h/3) − C'(h))/80
//! ```
//!
//! An event is a time at which an input switches, or at which the motion touches a cone
//! ([`events`]). The optimum on a grid with a node near the event indicates the exact time of the
//! event. This is a fixed-point iteration, which converges in a few rounds ([`fixed_point`]). No
//! exchange of arcs is cheaper, because an optimum of the interior-point method has multipliers of
//! the right sign at every node.
//!
//! # What of inputs that are at no limit?
//!
//! An input with more authority than necessary, such as forces if the rotation takes longer, has no
//! events. The cost does not depend on it.

mod events;
mod fixed_point;
mod grids;
mod settings;
#[cfg(test)]
mod tests;

use crate::maneuver::constraint::{Constraint, Rule};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Formulation, Motion, Problem, Scheme};
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::solution::{Outcome, Solution};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::mechanics::actuators::{ActuatorSet, LimitKind};
use crate::optimize::chain::model::Goal;
use crate::optimize::search::context::Context;
use events::{Event, Level};
use grids::{Grids, OnGrid, distance};
use settings::ON_EVENTS;
use std::cell::Cell;

/// Largest number of wheels whose torques are determined by a torque about all axes. More wheels
/// can divide a torque in many ways while a rate limit, a cone or a saturated wheel is active. Only
/// a thorough search then looks for arcs, because arcs are rarely found and the search takes long
/// (`slew plan -v --set solver.search=thorough` on a spec of `cargo run --release -p evidence --
/// everyday rate 0 1`).
const AXES: usize = 3;

/// Returns the plan with its arcs in continuous time, or the plan unchanged if no arcs are found.
pub(super) fn with_arcs(problem: &Problem, context: &Context, mut plan: Solution) -> Solution {
    // With an upper bound on the duration, the chain determines whether the plan takes the whole of
    // it.
    let converged = plan.outcome == Outcome::Converged && problem.duration.at_most().is_none();
    let formulation = Formulation::of(&problem.clone().planned_by(context.settings.method));
    let switches = formulation == Formulation::Chain && problem.objective.switches();
    if converged && switches && plan.switching.is_none() && may_have_arcs(problem) {
        let given = plan.on_grid(problem);
        plan.switching = arcs_of(&given, context, &plan);
        plan.solve_time += context.began.elapsed().as_secs_f64();
    }
    plan
}

/// Returns whether plans of a maneuver may have arcs that depend on more than torque limits and
/// that plan files can hold.
fn may_have_arcs(problem: &Problem) -> bool {
    let (torques, forces) = (&problem.actuation.torque, problem.actuation.force.as_ref());
    let moves = problem.motion == Motion::RigidBody;
    // Under a norm limit the direction turns smoothly, and the fuel of torques with rate limits is
    // not a sum over arcs.
    let within_limits_of_each = |set: &ActuatorSet| {
        let limits = set.limits();
        let ramps = limits.rate.is_some() && problem.objective.fuel().is_some();
        limits.size.is_some() && limits.norm.is_none() && !ramps
    };
    // A cone with given times becomes active or inactive between nodes.
    let at_all_times = |constraint: &Constraint| match &constraint.rule {
        Rule::Pointing(pointing) => pointing.during.given().is_none(),
        Rule::RateNorm(_) | Rule::RateAxes(_) => true,
    };
    (!problem.is_free_turn() || problem.has_shaping_limits())
        && problem.constraints.iter().all(at_all_times)
        && !problem.ends_in_any_attitude()
        && within_limits_of_each(torques)
        && forces.filter(|_| moves).is_none_or(within_limits_of_each)
        && problem.shortest_pulse().is_none()
}

/// Returns the arcs of a plan from the first attempt that finds them. The attempts use more and
/// more steps.
fn arcs_of(problem: &Problem, context: &Context, plan: &Solution) -> Option<Switching> {
    let thorough = context.settings.search == Thoroughness::Thorough;
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    if wheels > AXES && !plan.active.is_empty() && !thorough {
        return None;
    }
    let duration = plan.trajectory.time.last().copied().filter(|duration| *duration > 0.0)?;
    let goal = Goal { objective: problem.objective.clone() };
    let stated = problem.clone().with_duration(duration);
    let stated = Problem { scheme: Scheme::LieVerlet, objective: Objective::default(), ..stated };
    let most = if thorough { ON_EVENTS.steps.len() } else { ON_EVENTS.by_default };
    let left = Cell::new(if thorough { usize::MAX } else { ON_EVENTS.most });
    let attempts = ON_EVENTS.steps.iter().take(most).take_while(|_| context.interrupt().is_none());
    let mut arcs =
        attempts.filter_map(|steps| extrapolated_arcs(&stated, &goal, context, plan, (*steps, &left)));
    arcs.next()
}

/// Returns the arcs of a plan, extrapolated from three grids. The coarsest has `steps` steps.
fn extrapolated_arcs(
    stated: &Problem,
    goal: &Goal,
    context: &Context,
    plan: &Solution,
    steps: (usize, &Cell<usize>),
) -> Option<Switching> {
    let grids = Grids::of(stated, goal, context, steps);
    let coarse = grids.settled(&grids.first(&plan.trajectory)?, None)?;
    let counts = grids.counts(&coarse.events);
    let middle = grids.settled(&coarse, Some((&counts, 3)))?;
    // Event times have an expansion in even powers of the step, as costs have.
    let pairs = coarse.events.iter().zip(&middle.events);
    let ahead = pairs.map(|(a, b)| Event { at: b.at + (b.at - a.at) / 9.0, ..b.clone() }).collect();
    let fine = grids.settled(&middle.with_events(ahead), Some((&counts, 9)))?;
    let on = [&coarse, &middle, &fine];
    let (cost, error) = extrapolated(on.map(OnGrid::cost));
    if error > ON_EVENTS.error * cost || distance(&fine, &plan.trajectory) > ON_EVENTS.of_the_plan {
        return None;
    }
    let (stretch, _) = extrapolated(on.map(OnGrid::stretch));
    let duration = stated.seconds() * stretch;
    let time = |index: usize| extrapolated(on.map(|grid| grid.events[index].at)).0;
    let events: Vec<f64> = (0..fine.events.len()).map(time).collect();
    let (arcs, singular_inputs) = told(&grids, on, &events, duration)?;
    let structure = match goal.objective.fuel() {
        _ if arcs.iter().any(|arc| !arc.holds.is_empty()) => Structure::AlongLimits,
        _ if !singular_inputs.is_empty() => Structure::Singular,
        None => Structure::BangBang,
        Some(_) => Structure::BangOffBang,
    };
    Some(Switching {
        structure,
        continuous_duration_s: duration,
        continuous_cost: cost,
        gap: fine.gap()? * cost,
        eigenaxis_s: None,
        switches: arcs.windows(2).map(|pair| pair[0].switches_to(&pair[1])).sum(),
        singular_inputs,
        smoothing: None,
        beside_optimum: false,
        arcs,
        pulses: None,
    })
}

/// Returns the extrapolated limit of the values on three grids, and its estimated error. Each grid
/// has three times as many steps as the previous one.
fn extrapolated([coarse, middle, fine]: [f64; 3]) -> (f64, f64) {
    let [first, second] = [(coarse, middle), (middle, fine)].map(|(a, b)| b + (b - a) / 8.0);
    let limit = second + (second - first) / 80.0;
    (limit, (limit - second).abs())
}

/// Returns the arcs between events, whose times are fractions of the duration \[s\], and the inputs
/// that are between their limits on an arc without an active state limit. The value of such an
/// input is its mean on the arc.
fn told(
    grids: &Grids,
    on: [&OnGrid; 3],
    events: &[f64],
    duration: f64,
) -> Option<(Vec<SwitchingArc>, Vec<usize>)> {
    let fine = on[2];
    let reads = [grids.read(on[0])?, grids.read(on[1])?, grids.read(fine)?];
    let read = &reads[2];
    let ends = |inner: Vec<f64>| [vec![0.0], inner, vec![1.0]].concat();
    let (own, times) = (on.map(|grid| ends(grid.times())), ends(events.to_vec()));
    let mean = |input: usize, arc: usize| {
        let on_grid = |grid: usize| reads[grid].mean(input, own[grid][arc], own[grid][arc + 1]);
        extrapolated([0, 1, 2].map(on_grid)).0
    };
    let names = |groups: &mut dyn Iterator<Item = usize>| groups.map(|group| fine.name(group)).collect();
    let (touches, inputs) = (read.touches(), 0..fine.inputs());
    let rates = rates(grids.stated, fine.forces(), fine.inputs());
    let mut singular = vec![false; fine.inputs()];
    let mut arcs = Vec::new();
    for (arc, pair) in times.windows(2).enumerate() {
        let [from, to] = [own[2][arc], own[2][arc + 1]];
        let holds: Vec<String> = names(&mut read.held(from, to).into_iter());
        let (mut input, mut change) = (Some(Vec::new()), Vec::new());
        for index in inputs.clone() {
            let (level, slope) = read.middle(index, from, to);
            let ramps = rates[index] > 0.0;
            let value = match (level, slope) {
                (Level::At(level), slope) if !ramps || slope == Level::At(0.0) => Some(level),
                (_, Level::At(_)) if ramps => Some(read.value(index, from)),
                _ if holds.is_empty() => {
                    singular[index] = true;
                    Some(mean(index, arc))
                }
                _ => None,
            };
            input = input.zip(value).map(|(mut known, value)| {
                known.push(value * grids.size(index));
                known
            });
            change.push(if let Level::At(side) = slope { side * rates[index] } else { 0.0 });
        }
        let touched = touches.iter().filter(|(_, at, _)| (at - to).abs() < ON_EVENTS.apart);
        arcs.push(SwitchingArc {
            start_s: pair[0] * duration,
            end_s: pair[1] * duration,
            input: input.unwrap_or_default(),
            change: if rates.iter().any(|rate| *rate > 0.0) { change } else { Vec::new() },
            holds,
            touches: names(&mut touched.map(|(group, ..)| *group)),
        });
    }
    Some((arcs, inputs.filter(|input| singular[*input]).collect()))
}

/// Returns the rate limits of all inputs \[N·m/s or N/s\], zero if an input has none. The first
/// `forces` inputs are forces.
fn rates(problem: &Problem, forces: usize, inputs: usize) -> Vec<f64> {
    let mut rates = vec![0.0; inputs];
    for limit in problem.actuation.limits().filter(|limit| limit.kind == LimitKind::Rate) {
        let first = if limit.of_force { 0 } else { forces };
        for (rate, bound) in rates[first..].iter_mut().zip(limit.bounds) {
            *rate = *bound;
        }
    }
    rates
}
