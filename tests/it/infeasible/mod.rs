//! Proofs of infeasibility: never against a maneuver that exists, and the figures where they are known.

use crate::common::Random;
use nalgebra::DMatrix;
use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::infeasible::{Proof, proof};
use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::maneuver::solution::Trajectory;
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{GravityGradient, UniformGravity};
use slewkit::verify::{margins, replay};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::TAU;

const SCHEMES: [Scheme; 2] = [Scheme::LieEuler, Scheme::LieVerlet];

fn limited(limits: Limits) -> Actuation {
    Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap())
}

fn norm_limit(limit: f64) -> Actuation {
    limited(Limits { norm: Some(limit), ..Limits::default() })
}

fn body(j: Matrix3) -> Body {
    Body { inertia: Inertia::new(j).unwrap(), mass: None }
}

/// A body with principal moments up to a factor of about a hundred apart, axes askew.
fn random_body(random: &mut Random) -> Body {
    // Moments of a cloud of masses: every triangle inequality holds by itself.
    let spread = Vector3::from_fn(|_, _| 10.0_f64.powf(random.uniform()));
    let moments = Vector3::new(spread.y + spread.z, spread.z + spread.x, spread.x + spread.y);
    let axes = random.rotation();
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    body(0.5 * (j + j.transpose()))
}

fn rest_to_rest(body: Body, rotation: Vector3, duration: f64, actuation: Actuation) -> Problem {
    let start = State::at_rest(Matrix3::identity());
    Problem::attitude(body, start, State::at_rest(lie::exp(&rotation)), duration).with_actuation(actuation)
}

// ---- no maneuver that exists is denied --------------------------------------------------------------

/// Aimed at where its inputs lead.
fn aimed(mut problem: Problem, inputs: &[f64]) -> Option<(Problem, Trajectory)> {
    let plan = replay(&problem, inputs).ok()?;
    problem.end = State::attitude(
        lie::rotation_from_quaternion(plan.quaternion.last().unwrap()),
        *plan.angular_velocity.last().unwrap(),
    );
    Some((problem, plan))
}

/// Sets every limit to the very values that the plan attains, so that the proofs have all they can use.
fn tighten(mut problem: Problem, inputs: &[f64], random: &mut Random) -> Option<Problem> {
    let count = problem.actuation.count();
    let rows: Vec<&[f64]> = inputs.chunks(count).collect();
    let largest = |of: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
        (0..count).map(|i| of(i).iter().fold(1e-12, |a: f64, b| a.max(b.abs()))).collect()
    };
    let channel = problem.actuation.torque.clone();
    let all = Limits {
        size: Some(largest(&|i| rows.iter().map(|row| row[i]).collect())),
        norm: Some(rows.iter().map(|row| channel.output(row).norm()).fold(1e-12, f64::max)),
        rate: Some(largest(&|i| {
            rows.windows(2).map(|pair| (pair[1][i] - pair[0][i]) / problem.step()).collect()
        })),
    };
    let keep = |random: &mut Random| random.uniform() > 0.0;
    let limits = Limits {
        size: all.size.filter(|_| keep(random)),
        norm: all.norm.filter(|_| keep(random)),
        rate: all.rate.filter(|_| keep(random)),
    };
    problem.actuation.torque = channel.with_limits(limits).unwrap();
    // Limits that everything holds, then those that the margins leave.
    problem = problem
        .with_constraint(Constraint { name: "norm".into(), rule: Rule::RateNorm(1e3) })
        .with_constraint(Constraint { name: "axes".into(), rule: Rule::RateAxes(Vector3::repeat(1e3)) });
    let found = margins(&problem, inputs).ok()?;
    let margin = |name: &str| found.iter().find(|margin| margin.name == name).map(|margin| margin.margin);
    let rate = 1e3 - margin("norm").unwrap().to_radians();
    let axes = 1e3 - margin("axes").unwrap().to_radians();
    problem.constraints.clear();
    if keep(random) {
        problem = problem
            .with_constraint(Constraint { name: "norm".into(), rule: Rule::RateNorm(rate * (1.0 + 1e-12)) });
    }
    if keep(random) {
        let rule = Rule::RateAxes(Vector3::repeat(axes * (1.0 + 1e-12)));
        problem = problem.with_constraint(Constraint { name: "axes".into(), rule });
    }
    let stored = replay(&problem, inputs).ok()?.wheel_momentum;
    if let Some(wheels) = &mut problem.actuation.wheels {
        let most = stored.iter().fold(1e-12, |most: f64, h| most.max(h.abs()));
        wheels.momentum_limit = vec![most; count];
    }
    Some(problem)
}

