//! Writes the page of the figures, `docs/figures.md`, from `evidence/figures.toml`.
//!
//! `cargo run --release -p evidence -- figures` writes the page. The data have one table for each
//! figure: its name, the law by which it is counted or measured in one sentence, the command that
//! prints it, the value, its unit, and the date. A row of the page has at most 300 characters.
//!
//! `cargo run --release -p evidence -- figures --check` writes nothing and ends with 1 if the page
//! is not the one that is made from the data.

use evidence::figures::{data, made, page};
use evidence::words::Words;
use std::error::Error;
use std::fs;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let check = words.next_is("--check");
    words.end()?;
    let made = made(&fs::read_to_string(data())?)?;
    if !check {
        return Ok(fs::write(page(), made)?);
    }
    if fs::read_to_string(page())? != made {
        return Err(
            "docs/figures.md is not made from evidence/figures.toml: run this command without --check".into(),
        );
    }
    Ok(())
}
