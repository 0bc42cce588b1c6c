//! Checks which slews are reported as infeasible, for random bodies and rotations with a norm limit
//! on the torque.
//!
//! `cargo run --release -p evidence -- infeasible [CASES]`, 200 cases by default. With the torque
//! limit ū, no rest-to-rest slew by the angle θ takes less than `T₁ = 2 √(θ J_min/ū)`. About its
//! eigenaxis e the body can make it in `T_e = 2 √(θ √(|Je|² + θ²|e×Je|²)/ū)`. Each slew is planned
//! in 0.3, 0.9 and 0.999 T₁. All of these must be reported as infeasible, with a lower bound on the
//! duration between T₁ and T_e. This bound is sharper than T₁, because it uses bounds on the motion
//! of the body axes. At three durations in between, a slew may be reported as infeasible only if
//! this bound requires it, and at 1.3 T_e never.

use evidence::words::Words;
use slewkit::maneuver::{Problem, Settings, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::collections::BTreeMap;

use evidence::Random;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count = words.number("number of cases", 200)?;
    words.end()?;
    let mut tally = BTreeMap::<&str, BTreeMap<&str, u64>>::new();
    let mut named = Vec::new();
    let mut wrong = 0;
    for seed in 0..count {
        let mut random = Random::new(seed + 1);
        let (body, rotation) =
            (random_body(&mut random)?, 3.1 * random.unit().max(0.01) * random.direction());
        let (theta, axis) = (rotation.norm(), rotation.normalize());
        let (j, smallest) = (body.inertia.j(), body.inertia.principal()[0]);
        // The units are chosen so that the torque limit is 1.
        let least = 2.0 * (theta * smallest).sqrt();
        let along = j * axis;
        let eigenaxis = 2.0 * (theta * along.norm().hypot(theta * axis.cross(&along).norm())).sqrt();
        let between = |share: f64| least * (eigenaxis / least).powf(share);
        for (name, duration) in [
            ("below, 0.3 T1", 0.3 * least),
            ("below, 0.9 T1", 0.9 * least),
            ("below, 0.999 T1", 0.999 * least),
            ("between, near T1", between(0.01)),
            ("between", between(0.5)),
            ("between, at Te", eigenaxis),
            ("above, 1.3 Te", 1.3 * eigenaxis),
        ] {
            let limits = Limits { norm: Some(1.0), ..Limits::default() };
            let channel = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
            let [start, end] = [Matrix3::identity(), lie::exp(&rotation)].map(State::at_rest);
            let problem = Problem::attitude(body.clone(), start, end, duration)
                .with_actuation(Actuation::torques(channel))
                .with_steps(100);
            let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
            let infeasible = plan.status == Status::Infeasible;
            *tally.entry(name).or_default().entry(plan.status.name()).or_default() += 1;
            let shortest =
                slewkit::maneuver::infeasible::proof(&problem).and_then(|found| found.duration_lower_bound);
            let right = match (name.split(',').next(), shortest) {
                (Some("below"), Some(shortest)) => {
                    named.push(shortest / least);
                    infeasible && shortest >= (1.0 - 1e-3) * least && shortest <= eigenaxis
                }
                (Some("between"), Some(shortest)) => infeasible && duration < shortest,
                (_, None) => !infeasible,
                _ => false,
            };
            wrong += u64::from(!right);
        }
    }
    for (name, statuses) in tally {
        println!("{name:<18} {statuses:?}");
    }
    named.sort_by(f64::total_cmp);
    let [first, middle, last] = [0, named.len() / 2, named.len() - 1].map(|at| named[at]);
    println!("shortest duration named: {first:.4}-{last:.4} T1, median {middle:.4}; {wrong} wrong");
    if wrong > 0 { Err("infeasible where it must not be, or the reverse".into()) } else { Ok(()) }
}

/// Draws a body whose principal moments have a ratio of up to 20, about tilted axes.
fn random_body(random: &mut Random) -> Result<Body, Box<dyn std::error::Error>> {
    let spread = Vector3::from_fn(|_, _| 10.0_f64.powf(1.5 * random.unit()));
    let moments = Vector3::new(spread.y + spread.z, spread.z + spread.x, spread.x + spread.y);
    let axes = lie::exp(&(3.0 * random.direction()));
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    Ok(Body { inertia: Inertia::new(0.5 * (j + j.transpose()))?, mass: None })
}
