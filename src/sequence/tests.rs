//! Tests of sequences against plans of another program: multi-leg indirect shooting with exact
//! derivatives and multi-leg collocation with IPOPT, which agree to 1e-12 (minimum times to 1e-9).

use super::joined::Joined;
use super::joint::Joint;
use super::leg::Leg;
use super::order::Visit;
use super::rolls::cheapest;
use super::together::{Together, Tuning};
use super::{Ordering, Place, Sequence, SequenceError, SequencePlan, Stop, carried, windows};
use crate::maneuver::aim::Aim;
use crate::maneuver::constraint::{Constraint, Direction, Rule};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::Settings;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
use crate::plan::Status;
use crate::{Matrix3, Vector3, lie};

fn body(inertia: Matrix3) -> Body {
    Body { inertia: Inertia::new(inertia).unwrap(), mass: None }
}

/// Returns the body of the reference cases s02 and p06.
fn skew_body() -> Body {
    body(Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1))
}

fn rest() -> State {
    State::at_rest(Matrix3::identity())
}

fn to(quaternion: [f64; 4]) -> Place {
    Place::Attitude(lie::project_to_rotation(&lie::rotation_from_quaternion(&quaternion)))
}

/// Returns a place at which the third body axis points along a direction.
fn pointing(direction: [f64; 3]) -> Place {
    let at = Direction::Fixed(Vector3::from(direction).normalize());
    Place::Aim(Aim::new(Vector3::z(), at).at_rest())
}

fn stop(name: &str, place: Place) -> Stop {
    Stop::at(name, place)
}

fn planned(sequence: &Sequence) -> SequencePlan {
    sequence.plan(&Settings::discrete(), &mut Silent).unwrap()
}

/// Returns the cost in continuous time by Richardson extrapolation from two grids.
fn cost(on: impl Fn(usize) -> Sequence) -> f64 {
    let [coarse, fine] = [150, 300].map(|steps| planned(&on(steps)).cost);
    (4.0 * fine - coarse) / 3.0
}

fn is_near(found: f64, known: f64, within: f64) {
    assert!((found / known - 1.0).abs() < within, "{found:.12} {known:.12}");
}

/// Returns a minimum-effort sequence with a given total duration.
fn effort(body: Body, total: f64, stops: Vec<Stop>, steps: usize) -> Sequence {
    let craft = Problem::attitude(body, rest(), rest(), total).with_steps(steps);
    Sequence { craft, stops, order: Ordering::Given }
}

/// Two stops with free rolls and a third stop, at minimum effort: the rolls and the split of the
/// total time are found together.
#[test]
fn rolls_and_times_of_dwells_are_found_together() {
    let stops = || {
        let directions = [[1.0, 0.4, 0.3], [-0.3, 1.0, -0.5], [-0.8, -0.6, 0.4]];
        directions.iter().map(|direction| stop("dwell", pointing(*direction))).collect()
    };
    let found = planned(&effort(skew_body(), 13.5, stops(), 100));
    // With legs of 4, 5 and 4.5 s the minimum cost is 1.22057668385, and 1.22914 if each leg is
    // planned alone.
    assert!(found.cost < 1.2206 && found.cost > 1.1, "{}", found.cost);
    assert!((found.end - 13.5).abs() < 1e-9);
    // With the best split the Hamiltonian is equal in all legs: three times the mean rate of the
    // cost.
    let rates: Vec<f64> =
        found.legs.iter().map(|leg| leg.plan.solution.cost / leg.problem.seconds()).collect();
    assert!(rates.iter().all(|rate| (rate / rates[0] - 1.0).abs() < 1e-3), "{rates:?}");
}

/// Returns the cost of legs of given durations in continuous time, extrapolated from two grids.
fn of_legs(body: &Body, joints: &[Joint], durations: &[f64], first: &[State]) -> f64 {
    let on = |steps: usize| {
        let craft = Problem::attitude(body.clone(), rest(), rest(), 1.0).with_steps(steps);
        let (start, settings) = (rest(), &Settings::default());
        let mut time = 0.0;
        let ended = durations.iter().map(|lasting| {
            time += lasting;
            [time; 2]
        });
        let arrivals: Vec<[f64; 2]> = ended.collect();
        let together = Together {
            craft: &craft,
            start,
            begins: 0.0,
            visits: vec![Visit::PASSED; joints.len()],
            momentum: Vector3::zeros(),
            joints,
            arrivals: Some(&arrivals),
            settings,
            tuning: Tuning::default(),
        };
        let unknowns = together.unknowns(first, &[]);
        let whole = together.planned(unknowns, None, &mut Silent).unwrap().unwrap();
        together.improved(whole, &mut Silent).unwrap().cost()
    };
    let [coarse, fine] = [150, 300].map(on);
    (4.0 * fine - coarse) / 3.0
}

