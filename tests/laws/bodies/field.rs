//! The field of a polyhedron against closed forms, limits and other roads.

use super::systems::{horseshoe, octahedron, tetrahedron};
use crate::evidence::Random;
use slewkit::Vector3;
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::polyhedron::PolyhedronField;
use slewkit::mechanics::full_body::*;
use std::f64::consts::PI;

/// Returns `∫ dV/|r|` of a cuboid with its center at the origin, as a sum over its corners (Nagy
/// 1966, Seidov 2000).
fn cuboid_potential(edges: &Vector3, point: &Vector3) -> f64 {
    let mut sum = 0.0;
    for corner in 0..8 {
        let side = |axis: usize| if corner >> axis & 1 == 1 { 0.5 } else { -0.5 };
        let [x, y, z] = [0, 1, 2].map(|axis| side(axis) * edges[axis] - point[axis]);
        let r = (x * x + y * y + z * z).sqrt();
        let plane = |a: f64, b: f64, c: f64| a * b * (c + r).ln() - 0.5 * c * c * (a * b / (c * r)).atan();
        let sign = 8.0 * side(0) * side(1) * side(2);
        sum += sign * (plane(x, y, z) + plane(y, z, x) + plane(z, x, y));
    }
    sum
}

#[test]
fn cube_has_its_published_field() {
    // Example of the skulumani/polyhedron_gravity package for the unit cube at (1, 2, 3), G =
    // 6.67408e-11, density 1e6 kg/m³.
    let cube = PolyhedronField::new(&Polyhedron::cuboid(&Vector3::repeat(1.0)).unwrap());
    let point = Vector3::new(1.0, 2.0, 3.0);
    assert!((cube.potential(&point) / 0.26726619638669064 - 1.0).abs() < 2e-14);
    let published = Vector3::new(-1.273782722739791e-06, -2.548008881415967e-06, -3.823026510474731e-06);
    let found = 6.67408e-11 * 1e6 * cube.attraction(&point);
    assert!((found - published).amax() < 1e-14 * published.amax(), "{found}");
    // The potential at the center is 3 ln((√3 + 1)/(√3 − 1)) − π/2.
    let root = 3.0_f64.sqrt();
    let center = 3.0 * ((root + 1.0) / (root - 1.0)).ln() - 0.5 * PI;
    assert!((cube.potential(&Vector3::zeros()) - center).abs() < 1e-14);
    assert!(cube.attraction(&Vector3::zeros()).amax() < 1e-15);
}

#[test]
fn cuboid_has_its_closed_form() {
    let edges = Vector3::new(1.0, 0.6, 1.7);
    let field = PolyhedronField::new(&Polyhedron::cuboid(&edges).unwrap());
    let mut random = Random::new(2);
    let on_axis = [0.1, 0.7, 1.3, 2.0].map(|x| Vector3::new(x, 0.0, 0.0)).into_iter();
    for point in on_axis.chain((0..50).map(|_| 2.0 * random.vector())) {
        let expected = cuboid_potential(&edges, &point);
        let found = field.potential(&point);
        assert!((found - expected).abs() < 3e-14 * expected, "{point}: {found} {expected}");
    }
}

#[test]
fn attraction_is_the_gradient_and_laplacian_its_divergence() {
    const STEP: f64 = 1e-3;
    let difference = |f: &dyn Fn(f64) -> f64| {
        (8.0 * (f(STEP) - f(-STEP)) - (f(2.0 * STEP) - f(-2.0 * STEP))) / (12.0 * STEP)
    };
    let mut random = Random::new(3);
    for shape in [tetrahedron(), horseshoe(), octahedron()] {
        let field = PolyhedronField::new(&shape);
        for _ in 0..20 {
            // Above the body, but close enough for fifth derivatives of about 1e4: truncation
            // 3e-10 and more for the derivatives of the attraction.
            let point = (1.2 + 0.5 * random.uniform()) * random.direction();
            let mut divergence = 0.0;
            for axis in 0..3 {
                let along = Vector3::ith(axis, 1.0);
                let slope = difference(&|t| field.potential(&(point + t * along)));
                assert!((slope - field.attraction(&point)[axis]).abs() < 3e-10);
                divergence += difference(&|t| field.attraction(&(point + t * along))[axis]);
            }
            assert!(divergence.abs() < 2e-9, "{divergence:e}");
            assert!(field.laplacian(&point).abs() < 1e-13);
        }
    }
    let cube = PolyhedronField::new(&Polyhedron::cuboid(&Vector3::repeat(2.0)).unwrap());
    for _ in 0..20 {
        let point = 0.5 * random.vector();
        assert!((cube.laplacian(&point) + 4.0 * PI).abs() < 1e-13);
        let along = |axis| Vector3::ith(axis, 1.0);
        let divergence: f64 =
            (0..3).map(|axis| difference(&|t| cube.attraction(&(point + t * along(axis)))[axis])).sum();
        assert!((divergence + 4.0 * PI).abs() < 1e-9, "{divergence}");
    }
}

