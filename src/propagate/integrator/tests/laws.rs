//! Tests of the conservation laws of the variational methods: momenta, the symplectic form, and
//! time reversal.

use super::*;
use crate::propagate::integrator::Quadrature;
use nalgebra::DMatrix;

fn variational() -> Vec<Kind> {
    Kind::all().filter(|kind| kind.facts().symplectic).collect()
}

/// Returns a state displaced by (ζ, δΠ) for each body, and by (δx, δγ) for bodies that translate.
fn displaced(system: &System, state: &SystemState, z: &[f64]) -> SystemState {
    let (mut poses, mut momenta) = (state.poses().to_vec(), state.momenta().to_vec());
    let mut parts = z.chunks_exact(3).map(Vector3::from_column_slice);
    for (index, body) in system.bodies().iter().enumerate() {
        poses[index].attitude *= lie::exp(&parts.next().unwrap());
        momenta[index].angular += parts.next().unwrap();
        if body.mass.is_some() {
            poses[index].position += parts.next().unwrap();
            momenta[index].linear += parts.next().unwrap();
        }
    }
    SystemState::new(poses, momenta)
}

/// Returns the displacement between the states `a` and `b`.
fn displacement(system: &System, a: &SystemState, b: &SystemState) -> Vec<f64> {
    let mut z = Vec::new();
    for (index, body) in system.bodies().iter().enumerate() {
        let (pose_a, pose_b) = (a.poses()[index], b.poses()[index]);
        let (momentum_a, momentum_b) = (a.momenta()[index], b.momenta()[index]);
        z.extend(lie::log(&pose_a.attitude.tr_mul(&pose_b.attitude)).iter());
        z.extend((momentum_b.angular - momentum_a.angular).iter());
        if body.mass.is_some() {
            z.extend((pose_b.position - pose_a.position).iter());
            z.extend((momentum_b.linear - momentum_a.linear).iter());
        }
    }
    z
}

/// Returns the canonical form in left-trivialised displacements: `[[−S(Π), I], [−I, 0]]` for an
/// attitude (6.1).
fn form(system: &System, state: &SystemState) -> DMatrix<f64> {
    let size: usize = system.bodies().iter().map(|body| if body.mass.is_some() { 12 } else { 6 }).sum();
    let mut form = DMatrix::zeros(size, size);
    let mut at = 0;
    let pair = |form: &mut DMatrix<f64>, at: usize| {
        form.view_mut((at, at + 3), (3, 3)).copy_from(&Matrix3::identity());
        form.view_mut((at + 3, at), (3, 3)).copy_from(&-Matrix3::identity());
    };
    for (index, body) in system.bodies().iter().enumerate() {
        let twist = -lie::hat(&state.momenta()[index].angular);
        form.view_mut((at, at), (3, 3)).copy_from(&twist);
        pair(&mut form, at);
        at += 6;
        if body.mass.is_some() {
            pair(&mut form, at);
            at += 6;
        }
    }
    form
}

/// Returns the largest violation of `Aᵀ Ω(Π⁺) A = Ω(Π)` by one step, with the derivative A of the
/// step from central differences.
fn twisted(kind: Kind, (system, state): &(System, SystemState), h: f64) -> f64 {
    let step = |state: &SystemState| {
        let mut method = method(kind, system, state, h);
        method.step(&[]).unwrap();
        method.state().clone()
    };
    let end = step(state);
    let size = displacement(system, state, state).len();
    let width = 1e-4;
    let mut a = DMatrix::zeros(size, size);
    for column in 0..size {
        // The differences are of fourth order, so that their error stays below 1e-10.
        let mut sum = vec![0.0; size];
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let mut z = vec![0.0; size];
            z[column] = steps * width;
            let moved = displacement(system, &end, &step(&displaced(system, state, &z)));
            sum.iter_mut().zip(moved).for_each(|(sum, value)| *sum += weight * value / (12.0 * width));
        }
        a.column_mut(column).copy_from_slice(&sum);
    }
    (a.transpose() * form(system, &end) * a - form(system, state)).amax()
}

#[test]
fn a_step_keeps_the_symplectic_form() {
    for kind in variational() {
        for (case, h) in [(free_body(), 0.2), (pendulum(), 0.2), (dumbbells(2.5, 1.0), 0.05)] {
            let error = twisted(kind, &case, h);
            assert!(error < 2e-9, "{kind}: {error:e}");
        }
    }
    // Other methods violate the law, which shows that the test can fail.
    for kind in [Kind::ImplicitMidpoint, Kind::CrouchGrossman2, Kind::MuntheKaas4] {
        let error = twisted(kind, &pendulum(), 0.2);
        assert!(error > 1e-7, "{kind}: {error:e}");
    }
}

