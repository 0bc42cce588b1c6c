//! Minimum time through the public interface: laws that every optimum obeys, and honesty.

use slewkit::maneuver::problem::{Path, Problem, State};
use slewkit::maneuver::{Settings, Structure};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::verify::verify;
use slewkit::{Matrix3, Vector3, lie};

pub fn torques(axes: &[[f64; 3]], limits: &[f64]) -> Actuation {
    let axes = axes.iter().map(|axis| Vector3::from(*axis)).collect();
    let limits = Limits { size: Some(limits.to_vec()), ..Limits::default() };
    Actuation::torques(ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap())
}

pub const CUBE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub fn body(moments: [f64; 3]) -> Body {
    Body { inertia: Inertia::diagonal(moments.into()).unwrap(), mass: None }
}

pub fn at(turn: [f64; 3], rate: [f64; 3]) -> State {
    State::attitude(lie::exp(&turn.into()), rate.into())
}

pub fn solved(problem: &Problem) -> Plan {
    let found = plan(problem, &Settings::discrete(), None, &mut Silent).unwrap();
    let failed = found.verification.iter().flat_map(|found| &found.checks).filter(|check| !check.passed);
    assert_eq!(
        found.status,
        Status::Solved,
        "{:?} {:?}",
        found.solution.shortfall,
        failed.collect::<Vec<_>>()
    );
    found
}

fn duration(problem: &Problem) -> f64 {
    solved(problem).solution.switching.expect("arcs").continuous_duration_s
}

/// Returns a maneuver of an asymmetric body between moving states.
pub fn moving() -> Problem {
    let (start, end) = (at([0.2, 0.1, -0.3], [0.03, -0.02, 0.04]), at([0.9, -0.4, 0.6], [-0.02, 0.05, 0.01]));
    Problem::minimum_time(body([1.0, 2.0, 3.0]), start, end).with_actuation(torques(&CUBE, &[1.0, 1.2, 0.8]))
}

#[test]
fn a_maneuver_takes_as_long_backwards() {
    let forward = moving();
    let reversed = |state: &State| State { angular_velocity: -state.angular_velocity, ..*state };
    let backward =
        Problem { start: reversed(&forward.end), end: reversed(&forward.start), ..forward.clone() };
    let (there, back) = (duration(&forward), duration(&backward));
    assert!((there / back - 1.0).abs() < 1e-9, "{there} {back}");
}

/// A tiny turn, the long way round. The whole turn about the axis of the least moment takes
/// `2√(2πJ/U)`, whatever the axis of the tiny turn, which itself takes hardly any time.
#[test]
fn the_long_way_of_hardly_a_turn_takes_no_longer_than_a_whole_turn_about_the_quickest_axis() {
    let (least, small) = (1.0, 1e-4);
    let whole = 2.0 * (std::f64::consts::TAU * least).sqrt();
    for (axis, vector) in CUBE.iter().enumerate() {
        let end = at(vector.map(|part| small * part), [0.0; 3]);
        let problem = Problem::minimum_time(body([2.0, 2.9, least]), at([0.0; 3], [0.0; 3]), end)
            .with_actuation(torques(&CUBE, &[1.0; 3]));
        let long = duration(&problem.clone().with_path(Path::Long));
        // The same as one turn as written, about the same axis backwards.
        let turn = Vector3::from(*vector) * (small - std::f64::consts::TAU);
        let given = duration(&problem.with_path(Path::AsGiven(turn)));
        for found in [long, given] {
            assert!(found <= whole * (1.0 + 10.0 * small), "about {axis}: {found} instead of {whole}");
        }
    }
}

#[test]
fn no_turn_as_written_takes_no_time_and_no_fuel() {
    let still = at([0.2, 0.1, -0.3], [0.0; 3]);
    let sought = Problem::minimum_time(body([1.0, 2.0, 3.0]), still, still)
        .with_actuation(torques(&CUBE, &[1.0; 3]))
        .with_path(Path::AsGiven(Vector3::zeros()));
    let given = Problem::minimum_fuel(sought.body.clone(), still, still, 5.0)
        .with_actuation(sought.actuation.clone())
        .with_path(Path::AsGiven(Vector3::zeros()))
        .with_steps(50);
    for (problem, steps) in [(sought, 0), (given, 50)] {
        let plan = solved(&problem).solution;
        let found = (plan.steps, plan.cost, plan.switching.map(|found| found.structure));
        assert_eq!(found, (steps, 0.0, Some(Structure::Rest)));
    }
}

