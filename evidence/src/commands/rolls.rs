//! Compares plans with a free roll about the boresight with the cheapest of 24 given rolls, each
//! the short and the long way.
//!
//! `cargo run --release -p evidence -- rolls [COUNT]`: COUNT (500 by default) random maneuvers of
//! each of two kinds. In the first the boresight ends at rest at a fixed direction, in the second
//! at a moving direction and at its rate. The bodies have moments in a ratio of up to 10 about
//! random axes, and start at rest or with a rate. Boresights and directions are uniform on the
//! sphere, moving directions turn at up to 0.3 rad/s about each axis, and the duration is 2 to 8 s.
//! The plans minimise effort on 100 steps.
//!
//! The command prints how many plans cost no more than the best of the given rolls, and the time of
//! a plan relative to the time of a plan with a given end attitude. It ends with 1 if fewer than
//! 99.5 % of the plans cost no more.

use evidence::Random;
use evidence::words::Words;
use slewkit::maneuver::{Aim, Path, Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Body, Direction, Matrix3, Problem, State, Vector3, lie};
use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

/// The number of given rolls.
const ROLLS: usize = 24;
/// The relative excess over the cost of the best given roll above which a plan counts as a miss.
const NEAR: f64 = 1e-6;

/// Returns a direction that turns at a constant rate.
fn moving(from: &Vector3, rate: &Vector3, duration: f64) -> Direction {
    let along = |time: f64| lie::exp(&(rate * time)) * from;
    Direction::along(0.0, duration, duration, 20, along).expect("a unit vector does not vanish")
}

fn maneuver(index: usize, moves: bool) -> Problem {
    let mut random = Random::of_case(41, 2 * index + usize::from(moves));
    let body = Body { inertia: random.inertia(10.0), mass: None };
    let rate = if random.coin() { Vector3::zeros() } else { random.within_cube(0.5) };
    let start = State::attitude(random.uniform_rotation(), rate);
    let (boresight, direction) = (random.direction(), random.direction());
    let duration = random.within(2.0, 8.0);
    let at = if moves {
        moving(&direction, &random.within_cube(0.3), duration)
    } else {
        Direction::Fixed(direction)
    };
    let aim = Aim::new(boresight, at);
    Problem::attitude(body, start, start, duration).with_aim_at_end(if moves { aim } else { aim.at_rest() })
}

/// Plans the maneuver with each of the given rolls, and returns the lowest cost.
fn best_of_rolls(problem: &Problem, settings: &Settings) -> Result<f64, Box<dyn Error>> {
    let aim = problem.aim().ok_or("no target")?;
    let ends = aim.ends(problem.seconds(), &problem.start.attitude, &Vector3::zeros())?;
    let mut best = f64::INFINITY;
    for index in 0..ROLLS {
        let (attitude, angular_velocity) = ends.at(TAU * index as f64 / ROLLS as f64);
        let given = given(problem, attitude, angular_velocity);
        for path in [Path::Shortest, Path::Long] {
            let found = plan(&given.clone().with_path(path), settings, None, &mut Silent)?;
            if found.status == Status::Solved {
                best = best.min(found.solution.cost);
            }
        }
    }
    Ok(best)
}

fn given(problem: &Problem, attitude: Matrix3, rate: Vector3) -> Problem {
    let end = State::attitude(attitude, rate);
    Problem { end, end_condition: slewkit::maneuver::EndCondition::State, ..problem.clone() }
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of maneuvers", 500)?;
    words.end()?;
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut missed = false;
    for moves in [false, true] {
        let (mut good, mut worst, mut unsolved) = (0, 0.0_f64, 0);
        let (mut ratios, mut seconds) = (Vec::new(), Vec::new());
        for index in 0..count {
            let problem = maneuver(index, moves);
            let found = plan(&problem, &settings, None, &mut Silent)?;
            let best = best_of_rolls(&problem, &settings)?;
            if found.status != Status::Solved {
                unsolved += 1;
                println!("  case {index}: {}", found.status.name());
                continue;
            }
            let apart = found.solution.cost / best - 1.0;
            good += usize::from(apart <= NEAR);
            if apart > NEAR {
                println!("  case {index}: {:.6} where {best:.6} exists", found.solution.cost);
            }
            worst = worst.max(apart);
            let timed = |problem: &Problem| {
                let began = Instant::now();
                let planned = plan(problem, &Settings::default(), None, &mut Silent);
                planned.map(|planned| (began.elapsed().as_secs_f64(), planned))
            };
            let (took, planned) = timed(&problem.clone().with_steps(100))?;
            let last = planned.solution.trajectory.quaternion.last().ok_or("no end")?;
            let end = lie::project_to_rotation(&lie::rotation_from_quaternion(last));
            let aim = problem.aim().ok_or("no target")?;
            let ends = aim.ends(problem.seconds(), &problem.start.attitude, &Vector3::zeros())?;
            let (attitude, rate) = ends.at(ends.nearest(&end));
            let (alone, _) = timed(&given(&problem, attitude, rate).with_steps(100))?;
            ratios.push(took / alone);
            seconds.push(took);
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let what = if moves { "moving, rate matched" } else { "fixed, at rest" };
        println!(
            "{what:<22} {good} of {count} as cheap as the best of {ROLLS} rolls, worst {worst:+.2e}, \
                {unsolved} unsolved; median {:.2} ms, {:.1} times the plan to the end that was found",
            1e3 * median(&mut seconds),
            median(&mut ratios)
        );
        missed |= (good as f64) < 0.995 * count as f64;
    }
    if missed { Err("see above".into()) } else { Ok(()) }
}
