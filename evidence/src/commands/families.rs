//! Counts how often the default search finds the best known plan, over families of random
//! maneuvers.
//!
//! `cargo run --release -p evidence -- families [FAMILY … [--cases COUNT] [--seed SEED] [--search
//! quick] [--case N]]` draws random maneuvers of each family, plans them with default settings, and
//! compares the cost with the lowest cost of a thorough search from at least two hundred starts. A
//! cost within 1e-6 of it counts as a hit. Every case depends only on the seed and its number.

use evidence::families::{self, FAMILIES};
use evidence::words::{Misuse, Words};
use slewkit::maneuver::problem::Problem;
use slewkit::maneuver::settings::{Method, Settings, Thoroughness};
use slewkit::maneuver::solution::{Outcome, Solution};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

const STEPS: usize = 100;
/// The relative excess over the best known cost up to which a default plan counts as a hit.
const HIT: f64 = 1e-6;

/// The result of a case.
struct Case {
    index: usize,
    /// The relative excess of the default plan's cost over the best known cost.
    excess: Option<f64>,
    saddle: bool,
    seconds: f64,
    start: String,
    best_start: String,
}

fn cost(solution: &Solution) -> f64 {
    if solution.outcome == Outcome::Converged { solution.cost } else { f64::INFINITY }
}

/// Returns the best result of the thorough search. For limited maneuvers, the search also includes
/// SCP, which starts from other paths than shooting.
fn best_known(problem: &Problem) -> Solution {
    let by = |method| {
        let settings = Settings { search: Thoroughness::Thorough, method, ..Settings::discrete() };
        solve(problem, &settings, None, &mut Silent).expect("a sound problem")
    };
    let found = by(Method::Auto);
    if !problem.actuation.is_limited() || problem.actuation.wheels.is_some() {
        return found;
    }
    let convex = by(Method::Scp);
    if cost(&convex) < cost(&found) { convex } else { found }
}

fn judged(problem: &Problem, search: Thoroughness, index: usize) -> Case {
    let settings = Settings { search, ..Settings::discrete() };
    let clock = Instant::now();
    let default = solve(problem, &settings, None, &mut Silent).expect("a sound problem");
    let seconds = clock.elapsed().as_secs_f64();
    let thorough = best_known(problem);
    let best = cost(&default).min(cost(&thorough));
    Case {
        index,
        excess: (cost(&default).is_finite()).then(|| cost(&default) / best - 1.0),
        saddle: default.optimality.conjugate_points.is_some_and(|points| points > 0),
        seconds,
        start: default.start,
        best_start: thorough.start,
    }
}

/// Prints all attempts of one case.
fn tell(problem: &Problem, search: Thoroughness) {
    let settings = Settings { search, ..Settings::discrete() };
    let solution = solve(problem, &settings, None, &mut Silent).expect("a sound problem");
    for rung in &solution.ladder {
        let (first, last) = (rung.residuals.first(), rung.residuals.last());
        println!(
            "{:14} {:28} {:4} steps {:?} in {}: {first:?} to {last:?}",
            rung.rung, rung.start, rung.steps, rung.outcome, rung.iterations
        );
    }
    println!("{:?} {} {:?} {:?}", solution.outcome, solution.cost, solution.optimality, solution.shortfall);
    solution.rivals.iter().for_each(|rival| println!("{rival:?}"));
    let known = best_known(problem);
    let (cost, points, start) = (known.cost, known.optimality.conjugate_points, &known.start);
    println!("best known: {:?} {cost} {start}, conjugate points {points:?}", known.outcome);
    println!("excess {:e}", solution.cost / cost - 1.0);
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let mut wanted = Vec::new();
    let mut only = None;
    let (mut cases, mut seed, mut search) = (500, 1, Thoroughness::Default);
    let known = FAMILIES.each_ref().map(|family| family.name.split(' ').next().unwrap_or_default());
    while let Some(word) = words.take() {
        match word.as_str() {
            "--cases" => cases = words.required("number of cases")?,
            "--seed" => seed = words.required("seed")?,
            "--case" => only = Some(words.required("number of a case")?),
            "--search" => {
                let quick = words.required_one_of("search", &["quick", "default"])? == "quick";
                search = if quick { Thoroughness::Quick } else { Thoroughness::Default };
            }
            family if known.contains(&family) => wanted.push(word),
            _ => return Err(Misuse::of("family or option", &word, &known).into()),
        }
    }
    println!("{cases} cases a family, seed {seed}, {STEPS} steps; a hit is within {HIT:e} of the best known");
    println!("| family | hits | saddles | no plan | excess of misses: median, worst | ms: median, mean |");
    println!("|---|---|---|---|---|---|");
    for (number, family) in FAMILIES.iter().enumerate() {
        if !wanted.is_empty() && !wanted.iter().any(|name| family.name.split(" ").next() == Some(name)) {
            continue;
        }
        if let Some(index) = only {
            let mut random = families::case(seed, number, index);
            tell(&(family.draw)(&mut random).with_steps(STEPS), search);
            return Ok(());
        }
        let next = AtomicUsize::new(0);
        let results = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= cases {
                            break;
                        }
                        let mut random = families::case(seed, number, index);
                        let problem = (family.draw)(&mut random).with_steps(STEPS);
                        let case = judged(&problem, search, index);
                        if let Ok(mut results) = results.lock() {
                            results.push(case);
                        }
                    }
                });
            }
        });
        let mut results = results.into_inner().expect("no thread panicked");
        results.sort_by_key(|case| case.index);
        let hits = results.iter().filter(|case| case.excess.is_some_and(|excess| excess <= HIT)).count();
        let saddles = results.iter().filter(|case| case.saddle).count();
        let unsolved = results.iter().filter(|case| case.excess.is_none()).count();
        let mut misses: Vec<f64> =
            results.iter().filter_map(|case| case.excess).filter(|e| *e > HIT).collect();
        misses.sort_by(f64::total_cmp);
        let mut times: Vec<f64> = results.iter().map(|case| case.seconds * 1e3).collect();
        times.sort_by(f64::total_cmp);
        let share = 100.0 * hits as f64 / cases as f64;
        let missed = match misses.last() {
            Some(worst) => format!("{:.2e}, {worst:.2e}", misses[misses.len() / 2]),
            None => "–".into(),
        };
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        println!(
            "| {} | {share:.1} % | {saddles} | {unsolved} | {missed} | {:.2}, {mean:.2} |",
            family.name,
            times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
        );
        for case in
            results.iter().filter(|case| case.saddle || case.excess.is_none_or(|excess| excess > HIT)).take(8)
        {
            eprintln!(
                "  case {}: excess {:?}, saddle {}, {} instead of {}",
                case.index, case.excess, case.saddle, case.start, case.best_start
            );
        }
    }
    Ok(())
}