#[test]
fn names_of_axes_do_not_matter() {
    let given = moving();
    let p = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    let renamed =
        |state: &State| State::attitude(p * state.attitude * p.transpose(), p * state.angular_velocity);
    let other = Problem::minimum_time(body([2.0, 3.0, 1.0]), renamed(&given.start), renamed(&given.end))
        .with_actuation(torques(&CUBE, &[1.2, 0.8, 1.0]));
    let (one, other) = (duration(&given), duration(&other));
    assert!((one / other - 1.0).abs() < 1e-9, "{one} {other}");
}

#[test]
fn time_goes_with_the_root_of_inertia_over_torque() {
    let given = moving();
    let unit = (40.0_f64 / 0.5).sqrt();
    let slower = |state: &State| State { angular_velocity: state.angular_velocity / unit, ..*state };
    let scaled = Problem {
        body: body([40.0, 80.0, 120.0]),
        start: slower(&given.start),
        end: slower(&given.end),
        ..given.clone().with_actuation(torques(&CUBE, &[0.5, 0.6, 0.4]))
    };
    let (one, other) = (duration(&given), duration(&scaled));
    assert!((unit * one / other - 1.0).abs() < 1e-9, "{one} {other}");
}

#[test]
fn the_torque_of_a_ball_takes_longer_than_that_of_its_cube_and_turns_a_sphere_about_the_axis() {
    let norm = Limits { norm: Some(1.0), ..Limits::default() };
    let ball = Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(norm).unwrap());
    let end = at([0.0, 0.0, std::f64::consts::FRAC_PI_2], [0.0; 3]);
    let problem = Problem::minimum_time(body([1.0; 3]), at([0.0; 3], [0.0; 3]), end);
    let by_norm = solved(&problem.clone().with_actuation(ball)).solution.switching.unwrap();
    assert_eq!(by_norm.structure, Structure::Norm);
    // Closed form: 2 √(θ J / U).
    let closed = 2.0 * std::f64::consts::FRAC_PI_2.sqrt();
    assert!((by_norm.eigenaxis_s.unwrap() - closed).abs() < 1e-9);
    assert!(by_norm.continuous_duration_s >= closed && by_norm.continuous_duration_s < closed * (1.0 + 1e-4));
    let cube = duration(&problem.clone().with_actuation(torques(&CUBE, &[1.0; 3])));
    let inscribed = duration(&problem.with_actuation(torques(&CUBE, &[3.0_f64.sqrt().recip(); 3])));
    assert!(cube < closed && closed < inscribed);
}

#[test]
fn redundant_canted_torques_of_a_full_inertia_are_planned_and_one_more_makes_it_no_longer() {
    let inertia = Inertia::new(Matrix3::new(12.0, 0.4, -0.2, 0.4, 10.0, 0.3, -0.2, 0.3, 8.0)).unwrap();
    let axes = [[0.9, 0.3, 0.0], [-0.2, 0.9, 0.3], [0.1, -0.3, 0.9], [0.5, 0.5, 0.7]];
    let problem = Problem::minimum_time(
        Body { inertia, mass: None },
        at([0.0; 3], [0.0; 3]),
        at([0.7, -0.9, 0.5], [0.0; 3]),
    );
    let three = duration(&problem.clone().with_actuation(torques(&axes[..3], &[0.2, 0.1, 0.15])));
    let four = duration(&problem.with_actuation(torques(&axes, &[0.2, 0.1, 0.15, 0.1])));
    assert!(four < three, "{four} {three}");
}

