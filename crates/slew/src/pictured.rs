//! Reading the file that a report or a picture shows, and finding out its kind.

use super::{Console, Exit, Failure, Reading, spec_file};
use clap::builder::PossibleValuesParser;
use slewkit::plan::{Plan, Status};
use slewkit_files::batch::Results;
use slewkit_files::export::{EULER_SEQUENCES, ExportError, PlanFile, SequenceFile};
use slewkit_files::flown::MarginsRecord;
use slewkit_files::spec::{Loaded, LoadedSequence, escape};
use slewkit_report::Cases;
use std::io::{Cursor, Read};
use std::path::Path;

/// The default sequence of the Euler angles.
pub const EULER: &str = "zyx";

/// The options of pictures.
#[derive(Debug, clap::Args)]
pub struct Drawing {
    /// Sequence of the Euler angles, intrinsic: zyx is R = Rz Ry Rx
    #[arg(
        long,
        value_name = "SEQUENCE",
        default_value = EULER,
        value_parser = PossibleValuesParser::new(EULER_SEQUENCES),
        hide_possible_values = true,
    )]
    pub euler: String,
}

/// The contents of a file that slewkit wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A plan of one maneuver, or a file of unknown kind.
    Plan,
    /// The plan of a sequence.
    Sequence,
    /// A simulation.
    Simulation,
    /// Results of a batch.
    Results,
    /// A comparison of methods or integrators.
    Comparison,
}

/// The number of bytes that are read to identify a file. The identifying keys come before all
/// lists.
const HEAD: u64 = 4096;

/// Opens the file at `path`, or stdin for `-`, from its beginning, and returns the kind of its
/// contents.
pub fn open(path: &Path) -> Result<(Kind, Box<dyn Read>), Failure> {
    let mut input = spec_file::open_plan(path)?;
    let mut head = Vec::new();
    let read = input.by_ref().take(HEAD).read_to_end(&mut head);
    read.map_err(|error| Failure::unreadable(path, &error))?;
    let text = String::from_utf8_lossy(&head);
    // Within JSON strings quotes are escaped, so these matches are keys.
    let kind = if text.starts_with("{\"slew_results\":") {
        Kind::Results
    } else if SequenceFile::begins(text.as_bytes()) {
        Kind::Sequence
    } else if text.contains("\"compares\":") {
        Kind::Comparison
    } else if text.contains("\"integrator\":") {
        Kind::Simulation
    } else {
        Kind::Plan
    };
    Ok((kind, Box::new(Cursor::new(head).chain(input))))
}

/// Reads the results of a batch from the file at `path`, which may be incomplete.
pub fn results(path: &Path) -> Result<Cases, Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::Usage("results are read from a file, not from stdin".into()));
    }
    let mut results = Results::open(path)?;
    let mut cases = Cases::new(results.header());
    while let Some((result, _)) = results.next_result()? {
        cases.add(&result);
    }
    Ok(cases)
}

/// A plan that was read from its file and judged by the witnesses.
pub struct Pictured {
    /// The spec that the file contains, with its maneuver on the grid of the plan.
    pub loaded: Loaded,
    pub plan: Plan,
    /// The margins that the plan holds for its chance constraints.
    pub margins: Option<MarginsRecord>,
    /// The exit code: solved, or verification failed if the witnesses refute the file.
    pub exit: Exit,
}

/// Reads the plan file `input` from `path` and lets the witnesses judge its claims.
pub fn read(path: &Path, input: impl Read, console: &mut Console) -> Result<Pictured, Failure> {
    let unusable = |error| Failure::unusable(path, &error);
    let file = PlanFile::read(input).map_err(unusable)?;
    let held = file.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let reading = Reading { set: Vec::new(), input: None };
    let mut loaded = spec_file::read_held(held, path, &reading, console)?;
    let (file, exit) = settled(file, &loaded, path, console);
    // A plan that is proved infeasible has no trajectory.
    let has_rows = !file.trajectory.0.time.is_empty();
    if has_rows {
        loaded.problem = file.on_grid(&loaded.problem).map_err(unusable)?;
    }
    let margins = file.uncertainty.as_ref().and_then(|uncertainty| uncertainty.margins.clone());
    Ok(Pictured { loaded, plan: file.plan().map_err(unusable)?, margins, exit })
}

/// Reads the plan of a sequence from `path` and lets the witnesses judge its claims.
pub fn sequence(
    path: &Path,
    input: impl Read,
    reading: &Reading,
    console: &mut Console,
) -> Result<(SequenceFile<'static>, LoadedSequence, Exit), Failure> {
    let unusable = |error| Failure::unusable(path, &error);
    let mut file = SequenceFile::read(input).map_err(unusable)?;
    let held = file.record.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let loaded = spec_file::read_held_sequence(held, path, reading, console)?;
    if file.record.status != Status::Solved {
        return Ok((file, loaded, Exit::Solved));
    }
    let judged = file.judge(&loaded, &|| false).map_err(unusable)?;
    if judged.passed() {
        return Ok((file, loaded, Exit::Solved));
    }
    file.record.status = Status::VerificationFailed;
    let path = escape(&path.to_string_lossy());
    let reason = format!("{path} states that the plan is solved, but the witnesses reject it");
    console.error("E0153", &reason, "`slew verify` reports what fails; plan the spec again");
    Ok((file, loaded, Exit::Plan(Status::VerificationFailed)))
}

/// Returns the plan file of `path` with the verdict of the witnesses. If they refute the claims of
/// the file, the returned file states this.
pub fn settled<'a>(
    file: PlanFile<'a>,
    loaded: &Loaded,
    path: &Path,
    console: &mut Console,
) -> (PlanFile<'a>, Exit) {
    let (file, refused) = file.settled(loaded);
    let Some(why) = refused else { return (file, Exit::Solved) };
    let path = escape(&path.to_string_lossy());
    let reason =
        format!("{path} states that the plan is solved, but the witnesses reject it: {}", escape(&why));
    console.error("E0153", &reason, "`slew verify` reports what fails; plan the spec again");
    (file, Exit::Plan(Status::VerificationFailed))
}
