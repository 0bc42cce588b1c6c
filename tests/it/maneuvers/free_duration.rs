//! Least effort where a second has a price: references of another program, the law of rest to rest, and honesty.

use super::minimum_time::{CUBE, at, body, solved, torques};
use slewkit::maneuver::{Objective, Problem, Settings, State, Weights};
use slewkit::mechanics::environment::UniformGravity;
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia};
use slewkit::plan::{Plan, Silent, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};

fn priced(price: f64) -> Objective {
    Objective::Effort(Weights { time_price: Some(price), ..Weights::default() })
}

fn sought(body: Body, start: State, end: State, price: f64, steps: usize) -> Plan {
    let problem =
        Problem::attitude(body, start, end, f64::NAN).with_objective(priced(price)).with_steps(steps);
    let plan = solved(&problem);
    assert!(plan.solution.optimality.stationarity < 1e-12, "{:e}", plan.solution.optimality.stationarity);
    plan
}

fn duration(plan: &Plan) -> f64 {
    *plan.solution.trajectory.time.last().unwrap()
}

fn axis_angle(axis: [f64; 3], angle_deg: f64) -> State {
    State::at_rest(lie::exp(&(Vector3::from(axis).normalize() * angle_deg.to_radians())))
}

/// Both figures by another program: indirect shooting by a Runge–Kutta method of order 8, and Gauss collocation, which agree
/// to 3e-13. Richardson's extrapolation over N, 2N, 4N leaves an error of sixth order.
fn meets(body: &Body, [start, end]: [State; 2], price: f64, [cost, time]: [f64; 2]) {
    let plans = [100, 200, 400].map(|steps| sought(body.clone(), start, end, price, steps));
    for (figures, reference) in
        [(plans.each_ref().map(|plan| plan.solution.cost), cost), (plans.each_ref().map(duration), time)]
    {
        let order = ((figures[0] - reference) / (figures[1] - reference)).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}");
        let second = [0, 1].map(|k| (4.0 * figures[k + 1] - figures[k]) / 3.0);
        let fourth = (16.0 * second[1] - second[0]) / 15.0;
        assert!((fourth / reference - 1.0).abs() < 1e-10, "{fourth} {reference}");
    }
}

#[test]
fn references_are_met_by_extrapolation_and_the_order_is_two() {
    let identity = State::at_rest(Matrix3::identity());
    meets(
        &body([1.0, 2.0, 3.0]),
        [identity, axis_angle([1.0, 2.0, 3.0], 120.0)],
        1.0,
        [6.141_377_161_056_607_5, 4.606_032_870_792_456],
    );
    let full = Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1);
    let end = axis_angle([0.3, -1.0, 0.5], 100.0).attitude;
    meets(
        &Body { inertia: Inertia::new(full).unwrap(), mass: None },
        [
            State::attitude(Matrix3::identity(), Vector3::new(0.5, -0.3, 0.8)),
            State::attitude(end, Vector3::new(-0.2, 0.4, 0.1)),
        ],
        0.5,
        [3.113_791_045_869_072_5, 3.966_490_732_652_001],
    );
    meets(
        &body([5621.0, 4547.0, 2364.0]),
        [identity, axis_angle([1.0, 1.0, 0.5], 150.0)],
        200.0,
        [16_031.233_118_248_374, 60.117_124_193_431_78],
    );
}

/// `E ∝ T⁻³` on any grid, so that at the best duration `E = w T/3`.
#[test]
fn from_rest_to_rest_the_cost_is_four_thirds_of_the_price_of_the_duration() {
    let inertia = Inertia::new(Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1)).unwrap();
    for (price, steps) in [(0.01, 20), (1.0, 100), (300.0, 50)] {
        let body = Body { inertia: inertia.clone(), mass: None };
        let plan = sought(body, at([0.0; 3], [0.0; 3]), at([0.7, -1.1, 0.9], [0.0; 3]), price, steps);
        let (cost, duration) = (plan.solution.cost, duration(&plan));
        assert!((cost / (4.0 / 3.0 * price * duration) - 1.0).abs() < 1e-11, "{cost} {duration}");
    }
}

/// With limits; by torques about axes of the reference frame; in a field. A parabola through the costs beside the best
/// duration has its lowest point there.
#[test]
fn the_cost_is_least_at_the_duration_that_is_found() {
    let (start, end) = (at([0.1, 0.0, 0.2], [0.1, -0.2, 0.1]), at([0.9, -0.4, 0.6], [-0.1, 0.2, 0.15]));
    let attitude = Problem::attitude(body([1.0, 1.5, 2.0]), start, end, f64::NAN).with_steps(50);
    let axes = vec![Vector3::new(1.0, 0.2, 0.0), Vector3::y(), Vector3::new(0.0, -0.3, 1.2)];
    let in_reference = ActuatorSet::new(axes, AxisFrame::Reference).unwrap();
    let gravity =
        UniformGravity::new(1.0, 0.5, Vector3::new(0.3, -0.2, -1.0), Vector3::new(0.1, 0.2, 0.4)).unwrap();
    let problems = [
        attitude.clone().with_actuation(torques(&CUBE, &[0.3, 0.4, 0.5])),
        attitude.clone().with_actuation(Actuation::torques(in_reference)),
        attitude.with_environment(gravity),
    ];
    for problem in problems {
        let price = 0.2;
        let found = solved(&problem.clone().with_objective(priced(price)));
        let best = duration(&found);
        let cost = |factor: f64| {
            let given = problem.clone().with_duration(factor * best);
            solved(&given).solution.cost + price * factor * best
        };
        let apart = 1e-3;
        let [shorter, longer] = [1.0 - apart, 1.0 + apart].map(cost);
        let curvature = shorter + longer - 2.0 * found.solution.cost;
        assert!(curvature > 0.0, "{shorter} {} {longer}", found.solution.cost);
        let lowest = 0.5 * apart * (shorter - longer) / curvature;
        assert!(lowest.abs() < 1e-5, "{lowest:e}");
    }
}

#[test]
fn another_duration_is_noticed_and_what_has_none_to_be_sought_is_refused() {
    let end = at([0.0, 0.3, 1.0], [0.0; 3]);
    let problem = Problem::attitude(body([1.0, 1.5, 2.0]), at([0.0; 3], [0.0; 3]), end, f64::NAN);
    let found = solved(&problem.clone().with_objective(priced(1.0)));
    let own =
        problem.clone().with_objective(priced(1.0)).with_found_duration(&found.solution.trajectory.time);
    assert!(verify(&own, &found.solution.trajectory, 1e-12, None).passed());
    let other = own.clone().with_duration(1.001 * own.duration);
    assert!(!verify(&other, &found.solution.trajectory, 1e-12, None).passed());
    let refused = |problem: &Problem| {
        plan(problem, &Settings::default(), None, &mut Silent).expect_err("refused").to_string()
    };
    assert!(refused(&problem).contains("duration"));
    for price in [0.0, -1.0, f64::NAN] {
        assert!(refused(&problem.clone().with_objective(priced(price))).contains("price of time"));
    }
    let euler = problem.with_objective(priced(1.0)).with_scheme(slewkit::maneuver::Scheme::LieEuler);
    assert!(refused(&euler).contains("Lie–Verlet"));
}
