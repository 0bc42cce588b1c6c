//! `slew simulate`: propagates the bodies of a spec from their initial states, without
//! optimisation, and writes the motion row by row.

mod layout;
mod limits;
mod record;
mod report;

use super::console;
use super::{
    Console, Destination, Exit, Failure, Format, Message, OutputArgs, SpecArgs, interrupt, plan, spec_file,
    summary,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use layout::Layout;
use record::Recorder;
use report::Seen;
use slewkit::maneuver::{Duration, Problem};
use slewkit::numerics::figures::significant;
use slewkit::plan::Status;
use slewkit::propagate::integrator::{Kind, StepError};
use slewkit::propagate::simulate::{Encounter, Observer, Run, Simulation, SimulationError, SimulationRow};
use slewkit::verify::WitnessError;
use slewkit::verify::propagation::{self, Propagator};
use slewkit_files::export::ExportError;
use slewkit_files::spec::{Spec, escape};
use std::io::Write;
use std::ops::ControlFlow;
use std::time::Instant;

/// Arguments of `slew simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A simulation spec has [simulation] and [[bodies]]. A maneuver spec is propagated from its start over its
duration; its end has no effect.

CSV and JSON lines stream for any number of steps. JSON is held in memory first. Ctrl-C ends the motion
and keeps the rows so far and the last state, also in a file. Errors of conserved quantities, in the
summary and as `errors` in JSON, are the largest at the rows; larger ones may occur between them. Bodies
do not collide: a warning reports that two bodies came closer than the sum of their sizes.

Examples:
  slew simulate dumbbells.toml -o motion.csv
  slew simulate dumbbells.toml --integrator galerkin_gauss_3 --set simulation.step_s=0.1
  slew simulate maneuver.toml --steps 5000 --stride 10 --format jsonl")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Number of steps; by default the number of the spec
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub steps: Option<u64>,
    /// Steps from one row to the next; by default the output_stride of the spec, or 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub stride: Option<u64>,
    /// Method; by default the method of the spec, or lie_verlet
    #[arg(
        long,
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(Kind::NAMES).try_map(|name| name.parse::<Kind>()),
    )]
    pub integrator: Option<Kind>,
    /// Inputs of a maneuver, held throughout, forces before torques, as in `--inputs 0,0,0.1`; by
    /// default none
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true)]
    pub inputs: Option<Vec<f64>>,
}

/// Largest number of rows of a JSON document, summed over the bodies. These rows are stored in
/// memory.
const MAX_DOCUMENT_ROWS: u64 = 10_000_000;

/// The formats in which a simulation can be written.
const FORMATS: [Format; 4] = [Format::Text, Format::Json, Format::Jsonl, Format::Csv];

