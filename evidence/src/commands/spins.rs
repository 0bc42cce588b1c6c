//! Compares `path = "best"` with each requested path for bodies that spin by 1 to 5 turns at an
//! end: the best path must not cost more.
//!
//! `cargo run --release -p evidence -- spins [COUNT [OBJECTIVE]]`: COUNT (200 by default) random
//! maneuvers, for minimum effort, minimum time and minimum fuel in turn. A body with moments in a
//! ratio of up to 3 spins about a principal axis at the start, at the end, or at both, so fast that
//! it makes 1 to 5 turns in the duration. At an end without a spin it is at rest. Minimum-fuel
//! maneuvers have three torques, or six one-sided thrusters, which can stop the spin in a third of
//! the duration. Plans have 60 steps, or 120 steps for three turns or more.
//!
//! The plan with the best path is compared with plans for the short way, the long way, and the
//! prescribed rotations whose numbers of turns are nearest to the natural motion. The command ends
//! with 1 if fewer than 99.5 % of the best paths cost no more than the cheapest of these plans,
//! within 0.2 % and the gap of the plan.

use evidence::switching::cost_and_gap;
use evidence::words::Words;
use evidence::{Random, median};
use slewkit::maneuver::{Objective, Path, Settings, Target};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Inertia, Limits};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Body, Matrix3, Problem, State, Vector3, lie};
use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

const OBJECTIVES: [&str; 3] = ["effort", "time", "fuel"];
/// The largest accepted excess of the best path over a requested path, relative to the cost.
const NEAR: f64 = 2e-3;
const DURATION: f64 = 10.0;

struct Case {
    problem: Problem,
    /// The rotation vector of the natural motion: the mean of the spins at both ends times the
    /// duration.
    natural: Vector3,
}

fn case(index: usize) -> Result<Case, Box<dyn Error>> {
    let mut random = Random::of_case(83, index);
    let inertia = Inertia::new(Matrix3::from_diagonal(&random.mean_moments(3.0)))?;
    let axis = Vector3::ith(random.below(3), 1.0);
    let turns = random.within(1.0, 5.0);
    let spin = axis * (TAU * turns / DURATION);
    let (at_start, at_end) = [(true, false), (false, true), (true, true)][index / 3 % 3];
    let rate = |spins: bool| if spins { spin } else { Vector3::zeros() };
    let start = State::attitude(Matrix3::identity(), rate(at_start));
    let end = State::attitude(random.uniform_rotation(), rate(at_end));
    let force = inertia.j().diagonal().dot(&axis.component_mul(&axis)) * spin.norm() / (DURATION / 3.0);
    let limits = Limits { size: Some(vec![force; 3]), ..Limits::default() };
    let three = ActuatorSet::three_axes(AxisFrame::Body);
    let problem = Problem::attitude(Body { inertia, mass: None }, start, end, DURATION);
    let problem = match OBJECTIVES[index % 3] {
        "effort" => problem,
        "time" => Problem::minimum_time(problem.body.clone(), start, end)
            .with_actuation(Actuation::torques(three.with_limits(limits)?)),
        _ => {
            let set = if (index / 9).is_multiple_of(2) {
                three.with_limits(limits)?
            } else {
                let axes = (0..6).map(|k| Vector3::ith(k / 2, if k % 2 == 0 { 1.0 } else { -1.0 })).collect();
                let limits = Limits { size: Some(vec![force; 6]), one_sided: true, ..Limits::default() };
                ActuatorSet::new(axes, AxisFrame::Body)?.with_limits(limits)?
            };
            Problem::minimum_fuel(problem.body.clone(), start, end, DURATION)
                .with_actuation(Actuation::torques(set))
        }
    };
    let share = if at_start && at_end { 1.0 } else { 0.5 };
    Ok(Case {
        problem: problem.with_steps(if turns < 3.0 { 60 } else { 120 }),
        natural: share * DURATION * spin,
    })
}

/// Returns rotation vectors that lead to the end attitude, with the numbers of turns nearest to the
/// natural motion.
fn windings(problem: &Problem, natural: &Vector3) -> Vec<Vector3> {
    let short = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let angle = short.norm();
    let axis = if angle > 0.0 { short / angle } else { Vector3::x() };
    let nearest = ((natural.dot(&axis) - angle) / TAU).round();
    [nearest - 1.0, nearest, nearest + 1.0].map(|turns| axis * (angle + TAU * turns)).to_vec()
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count = words.number("number of maneuvers", 200)?;
    let asked = words.one_of("objective", &OBJECTIVES)?;
    words.end()?;
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut tally = [(0, 0, 0, 0.0_f64); 3];
    let mut seconds = Vec::new();
    for index in 0..count {
        let objective = OBJECTIVES[index % 3];
        if asked.as_ref().is_some_and(|asked| asked != objective) {
            continue;
        }
        let Case { problem, natural } = case(index)?;
        let cost_of = |path: Path| -> Result<(f64, f64), Box<dyn Error>> {
            let found = plan(&problem.clone().with_path(path), &settings, None, &mut Silent)?;
            let solved = found.status == Status::Solved;
            Ok(if solved { cost_and_gap(&found) } else { (f64::INFINITY, 0.0) })
        };
        let began = Instant::now();
        let (best, gap) = cost_of(Path::Best)?;
        seconds.push(began.elapsed().as_secs_f64());
        let mut others = vec![("short", cost_of(Path::Shortest)?.0), ("long", cost_of(Path::Long)?.0)];
        if matches!(problem.objective, Objective::Effort(_)) {
            for winding in windings(&problem, &natural) {
                others.push(("given", cost_of(Path::AsGiven(winding))?.0));
            }
        }
        let (name, least) = others.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no other path")?;
        let (cases, good, unsolved, worst) = &mut tally[index % 3];
        *cases += 1;
        *unsolved += usize::from(best.is_infinite());
        let apart = if best.is_infinite() && least.is_infinite() { 0.0 } else { best / least - 1.0 };
        if apart <= NEAR + gap {
            *good += 1;
        } else {
            println!("  case {index}, {objective}: {best:.6}, and {least:.6} by the path {name}");
        }
        *worst = worst.max(apart);
    }
    for (objective, (cases, good, unsolved, worst)) in
        OBJECTIVES.iter().zip(tally).filter(|(_, tally)| tally.0 > 0)
    {
        println!(
            "{objective:<7} {good} of {cases} as cheap as any path, worst {:.2} %, {unsolved} unsolved",
            100.0 * worst
        );
    }
    let (cases, good) = tally.iter().fold((0, 0), |(cases, good), one| (cases + one.0, good + one.1));
    println!("{good} of {cases} in all; median {:.2} s", median(&mut seconds));
    if (good as f64) < 0.995 * cases as f64 { Err("see above".into()) } else { Ok(()) }
}