fn given(quaternion: [f64; 4]) -> State {
    State::at_rest(lie::project_to_rotation(&lie::rotation_from_quaternion(&quaternion)))
}

/// Cases p05 and s03: an attitude is passed at a given time, at a free and at a bounded rate.
#[test]
fn an_attitude_is_passed_at_the_best_rate() {
    let body = body(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)));
    let at = given([0.8660254037844387, 0.3535533905932737, 0.3535533905932737, 0.0]);
    let end = given([0.5000000000000001, 0.0, 0.6123724356957945, 0.6123724356957945]);
    for (fastest, known) in [(f64::INFINITY, 0.998951630319055), (0.25, 1.4433075327632423)] {
        let joints = [Joint::Passing { at, fastest }, Joint::Given(end)];
        is_near(of_legs(&body, &joints, &[2.5, 3.5], &[at, end]), known, 1e-8);
    }
}

/// Case s02: three stops at rest, each with a free roll.
#[test]
fn three_rolls_are_found_together() {
    let directions = [[1.0, 0.4, 0.3], [-0.3, 1.0, -0.5], [-0.8, -0.6, 0.4]];
    let joints = directions.map(|direction| {
        let at = Direction::Fixed(Vector3::from(direction).normalize());
        let aim = Aim::new(Vector3::z(), at).at_rest();
        Joint::Roll(aim.ends(0.0, &Matrix3::identity(), &Vector3::zeros()).unwrap())
    });
    let body = skew_body();
    let first = cheapest(&rest(), &joints, &|_| true, (body.inertia.j(), 2.0), &[4.0, 5.0, 4.5]);
    is_near(of_legs(&body, &joints, &[4.0, 5.0, 4.5], &first), 1.2205766838479164, 1e-8);
}

/// A leg between given ends has no unknowns; the roll at the end of the next leg is still optimal.
#[test]
fn a_leg_without_unknowns_goes_with_a_free_roll() {
    let at = given([0.8660254037844387, 0.3535533905932737, 0.3535533905932737, 0.0]);
    let direction = Direction::Fixed(Vector3::new(-0.3, 1.0, -0.5).normalize());
    let aim = Aim::new(Vector3::z(), direction).at_rest();
    let ends = aim.ends(0.0, &Matrix3::identity(), &Vector3::zeros()).unwrap();
    let (body, roll) = (skew_body(), Joint::Roll(ends));
    let rolled = |roll: f64| Joint::Roll(ends).state(&[roll]);
    let of_roll = |roll: f64| {
        let end = rolled(roll);
        of_legs(&body, &[Joint::Given(at), Joint::Given(end)], &[4.0, 5.0], &[at, end])
    };
    let scanned = (0..24).map(|k| f64::from(k) * std::f64::consts::PI / 12.0);
    let scanned = scanned.map(|roll| (of_roll(roll), roll));
    let (least, first) = scanned.reduce(|a, b| if b.0 < a.0 { b } else { a }).unwrap();
    let found = of_legs(&body, &[Joint::Given(at), roll], &[4.0, 5.0], &[at, rolled(first)]);
    assert!(found < least && found > 0.97 * least, "{found} {least}");
}

/// Case p06: a boresight passes a direction at a free time, before a given attitude is reached.
#[test]
fn a_boresight_passes_a_target_at_the_best_time() {
    let end = [0.3420201433256688, -0.7004055260107409, 0.2801622104042964, 0.5603244208085928];
    let stops = || {
        vec![stop("target", pointing([1.0, 0.5, 0.2])).passed_at_most_at(f64::INFINITY), stop("end", to(end))]
    };
    is_near(cost(|steps| effort(skew_body(), 7.0, stops(), steps)), 1.2476630471456327, 1e-8);
    let found = planned(&effort(skew_body(), 7.0, stops(), 300));
    assert!((found.legs[1].begins - 3.0777053935790963).abs() < 1e-3);
}

