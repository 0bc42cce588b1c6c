//! Quantities that relative potentials conserve, and results that do not depend on threads.

use super::systems::{all, cloud, octahedron, poses, solid};
use crate::evidence::Random;
use slewkit::maneuver::problem::State;
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::*;
use slewkit::propagate::integrator::{ErrorControl, Kind, System};
use slewkit::{Vector3, lie};
use std::sync::Arc;

fn wrenches(potential: &dyn Potential, poses: &[Pose]) -> Vec<Wrench> {
    let mut wrenches = vec![Wrench::zero(); poses.len()];
    potential.wrenches(poses, &mut wrenches);
    wrenches
}

#[test]
fn total_force_and_total_moment_vanish_to_round_off() {
    for system in all() {
        let mut random = Random::new(11);
        for _ in 0..20 {
            let poses = poses(&mut random, system.bodies);
            let wrenches = wrenches(system.potential.as_ref(), &poses);
            let pairs = || poses.iter().zip(&wrenches);
            let force: Vector3 = wrenches.iter().map(|wrench| wrench.force).sum();
            let moment: Vector3 =
                pairs().map(|(pose, w)| pose.position.cross(&w.force) + pose.attitude * w.moment).sum();
            let size: f64 = pairs().map(|(pose, w)| (1.0 + pose.position.norm()) * w.force.norm()).sum();
            assert!(force.norm() < 4e-15 * size, "{}: force {:e}", system.name, force.norm() / size);
            assert!(moment.norm() < 4e-15 * size, "{}: moment {:e}", system.name, moment.norm() / size);
        }
    }
}

#[test]
fn energy_depends_on_relative_poses_alone() {
    for system in all() {
        let mut random = Random::new(13);
        let here = poses(&mut random, system.bodies);
        let (shift, turn) = (random.vector(), lie::exp(&random.vector()));
        let there: Vec<Pose> = here
            .iter()
            .map(|pose| Pose { position: turn * pose.position + shift, attitude: turn * pose.attitude })
            .collect();
        let (before, after) = (system.potential.energy(&here), system.potential.energy(&there));
        assert!(
            (before - after).abs() < system.round_off * before.abs(),
            "{}: {before} {after}",
            system.name
        );
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let sizes = [1, 700, 33, 1500, 5];
    let bodies: Vec<_> = sizes.iter().map(|&size| Attractor::Cloud(cloud(size as u64, size))).collect();
    let one = MutualGravity::new(0.9, bodies).unwrap().with_threads(Threads::One);
    let poses = poses(&mut Random::new(17), sizes.len());
    let expected = wrenches(&one, &poses);
    let energy = one.energy(&poses);
    let many = one.clone().with_threads(Threads::Many);
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| wrenches(&many, &poses)), expected, "{threads} threads");
        assert_eq!(pool.install(|| many.energy(&poses)).to_bits(), energy.to_bits(), "{threads} threads");
    }
    // Two evaluations at once: the second finds the buffer taken and works alone.
    let (first, second) = rayon::join(|| wrenches(&many, &poses), || wrenches(&many, &poses));
    assert_eq!(first, expected);
    assert_eq!(second, expected);
}

#[test]
fn a_coarse_cubature_conserves_what_an_exact_one_does() {
    // One Gauss point for each face, at a distance where the third digit of the potential is wrong:
    // an integrator still conserves its invariants.
    let bodies = vec![solid(octahedron(), 1), solid(octahedron(), 1)];
    let rigid = bodies.iter().map(|body| body.body().unwrap()).collect();
    let gravity = Arc::new(MutualGravity::new(1.0, bodies).unwrap());
    let system = System::new(rigid, Some(gravity)).unwrap();
    let at = |x: f64, spin: Vector3| State {
        position: Vector3::new(x, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.45 * x, 0.05),
        attitude: lie::exp(&Vector3::new(0.3 * x, 0.2, 0.5)),
        angular_velocity: spin,
    };
    let start = [at(1.0, Vector3::new(0.3, -0.2, 0.4)), at(-1.0, Vector3::new(0.1, 0.5, -0.2))];
    let start = system.state(&start).unwrap();
    let before = system.invariants(&start);
    let largest_error = |steps: usize| {
        let h = 40.0 / steps as f64;
        let mut method = Kind::LieVerlet.start(&system, &start, h, &ErrorControl::default()).unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..steps {
            method.step(&[]).unwrap();
            worst = worst.max((system.invariants(method.state()).energy - before.energy).abs());
        }
        let after = system.invariants(method.state());
        assert!((after.linear_momentum - before.linear_momentum).norm() < 1e-14);
        assert!((after.angular_momentum - before.angular_momentum).norm() < 2e-14);
        worst
    };
    let (coarse, fine) = (largest_error(2000), largest_error(4000));
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.1 && fine < 1e-4, "{coarse:e} {fine:e}");
}
