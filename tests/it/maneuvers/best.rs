//! The default answer is the best one: only minima, equal answers to symmetric problems, and the
//! requested homotopy class.

use evidence::Random;
use nalgebra::DMatrix;
use slewkit::maneuver::{Outcome, Path, Problem, SecondOrder, Sense, Settings, Solution, State, Weights};
use slewkit::mechanics::environment::UniformGravity;
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::{PI, TAU};

fn answer(problem: &Problem) -> Solution {
    solve(problem, &Settings::discrete(), None, &mut Silent).unwrap()
}

/// Returns a box with random edges, its principal moments.
fn random_box(random: &mut Random) -> Vector3 {
    let edges: [f64; 3] = std::array::from_fn(|_| random.within(0.2, 2.0));
    let [a, b, c] = edges.map(|edge| edge * edge);
    Vector3::new(b + c, c + a, a + b)
}

fn turn(moments: &Vector3, rotation: &Vector3) -> Problem {
    let body = Body { inertia: Inertia::new(Matrix3::from_diagonal(moments)).unwrap(), mass: None };
    let end = State::at_rest(lie::exp(rotation));
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 4.0).with_steps(60)
}

#[test]
fn boxes_that_turn_about_a_principal_axis_come_to_a_minimum_and_mirror_images_to_the_same() {
    let mut random = Random::new(20);
    let mut bent = 0;
    for case in 0..40 {
        let moments = random_box(&mut random);
        let axis = Vector3::ith(case % 3, 1.0);
        let half_turn = answer(&turn(&moments, &(axis * PI)));
        assert_eq!(half_turn.optimality.second_order(), SecondOrder::Minimum, "{moments}");
        let angle = 175f64.to_radians();
        let costs = [angle, -angle].map(|angle| answer(&turn(&moments, &(axis * angle))).cost);
        assert!((costs[0] - costs[1]).abs() <= 1e-9 * costs[0], "{moments}: {costs:?}");
        // Where the turn about the principal axis is a saddle the answer leaves that axis.
        let straight = answer(&turn(&moments, &(axis * angle)).with_path(Path::AsGiven(axis * angle)));
        bent += usize::from(straight.cost > costs[0] * (1.0 + 1e-6));
    }
    assert!(bent > 0, "no box had a saddle to leave");
}

/// Only one way starts on very few steps; the best way is found by descents on many steps.
#[test]
fn one_way_begun_on_few_steps_is_the_best_way_where_that_goes_so() {
    let mut random = Random::new(21);
    let mut same = 0;
    for _ in 0..40 {
        let moments = random_box(&mut random);
        let axis = Vector3::from_fn(|_, _| random.within(-1.0, 1.0)).normalize();
        let problem = turn(&moments, &(axis * random.within(0.01, 2.5))).with_steps(100);
        let (best, one) = (answer(&problem), answer(&problem.with_path(Path::Shortest)));
        assert_eq!((one.outcome, one.sense), (Outcome::Converged, Sense::Short));
        if best.sense == Sense::Short {
            same += 1;
            assert!(
                (one.cost - best.cost).abs() <= 1e-9 * best.cost,
                "{moments}: {} {}",
                one.cost,
                best.cost
            );
            assert!(one.ladder.iter().any(|rung| rung.steps < 16), "{:?}", one.ladder);
        }
    }
    assert!(same > 30, "{same}");
}

/// A maneuver from rest to rest on few steps is searched on fewer still, and one on many steps on
/// more: both give one plan.
#[test]
fn the_best_way_of_a_few_steps_is_that_of_many() {
    let mut random = Random::new(22);
    for case in 0..40 {
        let axis = Vector3::from_fn(|_, _| random.within(-1.0, 1.0)).normalize();
        let angle = if case % 4 == 0 { PI } else { random.within(0.01, PI) };
        let problem = turn(&random_box(&mut random), &(axis * angle));
        let (few, many) = (answer(&problem.clone().with_steps(399)), answer(&problem.with_steps(400)));
        assert_eq!((few.outcome, many.outcome), (Outcome::Converged, Outcome::Converged));
        let least = |solution: &Solution| solution.ladder.iter().map(|rung| rung.steps).min();
        assert!(least(&few) < least(&many), "{:?} {:?}", least(&few), least(&many));
        let apart = few.cost / many.cost - 1.0;
        assert!(apart.abs() < 1e-5, "case {case}: {} {}", few.cost, many.cost);
    }
}