/// Runs `slew simulate` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(&FORMATS, &[&args.spec.spec])?;
    let motion = match spec_file::load(&args.spec.spec, &args.spec.reading, console)? {
        Spec::Maneuver(loaded) => {
            let motion = Motion::of_maneuver(&loaded.problem, args)?;
            for reason in limits::exceeded(&loaded.problem, args.inputs.as_deref()) {
                let remedy = "a simulation does not saturate inputs: give smaller inputs, or a shorter \
                 `maneuver.duration_s`";
                console.warn("W0135", &reason, remedy);
            }
            motion
        }
        Spec::Sequence(_) => return Err(spec_file::refuse_stops()),
        Spec::Simulation(loaded) => {
            if args.inputs.is_some() {
                let reason = "--inputs: the bodies of a simulation spec have no actuators";
                return Err(Failure::Usage(reason.into()));
            }
            if let Destination::File(target, _) = &destination {
                loaded.files.iter().try_for_each(|file| target.distinct_from(file))?;
            }
            let mut simulation = loaded.simulation;
            simulation.kind = args.integrator.unwrap_or(simulation.kind);
            simulation.steps = args.steps.unwrap_or(simulation.steps);
            simulation.stride = args.stride.unwrap_or(simulation.stride);
            Motion::of_bodies(simulation, true)
        }
    };
    let layout = &motion.layout;
    let rows = (layout.steps / layout.stride).saturating_mul(layout.bodies.len() as u64);
    if matches!(&destination, Destination::Stdout(Format::Json) | Destination::File(_, Format::Json))
        && rows > MAX_DOCUMENT_ROWS
    {
        let reason = format!("{} steps are too many for one JSON document", layout.steps);
        return Err(Failure::Usage(format!("{reason}: raise --stride, or choose --format jsonl or csv")));
    }
    interrupt::watch();
    let mut job = Job { motion: &motion, seen: None, run: None, failure: None, stopped: None, message: None };
    let mut closed = false;
    let written = match &destination {
        Destination::None => job.run(Format::Text, &mut std::io::sink(), console),
        Destination::Stdout(format) => console::to_stdout(|output| {
            let written = job.run(*format, output, console);
            closed = written.as_ref().is_err_and(ExportError::is_broken_pipe);
            written
        }),
        Destination::File(target, format) => target.write(|output| job.run(*format, output, console)),
    };
    if let Some(failure) = job.failure {
        return Err(failure);
    }
    written?;
    if closed {
        // The program that reads the stream has closed it. The motion is incomplete, so no summary
        // is printed.
        console.clear_progress();
        return Ok(Exit::Solved);
    }
    let Job { seen, run, stopped, message, .. } = job;
    if let Some(seen) = &seen {
        console.say(&seen.summary(console, layout, run.as_ref(), stopped));
    }
    if let Some(Encounter { time, bodies, distance, .. }) = run.and_then(|run| run.encounter) {
        let [a, b] = bodies.map(|body| escape(&layout.bodies[body]));
        let (time, distance) = (significant(time, 4), significant(distance, 4));
        let reason = format!("{a} and {b} came closer than their sizes at t = {time} s, {distance} m apart");
        let remedy = "bodies do not collide here: use only the motion until then, or shorten the step if long \
         bodies nearly missed";
        console.warn("W0134", &reason, remedy);
    }
    if let Destination::File(target, _) = &destination {
        summary::wrote(console, target);
    }
    if let Some(Message { code, reason, remedy }) = &message {
        console.error(code, reason, remedy);
    }
    Ok(stopped.map_or(Exit::Solved, |(exit, _)| exit))
}

/// A motion to be propagated, with the layout of its rows and its propagation method.
struct Motion {
    layout: Layout,
    carrier: Carrier,
}

/// Method by which a motion is propagated.
enum Carrier {
    /// An integrator for one or several bodies.
    Integrator(Box<Simulation>),
    /// The equations of motion of the witnesses, for a body with reaction wheels under held inputs.
    Witness(Box<Problem>, Propagator, Option<Vec<f64>>),
}

/// Reason why a motion ended early.
enum Ended {
    /// A number became infinite or NaN. The rows before this time are kept.
    NotFinite(Message),
    /// The motion cannot be propagated.
    Failed(Failure),
}

impl Ended {
    fn of(not_finite: bool, failure: Failure) -> Self {
        match failure {
            Failure::Plan(_, message) if not_finite => Self::NotFinite(message),
            failure => Self::Failed(failure),
        }
    }
}

impl Motion {
    /// Creates the motion of the bodies of a simulation. `keeps_energy` is true if no inputs do
    /// work.
    fn of_bodies(simulation: Simulation, keeps_energy: bool) -> Self {
        let layout = Layout {
            name: simulation.name.clone(),
            integrator: simulation.kind.name(),
            bodies: simulation.bodies.clone(),
            moves: simulation.system.bodies().iter().map(|body| body.mass.is_some()).collect(),
            duration: simulation.duration,
            steps: simulation.steps,
            stride: simulation.stride,
            symmetry: simulation.system.symmetry(),
            keeps_energy,
            wheels: Vec::new(),
        };
        Self { layout, carrier: Carrier::Integrator(Box::new(simulation)) }
    }

