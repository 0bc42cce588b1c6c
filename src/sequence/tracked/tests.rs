//! Tests of holds on moving targets, against closed forms and the witnesses.

use super::super::{Ordering, Place, Sequence, SequencePlan, Stop};
use super::{moves, off_target, shared};
use crate::maneuver::aim::Aim;
use crate::maneuver::constraint::{Constraint, Direction, During, Pointing, Rule, Side};
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::Settings;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
use crate::plan::Status;
use crate::{Matrix3, Vector3, lie};

/// Angular rate of a target that passes overhead [rad/s].
const RATE: f64 = 0.02;

fn craft() -> Problem {
    let inertia = Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1);
    let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
    let rest = State::at_rest(Matrix3::identity());
    let mut craft = Problem::minimum_time(body, rest, rest).with_steps(60);
    let limits = Limits { size: Some(vec![0.3; 3]), ..Limits::default() };
    craft.actuation.torque = craft.actuation.torque.with_limits(limits).unwrap();
    craft
}

/// Returns the craft with four wheels, two of which spin.
fn on_wheels() -> Problem {
    let directions = [[0.8, 0.0, 0.6], [0.0, 0.8, 0.6], [-0.8, 0.0, 0.6], [0.0, -0.8, 0.6]];
    let set = ActuatorSet::new(directions.map(Vector3::from).to_vec(), AxisFrame::Body).unwrap();
    let set = set.with_limits(Limits { size: Some(vec![0.4; 4]), ..Limits::default() }).unwrap();
    let wheels = Wheels { momentum: vec![0.3, -0.1, 0.0, 0.0], momentum_limit: vec![2.0; 4] };
    let craft = craft();
    Problem { actuation: Actuation { torque: set, wheels: Some(wheels), ..craft.actuation }, ..craft }
}

/// Returns a direction that rotates about a perpendicular axis for 300 s.
fn target() -> Direction {
    let (vector, axis) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.0, RATE, 0.0));
    Direction::turning(vector, axis, 300.0).unwrap()
}

fn at_target(hold: f64) -> Stop {
    Stop::at("target", Place::Aim(Aim::new(Vector3::z(), target()))).held(hold)
}

fn given(name: &str, quaternion: [f64; 4]) -> Stop {
    let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(&quaternion));
    Stop::at(name, Place::Attitude(attitude))
}

fn planned(craft: &Problem, stops: Vec<Stop>) -> SequencePlan {
    let sequence = Sequence { craft: craft.clone(), stops, order: Ordering::Given };
    sequence.plan(&Settings::default(), &mut Silent).unwrap()
}

/// If the target rotates about an axis at a constant rate and the roll is kept, the body turns
/// about this axis at this rate, and the torque is Ω × JΩ.
#[test]
fn a_body_follows_a_target() {
    for craft in [craft(), on_wheels()] {
        let stops = vec![at_target(40.0), given("rest", [0.6, 0.0, 0.8, 0.0])];
        let plan = planned(&craft, stops);
        assert_eq!(plan.status(), Status::Solved);
        let leg = &plan.legs[0];
        let hold = leg.hold.as_ref().expect("the target moves");
        let path = &hold.plan.solution.trajectory;
        assert!((hold.problem.seconds() - 40.0).abs() < 1e-9);
        assert!(off_target(&at_target(40.0), leg.holds[0], path) < 1e-10);
        for (rate, quaternion) in path.angular_velocity.iter().zip(&path.quaternion) {
            let turning = lie::rotation_from_quaternion(quaternion) * rate;
            assert!((turning - Vector3::new(0.0, RATE, 0.0)).norm() < 1e-5, "{turning}");
        }
        let first = path.angular_velocity[30];
        let momentum = craft.body.inertia.j() * first + craft.actuation.stored_momentum();
        if craft.actuation.wheels.is_none() {
            assert!((path.torque[30] - first.cross(&momentum)).norm() < 1e-3 * first.norm());
        }
        // The next leg begins in the state in which the hold ends.
        let next = &plan.legs[1].problem.start;
        assert_eq!(*next, hold.end());
        assert!(next.angular_velocity.norm() > 0.9 * RATE);
        let joined = plan.joined();
        assert_eq!(joined.parts.iter().map(|part| part.rests).collect::<Vec<_>>(), [false, true, false]);
        assert!(joined.path.time.windows(2).all(|pair| pair[1] > pair[0]));
    }
}

/// A second axis determines the roll, and the body turns with both directions.
#[test]
fn a_roll_towards_a_direction_is_kept() {
    let aim =
        Aim::new(Vector3::z(), target()).with_roll_towards(Vector3::x(), Direction::Fixed(Vector3::y()), 0.0);
    let stop = Stop::at("target", Place::Aim(aim)).held(30.0);
    let plan = planned(&craft(), vec![stop.clone()]);
    assert_eq!(plan.status(), Status::Solved);
    let path = &plan.legs[0].hold.as_ref().unwrap().plan.solution.trajectory;
    assert!(off_target(&stop, plan.legs[0].holds[0], path) < 1e-10);
    let x = path.quaternion.iter().map(|q| lie::rotation_from_quaternion(q) * Vector3::x());
    assert!(x.into_iter().all(|x| (x - Vector3::y()).norm() < 1e-10));
}

