//! `slew convert`: prints one attitude in all notations.

use super::console;
use super::{Console, Exit, Failure, ReportArgs};
use serde_json::{Map, Value};
use slewkit_files::export::{ExportError, Notations, write_document};
use slewkit_files::spec::{self, Diagnostics, Format, Override};
use std::io::Read;

/// Arguments of `slew convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  slew convert 'euler_zyx_deg = [0, 0, 150]'
  slew convert 'axis = [0, 0, 1], angle_deg = 90' --format json
  slew convert 'matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]'

R maps body vectors to reference-frame vectors. Euler angles are intrinsic: zyx is R = Rz Ry Rx.
Quaternions are Hamilton. q and -q are one attitude; slew prints the one with a nonnegative scalar.")]
pub struct Args {
    /// The attitude as in a spec, quoted; `-` reads stdin
    #[arg(value_name = "ATTITUDE", required = true)]
    pub attitude: Vec<String>,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// Runs `slew convert` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let mut text = args.attitude.join(" ");
    if text == "-" {
        text.clear();
        let limit = spec::MAX_BYTES as u64;
        std::io::stdin()
            .lock()
            .take(limit)
            .read_to_string(&mut text)
            .map_err(|error| Failure::unreadable("stdin".as_ref(), &error))?;
    }
    let notations = Notations::from(&read(&text, console)?);
    console::to_stdout(|output| {
        if args.report.json() {
            return write_document(&notations, output);
        }
        // Each printed line can be pasted into a spec.
        let tree: Map<String, Value> = serde_json::to_value(&notations)
            .and_then(serde_json::from_value)
            .map_err(|error| ExportError::Io(error.into()))?;
        let mut lines: Vec<_> = tree.iter().collect();
        lines.sort_by_key(|(key, _)| (key.starts_with("euler"), *key));
        for (key, value) in lines {
            writeln!(output, "{key} = {}", value.to_string().replace(',', ", "))?;
        }
        Ok(())
    })?;
    Ok(Exit::Solved)
}

/// Keys that complete a spec with a given start attitude to a valid spec.
const REST: [&str; 4] = [
    "format=1",
    "body.inertia_kg_m2=[1, 1, 1]",
    "end.attitude.quaternion_wxyz=[1, 0, 0, 0]",
    "maneuver.duration_s=1",
];

/// Number of the line that contains the attitude in the spec that `read` builds.
const LINE: usize = 2;

/// Reads an attitude by means of a spec in which it is the start attitude. The notations, checks
/// and messages are therefore those of specs.
fn read(text: &str, console: &mut Console) -> Result<slewkit::Matrix3, Failure> {
    let text = text.trim();
    let text = text.strip_prefix("attitude").map_or(text, |rest| rest.trim_start().trim_start_matches('='));
    let text = text.trim();
    let inner = text.strip_prefix('{').and_then(|text| text.strip_suffix('}')).unwrap_or(text).trim();
    let spec = format!("[start]\nattitude = {{ {inner} }}\n");
    let rest = REST.iter().flat_map(|text| Override::parse(text)).collect::<Vec<_>>();
    let shift = |mut diagnostics: Diagnostics| {
        for diagnostic in &mut diagnostics.0 {
            diagnostic.line = diagnostic.line.saturating_sub(LINE - 1).max(1);
        }
        diagnostics
    };
    let loaded = spec::from_str(&spec, "attitude", Format::Toml, &rest).map_err(shift)?;
    for warning in shift(Diagnostics(loaded.warnings)).0 {
        // W0059 warns that the start and the end are equal, which is meaningless without a
        // maneuver.
        if warning.code != "W0059" {
            console.say(&warning.render(console.colour));
        }
    }
    Ok(loaded.problem.start.attitude)
}
