//! Paths from which descents start: smooth, coasting, bent and random ones, on the grid of a
//! problem.
//!
//! Every path connects the boundary attitudes; it need not meet the boundary rates, since the
//! inputs at the ends follow. The families:
//!
//! - *smooth*: a cubic in the rotation vector from the start that meets both rates, with more or
//!   fewer turns;
//! - *coasting*: the motion without inputs from the start, blended into the motion without inputs
//!   that arrives at the target, by the rotation between them;
//! - *slowed*: the same blend with coasts of a free body at the pace `1 − (1−κ)t + 6βt(1−t)`: κ = 0
//!   stops a rotation with the smallest torque, and β shifts its phase;
//! - *bent*: smooth paths with an added `± a sin²πt` about an axis;
//! - *random*: smooth paths with an added `Σ b_m sin πt sin mπt`, m = 1 … 3, with normal `b_m` from
//!   a fixed seed;
//! - *twisted*: any path, with more turns of the body about the axis of its smallest moment.
//!
//! # How is the best homotopy class found?
//!
//! Descents start from families of paths (`optimize/search/starts/paths.rs`): smooth ones by turns,
//! coasts blended into each other, slowed coasts, bent and random ones. Their number depends on the
//! maneuver (`families.rs`): two for a free body between states of rest; all of them for a long
//! detumbling, a field, missing inputs or weights of very different size. A free body that turns by
//! less than ten radians gets few slowed coasts, which all lead to the same two or three minima,
//! and more random paths instead: the cheapest minimum may be found by one random path in sixteen
//! and by no other. A moving rod starts from both ends, and with more turns about its axis, and so
//! do the lowest minima that are found: such turns cost little, and their gyroscopic torques bend
//! the path.
//!
//! A search that has done half of its starts ends after twenty starts without a lower minimum. A
//! descent whose Newton step leads to within 3e-3 rad of every node of a known minimum ends there:
//! two different minima at this distance would hardly differ in cost. The minima on the coarse grid
//! are merged by their cost. All within 15 % of the cheapest are transferred to the requested grid
//! and compared there, because costs on a coarse grid are wrong by some percent. `search = "quick"`
//! and `"thorough"` change only the number of starts.

use crate::Vector3;
use crate::lie;
use crate::maneuver::settings::Method;
use crate::mechanics::environment::Pose;
use crate::numerics::compensated::Sum;
use crate::numerics::hermite::hermite;
use crate::optimize::chain::model::Model;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::{Point, StepError};
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::search::starts::{name_of, wound};
use nalgebra::SVector;
use std::f64::consts::{PI, TAU};

/// Amplitude of random paths \[rad\].
const SPREAD: f64 = 1.2;
/// Angle of a rotation \[rad\] below which its rate hardly needs to be varied.
const SLOW: f64 = 1.0;

/// Creates a path through the nodes of the grid of `bvp`.
fn candidate<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    name: String,
    poses: impl Iterator<Item = Pose>,
) -> Candidate {
    let zero = Vector3::zeros();
    let states = poses.map(|pose| Point {
        position: Sum::new(pose.position),
        linear_momentum: Sum::new(zero),
        attitude: Sum::new(pose.attitude),
        momentum: Sum::new(zero),
    });
    let mut candidate = Candidate::empty(Method::Shooting, &name, bvp.dynamics.grid.clone());
    candidate.states = states.collect();
    candidate
}

/// Returns the path of an extremal.
pub fn of_extremal<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    extremal: &Candidate,
) -> Result<Candidate, StepError> {
    let mut poses = Vec::new();
    bvp.sweep_observed(&extremal.costate(), |node| poses.push(node.point.pose()))?;
    Ok(candidate(bvp, extremal.provenance.start.clone(), poses.into_iter()))
}

/// Returns the path of a candidate with known states, on the grid of `bvp`.
pub fn of_states<const N: usize>(bvp: &BoundaryValueProblem<N>, states: &Candidate) -> Candidate {
    let name = states.provenance.start.clone();
    candidate(bvp, name, states.states.iter().map(Point::pose))
}

