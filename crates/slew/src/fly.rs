//! `slew fly`: flies a plan many times, each time with a craft that differs from the model.

use super::batch::checked_threads;
use super::batch::merge::checked_ending;
use super::spec_file::PlanOrAttitudes;
use super::{
    Console, Destination, Exit, Failure, Format, Message, OutputArgs, Reading, interrupt, spec_file, summary,
};
use clap::ValueEnum;
use slewkit::closed_loop::Campaign;
use slewkit::maneuver::Outcome;
use slewkit::plan::Status;
use slewkit_files::batch::{FlightCase, FlightHeader, Journal};
use slewkit_files::export::{ExportError, PlanFile, SequenceFile, distinct};
use slewkit_files::flown::{
    Flight, LoopRecord, NotFlown, RunRecord, Runs, WholeFlight, write_cases, write_trace,
};
use slewkit_files::spec::{ClosedLoop, escape};
use slewkit_report::summary::flown as told;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `slew fly`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A plan of a sequence is flown over all legs and holds. Each stop has the errors at the start and the end of its
hold.
The spec in the plan states how the craft differs from the model ([uncertainty]), its gains ([feedback]) and the
response of its actuators ([plant]); --set changes them. The plan does not change. `slew monte-carlo` instead plans
every draw anew.

Every case has its own inertia, noise, errors and delays, and flies the continuous motion under torques held over a
tick. The random numbers of a case depend only on the seed and the number of the case. CSV and NPZ hold one row for each
case, JSON the statistics. With --case, CSV holds that case step by step. With --keep slew writes every case to a file
as it is flown. After a kill, Ctrl-C or with more --cases this command continues that file, with the same results.

Examples:
  slew plan maneuver.toml -o plan.json && slew fly plan.json
  slew fly plan.json --cases 100000 -o cases.npz
  slew fly plan.json --cases 1000000 --keep cases.jsonl --format json
  slew fly plan.json --set uncertainty.inertia.relative=0.05 --format json
  slew fly plan.json --case 17 -o case.csv")]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; `-` reads stdin
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Number of cases
    #[arg(
        long,
        value_name = "NUMBER",
        default_value = "1000",
        value_parser = clap::value_parser!(u64).range(2..=Campaign::MOST_CASES),
    )]
    pub cases: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "NUMBER", default_value = "1")]
    pub seed: u64,
    /// Keep every case in FILE.jsonl, one JSON object per line; an existing file is
    /// continued
    #[arg(long, value_name = "FILE")]
    pub keep: Option<PathBuf>,
    /// Number of threads; by default the number of the machine. It does not change the results
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Fly only this case, counted from 1, and show it step by step
    #[arg(
        long,
        value_name = "NUMBER",
        value_parser = clap::value_parser!(u64).range(1..),
        conflicts_with_all = ["keep", "threads"],
    )]
    pub case: Option<u64>,
    /// Loop: with the gains of the plan, without, or both side by side
    #[arg(long = "loop", value_name = "LOOP", default_value = "both")]
    pub which: Which,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// The loop of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Which {
    /// With the gains of the plan
    Closed,
    /// Without gains
    Open,
    /// Both
    Both,
}

/// Formats in which the results of the cases can be written.
const FORMATS: [Format; 4] = [Format::Text, Format::Json, Format::Csv, Format::Npz];

/// Number of cases that run between two checks for Ctrl-C. This many cases take a few tenths of a
/// second.
const CHUNK: usize = 4096;

/// Runs `slew fly` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(&FORMATS, &[&args.plan])?;
    keep_plan(&args.reading)?;
    let Args { seed, threads, .. } = *args;
    if let Some(threads) = threads {
        checked_threads(threads)?;
    }
    let (closed_loop, WholeFlight { problem, beside, marks }) =
        match spec_file::open_plan_or_attitudes(&args.plan)? {
            PlanOrAttitudes::Sequence(input) => sequence(args, input, console)?,
            PlanOrAttitudes::Plan(input) | PlanOrAttitudes::Attitudes(input) => {
                maneuver(args, input, console)?
            }
        };
    let Some(uncertainty) = &closed_loop.uncertainty else {
        let reason = "the plan has no uncertainty: the craft would fly as planned";
        let remedy = "add [uncertainty] to its spec, or give --set uncertainty.inertia.relative=0.02";
        return Err(Failure::File(Message::new("E0173", reason, remedy)));
    };
    let (problem, closed_loop, beside, marks) = (&problem, &closed_loop, &beside, &marks[..]);
    let runs = Runs { problem, closed_loop, uncertainty, beside, marks, seed, threads };
    match args.case {
        Some(case) => one(args, &runs, case, &destination, console),
        None => all(args, &runs, &destination, console),
    }
}

