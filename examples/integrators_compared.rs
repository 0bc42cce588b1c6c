//! Compares four integrators for two bodies that orbit each other: work and precision, and the
//! figures.
//!
//! `cargo run --release --example integrators_compared -- --figures DIRECTORY` also writes nine SVG
//! files there.

use slewkit::mechanics::full_body::{Dumbbell, Dumbbells};
use slewkit::propagate::integrator::System;
use slewkit::{State, Vector3, lie};
use slewkit_report::studies::integrators::Study;
use slewkit_report::studies::integrators::figures::{Outline, figures};
use std::ops::ControlFlow;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The second dumbbell has twice the mass and the length of the first; G = 1.
    let pair = [(1.0, 0.5), (2.0, 1.0)];
    let pair = pair.map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length });
    let bodies = pair.iter().map(Dumbbell::body).collect::<Result<_, _>>()?;
    let system = System::new(bodies, Some(Arc::new(Dumbbells::new(1.0, &pair)?)))?;
    // Zero total momentum, near-elliptic orbits of 14 s.
    let state = |part: f64, turn: Vector3, rate: Vector3| State {
        position: Vector3::new(2.5 * part, 0.0, 0.0),
        velocity: Vector3::new(0.0, part * 1.2_f64.sqrt(), 0.0),
        attitude: lie::exp(&turn),
        angular_velocity: 4.0 * rate,
    };
    let first = state(2.0 / 3.0, Vector3::new(0.2, 0.5, 0.3), Vector3::new(0.3, -0.2, 1.0));
    let second = state(-1.0 / 3.0, Vector3::new(-0.3, 0.1, 0.8), Vector3::new(0.1, 0.4, 0.5));
    let start = system.state(&[first, second])?;

    let study = Study { horizons: vec![16.0, 32.0, 64.0], ..Study::survey(0.01, 64.0) };
    let found = study.run(&system, &start, &mut |_| ControlFlow::Continue(()))?;
    println!("{found}");
    // For the same energy error over 64 s, both explicit rules look at the forces several times as
    // often.
    let last =
        found.equal_error.iter().filter(|row| row.horizon_s > 63.0 && row.method.starts_with("explicit"));
    assert!(last.filter_map(|row| row.force_evaluation_ratio).all(|ratio| ratio > 1.5));

    if let Some(directory) = std::env::args().skip_while(|argument| argument != "--figures").nth(1) {
        let outlines = ["first", "second"].iter().zip(&pair).map(|(name, d)| Outline::dumbbell(*name, d));
        for figure in figures("Two dumbbells", &study, &found, &outlines.collect::<Vec<_>>()) {
            std::fs::write(format!("{directory}/{}.svg", figure.name), figure.svg)?;
        }
    }
    Ok(())
}

#[test]
fn runs() -> Result<(), Box<dyn std::error::Error>> {
    main()
}
