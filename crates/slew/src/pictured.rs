//! The file that is to be looked at, and how.

use super::{Console, Failure, Reading, spec_file};
use clap::builder::PossibleValuesParser;
use slewkit::plan::Plan;
use slewkit_files::batch::Results;
use slewkit_files::export::{EULER_SEQUENCES, ExportError, PlanFile};
use slewkit_files::flown::MarginsRecord;
use slewkit_files::spec::Loaded;
use slewkit_report::Cases;
use std::io::{Cursor, Read};
use std::path::Path;

/// The default sequence of the Euler angles.
pub const EULER: &str = "zyx";

/// The options of pictures.
#[derive(Debug, clap::Args)]
pub struct Drawing {
    /// Sequence of the Euler angles, intrinsic: zyx is R = Rz Ry Rx
    #[arg(long, value_name = "SEQUENCE", default_value = EULER, value_parser = PossibleValuesParser::new(EULER_SEQUENCES), hide_possible_values = true)]
    pub euler: String,
}

/// The contents of a file that slewkit wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A plan, or nothing that is known.
    Plan,
    /// A simulation.
    Simulation,
    /// Results of a batch.
    Results,
    /// A comparison of methods or integrators.
    Comparison,
}

/// The number of bytes that identify a file: its identifying keys come before all lists.
const HEAD: u64 = 4096;

/// Opens the file at `path`, or stdin for `-`, from its beginning, and returns the kind of its
/// contents.
pub fn open(path: &Path) -> Result<(Kind, Box<dyn Read>), Failure> {
    let mut input = spec_file::open_plan(path)?;
    let mut head = Vec::new();
    let read = input.by_ref().take(HEAD).read_to_end(&mut head);
    read.map_err(|error| Failure::unreadable(path, &error))?;
    let text = String::from_utf8_lossy(&head);
    // No text in a JSON file holds a bare quote, so these are keys.
    let kind = if text.starts_with("{\"slew_results\":") {
        Kind::Results
    } else if text.contains("\"compares\":") {
        Kind::Comparison
    } else if text.contains("\"integrator\":") {
        Kind::Simulation
    } else {
        Kind::Plan
    };
    Ok((kind, Box::new(Cursor::new(head).chain(input))))
}

/// Reads the results in the file at `path`, complete or not.
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

/// Returns the spec that the plan file `input`, read from `path`, holds, its maneuver on the grid
/// of the plan, the plan, and what chances took.
pub fn read(
    path: &Path,
    input: impl Read,
    console: &mut Console,
) -> Result<(Loaded, Plan, Option<MarginsRecord>), Failure> {
    let unusable = |error| Failure::unusable(path, &error);
    let file = PlanFile::read(input).map_err(unusable)?;
    let held = file.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let reading = Reading { set: Vec::new(), input: None };
    let mut loaded = spec_file::read_held(held, path, &reading, console)?;
    // A plan that is proved infeasible has no trajectory.
    let has_rows = !file.trajectory.0.time.is_empty();
    if has_rows {
        loaded.problem = file.on_grid(&loaded.problem).map_err(unusable)?;
    }
    let margins = file.uncertainty.as_ref().and_then(|uncertainty| uncertainty.margins.clone());
    Ok((loaded, file.plan().map_err(unusable)?, margins))
}
