//! Far away the attraction of every body converges to MacCullagh's formula, and then to a point
//! mass, each at its order.

use super::systems::cloud;
use crate::evidence::Random;
use slewkit::mechanics::body::Inertia;
use slewkit::mechanics::environment::{Environment, Pose, SecondOrderGravity, Wrench};
use slewkit::mechanics::full_body::*;
use slewkit::{Matrix3, Vector3};

fn evaluate(bodies: [Attractor; 2], poses: &[Pose; 2]) -> [Wrench; 2] {
    let mut wrenches = [Wrench::zero(); 2];
    MutualGravity::new(1.0, bodies.to_vec()).unwrap().wrenches(poses, &mut wrenches);
    wrenches
}

/// Poses at a distance of 2, and the bodies shrunk by `scale`.
fn errors(shape: &PointCloud, scale: f64) -> (f64, f64) {
    let mut random = Random::new(3);
    let shrink = |shape: &PointCloud| {
        let points = shape.points().iter();
        let shrunk = points.map(|point| MassPoint { mass: point.mass, position: scale * point.position });
        PointCloud::new(shrunk.collect()).unwrap()
    };
    let small = shrink(shape);
    let poses = [
        Pose { position: Vector3::zeros(), attitude: random.rotation() },
        Pose { position: 2.0 * random.vector().normalize(), attitude: random.rotation() },
    ];
    let second =
        Attractor::SecondOrder { mass: small.mass(), inertia: Inertia::new(small.inertia()).unwrap() };
    let exact = evaluate([Attractor::Cloud(small.clone()), Attractor::Cloud(small)], &poses);
    let approximate = evaluate([second.clone(), second], &poses);
    let force = (exact[0].force - approximate[0].force).norm() / exact[0].force.norm();
    let moment = (exact[0].moment - approximate[0].moment).norm() / exact[0].moment.norm();
    (force, moment)
}

/// Returns the observed order as the size is halved.
fn orders(shape: &PointCloud) -> (f64, f64) {
    let (coarse, fine) = (errors(shape, 0.1), errors(shape, 0.05));
    ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2())
}

#[test]
fn clouds_meet_second_order_at_its_order() {
    let shape = cloud(5, 12);
    let (force, moment) = orders(&shape);
    assert!((force - 3.0).abs() < 0.2, "force {force}");
    assert!((moment - 1.0).abs() < 0.2, "moment {moment}");
    // Symmetric under ρ → −ρ: one order better.
    let both = |point: &MassPoint| [*point, MassPoint { position: -point.position, ..*point }];
    let symmetric = PointCloud::new(shape.points().iter().flat_map(both).collect()).unwrap();
    let (force, moment) = orders(&symmetric);
    assert!((force - 4.0).abs() < 0.2, "force {force}");
    assert!((moment - 2.0).abs() < 0.2, "moment {moment}");
}

#[test]
fn a_second_order_body_and_a_point_are_the_environment_of_that_name() {
    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap();
    let (mu, mass) = (1.9, 0.8);
    let environment = SecondOrderGravity::new(mu, mass, &inertia).unwrap();
    let mut random = Random::new(9);
    let pose = Pose { position: 3.0 * random.vector(), attitude: random.rotation() };
    let body = Attractor::SecondOrder { mass, inertia };
    let origin = Pose { position: Vector3::zeros(), attitude: random.rotation() };
    let expected = environment.wrench(&pose);
    for bodies in [[body.clone(), Attractor::point(mu).unwrap()], [Attractor::point(mu).unwrap(), body]] {
        let first = bodies[0].mass() == mass;
        let poses = if first { [pose, origin] } else { [origin, pose] };
        let found = evaluate(bodies, &poses)[usize::from(!first)];
        assert!((found.force - expected.force).amax() < 1e-15, "{found:?} {expected:?}");
        assert!((found.moment - expected.moment).amax() < 1e-15, "{found:?} {expected:?}");
    }
}

#[test]
fn two_points_attract_as_newton_says() {
    let bodies = || [Attractor::point(3.0).unwrap(), Attractor::point(5.0).unwrap()];
    let at = |x| Pose { position: Vector3::new(x, 0.0, 0.0), attitude: Matrix3::identity() };
    let wrenches = evaluate(bodies(), &[at(-1.0), at(1.0)]);
    assert_eq!(wrenches[0].force, Vector3::new(3.75, 0.0, 0.0));
    assert_eq!(wrenches[1].force, Vector3::new(-3.75, 0.0, 0.0));
    let gravity = MutualGravity::new(1.0, bodies().to_vec()).unwrap();
    assert_eq!(gravity.energy(&[at(-1.0), at(1.0)]), -7.5);
}
