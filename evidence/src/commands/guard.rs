//! Compares results, verdicts and times of many searches with the committed table
//! `evidence/guard.toml`, and lists which results are better, worse, new or lost.
//!
//! `cargo run --release -p evidence -- guard [--part PART] [--write] [--within TOLERANCE]` runs a
//! few cases of every count by which searches are judged. Each case is a default plan in its own
//! process; two processes run at a time. PART is a section of the table, or `quick`, which selects
//! some cases of each section and takes at most three minutes of CPU time. `--write` rewrites the
//! table, or only the rows of the part.
//!
//! - `problems`: the shipped maneuvers, including the published ones. `best_known`: the maneuvers
//!   of `evidence/best_known`.
//! - `limited_arcs`, `grids`, `families`, `constrained_robustness`, `images`, `pulses`,
//!   `public_set`: the first cases of these commands, planned as they plan them (`pulses` belong to
//!   `minimum_fuel`, `public_set` to `minimum_time`).
//!
//! Each case is a row of the table, with cost, verdict and CPU time in seconds. A case that exceeds
//! its time budget is stopped: `no answer in 60 s`. An answer is a plan that is solved and
//! verified, or a proof that no plan exists. A case is `new` if it has an answer and the table has
//! none. It is `lost` if it has no answer and the table has one, or if the answer is of another
//! kind. It is `better` or `worse` if it costs less or more by over TOLERANCE (1e-7), relative to
//! the cost. Times depend on the machine and its load. They are reported for each section, and for
//! cases that take more than twice as long and over half a second longer.
//!
//! The command ends with 1 if a case is worse or lost.

use super::{grids, limited_arcs, minimum_fuel, minimum_time};
use evidence::metamorphic::images;
use evidence::process::{Watch, cpu_seconds};
use evidence::words::{Misuse, Words};
use evidence::{ROOT, Random, constrained, families, median, switching};
use slewkit::maneuver::{Problem, Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::spec::read;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, thread};
use toml::de::DeTable;

/// The limit on the CPU time of a case [s].
const BUDGET: f64 = 60.0;

/// The number of cases that are planned at a time.
const WORKERS: usize = 2;

/// A case is reported as slower if its time exceeds this factor times the old time, and also the
/// old time plus this number of seconds.
const LONGER: (f64, f64) = (2.0, 0.5);

/// Cases that are not part of the table: section, beginning of the name, and the reason.
const LEFT_OUT: [(&str, &str, &str); 0] = [];

/// The problem and the settings of a case.
type Case = Result<(Problem, Settings), Box<dyn Error>>;

/// A section of the table.
struct Section {
    name: &'static str,
    /// Every `quick`-th case belongs to the quick part.
    quick: usize,
    names: fn() -> Result<Vec<String>, Box<dyn Error>>,
    case: fn(&[&str]) -> Case,
}

const SECTIONS: [Section; 9] = [
    Section {
        name: "problems",
        quick: 6,
        names: || shipped("problems"),
        case: |name| of_file("problems", name),
    },
    Section {
        name: "best_known",
        quick: 8,
        names: || shipped("evidence/best_known"),
        case: |name| of_file("evidence/best_known", name),
    },
    Section { name: "limited_arcs", quick: 7, names: || Ok(numbers(28)), case: limited_arc },
    Section { name: "grids", quick: 6, names: || Ok(grid_names()), case: grid },
    Section { name: "families", quick: 10, names: || Ok(each(&["F10", "F11", "F12"], 40)), case: family },
    Section { name: "constrained_robustness", quick: 10, names: || Ok(numbers(100)), case: constrained_case },
    Section { name: "images", quick: 15, names: || Ok(image_names()), case: image },
    Section { name: "pulses", quick: 7, names: || Ok(each(&PULSES, 20)), case: pulses },
    Section { name: "public_set", quick: 20, names: || Ok(each(&PUBLIC, 200)), case: public },
];

/// The number of steps of the maneuvers of `grids`.
const GRIDS: [usize; 1] = [100];

/// The number of maneuvers of each kind of `grids`, and of each kind of `images`.
const OF_GRIDS: usize = 3;
const OF_IMAGES: usize = 10;

const PULSES: [&str; 2] = ["box-pulses", "thruster-pulses"];

const PUBLIC: [&str; 3] = ["rest", "moving_ends", "asymmetric"];

fn discrete() -> Settings {
    Settings { target: Target::Discrete, ..Settings::default() }
}