/// Symmetric methods return to their start when the momenta are reversed.
#[test]
fn symmetric_methods_are_reversible_in_time() {
    let reversed = |state: &SystemState| {
        let turn = |momentum: &crate::propagate::integrator::Momentum| {
            crate::propagate::integrator::Momentum { linear: -momentum.linear, angular: -momentum.angular }
        };
        SystemState::new(state.poses().to_vec(), state.momenta().iter().map(turn).collect())
    };
    for (system, state) in [free_body(), pendulum(), dumbbells(2.5, 4.0)] {
        let there_and_back = |there: Kind, back: Kind| {
            let mut first = method(there, &system, &state, 0.05);
            (0..100).for_each(|_| first.step(&[]).unwrap());
            let mut second = method(back, &system, &reversed(first.state()), 0.05);
            (0..100).for_each(|_| second.step(&[]).unwrap());
            distance(&reversed(second.state()), &state)
        };
        for kind in variational() {
            // For degrees of 2 and higher the natural chart distinguishes the start of the step
            // from its end.
            let symmetric = !matches!(kind, Kind::Galerkin { degree: 2.., .. });
            // The two Lie–Euler methods are adjoint to each other.
            let back = match kind {
                Kind::LieEuler => Kind::LieEulerAdjoint,
                Kind::LieEulerAdjoint => Kind::LieEuler,
                other => other,
            };
            let error = there_and_back(kind, back);
            assert!(!symmetric || error < 1e-12, "{kind}: {error:e}");
        }
        let unsymmetric = Kind::Galerkin { degree: 2, quadrature: Quadrature::Gauss };
        let error = there_and_back(unsymmetric, unsymmetric);
        assert!(error > 1e-12, "degree 2 is not symmetric after all: {error:e}");
        if system.potential().is_some() {
            assert!(there_and_back(Kind::LieEuler, Kind::LieEuler) > 1e-4, "the test can fail");
        }
    }
}

/// Every variational method conserves these momenta to round-off: the spatial momentum of a free
/// body, its vertical component for the pendulum, and the linear and angular momentum of two
/// bodies.
#[test]
fn momentum_maps_are_kept_to_round_off() {
    for kind in variational() {
        for (name, (system, state), h) in [
            ("free", free_body(), 0.1),
            ("pendulum", pendulum(), 0.1),
            ("dumbbells", dumbbells(2.5, 4.0), 0.02),
        ] {
            let before = system.invariants(&state);
            let mut method = method(kind, &system, &state, h);
            for step in 0..1000 {
                method.step(&[]).unwrap();
                let after = system.invariants(method.state());
                let mut change = after.angular_momentum - before.angular_momentum;
                if name == "pendulum" {
                    (change.x, change.y) = (0.0, 0.0);
                }
                let scale = before.angular_momentum.norm();
                // The Lagrangian form has no compensated momentum.
                let limit = if kind == Kind::LieVerletLagrangian { 1e-12 } else { 5e-14 };
                assert!(change.norm() < limit * scale, "{kind} {name} step {step}: {change:?}");
                assert!(after.linear_momentum.norm() < 2e-15, "{kind} {name} step {step}");
                assert!(after.orthogonality < 1e-13, "{kind} {name} step {step}");
            }
        }
    }
}

/// For s = 3 and N = 16 steps over T = 1.6 the energy error is about 5e-12 and bounded.
#[test]
fn galerkin_energy_errors_are_small_and_bounded() {
    for (system, state) in [free_body(), pendulum()] {
        let before = system.invariants(&state).energy;
        for (degree, limit) in [(1, 2e-2), (2, 2e-5), (3, 2e-8), (4, 2e-11)] {
            for quadrature in [Quadrature::Gauss, Quadrature::Lobatto] {
                let kind = Kind::Galerkin { degree, quadrature };
                let mut method = method(kind, &system, &state, 0.1);
                let mut halves = [0.0, 0.0];
                for step in 0..4000 {
                    method.step(&[]).unwrap();
                    let error = (system.invariants(method.state()).energy - before).abs();
                    if step == 15 && degree == 3 {
                        assert!(error < 2e-11, "{kind}: {error:e}");
                    }
                    let half: &mut f64 = &mut halves[step / 2000];
                    *half = if error <= *half { *half } else { error };
                }
                println!("{kind} {halves:?}");
                assert!(halves[1] < limit && halves[1] < 3.0 * halves[0] + 1e-14, "{kind}: {halves:?}");
            }
        }
    }
}