/// Adds keep-out and keep-in cones that the plan just touches.
fn fence(mut problem: Problem, inputs: &[f64], random: &mut Random) -> Problem {
    let mut wanted = vec![];
    for index in 0..3 {
        let side = if random.uniform() > 0.0 { Side::KeepOut } else { Side::KeepIn };
        let pointing = Pointing {
            side,
            boresights: vec![random.direction()],
            directions: vec![Direction {
                vector: random.direction(),
                turns_with_frame: random.uniform() > 0.0,
            }],
            half_angle: 1.0,
            margin: 0.0,
        };
        wanted.push(Constraint { name: format!("cone {index}"), rule: Rule::Pointing(pointing) });
    }
    let with = Problem { constraints: wanted.clone(), ..problem.clone() };
    // The ends may be on the wrong side of a cone of any angle: measure without asking.
    let measure = |constraint: &Constraint, half_angle: f64| {
        let mut constraint = constraint.clone();
        let Rule::Pointing(pointing) = &mut constraint.rule else { unreachable!() };
        pointing.half_angle = half_angle;
        let probe = Problem { constraints: vec![constraint], ..with.clone() };
        margins(&probe, inputs).map(|found| found.last().unwrap().scaled)
    };
    for mut constraint in wanted {
        let Rule::Pointing(pointing) = &constraint.rule else { unreachable!() };
        let (widest, sign) =
            if pointing.side == Side::KeepOut { (1e-6, 1.0) } else { (std::f64::consts::PI - 1e-6, -1.0) };
        let Ok(margin) = measure(&constraint, widest) else { continue };
        let half_angle = widest + sign * (margin - 1e-9);
        if !(1e-6..std::f64::consts::PI - 1e-6).contains(&half_angle) {
            continue;
        }
        let Rule::Pointing(pointing) = &mut constraint.rule else { unreachable!() };
        pointing.half_angle = half_angle;
        problem = problem.with_constraint(constraint);
    }
    problem
}

/// Inputs of several shapes: noise, bang-bang, smooth, one axis.
fn shaped_inputs(random: &mut Random, rows: usize, count: usize, size: f64) -> Vec<f64> {
    let shape = (random.bits() % 5) as usize;
    let phase: Vec<f64> = (0..count).map(|_| 3.0 * random.uniform()).collect();
    let axis: Vec<f64> = (0..count).map(|_| random.uniform()).collect();
    let mut inputs = vec![];
    for row in 0..rows {
        let t = row as f64 / (rows - 1) as f64;
        for i in 0..count {
            let value = match shape {
                0 => random.uniform(),
                1 => (6.0 * t + phase[i]).sin().signum(),
                2 => (4.0 * t + phase[i]).sin(),
                3 => axis[i] * if t < 0.5 { 1.0 } else { -1.0 },
                _ => axis[i] * (1.0 - 2.0 * t),
            };
            inputs.push(size * value);
        }
    }
    inputs
}

/// The same with every limit of inputs and rates smaller, but none below the rates of the ends.
fn weakened(problem: &Problem, factor: f64) -> Problem {
    let mut weak = problem.clone();
    let channel = weak.actuation.torque.clone();
    let smaller = |limits: &Option<Vec<f64>>| limits.as_ref().map(|l| l.iter().map(|l| factor * l).collect());
    let limits = channel.limits().clone();
    let limits = Limits {
        size: smaller(&limits.size),
        norm: limits.norm.map(|l| factor * l),
        rate: smaller(&limits.rate),
    };
    weak.actuation.torque = channel.with_limits(limits).unwrap();
    let [start, end] = [problem.start.angular_velocity, problem.end.angular_velocity];
    for constraint in &mut weak.constraints {
        match &mut constraint.rule {
            Rule::RateNorm(limit) => *limit = (factor * *limit).max(start.norm()).max(end.norm()),
            Rule::RateAxes(limits) => *limits = (factor * *limits).sup(&start.abs()).sup(&end.abs()),
            Rule::Pointing(_) => {}
        }
    }
    weak
}

