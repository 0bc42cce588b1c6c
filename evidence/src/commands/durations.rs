//! Checks the durations that slewkit recommends for infeasible slews of random bodies. The slews
//! are from rest to rest, with limits on each torque, on the norm of the torque, on torques and
//! rates, on the rates of torques, or with four wheels that store little momentum. Their duration
//! is a third of the proved lower bound.
//!
//! `cargo run --release -p evidence -- durations [CASES]`, 200 cases by default. Each slew is
//! planned in the duration that the proof of its infeasibility recommends. The law is that a plan
//! exists. The duration is then reduced by 4 % as long as a plan is found, which shows by how much
//! the recommendation exceeds the shortest duration. The command ends with 1 if no duration is
//! recommended, or if more than one case in a hundred has no plan in it.

use evidence::Random;
use evidence::words::Words;
use slewkit::maneuver::constraint::{Constraint, Rule};
use slewkit::maneuver::{Problem, Settings, State};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Wheels};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::collections::BTreeMap;

const KINDS: [&str; 5] = ["box", "norm", "box and rate", "torque rates", "wheels"];
/// The factor by which a duration is multiplied to reduce it.
const SHORTER: f64 = 0.96;
/// The largest number of reductions.
const MOST: u32 = 25;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count = words.number("number of cases", 200)?;
    words.end()?;
    let mut tally = BTreeMap::<&str, BTreeMap<&str, u64>>::new();
    let mut ratios = BTreeMap::<&str, Vec<f64>>::new();
    let (mut wrong, mut cases) = (0, 0);
    for seed in 0..count {
        let kind = KINDS[seed as usize % KINDS.len()];
        let problem = case(kind, &mut Random::new(seed + 1))?;
        let planned = |duration: f64| {
            plan(&problem.clone().with_duration(duration), &Settings::default(), None, &mut Silent)
        };
        let denied = planned(problem.seconds())?;
        let mut told = |what| *tally.entry(kind).or_default().entry(what).or_default() += 1;
        if denied.status != Status::Infeasible {
            told("not proved infeasible");
            continue;
        }
        cases += 1;
        let Some(advised) = denied.solution.longer else {
            told("no duration named");
            wrong += 1;
            continue;
        };
        let found = planned(advised)?;
        if found.status != Status::Solved {
            println!("case {seed}, {kind}: {} in the {advised} s that were advised", found.status.name());
            told("no plan");
            wrong += 1;
            continue;
        }
        told("plan");
        let mut shortest = advised;
        for power in 1..=MOST {
            let duration = advised * SHORTER.powi(power as i32);
            if planned(duration)?.status != Status::Solved {
                break;
            }
            shortest = duration;
        }
        ratios.entry(kind).or_default().push(advised / shortest);
    }
    for (kind, results) in tally {
        let mut ratios = ratios.remove(kind).unwrap_or_default();
        ratios.sort_by(f64::total_cmp);
        let told = match (ratios.get(ratios.len() / 2), ratios.last()) {
            (Some(median), Some(most)) => format!("median {median:.2}, most {most:.2}"),
            _ => "-".into(),
        };
        println!("{kind:<14} {results:?}; advised over shortest found: {told}");
    }
    println!("{wrong} of {cases} durations are not named or have no plan");
    if 100 * wrong > cases { Err("a duration that is advised has no plan".into()) } else { Ok(()) }
}

/// Draws a slew whose duration is a third of the proved lower bound.
fn case(kind: &str, random: &mut Random) -> Result<Problem, Box<dyn std::error::Error>> {
    let spread = Vector3::from_fn(|_, _| 10.0_f64.powf(0.8 * random.unit()));
    let moments = 50.0 * Vector3::new(spread.y + spread.z, spread.z + spread.x, spread.x + spread.y);
    let axes = lie::exp(&(0.5 * random.direction()));
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (j + j.transpose()))?, mass: None };
    let rotation = (0.2 + 2.6 * random.unit()) * random.direction();
    let torque = 0.1 + 0.4 * random.unit();
    let size = Some(vec![torque; 3]);
    let limits = match kind {
        "norm" => Limits { norm: Some(torque), ..Limits::default() },
        "torque rates" => {
            Limits { size, rate: Some(vec![torque * (0.05 + 0.2 * random.unit()); 3]), ..Limits::default() }
        }
        _ => Limits { size, ..Limits::default() },
    };
    let actuation = if kind == "wheels" {
        let wheels = [[0.8, 0.0, 0.6], [0.0, 0.8, 0.6], [-0.8, 0.0, 0.6], [0.0, -0.8, 0.6]];
        let set = ActuatorSet::new(wheels.map(Vector3::from).to_vec(), AxisFrame::Body)?;
        let set = set.with_limits(Limits { size: Some(vec![torque; 4]), ..Limits::default() })?;
        let held = Wheels {
            momentum: (0..4).map(|_| 0.3 * (random.unit() - 0.5)).collect(),
            momentum_limit: vec![0.7 + 2.0 * random.unit(); 4],
        };
        Actuation { wheels: Some(held), ..Actuation::torques(set) }
    } else {
        Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?)
    };
    let [start, end] = [Matrix3::identity(), lie::exp(&rotation)].map(State::at_rest);
    let mut problem = Problem::attitude(body, start, end, 1.0).with_actuation(actuation);
    if kind == "box and rate" {
        let limit = (0.1 + 0.5 * random.unit()).to_radians();
        problem = problem.with_constraint(Constraint { name: "rate".into(), rule: Rule::RateNorm(limit) });
    }
    let bound = slewkit::maneuver::infeasible::proof(&problem).and_then(|proof| proof.duration_lower_bound);
    Ok(problem.with_duration(bound.unwrap_or(1.0) / 3.0))
}
