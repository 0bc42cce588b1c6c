//! Inputs of a plane for maneuvers that stay in it: closed forms, and the refusal of maneuvers that
//! leave the plane.

use super::fuel_of_forces::{each, flight, near, pushes};
use super::minimum_time::solved;
use slewkit::maneuver::{Duration, Objective, Problem};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::{Body, Inertia, Matrix3, State, Vector3, lie};

/// Returns four thrusters along x, two on either side of the mass center, at the distance `arm`
/// \[m\].
fn four(arm: f64, directions: [f64; 4]) -> Actuation {
    let positions = [-arm, -arm, arm, arm].map(|y| Vector3::new(0.0, y, 0.0));
    let limits = Limits { size: Some(vec![1.25; 4]), one_sided: true, ..Limits::default() };
    Actuation::of_thrusters(
        positions.to_vec(),
        directions.map(|x| Vector3::new(x, 0.0, 0.0)).to_vec(),
        limits,
    )
    .unwrap()
}

fn by_four(turn: [f64; 3], shift: [f64; 3]) -> Problem {
    let both_ways = four(0.5, [1.0, -1.0, 1.0, -1.0]);
    flight(turn, shift, each(1.0), AxisFrame::Body).with_actuation(both_ways)
}

/// Returns a turn in 6 s, or in least time, by one torque of at most 0.5 N·m about z.
fn about_z(degrees: f64) -> Problem {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1)).unwrap(), mass: None };
    let axis = ActuatorSet::new(vec![Vector3::z()], AxisFrame::Body).unwrap();
    let limits = Limits { size: Some(vec![0.5]), ..Limits::default() };
    let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, degrees.to_radians())));
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 6.0)
        .with_actuation(Actuation::torques(axis.with_limits(limits).unwrap()))
        .with_steps(50)
}

#[test]
fn a_shift_by_thrusters_of_a_plane_costs_what_one_force_does() {
    near(solved(&by_four([0.0; 3], [0.9, 0.0, 0.0])).solution.cost, pushes(0.9, 3.0, 2.5), 1e-8);
}

/// The shift is normal to all thrusters, so the body must turn for it, and turn back.
#[test]
fn a_shift_across_all_thrusters_is_made_by_turning() {
    let problem = by_four([0.0; 3], [0.0, 0.3, 0.0]).with_duration(6.0);
    let found = solved(&problem);
    assert!(found.solution.cost > pushes(0.3, 3.0, 2.5), "{}", found.solution.cost);
    let trajectory = &found.solution.trajectory;
    let turned = trajectory.quaternion.iter().map(|q| 2.0 * q[3].abs().asin()).fold(0.0, f64::max);
    assert!(turned > 0.2, "{turned}");
    // Nothing leaves the plane, to the last bits.
    assert!(trajectory.quaternion.iter().all(|q| q[1].abs() + q[2].abs() < 1e-14));
    assert!(trajectory.position.iter().all(|x| x.z.abs() < 1e-14));
}

/// `T = 2√(θJ/u)`, on equal steps to second order; and fuel by the same closed form of a double
/// integrator.
#[test]
fn a_turn_about_the_only_axis_takes_what_a_double_integrator_does() {
    let least = 2.0 * (1.2 * 1.1_f64 / 0.5).sqrt();
    let fastest =
        about_z(1.2_f64.to_degrees()).with_objective(Objective::Time).with_duration(Duration::SOUGHT);
    near(solved(&fastest).solution.cost, least, 5e-4);
    // u tb (T − tb)/J = θ, both burns: 2 u tb.
    let burn = 3.0 - (9.0 - 1.2 * 1.1 / 0.5_f64).sqrt();
    let fuel = about_z(1.2_f64.to_degrees()).with_objective(Objective::Fuel(Default::default()));
    near(solved(&fuel).solution.cost, 2.0 * 0.5 * burn, 2e-3);
}

#[test]
fn what_leaves_the_plane_is_refused() {
    let refused = |problem: Problem| {
        let error = problem.check().unwrap_err().to_string();
        assert!(error.contains("every direction"), "{error}");
    };
    by_four([0.0, 0.0, 0.5], [0.9, -0.2, 0.0]).check().unwrap();
    refused(by_four([0.2, 0.0, 0.0], [0.9, 0.0, 0.0]));
    refused(by_four([0.0; 3], [0.9, 0.0, 0.1]));
    let mut moving = by_four([0.0; 3], [0.9, 0.0, 0.0]);
    moving.start.velocity.z = 0.1;
    refused(moving);
    let mut tumbling = by_four([0.0; 3], [0.9, 0.0, 0.0]);
    tumbling.end.angular_velocity.x = 0.1;
    refused(tumbling);
    // All push the same way: none of them stops the body.
    refused(
        flight([0.0; 3], [0.9, 0.0, 0.0], each(1.0), AxisFrame::Body).with_actuation(four(0.5, [1.0; 4])),
    );
    let mut askew = about_z(60.0).with_objective(Objective::Time).with_duration(Duration::SOUGHT);
    askew.check().unwrap();
    askew.body.inertia = Inertia::new(Matrix3::new(2.0, 0.0, 0.2, 0.0, 1.6, 0.0, 0.2, 0.0, 1.1)).unwrap();
    refused(askew);
}
