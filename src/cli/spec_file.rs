//! Reading the spec that a command names.

use super::args::{Notation, Reading};
use super::console::Console;
use super::failure::Failure;
use slewkit::spec::{self, Format, Loaded, Override};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads the spec at `path`, or stdin for `-`, with the overrides, and tells its warnings.
pub fn read(path: &Path, reading: &Reading, console: &mut Console) -> Result<Loaded, Failure> {
    let overrides = reading
        .set
        .iter()
        .map(|text| Override::parse(text).map_err(|reason| Failure::Usage(format!("--set: {reason}"))))
        .collect::<Result<Vec<_>, _>>()?;
    let format = match reading.input {
        Some(Notation::Toml) => Format::Toml,
        Some(Notation::Json) => Format::Json,
        None => Format::of(path),
    };
    let loaded = if is_stdin(path) {
        spec::from_reader(io::stdin().lock(), "stdin", format, &overrides)?
    } else {
        spec::read_as(path, format, &overrides)?
    };
    for warning in &loaded.warnings {
        console.say(&warning.render(console.colour));
    }
    Ok(loaded)
}

/// Opens a plan file, or stdin for `-`.
pub fn open_plan(path: &Path) -> Result<Box<dyn Read>, Failure> {
    if is_stdin(path) {
        return Ok(Box::new(io::stdin().lock()));
    }
    let file = File::open(path).map_err(|error| Failure::unreadable(path, &error))?;
    Ok(Box::new(file))
}

/// Refuses to read two inputs from stdin.
pub fn one_stdin(inputs: &[&Path]) -> Result<(), Failure> {
    match inputs.iter().filter(|path| is_stdin(path)).count() {
        0 | 1 => Ok(()),
        _ => Err(Failure::Usage("only one input can come from stdin".into())),
    }
}

/// Whether `path` stands for stdin.
fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}
