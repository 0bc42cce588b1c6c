//! The arcs of a plan that more than limits of the torques shapes: what that of the chain on equal steps is in continuous time.

use super::context::Context;
use crate::maneuver::problem::{Formulation, Problem};
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::solution::{Outcome, Solution};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::optimize::methods::limited::exchange::{Optimum, improved};
use crate::optimize::methods::limited::motion::{Level, Maneuver};
use crate::optimize::methods::limited::newton::{Arcs, NO_LENGTH, Stationary};
use crate::optimize::methods::limited::structure::{self, Between};

/// Arcs whose cost differs from that of the plan by more than this part are those of another plan: a grid of some ten steps an arc is off
/// by less.
const OF_THE_PLAN: f64 = 1e-2;

/// Steps of the flow that the search for arcs may take by default: time against arcs that are not found
/// (`cargo run --release -p evidence -- limited_arcs`). A thorough search has no such limit.
const FLOW_STEPS: usize = 200_000;

/// Most wheels whose torques a torque about all axes determines. More wheels share it in many ways while a limit of the rates, a cone or a
/// full wheel acts. A thorough search alone looks for arcs then: time against arcs that are rarely found
/// (`slew plan -v --set solver.search=thorough` on a spec of `cargo run --release -p evidence -- everyday rate 0 1`).
const AXES: usize = 3;

/// Returns the plan with the arcs that it leads to, where these satisfy the maximum principle, and the same plan otherwise.
pub(super) fn with_arcs(problem: &Problem, context: &Context, mut plan: Solution) -> Solution {
    // Up to a longest duration it is the chain that knows whether all of it is used.
    let converged = plan.outcome == Outcome::Converged && problem.duration.at_most().is_none();
    let formulation = Formulation::of(&problem.clone().planned_by(context.settings.method));
    if converged && plan.switching.is_none() && formulation == Formulation::Chain {
        let given = plan.on_grid(problem);
        plan.switching = arcs_of(&given, context, &plan);
        plan.solve_time += context.began.elapsed().as_secs_f64();
    }
    plan
}

/// Returns the arcs that a plan leads to, where these satisfy the maximum principle.
fn arcs_of(problem: &Problem, context: &Context, plan: &Solution) -> Option<Switching> {
    let mut maneuver = Maneuver::of(problem)?;
    if context.settings.search != Thoroughness::Thorough {
        maneuver.most_steps = FLOW_STEPS;
    }
    let maneuver = &maneuver;
    let between = [Between::Pulses, Between::Means];
    let firsts: Vec<Arcs> =
        between.iter().filter_map(|between| structure::arcs(maneuver, plan, *between)).collect();
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let holds = firsts.iter().any(|arcs| arcs.laws.iter().any(|law| !law.holds.is_empty()));
    if wheels > AXES && holds && context.settings.search != Thoroughness::Thorough {
        return None;
    }
    let step = firsts.first()?.duration() / plan.steps as f64;
    let stop = || maneuver.is_spent() || context.interrupt().is_some();
    let Optimum { stationary: found, gap, chattering } = improved(maneuver, &firsts, step, &stop)?;
    let [cost, gap] = [found.followed.cost, gap].map(|scaled| scaled * maneuver.units.cost());
    let off = (cost - plan.cost).abs();
    // Arcs that chatter and have more to gain than they differ from the plan say less than that does.
    if off > OF_THE_PLAN * plan.cost || !chattering.is_empty() && gap > off {
        return None;
    }
    let arcs = told_arcs(maneuver, &found);
    let mut singular = [&chattering[..], &found.arcs.loose_inputs()].concat();
    singular.sort_unstable();
    singular.dedup();
    let structure = match problem.objective.fuel() {
        _ if !chattering.is_empty() => Structure::TruncatedChattering,
        _ if arcs.iter().any(|arc| !arc.holds.is_empty()) => Structure::AlongLimits,
        None => Structure::BangBang,
        Some(_) => Structure::BangOffBang,
    };
    Some(Switching {
        structure,
        continuous_duration_s: found.arcs.duration() * maneuver.units.time,
        continuous_cost: cost,
        gap,
        eigenaxis_s: None,
        switches: arcs.windows(2).map(|pair| pair[0].switches_to(&pair[1])).sum(),
        singular_inputs: singular,
        smoothing: None,
        beside_optimum: false,
        arcs,
        pulses: None,
    })
}

/// Arcs with the inputs of the maneuver, in seconds.
fn told_arcs(maneuver: &Maneuver, found: &Stationary) -> Vec<SwitchingArc> {
    let arcs = &found.arcs;
    let names = |limits: &[usize]| -> Vec<String> {
        limits.iter().map(|limit| maneuver.limits[*limit].name.clone()).collect()
    };
    let least = NO_LENGTH * arcs.duration();
    let mut told: Vec<SwitchingArc> = Vec::new();
    let mut end = 0.0;
    for (index, (law, length)) in arcs.laws.iter().zip(&arcs.lengths).enumerate() {
        let start_s = told.last().map_or(0.0, |last| last.end_s);
        end += length;
        let state = &found.followed.nodes[index];
        let input = law.levels.iter().zip(&maneuver.inputs).map(|(level, input)| match input.ramp {
            // Exactly what it holds, so that one arc has it from another.
            Some(ramp) if *level == Level::Free => {
                let of = |limit: &usize| maneuver.limits[*limit].ramp();
                let held = law.holds.iter().filter_map(of).find(|(number, _)| *number == ramp.number);
                held.map(|(_, side)| side * input.size)
            }
            Some(ramp) => Some(state.given(ramp.number) * input.size),
            None => Some(level.part()? * input.size),
        });
        // What holds its own limit does not change.
        let change = law.levels.iter().zip(&maneuver.inputs);
        let change = change
            .map(|(level, input)| input.ramp.map_or(0.0, |ramp| level.part().unwrap_or(0.0) * ramp.limit));
        let ramps = maneuver.ramps().next().is_some();
        let arc = SwitchingArc {
            start_s,
            end_s: end * maneuver.units.time,
            input: input.collect::<Option<_>>().unwrap_or_default(),
            change: if ramps { change.collect() } else { Vec::new() },
            holds: names(&law.holds),
            touches: arcs.contacts.get(index).map_or(Vec::new(), |limits| names(limits)),
        };
        match told.last_mut() {
            // What round-off leaves between inputs that switch together is no arc.
            Some(last) if *length <= least => {
                last.end_s = arc.end_s;
                last.touches.extend(arc.touches);
            }
            _ => told.push(arc),
        }
    }
    told
}