/// The coded gradient of a leg's cost agrees with differences.
#[test]
fn slopes_of_a_leg_are_those_of_its_cost() {
    let leg = |turn: &Vector3, rate: &Vector3, seconds: f64| {
        let end = State::attitude(
            lie::exp(&Vector3::new(0.4, -0.8, 1.2)) * lie::exp(turn),
            Vector3::new(0.1, 0.05, -0.1) + rate,
        );
        let problem = Problem::attitude(skew_body(), rest(), end, seconds).with_steps(200);
        Leg::of(problem, &Settings::default(), None, &mut Silent).unwrap().unwrap()
    };
    let (zero, by) = (Vector3::zeros(), 1e-4);
    let at = leg(&zero, &zero, 5.0);
    for axis in 0..3 {
        let by_turn = [by, -by].map(|by| leg(&Vector3::ith(axis, by), &zero, 5.0).cost);
        let by_rate = [by, -by].map(|by| leg(&zero, &Vector3::ith(axis, by), 5.0).cost);
        let slope = |[up, down]: [f64; 2]| (up - down) / (2.0 * by);
        assert!((slope(by_turn) - at.slopes[1][0][axis]).abs() < 1e-6, "turn {axis}");
        assert!((slope(by_rate) - at.slopes[1][1][axis]).abs() < 1e-6, "rate {axis}");
    }
    let by_time = [by, -by].map(|by| leg(&zero, &zero, 5.0 + by).cost);
    assert!(((by_time[0] - by_time[1]) / (2.0 * by) - at.by_duration).abs() < 1e-4);
}

/// The sum of minimum times and holds in the best order: case s01, and case s04 with all 120
/// orders.
#[test]
fn least_time_visits_stops_in_the_best_order() {
    let timed = |inertia: Matrix3, limits: [f64; 3], quaternions: &[[f64; 4]]| {
        let limits = Limits { size: Some(limits.to_vec()), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
        let craft = Problem::minimum_time(body(inertia), rest(), rest())
            .with_actuation(Actuation::torques(torques))
            .with_steps(100);
        let stops = quaternions.iter().enumerate().map(|(index, at)| stop(&format!("{index}"), to(*at)));
        Sequence { craft, stops: stops.collect(), order: Ordering::Free }
    };
    let xte = Matrix3::from_diagonal(&Vector3::new(5621.0, 4547.0, 2364.0));
    let mut two = timed(
        xte,
        [50.0; 3],
        &[
            [0.25881904510252074, 0.9659258262890683, 0.0, 0.0],
            [0.5735764363510462, 0.5792279653395691, -0.3475367792037415, 0.46338237227165535],
            [0.7933533402912352, 0.1577669331697267, 0.5258897772324224, -0.2629448886162112],
        ],
    );
    two.order = Ordering::FreeBeforeLast;
    (two.stops[0].visit.hold, two.stops[1].visit.hold) = (20.0, 35.0);
    let found = planned(&two);
    assert_eq!(found.legs.iter().map(|leg| leg.stop).collect::<Vec<_>>(), [1, 0, 2]);
    let order = found.order.as_ref().unwrap();
    // One leg has a singular arc, so its bang-bang arcs take 1.6e-5 s longer than the other
    // program's plan.
    assert!((order.end - 118.51363402375748).abs() < 5e-5, "{}", order.end);
    let five = timed(
        Matrix3::new(120.0, 4.0, -3.0, 4.0, 100.0, 2.0, -3.0, 2.0, 80.0),
        [3.0, 2.0, 2.5],
        &[
            [0.6755902076156602, 0.30099221235048296, 0.6019844247009659, -0.30099221235048296],
            [0.3420201433256688, -0.8202309647129254, 0.4101154823564627, 0.20505774117823136],
            [0.8660254037844387, 0.0, 0.14367394278317266, 0.4789131426105756],
            [0.1305261922200517, 0.5724109576008407, -0.5724109576008407, 0.5724109576008407],
            [0.5735764363510462, 0.13846196710008074, -0.6923098355004037, -0.4153859013002422],
        ],
    );
    let found = planned(&five);
    assert_eq!(found.legs.iter().map(|leg| leg.stop).collect::<Vec<_>>(), [2, 0, 3, 1, 4]);
    is_near(found.order.unwrap().end, 76.6975064971358, 1e-7);
}

/// Case s05: minimum effort without limits, for which the best split and order are known.
#[test]
fn effort_splits_its_time_by_the_fourth_roots_of_its_legs() {
    let quaternions = [
        [0.6755902076156602, 0.30099221235048296, 0.6019844247009659, -0.30099221235048296],
        [0.3420201433256688, -0.8202309647129254, 0.4101154823564627, 0.20505774117823136],
        [0.8660254037844387, 0.0, 0.14367394278317266, 0.4789131426105756],
        [0.1305261922200517, 0.5724109576008407, -0.5724109576008407, 0.5724109576008407],
        [0.5735764363510462, 0.13846196710008074, -0.6923098355004037, -0.4153859013002422],
    ];
    let inertia = Matrix3::new(1.2, 0.04, -0.03, 0.04, 1.0, 0.02, -0.03, 0.02, 0.8);
    let on = |steps: usize| Sequence {
        order: Ordering::Free,
        ..effort(body(inertia), 30.0, quaternions.iter().map(|at| stop("", to(*at))).collect(), steps)
    };
    is_near(cost(on), 0.47770595624872747, 1e-8);
    let found = planned(&on(150));
    assert_eq!(found.legs.iter().map(|leg| leg.stop).collect::<Vec<_>>(), [2, 0, 3, 1, 4]);
    let lasting: Vec<f64> = found.legs.iter().map(|leg| leg.problem.seconds()).collect();
    let known =
        [4.107988118103805, 6.423118880843569, 6.375850156125012, 6.242782712962539, 6.850260131965072];
    assert!(lasting.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-3), "{lasting:?}");
}

