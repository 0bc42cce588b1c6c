//! Tests of the comparison: against the table of an independent calculation for section 3.4 of the
//! survey, and against laws that it must satisfy.

use super::figures::{Outline, figures};
use super::*;
use slewkit::maneuver::State;
use slewkit::mechanics::environment::Pose;
use slewkit::mechanics::full_body::{Dumbbell, Dumbbells};
use slewkit::mechanics::{Body, Inertia};
use slewkit::propagate::integrator::Momentum;
use slewkit::{Matrix3, Vector3, lie};
use std::sync::Arc;

const PAIR: [(f64, f64); 2] = [(1.0, 0.5), (2.0, 1.0)];

fn pair() -> [Dumbbell; 2] {
    PAIR.map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length })
}

/// Returns two dumbbells with G = 1 at the separation 2.5. The second is twice as large as the
/// first, and the spins are multiplied by 4.
fn dumbbells() -> (System, SystemState) {
    let pair = pair();
    let bodies = pair.iter().map(|dumbbell| dumbbell.body().unwrap()).collect();
    let system = System::new(bodies, Some(Arc::new(Dumbbells::new(1.0, &pair).unwrap()))).unwrap();
    let (d, spin) = (2.5, 4.0);
    let state = |part: f64, f: Vector3, rate: Vector3| State {
        position: Vector3::new(part * d, 0.0, 0.0),
        velocity: Vector3::new(0.0, part * (3.0_f64 / d).sqrt(), 0.0),
        attitude: lie::exp(&f),
        angular_velocity: spin * rate,
    };
    let first = state(2.0 / 3.0, Vector3::new(0.2, 0.5, 0.3), Vector3::new(0.3, -0.2, 1.0));
    let second = state(-1.0 / 3.0, Vector3::new(-0.3, 0.1, 0.8), Vector3::new(0.1, 0.4, 0.5));
    let state = system.state(&[first, second]).unwrap();
    (system, state)
}

fn unwatched(_: &StudyProgress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn study() -> Study {
    Study {
        steps: vec![0.04, 0.02],
        horizons: vec![30.0, 300.0],
        levels: vec![1e-4],
        shown_step: 0.04,
        repeats: 1,
        ..Study::survey(0.04, 300.0)
    }
}

/// The table has mean |ΔE|, mean ‖I − RᵀR‖ and the error of the angular momentum over 300 s, from a
/// calculation in Python whose norms and samples are not known. Values other than energies are
/// therefore compared only up to a factor of two, and values of round-off only in that both are
/// round-off.
#[test]
fn four_methods_on_two_dumbbells_meet_an_independent_table() {
    let (system, start) = dumbbells();
    let found = study().run(&system, &start, &mut unwatched).unwrap();
    let table = [
        ("lie_verlet", 0.04, 8.5e-5, None, None),
        ("crouch_grossman_2", 0.04, 2.4e-3, None, Some(2.5e-3)),
        ("explicit_midpoint", 0.04, 3.0e-3, Some(0.97), Some(0.31)),
        ("implicit_midpoint", 0.04, 1.5e-5, None, Some(1.3e-4)),
        ("lie_verlet", 0.02, 2.0e-5, None, None),
        ("crouch_grossman_2", 0.02, 3.0e-4, None, Some(5.5e-4)),
        ("explicit_midpoint", 0.02, 2.9e-4, Some(8.1e-2), Some(1.9e-2)),
        ("implicit_midpoint", 0.02, 3.6e-6, None, Some(3.4e-5)),
    ];
    // The errors in the table are absolute.
    let size =
        |(pose, p): (&Pose, &Momentum)| (pose.position.cross(&p.linear) + pose.attitude * p.angular).norm();
    let momenta: f64 = start.poses().iter().zip(start.momenta()).map(size).sum();
    for (method, step, energy, orthogonality, momentum) in table {
        let run = row(&found, method, step, 300.0);
        let errors = run.errors.unwrap();
        let mean = errors.energy_error_mean * found.energy_scale_j;
        let drift = errors.angular_momentum_error_max * momenta;
        println!("{method:18} {step} {mean:.2e} {:.1e} {drift:.1e}", errors.orthogonality_error_mean);
        assert!((mean / energy - 1.0).abs() < 0.07, "{method} {step}: energy {mean:e}, {energy:e}");
        let like = |value: f64, expected: f64| (0.5..2.0).contains(&(value / expected));
        let found = errors.orthogonality_error_mean;
        // Each step of the implicit rule has an error of the tolerance of its iteration.
        let round_off = if method == "implicit_midpoint" { 1e-13 * run.steps as f64 } else { 1e-12 };
        assert!(
            orthogonality.map_or(found < round_off, |expected| like(found, expected)),
            "{method} {errors:?}"
        );
        assert!(momentum.map_or(drift < 1e-13, |expected| like(drift, expected)), "{method} {errors:?}");
        assert!(errors.linear_momentum_error_max < 1e-13, "{method}: only differences of positions act");
    }
    // The expected numbers of evaluations: one for each step and one at the start; two for each
    // step; one for each iteration.
    for (method, evaluations) in [("lie_verlet", 15_001), ("crouch_grossman_2", 30_000)] {
        assert_eq!(row(&found, method, 0.02, 300.0).force_evaluations, evaluations);
    }
    let run = row(&found, "implicit_midpoint", 0.02, 300.0);
    assert!(run.force_evaluations < run.iterations, "the forces are held while the bodies turn: {run:?}");
}

fn row<'a>(found: &'a WorkPrecision, method: &str, step: f64, horizon: f64) -> &'a IntegratorRun {
    let of = |run: &&IntegratorRun| {
        run.method == method && (run.step_s - step).abs() < 1e-12 && (run.horizon_s - horizon).abs() < 1e-9
    };
    found.runs.iter().find(of).unwrap()
}

