//! Counts how often random maneuvers are solved from a cold start with default settings.
//!
//! `cargo run --release -p evidence -- robustness [CASES [SEED]]` prints the laws of the random
//! maneuvers and the results. CASES is the number of maneuvers of each kind (10 000 by default). A
//! tenth of that number is planned with torque limits, by shooting alone and by the default method.
//! Every case depends only on the seed and its number.

use evidence::Random;
use evidence::words::Words;
use slewkit::maneuver::{Method, Problem, Rung, Scheme, Settings, State};
use slewkit::mechanics::{Body, Inertia, Limits};
use slewkit::optimize::search::solve;
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Vector3, lie};
use std::collections::BTreeMap;
use std::error::Error;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const STEPS: usize = 200;
const TERMINAL_LIMIT: f64 = 1e-12;

/// Draws an inertia whose principal moments have a ratio of up to 20, about random axes.
fn inertia(random: &mut Random) -> Inertia {
    let moments = random.moments(20.0);
    random.about_any_axes(&moments)
}

fn rates(random: &mut Random) -> Vector3 {
    random.within_cube(5.0)
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    RestToRest,
    MovingEnds,
    EachTorqueLimited,
    TorqueNormLimited,
}

fn problem(kind: Kind, seed: u64, index: usize) -> Problem {
    let mut random = Random::of_case(seed ^ ((kind as u64 + 1) << 56), index);
    let body = Body { inertia: inertia(&mut random), mass: None };
    let start = random.uniform_rotation();
    let end = match (kind, random.unit()) {
        (Kind::MovingEnds, _) => random.uniform_rotation(),
        (_, share) if share < 0.02 => {
            start * lie::exp(&(random.normal_direction() * (PI - random.within(-1e-6, 1e-6))))
        }
        (_, share) if share < 0.04 => {
            start * lie::exp(&(random.normal_direction() * random.within(0.0, 1e-6)))
        }
        _ => random.uniform_rotation(),
    };
    let end = lie::project_to_rotation(&end);
    let (start, end) = match kind {
        Kind::MovingEnds => {
            (State::attitude(start, rates(&mut random)), State::attitude(end, rates(&mut random)))
        }
        _ => (State::at_rest(start), State::at_rest(end)),
    };
    let problem = Problem::attitude(body, start, end, 1.0).with_steps(STEPS);
    let limited = matches!(kind, Kind::EachTorqueLimited | Kind::TorqueNormLimited);
    if !limited {
        return problem;
    }
    let scheme = if index.is_multiple_of(2) { Scheme::LieVerlet } else { Scheme::LieEuler };
    within_limits(kind, problem.with_scheme(scheme), random.within(0.6, 0.95))
}

/// Limits every torque, or the norm of the torques, to a fraction of its peak in the plan without
/// limits.
fn within_limits(kind: Kind, mut problem: Problem, part: f64) -> Problem {
    let free = solve(&problem, &Settings::discrete(), None, &mut Silent).expect("a valid problem");
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, f64::max);
    let torque = &free.trajectory.torque;
    let limits = if kind == Kind::TorqueNormLimited {
        let peak = largest(&mut torque.iter().map(|torque| torque.norm()));
        Limits { norm: Some(part * peak), ..Limits::default() }
    } else {
        let peak = largest(&mut torque.iter().map(|torque| torque.amax()));
        Limits { size: Some(vec![part * peak; 3]), ..Limits::default() }
    };
    let torque = problem.actuation.torque.clone().with_limits(limits).expect("a positive peak");
    problem.actuation.torque = torque;
    problem
}

/// The counted results of one plan.
struct Case {
    index: usize,
    status: Status,
    rung: String,
    terminal: f64,
    witness: f64,
    conjugate_points: Option<usize>,
    seconds: f64,
}

fn case(kind: Kind, method: Method, seed: u64, index: usize) -> Case {
    let problem = problem(kind, seed, index);
    let settings = Settings { method, ..Settings::default() };
    let Plan { solution, verification, status, .. } =
        plan(&problem, &settings, None, &mut Silent).expect("a valid problem");
    // The strategy that found the best plan is the last one on a coarse grid before the refinement.
    let rung = solution
        .ladder
        .iter()
        .rev()
        .find(|rung| rung.start == solution.start && rung.rung != Rung::CoarseToFine)
        .map_or_else(|| "none".into(), |rung| rung.rung.to_string());
    let witness = verification
        .map_or(f64::INFINITY, |found| found.discrete_attitude_rad.max(found.discrete_momentum_relative));
    Case {
        index,
        status,
        rung,
        terminal: solution.terminal.largest(),
        witness,
        conjugate_points: solution.optimality.conjugate_points,
        seconds: solution.solve_time,
    }
}

