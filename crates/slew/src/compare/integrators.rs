//! Comparison of integrators on the bodies of a simulation spec, as tables, JSON and figures.

use super::{Args, page};
use crate::{Console, Exit, Failure, Message, Tone, headline, interrupt, summary};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slewkit::mechanics::full_body::Attractor;
use slewkit::plan::Status;
use slewkit::propagate::integrator::Kind;
use slewkit_files::export::{FileError, Target};
use slewkit_files::spec::{BodyShape, LoadedSimulation, escape};
use slewkit_report::studies::integrators::figures::{FIGURES, Outline, figures};
use slewkit_report::studies::integrators::{Asked, Study, StudyError, StudyProgress};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// The options of the comparison that replace values of the spec.
#[derive(Debug, clap::Args)]
pub struct StudyArgs {
    /// Integrators; the others are compared with the first; by default lie_verlet,
    /// crouch_grossman_2, explicit_midpoint and implicit_midpoint
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        value_parser = PossibleValuesParser::new(Kind::NAMES).try_map(|name| name.parse::<Kind>()),
    )]
    pub integrators: Vec<Kind>,
    /// Steps in seconds, longest first; each must divide every horizon
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub step: Vec<f64>,
    /// Horizons in seconds, shortest first
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub horizon: Vec<f64>,
    /// Mean energy errors at which to compare work, largest first; by default up to five that the
    /// first integrator reaches
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub error: Vec<f64>,
    /// Draw figures: SVG files in the folder DIR, which is made if it does not exist
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Replace figures or a report that exist
    #[arg(long, requires = "written")]
    pub force: bool,
}

impl StudyArgs {
    /// Returns whether any of these options is given on the command line.
    pub fn any(&self) -> bool {
        let lists = [&self.step, &self.horizon, &self.error];
        self.figures.is_some() || !self.integrators.is_empty() || lists.iter().any(|list| !list.is_empty())
    }

    /// Returns the output files of the figures. Before any other work, checks that none of them is
    /// `spec`.
    fn targets(&self, spec: &Path) -> Result<Vec<Target>, Failure> {
        let Some(folder) = &self.figures else { return Ok(Vec::new()) };
        if !folder.exists() {
            std::fs::create_dir_all(folder).map_err(|reason| FileError::NotWritable {
                folder: escape(&folder.to_string_lossy()),
                reason,
            })?;
        }
        let target = |name: &&str| {
            let target = Target::new(folder.join(format!("{name}.svg")), self.force)?;
            target.distinct_from(spec)?;
            Ok(target)
        };
        FIGURES.iter().map(target).collect()
    }

    /// Creates the failure for a study that cannot be carried out. It is a usage error if the
    /// invalid numbers are on the command line.
    fn refusal(&self, error: &StudyError) -> Failure {
        if [&self.step, &self.horizon, &self.error].iter().any(|list| !list.is_empty()) {
            return Failure::Usage(format!("--step, --horizon, --error: {error}"));
        }
        let remedy = "choose --step, --horizon or --error";
        Failure::Problem(Message::new("E0124", error.to_string(), remedy))
    }

    /// Returns the values of the study that the options request.
    fn asked(&self) -> Asked {
        Asked {
            kinds: self.integrators.clone(),
            steps: self.step.clone(),
            horizons: self.horizon.clone(),
            levels: self.error.clone(),
        }
    }
}

/// Runs the comparison, prints it, and writes the figures.
pub fn run(args: &Args, loaded: &LoadedSimulation, console: &mut Console) -> Result<Exit, Failure> {
    let simulation = &loaded.simulation;
    let study = Study::of(simulation, &args.study.asked());
    study.check().map_err(|error| args.study.refusal(&error))?;
    let targets = args.study.targets(&args.spec.spec)?;
    let page_target = args.target(&loaded.files)?;
    interrupt::watch();
    let ran = study.run(&simulation.system, &simulation.start, &mut |progress| {
        let StudyProgress { kind, step, runs: (done, all) } = progress;
        console.progress(|| format!("  {} of {all}  {kind}, step {step} s", done + 1));
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let found = ran.map_err(|error| args.study.refusal(&error))?;
    let (exit, verdict, tone) = match found.interrupted {
        false => (Exit::Solved, "integrators compared", Tone::Good),
        true => (Exit::Plan(Status::Interrupted), "interrupted", Tone::Note),
    };
    console.say(&headline(console, &simulation.name, verdict, tone));
    console.say(&format!("\n{found}"));
    let document = document! {
        format: 1,
        generator: super::GENERATOR,
        compares: "integrators",
        status: exit.status(),
        exit_code: exit.code(),
        name: &simulation.name,
        bodies: &simulation.bodies,
        integrators: study.kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>(),
        steps_s: &study.steps,
        horizons_s: &study.horizons,
        energy_scale_j: found.energy_scale_j,
        levels: &found.levels,
        runs: &found.runs,
        equal_error: &found.equal_error,
        interrupted: found.interrupted,
    };
    args.report.print(&document)?;
    // An interrupted comparison has gaps, which figures would show like results.
    if !found.interrupted && !targets.is_empty() {
        let drawn = figures(&simulation.name, &study, &found, &outlines(loaded));
        for (figure, target) in drawn.iter().zip(&targets) {
            target.write(|output| Ok(output.write_all(figure.svg.as_bytes())?))?;
            summary::wrote(console, target);
        }
    }
    if !found.interrupted {
        page(page_target.as_ref(), &document, (Vec::new(), &[]), found.histories.clone(), console)?;
    }
    Ok(exit)
}

/// Returns the outlines of the bodies for figures of their motion.
fn outlines(loaded: &LoadedSimulation) -> Vec<Outline> {
    let outline = |(name, shape): (&String, &Option<BodyShape>)| match shape {
        Some(BodyShape::Dumbbell(dumbbell)) => Outline::dumbbell(name, dumbbell),
        Some(BodyShape::Other(attractor)) => match &**attractor {
            Attractor::Polyhedron(solid) => Outline::polyhedron(name, solid.shape()),
            Attractor::Cloud(cloud) => Outline::points(name, cloud),
            _ => Outline::point(name),
        },
        None => Outline::point(name),
    };
    loaded.simulation.bodies.iter().zip(&loaded.shapes).map(outline).collect()
}
