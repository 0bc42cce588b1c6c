//! The arcs of a plan that more than limits of the torques shapes: what that of the chain on equal steps is in continuous time.

use super::context::Context;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::{Outcome, Solution};
use crate::maneuver::switching::{Structure, Switching, SwitchingArc};
use crate::mechanics::environment::Pose;
use crate::optimize::methods::limited::exchange::{Optimum, improved};
use crate::optimize::methods::limited::motion::{Level, Maneuver};
use crate::optimize::methods::limited::newton::{Arcs, NO_LENGTH, Stationary};
use crate::optimize::methods::limited::structure::{self, Between};

/// Arcs whose cost differs from that of the plan by more than this part are those of another plan: a grid of some ten steps an arc is off
/// by less.
const OF_THE_PLAN: f64 = 1e-2;

/// The plan with the arcs that it leads to, where these satisfy the maximum principle; the same plan otherwise.
pub(super) fn with_arcs(problem: &Problem, context: &Context, mut plan: Solution) -> Solution {
    // Up to a longest duration it is the chain that knows whether all of it is used.
    let converged = plan.outcome == Outcome::Converged && problem.duration.at_most().is_none();
    if converged && plan.switching.is_none() {
        plan.switching = Maneuver::of(problem)
            .and_then(|maneuver| Told::of(&maneuver, problem, context, &plan))
            .map(|arcs| arcs.switching);
    }
    plan
}

/// The arcs that a plan leads to.
pub(super) struct Told {
    pub switching: Switching,
    found: Stationary,
}

impl Told {
    /// Those that satisfy the maximum principle; `None` where there are none.
    pub fn of(maneuver: &Maneuver, problem: &Problem, context: &Context, plan: &Solution) -> Option<Self> {
        let between = [Between::Pulses, Between::Means];
        let firsts: Vec<Arcs> =
            between.iter().filter_map(|between| structure::arcs(maneuver, plan, *between)).collect();
        let step = firsts.first()?.duration() / plan.steps as f64;
        let Optimum { stationary: found, gap, chattering } =
            improved(maneuver, &firsts, step, &|| context.interrupt().is_some())?;
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
        let switching = Switching {
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
        };
        Some(Self { switching, found })
    }

    /// Whether they are those of a plan of this cost on some grid.
    pub fn are_of(&self, cost: f64) -> bool {
        (self.switching.continuous_cost - cost).abs() <= OF_THE_PLAN * cost
    }

    /// The poses of their motion at the nodes of equal steps, in meters.
    pub fn poses(&self, maneuver: &Maneuver, steps: usize) -> Option<Vec<Pose>> {
        let Stationary { arcs, followed, .. } = &self.found;
        let step = arcs.duration() / steps as f64;
        let mut poses = vec![maneuver.pose(&maneuver.start)];
        let mut begun = 0.0;
        for ((law, length), from) in arcs.laws.iter().zip(&arcs.lengths).zip(&followed.nodes) {
            let driven = maneuver.driven(law)?;
            let (mut at, mut state) = (begun, *from);
            let ended = begun + length;
            while poses.len() < steps && poses.len() as f64 * step <= ended {
                let next = poses.len() as f64 * step;
                state = driven.flow(&state, next - at, driven.steps(&state, next - at));
                at = next;
                poses.push(maneuver.pose(&state));
            }
            begun = ended;
        }
        poses.push(maneuver.pose(followed.nodes.last()?));
        (poses.len() == steps + 1).then_some(poses)
    }
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
