//! What an everyday maneuver is: the spec of one, for other programs; `evidence::everyday` has their law.
//!
//! `cargo run -p evidence -- everyday KIND NUMBER [SEED]`: the maneuver of that number (from 0) among those of a kind (`time`,
//! `rate`, `cone`, `effort`) and a seed (1), as a spec in JSON. `cargo bench -p benches --bench everyday` plans them, and
//! `tests/exchange/everyday.py` compares the plans with those of CasADi and IPOPT.

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
