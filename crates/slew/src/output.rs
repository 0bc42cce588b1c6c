//! Destination and format of the data that a command writes.

use super::{Common, Console, Failure, Message, console, summary};
use clap::ValueEnum;
use slewkit_files::export::{ExportError, Target};
use slewkit_files::formats;
use slewkit_files::spec::escape;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Output of a command that makes a trajectory.
#[derive(Debug, clap::Args)]
pub struct OutputArgs {
    /// Format of the data, in the file of `-o`, or on stdout without a file; by default the ending of
    /// the file selects it, JSON for `-o -`
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// Write the data to FILE, completely or not at all; its ending selects the format. `-` is
    /// stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Format of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text for people on stderr, no data on stdout
    Text,
    /// One document with everything
    Json,
    /// The trajectory, one JSON object a line
    Jsonl,
    /// The trajectory as a table with a header
    Csv,
    /// CCSDS attitude ephemeris 2.0, keywords and values
    Aem,
    /// CCSDS attitude ephemeris 2.0, XML
    AemXml,
    /// CCSDS attitude ephemeris 1.0, for older programs
    Aem1,
    /// CCSDS attitude parameters 2.0: start, inertia, torque of every step
    Apm,
    /// STK attitude
    Stk,
    /// SPICE C-kernel, type 3 with rates; needs the clock kernel
    Ck,
    /// SPICE clock kernel for `ck`
    Sclk,
    /// SPICE frame kernel for `ck`
    Fk,
    /// NumPy arrays
    Npz,
    /// MATLAB, version 5
    Mat,
    /// Parquet, one row a node with the columns of `csv`; needs a build with the feature `parquet`
    Parquet,
    /// Table of waypoints for Basilisk
    Basilisk,
    /// Table for the simulator 42
    #[value(name = "42")]
    FortyTwo,
    /// Table of equal ticks with checksum, for on-board use
    Flight,
}

impl Format {
    /// Returns the data format; `None` for `text`, which is not a data format.
    pub fn of_data(self) -> Option<formats::Format> {
        formats::Format::named(&self.name())
    }

    /// Returns the file name extensions of the format. If several formats share an extension, it
    /// selects the first of them.
    fn endings(self) -> &'static [&'static str] {
        self.of_data().map_or(&[], formats::Format::endings)
    }

    /// Returns the name of the format as on the command line.
    fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().into())
    }
}

impl Destination {
    /// Returns an error if the output would overwrite one of `files`, to which the spec refers.
    pub fn distinct_from(&self, files: &[PathBuf]) -> Result<(), Failure> {
        if let Self::File(target, _) = self {
            files.iter().try_for_each(|file| target.distinct_from(file))?;
        }
        Ok(())
    }

    /// Returns the path of the output if it is a JSON file, which holds the whole plan; otherwise
    /// `None`.
    pub fn plan_file(&self) -> Option<&Path> {
        match self {
            Self::File(target, Format::Json) => Some(target.path()),
            _ => None,
        }
    }

    /// Returns the data format; `None` if no data are written.
    pub fn format(&self) -> Option<Format> {
        match self {
            Self::None => None,
            Self::Stdout(format) | Self::File(_, format) => Some(*format),
        }
    }

    /// Writes the data to the destination.
    pub fn write(
        &self,
        console: &mut Console,
        write: impl FnOnce(Format, &mut dyn Write) -> Result<(), ExportError>,
    ) -> Result<(), Failure> {
        match self {
            Self::None => {}
            Self::Stdout(format) => console::to_stdout(|output| write(*format, output))?,
            Self::File(target, format) => {
                target.write(|output| write(*format, output))?;
                console.say(&summary::line("wrote", &escape(&target.path().to_string_lossy())));
            }
        }
        Ok(())
    }
}

/// Destination of the data of a command, with the data format.
#[derive(Debug)]
pub enum Destination {
    /// No data are written; the command only prints text.
    None,
    /// The data are written to stdout.
    Stdout(Format),
    /// The data are written to a file.
    File(Target, Format),
}

impl OutputArgs {
    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        let json = matches!(self.format, Some(Format::Json | Format::Jsonl));
        Common { quiet: self.quiet, json }
    }

    /// Returns the destination of the data. Before any other work, checks that the format is one of
    /// `formats`, and that the output does not overwrite one of `inputs`.
    pub fn destination(&self, formats: &[Format], inputs: &[&Path]) -> Result<Destination, Failure> {
        if let Some(format) = self.format.filter(|format| !formats.contains(format)) {
            let reason = format!("this command does not write {}", format.name());
            return Err(Failure::Output(Message::new("E0107", reason, known(formats))));
        }
        let asked = self.format.filter(|format| *format != Format::Text);
        let Some(path) = &self.output else {
            return Ok(match asked {
                Some(format) => Destination::Stdout(format),
                None => Destination::None,
            });
        };
        // All these names mean stdout.
        if ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path.as_os_str() == *name) {
            return Ok(Destination::Stdout(asked.unwrap_or(Format::Json)));
        }
        if self.format == Some(Format::Text) {
            let reason = "-o writes data, and --format text is for people: remove --format text, or -o";
            return Err(Failure::Usage(reason.into()));
        }
        let target = Target::new(path, self.force)?;
        for input in inputs {
            target.distinct_from(input)?;
        }
        let format = of_file(path, asked, formats)?;
        Ok(Destination::File(target, format))
    }
}

/// Returns the format of the output file `path`: the requested format or, if none is requested, the
/// format that the file name extension selects. Returns an error if the two contradict each other.
fn of_file(path: &Path, asked: Option<Format>, formats: &[Format]) -> Result<Format, Failure> {
    let shown = escape(&path.to_string_lossy());
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let has = |format: &Format| ending.as_deref().is_some_and(|ending| format.endings().contains(&ending));
    let meant = formats.iter().copied().find(has);
    match (asked, meant) {
        // A file name without a known extension is allowed for every format.
        (Some(asked), None) => Ok(asked),
        (Some(asked), Some(_)) if has(&asked) => Ok(asked),
        (Some(asked), Some(meant)) => {
            let (asked_name, meant) = (asked.name(), meant.name());
            let reason = format!("{shown} ends as {meant} does, and --format is {asked_name}");
            let own = match asked.endings() {
                [first, ..] => format!("remove --format, or use the ending .{first}"),
                [] => "remove --format".into(),
            };
            Err(Failure::Output(Message::new("E0106", reason, own)))
        }
        (None, Some(meant)) => Ok(meant),
        (None, None) => {
            let reason = match &ending {
                Some(ending) => format!("{shown}: no format has the ending .{}", escape(ending)),
                None => format!("{shown} has no ending to select the format"),
            };
            Err(Failure::Output(Message::new("E0105", reason, known(formats))))
        }
    }
}

/// Returns a text that lists all formats with their file name extensions, for messages.
fn known(formats: &[Format]) -> String {
    let mut text = "the endings are".to_string();
    for format in formats.iter().filter(|format| !format.endings().is_empty()) {
        let endings: Vec<_> = format.endings().iter().map(|ending| format!(".{ending}")).collect();
        text.push_str(&format!("\n  {:<10} {}", format.name(), endings.join(", ")));
    }
    text.push_str("\n--format NAME allows any other name");
    text
}
