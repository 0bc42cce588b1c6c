//! `slew check`: the spec alone, all errors at once.

use super::args::{ReportArgs, SpecArgs};
use super::console::{self, Console, Tone};
use super::failure::{Exit, Failure};
use super::number::{counted, significant};
use super::{spec_file, summary};
use serde::Serialize;
use slewkit::actuation::{Actuation, Channel, LimitKind, Limits};
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
    limits: &'a [&'static str],
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
fn limits(actuation: &Actuation) -> Vec<&'static str> {
    let mut names = Vec::new();
    let channels = [(Some(&actuation.torque), false), (actuation.force.as_ref(), true)];
    for (channel, of_force) in channels {
        let Some(Limits { size, norm, rate }) = channel.map(Channel::limits) else { continue };
        let given = [
            (size.is_some(), LimitKind::Size),
            (norm.is_some(), LimitKind::Norm),
            (rate.is_some(), LimitKind::Rate),
        ];
        let given = given.into_iter().filter(|(given, _)| *given);
        names.extend(given.map(|(_, kind)| actuation.limit_name(kind, of_force)));
    }
    let momenta = actuation.wheels.iter().flat_map(|wheels| &wheels.momentum_limit);
    if momenta.clone().any(|limit| limit.is_finite()) {
        names.push(actuation.limit_name(LimitKind::WheelMomentum, false));
    }
    names
}
