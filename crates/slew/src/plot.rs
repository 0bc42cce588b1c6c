//! `slew plot`: the pictures of a plan, a simulation, a comparison or the results of a batch as SVG
//! files.

use super::pictured::{self, Drawing, Kind, Pictured};
use super::{Common, Console, Exit, Failure, Message, Reading, interrupt, summary};
use slewkit_files::export::{FileError, SimulationFile, Target};
use slewkit_files::spec::escape;
use slewkit_report::draw::{Picture, panel};
use slewkit_report::{
    CASE_KEYS, COMPARISON_KEYS, ComparisonFile, INTEGRATOR_KEYS, KEYS, SEQUENCE_KEYS, SIMULATION_KEYS, Shown,
    Subject, comparison_pictures, pictures, sequence_pictures, simulation_pictures,
};
use std::path::{Path, PathBuf};

/// Arguments of `slew plot`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A name that ends in .svg, .png or .pdf is one file. It holds the pictures of --charts in --columns, marked
(a), (b), …, or one picture alone. Any other name is a folder. slew creates it if needed, and writes one file for
each picture.

The pictures of a plan, if it has the data: sky, around, ground, inputs, forces, firings, switching, rates,
wheel_momentum, position, velocity, clearance, pointing, corrections, flown_pointing, flown_commands, euler,
quaternion, error, costates_attitude, costates_momentum, costates_position, costates_linear, hamiltonian,
convergence.

The pictures of a simulation (JSON): sky of one body, rates, position, euler, quaternion, energy,
angular_momentum, orthogonality. The pictures of compared integrators (JSON): energy_over_step,
orthogonality_over_step, momentum_over_step, time_over_step, evaluations_precision,
work_precision. The pictures of the results of a batch (JSON lines): cost (over one key), map (over two keys),
distribution, miss.

Shading marks arcs and times at which a limit is active. A label marks a curve that is cut because it diverges,
and a curve that lies under another. PNG and PDF need the cargo feature `paper`. Without it any converter makes
them from SVG, as in `rsvg-convert -f pdf figure.svg -o figure.pdf`.

Examples:
  slew plot plan.json -o figures
  slew plot plan.json -o figure.svg --charts sky,inputs,rates,clearance")]
pub struct Args {
    /// File that `slew plan SPEC -o FILE` or `slew simulate SPEC -o FILE` wrote, JSON, `-` reads
    /// stdin; or results of a batch, JSON lines
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// An SVG, PNG or PDF file, or a folder for one SVG file a picture
    #[arg(short, long, value_name = "DIR|FILE.svg")]
    pub output: PathBuf,
    /// Names of the pictures, in this order; by default all in a folder, the first four in a file
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub charts: Vec<String>,
    /// Number of columns of a file with several pictures; one is as wide as a page of text
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=4))]
    pub columns: u8,
    #[command(flatten)]
    pub drawing: Drawing,
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Format of an output file with pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Svg,
    Png,
    Pdf,
}

impl Format {
    /// Converts an SVG picture to the contents of a file in this format.
    #[cfg(feature = "paper")]
    fn bytes(self, svg: String) -> Result<Vec<u8>, Failure> {
        use slewkit_report::draw::paper::{PaperError, pdf, png};
        /// Number of PNG pixels per SVG pixel; the value 2 gives 192 pixels per inch.
        const SCALE: f32 = 2.0;
        let made = match self {
            Self::Svg => Ok(svg.into_bytes()),
            Self::Png => png(&svg, SCALE),
            Self::Pdf => pdf(&svg),
        };
        made.map_err(|error| {
            let remedy = match error {
                PaperError::NoFont => {
                    "install one (Debian: `apt-get install fonts-dejavu-core`), or write a .svg"
                }
                PaperError::Unreadable(_) => "write a .svg",
            };
            Failure::File(Message::new("E0108", error.to_string(), remedy))
        })
    }

    /// Returns the contents of an SVG file. Without the feature `paper`, an earlier check rejects
    /// all other formats.
    #[cfg(not(feature = "paper"))]
    fn bytes(self, svg: String) -> Result<Vec<u8>, Failure> {
        Ok(svg.into_bytes())
    }
}

/// Returns the names of all pictures, each of them once.
fn keys() -> Vec<&'static str> {
    let mut keys = Vec::new();
    let compared = COMPARISON_KEYS.into_iter().chain(INTEGRATOR_KEYS.iter().copied());
    for key in KEYS.into_iter().chain(SEQUENCE_KEYS).chain(SIMULATION_KEYS).chain(CASE_KEYS).chain(compared) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

/// Default number of pictures in a single output file.
const PANEL: usize = 4;

