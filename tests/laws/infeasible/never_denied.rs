//! A maneuver that exists is never denied, however close to the limit it is made.

use super::*;

/// Sets every limit to the very values that the plan attains, so that the proofs have all they can
/// use.
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
        ..Limits::default()
    };
    let keep = |random: &mut Random| random.uniform() > 0.0;
    let limits = Limits {
        size: all.size.filter(|_| keep(random)),
        norm: all.norm.filter(|_| keep(random)),
        rate: all.rate.filter(|_| keep(random)),
        ..Limits::default()
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
        let pointing = Pointing::new(
            side,
            vec![random.direction()],
            vec![{
                let vector = random.direction();
                if random.uniform() > 0.0 { Direction::InFrame(vector) } else { Direction::Fixed(vector) }
            }],
            1.0,
        );
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

/// Returns the same with every limit of inputs and rates smaller, but none below the rates of the
/// ends.
fn weakened(problem: &Problem, factor: f64) -> Problem {
    let mut weak = problem.clone();
    let channel = weak.actuation.torque.clone();
    let smaller = |limits: &Option<Vec<f64>>| limits.as_ref().map(|l| l.iter().map(|l| factor * l).collect());
    let limits = channel.limits().clone();
    let limits = Limits {
        size: smaller(&limits.size),
        norm: limits.norm.map(|l| factor * l),
        rate: smaller(&limits.rate),
        ..Limits::default()
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

/// A motion that the witness's own propagation makes within limits is never reported as impossible
/// with exactly these limits. The motions cover bodies of all kinds, both schemes, long steps and
/// short, wheels, fields, turning frames, torques fixed to the reference frame, moving ends, and
/// cones that are just touched.
///
/// `FEASIBLE_CASES` sets how many are drawn, for longer runs.
#[test]
fn a_maneuver_that_exists_is_never_denied() {
    let cases = std::env::var("FEASIBLE_CASES").map_or(6000, |count| count.parse().expect("a number"));
    let mut random = Random::new(2024);
    let (mut tried, mut constrained, mut denied) = (0, 0, [0; 4]);
    for case in 0..cases {
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
                let torque = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
                let unit = body.inertia.mean() / duration;
                let momentum =
                    (0..4).map(|_| if case % 2 == 0 { 0.0 } else { unit * random.uniform() }).collect();
                let wheels = Some(Wheels { momentum, momentum_limit: vec![f64::INFINITY; 4] });
                problem.actuation = Actuation { wheels, ..Actuation::torques(torque) };
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
    println!(
        "{tried} maneuvers that exist, {constrained} with cones: none denied; with less of every limit {denied:?}"
    );
    assert!(tried > 4000 && constrained > 1000, "only {tried} maneuvers, {constrained} with cones");
    // The claims have teeth: with limits a little smaller many of the same maneuvers are denied.
    assert!(denied[0] > 30 && denied[1] > 200 && denied[3] > 2000, "{denied:?} of {tried} are denied");
}

/// Under-actuated bodies next to those with a conserved momentum: a little asymmetry, misalignment
/// or initial rate, made large by hard torques, leads where the conserved quantity would not.
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
            let torque = ActuatorSet::new(axes, AxisFrame::Body).unwrap();
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

/// Returns the factor of the torque limit at which the proof first denies the maneuver: 1 would be
/// a false claim.
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

/// An attack on the proof: hill climbing on the torques of short maneuvers with long steps, towards
/// maneuvers that the proof excludes. It comes near the bound and never reaches it.
#[test]
fn torques_made_to_break_the_bound_do_not() {
    let mut random = Random::new(77);
    let mut nearest = vec![];
    for case in 0..16 {
        let body = random_body(&mut random);
        let steps = 3 + case / 2;
        let start = State::at_rest(Matrix3::identity());
        // The angle ranges from a small fraction of a radian per step to nearly the largest turn of
        // a step.
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
