//! Commands that plan many maneuvers: `slew batch`, `slew sweep`, `slew monte-carlo`, `slew merge`.

pub mod merge;
pub mod monte_carlo;
mod progress;
mod summary;
pub mod sweep;
pub mod table;

use super::{
    Common, Console, Exit, Failure, Message, OutputArgs, Reading, SpecArgs, export, interrupt, plan,
};
use progress::Progress;
pub use progress::span;
use slewkit_files::batch::{
    Batch, BatchError, CaseResult, CommaTable, Ended, Journal, MAX_THREADS, Options, Shard, Tally, run,
};
use slewkit_files::export::{FileError, Target, distinct};
use slewkit_files::spec::{Base, escape};
use std::cell::Cell;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The options for planning cases and for their results, common to all commands of many cases.
#[derive(Debug, clap::Args)]
pub struct Running {
    /// Append the results to FILE.jsonl, one JSON object on each line; an incomplete file is
    /// continued. FILE.csv is a table, written at the end. `-` is stdout. With --case: the plan
    /// file
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Throw away the results that FILE holds; replace the plan file
    #[arg(long)]
    pub force: bool,
    /// Number of threads; by default the number of the machine. It does not change the results
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Only every n-th case from the i-th on, for one of n processes; `slew merge` puts them
    /// together
    #[arg(long, value_name = "i/n")]
    pub shard: Option<String>,
    /// Also write the plan file of every case into a folder, which slew creates if needed
    #[arg(long, value_name = "DIR")]
    pub plans: Option<PathBuf>,
    /// Plan the case of this number alone, as `slew plan` does
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["shard", "plans", "threads", "times"])]
    pub case: Option<u64>,
    /// Put the wall time of each solve into its line; the same run then gives another file each
    /// time
    #[arg(long)]
    pub times: bool,
    /// Print progress also if stderr is not a terminal, every ten seconds
    #[arg(long)]
    pub progress: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl Running {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }

    fn options(&self) -> Result<Options, Failure> {
        let mut options = Options { plans: self.plans.clone(), times: self.times, ..Options::default() };
        if let Some(threads) = self.threads {
            checked_threads(threads)?;
            options.threads = threads;
        }
        Ok(options)
    }
}

/// Returns an error if the number of threads is zero or too large.
pub fn checked_threads(threads: usize) -> Result<(), Failure> {
    if (1..=MAX_THREADS).contains(&threads) {
        return Ok(());
    }
    let reason = format!("--threads: {threads} threads are not possible");
    let remedy = format!("give a number from 1 to {MAX_THREADS}, or remove the option");
    Err(Failure::Output(Message::new("E0115", reason, remedy)))
}

/// Command line of a batch, from which the summary builds a command that plans one case again.
pub struct Asked<'a> {
    /// Command with the options that define its cases, such as `slew sweep SPEC --over …`.
    pub command: String,
    /// Path of the spec, or of the folder of specs.
    pub spec: &'a Path,
    /// Path of the table of cases; `None` without `--cases`.
    pub cases: Option<&'a Path>,
    pub reading: &'a Reading,
}

/// Plans all cases of a batch, or only the case that `--case` requests.
pub fn conduct(
    batch: &Batch,
    asked: &Asked<'_>,
    running: &Running,
    console: &mut Console,
) -> Result<Exit, Failure> {
    if let Some(number) = running.case {
        return one(batch, number, asked, running, console);
    }
    if let Some(path) = running.output.as_deref().filter(|path| merge::is_parquet(path)) {
        let shown = escape(&path.to_string_lossy());
        let reason =
            format!("{shown}: results are appended as lines of JSON, and Parquet cannot be appended");
        let remedy = "give -o FILE.jsonl, then `slew merge FILE.jsonl -o FILE.parquet`";
        return Err(Failure::Output(Message::new("E0107", reason, remedy)));
    }
    let options = running.options()?;
    let shard = running.shard.as_deref().map_or(Ok(Shard::ALL), Shard::parse)?;
    let outputs = || running.output.iter().chain(&options.plans);
    let named = batch.files();
    for input in std::iter::once(asked.spec).chain(asked.cases).chain(named.iter().map(PathBuf::as_path)) {
        outputs().try_for_each(|output| distinct(output, input))?;
    }
    if let Some(path) = running.output.as_deref().filter(|path| path.as_os_str() != "-") {
        merge::checked_ending(path, &["jsonl", "ndjson", "csv"])?;
        if merge::is_csv(path) && running.shard.is_some() {
            let reason = "shards are joined from lines of JSON, not from tables";
            let remedy = "give -o FILE.jsonl, then `slew merge FILE.jsonl … -o ALL.csv`";
            return Err(Failure::Output(Message::new("E0107", reason, remedy)));
        }
    }
    if let Some(folder) = &options.plans {
        make(folder)?;
    }
    let header = batch.header(shard, options.times);
    let mut tally = Tally::default();
    let mut sink = Sink::open(running, &header, &mut tally, console)?;
    let done = tally.cases;
    // Existing plan files are an error only in a new run. In a continued run they are results of
    // this run, and a plan file of an interrupted case is replaced.
    if let Some(folder) = options.plans.as_ref().filter(|_| done == 0 && !running.force) {
        batch.check_plans(folder, shard)?;
    }

    if running.output.is_some() {
        interrupt::watch_kept();
    } else {
        interrupt::watch();
    }
    let began = Instant::now();
    let counts = Cell::new((tally.cases, tally.failed()));
    let progress = Progress::new(shard.count(batch.count()), done, running.progress);
    let mut take = |result: &CaseResult, line: &str| {
        sink.take(result, line)?;
        tally.add(result);
        counts.set((tally.cases, tally.failed()));
        Ok(())
    };
    let mut tick = || progress.tell(console, counts.get());
    let ended = run(batch, shard, done, &options, &interrupt::requested, &mut take, &mut tick);
    console.clear_progress();
    let ended = match ended {
        // The program that reads the stream has closed it, as `head` does.
        Err(BatchError::Closed) => return Ok(Exit::Solved),
        ended => ended?,
    };
    let path = sink.close()?;
    let facts = summary::Facts {
        asked,
        header: &header,
        shard,
        tally: &tally,
        done,
        seconds: began.elapsed().as_secs_f64(),
        threads: options.threads,
        output: path,
        stopped: ended == Ended::Stopped,
        forced: running.force,
    };
    console.say(&summary::text(console, &facts));
    Ok(match ended {
        Ended::Stopped => Exit::Plan(slewkit::plan::Status::Interrupted),
        Ended::Complete if tally.failed() > 0 => Exit::CasesFailed,
        Ended::Complete => Exit::Solved,
    })
}

