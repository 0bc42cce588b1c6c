//! Compares the plans of one maneuver in different forms: mirrored, on other grids, and with the
//! rotation as given.
//!
//! `cargo run --release -p evidence -- consistency [COUNT [SEED] [PART …]]`, 500 by default;
//! the parts are `mirrors`, `F1`, `F2`, `F3`, `F5`, `F6` and `turns`, all by default.
//!
//! - Mirrors: a body turns by θ and by −θ about a principal axis, from rest to rest; in one of ten
//!   cases θ is 180° minus a millionth of a radian. By symmetry, the costs must agree to 1e-9.
//! - Grids: maneuvers of the families F1, F2, F3, F5 and F6 on 100, 200 and 400 steps. Costs of one
//!   extremal converge at second order, so the second difference is a quarter of the first. If this
//!   does not hold within a third, and the costs differ by more than 1e-6, each plan is continued
//!   to the next grid: by Newton's method from its costates, directly or over intermediate grids,
//!   or by SCP along its path. The continuation succeeds if the nodes move by less than 0.2 rad.
//!   The continued plan is then the plan of that grid, or it costs more: the costs of two extremals
//!   cross between the grids, and each is cheaper on its own grid. If the continued plan costs
//!   less, or no continuation succeeds, a search has missed it. This counts as another answer.
//! - Turns as given: prescribed rotations of 200° to 700° about a random axis, with rates of up to
//!   2 rad/T at both ends. If a plan is reported as solved and verified, its rotation must be the
//!   prescribed one, full turns included. This is checked here independently, on the double cover
//!   of the rotations.
//!
//! The command ends with 1 if a mirror image has another cost, or if a plan with another rotation
//! than the prescribed one is reported as solved.

use evidence::families::{self, FAMILIES};
use evidence::words::{Misuse, Words};
use slewkit::maneuver::{Method, Outcome, Path, Problem, Settings, Solution, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::optimize::search::{Guess, polish, solve};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// The relative difference up to which costs of mirror images agree, and the relative difference
/// above which costs belong to different extremals.
const SAME: f64 = 1e-9;
const OTHER: f64 = 1e-6;
/// The largest distance between the nodes of one extremal on two grids \[rad\].
const NEAR: f64 = 0.2;
/// The number of intermediate grids over which an extremal is continued if it does not converge on
/// the next grid directly.
const GRIDS_BETWEEN: i32 = 12;
/// The indices of the families that are planned on several grids.
const ON_GRIDS: [usize; 5] = [0, 1, 2, 4, 5];
/// The number of steps of the coarsest grid, and the numbers of the random streams of mirrors and
/// turns, which no family uses.
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

/// Returns the cost of a maneuver's plan; NaN if it is not solved.
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
    // The comparison is written so that a NaN counts as a difference.
    let same = (one / other - 1.0).abs() <= SAME;
    if !same {
        println!("mirrors, case {index}: {one} and {other}, {:.2}° about axis {axis}", angle.to_degrees());
    }
    same
}

/// The result of comparing the plans of one maneuver on several grids.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Agreement {
    OneExtremal,
    Crossing,
    Other,
}

fn grids(problem: &Problem, name: &str, index: usize) -> Agreement {
    let grids = [1, 2, 4].map(|finer| problem.clone().with_steps(finer * STEPS));
    // The verdict of the witnesses does not count, because the steps may be too long for them.
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

/// Continues a plan to another grid and compares it with the plan of that grid; `None` if it cannot
/// be continued.
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

/// Continues a plan to another grid along its path: by Newton's method directly or over
/// intermediate grids, or by SCP. Returns `None` if this fails.
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

/// The result of planning a prescribed rotation.
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
    // The sign of each quaternion is chosen so that it is near the quaternion before.
    let mut lift = [1.0, 0.0, 0.0, 0.0];
    for quaternion in &plan.solution.trajectory.quaternion {
        let along: f64 = lift.iter().zip(quaternion).map(|(a, b)| a * b).sum();
        lift = quaternion.map(|part| part * along.signum());
    }
    let half = 0.5 * asked.norm();
    let axis = asked.normalize() * half.sin();
    let wanted = [half.cos(), axis.x, axis.y, axis.z];
    let along: f64 = lift.iter().zip(wanted).map(|(a, b)| a * b).sum();
    // The comparison is written so that a NaN counts as a difference.
    let there = along > 1.0 - 1e-9;
    if !there {
        println!("turn {index}, {:.0}°: solved, but it goes another way", asked.norm().to_degrees());
    }
    Ok(if there { Turn::AsAsked } else { Turn::Wrong })
}
