//! The systems of bodies that every potential is tested on.

use crate::evidence::Random;
use slewkit::Vector3;
use slewkit::mechanics::body::Inertia;
use slewkit::mechanics::environment::Pose;
use slewkit::mechanics::full_body::*;

/// A potential of several bodies of about unit size and mass.
pub struct System {
    pub name: &'static str,
    pub potential: Box<dyn Potential>,
    pub bodies: usize,
    /// Relative round-off of the energy.
    pub round_off: f64,
}

pub fn dumbbells() -> Vec<Dumbbell> {
    [(1.0, 0.5), (2.0, 1.0), (0.7, 0.8)]
        .map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length })
        .to_vec()
}

/// Returns the points without any symmetry.
pub fn cloud(seed: u64, points: usize) -> PointCloud {
    let mut random = Random::new(seed);
    let point = |_| MassPoint { mass: 1.2 + random.uniform(), position: 0.5 * random.vector() };
    PointCloud::centered((0..points).map(point).collect()).unwrap().0
}

pub fn second_order(mass: f64) -> Attractor {
    let inertia = Inertia::diagonal(mass * Vector3::new(0.1, 0.13, 0.2)).unwrap();
    Attractor::SecondOrder { mass, inertia }
}

/// Returns a tetrahedron without any symmetry, a body that is not star-shaped, and an octahedron.
pub fn tetrahedron() -> Polyhedron {
    let corners =
        [[0.5, -0.1, -0.2], [-0.4, 0.4, -0.1], [-0.2, -0.4, -0.3], [0.1, 0.0, 0.6]].map(Vector3::from);
    Polyhedron::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap().centered()
}

/// Returns a U of three bars: its mass center is outside.
pub fn horseshoe() -> Polyhedron {
    let outline = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
    let corner = |z: f64| outline.map(|[x, y]| 0.2 * Vector3::new(x, y, z));
    let vertices = [corner(0.0), corner(1.0)].concat();
    let caps = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]];
    let mut faces: Vec<[u32; 3]> =
        caps.iter().flat_map(|&[a, b, c]| [[a, c, b], [a + 8, b + 8, c + 8]]).collect();
    for a in 0..8 {
        let b = (a + 1) % 8;
        faces.extend([[a, b, b + 8], [a, b + 8, a + 8]]);
    }
    Polyhedron::new(vertices, faces).unwrap().centered()
}

pub fn octahedron() -> Polyhedron {
    Polyhedron::octahedron(&Vector3::new(0.7, 0.5, 0.4)).unwrap()
}

pub fn solid(shape: Polyhedron, order: usize) -> Attractor {
    Attractor::Polyhedron(HomogeneousPolyhedron::with_mass(shape, 1.1, order).unwrap())
}

/// Returns every potential. A new system is one line here.
pub fn all() -> Vec<System> {
    let closed = |dumbbells: &[Dumbbell]| Dumbbells::new(0.9, dumbbells).unwrap();
    let mutual = |bodies: Vec<Attractor>| MutualGravity::new(0.9, bodies).unwrap();
    let clouds = |sizes: &[usize]| -> Vec<Attractor> {
        sizes.iter().enumerate().map(|(i, size)| Attractor::Cloud(cloud(i as u64, *size))).collect()
    };
    let point = || Attractor::point(1.3).unwrap();
    let rods = dumbbells().iter().map(|dumbbell| Attractor::Cloud(dumbbell.cloud().unwrap())).collect();
    let pair = vec![second_order(1.2), second_order(0.4)];
    let mut mixed = clouds(&[7, 3]);
    mixed.extend([second_order(2.0), point()]);
    let crowd = vec![
        solid(octahedron(), 2),
        Attractor::Cloud(cloud(2, 6)),
        solid(tetrahedron(), 1),
        second_order(0.3),
        solid(horseshoe(), 2),
    ];
    let system = |name, bodies, potential| System { name, potential, bodies, round_off: 1e-14 };
    // About r² l/V ulps: see the derivation at the field of a polyhedron.
    let solids = |name, bodies, potential| System { round_off: 2e-13, ..system(name, bodies, potential) };
    vec![
        system("two dumbbells", 2, Box::new(closed(&dumbbells()[..2]))),
        system("three dumbbells", 3, Box::new(closed(&dumbbells()))),
        system("dumbbells as clouds", 3, Box::new(mutual(rods))),
        system("points", 2, Box::new(mutual(vec![point(), point()]))),
        system("two clouds", 2, Box::new(mutual(clouds(&[5, 9])))),
        system("five clouds", 5, Box::new(mutual(clouds(&[5, 9, 1, 4, 13])))),
        system("second order", 2, Box::new(mutual(pair))),
        system("clouds, second order, point", 4, Box::new(mutual(mixed))),
        solids("polyhedron and point", 2, Box::new(mutual(vec![point(), solid(tetrahedron(), 1)]))),
        solids(
            "polyhedron and cloud",
            2,
            Box::new(mutual(vec![solid(horseshoe(), 1), Attractor::Cloud(cloud(4, 7))])),
        ),
        solids("two octahedra", 2, Box::new(mutual(vec![solid(octahedron(), 3), solid(octahedron(), 3)]))),
        solids("bodies of every kind", 5, Box::new(mutual(crowd))),
    ]
}

/// Poses with mass centers at least about 2 apart.
pub fn poses(random: &mut Random, bodies: usize) -> Vec<Pose> {
    let place = |body: usize| {
        let grid = Vector3::new((body % 2) as f64, (body / 2 % 2) as f64, (body / 4) as f64);
        Pose { position: 3.0 * grid + 0.5 * random.vector(), attitude: random.rotation() }
    };
    (0..bodies).map(place).collect()
}