    fn of_maneuver(problem: &Problem, args: &Args) -> Result<Self, Failure> {
        let inputs = args.inputs.as_deref();
        if inputs.iter().copied().flatten().any(|value| !value.is_finite()) {
            return Err(Failure::Usage("--inputs: every input must be finite".into()));
        }
        let Duration::Given(duration) = problem.duration else {
            let reason = "the duration is free, so the length of the simulation is unknown".to_string();
            let remedy = "give `maneuver.duration_s`, with minimize = \"effort\" and no price of time; `--set \
             KEY=VALUE` does this";
            return Err(Failure::Problem(Message::new("E0121", reason, remedy)));
        };
        let (steps, stride) = (args.steps.unwrap_or(problem.steps as u64), args.stride.unwrap_or(1));
        if problem.actuation.wheels.is_none() {
            let mut simulation = Simulation::of(problem, inputs).map_err(refusal)?;
            simulation.kind = args.integrator.unwrap_or(simulation.kind);
            (simulation.steps, simulation.stride) = (steps, stride);
            return Ok(Self::of_bodies(simulation, !works(inputs)));
        }
        let kind = args.integrator.unwrap_or(Kind::LieVerlet);
        let propagator = match kind {
            Kind::LieVerlet => Propagator::LieVerlet,
            Kind::Verner98 => Propagator::Verner98,
            other => {
                let reason = format!("--integrator {other}: it does not support reaction wheels");
                return Err(Failure::Usage(format!("{reason}; use lie_verlet or verner98")));
            }
        };
        let layout = Layout {
            name: problem.name.clone(),
            integrator: kind.name(),
            bodies: vec!["body 1".into()],
            moves: vec![problem.motion == slewkit::maneuver::Motion::RigidBody],
            duration,
            steps,
            stride,
            // The torques of wheels are internal torques, so the symmetry of the environment is not
            // affected.
            symmetry: problem.environment.symmetry(),
            keeps_energy: !works(inputs),
            wheels: limits::wheel_momenta(problem, inputs),
        };
        let carrier = Carrier::Witness(Box::new(problem.clone()), propagator, args.inputs.clone());
        Ok(Self { layout, carrier })
    }

    fn run(&self, observer: &mut impl Observer) -> Result<Option<Run>, Ended> {
        match &self.carrier {
            Carrier::Integrator(simulation) => simulation.run(observer).map(Some).map_err(|error| {
                let not_finite = matches!(&error, SimulationError::Step { error: StepError::NotFinite, .. });
                Ended::of(not_finite, refusal(error))
            }),
            Carrier::Witness(problem, propagator, inputs) => {
                let Layout { steps, stride, .. } = self.layout;
                let (propagator, inputs) = (*propagator, inputs.as_deref());
                let settings = propagation::Propagation { propagator, steps, stride, inputs };
                propagation::propagate(problem, &settings, observer).map_err(|error| {
                    let not_finite = matches!(&error, WitnessError::NotFinite { .. });
                    Ended::of(not_finite, refusal_of_witness(error))
                })?;
                Ok(None)
            }
        }
    }
}

/// Returns whether any input is nonzero, so that it can change the energy.
fn works(inputs: Option<&[f64]>) -> bool {
    inputs.is_some_and(|inputs| inputs.iter().any(|input| input.abs() > 0.0))
}

/// A simulation that is being written to an output.
struct Job<'a> {
    motion: &'a Motion,
    seen: Option<Seen>,
    run: Option<Run>,
    /// Reason why the motion could not be propagated to its end; the output is then discarded.
    failure: Option<Failure>,
    /// Exit code and number of steps of a motion that ended early, because of Ctrl-C or because a
    /// number was not finite. The steps are counted up to the last row with finite numbers. `None`
    /// if the motion did not end early.
    stopped: Option<(Exit, u64)>,
    /// Message for the user about a motion that ended early.
    message: Option<Message>,
}

impl Job<'_> {
    /// Propagates the motion and writes its rows. If the motion ends early, the rows up to this
    /// time are written.
    fn run(
        &mut self,
        format: Format,
        output: &mut dyn Write,
        console: &mut Console,
    ) -> Result<(), ExportError> {
        let layout = &self.motion.layout;
        let recorder = Recorder::new(layout);
        if format == Format::Csv {
            recorder.write_header(output)?;
        }
        let mut writer = Writer {
            layout,
            format,
            output,
            recorder,
            seen: None,
            result: Ok(()),
            stopped: None,
            made: 0,
            at_row: 0,
            progress: ProgressLine::new(console, layout.steps),
        };
        let ended = self.motion.run(&mut writer);
        let Writer { recorder, seen, result, stopped, at_row, .. } = writer;
        (self.seen, self.stopped) = (seen, stopped.map(|steps| (Exit::Plan(Status::Interrupted), steps)));
        result?;
        match ended {
            Ok(run) => self.run = run,
            Err(Ended::NotFinite(message)) => {
                (self.stopped, self.message) = (Some((Exit::NotFinite, at_row)), Some(message));
            }
            Err(Ended::Failed(failure)) => {
                self.failure = Some(failure);
                return Err(std::io::Error::other("the simulation stopped").into());
            }
        }
        if format != Format::Json {
            return Ok(());
        }
        recorder.write_document(self.run.as_ref(), self.seen.as_ref(), self.stopped, output)
    }
}

