//! Margins against dense sampling, closed forms and independent arithmetic.

use crate::evidence::{Random, Turning};
use slewkit::maneuver::constraint::{
    Arc, Constraint, Direction, Extreme, Pointing, Rule, Side, Target, angle_between,
};
use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::maneuver::solution::Trajectory;
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::verify::{Margin, margins, replay, verify, worst_violation};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];
const EXTREMES: [Extreme; 2] = [Extreme::Nearest, Extreme::Farthest];

/// Returns the extremum of `angle` over [0, 1]: dense sampling, and golden sections around every
/// sample that is better than its neighbours.
fn sampled(angle: impl Fn(f64) -> f64, which: Extreme, samples: usize) -> f64 {
    let sign = if which == Extreme::Nearest { 1.0 } else { -1.0 };
    let value = |part: f64| sign * angle(part);
    let values: Vec<f64> = (0..=samples).map(|index| value(index as f64 / samples as f64)).collect();
    let mut best = f64::INFINITY;
    for index in 0..=samples {
        let (before, after) = (index.saturating_sub(1), (index + 1).min(samples));
        if values[index] > values[before].min(values[after]) {
            continue;
        }
        let (mut low, mut high) = (before as f64 / samples as f64, after as f64 / samples as f64);
        for _ in 0..80 {
            let part = (high - low) * 0.381_966_011_250_105;
            let (a, b) = (low + part, high - part);
            if value(a) < value(b) { high = b } else { low = a }
        }
        best = best.min(value(0.5 * (low + high))).min(values[index]);
    }
    sign * best
}

/// Arcs of up to 85°, and of up to two turns; boresights near the axis, near the direction,
/// anywhere.
#[test]
fn extremum_on_an_arc_is_that_of_dense_sampling() {
    let mut random = Random::new(11);
    let (mut inside, mut ends) = (0, 0);
    for case in 0..3000 {
        let size = if case % 7 == 0 { 4.0 * PI } else { 1.48 };
        let arc = Arc {
            start: random.rotation(),
            turn: size * random.uniform().abs().powi(1 + case % 4) * random.direction(),
        };
        let boresight = match case % 5 {
            0 => (arc.turn.normalize() + 1e-3 * random.vector()).normalize(),
            _ => random.direction(),
        };
        let direction = match case % 3 {
            0 => (arc.attitude(random.uniform().abs()) * boresight + 1e-4 * random.vector()).normalize(),
            _ => random.direction(),
        };
        let target = Target::fixed(direction);
        for which in EXTREMES {
            let found = arc.extreme(&boresight, &target, which);
            let expected = sampled(|part| arc.angle(&boresight, &target, part), which, 400);
            assert!((found.angle - expected).abs() < 1e-10, "{case} {which:?}: {found:?} {expected}");
            assert!((found.angle - arc.angle(&boresight, &target, found.part)).abs() < 1e-15);
            if found.part > 0.0 && found.part < 1.0 { inside += 1 } else { ends += 1 }
        }
    }
    assert!(inside > 1000 && ends > 1000, "{inside} inside, {ends} at the ends");
}

/// Directions that turn with a frame, against sampling; and in the same or the opposite sense as
/// the body about one axis, where the relative motion is again one rotation with its closed form.
#[test]
fn extremum_on_an_arc_is_exact_for_turning_directions() {
    let mut random = Random::new(12);
    for case in 0..600 {
        let mut arc = Arc { start: random.rotation(), turn: 1.4 * random.uniform() * random.direction() };
        let boresight = random.direction();
        let axis = random.direction();
        let mut target =
            Target { start: random.direction(), turn: random.uniform() * axis, radius: 0.0, growth: 0.0 };
        if case % 3 == 0 {
            target.start = (arc.attitude(0.4) * boresight + 1e-3 * random.vector()).normalize();
        }
        for which in EXTREMES {
            let found = arc.extreme(&boresight, &target, which);
            let expected = sampled(|part| arc.angle(&boresight, &target, part), which, 400);
            assert!((found.angle - expected).abs() < 1e-10, "{case} {which:?}: {found:?} {expected}");
        }
        // About one axis: exp(−τ s a) A exp(τ r Aᵀa) = A exp(τ (r − s) Aᵀa).
        let (body, frame) = (random.uniform(), random.uniform());
        arc.turn = body * arc.start.tr_mul(&axis);
        target.turn = frame * axis;
        let relative = Arc { start: arc.start, turn: (body - frame) * arc.start.tr_mul(&axis) };
        let fixed = Target::fixed(target.start);
        for which in EXTREMES {
            let a = arc.extreme(&boresight, &target, which).angle;
            let b = relative.extreme(&boresight, &fixed, which).angle;
            assert!((a - b).abs() < 1e-12, "{case} {which:?}: {a} {b}");
        }
    }
}

