//! `slew compare`: compares methods or objectives on the maneuver of a spec, or integrators on a
//! simulation.

mod bound;
mod integrators;
mod objectives;
mod table;

use super::plan::{Watcher, refusal};
use super::{Console, Exit, Failure, ReportArgs, SpecArgs, interrupt, report, spec_file};
use serde::Serialize;
use slewkit::plan::Status;
use slewkit_files::export::Target;
use slewkit_files::spec::{Loaded, Spec};
use slewkit_report::studies::integrators::History;
use slewkit_report::studies::methods::compare;
use slewkit_report::{ComparisonFile, Motion, comparison_page};
use std::path::{Path, PathBuf};

/// Arguments of `slew compare`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("written").args(["figures", "page"]).multiple(true))]
#[command(after_help = "\
A spec of a maneuver compares methods, a spec of a simulation integrators. If a maneuver minimises time
or fuel, or has a free duration, slew compares its objectives, and the methods for a plan that switches.

The methods: shooting, where it applies; scp, sequential convex programming to its own
convergence; scp + polish, SCP with final Newton iterations, as in `slew plan`. The key
`solver.method` of the spec has no effect. A time limit applies to each solve.

Exit codes: 0 when at least one method solved and those that did agree; 7 when their costs
differ, or a witness rejects a plan; otherwise the codes of `slew plan`. A missing bound does not
change the exit code.

If inputs switch (minimum time or fuel), slew compares the smoothed law, switching times, and for minimum
time the interior point, on one number of steps; then the objectives.

The objectives (`--objectives`): plans of minimum time, fuel and effort, each measured by all three.
Weights and prices come from the spec. Effort and fuel use the duration of the spec or of its price of
time. If the spec minimises time, they use 1.5 times the shortest duration. Exit code 0 means that at
least one plan is solved.

Integrators run with 16 … ¼ times the step of the spec, over its duration, a tenth and a
hundredth of it. The table shows errors of energy, RᵀR and momenta, the work, and the work of
each integrator at equal mean energy error, relative to the first. An integrator that fails has a row
with the reason, and does not change the exit code.

Two runs differ in JSON only in the keys of times (`solve_time_s`, `time_s`, `time_ratio`).

Examples:
  slew compare maneuver.toml
  slew compare maneuver.toml --format json | jq .agreement
  slew compare maneuver.toml --objectives --report objectives.html
  slew compare maneuver.toml --bound --bound-steps 4
  slew compare dumbbells.toml --figures figures
  slew compare dumbbells.toml --integrators lie_verlet,rkf78 --step 0.4,0.2,0.1 --horizon 30,300")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub report: ReportArgs,
    /// Add a global lower bound on the grid of `--bound-steps`, a plan on that grid, and the gap
    /// between them. Free bodies only; the bound ignores limits. Needs the cargo feature `sdp`
    #[arg(long)]
    pub bound: bool,
    /// Steps of the grid of the bound, by default 8; the time to solve grows fast with them
    #[arg(long, value_name = "STEPS", requires = "bound", value_parser = clap::value_parser!(u16).range(2..=60))]
    pub bound_steps: Option<u16>,
    /// Compare minimum-time, minimum-fuel and minimum-effort plans instead of the methods; torques
    /// need limits
    #[arg(long, conflicts_with = "bound")]
    pub objectives: bool,
    /// Write the comparison as one page for a browser as well
    #[arg(long = "report", value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    #[command(flatten)]
    pub study: integrators::StudyArgs,
}

impl Args {
    /// Returns the output file of the page; `None` without `--report`. Before any other work,
    /// checks that it overwrites neither the spec nor one of the `files` to which the spec refers.
    fn target(&self, files: &[PathBuf]) -> Result<Option<Target>, Failure> {
        let inputs: Vec<&Path> =
            std::iter::once(&self.spec.spec).chain(files).map(PathBuf::as_path).collect();
        let target = |page: &PathBuf| report::target(page, self.study.force, &inputs);
        self.page.as_ref().map(target).transpose()
    }
}