/// Returns a run whose numbers follow powers of its step.
fn power(method: &'static str, step: f64, order: i32, cost: f64) -> IntegratorRun {
    IntegratorRun {
        method,
        step_s: step,
        horizon_s: 1.0,
        steps: (1.0 / step) as u64,
        errors: Some(Errors { energy_error_mean: step.powi(order), ..Errors::default() }),
        force_evaluations: (cost / step) as u64,
        iterations: 0,
        time_s: 1e-3 * cost / step,
        failure: None,
    }
}

#[test]
fn work_at_equal_error_is_exact_for_powers_of_the_step() {
    let steps = vec![1.0 / 8.0, 1.0 / 32.0, 1.0 / 128.0, 1.0 / 512.0];
    let (first, second) = (Kind::LieVerlet, Kind::ExplicitMidpoint);
    let study = Study {
        kinds: vec![first, second, Kind::MuntheKaas4],
        levels: vec![0.5_f64.powi(9), 0.5_f64.powi(12), 0.5_f64.powi(24)],
        horizons: vec![1.0],
        shown_step: steps[0],
        steps: steps.clone(),
        ..Study::survey(1.0, 1.0)
    };
    study.check().unwrap();
    // The methods have the orders 2 and 1, and the second needs twice the work; the longest steps
    // of the third fail.
    let mut runs: Vec<IntegratorRun> =
        steps.iter().map(|step| power(first.name(), *step, 2, 4096.0)).collect();
    runs.extend(steps.iter().map(|step| power(second.name(), *step, 1, 8192.0)));
    runs.extend(steps.iter().map(|step| power("rkmk4", *step, 4, 4096.0)));
    for run in &mut runs[8..10] {
        run.errors = None;
    }
    let table = at_equal_error::table(&study, &study.levels, &runs);
    let row = |level: i32, method: &str| {
        let of = |row: &&EqualError| row.energy_error == 0.5_f64.powi(level) && row.method == method;
        table.iter().find(of).unwrap()
    };
    // h = 2^-4.5 and 2^-9: 2^4.5 times the steps, each with twice the work.
    assert_eq!(row(9, "lie_verlet").bound, Bound::Interpolated);
    assert!((row(9, "lie_verlet").step_s.unwrap() / 0.5_f64.powf(4.5) - 1.0).abs() < 1e-12);
    assert!((row(9, "lie_verlet").time_ratio.unwrap() - 1.0).abs() < 1e-12);
    let explicit = row(9, "explicit_midpoint");
    assert_eq!((explicit.bound, explicit.ratio_bound), (Bound::Interpolated, Some(Bound::Interpolated)));
    assert!((explicit.force_evaluation_ratio.unwrap() / 2_f64.powf(5.5) - 1.0).abs() < 1e-12, "{explicit:?}");
    assert!((explicit.time_ratio.unwrap() / 2_f64.powf(5.5) - 1.0).abs() < 1e-12);
    // 2^-12 needs h = 2^-12, which is not among the steps: more than at the shortest.
    let explicit = row(12, "explicit_midpoint");
    assert_eq!((explicit.bound, explicit.ratio_bound), (Bound::AtLeast, Some(Bound::AtLeast)));
    assert!((explicit.time_ratio.unwrap() - 16.0).abs() < 1e-12, "{explicit:?}");
    // If the next longer step fails, the first step that succeeds is the only bound.
    let fourth = row(9, "rkmk4");
    assert_eq!((fourth.bound, fourth.ratio_bound), (Bound::AtMost, Some(Bound::AtMost)));
    assert!((fourth.time_ratio.unwrap() - 2_f64.powf(2.5)).abs() < 1e-12, "{fourth:?}");
    // Neither method reaches this horizon, so no ratio follows.
    assert_eq!(row(24, "explicit_midpoint").ratio_bound, None);
    assert_eq!(row(24, "explicit_midpoint").time_ratio, None);
}

