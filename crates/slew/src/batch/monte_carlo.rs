//! `slew monte-carlo`: plans a maneuver for random draws of its uncertain quantities.

use super::{Asked, Running, base, conduct};
use crate::advice::word;
use crate::{Console, Exit, Failure, SpecArgs};
use slewkit_files::batch::Batch;

/// Arguments of `slew monte-carlo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The spec states the distributions about its own values:

  [dispersion]
  seed = 1
  cases = 1000

  [[dispersion.vary]]
  key = \"body.inertia_kg_m2\"               # normal: sigma, sigma_relative or covariance
  kind = \"normal\"
  sigma_relative = 0.02

  [[dispersion.vary]]
  key = \"actuators.torque_limit_n_m\"       # uniform: half_width or half_width_relative
  kind = \"uniform\"
  half_width_relative = 0.1

  [[dispersion.vary]]
  key = \"start.angular_velocity_deg_s\"     # uniform within an ellipsoid: semi_axes
  kind = \"ellipsoid\"
  semi_axes = [0.1, 0.1, 0.02]

  [[dispersion.vary]]
  key = \"end.attitude.rotation_vector_deg\" # R exp(d), d in body axes, for every notation of R
  kind = \"normal\"
  sigma = [0.05, 0.05, 0.2]

Numbers are in the unit of the key. The random numbers of a case depend only on the seed, the number
of the case and the place of the entry. A draw that is not a valid spec, such as an impossible inertia,
is a failed case: slew counts it with its error and does not draw it again.

`slew batch --help` describes results, interrupted runs, shards and exit codes.

Examples:
  slew monte-carlo maneuver.toml -o results.jsonl
  slew monte-carlo maneuver.toml --set dispersion.cases=100000 -o part3.jsonl --shard 3/40
  slew monte-carlo maneuver.toml --case 17 -o plan.json")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub running: Running,
}

/// Runs `slew monte-carlo` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let SpecArgs { spec, reading } = &args.spec;
    let batch = Batch::of_dispersion(base(spec, reading)?)?;
    let command = format!("slew monte-carlo {}", word(&spec.to_string_lossy()));
    conduct(&batch, &Asked { command, spec, cases: None, reading }, &args.running, console)
}