/// Returns the rotation vector with `turns` more turns than the shortest rotation from start to
/// target.
pub(crate) fn rotation<const N: usize>(bvp: &BoundaryValueProblem<N>, turns: i32) -> Vector3 {
    wound(&lie::minus(&bvp.terminal.target().attitude.value, &bvp.start.attitude.value), turns)
}

/// Blending function from 0 to 1 with zero first and second derivatives at both ends.
fn blend(t: f64) -> f64 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// Returns the smooth path along `rotation`, the rotation vector from the start, with the addition
/// `bend`, which is zero at both ends.
pub(crate) fn smooth<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    name: String,
    rotation: &Vector3,
    bend: impl Fn(f64) -> Vector3,
) -> Candidate {
    let dynamics = &bvp.dynamics;
    let (start, target) = (&bvp.start, bvp.terminal.target());
    let frame = dynamics.frame_rate();
    let rate =
        |point: &Point| dynamics.j_inverse * point.momentum.value - point.attitude.value.tr_mul(&frame);
    // Near a full turn J_r⁻¹ is singular. The slope at the end is only a guess, so it may be
    // omitted there.
    let away = (rotation.norm() - TAU).abs() > 0.5;
    let arrival = if away { lie::right_jacobian_inverse(rotation) * rate(target) } else { rate(target) };
    let zero = Vector3::zeros();
    let grid = &dynamics.grid;
    let poses = (0..=grid.steps()).map(|node| {
        let t = grid.after(node);
        let turned = hermite(t, 1.0, [&zero, rotation], [&rate(start), &arrival]) + bend(t);
        Pose { position: position(bvp, t), attitude: start.attitude.value * lie::exp(&turned) }
    });
    candidate(bvp, name, poses)
}

/// Returns the position at the time fraction t on the cubic between the boundary positions.
fn position<const N: usize>(bvp: &BoundaryValueProblem<N>, t: f64) -> Vector3 {
    let (start, target) = (&bvp.start, bvp.terminal.target());
    let ends = [&start.position.value, &target.position.value];
    hermite(t, 1.0, ends, [&start.linear_momentum.value, &target.linear_momentum.value])
}

/// Returns a zero bend: the path is not bent.
pub(crate) fn straight(_: f64) -> Vector3 {
    Vector3::zeros()
}

/// Returns smooth paths with the given numbers of turns.
pub fn smooth_ways<'a, const N: usize>(
    bvp: &'a BoundaryValueProblem<'a, N>,
    turns: &'a [i32],
) -> impl Iterator<Item = Candidate> + 'a {
    turns.iter().map(|turns| {
        let name = format!("{}, smooth path", name_of(*turns));
        smooth(bvp, name, &rotation(bvp, *turns), straight)
    })
}

/// Returns smooth short and long paths that are bent by `by` \[rad\] about every axis, to either
/// side.
pub fn bent<'a, const N: usize>(
    bvp: &'a BoundaryValueProblem<'a, N>,
    by: f64,
) -> impl Iterator<Item = Candidate> + 'a {
    let humps = [by, -by].into_iter().flat_map(|by| (0..3).map(move |axis| Vector3::ith(axis, by)));
    humps.flat_map(move |hump| {
        [0, -1].into_iter().map(move |turns| {
            let name = format!("{}, bent path", name_of(turns));
            smooth(bvp, name, &rotation(bvp, turns), |t| hump * (PI * t).sin().powi(2))
        })
    })
}

/// Returns random smooth paths, alternately short and long.
pub fn random<'a, const N: usize>(
    bvp: &'a BoundaryValueProblem<'a, N>,
    count: usize,
) -> impl Iterator<Item = Candidate> + 'a {
    let mut bends = Bends::new();
    (0..count).map(move |index| {
        let bend = bends.draw(SPREAD);
        let turns = -((index % 2) as i32);
        let name = format!("{}, random path {}", name_of(turns), index + 1);
        smooth(bvp, name, &rotation(bvp, turns), |t| bend.at(t))
    })
}

/// Returns a path with more turns of the body about a body axis and unchanged ends.
pub fn twisted<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    path: &Candidate,
    axis: &Vector3,
    turns: i32,
) -> Candidate {
    let grid = &bvp.dynamics.grid;
    let by = axis * (TAU * f64::from(turns));
    let poses = path.states.iter().enumerate().map(|(node, point)| {
        let Pose { position, attitude } = point.pose();
        Pose { position, attitude: attitude * lie::exp(&(by * blend(grid.after(node)))) }
    });
    let start = path.provenance.start.as_str();
    let start = start.split_once(", twisted").map_or(start, |(start, _)| start);
    candidate(bvp, format!("{start}, twisted"), poses)
}

