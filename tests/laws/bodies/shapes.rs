//! Volume, mass center and inertia of solids, their checks, and points that represent them.

use super::systems::{horseshoe, octahedron, solid, tetrahedron};
use crate::evidence::Random;
use slewkit::mechanics::environment::Pose;
use slewkit::mechanics::full_body::polyhedron::ShapeError;
use slewkit::mechanics::full_body::*;
use slewkit::{Matrix3, Vector3};

fn diagonal(x: f64, y: f64, z: f64) -> Matrix3 {
    Matrix3::from_diagonal(&Vector3::new(x, y, z))
}

#[test]
fn cuboid_and_octahedron_have_their_inertia() {
    let (a, b, c) = (0.7, 0.5, 0.4);
    let shape = octahedron();
    let volume = 4.0 / 3.0 * a * b * c;
    assert!((shape.volume() - volume).abs() < 1e-16);
    let expected = 0.1 * volume * diagonal(b * b + c * c, c * c + a * a, a * a + b * b);
    assert!((shape.unit_inertia() - expected).amax() < 1e-16);
    let cuboid = Polyhedron::cuboid(&Vector3::new(1.0, 2.0, 3.0)).unwrap();
    assert!((cuboid.volume() - 6.0).abs() < 1e-14);
    assert!((cuboid.unit_inertia() - 0.5 * diagonal(13.0, 10.0, 5.0)).amax() < 1e-14);
    assert!(cuboid.is_star_shaped() && shape.is_star_shaped() && !horseshoe().is_star_shaped());
}

#[test]
fn a_tetrahedron_has_its_moments() {
    // ∫ x dV/V is the mean of the corners; ∫ x xᵀ dV/V about it is Σ (corner − mean)(…)ᵀ/20.
    let shape = tetrahedron();
    assert!(shape.center().norm() == 0.0);
    let second = shape.vertices().iter().fold(Matrix3::zeros(), |sum, x| sum + x * x.transpose() / 20.0);
    let expected = shape.volume() * (second.trace() * Matrix3::identity() - second);
    assert!((shape.unit_inertia() - expected).amax() < 1e-17);
}

#[test]
fn moments_follow_shift_turn_and_scale() {
    let mut random = Random::new(21);
    let shape = horseshoe();
    let (shift, turn, scale) = (1e3 * random.vector(), random.rotation(), 1e4);
    let vertices = shape.vertices().iter().map(|x| scale * (turn * x + shift)).collect();
    let moved = Polyhedron::new(vertices, shape.faces().to_vec()).unwrap();
    assert!((moved.volume() / (shape.volume() * scale.powi(3)) - 1.0).abs() < 1e-11);
    assert!((moved.center() - scale * shift).norm() < 1e-12 * scale * shift.norm());
    let expected = turn * shape.unit_inertia() * turn.transpose() * scale.powi(5);
    assert!((moved.unit_inertia() - expected).amax() < 1e-11 * expected.amax());
    // The solid turned to its principal axes has the moments that were computed for these axes.
    let (principal, axes) = moved.principal();
    assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-15);
    assert!((axes.determinant() - 1.0).abs() < 1e-15);
    let again = Polyhedron::new(principal.vertices().to_vec(), principal.faces().to_vec()).unwrap();
    let inertia = again.unit_inertia();
    assert!((inertia - principal.unit_inertia()).amax() < 1e-11 * inertia.amax());
    assert!((inertia - Matrix3::from_diagonal(&inertia.diagonal())).amax() < 1e-11 * inertia.amax());
    assert!(inertia[(0, 0)] <= inertia[(1, 1)] && inertia[(1, 1)] <= inertia[(2, 2)]);
    assert!(again.center().norm() < 1e-11 * again.radius());
}

#[test]
fn gauss_points_have_mass_center_and_inertia_of_the_solid() {
    for shape in [tetrahedron(), octahedron(), horseshoe()] {
        for order in 2..5 {
            let solid = HomogeneousPolyhedron::new(shape.clone(), 2.0, order).unwrap();
            let cloud = solid.cubature();
            assert_eq!(cloud.points().len(), shape.faces().len() * order.pow(3));
            assert!((cloud.mass() / solid.mass() - 1.0).abs() < 1e-13);
            assert!((cloud.inertia() - solid.inertia()).amax() < 1e-13 * solid.inertia().amax());
            let center: Vector3 = cloud.points().iter().map(|point| point.mass * point.position).sum();
            assert!(center.amax() < 1e-14);
            let positive = cloud.points().iter().all(|point| point.mass > 0.0);
            assert_eq!(positive, shape.is_star_shaped());
        }
    }
}