/// A cube turns about each of its axes in the published time (Bilimoria and Wie 1993).
#[test]
fn a_cube_turns_alike_about_all_its_axes() {
    for (degrees, published) in [(180.0_f64, 3.2431), (135.0, 2.8845), (90.0, 2.4211)] {
        for axis in CUBE {
            let end = at((Vector3::from(axis) * degrees.to_radians()).into(), [0.0; 3]);
            let problem = Problem::minimum_time(body([1.0; 3]), State::at_rest(Matrix3::identity()), end);
            let found = duration(&problem.with_actuation(torques(&CUBE, &[1.0; 3])));
            assert!((found - published).abs() < 5.1e-5, "{degrees} {axis:?} {found}");
        }
    }
}

/// Boxes turn about an axis with unequal limits. The time is equal in all body axes in which the
/// maneuver is written, and shorter than a turn about that axis.
#[test]
fn the_time_of_a_box_is_the_same_in_all_axes() {
    let other = lie::exp(&Vector3::new(0.3, -0.5, 0.7));
    let half = std::f64::consts::PI;
    for (moments, limits, turn, at_most) in [
        ([1.0, 2.0, 2.5], [1.0, 0.5, 2.0], Vector3::new(1.0, 1.0, 0.0).normalize() * half, 3.5001),
        ([5.0, 5.0, 2.0], [1.0, 0.5, 2.0], Vector3::y() * (half * 2.0 / 3.0), 6.502),
        ([1.0, 1.0, 1.0], [1.0, 2.0, 4.0], Vector3::x() * half, 2.4662),
        ([1.0, 1.6, 2.3], [1.0, 1.0, 1.0], Vector3::z() * half, 4.1822),
    ] {
        let of = |axes: &Matrix3| {
            let turned = |attitude: Matrix3| State::at_rest(axes * attitude * axes.transpose());
            let inertia = axes * Matrix3::from_diagonal(&moments.into()) * axes.transpose();
            let inertia = Inertia::new(0.5 * (inertia + inertia.transpose())).unwrap();
            let body = Body { inertia, mass: None };
            let inputs: Vec<[f64; 3]> = (0..3).map(|input| axes.column(input).into_owned().into()).collect();
            Problem::minimum_time(body, turned(Matrix3::identity()), turned(lie::exp(&turn)))
                .with_actuation(torques(&inputs, &limits))
        };
        let found = solved(&of(&Matrix3::identity())).solution.switching.expect("arcs");
        let there = duration(&of(&other));
        let here = found.continuous_duration_s;
        assert!((here / there - 1.0).abs() < 1e-6, "{moments:?} {limits:?}: {here} {there}");
        assert!(here < at_most && here < found.eigenaxis_s.unwrap(), "{moments:?} {limits:?}: {here}");
    }
}

#[test]
fn a_body_that_is_there_needs_no_time() {
    let there = at([0.3, 0.2, 0.1], [0.0; 3]);
    let problem =
        Problem::minimum_time(body([1.0, 2.0, 3.0]), there, there).with_actuation(torques(&CUBE, &[1.0; 3]));
    let found = solved(&problem).solution;
    assert_eq!((found.cost, found.steps), (0.0, 0));
    assert_eq!(found.switching.unwrap().structure, Structure::Rest);
}

#[test]
fn a_switch_that_is_moved_is_noticed() {
    let problem = moving();
    let found = solved(&problem);
    let problem = problem.with_steps(found.solution.steps);
    let mut moved = found.solution.trajectory.clone();
    let rows = moved.torque.len();
    let switch = (1..rows).find(|row| moved.inputs(*row) != moved.inputs(row - 1)).expect("a switch");
    let count = moved.input_count;
    moved.input.copy_within((switch - 1) * count..switch * count, switch * count);
    moved.torque[switch] = moved.torque[switch - 1];
    assert!(verify(&problem, &found.solution.trajectory, 1e-12, None).passed());
    assert!(!verify(&problem, &moved, 1e-12, None).passed());
    let mut late = found.solution.trajectory.clone();
    late.time[switch] += 1e-6;
    assert!(!verify(&problem, &late, 1e-12, None).passed());
    let mut back = found.solution.trajectory;
    back.time.swap(3, 4);
    assert!(!verify(&problem, &back, 1e-12, None).passed());
}

#[test]
fn equal_problems_have_equal_plans() {
    let [one, other] = [(); 2].map(|()| solved(&moving()).solution);
    assert_eq!(one.trajectory, other.trajectory);
    assert_eq!(one.switching, other.switching);
}

