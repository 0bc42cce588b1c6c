//! Minimum fuel through the public interface: closed forms, laws that every optimum obeys, and
//! honesty.

use super::minimum_time::{CUBE, at, body, moving, solved, torques};
use slewkit::maneuver::{Duration, Fuel, Objective, Outcome, Problem, Settings, State, Structure};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Silent, Status, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::FRAC_PI_2;

fn fuel(problem: &Problem) -> f64 {
    solved(problem).solution.switching.expect("arcs").continuous_cost
}

/// Returns a maneuver of an asymmetric body between moving states, in about twice the shortest
/// time.
fn moving_slowly() -> Problem {
    moving().with_objective(Objective::Fuel(Fuel::default())).with_duration(5.0)
}

/// Returns a quarter turn of a body about its principal axis, by one torque of each axis.
fn quarter_turn(objective: Fuel, duration: impl Into<Duration>) -> Problem {
    let end = at([0.0, 0.0, FRAC_PI_2], [0.0; 3]);
    Problem::minimum_fuel(body([2.0, 2.5, 3.0]), at([0.0; 3], [0.0; 3]), end, duration)
        .with_actuation(torques(&CUBE, &[1.0, 1.0, 0.8]))
        .with_objective(Objective::Fuel(objective))
}

/// Thrusters, each with an opposite one.
pub(super) fn thrusters(axes: &[[f64; 3]], limit: f64) -> Actuation {
    let axes: Vec<Vector3> =
        axes.iter().flat_map(|axis| [Vector3::from(*axis), -Vector3::from(*axis)]).collect();
    let limits = Limits { size: Some(vec![limit; axes.len()]), one_sided: true, ..Limits::default() };
    Actuation::torques(ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap())
}

/// Returns a torque of limited norm that points anywhere.
pub(super) fn ball(limit: f64) -> Actuation {
    let limits = Limits { norm: Some(limit), ..Limits::default() };
    Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap())
}

/// Two burns of length `½ (T − √(T² − T_min²))` with `T_min = 2 √(jθ/U)`.
#[test]
fn a_turn_about_a_principal_axis_burns_as_the_closed_form_says() {
    let (limit, duration) = (0.8, 7.0);
    let shortest = 2.0 * (3.0 * FRAC_PI_2 / limit).sqrt();
    let closed = limit * (duration - (duration * duration - shortest * shortest).sqrt());
    let plan = solved(&quarter_turn(Fuel::default(), duration));
    let switching = plan.solution.switching.unwrap();
    assert_eq!((switching.structure, switching.switches), (Structure::BangOffBang, 2));
    assert!(
        (switching.continuous_cost / closed - 1.0).abs() < 1e-9,
        "{} {closed}",
        switching.continuous_cost
    );
    // Steps about one axis turn by 2 atan(hω/2): an error of second order in the step.
    assert!((plan.solution.cost / closed - 1.0).abs() < 1e-4, "{} {closed}", plan.solution.cost);
}

/// `U T_min² / (T + √(T² − T_min²))`, which loses no digits, from ten to ten thousand times the
/// shortest duration: in long ones burns take less than a millionth of the time.
#[test]
fn fuel_in_a_long_duration_is_that_of_the_closed_form() {
    for (actuation, limit) in [(torques(&CUBE, &[1.0, 1.0, 0.8]), 0.8), (ball(0.8), 0.8)] {
        let shortest = 2.0 * (3.0 * FRAC_PI_2 / limit).sqrt();
        for times in [10.0, 20.0, 50.0, 100.0, 1e3, 1e4] {
            let duration: f64 = times * shortest;
            let closed =
                limit * shortest * shortest / (duration + (duration * duration - shortest * shortest).sqrt());
            let plan = solved(&quarter_turn(Fuel::default(), duration).with_actuation(actuation.clone()));
            let switching = plan.solution.switching.unwrap();
            let apart =
                [switching.continuous_cost, plan.solution.cost].map(|cost| (cost / closed - 1.0).abs());
            assert!(apart[0] < 1e-8 && apart[1] < 1e-4, "{times} times: {apart:?}");
        }
    }
}

/// A slower motion along the same path burns less in proportion.
#[test]
fn fuel_times_duration_never_grows() {
    let end = at([0.6, 1.1, 1.6], [0.0; 3]);
    let of = |duration: f64| {
        let problem = Problem::minimum_fuel(body([1.0, 2.0, 2.9]), at([0.0; 3], [0.0; 3]), end, duration);
        duration * fuel(&problem.with_actuation(torques(&CUBE, &[1.0; 3])).with_steps(100))
    };
    let products = [15.0, 30.0, 60.0, 120.0, 240.0, 480.0].map(of);
    assert!(products.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-6)), "{products:?}");
}