/// Whatever a body can do within limits, by the witness's own propagation, is not claimed to be impossible
/// with exactly these limits: bodies of all kinds, both schemes, long steps and short, wheels, fields, frames
/// that turn, torques fixed to the reference frame, moving ends, cones that are just touched.
#[test]
fn a_maneuver_that_exists_is_never_denied() {
    let mut random = Random::new(2024);
    let (mut tried, mut constrained, mut denied) = (0, 0, [0; 4]);
    for case in 0..6000 {
        let steps = 2 + (random.bits() % 30) as usize;
        let duration = 10.0_f64.powf(random.uniform());
        let body = random_body(&mut random);
        let unit = body.inertia.principal()[0] / (duration * duration);
        let size = unit * 10.0_f64.powf(1.2 * random.uniform());
        let rate = if case % 3 == 0 { 0.5 / duration * random.vector() } else { Vector3::zeros() };
        let start = State::attitude(random.rotation(), rate);
        let mut problem = Problem::attitude(body.clone(), start, start, duration)
            .with_steps(steps)
            .with_scheme(SCHEMES[case % 2]);
        match case % 5 {
            0 => {
                let axes: Vec<Vector3> = (0..4).map(|_| random.direction()).collect();
                let torque = ActuatorSet::new(axes, AxisFrame::Body, DMatrix::identity(4, 4)).unwrap();
                let unit = body.inertia.mean() / duration;
                let momentum =
                    (0..4).map(|_| if case % 2 == 0 { 0.0 } else { unit * random.uniform() }).collect();
                let wheels = Some(Wheels { momentum, momentum_limit: vec![f64::INFINITY; 4] });
                problem.actuation = Actuation { torque, force: None, wheels };
            }
            1 => {
                let field = UniformGravity::new(1.0, size, random.direction(), 0.3 * random.direction());
                problem = problem.with_environment(field.unwrap());
                if case % 2 == 0 {
                    problem.actuation.torque = ActuatorSet::three_axes(AxisFrame::Reference);
                }
            }
            2 => {
                let field = GravityGradient::new(1.0 / duration, &body.inertia);
                problem = problem.with_environment(field.unwrap());
                if case % 2 == 0 {
                    problem.actuation.torque = ActuatorSet::three_axes(AxisFrame::Reference);
                }
            }
            _ => {}
        }
        let count = problem.actuation.count();
        let rows = problem.scheme.input_rows(steps);
        let inputs = shaped_inputs(&mut random, rows, count, size);
        let Some((problem, _)) = aimed(problem, &inputs) else { continue };
        let Some(problem) = tighten(problem, &inputs, &mut random) else { continue };
        let problem = fence(problem, &inputs, &mut random);
        if problem.check().is_err() {
            continue;
        }
        tried += 1;
        constrained += usize::from(problem.constraints.len() > 2);
        let found = margins(&problem, &inputs).unwrap();
        let worst = slewkit::verify::worst_violation(&found);
        assert!(worst < 1e-8, "{case}: the plan itself violates its limits: {found:#?}");
        assert_eq!(proof(&problem), None, "{case}: {problem:#?}");
        for (count, factor) in denied.iter_mut().zip([0.99, 0.9, 0.7, 0.4]) {
            let weak = weakened(&problem, factor);
            *count += usize::from(weak.check().is_ok() && proof(&weak).is_some());
        }
    }
    assert!(tried > 4000 && constrained > 1000, "only {tried} maneuvers, {constrained} with cones");
    // The claims have teeth: with limits a little smaller many of the same maneuvers are denied.
    assert!(denied[0] > 30 && denied[1] > 200 && denied[3] > 2000, "{denied:?} of {tried} are denied");
}

/// Under-actuated bodies next to those with a conserved momentum: a little asymmetry, misalignment or initial rate,
/// made large by hard torques, leads where the conserved quantity would not.
#[test]
fn a_premise_that_holds_nearly_proves_nothing() {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut strayed = 0;
    for exponent in 4..=13 {
        let little = 0.9 * 10.0_f64.powi(-exponent);
        let tilted = Matrix3::new(1.0, 0.0, 0.0, 0.0, 2.0, little, 0.0, little, 2.5);
        let diagonal = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
        let cases = [
            (diagonal(1.0, 1.0 + little, 1.5), vec![x, y], Vector3::zeros(), 60.0),
            (tilted, vec![y], Vector3::zeros(), 100.0),
            (diagonal(1.2, 2.0, 3.0), vec![y], x * little, 400.0),
            (diagonal(1.0, 2.0, 2.5), vec![y + z * little], Vector3::zeros(), 100.0),
        ];
        for (j, axes, rate, size) in cases {
            let count = axes.len();
            let torque = ActuatorSet::new(axes, AxisFrame::Body, DMatrix::identity(count, count)).unwrap();
            let start = State::attitude(Matrix3::identity(), rate);
            let problem = Problem::attitude(body(j), start, start, 1.0)
                .with_steps(400)
                .with_actuation(Actuation::torques(torque));
            let inputs: Vec<f64> =
                (0..=400).flat_map(|row| vec![size * (TAU * f64::from(row) / 400.0).sin(); count]).collect();
            let (problem, _) = aimed(problem, &inputs).unwrap();
            strayed += usize::from(problem.end.angular_velocity.cross(&y).norm() > 1e-8);
            assert_eq!(proof(&problem), None, "{little:e}: {problem:#?}");
        }
    }
    assert!(strayed > 20, "only {strayed} cases try the proofs");
}