#[test]
fn field_is_finite_and_continuous_on_faces_edges_and_corners() {
    let field = PolyhedronField::new(&Polyhedron::cuboid(&Vector3::repeat(2.0)).unwrap());
    let mut random = Random::new(4);
    for point in [[1.0, 0.2, 0.3], [1.0, 1.0, 0.3], [1.0, 1.0, 1.0], [1.0, 0.25, 0.25], [-1.0, 1.0, 0.0]] {
        let point = Vector3::from(point);
        let (u, g) = (field.potential(&point), field.attraction(&point));
        assert!(u.is_finite() && g.iter().all(|component| component.is_finite()), "{point}");
        let near = point + 1e-9 * random.vector();
        assert!((field.potential(&near) - u).abs() < 1e-7, "{point}");
        // Near an edge the attraction varies like d ln d.
        assert!((field.attraction(&near) - g).amax() < 1e-6, "{point}");
    }
}

#[test]
fn parts_attract_as_the_whole() {
    // The horseshoe is three bars.
    let whole = horseshoe();
    let bars = [
        ([0.3, 0.1, 0.1], [0.6, 0.2, 0.2]),
        ([0.1, 0.4, 0.1], [0.2, 0.4, 0.2]),
        ([0.5, 0.4, 0.1], [0.2, 0.4, 0.2]),
    ];
    let mut random = Random::new(6);
    let field = PolyhedronField::new(&whole);
    for _ in 0..30 {
        let point = random.vector();
        let sum: f64 = bars
            .iter()
            .map(|(center, edges)| {
                let relative = point + whole_center() - Vector3::from(*center);
                cuboid_potential(&Vector3::from(*edges), &relative)
            })
            .sum();
        assert!((field.potential(&point) - sum).abs() < 1e-13, "{point}");
    }
}

/// Returns the mass center of the horseshoe as drawn: bars of 3, 2 and 2 cubes of 0.2 m.
fn whole_center() -> Vector3 {
    0.2 * (3.0 * Vector3::new(1.5, 0.5, 0.5)
        + 2.0 * Vector3::new(0.5, 2.0, 0.5)
        + 2.0 * Vector3::new(2.5, 2.0, 0.5))
        / 7.0
}

#[test]
fn a_face_without_area_changes_nothing() {
    // The edge from 0 to 1 of a tetrahedron has a vertex 4 in the middle, which one side alone
    // knows; a triangle without area closes the gap.
    let plain = tetrahedron();
    let mut vertices = plain.vertices().to_vec();
    vertices.push(0.5 * (vertices[0] + vertices[1]));
    let faces = vec![[0, 2, 1], [0, 4, 3], [4, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 4]];
    let split = Polyhedron::new(vertices, faces).unwrap();
    assert!((split.volume() / plain.volume() - 1.0).abs() < 1e-15);
    let (plain, split) = (PolyhedronField::new(&plain), PolyhedronField::new(&split));
    let mut random = Random::new(8);
    for _ in 0..30 {
        let point = random.vector();
        let error = (plain.potential(&point) - split.potential(&point)).abs();
        assert!(error < 1e-14, "{error:e}");
        assert!((plain.attraction(&point) - split.attraction(&point)).amax() < 1e-13);
    }
}

/// Returns an octahedron whose faces are repeatedly divided in four, with its vertices on the unit
/// sphere.
fn sphere(cuts: usize) -> Polyhedron {
    let shape = Polyhedron::octahedron(&Vector3::repeat(1.0)).unwrap();
    let (mut vertices, mut faces) = (shape.vertices().to_vec(), shape.faces().to_vec());
    for _ in 0..cuts {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(p, q): (u32, u32)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    vertices.push((vertices[p as usize] + vertices[q as usize]).normalize());
                    vertices.len() as u32 - 1
                })
            });
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        faces = finer;
    }
    Polyhedron::new(vertices, faces).unwrap()
}

#[test]
fn finer_and_finer_polyhedra_attract_as_a_sphere() {
    let point = Vector3::new(0.9, -0.7, 1.1);
    let inside = Vector3::new(0.1, 0.3, -0.2);
    let errors: Vec<[f64; 3]> = (2..6)
        .map(|cuts| {
            let shape = sphere(cuts);
            let field = PolyhedronField::new(&shape);
            let newton = -4.0 / 3.0 * PI / point.norm().powi(3) * point;
            let within = -4.0 / 3.0 * PI * inside;
            [
                (shape.volume() - 4.0 / 3.0 * PI).abs(),
                (field.attraction(&point) - newton).norm(),
                (field.attraction(&inside) - within).norm(),
            ]
        })
        .collect();
    // Edges halve: second order in their length.
    for pair in errors.windows(2).skip(1) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            let order = (coarse / fine).log2();
            assert!((1.8..2.3).contains(&order), "{errors:?}");
        }
    }
}

