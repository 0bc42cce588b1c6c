//! Counts how many plans with a free roll or attitude at the end, or between states of motion, are
//! solved, and measures their time.
//!
//! `cargo run --release -p evidence -- ends [COUNT] [--thorough MORE] [--rolls FEW] [--only WORD]`:
//! COUNT (20) random maneuvers of each end with each of the inputs and limits, and of each motion,
//! by the law of `evidence::ends`, for minimum effort, time and fuel, with default settings. The
//! first MORE (5) are also planned with `search = "thorough"`. The first FEW (1) with a free roll
//! or a moving target in a given duration are also planned with 24 given rolls, of which the best
//! one counts. WORD selects the rows whose name contains it. `--specs FOLDER` only writes the
//! maneuvers to FOLDER as specs for other programs.
//!
//! The command prints one row for each combination: how many plans are solved and verified, the
//! elapsed time (median and largest), and how many of the compared plans exceed the best known cost
//! by more than 0.1 %, and by how much.

use evidence::ends::{ENDS, INPUTS, MOTIONS, OBJECTIVES, between, to_end};
use evidence::words::Words;
use slewkit::maneuver::{EndCondition, Settings, Target, Thoroughness};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Problem, State, Vector3};
use slewkit_files::spec::SpecDocument;
use std::error::Error;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The number of given rolls with which a free roll is compared.
const ROLLS: usize = 24;
/// The largest accepted excess over the best known cost, relative to it.
const NEAR: f64 = 1e-3;
/// The time limit of a plan \[s\].
const LONGEST: f64 = 60.0;
/// The elapsed time above which a plan is listed by name \[s\].
const SLOW: f64 = 2.0;
/// The distance in case numbers to the case that replaces one whose ends violate a limit.
const APART: usize = 1000;

/// Returns the discrete cost of a solved and verified plan, or the reason why none was found, and
/// the elapsed time \[s\].
fn planned(problem: &Problem, settings: &Settings) -> (Result<f64, String>, f64) {
    let settings = Settings { time_limit: Some(Duration::from_secs_f64(LONGEST)), ..settings.clone() };
    let began = Instant::now();
    let found = plan(problem, &settings, None, &mut Silent);
    let took = began.elapsed().as_secs_f64();
    let cost = found.map_err(|error| error.to_string()).and_then(|found| match found.status {
        Status::Solved => {
            Ok(found.solution.landing.map_or(found.solution.cost, |landing| landing.cost_before))
        }
        status => Err(found.solution.shortfall.map_or(format!("{status:?}"), |lacks| lacks.to_string())),
    });
    (cost, took)
}

/// Returns the cheapest of the plans to given rolls, in the duration of the maneuver.
fn of_rolls(problem: &Problem) -> Option<f64> {
    let duration = problem.duration.known()?;
    let ends = problem.aim()?.ends(duration, &problem.start.attitude, &Vector3::zeros()).ok()?;
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let mut best = f64::INFINITY;
    for index in 0..ROLLS {
        let (attitude, rate) = ends.at(TAU * index as f64 / ROLLS as f64);
        let end = State::attitude(attitude, rate);
        let given = Problem { end, end_condition: EndCondition::State, ..problem.clone() };
        if given.check().is_ok() {
            best = best.min(planned(&given, &settings).0.unwrap_or(f64::INFINITY));
        }
    }
    best.is_finite().then_some(best)
}

/// Draws the case with this number, or the next case whose start and end keep all limits. Returns
/// `None` if the end, the inputs and the objective cannot be combined.
fn usable(draw: &dyn Fn(usize) -> Problem, number: usize) -> Option<Problem> {
    (0..50).map(|again| draw(number + again * APART)).find(|problem| problem.check().is_ok())
}

