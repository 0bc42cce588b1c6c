//! `slew timeline`: reads a pointing file, prints its attitudes, and plans the slews between its
//! observations.

use super::args::ReportFormat;
use super::pictured::EULER;
use super::plan::Watcher;
use super::plan::sequence::refusal;
use super::{
    Common, Console, Exit, Failure, Format, Lines, Message, OutputArgs, Reading, Tone, console, export,
    interrupt, report, spec_file, summary,
};
use clap::ValueEnum;
use serde::Serialize;
use slewkit::numerics::figures::{counted, short};
use slewkit::plan::Status;
use slewkit::{Matrix3, lie};
use slewkit_files::epoch::Epoch;
use slewkit_files::export::{ExportError, SequenceFile, Target, write_document};
use slewkit_files::formats;
use slewkit_files::pointing::{self, Observation, PointingFile, Timeline, read_pointing};
use slewkit_files::spec::{ClosedLoop, Loaded, LoadedSequence, escape};
use slewkit_report::sequence_page;
use std::path::{Path, PathBuf};

/// Arguments of `slew timeline`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
FILE is a resolved timeline of ESA (PTR, .ptx) or a pointing request message of CCSDS (PRM, 509.0-B-1), with inertial
targets; a PRM may also have the Sun, and free rolls. All else is refused with its line.

Without --spec the attitudes of the observations are reported, and -o converts one format to the other. With --spec the
slews are planned: from the start of the spec, at its epoch, through all observations. Without an epoch the first
observation is the start. Slews of `minimize = \"time\"` are as fast as possible, and must fit. Slews of effort and fuel
last from one observation to the next. -o then has the planned times, and the attitude of every observation.

Examples:
  slew timeline requests.xml
  slew timeline requests.xml -o requests.ptx
  slew timeline requests.ptx --spec spacecraft.toml -o resolved.ptx
  slew timeline requests.ptx --spec spacecraft.toml --plan attitude.aem --report day.html")]
pub struct Args {
    /// The pointing file; `-` reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The spacecraft: plan the slews between the observations. Its [end] is not used
    #[arg(long, value_name = "SPEC")]
    pub spec: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Write the timeline: .ptx is a PTR, .xml or .prm a PRM
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Write the plan of the slews and holds, as `slew plan` does: .json, .aem, .bc, .csv and others
    #[arg(long, value_name = "FILE", requires = "spec")]
    pub plan: Option<PathBuf>,
    /// Show that plan as one page for a browser
    #[arg(long, value_name = "FILE.html", requires = "spec")]
    pub report: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
    /// `json` prints the report on stdout
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: ReportFormat,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl Args {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: self.format == ReportFormat::Json }
    }

    /// Returns the output file, and true if its format is PTR, false for PRM; `None` if no file is
    /// requested. The file name is checked before any other work.
    fn target(&self) -> Result<Option<(Target, bool)>, Failure> {
        let Some(path) = &self.output else { return Ok(None) };
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let ptr = match ending.as_deref() {
            Some("ptx") => true,
            Some("xml" | "prm") => false,
            _ => {
                let reason = format!(
                    "{} does not have the ending of a pointing file",
                    escape(&path.to_string_lossy())
                );
                let remedy = "end it in .ptx for a PTR, or in .xml or .prm for a PRM";
                return Err(Failure::Output(Message::new("E0105", reason, remedy)));
            }
        };
        let target = Target::new(path, self.force)?;
        for input in [Some(&self.file), self.spec.as_ref()].into_iter().flatten() {
            target.distinct_from(input)?;
        }
        Ok(Some((target, ptr)))
    }
}

/// Delay above which a slew counts as late \[s\]. It allows for the round-off of a slew that uses
/// all its available time.
const LATE: f64 = 1e-6;

/// Slew to an observation, with its available and its planned time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Slew {
    /// Time between the previous observation and this one in the file \[s\].
    available_s: f64,
    /// Duration of the planned slew \[s\]; `None` if no slew was planned.
    planned_s: Option<f64>,
    /// Status of the planned slew; `None` if no slew was planned.
    status: Option<Status>,
}

impl Slew {
    /// Returns whether the planned slew takes longer than the time available.
    fn is_late(&self) -> bool {
        self.planned_s.is_some_and(|planned| planned - self.available_s > LATE)
    }
}

/// Data from which the report on a pointing file is made.
struct Told {
    /// Pointing file, with the planned times and attitudes if slews were planned.
    file: PointingFile,
    /// Slew to each observation; `None` for the first observation if the spacecraft starts in its
    /// attitude.
    slews: Vec<Option<Slew>>,
    /// Assumptions that could not be verified, one sentence each, without the final period.
    open: Vec<String>,
    /// Status of the plan of all slews; `None` if no slews were planned.
    status: Option<Status>,
    /// Name of the originator for the header of a PRM.
    originator: String,
}

