//! Tests of the Galerkin methods against reference steps, the reduced equations, and other degrees.

use super::*;
use crate::mechanics::environment::Pose;
use crate::mechanics::full_body::Potential;
use crate::propagate::integrator::{EulerPoincare, Quadrature};

fn rule(name: &str) -> Quadrature {
    if name.starts_with("gauss") { Quadrature::Gauss } else { Quadrature::Lobatto }
}

#[test]
fn single_steps_meet_the_reference() {
    let file = reference("galerkin.json");
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 12);
    for case in cases {
        let (name, quadrature) = (case["potential"].as_str().unwrap(), case["quadrature"].as_str().unwrap());
        let (system, _) = if name == "free" { free_body() } else { pendulum() };
        let state = super::start(&system, &matrix(&file["R0"]), vector(&file["Pi0"]));
        let degree = case["degree"].as_u64().unwrap() as usize;
        let kind = Kind::Galerkin { degree, quadrature: rule(quadrature) };
        let mut method = method(kind, &system, &state, case["h"].as_f64().unwrap());
        method.step(&[]).unwrap();
        let (pose, momentum) = (method.state().poses()[0], method.state().momenta()[0]);
        let error = (pose.attitude - matrix::<3, 3>(&case["R1"])).amax();
        assert!(error < 1e-13, "{kind} {name}: R {error:e}");
        let error = (momentum.angular - vector::<3>(&case["Pi1"])).amax();
        assert!(error < 1e-13, "{kind} {name}: Π {error:e}");
        // With the exact Jacobian 2–4 iterations suffice.
        assert!((2..=4).contains(&method.work().iterations), "{kind} {name}: {:?}", method.work());
    }
}

#[test]
fn the_reduced_equations_give_the_same_free_body() {
    let (system, state) = free_body();
    for kind in Kind::all() {
        let Kind::Galerkin { degree, quadrature } = kind else { continue };
        let mut full = method(kind, &system, &state, 0.2);
        let mut reduced = EulerPoincare::new(&system.bodies()[0].inertia, degree, quadrature, 0.2).unwrap();
        let (mut attitude, mut momentum) = (state.poses()[0].attitude, state.momenta()[0].angular);
        for _ in 0..50 {
            full.step(&[]).unwrap();
            let step = reduced.step(&momentum).unwrap();
            assert!(step.iterations <= 5, "{kind}: {step:?}");
            attitude += attitude * step.turn;
            momentum = step.momentum;
        }
        assert!((full.state().poses()[0].attitude - attitude).amax() < 1e-13, "{kind}");
        assert!((full.state().momenta()[0].angular - momentum).amax() < 1e-13, "{kind}");
    }
}

/// A moment held in body axes that reports whether it depends on the pose, as chosen.
#[derive(Debug)]
struct Held {
    moment: Vector3,
    quiet: bool,
}

impl Potential for Held {
    fn energy(&self, _: &[Pose]) -> f64 {
        0.0
    }

    fn wrenches(&self, _: &[Pose], wrenches: &mut [Wrench]) {
        wrenches[0] = Wrench { force: Vector3::zeros(), moment: self.moment };
    }

    fn depends_on_poses(&self) -> bool {
        self.quiet
    }
}

/// Claim: if a load is known not to depend on the pose, Newton's method has the exact Jacobian, and
/// two iterations suffice from the first step on.
#[test]
fn a_held_moment_takes_two_iterations_a_step() {
    let moment = Vector3::new(0.3, -0.5, 0.4);
    let motion = |quiet: bool| {
        let system = System::new(vec![attitude_body()], Some(Arc::new(Held { moment, quiet }))).unwrap();
        let state = super::start(&system, &Matrix3::identity(), Vector3::new(0.1, -0.06, 0.08));
        let kind = Kind::Galerkin { degree: 4, quadrature: Quadrature::Gauss };
        let mut method = method(kind, &system, &state, 0.05);
        for _ in 0..20 {
            method.step(&[]).unwrap();
        }
        (method.state().clone(), method.work().iterations)
    };
    let ((told, few), (quiet, more)) = (motion(false), motion(true));
    assert!(distance(&told, &quiet) < 1e-14, "{:e}", distance(&told, &quiet));
    assert!(few <= 40 && more > 40, "{few} {more}");
}
