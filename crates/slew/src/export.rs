//! `slew export`: writes a plan file in the formats of other programs.

use super::pictured::Kind;
use super::{
    Console, Destination, Exit, Failure, Format, Message, OutputArgs, Reading, interrupt, pictured, spec_file,
};
use clap::ValueEnum;
use slewkit::maneuver::Problem;
use slewkit_files::exchange::Tables;
use slewkit_files::export::{ExportError, PlanFile};
use slewkit_files::formats;
use slewkit_files::identity::Identity;
use slewkit_files::spec::{Loaded, LoadedSequence};
use std::path::PathBuf;

/// Arguments of `slew export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Attitudes of a plan map the body to the reference frame. slew converts them to the convention of each format.
The spec in the plan states names, epoch and number of the spacecraft ([names], epoch); --set changes them.

Examples:
  slew export plan.json -o plan.aem --set epoch='2026-11-21T07:00:00 UTC'
  slew export plan.json -o plan.bc; slew export plan.json -o plan.tsc; slew export plan.json -o plan.tf
  slew export plan.json -o table.flight --tick 0.1
  slew export plan.json -o plan.csv --margins")]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; `-` reads stdin
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub tables: TableArgs,
}

/// The options of tables.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct TableArgs {
    /// Tick of `--format flight`; by default the step of the plan
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub tick: Option<f64>,
    /// In CSV and Parquet, also write the margin of every limit and constraint at each node, and
    /// the angle in degrees between each boresight and the direction of its cone, such as the Sun
    #[arg(long)]
    pub margins: bool,
}

impl TableArgs {
    /// Returns the requested contents of a table, or an error if an option is given that the format
    /// does not support.
    pub fn checked(self, destination: &Destination) -> Result<Tables, Failure> {
        let format = destination.format().and_then(Format::of_data);
        if self.margins && !format.is_some_and(formats::Format::tells_margins) {
            let reason = "--margins: only the tables csv and parquet have columns for margins".to_string();
            return Err(Failure::Output(Message::new(
                "E0107",
                reason,
                "give -o FILE.csv, or remove the option",
            )));
        }
        Ok(Tables { tick: self.tick, margins: self.margins })
    }
}

/// Runs `slew export` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    interrupt::end_at_once();
    let destination = args.output.destination(Format::value_variants(), &[&args.plan])?;
    if destination.format().is_none() {
        let reason = "an export needs a file or a format: -o plan.aem, or --format csv for stdout";
        return Err(Failure::Usage(reason.into()));
    }
    let unusable = |error: ExportError| Failure::unusable(&args.plan, &error);
    let tables = args.tables.checked(&destination)?;
    let input = match pictured::open(&args.plan)? {
        (Kind::Sequence, input) => {
            let (file, loaded, exit) = pictured::sequence(&args.plan, input, &args.reading, console)?;
            let LoadedSequence { sequence, identity, .. } = &loaded;
            check(&destination, &sequence.craft, identity)?;
            destination.write(console, |format, output| {
                let format = format.of_data().unwrap_or(formats::Format::Json);
                format.write_sequence(&file, &sequence.craft, identity, tables, output)
            })?;
            return Ok(exit);
        }
        (_, input) => input,
    };
    let plan = PlanFile::read(input).map_err(unusable)?;
    let held = plan.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let loaded = spec_file::read_held(held, &args.plan, &args.reading, console)?;
    let (plan, exit) = pictured::settled(plan, &loaded, &args.plan, console);
    let Loaded { problem, identity, .. } = loaded;
    let problem = plan.on_grid(&problem).map_err(unusable)?;
    destination.write(console, |format, output| {
        let format = format.of_data().unwrap_or(formats::Format::Json);
        format.write(&plan, &problem, &identity, tables, output)
    })?;
    Ok(exit)
}

/// Parses a positive number of seconds that is given on the command line.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a positive number of seconds".into()),
    }
}

/// Checks that the maneuver has all data that the format requires, such as names or an epoch.
pub fn check(destination: &Destination, problem: &Problem, identity: &Identity) -> Result<(), Failure> {
    let Some(format) = destination.format().and_then(Format::of_data) else { return Ok(()) };
    format.check(problem, identity).map_err(|lacking| Failure::from(ExportError::from(lacking)))
}