/// Returns a path bent at random by about `by` \[rad\], with unchanged ends.
pub fn bent_at_random<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    path: &Candidate,
    bends: &mut Bends,
    by: f64,
) -> Candidate {
    let grid = &bvp.dynamics.grid;
    let bend = bends.draw(by);
    let poses = path.states.iter().enumerate().map(|(node, point)| {
        let Pose { position, attitude } = point.pose();
        Pose { position, attitude: attitude * lie::exp(&bend.at(grid.after(node))) }
    });
    candidate(bvp, path.provenance.start.clone(), poses)
}

/// A stream of bends from a linear congruential generator, of which the high bits are used. Starts
/// need to be spread, not random.
pub struct Bends(u64);

/// A bend `Σ b_m sin πt sin mπt`, m = 1 … 3.
struct Bend([Vector3; 3]);

impl Bends {
    /// Creates the stream with its fixed seed.
    pub fn new() -> Self {
        Self(0x5EED)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2.0f64.powi(53)
    }

    /// Returns the next bend, with normal `b_m` of standard deviation `by` \[rad\].
    fn draw(&mut self, by: f64) -> Bend {
        let mut normal = || {
            let (radius, angle) = ((-2.0 * (1.0 - self.uniform()).ln()).sqrt(), TAU * self.uniform());
            by * radius * angle.cos()
        };
        Bend(std::array::from_fn(|_| Vector3::from_fn(|_, _| normal())))
    }
}

impl Bend {
    fn at(&self, t: f64) -> Vector3 {
        let mode = |m: usize| self.0[m] * (PI * (m + 1) as f64 * t).sin();
        (mode(0) + mode(1) + mode(2)) * (PI * t).sin()
    }
}

/// Returns, for each number of turns, the blend of the motion without inputs from the start and the
/// motion without inputs that arrives at the target.
pub fn coasting<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    turns: &[i32],
) -> Result<Vec<Candidate>, StepError> {
    if turns.is_empty() {
        return Ok(Vec::new());
    }
    let coast = |from: BoundaryValueProblem<N>| {
        let mut poses = Vec::new();
        from.sweep_observed(&SVector::zeros(), |node| poses.push(node.point.pose()))?;
        Ok(poses)
    };
    let forward = coast(bvp.clone())?;
    let mut backward = coast(bvp.reversed())?;
    backward.reverse();
    let blended = turns.iter().map(|turns| {
        let name = format!("{}, coasting", name_of(*turns));
        blended(bvp, name, &forward, &backward, *turns)
    });
    Ok(blended.collect())
}

/// Returns the path of a free body without inputs: its rate changes from the rate of the
/// uncontrolled motion from the start to the rate of the uncontrolled motion to the target. The
/// remaining attitude error, with additional turns, is distributed over the path.
pub fn natural<const N: usize>(bvp: &BoundaryValueProblem<N>, turns: i32) -> Result<Candidate, StepError> {
    let rates = |from: BoundaryValueProblem<N>, sign: f64| {
        let mut rates = Vec::new();
        let rate = |point: &Point| from.dynamics.j_inverse * point.momentum.value * sign;
        from.sweep_observed(&SVector::zeros(), |node| rates.push(rate(&node.point)))?;
        Ok::<Vec<Vector3>, StepError>(rates)
    };
    let forward = rates(bvp.clone(), 1.0)?;
    let mut backward = rates(bvp.reversed(), -1.0)?;
    backward.reverse();
    let grid = &bvp.dynamics.grid;
    let mixed = |node: usize| forward[node].lerp(&backward[node], blend(grid.after(node)));
    let mut attitudes = vec![bvp.start.attitude.value];
    for node in 0..grid.steps() {
        let rate = 0.5 * (mixed(node) + mixed(node + 1));
        attitudes.push(attitudes[node] * lie::exp(&(rate * grid.step(node))));
    }
    let last = attitudes[grid.steps()];
    let missed = last * wound(&lie::minus(&bvp.terminal.target().attitude.value, &last), turns);
    let poses = attitudes.iter().enumerate().map(|(node, attitude)| Pose {
        position: position(bvp, grid.after(node)),
        attitude: lie::exp(&(missed * blend(grid.after(node)))) * attitude,
    });
    let name = if turns == 0 { "natural".into() } else { format!("natural, {turns:+} turns") };
    Ok(candidate(bvp, name, poses.collect::<Vec<_>>().into_iter()))
}

