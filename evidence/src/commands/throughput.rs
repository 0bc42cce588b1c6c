//! Measures the number of maneuvers per second, bare and with all features, on one thread and on
//! two, and the memory of a long Monte Carlo run.
//!
//! `cargo run --release -p evidence -- throughput [CASES] [STEPS] [ROUNDS] [NAME]`: slews of a free
//! asymmetric body between states of rest, end attitudes drawn within a ball of rotation vectors of
//! 1.5 rad. `bare` solves the shortest way to 1e-12 without the test of second order, and replays
//! it by the discrete witness, from library calls. The other measurements run as a batch with a
//! file of results and all witnesses, as in `slew monte-carlo`. Rounds on one thread and on two
//! threads alternate, and the best round of each counts, so that other work of the machine affects
//! both in the same way. On a busy machine, the CPU time of Linux is more reliable. NAME selects
//! one of the measurements, such as `bare`.

use evidence::process::{own_cpu_seconds, peak_memory};
use evidence::words::{Misuse, Words};
use slewkit::lie;
use slewkit::maneuver::{Outcome, Problem, Settings};
use slewkit::optimize::search;
use slewkit::plan::Silent;
use slewkit::verify;
use slewkit_files::batch::{Batch, CaseResult, Journal, Options, Shard, Tally, run as run_batch};
use slewkit_files::spec::{Base, Format, Override};
use std::error::Error;
use std::path::Path;
use std::thread;
use std::time::Instant;

const SPEC: &str = r#"
format = 1
body = { inertia_kg_m2 = [[120, 4, -3], [4, 100, 2], [-3, 2, 80]] }
start = { attitude = { axis = [0, 0, 1], angle_deg = 0 } }
end = { attitude = { axis = [1, 2, 3], angle_deg = 60 } }
maneuver = { duration_s = 60 }

[dispersion]
seed = 1
cases = 1000
[[dispersion.vary]]
key = "end.attitude.rotation_vector_rad"
kind = "ellipsoid"
semi_axes = [1.5, 1.5, 1.5]
"#;