/// The factor of the torque limit at which the proof first denies the maneuver: 1 would be a false claim.
fn critical(problem: &Problem) -> f64 {
    let norm = problem.actuation.torque.limits().norm.unwrap();
    let denied = |factor: f64| {
        let weak = problem.clone().with_actuation(norm_limit(factor * norm));
        proof(&weak).is_some()
    };
    if denied(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        *(if denied(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

/// An attack: hill climbing on the torques of short maneuvers with long steps, for the maneuver that comes
/// nearest to what the proof denies. It comes near, and never there.
#[test]
fn torques_made_to_break_the_bound_do_not() {
    let mut random = Random::new(77);
    let mut nearest = vec![];
    for case in 0..16 {
        let body = random_body(&mut random);
        let steps = 3 + case / 2;
        let start = State::at_rest(Matrix3::identity());
        // From a small fraction of a radian per step to nearly all that a step can turn.
        let angle = 0.1 * 10.0_f64.powf((case % 4) as f64 / 3.2);
        let limit = 4.0 * angle * body.inertia.principal()[0] / steps as f64;
        let problem = Problem::attitude(body.clone(), start, start, steps as f64)
            .with_steps(steps)
            .with_scheme(SCHEMES[case % 2])
            .with_actuation(norm_limit(limit));
        let rows = problem.scheme.input_rows(steps);
        let reached = |inputs: &[f64]| {
            let (problem, _) = aimed(problem.clone(), inputs)?;
            problem.check().ok()?;
            assert_eq!(proof(&problem), None, "{case}: {problem:#?} {inputs:?}");
            Some(critical(&problem))
        };
        // Bang-bang about the axis of the smallest moment, or about any.
        let axis = if case % 3 == 0 { random.direction() } else { smallest_axis(&body) };
        let flip = |row: usize| if 2 * row < rows { limit } else { -limit };
        let mut inputs: Vec<f64> = (0..rows).flat_map(|row| (axis * flip(row)).data.0[0]).collect();
        let mut best = reached(&inputs).unwrap_or(0.0);
        for _ in 0..120 {
            let mut tried = inputs.clone();
            let size = 10.0_f64.powf(-1.5 + 1.5 * random.uniform());
            for row in tried.chunks_mut(3) {
                let torque = Vector3::from_column_slice(row) + size * limit * random.vector();
                row.copy_from_slice((torque * (limit / torque.norm()).min(1.0)).as_slice());
            }
            if let Some(found) = reached(&tried).filter(|found| *found > best) {
                (best, inputs) = (found, tried);
            }
        }
        nearest.push(best);
    }
    assert!(nearest.iter().all(|best| *best < 1.0), "{nearest:?}");
    let near = nearest.iter().filter(|best| **best > 0.8).count();
    assert!(near >= 6, "the attack is weak: {nearest:?}");
}

fn smallest_axis(body: &Body) -> Vector3 {
    let eigen = body.inertia.j().symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned()
}

// ---- the figures ------------------------------------------------------------------------------------

fn denied(problem: &Problem) -> Proof {
    problem.check().unwrap();
    proof(problem).unwrap_or_else(|| panic!("not denied: {problem:#?}"))
}

/// The named shortest duration, which must be a little below the closed form and never above.
fn shortest(problem: &Problem, closed_form: f64, slack: f64) -> String {
    let found = denied(problem);
    let shortest = found.duration_lower_bound.unwrap();
    let below = closed_form * (1.0 - slack) <= shortest && shortest <= closed_form * (1.0 + 1e-6);
    assert!(below, "{shortest} against {closed_form}: {found}");
    // Just below it is denied, just above it is not; and the duration is in the text.
    let with = |duration: f64| Problem { duration, ..problem.clone() };
    assert!(proof(&with(shortest * (1.0 - 1e-5))).is_some(), "{found}");
    assert_eq!(proof(&with(shortest * (1.0 + 1e-5))), None);
    let digits: f64 = text_between(&found.reason, "no plan under ", " s").parse().unwrap();
    assert!(digits <= shortest * (1.0 + 3e-6) && digits >= shortest * 0.999, "{found}");
    found.reason
}

fn text_between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    text.split(from).nth(1).and_then(|rest| rest.split(to).next()).unwrap_or_else(|| panic!("{text}"))
}

/// `T ≥ 2 √(θ J₁/ū)` for every body and rotation, and more where an axis of a larger moment is turned.
#[test]
fn no_slew_is_faster_than_its_torque_allows() {
    let mut random = Random::new(31);
    for case in 0..60 {
        let body = random_body(&mut random);
        let [smallest, middle] = [body.inertia.principal()[0], body.inertia.principal()[1]];
        let rotation = random.direction() * 3.1 * (0.05 + 0.95 * random.uniform().abs());
        let limit = 0.3;
        let least = 2.0 * (rotation.norm() * smallest / limit).sqrt();
        let problem = |factor: f64| {
            rest_to_rest(body.clone(), rotation, factor * least, norm_limit(limit))
                .with_steps(200)
                .with_scheme(SCHEMES[case % 2])
        };
        for factor in [1e-3, 0.3, 0.9, 0.999] {
            let found = denied(&problem(factor)).duration_lower_bound.unwrap();
            assert!(found >= 0.9998 * least, "{case}: {found} {least}");
        }
        // The axis of the smallest moment moves only by turns about the others.
        let axis = smallest_axis(&body);
        let way = (lie::exp(&rotation) * axis).dot(&axis).clamp(-1.0, 1.0).acos();
        let sharper = 2.0 * (way * middle / limit).sqrt();
        let expected = least.max(sharper);
        let found = denied(&problem(0.5)).duration_lower_bound.unwrap();
        assert!(found >= 0.99 * expected, "{case}: {found} {expected}");
        // Never above what an eigenaxis slew needs with its gyroscopic torque.
        let (angle, e) = (rotation.norm(), rotation.normalize());
        let je = body.inertia.j() * e;
        let eigenaxis = (je.norm_squared() + angle * angle * e.cross(&je).norm_squared()).sqrt();
        assert!(found <= 2.0 * (angle * eigenaxis / limit).sqrt());
    }
}

/// About the axis of the smallest moment the bound is the time of the bang-bang slew itself.
#[test]
fn the_bound_is_sharp_about_the_axis_of_the_smallest_moment() {
    let moments = Vector3::new(2.0, 3.0, 4.0);
    let body = Body { inertia: Inertia::diagonal(moments).unwrap(), mass: None };
    let rotation = Vector3::new(2.0, 0.0, 0.0);
    let problem = rest_to_rest(body, rotation, 5.0, norm_limit(0.3)).with_steps(400);
    let reason = shortest(&problem, 2.0 * (2.0 * 2.0 / 0.3_f64).sqrt(), 1e-4);
    // In 5 s: θ = ū T²/4J = 0.9375 rad = 53.7 deg; it takes ū = 4θJ/T² = 0.64 N·m.
    assert!(reason.contains("turn by 114.5 deg, 5 s allow 53.7"), "{reason}");
    let torque: f64 = text_between(&reason, "it takes at least ", " N·m").parse().unwrap();
    assert!((torque - 0.64).abs() < 1e-3 && torque <= 0.64, "{reason}");
    assert!(reason.contains("the body has to turn"), "{reason}");
    assert!(reason.contains("no plan under 7.30") && reason.contains("s with 0.3 N·m"), "{reason}");
}

/// A cube turns 180° in 3.2431 with torques up to 1 about each axis: faster than its eigenaxis slew (3.5449).
#[test]
fn box_limits_are_bounded_by_their_corner_only() {
    let cube = Body { inertia: Inertia::diagonal(Vector3::repeat(1.0)).unwrap(), mass: None };
    let rotation = Vector3::new(0.0, 0.0, std::f64::consts::PI);
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let problem = |duration: f64| {
        rest_to_rest(cube.clone(), rotation, duration, limited(limits.clone())).with_steps(200)
    };
    for possible in [3.2431, 3.4, 3.6] {
        assert_eq!(proof(&problem(possible)), None);
    }
    let reason = shortest(&problem(2.5), 2.0 * (std::f64::consts::PI / 3.0_f64.sqrt()).sqrt(), 1e-3);
    assert!(reason.contains("1.732 N·m at most from all inputs at their limits"), "{reason}");
    let factor: f64 = text_between(&reason, "torque limits at least ", " times").parse().unwrap();
    assert!((factor - std::f64::consts::PI / 3.0_f64.sqrt() * 4.0 / 6.25).abs() < 2e-3, "{reason}");
}

/// θ/ω alone; with torque too the trapezoid θ/ω + ωJ/ū.
#[test]
fn rate_limits_bound_the_time() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(2.0, 0.0, 0.0);
    let rate = |limit: f64| Constraint { name: "gyro".into(), rule: Rule::RateNorm(limit) };
    let free = rest_to_rest(
        body.clone(),
        rotation,
        5.0,
        Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body)),
    );
    assert_eq!(proof(&free), None);
    let reason = shortest(&free.clone().with_constraint(rate(0.25)), 8.0, 1e-6);
    assert!(reason.contains("14.32 deg/s") && reason.contains("rate limits at least 1.6 times"), "{reason}");
    let both = rest_to_rest(body, rotation, 5.0, norm_limit(0.3)).with_steps(400).with_constraint(rate(0.25));
    shortest(&both, 2.0 / 0.25 + 0.25 * 2.0 / 0.3, 1e-3);
    // Per axis: the corner of the box, and for an axis of the body what moves it.
    let axes = Constraint { name: "axes".into(), rule: Rule::RateAxes(Vector3::new(0.3, 0.4, 0.1)) };
    let about_z = Problem { end: State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, 2.0))), ..free };
    // The y axis is moved by turns about x and z only.
    shortest(&about_z.with_constraint(axes), 2.0 / 0.1_f64.sqrt(), 1e-6);
}