fn numbers(count: usize) -> Vec<String> {
    (0..count).map(|index| index.to_string()).collect()
}

/// Returns the case names: `count` numbered cases for each of `names`.
fn each(names: &[&str], count: usize) -> Vec<String> {
    names.iter().flat_map(|name| (0..count).map(move |index| format!("{name} {index}"))).collect()
}

/// Returns the names of the maneuvers in a folder and its direct subfolders, without simulations.
fn shipped(folder: &str) -> Result<Vec<String>, Box<dyn Error>> {
    let top = Path::new(ROOT).join(folder);
    let mut names = Vec::new();
    for within in ["", "published"] {
        let Ok(entries) = fs::read_dir(top.join(within)) else { continue };
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            let name = path.strip_prefix(&top)?.with_extension("").to_string_lossy().into_owned();
            if path.extension().is_some_and(|end| end == "toml") && read(&path, &[]).is_ok() {
                names.push(name);
            }
        }
    }
    names.sort();
    Ok(names)
}

fn of_file(folder: &str, name: &[&str]) -> Case {
    let path = Path::new(ROOT).join(folder).join(format!("{}.toml", name.join(" ")));
    let loaded = read(&path, &[]).map_err(|error| error.to_string())?;
    let target = if folder == "problems" { loaded.settings.target } else { Target::Discrete };
    Ok((loaded.problem, Settings { target, ..loaded.settings }))
}

/// Returns the name and the number in the words of a case name.
fn numbered<'a>(words: &[&'a str]) -> Result<(&'a str, usize), Box<dyn Error>> {
    let [name, index, ..] = words else { return Err("a name and a number".into()) };
    Ok((name, index.parse()?))
}

fn limited_arc(words: &[&str]) -> Case {
    let seed: usize = words.first().ok_or("a number")?.parse()?;
    let (kind, fuel) = limited_arcs::kind_of(seed, None);
    let problem = limited_arcs::case(seed, kind, fuel).ok_or(NOT_DRAWN)?;
    Ok((problem.with_steps(100), discrete()))
}

fn grid_names() -> Vec<String> {
    let maneuvers = grids::KINDS.map(|(name, ..)| each(&[name], OF_GRIDS)).concat();
    maneuvers.iter().flat_map(|name| GRIDS.map(|steps| format!("{name} on {steps}"))).collect()
}

fn grid(words: &[&str]) -> Case {
    let (name, index) = numbered(words)?;
    let steps: usize = words.last().ok_or("steps")?.parse()?;
    let kind = grids::KINDS.into_iter().find(|(known, ..)| *known == name);
    let (_, limited, fuel) = kind.ok_or("no such kind")?;
    let problem = grids::maneuver(limited, fuel, index).ok_or(NOT_DRAWN)?;
    Ok((problem.with_steps(steps), Settings::default()))
}

fn family(words: &[&str]) -> Case {
    let (name, index) = numbered(words)?;
    let is_it = |family: &families::Family| family.name.split(' ').next() == Some(name);
    let number = families::FAMILIES.iter().position(is_it).ok_or("no such family")?;
    let problem = (families::FAMILIES[number].draw)(&mut families::case(1, number, index));
    Ok((problem.with_steps(100), Settings::discrete()))
}

fn constrained_case(words: &[&str]) -> Case {
    let seed = words.first().ok_or("a number")?.parse()?;
    Ok((constrained::case(seed, None).ok_or(NOT_DRAWN)?, Settings::default()))
}

fn image_names() -> Vec<String> {
    let views = ["itself", "backwards", "x mirrored", "y mirrored", "z mirrored", "axes permuted"];
    let maneuvers = each(&["cones", "cone-fuel"], OF_IMAGES);
    maneuvers.iter().flat_map(|name| views.map(|view| format!("{name} {view}"))).collect()
}

fn image(words: &[&str]) -> Case {
    let (name, index) = numbered(words)?;
    let (_, kind) = switching::KINDS.into_iter().find(|(known, _)| *known == name).ok_or("no such kind")?;
    let problem = switching::maneuver(kind, index as u64).ok_or(NOT_DRAWN)?;
    let view = words[2..].join(" ");
    let problem = match view.as_str() {
        "itself" => problem,
        _ => images(&problem).into_iter().find(|(name, _)| *name == view).ok_or("no such image")?.1,
    };
    Ok((problem, discrete()))
}