/// Runs `slew plan` on one case.
fn one(
    batch: &Batch,
    number: u64,
    asked: &Asked<'_>,
    running: &Running,
    console: &mut Console,
) -> Result<Exit, Failure> {
    if asked.spec.as_os_str() == "-" {
        return Err(Failure::Usage("--case: the spec is read twice, so it cannot come from stdin".into()));
    }
    let case = batch.case(number)?;
    let own = case.set.iter().map(|set| format!("{}={}", set.path(), set.value()));
    let set = asked.reading.set.iter().cloned().chain(own).collect();
    let output = OutputArgs {
        format: None,
        output: running.output.clone(),
        force: running.force,
        quiet: running.quiet,
    };
    let spec = case.spec.unwrap_or_else(|| asked.spec.into());
    let spec = SpecArgs { spec, reading: Reading { set, input: asked.reading.input } };
    plan::run(
        &plan::Args {
            spec,
            output,
            tables: export::TableArgs::default(),
            guess: None,
            guess_alone: false,
            warm: None,
            at: None,
            report: None,
            verbose: false,
        },
        console,
    )
}

/// Reads the spec on which the cases are based, with the overrides on the command line.
pub fn base(spec: &Path, reading: &Reading) -> Result<Base, Failure> {
    let (overrides, format) = super::spec_file::arguments(spec, reading)?;
    Ok(if spec.as_os_str() == "-" {
        Base::from_reader(io::stdin().lock(), "stdin", format, &overrides)?
    } else {
        Base::open(spec, format, &overrides)?
    })
}

fn make(folder: &Path) -> Result<(), Failure> {
    if !folder.is_dir() {
        let shown = escape(&folder.to_string_lossy());
        std::fs::create_dir_all(folder).map_err(|reason| FileError::NotWritable { folder: shown, reason })?;
    }
    Ok(())
}

/// Destination to which the results of a batch are written.
enum Sink {
    Nowhere,
    Stdout,
    File(PathBuf, Box<Journal>),
    /// A table of comma-separated values, which is written after the last case.
    Table(Target, Box<slewkit_files::batch::Header>, Vec<CaseResult>),
}

impl Sink {
    /// Opens the destination. Results that the file already contains are added to the statistics.
    fn open(
        running: &Running,
        header: &slewkit_files::batch::Header,
        tally: &mut Tally,
        console: &mut Console,
    ) -> Result<Self, Failure> {
        match &running.output {
            Some(path) if merge::is_csv(path) => {
                Ok(Self::Table(Target::new(path, running.force)?, Box::new(header.clone()), Vec::new()))
            }
            Some(path) if path.as_os_str() != "-" => {
                let (journal, found) =
                    Journal::open(path, header, running.force, &mut |result| tally.add(result))?;
                if found.torn > 0 {
                    let shown = escape(&path.to_string_lossy());
                    let reason = format!(
                        "{shown}: the last line was incomplete, {} bytes of it; it is removed",
                        found.torn
                    );
                    console.warn("W0113", &reason, "no action is needed: its case is planned again");
                }
                Ok(Self::File(path.clone(), Box::new(journal)))
            }
            None => Ok(Self::Nowhere),
            _ => {
                let head =
                    serde_json::to_string(header).map_err(|error| Failure::Internal(error.to_string()))?;
                Self::Stdout.line(&head)?;
                Ok(Self::Stdout)
            }
        }
    }

    fn take(&mut self, result: &CaseResult, line: &str) -> Result<(), BatchError> {
        if let Self::Table(_, _, results) = self {
            results.push(result.clone());
            return Ok(());
        }
        self.line(line)
    }

    fn line(&mut self, line: &str) -> Result<(), BatchError> {
        match self {
            Self::Nowhere | Self::Table(..) => Ok(()),
            Self::File(_, journal) => journal.line(line),
            Self::Stdout => {
                let mut output = io::stdout().lock();
                writeln!(output, "{line}").and_then(|()| output.flush()).map_err(|error| match error.kind() {
                    io::ErrorKind::BrokenPipe => BatchError::Closed,
                    _ => slewkit_files::export::ExportError::from(error).into(),
                })
            }
        }
    }

    /// Writes all data to the disk. Returns the path of the destination, or `None` if it is not a
    /// file.
    fn close(self) -> Result<Option<PathBuf>, BatchError> {
        match self {
            Self::Nowhere | Self::Stdout => Ok(None),
            Self::File(path, journal) => journal.close().map(|()| Some(path)),
            Self::Table(target, header, results) => {
                target.write(|output| {
                    let mut table = CommaTable::begin(&header, output)?;
                    results.iter().try_for_each(|result| table.add(result))
                })?;
                Ok(Some(target.path().to_path_buf()))
            }
        }
    }
}