#[test]
fn extremum_on_an_arc_at_rest_without_numbers_or_too_fast() {
    let (x, z) = (Vector3::x(), Vector3::z());
    let fixed = Target::fixed(z);
    let rest = Arc { start: Matrix3::identity(), turn: Vector3::zeros() };
    for which in EXTREMES {
        assert_eq!(rest.extreme(&x, &fixed, which).angle, PI / 2.0);
        assert_eq!(rest.extreme(&z, &fixed, which).angle, 0.0);
        let lost = Arc { turn: Vector3::new(0.1, f64::NAN, 0.0), ..rest };
        assert!(lost.extreme(&x, &fixed, which).angle.is_nan());
        for turn in [1e9, f64::INFINITY, f64::NAN] {
            let fast = Target { start: z, turn: turn * x, radius: 0.0, growth: 0.0 };
            assert!(rest.extreme(&x, &fast, which).angle.is_nan(), "{turn}");
        }
    }
}

// ---- margins of whole plans
// -------------------------------------------------------------------------

fn full_inertia() -> Matrix3 {
    Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)
}

fn tumbling(scheme: Scheme) -> Problem {
    let body = Body { inertia: Inertia::new(full_inertia()).unwrap(), mass: None };
    let start = State::attitude(lie::exp(&Vector3::new(0.4, -0.3, 0.5)), Vector3::new(0.3, -0.4, 0.6));
    Problem::attitude(body, start, start, 4.0).with_steps(30).with_scheme(scheme)
}

fn smooth_inputs(problem: &Problem) -> Vec<f64> {
    let rows = problem.scheme.input_rows(problem.steps);
    let count = problem.actuation.count();
    let input = |row: usize, i: usize| {
        let t = (row + problem.steps + 1 - rows) as f64 / problem.steps as f64;
        (1.0 + i as f64 + 3.0 * t).sin() * (2.0 - i as f64 * t)
    };
    (0..rows).flat_map(|row| (0..count).map(move |i| input(row, i))).collect()
}

fn cone(side: Side, half_angle: f64, margin: f64, turns_with_frame: bool) -> Constraint {
    let directions = [Vector3::new(0.6, -0.64, 0.48), Vector3::new(0.0, 0.28, 0.96)];
    let direction = if turns_with_frame { Direction::InFrame } else { Direction::Fixed };
    let pointing = Pointing {
        side,
        boresights: vec![Vector3::x(), Vector3::new(0.0, 0.8, 0.6), Vector3::z()],
        directions: directions.map(direction).to_vec(),
        half_angle,
        margin,
        during: Default::default(),
    };
    Constraint { name: format!("{side:?} {turns_with_frame}"), rule: Rule::Pointing(pointing) }
}

fn attitudes(plan: &Trajectory) -> Vec<Matrix3> {
    plan.quaternion.iter().map(lie::rotation_from_quaternion).collect()
}

fn find<'a>(found: &'a [Margin], name: &str) -> &'a Margin {
    found.iter().find(|margin| margin.name == name).unwrap_or_else(|| panic!("no {name}: {found:#?}"))
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + b.abs())
}

