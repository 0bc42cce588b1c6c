//! `slew check`: the spec alone, all errors at once.

use super::args::{ReportArgs, SpecArgs};
use super::console::{self, Console, Tone};
use super::failure::{Exit, Failure};
use super::number::{counted, significant};
use super::{spec_file, summary};
use serde::Serialize;
use slewkit::export::write_document;
use slewkit::problem::Motion;
use slewkit::spec::{Diagnostic, Loaded};

/// Arguments of `slew check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

#[derive(Serialize)]
struct Report<'a> {
    status: &'static str,
    exit_code: u8,
    name: &'a str,
    steps: usize,
    step_s: f64,
    duration_s: f64,
    diagnostics: &'a [Diagnostic],
}

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let Loaded { problem, warnings, .. } = spec_file::read(&args.spec.spec, &args.spec.reading, console)?;
    problem.check().map_err(super::plan::invalid)?;
    let verdict = match warnings.len() {
        0 => "valid".into(),
        count => format!("valid, {}", counted(count, "warning")),
    };
    let tone = if warnings.is_empty() { Tone::Good } else { Tone::Note };
    let moves = match problem.motion {
        Motion::Attitude => "attitude",
        Motion::RigidBody => "position and attitude",
    };
    let (duration, step) = (significant(problem.duration, 4), significant(problem.step(), 3));
    let lines = [
        summary::headline(console, &problem.name, &verdict, tone),
        summary::line("maneuver", &format!("{moves}, {duration} s in {} steps of {step} s", problem.steps)),
        summary::line("inputs", &problem.actuation.count().to_string()),
    ];
    console.say(&lines.join("\n"));
    if args.report.json() {
        let report = Report {
            status: "valid",
            exit_code: 0,
            name: &problem.name,
            steps: problem.steps,
            step_s: problem.step(),
            duration_s: problem.duration,
            diagnostics: &warnings,
        };
        console::to_stdout(|output| write_document(&report, output))?;
    }
    Ok(Exit::Solved)
}
