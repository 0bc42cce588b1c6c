//! Reading of a file for a report or a picture, including the recognition of its kind.

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

/// Default sequence of the Euler angles in charts.
pub const EULER: &str = "zyx";

/// Options of commands that draw pictures.
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

/// Kind of the contents of a file that slewkit wrote.
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

/// Number of bytes that are read to recognise the kind of a file. The identifying keys precede all
/// long lists.
const HEAD: u64 = 4096;

/// Opens the file at `path`, or stdin for `-`. Returns the kind of its contents and a reader that
/// begins at the start of the file.
pub fn open(path: &Path) -> Result<(Kind, Box<dyn Read>), Failure> {
    let mut input = spec_file::open_plan(path)?;
    let mut head = Vec::new();
    let read = input.by_ref().take(HEAD).read_to_end(&mut head);
    read.map_err(|error| Failure::unreadable(path, &error))?;
    let text = String::from_utf8_lossy(&head);
    // Quotes within JSON strings are escaped, so the texts found are keys.
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

/// Reads the results of a batch from the file at `path`, which may be an incomplete file.
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

/// A plan that was read from its file and verified by the witnesses.
pub struct Pictured {
    /// Spec in the file, with its maneuver on the grid of the plan.
    pub loaded: Loaded,
    pub plan: Plan,
    /// Margins that the plan keeps for its chance constraints; `None` if it has none.
    pub margins: Option<MarginsRecord>,
    /// Exit code: solved, or verification failed if the witnesses refute the plan.
    pub exit: Exit,
}

/// Reads the plan file `input`, whose path is `path`, and verifies it with the witnesses.
pub fn read(path: &Path, input: impl Read, console: &mut Console) -> Result<Pictured, Failure> {
    let unusable = |error| Failure::unusable(path, &error);
    let file = PlanFile::read(input).map_err(unusable)?;
    let held = file.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let reading = Reading { set: Vec::new(), input: None };
    let mut loaded = spec_file::read_held(held, path, &reading, console)?;
    let (file, exit) = settled(file, &loaded, path, console);
    // A plan file without a trajectory states that the maneuver is infeasible.
    let has_rows = !file.trajectory.0.time.is_empty();
    if has_rows {
        loaded.problem = file.on_grid(&loaded.problem).map_err(unusable)?;
    }
    let margins = file.uncertainty.as_ref().and_then(|uncertainty| uncertainty.margins.clone());
    Ok(Pictured { loaded, plan: file.plan().map_err(unusable)?, margins, exit })
}

/// Reads the plan of a sequence, whose path is `path`, and verifies it with the witnesses.
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

/// Returns the plan file with the verdict of the witnesses. If they refute the status in the file,
/// the status of the returned file states this, and an error is printed.
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
