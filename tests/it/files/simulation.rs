//! The meaning of the spec of a simulation.

use super::SIMULATION;
use slewkit::propagate::integrator::Kind;
use slewkit::propagate::simulate::Simulation;
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::spec::{self, Format, Spec};

#[test]
fn simulation_template_loads_without_a_word() {
    let Ok(Spec::Simulation(loaded)) = super::load_any(spec::simulation_template(), &[]) else {
        panic!("no simulation");
    };
    assert_eq!(loaded.warnings, []);
    let simulation = loaded.simulation;
    assert_eq!((simulation.steps, simulation.stride, simulation.kind), (1000, 10, Kind::LieVerlet));
    assert_eq!(simulation.bodies, ["primary", "moonlet"]);
    // Mass and inertia of the octahedron: V = 4/3 abc, J₁ = m (b² + c²)/10.
    let body = &simulation.system.bodies()[0];
    let mass = 2000.0 * 4.0 / 3.0 * 500.0 * 400.0 * 350.0;
    assert!((body.mass.unwrap() / mass - 1.0).abs() < 1e-14);
    let moment = mass * (400.0_f64.powi(2) + 350.0_f64.powi(2)) / 10.0;
    assert!((body.inertia.j()[(0, 0)] / moment - 1.0).abs() < 1e-13);
}

fn simulation(text: &str, set: &[&str]) -> Simulation {
    match super::load_any(text, set) {
        Ok(Spec::Simulation(loaded)) => loaded.simulation,
        Ok(_) => panic!("no simulation"),
        Err(errors) => panic!("{errors}"),
    }
}

#[test]
fn every_key_of_a_simulation_reaches_it() {
    let loaded = simulation(SIMULATION, &[]);
    assert_eq!(loaded.name, "test");
    assert_eq!(loaded.bodies, ["dumbbell", "tetrahedron"]);
    assert_eq!((loaded.duration, loaded.steps, loaded.stride), (30.0, 600, 4));
    assert_eq!(loaded.kind.name(), "galerkin_gauss_2");
    assert_eq!(loaded.settings.tolerance, 1e-12);
    let (bodies, start) = (loaded.system.bodies(), &loaded.start);
    // J = diag(J_a, J_a + m l²/4, …), J_a = 0.4 m r².
    let axial = 0.4 * 2.0 * 0.1 * 0.1;
    let across = axial + 2.0 * 0.25 / 4.0;
    let expected = Matrix3::from_diagonal(&Vector3::new(axial, across, across));
    assert!((bodies[0].inertia.j() - expected).amax() < 1e-16);
    assert!((start.momenta()[0].angular - expected * Vector3::new(0.1, -0.2, 0.3)).amax() < 1e-16);
    assert!((start.momenta()[0].linear - Vector3::new(0.0, 1.0, 0.0)).amax() < 1e-16);
    assert!(
        (start.poses()[0].attitude - lie::exp(&Vector3::new(0.0, 0.0, 30_f64.to_radians()))).amax() < 1e-15
    );
    // A tetrahedron of edge 2√2: V = 8/3, J = m a²/20.
    assert!((bodies[1].mass.unwrap() - 8.0).abs() < 1e-14);
    assert!((bodies[1].inertia.j() - Matrix3::identity() * (8.0 * 8.0 / 20.0)).amax() < 1e-14);
    assert!((start.momenta()[1].angular - Vector3::new(0.0, 0.0, 0.1)).amax() < 1e-16);
    assert!((start.momenta()[1].linear - Vector3::new(0.0, -1.0, 0.0)).amax() < 1e-15);

    let second_order = simulation(SIMULATION, &["gravity.potential=second_order"]);
    let energy = |simulation: &Simulation| simulation.system.invariants(&simulation.start).energy;
    let difference = (energy(&second_order) - energy(&loaded)).abs() / energy(&loaded).abs();
    assert!(difference > 1e-6 && difference < 0.05, "{difference:e}");
    let degrees = ["bodies.0.angular_velocity_rad_s=[0,0,1]", "simulation.integrator=dop853"];
    assert_eq!(simulation(SIMULATION, &degrees).kind, Kind::Dop853);
}