/// A sphere, torque rising and falling at r: θ = r T³/12J, whatever the torque itself may be.
#[test]
fn torque_rate_limits_bound_the_time() {
    let sphere = Body { inertia: Inertia::diagonal(Vector3::repeat(2.0)).unwrap(), mass: None };
    let axes = vec![Vector3::x()];
    let limits = Limits { rate: Some(vec![0.05]), ..Limits::default() };
    let channel = ActuatorSet::new(axes, AxisFrame::Body, DMatrix::identity(1, 1)).unwrap();
    let actuation = Actuation::torques(channel.with_limits(limits).unwrap());
    for scheme in SCHEMES {
        let problem = rest_to_rest(sphere.clone(), Vector3::new(1.5, 0.0, 0.0), 5.0, actuation.clone());
        let problem = problem.with_steps(400).with_scheme(scheme);
        let reason = shortest(&problem, (12.0 * 2.0 * 1.5 / 0.05_f64).cbrt(), 1e-3);
        assert!(reason.contains("torque rate limits at least"), "{reason}");
    }
}

/// The moment of a pendulum is so much more torque: `ū + m g |ρ|`.
#[test]
fn a_bounded_field_counts_as_torque() {
    let sphere = Body { inertia: Inertia::diagonal(Vector3::repeat(2.0)).unwrap(), mass: None };
    let rotation = Vector3::new(1.5, 0.0, 0.0);
    let field = UniformGravity::new(0.1, 2.0, Vector3::z(), Vector3::new(0.0, 0.0, 0.5)).unwrap();
    let problem =
        rest_to_rest(sphere, rotation, 4.0, norm_limit(0.3)).with_steps(400).with_environment(field);
    let reason = shortest(&problem, 2.0 * (1.5 * 2.0 / 0.4_f64).sqrt(), 1e-4);
    assert!(reason.contains("0.3 N·m and 0.1 N·m of the field"), "{reason}");
}

