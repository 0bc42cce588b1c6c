//! `slew merge`: shards put together.

use crate::{Common, Console, Exit, Failure, interrupt, summary};
use slewkit::numerics::figures::counted;
use slewkit_files::batch::{merge, merge_to_parquet};
use slewkit_files::export::Target;
use std::path::{Path, PathBuf};

/// Arguments of `slew merge`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The shards may be named in any order. All of them are needed, and each must be complete: what is
missing is named, and nothing is written. The result is, byte for byte, the file of a run
without --shard. A name that ends in .parquet makes a table of it, a row a case, for pandas and its
like; that needs a build with the feature `parquet`.

Examples:
  slew merge part1.jsonl part2.jsonl part3.jsonl -o all.jsonl
  slew merge all.jsonl -o all.parquet")]
pub struct Args {
    /// Results of all shards of one batch, or of a whole one
    #[arg(value_name = "SHARD.jsonl", required = true)]
    pub shards: Vec<PathBuf>,
    /// The file of all results
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
    /// No text but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl Args {
    /// The part that failures need.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }
}

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    interrupt::end_at_once();
    let target = Target::new(&args.output, args.force)?;
    args.shards.iter().try_for_each(|shard| target.distinct_from(shard))?;
    let cases = if is_parquet(&args.output) {
        merge_to_parquet(&args.shards, &target)
    } else {
        merge(&args.shards, &target)
    }?;
    let shards = counted(args.shards.len(), "shard");
    console.say(&summary::line("merged", &format!("{cases} cases of {shards}")));
    summary::wrote(console, &target);
    Ok(Exit::Solved)
}

/// Whether a file of this name is to be Parquet.
pub fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}