/// `d/dT (U (T − √(T² − T_min²)) + w T) = 0`.
#[test]
fn a_price_of_time_chooses_the_duration_of_the_closed_form() {
    let (limit, price) = (0.8, 0.3);
    let shortest = 2.0 * (3.0 * FRAC_PI_2 / limit).sqrt();
    let k = 1.0 + price / limit;
    let best = shortest * k / (k * k - 1.0).sqrt();
    let closed = limit * (best - (best * best - shortest * shortest).sqrt()) + price * best;
    let objective = Fuel { time_price: Some(price), ..Fuel::default() };
    let found = solved(&quarter_turn(objective, Duration::SOUGHT)).solution.switching.unwrap();
    assert!((found.continuous_duration_s / best - 1.0).abs() < 1e-13, "{found:?} {best}");
    assert!((found.continuous_cost / closed - 1.0).abs() < 1e-9, "{found:?} {closed}");
}

/// A sphere turns about one axis, whatever the direction of the torque inputs: two burns of
/// `½ (T − √(T² − T_min²))` with `T_min = 2 √(jθ/U)`, and a price of time chooses `T` as above.
#[test]
fn a_torque_of_limited_norm_burns_as_the_closed_form_says() {
    let (inertia, limit, price, angle) = (2.0_f64, 0.8, 2.5, 1.9);
    let axis = Vector3::new(2.0, -1.0, 0.7).normalize();
    let shortest = 2.0 * (inertia * angle / limit).sqrt();
    let at_rest = |turn: Vector3| at(turn.into(), [0.0; 3]);
    let problem = |objective: Fuel, duration: Duration| {
        let [start, end] = [Vector3::zeros(), angle * axis].map(at_rest);
        Problem::minimum_fuel(body([inertia; 3]), start, end, duration)
            .with_actuation(ball(limit))
            .with_objective(Objective::Fuel(objective))
    };
    let burnt =
        |duration: f64| price * limit * (duration - (duration * duration - shortest * shortest).sqrt());
    let prices = Some(vec![price; 3]);
    let duration = 1.3 * shortest;
    let given = problem(Fuel { prices: prices.clone(), ..Fuel::default() }, Duration::Given(duration));
    let plan = solved(&given.with_steps(400));
    let found = plan.solution.switching.unwrap();
    assert_eq!((found.structure, found.switches), (Structure::BangOffBang, 2));
    assert!((found.continuous_cost / burnt(duration) - 1.0).abs() < 1e-10, "{found:?}");
    assert!((plan.solution.cost / burnt(duration) - 1.0).abs() < 1e-4);
    // The torque is zero on the coast. It turns on a burn, and arcs do not report it.
    assert!(found.arcs[0].input.is_empty() && found.arcs[1].input == [0.0; 3]);

    let time_price = 0.9;
    let k = 1.0 + time_price / (price * limit);
    let best = shortest * k / (k * k - 1.0).sqrt();
    let found =
        solved(&problem(Fuel { prices, time_price: Some(time_price), ..Fuel::default() }, Duration::SOUGHT));
    let found = found.solution.switching.unwrap();
    assert!((found.continuous_duration_s / best - 1.0).abs() < 1e-10, "{found:?} {best}");
    let closed = burnt(best) + time_price * best;
    assert!((found.continuous_cost / closed - 1.0).abs() < 1e-10, "{found:?} {closed}");
}

/// Three torques whose cube lies in the ball can do no better than the ball, and the ball no better
/// than the cube about it but for `Σ|τ_i| ≤ √3 |τ|`.
#[test]
fn a_ball_of_torques_burns_between_the_cubes_in_it_and_the_norms_of_those_about_it() {
    let given = moving_slowly();
    let norm = fuel(&given.clone().with_actuation(ball(1.0)));
    let inscribed = fuel(&given.clone().with_actuation(torques(&CUBE, &[1.0 / 3.0_f64.sqrt(); 3])));
    let around = fuel(&given.with_actuation(torques(&CUBE, &[1.0; 3])));
    // |τ| ≤ Σ|τ_i| ≤ √3 |τ|.
    assert!(norm <= inscribed * (1.0 + 1e-9), "{norm} {inscribed}");
    assert!(around <= 3.0_f64.sqrt() * norm * (1.0 + 1e-9), "{around} {norm}");
}

