//! Tests of replanning: order of the initial guess, comparison with cold searches, and rejected
//! plans.

use super::*;
use crate::Vector3;
use crate::feedback::tests::maneuver;
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
use crate::plan::{Status, plan, replan};
use crate::testing::Random;

fn solved(problem: &Problem, settings: &Settings) -> Solution {
    let solution = search::solve(problem, settings, None, &mut Silent).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged);
    solution
}

fn prepared(problem: &Problem) -> Replanner {
    Replanner::new(problem, &solved(problem, &Settings::discrete())).unwrap()
}

/// Returns the planned state at a moment, displaced by a scaled `z`.
fn beside(replanner: &Replanner, moment: &Moment, z: &Vector6) -> State {
    let planned = replanner.planned(moment);
    let (problem, time) = (replanner.problem(), replanner.problem().seconds());
    let momentum = z.fixed_rows::<3>(3) * (problem.body.inertia.mean() / time);
    State {
        attitude: planned.attitude * lie::exp(&z.fixed_rows::<3>(0).into_owned()),
        angular_velocity: planned.angular_velocity + problem.body.inertia.j_inverse() * momentum,
        ..planned
    }
}

fn direction(random: &mut Random) -> Vector6 {
    Vector6::from_fn(|_, _| random.uniform()).normalize()
}

/// The error of the guess at the end is proportional to the square of the displacement of the
/// start: slope 2.00 ± 0.1 at nodes, for both schemes, force fields and limits. A guess without the
/// correction, or with the opposite one, has slope 1. The cost agrees with its second-order
/// expansion up to the third order.
#[test]
fn the_guess_misses_by_the_square_of_the_shift() {
    let mut random = Random(11);
    for case in 0..40 {
        let problem = maneuver(&mut random, case % 5);
        let replanner = prepared(&problem);
        assert!(replanner.corrects());
        let wrong = |factor: f64| {
            let mut wrong = replanner.clone();
            wrong.nodes.iter_mut().for_each(|node| node.correction *= factor);
            wrong
        };
        let moment = replanner.node([0, 1, 17, 40][case % 4]).unwrap();
        let z = direction(&mut random);
        let slope = |of: &Replanner| {
            let error =
                |size: f64| of.replan(&beside(of, &moment, &(z * size)), &moment, None).unwrap().guess_error;
            // Where limits become active or inactive, the error is not quadratic.
            let size = if case % 5 == 4 { 1e-4 } else { 1e-3 };
            (error(size) / error(0.1 * size)).log10()
        };
        let found = slope(&replanner);
        assert!((found - 2.0).abs() <= 0.1, "case {case}: {found}");
        for factor in [0.0, -1.0] {
            let found = slope(&wrong(factor));
            assert!((found - 1.0).abs() <= 0.1, "case {case}, times {factor}: {found}");
        }
    }
}

/// The cost of a neighbour is predicted up to the third order: slope 3 for a free body.
#[test]
fn the_cost_to_go_is_that_of_its_two_derivatives() {
    let mut random = Random(12);
    for case in 0..9 {
        let replanner = prepared(&maneuver(&mut random, case % 3));
        let moment = replanner.node([0, 17, 30][case / 3]).unwrap();
        let z = direction(&mut random);
        let apart = |size: f64| {
            let z = z * size;
            let found = replanner.replan(&beside(&replanner, &moment, &z), &moment, None).unwrap();
            let from = replanner.beginning(&moment);
            let expected = from.cost + from.slope.dot(&z) + 0.5 * z.dot(&(from.curvature * z));
            (found.cost / replanner.bvp.dynamics.units.cost - expected).abs()
        };
        let slope = (apart(1e-2) / apart(1e-3)).log10();
        assert!((slope - 3.0).abs() <= 0.25, "case {case}: {slope}");
    }
}

/// The rest of an optimal plan is optimal: replanned from its own state at a node, the plan is its
/// own neighbour, without a Newton step.
#[test]
fn a_plan_is_its_own_rest() {
    let mut random = Random(13);
    for case in 0..10 {
        let problem = maneuver(&mut random, case % 5);
        let solution = solved(&problem, &Settings::discrete());
        let replanner = Replanner::new(&problem, &solution).unwrap();
        for node in [0, 1, 20, 48] {
            let moment = replanner.node(node).unwrap();
            let found = replanner.replan(&replanner.planned(&moment), &moment, None).unwrap();
            assert!(found.guess_error < 1e-11, "case {case}, node {node}: {:e}", found.guess_error);
            let to_go = replanner.nodes[node].cost * replanner.bvp.dynamics.units.cost;
            assert!((found.cost / to_go - 1.0).abs() < 1e-11, "case {case}, node {node}");
            let row = (node + 1).checked_sub(1 + problem.scheme.first_input());
            let Some(row) = row else { continue };
            let own = &solution.trajectory.costates[6 * row..6 * row + 6];
            let apart =
                found.costates.iter().zip(own).fold(0.0, |apart: f64, (a, b)| apart.max((a - b).abs()));
            let size = own.iter().fold(0.0, |size: f64, value| size.max(value.abs()));
            assert!(apart <= 1e-10 * size, "case {case}, node {node}: {apart:e} of {size:e}");
        }
    }
}