/// Runs `slew timeline` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let inputs: Vec<&Path> = std::iter::once(&args.file).chain(&args.spec).map(PathBuf::as_path).collect();
    spec_file::one_stdin(&inputs)?;
    let target = args.target()?;
    let name = args.file.to_string_lossy().into_owned();
    let file = read_pointing(spec_file::open_plan(&args.file)?, &name)?;
    let told = match &args.spec {
        Some(spec) => planned(&file, &name, spec, args, console)?,
        None => {
            let told = unplanned(file);
            console.say(&told.lines(console, &name).join("\n"));
            told
        }
    };
    if args.format == ReportFormat::Json {
        console::to_stdout(|output| write_document(&told.document(), output))?;
    }
    let whole = told.slews.len() == told.file.observations.len();
    if let (Some(_), false) = (&target, whole) {
        console.say(&summary::line("wrote", "no timeline: the plan does not reach its end"));
    }
    if let Some((target, ptr)) = target.as_ref().filter(|_| whole) {
        interrupt::writing();
        target
            .write(|output| match ptr {
                true => told.file.write_ptr(output),
                false => told.file.write_prm(&formats::now(), &told.originator, output),
            })
            .map_err(|error| match error {
                ExportError::Lacking(lacking) => {
                    Failure::Output(Message::new(lacking.code(), lacking.to_string(), lacking.remedy()))
                }
                other => other.into(),
            })?;
        summary::wrote(console, target);
    }
    Ok(match told.status {
        None | Some(Status::Solved) => Exit::Solved,
        Some(status) => Exit::Plan(status),
    })
}

/// Creates the report on a pointing file without planning any slews.
fn unplanned(file: PointingFile) -> Told {
    let gaps = file.observations.windows(2).map(|pair| pair[1].begin.since(&pair[0].end));
    let slew = |available_s| Some(Slew { available_s, planned_s: None, status: None });
    let slews = std::iter::once(None).chain(gaps.map(slew)).collect();
    let open = file.not_taken.clone();
    Told { slews, open, status: None, originator: "UNKNOWN".into(), file }
}

/// Plans the slews between the observations of a pointing file, and writes the plan.
fn planned(
    file: &PointingFile,
    name: &str,
    spec: &Path,
    args: &Args,
    console: &mut Console,
) -> Result<Told, Failure> {
    let inputs = [args.file.as_path(), spec];
    let output = OutputArgs { format: None, output: args.plan.clone(), force: args.force, quiet: args.quiet };
    let destination = output.destination(Format::value_variants(), &inputs)?;
    let page = args.report.as_deref().map(|path| report::target(path, args.force, &inputs)).transpose()?;
    let Loaded { problem, settings, mut identity, files, .. } =
        spec_file::read(spec, &args.reading, console)?;
    destination.distinct_from(&files)?;
    let timeline = Timeline::new(file, name, &problem, &identity)?;
    identity.epoch = Some(timeline.zero);
    let tables = export::TableArgs::default().checked(&destination)?;
    let sequence = timeline.sequence.clone();
    let loaded = LoadedSequence {
        sequence,
        settings,
        expect: None,
        identity,
        closed_loop: ClosedLoop::default(),
        files,
        warnings: Vec::new(),
    };
    let LoadedSequence { sequence, settings, identity, .. } = &loaded;
    export::check(&destination, &sequence.craft, identity)?;
    interrupt::watch();
    let plan = sequence.plan(settings, &mut Watcher(console));
    console.clear_progress();
    let plan = plan.map_err(|error| refusal(&error))?;
    let mut slews: Vec<Option<Slew>> = vec![None; timeline.first];
    for (leg, available_s) in plan.legs.iter().zip(timeline.available()) {
        let lasting = leg.plan.solution.trajectory.time.last().copied();
        slews.push(Some(Slew { available_s, planned_s: lasting, status: Some(leg.plan.status) }));
    }
    let mut found = timeline.resolved(file, &plan);
    found.object = found.object.or(identity.object.clone());
    found.object_id = found.object_id.or(identity.object_id.clone());
    let told = Told {
        file: found,
        slews,
        open: timeline.open,
        status: Some(plan.status()),
        originator: identity.originator.clone().unwrap_or("UNKNOWN".into()),
    };
    console.say(&told.lines(console, name).join("\n"));
    interrupt::writing();
    let written = SequenceFile::new(&loaded, &plan);
    destination.write(console, |format, output| {
        let format = format.of_data().unwrap_or(formats::Format::Json);
        format.write_sequence(&written, &sequence.craft, identity, tables, output)
    })?;
    if let Some(page) = &page {
        report::write(page, &sequence_page(&written, &loaded, EULER), console)?;
    }
    Ok(told)
}