/// Fuel from rest to rest falls with the duration, so all of it is used. The duration at a price of
/// time is the duration of the closed form, if it is allowed.
#[test]
fn a_longest_duration_is_taken_or_is_longer_than_needed() {
    let (limit, price) = (0.8, 0.3);
    let shortest = 2.0 * (3.0 * FRAC_PI_2 / limit).sqrt();
    let k = 1.0 + price / limit;
    let best = shortest * k / (k * k - 1.0).sqrt();
    let bounded = |time_price: Option<f64>, longest: f64| {
        let problem = quarter_turn(Fuel { time_price, ..Fuel::default() }, Duration::SOUGHT);
        solved(&problem.with_duration_at_most(longest)).solution
    };
    let found = bounded(None, 7.0);
    assert!((found.trajectory.time.last().unwrap() / 7.0 - 1.0).abs() < 1e-14);
    let given = solved(&quarter_turn(Fuel::default(), 7.0)).solution;
    assert_eq!(found.cost, given.cost);
    let found = bounded(Some(price), 2.0 * best).switching.unwrap();
    assert!((found.continuous_duration_s / best - 1.0).abs() < 1e-12, "{found:?} {best}");
    let longest = 0.5 * (shortest + best);
    let found = bounded(Some(price), longest).switching.unwrap();
    let closed = limit * (longest - (longest * longest - shortest * shortest).sqrt()) + price * longest;
    assert!((found.continuous_duration_s / longest - 1.0).abs() < 1e-14);
    assert!((found.continuous_cost / closed - 1.0).abs() < 1e-9, "{found:?} {closed}");
}

/// Two maneuvers have far more time than they need, and their arcs are not read from a smoothed
/// extremal at once: a pulse much shorter than its switching function has the wrong sign, and a
/// singular arc needs a dozen pulses. The discrete optimum of smoothed inputs of the second one
/// costs 2 % more.
#[test]
fn short_pulses_and_singular_arcs_are_refined_until_hardly_anything_is_to_be_gained() {
    let narrow = Problem::minimum_fuel(
        Body {
            inertia: Inertia::new(Matrix3::new(
                8.69342, -1.60225, 0.60517, -1.60225, 4.27508, 2.2136, 0.60517, 2.2136, 6.10699,
            ))
            .unwrap(),
            mass: None,
        },
        at([0.0; 3], [0.058015, 0.009845, 0.018979]),
        at([0.649536, 0.283021, 0.251468], [-0.063446, 0.02889, -0.000895]),
        8.128664,
    )
    .with_actuation(torques(&CUBE, &[4.334028, 3.778618, 2.195728]));
    let singular = Problem::minimum_fuel(
        Body {
            inertia: Inertia::new(Matrix3::new(3.11, -1.05, 0.26, -1.05, 4.2, 0.046, 0.26, 0.046, 4.68))
                .unwrap(),
            mass: None,
        },
        at([0.0; 3], [0.0; 3]),
        at([0.5336, 2.4927, 1.1095], [0.0; 3]),
        15.9,
    )
    .with_actuation(torques(&CUBE, &[2.76, 1.64, 2.47]));
    for problem in [narrow, singular] {
        let plan = solved(&problem);
        let switching = plan.solution.switching.unwrap();
        assert!(switching.gap <= 1e-4 * switching.continuous_cost, "{switching:?}");
        assert_eq!(switching.smoothing, None);
        assert!((plan.solution.cost / switching.continuous_cost - 1.0).abs() < 1e-3, "{switching:?}");
    }
}

fn full(inertia: [f64; 6]) -> Body {
    let [xx, xy, xz, yy, yz, zz] = inertia;
    Body { inertia: Inertia::new(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)).unwrap(), mass: None }
}

/// Thrusters of these axes and limits, each by itself.
fn canted(axes: [[f64; 3]; 8], limits: [f64; 8]) -> Actuation {
    let limits = Limits { size: Some(limits.to_vec()), one_sided: true, ..Limits::default() };
    let axes = axes.map(Vector3::from).to_vec();
    Actuation::torques(ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap())
}

