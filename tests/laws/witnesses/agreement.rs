//! The witnesses describe one motion, at the order of the scheme or to round-off.

use super::support::*;
use super::wrong_plans::good;

/// Free, pendulum, turning gravity gradient; torques in the body and in the reference frame; SE(3)
/// with forces in either frame.
fn assortment() -> Vec<(&'static str, Problem)> {
    let free = ballistic(full_inertia(), Vector3::new(0.3, -0.4, 0.6), 2.0).with_steps(80);
    let pendulum = free.clone().with_environment(Field::pendulum(Vector3::new(0.2, -0.3, 1.5)));
    let turning =
        Field { gradient: (1.0, Vector3::z(), full_inertia()), rate: Vector3::y(), ..Field::none() };
    let mut cases = vec![
        ("free", free.clone()),
        ("pendulum", pendulum.clone()),
        ("reference torques", pendulum.with_actuation(torques(Matrix3::identity(), AxisFrame::Reference))),
        ("turning", free.clone().with_environment(turning)),
        (
            "turning, reference torques",
            free.with_environment(Field { rate: Vector3::new(0.3, 0.9, 0.2), ..Field::none() })
                .with_actuation(torques(full_inertia(), AxisFrame::Reference)),
        ),
    ];
    for frame in [AxisFrame::Body, AxisFrame::Reference] {
        let mut start = State::attitude(lie::exp(&Vector3::x()), Vector3::new(0.3, -0.4, 0.6));
        start.position = Vector3::new(1.0, 0.0, 0.1);
        start.velocity = Vector3::new(0.0, 1.0, 0.2);
        let body = Body { inertia: Inertia::new(full_inertia()).unwrap(), mass: Some(1.3) };
        let mut problem = Problem::rigid_body(body, start, start, 2.0)
            .with_environment(Field { point: 1.3, ..Field::pendulum(Vector3::new(0.2, -0.3, 1.5)) })
            .with_steps(80);
        problem.actuation.force = Some(ActuatorSet::three_axes(frame));
        cases.push((if frame == AxisFrame::Body { "body force" } else { "reference force" }, problem));
    }
    cases
}

#[test]
fn held_torques_converge_at_the_order_of_the_scheme() {
    for (name, problem) in assortment() {
        for scheme in SCHEMES {
            let problem = problem.clone().with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(found.passed(), "{name} {scheme:?}: {found:#?}");
            let (order, expected) = (found.order.unwrap(), f64::from(scheme.order()));
            assert!((order - expected).abs() < 0.15, "{name} {scheme:?}: order {order}");
        }
    }
}

/// Two exact integrators of unlike kinds: another crate's Runge–Kutta pair on quaternions, and a
/// variational method in rotation vectors. Plans of 80 steps, of 8 whose steps it divides, and of
/// 2000.
#[test]
fn the_symplectic_witness_ends_where_the_continuous_one_does() {
    for (name, problem) in assortment() {
        for (scheme, steps) in [(SCHEMES[0], 80), (SCHEMES[1], 80), (SCHEMES[1], 8), (SCHEMES[1], 2000)] {
            let problem = problem.clone().with_scheme(scheme).with_steps(steps);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(check(&found, "symplectic witness"), "{name} {scheme:?} {steps}: {found:#?}");
            let apart = found.symplectic_to_continuous.unwrap();
            assert!(apart < 1e-12, "{name} {scheme:?} {steps}: {apart:e}");
            let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 1e-11;
            assert!(near(found.symplectic_attitude_rad, Some(found.continuous_attitude_rad)));
            assert!(near(found.symplectic_rate_rad_s, Some(found.continuous_rate_rad_s)));
            assert_eq!(found.symplectic_position_m.is_some(), found.continuous_position_m.is_some());
            if found.symplectic_position_m.is_some() {
                assert!(near(found.symplectic_position_m, found.continuous_position_m));
                assert!(near(found.symplectic_velocity_m_s, found.continuous_velocity_m_s));
            }
        }
    }
}

/// The planner evaluates another field than the acting one, because the force is not a function of
/// the pose. The witnesses evaluate it at other places and other times.
#[test]
fn witnesses_that_see_different_fields_do_not_agree() {
    #[derive(Debug, Default)]
    struct Fickle(std::sync::atomic::AtomicU64);
    impl Environment for Fickle {
        fn potential(&self, _: &Pose) -> f64 {
            0.0
        }
        fn wrench(&self, _: &Pose) -> Wrench {
            let calls = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Wrench { force: Vector3::zeros(), moment: Vector3::x() * (1e-6 * (calls / 1000 % 7) as f64) }
        }
        fn gradient(&self, _: &Pose) -> Blocks {
            unreachable!("the witnesses use no derivative")
        }
        fn curvature(&self, _: &Pose, _: &Wrench) -> Blocks {
            unreachable!("the witnesses use no derivative")
        }
    }
    let (problem, plan) = good();
    let found = verify(&problem.with_environment(Fickle::default()), &plan, 1e-3, None);
    assert!(!check(&found, "symplectic witness"), "{found:#?}");
}

