//! Cones that hold in turns, of which at every time one is enough.

use super::on_equal_steps::on_equal_steps;
use super::shortest::cone;
use slewkit::maneuver::{
    Aim, Alternatives, Constraint, Direction, During, Fuel, Objective, Outcome, Problem, ProblemError, Rule,
    Settings, Side, Target,
};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::plan::{Plan, PlanError, Silent, Status, plan};
use slewkit::{Body, Inertia, Matrix3, State, Vector3, lie};

const HALF_ANGLE: f64 = 35.0;
const TRACKERS: [[f64; 3]; 2] = [[0.796, 0.402, -0.452], [0.83, -0.505, 0.237]];
const SUN: [f64; 3] = [0.261, 0.914, -0.312];

/// Returns the maneuver of `problems/two_trackers.toml` without its trackers.
fn free() -> Problem {
    let inertia = Matrix3::new(120.0, 4.0, -3.0, 4.0, 100.0, 2.0, -3.0, 2.0, 80.0);
    let body = Body { inertia: Inertia::new(inertia).unwrap(), mass: None };
    let axis = Vector3::new(0.2, 0.3, 0.93).normalize();
    let end = State::at_rest(lie::exp(&(axis * 130_f64.to_radians())));
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 60.0).with_steps(40)
}

fn both() -> Problem {
    let [first, second] = TRACKERS.map(|axis| Vector3::from(axis).normalize().into());
    let one = cone(free(), Side::KeepOut, first, SUN, HALF_ANGLE);
    let mut both = cone(one, Side::KeepOut, second, SUN, HALF_ANGLE);
    for (index, constraint) in both.constraints.iter_mut().enumerate() {
        constraint.name = format!("tracker {}", index + 1);
    }
    both
}

fn in_turns() -> Problem {
    let sets = ["tracker 1", "tracker 2"].map(|name| vec![name.to_string()]).to_vec();
    both().with_alternatives(Alternatives { name: "sky".into(), sets })
}

fn planned(problem: &Problem, target: Target) -> Plan {
    plan(problem, &Settings { target, ..Settings::default() }, None, &mut Silent).unwrap()
}

/// Returns the trackers at given times alone.
fn with(times: [[f64; 2]; 2]) -> Problem {
    let mut problem = both();
    for (Constraint { rule, .. }, times) in problem.constraints.iter_mut().zip(times) {
        let Rule::Pointing(cone) = rule else { unreachable!("a cone") };
        cone.during = During::intervals([times]);
    }
    problem
}

/// Every moment at which the one tracker may follow the other is tried, in either order: none leads
/// to a cheaper plan.
#[test]
fn no_moment_of_handing_over_is_cheaper() {
    let found = planned(&in_turns(), Target::Discrete);
    assert_eq!(found.status, Status::Solved);
    assert_eq!(found.solution.turns[0].shifts.len(), 2);
    let mut tried = 0;
    for moment in (1..40).map(|node| 1.5 * f64::from(node)) {
        let [early, late] = [[0.0, moment], [moment, 60.0]];
        for times in [[early, late], [late, early]] {
            // The start and the end violate the cones in one of the orders.
            let Ok(other) = plan(&with(times), &Settings::discrete(), None, &mut Silent) else { continue };
            let other = other.solution;
            if other.outcome == Outcome::Converged {
                tried += 1;
                assert!(found.solution.cost < other.cost * (1.0 + 1e-6), "{moment}: {}", other.cost);
            }
        }
    }
    assert!(tried > 30, "{tried}");
}

/// Least fuel costs no less than without trackers on the same equal steps, and no more than with one
/// hand-over halfway.
#[test]
fn least_fuel_in_a_given_duration_is_planned_in_turns() {
    let limits = Limits { size: Some(vec![0.8; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let fuel = |problem: Problem| {
        let fuel = problem.with_objective(Objective::Fuel(Fuel::default()));
        fuel.with_actuation(Actuation::torques(torques.clone()))
    };
    let cost = |problem: Problem| {
        let found = planned(&fuel(problem), Target::Discrete);
        assert_eq!(found.status, Status::Solved);
        found.solution.cost
    };
    let halfway = with([[30.0, 60.0], [0.0, 30.0]]);
    let without = on_equal_steps(&fuel(free())).solution.cost;
    let (turns, halfway) = (cost(in_turns()), cost(halfway));
    assert!(without * (1.0 - 1e-9) < turns && turns < halfway * (1.0 + 1e-6), "{without} {turns} {halfway}");
}

/// At every node of the motion one of the trackers is away from the Sun, independent of the shifts
/// that the plan states.
#[test]
fn one_tracker_sees_at_every_time() {
    let found = planned(&in_turns(), Target::Motion);
    assert_eq!(found.status, Status::Solved);
    let angle = |quaternion: &[f64; 4], boresight: [f64; 3]| {
        let seen = lie::rotation_from_quaternion(quaternion) * Vector3::from(boresight).normalize();
        seen.angle(&Vector3::from(SUN).normalize()).to_degrees()
    };
    let (mut alone, mut least) = ([f64::INFINITY; 2], f64::INFINITY);
    for quaternion in &found.solution.trajectory.quaternion {
        let angles = TRACKERS.map(|boresight| angle(quaternion, boresight));
        alone = std::array::from_fn(|index| alone[index].min(angles[index]));
        least = least.min(angles[0].max(angles[1]));
    }
    assert!(least > HALF_ANGLE - 1e-6, "{least}");
    assert!(alone.iter().all(|angle| *angle < HALF_ANGLE - 1.0), "{alone:?}");
}

/// Two trackers can do more than one alone; and one that is enough is as good as no choice.
#[test]
fn a_set_that_is_enough_all_along_costs_what_it_costs_alone() {
    let sets = [vec!["Sun".to_string()], vec!["tracker 2".to_string()]].to_vec();
    let mut problem = both();
    // A tracker that looks away from the Sun all along.
    let away = Vector3::from(SUN).normalize();
    problem.constraints[0].name = "Sun".into();
    let Rule::Pointing(cone) = &mut problem.constraints[0].rule else { unreachable!("a cone") };
    cone.boresights = vec![-away];
    let alone = planned(&free(), Target::Discrete).solution.cost;
    let found =
        planned(&problem.with_alternatives(Alternatives { name: "sky".into(), sets }), Target::Discrete);
    assert_eq!(found.status, Status::Solved);
    assert!((found.solution.cost / alone - 1.0).abs() < 1e-9, "{} and {alone}", found.solution.cost);
}

/// An end that a cone beside the sets forbids at every roll is refused, as it is without the sets.
#[test]
fn an_end_in_a_cone_is_refused_beside_sets() {
    let aim = Aim::new(Vector3::z(), Direction::Fixed(Vector3::from(SUN).normalize())).at_rest();
    let problem = cone(in_turns(), Side::KeepOut, [0.0, 0.0, 1.0], SUN, 30.0).with_aim_at_end(aim);
    let found = plan(&problem, &Settings::default(), None, &mut Silent);
    assert!(matches!(found, Err(PlanError::Problem(ProblemError::Violated { end: "end", .. }))), "{found:?}");
}

/// If no set holds at an end, this is reported, with the fault of each.
#[test]
fn an_end_that_no_set_holds_is_refused() {
    let mut problem = in_turns();
    for constraint in &mut problem.constraints {
        let Rule::Pointing(cone) = &mut constraint.rule else { unreachable!("a cone") };
        cone.boresights = vec![Vector3::from(SUN).normalize()];
    }
    let error = problem.check().unwrap_err().to_string();
    assert!(error.starts_with("the start violates \"sky\"") && error.contains(", and "), "{error}");
}
