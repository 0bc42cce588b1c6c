//! `slew simulate`: propagate the start of a spec, without optimisation, row after row.

use super::args::{Destination, Format, OutputArgs, SpecArgs};
use super::console::{self, Console, Tone};
use super::failure::{Exit, Failure, Message};
use super::number::{error, significant};
use super::{plan, spec_file, summary};
use clap::ValueEnum;
use serde::Serialize;
use slewkit::Vector3;
use slewkit::export::{ExportError, write_document};
use slewkit::plan::Status;
use slewkit::problem::{Motion, Problem};
use slewkit::simulate::{Propagator, Row, Simulation, simulate};
use slewkit::spec::Loaded;
use slewkit::verify::WitnessError;
use std::io::Write;

/// Arguments of `slew simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The motion lasts as long as the maneuver of the spec and begins at its start; the end plays no part.
CSV and JSON lines are streamed, whatever the number of steps; JSON is held in memory first.")]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    /// Number of steps; by default those of the spec
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub steps: Option<u64>,
    /// One row every so many steps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub stride: u64,
    /// How to propagate
    #[arg(long, value_name = "METHOD", default_value = "lie_verlet")]
    pub propagator: Method,
    /// Inputs held throughout, forces before torques, as in `--inputs 0,0,0.1`; by default none
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true)]
    pub inputs: Option<Vec<f64>>,
}

/// How to propagate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Second order, symplectic: no drift of energy or momentum
    #[value(name = "lie_verlet")]
    LieVerlet,
    /// Verner 9(8) at 1e-14: exact to round-off, slower
    #[value(name = "continuous")]
    Continuous,
}

/// Rows of one JSON document, held in memory.
const MAX_DOCUMENT_ROWS: u64 = 10_000_000;

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let destination = args.output.destination(&[&args.spec.spec])?;
    let Loaded { problem, .. } = spec_file::read(&args.spec.spec, &args.spec.reading, console)?;
    if args.inputs.iter().flatten().any(|value| !value.is_finite()) {
        return Err(Failure::Usage("--inputs: every input must be finite".into()));
    }
    let settings = Simulation {
        propagator: match args.propagator {
            Method::LieVerlet => Propagator::LieVerlet,
            Method::Continuous => Propagator::Continuous,
        },
        steps: args.steps.unwrap_or(problem.steps as u64),
        stride: args.stride,
        inputs: args.inputs.as_deref(),
    };
    if matches!(&destination, Destination::Stdout(Format::Json) | Destination::File(_, Format::Json))
        && settings.steps / settings.stride > MAX_DOCUMENT_ROWS
    {
        let reason = format!("{} steps are too many for one JSON document", settings.steps);
        return Err(Failure::Usage(format!("{reason}: raise --stride, or choose --format jsonl or csv")));
    }
    let mut job = Job { problem: &problem, settings: &settings, seen: None, failure: None };
    let written = match &destination {
        Destination::None => job.run(Format::Text, &mut std::io::sink()),
        Destination::Stdout(format) => console::to_stdout(|output| job.run(*format, output)),
        Destination::File(target, format) => target.write(|output| job.run(*format, output)),
    };
    if let Some(error) = job.failure {
        return Err(refusal(error));
    }
    written?;
    if let Some(seen) = &job.seen {
        let duration = significant(problem.duration, 4);
        let verdict = format!("{duration} s in {} steps", settings.steps);
        let mut lines = vec![summary::headline(console, &problem.name, &verdict, Tone::Good)];
        lines.extend(seen.lines());
        console.say(&lines.join("\n"));
    }
    if let Destination::File(target, _) = &destination {
        plan::wrote(console, target);
    }
    Ok(Exit::Solved)
}

/// A simulation on its way to an output.
struct Job<'a> {
    problem: &'a Problem,
    settings: &'a Simulation<'a>,
    seen: Option<Seen>,
    /// Why the motion could not be followed to its end: the output is then given up.
    failure: Option<WitnessError>,
}

impl Job<'_> {
    fn run(&mut self, format: Format, output: &mut dyn Write) -> Result<(), ExportError> {
        let moving = self.problem.motion == Motion::RigidBody;
        let mut document = (format == Format::Json).then(|| Document::new(self.problem, self.settings));
        if format == Format::Csv {
            writeln!(output, "{}", header(moving))?;
        }
        let mut result = Ok(());
        let seen = &mut self.seen;
        let ended = simulate(self.problem, self.settings, |row| {
            seen.get_or_insert_with(|| Seen::new(row)).note(row);
            let record = Record::new(row, moving);
            result = match (&mut document, format) {
                (Some(document), _) => {
                    document.trajectory.push(record);
                    Ok(())
                }
                (None, Format::Csv) => record.write_csv(output),
                (None, Format::Jsonl) => record.write_jsonl(output),
                (None, _) => Ok(()),
            };
            result.is_ok()
        });
        result?;
        if let Err(error) = ended {
            self.failure = Some(error);
            return Err(std::io::Error::other("the simulation stopped").into());
        }
        document.map_or(Ok(()), |document| write_document(&document, output))
    }
}

fn refusal(error: WitnessError) -> Failure {
    let reason = error.to_string();
    match error {
        WitnessError::Problem(error) => plan::invalid(error),
        WitnessError::Rows { .. } => Failure::Usage(format!("--inputs: {reason}")),
        WitnessError::StepTooLong { .. } => {
            let remedy = "raise `--steps`".into();
            Failure::Plan(Status::NotConverged, Message { code: "E0120", reason, remedy })
        }
        _ => {
            let remedy = "check start and environment".into();
            Failure::Plan(Status::NotConverged, Message { code: "E0122", reason, remedy })
        }
    }
}