#[test]
fn input_margins_are_those_of_the_rows() {
    for scheme in SCHEMES {
        let axes = vec![Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(1.0, 1.0, 0.5)];
        let limits = Limits {
            size: Some(vec![3.0, 1.9, 2.0, 2.5]),
            norm: Some(2.6),
            rate: Some(vec![1.5, 2.0, 1.2, 9.0]),
            ..Limits::default()
        };
        let channel = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
        let channel = channel.with_limits(limits.clone()).unwrap();
        let problem = tumbling(scheme).with_actuation(Actuation::torques(channel.clone()));
        let inputs = smooth_inputs(&problem);
        let found = margins(&problem, &inputs).unwrap();
        assert_eq!(found.len(), 3);
        let rows: Vec<&[f64]> = inputs.chunks(4).collect();
        let smallest = |values: Vec<f64>| values.into_iter().fold(f64::INFINITY, f64::min);
        let each = |of: &dyn Fn(usize) -> Vec<f64>, limits: &[f64]| {
            smallest(
                (0..4)
                    .flat_map(|i| of(i).into_iter().map(move |u| (limits[i] - u.abs()) / limits[i]))
                    .collect(),
            )
        };
        let size = each(&|i| rows.iter().map(|row| row[i]).collect(), limits.size.as_ref().unwrap());
        let slope = each(
            &|i| rows.windows(2).map(|pair| (pair[1][i] - pair[0][i]) / problem.step()).collect(),
            limits.rate.as_ref().unwrap(),
        );
        let norm = smallest(rows.iter().map(|row| 2.6 - channel.output(row).norm()).collect());
        assert!(close(find(&found, "torque limit").scaled, size), "{found:#?}");
        assert!(close(find(&found, "torque rate limit").scaled, slope), "{found:#?}");
        assert!(close(find(&found, "torque norm limit").margin, norm), "{found:#?}");
        assert!(close(find(&found, "torque norm limit").scaled, norm / 2.6), "{found:#?}");
        // The margin names the input and the time: its figure is the figure of that row.
        let worst = find(&found, "torque limit");
        let input: usize = worst.at.strip_prefix("input ").unwrap().parse().unwrap();
        let row = (worst.time_s / problem.step()).round() as usize + rows.len() - problem.steps - 1;
        let limit = limits.size.as_ref().unwrap()[input - 1];
        assert!(close(worst.margin, limit - rows[row][input - 1].abs()), "{worst:?}");
        assert_eq!((worst.unit.as_str(), find(&found, "torque rate limit").unit.as_str()), ("N·m", "N·m/s"));
    }
}

#[test]
fn force_margins_are_those_of_the_forces() {
    let mut start = State::at_rest(Matrix3::identity());
    start.position = Vector3::x();
    let body = Body { inertia: Inertia::new(full_inertia()).unwrap(), mass: Some(2.0) };
    let mut problem = Problem::rigid_body(body, start, start, 2.0).with_steps(20);
    let limits =
        Limits { size: Some(vec![3.0; 3]), norm: Some(4.0), rate: Some(vec![9.0; 3]), ..Limits::default() };
    problem.actuation.force = Some(problem.actuation.force.unwrap().with_limits(limits).unwrap());
    problem.actuation.torque =
        problem.actuation.torque.with_limits(Limits { norm: Some(7.0), ..Limits::default() }).unwrap();
    let inputs = smooth_inputs(&problem);
    let found = margins(&problem, &inputs).unwrap();
    let names: Vec<&str> = found.iter().map(|margin| margin.name.as_str()).collect();
    assert_eq!(names, ["torque norm limit", "force limit", "force norm limit", "force rate limit"]);
    let norm = |at: usize| {
        let rows = inputs.chunks(6).map(|row| Vector3::from_column_slice(&row[at..at + 3]).norm());
        rows.fold(0.0, f64::max)
    };
    assert!(close(found[0].margin, 7.0 - norm(3)) && found[0].unit == "N·m", "{found:#?}");
    assert!(close(found[2].margin, 4.0 - norm(0)) && found[2].unit == "N", "{found:#?}");
    assert_eq!(found[3].unit, "N/s");
}