#[test]
fn levels_are_round_numbers_within_reach_of_the_first_method() {
    let steps = vec![0.3, 0.1, 0.03];
    let study = Study {
        kinds: vec![Kind::LieVerlet, Kind::ExplicitMidpoint],
        levels: Vec::new(),
        horizons: vec![1.0],
        shown_step: 0.3,
        steps: steps.clone(),
        ..Study::survey(1.0, 1.0)
    };
    // The levels are from 0.09 to 9e-4; the errors of the second method do not count.
    let mut runs: Vec<IntegratorRun> =
        steps.iter().map(|step| power("lie_verlet", *step, 2, 1000.0)).collect();
    runs.extend(steps.iter().map(|step| power("explicit_midpoint", *step, 6, 1000.0)));
    assert_eq!(at_equal_error::levels(&study, &runs), [3e-2, 1e-2, 3e-3, 1e-3]);
    for run in &mut runs {
        run.errors = None;
    }
    assert!(at_equal_error::levels(&study, &runs).is_empty());
}

#[test]
fn the_survey_can_be_made_for_any_step_and_duration() {
    for (step, duration) in [(0.01, 3200.0), (0.01, 1.0), (0.7, 60.0), (1e-3, 1e6), (3.0, 7.0), (1e9, 1e-3)] {
        let study = Study::survey(step, duration);
        study.check().unwrap_or_else(|error| panic!("{step} {duration}: {error}"));
    }
    let study = Study::survey(0.01, 3200.0);
    assert_eq!(study.steps, [0.16, 0.08, 0.04, 0.02, 0.01, 0.005, 0.0025]);
    assert_eq!(study.horizons, [32.0, 320.0, 3200.0]);
    // 3 s are not a multiple of the step 0.16 s, but 3.04 s are.
    assert!((Study::survey(0.01, 300.0).horizons[0] - 3.04).abs() < 1e-12);
}

#[test]
fn a_step_that_is_good_by_luck_is_no_evidence() {
    let steps = vec![0.5, 0.25, 0.125];
    let study = Study {
        kinds: vec![Kind::LieVerlet],
        levels: vec![0.02],
        horizons: vec![1.0],
        shown_step: 0.5,
        steps: steps.clone(),
        ..Study::survey(1.0, 1.0)
    };
    let mut runs: Vec<IntegratorRun> =
        steps.iter().map(|step| power("lie_verlet", *step, 2, 1000.0)).collect();
    runs[0].errors = Some(Errors { energy_error_mean: 1e-9, ..Errors::default() });
    let table = at_equal_error::table(&study, &study.levels, &runs);
    assert!((0.125..0.25).contains(&table[0].step_s.unwrap()), "{table:?}");
}

