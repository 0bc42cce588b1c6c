//! `slew verify`: a plan file against the spec that it holds, or another, by the witnesses alone.

use super::spec_file::PlanOrAttitudes;
use super::{
    Console, Exit, Failure, Lines, Message, Reading, ReportArgs, Tone, interrupt, spec_file, summary,
};
use slewkit::numerics::figures::{error, significant};
use slewkit::plan::Status;
use slewkit::verify::{DEFAULT_ACCURACY_DEG, judge_attitudes};
use slewkit_files::exchange::read_attitudes;
use slewkit_files::export::{ExportError, Judgement, PlanFile};
use slewkit_files::spec::{Difference, Loaded, escape};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Arguments of `slew verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Plan file, as `slew plan SPEC -o PLAN.json` wrote it; or with --spec an AEM or a table of attitudes, of which
    /// ends, cones and rates are judged. `-` reads stdin
    #[arg(value_name = "FILE")]
    pub plan: PathBuf,
    /// The spec that the plan must fulfil, instead of the one that it holds; `-` reads stdin
    #[arg(long)]
    pub spec: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// What a plan file tells beside that, which no witness of a motion can judge.
const NOT_JUDGED: &str = "whether the plan is optimal (conjugate points, costates, rivals) and how it was found: `slew plan` finds that again";

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let inputs: Vec<&Path> = std::iter::once(&args.plan).chain(&args.spec).map(PathBuf::as_path).collect();
    spec_file::one_stdin(&inputs)?;
    let unusable = |error| Failure::unusable(&args.plan, &error);
    let given = args.spec.as_deref().map(|path| spec_file::read(path, &args.reading, console)).transpose()?;
    let input = match spec_file::open_plan_or_attitudes(&args.plan)? {
        PlanOrAttitudes::Plan(input) => input,
        PlanOrAttitudes::Attitudes(input) => return attitudes(args, given, input, console),
    };
    let plan = PlanFile::read(input).map_err(unusable)?;
    // What the plan must achieve stands in the spec that is given, else in its own.
    let Loaded { problem, settings, identity, .. } = match (given, &plan.spec) {
        (Some(given), _) => given,
        (None, Some(held)) => spec_file::read_held(held, &args.plan, &args.reading, console)?,
        (None, None) => return Err(unusable(ExportError::NoSpec)),
    };
    interrupt::watch();
    let judged = plan.judge(&problem, &settings, &interrupt::requested);
    let Judgement { problem, verification, differences } = judged.map_err(|error| misfit(args, &error))?;
    let (exit, verdict, tone) = if verification.passed() {
        (Exit::Solved, "verified", Tone::Good)
    } else if verification.was_stopped() {
        (Exit::Plan(Status::Interrupted), "interrupted", Tone::Note)
    } else {
        (Exit::Plan(Status::VerificationFailed), "verification failed", Tone::Bad)
    };
    let mut lines = vec![summary::headline(console, &problem.name, verdict, tone)];
    // Which limits act the witnesses see by themselves.
    let trajectory = &plan.trajectory.0;
    let judged = summary::Judged { problem: &problem, identity: &identity, trajectory, active: None };
    lines.extend(summary::verified(console, &judged, &verification));
    for difference in &differences {
        let Difference { key, first, second } = difference;
        lines.line("differs", format!("{key}: {first} in the plan, {second} in the spec"));
    }
    lines.line("not judged", NOT_JUDGED);
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

/// Judges attitudes alone.
fn attitudes(
    args: &Args,
    given: Option<Loaded>,
    input: Box<dyn Read>,
    console: &mut Console,
) -> Result<Exit, Failure> {
    let Some(Loaded { problem, settings, .. }) = given else {
        let reason = "attitudes do not say what they must achieve: give the spec with --spec";
        return Err(Failure::Usage(reason.into()));
    };
    let found = read_attitudes(input, &args.plan.to_string_lossy())?;
    let tolerance = settings.continuous_tolerance.unwrap_or(DEFAULT_ACCURACY_DEG.to_radians());
    let judged = judge_attitudes(&problem, &found.time, &found.quaternion, &found.rate, tolerance);
    let (exit, verdict, tone) = if judged.passed() {
        (Exit::Solved, "attitudes agree with the spec", Tone::Good)
    } else {
        (Exit::Plan(Status::VerificationFailed), "attitudes do not agree", Tone::Bad)
    };
    let mut lines = vec![summary::headline(console, &problem.name, verdict, tone)];
    for check in &judged.checks {
        let state = if check.passed { "" } else { "failed: " };
        let (value, limit) = (error(check.value), error(check.limit));
        let unit = if check.name.starts_with("rate") {
            " rad/s"
        } else if check.name == "duration" {
            ", relative"
        } else {
            " rad"
        };
        lines.line("", format!("{state}{} off by {value}{unit}, at most {limit}", check.name));
    }
    lines.lines("violated", judged.violations.iter().map(|text| escape(text)));
    let rates = if found.rate.is_empty() { "rates, " } else { "" };
    lines.line(
        "not judged",
        format!("{rates}inputs, their limits, cost and optimality: the file does not have them"),
    );
    if let Some(peak) = judged.peak_torque_n_m {
        lines.line("needs", format!("a mean torque between rows of at most {} N·m", significant(peak, 3)));
    }
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: exit.status(),
        exit_code: exit.code(),
        name: &problem.name,
        rows: found.time.len(),
        checks: &judged.checks,
        violations: &judged.violations,
        peak_torque_n_m: judged.peak_torque_n_m,
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
