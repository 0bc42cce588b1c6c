//! Tests of rotating frames and of inputs with every method.

use super::*;
use crate::mechanics::environment::{Blocks, CentralGravity, Environment, GravityGradient, PointMass, Pose};

/// A central field in a frame that rotates about its centre, in which the field is unchanged.
#[derive(Debug)]
struct Turning(CentralGravity, Vector3);

impl Environment for Turning {
    fn potential(&self, pose: &Pose) -> f64 {
        self.0.potential(pose)
    }
    fn wrench(&self, pose: &Pose) -> Wrench {
        self.0.wrench(pose)
    }
    fn gradient(&self, pose: &Pose) -> Blocks {
        self.0.gradient(pose)
    }
    fn curvature(&self, pose: &Pose, costates: &Wrench) -> Blocks {
        self.0.curvature(pose, costates)
    }
    fn frame_rate(&self) -> Vector3 {
        self.1
    }
}

/// The motion of a dumbbell about an attracting point, computed in a rotating frame, equals the
/// inertial motion transformed to that frame.
#[test]
fn a_frame_turns_positions_attitudes_and_momenta_alike() {
    let rate = Vector3::new(0.3, -0.4, 0.6);
    let points =
        [1.0, -1.0].map(|end| PointMass { parameter: 0.5, position: end * Vector3::new(0.15, 0.0, 0.05) });
    let field = CentralGravity::new(points.to_vec()).unwrap();
    let body = Body { inertia: full_inertia(), mass: Some(1.0) };
    let inertial = System::single(body.clone(), Arc::new(field.clone())).unwrap();
    let turning = System::single(body, Arc::new(Turning(field, rate))).unwrap();
    let start = State {
        position: Vector3::new(1.0, 0.1, -0.2),
        velocity: Vector3::new(0.1, 0.9, 0.2),
        attitude: lie::exp(&Vector3::new(0.2, -0.1, 0.3)),
        angular_velocity: Vector3::new(0.3, 0.6, -0.2),
    };
    let state = inertial.state(&[start]).unwrap();
    for kind in Kind::all() {
        let mut still = method(kind, &inertial, &state, 0.05);
        let mut turned = method(kind, &turning, &state, 0.05);
        for _ in 0..40 {
            still.step(&[]).unwrap();
            turned.step(&[]).unwrap();
        }
        let back = lie::exp(&(-2.0 * rate));
        let (pose, momentum) = (still.state().poses()[0], still.state().momenta()[0]);
        let expected = SystemState::new(
            vec![Pose { position: back * pose.position, attitude: back * pose.attitude }],
            vec![crate::propagate::integrator::Momentum {
                linear: back * momentum.linear,
                angular: momentum.angular,
            }],
        );
        let error = distance(turned.state(), &expected);
        // Error-controlled methods choose other parts, and iterations stop at other points.
        assert!(error < 2e-12, "{kind}: {error:e}");
        if let Kind::Galerkin { .. } = kind {
            assert!(turned.work().iterations <= 4 * turned.work().steps, "{kind}: {:?}", turned.work());
        }
    }
}

/// All methods converge to the motion under a torque and a force that are smooth in time and are
/// given as linear functions over each step.
#[test]
fn inputs_act_alike_in_every_method() {
    let duration = 1.6;
    let n = 64;
    let h = duration / f64::from(n);
    let inputs: Vec<Input> = (0..n)
        .map(|k| {
            let at = |t: f64| Wrench {
                force: Vector3::new(0.0, 0.0, 0.0),
                moment: Vector3::new((2.0 * t).sin(), 0.5 * t, -(3.0 * t).cos()),
            };
            Input { start: at(f64::from(k) * h), end: at(f64::from(k + 1) * h) }
        })
        .collect();
    let orbit =
        System::single(attitude_body(), Arc::new(GravityGradient::new(0.8, &full_inertia()).unwrap()));
    let free = System::new(vec![Body { inertia: full_inertia(), mass: Some(1.3) }], None).unwrap();
    let start = State {
        position: Vector3::zeros(),
        velocity: Vector3::zeros(),
        attitude: lie::exp(&Vector3::new(0.4, -0.3, 0.5)),
        angular_velocity: Vector3::new(0.3, -0.5, 0.9),
    };
    for (system, moves) in [(orbit.unwrap(), false), (free, true)] {
        let state = system.state(&[start]).unwrap();
        let run = |kind: Kind| {
            let mut method = kind.start(&system, &state, h, &ErrorControl { tolerance: 1e-14 }).unwrap();
            for (k, input) in inputs.iter().enumerate() {
                let mut input = *input;
                if moves {
                    input.start.force = Vector3::new(0.1 * k as f64, 1.0, -0.3);
                    input.end.force = Vector3::new(0.1 * (k + 1) as f64, 1.0, -0.3);
                }
                method.step(&[input]).unwrap();
            }
            method.state().clone()
        };
        let end = run(Kind::Verner98);
        for kind in Kind::all() {
            let error = distance(&run(kind), &end);
            let limit = match kind.facts().order {
                // A half kick is missing at each end: (h/2)|f(T) − f(0)| = 0.08.
                1 => 0.1,
                2 => 1e-3,
                3 => 2e-5,
                4 => 1e-7,
                6 => 1e-11,
                _ => 2e-14,
            };
            assert!(error < limit, "{kind}, moves {moves}: {error:e}");
        }
    }
}