#[test]
fn a_method_that_fails_says_when_and_why() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5)).unwrap(), mass: None };
    let system = System::new(vec![body], None).unwrap();
    let state = State::attitude(Matrix3::identity(), Vector3::new(0.1, 1.0, 0.2));
    let start = system.state(&[state]).unwrap();
    let study = Study {
        kinds: vec![Kind::LieVerlet, Kind::ExplicitMidpoint],
        steps: vec![4.0, 0.125],
        horizons: vec![8.0, 4000.0],
        shown_step: 0.125,
        ..Study::survey(1.0, 1.0)
    };
    let found = study.run(&system, &start, &mut unwatched).unwrap();
    let failed = row(&found, "lie_verlet", 4.0, 8.0);
    assert_eq!(failed.errors, None);
    assert!(failed.failure.as_ref().unwrap().starts_with("at t = 4 s: step 4 s is too long"), "{failed:?}");
    // At 1 rad/s, a step of 4 s makes the explicit rule diverge, before or after the first horizon.
    let failed = row(&found, "explicit_midpoint", 4.0, 4000.0);
    assert!(failed.failure.is_some() && failed.errors.is_none(), "{failed:?}");
    let fine = row(&found, "lie_verlet", 0.125, 4000.0);
    assert!(fine.failure.is_none() && fine.errors.unwrap().energy_error_max < 1e-13);
    // A body that only turns has no linear momentum, and no potential to evaluate.
    assert_eq!(fine.errors.unwrap().linear_momentum_error_max, 0.0);
    assert_eq!(fine.force_evaluations, 0);
    assert!(figures("free body", &study, &found, &[]).iter().all(|figure| !figure.svg.contains("NaN")));
}

#[test]
fn a_study_that_makes_no_sense_is_refused() {
    let good = study();
    good.check().unwrap();
    let order = |study: &Study| matches!(study.check(), Err(StudyError::Order { .. }));
    assert!(order(&Study { steps: vec![0.01, 0.02], ..good.clone() }));
    assert!(order(&Study { horizons: vec![300.0, 30.0], ..good.clone() }));
    assert!(order(&Study { levels: vec![1e-3, f64::NAN], ..good.clone() }));
    assert!(order(&Study { horizons: vec![f64::INFINITY], ..good.clone() }));
    assert!(order(&Study { steps: vec![-0.02], ..good.clone() }));
    assert!(matches!(Study { kinds: vec![], ..good.clone() }.check(), Err(StudyError::Count { .. })));
    let error = Study { steps: vec![0.7], shown_step: 0.7, ..good.clone() }.check().unwrap_err();
    assert!(error.to_string().starts_with("the step 0.7 s does not divide the horizon 30 s"), "{error}");
    let many = Study { steps: vec![1e-12], shown_step: 1e-12, ..good.clone() };
    assert!(matches!(many.check(), Err(StudyError::TooManySteps { .. })));
    assert_eq!(Study { shown_step: 0.03, ..good }.check(), Err(StudyError::ShownStep { step: 0.03 }));
}

#[test]
fn a_study_stops_when_told_to_and_keeps_what_it_has() {
    let (system, start) = dumbbells();
    let mut looks = 0;
    let mut watch = |progress: &StudyProgress| {
        looks += 1;
        if progress.runs.0 == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found = study().run(&system, &start, &mut watch).unwrap();
    assert!(found.interrupted && looks > 1);
    assert_eq!(found.runs.len(), 2, "one step to two horizons");
}

#[test]
fn figures_are_wellformed_and_hold_every_method() {
    let (system, start) = dumbbells();
    let study = Study { horizons: vec![16.0, 32.0], ..study() };
    let found = study.run(&system, &start, &mut unwatched).unwrap();
    let outlines: Vec<_> =
        pair().iter().enumerate().map(|(i, d)| Outline::dumbbell(format!("<{i}> & \u{1}"), d)).collect();
    let figures = figures("two \"dumbbells\"", &study, &found, &outlines);
    assert_eq!(figures.len(), 10);
    for figure in &figures {
        assert!(!figure.svg.contains("NaN") && !figure.svg.contains("inf"), "{}", figure.name);
        let tags = figure.svg.matches('<').count();
        let (closed, whole) = (figure.svg.matches("</").count(), figure.svg.matches("/>").count());
        assert_eq!(tags, 2 * closed + whole, "{}: every element ends", figure.name);
        assert!(figure.svg.contains("two &quot;dumbbells&quot;"));
        if figure.name != "trajectories" {
            for kind in Study::SURVEY {
                assert!(figure.svg.contains(kind.name()), "{}: {kind}", figure.name);
            }
        }
    }
    assert!(figures[0].svg.contains("&lt;1&gt; &amp; \u{fffd}"));
    // Eight snapshots of two balls each, and a legend.
    assert_eq!(figures[0].svg.matches("<circle").count(), 2 * (8 * 2 + 1));
}