#[test]
fn momentum_that_cannot_be_gained_in_time_is_named() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let end = State::attitude(Matrix3::identity(), Vector3::new(0.0, 0.0, 0.9));
    let mut problem = rest_to_rest(body, Vector3::zeros(), 5.0, norm_limit(0.3));
    problem.end = end;
    let reason = shortest(&problem, 12.0, 1e-6);
    assert!(reason.contains("change by 3.6 N·m·s, 1.5") && reason.contains("at least 0.72 N·m"), "{reason}");
}

#[test]
fn forces_and_distances_are_bounded() {
    let mut start = State::at_rest(Matrix3::identity());
    let body = Body { inertia: Inertia::diagonal(Vector3::repeat(2.0)).unwrap(), mass: Some(4.0) };
    let mut end = start;
    end.position = Vector3::new(3.0, 4.0, 0.0);
    let limited = |problem: Problem| {
        let limits = Limits { norm: Some(0.5), ..Limits::default() };
        let force = problem.actuation.force.clone().unwrap().with_limits(limits).unwrap();
        let actuation = Actuation { force: Some(force), ..problem.actuation.clone() };
        problem.with_actuation(actuation).with_steps(100)
    };
    let problem = limited(Problem::rigid_body(body.clone(), start, end, 10.0));
    let reason = shortest(&problem, 2.0 * (5.0 * 4.0 / 0.5_f64).sqrt(), 1e-6);
    assert!(reason.contains("go 5 m") && reason.contains("with 0.5 N"), "{reason}");
    start.velocity.x = -1.0;
    end.velocity.x = 1.0;
    let found = shortest(&limited(Problem::rigid_body(body.clone(), start, end, 10.0)), 16.0, 1e-6);
    assert!(found.contains("velocity"), "{found}");
    end.velocity.x = -1.0;
    let found = denied(&limited(Problem::rigid_body(body, start, end, 10.0)));
    assert!(found.reason.contains("beside the mean") && found.duration_lower_bound.is_none(), "{found}");
}

// ---- wheels -----------------------------------------------------------------------------------------

