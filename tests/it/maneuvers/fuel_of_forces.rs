//! Minimum fuel and time where forces move the body, and in fields: closed forms on the grid,
//! another program on the same grid, laws.

use super::minimum_time::{body, solved};
use super::on_equal_steps::on_equal_steps;
use slewkit::maneuver::{Duration, Fuel, Method, Objective, Problem, ProblemError, Settings, State, Weights};
use slewkit::mechanics::{
    ActuatorSet, AxisFrame, GravityGradient, Limits, SecondOrderGravity, UniformGravity,
};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};

pub(super) const MASS: f64 = 4.0;
const STEPS: usize = 40;
/// Steps of maneuvers that are planned several times, and compared with each other alone.
pub(super) const FEW: usize = 24;

pub(super) fn each(limit: f64) -> Limits {
    Limits { size: Some(vec![limit; 3]), ..Limits::default() }
}

/// Returns a maneuver from rest to rest by a turn and a shift, with torques of at most 2 N·m along
/// body axes and forces under `limits`.
pub(super) fn flight(turn: [f64; 3], shift: [f64; 3], limits: Limits, frame: AxisFrame) -> Problem {
    let mut body = body([2.0, 1.6, 1.1]);
    body.mass = Some(MASS);
    let end = State { position: Vector3::from(shift), ..State::at_rest(lie::exp(&Vector3::from(turn))) };
    let mut problem = Problem::rigid_body(body, State::at_rest(Matrix3::identity()), end, 3.0);
    problem.actuation.torque = problem.actuation.torque.with_limits(each(2.0)).unwrap();
    problem.actuation.force = Some(ActuatorSet::three_axes(frame).with_limits(limits).unwrap());
    problem.with_steps(STEPS).with_objective(Objective::Fuel(Fuel::default()))
}

/// Returns the least `Σ κ |f|` of a shift from rest to rest along a line, in closed form: the
/// earlier a push and the later its counterpart, the farther it carries, and the kicks of both ends
/// have half the weight.
pub(super) fn pushes(shift: f64, duration: f64, limit: f64) -> f64 {
    let h = duration / STEPS as f64;
    let (mut left, mut fuel) = (MASS * shift.abs(), 0.0);
    for node in 0..STEPS / 2 {
        let reach = duration - 2.0 * h * node as f64;
        let most = limit * if node == 0 { 0.5 * h } else { h };
        let push = most.min(left / reach);
        (left, fuel) = (left - push * reach, fuel + 2.0 * push);
    }
    assert!(left < 1e-12, "no plan");
    fuel
}

pub(super) fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found / wanted - 1.0).abs() <= tolerance, "{found:.10}, wanted {wanted:.10}");
}

#[test]
fn a_shift_costs_what_the_earliest_and_latest_pushes_do() {
    let shift = [0.9, -0.4, 0.2];
    let each_axis: f64 = shift.iter().map(|along| pushes(*along, 3.0, 2.5)).sum();
    let found = solved(&flight([0.0; 3], shift, each(2.5), AxisFrame::Reference));
    near(found.solution.cost, each_axis, 1e-8);
    // One force that points anywhere.
    let length = Vector3::from(shift).norm();
    let whole = Limits { norm: Some(2.5), ..Limits::default() };
    let found = solved(&flight([0.0; 3], shift, whole, AxisFrame::Reference));
    near(found.solution.cost, pushes(length, 3.0, 2.5), 1e-8);
}

#[test]
fn prices_weigh_forces_against_torques_and_neither_feels_the_other() {
    let (turn, shift) = ([0.5, -0.7, 0.3], [0.9, -0.4, 0.2]);
    let still = solved(&flight(turn, [0.0; 3], each(2.5), AxisFrame::Reference)).solution.cost;
    let prices = [2.0, 1.0, 0.5];
    let fuel = Fuel { force_prices: Some(prices.to_vec()), ..Fuel::default() };
    let priced = flight(turn, shift, each(2.5), AxisFrame::Reference).with_objective(Objective::Fuel(fuel));
    let of_axes = shift.iter().zip(prices).map(|(along, price)| price * pushes(*along, 3.0, 2.5));
    near(solved(&priced).solution.cost, still + of_axes.sum::<f64>(), 1e-6);
}

#[test]
fn the_shortest_flight_pushes_all_the_way() {
    // Half of the way each way, at full force: T = 2 √(m d / f), on an even number of steps to the
    // last digit.
    let flight = flight([0.2, 0.1, -0.3], [0.9, -0.4, 0.2], each(2.5), AxisFrame::Reference);
    let found = solved(&flight.with_objective(Objective::Time).with_duration(Duration::SOUGHT));
    near(found.solution.cost, 2.0 * (MASS * 0.9 / 2.5_f64).sqrt(), 1e-8);
}