#[test]
fn the_way_that_is_asked_for_is_gone() {
    let end = at([0.0, 0.0, 3.0], [0.0; 3]);
    let problem = Problem::minimum_time(body([1.0, 2.0, 3.0]), at([0.0; 3], [0.0; 3]), end)
        .with_actuation(torques(&CUBE, &[1.0; 3]));
    let short = duration(&problem.clone().with_path(Path::Shortest));
    let long = duration(&problem.clone().with_path(Path::Long));
    assert!(short < long, "{short} {long}");
    assert!((duration(&problem) - short).abs() < 1e-9);
}

#[test]
fn what_cannot_be_planned_in_minimum_time_is_refused() {
    let problem = moving();
    let refused = |problem: &Problem, settings: &Settings| {
        plan(problem, settings, None, &mut Silent).expect_err("refused").to_string()
    };
    let settings = Settings::discrete();
    let unlimited =
        problem.clone().with_actuation(Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body)));
    assert!(refused(&unlimited, &settings).contains("need a limit"));
    let two = problem.clone().with_actuation(torques(&CUBE[..2], &[1.0; 2]));
    assert!(refused(&two, &settings).contains("every direction"));
}

/// The best durations that were published, in three digits: `evidence/public_set/ORIGIN.md`; all
/// 1500 by `cargo run --release -p evidence -- minimum_time`. The first ones of each kind, then
/// those with singular arcs which smoothing leaves longer, of one of which the branch ends before
/// smoothing does.
#[test]
fn published_cases_are_solved_and_not_longer() {
    let kinds: [(&str, [f64; 3], &[usize]); 3] = [
        ("rest", [1.0; 3], &[0, 1, 2, 45, 232]),
        ("moving_ends", [1.0; 3], &[0, 1, 2, 3]),
        ("asymmetric", [1.0, 2.0, 3.0], &[0, 1, 2, 175]),
    ];
    for (name, moments, cases) in kinds {
        let path = format!("{}/../../evidence/public_set/{name}.csv", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let lines: Vec<&str> = text.lines().skip(1).collect();
        for case in cases {
            let line = lines[*case];
            let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
            let [start, end] = [0, 7].map(|at| {
                let quaternion = [numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]];
                let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(&quaternion));
                State::attitude(attitude, Vector3::from_row_slice(&numbers[at + 4..at + 7]))
            });
            let problem =
                Problem::minimum_time(body(moments), start, end).with_actuation(torques(&CUBE, &[1.0; 3]));
            let switching = solved(&problem).solution.switching.unwrap();
            let longer = switching.continuous_duration_s - numbers[14];
            assert!(longer < 5e-4, "{name}, case {case}: {longer:e} longer than published");
            assert!(switching.gap < 1e-5, "{name}, case {case}: {:e} to be gained", switching.gap);
        }
    }
}

/// About one axis the strong side accelerates and the weak one brakes: `T² = 2jθ (1/U + 1/u)`.
/// Turning about other axes as well can only be quicker.
#[test]
fn thrusters_that_push_unequally_turn_a_body() {
    let (strong, weak, angle) = (3.0, 0.15, 1.0);
    let axes = CUBE.iter().flat_map(|axis| [Vector3::from(*axis), -Vector3::from(*axis)]).collect();
    let limits = Limits { size: Some([strong, weak].repeat(3)), one_sided: true, ..Limits::default() };
    let thrusters = ActuatorSet::new(axes, AxisFrame::Body).unwrap().with_limits(limits).unwrap();
    let problem =
        Problem::minimum_time(body([1.0, 1.5, 2.0]), at([0.0; 3], [0.0; 3]), at([0.0, 0.0, angle], [0.0; 3]))
            .with_actuation(Actuation::torques(thrusters));
    let about_its_axis = (2.0 * 2.0 * angle * (1.0 / strong + 1.0 / weak)).sqrt();
    let shortest = duration(&problem);
    assert!(
        shortest < about_its_axis * (1.0 + 1e-9) && shortest > 0.3 * about_its_axis,
        "{shortest} {about_its_axis}"
    );
}
