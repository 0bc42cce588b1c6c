//! Writes the page of the claims, `docs/validation.md`, from `evidence/validation.toml`.
//!
//! `cargo run --release -p evidence -- validation` writes the page. The data have one table for
//! each claim: the claim in one sentence, the reference of the comparison, and either the test that
//! checks it with the bound that the test requires, or the name of a figure of
//! `evidence/figures.toml`. A test, a bound or a figure that does not exist is an error.
//!
//! `cargo run --release -p evidence -- validation --check` writes nothing and ends with 1 if the
//! page is not the one that is made from the data.

use evidence::validation::{data, made, page};
use evidence::words::Words;
use std::error::Error;
use std::fs;

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let check = words.next_is("--check");
    words.end()?;
    let read = |path| fs::read_to_string(path);
    let made = made(&read(data())?, &read(evidence::figures::data())?)?;
    if !check {
        return Ok(fs::write(page(), made)?);
    }
    if read(page())? != made {
        let text = "docs/validation.md is not made from evidence/validation.toml: run this command without \
                    --check";
        return Err(text.into());
    }
    Ok(())
}
