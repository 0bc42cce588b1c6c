//! `method = "interior_point"` for maneuvers that the shooting can solve: equal optima on equal
//! steps, by another method.

use super::minimum_time::{CUBE, body, solved, torques};
use super::shortest::turn;
use slewkit::maneuver::{Fuel, Method, Objective, Problem, ProblemError, Settings, State, Unsuited, Weights};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::plan::{Plan, PlanError, Silent, Status, plan};
use slewkit::{Duration, Matrix3};

/// Returns a plan by the interior point on equal steps, which the witnesses have verified.
pub(super) fn on_equal_steps(problem: &Problem) -> Plan {
    let settings = Settings { method: Method::InteriorPoint, ..Settings::discrete() };
    let found = plan(problem, &settings, None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved, "{:?}", found.solution.shortfall);
    assert_eq!(found.solution.method, Method::InteriorPoint);
    assert!(found.solution.switching.is_none());
    found
}

fn slew(moments: [f64; 3], degrees: f64) -> Problem {
    let end = turn([0.0, 0.0, 1.0], degrees);
    Problem::minimum_time(body(moments), State::at_rest(Matrix3::identity()), end)
        .with_actuation(torques(&CUBE, &[1.0; 3]))
}

/// Returns the relative difference of two figures.
fn apart(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

/// Bilimoria and Wie, Time-optimal three-axis reorientation of a rigid spacecraft, 1993: 2.4211 s
/// for a quarter of a turn of a sphere. A turn about the axis alone takes 2.5066 s.
#[test]
fn a_quarter_of_a_turn_takes_what_was_published() {
    let quarter = slew([1.0; 3], 90.0);
    let [coarse, fine] = [60, 120].map(|steps| {
        let found = on_equal_steps(&quarter.clone().with_steps(steps)).solution;
        assert_eq!(found.cost, found.duration(&quarter));
        found.cost
    });
    assert!(apart(coarse, 2.4211) < 2e-3 && apart(fine, 2.4211) < 5e-4, "{coarse} {fine}");
}

#[test]
fn least_fuel_is_that_of_the_arcs_but_for_the_grid() {
    let fuel = Objective::Fuel(Fuel::default());
    let problem = slew([1.0, 2.0, 3.0], 120.0).with_objective(fuel).with_duration(6.0).with_steps(80);
    let arcs = solved(&problem).solution.switching.expect("arcs").continuous_cost;
    let found = on_equal_steps(&problem).solution.cost;
    assert!(apart(found, arcs) < 2e-3, "{found} {arcs}");
}

/// The interior point and the shooting find the same least effort in the best duration, which the
/// shooting takes as given; no neighboring duration costs less.
#[test]
fn a_duration_that_is_sought_is_the_best_of_those_given_to_the_shooting() {
    let (price, weights) = (0.05, Weights { time_price: Some(0.05), ..Weights::default() });
    let effort = slew([1.0, 2.0, 3.0], 120.0).with_objective(Objective::default());
    let problem = effort.with_duration(Duration::SOUGHT);
    let sought = solved(&problem.clone().with_objective(Objective::from(weights))).solution;
    let best = sought.duration(&problem);
    let given = |part: f64| {
        let plan = solved(&problem.clone().with_duration(part * best)).solution;
        assert_eq!(plan.method, Method::Shooting);
        plan.cost + price * part * best
    };
    assert_eq!(sought.method, Method::InteriorPoint);
    assert!(apart(sought.cost, given(1.0)) < 1e-12, "{} {}", sought.cost, given(1.0));
    assert!(given(0.999) > sought.cost && given(1.001) > sought.cost);
}

#[test]
fn pulses_are_between_equal_steps_and_refused() {
    let limits = Limits { size: Some(vec![1.0; 3]), shortest_pulse: Some(0.2), ..Limits::default() };
    let torque = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let fuel = slew([1.0; 3], 90.0).with_objective(Objective::Fuel(Fuel::default())).with_duration(6.0);
    let pulses = fuel.with_actuation(Actuation::torques(torque));
    let settings = Settings { method: Method::InteriorPoint, ..Settings::discrete() };
    let refused = plan(&pulses, &settings, None, &mut Silent).unwrap_err();
    assert_eq!(refused, PlanError::Problem(ProblemError::Unsuited(Unsuited::PulsesOnEqualSteps)));
}
