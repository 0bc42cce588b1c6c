//! `slew table`: tabulates the times, or efforts, of all turns of a spacecraft from rest to rest.

use super::batch::{checked_threads, span};
use super::{
    Console, Destination, Exit, Failure, Format, Lines, Message, OutputArgs, SpecArgs, Tone, interrupt, plan,
    spec_file, summary,
};
use slewkit::numerics::figures::significant;
use slewkit::plan::Status;
use slewkit::sequence::table::Left;
use slewkit::sequence::{Making, Quantity, SlewTable, TableError, TableOptions};
use slewkit_files::spec::{Loaded, SpecDocument};
use slewkit_files::table::{checksum, write_npz, write_parquet};
use std::time::Instant;

/// Arguments of `slew table`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The table has the body, the actuators and the limits of rates of the spec, and its objective: `minimize = \"time\"`, or
`\"effort\"` with `duration_s`. Start and end of the spec are not used: the table has every turn from rest to rest.
Symmetric spacecraft need fewer plans. The file states the errors of the interpolation on random turns that were
planned too.

Cones and momentum stored in wheels depend on both attitudes, not on the turn alone. Cones are left out: with them legs
take longer, so values are lower estimates, and bounds stay bounds. Stored momentum, fields and forces are refused.

Python reads the .npz: slewkit.SlewTable(\"slew.npz\")(q1, q2) and .matrix(q). Parquet has a row for each node.

Examples:
  slew table spacecraft.toml -o slew.npz
  slew table spacecraft.toml -o slew.npz --settling 15 --divisions 16
  slew table spacecraft.toml -o slew.parquet --checks 1000")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    /// Divisions n of a quarter turn between axes: 4n² + 2 axes of turns, about 90°/n apart. Twice
    /// as many take four times as long, and leave about a quarter of the error. By default 8, and
    /// up to 16 for symmetric spacecraft
    #[arg(long, value_name = "N")]
    pub divisions: Option<usize>,
    /// Random turns that are planned to measure the errors
    #[arg(long, value_name = "NUMBER", default_value = "200")]
    pub checks: usize,
    /// Time after a turn until the pointing counts, kept apart from the times
    #[arg(long, value_name = "SECONDS", default_value = "0")]
    pub settling: f64,
    /// Number of threads; by default the number of the machine. It does not change the results
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Formats in which a slew-time table can be written.
const FORMATS: [Format; 3] = [Format::Text, Format::Npz, Format::Parquet];

/// Runs `slew table` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(&FORMATS, &[&args.spec.spec])?;
    if args.output.output.is_none() && args.output.format.is_none() {
        return Err(Failure::Usage("a table needs a file: -o slew.npz, or -o slew.parquet".into()));
    }
    #[cfg(not(feature = "parquet"))]
    if destination.format() == Some(Format::Parquet) {
        return Err(
            slewkit_files::export::ExportError::from(slewkit_files::exchange::Lacking::Parquet).into()
        );
    }
    if let Some(threads) = args.threads {
        checked_threads(threads)?;
    }
    let Loaded { problem, settings, .. } = spec_file::read(&args.spec.spec, &args.spec.reading, console)?;
    problem.check().map_err(plan::invalid)?;
    let unwritable = |error: slewkit_files::spec::Unwritable| {
        Failure::Problem(Message::new("E0121", error.to_string(), "change the spec accordingly"))
    };
    let spec = SpecDocument::new(&problem, &settings).map_err(unwritable)?;
    let left_out = SlewTable::left_out(&problem);
    for left in &left_out {
        let (reason, remedy) = match left {
            Left::Cones => (
                "the table ignores the cones of the spec, which only lengthen the turns",
                "values are lower estimates; plan the legs of a schedule with the cones by `slew batch`",
            ),
            Left::Ends => (
                "the table holds turns from rest to rest: it ignores rates and targets of the spec",
                "plan legs with moving ends by `slew batch`",
            ),
        };
        console.warn("W0180", reason, remedy);
    }
    let options = TableOptions {
        divisions: args.divisions,
        checks: args.checks,
        settling_s: args.settling,
        threads: args.threads,
        ..TableOptions::default()
    };
    interrupt::watch();
    let began = Instant::now();
    let mut progress = |making: Making| {
        console.progress(|| progress(&making, began.elapsed().as_secs_f64()));
        !interrupt::requested()
    };
    let made = SlewTable::make(&problem, &settings, &options, &mut progress);
    console.clear_progress();
    let table = made.map_err(failure)?;
    interrupt::writing();
    let sum = checksum(&spec)?;
    let seconds = began.elapsed().as_secs_f64();
    console.say(&told(console, &problem.name, &table, seconds).join("\n"));
    destination.write(console, |format, output| match format {
        Format::Parquet => write_parquet(&table, sum, output),
        _ => write_npz(&table, sum, output),
    })?;
    if let Destination::File(..) = destination {
        console.say(&summary::line("next", "python: slewkit.SlewTable(FILE)(q1, q2), for the .npz"));
    }
    Ok(Exit::Solved)
}

