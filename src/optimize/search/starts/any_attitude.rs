//! Paths to a rate with a free terminal attitude (detumbling): the momentum changes from its
//! initial to its terminal value, and the attitude follows.
//!
//! ```text
//! Π(t) = (1 − s)^a q(t) + s Π_d ,   q̇ = q × J⁻¹Π ,   q(0) = Π_0 ,   s = t/T ,   Ṙ = R S(J⁻¹Π)
//! ```
//!
//! With `Π_d = 0`, `a = 1` and torques of equal weight about all axes this path is the optimum: the
//! torque brakes along the momentum, `∫ ½|τ|² dt = |Π_0|²/2T` for any inertia, since
//! `d|Π|/dt ≥ −|τ|`. Paths with other paces end after other angles, and bent paths in other
//! attitudes: the optimum with weights, limits, cones, wheels and fields is near one of them.

use crate::lie;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Thoroughness;
use crate::mechanics::environment::Pose;
use crate::numerics::hermite::hermite;
use crate::numerics::random::Stream;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::{Matrix3, Vector3};

/// Exponents `a` of the pace, with the names of the paths: the pace of the optimum with equal
/// weights, faster at first, and slower at first.
const PACES: [(f64, &str); 3] = [(1.0, "braked"), (2.0, "braked early"), (0.5, "braked late")];

/// Rotation of the terminal attitude about each body axis, to either side, by which paths are bent
/// \[rad\]. A smaller rotation leads to the same minima, and a larger one costs subproblems.
/// `families F13` counts the minima that the default search misses and the thorough search finds.
const BEND: f64 = 1.0;

/// Number of random bends in a thorough search. More bends take longer and miss fewer minima.
const RANDOM: u32 = 60;
/// Size of the random bends \[rad\]: the terminal attitudes cover all rotations.
const SPREAD: f64 = 2.0;

/// Largest rotation in one integration step of the kinematics \[rad\]: these paths are initial
/// guesses, so that low accuracy suffices.
const PART: f64 = 0.1;

/// Returns paths on the grid of `model`, the most promising first.
pub fn paths(problem: &Problem, model: &Model, search: Thoroughness) -> Vec<Candidate> {
    let grid = &model.dynamics.grid;
    let mut straight: Vec<(&str, Vec<Matrix3>)> =
        PACES.iter().map(|(pace, name)| (*name, braked(problem, grid, *pace))).collect();
    if problem.end.angular_velocity != Vector3::zeros() {
        let spun = ["spun up", "spun up late", "spun up early"];
        straight
            .extend(PACES.iter().zip(spun).map(|((pace, _), name)| (name, spun_up(problem, grid, *pace))));
    }
    let zero = Vector3::zeros();
    let mut paths: Vec<Candidate> =
        straight.iter().map(|(name, attitudes)| bent(model, name, attitudes, &zero)).collect();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for by in [BEND, -BEND] {
            let side = if by > 0.0 { '+' } else { '-' };
            let bend = Vector3::ith(axis, by);
            paths.push(bent(model, &format!("braked, bent {side}{name}"), &straight[0].1, &bend));
        }
    }
    if search == Thoroughness::Thorough {
        for index in 0..RANDOM {
            let mut stream = Stream::new(0, 0, index);
            let bend = Vector3::from_fn(|_, _| SPREAD * stream.normal());
            let (name, attitudes) = &straight[index as usize % straight.len()];
            paths.push(bent(model, &format!("{name}, bent at random {}", index + 1), attitudes, &bend));
        }
    }
    paths
}

/// Returns the terminal attitude of a body that brakes along its momentum. If the duration is
/// unknown, returns the initial attitude.
pub fn likely_end(problem: &Problem) -> Matrix3 {
    if problem.duration.known().is_none() {
        return problem.start.attitude;
    }
    let attitudes = braked(problem, &Grid::uniform(problem.scheme, 1.0, problem.steps), 1.0);
    attitudes.last().copied().unwrap_or(problem.start.attitude)
}

/// Returns the attitudes at the nodes of a grid whose unit of time is the problem's duration. The
/// initial momentum is fixed in space and decreases while the terminal momentum increases.
fn braked(problem: &Problem, grid: &Grid, pace: f64) -> Vec<Matrix3> {
    let turned = turned(problem, grid, pace, momenta(problem), 1.0);
    from_start(problem, grid, &turned)
}

/// Returns the attitudes of a path on which the terminal momentum is fixed in space, integrated
/// backward from the end.
fn spun_up(problem: &Problem, grid: &Grid, pace: f64) -> Vec<Matrix3> {
    let [first, last] = momenta(problem);
    let mut turned = turned(problem, grid, pace, [last, first], -1.0);
    turned.reverse();
    from_start(problem, grid, &turned)
}

/// Returns the momenta at the start and at the end, in body axes.
fn momenta(problem: &Problem) -> [Vector3; 2] {
    [&problem.start, &problem.end].map(|end| problem.body.inertia.j() * end.angular_velocity)
}

/// Returns attitudes in the reference frame from the rotations of the body at the nodes, beginning
/// with the initial attitude.
fn from_start(problem: &Problem, grid: &Grid, turned: &[Matrix3]) -> Vec<Matrix3> {
    let frame = problem.environment.frame_rate() * problem.seconds();
    let first = problem.start.attitude * turned[0].transpose();
    let of_node = |(node, turned): (usize, &Matrix3)| {
        lie::project_to_rotation(&(lie::exp(&(-frame * grid.after(node))) * first * turned))
    };
    turned.iter().enumerate().map(of_node).collect()
}

/// Returns the rotations of the body at the nodes while its momentum changes from the first to the
/// second of `momenta`. The motion runs forward in time if `sense` is 1, and backward if it is −1.
fn turned(problem: &Problem, grid: &Grid, pace: f64, momenta: [Vector3; 2], sense: f64) -> Vec<Matrix3> {
    let inertia = &problem.body.inertia;
    let [mut first, last] = momenta;
    let fastest = momenta.map(|momentum| (inertia.j_inverse() * momentum).norm());
    let mut attitude = Matrix3::identity();
    let mut attitudes = vec![attitude];
    for node in 1..=grid.steps() {
        let [from, to] = [node - 1, node].map(|node| grid.after(node));
        let parts =
            (((fastest[0] + fastest[1]) * (to - from) * problem.seconds() / PART).ceil() as usize).max(1);
        let part = (to - from) / parts as f64;
        for index in 0..parts {
            let s = from + (index as f64 + 0.5) * part;
            let momentum = first * (1.0 - s).max(0.0).powf(pace) + last * s;
            let turn = inertia.j_inverse() * momentum * (sense * part * problem.seconds());
            first = lie::exp(&-turn) * first;
            attitude *= lie::exp(&turn);
        }
        attitudes.push(attitude);
    }
    attitudes
}

/// Returns a path through attitudes, bent progressively by up to `bend` at its end, with a cubic
/// between the boundary positions.
fn bent(model: &Model, name: &str, attitudes: &[Matrix3], bend: &Vector3) -> Candidate {
    let grid = &model.dynamics.grid;
    let poses = attitudes.iter().enumerate().map(|(node, attitude)| {
        let s = grid.after(node);
        let ends = [&model.start.position, &model.target.position];
        let position = hermite(s, 1.0, ends, [&Vector3::zeros(), &Vector3::zeros()]);
        Pose { position, attitude: attitude * lie::exp(&(bend * (s * s))) }
    });
    path(name, grid, poses)
}
