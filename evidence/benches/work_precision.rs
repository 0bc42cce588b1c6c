//! Work at equal energy error: the survey's two dumbbells, and two octahedra against
//! Runge–Kutta–Fehlberg 7(8).
//!
//! `cargo bench -p benches --bench work_precision`. If `--bench` is missing (as when `cargo test`
//! calls it), everything runs shortly, once. The figures of the first comparison are drawn by
//! `slew compare problems/two_dumbbells.toml`.

use slewkit::maneuver::problem::State;
use slewkit::mechanics::full_body::{Attractor, HomogeneousPolyhedron, MutualGravity, Polyhedron, Threads};
use slewkit::propagate::integrator::{Kind, System, SystemState};
use slewkit::{Vector3, lie};
use slewkit_report::studies::integrators::{Study, WorkPrecision};
use std::ops::ControlFlow;
use std::sync::Arc;

fn main() {
    let benching = std::env::args().any(|argument| argument == "--bench");
    let part = if benching { 1.0 } else { 0.01 };
    println!("two dumbbells, the second twice the first; separation 2.5, near-elliptic orbits of 14.3 s\n");
    let (system, start) = evidence::motions::dumbbells();
    print(&Study::survey(0.01, 3200.0 * part), &system, &start);

    println!("\ntwo octahedra, 500 and 150 m, on an orbit of about one revolution a period\n");
    let (system, start, period) = octahedra();
    let kinds = vec![Kind::LieVerlet, Kind::Fehlberg78];
    let steps: Vec<f64> = [8.0, 16.0, 32.0, 64.0, 128.0, 256.0].map(|n| period / n).to_vec();
    let horizons = if benching { [1.0, 10.0, 100.0].map(|n| n * period).to_vec() } else { vec![period] };
    let shown_step = steps[0];
    print(&Study { kinds, steps, horizons, shown_step, ..Study::survey(1.0, 100.0) }, &system, &start);
}

fn print(study: &Study, system: &System, start: &SystemState) {
    let found: WorkPrecision = study.run(system, start, &mut |_| ControlFlow::Continue(())).unwrap();
    println!("{found}");
}

/// Returns two octahedra of 2000 kg/m³, 0.5 and 0.15 km, 1.2 km apart, and the period of their
/// orbit.
fn octahedra() -> (System, SystemState, f64) {
    let solid = |size: f64| {
        let shape = Polyhedron::octahedron(&(size * Vector3::new(1.0, 0.8, 0.7))).unwrap();
        Attractor::Polyhedron(HomogeneousPolyhedron::new(shape, 2000.0, 2).unwrap())
    };
    let attractors = vec![solid(500.0), solid(150.0)];
    let masses: Vec<f64> = attractors.iter().map(Attractor::mass).collect();
    let total: f64 = masses.iter().sum();
    let constant = slewkit::mechanics::full_body::GRAVITATIONAL_CONSTANT;
    let bodies = attractors.iter().map(|attractor| attractor.body().unwrap()).collect();
    let gravity = MutualGravity::new(constant, attractors).unwrap().with_threads(Threads::One);
    let system = System::new(bodies, Some(Arc::new(gravity))).unwrap();
    let separation = 1200.0;
    let rate = (constant * total / f64::powi(separation, 3)).sqrt();
    let state = |part: f64, f: Vector3, spin: Vector3| State {
        position: Vector3::new(part * separation, 0.0, 0.0),
        velocity: Vector3::new(0.0, part * separation * rate, 0.0),
        attitude: lie::exp(&f),
        angular_velocity: rate * spin,
    };
    let (first, second) = (masses[1] / total, -masses[0] / total);
    let start = [
        state(first, Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.3, -0.2, 2.0)),
        state(second, Vector3::new(-0.3, 0.1, 0.8), Vector3::new(0.1, 0.2, 1.2)),
    ];
    let start = system.state(&start).unwrap();
    (system, start, 2.0 * std::f64::consts::PI / rate)
}