#[test]
fn rate_margins_are_those_of_nodes_and_arcs() {
    for scheme in SCHEMES {
        let axes = Vector3::new(2.0, 1.5, 2.5);
        let problem = tumbling(scheme)
            .with_environment(Turning(Vector3::new(0.1, 0.5, -0.2)))
            .with_constraint(Constraint { name: "norm".into(), rule: Rule::RateNorm(2.0) })
            .with_constraint(Constraint { name: "axes".into(), rule: Rule::RateAxes(axes) });
        let inputs = smooth_inputs(&problem);
        let plan = replay(&problem, &inputs).unwrap();
        let found = margins(&problem, &inputs).unwrap();
        let frame = lie::exp(&(problem.step() * Vector3::new(0.1, 0.5, -0.2)));
        let arcs = attitudes(&plan)
            .windows(2)
            .map(|pair| lie::log(&(pair[0].transpose() * frame * pair[1])) / problem.step())
            .collect::<Vec<_>>();
        let rates: Vec<Vector3> = plan.angular_velocity.iter().copied().chain(arcs).collect();
        let peak = rates.iter().map(|rate| rate.norm()).fold(0.0, f64::max);
        assert!(close(find(&found, "norm").margin, (2.0 - peak).to_degrees()), "{found:#?}");
        let worst = rates.iter().map(|rate| (axes - rate.abs()).component_div(&axes).min());
        assert!(close(find(&found, "axes").scaled, worst.fold(f64::INFINITY, f64::min)), "{found:#?}");
        assert!(find(&found, "axes").at.starts_with("axis ") && found[0].unit == "deg/s");
    }
}

/// Cones with fixed and turning directions, in a standing and in a turning frame: the replayed
/// attitudes, carried along each arc in the axes of the reference frame, and [`Direction::at`].
#[test]
fn cone_margins_are_those_of_a_dense_sampling() {
    for (scheme, frame) in SCHEMES.into_iter().zip([Vector3::zeros(), Vector3::new(0.1, 0.5, -0.2)]) {
        let mut problem = tumbling(scheme).with_environment(Turning(frame));
        for side in [Side::KeepOut, Side::KeepIn] {
            for turns in [false, true] {
                problem = problem.with_constraint(cone(side, 0.7, 0.1, turns));
            }
        }
        let inputs = smooth_inputs(&problem);
        let (plan, found) = (replay(&problem, &inputs).unwrap(), margins(&problem, &inputs).unwrap());
        let (h, attitudes) = (problem.step(), attitudes(&plan));
        for (constraint, margin) in problem.constraints.iter().zip(&found) {
            let Rule::Pointing(pointing) = &constraint.rule else { unreachable!() };
            let keep_out = pointing.side == Side::KeepOut;
            let mut expected = f64::INFINITY;
            for (k, pair) in attitudes.windows(2).enumerate() {
                let turn = lie::log(&(pair[0].transpose() * lie::exp(&(h * frame)) * pair[1]));
                for (b, w) in pointing.pairs() {
                    let angle = |part: f64| {
                        let attitude = lie::exp(&(-part * h * frame)) * pair[0] * lie::exp(&(part * turn));
                        angle_between(&(attitude * b), &w.at((k as f64 + part) * h, &frame))
                    };
                    let which =
                        if pointing.side == Side::KeepOut { Extreme::Nearest } else { Extreme::Farthest };
                    let angle = sampled(angle, which, 40);
                    expected = expected.min(if keep_out { angle - 0.8 } else { 0.6 - angle });
                }
            }
            assert_eq!(margin.name, constraint.name);
            assert!((margin.scaled - expected).abs() < 1e-9, "{margin:?} {expected}");
            assert!((margin.margin - expected.to_degrees()).abs() < 1e-7 && margin.unit == "deg");
            assert!(margin.at.contains("boresight") && margin.at.contains("direction"), "{margin:?}");
        }
    }
}