fn three_wheels(momentum: [f64; 3], limit: f64, torque: f64) -> Actuation {
    let limits = Limits { size: Some(vec![torque; 3]), ..Limits::default() };
    let channel = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits).unwrap();
    let wheels = Wheels { momentum: momentum.to_vec(), momentum_limit: vec![limit; 3] };
    Actuation { torque: channel, force: None, wheels: Some(wheels) }
}

/// Turned by 90° about x, the momentum that the z wheel holds must be held by the y wheel, and the body has
/// to end with none.
#[test]
fn momentum_that_the_wheels_cannot_hold_in_the_end_is_named() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let mut actuation = three_wheels([0.0, 0.0, 4.0], 5.0, 1.0);
    let mut problem = rest_to_rest(body, rotation, 60.0, actuation.clone());
    assert_eq!(proof(&problem), None);
    actuation.wheels.as_mut().unwrap().momentum_limit = vec![5.0, 2.5, 5.0];
    problem.actuation = actuation;
    let found = denied(&problem);
    assert!(found.reason.contains("hold 4 N·m·s along the body axis (0, 1, 0)"), "{found}");
    assert!(found.reason.contains("store 2.5") && found.reason.contains("at least 1.6 times"), "{found}");
    // Two wheels, and momentum about the third axis at the end.
    let channel =
        ActuatorSet::new(vec![Vector3::x(), Vector3::z()], AxisFrame::Body, DMatrix::identity(2, 2)).unwrap();
    let wheels = Wheels { momentum: vec![0.0, 4.0], momentum_limit: vec![f64::INFINITY; 2] };
    problem.actuation = Actuation { torque: channel, force: None, wheels: Some(wheels) };
    let found = denied(&problem);
    assert!(found.reason.contains("no wheel turns about it"), "{found}");
}

/// Full wheels turn no faster than their momentum: `T ≥ θ J/h`, here of the axis of the smallest moment, with
/// the corner of three wheels; and no faster than the torque takes to fill and to empty them.
#[test]
fn wheels_turn_the_body_no_faster_than_they_store() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(2.0, 0.0, 0.0);
    let corner = 3.0_f64.sqrt();
    let problem =
        rest_to_rest(body.clone(), rotation, 30.0, three_wheels([0.0; 3], 0.05, 0.02)).with_steps(2000);
    let (capacity, torque) = (0.05 * corner, 0.02 * corner);
    // Two ramps of the torque at the ends, full wheels between.
    let reason = shortest(&problem, 2.0 * 2.0 / capacity + capacity / torque, 1e-2);
    assert!(reason.contains("wheel momentum limits at least"), "{reason}");
    let problem = rest_to_rest(body, rotation, 2.0, three_wheels([0.0; 3], 50.0, 0.1)).with_steps(400);
    let reason = shortest(&problem, 2.0 * (2.0 * 2.0 / (0.1 * corner)).sqrt(), 1e-3);
    assert!(reason.contains("torque limits at least"), "{reason}");
}

/// A half turn about x brings 4 N·m·s of the z wheel to −z: 8 N·m·s in 8 s with 1 N·m, no faster.
#[test]
fn wheels_take_up_momentum_no_faster_than_their_torques() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rotation = Vector3::new(std::f64::consts::PI, 0.0, 0.0);
    let problem = rest_to_rest(body, rotation, 6.0, three_wheels([0.0, 0.0, 4.0], 5.0, 1.0));
    let found = denied(&problem);
    assert!((found.duration_lower_bound.unwrap() - 8.0).abs() < 1e-5, "{found}");
    assert!(found.reason.contains("take up 8 N·m·s"), "{found}");
}

/// A gyrostat spun up and down about one axis against what its wheel holds, in long steps: it turns farther
/// than without the wheel, and just as far as the bound says, for the body as for each of its other axes.
#[test]
fn a_gyrostat_about_one_axis_attains_its_bound() {
    for scheme in SCHEMES {
        let steps = 8;
        let start = State::at_rest(Matrix3::identity());
        let mut problem = Problem::attitude(body(2.0 * Matrix3::identity()), start, start, 8.0)
            .with_steps(steps)
            .with_scheme(scheme)
            .with_actuation(three_wheels([-0.5, 0.0, 0.0], f64::INFINITY, 0.1));
        let axis = vec![Vector3::x()];
        let limits = Limits { size: Some(vec![0.1]), ..Limits::default() };
        problem.actuation.torque = ActuatorSet::new(axis, AxisFrame::Body, DMatrix::identity(1, 1))
            .unwrap()
            .with_limits(limits)
            .unwrap();
        problem.actuation.wheels = Some(Wheels { momentum: vec![-0.5], momentum_limit: vec![f64::INFINITY] });
        let inputs: Vec<f64> = match scheme {
            Scheme::LieEuler => (0..8).map(|k| if k < 4 { 0.1 } else { -0.1 }).collect(),
            Scheme::LieVerlet => {
                (0..9).map(|k| [0.1, 0.0, -0.1][usize::from(k >= 4) + usize::from(k > 4)]).collect()
            }
        };
        let (problem, plan) = aimed(problem, &inputs).unwrap();
        assert!(plan.angular_velocity.last().unwrap().norm() < 1e-14);
        assert_eq!(proof(&problem), None, "{scheme:?}");
        let mut weak = problem.clone();
        let limits = Limits { size: Some(vec![0.0999]), ..Limits::default() };
        weak.actuation.torque = weak.actuation.torque.with_limits(limits).unwrap();
        assert!(proof(&weak).is_some(), "{scheme:?}");
    }
}