/// Returns force and moment on the first body.
fn exchange(bodies: [Attractor; 2], poses: &[Pose; 2]) -> Wrench {
    let mut wrenches = [Wrench::zero(); 2];
    MutualGravity::new(1.0, bodies.to_vec()).unwrap().wrenches(poses, &mut wrenches);
    wrenches[0]
}

#[test]
fn far_away_a_polyhedron_is_a_point_and_then_second_order() {
    let mut random = Random::new(10);
    let attitude = random.rotation();
    let direction = random.direction();
    for (shape, point_order, maccullagh_order) in [(tetrahedron(), 2.0, 3.0), (octahedron(), 2.0, 4.0)] {
        let solid = HomogeneousPolyhedron::new(shape, 1.3, 1).unwrap();
        let inertia = slewkit::mechanics::body::Inertia::new(solid.inertia()).unwrap();
        let errors = |distance: f64| {
            let poses = [
                Pose { position: Vector3::zeros(), attitude },
                Pose { position: distance * direction, attitude: nalgebra::Matrix3::identity() },
            ];
            let against = |body: Attractor| exchange([body, Attractor::point(2.0).unwrap()], &poses);
            let exact = against(Attractor::Polyhedron(solid.clone()));
            let second = against(Attractor::SecondOrder { mass: solid.mass(), inertia: inertia.clone() });
            let point = against(Attractor::point(solid.mass()).unwrap());
            let size = exact.force.norm();
            [
                (exact.force - point.force).norm() / size,
                (exact.force - second.force).norm() / size,
                (exact.moment - second.moment).norm() / exact.moment.norm(),
            ]
        };
        let (near, far) = (errors(8.0), errors(16.0));
        let expected = [point_order, maccullagh_order, maccullagh_order - 2.0];
        for ((near, far), expected) in near.iter().zip(far).zip(expected) {
            let order = (near / far).log2();
            assert!((order - expected).abs() < 0.2, "{order} {expected}");
        }
    }
}

#[test]
fn cancellation_far_away_is_as_stated() {
    // r² l/V ulps of the attraction: against a cubature of degree 23, exact there to round-off,
    // face by face.
    let solid = HomogeneousPolyhedron::new(octahedron(), 1.0, 12).unwrap();
    let direction = Random::new(12).direction();
    for distance in [3.0, 10.0, 100.0, 1000.0] {
        let y = distance * direction;
        let pull = |point: &MassPoint| {
            let d = point.position - y;
            point.mass / d.norm().powi(3) * d
        };
        let rows = solid.cubature().points().chunks(12);
        let planes: Vec<Vector3> = rows.map(|row| row.iter().map(pull).sum()).collect();
        let faces: Vec<Vector3> = planes.chunks(144).map(|planes| planes.iter().sum()).collect();
        let cloud: Vector3 = faces.iter().sum();
        let error = (solid.attraction(&y) - cloud).norm() / cloud.norm();
        println!("{distance}: {error:e}");
        let stated = f64::EPSILON * distance.powi(2) * 1.4 / solid.shape().volume();
        assert!(error < 5e-15 + 2.0 * stated, "{distance}: {error:e} {stated:e}");
    }
}

/// Relative pose with the octahedra about a third of a radius apart.
fn close_poses() -> [Pose; 2] {
    let mut random = Random::new(14);
    [Vector3::zeros(), Vector3::new(1.3, 0.4, -0.3)]
        .map(|position| Pose { position, attitude: random.rotation() })
}

#[test]
fn two_polyhedra_converge_geometrically_and_to_the_same_from_both_sides() {
    let small = Polyhedron::octahedron(&Vector3::new(0.5, 0.4, 0.3)).unwrap();
    let poses = close_poses();
    let energy = |order: usize| {
        let bodies = [octahedron(), small.clone()];
        let solids =
            bodies.map(|shape| Attractor::Polyhedron(HomogeneousPolyhedron::new(shape, 1.0, order).unwrap()));
        MutualGravity::new(1.0, solids.to_vec()).unwrap().energy(&poses)
    };
    // The other way about: the exact field of the small one over the points of the large one.
    let reverse = |order: usize| {
        let field = Attractor::Polyhedron(HomogeneousPolyhedron::new(small.clone(), 1.0, 1).unwrap());
        let large = HomogeneousPolyhedron::new(octahedron(), 1.0, order).unwrap();
        let cloud = Attractor::Cloud(PointCloud::new(large.cubature().points().to_vec()).unwrap());
        MutualGravity::new(1.0, vec![cloud, field]).unwrap().energy(&poses)
    };
    let exact = energy(16);
    assert!((reverse(16) / exact - 1.0).abs() < 1e-13);
    let errors: Vec<f64> = (1..8).map(|order| (energy(order) / exact - 1.0).abs()).collect();
    println!("{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.35 * pair[0], "{errors:?}");
    }
    assert!(errors[0] < 0.05 && errors[6] < 1e-8, "{errors:?}");
}
