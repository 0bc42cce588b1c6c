//! The verdicts of the witnesses on plans that are wrong, incomplete or not finite.

use super::support::*;
use slewkit::Duration;

pub(crate) fn good() -> (Problem, Trajectory) {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0).with_steps(50);
    aimed(problem.clone(), &smooth_inputs(&problem))
}

#[test]
fn wrong_inputs_fail_the_discrete_terminal_check() {
    let (problem, plan) = good();
    assert!(verify(&problem, &plan, 1e-12, None).passed());
    let mut flipped = plan.clone();
    flipped.input.iter_mut().for_each(|u| *u = -*u);
    let mut nudged = plan.clone();
    nudged.input[61] += 1e-6;
    let right = verify(&problem, &plan, 1e-12, None).symplectic_attitude_rad.unwrap();
    for (nudge, seen) in [(1e-6, 1e-9), (1.0, 1e-3)] {
        let mut wrong = plan.clone();
        wrong.input[61] += nudge;
        let wrong = verify(&problem, &wrong, 1e-12, None).symplectic_attitude_rad.unwrap();
        assert!((wrong - right).abs() > seen, "{nudge}: {right:e} {wrong:e}");
    }
    let mut nudged_little = plan;
    nudged_little.input[61] += 1e-9;
    for wrong in [flipped, nudged, nudged_little] {
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(!check(&found, "discrete terminal"), "{found:#?}");
        assert!(!found.passed());
        // The witness of other equations finds an equal difference.
        let apart = (found.symplectic_attitude_rad.unwrap() - found.continuous_attitude_rad).abs();
        assert!(apart < 1e-12, "{found:#?}");
    }
}

#[test]
fn a_plan_for_another_body_field_or_target_fails() {
    let (problem, plan) = good();
    let mut other = problem.clone();
    other.body.inertia = Inertia::new(full_inertia() * 1.001).unwrap();
    let mut target = problem.clone();
    target.end.attitude *= lie::exp(&Vector3::new(1e-9, 0.0, 0.0));
    let field = problem.clone().with_environment(Field::pendulum(Vector3::new(0.0, 0.0, 1e-6)));
    for wrong in [other, target, field] {
        assert!(!check(&verify(&wrong, &plan, 1e-12, None), "discrete terminal"));
    }
    // The sign of the field's moment.
    let p = Vector3::new(0.2, -0.3, 1.5);
    let swung = ballistic(full_inertia(), Vector3::zeros(), 2.0).with_environment(Field::pendulum(p));
    let (swung, plan) = aimed(swung.clone(), &smooth_inputs(&swung));
    assert!(verify(&swung, &plan, 1e-12, None).passed());
    let upside_down = swung.with_environment(Field::pendulum(-p));
    assert!(!verify(&upside_down, &plan, 1e-12, None).passed());
}

#[test]
fn recorded_states_that_are_not_the_motion_fail() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory); 5] = [
        |plan| plan.time[20] += 1e-6,
        |plan| plan.quaternion[20] = [1.0, 0.0, 0.0, 0.0],
        |plan| plan.angular_velocity[20].x += 1e-6,
        |plan| plan.torque[20].z += 1e-6,
        |plan| plan.quaternion[20].iter_mut().for_each(|part| *part *= 1.001),
    ];
    for spoil in spoil {
        let mut wrong = plan.clone();
        spoil(&mut wrong);
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(check(&found, "discrete terminal") && !check(&found, "recorded states"), "{found:#?}");
    }
    let mut same = plan;
    same.quaternion[20].iter_mut().for_each(|part| *part = -*part);
    assert!(verify(&problem, &same, 1e-12, None).passed(), "q and −q are one attitude");
}

#[test]
fn nan_and_infinity_fail_wherever_they_stand() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory, f64); 6] = [
        |plan, bad| plan.input[17] = bad,
        |plan, bad| plan.time[3] = bad,
        |plan, bad| plan.quaternion[3][1] = bad,
        |plan, bad| plan.angular_velocity[3].x = bad,
        |plan, bad| plan.torque[3].x = bad,
        |plan, bad| plan.costates.push(bad),
    ];
    for (index, spoil) in spoil.into_iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut wrong = plan.clone();
            spoil(&mut wrong, bad);
            let found = verify(&problem, &wrong, 1e-12, None);
            assert!(!check(&found, "finite") && !found.passed(), "{index} {bad}: {found:#?}");
            let states = (1..=4).contains(&index);
            assert!(!states || !check(&found, "recorded states"), "{index} {bad}: {found:#?}");
        }
    }
    let mut nan_input = plan.clone();
    nan_input.input[17] = f64::NAN;
    let found = verify(&problem, &nan_input, 1e-12, Some(1.0));
    for name in ["finite", "discrete terminal", "recorded states", "order", "continuous terminal"] {
        assert!(!check(&found, name), "{name}");
    }
    assert!(found.failure.unwrap().contains("no longer finite"));
    let mut thrown = plan.clone();
    thrown.input.fill(1e300);
    let huge = verify(&problem, &thrown, 1e-12, None);
    assert!(!huge.passed());
}