/// One row of the output, keys with units.
#[derive(Serialize)]
struct Record {
    time_s: f64,
    quaternion_wxyz: [f64; 4],
    angular_velocity_rad_s: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_m_s: Option<[f64; 3]>,
    energy_j: f64,
    angular_momentum_n_m_s: [f64; 3],
}

fn header(moving: bool) -> String {
    let vector =
        |name: &str, unit: &str| ["x", "y", "z"].map(|part| format!("{name}_{part}_{unit}")).join(",");
    let mut columns = vec!["time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z".into()];
    columns.push(vector("angular_velocity", "rad_s"));
    if moving {
        columns.extend([vector("position", "m"), vector("velocity", "m_s")]);
    }
    columns.extend(["energy_j".into(), vector("angular_momentum", "n_m_s")]);
    columns.join(",")
}

impl Record {
    fn new(row: &Row, moving: bool) -> Self {
        Self {
            time_s: row.time,
            quaternion_wxyz: row.quaternion,
            angular_velocity_rad_s: row.angular_velocity.into(),
            position_m: moving.then(|| row.position.into()),
            velocity_m_s: moving.then(|| row.velocity.into()),
            energy_j: row.energy,
            angular_momentum_n_m_s: row.momentum.into(),
        }
    }

    fn write_csv(&self, output: &mut dyn Write) -> Result<(), ExportError> {
        // The debug form of a float is the shortest that reads back to the same bits.
        write!(output, "{:?}", self.time_s)?;
        let energy = [self.energy_j];
        let groups: [&[f64]; 6] = [
            &self.quaternion_wxyz,
            &self.angular_velocity_rad_s,
            self.position_m.as_ref().map_or(&[], |v| v),
            self.velocity_m_s.as_ref().map_or(&[], |v| v),
            &energy,
            &self.angular_momentum_n_m_s,
        ];
        for value in groups.into_iter().flatten() {
            write!(output, ",{value:?}")?;
        }
        Ok(writeln!(output)?)
    }

    fn write_jsonl(&self, output: &mut dyn Write) -> Result<(), ExportError> {
        serde_json::to_writer(&mut *output, self)?;
        Ok(writeln!(output)?)
    }
}

/// The whole simulation as one document, a list per key.
#[derive(Serialize)]
struct Document<'a> {
    status: &'static str,
    exit_code: u8,
    name: &'a str,
    duration_s: f64,
    steps: u64,
    stride: u64,
    trajectory: Columns,
}

#[derive(Default, Serialize)]
struct Columns {
    time_s: Vec<f64>,
    quaternion_wxyz: Vec<[f64; 4]>,
    angular_velocity_rad_s: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    position_m: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    velocity_m_s: Vec<[f64; 3]>,
    energy_j: Vec<f64>,
    angular_momentum_n_m_s: Vec<[f64; 3]>,
}

impl<'a> Document<'a> {
    fn new(problem: &'a Problem, settings: &Simulation) -> Self {
        Self {
            status: "simulated",
            exit_code: 0,
            name: &problem.name,
            duration_s: problem.duration,
            steps: settings.steps,
            stride: settings.stride,
            trajectory: Columns::default(),
        }
    }
}

impl Columns {
    fn push(&mut self, record: Record) {
        self.time_s.push(record.time_s);
        self.quaternion_wxyz.push(record.quaternion_wxyz);
        self.angular_velocity_rad_s.push(record.angular_velocity_rad_s);
        self.position_m.extend(record.position_m);
        self.velocity_m_s.extend(record.velocity_m_s);
        self.energy_j.push(record.energy_j);
        self.angular_momentum_n_m_s.push(record.angular_momentum_n_m_s);
    }
}

/// What a reader wants to know first: where it ended, and what was conserved.
struct Seen {
    first: Row,
    last: Row,
    energy_change: f64,
    momentum_change: f64,
}

impl Seen {
    fn new(row: &Row) -> Self {
        Self { first: *row, last: *row, energy_change: 0.0, momentum_change: 0.0 }
    }

    fn note(&mut self, row: &Row) {
        self.last = *row;
        self.energy_change = self.energy_change.max((row.energy - self.first.energy).abs());
        self.momentum_change = self.momentum_change.max((row.momentum - self.first.momentum).norm());
    }

    fn lines(&self) -> [String; 4] {
        let list = |values: &[f64]| {
            let values: Vec<_> = values.iter().map(|value| significant(*value, 6)).collect();
            format!("[{}]", values.join(", "))
        };
        let rate: Vector3 = self.last.angular_velocity.map(f64::to_degrees);
        let (energy, momentum) =
            (significant(self.first.energy, 6), significant(self.first.momentum.norm(), 6));
        let (de, dl) = (error(self.energy_change), error(self.momentum_change));
        [
            summary::line("end", &format!("quaternion_wxyz {}", list(&self.last.quaternion))),
            summary::line("", &format!("angular_velocity_deg_s {}", list(rate.as_slice()))),
            summary::line("energy", &format!("{energy} J at the start, changes by at most {de} J")),
            summary::line(
                "momentum",
                &format!("{momentum} N·m·s at the start, changes by at most {dl} N·m·s"),
            ),
        ]
    }
}
