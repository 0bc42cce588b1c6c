//! Tests of arc gains against reference values, against plans solved again, and of the order of the
//! terminal miss.

use super::*;
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::Outcome;
use crate::mechanics::actuators::{Actuation, ActuatorSet, Limits};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search;
use crate::testing::{Random, reference, vector};
use crate::{Matrix3, Vector3};
use serde_json::Value;

fn limited(limit: f64) -> Actuation {
    let limits = Limits { size: Some(vec![limit; 3]), ..Limits::default() };
    Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap())
}

/// Returns a maneuver of the reference file and its plan, with one step per arc.
fn of_reference(case: &Value) -> (Problem, Trajectory) {
    let inertia = Matrix3::from_diagonal(&vector::<3>(&case["inertia"]));
    let end: [f64; 4] = std::array::from_fn(|index| case["qf"][index].as_f64().unwrap());
    let end = State::at_rest(lie::project_to_rotation(&lie::rotation_from_quaternion(&end)));
    let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
    let limit = case["torque_limit"].as_f64().unwrap();
    let problem = Problem::minimum_time(body, State::at_rest(Matrix3::identity()), end);
    let problem = problem.with_actuation(limited(limit));
    let lengths: Vec<f64> =
        case["arc_lengths"].as_array().unwrap().iter().map(|length| length.as_f64().unwrap()).collect();
    let mut plan = Trajectory { input_count: 3, time: vec![0.0], ..Trajectory::default() };
    for (arc, length) in lengths.iter().enumerate() {
        plan.time.push(plan.time[arc] + length);
        let inputs: Vector3 = vector(&case["inputs_per_arc"][arc]);
        plan.input.extend(inputs.iter());
        plan.torque.push(inputs);
    }
    plan.quaternion = vec![[1.0, 0.0, 0.0, 0.0]; plan.time.len()];
    plan.angular_velocity = vec![Vector3::zeros(); plan.time.len()];
    (problem, plan)
}

fn cases() -> serde_json::Map<String, Value> {
    reference("closed_loop/cl03_switching_time_gains.json")["cases"].as_object().unwrap().clone()
}

/// Converts the derivatives `∂d/∂[ζ; Π]` of an arc length to `∂d/∂[ζ; Ω]`.
fn by_rate(gains: &SwitchingGains, problem: &Problem, arc: usize) -> Vector6 {
    let row = gains.row(arc);
    let by_rate = problem.body.inertia.j() * Vector3::from_column_slice(&row[3..]);
    Vector6::new(row[0], row[1], row[2], by_rate.x, by_rate.y, by_rate.z)
}

#[test]
fn gains_of_arcs_are_those_of_the_references() {
    for (name, case) in cases() {
        let (problem, plan) = of_reference(&case);
        let gains = SwitchingGains::along(&problem, &plan).unwrap();
        let largest = case["gain_darc_dz0"].as_array().unwrap().iter();
        let largest = largest.map(|row| vector::<6>(row).amax()).fold(0.0, f64::max);
        for arc in 0..gains.arcs.len() {
            let expected: Vector6 = vector(&case["gain_darc_dz0"][arc]);
            let apart = (by_rate(&gains, &problem, arc) - expected).amax() / largest;
            assert!(apart < 1e-11, "{name} {arc}: {apart:e}");
        }
    }
}

/// Returns the problem with its start displaced by `z`, in rad and rad/s.
fn moved(problem: &Problem, z: &Vector6) -> Problem {
    let mut start = problem.start;
    start.attitude *= lie::exp(&z.fixed_rows::<3>(0).into_owned());
    start.angular_velocity += z.fixed_rows::<3>(3);
    Problem { start, ..problem.clone() }
}