fn count(kind: Kind, method: Method, name: &str, cases: usize, seed: u64) {
    let began = Instant::now();
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut results: Vec<Case> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|_| {
                scope.spawn(|| {
                    let mut mine = Vec::new();
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= cases {
                            return mine;
                        }
                        mine.push(case(kind, method, seed, index));
                    }
                })
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("no panic")).collect()
    });
    results.sort_by_key(|case| case.index);
    println!("{name}: {cases} cases");
    let mut statuses = BTreeMap::new();
    let mut rungs = BTreeMap::new();
    for case in &results {
        *statuses.entry(case.status.name()).or_insert(0usize) += 1;
        if case.status == Status::Solved {
            *rungs.entry(case.rung.as_str()).or_insert(0usize) += 1;
        }
    }
    let share = |count: usize| 100.0 * count as f64 / cases as f64;
    for (status, count) in &statuses {
        println!("  {status:<22}{count:>7}  {:.3} %", share(*count));
    }
    for (rung, count) in &rungs {
        println!("    by {rung:<17}{count:>7}  {:.3} %", share(*count));
    }
    let solved: Vec<&Case> = results.iter().filter(|case| case.status == Status::Solved).collect();
    let wrong =
        solved.iter().filter(|case| case.terminal > TERMINAL_LIMIT || case.witness > TERMINAL_LIMIT).count();
    let worst = |value: &dyn Fn(&Case) -> f64| solved.iter().map(|case| value(case)).fold(0.0, f64::max);
    println!("  called solved with a terminal error above {TERMINAL_LIMIT:.0e}: {wrong}");
    println!("  largest terminal error: solver {:.1e}", worst(&|case| case.terminal));
    println!("  largest terminal error: witness {:.1e}", worst(&|case| case.witness));
    let minima = solved.iter().filter(|case| case.conjugate_points == Some(0)).count();
    println!("  without a conjugate point: {minima}  {:.3} %", share(minima));
    let mut times: Vec<f64> = results.iter().map(|case| case.seconds).collect();
    times.sort_by(f64::total_cmp);
    let at = |part: f64| 1e3 * times[((times.len() - 1) as f64 * part) as usize];
    println!("  solve time, ms: median {:.2}, 99 % {:.2}, largest {:.2}", at(0.5), at(0.99), at(1.0));
    let failed: Vec<usize> =
        results.iter().filter(|case| case.status != Status::Solved).map(|case| case.index).collect();
    if !failed.is_empty() {
        println!("  not solved: {:?}", &failed[..failed.len().min(40)]);
    }
    println!("  wall time {:.1} s on {threads} threads\n", began.elapsed().as_secs_f64());
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let cases = words.number("number of cases", 10_000)?;
    let seed = words.number("seed", 2026)?;
    words.end()?;
    println!(
        "Random slews from a cold start: T = 1, lie_verlet, N = {STEPS}, default settings, seed {seed}."
    );
    println!("Attitudes uniform on SO(3); principal second moments of mass log-uniform over a factor of 40,");
    println!("principal ratios of the inertia up to 20, random axes.\n");
    let auto = Method::Auto;
    let rest = "Rest to rest, 2 % within 1e-6 of 180 deg, 2 % within 1e-6 of 0";
    count(Kind::RestToRest, auto, rest, cases, seed);
    count(Kind::MovingEnds, auto, "Boundary rates uniform in ±5 rad/T on each axis, both ends", cases, seed);
    println!("The same rest to rest, both schemes by turns, torques within 60 to 95 % of their peak without");
    println!("limits:\n");
    for (kind, what) in [
        (Kind::EachTorqueLimited, "Each torque limited"),
        (Kind::TorqueNormLimited, "Norm of the torque limited"),
    ] {
        for (method, road) in [(Method::Shooting, "shooting alone"), (auto, "default method")] {
            count(kind, method, &format!("{what}, {road}"), cases / 10, seed);
        }
    }
    Ok(())
}
