//! Tests of the motion over a whole sequence against the plans of its legs and holds.

use super::super::{Ordering, Place, Sequence, SequencePlan, Stop};
use super::WholeMotion;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::Settings;
use crate::mechanics::actuators::Limits;
use crate::mechanics::body::{Body, Inertia};
use crate::optimize::search::Silent;
use crate::{Matrix3, Vector3, lie};

/// Returns a sequence of two stops at rest, with a hold at the first one and limits on the torques,
/// and its plan.
fn planned() -> (Sequence, SequencePlan) {
    let inertia = Matrix3::from_diagonal(&Vector3::new(2.2, 1.6, 1.1));
    let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
    let rest = State::at_rest(Matrix3::identity());
    let mut craft = Problem::minimum_time(body, rest, rest).with_steps(40);
    let limits = Limits { size: Some(vec![0.3; 3]), ..Limits::default() };
    craft.actuation.torque = craft.actuation.torque.with_limits(limits).unwrap();
    let at = |turn: Vector3| Place::Attitude(lie::exp(&turn));
    let mut first = Stop::at("A", at(Vector3::new(0.8, 0.0, 0.3))).held(6.0);
    first.visit.settling = 1.5;
    let stops = vec![first, Stop::at("B", at(Vector3::new(0.2, 0.9, -0.4)))];
    let sequence = Sequence { craft, stops, order: Ordering::Given };
    let plan = sequence.plan(&Settings::default(), &mut Silent).unwrap();
    (sequence, plan)
}

/// The whole motion has increasing times, a row of inputs for each step, and nodes at the start and
/// the end of the hold, at which the body has the attitude that the stop requires.
#[test]
fn legs_and_holds_are_one_motion() {
    let (sequence, plan) = planned();
    let whole = WholeMotion::of_plan(&sequence, &plan).unwrap();
    let path = &whole.path;
    assert!(path.time.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(path.torque.len(), path.time.len() - 1);
    assert!((path.time.last().unwrap() - plan.end).abs() < 1e-12);
    let [begins, ends, last] = [0, 1, 2].map(|index| whole.instants[index]);
    assert_eq!([begins.ends, ends.ends, last.ends], [false, true, false]);
    assert!((path.time[begins.node] - plan.legs[0].holds[0]).abs() < 1e-12);
    assert!((path.time[ends.node] - path.time[begins.node] - 6.0).abs() < 1e-12);
    assert_eq!(whole.stops(), [begins.node, ends.node]);
    assert_eq!(last.node, path.time.len() - 1);
    for (instant, stop) in [(begins, 0), (ends, 0), (last, 1)] {
        let Place::Attitude(wanted) = &sequence.stops[stop].place else { unreachable!() };
        let found = lie::rotation_from_quaternion(&path.quaternion[instant.node]);
        assert!(lie::minus(&found, wanted).norm() < 1e-6);
    }
    // The steps of the rest are not longer than the steps of the leg.
    let longest = path.time.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(longest <= whole.shortest / 10.0);
}
