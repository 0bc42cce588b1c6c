//! Whether the planner gives the same answer to the same question, asked in other ways.
//!
//! `cargo run --release --example consistency [-- COUNT [SEED]]`, 500 by default.
//!
//! - Mirrors: a box turns by θ and by −θ about a principal axis, from rest to rest, one in ten times by 180° less a millionth of a
//!   radian: equal costs to 1e-9, by symmetry.
//! - Grids: maneuvers of the families F1, F2, F3, F5 and F6 on 100, 200 and 400 steps. Costs of one extremal converge at second order:
//!   the second difference is a quarter of the first. Where it is not within a third, and they differ by more than 1e-6, another
//!   extremal was the answer.
//! - Turns as given: 200° to 700° about any axis between rates up to 2 rad/T. A plan that is called solved and verified ends on the
//!   lift of the turn that was asked for (the double cover of the rotations), which is counted here once more.
//!
//! Ends with 1 where a mirror image costs something else, or a turn is called solved that is another.

#[path = "common/families.rs"]
mod families;

use families::{FAMILIES, Random};
use slewkit::maneuver::{Path, Problem, Settings, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Relative difference that costs of mirror images may have, and that other extremals have at least.
const SAME: f64 = 1e-9;
const OTHER: f64 = 1e-6;
/// Steps of the coarsest grid; an even number of streams for random numbers beside those of the families.
const STEPS: usize = 100;
const STREAMS: [usize; 2] = [100, 101];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<u64> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let count = numbers.first().copied().unwrap_or(500) as usize;
    let seed = numbers.get(1).copied().unwrap_or(1);
    let unequal = (0..count).filter(|index| !mirrors(seed, *index)).count();
    println!("mirrors: {unequal} of {count} pairs differ by more than {SAME:e}");
    for number in [0, 1, 2, 4, 5] {
        let family = &FAMILIES[number];
        let mut other = 0;
        for index in 0..count {
            let problem = (family.draw)(&mut Random::case(seed, number, index));
            other += usize::from(!grids(&problem, family.name, index));
        }
        println!("{}: {other} of {count} have another answer on another grid", family.name);
    }
    let mut tally = [0; 3];
    for index in 0..count {
        tally[turn(seed, index)? as usize] += 1;
    }
    let [solved, unsolved, wrong] = tally;
    println!(
        "turns as given: {solved} of {count} solved and verified as asked, {unsolved} not solved, {wrong} wrong"
    );
    if unequal + wrong > 0 { Err("see above".into()) } else { Ok(()) }
}

fn planned(problem: &Problem) -> Option<Plan> {
    plan(problem, &Settings::default(), None, &mut Silent).ok()
}

/// The cost of a plan that is solved; NaN where it is not.
fn cost(problem: &Problem) -> f64 {
    planned(problem).filter(|plan| plan.status == Status::Solved).map_or(f64::NAN, |plan| plan.solution.cost)
}

fn mirrors(seed: u64, index: usize) -> bool {
    let mut random = Random::case(seed, STREAMS[0], index);
    let body = Body { inertia: Inertia::diagonal(random.moments(8.0)).expect("a box"), mass: None };
    let angle = if index.is_multiple_of(10) { PI - 1e-6 } else { random.within(0.1, PI - 1e-3) };
    let axis = index % 3;
    let [one, other] = [angle, -angle].map(|angle| {
        let end = State::at_rest(lie::exp(&Vector3::ith(axis, angle)));
        let start = State::at_rest(Matrix3::identity());
        cost(&Problem::attitude(body.clone(), start, end, 1.0).with_steps(STEPS))
    });
    // Written so that a NaN is a complaint.
    let same = (one / other - 1.0).abs() <= SAME;
    if !same {
        println!("mirrors, case {index}: {one} and {other}, {:.2}° about axis {axis}", angle.to_degrees());
    }
    same
}

fn grids(problem: &Problem, name: &str, index: usize) -> bool {
    let [coarse, middle, fine] = [1, 2, 4].map(|finer| cost(&problem.clone().with_steps(finer * STEPS)));
    let (first, second) = (coarse - middle, middle - fine);
    let one_extremal = (second - 0.25 * first).abs() <= 0.25 * first.abs() / 3.0;
    let same = one_extremal || first.abs().max(second.abs()) <= OTHER * fine;
    if !same {
        println!("{name}, case {index}: {coarse}, {middle}, {fine}");
    }
    same
}

/// How a turn that is taken as written came out.
#[derive(Clone, Copy)]
enum Turn {
    AsAsked,
    NotSolved,
    Wrong,
}

fn turn(seed: u64, index: usize) -> Result<Turn, Box<dyn std::error::Error>> {
    let mut random = Random::case(seed, STREAMS[1], index);
    let body = Body { inertia: random.inertia(8.0), mass: None };
    let asked = random.direction() * random.within(200.0, 700.0).to_radians();
    let rate = if index.is_multiple_of(2) { 0.0 } else { 2.0 };
    let start = State::attitude(Matrix3::identity(), random.within_cube(rate));
    let end = State::attitude(lie::exp(&asked), random.within_cube(rate));
    let problem =
        Problem::attitude(body, start, end, 1.0).with_path(Path::AsGiven(asked)).with_steps(2 * STEPS);
    let plan = planned(&problem).ok_or("a sound problem")?;
    if plan.status != Status::Solved {
        println!("turn {index}, {:.0}°: {}", asked.norm().to_degrees(), plan.status.name());
        return Ok(Turn::NotSolved);
    }
    // Neighbours on the lift are on one side of it.
    let mut lift = [1.0, 0.0, 0.0, 0.0];
    for quaternion in &plan.solution.trajectory.quaternion {
        let along: f64 = lift.iter().zip(quaternion).map(|(a, b)| a * b).sum();
        lift = quaternion.map(|part| part * along.signum());
    }
    let half = 0.5 * asked.norm();
    let axis = asked.normalize() * half.sin();
    let wanted = [half.cos(), axis.x, axis.y, axis.z];
    let along: f64 = lift.iter().zip(wanted).map(|(a, b)| a * b).sum();
    // Written so that a NaN is a complaint.
    let there = along > 1.0 - 1e-9;
    if !there {
        println!("turn {index}, {:.0}°: solved, but it goes another way", asked.norm().to_degrees());
    }
    Ok(if there { Turn::AsAsked } else { Turn::Wrong })
}
