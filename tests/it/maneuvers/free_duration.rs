//! Least effort where a second has a price: references of another program, the law of rest to rest,
//! and honesty.

use super::minimum_time::{CUBE, at, body, solved, torques};
use evidence::Turning;
use slewkit::maneuver::{Duration, Objective, Problem, Settings, State, Weights};
use slewkit::mechanics::environment::{GravityGradient, UniformGravity};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia};
use slewkit::plan::{Plan, Silent, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};

fn priced(price: f64) -> Objective {
    Objective::Effort(Weights { time_price: Some(price), ..Weights::default() })
}

/// Returns a plan whose cost is stationary in its duration.
fn found(problem: &Problem) -> Plan {
    let plan = solved(problem);
    assert!(plan.solution.optimality.stationarity < 1e-12, "{:e}", plan.solution.optimality.stationarity);
    plan
}

fn sought(body: Body, [start, end]: [State; 2], price: f64) -> Problem {
    Problem::attitude(body, start, end, Duration::SOUGHT).with_objective(priced(price))
}

fn duration(plan: &Plan) -> f64 {
    *plan.solution.trajectory.time.last().unwrap()
}

fn axis_angle(axis: [f64; 3], angle_deg: f64) -> State {
    State::at_rest(lie::exp(&(Vector3::from(axis).normalize() * angle_deg.to_radians())))
}

/// Both figures by another program: indirect shooting by a Runge–Kutta method of order 8, and Gauss
/// collocation, which agree to 3e-13. Richardson's extrapolation over N, 2N, 4N leaves an error of
/// sixth order.
fn meets(problem: &Problem, [cost, time]: [f64; 2]) {
    let plans = [100, 200, 400].map(|steps| found(&problem.clone().with_steps(steps)));
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
    let asymmetric = body([1.0, 2.0, 3.0]);
    meets(
        &sought(asymmetric, [identity, axis_angle([1.0, 2.0, 3.0], 120.0)], 1.0),
        [6.141_377_161_056_607_5, 4.606_032_870_792_456],
    );
    let full = Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1);
    let end = axis_angle([0.3, -1.0, 0.5], 100.0).attitude;
    let ends = [
        State::attitude(Matrix3::identity(), Vector3::new(0.5, -0.3, 0.8)),
        State::attitude(end, Vector3::new(-0.2, 0.4, 0.1)),
    ];
    let full = Body { inertia: Inertia::new(full).unwrap(), mass: None };
    meets(&sought(full, ends, 0.5), [3.113_791_045_869_072_5, 3.966_490_732_652_001]);
    let xte = body([5621.0, 4547.0, 2364.0]);
    meets(
        &sought(xte, [identity, axis_angle([1.0, 1.0, 0.5], 150.0)], 200.0),
        [16_031.233_118_248_374, 60.117_124_193_431_78],
    );
}

/// `E ∝ T⁻³` on any grid, so that at the best duration `E = w T/3`.
#[test]
fn from_rest_to_rest_the_cost_is_four_thirds_of_the_price_of_the_duration() {
    let inertia = Inertia::new(Matrix3::new(2.2, -0.3, 0.2, -0.3, 1.6, -0.25, 0.2, -0.25, 1.1)).unwrap();
    for (price, steps) in [(0.01, 20), (1.0, 100), (300.0, 50)] {
        let body = Body { inertia: inertia.clone(), mass: None };
        let ends = [at([0.0; 3], [0.0; 3]), at([0.7, -1.1, 0.9], [0.0; 3])];
        let plan = found(&sought(body, ends, price).with_steps(steps));
        let (cost, duration) = (plan.solution.cost, duration(&plan));
        assert!((cost / (4.0 / 3.0 * price * duration) - 1.0).abs() < 1e-11, "{cost} {duration}");
    }
}

