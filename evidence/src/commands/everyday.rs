//! The spec of an everyday maneuver, for other programs, by the law of `evidence::everyday`.
//!
//! `cargo run -p evidence -- everyday KIND NUMBER [SEED]` prints the maneuver of a number (from 0),
//! a kind (`time`, `rate`, `cone`, `effort`) and a seed (1) as a spec in JSON.
//! `cargo bench -p benches --bench everyday` plans these maneuvers, and
//! `tests/exchange/everyday.py` compares the plans with the results of CasADi and IPOPT.

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
