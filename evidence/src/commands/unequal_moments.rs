//! Compares minimum-effort plans between given rates, for bodies with unequal moments, with the
//! plans of symmetric maneuvers: time-reversed, mirrored in three planes, with permuted axes. All
//! have the same optimal cost.
//!
//! `cargo run --release -p evidence -- unequal_moments [COUNT [RATIO]]`: COUNT (200 by default)
//! random maneuvers; with a RATIO only its maneuvers are planned. Moments are 1, r and r within 10
//! %, with r from 3, 5, 10 and 30 in turn. Attitudes are uniform, the rates at both ends are up to
//! 0.5 rad/s, and durations are 3 to 12 s, on 200 steps. A rod turns by up to four turns about its
//! axis.
//!
//! For each ratio, the command prints how many plans cost no more than the cheapest symmetric
//! maneuver, within 0.2 %, and the largest excess. It ends with 1 if fewer than 99.5 % of all plans
//! cost no more.

use evidence::metamorphic::images;
use evidence::words::Words;
use evidence::{Random, median};
use slewkit::maneuver::{Settings, Target};
use slewkit::mechanics::Inertia;
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Body, Matrix3, Problem, State, Vector3};
use std::error::Error;
use std::time::Instant;

const RATIOS: [f64; 4] = [3.0, 5.0, 10.0, 30.0];
/// The largest accepted excess of a plan over its cheapest symmetric maneuver, relative to the
/// cost.
const NEAR: f64 = 2e-3;

fn maneuver(index: usize) -> Result<Problem, Box<dyn Error>> {
    let mut random = Random::of_case(57, index);
    let ratio = RATIOS[index % RATIOS.len()];
    // The difference of two moments is at most the third moment.
    let least = (0.9 * ratio).max(ratio - 0.5);
    let mut moments = [1.0, random.within(least, ratio), random.within(least, ratio)];
    moments.rotate_left(random.below(3));
    let inertia = Inertia::new(Matrix3::from_diagonal(&Vector3::from(moments)))?;
    let mut state = || State::attitude(random.uniform_rotation(), random.within_cube(0.5));
    let (start, end) = (state(), state());
    Ok(Problem::attitude(Body { inertia, mass: None }, start, end, random.within(3.0, 12.0)).with_steps(200))
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of maneuvers", 200)?;
    let asked = words.one_of("ratio", &["3", "5", "10", "30"])?;
    words.end()?;
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut tally = [(0, 0, 0.0_f64); RATIOS.len()];
    let mut seconds = Vec::new();
    for index in 0..count {
        let ratio = RATIOS[index % RATIOS.len()].to_string();
        if asked.as_ref().is_some_and(|asked| *asked != ratio) {
            continue;
        }
        let problem = maneuver(index)?;
        let began = Instant::now();
        let cost_of = |problem: &Problem| -> Result<f64, Box<dyn Error>> {
            let found = plan(problem, &settings, None, &mut Silent)?;
            Ok(if found.status == Status::Solved { found.solution.cost } else { f64::INFINITY })
        };
        let own = cost_of(&problem)?;
        seconds.push(began.elapsed().as_secs_f64());
        let mut best = ("itself", own);
        for (name, image) in images(&problem) {
            let cost = cost_of(&image)?;
            if cost < best.1 {
                best = (name, cost);
            }
        }
        let (cases, good, worst) = &mut tally[index % RATIOS.len()];
        *cases += 1;
        let apart = own / best.1 - 1.0;
        if apart <= NEAR {
            *good += 1;
        } else {
            println!("  case {index}: {own:.6}, and {:.6} {}", best.1, best.0);
        }
        *worst = worst.max(apart);
    }
    for (ratio, (cases, good, worst)) in RATIOS.iter().zip(tally).filter(|(_, tally)| tally.0 > 0) {
        println!(
            "ratio {ratio:<3} {good} of {cases} as cheap as their best image, worst {:.2} %",
            100.0 * worst
        );
    }
    let (cases, good) = tally.iter().fold((0, 0), |(cases, good), one| (cases + one.0, good + one.1));
    println!("{good} of {cases} in all; median {:.1} ms", 1e3 * median(&mut seconds));
    if (good as f64) < 0.995 * cases as f64 { Err("see above".into()) } else { Ok(()) }
}
