//! Boresights that are held on a cone, and cones that act at times, against closed forms.

use super::support::extrapolated;
use slewkit::maneuver::During;
use slewkit::maneuver::constraint::angle_between;
use slewkit::{
    Body, Constraint, Direction, Inertia, Matrix3, Plan, Pointing, Problem, Rule, Settings, Side, Silent,
    State, Status, Vector3, lie, plan,
};

/// About z, the axis of the largest moment, by 150° in 10 s from rest to rest: other ways are
/// cheaper.
fn slew() -> Problem {
    let inertia = Inertia::new(Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.9))).unwrap();
    let end = lie::exp(&(Vector3::z() * ANGLE));
    let [start, end] = [Matrix3::identity(), end].map(State::at_rest);
    Problem::attitude(Body { inertia, mass: None }, start, end, 10.0)
}

const ANGLE: f64 = 150.0 * std::f64::consts::PI / 180.0;

/// Returns `½∫u²` of a turn about a principal axis from rest to rest.
fn about_one_axis() -> f64 {
    6.0 * (2.9 * ANGLE).powi(2) / 10f64.powi(3)
}

fn cone(side: Side, boresight: Vector3, direction: Vector3, half_angle: f64, during: During) -> Constraint {
    let (boresights, directions) = (vec![boresight], vec![Direction::Fixed(direction)]);
    let rule = Rule::Pointing(Pointing { side, boresights, directions, half_angle, margin: 0.0, during });
    Constraint { name: format!("cone of {boresight}"), rule }
}

/// Returns a boresight held on the cone about z on which it begins.
fn held(boresight: Vector3, during: During) -> Constraint {
    let half_angle = angle_between(&boresight, &Vector3::z());
    cone(Side::On { within: 2e-3 }, boresight, Vector3::z(), half_angle, during)
}

fn solved(problem: &Problem) -> Plan {
    let found = plan(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved, "{:?} {:?}", found.verification, found.solution.shortfall);
    found
}

/// Two boresights on cones about one axis leave a turn about it alone: `6 θ²J²/T³` in continuous
/// time.
#[test]
fn boresights_held_on_two_cones_turn_about_their_axis() {
    let held = |boresight: Vector3| held(boresight, During::default());
    let tilted = Vector3::new(0.6, 0.0, 0.8);
    let problem = slew().with_constraint(held(tilted)).with_constraint(held(Vector3::y()));
    let found = extrapolated(&problem, 50);
    assert!((found / about_one_axis() - 1.0).abs() < 1e-8, "{found} {}", about_one_axis());
    // Each of them alone leaves a cheaper way, and none at all the cheapest.
    let cost = |problem: &Problem| solved(&problem.clone().with_steps(100)).solution.cost;
    let [free, one] = [slew(), slew().with_constraint(held(tilted))].map(|problem| cost(&problem));
    assert!(free < 0.95 * one && one < 0.99 * found, "{free} {one} {found}");
}

/// The nodes are on the cone to round-off. Between them the distance of an arc from the cone falls
/// with the square of the step.
#[test]
fn a_boresight_is_held_at_the_nodes_and_strays_by_the_square_of_the_step() {
    let boresight = Vector3::new(0.6, 0.0, 0.8);
    let problem = slew().with_constraint(held(boresight, During::default()));
    let strays = |steps: usize| {
        let found = solved(&problem.clone().with_steps(steps));
        let angle = |quaternion: &[f64; 4]| {
            angle_between(&(lie::rotation_from_quaternion(quaternion) * boresight), &Vector3::z())
        };
        let wanted = angle_between(&boresight, &Vector3::z());
        for quaternion in &found.solution.trajectory.quaternion {
            assert!((angle(quaternion) - wanted).abs() < 1e-10);
        }
        let margin = &found.verification.unwrap().margins[0];
        assert!(margin.scaled < 2e-3);
        2e-3 - margin.scaled
    };
    let ratio = strays(50) / strays(100);
    assert!((ratio - 4.0).abs() < 0.2, "{ratio}");
}

/// A cone that never acts, or acts while it is not in the way, has no effect. A cone that always
/// acts has its full effect.
#[test]
fn a_cone_has_no_say_but_while_it_acts() {
    let boresight = Vector3::x();
    let free = solved(&slew().with_steps(100)).solution.cost;
    // The cone is on the way of the boresight, a little aside, in the middle of the maneuver.
    let middle =
        lie::rotation_from_quaternion(&solved(&slew().with_steps(100)).solution.trajectory.quaternion[50]);
    let aside = lie::exp(&(Vector3::z() * 0.05)) * (middle * boresight);
    let cost = |during: During| {
        let rule = cone(Side::KeepOut, boresight, aside, 0.3, during);
        let found = solved(&slew().with_steps(100).with_constraint(rule));
        let margins = found.verification.unwrap().margins;
        (found.solution.cost, margins.iter().map(|margin| margin.scaled).next())
    };
    let (always, _) = cost(During::default());
    assert!(always > 1.01 * free, "{always} {free}");
    let (never, margin) = cost(During::intervals([]));
    assert!((never / free - 1.0).abs() < 1e-9 && margin.is_none());
    // The cone has an effect before the boresight reaches it, and after the boresight has left it.
    let (aside, margin) = cost(During::intervals([[0.0, 2.0], [8.2, 10.0]]));
    assert!((aside / free - 1.0).abs() < 1e-9 && margin.is_some_and(|margin| margin > 0.0), "{aside} {free}");
    // A cone acts all the time that it is in the way, or a part of it: the cost is at least the
    // cost without it, and at most the cost of one that always acts.
    let (whole, _) = cost(During::intervals([[0.5, 9.5]]));
    assert!((whole / always - 1.0).abs() < 1e-7, "{whole} {always}");
    // The cone acts from a time between two nodes on.
    let (part, margin) = cost(During::intervals([[5.03, 10.0]]));
    assert!(free < part && part < always * (1.0 + 1e-9), "{free} {part} {always}");
    assert!(margin.is_some_and(|margin| margin.abs() < 1e-8), "{margin:?}");
}

/// Against CasADi 3.7 and IPOPT on torques held over 50, 100, 200 and 400 intervals, Runge and
/// Kutta's method of order four, the cone held at their ends, extrapolated
/// (`tests/exchange/direct.py` has the same equations).
#[test]
fn a_boresight_on_one_cone_goes_the_way_that_another_program_finds() {
    const WANTED: f64 = 0.339_212_165_52;
    let boresight = Vector3::new(1.0, 0.0, 1.0).normalize();
    let found = extrapolated(&slew().with_constraint(held(boresight, During::default())), 50);
    assert!((found / WANTED - 1.0).abs() < 1e-8, "{found}");
}