/// Paces of the slowed coasts, as functions of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Paces {
    #[default]
    None,
    /// The pace falls linearly.
    Even,
    /// The pace falls linearly. Coasts shifted in phase by half a turn to either side are added.
    Shifted,
}

/// Returns slowed coasts, in both homotopy classes.
pub fn slowed<const N: usize>(bvp: &BoundaryValueProblem<N>, paces: Paces) -> Vec<Candidate> {
    let rate = |point: &Point| (bvp.dynamics.j_inverse * point.momentum.value).norm();
    let reversed = bvp.reversed();
    // Paces at one end. If the body hardly rotates there, one pace is enough.
    let paces_at = |rate: f64| -> Vec<(f64, f64)> {
        if rate <= SLOW {
            return vec![(1.0, 0.0)];
        }
        let shift = PI / rate;
        let betas = if paces == Paces::Even { vec![0.0] } else { vec![0.0, shift, -shift] };
        let at = |kappa: f64| betas.iter().map(move |beta| (kappa, *beta));
        at(0.0).chain(at(0.5)).collect()
    };
    let ends = (rate(&bvp.start), rate(bvp.terminal.target()));
    if paces == Paces::None || ends.0.max(ends.1) <= SLOW {
        return Vec::new();
    }
    let mut out = Vec::new();
    for ahead in paces_at(ends.0) {
        let forward = free_coast(bvp, ahead);
        for back in paces_at(ends.1) {
            let mut backward = free_coast(&reversed, back);
            backward.reverse();
            for turns in [0, -1] {
                let name = format!("{}, slowed coast", name_of(turns));
                out.push(blended(bvp, name, &forward, &backward, turns));
            }
        }
    }
    out
}

/// Returns the rotation of the free body from the start of `bvp` at the pace
/// `1 − (1−κ)t + 6βt(1−t)`, by midpoint steps.
fn free_coast<const N: usize>(bvp: &BoundaryValueProblem<N>, (kappa, beta): (f64, f64)) -> Vec<Pose> {
    let dynamics = &bvp.dynamics;
    let grid = &dynamics.grid;
    let (mut attitude, mut momentum) = (bvp.start.attitude.value, bvp.start.momentum.value);
    let mut poses = vec![bvp.start.pose()];
    for step in 0..grid.steps() {
        let (t, h) = (grid.after(step) + 0.5 * grid.step(step), grid.step(step));
        let by = h * (1.0 - (1.0 - kappa) * t + 6.0 * beta * t * (1.0 - t));
        let middle = momentum + momentum.cross(&(dynamics.j_inverse * momentum)) * (0.5 * by);
        let turn = lie::exp(&(dynamics.j_inverse * middle * by));
        attitude = dynamics.turned(step, &(attitude * turn));
        momentum = turn.tr_mul(&momentum);
        poses.push(Pose { position: bvp.start.position.value, attitude });
    }
    poses
}

/// Returns the path `R_f(t) exp(σ(t) ℓ(t))` with the blending function σ and `ℓ = log(R_fᵀR_b)`. ℓ
/// is continued in t from its value at half time, with `turns` additional turns.
fn blended<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    name: String,
    forward: &[Pose],
    backward: &[Pose],
    turns: i32,
) -> Candidate {
    let grid = &bvp.dynamics.grid;
    let steps = grid.steps();
    let between = |node: usize| lie::minus(&backward[node].attitude, &forward[node].attitude);
    let middle = steps / 2;
    let mut logs = vec![Vector3::zeros(); steps + 1];
    logs[middle] = wound(&between(middle), turns);
    for node in (0..middle).rev() {
        logs[node] = nearest_branch(&between(node), &logs[node + 1]);
    }
    for node in middle + 1..=steps {
        logs[node] = nearest_branch(&between(node), &logs[node - 1]);
    }
    let poses = (0..=steps).map(|node| {
        let share = blend(grid.after(node));
        Pose {
            position: position(bvp, grid.after(node)),
            attitude: forward[node].attitude * lie::exp(&(logs[node] * share)),
        }
    });
    let poses: Vec<Pose> = poses.collect();
    candidate(bvp, name, poses.into_iter())
}