// ---- cones ------------------------------------------------------------------------------------------

/// A cone in the way makes the way longer: for the boresight z, from 60° on one side of a cone of 50° about
/// the middle to 60° on the other.
#[test]
fn a_cone_in_the_way_needs_time() {
    let sphere = Body { inertia: Inertia::diagonal(Vector3::repeat(2.0)).unwrap(), mass: None };
    let rotation = Vector3::new(120.0_f64.to_radians(), 0.0, 0.0);
    let axis = lie::exp(&(0.5 * rotation)) * Vector3::z();
    let cone = |degrees: f64| {
        let direction = Direction { vector: axis, turns_with_frame: false };
        let half_angle = degrees.to_radians();
        let (boresights, directions) = (vec![Vector3::z()], vec![direction]);
        let rule =
            Rule::Pointing(Pointing { side: Side::KeepOut, boresights, directions, half_angle, margin: 0.0 });
        Constraint { name: "sun".into(), rule }
    };
    let direct = 2.0 * (rotation.norm() * 2.0 / 0.3_f64).sqrt();
    let problem = rest_to_rest(sphere, rotation, 1.02 * direct, norm_limit(0.3)).with_steps(400);
    assert_eq!(proof(&problem), None);
    let beta = 50.0_f64.to_radians();
    let tangent = (60.0_f64.to_radians().cos() / beta.cos()).acos();
    let contact = (beta.tan() / 60.0_f64.to_radians().tan()).acos();
    let way = 2.0 * tangent + beta.sin() * (std::f64::consts::PI - 2.0 * contact);
    let with = problem.clone().with_constraint(cone(50.0));
    let reason = shortest(&with, 2.0 * (way * 2.0 / 0.3_f64).sqrt(), 1e-3);
    assert!(reason.contains("around \"sun\""), "{reason}");
    let most: f64 = text_between(&reason, "a half angle of at most ", " deg").parse().unwrap();
    // The named cone is on the border itself.
    assert!(proof(&problem.clone().with_constraint(cone(most - 0.05))).is_none(), "{reason}");
    assert!(proof(&problem.with_constraint(cone(most + 0.05))).is_some(), "{reason}");
}

/// A boresight to be kept near the zenith of an orbit, and away from a star that the zenith passes: at that
/// moment there is no attitude. Both ends are fine.
#[test]
fn cones_that_meet_on_the_way_are_named_both() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 3.0, 4.0)).unwrap(), mass: None };
    let rate = 1e-3;
    let field = GravityGradient::new(rate, &body.inertia).unwrap();
    let start = State::attitude(Matrix3::identity(), Vector3::new(0.0, rate, 0.0));
    let duration = 2000.0;
    let star = lie::exp(&Vector3::new(0.0, 1.0, 0.0)) * Vector3::z();
    let cone = |name: &str, side, vector, turns_with_frame, degrees: f64| {
        let (boresights, half_angle) = (vec![Vector3::z()], degrees.to_radians());
        let directions = vec![Direction { vector, turns_with_frame }];
        let rule = Rule::Pointing(Pointing { side, boresights, directions, half_angle, margin: 0.0 });
        Constraint { name: name.into(), rule }
    };
    let problem = |keep_in: f64, keep_out: f64| {
        Problem::attitude(body.clone(), start, start, duration)
            .with_environment(field.clone())
            .with_constraint(cone("zenith", Side::KeepIn, Vector3::z(), true, keep_in))
            .with_constraint(cone("star", Side::KeepOut, star, false, keep_out))
    };
    assert_eq!(proof(&problem(30.0, 29.0)), None);
    let found = denied(&problem(20.0, 30.0));
    assert!(found.reason.contains("\"zenith\" and \"star\""), "{found}");
    assert!(found.reason.contains("t = 1000 s") && found.reason.contains("10 deg"), "{found}");
}
