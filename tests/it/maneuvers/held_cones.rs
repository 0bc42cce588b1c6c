//! Boresights that are held on a cone, and cones that act at times, against closed forms.

use super::support::extrapolated;
use slewkit::maneuver::During;
use slewkit::maneuver::constraint::angle_between;
use slewkit::{
    Body, Constraint, Direction, Inertia, Matrix3, Plan, Pointing, Problem, Rule, Settings, Side, Silent, State,
    Status, Vector3, lie, plan,
};

/// About z, the axis of the largest moment, by 150° in 10 s from rest to rest: other ways are cheaper.
fn slew() -> Problem {
    let inertia = Inertia::new(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.9))).unwrap();
    let end = lie::exp(&(Vector3::z() * ANGLE));
    let [start, end] = [Matrix3::identity(), end].map(State::at_rest);
    Problem::attitude(Body { inertia, mass: None }, start, end, 10.0)
}

const ANGLE: f64 = 150.0 * std::f64::consts::PI / 180.0;

/// `½∫u²` of a turn about a principal axis from rest to rest.
fn about_one_axis() -> f64 {
    6.0 * (2.9 * ANGLE).powi(2) / 10f64.powi(3)
}

fn cone(side: Side, boresight: Vector3, direction: Vector3, half_angle: f64, during: During) -> Constraint {
    let (boresights, directions) = (vec![boresight], vec![Direction::Fixed(direction)]);
    let rule = Rule::Pointing(Pointing { side, boresights, directions, half_angle, margin: 0.0, during });
    Constraint { name: format!("cone of {boresight}"), rule }
}

/// A boresight held on the cone about z on which it begins.
fn held(boresight: Vector3, during: During) -> Constraint {
    let half_angle = angle_between(&boresight, &Vector3::z());
    cone(Side::On { within: 2e-3 }, boresight, Vector3::z(), half_angle, during)
}

fn solved(problem: &Problem) -> Plan {
    let found = plan(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved, "{:?} {:?}", found.verification, found.solution.shortfall);
    found
}
