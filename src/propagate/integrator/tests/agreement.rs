//! Tests that two independent methods compute the same motion.

use super::*;
use crate::maneuver::problem::Problem;
use crate::mechanics::environment::GravityGradient;
use crate::propagate::simulate::SimulationRow;
use crate::verify::propagation::{self, Propagator};
use std::ops::ControlFlow;

/// The orbital frame rotates relative to the inertial axes. The witnesses use inertial axes and
/// another method.
#[test]
fn a_turning_frame_agrees_with_the_inertial_treatment() {
    let field = GravityGradient::new(1.0, &full_inertia()).unwrap();
    let body = attitude_body();
    let start = State::attitude(lie::exp(&Vector3::new(0.2, -0.1, 0.3)), Vector3::new(0.1, 1.1, -0.2));
    let system = System::single(body.clone(), Arc::new(field.clone())).unwrap();
    let problem = Problem::attitude(body, start, start, 5.0).with_environment(field);
    let settings =
        propagation::Propagation { propagator: Propagator::LieVerlet, steps: 500, stride: 500, inputs: None };
    let mut rows = Vec::new();
    propagation::propagate(&problem, &settings, &mut |row: &SimulationRow| {
        rows.push(row.clone());
        ControlFlow::Continue(())
    })
    .unwrap();
    let state = system.state(&[start]).unwrap();
    for kind in [Kind::LieVerlet, Kind::LieVerletLagrangian] {
        let mut method = method(kind, &system, &state, 0.01);
        for _ in 0..500 {
            method.step(&[]).unwrap();
        }
        let (pose, last) = (method.state().poses()[0], rows.last().unwrap());
        let error = (pose.attitude - lie::rotation_from_quaternion(&last.bodies[0].quaternion)).amax();
        assert!(error < 1e-13, "{kind}: {error:e}");
        let energy = system.invariants(method.state()).energy;
        assert!((energy - last.invariants.energy).abs() < 1e-13);
        assert!((energy - rows[0].invariants.energy).abs() < 1e-4, "Jacobi's integral");
    }
}

#[test]
fn both_forms_of_verlet_are_one_map() {
    for (system, state) in [free_body(), pendulum(), dumbbells(2.5, 4.0)] {
        let mut hamiltonian = method(Kind::LieVerlet, &system, &state, 0.02);
        let mut lagrangian = method(Kind::LieVerletLagrangian, &system, &state, 0.02);
        let input = |k: f64| {
            let moment = 1e-3 * Vector3::new(k, -0.1, 0.2);
            let wrench = Wrench { force: Vector3::new(0.01, k, 0.0), moment };
            vec![
                Input { start: wrench, end: Wrench { moment: 1.5 * wrench.moment, ..wrench } };
                system.bodies().len()
            ]
        };
        for k in 0..100 {
            let inputs = input(0.01 * f64::from(k));
            hamiltonian.step(&inputs).unwrap();
            lagrangian.step(&inputs).unwrap();
        }
        let error = distance(hamiltonian.state(), lagrangian.state());
        assert!(error < 2e-13, "{error:e}");
    }
}

/// Velocity Verlet in Π equals Lie–Euler in the variable `Π̃ = Π + (h/2) M` in every step.
#[test]
fn lie_euler_is_conjugate_to_verlet_by_half_kicks() {
    for (system, state) in [pendulum(), dumbbells(2.5, 4.0)] {
        let h = 0.02;
        let n = system.bodies().len();
        let half_kick = |state: &SystemState, weight: f64| {
            let mut wrenches = vec![Wrench::zero(); n];
            system.potential().unwrap().wrenches(state.poses(), &mut wrenches);
            let mut kicked = state.clone();
            kicked.kick(system.bodies(), weight, &wrenches).unwrap();
            kicked
        };
        let mut verlet = method(Kind::LieVerlet, &system, &state, h);
        let mut euler = method(Kind::LieEuler, &system, &half_kick(&state, 0.5 * h), h);
        let mut adjoint = method(Kind::LieEulerAdjoint, &system, &half_kick(&state, -0.5 * h), h);
        for k in 1..=300 {
            verlet.step(&[]).unwrap();
            euler.step(&[]).unwrap();
            adjoint.step(&[]).unwrap();
            let error = distance(&half_kick(verlet.state(), 0.5 * h), euler.state());
            assert!(error < 1e-12, "step {k}: {error:e}");
            let error = distance(&half_kick(verlet.state(), -0.5 * h), adjoint.state());
            assert!(error < 1e-12, "adjoint, step {k}: {error:e}");
        }
    }
}