/// Writes the page of a comparison, if it is requested. It is made from the JSON document, and from
/// the motions and errors over time, which the document does not contain.
fn page(
    target: Option<&Target>,
    document: &impl Serialize,
    (motions, inputs): (Vec<Motion>, &[String]),
    histories: Vec<History>,
    console: &mut Console,
) -> Result<(), Failure> {
    let Some(target) = target else { return Ok(()) };
    let internal = |error: &dyn std::fmt::Display| Failure::Internal(error.to_string());
    let document = serde_json::to_value(document).map_err(|error| internal(&error))?;
    let mut file = ComparisonFile::of(document).map_err(|error| internal(&error))?;
    (file.motions, file.inputs, file.histories) = (motions, inputs.to_vec(), histories);
    report::write(target, &comparison_page(&file), console)
}

/// The name and version of the program, for the JSON document.
const GENERATOR: &str = concat!("slewkit ", env!("CARGO_PKG_VERSION"));

/// Runs `slew compare` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    if args.bound {
        bound::available()?;
    }
    match spec_file::load(&args.spec.spec, &args.spec.reading, console)? {
        Spec::Maneuver(_) if args.study.any() => {
            let reason =
                "--integrators, --step, --horizon, --error, --figures: these need a spec of a simulation";
            Err(Failure::Usage(format!("{reason}; this spec is a maneuver")))
        }
        Spec::Maneuver(loaded) => {
            let objective = &loaded.problem.objective;
            let other = args.objectives || objective.switches() || loaded.problem.seeks_duration();
            if other && !args.bound {
                objectives::run(args, &loaded, console)
            } else {
                methods(args, *loaded, console)
            }
        }
        Spec::Sequence(_) => Err(spec_file::refuse_stops()),
        Spec::Simulation(_) if args.objectives => Err(Failure::Usage(
            "--objectives: it needs a spec of a maneuver; this spec is a simulation".into(),
        )),
        Spec::Simulation(_) if args.bound => {
            Err(Failure::Usage("--bound: it needs a spec of a maneuver; this spec is a simulation".into()))
        }
        Spec::Simulation(loaded) => integrators::run(args, &loaded, console),
    }
}

fn methods(args: &Args, loaded: Loaded, console: &mut Console) -> Result<Exit, Failure> {
    let Loaded { problem, settings, identity, files, .. } = loaded;
    let target = args.target(&files)?;
    interrupt::watch();
    let comparison = compare(&problem, &settings, &mut Watcher(console)).map_err(refusal)?;
    let bound = args
        .bound
        .then(|| bound::bound(&problem, &settings, args.bound_steps.map(usize::from), &mut Watcher(console)));
    let bound = bound.transpose()?;
    let mut lines = table::lines(console, &problem, &comparison);
    lines.extend(bound.iter().flat_map(|bound| bound.lines.clone()));
    console.say(&lines.join("\n"));
    let status = comparison.status();
    let document = document! {
        format: 1,
        generator: GENERATOR,
        compares: "methods",
        status: status,
        exit_code: status.exit_code(),
        name: &problem.name,
        scheme: problem.scheme.name(),
        steps: problem.steps,
        step_s: problem.step(),
        duration_s: problem.seconds(),
        tolerance: settings.tolerance,
        methods: &comparison.methods,
        agreement: &comparison.agreement,
        bound if some: bound.as_ref().map(|bound| &bound.document),
    };
    args.report.print(&document)?;
    let motions = comparison.methods.iter().filter_map(|run| {
        let trajectory = run.trajectory.clone()?;
        Some(Motion { name: table::name(run.method).into(), held: false, trajectory })
    });
    page(target.as_ref(), &document, (motions.collect(), &identity.inputs), Vec::new(), console)?;
    Ok(match status {
        Status::Solved => Exit::Solved,
        status => Exit::Plan(status),
    })
}
