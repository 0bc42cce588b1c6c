//! The coarse grid of a search.

use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Motion, Path, Problem, Scheme, State};
use crate::mechanics::environment::Pose;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::search::starts::families::twisted_by;
use std::f64::consts::{PI, TAU};

/// How coarse a grid may be.
struct CoarseRule {
    /// Fewest steps.
    fewest: usize,
    /// Angle per step that it aims at \[rad\].
    angle: f64,
    /// It is worth its while where it has so many times fewer steps than the requested one.
    worth: f64,
}

/// For the shooting, of a free body.
const SHOOTING_FREE: CoarseRule = CoarseRule { fewest: 32, angle: 0.35, worth: 2.0 };
/// The same from rest to rest on few steps where one way is asked for, and the ballistic start
/// alone is tried at first: what the search takes is then felt, and the angle is known. On many it
/// is not felt, and what extrapolation from coarser grids misses would cost a sweep more. With
/// rates so coarse a grid leads to another extremal in one of a hundred.
const SHOOTING_ONE_WAY: CoarseRule = CoarseRule { fewest: 8, ..SHOOTING_FREE };
/// The same where the best way is sought: descents begin on both ways round, and what they end at
/// is compared on the requested grid.
const SHOOTING_FROM_REST: CoarseRule = CoarseRule { fewest: 12, angle: 0.45, ..SHOOTING_FREE };
/// Fewest steps of a requested grid beside which that is taken.
const FEWEST_FROM_REST: usize = 64;
/// Steps that are few.
const FEW_STEPS: usize = 400;
/// Where inputs about an axis are missing or dear a body turns far and fast instead, and takes
/// sharp bends.
const SHOOTING_UNEVEN: CoarseRule = CoarseRule { fewest: 64, ..SHOOTING_FREE };
/// The rate that a field may give a body, in units of that of its oscillations: twice, as a
/// pendulum that falls from above.
const SWING: f64 = 2.0;
/// For a chain: enough for the angle per step and for cones between the nodes.
const CHAIN: CoarseRule = CoarseRule { fewest: 24, angle: 0.3, worth: 1.5 };

/// Steps of the grid to search on, for a way that turns by `angle` \[rad\]: enough for its fastest
/// moment, or the requested grid where that is hardly finer.
fn coarse_steps(problem: &Problem, angle: f64, rule: &CoarseRule) -> usize {
    let ends = [&problem.start, &problem.end];
    let rate = ends
        .map(|end| end.angular_velocity.norm() + SWING * field_rate(problem, end))
        .into_iter()
        .fold(0.0, f64::max);
    // In steps that do not resolve the nutation there may be no path that meets its end.
    let rate = rate + problem.body.inertia.nutation(&problem.actuation.stored_momentum());
    // The fastest moment of a rest-to-rest slew is 1.5 times its mean rate.
    let needed = ((1.5 * angle + rate * problem.seconds()) / rule.angle).ceil().min(problem.steps as f64);
    // Even, so that grids of 3/2 as many steps exist.
    let coarse = (needed as usize).max(rule.fewest).next_multiple_of(2);
    if rule.worth * coarse as f64 <= problem.steps as f64 { coarse } else { problem.steps }
}

/// The rate of the oscillations about an attitude that the field holds or repels by its gradient
/// there, about the stiffest axis \[rad/s\].
fn field_rate(problem: &Problem, at: &State) -> f64 {
    if problem.environment.is_free() {
        return 0.0;
    }
    let pose = Pose { position: at.position, attitude: at.attitude };
    let stiffness = problem.environment.gradient(&pose).rr.norm();
    (stiffness / problem.body.inertia.mean()).sqrt()
}

/// Steps of the coarse grid of a chain.
pub fn chain_steps(problem: &Problem) -> usize {
    let angle = lie::minus(&problem.end.attitude, &problem.start.attitude).norm();
    coarse_steps(problem, angle, &CHAIN)
}

/// Steps of the grid that descents with widened authority begin on, where the search goes on on the
/// grid of `coarse`.
pub fn rough_grid<const N: usize>(problem: &Problem, coarse: &BoundaryValueProblem<N>) -> usize {
    let rough = coarse_steps(problem, PI, &SHOOTING_FREE);
    rough.min(coarse.dynamics.grid.steps())
}

/// Whether the best way from rest may be sought on a grid of very few steps: that of the
/// first-order scheme is too coarse to tell a rival's cost by, and so it is beside a requested grid
/// on which the search would take place itself.
fn coarse_from_rest(problem: &Problem) -> bool {
    problem.scheme == Scheme::LieVerlet && problem.steps >= FEWEST_FROM_REST
}

/// The grid on which the shooting searches.
pub fn search_grid(problem: &Problem, turns: i32, even: bool) -> usize {
    // Where inputs meet their limits, costates on two grids have no expansion in the step.
    if problem.actuation.is_limited() {
        return problem.steps;
    }
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = (short.norm() + TAU * f64::from(turns)).abs();
    let ends = [&problem.start, &problem.end];
    let rests = ends.iter().all(|end| end.angular_velocity == Vector3::zeros());
    // A body that only turns, and about all axes alike, turns by hardly more than the angle of its
    // way.
    let plain = problem.steps < FEW_STEPS && rests && even && problem.motion == Motion::Attitude;
    let rule = match problem.path {
        _ if !problem.environment.is_free() => SHOOTING_FREE,
        Path::Best if !even => SHOOTING_UNEVEN,
        Path::Best if plain && coarse_from_rest(problem) => SHOOTING_FROM_REST,
        Path::Best => SHOOTING_FREE,
        _ if plain => return coarse_steps(problem, angle, &SHOOTING_ONE_WAY),
        _ => SHOOTING_FREE,
    };
    // Other extremals may turn by half a turn and more.
    let angle = angle.max(PI) + twisted_by(problem);
    coarse_steps(problem, angle, &rule)
}
