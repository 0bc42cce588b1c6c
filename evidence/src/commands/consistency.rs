//! Compares the answers of the planner to one question in different forms.
//!
//! `cargo run --release -p evidence -- consistency [COUNT [SEED] [PART …]]`, 500 by default;
//! the parts are `mirrors`, `F1`, `F2`, `F3`, `F5`, `F6` and `turns`, all by default.
//!
//! - Mirrors: a box turns by θ and by −θ about a principal axis, from rest to rest, one in ten
//!   times by 180° less a millionth of a radian: equal costs to 1e-9, by symmetry.
//! - Grids: maneuvers of the families F1, F2, F3, F5 and F6 on 100, 200 and 400 steps. Costs of one
//!   extremal converge at second order: the second difference is a quarter of the first. If it is
//!   not within a third, and the costs differ by more than 1e-6, each answer is carried to the next
//!   grid: by Newton from its costates, at once or over grids between, or by SCP along its path. It
//!   is there if its nodes move by less than 0.2 rad. Either it is the answer of that grid, or it
//!   costs more than that answer: then the costs of two extremals cross between the grids, and each
//!   is the cheaper on its own. If it costs less, or neither can be carried, a search has missed
//!   it: another answer.
//! - Turns as given: 200° to 700° about any axis between rates up to 2 rad/T. A plan that is
//!   reported as solved and verified ends on the lift of the requested turn (the double cover of
//!   the rotations), which is counted here once more.
//!
//! Ends with 1 where a mirror image costs something else, or a turn is called solved that is
//! another.