/// A warm-started plan equals the plan of a cold search from the same start, at nodes and between
/// them, to the planned end and to another one: the cost to 1e-9, the end to 1e-12, within three
/// Newton steps.
#[test]
fn a_warm_plan_is_the_cold_one() {
    let mut random = Random(14);
    let settings = Settings::discrete();
    for case in 0..30 {
        let problem = maneuver(&mut random, case % 5);
        let replanner = prepared(&problem);
        let at = [0.0, 1.6, 2.0 + 0.3 * random.uniform()][case % 3];
        let moment = replanner.at(at).unwrap();
        assert!((moment.time + moment.duration - problem.seconds()).abs() < 1e-14 * problem.seconds());
        let size = 0.02;
        let start = beside(&replanner, &moment, &(direction(&mut random) * size));
        let end = State {
            attitude: problem.end.attitude * lie::exp(&(random.vector3() * 0.01)),
            angular_velocity: problem.end.angular_velocity + random.vector3() * 0.003,
            ..problem.end
        };
        let end = (case % 2 == 1).then_some(end);
        let warm = replanner.replan(&start, &moment, end.as_ref()).unwrap();
        let rest = Problem { start, end: end.unwrap_or(problem.end), ..problem.clone() };
        let rest = replanner.remaining(&rest, &moment);
        assert_eq!(rest.steps, moment.steps);
        let cold = solved(&rest, &settings);
        let apart = (warm.cost / cold.cost - 1.0).abs();
        assert!(apart <= 1e-9, "case {case}: {apart:e}, {} {}", warm.cost, cold.cost);
        assert!(warm.residual <= 1e-12 && warm.newton_steps <= 3, "case {case}: {warm:?}");
        let solution = replanner.solution(&rest, &warm, &settings, &mut Silent).unwrap();
        assert_eq!(solution.outcome, Outcome::Converged);
        assert!(solution.terminal.largest() <= 1e-12 && solution.iterations <= 1, "case {case}");
        assert!((solution.cost / cold.cost - 1.0).abs() <= 1e-9, "case {case}");
        assert_eq!(solution.optimality.conjugate_points, Some(0), "case {case}");
    }
}

fn landing() -> (Problem, Solution) {
    let body = Body { inertia: crate::testing::full_inertia(), mass: None };
    let start = State::attitude(lie::exp(&Vector3::new(0.1, 0.2, -0.3)), Vector3::new(0.2, -0.1, 0.1));
    let end = State::attitude(lie::exp(&Vector3::new(0.9, -0.8, 0.5)), Vector3::new(-0.1, 0.2, 0.1));
    let problem = Problem::attitude(body, start, end, 4.0).with_steps(60);
    let solution = solved(&problem, &Settings::default());
    assert!(solution.trajectory.target.is_some());
    (problem, solution)
}

/// A landed plan is replanned from its true motion. A start on the plan needs no Newton step, and
/// the witnesses confirm that the new plan lands.
#[test]
fn a_plan_that_lands_is_planned_again_to_land() {
    let (problem, solution) = landing();
    let replanner = Replanner::new(&problem, &solution).unwrap();
    for node in [0, 20, 50] {
        let moment = replanner.node(node).unwrap();
        let planned = replanner.planned(&moment);
        let own = replanner.replan(&planned, &moment, None).unwrap();
        assert!(own.guess_error < 1e-11, "node {node}: {:e}", own.guess_error);
        let start = beside(&replanner, &moment, &Vector6::new(0.01, -0.02, 0.01, 0.02, 0.01, -0.01));
        let moved = Problem { start, ..problem.clone() };
        let again = replan(&moved, &replanner, moment.time, &Settings::default(), &mut Silent).unwrap();
        assert_eq!((again.plan.status, again.warm.is_ok()), (Status::Solved, true), "node {node}");
        assert!(again.plan.solution.landing.is_some(), "node {node}");
        let time = &again.plan.solution.trajectory.time;
        assert_eq!((time.len(), again.problem.steps), (61 - node, 60 - node));
    }
}