/// If the second-order test is off, the search finds an equal extremal, also a saddle, and claims
/// no result of the test.
#[test]
fn what_is_not_tested_is_the_same_extremal_and_says_so() {
    let untested = Settings { test_second_order: false, ..Settings::discrete() };
    let moments = Vector3::new(1.0, 2.0, 3.0);
    let straight = Vector3::y() * PI;
    let oblique = Vector3::new(0.4, -0.8, 0.3);
    // The test runs while the trajectory is recorded if the steps are many.
    for (rotation, path, steps) in [
        (oblique, Path::Shortest, 60),
        (oblique, Path::Shortest, 500),
        (straight, Path::AsGiven(straight), 60),
    ] {
        let problem = turn(&moments, &rotation).with_path(path).with_steps(steps);
        let tested = answer(&problem);
        let bare = solve(&problem, &untested, None, &mut Silent).unwrap();
        assert_eq!(bare.outcome, Outcome::Converged);
        assert_eq!((bare.cost, &bare.trajectory), (tested.cost, &tested.trajectory));
        assert_ne!(tested.optimality.second_order(), SecondOrder::NotTested);
        assert_eq!(bare.optimality.second_order(), SecondOrder::NotTested);
        assert!(bare.optimality.stationarity.is_nan() && bare.optimality.conjugate_points.is_none());
        assert!(bare.rivals.iter().all(|rival| rival.conjugate_points.is_none()));
    }
}

#[test]
fn a_rotation_that_is_given_is_taken_in_its_class_or_not_called_solved() {
    let mut random = Random::new(21);
    let (cases, mut solved) = (40, 0);
    for _ in 0..cases {
        let axis = Vector3::from_fn(|_, _| random.uniform()).normalize();
        let rotation = axis * random.within(200.0, 700.0).to_radians();
        let mut problem = turn(&random_box(&mut random), &rotation).with_path(Path::AsGiven(rotation));
        problem.start.angular_velocity = Vector3::from_fn(|_, _| 0.1 * random.uniform());
        let solution = answer(&problem);
        if solution.outcome != Outcome::Converged {
            assert!(solution.shortfall.is_some() || solution.trajectory.time.is_empty());
            continue;
        }
        solved += 1;
        // A rotation by less than a turn beyond a whole number of turns: odd numbers of half turns
        // change the class.
        let halves = (rotation.norm() / PI).floor() as i64;
        let sense = if (halves + 1) / 2 % 2 == 0 { Sense::Short } else { Sense::Long };
        assert_eq!(solution.sense, sense, "{:.0}°", rotation.norm().to_degrees());
    }
    assert!(solved * 100 >= cases * 95, "{solved} of {cases}");
}

#[test]
fn a_saddle_on_the_asked_way_is_left_for_a_minimum_of_that_way() {
    // The direct turn is a saddle of the long way of a large turn; the minimum has the same
    // homotopy class.
    let moments = Vector3::new(1.0, 2.0, 2.6);
    let problem = turn(&moments, &(Vector3::y() * (TAU - 3.6))).with_path(Path::Long);
    let solution = answer(&problem);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_eq!(solution.sense, Sense::Long);
    assert_eq!(solution.optimality.second_order(), SecondOrder::Minimum);
}

/// An extremal of the requested class is preferred to an extremal of the other class, however much
/// nearer its ∫Ω is to the rotation.
#[test]
fn the_class_of_a_given_rotation_comes_before_its_length() {
    let asked = Vector3::new(-2.889, -9.099, -5.05);
    let inertia = Inertia::new(symmetric([1.135, -0.02, 0.125, 1.153, 0.142, 0.713])).unwrap();
    let end = State::at_rest(lie::exp(&asked));
    let body = Body { inertia, mass: None };
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 1.0);
    let solution = answer(&problem.with_path(Path::AsGiven(asked)).with_steps(100));
    // 619° is nearer to two whole turns than to one.
    assert_eq!((solution.outcome, solution.sense), (Outcome::Converged, Sense::Short));
}

/// Between high rates one start in thirty may lead to the best way.
#[test]
fn between_high_rates_the_answer_is_as_cheap_as_any_known() {
    let inertia = Inertia::new(symmetric([1.365, 0.116, 0.086, 0.668, -0.54, 0.967])).unwrap();
    let start = State::attitude(Matrix3::identity(), Vector3::new(-2.424, -1.93, -0.569));
    let attitude = lie::exp(&Vector3::new(-0.982, -1.025, -1.091));
    let end = State::attitude(attitude, Vector3::new(4.33, -1.037, 0.639));
    let problem = Problem::attitude(Body { inertia, mass: None }, start, end, 1.0).with_steps(100);
    let (solution, known) = (answer(&problem), 112.559_788_075);
    assert!(solution.cost <= known * (1.0 + 1e-6), "{}", solution.cost);
}