/// Halving the plan's own step: mean and linear torque of Verlet and the held torque of Lie–Euler
/// lead the continuous motion to the discrete end at the order of the scheme (theory, section 3).
#[test]
fn continuous_terminal_error_falls_at_the_order_of_the_scheme() {
    for (name, problem) in assortment() {
        for scheme in SCHEMES {
            let found = [160, 320].map(|steps| {
                let problem = problem.clone().with_scheme(scheme).with_steps(steps);
                let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
                verify(&problem, &plan, 1e-12, None)
            });
            let [a, b] = &found;
            let held = (a.continuous_attitude_rad / b.continuous_attitude_rad).log2();
            let linear = (a.interpolated_attitude_rad / b.interpolated_attitude_rad).log2();
            let expected = f64::from(scheme.order());
            assert!((held - expected).abs() < 0.15, "{name} {scheme:?}: held {held}");
            assert!((linear - expected).abs() < 0.15, "{name} {scheme:?}: linear {linear}");
        }
    }
}

#[test]
fn verdict_does_not_depend_on_the_units() {
    // XTE: thousands of kg·m², minutes, 50 N·m; and a cubesat of grams.
    for (size, duration) in [(5000.0, 60.0), (1e-3, 60.0), (1e-3, 1e6), (1e20, 1e-6)] {
        let rate = 2.0 / duration * Vector3::new(0.3, -0.4, 0.6);
        let problem = ballistic(size * full_inertia(), rate, duration).with_steps(200);
        let unit = 4.0 * size / (duration * duration);
        let inputs: Vec<f64> = smooth_inputs(&problem).iter().map(|u| u * unit).collect();
        let (problem, plan) = aimed(problem, &inputs);
        let found = verify(&problem, &plan, 1e-12, Some(0.01));
        assert!(found.passed(), "{size} {duration}: {found:#?}");
        assert!((found.order.unwrap() - 2.0).abs() < 0.1);
    }
}

#[test]
fn coarse_plans_are_judged_on_finer_levels() {
    let mut random = Random::new(7);
    for steps in [4, 6, 8, 10, 14] {
        for scheme in SCHEMES {
            let rate = 1.5 * random.vector();
            let problem = ballistic(full_inertia(), rate, 1.6).with_steps(steps).with_scheme(scheme);
            let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
            let found = verify(&problem, &plan, 1e-12, None);
            assert!(found.passed(), "{steps} {scheme:?} {rate}: {found:#?}");
        }
    }
}

#[test]
fn a_body_left_alone_agrees_to_round_off() {
    let start = State::at_rest(lie::exp(&Vector3::new(0.4, -0.3, 0.5)));
    let problem = Problem::attitude(body(full_inertia()), start, start, 10.0);
    let (problem, plan) = aimed(problem.clone(), &vec![0.0; 303]);
    let found = verify(&problem, &plan, 1e-12, Some(1e-9));
    assert!(found.passed(), "{found:#?}");
    assert_eq!(found.order, None);
    assert!(check(&found, "round-off"));
}

/// Upright and left alone, a pendulum multiplies its round-off by a hundred thousand. Windows begin
/// where the continuous witness has come to, so that this is a motion as any other: there is no
/// disagreement.
#[test]
fn amplified_round_off_is_no_disagreement() {
    let start = State::at_rest(lie::exp(&Vector3::new(0.4, -0.3, 0.5)));
    let upright = -1.7 * (start.attitude.transpose() * Vector3::z());
    let mut strayed = vec![];
    for duration in [10.0, 14.0, 18.0] {
        let problem = Problem::attitude(body(full_inertia()), start, start, duration)
            .with_environment(Field::pendulum(upright));
        let (problem, plan) = aimed(problem.clone(), &vec![0.0; 303]);
        let found = verify(&problem, &plan, 1e-12, None);
        assert!(found.passed() && check(&found, "symplectic witness"), "{found:#?}");
        strayed.push(found.continuous_attitude_rad);
    }
    assert!(strayed.iter().any(|error| *error > 1e-11), "nothing was amplified: {strayed:?}");
}

/// Every witness reports the number of its steps; a witness that cannot judge reports why.
#[test]
fn what_ran_over_how_many_steps_is_on_record() {
    for (steps, covered) in [(10, (10, 1)), (100, (16, 8)), (2000, (64, 8))] {
        let (name, problem) = assortment().swap_remove(0);
        let problem = problem.with_steps(steps);
        let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
        let found = verify(&problem, &plan, 1e-12, None);
        let ran = |witness: &str| {
            let ran = found.witnesses.iter().find(|ran| ran.witness == witness);
            let ran = ran.unwrap_or_else(|| panic!("{name} {steps}: {found:#?}"));
            (ran.steps, ran.windows)
        };
        for whole in ["discrete", "continuous, held torque", "continuous, linear torque"] {
            assert_eq!(ran(whole), (steps, 1));
        }
        assert_eq!((ran("order"), ran("symplectic")), (covered, covered), "{steps}");
    }
}

/// A plan whose witnesses are stopped at their first question or at a later one is not verified,
/// and the reason is reported.
#[test]
fn witnesses_that_are_stopped_do_not_call_a_plan_verified() {
    let problem = good().0.with_steps(2000);
    let (problem, plan) = aimed(problem.clone(), &smooth_inputs(&problem));
    let calls = std::cell::Cell::new(0);
    let count = |stop_at: usize| {
        calls.set(0);
        verify_until(&problem, &plan, 1e-12, None, &|| {
            calls.set(calls.get() + 1);
            calls.get() > stop_at
        })
    };
    assert!(count(usize::MAX).passed());
    let all = calls.get();
    assert!(all > 100, "{all}");
    for stop_at in [0, 1, 50, all / 2] {
        let found = count(stop_at);
        assert!(found.was_stopped() && !found.passed(), "{stop_at}: {found:#?}");
        assert!(found.failure.unwrap().contains("stopped"));
    }
}