/// If holds begin at given times, the duration of each leg is given.
#[test]
fn holds_that_begin_at_given_times_divide_the_whole() {
    let at = |name: &str, begins: f64, quaternion: [f64; 4]| {
        let mut stop = stop(name, to(quaternion)).held(3.0);
        (stop.visit.window[0], stop.visit.pinned) = (begins, true);
        stop
    };
    let stops = vec![at("A", 4.0, [0.6, 0.8, 0.0, 0.0]), at("B", 12.0, [0.6, 0.0, 0.8, 0.0])];
    let found = planned(&effort(skew_body(), 15.0, stops, 60));
    let lasting: Vec<f64> = found.legs.iter().map(|leg| leg.problem.seconds()).collect();
    assert_eq!((lasting, found.end, found.late), (vec![4.0, 5.0], 15.0, 0.0));
}

/// An active window of a stop fixes its arrival; the legs before and after it divide their
/// remaining times by the fourth roots of their costs (s05).
#[test]
fn effort_keeps_windows() {
    let quaternions = [
        [0.8660254037844387, 0.0, 0.14367394278317266, 0.4789131426105756],
        [0.6755902076156602, 0.30099221235048296, 0.6019844247009659, -0.30099221235048296],
        [0.1305261922200517, 0.5724109576008407, -0.5724109576008407, 0.5724109576008407],
        [0.3420201433256688, -0.8202309647129254, 0.4101154823564627, 0.20505774117823136],
        [0.5735764363510462, 0.13846196710008074, -0.6923098355004037, -0.4153859013002422],
    ];
    let inertia = Matrix3::new(1.2, 0.04, -0.03, 0.04, 1.0, 0.02, -0.03, 0.02, 0.8);
    let on = |steps: usize, window: [f64; 2]| {
        let mut stops: Vec<Stop> = quaternions.iter().map(|at| stop("", to(*at))).collect();
        stops[1].visit.window = window;
        effort(body(inertia), 30.0, stops, steps)
    };
    // Without a window the legs have these fractions of 30 s, and cost 0.47770595624872747: c_i = k
    // p_i⁴.
    let parts =
        [4.107988118103805, 6.423118880843569, 6.375850156125012, 6.242782712962539, 6.850260131965072];
    let power = 0.47770595624872747 * 30.0_f64.powi(3) / 30.0_f64.powi(4);
    let shared = |legs: &[f64], total: f64| power * legs.iter().sum::<f64>().powi(4) / total.powi(3);
    for (window, arrival) in [([0.0, 8.0], 8.0), ([12.0, 20.0], 12.0), ([5.0, 25.0], parts[0] + parts[1])] {
        let known = shared(&parts[..2], arrival) + shared(&parts[2..], 30.0 - arrival);
        is_near(cost(|steps| on(steps, window)), known, 1e-8);
        let found = planned(&on(150, window));
        assert!((found.legs[2].begins - arrival).abs() < 1e-3 && found.late == 0.0);
    }
    // The window opens at 31 s, after the total duration of 30 s.
    let found = on(50, [31.0, 40.0]).plan(&Settings::discrete(), &mut Silent);
    assert!(matches!(found, Err(SequenceError::Windows { late, .. }) if late > 1.0 - 1e-12));
    let free = Sequence { order: Ordering::Free, ..on(50, [0.0, 8.0]) };
    assert!(matches!(free.check(), Err(SequenceError::Unsupported(_))));
}

