//! `slew batch`: plans a table of cases, or a folder of specs.

use super::{Asked, Running, base, conduct};
use crate::advice::word;
use crate::{Console, Exit, Failure, SpecArgs, spec_file};
use slewkit_files::batch::Batch;
use std::path::PathBuf;

/// Arguments of `slew batch`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The table is comma-separated. Its header has dotted keys of the spec, and each row is a case. A list
needs quotes. A column `name` names the cases. An empty cell keeps the value of the spec:

  name,maneuver.duration_s,start.angular_velocity_deg_s
  slow,90,\"[0, 0, 0]\"
  fast,45,\"[0, 0, 1.5]\"

A folder has one case for each of its .toml and .json files, in the order of their names.

Results are JSON lines in the order of the cases: a header, then for each case its keys, status,
cost, duration, terminal errors, second order and the verdict of the witnesses. The file has the same
bytes on any number of threads, after any interruption, and from shards that `slew merge` joins,
unless a time limit ends a solve. The time limit of the spec (`solver.time_limit_s`) applies to each
case. Exit code 9 means that some cases failed.

Examples:
  slew batch maneuver.toml --cases cases.csv -o results.jsonl
  slew batch specs/ -o results.jsonl --plans plans
  slew batch maneuver.toml --cases cases.csv -o part3.jsonl --shard 3/40")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    /// Table of cases, comma-separated; without it SPEC is a folder of specs
    #[arg(long, value_name = "FILE.csv")]
    pub cases: Option<PathBuf>,
    #[command(flatten)]
    pub running: Running,
}

/// Runs `slew batch` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let SpecArgs { spec, reading } = &args.spec;
    let path = word(&spec.to_string_lossy());
    let (batch, command) = match &args.cases {
        Some(cases) if cases.as_os_str() == "-" => {
            return Err(Failure::Usage(
                "--cases: the table is read twice, so it cannot come from stdin".into(),
            ));
        }
        Some(cases) => {
            let command = format!("slew batch {path} --cases {}", word(&cases.to_string_lossy()));
            (Batch::of_table(base(spec, reading)?, cases)?, command)
        }
        None if spec.is_dir() => {
            if reading.input.is_some() {
                return Err(Failure::Usage(
                    "--input: the endings of the files of a folder select their notation".into(),
                ));
            }
            let (overrides, _) = spec_file::arguments(spec, reading)?;
            (Batch::of_folder(spec, overrides)?, format!("slew batch {path}"))
        }
        None => {
            let reason = format!(
                "a batch needs more than one spec: give --cases FILE.csv, or a folder of specs instead of \
                {path}"
            );
            return Err(Failure::Usage(reason));
        }
    };
    conduct(&batch, &Asked { command, spec, cases: args.cases.as_deref(), reading }, &args.running, console)
}
