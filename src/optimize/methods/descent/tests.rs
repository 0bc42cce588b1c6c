//! Tests of descent against finite differences, a dense Hessian and shooting.

use super::path::{Direction, Path, Setting};
use super::riccati::{Backward, Shift};
use super::*;
use crate::Vector3;
use crate::maneuver::problem::{Problem, Scheme};
use crate::maneuver::settings::Method as Road;
use crate::mechanics::actuators::AxisFrame;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::shooting::newton::Newton;
use crate::testing::{Random, attitude_only, moving_ends};
use nalgebra::DMatrix;

const STEPS: usize = 12;

/// Returns maneuvers on SE(3) with nonzero boundary rates in a gravity field, for both schemes and
/// input frames.
fn maneuvers(random: &mut Random) -> Vec<Problem> {
    let frames = [AxisFrame::Body, AxisFrame::Reference];
    let schemes = [Scheme::LieVerlet, Scheme::LieEuler];
    let every = frames.iter().flat_map(|frame| schemes.iter().map(move |scheme| (*frame, *scheme)));
    every.map(|(frame, scheme)| moving_ends(random, frame).with_scheme(scheme).with_steps(STEPS)).collect()
}

/// Returns a random path between the boundary poses.
fn bent<const N: usize>(bvp: &BoundaryValueProblem<N>, random: &mut Random, by: f64) -> Vec<Pose> {
    let (start, target) = (bvp.start.pose(), bvp.terminal.target().pose());
    let turn = lie::minus(&target.attitude, &start.attitude);
    let (a, b) = (random.vector3() * by, random.vector3() * by);
    (0..=STEPS)
        .map(|node| {
            let t = node as f64 / STEPS as f64;
            let hump = (std::f64::consts::PI * t).sin();
            Pose {
                position: start.position.lerp(&target.position, t) + a * hump,
                attitude: start.attitude * lie::exp(&(turn * t + b * hump)),
            }
        })
        .collect()
}

/// Returns the unknowns of a path for finite differences: for each, the node and the row that it
/// moves.
fn unknowns<const N: usize, const D: usize>(setting: &Setting<N, D>) -> Vec<(usize, Half<D>)> {
    let rows = |node| (0..D).map(move |row| (node, Half::<D>::from_fn(|r, _| f64::from(u8::from(r == row)))));
    setting.inner().flat_map(rows).collect()
}

fn with_moved<const N: usize, const D: usize>(
    setting: &Setting<N, D>,
    path: &Path<D>,
    node: usize,
    along: &Half<D>,
    by: f64,
) -> Path<D> {
    let mut poses = path.poses.clone();
    poses[node] = moved(&poses[node], along, by);
    let mut path = Path::of(setting, poses).unwrap();
    path.differentiate(setting);
    path
}

fn check_gradient<const N: usize, const D: usize>(problem: &Problem, random: &mut Random) {
    let bvp = BoundaryValueProblem::<N>::new(problem, STEPS);
    let setting = Setting::<N, D>::new(&bvp.dynamics, &bvp.start, bvp.terminal.target()).unwrap();
    let mut path = Path::of(&setting, bent(&bvp, random, 0.3)).unwrap();
    path.differentiate(&setting);
    let unknowns = unknowns(&setting);
    let size = path.gradient.iter().map(|g| g.amax()).fold(0.0, f64::max);
    for (node, along) in &unknowns {
        let ahead = with_moved(&setting, &path, *node, along, 1e-5);
        let back = with_moved(&setting, &path, *node, along, -1e-5);
        let slope = (ahead.cost - back.cost) / 2e-5;
        let error = (slope - path.gradient[*node].dot(along)).abs() / size;
        assert!(error < 1e-6, "gradient: {error:e}");
    }
}

#[test]
fn the_gradient_is_that_of_finite_differences() {
    let mut random = Random(7);
    for problem in maneuvers(&mut random) {
        check_gradient::<12, 6>(&problem, &mut random);
        check_gradient::<6, 3>(&attitude_only(problem), &mut random);
    }
}

/// Returns the Hessian, by finite differences of the gradient; symmetric.
fn dense<const N: usize, const D: usize>(setting: &Setting<N, D>, path: &Path<D>) -> DMatrix<f64> {
    let unknowns = unknowns(setting);
    let mut hessian = DMatrix::zeros(unknowns.len(), unknowns.len());
    for (column, (node, along)) in unknowns.iter().enumerate() {
        let ahead = with_moved(setting, path, *node, along, 1e-5);
        let back = with_moved(setting, path, *node, along, -1e-5);
        for (row, (other, direction)) in unknowns.iter().enumerate() {
            hessian[(row, column)] = (ahead.gradient[*other] - back.gradient[*other]).dot(direction) / 2e-5;
        }
    }
    (&hessian + hessian.transpose()) * 0.5
}