#[test]
fn missing_and_surplus_rows_fail() {
    let (problem, plan) = good();
    let spoil: [fn(&mut Trajectory); 9] = [
        |plan| plan.input.truncate(plan.input.len() - 1),
        |plan| plan.input.extend([0.0; 3]),
        |plan| plan.input_count = 2,
        |plan| plan.time.truncate(plan.time.len() - 1),
        |plan| plan.quaternion.truncate(plan.quaternion.len() - 1),
        |plan| plan.angular_velocity.push(Vector3::zeros()),
        |plan| plan.torque.truncate(plan.torque.len() - 1),
        |plan| plan.position.push(Vector3::zeros()),
        |plan| *plan = Trajectory::default(),
    ];
    for (index, spoil) in spoil.into_iter().enumerate() {
        let mut wrong = plan.clone();
        spoil(&mut wrong);
        let found = verify(&problem, &wrong, 1e-12, None);
        assert!(!found.passed() && found.failure.is_some(), "{index}: {found:#?}");
    }
    assert!(matches!(replay(&problem, &[0.0; 7]), Err(WitnessError::Rows { found: 7, .. })));
}

#[test]
fn continuous_tolerance_is_its_own_check() {
    let (problem, plan) = good();
    let found = verify(&problem, &plan, 1e-12, Some(1e-6));
    assert!(!check(&found, "continuous terminal") && check(&found, "order"), "{found:#?}");
    assert!(verify(&problem, &plan, 1e-12, Some(0.1)).passed());
}

#[test]
fn steps_too_long_and_bad_problems_are_failures_with_reasons() {
    let (mut problem, plan) = good();
    let mut kicked = plan.clone();
    kicked.input.iter_mut().for_each(|u| *u *= 1000.0);
    let found = verify(&problem, &kicked, 1e-12, None);
    assert!(found.failure.as_ref().unwrap().contains("one step"), "{found:#?}");
    assert!(!found.passed());
    problem.duration = Duration::Given(f64::NAN);
    let found = verify(&problem, &plan, 1e-12, None);
    assert!(!found.passed() && found.failure.unwrap().contains("duration"));
    problem.duration = Duration::Given(2.0);
    problem.steps = 0;
    let found = verify(&problem, &plan, 1e-12, None);
    assert!(!found.passed() && found.failure.unwrap().contains("steps"));
}

#[test]
fn a_field_without_a_value_ends_the_simulation_with_its_time() {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0)
        .with_environment(Field::pendulum(Vector3::repeat(f64::NAN)));
    let run = |propagator| {
        let settings = Propagation { propagator, ..Propagation::default() };
        propagate(&problem, &settings, &mut |_: &SimulationRow| ControlFlow::Continue(()))
    };
    assert_eq!(run(Propagator::Verner98), Err(WitnessError::Continuous { time: 0.0 }));
    assert!(matches!(run(Propagator::LieVerlet), Err(WitnessError::NotFinite { .. })));
}

#[test]
fn simulation_hands_out_the_rows_asked_for() {
    let problem = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0);
    for propagator in PROPAGATORS {
        let mut times = vec![];
        let settings = Propagation { propagator, steps: 10, stride: 4, inputs: None };
        propagate(&problem, &settings, &mut |row: &SimulationRow| {
            times.push(row.time);
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(times, [0.0, 0.8, 1.6, 2.0]);
        let mut rows = 0;
        propagate(&problem, &settings, &mut |_: &SimulationRow| {
            rows += 1;
            if rows < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
        .unwrap();
        assert_eq!(rows, 2, "stops when told");
    }
    let settings = Propagation { inputs: Some(&[1.0]), ..Propagation::default() };
    assert!(matches!(
        propagate(&problem, &settings, &mut |_: &SimulationRow| ControlFlow::Continue(())),
        Err(WitnessError::Rows { .. })
    ));
}

/// A field that is not a function of the pose: its moment depends on the number of evaluations.
#[test]
fn witnesses_that_disagree_fail_the_order_check() {
    #[derive(Debug, Default)]
    struct Drifting(std::sync::atomic::AtomicU64);
    impl Environment for Drifting {
        fn potential(&self, _: &Pose) -> f64 {
            0.0
        }
        fn wrench(&self, _: &Pose) -> Wrench {
            let calls = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Wrench { force: Vector3::zeros(), moment: Vector3::new(1e-4 * (calls as f64).sqrt(), 0.0, 0.0) }
        }
        fn gradient(&self, _: &Pose) -> Blocks {
            Blocks::zero()
        }
        fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
            Blocks::zero()
        }
    }
    let (problem, plan) = good();
    let found = verify(&problem.with_environment(Drifting::default()), &plan, 1e-1, None);
    assert!(check(&found, "discrete terminal") && !check(&found, "order"), "{found:#?}");
}

/// Plates and rods, principal moments up to a factor of 1e8 apart, axes askew.
#[test]
fn degenerate_bodies_are_judged_like_others() {
    let tilt = lie::exp(&Vector3::new(0.4, -0.3, 0.5));
    for (moments, steps) in [([1.0, 1.0, 2.0], 80), ([1e-4, 1.0, 1.0], 400), ([1e-8, 1.0, 1.0], 400)] {
        let j = tilt * Matrix3::from_diagonal(&Vector3::from(moments)) * tilt.transpose();
        // Inputs across the thin axis: about it they would spin the rod up beyond any step.
        let across = torques(tilt, AxisFrame::Body).torque.axes()[1..].to_vec();
        let channel = ActuatorSet::new(across, AxisFrame::Body).unwrap();
        for scheme in SCHEMES {
            let problem = ballistic(0.5 * (j + j.transpose()), Vector3::zeros(), 2.0)
                .with_actuation(Actuation::torques(channel.clone()))
                .with_steps(steps)
                .with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-7, None);
            assert!(found.passed(), "{moments:?} {scheme:?}: {found:#?}");
        }
    }
}