/// Returns the attitude during an observation; `None` if the file does not determine it.
fn attitude(observation: &Observation) -> Option<Matrix3> {
    match observation.target {
        pointing::Target::Inertial(target) => observation.attitude(&target),
        pointing::Target::Sun => None,
    }
}

/// Formats a date and time of day with a resolution of a millisecond.
fn milliseconds(moment: &Epoch) -> String {
    moment.calendar_text().chars().take("2032-12-26T10:15:31.000".len()).collect()
}

/// Largest number of characters of an observation's name that the summary shows.
const NAME: usize = 16;
/// Largest number of observations that the summary lists.
const SHOWN: usize = 30;

impl Told {
    /// Returns each observation with its number (counted from 1), its attitude, and the slew to it.
    fn rows(&self) -> impl Iterator<Item = (usize, &Observation, Option<Matrix3>, Option<Slew>)> {
        let slews = self.slews.iter().copied().chain(std::iter::repeat(None));
        let rows = self.file.observations.iter().zip(slews).enumerate();
        rows.map(|(index, (observation, slew))| (index + 1, observation, attitude(observation), slew))
    }

    /// Returns the lines of the summary of the timeline.
    fn lines(&self, console: &Console, name: &str) -> Vec<String> {
        let file = &self.file;
        let (verdict, tone) = match self.status {
            None => ("read", Tone::Good),
            Some(Status::Solved) => ("planned and verified", Tone::Good),
            Some(Status::NotConverged) => ("not planned as requested", Tone::Bad),
            Some(status) => (status.name(), Tone::Bad),
        };
        let mut lines = vec![summary::headline(console, &escape(name), verdict, tone)];
        let observed: f64 = file.observations.iter().map(Observation::lasting).sum();
        let observations = counted(file.observations.len(), "observation");
        lines.line("timeline", format!("{observations}, {} s observed", short(observed)));
        if let [first, .., last] | [first @ last] = &file.observations[..] {
            lines.line("from", first.begin.to_string());
            lines.line("to", last.end.to_string());
        }
        let frames = format!("from {} to {}", file.body_frame, file.reference_frame);
        lines.line("attitude", escape(&frames));
        let head = [("turn", 9), ("slew has", 12), ("takes", 11), ("begins", 25), ("lasts", 11)];
        let head: String = head.iter().map(|(word, width)| format!("{word:>width$}")).collect();
        lines.line("blocks", format!("{:<NAME$}{head}", ""));
        let mut before = None;
        for (number, observation, attitude, slew) in self.rows().take(SHOWN) {
            let name = observation.name.as_deref().map_or(format!("{number}"), escape);
            let name: String = name.chars().take(NAME - 1).collect();
            let turned = before.zip(attitude).map(|(from, to): (Matrix3, Matrix3)| {
                format!("{:.1}°", lie::log(&(from.transpose() * to)).norm().to_degrees())
            });
            let seconds = |time: Option<f64>| time.map_or("-".into(), |time| format!("{time:.2} s"));
            let (has, takes) = (slew.map(|slew| slew.available_s), slew.and_then(|slew| slew.planned_s));
            lines.line(
                "",
                format!(
                    "{name:<NAME$}{:>9}{:>12}{:>11}{:>25}{:>11}",
                    turned.unwrap_or("-".into()),
                    seconds(has),
                    seconds(takes),
                    milliseconds(&observation.begin),
                    seconds(Some(observation.lasting()))
                ),
            );
            before = attitude;
        }
        if file.observations.len() > SHOWN {
            lines.line("", format!("… {observations} in all; --format json has them"));
        }
        for (number, observation, _, slew) in self.rows() {
            let Some(slew) = slew.filter(Slew::is_late) else { continue };
            let name = observation.name.as_deref().map_or(format!("observation {number}"), escape);
            lines.line(
                "violated",
                format!(
                    "the slew to {name} takes {} s and has {} s",
                    short(slew.planned_s.unwrap_or(0.0)),
                    short(slew.available_s)
                ),
            );
        }
        lines.texts("open", self.open.iter().map(|text| escape(text)));
        lines
    }

    /// Returns the report as a JSON document.
    fn document(&self) -> impl Serialize {
        let observations: Vec<_> = self
            .rows()
            .map(|(_, observation, attitude, slew)| {
                document! {
                    name: observation.name.clone(),
                    begins: observation.begin.to_string(),
                    ends: observation.end.to_string(),
                    quaternion_wxyz: attitude.map(|attitude| lie::quaternion_from_rotation(&attitude)),
                    slew: slew,
                }
            })
            .collect();
        document! {
            status: self.status.map_or("read", Status::name),
            body_frame: self.file.body_frame.clone(),
            reference_frame: self.file.reference_frame.clone(),
            observations: observations,
            open: self.open.clone(),
        }
    }
}