/// The leg to a single stop has the total duration minus the hold.
#[test]
fn one_leg_lasts_as_long_as_its_hold_leaves() {
    let stops = vec![stop("A", to([0.6, 0.8, 0.0, 0.0])).held(5.0)];
    let found = planned(&effort(skew_body(), 30.0, stops, 40));
    assert_eq!((found.legs[0].problem.seconds(), found.end), (25.0, 30.0));
}

/// No leg uses the end of the craft; the [end] of a spec becomes the last stop of its sequence.
#[test]
fn legs_end_at_their_own_stops() {
    let place = to([0.6, 0.8, 0.0, 0.0]);
    let Place::Attitude(attitude) = place else { panic!("an attitude") };
    let target = pointing([0.2, 0.1, 1.0]);
    let Place::Aim(aim) = target.clone() else { panic!("a target") };
    let mut sequence = effort(skew_body(), 30.0, vec![stop("A", place), stop("end", target)], 40);
    sequence.craft = sequence.craft.with_aim_at_end(aim);
    let found = planned(&sequence);
    let last = found.legs[0].plan.solution.trajectory.quaternion.last().unwrap();
    assert!(lie::minus(&lie::rotation_from_quaternion(last), &attitude).norm() < 1e-9);
}

/// Returns a body with four wheels, two of which spin at the start.
fn on_wheels(steps: usize) -> Problem {
    let directions = [[0.8, 0.0, 0.6], [0.0, 0.8, 0.6], [-0.8, 0.0, 0.6], [0.0, -0.8, 0.6]];
    let axes = directions.map(Vector3::from).to_vec();
    let set = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
    let set = set.with_limits(Limits { size: Some(vec![0.4; 4]), ..Limits::default() }).unwrap();
    let wheels = Wheels { momentum: vec![0.3, -0.1, 0.0, 0.0], momentum_limit: vec![2.0; 4] };
    let mut craft = Problem::minimum_time(skew_body(), rest(), rest()).with_steps(steps);
    craft.actuation = Actuation { torque: set, wheels: Some(wheels), ..craft.actuation };
    craft
}

/// Without an external torque `R(JΩ + Σ a_i h_i)` is a constant vector over all legs and rests: the
/// wheels pass their momentum from leg to leg.
#[test]
fn wheels_carry_their_momentum_from_leg_to_leg() {
    let craft = on_wheels(50);
    let stops = vec![
        stop("A", to([0.6, 0.8, 0.0, 0.0])).held(5.0),
        stop("B", to([0.6, 0.0, 0.8, 0.0])),
        stop("C", to([0.5, 0.5, 0.5, 0.5])).held(2.0),
    ];
    let sequence = Sequence { craft: craft.clone(), stops, order: Ordering::Given };
    let path = sequence.plan(&Settings::default(), &mut Silent).unwrap().joined().path;
    let stored = craft.actuation.stored_momentum();
    for node in 0..path.time.len() {
        let momenta = &path.wheel_momentum[4 * node..4 * node + 4];
        let body =
            craft.body.inertia.j() * path.angular_velocity[node] + craft.actuation.torque.output(momenta);
        let whole = lie::rotation_from_quaternion(&path.quaternion[node]) * body;
        // In a landed plan the discrete motion misses the stop by the discretisation error.
        assert!((whole - stored).norm() < 2e-3 * stored.norm(), "{node}: {whole} {stored}");
    }
}

/// A body on four wheels that turns with least effort and stores momentum.
fn of_effort_on_wheels(steps: usize) -> Problem {
    let craft = on_wheels(steps);
    Problem { objective: Objective::default(), ..craft }.with_duration(8.0)
}

