//! `slew merge`: joins the results of all shards of a batch.

use crate::{Common, Console, Exit, Failure, Message, interrupt, summary};
use slewkit::numerics::figures::counted;
use slewkit_files::batch::{merge, merge_to_csv, merge_to_parquet};
use slewkit_files::export::Target;
use slewkit_files::spec::escape;
use std::path::{Path, PathBuf};

/// Arguments of `slew merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Name the shards in any order. slew needs all of them, and each must be complete. If one is missing or
incomplete, slew names it and writes nothing. The result has the same bytes as a run without --shard.
The endings .csv and .parquet select a table with one row for each case, for spreadsheets and pandas.
.parquet needs a build with the feature `parquet`.

Examples:
  slew merge part1.jsonl part2.jsonl part3.jsonl -o all.jsonl
  slew merge all.jsonl -o all.csv")]
pub struct Args {
    /// Results of all shards of one batch, or of a whole one
    #[arg(value_name = "SHARD.jsonl", required = true)]
    pub shards: Vec<PathBuf>,
    /// The file of all results: .jsonl, .ndjson, .csv or .parquet
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl Args {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }
}

/// Runs `slew merge` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    interrupt::end_at_once();
    let target = Target::new(&args.output, args.force)?;
    args.shards.iter().try_for_each(|shard| target.distinct_from(shard))?;
    checked_ending(&args.output, &["jsonl", "ndjson", "csv", "parquet"])?;
    let cases = if is_parquet(&args.output) {
        merge_to_parquet(&args.shards, &target)
    } else if is_csv(&args.output) {
        merge_to_csv(&args.shards, &target)
    } else {
        merge(&args.shards, &target)
    }?;
    let shards = counted(args.shards.len(), "shard");
    console.say(&summary::line("merged", &format!("{cases} cases of {shards}")));
    summary::wrote(console, &target);
    Ok(Exit::Solved)
}

/// Returns an error if the name of the file of results has none of the file name extensions
/// `endings`. A path that is not a regular file, such as `/dev/null`, needs no extension.
pub fn checked_ending(path: &Path, endings: &[&str]) -> Result<(), Failure> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let is_known = ending.as_deref().is_some_and(|ending| endings.contains(&ending));
    if is_known || (path.exists() && !path.is_file()) {
        return Ok(());
    }
    let shown = escape(&path.to_string_lossy());
    let reason = match ending {
        Some(ending) => format!("{shown}: results have no format with the ending .{}", escape(&ending)),
        None => format!("{shown} has no ending to select the format"),
    };
    let known: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    let remedy =
        format!("use the ending {}: .jsonl holds lines of JSON, and can be continued", known.join(", "));
    Err(Failure::Output(Message::new("E0105", reason, remedy)))
}

/// Returns whether the file name has the extension of a comma-separated table.
pub fn is_csv(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

/// Returns whether the file name has the extension of a Parquet file.
pub fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}
