//! Compares costs of minimum-time and minimum-fuel plans before and after a change of the search,
//! plan by plan.
//!
//! Use this command to measure changes of the search's constants.
//!
//! `cargo run --release -p evidence -- dearer COUNT FILE [KIND ...]` plans COUNT maneuvers of each
//! kind without cones, or of the named kinds, by the laws of `evidence::switching`. If FILE does
//! not exist, the command stores the costs there. Otherwise it compares each plan with the stored
//! one. It prints how many plans cost more or less by over 1e-5 and the reported gaps, the worst of
//! them, how many are no longer or newly solved, the gaps above 1e-4 of the cost, and the ratio of
//! the times.
//!
//! `… -- dearer thorough COUNT FILE [KIND ...]` uses the thorough search. A later comparison with
//! FILE then shows which plans the default search misses.
//!
//! `cargo run --release -p evidence -- dearer spec KIND INDEX` writes one of the maneuvers as
//! a spec in JSON.

use evidence::median;
use evidence::switching::{KINDS, Kind, cost_and_gap, maneuver};
use evidence::words::{Misuse, Words};
use slewkit::maneuver::{Settings, Target, Thoroughness};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::spec::SpecDocument;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::time::Instant;

/// The relative difference below which two costs count as equal, and the relative gap above which a
/// gap counts as large.
const SAME: f64 = 1e-5;
const LARGE: f64 = 1e-4;

/// The result of a search: the cost and the relative gap of the plan, both infinite without a plan,
/// and the computing time \[ms\].
#[derive(Clone, Copy)]
struct Found {
    cost: f64,
    gap: f64,
    milliseconds: f64,
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let kinds = KINDS.map(|(name, _)| name);
    if words.next_is("spec") {
        let name = words.required_one_of("kind", &kinds)?;
        let index = words.required("number of a maneuver")?;
        words.end()?;
        let (_, kind) = KINDS.into_iter().find(|(known, _)| *known == name).ok_or("no such kind")?;
        let problem = maneuver(kind, index).ok_or("no such maneuver")?;
        println!("{}", serde_json::to_string(&SpecDocument::new(&problem, &Settings::default())?)?);
        return Ok(());
    }
    let thorough = words.next_is("thorough");
    let count: u64 = words.required("number of maneuvers")?;
    let file = words.word("file")?;
    let asked = words.rest();
    if let Some(unknown) = asked.iter().find(|asked| !kinds.contains(&asked.as_str())) {
        return Err(Misuse::of("kind", unknown, &kinds).into());
    }
    let search = if thorough { Thoroughness::Thorough } else { Thoroughness::Default };
    let kept = fs::read_to_string(&file).ok().map(|text| read(&text)).transpose()?;
    let mut written = String::new();
    for (name, kind) in KINDS {
        let is_asked = asked.iter().any(|asked| asked == name);
        if !(is_asked || asked.is_empty() && !matches!(kind, Kind::Cones | Kind::ConeFuel)) {
            continue;
        }
        let mut pairs = Vec::new();
        for index in 0..count {
            let Some(found) = found(kind, index, search) else { continue };
            writeln!(written, "{name} {index} {} {} {}", found.cost, found.gap, found.milliseconds)?;
            let before = kept.as_ref().and_then(|kept| kept.get(&(name.to_string(), index)));
            pairs.push((index, *before.unwrap_or(&found), found));
        }
        tell(name, &pairs);
    }
    if kept.is_none() {
        fs::write(file, written)?;
    }
    Ok(())
}

fn found(kind: Kind, index: u64, search: Thoroughness) -> Option<Found> {
    let problem = maneuver(kind, index)?;
    let settings = Settings { target: Target::Discrete, search, ..Settings::default() };
    let began = Instant::now();
    let planned = plan(&problem, &settings, None, &mut Silent).ok();
    let milliseconds = 1e3 * began.elapsed().as_secs_f64();
    let solved = planned.filter(|plan| plan.status == Status::Solved);
    let (cost, gap) = solved.as_ref().map_or((f64::INFINITY, f64::INFINITY), cost_and_gap);
    Some(Found { cost, gap, milliseconds })
}

fn read(text: &str) -> Result<BTreeMap<(String, u64), Found>, Box<dyn Error>> {
    let line = |line: &str| {
        let [name, index, cost, gap, milliseconds] = line.split(' ').collect::<Vec<_>>()[..] else {
            return Err(format!("not a plan: {line}").into());
        };
        let found = Found { cost: cost.parse()?, gap: gap.parse()?, milliseconds: milliseconds.parse()? };
        Ok(((name.to_string(), index.parse()?), found))
    };
    text.lines().map(line).collect()
}

fn tell(name: &str, pairs: &[(u64, Found, Found)]) {
    let (mut dearer, mut cheaper, mut lost, mut gained, mut large) = (vec![], vec![], vec![], 0, [0, 0]);
    for (index, before, after) in pairs {
        large[0] += usize::from(before.gap > LARGE);
        large[1] += usize::from(after.gap > LARGE);
        match (before.cost.is_finite(), after.cost.is_finite()) {
            (true, false) => lost.push(*index),
            (false, true) => gained += 1,
            (false, false) => {}
            (true, true) => {
                let change = after.cost / before.cost - 1.0;
                if change.abs() > SAME.max(before.gap).max(after.gap) {
                    if change > 0.0 { dearer.push((*index, change)) } else { cheaper.push((*index, change)) }
                }
            }
        }
    }
    let worst = |all: &[(u64, f64)]| {
        let worst = all.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        worst.map_or(String::new(), |(index, change)| {
            format!(" (at most {:.3} %, {index})", 100.0 * change.abs())
        })
    };
    let solved = pairs.iter().filter(|(.., after)| after.cost.is_finite()).count();
    let times = |of: fn(&(u64, Found, Found)) -> f64| pairs.iter().map(of).collect::<Vec<f64>>();
    let [mut before, mut after] = [times(|pair| pair.1.milliseconds), times(|pair| pair.2.milliseconds)];
    let over = after.iter().sum::<f64>() / before.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    println!(
        "{name:<14} {:>4}, solved {solved}: dearer {}{}, cheaper {}{}, lost {lost:?}, gained {gained}, gaps \
            {} then {}; \
         median {:.1} then {:.1} ms, all {over:.2} times",
        pairs.len(),
        dearer.len(),
        worst(&dearer),
        cheaper.len(),
        worst(&cheaper),
        large[0],
        large[1],
        median(&mut before),
        median(&mut after),
    );
}
