//! Force and moment of every potential against differences of its energy.

use super::systems::{all, poses};
use crate::evidence::Random;
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::{Vector3, lie};

/// The step of the differences by the fourth-order formula. Their truncation `h⁴ f⁽⁵⁾/30` is below
/// 1e-11 at these distances, and their round-off is the round-off of the energy over the step.
const STEP: f64 = 1e-3;
const TRUNCATION: f64 = 1e-11;

/// Returns `d/dt` at 0 by the five-point formula.
fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(STEP) - f(-STEP)) - (f(2.0 * STEP) - f(-2.0 * STEP))) / (12.0 * STEP)
}

fn moved(poses: &[Pose], body: usize, change: impl Fn(&mut Pose)) -> Vec<Pose> {
    let mut poses = poses.to_vec();
    change(&mut poses[body]);
    poses
}

#[test]
fn force_and_moment_are_the_negative_gradient_of_the_energy() {
    for system in all() {
        let mut random = Random::new(7);
        for _ in 0..4 {
            let poses = poses(&mut random, system.bodies);
            let mut wrenches = vec![Wrench::zero(); system.bodies];
            system.potential.wrenches(&poses, &mut wrenches);
            let size = wrenches.iter().map(|wrench| wrench.force.amax()).fold(0.0, f64::max);
            for (body, wrench) in wrenches.iter().enumerate() {
                for axis in 0..3 {
                    let along = Vector3::ith(axis, 1.0);
                    let energy = |poses: Vec<Pose>| system.potential.energy(&poses);
                    let force =
                        -derivative(|t| energy(moved(&poses, body, |pose| pose.position += t * along)));
                    let turn = |t: f64| lie::exp(&(t * along));
                    let moment =
                        -derivative(|t| energy(moved(&poses, body, |pose| pose.attitude *= turn(t))));
                    for (name, difference, value) in
                        [("force", force, wrench.force[axis]), ("moment", moment, wrench.moment[axis])]
                    {
                        let error = (difference - value).abs() / size;
                        let tolerance = TRUNCATION + system.round_off / STEP;
                        assert!(error < tolerance, "{} {name} {body} {axis}: {error:e}", system.name);
                    }
                }
            }
        }
    }
}