/// Returns the terminal error of the motion of a plan relative to the requested end: in rad, and
/// for rates in rad per duration of the plan.
fn miss(problem: &Problem, plan: &Trajectory, end: &State) -> f64 {
    let duration = *plan.time.last().unwrap();
    let flown = Flight::new(problem).fly(&Flight::of_plan(problem, plan), None).unwrap();
    let rate = (flown.angular_velocity - end.angular_velocity) * duration;
    lie::minus(&flown.attitude, &end.attitude).norm().hypot(rate.norm())
}

fn end_of(problem: &Problem, plan: &Trajectory) -> State {
    Flight::new(problem).fly(&Flight::of_plan(problem, plan), None).unwrap()
}

/// Returns the order with which the terminal miss of corrected starts falls with the deviation of
/// the start, measured between deviations of 1e-3 and 1e-4 (rad, and rad per duration of the plan).
fn slope(problem: &Problem, plan: &Trajectory, gains: &SwitchingGains, direction: &Vector6) -> f64 {
    let (end, duration) = (end_of(problem, plan), *plan.time.last().unwrap());
    let at = |size: f64| {
        let mut z = direction * size;
        z.fixed_rows_mut::<3>(3).scale_mut(1.0 / duration);
        let beside = moved(problem, &z);
        miss(&beside, &gains.corrected(&beside, plan).unwrap(), &end)
    };
    (at(1e-3) / at(1e-4)).log10()
}

#[test]
fn corrected_arcs_land_to_second_order_and_a_wrong_sign_to_first() {
    let mut random = Random(11);
    for (name, case) in cases() {
        let (problem, plan) = of_reference(&case);
        let gains = SwitchingGains::along(&problem, &plan).unwrap();
        for _ in 0..4 {
            let direction = Vector6::from_fn(|_, _| random.uniform()).normalize();
            let right = slope(&problem, &plan, &gains, &direction);
            assert!((right - 2.0).abs() < 0.1, "{name}: {right}");
            let mut turned = gains.clone();
            turned.rows.iter_mut().skip(2).step_by(6).for_each(|value| *value = -*value);
            let wrong = slope(&problem, &plan, &turned, &direction);
            assert!((wrong - 1.0).abs() < 0.1, "{name}: {wrong}");
        }
    }
}

/// Tests a plan of the planner itself: on a grid, for the discrete problem, landed on the true
/// motion.
#[test]
fn plans_that_switch_are_corrected_as_they_are_flown() {
    let (problem, _) = of_reference(&cases()["xte_110_six_switches"]);
    let problem = problem.with_steps(80);
    let solution = search::solve(&problem, &Settings::default(), None, &mut search::Silent).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged);
    let problem = solution.on_grid(&problem);
    let plan = &solution.trajectory;
    let gains = SwitchingGains::along(&problem, plan).unwrap();
    assert_eq!(gains.arcs.len(), 7);
    assert_eq!(gains.arcs.iter().map(|arc| arc.steps).sum::<usize>(), problem.steps);
    let mut random = Random(5);
    for _ in 0..4 {
        let direction = Vector6::from_fn(|_, _| random.uniform()).normalize();
        let slope = slope(&problem, plan, &gains, &direction);
        assert!((slope - 2.0).abs() < 0.1, "{slope}");
    }
}

/// Returns the lengths of the continuous-time arcs of a plan.
fn continuous(problem: &Problem) -> Vec<f64> {
    let solution = search::solve(problem, &Settings::discrete(), None, &mut search::Silent).unwrap();
    assert_eq!(solution.outcome, Outcome::Converged);
    solution.switching.unwrap().arcs.iter().map(|arc| arc.end_s - arc.start_s).collect()
}

/// Returns the continuous-time arcs of a plan as a trajectory with one step per arc.
fn of_continuous(problem: &Problem) -> Trajectory {
    let solution = search::solve(problem, &Settings::discrete(), None, &mut search::Silent).unwrap();
    let arcs = solution.switching.unwrap().arcs;
    let nodes = arcs.len() + 1;
    Trajectory {
        input_count: 3,
        time: std::iter::once(0.0).chain(arcs.iter().map(|arc| arc.end_s)).collect(),
        input: arcs.iter().flat_map(|arc| arc.input.clone()).collect(),
        torque: arcs.iter().map(|arc| problem.actuation.torque.output(&arc.input)).collect(),
        quaternion: vec![lie::quaternion_from_rotation(&problem.start.attitude); nodes],
        angular_velocity: vec![problem.start.angular_velocity; nodes],
        ..Trajectory::default()
    }
}