fn descended<const N: usize, const D: usize>(problem: &Problem, random: &mut Random) {
    let bvp = BoundaryValueProblem::<N>::new(problem, STEPS);
    let (start, target) = (&bvp.start, bvp.terminal.target());
    let poses = bent(&bvp, random, 0.5);
    let mut candidate = Candidate::empty(Road::Shooting, "bent", bvp.dynamics.grid.clone());
    candidate.states = poses.iter().map(|pose| point(pose, Vector3::zeros(), Vector3::zeros())).collect();
    let (dynamics, tolerance) = (&bvp.dynamics, 1e-14);
    let descent = Descent { dynamics, start, target, translates: D == 6, tolerance, known: &[] };
    let budget = Budget { iterations: 200, watch: Watch::NONE };
    let attempt = descent.improve(candidate, &budget);
    let residuals = &attempt.runs[0].report.residuals;
    assert!(attempt.converged(), "{:?} {residuals:?}", attempt.outcome);
    // The descent ends at the extremal of shooting, with the same cost.
    let costate = attempt.candidate.costate::<N>();
    let newton = Newton::new(&bvp, 1e-11, costate, None).unwrap();
    assert!(newton.end.residual() < 1e-4, "{:e}", newton.end.residual());
    let (newton, report) = run(newton, 10, &|| None);
    assert_eq!(report.outcome, Outcome::Converged);
    let error = (newton.end.cost - attempt.cost).abs() / attempt.cost;
    assert!(error < 1e-10, "{error:e} after {} iterations", residuals.len());
    // The Hessian is positive definite, and the direction at a nearby path is Newton's.
    let setting = Setting::<N, D>::new(&bvp.dynamics, start, target).unwrap();
    let mut path = Path::of(&setting, attempt.candidate.states.iter().map(Point::pose).collect()).unwrap();
    path.differentiate(&setting);
    let hessian = dense(&setting, &path);
    let lowest = hessian.clone().symmetric_eigen().eigenvalues.min();
    assert!(lowest > 0.0, "{lowest:e}");
    // From a nearby path the iteration converges quadratically, so that the direction uses the
    // exact Hessian.
    let mut left = Vec::new();
    for size in [1e-3, 1e-4] {
        let mut beside = path.clone();
        let mut bump = Direction::<D>::new(STEPS);
        for node in setting.inner() {
            let t = node as f64 / STEPS as f64;
            bump.zeta[node] =
                Half::<D>::from_fn(|row, _| size * (3.0 * t + row as f64).sin() * t * (1.0 - t));
        }
        beside.moved(&path, &bump, 1.0);
        assert!(beside.evaluate(&setting));
        beside.differentiate(&setting);
        let mut backward = Backward::<D>::new(STEPS);
        let mut direction = Direction::<D>::new(STEPS);
        assert!(backward.sweep(&setting, &beside, Shift(0.0)).is_ok());
        backward.forward(&setting, &mut direction);
        let errors = direction.zeta.iter().zip(&bump.zeta).map(|(a, b)| (a + b).norm());
        left.push(errors.fold(0.0, f64::max) / size);
    }
    assert!(left[1] < 0.15 * left[0] && left[0] < 0.1, "{left:?}");
}

#[test]
fn a_descent_ends_at_an_extremal_that_is_a_minimum_and_its_direction_is_that_of_newton() {
    let mut random = Random(11);
    for problem in maneuvers(&mut random) {
        descended::<12, 6>(&problem, &mut random);
        descended::<6, 3>(&attitude_only(problem), &mut random);
    }
}

/// Claim: a descent that approaches a known minimum returns it after fewer iterations; a known path
/// of equal cost with one different node does not stop it.
fn meets<const N: usize, const D: usize>(problem: &Problem, random: &mut Random) {
    let bvp = BoundaryValueProblem::<N>::new(problem, STEPS);
    let (start, target) = (&bvp.start, bvp.terminal.target());
    let starting = |poses: Vec<Pose>| {
        let mut candidate = Candidate::empty(Road::Shooting, "bent", bvp.dynamics.grid.clone());
        candidate.states = poses.iter().map(|pose| point(pose, Vector3::zeros(), Vector3::zeros())).collect();
        candidate
    };
    let descended = |from: &Candidate, known: &[Attempt]| {
        let dynamics = &bvp.dynamics;
        let descent = Descent { dynamics, start, target, translates: D == 6, tolerance: 1e-14, known };
        let attempt = descent.improve(from.clone(), &Budget { iterations: 200, watch: Watch::NONE });
        assert!(attempt.converged(), "{:?}", attempt.outcome);
        attempt
    };
    let poses = |attempt: &Attempt| attempt.candidate.states.iter().map(Point::pose).collect::<Vec<_>>();
    let minimum = descended(&starting(bent(&bvp, random, 0.3)), &[]);
    let from =
        starting(poses(&minimum).iter().map(|pose| moved(pose, &Half::<D>::repeat(0.02), 1.0)).collect());
    let iterations = |attempt: &Attempt| attempt.runs[0].report.iterations;
    let (alone, met) = (descended(&from, &[]), descended(&from, std::slice::from_ref(&minimum)));
    assert!((alone.cost - minimum.cost).abs() < 1e-12 * minimum.cost, "{} {}", alone.cost, minimum.cost);
    assert!(iterations(&met) < iterations(&alone), "{} {}", iterations(&met), iterations(&alone));
    assert_eq!((met.cost.to_bits(), poses(&met)), (minimum.cost.to_bits(), poses(&minimum)));
    let mut decoy = minimum.clone();
    let state = &mut decoy.candidate.states[STEPS / 2];
    *state = point(&moved(&state.pose(), &Half::<D>::repeat(0.01), 1.0), Vector3::zeros(), Vector3::zeros());
    assert_eq!(poses(&descended(&from, &[decoy])), poses(&alone));
}

#[test]
fn a_descent_ends_where_it_runs_into_a_known_minimum() {
    let mut random = Random(13);
    for problem in maneuvers(&mut random) {
        meets::<12, 6>(&problem, &mut random);
        meets::<6, 3>(&attitude_only(problem), &mut random);
    }
}
