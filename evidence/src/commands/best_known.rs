//! Plans maneuvers for which a search once missed the best plan, and compares each cost with the
//! best known cost, on grids of several sizes.
//!
//! `cargo run --release -p evidence -- best_known [WORD [STEPS …]]` plans the maneuvers whose file
//! name contains WORD (all maneuvers by default), on the steps of their spec and on the given
//! numbers of STEPS. The first line of each file of `evidence/best_known` states the best known
//! cost and its source: a closed form, a published value, another program, or a symmetric maneuver.
//!
//! Each printed line has the cost of the discrete optimum and its excess over the known cost. The
//! command ends with 1 if an excess is more than 0.1 %, or if a maneuver has no plan.

use evidence::words::{Misuse, Words};
use slewkit::maneuver::{Settings, Target};
use slewkit::plan::{Silent, Status, plan};
use slewkit_files::spec::{Format, from_str};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// The largest accepted excess over the best known cost, relative to it.
const NEAR: f64 = 1e-3;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let word = words.take().unwrap_or_default();
    let grids: Vec<usize> = words.numbers("number of steps")?;
    let mut files: Vec<_> = fs::read_dir(Path::new(evidence::ROOT).join("evidence/best_known"))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    files.sort();
    let names: Vec<_> = files.iter().filter_map(|path| path.file_stem()?.to_str()).collect();
    if !names.iter().any(|name| name.contains(&word)) {
        return Err(Misuse::of("part of the name of a maneuver", &word, &names).into());
    }
    let (mut count, mut missed) = (0, 0);
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !name.contains(&word) {
            continue;
        }
        let text = fs::read_to_string(&path)?;
        let told = text.split(&[' ', '\n'][..]).nth(3).ok_or("no best known cost")?;
        let best: f64 = told.parse()?;
        let loaded = from_str(&text, &name, Format::Toml, &[]).map_err(|error| format!("{name}: {error}"))?;
        let own = loaded.problem.steps;
        for steps in std::iter::once(own).chain(grids.iter().copied()) {
            let settings = Settings { target: Target::Discrete, ..loaded.settings.clone() };
            let began = Instant::now();
            let found = plan(&loaded.problem.clone().with_steps(steps), &settings, None, &mut Silent)?;
            let seconds = began.elapsed().as_secs_f64();
            let solved = found.status == Status::Solved;
            let apart = found.solution.cost / best - 1.0;
            let good = solved && apart <= NEAR;
            count += 1;
            missed += usize::from(!good);
            let cost = if solved {
                format!("{:.6} ({:+.3} %)", found.solution.cost, 100.0 * apart)
            } else {
                found.status.name().into()
            };
            let mark = if good { "" } else { "  <-" };
            println!("{name:<30} {steps:>6} steps  {cost:<24} best known {best}  {seconds:.2} s{mark}");
        }
    }
    println!("{} of {count} as cheap as the best known", count - missed);
    if missed > 0 { Err("see above".into()) } else { Ok(()) }
}