#[test]
fn more_time_never_costs_more_fuel_and_a_price_of_time_finds_its_trade() {
    let flight = flight([0.5, -0.7, 0.3], [0.9, -0.4, 0.2], each(2.5), AxisFrame::Body);
    let costs = [2.8, 3.5, 5.0].map(|duration| solved(&flight.clone().with_duration(duration)).solution.cost);
    assert!(costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
    let price = 1.5;
    let objective = Objective::Fuel(Fuel { time_price: Some(price), ..Fuel::default() });
    let traded = solved(&flight.clone().with_objective(objective).with_duration(Duration::SOUGHT));
    let duration = traded.solution.duration(&flight);
    // No plan in the duration found costs less, and neither does a plan in slightly more or less
    // time.
    for factor in [0.97, 1.0, 1.03] {
        let stated = solved(&flight.clone().with_duration(duration * factor)).solution.cost;
        let whole = stated + price * duration * factor;
        assert!(
            traded.solution.cost <= whole * (1.0 + 1e-6),
            "{factor}: {whole}, found {}",
            traded.solution.cost
        );
    }
}

#[test]
fn moves_along_a_bend_are_corrected_and_few() {
    // A pendulum's field bends the dynamics along a move: the defects at the end of a move give
    // back the duration that the move takes away. The iteration needs ten times as many moves,
    // which shrink, if it has no corrections of second order.
    let field = UniformGravity::new(MASS, 9.81, Vector3::z(), Vector3::new(0.02, 0.1, 0.1)).unwrap();
    let start = State::at_rest(lie::exp(&Vector3::new(0.3, 0.2, 0.1)));
    let end = State::at_rest(start.attitude * lie::exp(&Vector3::new(0.9, 0.1, 0.2)));
    let mut pendulum =
        Problem::attitude(body([2.0, 1.6, 1.1]), start, end, Duration::SOUGHT).with_environment(field);
    pendulum.actuation.torque = pendulum.actuation.torque.with_limits(each(7.5)).unwrap();
    let found = solved(&pendulum.with_steps(24).with_objective(Objective::Time));
    let iterations = found.solution.interior.expect("planned by the interior point").iterations;
    assert!(iterations <= 30, "{iterations} iterations");
}

#[test]
fn in_a_field_that_pulls_hardly_the_fuel_is_that_of_a_free_body() {
    let free = {
        let mut problem = flight([0.5, -0.7, 0.3], [0.0; 3], each(2.5), AxisFrame::Reference);
        problem.motion = slewkit::maneuver::Motion::Attitude;
        problem.body.mass = None;
        problem.actuation.force = None;
        problem
    };
    let wanted = on_equal_steps(&free).solution.cost;
    let pull = UniformGravity::new(1e-9, 9.81, Vector3::z(), Vector3::new(0.0, 0.1, 0.3)).unwrap();
    near(solved(&free.clone().with_environment(pull)).solution.cost, wanted, 1e-6);
    let orbit = GravityGradient::new(1e-7, &free.body.inertia).unwrap();
    near(solved(&free.clone().with_environment(orbit)).solution.cost, wanted, 1e-6);
}

/// Returns a body at rest in the frame of an orbit that yaws by a quarter of a turn, under torques
/// of at most 0.3 N·m.
fn on_an_orbit(rate: f64) -> Problem {
    let body = body([2.0, 1.6, 1.1]);
    let orbit = GravityGradient::new(rate, &body.inertia).unwrap();
    let still = |attitude: Matrix3| State {
        angular_velocity: attitude.tr_mul(&(rate * Vector3::y())),
        ..State::at_rest(attitude)
    };
    let end = still(lie::exp(&Vector3::new(0.1, 0.0, 1.5)));
    let mut problem = Problem::attitude(body, still(Matrix3::identity()), end, 5.0).with_environment(orbit);
    problem.actuation.torque = problem.actuation.torque.with_limits(each(0.3)).unwrap();
    problem.with_steps(STEPS)
}

/// Returns the objective of least effort with a price of time.
fn effort(price: f64) -> Objective {
    Objective::Effort(Weights { time_price: Some(price), ..Weights::default() })
}

/// Requires that a plan with a sought duration costs at most as much as plans in durations near it,
/// and exactly as much as a plan in that duration.
fn is_cheapest_in_its_duration(sought: &Problem, price: f64) {
    let found = solved(sought);
    let duration = *found.solution.trajectory.time.last().unwrap();
    let of_given = |duration: f64| {
        let objective = match &sought.objective {
            Objective::Fuel(fuel) => Objective::Fuel(Fuel { time_price: None, ..fuel.clone() }),
            _ => Objective::default(),
        };
        let given = sought.clone().with_objective(objective).with_duration(duration);
        solved(&given).solution.cost + price * duration
    };
    near(found.solution.cost, of_given(duration), 1e-7);
    for beside in [0.97, 1.03] {
        assert!(of_given(beside * duration) > found.solution.cost * (1.0 + 1e-6), "{beside}");
    }
}

#[test]
fn a_duration_is_sought_in_a_frame_that_turns() {
    let fuel = |price| Objective::Fuel(Fuel { time_price: Some(price), ..Fuel::default() });
    let turn = on_an_orbit(0.2).with_steps(FEW).with_duration(Duration::SOUGHT);
    is_cheapest_in_its_duration(&turn.clone().with_objective(fuel(0.05)), 0.05);
    // No plan is shorter than the shortest duration, and a plan exists in a little more.
    let quickest = solved(&turn.clone().with_objective(Objective::Time)).solution.cost;
    let given = |duration: f64| {
        let given = turn.clone().with_objective(Objective::Fuel(Fuel::default())).with_duration(duration);
        plan(&given, &Settings::discrete(), None, &mut Silent).unwrap().status
    };
    assert_eq!(given(1.001 * quickest), Status::Solved);
    assert_eq!(given(0.99 * quickest), Status::NotConverged);
    // If the frame hardly turns, the cost is the cost of a free body.
    let slow = solved(
        &on_an_orbit(1e-7).with_steps(FEW).with_duration(Duration::SOUGHT).with_objective(Objective::Time),
    );
    let free =
        on_an_orbit(0.0).with_steps(FEW).with_duration(Duration::SOUGHT).with_objective(Objective::Time);
    near(slow.solution.cost, on_equal_steps(&free).solution.cost, 1e-6);
}

#[test]
fn a_duration_of_least_effort_is_the_best_of_those_given_to_the_shooting_in_a_frame_that_turns() {
    let price = 2e-3;
    let turning = on_an_orbit(0.2).with_objective(Objective::default());
    let sought = turning.clone().with_objective(effort(price)).with_duration(Duration::SOUGHT);
    let found = solved(&sought).solution;
    let best = found.duration(&sought);
    let given = |part: f64| {
        let plan = solved(&turning.clone().with_duration(part * best)).solution;
        assert_eq!(plan.method, Method::Shooting);
        plan.cost + price * part * best
    };
    assert_eq!(found.method, Method::InteriorPoint);
    near(found.cost, given(1.0), 1e-10);
    assert!(given(0.999) > found.cost && given(1.001) > found.cost);
}

#[test]
fn a_duration_is_sought_where_a_body_moves_through_a_field() {
    // The body is fast at both ends, so the unit of length scales with the duration.
    let mut flight = flight([0.5, -0.7, 0.3], [1.2, 0.4, -0.2], each(2.5), AxisFrame::Reference);
    flight.start.position = Vector3::new(1.0, 0.2, 0.1);
    flight.start.velocity = Vector3::new(0.1, 0.8, -0.2);
    flight.end.velocity = Vector3::new(-0.3, 0.6, 0.1);
    let pull = SecondOrderGravity::new(0.8, MASS, &flight.body.inertia).unwrap();
    // Discrete motions on fewer steps pass by the center of the field as no body does.
    let flight = flight.with_steps(2 * STEPS).with_environment(pull).with_duration(Duration::SOUGHT);
    let fuel = Fuel { time_price: Some(2.0), ..Fuel::default() };
    is_cheapest_in_its_duration(&flight.clone().with_objective(Objective::Fuel(fuel)), 2.0);
    let mut unlimited = flight.clone().with_objective(effort(1.0));
    unlimited.actuation.force = Some(ActuatorSet::three_axes(AxisFrame::Reference));
    unlimited.actuation.torque = ActuatorSet::three_axes(AxisFrame::Body);
    is_cheapest_in_its_duration(&unlimited, 1.0);
    solved(&flight.with_objective(Objective::Time));
}

#[test]
fn forces_need_limits_and_a_price_each() {
    let free = flight([0.5, -0.7, 0.3], [0.9, -0.4, 0.2], each(2.5), AxisFrame::Reference);
    let mut unlimited = free.clone();
    unlimited.actuation.force = Some(ActuatorSet::three_axes(AxisFrame::Reference));
    let error = unlimited.check().expect_err("accepted");
    assert!(matches!(error, ProblemError::Unsuited(_)), "{error}");
    assert!(error.to_string().contains("a limit on every force"), "{error}");
    let two = Fuel { force_prices: Some(vec![1.0; 2]), ..Fuel::default() };
    let error = free.with_objective(Objective::Fuel(two)).check().expect_err("accepted").to_string();
    assert!(error.contains("number of force inputs"), "{error}");
}

#[test]
fn what_cannot_be_reached_in_time_is_told_with_the_shortest_duration() {
    let hasty =
        flight([0.2, 0.1, -0.3], [0.9, -0.4, 0.2], each(2.5), AxisFrame::Reference).with_duration(2.2);
    let found = plan(&hasty, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::NotConverged);
    near(found.solution.shortest.expect("told"), 2.0 * (MASS * 0.9 / 2.5_f64).sqrt(), 1e-4);
}