/// The slopes of a leg on wheels are those of its cost: by differences, at both ends. The wheels take
/// up what the body leaves of the momentum of the whole.
#[test]
fn slopes_of_a_leg_on_wheels_are_those_of_its_cost() {
    let craft = of_effort_on_wheels(200);
    let whole = carried::momentum(&craft);
    let leg = |turns: [&Vector3; 2], rates: [&Vector3; 2], seconds: f64| {
        let start = lie::exp(&Vector3::new(-0.2, 0.3, 0.1));
        let end = lie::exp(&Vector3::new(0.4, -0.8, 1.2));
        let mut problem = Problem {
            start: State::attitude(start * lie::exp(turns[0]), Vector3::new(-0.05, 0.1, 0.08) + rates[0]),
            end: State::attitude(end * lie::exp(turns[1]), Vector3::new(0.1, 0.05, -0.1) + rates[1]),
            ..craft.clone().with_duration(seconds)
        };
        carried::carry(&mut problem, &whole, None);
        Leg::of(problem, &Settings::default(), None, &mut Silent).unwrap().unwrap()
    };
    let (zero, by) = (Vector3::zeros(), 1e-3);
    let at = leg([&zero; 2], [&zero; 2], 8.0);
    let largest = at.slopes.iter().flatten().map(|slope| slope.amax()).fold(0.0, f64::max);
    for (end, axis) in [0, 1].into_iter().flat_map(|end| (0..3).map(move |axis| (end, axis))) {
        let moved = |by: f64| {
            let by = Vector3::ith(axis, by);
            if end == 0 { [by, zero] } else { [zero, by] }
        };
        let slope = |[up, down]: [f64; 2]| (up - down) / (2.0 * by);
        let by_turn = slope([by, -by].map(|by| leg(moved(by).each_ref(), [&zero; 2], 8.0).cost));
        let by_rate = slope([by, -by].map(|by| leg([&zero; 2], moved(by).each_ref(), 8.0).cost));
        let [turn, rate] = at.slopes[end].map(|slope| slope[axis]);
        assert!((by_turn - turn).abs() < 1e-3 * largest, "turn {end} {axis}: {by_turn} {turn}");
        assert!((by_rate - rate).abs() < 1e-3 * largest, "rate {end} {axis}: {by_rate} {rate}");
    }
    let by_time = [by, -by].map(|by| leg([&zero; 2], [&zero; 2], 8.0 + by).cost);
    let by_time = (by_time[0] - by_time[1]) / (2.0 * by);
    assert!((by_time / at.by_duration - 1.0).abs() < 1e-2, "{by_time} {}", at.by_duration);
}

/// An attitude that the best slew on wheels goes through anyway costs nothing: the passage is made at
/// the rate and the time of that slew.
#[test]
fn wheels_pass_an_attitude_on_their_way() {
    let craft = Problem { end: given([0.5, 0.5, 0.5, 0.5]), ..of_effort_on_wheels(200) };
    let alone = Leg::of(craft.clone(), &Settings::default(), None, &mut Silent).unwrap().unwrap();
    let middle = Place::Attitude(lie::rotation_from_quaternion(&alone.solution.trajectory.quaternion[90]));
    let stops =
        vec![stop("middle", middle).passed_at_most_at(f64::INFINITY), stop("end", to([0.5, 0.5, 0.5, 0.5]))];
    let found = planned(&Sequence { craft: craft.with_steps(100), stops, order: Ordering::Given });
    assert_eq!(found.status(), Status::Solved);
    is_near(found.cost, alone.cost, 1e-3);
    is_near(found.legs[1].begins, 8.0 * 90.0 / 200.0, 1e-2);
}

/// The joined motion contains the nodes of all legs in the order of time, with a continuous
/// attitude and with rests between the legs.
#[test]
fn legs_and_rests_are_joined() {
    let stops = vec![
        stop("A", to([0.6, 0.8, 0.0, 0.0])).held(3.0),
        stop("B", to([0.6, 0.0, 0.8, 0.0])),
        stop("C", to([-0.6, 0.8, 0.0, 0.0])).held(2.0),
    ];
    let found = planned(&effort(skew_body(), 30.0, stops, 40));
    let Joined { path, parts } = found.joined();
    assert!(path.time.windows(2).all(|pair| pair[1] > pair[0]));
    assert_eq!((path.time[0], *path.time.last().unwrap()), (0.0, 30.0));
    assert_eq!(path.torque.len() + 1, path.time.len());
    let rests: Vec<bool> = parts.iter().map(|part| part.rests).collect();
    assert_eq!(rests, [false, true, false, false, true]);
    assert!(parts.windows(2).all(|pair| pair[0].nodes[1] == pair[1].nodes[0]));
    let turn = |pair: &[[f64; 4]]| pair[0].iter().zip(&pair[1]).map(|(a, b)| a * b).sum::<f64>();
    for part in parts.iter().filter(|part| part.rests) {
        let [from, until] = part.nodes;
        // A leg ends at its stop within the tolerance, and the next leg begins exactly at the stop.
        assert!(turn(&path.quaternion[from..=until]) > 1.0 - 1e-12);
        assert_eq!(path.torque[from], Vector3::zeros());
    }
    assert!(path.quaternion.windows(2).all(|pair| turn(pair) > 0.9));
}

