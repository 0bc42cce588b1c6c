//! `slew verify` for the plan of a sequence.

use super::super::{Console, Exit, Failure, Lines, Tone, interrupt, spec_file, summary};
use super::{Args, misfit};
use slewkit::numerics::figures::{counted, scientific, told_apart};
use slewkit::plan::Status;
use slewkit::verify::Check;
use slewkit_files::export::{ExportError, SequenceFile, SequenceJudgement};
use slewkit_files::spec::{Spec, escape};
use std::io::Read;

/// Verifies the plan of each leg, and the transitions between legs: states, holds and windows.
pub(super) fn run(
    args: &Args,
    given: Option<Spec>,
    input: Box<dyn Read>,
    console: &mut Console,
) -> Result<Exit, Failure> {
    let unusable = |error| Failure::unusable(&args.plan, &error);
    let file = SequenceFile::read(input).map_err(unusable)?;
    let loaded = match (given, &file.record.spec) {
        (Some(Spec::Sequence(loaded)), _) => *loaded,
        (Some(_), _) => return Err(spec_file::without_stops()),
        (None, Some(held)) => spec_file::read_held_sequence(held, &args.plan, &args.reading, console)?,
        (None, None) => return Err(unusable(ExportError::NoSpec)),
    };
    interrupt::watch();
    let judged = file.judge(&loaded, &interrupt::requested).map_err(|error| misfit(args, &error))?;
    let (exit, verdict, tone) = if judged.passed() {
        (Exit::Solved, "verified", Tone::Good)
    } else if judged.was_stopped() {
        (Exit::Plan(Status::Interrupted), "interrupted", Tone::Note)
    } else {
        (Exit::Plan(Status::VerificationFailed), "verification failed", Tone::Bad)
    };
    let SequenceJudgement { legs, holds, checks } = &judged;
    let mut lines = vec![summary::headline(console, &loaded.sequence.craft.name, verdict, tone)];
    let passed = legs.iter().filter(|leg| leg.verification.passed()).count();
    lines
        .line("legs", format!("{} of {} verified by the witnesses", passed, counted(file.legs.len(), "leg")));
    let held = checks.iter().filter(|check| check.passed).count();
    lines.line(
        "joins",
        format!("{held} of {} hold: ends, stops, holds, windows, records", counted(checks.len(), "check")),
    );
    if !holds.is_empty() {
        let passed = holds.iter().filter(|(_, hold)| hold.verification.passed()).count();
        let told = format!("{passed} of {} verified by the witnesses", counted(holds.len(), "hold"));
        lines.line("holds", told);
    }
    let parts = legs
        .iter()
        .zip(&file.record.stops)
        .map(|(leg, stop)| (format!("leg to {}", escape(&stop.name)), leg))
        .chain(holds.iter().map(|(name, hold)| (format!("hold at {}", escape(name)), hold)));
    for (part, found) in parts {
        let failed = found.verification.checks.iter().filter(|check| !check.passed);
        lines.lines("failed", failed.map(|check| format!("{part}: {}", told(check))));
        let violated = found.verification.margins.iter().filter(|margin| !margin.holds());
        lines.lines("violated", violated.map(|margin| format!("{part}: {}", escape(&margin.name))));
        for difference in &found.differences {
            lines.line("differs", format!("{part}: {difference}"));
        }
    }
    lines.lines("failed", checks.iter().filter(|check| !check.passed).map(told));
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: exit.status(),
        exit_code: exit.code(),
        name: &loaded.sequence.craft.name,
        legs: legs.iter().map(|leg| &leg.verification).collect::<Vec<_>>(),
        holds: holds.iter().map(|(_, hold)| &hold.verification).collect::<Vec<_>>(),
        checks: checks,
    })?;
    Ok(exit)
}

/// Describes a check that failed.
fn told(check: &Check) -> String {
    let [value, limit] = told_apart([check.value, check.limit], 2, scientific);
    format!("{}: {value}, at most {limit}", escape(&check.name))
}
