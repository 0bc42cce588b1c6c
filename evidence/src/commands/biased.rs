//! Plans slews of bodies whose wheels store momentum at the start, with the number of steps that
//! the planner chooses.
//!
//! `cargo run --release -p evidence -- biased [COUNT]`: COUNT (200 by default) random bodies with
//! three wheels and moments in a ratio of up to 3. One wheel stores so much momentum that the body
//! nutates at 0.05 to 0.5 rad/s, by 3 to 100 rad during the slew. Each slew turns by 0.3 to 2.8 rad
//! about a random axis, from rest to rest, with minimum effort.
//!
//! The law: every plan is verified, and the motion under its held torques, integrated by
//! independent equations (`evidence::held`), ends within 1e-6 rad of the target. The command ends
//! with 1 if fewer than 99.5 % of the plans satisfy it.

use evidence::words::Words;
use evidence::{Random, held, median};
use slewkit::maneuver::Settings;
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Inertia, Wheels};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Body, Matrix3, Problem, State, lie};
use std::error::Error;
use std::time::Instant;

fn maneuver(index: usize) -> Result<Problem, Box<dyn Error>> {
    let mut random = Random::of_case(96, index);
    let inertia = Inertia::new(Matrix3::from_diagonal(&(100.0 * random.mean_moments(3.0))))?;
    let nutation = 10.0_f64.powf(random.within(-1.3, -0.3));
    let turned = 10.0_f64.powf(random.within(0.5, 2.0));
    let wheel = random.below(3);
    let (one, other) =
        (inertia.j()[((wheel + 1) % 3, (wheel + 1) % 3)], inertia.j()[((wheel + 2) % 3, (wheel + 2) % 3)]);
    let mut momentum = vec![0.0; 3];
    momentum[wheel] = nutation * (one * other).sqrt() * if random.coin() { 1.0 } else { -1.0 };
    let wheels = Wheels { momentum, momentum_limit: vec![f64::INFINITY; 3] };
    let torques = Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body));
    let actuation = Actuation { wheels: Some(wheels), ..torques };
    let rotation = random.within(0.3, 2.8) * random.direction();
    let [start, end] = [Matrix3::identity(), lie::exp(&rotation)].map(State::at_rest);
    let problem = Problem::attitude(Body { inertia, mass: None }, start, end, turned / nutation);
    let problem = problem.with_actuation(actuation);
    let spec = slewkit_files::spec::SpecDocument::new(&problem, &Settings::default())?;
    // A spec without steps lets the planner choose them.
    let mut keys: serde_json::Value = serde_json::from_str(&spec.to_string())?;
    if let Some(maneuver) = keys["maneuver"].as_object_mut() {
        maneuver.remove("steps");
    }
    Ok(slewkit_files::spec::from_str(&keys.to_string(), "biased", slewkit_files::spec::Format::Json, &[])
        .map_err(|errors| errors.to_string())?
        .problem)
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of maneuvers", 200)?;
    words.end()?;
    let (mut good, mut worst, mut seconds) = (0, 0.0_f64, Vec::new());
    for index in 0..count {
        let problem = maneuver(index)?;
        let began = Instant::now();
        let found = plan(&problem, &Settings::default(), None, &mut Silent)?;
        seconds.push(began.elapsed().as_secs_f64());
        // A maneuver without a plan has no trajectory.
        let trajectory = Some(&found.solution.trajectory).filter(|found| !found.time.is_empty());
        let off = trajectory.and_then(|found| held::missed(&problem, found)).unwrap_or(f64::INFINITY);
        if found.status == Status::Solved && off < Settings::CONTINUOUS_TOLERANCE {
            good += 1;
            worst = worst.max(off);
        } else {
            println!(
                "  case {index}: {}, {off:.1e} rad off on {} steps",
                found.status.name(),
                found.solution.steps
            );
        }
    }
    println!(
        "{good} of {count} verified on the steps that are chosen, at most {worst:.1e} rad off; median {:.1} ms",
        1e3 * median(&mut seconds)
    );
    if (good as f64) < 0.995 * count as f64 { Err("see above".into()) } else { Ok(()) }
}