impl Args {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }

    /// Returns the format of the output if it is a single file; `None` if it is a folder.
    fn one_file(&self) -> Result<Option<Format>, Failure> {
        let ending = self.output.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let format = match ending.as_deref() {
            None => return Ok(None),
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            Some("pdf") => Format::Pdf,
            Some(_) if self.output.is_dir() => return Ok(None),
            Some(ending) => {
                return Err(Failure::Usage(format!(
                    "-o: pictures are .svg, .png or .pdf, or files in a folder whose name has no \
                    ending; not .{}",
                    escape(ending)
                )));
            }
        };
        if format != Format::Svg && cfg!(not(feature = "paper")) {
            return Err(Failure::Usage(
                "-o: PNG and PDF need converters, and this `slew` was built without them: write a \
                .svg and convert it, as in `rsvg-convert figure.svg -o figure.png`, or build with \
                `cargo install --path crates/slew --features paper`"
                    .into(),
            ));
        }
        Ok(Some(format))
    }

    fn target(&self, path: impl Into<PathBuf>) -> Result<Target, Failure> {
        let target = Target::new(path, self.force)?;
        target.distinct_from(&self.plan)?;
        Ok(target)
    }

    /// Returns the requested pictures in the requested order; `shown` are all pictures that exist.
    fn chosen<'a>(&self, shown: &'a [Shown]) -> Result<Vec<&'a Shown>, Failure> {
        let find = |key: &String| {
            shown.iter().find(|shown| shown.key == *key).ok_or_else(|| {
                let there: Vec<&str> = shown.iter().map(|shown| shown.key).collect();
                let known = if keys().contains(&key.as_str()) {
                    "this file has no picture"
                } else {
                    "no picture is called"
                };
                let reason = format!("{known} \"{}\"", escape(key));
                Failure::Usage(format!("--charts: {reason}; its pictures are {}", there.join(", ")))
            })
        };
        self.charts.iter().map(find).collect()
    }
}

/// Runs `slew plot` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    interrupt::end_at_once();
    let one_file = args.one_file()?;
    let target = one_file.map(|format| Ok::<_, Failure>((args.target(&args.output)?, format))).transpose()?;
    let Pictured { loaded, plan, exit, .. } = match pictured::open(&args.plan)? {
        (Kind::Plan, input) => pictured::read(&args.plan, input, console)?,
        (Kind::Results, _) => {
            let shown = pictured::results(&args.plan)?.pictures();
            return draw(args, target, &shown, console);
        }
        (Kind::Comparison, input) => {
            let file = ComparisonFile::read(input).map_err(|error| Failure::unusable(&args.plan, &error))?;
            return draw(args, target, &comparison_pictures(&file), console);
        }
        (Kind::Sequence, input) => {
            let reading = Reading { set: Vec::new(), input: None };
            let (file, loaded, exit) = pictured::sequence(&args.plan, input, &reading, console)?;
            draw(args, target, &sequence_pictures(&file, &loaded, &args.drawing.euler), console)?;
            return Ok(exit);
        }
        (Kind::Simulation, input) => {
            let file = SimulationFile::read(input).map_err(|error| Failure::unusable(&args.plan, &error))?;
            return draw(args, target, &simulation_pictures(&file, &args.drawing.euler), console);
        }
    };
    let subject = Subject::new(&loaded.problem, &plan, &loaded.identity, &args.drawing.euler);
    let shown = pictures(&subject.flown_with(&loaded.closed_loop));
    draw(args, target, &shown, console)?;
    Ok(exit)
}

/// Writes the requested pictures into one file or into a folder.
fn draw(
    args: &Args,
    target: Option<(Target, Format)>,
    shown: &[Shown],
    console: &mut Console,
) -> Result<Exit, Failure> {
    if shown.is_empty() {
        let reason = format!("{}: the plan has nothing to draw", escape(&args.plan.to_string_lossy()));
        let remedy = "`slew report` states the reason";
        return Err(Failure::File(Message::new("E0108", reason, remedy)));
    }
    let chosen = args.chosen(shown)?;
    if let Some((target, format)) = target {
        let chosen: Vec<&Picture> = match chosen.is_empty() {
            true => shown.iter().take(PANEL).map(|shown| &shown.picture).collect(),
            false => chosen.iter().map(|shown| &shown.picture).collect(),
        };
        write(&target, &format.bytes(panel(&chosen, args.columns.into()))?, console)?;
    } else {
        let chosen = if chosen.is_empty() { shown.iter().collect() } else { chosen };
        folder(&args.output)?;
        let file = |shown: &&Shown| args.target(args.output.join(format!("{}.svg", shown.key)));
        // All output paths are checked before the first file is written.
        let targets = chosen.iter().map(file).collect::<Result<Vec<_>, _>>()?;
        for (shown, target) in chosen.iter().zip(&targets) {
            write(target, shown.picture.svg().as_bytes(), console)?;
        }
    }
    Ok(Exit::Solved)
}

fn folder(path: &Path) -> Result<(), Failure> {
    if !path.exists() {
        let folder = escape(&path.to_string_lossy());
        std::fs::create_dir_all(path).map_err(|reason| FileError::NotWritable { folder, reason })?;
    }
    Ok(())
}

fn write(target: &Target, bytes: &[u8], console: &mut Console) -> Result<(), Failure> {
    target.write(|output| Ok(output.write_all(bytes)?))?;
    summary::wrote(console, target);
    Ok(())
}