/// Returns a motion whose boresight x turns by 20° in each step about z. Midway between two nodes,
/// at 30°, it passes a direction 10° off its plane: at a distance of 10° there, and of acos(cos 10°
/// cos 10°) = 14.1° at the nodes.
fn passing_between_nodes(half_angle_deg: f64) -> (Problem, Trajectory) {
    let steps = 9;
    // J sin f = hΠ about a principal axis.
    let rate = (20.0_f64.to_radians()).sin();
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.5, 2.0)).unwrap(), mass: None };
    let start = State::attitude(Matrix3::identity(), Vector3::new(0.0, 0.0, rate));
    let (azimuth, height) = (30.0_f64.to_radians(), 10.0_f64.to_radians());
    let vector = lie::exp(&Vector3::new(0.0, 0.0, azimuth))
        * lie::exp(&Vector3::new(0.0, -height, 0.0))
        * Vector3::x();
    let pointing = Pointing::new(
        Side::KeepOut,
        vec![Vector3::x()],
        vec![Direction::Fixed(vector)],
        half_angle_deg.to_radians(),
    );
    let mut problem = Problem::attitude(body, start, start, steps as f64)
        .with_steps(steps)
        .with_constraint(Constraint { name: "sun".into(), rule: Rule::Pointing(pointing) });
    let plan = replay(&problem, &vec![0.0; 3 * (steps + 1)]).unwrap();
    problem.end.attitude = lie::rotation_from_quaternion(plan.quaternion.last().unwrap());
    (problem, plan)
}

#[test]
fn a_cone_entered_between_the_nodes_only_is_refused() {
    let (problem, plan) = passing_between_nodes(12.0);
    let Rule::Pointing(pointing) = &problem.constraints[0].rule else { unreachable!() };
    let w = *pointing.directions[0].constant().unwrap();
    let at_nodes =
        attitudes(&plan).iter().map(|r| angle_between(&(r * Vector3::x()), &w)).fold(9.0, f64::min);
    let expected = (10.0_f64.to_radians().cos().powi(2)).acos();
    assert!((at_nodes - expected).abs() < 1e-12, "no node is inside: {}", at_nodes.to_degrees());
    let found = verify(&problem, &plan, 1e-12, None);
    let margin = &found.margins[0];
    assert!((margin.margin + 2.0).abs() < 1e-10, "{margin:?}");
    assert!((margin.time_s - 1.5).abs() < 1e-10, "{margin:?}");
    assert_eq!(margin.to_string(), "\"sun\" is missed by 2 deg at t = 1.5 s");
    let failed: Vec<_> = found.checks.iter().filter(|check| !check.passed).collect();
    assert_eq!(failed.len(), 1, "{found:#?}");
    assert_eq!(failed[0].name, "constraints");
    assert!((failed[0].value - 2.0_f64.to_radians()).abs() < 1e-12);
    // The cone that just touches the arc holds; a micro-degree more does not.
    for (half_angle, holds) in [(9.0, true), (10.0, true), (10.000_001, false)] {
        let (problem, plan) = passing_between_nodes(half_angle);
        assert_eq!(verify(&problem, &plan, 1e-12, None).passed(), holds, "{half_angle}");
    }
}

#[test]
fn margins_that_are_not_known_are_not_held() {
    let (problem, plan) = passing_between_nodes(5.0);
    assert!(verify(&problem, &plan, 1e-12, None).passed());
    let mut wrong = plan.clone();
    wrong.input[4] = f64::NAN;
    let found = verify(&problem, &wrong, 1e-12, None);
    let check = found.checks.iter().find(|check| check.name == "constraints").unwrap();
    assert!(check.value.is_nan() && !check.passed);
    assert!(margins(&problem, &wrong.input).is_err() && margins(&problem, &[]).is_err());
    let sound = margins(&problem, &plan.input).unwrap();
    let [nan, held, missed] = [f64::NAN, 0.5, -0.25].map(|scaled| {
        let mut margin = sound[0].clone();
        margin.scaled = scaled;
        margin
    });
    assert_eq!(worst_violation(&[held.clone(), missed.clone()]), 0.25);
    assert_eq!(worst_violation(std::slice::from_ref(&held)), 0.0);
    assert!(worst_violation(&[missed, nan.clone(), held]).is_nan() && !nan.holds());
    // A plan without constraints has no margin to check.
    let free = Problem { constraints: vec![], ..problem };
    assert!(verify(&free, &plan, 1e-12, None).checks.iter().all(|check| check.name != "constraints"));
}

