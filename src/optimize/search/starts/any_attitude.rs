//! Paths to a rate in any attitude (detumbling): the momentum runs from that of the start to that
//! of the end, and the attitude follows.
//!
//! ```text
//! Π(t) = (1 − s)^a q(t) + s Π_d ,   q̇ = q × J⁻¹Π ,   q(0) = Π_0 ,   s = t/T ,   Ṙ = R S(J⁻¹Π)
//! ```
//!
//! With `Π_d = 0`, `a = 1` and torques of equal weight about all axes this is the optimum itself:
//! the torque brakes along the momentum, `∫ ½|τ|² dt = |Π_0|²/2T` whatever the inertia, since
//! `d|Π|/dt ≥ −|τ|`. Other paces end after other angles, and bends away from the path in other
//! attitudes: what weights, limits, cones, wheels and fields make of the optimum lies near one of
//! them.

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

/// The paces `a`: along the optimum of equal weights, faster at first, slower at first.
const PACES: [(f64, &str); 3] = [(1.0, "braked"), (2.0, "braked early"), (0.5, "braked late")];

/// Turn of the end about each body axis by which the paths are bent, to either side \[rad\]: less
/// leads to the same minima, more costs subproblems. What the default search misses of the thorough
/// one is counted by `families F13`.
const BEND: f64 = 1.0;

/// Random bends that a thorough search tries: time against what it may miss.
const RANDOM: u32 = 60;
/// Their size \[rad\]: ends all over the rotations.
const SPREAD: f64 = 2.0;

/// Turn in a part of a step of the kinematics \[rad\]: what is followed are starts, not plans.
const PART: f64 = 0.1;

/// Paths on the grid of `model`, the likeliest first.
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

/// The attitude in which the body ends that brakes along its momentum, where the duration is known;
/// that of the start otherwise.
pub fn likely_end(problem: &Problem) -> Matrix3 {
    if problem.duration.known().is_none() {
        return problem.start.attitude;
    }
    let attitudes = braked(problem, &Grid::uniform(problem.scheme, 1.0, problem.steps), 1.0);
    attitudes.last().copied().unwrap_or(problem.start.attitude)
}

/// Attitudes at the nodes of a grid whose unit of time is the stated duration: the momentum of the
/// start stays where it is in space, and gives way to that of the end.
fn braked(problem: &Problem, grid: &Grid, pace: f64) -> Vec<Matrix3> {
    let turned = turned(problem, grid, pace, momenta(problem), 1.0);
    from_start(problem, grid, &turned)
}

/// Attitudes on the way on which the momentum of the end stays where it is in space, found backward
/// from the end.
fn spun_up(problem: &Problem, grid: &Grid, pace: f64) -> Vec<Matrix3> {
    let [first, last] = momenta(problem);
    let mut turned = turned(problem, grid, pace, [last, first], -1.0);
    turned.reverse();
    from_start(problem, grid, &turned)
}

/// Momenta of start and end, body axes.
fn momenta(problem: &Problem) -> [Vector3; 2] {
    [&problem.start, &problem.end].map(|end| problem.body.inertia.j() * end.angular_velocity)
}

/// Attitudes in the reference frame of a body that is turned so from node to node, from that of the
/// start.
fn from_start(problem: &Problem, grid: &Grid, turned: &[Matrix3]) -> Vec<Matrix3> {
    let frame = problem.environment.frame_rate() * problem.seconds();
    let first = problem.start.attitude * turned[0].transpose();
    let of_node = |(node, turned): (usize, &Matrix3)| {
        lie::project_to_rotation(&(lie::exp(&(-frame * grid.after(node))) * first * turned))
    };
    turned.iter().enumerate().map(of_node).collect()
}

/// Rotations of the body from node to node, forward or backward in time, from the first of two
/// momenta to the other.
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

/// A path through attitudes, bent more and more by up to `bend` at its end, with the cubic between
/// the boundary positions.
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