/// Observer of a simulation, which writes its rows to the output.
struct Writer<'l, 'a> {
    layout: &'l Layout,
    format: Format,
    output: &'a mut dyn Write,
    recorder: Recorder<'l>,
    seen: Option<Seen>,
    result: Result<(), ExportError>,
    stopped: Option<u64>,
    /// Number of steps that have been made.
    made: u64,
    at_row: u64,
    progress: ProgressLine<'a>,
}

impl Observer for Writer<'_, '_> {
    fn on_row(&mut self, row: &SimulationRow) -> ControlFlow<()> {
        self.at_row = self.made;
        self.seen.get_or_insert_with(|| Seen::new(row, self.layout)).note(row);
        self.result = match self.format {
            Format::Json => {
                self.recorder.hold(row);
                Ok(())
            }
            Format::Csv => self.recorder.write_csv(row, self.output),
            Format::Jsonl => self.recorder.write_jsonl(row, self.output),
            // An earlier check has rejected all other formats.
            _ => Ok(()),
        };
        if self.result.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn on_step(&mut self, steps: u64) -> ControlFlow<()> {
        self.made = steps;
        if interrupt::requested() {
            self.stopped = Some(steps);
            return ControlFlow::Break(());
        }
        self.progress.note(steps);
        ControlFlow::Continue(())
    }
}

/// Progress line of a simulation, and the step at which the clock is read next. Reading the clock
/// takes as long as a short step, so it is not read in every step.
struct ProgressLine<'a> {
    console: &'a mut Console,
    steps: u64,
    began: Instant,
    next: u64,
    stride: u64,
}

impl<'a> ProgressLine<'a> {
    fn new(console: &'a mut Console, steps: u64) -> Self {
        let next = if console.shows_progress() { 1 } else { u64::MAX };
        Self { console, steps, began: Instant::now(), next, stride: 1 }
    }

    fn note(&mut self, made: u64) {
        if made < self.next {
            return;
        }
        // The number of steps between two readings is chosen so that the clock is read a few times
        // for each progress line.
        self.stride =
            if self.console.is_due() { (self.stride / 4).max(1) } else { (2 * self.stride).min(1 << 20) };
        let (share, elapsed) = (made as f64 / self.steps as f64, self.began.elapsed().as_secs_f64());
        let (percent, rest) = ((100.0 * share).floor(), elapsed * (1.0 - share) / share);
        let steps = self.steps;
        self.console.progress(|| format!("  {percent} %  step {made} of {steps}, {rest:.0} s to go"));
        self.next = made.saturating_add(self.stride);
    }
}

fn refusal(error: SimulationError) -> Failure {
    let reason = error.to_string();
    let stopped =
        |code, remedy: &str| Failure::Plan(Status::NotConverged, Message::new(code, reason.clone(), remedy));
    match error {
        SimulationError::Problem(error) => plan::invalid(error),
        SimulationError::Inputs { .. } => Failure::Usage(format!("--inputs: {reason}")),
        SimulationError::Step {
            error: StepError::TooLong { .. } | StepError::NotConverged { .. }, ..
        } => stopped("E0120", "increase `--steps`, or shorten the step in the spec"),
        SimulationError::Step { error: StepError::NotFinite, .. } => {
            stopped("E0123", "increase `--steps`, or look at the rows before; bodies may have met")
        }
        SimulationError::Step { .. } => {
            stopped("E0122", "check the start, the forces and the torques; bodies may have met")
        }
        SimulationError::System(_)
        | SimulationError::Sought
        | SimulationError::Grid
        | SimulationError::Wheels => {
            Failure::Problem(Message::new("E0121", reason, "change the spec accordingly"))
        }
    }
}

fn refusal_of_witness(error: WitnessError) -> Failure {
    let reason = error.to_string();
    let stopped =
        |code, remedy| Failure::Plan(Status::NotConverged, Message::new(code, reason.clone(), remedy));
    match error {
        WitnessError::Problem(error) => plan::invalid(error),
        WitnessError::Rows { .. } => Failure::Usage(format!("--inputs: {reason}")),
        WitnessError::StepTooLong { .. } => stopped("E0120", "increase `--steps`"),
        WitnessError::NotFinite { .. } => stopped("E0123", "increase `--steps`, or look at the rows before"),
        _ => stopped("E0122", "check the start and the environment"),
    }
}