/// The cases are six switches that hardly determine the costates, whose own gap is a quarter of the
/// cost; two singular arcs, which need two dozen pulses; and a branch whose last smoothed extremal
/// alone shows that the arcs found are near it.
#[test]
fn trains_of_pulses_stand_for_singular_arcs() {
    let few = Problem::minimum_fuel(
        full([5.982, 0.5765, -0.246, 2.023, 1.889, 5.176]),
        at([0.0; 3], [0.0; 3]),
        at([-0.8346, -0.1312, 0.5215], [0.0; 3]),
        4.144,
    )
    .with_actuation(torques(&CUBE, &[4.62, 1.358, 1.132]));
    let two_arcs = Problem::minimum_fuel(
        full([7.497, 2.672, -1.209, 6.189, 1.574, 8.534]),
        at([0.0; 3], [-0.009447, 0.01102, -0.01641]),
        at([1.579, -1.489, -0.9009], [-0.04758, -0.05897, 0.06722]),
        9.723,
    )
    .with_actuation(torques(&CUBE, &[4.921, 2.214, 2.909]));
    let far = Problem::minimum_fuel(
        full([3.514, -1.976, -0.1625, 3.112, -0.2307, 5.215]),
        at([0.0; 3], [-0.0477, 0.00982, 0.04299]),
        at([-0.3286, -1.124, 2.837], [0.08372, 0.0555, 0.1063]),
        11.08,
    )
    .with_actuation(torques(&CUBE, &[2.627, 4.988, 2.467]));
    for problem in [few, two_arcs, far] {
        let plan = solved(&problem);
        let switching = plan.solution.switching.unwrap();
        assert!(switching.gap <= 1e-4 * switching.continuous_cost, "{switching:?}");
        assert_eq!(switching.smoothing, None);
        assert!((plan.solution.cost / switching.continuous_cost - 1.0).abs() < 2e-3, "{switching:?}");
    }
}

/// Smoothed thrusters that push unequally turn the body all of the time, in a long time too far.
#[test]
fn long_durations_have_extremals_where_smoothed_thrusters_lead_astray() {
    let axes = [
        [-0.6688, -0.5058, -0.5449],
        [0.6274, -0.5215, -0.5783],
        [-0.3562, 0.6372, -0.6834],
        [0.8609, 0.3271, -0.3896],
        [-0.3847, -0.8038, 0.4538],
        [0.6193, -0.4133, 0.6676],
        [-0.5778, 0.4735, 0.6648],
        [0.6709, 0.6423, 0.3706],
    ];
    let problem = Problem::minimum_fuel(
        full([5.685, 0.9157, -0.5607, 5.958, -1.08, 6.709]),
        at([0.0; 3], [0.0; 3]),
        at([-1.117, 2.734, -0.7798], [0.0; 3]),
        16.77,
    )
    .with_actuation(canted(axes, [1.004, 2.375, 1.089, 3.668, 2.971, 3.122, 4.787, 4.773]));
    let switching = solved(&problem).solution.switching.unwrap();
    assert!(switching.gap <= 1e-4 * switching.continuous_cost, "{switching:?}");
}

/// Inputs in the middle of their limits turn the body, and turn it more if a first path takes
/// longer.
#[test]
fn thrusters_that_push_unequally_have_a_shortest_time() {
    let axes = [
        [-0.6944, -0.3899, -0.6048],
        [0.8655, -0.4105, -0.2872],
        [-0.6737, 0.2562, -0.693],
        [0.6448, 0.6524, -0.3983],
        [-0.4249, -0.8183, 0.3871],
        [0.3374, -0.8112, 0.4775],
        [-0.7313, 0.301, 0.612],
        [0.4106, 0.323, 0.8527],
    ];
    let problem = Problem::minimum_time(
        full([8.642, -0.5708, -1.957, 9.095, -0.4338, 1.865]),
        at([0.0; 3], [0.0; 3]),
        at([-1.642, 0.2817, 0.5205], [0.0; 3]),
    )
    .with_actuation(canted(axes, [4.563, 2.49, 1.07, 2.914, 4.861, 3.757, 4.197, 2.857]));
    // A smoothed extremal takes 2.89824 s, and the limits would allow 0.00562 s less at most along
    // it.
    let duration = solved(&problem).solution.cost;
    assert!((duration / 2.89262 - 1.0).abs() < 1e-3, "{duration}");
}