fn pulses(words: &[&str]) -> Case {
    let (name, index) = numbered(words)?;
    let family = minimum_fuel::Family::ALL.into_iter().find(|family| family.name() == name);
    let family = family.ok_or("no such family")?;
    let mut random = Random::new(2026);
    let mut drawn = None;
    for turn in 0..=index {
        drawn = minimum_fuel::pulses_case(&mut random, family, turn % 2 == 1)?;
    }
    Ok((drawn.ok_or(NOT_DRAWN)?, Settings::default()))
}

fn public(words: &[&str]) -> Case {
    let (name, index) = numbered(words)?;
    let file = Path::new(ROOT).join("evidence/public_set").join(format!("{name}.csv"));
    let text = fs::read_to_string(file)?;
    let inertia = if name == "asymmetric" { [1.0, 2.0, 3.0] } else { [1.0; 3] };
    let problem = minimum_time::maneuver(text.lines().nth(index + 1).ok_or("no such line")?, inertia)?;
    Ok((problem, Settings::default()))
}

/// The error for a case for which the random law gives no maneuver.
const NOT_DRAWN: &str = "not drawn";

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    /// The cost of a plan that is solved and verified, in the unit of the maneuver's objective,
    /// such as s or N²·m²·s; `None` for other results.
    cost: Option<f64>,
    verdict: String,
    /// The CPU time \[s\], or the elapsed time if the system does not report CPU time.
    seconds: f64,
}

impl Row {
    /// Returns whether the row is a plan that is solved and verified, or a proof that no plan
    /// exists.
    fn is_answer(&self) -> bool {
        self.verdict == Status::Solved.name() || self.verdict == Status::Infeasible.name()
    }
}

/// The rows of the table, by section and name.
type Table = BTreeMap<String, BTreeMap<String, Row>>;

fn table_path() -> PathBuf {
    Path::new(ROOT).join("evidence/guard.toml")
}

/// Reads the committed table; empty if the file does not exist.
fn known() -> Result<Table, Box<dyn Error>> {
    let path = table_path();
    let text = if path.exists() { fs::read_to_string(&path)? } else { String::new() };
    let wrong = |what: String| format!("{}: {what}", path.display());
    let mut table = Table::new();
    let parsed = DeTable::parse(&text).map_err(|error| wrong(error.to_string()))?;
    for (section, rows) in parsed.into_inner() {
        let rows = rows.get_ref().as_table().ok_or_else(|| wrong("a section is a table".into()))?;
        for (name, row) in rows {
            let (row, name) = (row.get_ref(), name.get_ref().to_string());
            let number = |key: &str| row.get(key)?.get_ref().as_float()?.as_str().parse::<f64>().ok();
            let verdict = row.get("verdict").and_then(|verdict| verdict.get_ref().as_str());
            let (Some(verdict), Some(seconds)) = (verdict, number("seconds")) else {
                return Err(wrong(format!("{name}: no verdict, or no seconds")).into());
            };
            let row = Row { cost: number("cost"), verdict: verdict.into(), seconds };
            table.entry(section.get_ref().to_string()).or_default().insert(name, row);
        }
    }
    Ok(table)
}

fn written(table: &Table) -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# Answers, verdicts and times of short counts, with which \
            `cargo run --release -p evidence -- guard` compares.\n\
         # `guard --write` writes this file; `evidence help guard` tells what the rows are.\n",
    );
    for section in SECTIONS {
        let Some(rows) = table.get(section.name) else { continue };
        writeln!(text, "\n[{}]", section.name)?;
        // The names are in the order in which the cases are planned.
        for name in (section.names)()? {
            let Some(Row { cost, verdict, seconds }) = rows.get(&name) else { continue };
            let cost = cost.map_or(String::new(), |cost| format!("cost = {cost:?}, "));
            writeln!(text, "\"{name}\" = {{ {cost}verdict = \"{verdict}\", seconds = {seconds:?} }}")?;
        }
    }
    fs::write(table_path(), text)?;
    Ok(())
}

