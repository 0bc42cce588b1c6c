//! Number of steps of the coarse grid of a search.

use crate::Vector3;
use crate::lie;
use crate::maneuver::problem::{Motion, Path, Problem, Scheme, State};
use crate::mechanics::environment::Pose;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::search::starts::families::twisted_by;
use std::f64::consts::{PI, TAU};

/// Rule for the number of steps of a coarse grid.
struct CoarseRule {
    /// Fewest steps of the coarse grid.
    fewest: usize,
    /// Largest rotation per step for which the grid is designed \[rad\].
    angle: f64,
    /// Smallest ratio of the requested to the coarse number of steps at which the coarse grid is
    /// used.
    worth: f64,
}

/// Rule for shooting with a free body.
const SHOOTING_FREE: CoarseRule = CoarseRule { fewest: 32, angle: 0.35, worth: 2.0 };
/// Rule for shooting with few requested steps, from rest to rest, in one homotopy class, where only
/// the ballistic start is tried at first. The time of the search is then noticeable, and the angle
/// is known. With many steps it is not noticeable, and the error of extrapolation from coarser
/// grids would cost one more sweep. With boundary rates, so coarse a grid leads to another extremal
/// in one of a hundred cases.
const SHOOTING_ONE_WAY: CoarseRule = CoarseRule { fewest: 8, ..SHOOTING_FREE };
/// Rule for shooting from rest to rest if the best path is sought: descents begin in both homotopy
/// classes, and their results are compared on the requested grid.
const SHOOTING_FROM_REST: CoarseRule = CoarseRule { fewest: 12, angle: 0.45, ..SHOOTING_FREE };
/// Smallest requested number of steps for which [`SHOOTING_FROM_REST`] is used.
const FEWEST_FROM_REST: usize = 64;
/// Requested number of steps below which the search takes a noticeable part of the time.
const FEW_STEPS: usize = 400;
/// Rule for shooting if inputs about an axis are missing or costly. The body then turns far and
/// fast, and its path has sharp bends.
const SHOOTING_UNEVEN: CoarseRule = CoarseRule { fewest: 64, ..SHOOTING_FREE };
/// Rate that a force field may give a body, in units of the frequency of its oscillations. A
/// pendulum that falls from the top reaches twice this frequency.
const SWING: f64 = 2.0;
/// Rule for a chain. The grid resolves the rotation per step and the cones between the nodes.
const CHAIN: CoarseRule = CoarseRule { fewest: 24, angle: 0.3, worth: 1.5 };

/// Returns the number of steps of the search grid for a path that turns by `angle` \[rad\]. It is
/// sufficient for the fastest part of the path. If it is hardly smaller than the requested number,
/// the requested number is used.
fn coarse_steps(problem: &Problem, angle: f64, rule: &CoarseRule) -> usize {
    let ends = [&problem.start, &problem.end];
    let rate = ends
        .map(|end| end.angular_velocity.norm() + SWING * field_rate(problem, end))
        .into_iter()
        .fold(0.0, f64::max);
    // If steps do not resolve the nutation, there may be no path that meets its end.
    let rate = rate + problem.body.inertia.nutation(&problem.actuation.stored_momentum());
    // The peak rate of a rest-to-rest slew is 1.5 times its mean rate.
    let needed = ((1.5 * angle + rate * problem.seconds()) / rule.angle).ceil().min(problem.steps as f64);
    // An even number, so that a grid with 3/2 as many steps exists.
    let coarse = (needed as usize).max(rule.fewest).next_multiple_of(2);
    if rule.worth * coarse as f64 <= problem.steps as f64 { coarse } else { problem.steps }
}

/// Returns the frequency of oscillations about an attitude due to the gradient of the force field,
/// about the stiffest axis \[rad/s\]. An unstable attitude is treated as a stable one.
fn field_rate(problem: &Problem, at: &State) -> f64 {
    if problem.environment.is_free() {
        return 0.0;
    }
    let pose = Pose { position: at.position, attitude: at.attitude };
    let stiffness = problem.environment.gradient(&pose).rr.norm();
    (stiffness / problem.body.inertia.mean()).sqrt()
}

/// Returns the number of steps of the coarse grid of a chain.
pub fn chain_steps(problem: &Problem) -> usize {
    let angle = lie::minus(&problem.end.attitude, &problem.start.attitude).norm();
    coarse_steps(problem, angle, &CHAIN)
}

/// Returns the number of steps of the rough grid on which descents with widened authority begin,
/// before they continue on the grid of `coarse`.
pub fn rough_grid<const N: usize>(problem: &Problem, coarse: &BoundaryValueProblem<N>) -> usize {
    let rough = coarse_steps(problem, PI, &SHOOTING_FREE);
    rough.min(coarse.dynamics.grid.steps())
}

/// Returns whether the best path from rest may be sought on a grid of very few steps. The scheme
/// must be of second order, because otherwise the costs of rivals would be too inaccurate. The
/// requested grid must be so fine that the search does not use it itself.
fn coarse_from_rest(problem: &Problem) -> bool {
    problem.scheme == Scheme::LieVerlet && problem.steps >= FEWEST_FROM_REST
}

/// Returns the number of steps of the grid on which shooting searches. `turns` is the number of
/// additional full turns; `even` states that the inputs have similar authority about all axes.
pub fn search_grid(problem: &Problem, turns: i32, even: bool) -> usize {
    // If inputs reach their limits, costates on two grids have no expansion in the step.
    if problem.actuation.is_limited() {
        return problem.steps;
    }
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = (short.norm() + TAU * f64::from(turns)).abs();
    let ends = [&problem.start, &problem.end];
    let rests = ends.iter().all(|end| end.angular_velocity == Vector3::zeros());
    // A body that only rotates, with equal authority about all axes, turns by hardly more than the
    // angle of its path.
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
