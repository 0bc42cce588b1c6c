//! `slew plan`: solve, verify, tell, write.

use super::console;
use super::{
    Console, Destination, Exit, Failure, Format, Message, OutputArgs, SpecArgs, interrupt, spec_file, summary,
};
use slewkit::files::export::{ExportError, PlanFile, Target, read_guess, write_csv, write_jsonl};
use slewkit::files::spec::Loaded;
use slewkit::maneuver::{Problem, ProblemError, Settings};
use slewkit::plan::{self, Control, Guess, Observer, Plan, PlanError, Progress, Status};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `slew plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  slew plan maneuver.toml -o plan.json
  slew plan maneuver.toml --set maneuver.duration_s=90 --format json | jq .cost
  slew plan maneuver.toml --guess neighbour.json -o trajectory.csv")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Begin from another plan: its costates, or its path where limits act; `-` reads stdin
    #[arg(long, value_name = "PLAN.json")]
    pub guess: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let mut inputs: Vec<&Path> = vec![&args.spec.spec];
    inputs.extend(args.guess.as_deref());
    spec_file::one_stdin(&inputs)?;
    let destination = args.output.destination(&inputs)?;
    let Loaded { problem, settings, .. } = spec_file::read(&args.spec.spec, &args.spec.reading, console)?;
    let guess = args.guess.as_deref().map(|path| guess(path, &problem)).transpose()?;

    interrupt::watch();
    let plan = plan::plan(&problem, &settings, guess.as_ref(), &mut Watcher(console)).map_err(refusal)?;

    console.say(&summary::plan(console, &args.spec, &problem, &settings, &plan));
    match &destination {
        Destination::None => {}
        Destination::Stdout(format) => {
            console::to_stdout(|output| write(*format, &problem, &settings, &plan, output))?;
        }
        Destination::File(target, format) => {
            target.write(|output| write(*format, &problem, &settings, &plan, output))?;
            wrote(console, target);
        }
    }
    Ok(match plan.status {
        Status::Solved => Exit::Solved,
        status => Exit::Plan(status),
    })
}

/// The closing line of a summary.
pub fn wrote(console: &mut Console, target: &Target) {
    console.say(&summary::line("wrote", &slewkit::files::spec::escape(&target.path().to_string_lossy())));
}

fn write(
    format: Format,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    output: &mut dyn Write,
) -> Result<(), ExportError> {
    match format {
        Format::Jsonl => write_jsonl(&plan.solution.trajectory, output),
        Format::Csv => write_csv(&plan.solution.trajectory, output),
        Format::Json | Format::Text => PlanFile::new(problem, settings, plan).write(output),
    }
}

fn guess(path: &Path, problem: &Problem) -> Result<Guess, Failure> {
    let guess = read_guess(spec_file::open_plan(path)?).map_err(|error| Failure::unusable(path, &error))?;
    let (found, needed) = (guess.costates.len(), problem.dimension());
    if found != needed {
        let reason = format!("the guess has {found} costates, this maneuver needs {needed}");
        let remedy =
            "give a plan of the same kind of maneuver: 6 costates for an attitude, 12 with positions";
        return Err(Failure::File(Message::new("E0103", reason, remedy)));
    }
    Ok(guess)
}

/// Why the planner did not even begin.
pub fn refusal(error: PlanError) -> Failure {
    match error {
        PlanError::Problem(error) => invalid(error),
        other => Failure::Problem(Message::new("E0121", other.to_string(), "change the spec accordingly")),
    }
}

/// A spec that reads well and asks what cannot be.
pub fn invalid(error: ProblemError) -> Failure {
    let (code, remedy) = match &error {
        ProblemError::StepTooLong { steps, .. } => {
            ("E0120", format!("raise `maneuver.steps` to {steps} or more"))
        }
        _ => ("E0121", "change the spec accordingly".into()),
    };
    Failure::Problem(Message::new(code, error.to_string(), remedy))
}

/// Shows progress and listens to Ctrl-C.
pub struct Watcher<'a>(pub &'a mut Console);

impl Observer for Watcher<'_> {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        let Progress { rung, start, steps, elapsed, .. } = progress;
        self.0.progress(|| format!("  {elapsed:.1} s  {rung}, start {start}, {steps} steps"));
        if interrupt::requested() { Control::Stop } else { Control::Continue }
    }
}
