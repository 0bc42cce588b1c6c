//! Prints the gaps between the costs of plans on coarse grids and proved global lower bounds, which
//! hold for all homotopy classes.
//!
//! `cargo run --release -p evidence --features sdp -- global_bound [STEPS]`: slews of a tilted body
//! from rest to rest on grids of at most STEPS (4), up to 16. The bounds need the feature `sdp`,
//! which links OpenBLAS.

use evidence::words::Words;
use std::error::Error;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let most: usize = words.number("largest number of steps", 4)?;
    words.end()?;
    bounds(most)
}

#[cfg(not(feature = "sdp"))]
fn bounds(_: usize) -> Result<(), Box<dyn Error>> {
    let remedy = "cargo run --release -p evidence --features sdp -- global_bound";
    Err(evidence::words::Misuse::new(format!("this program was built without the feature sdp: {remedy}"))
        .into())
}

#[cfg(feature = "sdp")]
fn bounds(most: usize) -> Result<(), Box<dyn Error>> {
    use slewkit::maneuver::{Problem, Scheme, Settings, State};
    use slewkit::mechanics::{Body, Inertia};
    use slewkit::optimize::lower_bound::{BoundSettings, lower_bound};
    use slewkit::optimize::search;
    use slewkit::plan::Silent;
    use slewkit::{Matrix3, Vector3, lie};

    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1))?;
    let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
    println!("angle  scheme      steps       cost      bound        gap  largest step  moments  seconds");
    for steps in [3, 4, 6, 8, 12, 16].into_iter().filter(|steps| *steps <= most) {
        for degrees in [60.0, 120.0, 170.0] {
            for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
                let body = Body { inertia: inertia.clone(), mass: None };
                let end = State::at_rest(lie::exp(&(axis * f64::to_radians(degrees))));
                let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 2.0)
                    .with_scheme(scheme)
                    .with_steps(steps);
                let plan = search::solve(&problem, &Settings::discrete(), None, &mut Silent)?;
                // If no plan exists, no cost is known, and only the bound is printed.
                let known_cost = plan.cost.is_finite().then_some(plan.cost);
                let bound = lower_bound(&problem, &BoundSettings { known_cost, ..BoundSettings::default() })?;
                let largest = bound.step_angles.iter().copied().fold(0.0, f64::max).to_degrees();
                let missing = || "no plan".to_string();
                let cost = known_cost.map_or_else(missing, |cost| format!("{cost:.6}"));
                let gap = bound.gap.map_or_else(missing, |gap| format!("{gap:.1e}"));
                println!(
                    "{degrees:4.0}°  {:10} {steps:6} {cost:>10} {:10.6} {gap:>10} {largest:12.1}° {:8} {:8.2}",
                    scheme.name(),
                    bound.cost,
                    bound.moments,
                    bound.solve_time,
                );
            }
        }
    }
    Ok(())
}
