//! `slew check`: the spec alone, all errors at once.

use super::args::{ReportArgs, SpecArgs};
use super::console::{self, Console, Tone};
use super::failure::{Exit, Failure};
use super::number::{counted, significant};
use super::{spec_file, summary};
use serde::Serialize;
use slewkit::actuation::{Actuation, Channel, Limits};
use slewkit::export::write_document;
use slewkit::problem::Motion;
use slewkit::spec::{Diagnostic, Loaded, escape};

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
    inputs: usize,
    wheels: usize,
    limits: &'a [String],
    constraints: Vec<&'a str>,
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
    let inputs = problem.actuation.count();
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let of_wheels = if wheels > 0 { ", each the torque of a reaction wheel" } else { "" };
    let mut lines = vec![
        summary::headline(console, &problem.name, &verdict, tone),
        summary::line("maneuver", &format!("{moves}, {duration} s in {} steps of {step} s", problem.steps)),
        summary::line("inputs", &format!("{inputs}{of_wheels}")),
    ];
    let limits = limits(&problem.actuation);
    let constraints: Vec<&str> =
        problem.constraints.iter().map(|constraint| constraint.name.as_str()).collect();
    if !limits.is_empty() {
        lines.push(summary::line("limits", &limits.join(", ")));
    }
    if !constraints.is_empty() {
        lines.push(summary::line("constraints", &escape(&listed(&constraints))));
    }
    console.say(&lines.join("\n"));
    if args.report.json() {
        let report = Report {
            status: "valid",
            exit_code: 0,
            name: &problem.name,
            steps: problem.steps,
            step_s: problem.step(),
            duration_s: problem.duration,
            inputs,
            wheels,
            limits: &limits,
            constraints,
            diagnostics: &warnings,
        };
        console::to_stdout(|output| write_document(&report, output))?;
    }
    Ok(Exit::Solved)
}

/// Names that a line shows.
const SHOWN: usize = 6;

fn listed(names: &[&str]) -> String {
    let more = if names.len() > SHOWN { format!(", … {} in all", names.len()) } else { String::new() };
    format!("{}{more}", names[..names.len().min(SHOWN)].join(", "))
}

/// The limits of the actuators, by the names that reports use.
fn limits(actuation: &Actuation) -> Vec<String> {
    let of = |channel: &Channel, what: &str, wheels: bool| {
        let Limits { size, norm, rate } = channel.limits();
        let name = |given: bool, limit: &str| given.then(|| format!("{what} {limit}"));
        let of_wheels = if wheels { "wheel " } else { "" };
        let size = name(size.is_some(), "limit").map(|name| format!("{of_wheels}{name}"));
        [size, name(norm.is_some(), "norm limit"), name(rate.is_some(), "rate limit")]
    };
    let momentum =
        actuation.wheels.as_ref().map(|wheels| wheels.momentum_limit.iter().any(|limit| limit.is_finite()));
    let force = actuation.force.as_ref().map(|channel| of(channel, "force", false));
    let torque = of(&actuation.torque, "torque", actuation.wheels.is_some());
    let momentum = momentum.unwrap_or(false).then(|| "wheel momentum limit".to_string());
    torque.into_iter().chain(force.into_iter().flatten()).flatten().chain(momentum).collect()
}