/// Compares the gains with the differences between minimum-time and minimum-fuel plans that the
/// planner finds from starts on both sides.
#[test]
fn gains_of_arcs_are_the_differences_of_plans_solved_again() {
    let (time, _) = of_reference(&cases()["xte_110_six_switches"]);
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.4, 0.8)).unwrap(), mass: None };
    let end = State::at_rest(lie::exp(&Vector3::new(0.5, 0.9, -0.7)));
    let fuel = Problem::minimum_fuel(body, State::at_rest(Matrix3::identity()), end, 4.5);
    let fuel = fuel.with_actuation(limited(1.0));
    let mut random = Random(21);
    for (name, problem) in [("time", time), ("fuel", fuel)] {
        let problem = problem.with_steps(80);
        let gains = SwitchingGains::along(&problem, &of_continuous(&problem)).unwrap();
        for _ in 0..2 {
            let mut z = Vector6::from_fn(|_, _| random.uniform()) * 1e-4;
            z.fixed_rows_mut::<3>(3).scale_mut(1.0 / gains.arcs.iter().map(|arc| arc.length).sum::<f64>());
            let (plus, minus) = (continuous(&moved(&problem, &z)), continuous(&moved(&problem, &-z)));
            let found: Vec<f64> = plus.iter().zip(&minus).map(|(a, b)| 0.5 * (a - b)).collect();
            let size = found.iter().fold(0.0, |size: f64, change| size.max(change.abs()));
            for (arc, found) in found.iter().enumerate() {
                let expected = by_rate(&gains, &problem, arc).dot(&z);
                assert!((found - expected).abs() < 1e-5 * size, "{name} {arc}: {found} {expected}");
            }
        }
        if name == "fuel" {
            // The duration is given, so the changes of the arc lengths add up to zero.
            for column in 0..6 {
                let sum: f64 = (0..gains.arcs.len()).map(|arc| gains.row(arc)[column]).sum();
                assert!(sum.abs() < 1e-9, "{sum}");
            }
        }
    }
}

#[test]
fn an_error_that_reverses_an_arc_is_told() {
    let (problem, plan) = of_reference(&cases()["xte_150_five_switches"]);
    let gains = SwitchingGains::along(&problem, &plan).unwrap();
    for (column, (least, arc)) in gains.reach().into_iter().enumerate() {
        let mut z = Vector6::zeros();
        z[column] = -least * gains.row(arc)[column].signum();
        assert!(gains.lengths(&(z * 0.999)).is_ok());
        assert_eq!(gains.lengths(&(z * 1.001)).unwrap_err().arc, arc);
    }
}

#[test]
fn arcs_that_no_start_moves_are_refused_with_the_reason() {
    let (problem, plan) = of_reference(&cases()["xte_150_five_switches"]);
    let refused = |problem: &Problem, plan: &Trajectory| match SwitchingGains::along(problem, plan) {
        Err(NoGains::Arcs(why)) => why,
        other => panic!("{other:?}"),
    };
    let given = problem.clone().with_duration(30.0);
    let effort = Problem { objective: Default::default(), ..given };
    assert!(refused(&effort, &plan).contains("do not switch"));
    let mut singular = plan.clone();
    singular.input[1] = 10.0;
    assert!(refused(&problem, &singular).contains("singular"));
    // A turn about one axis has only two arcs.
    let mut short = plan.clone();
    short.time.truncate(3);
    short.input.truncate(6);
    assert!(refused(&problem, &short).contains("too few"));
    assert!(refused(&problem, &Trajectory::default()).contains("no trajectory"));
}