/// Reads the plan of a maneuver, and computes the gains and covariances along it.
fn maneuver(
    args: &Args,
    input: Box<dyn Read>,
    console: &mut Console,
) -> Result<(ClosedLoop, WholeFlight), Failure> {
    let unusable = |error: ExportError| Failure::unusable(&args.plan, &error);
    let plan = PlanFile::read(input).map_err(unusable)?;
    let held = plan.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let loaded = spec_file::read_held(held, &args.plan, &args.reading, console)?;
    if plan.outcome != Outcome::Converged {
        return Err(unsolved(args));
    }
    let flight = WholeFlight::of_maneuver(&plan, &loaded).map_err(|error| not_flown(args, error))?;
    Ok((loaded.closed_loop, flight))
}

/// Reads the plan of a sequence, and computes the gains and covariances along its whole motion.
fn sequence(
    args: &Args,
    input: Box<dyn Read>,
    console: &mut Console,
) -> Result<(ClosedLoop, WholeFlight), Failure> {
    let unusable = |error: ExportError| Failure::unusable(&args.plan, &error);
    let file = SequenceFile::read(input).map_err(unusable)?;
    let held = file.record.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let loaded = spec_file::read_held_sequence(held, &args.plan, &args.reading, console)?;
    if file.record.status != Status::Solved {
        return Err(unsolved(args));
    }
    let flight = WholeFlight::of(&file, &loaded).map_err(|error| not_flown(args, error))?;
    Ok((loaded.closed_loop, flight))
}

fn unsolved(args: &Args) -> Failure {
    let reason = format!("{}: this plan did not reach its end", args.plan.display());
    Failure::File(Message::new("E0173", reason, "give a solved plan"))
}

fn not_flown(args: &Args, error: NotFlown) -> Failure {
    match error {
        NotFlown::File(error) => Failure::unusable(&args.plan, &error),
        error => Failure::File(Message::new("E0170", error.to_string(), error.remedy())),
    }
}

/// Keys that define the maneuver. If their values were changed, the recorded plan would not belong
/// to the maneuver.
const PLANNED: [&str; 8] = ["body", "start", "end", "stop", "maneuver", "environment", "orbit", "epoch"];

/// Returns an error if an override changes a key that defines the maneuver.
fn keep_plan(reading: &Reading) -> Result<(), Failure> {
    let key = |text: &String| text.split('=').next().unwrap_or_default().trim().to_string();
    let table = |key: &str| key.split('.').next().unwrap_or_default().to_string();
    match reading.set.iter().map(key).find(|key| PLANNED.contains(&table(key).as_str())) {
        None => Ok(()),
        Some(key) => Err(Failure::Usage(format!(
            "--set {}: the plan does not change in flight; to fly a craft that differs from its model, set \
            [uncertainty], [feedback] or [plant]",
            escape(&key)
        ))),
    }
}

/// Returns the requested loops: true for the closed loop, false for the open loop.
fn loops(args: &Args, runs: &Runs<'_>) -> Result<Vec<bool>, Failure> {
    let has = runs.beside.gains.is_some();
    match args.which {
        Which::Closed if !has => {
            let remedy = "add [feedback] to its spec, or give --set feedback.kind=tvlqr";
            Err(Failure::File(Message::new("E0173", "the plan has no gains", remedy)))
        }
        Which::Closed => Ok(vec![true]),
        Which::Open => Ok(vec![false]),
        Which::Both => Ok(if has { vec![true, false] } else { vec![false] }),
    }
}

