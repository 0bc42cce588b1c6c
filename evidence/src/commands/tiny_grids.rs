//! Counts faults of plans and simulations on 2 to 50 steps, which are too long for almost all
//! maneuvers.
//!
//! `cargo run --release -p evidence -- tiny_grids [COUNT [FIRST]]`, 2,000 by default. Every case
//! draws one of 26 kinds of random maneuvers, a number of steps and a method, and plans the
//! maneuver. One of all integrators then propagates it without inputs over as few steps. These
//! count as wrong:
//!
//! - a panic;
//! - a number that is not finite in a solved plan or in a row of a simulation;
//! - a plan that is reported as solved for a maneuver that is proved impossible on a thousand
//!   steps;
//! - a plan whose motion, by the independent equations of `evidence::held`, misses the end by more
//!   than is accepted for a plan (a quarter of the slew angle, clamped to 5°–45°), or by another
//!   amount than the continuous witness reports;
//! - more than thirty seconds of computing, on an idle machine.
//!
//! The command ends with 1 if a result was wrong.

use evidence::random_specs::{RandomSpec, random_spec};
use evidence::words::Words;
use evidence::{Random, held};
use slewkit::maneuver::{Problem, Trajectory, infeasible};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::propagate::integrator::Kind;
use slewkit::propagate::simulate::{Simulation, SimulationRow};
use slewkit_files::spec::{Format, Override, from_str};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::panic::catch_unwind;
use std::time::Instant;

/// The largest accepted difference between the terminal errors of the two integrations \[rad\].
const APART: f64 = 1e-5;
/// The largest accepted computing time of a case \[s\].
const LONGEST: f64 = 30.0;

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = words.number("number of cases", 2_000)?;
    let first = words.number("number of the first case", 0)?;
    words.end()?;
    let (mut tally, mut wrong) = (BTreeMap::<String, u64>::new(), 0);
    // Panics are printed below, together with their case.
    std::panic::set_hook(Box::new(|_| {}));
    for index in first..first + count {
        let began = Instant::now();
        let told = catch_unwind(|| case(index)).unwrap_or_else(|_| Told::wrong("panic"));
        let seconds = began.elapsed().as_secs_f64();
        let slow = (seconds > LONGEST).then(|| format!("{seconds:.0} s"));
        for complaint in told.wrong.iter().chain(&slow) {
            println!("case {index}: {complaint}");
            wrong += 1;
        }
        told.ends.into_iter().for_each(|end| *tally.entry(end).or_default() += 1);
    }
    for (end, times) in tally {
        println!("{end:<32} {times}");
    }
    println!("{count} plans and as many simulations: {wrong} wrong");
    if wrong > 0 { Err("see above".into()) } else { Ok(()) }
}

/// The outcomes of a case, and its faults.
#[derive(Default)]
struct Told {
    ends: Vec<String>,
    wrong: Vec<String>,
}

impl Told {
    fn wrong(what: &str) -> Self {
        Self { wrong: vec![what.into()], ..Self::default() }
    }
}

fn case(index: u64) -> Told {
    let mut random = Random::new(index ^ 0x5EED_0000);
    let RandomSpec { kind, text } = random_spec(index);
    let steps = 2 + random.below(49);
    let mut set = vec![format!("maneuver.steps={steps}"), "solver.time_limit_s=8".into()];
    // The convex iteration is the default if only the inputs have limits.
    if random.below(3) == 0 {
        set.push("solver.method=scp".into());
    }
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("an override")).collect();
    let mut told = Told::default();
    let Ok(loaded) = from_str(&text, "case", Format::Toml, &set) else {
        // The reader refuses some combinations of a kind with a grid or a method.
        told.ends.push("plan: refused by the spec".into());
        return told;
    };
    let problem = &loaded.problem;
    match plan(problem, &loaded.settings, None, &mut Silent) {
        Ok(plan) => {
            told.ends.push(format!("plan: {}", plan.status.name()));
            if plan.status == Status::Solved {
                told.wrong.extend(
                    complaints(problem, &plan)
                        .into_iter()
                        .map(|text| format!("{kind}, {steps} steps, {text}")),
                );
            }
        }
        Err(_) => told.ends.push("plan: refused".into()),
    }
    if let Ok(mut simulation) = Simulation::of(problem, None) {
        simulation.steps = steps as u64;
        simulation.kind = Kind::all().nth(random.below(Kind::NAMES.len())).expect("a method");
        let mut finite = true;
        let ended = simulation.run(&mut |row: &SimulationRow| {
            finite &= row.is_finite();
            ControlFlow::Continue(())
        });
        let end = if ended.is_ok() { "to its end" } else { "ended early, with a reason" };
        told.ends.push(format!("simulation: {end}"));
        if !finite {
            told.wrong.push(format!("{steps} steps of {}: a row that is not finite", simulation.kind));
        }
    }
    told
}

/// Returns the faults of a plan that is reported as solved.
fn complaints(problem: &Problem, plan: &Plan) -> Vec<String> {
    let mut complaints = Vec::new();
    let Trajectory { time, angular_velocity, quaternion, input, .. } = &plan.solution.trajectory;
    let vectors = angular_velocity.iter().flat_map(|rate| rate.iter());
    let mut numbers = time.iter().chain(quaternion.iter().flatten()).chain(input).chain(vectors);
    if !plan.solution.cost.is_finite() || !numbers.all(|number| number.is_finite()) {
        complaints.push("a number that is not finite".into());
    }
    if infeasible::proof(&problem.clone().with_steps(1000)).is_some() {
        complaints.push("solved what is impossible".into());
    }
    let told = plan.verification.as_ref().map_or(f64::NAN, |found| found.continuous_attitude_rad);
    let problem = &plan.solution.on_grid(problem);
    match held::missed(problem, &plan.solution.trajectory) {
        None => complaints.push("cannot be followed".into()),
        Some(missed) => {
            let (degrees, allowed) = (missed.to_degrees(), allowed_deg(quaternion));
            // The comparison is written so that a NaN counts as a fault.
            let near = degrees <= allowed * (1.0 + 1e-6);
            let as_told = (missed - told).abs() <= APART;
            if !near {
                complaints.push(format!("misses the end by {degrees:.1} deg, {allowed:.1} are allowed"));
            }
            if !as_told {
                let told = told.to_degrees();
                complaints.push(format!("misses the end by {degrees:.5} deg, told are {told:.5}"));
            }
        }
    }
    complaints
}

/// Returns the largest accepted attitude error of a plan on such long steps \[deg\]. It depends on
/// the total angle from node to node.
fn allowed_deg(quaternion: &[[f64; 4]]) -> f64 {
    let angle = |pair: &[[f64; 4]]| {
        let dot: f64 = pair[0].iter().zip(&pair[1]).map(|(a, b)| a * b).sum();
        2.0 * dot.abs().min(1.0).acos()
    };
    let turned: f64 = quaternion.windows(2).map(angle).sum();
    (0.25 * turned.to_degrees()).clamp(5.0, 45.0)
}