/// Plans a case in this process, and prints its row.
fn one(section: &str, name: &str) -> Result<(), Box<dyn Error>> {
    let section = SECTIONS.into_iter().find(|known| known.name == section).ok_or("no such section")?;
    let case = (section.case)(&name.split(' ').collect::<Vec<_>>());
    let (problem, settings) = match case {
        Ok(case) => case,
        Err(error) if error.to_string() == NOT_DRAWN => {
            println!("{NOT_DRAWN}");
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    let watch = Watch::start();
    let found = plan(&problem, &settings, None, &mut Silent)?;
    let seconds = watch.seconds();
    println!("{};{:?};{seconds}", found.status.name(), found.solution.cost);
    Ok(())
}

/// Plans a case in its own process and returns its row.
fn row(section: &str, name: &str) -> Result<Row, Box<dyn Error>> {
    let mut command = Command::new(env::current_exe()?);
    // Each process uses one thread, because another process runs at the same time.
    command.args(["guard", "--case", section, name]).env("RAYON_NUM_THREADS", "1");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let (clock, id) = (Instant::now(), child.id().to_string());
    let without = |verdict: String, seconds: f64| Row { cost: None, verdict, seconds };
    let mut pause = Duration::from_millis(1);
    loop {
        if child.try_wait()?.is_some() {
            break;
        }
        let used = cpu_seconds(&id).unwrap_or_else(|| clock.elapsed().as_secs_f64());
        if used > BUDGET {
            child.kill()?;
            child.wait()?;
            return Ok(without(format!("no answer in {BUDGET} s"), BUDGET));
        }
        thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(50));
    }
    let output = child.wait_with_output()?;
    let told = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Ok(without("an error, or a panic".into(), 0.0));
    }
    let cells: Vec<&str> = told.trim().split(';').collect();
    let [verdict, cost, seconds] = cells[..] else { return Ok(without(told.trim().into(), 0.0)) };
    let cost = (verdict == Status::Solved.name()).then(|| cost.parse()).transpose()?;
    // Times are rounded to milliseconds; shorter times to three digits.
    let seconds: f64 = seconds.parse()?;
    let seconds = format!("{seconds:.*}", if seconds < 0.1 { 5 } else { 3 }).parse()?;
    Ok(Row { cost, verdict: verdict.into(), seconds })
}

/// The change of a row relative to the table.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    Better,
    Worse,
    New,
    Lost,
}

/// Compares a case with its row in the table; `None` if nothing changed.
fn change(before: &Row, now: &Row, within: f64) -> Option<Change> {
    if !before.is_answer() {
        return now.is_answer().then_some(Change::New);
    }
    if now.verdict != before.verdict {
        return Some(Change::Lost);
    }
    let (before, now) = before.cost.zip(now.cost)?;
    let apart = now - before;
    // The comparison is written so that a NaN counts as worse.
    if apart.abs() <= within * before.abs() {
        None
    } else if apart < 0.0 {
        Some(Change::Better)
    } else {
        Some(Change::Worse)
    }
}

fn told(row: &Row) -> String {
    match row.cost {
        Some(cost) => format!("{cost:.10} in {} s", row.seconds),
        None => row.verdict.clone(),
    }
}