/// A start outside of the basin of convergence is reported, and a search can plan it.
#[test]
fn a_start_far_away_falls_back_to_a_search() {
    let (problem, solution) = landing();
    let replanner = Replanner::new(&problem, &solution).unwrap();
    let settings = Settings::discrete();
    let mut left = 0;
    for axis in 0..3 {
        let mut turn = Vector3::zeros();
        turn[axis] = 3.0;
        let start = State {
            attitude: problem.start.attitude * lie::exp(&turn),
            angular_velocity: problem.start.angular_velocity + turn,
            ..problem.start
        };
        let moved = Problem { start, ..problem.clone() };
        let again = replan(&moved, &replanner, 0.0, &settings, &mut Silent).unwrap();
        assert_eq!(again.plan.status, Status::Solved);
        let Err(why) = again.warm else { continue };
        left += 1;
        assert!(!why.to_string().is_empty());
        let cold = plan(&moved.clone().with_steps(60), &settings, None, &mut Silent).unwrap();
        assert_eq!(again.plan.solution.cost, cold.solution.cost);
    }
    assert!(left >= 2, "{left}");
    let nowhere = State { angular_velocity: Vector3::repeat(f64::NAN), ..problem.start };
    let moment = replanner.node(0).unwrap();
    assert!(replanner.replan(&nowhere, &moment, None).is_err());
}

/// Newton's method also converges to extremals of another family; their cost shows this.
#[test]
fn an_extremal_that_costs_more_than_a_neighbour_is_none() {
    let (problem, solution) = landing();
    let mut replanner = Replanner::new(&problem, &solution).unwrap();
    let moment = replanner.node(0).unwrap();
    let start = replanner.planned(&moment);
    replanner.nodes[0].cost *= 0.7;
    assert_eq!(replanner.replan(&start, &moment, None).unwrap().newton_steps, 0);
    replanner.nodes[0].cost *= 0.9;
    let left = replanner.replan(&start, &moment, None).unwrap_err();
    assert!(matches!(left, Left::Dearer { cost, expected } if cost > 1.58 * expected), "{left:?}");
    replanner.nodes[0].cost = f64::NAN;
    assert!(replanner.replan(&start, &moment, None).is_err());
}

#[test]
fn what_cannot_be_begun_from_is_said() {
    let (problem, solution) = landing();
    let refused = |problem: &Problem| Replanner::new(problem, &solution).unwrap_err();
    assert_eq!(refused(&problem.clone().with_any_attitude_at_end()), NotReplanned::End);
    let moves = Problem { motion: Motion::RigidBody, ..problem.clone() };
    assert_eq!(refused(&moves), NotReplanned::Translation);
    let sought = problem.clone().with_duration(crate::maneuver::Duration::SOUGHT);
    assert_eq!(refused(&sought), NotReplanned::Form);
    let other = Problem { end: problem.start, ..problem.clone() };
    let mut elsewhere = solution.clone();
    elsewhere.trajectory.target = None;
    assert_eq!(Replanner::new(&other, &elsewhere).unwrap_err(), NotReplanned::Trajectory);
    let mut short = solution.clone();
    short.trajectory.costates.clear();
    assert_eq!(Replanner::new(&problem, &short).unwrap_err(), NotReplanned::Trajectory);
    let mut unfinished = solution.clone();
    unfinished.outcome = Outcome::Stalled;
    assert_eq!(Replanner::new(&problem, &unfinished).unwrap_err(), NotReplanned::Trajectory);
    let mut lost = solution.clone();
    lost.trajectory.costates[2] = f64::NAN;
    assert_eq!(Replanner::new(&problem, &lost).unwrap_err(), NotReplanned::Trajectory);

    let replanner = Replanner::new(&problem, &solution).unwrap();
    for time in [-0.1, f64::NAN, f64::INFINITY, 3.9, 4.0, 5.0] {
        assert!(matches!(replanner.at(time), Err(NotReplanned::Time { .. })), "{time}");
    }
    assert_eq!(replanner.at(4.0 - 2.0 * 4.0 / 60.0).unwrap().steps, 2);
    assert_eq!(replanner.at(1.0).unwrap(), replanner.node(15).unwrap());
    let heavy = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let heavy = Problem { body: heavy, ..problem.clone() };
    assert_eq!(replanner.fits(&heavy), Err(NotReplanned::Other("another body")));
    assert_eq!(replanner.fits(&problem), Ok(()));
}