/// The pulses of the discrete optimum on 100 steps differ from the pulses of the continuous one,
/// and smoothed inputs burn 7 % more.
#[test]
fn arcs_that_are_no_discrete_optimum_stay_the_plan() {
    let axes = [
        [-0.557, -0.3267, -0.7636],
        [0.6155, -0.5257, -0.5872],
        [-0.415, 0.7154, -0.5622],
        [0.2494, 0.5767, -0.7779],
        [-0.5432, -0.314, 0.7787],
        [0.3948, -0.7848, 0.4778],
        [-0.2887, 0.4642, 0.8373],
        [0.3811, 0.857, 0.3469],
    ];
    let problem = Problem::minimum_fuel(
        full([5.395, 0.2816, 0.6612, 5.608, -0.5498, 4.483]),
        at([0.0; 3], [-0.005568, -0.008982, 0.0007385]),
        at([-0.9748, -0.9954, 2.419], [-0.006498, 0.001654, 0.006079]),
        11.51,
    )
    .with_actuation(canted(axes, [3.596, 1.423, 4.615, 3.156, 1.057, 4.973, 4.934, 2.472]));
    let plan = solved(&problem);
    let switching = plan.solution.switching.unwrap();
    assert_eq!((switching.structure, switching.smoothing), (Structure::BangOffBang, None));
    assert!((plan.solution.cost / switching.continuous_cost - 1.0).abs() < 1e-3, "{}", plan.solution.cost);
}

#[test]
fn a_maneuver_burns_as_much_backwards() {
    let forward = moving_slowly();
    let reversed = |state: &State| State { angular_velocity: -state.angular_velocity, ..*state };
    let backward =
        Problem { start: reversed(&forward.end), end: reversed(&forward.start), ..forward.clone() };
    let (there, back) = (fuel(&forward), fuel(&backward));
    assert!((there / back - 1.0).abs() < 1e-8, "{there} {back}");
}

#[test]
fn fuel_goes_with_inertia_over_duration_and_with_its_price() {
    let given = moving_slowly();
    let unit = 7.0;
    let slower = |state: &State| State { angular_velocity: state.angular_velocity / unit, ..*state };
    let limits = [1.0, 1.2, 0.8].map(|limit| 40.0 * limit / (unit * unit));
    let priced = Fuel { prices: Some(vec![2.5; 3]), ..Fuel::default() };
    let scaled = Problem {
        body: body([40.0, 80.0, 120.0]),
        start: slower(&given.start),
        end: slower(&given.end),
        duration: Duration::Given(unit * given.seconds()),
        ..given.clone().with_actuation(torques(&CUBE, &limits)).with_objective(Objective::Fuel(priced))
    };
    let (one, other) = (fuel(&given), fuel(&scaled));
    assert!((2.5 * 40.0 / unit * one / other - 1.0).abs() < 1e-8, "{one} {other}");
}

#[test]
fn opposite_thrusters_are_a_torque_of_both_signs_and_more_time_burns_less() {
    let end = at([0.9, -0.4, 0.6], [0.0; 3]);
    let problem = |duration: f64| {
        Problem::minimum_fuel(body([1.0, 2.0, 2.5]), at([0.0; 3], [0.0; 3]), end, duration)
            .with_actuation(torques(&CUBE, &[1.0; 3]))
    };
    let both = fuel(&problem(4.0));
    let pairs = problem(4.0).with_actuation(thrusters(&CUBE, 1.0));
    let plan = solved(&pairs);
    assert!(plan.solution.trajectory.input.iter().all(|input| *input >= 0.0));
    let one_sided = plan.solution.switching.unwrap().continuous_cost;
    assert!((both / one_sided - 1.0).abs() < 1e-10, "{both} {one_sided}");
    // Stretched by s, a motion from rest to rest takes a torque of 1/s²: at least so much is saved.
    let later = fuel(&problem(6.0));
    assert!(later < both * 4.0 / 6.0 * (1.0 + 1e-9), "{later} {both}");
}

#[test]
fn costs_on_aligned_grids_converge_with_the_square_of_the_step() {
    for given in [moving_slowly(), moving_slowly().with_actuation(ball(1.0))] {
        let cost = |steps: usize| solved(&given.clone().with_steps(steps)).solution;
        let [coarse, middle, fine] = [100, 200, 400].map(cost);
        let exact = fine.switching.unwrap().continuous_cost;
        let order = ((coarse.cost - exact) / (middle.cost - exact)).log2();
        assert!((order - 2.0).abs() < 0.15, "{order}");
        let order = ((middle.cost - exact) / (fine.cost - exact)).log2();
        assert!((order - 2.0).abs() < 0.15, "{order}");
    }
}