/// The name of an end or motion with its inputs, its objective, and the function that draws the
/// maneuver with a given number.
type Row = (String, &'static str, Box<dyn Fn(usize) -> Problem>);

/// Writes the maneuvers of the rows whose name contains `only` as specs.
fn specs(folder: &Path, only: &str, count: usize, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for (name, of, draw) in rows.iter().filter(|(name, of, _)| format!("{name}, {of}").contains(only)) {
        for number in 0..count {
            let Some(problem) = usable(draw, number) else { continue };
            let document = SpecDocument::new(&problem, &Settings::default())?;
            let file = format!("{name} {of} {number}.json").replace(", ", "-").replace(' ', "_");
            std::fs::write(folder.join(file), serde_json::to_string(&document)?)?;
        }
    }
    Ok(())
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let (mut count, mut more, mut few, mut only) = (20, 5, 1, String::new());
    let mut folder = None;
    while let Some(word) = words.take() {
        match word.as_str() {
            "--thorough" => more = words.required("number of cases")?,
            "--rolls" => few = words.required("number of cases")?,
            "--specs" => folder = Some(PathBuf::from(words.word("folder")?)),
            "--only" => only = words.word("part of a name")?,
            _ => count = evidence::words::parsed("number of cases", &word)?,
        }
    }
    let mut rows: Vec<Row> = Vec::new();
    for end in ENDS {
        for input in INPUTS {
            for of in OBJECTIVES {
                let draw = Box::new(move |number| to_end(end, input, of, number));
                rows.push((format!("{end}, {input}"), of, draw));
            }
        }
    }
    for motion in MOTIONS {
        for of in OBJECTIVES {
            rows.push((motion.to_string(), of, Box::new(move |number| between(motion, of, number))));
        }
    }
    if let Some(folder) = folder {
        return specs(&folder, &only, count, &rows);
    }
    println!(
        "{:<38}{:<8}{:>9}{:>10}{:>10}{:>10}{:>10}",
        "end or motion", "cost", "solved", "median s", "worst s", "dearer", "worst"
    );
    let (mut all, mut solved_of_all, mut dearer_of_all, mut compared_of_all) = (Vec::new(), 0, 0, 0);
    for (name, objective, draw) in rows.iter().filter(|(name, of, _)| format!("{name}, {of}").contains(&only))
    {
        let (mut solved, mut dearer, mut compared, mut worst) = (0, 0, 0, 0.0_f64);
        let mut seconds = Vec::new();
        for number in 0..count {
            let Some(problem) = usable(draw, number) else { continue };
            let (cost, took) = planned(&problem, &Settings::default());
            seconds.push(took);
            solved += usize::from(cost.is_ok());
            if let Err(reason) = &cost {
                println!("  {}: no plan in {took:.2} s: {reason}", problem.name);
            } else if took > SLOW {
                println!("  {}: {took:.2} s", problem.name);
            }
            let mut best = f64::INFINITY;
            if number < more {
                let thorough = Settings { search: Thoroughness::Thorough, ..Settings::default() };
                best = planned(&problem, &thorough).0.unwrap_or(best);
            }
            if number < few {
                best = best.min(of_rolls(&problem).unwrap_or(best));
            }
            let Some(cost) = cost.ok().filter(|_| best.is_finite()) else { continue };
            let apart = cost / best - 1.0;
            compared += 1;
            worst = worst.max(apart);
            if apart > NEAR {
                dearer += 1;
                println!("  {}: {cost:.6e} where {best:.6e} exists", problem.name);
            }
        }
        if seconds.is_empty() {
            println!("{name:<38}{objective:<8}{:>9}", "refused");
            continue;
        }
        seconds.sort_by(f64::total_cmp);
        let [median, longest] = [seconds.len() / 2, seconds.len().saturating_sub(1)]
            .map(|place| seconds.get(place).copied().unwrap_or(f64::NAN));
        println!(
            "{name:<38}{objective:<8}{:>9}{median:>10.3}{longest:>10.3}{:>10}{worst:>10.1e}",
            format!("{solved}/{}", seconds.len()),
            format!("{dearer}/{compared}")
        );
        all.extend(seconds);
        solved_of_all += solved;
        dearer_of_all += dearer;
        compared_of_all += compared;
    }
    all.sort_by(f64::total_cmp);
    println!(
        "all: {solved_of_all} of {} solved and verified, median {:.3} s, worst {:.3} s; {dearer_of_all} of \
            {compared_of_all} dearer by more than {:.1} %",
        all.len(),
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN),
        all.last().copied().unwrap_or(f64::NAN),
        100.0 * NEAR
    );
    Ok(())
}
