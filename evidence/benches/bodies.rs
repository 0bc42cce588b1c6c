//! The cost of one evaluation of the mutual gravity, force and moment on every body, and of one
//! step of all bodies.
//!
//! The throughput column counts interactions: pairs of points, or a face of a polyhedron and a
//! point. `serial` is on the calling thread, `parallel` on all threads; the library takes the
//! faster of the two by size.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use slewkit::maneuver::problem::State;
use slewkit::mechanics::body::Body;
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::*;
use slewkit::propagate::integrator::{ErrorControl, Kind, System};
use slewkit::{Vector3, lie};
use std::sync::Arc;

fn main() {
    divan::main();
}

/// Vectors that fill the cube [−1, 1)³ evenly.
fn scattered(index: usize) -> Vector3 {
    Vector3::from_fn(|axis, _| 2.0 * (index as f64 * [0.819, 0.671, 0.549][axis]).fract() - 1.0)
}

/// Returns poses of bodies on a lattice, far enough apart.
fn poses(bodies: usize) -> Vec<Pose> {
    let place = |k: usize| Vector3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64);
    let pose = |k| Pose { position: 4.0 * place(k), attitude: lie::exp(&(2.0 * scattered(k + 7))) };
    (0..bodies).map(pose).collect()
}

fn cloud(points: usize) -> Attractor {
    let point = |k| MassPoint { mass: 1.0 / points as f64, position: scattered(k) };
    Attractor::Cloud(PointCloud::centered((0..points).map(point).collect()).unwrap().0)
}

fn evaluate(bencher: Bencher, potential: &dyn Potential, bodies: usize, interactions: usize) {
    let (poses, mut wrenches) = (poses(bodies), vec![Wrench::zero(); bodies]);
    bencher
        .counter(ItemsCount::new(interactions))
        .bench_local(|| potential.wrenches(black_box(&poses), black_box(&mut wrenches)));
}

fn clouds(bencher: Bencher, (bodies, points): (usize, usize), threads: Threads) {
    let gravity = MutualGravity::new(1.0, vec![cloud(points); bodies]).unwrap().with_threads(threads);
    evaluate(bencher, &gravity, bodies, bodies * (bodies - 1) / 2 * points * points);
}

/// Bodies and points per body. The cost is proportional to the square of both: 10 bodies of 10⁴
/// points, or 100 of 10³, take 100 times as long as the largest here.
const CLOUDS: [(usize, usize); 10] = [
    (2, 1),
    (2, 10),
    (2, 100),
    (2, 1_000),
    (2, 10_000),
    (10, 1),
    (10, 100),
    (10, 1_000),
    (100, 1),
    (100, 100),
];

#[divan::bench(args = CLOUDS, max_time = 2)]
fn clouds_serial(bencher: Bencher, size: (usize, usize)) {
    clouds(bencher, size, Threads::One);
}

#[divan::bench(args = CLOUDS, max_time = 2)]
fn clouds_parallel(bencher: Bencher, size: (usize, usize)) {
    clouds(bencher, size, Threads::Many);
}

/// Measures a Lie–Verlet step of all bodies, with threads if they pay, as by default.
#[divan::bench(args = CLOUDS, max_time = 2)]
fn step_of_clouds(bencher: Bencher, (bodies, points): (usize, usize)) {
    let attractors = vec![cloud(points); bodies];
    // A point has no inertia: a small ball replaces it.
    let inertia = slewkit::mechanics::body::Inertia::diagonal(Vector3::new(0.3, 0.4, 0.5)).unwrap();
    let rigid = attractors.iter().map(|body| Body { inertia: inertia.clone(), mass: Some(body.mass()) });
    let (rigid, gravity) = (rigid.collect(), MutualGravity::new(1.0, attractors).unwrap());
    let system = System::new(rigid, Some(Arc::new(gravity))).unwrap();
    let states = poses(bodies).into_iter().map(|pose| State {
        position: pose.position,
        ..State::attitude(pose.attitude, Vector3::new(0.1, 0.3, 0.2))
    });
    let start = system.state(&states.collect::<Vec<_>>()).unwrap();
    let mut method = Kind::LieVerlet.start(&system, &start, 1e-6, &ErrorControl::default()).unwrap();
    bencher.bench_local(|| method.step(black_box(&[])).unwrap());
}

#[divan::bench(args = [2, 10, 100])]
fn dumbbells(bencher: Bencher, bodies: usize) {
    let dumbbell = Dumbbell { mass: 1.0, length: 1.0, sphere_radius: 0.2 };
    let gravity = Dumbbells::new(1.0, &vec![dumbbell; bodies]).unwrap();
    evaluate(bencher, &gravity, bodies, 2 * bodies * (bodies - 1));
}

#[divan::bench(args = [2, 10, 100])]
fn second_order(bencher: Bencher, bodies: usize) {
    let inertia = slewkit::mechanics::body::Inertia::diagonal(Vector3::new(1.0, 1.2, 1.5)).unwrap();
    let gravity =
        MutualGravity::new(1.0, vec![Attractor::SecondOrder { mass: 1.0, inertia }; bodies]).unwrap();
    evaluate(bencher, &gravity, bodies, bodies * (bodies - 1) / 2);
}

/// Returns a ball of 8·4^cuts faces.
fn ball(cuts: usize) -> Polyhedron {
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
    Polyhedron::new(vertices, faces).unwrap().centered()
}

fn solid(cuts: usize, order: usize) -> Attractor {
    Attractor::Polyhedron(HomogeneousPolyhedron::new(ball(cuts), 1.0, order).unwrap())
}

/// Measures a polyhedron of a number of faces and a point.
#[divan::bench(args = [0, 2, 4, 6])]
fn polyhedron_and_point(bencher: Bencher, cuts: usize) {
    let bodies = vec![solid(cuts, 1), Attractor::point(1.0).unwrap()];
    evaluate(bencher, &MutualGravity::new(1.0, bodies).unwrap(), 2, 8 << (2 * cuts));
}

fn polyhedra(bencher: Bencher, (cuts, order): (usize, usize), threads: Threads) {
    let bodies = vec![solid(cuts, order); 2];
    let faces = 8 << (2 * cuts);
    let gravity = MutualGravity::new(1.0, bodies).unwrap().with_threads(threads);
    evaluate(bencher, &gravity, 2, faces * faces * order.pow(3));
}

/// Cuts of the octahedron, hence faces of both, and order of the cubature.
const POLYHEDRA: [(usize, usize); 7] = [(0, 1), (0, 2), (0, 3), (0, 5), (1, 2), (2, 1), (3, 1)];

#[divan::bench(args = POLYHEDRA, max_time = 2)]
fn polyhedra_serial(bencher: Bencher, size: (usize, usize)) {
    polyhedra(bencher, size, Threads::One);
}

#[divan::bench(args = POLYHEDRA, max_time = 2)]
fn polyhedra_parallel(bencher: Bencher, size: (usize, usize)) {
    polyhedra(bencher, size, Threads::Many);
}