/// A shape of points, the same points in an environment, and a cuboid of mass or density: one body
/// each.
#[test]
fn shapes_give_mass_and_inertia() {
    let body = |shape: &str| {
        let text = format!(
            "format = 1\n[simulation]\nduration_s = 1\nsteps = 10\n[[bodies]]\n{shape}\n\
             attitude = {{ quaternion_wxyz = [1, 0, 0, 0] }}\nposition_m = [0, 0, 0]\n"
        );
        simulation(&text, &[]).system.bodies()[0].clone()
    };
    let points = body(
        "shape = { kind = \"points\", points = [{ mass_kg = 1, position_m = [5, 1, 0] }, \
         { mass_kg = 1, position_m = [5, -1, 0] }, { mass_kg = 2, position_m = [7, 0, 0] }] }",
    );
    // Mass center at x = 6: the three points are at −1, −1, +1.
    let expected = Matrix3::from_diagonal(&Vector3::new(2.0, 4.0, 6.0));
    assert_eq!(points.mass, Some(4.0));
    assert!((points.inertia.j() - expected).amax() < 1e-14, "{}", points.inertia.j());
    let by_mass = body("mass_kg = 12\nshape = { kind = \"cuboid\", edges_m = [1, 2, 3] }");
    let by_density = body("shape = { kind = \"cuboid\", edges_m = [1, 2, 3], density_kg_m3 = 2 }");
    let expected = Matrix3::from_diagonal(&Vector3::new(13.0, 10.0, 5.0));
    for body in [by_mass, by_density] {
        assert!((body.mass.unwrap() - 12.0).abs() < 1e-13);
        assert!((body.inertia.j() - expected).amax() < 1e-13, "{}", body.inertia.j());
    }
    let ball = body("shape = { kind = \"sphere\", radius_m = 2, density_kg_m3 = 3 }");
    let mass = 3.0 * 4.0 / 3.0 * std::f64::consts::PI * 8.0;
    assert!((ball.mass.unwrap() - mass).abs() < 1e-12);
    assert!((ball.inertia.j() - Matrix3::identity() * (0.4 * mass * 4.0)).amax() < 1e-12);
    let given = body("mass_kg = 1\ninertia_kg_m2 = [1, 2, 2.5]\nshape = { kind = \"sphere\", radius_m = 2 }");
    assert_eq!(given.inertia.j()[(1, 1)], 2.0, "a given inertia comes before that of the shape");
}

/// An OBJ file must be in the folder of the spec.
#[test]
fn shapes_come_from_files_beside_the_spec_and_from_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let shape = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
    std::fs::write(inner.join("shape.obj"), shape).unwrap();
    std::fs::write(folder.path().join("outside.obj"), shape).unwrap();
    let spec = |obj: &str| {
        let text = format!(
            "format = 1\n[simulation]\nduration_s = 1\nsteps = 10\n[[bodies]]\n\
             shape = {{ kind = \"polyhedron\", obj = \"{obj}\", obj_unit_m = 10, density_kg_m3 = 1 }}\n\
             attitude = {{ quaternion_wxyz = [1, 0, 0, 0] }}\nposition_m = [0, 0, 0]\n"
        );
        let path = inner.join("spec.toml");
        std::fs::write(&path, text).unwrap();
        spec::load(&path, Format::Toml, &[])
    };
    // A sparse file takes no space on the disk, but would take minutes to read.
    let huge = std::fs::File::create(inner.join("huge.obj")).unwrap();
    huge.set_len(1 << 32).unwrap();
    let errors = spec("huge.obj").unwrap_err();
    assert_eq!(errors.0[0].code, "E0034");
    assert!(errors.0[0].reason.contains("4096 MiB"), "{errors}");
    let Ok(Spec::Simulation(loaded)) = spec("./shape.obj") else { panic!("not read") };
    let mass = loaded.simulation.system.bodies()[0].mass.unwrap();
    assert!((mass / (8000.0 / 3.0) - 1.0).abs() < 1e-14, "{mass}");
    assert_eq!(spec("../outside.obj").unwrap_err().0[0].code, "E0091");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join("outside.obj"), inner.join("link.obj")).unwrap();
        let errors = spec("link.obj").unwrap_err();
        assert_eq!(errors.0[0].code, "E0091");
        assert!(errors.0[0].reason.contains("link"), "{errors}");
    }
}

/// A simulation that needs too much memory or time is refused before it is built.
#[test]
fn shapes_beyond_memory_and_time_are_refused() {
    let bodies = |count: usize, order: usize| {
        let body = |index: usize| {
            format!(
                "[[bodies]]\nmass_kg = 1\nshape = {{ kind = \"cuboid\", edges_m = [1, 1, 1], gauss_order = {order} }}\n\
                 attitude = {{ quaternion_wxyz = [1, 0, 0, 0] }}\nposition_m = [{}, 0, 0]\n",
                10 * index
            )
        };
        let bodies: String = (0..count).map(body).collect();
        format!("format = 1\n[simulation]\nduration_s = 1\nsteps = 10\n[gravity]\n{bodies}")
    };
    // 12 faces of 8³ points each: 325 bodies have two million points.
    let errors = super::load_any(&bodies(330, 8), &[]).unwrap_err();
    assert_eq!(errors.0[0].code, "E0034");
    assert!(errors.0[0].reason.contains("2000000 points"), "{errors}");
    // 300 bodies have fewer, but their pairs take 3e10 interactions.
    let errors = super::load_any(&bodies(300, 8), &[]).unwrap_err();
    assert_eq!(errors.0[0].code, "E0086");
    assert!(errors.0[0].reason.contains("interactions"), "{errors}");
    let errors = super::load_any(&bodies(1001, 1), &[]).unwrap_err();
    assert_eq!((errors.0[0].code, errors.0[0].key.as_str()), ("E0034", "bodies"));
    super::load_any(&bodies(20, 4), &[]).unwrap();
}