fn progress(making: &Making, seconds: f64) -> String {
    let Making { done, total } = *making;
    let left = seconds / done.max(1) as f64 * (total - done) as f64;
    let to_go = if done > 0 { format!(", {} to go", span(left)) } else { String::new() };
    format!("  {done} of {total} turns{to_go}")
}

/// Returns the summary of a slew-time table that took `seconds` to compute.
fn told(console: &Console, name: &str, table: &SlewTable, seconds: f64) -> Vec<String> {
    let nodes = table.nodes();
    let what = match nodes.quantity {
        Quantity::Time => "minimum times from rest to rest".into(),
        Quantity::Effort => {
            format!("minimum efforts from rest to rest in {} s", significant(nodes.duration_s, 4))
        }
    };
    let angles = nodes.angles.len();
    let percent = |part: f64| format!("{} %", significant(100.0 * part, 2));
    let mut lines = vec![
        summary::headline(console, name, "tabulated", Tone::Good),
        summary::line("table", &what),
        summary::line(
            "turns",
            &format!(
                "{} axes × {angles} angles, {} planned, symmetry of order {}",
                nodes.values.len() / angles,
                nodes.planned,
                nodes.maps.len()
            ),
        ),
    ];
    let largest = nodes.values.iter().copied().fold(0.0, f64::max);
    let unit = if nodes.quantity == Quantity::Time { " s" } else { "" };
    lines.line("longest", format!("{}{unit}", significant(largest, 4)));
    let errors = &nodes.errors;
    if errors.count > 0 {
        lines.line(
            "errors",
            format!(
                "on {} random turns: median {}, {} at 99 %, from {} to {}",
                errors.count,
                percent(errors.median),
                percent(errors.most),
                percent(errors.lowest),
                percent(errors.highest)
            ),
        );
        lines
            .line("bound", format!("the lower bound is {} of the plan in the median", percent(errors.bound)));
    }
    if nodes.settling_s > 0.0 {
        lines.line("settling", format!("{} s, apart from the values", significant(nodes.settling_s, 4)));
    }
    lines.line("made in", span(seconds));
    lines
}

fn failure(error: TableError) -> Failure {
    let message = |reason: String, remedy: &str| Message::new("E0180", reason, remedy);
    match error {
        TableError::Refused { reason, remedy } => {
            Failure::Problem(message(format!("no table: {reason}"), remedy))
        }
        TableError::Plan(error) => plan::refusal(error),
        TableError::Unplanned { remedy, .. } => {
            Failure::Plan(Status::NotConverged, message(error.to_string(), remedy))
        }
        TableError::Option { what } => Failure::Usage(what.into()),
        TableError::Stopped => {
            let remedy =
                "a table is written only when complete: run it again; fewer --divisions take less time";
            Failure::Plan(Status::Interrupted, message("interrupted: no table was written".into(), remedy))
        }
        TableError::NoThread => Failure::Output(message(error.to_string(), "")),
        TableError::Nodes { .. } => Failure::Internal(error.to_string()),
    }
}
