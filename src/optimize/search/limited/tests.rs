//! Tests of arcs within limits, against closed forms and against plans on other grids.

use super::extrapolated;
use crate::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::maneuver::switching::{Structure, Switching};
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
use crate::{Vector3, lie};

#[test]
fn three_grids_give_what_an_even_expansion_has_at_no_step() {
    let at = |h: f64| 2.0 + 0.3 * h * h - 0.7 * h.powi(4);
    let (limit, error) = extrapolated([1.0, 1.0 / 3.0, 1.0 / 9.0].map(at));
    assert!((limit - 2.0).abs() < 1e-15 && error > 0.0, "{limit} {error}");
}

/// Returns a rest-to-rest turn about an axis, with torque limits of 1 N·m and principal moments of
/// 1, 2 and 2.9 kg·m².
fn turn(angle_deg: f64, axis: Vector3, rule: Rule) -> Problem {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.9)).unwrap(), mass: None };
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let end = lie::exp(&(axis.normalize() * angle_deg.to_radians()));
    let problem = Problem::attitude(
        body,
        State::at_rest(crate::Matrix3::identity()),
        State::at_rest(end),
        crate::maneuver::duration::Duration::SOUGHT,
    );
    let problem = problem.with_actuation(Actuation::torques(torques)).with_objective(Objective::Time);
    problem.with_constraint(Constraint { name: "limit".into(), rule })
}

fn cone() -> Rule {
    let direction = Direction::Fixed(Vector3::new(0.5, 3.0_f64.sqrt() / 2.0, 0.1).normalize());
    Rule::Pointing(Pointing::new(Side::KeepOut, vec![Vector3::x()], vec![direction], 20.0_f64.to_radians()))
}

/// Returns a rest-to-rest turn of this body by wheels with the given momentum limit.
fn by_wheels(angle_deg: f64, axis: Vector3, momentum_limit: f64) -> Problem {
    let wheels = Wheels { momentum: vec![0.0; 3], momentum_limit: vec![momentum_limit; 3] };
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let wheels = Actuation::of_wheels(axes, vec![1.0; 3], wheels).unwrap();
    let mut problem = turn(angle_deg, axis, cone()).with_actuation(wheels);
    problem.constraints.clear();
    problem
}

/// Returns the arcs of the plan of a problem on the given number of steps.
fn arcs_on(problem: &Problem, steps: usize, search: Thoroughness) -> Switching {
    let settings = Settings { target: Target::Discrete, search, ..Settings::default() };
    let problem = problem.clone().with_steps(steps);
    let found = crate::optimize::search::solve(&problem, &settings, None, &mut Silent).unwrap();
    found.switching.unwrap_or_else(|| panic!("no arcs on {steps} steps, {:?}", problem.objective))
}

/// Returns the cost in continuous time, the switching structure and the active limits of a plan on
/// the given number of steps.
fn planned(problem: &Problem, steps: usize) -> (f64, Structure, Vec<String>) {
    let told = arcs_on(problem, steps, Thoroughness::Default);
    assert!(told.gap < 1e-9 * told.continuous_cost);
    let met = told.arcs.iter().flat_map(|arc| arc.holds.iter().chain(&arc.touches).cloned()).collect();
    (told.continuous_cost, told.structure, met)
}

#[test]
fn least_time_and_fuel_past_a_cone_do_not_depend_on_the_grid() {
    let fuel =
        turn(120.0, Vector3::z(), cone()).with_objective(Objective::Fuel(Fuel::default())).with_duration(8.0);
    let time = turn(120.0, Vector3::z(), cone());
    for problem in [fuel, time] {
        let (coarse, structure, met) = planned(&problem, 80);
        let (fine, other, _) = planned(&problem, 120);
        assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
        assert_eq!(structure, other);
        assert!(!met.is_empty() || problem.objective == Objective::Time);
    }
}

/// Claim: for a flight with body-fixed thrust and wheels that saturate, the continuous cost does
/// not depend on the grid.
#[test]
fn least_fuel_of_flights_and_wheels_does_not_depend_on_the_grid() {
    let wheels = by_wheels(120.0, Vector3::new(1.0, 2.0, 3.0), 0.9);
    let wheels = wheels.with_objective(Objective::Fuel(Fuel::default())).with_duration(7.0);
    let body = Body { mass: Some(4.0), ..wheels.body.clone() };
    let limited = |size: f64| Limits { size: Some(vec![size; 3]), ..Limits::default() };
    let [torque, force] =
        [5.0, 4.0].map(|size| ActuatorSet::three_axes(AxisFrame::Body).with_limits(limited(size)).unwrap());
    let end = State { position: Vector3::new(0.3, -0.2, 0.5), ..wheels.end };
    let flight = Problem::rigid_body(body, wheels.start, end, 2.6);
    let flight = flight.with_actuation(Actuation::torques_and_forces(torque, force));
    let flight = flight.with_objective(Objective::Fuel(Fuel::default()));
    for problem in [wheels, flight] {
        let [coarse, fine] = [60, 100].map(|steps| planned(&problem, steps).0);
        assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
    }
}

/// Claim: if a short displacement takes less time than the turn, the forces are not saturated, and
/// the flight lasts as long as the turn alone, which has its own arcs.
#[test]
fn a_flight_by_forces_that_have_time_to_spare_lasts_as_long_as_its_turn() {
    let mut alone = turn(120.0, Vector3::new(1.0, 2.0, 3.0), cone()).with_steps(60);
    alone.constraints.clear();
    // The time limit of the search for arcs is not tested here.
    let search = Thoroughness::Thorough;
    let settings = Settings { target: Target::Discrete, search, ..Settings::default() };
    let lasts = |problem: &Problem| {
        let found = crate::optimize::search::solve(problem, &settings, None, &mut Silent).unwrap();
        found.switching.unwrap()
    };
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let force = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let body = Body { mass: Some(1.0), ..alone.body.clone() };
    let end = State { position: Vector3::new(0.2, 0.1, 0.1), ..alone.end };
    let flight = Problem::rigid_body(body, alone.start, end, crate::maneuver::duration::Duration::SOUGHT);
    let flight = flight.with_actuation(Actuation::torques_and_forces(alone.actuation.torque.clone(), force));
    let flight = flight.with_objective(Objective::Time).with_steps(60);
    let (alone, flight) = (lasts(&alone), lasts(&flight));
    assert!((flight.continuous_duration_s / alone.continuous_duration_s - 1.0).abs() < 1e-9);
    assert!(flight.gap < 1e-8, "{:e}", flight.gap);
    assert_eq!(flight.singular_inputs, [0, 1, 2], "forces are within their limits");
}

#[test]
fn fuel_under_a_rate_limit_goes_along_it() {
    let rule = Rule::RateAxes(Vector3::repeat(0.35));
    let problem = turn(120.0, Vector3::new(1.0, 2.0, 3.0), rule);
    let problem = problem.with_objective(Objective::Fuel(Fuel::default())).with_duration(8.0);
    let [coarse, fine] = [50, 100].map(|steps| planned(&problem, steps).0);
    assert!((coarse / fine - 1.0).abs() < 1e-9, "{coarse} {fine}");
}