fn one(
    args: &Args,
    runs: &Runs<'_>,
    case: u64,
    destination: &Destination,
    console: &mut Console,
) -> Result<Exit, Failure> {
    if matches!(destination.format(), Some(Format::Npz | Format::Json)) {
        let reason = "one case is written as a table of its steps";
        return Err(Failure::Output(Message::new("E0107", reason, "give -o FILE.csv")));
    }
    let closed = loops(args, runs)?[0];
    let Ok((flown, moments)) = runs.campaign(closed).traced(case - 1) else {
        let reason = format!("case {case} turns too fast to be propagated, or its inertia is impossible");
        let remedy = "fly another case, or reduce the uncertainty";
        return Err(Failure::Problem(Message::new("E0174", reason, remedy)));
    };
    let inputs = runs.problem.actuation.torque.count();
    console.say(&told::case(runs.problem, runs.uncertainty, case, closed, &flown).join("\n"));
    destination.write(console, |_, output| write_trace(inputs, &moments, output))?;
    Ok(Exit::Solved)
}

fn all(
    args: &Args,
    runs: &Runs<'_>,
    destination: &Destination,
    console: &mut Console,
) -> Result<Exit, Failure> {
    let closed = loops(args, runs)?;
    let campaigns: Vec<Campaign<'_>> = closed.iter().map(|closed| runs.campaign(*closed)).collect();
    let mut flights: Vec<Flight<'_>> = closed.iter().filter_map(|closed| runs.flight(*closed)).collect();
    let mut kept = match &args.keep {
        Some(path) => Some(kept(args, path, &FlightHeader::new(runs, &closed), &mut flights, console)?),
        None => None,
    };
    if kept.is_some() {
        interrupt::watch_kept();
    } else {
        interrupt::watch();
    }
    let began = Instant::now();
    let count =
        |flights: &[Flight<'_>]| flights.first().map_or(args.cases, |flight| flight.cases.len() as u64);
    while count(&flights) < args.cases && !interrupt::requested() {
        let first = count(&flights);
        let more = ((args.cases - first) as usize).min(CHUNK);
        for (campaign, flight) in campaigns.iter().zip(&mut flights) {
            flight.cases.extend(campaign.fly_all(first, more));
        }
        if let Some(kept) = &mut kept {
            for case in first..count(&flights) {
                let of_case: Vec<_> = flights.iter().map(|flight| &flight.cases[case as usize]).collect();
                kept.add(&FlightCase::new(case + 1, &of_case))?;
            }
        }
        console.progress(|| format!("  {} of {} cases", count(&flights), args.cases));
    }
    let record = RunRecord {
        name: runs.problem.name.clone(),
        seed: args.seed,
        cases: count(&flights) as usize,
        time_s: began.elapsed().as_secs_f64(),
        loops: flights.iter().map(|flight| LoopRecord::new(runs.problem, runs.marks, flight)).collect(),
    };
    let stopped = interrupt::requested();
    interrupt::writing();
    console.say(&told::runs(console.colour, &record).join("\n"));
    if let Some(kept) = kept {
        kept.close()?;
        if stopped {
            console.say(&summary::line("resume", "this command continues the run"));
        }
    }
    destination.write(console, |format, output| match format {
        Format::Json => record.write(output),
        _ => {
            let Runs { problem, uncertainty, marks, .. } = *runs;
            write_cases((problem, uncertainty, marks), &flights, format == Format::Npz, output)
        }
    })?;
    Ok(if stopped { Exit::Plan(Status::Interrupted) } else { Exit::Solved })
}

/// Opens the file of `--keep`, and adds the cases in it to the flights of their loops.
fn kept(
    args: &Args,
    path: &Path,
    header: &FlightHeader,
    flights: &mut [Flight<'_>],
    console: &mut Console,
) -> Result<Journal, Failure> {
    checked_ending(path, &["jsonl", "ndjson"])?;
    for other in std::iter::once(&args.plan).chain(&args.output.output) {
        distinct(path, other)?;
    }
    let (journal, found) = Journal::open(path, header, false, &mut |case: &FlightCase| {
        for (flight, of_case) in flights.iter_mut().zip(case.flights()) {
            flight.cases.push(of_case);
        }
    })?;
    let shown = escape(&path.to_string_lossy());
    if found.torn > 0 {
        let reason =
            format!("{shown}: the last line was incomplete, {} bytes of it; it is removed", found.torn);
        console.warn("W0113", &reason, "no action is needed: its case is flown again");
    }
    if found.done > args.cases {
        let reason = format!("{shown} holds {} cases, more than requested", found.done);
        let remedy = format!("give --cases {}, or another file", found.done);
        return Err(Failure::Output(Message::new("E0112", reason, remedy)));
    }
    if found.done > 0 {
        console.say(&summary::line("continued", &format!("after {} cases that were there", found.done)));
    }
    Ok(journal)
}
