//! `slew verify`: verifies a plan file with the witnesses only, against the spec in the file or
//! against another spec.

mod sequence;

use super::spec_file::PlanOrAttitudes;
use super::{
    Console, Exit, Failure, Lines, Message, Reading, ReportArgs, Tone, interrupt, spec_file, summary,
};
use slewkit::numerics::figures::{scientific, significant, told_apart};
use slewkit::plan::Status;
use slewkit::verify::{Check, DEFAULT_ACCURACY_DEG};
use slewkit_files::exchange::{Attitudes, judge_file, read_attitudes};
use slewkit_files::export::{ExportError, Judgement, PlanFile};
use slewkit_files::spec::{Difference, Loaded, Spec, escape};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Arguments of `slew verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Plan file from `slew plan SPEC -o PLAN.json`; or with --spec an AEM or a table of
    /// attitudes, for which slew judges ends, cones and rates. `-` reads stdin
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

/// Runs `slew verify` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let inputs: Vec<&Path> = std::iter::once(&args.plan).chain(&args.spec).map(PathBuf::as_path).collect();
    spec_file::one_stdin(&inputs)?;
    let unusable = |error| Failure::unusable(&args.plan, &error);
    let read = |path| spec_file::read_planned(path, &args.reading, console);
    let given = args.spec.as_deref().map(read).transpose()?;
    let opened = spec_file::open_plan_or_attitudes(&args.plan)?;
    if let PlanOrAttitudes::Sequence(input) = opened {
        return sequence::run(args, given, input, console);
    }
    let given = match given {
        Some(Spec::Maneuver(loaded)) => Some(*loaded),
        Some(_) => return Err(spec_file::refuse_stops()),
        None => None,
    };
    let input = match opened {
        PlanOrAttitudes::Plan(input) | PlanOrAttitudes::Sequence(input) => input,
        PlanOrAttitudes::Attitudes(input) => return attitudes(args, given, input, console),
    };
    let plan = PlanFile::read(input).map_err(unusable)?;
    // The plan is verified against the given spec or, if none is given, against the spec in the
    // file.
    let Loaded { problem, settings, identity, closed_loop, .. } = match (given, &plan.spec) {
        (Some(given), _) => given,
        (None, Some(held)) => spec_file::read_held(held, &args.plan, &args.reading, console)?,
        (None, None) => return Err(unusable(ExportError::NoSpec)),
    };
    interrupt::watch();
    let judged = plan.judge(&problem, &settings, &identity, &closed_loop, &interrupt::requested);
    let Judgement { problem, verification, differences, recorded, not_judged } =
        judged.map_err(|error| misfit(args, &error))?;
    let (exit, verdict, tone) = if verification.passed() {
        (Exit::Solved, "verified", Tone::Good)
    } else if verification.was_stopped() {
        (Exit::Plan(Status::Interrupted), "interrupted", Tone::Note)
    } else {
        (Exit::Plan(Status::VerificationFailed), "verification failed", Tone::Bad)
    };
    let mut lines = vec![summary::headline(console, &problem.name, verdict, tone)];
    // The summary shows the active limits that the witnesses find, not those that are recorded.
    let trajectory = &plan.trajectory.0;
    let judged = summary::Judged { problem: &problem, identity: &identity, trajectory, active: None };
    lines.extend(summary::verified(console, &judged, &verification));
    for difference in &differences {
        lines.line("differs", difference.to_string());
    }
    for Difference { key, first, second } in &recorded {
        lines.line("recorded", escape(&format!("{key}: {first} in the file, {second} found")));
    }
    lines.lines("not judged", not_judged.iter().map(|text| escape(text)));
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: exit.status(),
        exit_code: exit.code(),
        name: &problem.name,
        steps: problem.steps,
        verified: &verification,
        // Keys whose values differ between the spec in the file and the given spec. In each
        // difference, the value in the file is first.
        differences: &differences,
        // Recorded values that differ from the results of the witnesses. In each difference, the
        // recorded value is first.
        recorded: &recorded,
        not_judged: &not_judged,
    })?;
    Ok(exit)
}

/// Verifies an attitude file, which contains no torques.
fn attitudes(
    args: &Args,
    given: Option<Loaded>,
    input: Box<dyn Read>,
    console: &mut Console,
) -> Result<Exit, Failure> {
    let Some(Loaded { problem, settings, identity, .. }) = given else {
        let name = escape(&args.plan.to_string_lossy());
        let reason = format!(
            "{name} is not a plan file; if it is a table of attitudes, it has no targets and limits: give \
            the spec with --spec"
        );
        return Err(Failure::Usage(reason));
    };
    let name = args.plan.to_string_lossy();
    let found = read_attitudes(input, &name)?;
    for warning in &found.warnings {
        console.say(&warning.render(console.colour));
    }
    let tolerance = settings.continuous_tolerance.unwrap_or(DEFAULT_ACCURACY_DEG.to_radians());
    let judged = judge_file(&found, &name, &problem, &identity, tolerance)?;
    let rows = &judged.attitudes;
    let (exit, verdict, tone) = if judged.passed() {
        (Exit::Solved, "attitudes agree with the spec", Tone::Good)
    } else {
        (Exit::Plan(Status::VerificationFailed), "attitudes do not agree", Tone::Bad)
    };
    let mut lines = vec![summary::headline(console, &problem.name, verdict, tone)];
    for check in &rows.checks {
        lines.line("", told(check, &found, &name));
    }
    let violated = rows.violations.iter().zip(&rows.violated_at);
    lines.lines(
        "violated",
        violated.map(|(text, row)| format!("{} ({}:{})", escape(text), escape(&name), found.line[*row])),
    );
    lines.lines("not judged", judged.not_judged.iter().map(|text| escape(text)));
    let needs = [(rows.peak_torque_n_m, "rates"), (rows.peak_torque_of_attitudes_n_m, "attitudes")];
    let needs = needs.into_iter().filter_map(|(peak, of)| {
        Some(format!("a mean torque of at most {} N·m between rows, from the {of}", significant(peak?, 3)))
    });
    lines.lines("needs", needs);
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: exit.status(),
        exit_code: exit.code(),
        name: &problem.name,
        rows: found.time.len(),
        checks: &rows.checks,
        violations: &rows.violations,
        not_judged: &judged.not_judged,
        peak_torque_n_m: rows.peak_torque_n_m,
        peak_torque_of_attitudes_n_m: rows.peak_torque_of_attitudes_n_m,
    })?;
    Ok(exit)
}

/// Describes the result of a check of an attitude file, with the line of the file to which it
/// refers.
fn told(check: &Check, found: &Attitudes, file: &str) -> String {
    let Check { name, value, limit, passed } = check;
    let unit = match name.as_str() {
        "duration" => ", relative",
        "moment of the start" => " s",
        name if name.starts_with("rate at") => " rad/s",
        _ => " rad",
    };
    let failed = if *passed { "" } else { "failed: " };
    let [value_text, limit_text] = told_apart([*value, *limit], 1, scientific);
    let mut text = format!("{failed}{name} off by {value_text}{unit}, at most {limit_text}");
    let line = if name.ends_with("start") {
        found.line.first()
    } else {
        found.line.last().filter(|_| name == "duration" || name.ends_with("end"))
    };
    if let (false, Some(line)) = (*passed, line) {
        text.push_str(&format!(" ({}:{line})", escape(file)));
    }
    if !passed && found.rounding.attitude > *limit && name.starts_with("attitude") {
        text.push_str("; the digits of the file allow more");
    }
    text
}

/// Creates the failure that the lengths of the arrays of a plan do not fit the maneuver of the
/// spec.
fn misfit(args: &Args, error: &ExportError) -> Failure {
    match Failure::unusable(&args.plan, error) {
        Failure::File(Message { code: code @ "E0103", reason, remedy }) => {
            let misfits = !matches!(error, ExportError::NoMotion);
            let remedy = if misfits { "give the spec of the plan".into() } else { remedy };
            let message = Message::new(code, reason, remedy);
            Failure::Plan(Status::VerificationFailed, message)
        }
        other => other,
    }
}
