//! `slew plot`: the pictures of a plan, a simulation, a comparison or the results of a batch as SVG files.

use super::pictured::{self, Drawing, Kind};
use super::{Common, Console, Exit, Failure, Message, summary};
use slewkit::draw::{Picture, panel};
use slewkit::files::export::{FileError, SimulationFile, Target};
use slewkit::files::spec::escape;
use slewkit::report::{
    CASE_KEYS, COMPARISON_KEYS, ComparisonFile, KEYS, SIMULATION_KEYS, Shown, Subject, comparison_pictures,
    pictures, simulation_pictures,
};
use std::path::{Path, PathBuf};

/// Arguments of `slew plot`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A name that ends in .svg is one file: a panel of the pictures named by --charts in two columns,
marked (a), (b), …, or the one picture alone. Any other name is a folder, which is made if it
does not exist and gets one file a picture.

The pictures, where the plan has them: sky, inputs, forces, switching, rates, wheel_momentum,
position, velocity, clearance, euler, quaternion, error, costates_attitude, costates_momentum,
costates_position, costates_linear, hamiltonian, convergence.

Of a simulation, JSON: sky of one body, rates, position, euler, quaternion, energy,
angular_momentum, orthogonality. Of integrators compared, JSON: energy_over_step,
orthogonality_over_step, momentum_over_step, time_over_step, evaluations_precision,
work_precision. Of the results of a batch, JSON lines: cost (over one key), map (over two), distribution, miss.

Times at which a limit acts, or arcs, are shaded; a curve that diverges is cut and says so, and one that
lies under another says under which. SVG becomes PDF or PNG by any converter, as in
`rsvg-convert -f pdf figure.svg -o figure.pdf`.

Examples:
  slew plot plan.json -o figures
  slew plot plan.json -o figure.svg --charts sky,inputs,rates,clearance")]
pub struct Args {
    /// File that `slew plan SPEC -o FILE` or `slew simulate SPEC -o FILE` wrote, JSON, `-` reads stdin; or results of a
    /// batch, JSON lines
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// An SVG file, or a folder for one file a picture
    #[arg(short, long, value_name = "DIR|FILE.svg")]
    pub output: PathBuf,
    /// Which pictures, in this order; by default all in a folder, the first four in a file
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(keys()), hide_possible_values = true)]
    pub charts: Vec<String>,
    #[command(flatten)]
    pub drawing: Drawing,
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
    /// No text but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// The names of all pictures, each once.
fn keys() -> Vec<&'static str> {
    let mut keys = Vec::new();
    for key in KEYS.into_iter().chain(SIMULATION_KEYS).chain(CASE_KEYS).chain(COMPARISON_KEYS) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

/// Pictures of a panel where none are named.
const PANEL: usize = 4;

impl Args {
    /// The part that failures need.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: false }
    }

    /// Whether all go into one file.
    fn one_file(&self) -> Result<bool, Failure> {
        match self.output.extension().and_then(|ending| ending.to_str()) {
            None => Ok(false),
            Some(ending) if ending.eq_ignore_ascii_case("svg") => Ok(true),
            Some(_) if self.output.is_dir() => Ok(false),
            Some(ending) => Err(Failure::Usage(format!(
                "-o: pictures are written as .svg, or into a folder, whose name has no ending; not as .{}",
                escape(ending)
            ))),
        }
    }

    fn target(&self, path: impl Into<PathBuf>) -> Result<Target, Failure> {
        let target = Target::new(path, self.force)?;
        target.distinct_from(&self.plan)?;
        Ok(target)
    }

    /// Those of `shown` that are asked for, in that order.
    fn chosen<'a>(&self, shown: &'a [Shown]) -> Result<Vec<&'a Shown>, Failure> {
        let find = |key: &String| {
            shown.iter().find(|shown| shown.key == *key).ok_or_else(|| {
                let there: Vec<&str> = shown.iter().map(|shown| shown.key).collect();
                let reason = format!("there is no picture \"{key}\"");
                Failure::Usage(format!("--charts: {reason}; there are {}", there.join(", ")))
            })
        };
        self.charts.iter().map(find).collect()
    }
}

/// Runs the command.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let one_file = args.one_file()?;
    let target = one_file.then(|| args.target(&args.output)).transpose()?;
    let (loaded, plan) = match pictured::open(&args.plan)? {
        (Kind::Plan, input) => pictured::read(&args.plan, input, console)?,
        (Kind::Results, _) => {
            let shown = pictured::results(&args.plan)?.pictures();
            return draw(args, target, &shown, console);
        }
        (Kind::Comparison, input) => {
            let file = ComparisonFile::read(input).map_err(|error| Failure::unusable(&args.plan, &error))?;
            return draw(args, target, &comparison_pictures(&file), console);
        }
        (Kind::Simulation, input) => {
            let file = SimulationFile::read(input).map_err(|error| Failure::unusable(&args.plan, &error))?;
            return draw(args, target, &simulation_pictures(&file, &args.drawing.euler), console);
        }
    };
    let shown = pictures(&Subject::new(&loaded.problem, &plan, &loaded.identity, &args.drawing.euler));
    draw(args, target, &shown, console)
}

/// Writes the pictures that are asked for.
fn draw(
    args: &Args,
    target: Option<Target>,
    shown: &[Shown],
    console: &mut Console,
) -> Result<Exit, Failure> {
    if shown.is_empty() {
        let reason = format!("{}: there is nothing to draw", escape(&args.plan.to_string_lossy()));
        let remedy = "`slew report` tells why there is none";
        return Err(Failure::File(Message::new("E0108", reason, remedy)));
    }
    let chosen = args.chosen(shown)?;
    if let Some(target) = target {
        let chosen: Vec<&Picture> = match chosen.is_empty() {
            true => shown.iter().take(PANEL).map(|shown| &shown.picture).collect(),
            false => chosen.iter().map(|shown| &shown.picture).collect(),
        };
        write(&target, &panel(&chosen), console)?;
    } else {
        let chosen = if chosen.is_empty() { shown.iter().collect() } else { chosen };
        folder(&args.output)?;
        let file = |shown: &&Shown| args.target(args.output.join(format!("{}.svg", shown.key)));
        // All names are checked before the first file is written.
        let targets = chosen.iter().map(file).collect::<Result<Vec<_>, _>>()?;
        for (shown, target) in chosen.iter().zip(&targets) {
            write(target, &shown.picture.svg(), console)?;
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

fn write(target: &Target, text: &str, console: &mut Console) -> Result<(), Failure> {
    target.write(|output| Ok(output.write_all(text.as_bytes())?))?;
    summary::wrote(console, target);
    Ok(())
}