use evidence::families::{self, FAMILIES};
use evidence::words::{Misuse, Words};
use slewkit::maneuver::{Method, Outcome, Path, Problem, Settings, Solution, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::optimize::search::{Guess, polish, solve};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Relative difference that costs of mirror images may have, and that other extremals have at
/// least.
const SAME: f64 = 1e-9;
const OTHER: f64 = 1e-6;
/// Nodes of one extremal on two grids are nearer than this \[rad\].
const NEAR: f64 = 0.2;
/// The grids through which an extremal is continued if it does not converge on the last grid at
/// once.
const GRIDS_BETWEEN: i32 = 12;
/// Families that are planned on several grids.
const ON_GRIDS: [usize; 5] = [0, 1, 2, 4, 5];
/// The number of steps of the coarsest grid, and an even number of streams of random numbers in
/// addition to the streams of the families.
const STEPS: usize = 100;
const STREAMS: [usize; 2] = [100, 101];

pub fn run(words: &mut Words) -> Result<(), Box<dyn std::error::Error>> {
    let (mut numbers, mut parts) = (Vec::new(), Vec::new());
    for text in words.rest() {
        match text.parse::<u64>() {
            Ok(number) => numbers.push(number),
            Err(_) => parts.push(text),
        }
    }
    let known = ON_GRIDS.map(|number| FAMILIES[number].name);
    let known: Vec<_> =
        known.iter().filter_map(|name| name.split(' ').next()).chain(["mirrors", "turns"]).collect();
    if let Some(unknown) = parts.iter().find(|part| !known.contains(&part.as_str())) {
        return Err(Misuse::of("part", unknown, &known).into());
    }
    let wanted = |name: &str| {
        parts.is_empty() || parts.iter().any(|part| Some(part.as_str()) == name.split(' ').next())
    };
    let count = numbers.first().copied().unwrap_or(500) as usize;
    let seed = numbers.get(1).copied().unwrap_or(1);
    let mut bad = 0;
    if wanted("mirrors") {
        let unequal = (0..count).filter(|index| !mirrors(seed, *index)).count();
        println!("mirrors: {unequal} of {count} pairs differ by more than {SAME:e}");
        bad += unequal;
    }
    for (number, family) in ON_GRIDS.map(|number| (number, &FAMILIES[number])) {
        if !wanted(family.name) {
            continue;
        }
        let mut tally = [0; 3];
        for index in 0..count {
            let problem = (family.draw)(&mut families::case(seed, number, index));
            tally[grids(&problem, family.name, index) as usize] += 1;
        }
        let [_, crossing, other] = tally;
        println!(
            "{}: {other} of {count} have another answer on another grid; of {crossing} the costs of two \
                extremals cross",
            family.name
        );
    }
    if wanted("turns") {
        let mut tally = [0; 3];
        for index in 0..count {
            tally[turn(seed, index)? as usize] += 1;
        }
        let [solved, unsolved, wrong] = tally;
        println!(
            "turns as given: {solved} of {count} solved and verified as asked, {unsolved} not solved, {wrong} wrong"
        );
        bad += wrong;
    }
    if bad > 0 { Err("see above".into()) } else { Ok(()) }
}

fn planned(problem: &Problem) -> Option<Plan> {
    plan(problem, &Settings::discrete(), None, &mut Silent).ok()
}

/// Returns the cost of a plan that is solved; NaN if it is not.
fn cost(problem: &Problem) -> f64 {
    planned(problem).filter(|plan| plan.status == Status::Solved).map_or(f64::NAN, |plan| plan.solution.cost)
}

fn mirrors(seed: u64, index: usize) -> bool {
    let mut random = families::case(seed, STREAMS[0], index);
    let body = Body { inertia: Inertia::diagonal(random.mean_moments(8.0)).expect("a box"), mass: None };
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

/// The agreement of the answers on several grids.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Agreement {
    OneExtremal,
    Crossing,
    Other,
}

fn grids(problem: &Problem, name: &str, index: usize) -> Agreement {
    let grids = [1, 2, 4].map(|finer| problem.clone().with_steps(finer * STEPS));
    // The verdict of the witness on so few steps is not considered.
    let answers = grids.each_ref().map(|problem| planned(problem).map(|plan| plan.solution));
    let costs =
        answers.each_ref().map(|answer| answer.as_ref().filter(|a| is_found(a)).map_or(f64::NAN, |a| a.cost));
    let (first, second) = (costs[0] - costs[1], costs[1] - costs[2]);
    let one_extremal = (second - 0.25 * first).abs() <= 0.25 * first.abs() / 3.0;
    if one_extremal || first.abs().max(second.abs()) <= OTHER * costs[2] {
        return Agreement::OneExtremal;
    }
    let mut agreement = Agreement::OneExtremal;
    for pair in 0..2 {
        let (Some(coarse), Some(fine)) = (&answers[pair], &answers[pair + 1]) else {
            return Agreement::Other;
        };
        let finer = compared(coarse, &grids[pair], fine, &grids[pair + 1]);
        let coarser = compared(fine, &grids[pair + 1], coarse, &grids[pair]);
        let both = match (finer, coarser) {
            (Some(Agreement::Other), _) | (_, Some(Agreement::Other)) | (None, None) => Agreement::Other,
            (Some(Agreement::OneExtremal), _) | (_, Some(Agreement::OneExtremal)) => Agreement::OneExtremal,
            (Some(Agreement::Crossing), Some(Agreement::Crossing)) => Agreement::Crossing,
            _ => Agreement::Other,
        };
        if both > agreement {
            agreement = both;
        }
    }
    if agreement != Agreement::OneExtremal {
        let told = if agreement == Agreement::Other { "another answer" } else { "costs cross" };
        println!("{name}, case {index}: {told}: {}, {}, {}", costs[0], costs[1], costs[2]);
    }
    agreement
}

fn is_found(solution: &Solution) -> bool {
    solution.outcome == Outcome::Converged
}

/// Compares an answer, continued to another grid, with the answer there; `None` if it cannot be
/// continued.
fn compared(answer: &Solution, on: &Problem, other: &Solution, on_other: &Problem) -> Option<Agreement> {
    if !is_found(answer) || !is_found(other) {
        return Some(Agreement::Other);
    }
    let carried = carried(answer, on, on_other)?;
    let difference = carried.cost / other.cost - 1.0;
    Some(match difference {
        _ if difference.abs() <= OTHER => Agreement::OneExtremal,
        _ if difference > 0.0 => Agreement::Crossing,
        _ => Agreement::Other,
    })
}

/// Returns the extremal on another grid that follows the path of an answer: by Newton at once, by
/// Newton grid by grid, or by SCP.
fn carried(answer: &Solution, on: &Problem, to: &Problem) -> Option<Solution> {
    let settings = Settings::discrete();
    let newton = |steps: usize, costates: &[f64]| {
        let found = polish(&to.clone().with_steps(steps), &settings, costates, &mut Silent).ok()?;
        is_found(&found).then_some(found)
    };
    let at_once = || newton(to.steps, answer.costates_0(on));
    let by_and_by = || {
        let mut known = answer.costates_0(on).to_vec();
        let ratio = to.steps as f64 / on.steps as f64;
        for part in 1..GRIDS_BETWEEN {
            let steps = on.steps as f64 * ratio.powf(f64::from(part) / f64::from(GRIDS_BETWEEN));
            let between = on.clone().with_steps(steps.round() as usize);
            known = newton(between.steps, &known)?.costates_0(&between).to_vec();
        }
        newton(to.steps, &known)
    };
    let by_path = || {
        let guess = Guess { costates: Vec::new(), ..Guess::of(answer, on) };
        let settings = Settings { method: Method::Scp, ..settings.clone() };
        solve(to, &settings, Some(&guess), &mut Silent).ok()
    };
    let is_near = |found: &Solution| is_found(found) && distance(found, answer) < NEAR;
    at_once().filter(is_near).or_else(|| by_and_by().filter(is_near)).or_else(|| by_path().filter(is_near))
}

/// Returns the largest angle between the nodes that the grids of two solutions share \[rad\].
fn distance(a: &Solution, b: &Solution) -> f64 {
    let [a, b] = [a, b].map(|solution| &solution.trajectory.quaternion);
    let (few, many) = if a.len() < b.len() { (a, b) } else { (b, a) };
    let ratio = (many.len() - 1) / (few.len() - 1);
    let angle = |(x, y): (&[f64; 4], &[f64; 4])| {
        let along: f64 = x.iter().zip(y).map(|(a, b)| a * b).sum();
        2.0 * along.abs().min(1.0).acos()
    };
    few.iter().zip(many.iter().step_by(ratio)).map(angle).fold(0.0, f64::max)
}

/// The result of a turn that is planned as written.
#[derive(Clone, Copy)]
enum Turn {
    AsAsked,
    NotSolved,
    Wrong,
}

fn turn(seed: u64, index: usize) -> Result<Turn, Box<dyn std::error::Error>> {
    let mut random = families::case(seed, STREAMS[1], index);
    let body = Body { inertia: random.inertia(8.0), mass: None };
    let asked = random.normal_direction() * random.within(200.0, 700.0).to_radians();
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