/// Plans all cases, several at a time, and prints the progress occasionally.
fn planned(cases: &[(&'static str, String)]) -> Result<Vec<Row>, Box<dyn Error>> {
    let (next, rows) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some((section, name)) = cases.get(index) else { break };
                    let row = row(section, name).map_err(|error| format!("{section}, {name}: {error}"));
                    let Ok(mut rows) = rows.lock() else { break };
                    rows.push((index, row));
                    if rows.len().is_multiple_of(50) {
                        eprintln!("{} of {}", rows.len(), cases.len());
                    }
                }
            });
        }
    });
    let mut rows = rows.into_inner()?;
    rows.sort_by_key(|(index, _)| *index);
    Ok(rows.into_iter().map(|(_, row)| row).collect::<Result<_, _>>()?)
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let parts: Vec<_> = ["quick"].into_iter().chain(SECTIONS.map(|section| section.name)).collect();
    let (mut part, mut writes, mut within) = (None, false, 1e-7);
    while let Some(word) = words.take() {
        match word.as_str() {
            "--part" => part = Some(words.required_one_of("part", &parts)?),
            "--write" => writes = true,
            "--within" => within = words.required::<f64>("tolerance")?,
            "--case" => {
                let (section, name) = (words.word("section")?, words.word("name")?);
                words.end()?;
                return one(&section, &name);
            }
            _ => return Err(Misuse::of("option", &word, &["--part", "--write", "--within"]).into()),
        }
    }
    if within.is_nan() || within < 0.0 {
        return Err(Misuse::new(format!("{within} is no tolerance")).into());
    }
    let mut table = known()?;
    let mut cases = Vec::new();
    for section in SECTIONS {
        let quick = part.as_deref() == Some("quick");
        if !quick && part.as_ref().is_some_and(|part| part != section.name) {
            continue;
        }
        let is_in = |name: &str| {
            !LEFT_OUT.iter().any(|(of, start, _)| *of == section.name && name.starts_with(start))
        };
        let names = (section.names)()?.into_iter().filter(|name| is_in(name));
        let every = if quick { section.quick } else { 1 };
        cases.extend(names.step_by(every).map(|name| (section.name, name)));
    }
    let rows = planned(&cases)?;
    let mut counts = [0; 4];
    for (change, word) in
        [(Change::Better, "better"), (Change::Worse, "worse"), (Change::New, "new"), (Change::Lost, "lost")]
    {
        for ((section, name), row) in cases.iter().zip(&rows) {
            let Some(before) = table.get(*section).and_then(|rows| rows.get(name)) else { continue };
            if self::change(before, row, within) == Some(change) {
                counts[change as usize] += 1;
                println!("{word:<7}{section}, {name}: {}; was {}", told(row), told(before));
            }
        }
    }
    let mut gone = 0;
    if part.as_deref() != Some("quick") {
        for (section, name) in missing(&table, &cases) {
            println!("lost   {section}, {name}: no such case any more");
            gone += 1;
        }
    }
    times(&table, &cases, &rows);
    LEFT_OUT.iter().for_each(|(section, name, reason)| println!("left out: {section}, {name}: {reason}"));
    let of_table =
        |(section, name): &&(&str, String)| table.get(*section).is_some_and(|rows| rows.contains_key(name));
    let added = cases.len() - cases.iter().filter(of_table).count();
    let [better, worse, new, lost] = counts;
    let answers = rows.iter().filter(|row| row.is_answer()).count();
    println!(
        "{answers} answers of {} cases; {better} better, {worse} worse, {new} new, {} lost; {added} in no table yet",
        rows.len(),
        lost + gone
    );
    if writes {
        let whole: Vec<_> =
            if part.is_none() { table.keys().cloned().collect() } else { part.into_iter().collect() };
        whole.iter().for_each(|section| {
            table.remove(section);
        });
        for ((section, name), row) in cases.into_iter().zip(rows) {
            table.entry(section.into()).or_default().insert(name, row);
        }
        return written(&table);
    }
    if worse + lost + gone > 0 { Err("see above".into()) } else { Ok(()) }
}

/// Returns the rows of the planned sections in the table that no longer belong to a case.
fn missing(table: &Table, cases: &[(&'static str, String)]) -> Vec<(String, String)> {
    let mut missing = Vec::new();
    for (section, rows) in table {
        let of = || cases.iter().filter(|(name, _)| name == section);
        let gone = rows.keys().filter(|name| of().all(|(_, planned)| planned != *name));
        missing.extend(gone.filter(|_| of().next().is_some()).map(|name| (section.clone(), name.clone())));
    }
    missing
}

/// Prints the time of each section next to the time in the table, and the cases that take much
/// longer.
fn times(table: &Table, cases: &[(&'static str, String)], rows: &[Row]) {
    println!("{:<24}{:>7}{:>9}{:>9}{:>9}{:>9}", "seconds", "cases", "all", "was", "median", "was");
    for section in SECTIONS {
        let pairs = cases.iter().zip(rows).filter(|((name, _), _)| *name == section.name);
        let before =
            |name: &str| table.get(section.name).and_then(|rows| rows.get(name)).map(|row| row.seconds);
        let (mut now, mut was): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for ((_, name), row) in pairs {
            now.push(row.seconds);
            was.extend(before(name));
            let (times, more) = LONGER;
            if let Some(before) =
                before(name).filter(|before| row.seconds > (times * before).max(before + more))
            {
                println!("  longer: {}, {name}: {} s; was {before} s", section.name, row.seconds);
            }
        }
        if !now.is_empty() {
            let sums = [&now, &was].map(|seconds| seconds.iter().fold(0.0, |sum, one| sum + one));
            let (count, middles) = (now.len(), [median(&mut now), median(&mut was)]);
            println!(
                "{:<24}{count:>7}{:>9.2}{:>9.2}{:>9.3}{:>9.3}",
                section.name, sums[0], sums[1], middles[0], middles[1]
            );
        }
    }
}
