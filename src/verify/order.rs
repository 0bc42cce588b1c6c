//! Whether the discrete and the continuous witness describe one motion.
//!
//! The torque that the plan holds over each step is propagated by the discrete witness at h, h/2, h/4.
//! Its end must approach the end of the continuous witness at the order of the scheme. Steps too long
//! to be in that regime, or leading terms that happen to cancel, are given h/8 and h/16.

use super::WitnessError;
use super::discrete::Discrete;
use super::motion::{Inputs, Phase, Scale};
use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::Problem;
use crate::maneuver::solution::TerminalError;
use crate::propagate::plant::Plant;

/// Refinements of the plan's step.
const LEVELS: [usize; 5] = [1, 2, 4, 8, 16];

/// Levels beyond h/4 only up to this number of steps, about two seconds.
const MAX_STEPS: usize = 4_000_000;

/// What is missing to the full order and still passes.
pub(super) const SLACK: f64 = 0.5;

/// Agreement, scaled and relative to the size of the motion, that counts as round-off.
const ROUND_OFF: f64 = 1e-12;

/// Agreement that amplified round-off can excuse at most.
const AMPLIFIED: f64 = 1e-6;

/// Round-off of the propagations, before the dynamics amplify it.
const START_ROUND_OFF: f64 = 2e-13;

/// How the discrete and the continuous witness compare.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comparison {
    /// Scaled distance of the ends at h, h/2, h/4, …; NaN where a step was too long.
    pub(super) errors: Vec<f64>,
    /// Order observed between the finest two levels; `None` at round-off.
    pub(super) order: Option<f64>,
    /// Distance below which the ends agree to round-off.
    pub(super) floor: f64,
    pub(super) passed: bool,
}

/// Euclidean norm of the four parts.
pub(super) fn norm(error: &TerminalError) -> f64 {
    let parts = [
        error.attitude_rad,
        error.momentum_relative,
        error.position_relative.unwrap_or(0.0),
        error.linear_momentum_relative.unwrap_or(0.0),
    ];
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// End of the held plan by the discrete witness at `h/refinement`.
pub(super) fn held_end(
    plant: &Plant,
    inputs: &Inputs,
    start: &Phase,
    refinement: usize,
) -> Result<Phase, WitnessError> {
    let problem = plant.problem;
    let step = problem.duration / (problem.steps * refinement) as f64;
    let mut body = Discrete::new(plant, start, problem.scheme, step);
    for k in 0..problem.steps {
        let held = inputs.held(k);
        for _ in 0..refinement {
            body.advance(&held, &held)?;
        }
    }
    Ok(body.phase())
}

/// Compares the discrete and the continuous witness on the held plan, whose continuous end is `continuous`.
pub(super) fn compare(plant: &Plant, inputs: &Inputs, continuous: &Phase) -> Comparison {
    let problem = plant.problem;
    let scale = Scale::of(problem);
    let start = Phase::of(problem, &problem.start);
    let distance = |phase: &Phase| norm(&scale.distance(phase, continuous, problem.motion));
    let size = 1.0 + continuous.momentum.norm() * scale.time / scale.inertia;
    let mut found = Comparison { errors: vec![], order: None, floor: ROUND_OFF * size, passed: false };
    for refinement in LEVELS {
        if refinement > 4 && problem.steps * refinement > MAX_STEPS {
            break;
        }
        let error = held_end(plant, inputs, &start, refinement).map_or(f64::NAN, |end| distance(&end));
        found.errors.push(error);
        if error <= found.floor {
            found.order = None;
            found.passed = true;
            return found;
        }
        let orders: Vec<f64> = found.errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        found.order = orders.last().copied().filter(|order| order.is_finite());
        let enough = f64::from(problem.scheme.order()) - SLACK;
        if orders.len() >= 2 && orders[orders.len() - 2..].iter().all(|order| *order >= enough) {
            found.passed = true;
            return found;
        }
    }
    // Of the last two orders that did not both suffice, the one to blame.
    let blamed = found.errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).rev().take(2);
    found.order = blamed.fold(found.order, |worst, order| worst.map(|worst| worst.min(order)));
    // Dynamics that amplify a disturbance of the start amplify round-off alike.
    let finest = found.errors.last().copied().unwrap_or(f64::NAN);
    if finest < AMPLIFIED {
        found.floor = found.floor.max(START_ROUND_OFF * size * amplification(plant, inputs, &start, &scale));
        if finest <= found.floor {
            found.order = None;
            found.passed = true;
        }
    }
    found
}

/// Distance, scaled and relative to the size of the motion, that the ends of two exact witnesses may have.
const EXACT: f64 = 1e-9;

/// How far apart two witnesses of the held plan may end whose own errors are round-off; `continuous` is the end of
/// one, `apart` how far they are.
pub(super) fn agreement(plant: &Plant, inputs: &Inputs, continuous: &Phase, apart: f64) -> f64 {
    let scale = Scale::of(plant.problem);
    let size = 1.0 + continuous.momentum.norm() * scale.time / scale.inertia;
    let limit = EXACT * size;
    if apart <= limit {
        return limit;
    }
    let start = Phase::of(plant.problem, &plant.problem.start);
    let amplified = START_ROUND_OFF * size * amplification(plant, inputs, &start, &scale);
    // Written so that a NaN leaves the limit as it is.
    if amplified > limit { amplified.min(AMPLIFIED * size) } else { limit }
}

/// By how much a small disturbance of the start has grown at the end.
fn amplification(plant: &Plant, inputs: &Inputs, start: &Phase, scale: &Scale) -> f64 {
    const DISTURBANCE: f64 = 1e-7;
    let problem: &Problem = plant.problem;
    // A direction with no preferred axis, so that the fastest growing motion is part of it.
    let direction = Vector3::new(0.48, -0.60, 0.64);
    let change = DISTURBANCE * direction;
    let disturbed = Phase {
        position: start.position + scale.length * change,
        linear_momentum: start.linear_momentum - scale.mass * scale.length / scale.time * change,
        attitude: start.attitude * lie::exp(&change),
        momentum: start.momentum + scale.inertia / scale.time * change,
        stored: start.stored,
    };
    let ends = [start, &disturbed].map(|phase| held_end(plant, inputs, phase, 1));
    match ends {
        [Ok(a), Ok(b)] => norm(&scale.distance(&a, &b, problem.motion)) / DISTURBANCE,
        _ => 0.0,
    }
}
