//! Prints the spec of an everyday maneuver for other programs, by the law of `evidence::everyday`.
//!
//! `cargo run -p evidence -- everyday KIND NUMBER [SEED]` prints a maneuver as a spec in JSON. KIND
//! is `time`, `rate`, `cone` or `effort`; NUMBER counts from 0; SEED is 1 by default. `cargo bench
//! -p benches --bench everyday` plans these maneuvers, and `tests/exchange/everyday.py` compares
//! the plans with the results of CasADi and IPOPT.

use evidence::everyday::{KINDS, maneuver};
use evidence::words::Words;
use slewkit::maneuver::Settings;
use slewkit_files::spec::SpecDocument;
use std::error::Error;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let name = words.required_one_of("kind", &KINDS.map(|(name, _)| name))?;
    let number = words.required("number of a maneuver")?;
    let seed = words.number("seed", 1)?;
    words.end()?;
    let (_, kind) = KINDS.into_iter().find(|(known, _)| *known == name).ok_or("no such kind")?;
    let document = SpecDocument::new(&maneuver(kind, seed, number), &Settings::default())?;
    println!("{}", serde_json::to_string(&document)?);
    Ok(())
}