/// A parabola through the costs near the best duration has its lowest point there: in a field whose
/// frame turns; with limits; by torques about axes of the reference frame; in a field at rest.
#[test]
fn the_cost_is_least_at_the_duration_that_is_found() {
    let (start, end) = (at([0.1, 0.0, 0.2], [0.1, -0.2, 0.1]), at([0.9, -0.4, 0.6], [-0.1, 0.2, 0.15]));
    let attitude = Problem::attitude(body([1.0, 1.5, 2.0]), start, end, Duration::SOUGHT).with_steps(50);
    let axes = vec![Vector3::new(1.0, 0.2, 0.0), Vector3::y(), Vector3::new(0.0, -0.3, 1.2)];
    let in_reference = ActuatorSet::new(axes, AxisFrame::Reference).unwrap();
    let gravity =
        UniformGravity::new(1.0, 0.5, Vector3::new(0.3, -0.2, -1.0), Vector3::new(0.1, 0.2, 0.4)).unwrap();
    let turning_field = GravityGradient::new(0.2, &body([1.0, 1.5, 2.0]).inertia).unwrap();
    let problems = [
        attitude.clone().with_environment(turning_field),
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

/// A target that turns with its frame, and is met with its rate. Another program, as above, gives
/// 3.15320718951 at 4.54367210804 s; local minima at 6.29 s and 9.11 s.
#[test]
fn a_target_that_turns_is_met_when_it_is_cheapest() {
    let frame_rate = Vector3::new(0.0, 0.2, 0.1);
    let [w, x, y, z] = [
        0.573_576_436_351_046_2,
        0.334_417_421_710_959_56,
        0.668_834_843_421_919_1,
        -0.334_417_421_710_959_56,
    ];
    let end = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let end = State::attitude(end, end.inverse() * frame_rate);
    let ends = [State::at_rest(Matrix3::identity()), end];
    let problem = sought(body([1.0, 1.6, 2.3]), ends, 0.5).with_environment(Turning(frame_rate));
    meets(&problem, [3.153_207_189_512_530_7, 4.543_672_108_039_847]);
}

/// A maneuver from rest to rest uses all of the time: `E ∝ T⁻³`. If the body moves, the duration of
/// least effort is used if it is allowed, and no price is needed; with a price the bound acts only
/// below the duration that the price chooses.
#[test]
fn a_longest_duration_is_taken_or_is_longer_than_needed() {
    let (still, there) = (at([0.0; 3], [0.0; 3]), at([0.7, -1.1, 0.9], [0.0; 3]));
    let rest = Problem::attitude(body([1.0, 1.5, 2.0]), still, there, Duration::SOUGHT).with_steps(60);
    let bounded = solved(&rest.clone().with_duration_at_most(5.0));
    assert!((duration(&bounded) / 5.0 - 1.0).abs() < 1e-15);
    let given = solved(&rest.clone().with_duration(5.0));
    assert_eq!(bounded.solution.cost, given.solution.cost);

    // It turns towards the target by itself: in the best duration it needs hardly any torque.
    let coasting = [at([0.0; 3], [0.0, 0.0, 0.5]), at([0.0, 0.0, 1.5], [0.0, 0.0, 0.5])];
    let problem =
        Problem::attitude(body([1.0, 1.5, 2.0]), coasting[0], coasting[1], Duration::SOUGHT).with_steps(60);
    let found = solved(&problem.clone().with_duration_at_most(10.0));
    // A step turns by tan(hω/2), so the discrete coast takes 3 s up to h².
    assert!((duration(&found) - 3.0).abs() < 1e-3 && found.solution.cost < 1e-20, "{}", duration(&found));

    for (longest, acts) in [(2.0, true), (20.0, false)] {
        let problem = rest.clone().with_objective(priced(0.5));
        let free = solved(&problem);
        let bounded = solved(&problem.clone().with_duration_at_most(longest));
        let expected = if acts { longest } else { duration(&free) };
        assert!((duration(&bounded) / expected - 1.0).abs() < 1e-10, "{}", duration(&bounded));
        assert!(bounded.solution.cost >= free.solution.cost * (1.0 - 1e-12));
    }

    // A plan that takes longer is refused.
    let beyond = found.solution.trajectory.completed(&problem.clone().with_duration_at_most(2.9));
    let judged = verify(&beyond, &found.solution.trajectory, 1e-12, None);
    let named: Vec<_> = judged.checks.iter().filter(|check| !check.passed).map(|check| &check.name).collect();
    assert_eq!(named, ["longest duration"]);
}

#[test]
fn another_duration_is_noticed_and_what_has_none_to_be_sought_is_refused() {
    let end = at([0.0, 0.3, 1.0], [0.0; 3]);
    let problem = Problem::attitude(body([1.0, 1.5, 2.0]), at([0.0; 3], [0.0; 3]), end, Duration::SOUGHT);
    let found = solved(&problem.clone().with_objective(priced(1.0)));
    let own = found.solution.trajectory.completed(&problem.clone().with_objective(priced(1.0)));
    assert!(verify(&own, &found.solution.trajectory, 1e-12, None).passed());
    let other = own.clone().with_duration(Duration::Found { duration: 1.001 * own.seconds(), at_most: None });
    assert!(!verify(&other, &found.solution.trajectory, 1e-12, None).passed());
    let refused = |problem: &Problem| {
        plan(problem, &Settings::discrete(), None, &mut Silent).expect_err("refused").to_string()
    };
    assert!(refused(&problem).contains("duration"));
    for price in [0.0, -1.0, f64::NAN] {
        assert!(refused(&problem.clone().with_objective(priced(price))).contains("price of time"));
    }
    for longest in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&problem.clone().with_duration_at_most(longest)).contains("longest duration"));
    }
    let fastest = problem.clone().with_actuation(torques(&CUBE, &[1.0; 3])).with_objective(Objective::Time);
    assert!(refused(&fastest.with_duration_at_most(10.0)).contains("remove the bound"));
    let euler = problem.with_objective(priced(1.0)).with_scheme(slewkit::maneuver::Scheme::LieEuler);
    assert!(refused(&euler).contains("Lie–Verlet"));
}
