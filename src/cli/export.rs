//! `slew export`: a plan file in the formats of other programs.

use super::{Console, Destination, Exit, Failure, Format, OutputArgs, Reading, spec_file};
use clap::ValueEnum;
use slewkit::files::epoch::Epoch;
use slewkit::files::exchange::Record;
use slewkit::files::export::{ExportError, PlanFile, write_csv, write_jsonl};
use slewkit::files::identity::Identity;
use slewkit::files::spec::Loaded;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::numerics::figures::error;
use slewkit::verify::Verification;
use std::borrow::Cow;
use std::io::Write;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// Arguments of `slew export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Attitudes lead from the body to the reference frame; what a format wants otherwise is done. Names, epoch and
number of the spacecraft stand in the spec that the plan holds ([names], epoch), or are given by --set.

Examples:
  slew export plan.json -o plan.aem --set epoch='2026-11-21T07:00:00 UTC'
  slew export plan.json -o plan.bc; slew export plan.json -o plan.tsc; slew export plan.json -o plan.tf
  slew export plan.json -o table.flight --tick 0.1")]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; `-` reads stdin
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Tick of `--format flight`; by default the step of the plan
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub tick: Option<f64>,
}

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(Format::value_variants(), &[&args.plan])?;
    let unusable = |error: ExportError| Failure::unusable(&args.plan, &error);
    let plan = PlanFile::read(spec_file::open_plan(&args.plan)?).map_err(unusable)?;
    let held = plan.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let Loaded { problem, identity, .. } = spec_file::read_held(held, &args.plan, &args.reading, console)?;
    let problem = plan.on_grid(&problem).map_err(unusable)?;
    let trajectory = &plan.trajectory.0;
    let notes = notes(plan.verified.as_ref());
    destination.write(console, |format, output| match format {
        Format::Jsonl => write_jsonl(trajectory, output),
        Format::Csv => write_csv(trajectory, &identity, output),
        Format::Json | Format::Text => plan.clone().with_identity(&identity).write(output),
        other => write(other, &record(&problem, &identity, trajectory, args.tick, notes), output),
    })?;
    Ok(Exit::Solved)
}

/// A number of seconds on the command line.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number of seconds is needed".into()),
    }
}

/// Refuses a format for which the maneuver does not say enough.
pub fn check(
    destination: &Destination,
    problem: &Problem,
    identity: &Identity,
    tick: Option<f64>,
) -> Result<(), Failure> {
    let Some(format) = destination.format().and_then(Format::of_others) else { return Ok(()) };
    let none = Trajectory::default();
    format
        .check(&record(problem, identity, &none, tick, Vec::new()))
        .map_err(|lacking| Failure::from(ExportError::from(lacking)))
}

/// What formats of other programs are written from.
pub fn record<'a>(
    problem: &'a Problem,
    identity: &'a Identity,
    trajectory: &'a Trajectory,
    tick: Option<f64>,
    notes: Vec<String>,
) -> Record<'a> {
    Record { problem, identity: Cow::Borrowed(identity), trajectory, created: now(), tick, notes }
}

/// Writes one of the formats of other programs.
pub fn write(format: Format, record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    format.of_others().map_or(Ok(()), |format| format.write(record, output))
}

/// What to know about a plan, for comments.
pub fn notes(verification: Option<&Verification>) -> Vec<String> {
    let mut notes = vec![format!("planned by slewkit {}", env!("CARGO_PKG_VERSION"))];
    notes.push(match verification {
        Some(found) if found.passed() => format!(
            "verified: the motion under the held torque ends within {} rad of the target",
            error(found.continuous_attitude_rad)
        ),
        _ => "not verified".into(),
    });
    notes
}

/// The date of creation that messages carry: now, or what `SOURCE_DATE_EPOCH` says, for equal files of equal inputs.
fn now() -> Epoch {
    let said = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    Epoch::of_unix(said.unwrap_or_else(clock))
}