/// Returns, of all rotation vectors of the rotation `exp(log)`, the one nearest to `near`.
fn nearest_branch(log: &Vector3, near: &Vector3) -> Vector3 {
    let angle = log.norm();
    let along = if angle > 1e-9 { log / angle } else { near.try_normalize(1e-9).unwrap_or_else(Vector3::x) };
    along * (angle + TAU * ((near.dot(&along) - angle) / TAU).round())
}

/// Returns the path of a candidate on another grid, with smooth interpolation between its nodes.
pub fn on_grid<const N: usize>(bvp: &BoundaryValueProblem<N>, path: &Candidate) -> Candidate {
    let (from, to) = (path.steps(), bvp.dynamics.grid.steps());
    let smooth = super::transfer::Interpolant::of(path.states.iter().map(Point::pose).collect());
    let poses: Vec<Pose> = (0..=to)
        .map(|node| {
            let at = node as f64 * from as f64 / to as f64;
            let low = (at.floor() as usize).min(from - 1);
            smooth.at(low, at - low as f64)
        })
        .collect();
    let moved = candidate(bvp, path.provenance.start.clone(), poses.into_iter());
    Candidate { provenance: path.provenance.clone(), ..moved }
}

/// Returns a cubic path along the shortest rotation from the start to the end.
pub fn shortest_way(model: &Model) -> Candidate {
    let relative = lie::minus(&model.target.attitude, &model.start.attitude);
    let pose = |stage: usize| {
        let t = stage as f64 * model.h;
        let along = hermite(t, 1.0, [&0.0, &1.0], [&0.0, &0.0]);
        Pose {
            position: model.start.position + (model.target.position - model.start.position) * along,
            attitude: model.start.attitude * lie::exp(&(relative * along)),
        }
    };
    path("straight", &model.dynamics.grid, (0..=model.steps).map(pose))
}

#[cfg(test)]
mod tests {
    use super::natural;
    use crate::lie;
    use crate::maneuver::problem::{Problem, State};
    use crate::mechanics::body::{Body, Inertia};
    use crate::optimize::discrete::sweep::BoundaryValueProblem;
    use crate::{Matrix3, Vector3};

    /// Claim: if the end is that of the motion without inputs, the path is that motion; with an
    /// additional turn it meets the same end.
    #[test]
    fn a_body_that_needs_no_inputs_goes_as_it_does_by_itself() {
        let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap(), mass: None };
        let start = State::attitude(Matrix3::identity(), Vector3::new(0.3, -0.2, 0.5));
        let of = |end: State| Problem::attitude(body.clone(), start, end, 20.0).with_steps(400);
        let problem = of(start);
        let mut coast = Vec::new();
        let bvp = BoundaryValueProblem::<6>::new(&problem, 400);
        bvp.coast(|attitude| coast.push(*attitude)).unwrap();
        let last = *coast.last().unwrap();
        // The momentum is constant in inertial space.
        let momentum = last.tr_mul(&(body.inertia.j() * start.angular_velocity));
        let problem = of(State::attitude(last, body.inertia.j_inverse() * momentum));
        let bvp = BoundaryValueProblem::<6>::new(&problem, 400);
        let [way, longer] = [0, 1].map(|turns| natural(&bvp, turns).unwrap());
        let off =
            |node: usize, attitude: &Matrix3| lie::minus(&way.states[node].attitude.value, attitude).norm();
        let worst = coast.iter().enumerate().map(|(node, attitude)| off(node, attitude)).fold(0.0, f64::max);
        assert!(coast.len() == 401 && worst < 1e-3, "{worst:.1e}");
        for path in [&way, &longer] {
            assert!(lie::minus(&path.states[400].attitude.value, &last).norm() < 1e-12);
        }
    }
}
