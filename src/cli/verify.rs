//! `slew verify`: a plan file against the spec that it holds, or another, by the witnesses alone.

use super::{
    Console, Exit, Failure, Lines, Message, Reading, ReportArgs, Tone, interrupt, spec_file, summary,
};
use slewkit::files::export::{ExportError, PlanFile};
use slewkit::files::spec::{Difference, Loaded, SpecDocument};
use slewkit::plan::Status;
use slewkit::verify::{self, Check};
use std::path::{Path, PathBuf};

/// Arguments of `slew verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; `-` reads stdin
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// The spec that the plan must fulfil, instead of the one that it holds; `-` reads stdin
    #[arg(long)]
    pub spec: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// Relative error that a recorded cost may have: that of sums in another order.
const RECORDED_COST: f64 = 1e-9;

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let inputs: Vec<&Path> = std::iter::once(&args.plan).chain(&args.spec).map(PathBuf::as_path).collect();
    spec_file::one_stdin(&inputs)?;
    let unusable = |error| Failure::unusable(&args.plan, &error);
    let given = args.spec.as_deref().map(|path| spec_file::read(path, &args.reading, console)).transpose()?;
    let plan = PlanFile::read(spec_file::open_plan(&args.plan)?).map_err(unusable)?;
    let held = plan.spec.as_ref();
    // What the plan must achieve stands in the spec that is given, else in its own.
    let Loaded { problem, settings, .. } = match (given, held) {
        (Some(given), _) => given,
        (None, Some(held)) => spec_file::read_held(held, &args.plan, &args.reading, console)?,
        (None, None) => return Err(unusable(ExportError::NoSpec)),
    };
    // The grid is the plan's own matter.
    let problem = plan.on_grid(&problem).map_err(|error| misfit(args, &error))?;
    let judged_by = SpecDocument::new(&problem, &settings).ok();
    let differences = held.zip(judged_by).map_or(Vec::new(), |(held, other)| held.differences(&other));
    let (trajectory, tolerance) = (&plan.trajectory.0, settings.tolerance);
    interrupt::watch();
    let continuous = settings.continuous_tolerance;
    let mut verification =
        verify::verify_until(&problem, trajectory, tolerance, continuous, &interrupt::requested);
    let cost = verify::effort(&problem, &trajectory.input);
    let value = (plan.cost - cost).abs() / cost.abs().max(f64::MIN_POSITIVE);
    verification.checks.push(Check {
        name: "recorded cost".into(),
        value,
        limit: RECORDED_COST,
        passed: value <= RECORDED_COST,
    });
    let (exit, verdict, tone) = if verification.passed() {
        (Exit::Solved, "verified", Tone::Good)
    } else if verification.was_stopped() {
        (Exit::Plan(Status::Interrupted), "interrupted", Tone::Note)
    } else {
        (Exit::Plan(Status::VerificationFailed), "verification failed", Tone::Bad)
    };
    let mut lines = vec![summary::headline(console, &problem.name, verdict, tone)];
    // Which limits act the witnesses see by themselves.
    let judged = summary::Judged { problem: &problem, trajectory, active: None };
    lines.extend(summary::verified(console, &judged, &verification));
    for difference in &differences {
        let Difference { key, first, second } = difference;
        lines.line("differs", format!("{key}: {first} in the plan, {second} in the spec"));
    }
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: exit.status(),
        exit_code: exit.code(),
        name: &problem.name,
        steps: problem.steps,
        verified: &verification,
        // Where the spec that the plan holds is not the one that it is judged by: plan first.
        differences: &differences,
    })?;
    Ok(exit)
}

/// A plan whose arrays do not fit the maneuver of the spec has failed.
fn misfit(args: &Args, error: &ExportError) -> Failure {
    match Failure::unusable(&args.plan, error) {
        Failure::File(Message { code: code @ "E0103", reason, .. }) => {
            let message = Message::new(code, reason, "give the spec that the plan was made from");
            Failure::Plan(Status::VerificationFailed, message)
        }
        other => other,
    }
}