#[test]
fn a_body_that_is_there_burns_nothing() {
    let there = at([0.3, 0.2, 0.1], [0.0; 3]);
    let problem = Problem::minimum_fuel(body([1.0, 2.0, 2.5]), there, there, 5.0)
        .with_actuation(torques(&CUBE, &[1.0; 3]));
    let found = solved(&problem).solution;
    assert_eq!((found.cost, found.steps), (0.0, problem.steps));
    assert_eq!(found.switching.unwrap().structure, Structure::Rest);
}

#[test]
fn too_short_a_duration_is_answered_by_the_shortest_one() {
    let too_short = moving_slowly().with_duration(1.2);
    let plan = plan(&too_short, &Settings::discrete(), None, &mut Silent).unwrap();
    assert_eq!((plan.status, plan.solution.outcome), (Status::NotConverged, Outcome::Stalled));
    let shortest = solved(&moving()).solution.switching.unwrap().continuous_duration_s;
    let told = plan.solution.shortfall.unwrap().to_string();
    assert!(told.contains(&format!("{shortest:.5}")), "{told}, not {shortest}");
    let longer = plan.solution.longer.expect("a longer duration");
    assert!(longer > shortest);
    solved(&too_short.with_duration(longer));
}

#[test]
fn a_plan_of_another_duration_or_with_a_thruster_that_pulls_is_noticed() {
    let problem = moving_slowly().with_actuation(thrusters(&CUBE, 1.0));
    let found = solved(&problem).solution;
    assert!(verify(&problem, &found.trajectory, 1e-12, None).passed());
    assert!(!verify(&problem.clone().with_duration(5.1), &found.trajectory, 1e-12, None).passed());
    // The same torque by two thrusters that pull.
    let mut pulls = found.trajectory.clone();
    for row in pulls.input.chunks_exact_mut(2) {
        (row[0], row[1]) = (-row[1], -row[0]);
    }
    let judged = verify(&problem, &pulls, 1e-12, None);
    assert!(judged.margins.iter().any(|margin| !margin.holds()));
    assert!(!judged.passed());
}

#[test]
fn what_cannot_be_planned_with_least_fuel_is_refused() {
    let refused = |problem: &Problem| {
        plan(problem, &Settings::discrete(), None, &mut Silent).expect_err("refused").to_string()
    };
    let given = moving_slowly();
    let unequal = Fuel { prices: Some(vec![1.0, 1.0, 2.0]), ..Fuel::default() };
    let unequal = given.clone().with_actuation(ball(1.0)).with_objective(Objective::Fuel(unequal));
    assert!(refused(&unequal).contains("must be one number"));
    // Three thrusters push to one side of a plane.
    let limits = Limits { size: Some(vec![1.0; 3]), one_sided: true, ..Limits::default() };
    let three = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    assert!(
        refused(&given.clone().with_actuation(Actuation::torques(three.clone()))).contains("every direction")
    );
    let prices = |prices: Vec<f64>| {
        let objective = Fuel { prices: Some(prices), ..Fuel::default() };
        refused(&given.clone().with_objective(Objective::Fuel(objective)))
    };
    assert!(prices(vec![1.0; 2]).contains("prices"));
    assert!(prices(vec![1.0, f64::NAN, 1.0]).contains("price"));
    assert!(prices(vec![1.0, 0.0, 1.0]).contains("price"));
    let effort = moving().with_objective(Objective::default()).with_duration(5.0);
    assert!(refused(&effort.with_actuation(Actuation::torques(three))).contains("thrusters"));
}

/// No extremal that is faster than the turn about a principal axis has the symmetry of that turn.
#[test]
fn fuel_has_plans_between_the_shortest_time_and_that_about_the_axis() {
    let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, FRAC_PI_2)));
    let turn = Problem::minimum_time(body([1.0, 1.6, 2.3]), State::at_rest(Matrix3::identity()), end)
        .with_actuation(torques(&CUBE, &[1.0; 3]));
    let quickest = solved(&turn).solution.switching.expect("arcs");
    let axis = quickest.eigenaxis_s.unwrap();
    let fuel = |duration: f64| {
        let given = turn.clone().with_objective(Objective::Fuel(Fuel::default())).with_duration(duration);
        solved(&given).solution.cost
    };
    let mut last = f64::INFINITY;
    for part in [0.3, 0.6, 0.9] {
        let found = fuel(quickest.continuous_duration_s * (1.0 - part) + axis * part);
        assert!(found < last, "{part}: {found} after {last}");
        last = found;
    }
}
