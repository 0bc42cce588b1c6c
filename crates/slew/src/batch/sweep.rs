//! `slew sweep`: plans a maneuver for a grid of values of some keys.

use super::{Asked, Running, base, conduct};
use crate::advice::word;
use crate::{Console, Exit, Failure, SpecArgs};
use slewkit_files::batch::{Axis, Batch};

/// Arguments of `slew sweep`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
KEY=START:STOP:COUNT gives COUNT values at equal distances, with both ends. KEY=A,B,C lists the values;
each may be anything that the key accepts: `end.angular_velocity_deg_s=[0,0,0],[0,0,1]`.

Several --over make all combinations. The first key changes slowest, the last fastest, and cases
are numbered from 1 in that order. Every case has a cold start, like `slew plan`: no result depends on
its neighbours.

`slew batch --help` describes results, interrupted runs, shards and exit codes.

Examples:
  slew sweep maneuver.toml --over maneuver.duration_s=20:200:37 -o sweep.jsonl
  slew sweep maneuver.toml --over maneuver.duration_s=20:60:9 --over actuators.torque_limit_n_m=0.1,0.2,0.4")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    /// A key of the spec and its values, START:STOP:COUNT or A,B,C; may be repeated
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub over: Vec<String>,
    #[command(flatten)]
    pub running: Running,
}

/// Runs `slew sweep` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let SpecArgs { spec, reading } = &args.spec;
    let axes = args.over.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let batch = Batch::of_grid(base(spec, reading)?, axes)?;
    let over: String = args.over.iter().map(|text| format!(" --over {}", word(text))).collect();
    let command = format!("slew sweep {}{over}", word(&spec.to_string_lossy()));
    conduct(&batch, &Asked { command, spec, cases: None, reading }, &args.running, console)
}