/// A stiff pendulum, two turns and a third: the grid of the search follows how fast the field
/// swings the body.
#[test]
fn in_a_stiff_field_the_answer_does_not_depend_on_the_number_of_steps() {
    let inertia = Inertia::new(symmetric([1.117, -0.257, 0.254, 0.764, 0.041, 1.119])).unwrap();
    let arm = Vector3::new(-0.10966, -0.144029, -0.239228);
    let field = UniformGravity::new(1.0, 260.355, Vector3::z(), arm).unwrap();
    let [start, end] =
        [([1.497, 1.61, 1.387], [0.999, 0.805, -0.691]), ([0.349, -0.731, 1.861], [0.488, 0.162, 0.235])]
            .map(|(rotation, rate)| State::attitude(lie::exp(&Vector3::from(rotation)), rate.into()));
    let problem = Problem::attitude(Body { inertia, mass: None }, start, end, 1.0).with_environment(field);
    let costs = [100, 200, 400].map(|steps| answer(&problem.clone().with_steps(steps)).cost);
    let (first, second) = (costs[1] - costs[0], costs[2] - costs[1]);
    assert!((second / first - 0.25).abs() < 0.01, "{costs:?}");
}

/// Returns the rows of a symmetric matrix.
fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Matrix3 {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Returns a maneuver in unit time with torques about two axes alone, from rest to rest.
fn two_torques(inertia: [f64; 6], axes: [[f64; 3]; 2], rotation: [f64; 3]) -> Problem {
    let body = Body { inertia: Inertia::new(symmetric(inertia)).unwrap(), mass: None };
    let end = State::at_rest(lie::exp(&Vector3::from(rotation)));
    let set = ActuatorSet::new(axes.map(Vector3::from).to_vec(), AxisFrame::Body).unwrap();
    let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 1.0);
    problem.with_actuation(Actuation::torques(set)).with_steps(100)
}

/// Returns a maneuver in unit time with weights 1, `middle` and 1000 about the axes that `axes`
/// turns the body's into.
fn uneven(
    inertia: [f64; 6],
    (axes, middle): ([f64; 3], f64),
    rotation: [f64; 3],
    [before, after]: [[f64; 3]; 2],
) -> Problem {
    let body = Body { inertia: Inertia::new(symmetric(inertia)).unwrap(), mass: None };
    let axes = lie::exp(&Vector3::from(axes));
    let w = axes * Matrix3::from_diagonal(&Vector3::new(1.0, middle, 1000.0)) * axes.transpose();
    let weight = DMatrix::from_fn(3, 3, |row, column| 0.5 * (w[(row, column)] + w[(column, row)]));
    let start = State::attitude(Matrix3::identity(), before.into());
    let end = State::attitude(lie::exp(&Vector3::from(rotation)), after.into());
    Problem::attitude(body, start, end, 1.0).with_objective(Weights::of_torques(weight)).with_steps(100)
}

/// Costs that searches of two hundred starts and more have met at most (`search = "thorough"`).
#[test]
fn with_two_torques_or_uneven_weights_the_answer_is_a_minimum_and_as_cheap_as_any_known() {
    let cases = [
        // A plan that is found on few steps has to be found again on many, for which λ₋₁ no longer
        // leads to it.
        (
            two_torques(
                [1.386, 0.151, -0.044, 0.907, 0.038, 0.707],
                [[-0.676, -0.55, -0.491], [-0.733, -0.31, -0.605]],
                [1.595, -0.889, -1.248],
            ),
            1_314.958_599_540,
        ),
        // The cheapest with a little authority about the third axis is not the cheapest without.
        (
            two_torques(
                [0.582, -0.311, 0.304, 1.192, 0.135, 1.226],
                [[0.587, -0.809, -0.022], [0.782, -0.448, 0.432]],
                [-0.371, 0.932, 1.436],
            ),
            206.100_394_077_7,
        ),
        // Newton on all nodes stalls where the last of the authority is taken away.
        (
            two_torques(
                [1.309, 0.003, -0.109, 1.333, 0.029, 0.359],
                [[-0.169, -0.976, 0.137], [-0.183, 0.98, -0.082]],
                [1.771, -1.015, -0.569],
            ),
            849.786_910_622,
        ),
        // An extremal whose costates round-off carries away before the end: only its nodes are a
        // plan.
        (
            uneven(
                [0.901, -0.323, 0.093, 1.247, 0.035, 0.851],
                ([-1.88, -1.05, 2.102], 464.0),
                [2.296, -1.327, 0.508],
                [[0.197, -0.931, -0.565], [0.716, -2.16, -1.313]],
            ),
            2_948.710_169_017,
        ),
        // Even weights lead to a valley that is missed from afar.
        (
            uneven(
                [1.142, -0.262, -0.04, 1.037, -0.24, 0.821],
                ([1.002, 0.967, -2.763], 474.7),
                [0.139, -2.778, -1.243],
                [[-2.141, -2.863, 2.688], [1.069, -1.652, -1.421]],
            ),
            3_838.838_131_220,
        ),
    ];
    for (case, (problem, known)) in cases.iter().enumerate() {
        let solution = answer(problem);
        assert_eq!(solution.outcome, Outcome::Converged, "case {case}");
        assert_eq!(solution.optimality.second_order(), SecondOrder::Minimum, "case {case}");
        assert!(solution.cost <= known * (1.0 + 1e-6), "case {case}: {} and {known}", solution.cost);
    }
}