/// A window that closes before the lower bound of the leg is reported before any leg is planned.
#[test]
fn windows_that_no_plan_can_keep_are_proved() {
    let mut craft = Problem::minimum_time(skew_body(), rest(), rest()).with_steps(50);
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    craft.actuation.torque = craft.actuation.torque.with_limits(limits).unwrap();
    let within = |name: &str, until: f64, place: Place| {
        let mut stop = stop(name, place).held(1.0);
        stop.visit.window = [0.0, until];
        stop
    };
    let [a, b] = [[0.6, 0.8, 0.0, 0.0], [0.6, -0.8, 0.0, 0.0]].map(to);
    let plan = |stops: Vec<Stop>, order: Ordering| {
        Sequence { craft: craft.clone(), stops, order }.plan(&Settings::discrete(), &mut Silent)
    };
    let missed = |found: Result<SequencePlan, SequenceError>| match found {
        Err(SequenceError::Windows { stops, late }) if late > 0.0 => Some(stops),
        Err(error) => panic!("{error}"),
        Ok(_) => None,
    };
    // A leg takes at least 3.3 s, and a leg from A to B at least 4.5 s.
    for order in [Ordering::Given, Ordering::Free] {
        assert_eq!(missed(plan(vec![within("A", 3.0, a.clone())], order)), Some("`A`".into()));
        let both = vec![within("A", 7.0, a.clone()), within("B", 7.0, b.clone())];
        let named = if order == Ordering::Given { "`B`" } else { "`A` or that of `B`" };
        assert_eq!(missed(plan(both, order)), Some(named.into()));
        let wide = vec![within("A", 12.0, a.clone()), within("B", 12.0, b.clone())];
        let found = plan(wide, order).unwrap();
        assert_eq!((found.late, found.legs.len()), (0.0, 2));
    }
    let aims = vec![within("A", 1.0, pointing([1.0, 0.0, 0.0]))];
    assert_eq!(missed(plan(aims, Ordering::Given)), Some("`A`".into()));
    // For a body that moves at the start only the rate limit gives a bound: a turn by 106° takes at
    // least 6.2 s at 0.3 rad/s.
    let mut moving = craft.clone();
    moving.start.angular_velocity = Vector3::new(0.0, 0.0, 0.01);
    moving.constraints.push(Constraint { name: "rate".into(), rule: Rule::RateNorm(0.3) });
    let sequence = |until: f64| Sequence {
        craft: moving.clone(),
        stops: vec![within("A", until, a.clone())],
        order: Ordering::Given,
    };
    assert_eq!(missed(sequence(7.0).plan(&Settings::discrete(), &mut Silent)), Some("`A`".into()));
    assert!(windows::missed(&sequence(7.2)).is_none());
}

#[test]
fn numbers_of_a_joint_stay_within_their_bounds() {
    let joint = Joint::Passing { at: rest(), fastest: 0.5 };
    let mut free = vec![3.0, 0.0, 4.0];
    joint.hold(&mut free);
    assert!((free[0] - 0.3).abs() + (free[2] - 0.4).abs() < 1e-15, "{free:?}");
    assert_eq!(joint.numbers(&joint.state(&free)), free);
}

#[test]
fn a_sequence_without_stops_is_no_plan_to_make() {
    let craft = Problem::minimum_time(skew_body(), rest(), rest());
    for order in [Ordering::Given, Ordering::Free, Ordering::FreeBeforeLast] {
        let sequence = Sequence { craft: craft.clone(), stops: Vec::new(), order };
        let found = planned(&sequence);
        assert!(found.legs.is_empty() && found.end == 0.0 && found.cost == 0.0);
    }
}

