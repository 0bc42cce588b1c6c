//! Reading of the spec or plan file that a command line names.

use super::{Console, Failure, Message, Notation, Reading};
use slewkit_files::export::{PlanFile, SequenceFile};
use slewkit_files::spec::{self, Diagnostic, Format, Loaded, LoadedSequence, Override, Spec, SpecDocument};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Reads the maneuver at `path`, or from stdin for `-`, applies the overrides, and prints the
/// warnings.
pub fn read(path: &Path, reading: &Reading, console: &mut Console) -> Result<Loaded, Failure> {
    let (overrides, format) = arguments(path, reading)?;
    let loaded = if is_stdin(path) {
        spec::from_reader(io::stdin().lock(), "stdin", format, &overrides)?
    } else {
        spec::read_as(path, format, &overrides)?
    };
    tell(&loaded.warnings, console);
    Ok(loaded)
}

/// Reads the maneuver or the sequence at `path`, or from stdin for `-`, applies the overrides, and
/// prints the warnings.
pub fn read_planned(path: &Path, reading: &Reading, console: &mut Console) -> Result<Spec, Failure> {
    let (overrides, format) = arguments(path, reading)?;
    let spec = if is_stdin(path) {
        spec::planned_from_reader(io::stdin().lock(), "stdin", format, &overrides)?
    } else {
        spec::read_planned(path, format, &overrides)?
    };
    tell(spec.warnings(), console);
    Ok(spec)
}

/// Reads a spec of any kind at `path`, or from stdin for `-`, applies the overrides, and prints the
/// warnings.
pub fn load(path: &Path, reading: &Reading, console: &mut Console) -> Result<Spec, Failure> {
    let (overrides, format) = arguments(path, reading)?;
    let spec = if is_stdin(path) {
        spec::load_from_reader(io::stdin().lock(), "stdin", format, &overrides)?
    } else {
        spec::load(path, format, &overrides)?
    };
    tell(spec.warnings(), console);
    Ok(spec)
}

/// Reads the spec in the plan file `plan`, applies the overrides, and prints the warnings.
pub fn read_held(
    held: &SpecDocument,
    plan: &Path,
    reading: &Reading,
    console: &mut Console,
) -> Result<Loaded, Failure> {
    let (overrides, _) = arguments(plan, reading)?;
    let loaded = held.read(&format!("{}, spec", plan.display()), &overrides)?;
    tell(&loaded.warnings, console);
    Ok(loaded)
}

/// Creates the failure of a command that supports single maneuvers only but was given a sequence.
pub fn refuse_stops() -> Failure {
    let reason = "the spec has stops, and this command supports only a single maneuver";
    Failure::Problem(Message::new("E0018", reason, "run `slew plan` on it; or remove the stops"))
}

/// Reads the spec in the plan file of a sequence, applies the overrides, and prints the warnings.
pub fn read_held_sequence(
    held: &SpecDocument,
    plan: &Path,
    reading: &Reading,
    console: &mut Console,
) -> Result<LoadedSequence, Failure> {
    let (overrides, _) = arguments(plan, reading)?;
    let loaded = held.read_sequence(&format!("{}, spec", plan.display()), &overrides)?;
    let Some(loaded) = loaded else { return Err(without_stops()) };
    tell(&loaded.warnings, console);
    Ok(loaded)
}

/// Creates the failure that the spec of a sequence has no stops.
pub fn without_stops() -> Failure {
    let reason = "the plan file holds a sequence, and the spec has no stops";
    Failure::Problem(Message::new("E0018", reason, "give the spec of the sequence, with [[stop]]"))
}

fn tell(warnings: &[Diagnostic], console: &mut Console) {
    for warning in warnings {
        console.say(&warning.render(console.colour));
    }
}

/// Returns the overrides on the command line, and the format of the spec.
pub fn arguments(path: &Path, reading: &Reading) -> Result<(Vec<Override>, Format), Failure> {
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
    Ok((overrides, format))
}

/// Opens a plan file, or stdin for `-`.
pub fn open_plan(path: &Path) -> Result<Box<dyn Read>, Failure> {
    if is_stdin(path) {
        return Ok(Box::new(io::stdin().lock()));
    }
    let file = File::open(path).map_err(|error| Failure::unreadable(path, &error))?;
    Ok(Box::new(file))
}

/// An open plan file, or an open attitude file of any program. The beginning of the file shows
/// which of them it is.
pub enum PlanOrAttitudes {
    /// A plan file.
    Plan(Box<dyn Read>),
    /// The plan of a sequence.
    Sequence(Box<dyn Read>),
    /// An AEM or a table of attitudes.
    Attitudes(Box<dyn Read>),
}

/// Opens a plan file or an attitude file, or stdin for `-`.
pub fn open_plan_or_attitudes(path: &Path) -> Result<PlanOrAttitudes, Failure> {
    let mut input = BufReader::new(open_plan(path)?);
    let start = input.fill_buf().map_err(|error| Failure::unreadable(path, &error))?;
    let (is_plan, is_sequence) = (PlanFile::begins(start), SequenceFile::begins(start));
    let input = Box::new(input);
    Ok(if is_sequence {
        PlanOrAttitudes::Sequence(input)
    } else if is_plan {
        PlanOrAttitudes::Plan(input)
    } else {
        PlanOrAttitudes::Attitudes(input)
    })
}

/// Returns an error if more than one of the inputs is stdin.
pub fn one_stdin(inputs: &[&Path]) -> Result<(), Failure> {
    match inputs.iter().filter(|path| is_stdin(path)).count() {
        0 | 1 => Ok(()),
        _ => Err(Failure::Usage("only one input can come from stdin".into())),
    }
}

/// Returns whether `path` means stdin.
fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}