/// The overrides for the quickest complete plan, and for a bare plan.
const QUICK: [&str; 2] = ["solver.search=quick", "maneuver.path=shortest"];
const BARE: [&str; 3] = [QUICK[0], QUICK[1], "solver.second_order=skipped"];
/// The largest terminal error of the discrete witness, scaled.
const TOLERANCE: f64 = 1e-12;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let cases: u64 = words.number("number of slews", 400)?;
    let steps: usize = words.number("number of steps", 100)?;
    let rounds: usize = words.number("number of rounds", 3)?;
    let wanted = words.take().unwrap_or_default();
    words.end()?;
    let names = ["bare, shortest way", "quick, shortest way", "default"];
    if !names.iter().any(|name| name.contains(&wanted)) {
        return Err(Misuse::of("part of a name", &wanted, &names).into());
    }
    println!("{cases} slews, {steps} steps; the best of {rounds} rounds each");

    let drawn = problems(&batch(cases, steps, &BARE)?, cases)?;
    if "bare, shortest way".contains(&wanted) {
        told("bare, shortest way", rounds, cases, &mut |threads| bare(&drawn, threads));
    }

    let folder = std::env::temp_dir().join(format!("slewkit-throughput-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let path = folder.join("results.jsonl");
    let whole = [("quick, shortest way", &QUICK[..]), ("default", &[])];
    for (name, settings) in whole.into_iter().filter(|(name, _)| name.contains(&wanted)) {
        let batch = batch(cases, steps, settings)?;
        told(name, rounds, cases, &mut |threads| verified(&batch, threads, &path).expect("a batch"));
    }
    std::fs::remove_dir_all(&folder)?;
    // Only Linux reports the peak of the resident memory.
    if let Some(peak) = peak_memory("self") {
        println!("  peak memory {:.0} MB", peak / 1e6);
    }
    Ok(())
}

/// Runs `solved` alternately on one thread and on two threads, and prints the cases per second.
/// `solved` returns the number of solved cases.
fn told(name: &str, rounds: usize, cases: u64, solved: &mut dyn FnMut(usize) -> u64) {
    let (mut best, mut count, mut least) = ([0.0_f64; 2], [0; 2], f64::INFINITY);
    for _ in 0..rounds {
        for threads in [1, 2] {
            let (began, before) = (Instant::now(), own_cpu_seconds());
            count[threads - 1] = solved(threads);
            if threads == 1 {
                least = least.min((own_cpu_seconds() - before) / cases as f64);
            }
            let rate = cases as f64 / began.elapsed().as_secs_f64();
            best[threads - 1] = best[threads - 1].max(rate);
        }
    }
    let ([one, two], ratio) = (best, best[1] / best[0]);
    assert_eq!(count[0], count[1], "threads change nothing");
    println!(
        "  {name:<20} 1 thread {one:7.0} a second, 2 threads {two:7.0}: {ratio:.2} ×; {:.0} µs of a \
            processor each; {} solved",
        1e6 * least,
        count[0]
    );
}

fn batch(cases: u64, steps: usize, settings: &[&str]) -> Result<Batch, Box<dyn Error>> {
    let set = [format!("dispersion.cases={cases}"), format!("maneuver.steps={steps}")];
    let set = set.iter().map(String::as_str).chain(settings.iter().copied()).map(Override::parse);
    let set = set.collect::<Result<Vec<_>, _>>()?;
    let base = Base::from_reader(SPEC.as_bytes(), "throughput.toml", Format::Toml, &set)?;
    Ok(Batch::of_dispersion(base)?)
}

/// Reads all maneuvers of a batch, so that the measurement does not include reading.
fn problems(batch: &Batch, cases: u64) -> Result<Vec<(Problem, Settings)>, Box<dyn Error>> {
    let read = |number| {
        let loaded = batch.read(&batch.case(number)?)?.maneuver().ok_or("the spec is of one maneuver")?;
        Ok((loaded.problem, loaded.settings))
    };
    (1..=cases).map(read).collect()
}

/// Solves and replays all maneuvers. The threads share them in alternation. Returns the number of
/// solved ones.
fn bare(problems: &[(Problem, Settings)], threads: usize) -> u64 {
    let one = |(problem, settings): &(Problem, Settings)| {
        let solution = search::solve(problem, settings, None, &mut Silent).expect("a usable problem");
        let replayed = verify::replay(problem, &solution.trajectory.input).expect("inputs that fit");
        let (end, rate) = (replayed.quaternion.last(), replayed.angular_velocity.last());
        let (end, rate) = (lie::rotation_from_quaternion(end.expect("a node")), rate.expect("a node"));
        let angle = lie::minus(&end, &problem.end.attitude).norm();
        let momentum = problem.body.inertia.j() * (rate - problem.end.angular_velocity);
        let mean = problem.body.inertia.j().trace() / 3.0;
        let error = angle.max(momentum.norm() * problem.seconds() / mean);
        solution.outcome == Outcome::Converged && error <= TOLERANCE
    };
    let part = |first: usize| problems.iter().skip(first).step_by(threads).filter(|case| one(case)).count();
    thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|first| scope.spawn(move || part(first))).collect();
        let own = part(0);
        others.into_iter().map(|other| other.join().expect("no panic")).sum::<usize>() + own
    }) as u64
}

/// Plans and verifies all maneuvers as a batch with a file of results.
fn verified(batch: &Batch, threads: usize, path: &Path) -> Result<u64, Box<dyn Error>> {
    let options = Options { threads, ..Options::default() };
    let mut tally = Tally::default();
    let (mut journal, _) =
        Journal::open(path, &batch.header(Shard::ALL, false), true, &mut |_: &CaseResult| {})?;
    run_batch(
        batch,
        Shard::ALL,
        0,
        &options,
        &|| false,
        &mut |result, line| {
            tally.add(result);
            journal.line(line)
        },
        &mut || {},
    )?;
    journal.close()?;
    Ok(tally.solved())
}