#[test]
fn what_a_sequence_cannot_have_is_told() {
    let stops = vec![stop("A", to([0.6, 0.8, 0.0, 0.0])).held(40.0)];
    let found = effort(skew_body(), 30.0, stops, 50).plan(&Settings::discrete(), &mut Silent);
    assert!(matches!(found, Err(SequenceError::NoTime { holds: 40.0, total: 30.0 })));
    // At minimum effort a moving target requires a given time of arrival.
    let moving = Direction::along(0.0, 60.0, 10.0, 6, |t| Vector3::new(1.0, 0.01 * t, 0.0)).unwrap();
    let stops = vec![stop("A", Place::Aim(Aim::new(Vector3::z(), moving.clone())))];
    let found = effort(skew_body(), 30.0, stops, 50).plan(&Settings::discrete(), &mut Silent);
    assert!(matches!(found, Err(SequenceError::Unsupported(_))));
    // The positions of the target are known for one minute only.
    let stops = vec![stop("A", Place::Aim(Aim::new(Vector3::z(), moving))).held(70.0)];
    let mut craft = Problem::minimum_time(skew_body(), rest(), rest()).with_steps(50);
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    craft.actuation.torque = craft.actuation.torque.with_limits(limits).unwrap();
    let found = Sequence { craft, stops, order: Ordering::Given }.plan(&Settings::discrete(), &mut Silent);
    assert!(matches!(found, Err(SequenceError::Beyond { known: 60.0, .. })));
}

/// A stop that repeats the place before it adds nothing: neither to the cost of given attitudes and
/// free rolls, nor to the time of the best order, which visits both one after the other.
#[test]
fn a_stop_that_repeats_the_place_before_it_costs_nothing() {
    let (there, aside) = (to([0.9, 0.1, -0.4, 0.2]), pointing([0.3, -0.8, 0.5]));
    let home = to([1.0, 0.0, 0.0, 0.0]);
    let legs = |places: &[&Place]| {
        let stops = places.iter().enumerate().map(|(index, place)| {
            stop(&index.to_string(), (*place).clone()).held(if index == 1 { 2.0 } else { 0.0 })
        });
        effort(skew_body(), 30.0, stops.collect(), 40)
    };
    let once = planned(&legs(&[&aside, &there, &home]));
    let twice = planned(&legs(&[&aside, &there, &there, &home]));
    is_near(twice.cost, once.cost, 1e-9);
    let moved = Sequence { stops: legs(&[&there, &aside, &home]).stops, ..legs(&[]) };
    let again = legs(&[&there, &aside, &aside, &home]);
    is_near(planned(&again).cost, planned(&moved).cost, 1e-9);
    let quick = |stops: Vec<Stop>, order| Sequence { craft: limited(), stops, order };
    let given = vec![stop("A", there.clone()), stop("B", home.clone()), stop("C", home.clone())];
    let mixed = vec![given[1].clone(), given[0].clone(), given[2].clone()];
    let [given, best] =
        [quick(given, Ordering::Given), quick(mixed, Ordering::Free)].map(|all| planned(&all).end);
    assert!(best <= given * (1.0 + 1e-9), "{best} {given}");
}

/// The time limit is of the whole, and a stopped plan says that the limit stopped it.
#[test]
fn a_time_limit_is_of_the_whole_sequence() {
    let stops = (0..40).map(|index| stop(&index.to_string(), to([1.0, 0.1 * f64::from(index), 0.5, -0.2])));
    let sequence = Sequence { craft: limited(), stops: stops.collect(), order: Ordering::Free };
    let limit = std::time::Duration::from_millis(50);
    let settings = Settings { time_limit: Some(limit), ..Settings::discrete() };
    let began = std::time::Instant::now();
    let found = sequence.plan(&settings, &mut Silent);
    assert!(matches!(found, Err(SequenceError::Stopped(Status::LimitReached))), "{found:?}");
    assert!(began.elapsed().as_secs() < 10);
}

/// Returns a minimum-time craft with a limit on the torque about each axis.
fn limited() -> Problem {
    let limits = crate::Limits { size: Some(vec![0.3; 3]), ..crate::Limits::default() };
    let torques = crate::ActuatorSet::three_axes(crate::AxisFrame::Body).with_limits(limits).unwrap();
    let actuation = crate::Actuation::torques(torques);
    Problem::minimum_time(skew_body(), rest(), rest()).with_actuation(actuation).with_steps(40)
}