#[test]
fn a_lattice_converges_to_the_solid() {
    let shape = horseshoe();
    let body = HomogeneousPolyhedron::with_mass(shape, 1.1, 1).unwrap();
    let poses = [Vector3::zeros(), Vector3::new(0.9, 0.5, 0.4)]
        .map(|position| Pose { position, attitude: slewkit::lie::exp(&Vector3::new(0.3, 0.2, 0.1)) });
    let error = |body: &HomogeneousPolyhedron, spacing: f64| {
        let cloud = body.lattice(spacing).unwrap();
        assert!((cloud.mass() - 1.1).abs() < 1e-12);
        let energy = |first| {
            let bodies = vec![first, Attractor::point(1.0).unwrap()];
            MutualGravity::new(1.0, bodies).unwrap().energy(&poses)
        };
        let inertia = (cloud.inertia() - body.inertia()).amax() / body.inertia().amax();
        let exact = energy(Attractor::Polyhedron(body.clone()));
        (inertia, (energy(Attractor::Cloud(cloud)) / exact - 1.0).abs())
    };
    let (coarse, fine) = (error(&body, 0.05), error(&body, 0.0125));
    println!("{coarse:?} {fine:?}");
    assert!(coarse.0 / fine.0 > 8.0 && coarse.1 / fine.1 > 8.0, "{coarse:?} {fine:?}");
    // Slanted faces cut cells in two: the count itself is off, and converges unevenly.
    let slanted = HomogeneousPolyhedron::with_mass(octahedron(), 1.1, 1).unwrap();
    let (coarse, fine) = (error(&slanted, 0.08), error(&slanted, 0.01));
    println!("{coarse:?} {fine:?}");
    assert!(coarse.0 / fine.0 > 8.0, "{coarse:?} {fine:?}");
    assert!(fine.0 < 2e-3 && fine.1 < 2e-3);
    // The lattice has as many points as fit: 0.2³·7 by 0.05³, none cut and none twice.
    assert_eq!(body.lattice(0.05).unwrap().points().len(), 448);
}

#[test]
fn what_is_not_a_solid() {
    let vertices = || tetrahedron().vertices().to_vec();
    let faces = || tetrahedron().faces().to_vec();
    let error = |vertices, faces| Polyhedron::new(vertices, faces).unwrap_err();
    let with = |index: usize, face: [u32; 3]| {
        let mut faces = faces();
        faces[index] = face;
        faces
    };
    assert_eq!(
        error(vertices(), with(2, [1, 2, 7])),
        ShapeError::OutOfRange { face: 3, vertex: 8, vertices: 4 }
    );
    assert_eq!(error(vertices(), with(2, [1, 2, 1])), ShapeError::Repeated { face: 3, vertex: 2 });
    assert!(matches!(error(vertices(), with(2, [3, 2, 1])), ShapeError::Orientation { .. }));
    let mut open = faces();
    open.push([0, 1, 2]);
    assert!(matches!(error(vertices(), open), ShapeError::NotManifold { faces: 3, .. }));
    let mut open = horseshoe().faces().to_vec();
    open.pop();
    assert!(matches!(error(horseshoe().vertices().to_vec(), open), ShapeError::Open { .. }));
    let inwards = faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inverted = error(vertices(), inwards);
    assert!(matches!(inverted, ShapeError::Inverted { volume } if volume < 0.0), "{inverted}");
    let flat = vertices().iter().map(|x| Vector3::new(x.x, x.y, 1.0)).collect();
    assert!(matches!(error(flat, faces()), ShapeError::NoVolume { .. }));
    let point = vec![Vector3::repeat(1.0); 4];
    assert!(matches!(error(point, faces()), ShapeError::NoVolume { .. }));
    for bad in [f64::NAN, f64::INFINITY, 1e31] {
        let mut vertices = vertices();
        vertices[1].y = bad;
        assert!(matches!(error(vertices, faces()), ShapeError::Coordinate { vertex: 2, .. }));
    }
    assert!(matches!(error(vec![], vec![]), ShapeError::Count { name: "vertices", count: 0, .. }));
    assert!(Polyhedron::octahedron(&Vector3::new(1.0, 0.0, 1.0)).is_err());
    assert!(Polyhedron::octahedron(&Vector3::new(1.0, -1.0, 1.0)).is_err());
    assert!(Polyhedron::cuboid(&Vector3::new(f64::NAN, 1.0, 1.0)).is_err());
}

#[test]
fn what_is_not_a_homogeneous_body() {
    let error =
        |density, order| HomogeneousPolyhedron::new(octahedron(), density, order).unwrap_err().to_string();
    assert_eq!(error(-1.0, 2), "density is -1; it must be positive");
    assert_eq!(error(1.0, 17), "order of the cubature: 17; the number must be from 1 to 16");
    let vertices = octahedron().vertices().iter().map(|x| x + Vector3::x()).collect();
    let shifted = Polyhedron::new(vertices, octahedron().faces().to_vec()).unwrap();
    let message = HomogeneousPolyhedron::new(shifted.clone(), 1.0, 1).unwrap_err().to_string();
    assert!(message.starts_with("the mass center is at (1, "), "{message}");
    assert!(HomogeneousPolyhedron::new(shifted.centered(), 1.0, 1).is_ok());
    let Attractor::Polyhedron(body) = solid(octahedron(), 1) else { panic!() };
    for (spacing, message) in [
        (0.0, "spacing of the lattice is 0; it must be positive"),
        (1e-4, "points of a lattice: 186666666666; the number must be from 1 to 10000000"),
        (100.0, "points of a lattice: 0; the number must be from 1 to 10000000"),
    ] {
        assert_eq!(body.lattice(spacing).unwrap_err().to_string(), message);
    }
}