/// Cones use the time of the sequence. A cone that is active only late bends the second leg, and a
/// cone that moves over the boresight during a rest makes the hold fail.
#[test]
fn cones_act_in_the_time_of_the_sequence() {
    let cone = |at: Vector3, from: f64| {
        let direction = Direction::Fixed(at.normalize());
        let mut cone = Pointing::new(Side::KeepOut, vec![Vector3::z()], vec![direction], 20_f64.to_radians());
        cone.during = During::intervals([[from, 1000.0]]);
        Constraint { name: "late".into(), rule: Rule::Pointing(cone) }
    };
    let at = |angle: f64| [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0];
    let stops = || vec![given("A", at(1.6)).held(20.0), given("B", at(0.0))];
    let free = planned(&craft(), stops());
    let between = lie::exp(&Vector3::new(0.0, 0.8, 0.0)) * Vector3::z();
    let late = planned(&craft().with_constraint(cone(between, free.legs[0].holds[1] - 1.0)), stops());
    assert_eq!(late.status(), Status::Solved);
    assert!((late.legs[0].plan.solution.cost / free.legs[0].plan.solution.cost - 1.0).abs() < 1e-3);
    let nearest = |plan: &SequencePlan| {
        let path = &plan.legs[1].plan.solution.trajectory;
        let boresights = path.quaternion.iter().map(|q| lie::rotation_from_quaternion(q) * Vector3::z());
        boresights.map(|b| b.angle(&between).to_degrees()).fold(f64::INFINITY, f64::min)
    };
    // Without the cone the boresight leaves the plane of the two pointings, but still enters the
    // cone.
    assert!(nearest(&free) < 18.0 && nearest(&late) > 20.0 - 1e-6, "{} {}", nearest(&free), nearest(&late));
    assert!(late.legs[1].plan.solution.cost > free.legs[1].plan.solution.cost);
    // This cone covers the boresight at rest, from the middle of the rest on.
    let over = lie::exp(&Vector3::new(0.0, 1.6, 0.0)) * Vector3::z();
    let caught = planned(&craft().with_constraint(cone(over, free.legs[0].holds[0] + 10.0)), stops());
    assert_eq!((caught.status(), caught.legs.len()), (Status::VerificationFailed, 1));
}

/// The best order visits the target that moves away first, and then the one at rest.
#[test]
fn a_target_that_moves_away_comes_first() {
    let away = Stop { name: "away".into(), ..at_target(1.0) };
    let still = given("still", [0.9, 0.0, -0.43588989435406733, 0.0]).held(60.0);
    let order = |stops: Vec<Stop>| {
        let sequence = Sequence { craft: craft(), stops, order: Ordering::Free };
        let plan = sequence.plan(&Settings::discrete(), &mut Silent).unwrap();
        let names: Vec<String> = plan.legs.iter().map(|leg| sequence.stops[leg.stop].name.clone()).collect();
        (names, plan.end)
    };
    let (first, end) = order(vec![still.clone(), away.clone()]);
    let (second, same) = order(vec![away, still]);
    assert_eq!((first, end), (second.clone(), same));
    assert_eq!(second, ["away", "still"]);
}

/// Least-squares inputs for a torque, compared with the closed form for one-sided pairs, and within
/// limits that the pseudo-inverse violates.
#[test]
fn inputs_share_a_torque() {
    let axes = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let set = |size: f64, one_sided: bool, axes: &[[f64; 3]]| {
        let limits = Limits { size: Some(vec![size; axes.len()]), one_sided, ..Limits::default() };
        let axes = axes.iter().map(|axis| Vector3::from(*axis)).collect();
        ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap()
    };
    let found = shared(&set(1.0, true, &axes), &Vector3::new(0.3, -0.5, 0.0));
    let wanted = [0.3, 0.0, 0.0, 0.5, 0.0, 0.0];
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
    // Two inputs along x share 1.5. The pseudo-inverse gives 0.6 and 0.9, where the second exceeds
    // its limit.
    let four = [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let torque = Vector3::new(2.6, 0.1, -0.2);
    let narrow = set(0.55, false, &four);
    let found = shared(&narrow, &torque);
    assert!((narrow.output(&found) - torque).norm() < 1e-14, "{found:?}");
    assert!((found[1] - 0.55).abs() < 1e-15 && (found[0] - 0.475).abs() < 1e-14, "{found:?}");
    // For a torque that no inputs produce, the iteration ends with inputs within their limits.
    let found = shared(&narrow, &Vector3::new(1e3, 0.0, 0.0));
    assert!(found.iter().all(|input| input.abs() <= 0.55), "{found:?}");
}

#[test]
fn stops_that_move_are_those_on_targets_that_do() {
    assert!(moves(&at_target(1.0)));
    assert!(!moves(&given("A", [1.0, 0.0, 0.0, 0.0])));
}
