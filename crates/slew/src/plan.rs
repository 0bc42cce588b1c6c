//! `slew plan`: plans a maneuver, verifies the plan, reports it and writes it.

pub mod sequence;
mod warm;

use super::pictured::EULER;
use super::spec_file::PlanOrAttitudes;
use super::{
    Console, Exit, Failure, Format, Message, OutputArgs, SpecArgs, export, interrupt, memory, report,
    spec_file, summary,
};
use clap::ValueEnum;
use slewkit::assured::{self, Beside, Margins, NotKept, NotKnown};
use slewkit::feedback::Gains;
use slewkit::maneuver::{Outcome, Problem, ProblemError, Settings};
use slewkit::plan::{self, Control, Guess, Observer, Plan, PlanError, Progress, Status};
use slewkit_files::exchange::read_attitudes;
use slewkit_files::export::{ExportError, PlanFile, read_guess};
use slewkit_files::flown::{MarginsRecord, gains_alone, is_posed};
use slewkit_files::formats;
use slewkit_files::spec::{ClosedLoop, Loaded, Spec};
use slewkit_report::plan_page;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Arguments of `slew plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  slew plan maneuver.toml -o plan.json
  slew plan maneuver.toml --set maneuver.duration_s=90 --format json | jq .cost
  slew plan maneuver.toml -o plan.json --report report.html
  slew plan maneuver.toml --guess neighbour.json -o trajectory.csv
  slew plan measured.toml --warm plan.json --at 12.5 -o rest.json")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Also report how the plan was found: method, iterations, residuals, optimality, and the
    /// results of each witness
    #[arg(short, long)]
    pub verbose: bool,
    #[command(flatten)]
    pub tables: export::TableArgs,
    /// Search also from another plan: its costates, or its path if limits are active; or from the path
    /// of an AEM or a table of attitudes. The cheapest plan is the result, and the others are
    /// reported. `-` reads stdin
    #[arg(long, value_name = "FILE")]
    pub guess: Option<PathBuf>,
    /// Search from the costates of the guess alone, if they lead to a plan: quicker, but a cheaper
    /// plan may exist
    #[arg(long, requires = "guess")]
    pub guess_alone: bool,
    /// Replan the rest of a plan: from the start of SPEC, which is the state of the craft at the
    /// time --at of that plan, to the end of SPEC, in the remaining time and on the remaining
    /// steps. A few Newton steps usually suffice; otherwise a new search runs, and the summary
    /// reports it. `-` reads stdin
    #[arg(long, value_name = "PLAN.json", conflicts_with = "guess")]
    pub warm: Option<PathBuf>,
    /// Time of that plan at which the craft is at the start of SPEC, from its beginning; 0 by
    /// default
    #[arg(long, value_name = "SECONDS", requires = "warm", allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Show the plan as one page for a browser, as `slew report` does
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Name of the initial guess in a plan file if it is the plan given by `--guess`.
const GUESS: &str = "guess";
/// Note in the summary if the plan was found from the plan given by `--guess`.
const FROM_GUESS: &str = "found from the guess: the search without it found only plans with a higher cost";
/// Note in the summary if the plan was found with `--guess-alone`.
const FROM_GUESS_ALONE: &str =
    "found only from the guess, without a search: a plan without --guess-alone may cost less";

/// Runs `slew plan` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let mut inputs: Vec<&Path> = vec![&args.spec.spec];
    inputs.extend(args.guess.as_deref().or(args.warm.as_deref()));
    spec_file::one_stdin(&inputs)?;
    let destination = args.output.destination(Format::value_variants(), &inputs)?;
    let tables = args.tables.checked(&destination)?;
    let page =
        args.report.as_deref().map(|path| report::target(path, args.output.force, &inputs)).transpose()?;
    let loaded = match spec_file::read_planned(&args.spec.spec, &args.spec.reading, console)? {
        Spec::Maneuver(loaded) => *loaded,
        Spec::Sequence(loaded) => {
            return sequence::run(args, &loaded, (&destination, tables, page.as_ref()), console);
        }
        // `read_planned` returns an error for a simulation, so this case does not occur.
        Spec::Simulation(_) => return Err(Failure::Internal("a simulation has no plan".into())),
    };
    let Loaded { problem, settings, mut identity, closed_loop, files, .. } = loaded;
    destination.distinct_from(&files)?;
    if let Some(page) = &page {
        files.iter().try_for_each(|file| page.distinct_from(file))?;
    }
    // The format is checked before the search, so that a plan is not lost because data for its
    // output are missing.
    export::check(&destination, &problem, &identity)?;
    memory::check(&problem, &settings, console)?;
    let guess = args.guess.as_deref().map(|path| guess(path, &problem, console)).transpose()?;
    let guess = guess.map(|guess| if args.guess_alone { guess.alone() } else { guess });

    let from =
        args.warm.as_deref().map(|path| warm::begun(path, args.at, &problem, &mut identity)).transpose()?;

    interrupt::watch();
    let (problem, plan, margins, warm) = match &from {
        Some(from) => {
            let (problem, plan, warm) = from.plan(&problem, &settings, &mut Watcher(console))?;
            (problem, plan, None, warm.map(|told| ("warm", told)))
        }
        None => {
            let (problem, plan, margins) =
                planned(&problem, &settings, &closed_loop, guess.as_ref(), console)?;
            let guessed = guess.is_some() && plan.solution.start == GUESS;
            let told = if args.guess_alone { FROM_GUESS_ALONE } else { FROM_GUESS };
            (problem, plan, margins, guessed.then(|| ("guess", told.to_string())))
        }
    };

    let problem = plan.solution.on_grid(&problem);
    let beside = beside(&problem, &plan, &closed_loop, console);
    let gains = gains(&problem, &plan, &closed_loop, console);
    let format = destination.format().map(|format| format.of_data().unwrap_or(formats::Format::Json));
    let record = margins.as_ref().map(|margins| MarginsRecord::new(&closed_loop, margins));
    let told = summary::Told {
        problem: &problem,
        settings: &settings,
        plan: &plan,
        identity: &identity,
        verbose: args.verbose,
        file: destination.plan_file(),
        beside: beside.as_ref().map(|beside| (&closed_loop, beside)),
        margins: record.as_ref(),
        gains: gains.as_ref(),
        begun: warm.as_ref().map(|(label, told)| (*label, told.as_str())),
    };
    console.say(&summary::plan(console, &args.spec, &told));
    interrupt::writing();
    if plan.solution.outcome != Outcome::Converged && matches!(format, Some(formats::Format::Exchange(_))) {
        console.say(&summary::line("wrote", "no plan exists, and this format holds nothing else"));
    } else if let Some(format) = format {
        let file = PlanFile::new(&problem, &settings, &plan);
        let file = match &gains {
            Some(gains) => file.with_gains(&problem, gains, &closed_loop),
            None => file.with_beside(&problem, beside.as_ref(), &closed_loop, margins.as_ref()),
        };
        destination.write(console, |_, output| format.write(&file, &problem, &identity, tables, output))?;
    }
    if let Some(target) = &page {
        report::write(
            target,
            &plan_page(&problem, &settings, &plan, &identity, (&closed_loop, record.as_ref()), EULER),
            console,
        )?;
    }
    Ok(match plan.status {
        Status::Solved => Exit::Solved,
        status => Exit::Plan(status),
    })
}

/// Plans a maneuver. If the spec has chance constraints, also returns the margins that the plan
/// keeps for them.
fn planned(
    problem: &Problem,
    settings: &Settings,
    closed_loop: &ClosedLoop,
    guess: Option<&Guess>,
    console: &mut Console,
) -> Result<(Problem, Plan, Option<Margins>), Failure> {
    let Some((uncertainty, kept)) = closed_loop.kept() else {
        let plan = plan::plan(problem, settings, guess, &mut Watcher(console)).map_err(refusal)?;
        return Ok((problem.clone(), plan, None));
    };
    let feedback = closed_loop.feedback;
    let found = assured::plan(problem, settings, feedback, uncertainty, &kept, &mut Watcher(console));
    let (with, plan, margins) = found.map_err(|error| match error {
        NotKept::Plan(PlanError::Problem(error @ ProblemError::Violated { .. })) => {
            let reason = format!("{error}, with the margin that its chance requires");
            let remedy = "allow a larger chance, reduce the uncertainty, or give [feedback]";
            Failure::Problem(Message::new("E0172", reason, remedy))
        }
        NotKept::Plan(other) => refusal(other),
        other => {
            let remedy = "allow a larger chance or a larger limit, reduce the uncertainty, or reduce the \
                weights of the gains";
            Failure::Problem(Message::new("E0172", other.to_string(), remedy))
        }
    })?;
    Ok((with, plan, Some(margins)))
}

/// Computes the gains, covariances and probabilities of violation along a plan. Returns `None` if
/// the spec does not request them, if no plan exists, or after a warning that they cannot be
/// computed.
fn beside(problem: &Problem, plan: &Plan, closed_loop: &ClosedLoop, console: &mut Console) -> Option<Beside> {
    if !closed_loop.is_asked() || is_posed(problem) || plan.solution.outcome != Outcome::Converged {
        return None;
    }
    let uncertainty = closed_loop.uncertainty.as_ref();
    match Beside::along(problem, &plan.solution.trajectory, closed_loop.feedback, uncertainty) {
        Ok(beside) => Some(beside),
        Err(error) => unknown(&error, console),
    }
}

/// Computes the gains along a plan without covariances, either because the spec states no
/// uncertainty, or because covariances cannot be computed for this plan.
fn gains(problem: &Problem, plan: &Plan, closed_loop: &ClosedLoop, console: &mut Console) -> Option<Gains> {
    let converged = Some(&plan.solution).filter(|solution| solution.outcome == Outcome::Converged)?;
    gains_alone(problem, &converged.trajectory, closed_loop)?
        .map_or_else(|error| unknown(&error, console), Some)
}

/// Prints a warning with the reason why gains or covariances cannot be computed, and returns
/// `None`.
fn unknown<T>(error: &NotKnown, console: &mut Console) -> Option<T> {
    let reason = format!("no gains and no covariance for this plan: {error}");
    console.warn("W0171", &reason, "give [feedback] kind = \"tvlqr\", or larger limits");
    None
}

fn guess(path: &Path, problem: &Problem, console: &mut Console) -> Result<Guess, Failure> {
    let input = match spec_file::open_plan_or_attitudes(path)? {
        PlanOrAttitudes::Plan(input) => input,
        PlanOrAttitudes::Sequence(_) => return Err(Failure::unusable(path, &ExportError::Sequence)),
        PlanOrAttitudes::Attitudes(input) => {
            if !problem.is_constrained() {
                let reason = "a file of attitudes gives only a path, which this maneuver does not use as a \
                    guess, because it has no limits";
                console.warn(
                    "W0141",
                    reason,
                    "give a plan file as the guess; or set solver.method=interior_point",
                );
            }
            let quaternion = read_attitudes(input, &path.to_string_lossy())?.evenly();
            return Ok(Guess { quaternion, ..Guess::default() });
        }
    };
    let guess = read_guess(input).map_err(|error| Failure::unusable(path, &error))?;
    let (found, needed) = (guess.costates.len(), problem.dimension());
    if found != needed {
        let reason = format!("the guess has {found} costates, and this maneuver needs {needed}");
        let remedy =
            "give a plan of the same kind of maneuver: 6 costates for an attitude, 12 with positions";
        return Err(Failure::File(Message::new("E0103", reason, remedy)));
    }
    Ok(guess)
}

/// Creates the failure for a maneuver that the planner rejects.
pub fn refusal(error: PlanError) -> Failure {
    match error {
        PlanError::Problem(error) => invalid(error),
        error @ (PlanError::Guess { .. } | PlanError::GuessPath) => {
            Failure::File(Message::new("E0103", error.to_string(), "give another plan as the guess"))
        }
        other => Failure::Problem(Message::new("E0121", other.to_string(), "change the spec accordingly")),
    }
}

/// Creates the failure for a spec whose keys are valid but contradict each other.
pub fn invalid(error: ProblemError) -> Failure {
    let (code, remedy) = match &error {
        ProblemError::StepTooLong { steps, .. } => {
            ("E0120", format!("set `maneuver.steps` to {steps} or more"))
        }
        ProblemError::Violated { end, .. } => {
            ("E0121", format!("change the {end}, or the limit or the cone that it violates"))
        }
        _ => ("E0121", "change the spec accordingly".into()),
    };
    Failure::Problem(Message::new(code, error.to_string(), remedy))
}

/// Observer of a search. It shows the progress, and stops the search on Ctrl-C.
pub struct Watcher<'a>(pub &'a mut Console);

impl Observer for Watcher<'_> {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        let Progress { rung, start, steps, elapsed, part, .. } = progress;
        let part = if part.is_empty() { String::new() } else { format!("{part}: ") };
        self.0.progress(|| format!("  {part}{elapsed:.1} s  {rung}, start {start}, {steps} steps"));
        if interrupt::requested() { Control::Stop } else { Control::Continue }
    }

    fn stop_flag(&self) -> Option<Arc<AtomicBool>> {
        Some(interrupt::flag())
    }
}
