//! Arguments that several commands share.

use super::{Failure, console};
use clap::ValueEnum;
use serde::Serialize;
use slewkit::files::export::{Target, write_document};
use std::path::{Path, PathBuf};

/// What is needed to report a failure, whatever the command.
#[derive(Clone, Copy, Debug, Default)]
pub struct Common {
    /// No text but errors.
    pub quiet: bool,
    /// A failure is a JSON document on stdout too.
    pub json: bool,
}

/// The spec of a command.
#[derive(Debug, clap::Args)]
pub struct SpecArgs {
    /// Spec file; `-` reads stdin
    #[arg(value_name = "SPEC")]
    pub spec: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
}

/// How a spec is read.
#[derive(Debug, clap::Args)]
pub struct Reading {
    /// Override a key of the spec, as in `--set maneuver.steps=2000`; may be repeated
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    pub set: Vec<String>,
    /// Notation of the spec; by default that of the file name, TOML from stdin
    #[arg(long, value_name = "FORMAT")]
    pub input: Option<Notation>,
}

/// Notation of a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Notation {
    /// TOML
    Toml,
    /// JSON
    Json,
}

/// Output of a command that makes a trajectory.
#[derive(Debug, clap::Args)]
pub struct OutputArgs {
    /// Format of the data, on stdout or in the file of `-o`; by default that of the file name, else JSON
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<Format>,
    /// Write the data to FILE, whole or not at all; `-` is stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    pub force: bool,
    /// No text but errors
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
}

/// Where data go.
#[derive(Debug)]
pub enum Destination {
    /// Nowhere: text only.
    None,
    /// Stdout.
    Stdout(Format),
    /// A file.
    File(Target, Format),
}

impl OutputArgs {
    /// The part that failures need.
    pub fn common(&self) -> Common {
        let json = matches!(self.format, Some(Format::Json | Format::Jsonl));
        Common { quiet: self.quiet, json }
    }

    /// Where the data go, checked before any work; an output that is one of `inputs` is refused.
    pub fn destination(&self, inputs: &[&Path]) -> Result<Destination, Failure> {
        let asked = self.format.filter(|format| *format != Format::Text);
        let Some(path) = &self.output else {
            return Ok(asked.map_or(Destination::None, Destination::Stdout));
        };
        if path.as_os_str() == "-" {
            return Ok(Destination::Stdout(asked.unwrap_or(Format::Json)));
        }
        if self.format == Some(Format::Text) {
            let reason =
                "-o writes data, and the text for people goes to stderr: leave out --format text, or -o";
            return Err(Failure::Usage(reason.into()));
        }
        let target = Target::new(path, self.force)?;
        for input in inputs {
            target.distinct_from(input)?;
        }
        let by_ending = match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Format::Csv,
            Some("jsonl" | "ndjson") => Format::Jsonl,
            _ => Format::Json,
        };
        Ok(Destination::File(target, asked.unwrap_or(by_ending)))
    }
}

/// Output of a command that makes a report.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// `json` prints the report on stdout
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: ReportFormat,
    /// No text but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Format of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReportFormat {
    /// Text for people
    Text,
    /// One document
    Json,
}

impl ReportArgs {
    /// Whether the report is a document on stdout.
    pub fn json(&self) -> bool {
        self.format == ReportFormat::Json
    }

    /// Prints the report where it is asked for.
    pub fn print(&self, document: &impl Serialize) -> Result<(), Failure> {
        if self.json() {
            console::to_stdout(|output| write_document(document, output))?;
        }
        Ok(())
    }

    /// The part that failures need.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: self.json() }
    }
}
