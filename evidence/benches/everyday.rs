//! Plans of everyday maneuvers: how many are solved and verified, in what time, at what cost.
//!
//! ```text
//! cargo bench -p benches --bench everyday [-- [KIND …] [--cases COUNT] [--seed SEED]
//!     [--limit SECONDS] [--costs FILE]]
//! ```
//!
//! It plans COUNT (100) maneuvers of each kind (`time`, `rate`, `cone`, `effort`) by the law of
//! `evidence::everyday`, in sequence, with default settings, each within SECONDS of wall time if
//! given. Times are processor times of all threads of a plan, if the system reports them, and wall
//! times otherwise. Costs are in seconds, or in N²·m²·s. FILE gets a line for each plan: kind,
//! seed, number, verdict, cost, seconds.
//!
//! In addition to the plans it times the interior point by itself, cold, from the path about the
//! fixed axis: the median of its iterations to round-off, and the median wall time of an iteration
//! divided by the steps.
//!
//! If `--bench` is missing (as when `cargo test` calls it), one maneuver of least effort is
//! planned.

use evidence::everyday::{KINDS, STEPS, maneuver};
use evidence::process::Watch;
use evidence::words::{Misuse, Words};
use slewkit::maneuver::{Problem, Settings};
use slewkit::optimize::with_cold_solve;
use slewkit::plan::{Silent, Status, plan};
use std::error::Error;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// The options of the command line.
struct Asked {
    kinds: Vec<String>,
    cases: usize,
    seed: u64,
    limit: Option<Duration>,
    costs: Option<String>,
}

impl Asked {
    fn read(words: &mut Words) -> Result<Self, Misuse> {
        let known = KINDS.map(|(name, _)| name);
        let mut asked = Self { kinds: Vec::new(), cases: 100, seed: 1, limit: None, costs: None };
        let mut is_bench = false;
        while let Some(word) = words.take() {
            match word.as_str() {
                "--bench" => is_bench = true,
                "--cases" => asked.cases = words.required("number of cases")?,
                "--seed" => asked.seed = words.required("seed")?,
                "--limit" => {
                    let seconds: f64 = words.required("number of seconds")?;
                    let limit = Duration::try_from_secs_f64(seconds);
                    asked.limit =
                        Some(limit.map_err(|_| Misuse::new(format!("no time limit: {seconds} s")))?);
                }
                "--costs" => asked.costs = Some(words.word("file")?),
                kind if known.contains(&kind) => asked.kinds.push(word),
                _ => return Err(Misuse::of("kind or option", &word, &known)),
            }
        }
        if !is_bench {
            asked = Self { kinds: vec!["effort".into()], cases: 1, ..asked };
        }
        Ok(asked)
    }
}

fn main() -> ExitCode {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let told =
        Asked::read(&mut Words::new(words.collect())).map_err(Into::into).and_then(|asked| run(&asked));
    let Err(error) = told else { return ExitCode::SUCCESS };
    eprintln!("everyday: {error}");
    ExitCode::from(if error.is::<Misuse>() { 2 } else { 1 })
}

fn run(asked: &Asked) -> Result<(), Box<dyn Error>> {
    let mut written = String::new();
    println!("everyday maneuvers, {STEPS} steps, seed {}, {} of each kind", asked.seed, asked.cases);
    println!(
        "{:<8}{:>14}{:>12}{:>10}{:>10}{:>14}{:>12}{:>10}",
        "kind", "solved", "median s", "99 % s", "worst s", "mean cost", "iterations", "us/step"
    );
    for (name, kind) in KINDS {
        if !(asked.kinds.is_empty() || asked.kinds.iter().any(|kind| kind == name)) {
            continue;
        }
        let (mut seconds, mut costs) = (Vec::new(), Vec::new());
        let (mut iterations, mut micros) = (Vec::new(), Vec::new());
        for number in 0..asked.cases {
            let problem = maneuver(kind, asked.seed, number);
            let settings = Settings { time_limit: asked.limit, ..Settings::default() };
            let watch = Watch::start();
            let found = plan(&problem, &settings, None, &mut Silent)?;
            let took = watch.seconds();
            seconds.push(took);
            let (status, cost) = (found.status, found.solution.cost);
            if status == Status::Solved {
                costs.push(cost);
                let duration = found.solution.trajectory.time.last().copied().unwrap_or(f64::NAN);
                let (count, took) = cold(&problem.with_duration(duration));
                iterations.push(count);
                micros.push(took);
            } else {
                println!("  {name} {number}: {}", status.name());
            }
            writeln!(written, "{name},{},{number},{},{cost:e},{took}", asked.seed, status.name())?;
        }
        let solved = format!("{} of {}", costs.len(), asked.cases);
        seconds.sort_by(f64::total_cmp);
        [&mut iterations, &mut micros].into_iter().for_each(|values| values.sort_by(f64::total_cmp));
        // The least that so large a part does not exceed.
        let of = |values: &[f64], part: f64| {
            let rank = (part * values.len() as f64).ceil() as usize;
            values.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
        };
        let at = |part: f64| of(&seconds, part);
        let mean = (costs.iter().map(|cost| cost.ln()).sum::<f64>() / costs.len() as f64).exp();
        let [count, took] = [&iterations, &micros].map(|values| of(values, 0.5));
        println!(
            "{name:<8}{solved:>14}{:>12.3}{:>10.3}{:>10.3}{mean:>14.6e}{count:>12.0}{took:>10.2}",
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
    println!("mean costs are geometric");
    if let Some(file) = &asked.costs {
        std::fs::write(file, written).map_err(|error| format!("{file}: {error}"))?;
    }
    Ok(())
}

/// The number of solves, of which the fastest counts.
const RUNS: usize = 5;

/// Returns the iterations of the interior point from its one start, and the microseconds of an
/// iteration for each step.
fn cold(problem: &Problem) -> (f64, f64) {
    with_cold_solve(problem, |solve| {
        let mut best = (f64::NAN, f64::INFINITY);
        for _ in 0..RUNS {
            let began = Instant::now();
            let iterations = solve().max(1) as f64;
            let each = 1e6 * began.elapsed().as_secs_f64() / iterations / problem.steps as f64;
            best = (iterations, best.1.min(each));
        }
        best
    })
}