#[test]
fn motions_along_the_pole_and_across_a_narrow_cone_are_exact() {
    // The boresight on the axis of rotation keeps its angle: the margin is that, on every arc.
    let (mut problem, plan) = passing_between_nodes(5.0);
    let Rule::Pointing(pointing) = &mut problem.constraints[0].rule else { unreachable!() };
    pointing.boresights = vec![Vector3::z()];
    let expected = 80.0 - 5.0;
    assert!((margins(&problem, &plan.input).unwrap()[0].margin - expected).abs() < 1e-12);
    // A direction in the very plane: met head-on at 0°, where a cosine would lose half of the
    // digits.
    pointing_at(&mut problem, lie::exp(&Vector3::new(0.0, 0.0, 0.5)) * Vector3::x(), 1e-4);
    let found = &margins(&problem, &plan.input).unwrap()[0];
    assert!((found.scaled + 1e-4).abs() < 1e-14, "{found:?}");
}

fn pointing_at(problem: &mut Problem, vector: Vector3, half_angle: f64) {
    let Rule::Pointing(pointing) = &mut problem.constraints[0].rule else { unreachable!() };
    pointing.boresights = vec![Vector3::x()];
    pointing.directions = vec![Direction::Fixed(vector)];
    pointing.half_angle = half_angle;
}

/// The continuous motion under the held torque is compared with the discrete one of steps so short
/// that both agree: 800 and 1600 short steps a step, and in the limit.
#[test]
fn continuous_margins_are_those_of_ever_shorter_steps() {
    let mut moved = 0.0_f64;
    for scheme in SCHEMES {
        let problem = tumbling(scheme)
            .with_constraint(cone(Side::KeepOut, 0.2, 0.0, false))
            .with_constraint(cone(Side::KeepIn, 1.0, 0.1, false))
            .with_constraint(Constraint { name: "norm".into(), rule: Rule::RateNorm(2.0) })
            .with_constraint(Constraint { name: "axes".into(), rule: Rule::RateAxes(Vector3::repeat(1.5)) });
        let inputs = smooth_inputs(&problem);
        let found = verify(&problem, &replay(&problem, &inputs).unwrap(), 1e-12, Some(0.1));
        let rows: Vec<&[f64]> = inputs.chunks(3).collect();
        let held = |step: usize| -> Vec<f64> {
            match scheme {
                Scheme::LieEuler => rows[step].to_vec(),
                Scheme::LieVerlet => {
                    rows[step].iter().zip(rows[step + 1]).map(|(a, b)| 0.5 * (a + b)).collect()
                }
            }
        };
        let fine = |times: usize| {
            let fine = problem.clone().with_steps(times * problem.steps).with_scheme(Scheme::LieEuler);
            let inputs: Vec<f64> = (0..fine.steps).flat_map(|step| held(step / times)).collect();
            margins(&fine, &inputs).unwrap()
        };
        let (coarse, finer) = (fine(800), fine(1600));
        for ((margin, coarse), finer) in found.margins.iter().zip(&coarse).zip(&finer) {
            let expected = 2.0 * finer.margin - coarse.margin;
            let (continuous, difference) = (margin.continuous_margin.unwrap(), margin.margin - expected);
            let missed = (continuous - expected).abs();
            assert!(missed < 0.02 * difference.abs() + 1e-4, "{scheme:?} {margin:?} {expected}");
            moved = moved.max(difference.abs());
        }
        // A boresight that enters a cone by more than the tolerance fails.
        let check = found.checks.iter().find(|check| check.name == "continuous constraints").unwrap();
        let worst = found.margins[..2].iter().map(|margin| -margin.continuous_margin.unwrap().to_radians());
        assert!((check.value - worst.fold(0.0, f64::max)).abs() < 1e-12 && !check.passed);
    }
    assert!(moved > 0.5, "the discrete and the continuous margins hardly differ: {moved} deg");
}
