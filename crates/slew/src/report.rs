//! `slew report`: writes a plan, a simulation, a comparison or the results of a batch as one page
//! for a browser.

use super::pictured::{self, Drawing, Kind, Pictured};
use super::{Common, Console, Exit, Failure, Reading, console, interrupt, summary};
use slewkit_files::export::{SimulationFile, Target};
use slewkit_files::spec::Loaded;
use slewkit_report::{
    ComparisonFile, comparison_page, plan_page, results_page, sequence_page, simulation_page,
};
use std::path::{Path, PathBuf};

/// Arguments of `slew report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The report is one HTML file. Any browser opens it from disk, without a network, and can print it. It shows
the verdict and the proof, boresights and cones on the sphere, inputs, rates and wheels with their limits,
clearance, attitude, costates, convergence, rivals, checks, and the body in motion.

slew reads only FILE, which may be:
  a plan             also one without a trajectory: proved infeasible or not converged
  a sequence         the plan of a spec with stops: timeline, stops, the motion over all legs
  a simulation       motion, energy and momentum
  a comparison       the JSON of `slew compare SPEC --format json`: tables, work and precision of integrators;
                     `slew compare SPEC --report` also shows the motions side by side
  results            of `slew batch`, `slew sweep` or `slew monte-carlo`: the cost over one or two keys,
                     distributions, failed and costliest cases

Examples:
  slew report plan.json -o report.html
  slew plan maneuver.toml -o plan.json --report report.html
  slew simulate bodies.toml -o run.json && slew report run.json -o run.html
  slew sweep maneuver.toml --over maneuver.duration_s=20:200:37 -o sweep.jsonl
  slew report sweep.jsonl -o sweep.html")]
pub struct Args {
    /// File that `slew plan SPEC -o FILE` or `slew simulate SPEC -o FILE` wrote, JSON, `-` reads
    /// stdin; a comparison, JSON; or results of a batch, JSON lines
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// The page; `-` is stdout
    #[arg(short, long, value_name = "FILE.html")]
    pub output: PathBuf,
    #[command(flatten)]
    pub drawing: Drawing,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl Args {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }
}

/// Runs `slew report` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    interrupt::end_at_once();
    let target = match args.output.as_os_str() == "-" {
        true => None,
        false => Some(target(&args.output, args.force, &[&args.plan])?),
    };
    let sequence = &args.drawing.euler;
    let mut exit = Exit::Solved;
    let text = match pictured::open(&args.plan)? {
        (Kind::Plan, input) => {
            let Pictured { loaded, plan, margins, exit: found } = pictured::read(&args.plan, input, console)?;
            let Loaded { problem, settings, identity, closed_loop, .. } = loaded;
            exit = found;
            plan_page(&problem, &settings, &plan, &identity, (&closed_loop, margins.as_ref()), sequence)
        }
        (Kind::Sequence, input) => {
            let reading = Reading { set: Vec::new(), input: None };
            let (file, loaded, found) = pictured::sequence(&args.plan, input, &reading, console)?;
            exit = found;
            sequence_page(&file, &loaded, sequence)
        }
        (Kind::Simulation, input) => {
            let read = SimulationFile::read(input);
            simulation_page(&read.map_err(|error| Failure::unusable(&args.plan, &error))?, sequence)
        }
        (Kind::Results, _) => results_page(&pictured::results(&args.plan)?),
        (Kind::Comparison, input) => {
            let read = ComparisonFile::read(input);
            comparison_page(&read.map_err(|error| Failure::unusable(&args.plan, &error))?)
        }
    };
    match &target {
        Some(target) => write(target, &text, console)?,
        None => console::to_stdout(|output| Ok(output.write_all(text.as_bytes())?))?,
    }
    Ok(exit)
}

/// Returns the output file of a page. Before any other work, checks that its name has an HTML
/// extension, and that it is not one of `inputs`.
pub fn target(path: &Path, force: bool, inputs: &[&Path]) -> Result<Target, Failure> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !["html", "htm"].iter().any(|known| ending.eq_ignore_ascii_case(known)) {
        let path = slewkit_files::spec::escape(&path.to_string_lossy());
        let reason = format!("a report is a page for a browser: {path} must end in .html or .htm");
        return Err(Failure::Usage(reason));
    }
    let target = Target::new(path, force)?;
    inputs.iter().try_for_each(|input| target.distinct_from(input))?;
    Ok(target)
}

/// Writes the HTML text of a page, and prints the name of the written file.
pub fn write(target: &Target, text: &str, console: &mut Console) -> Result<(), Failure> {
    target.write(|output| Ok(output.write_all(text.as_bytes())?))?;
    summary::wrote(console, target);
    Ok(())
}
