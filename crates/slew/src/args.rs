//! Arguments that several commands share.

use super::{Failure, console};
use clap::ValueEnum;
use serde::Serialize;
use slewkit_files::export::write_document;
use std::path::PathBuf;

/// The options that determine how a failure of any command is reported.
#[derive(Clone, Copy, Debug, Default)]
pub struct Common {
    /// True if all text except errors is suppressed.
    pub quiet: bool,
    /// A failure is also written to stdout as a JSON document.
    pub json: bool,
}

/// Path of the spec of a command, with the options for reading it.
#[derive(Debug, clap::Args)]
pub struct SpecArgs {
    /// Spec file; `-` reads stdin
    #[arg(value_name = "SPEC")]
    pub spec: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
}

/// The options for reading a spec.
#[derive(Debug, clap::Args)]
pub struct Reading {
    /// Override a key of the spec, as in `--set maneuver.steps=2000`; may be repeated
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    pub set: Vec<String>,
    /// Notation of the spec; by default the ending of the file selects it, TOML for stdin
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

impl Notation {
    /// Returns the name that `--input` accepts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Toml => "toml",
            Self::Json => "json",
        }
    }
}

/// Output of a command that makes a report.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// `json` prints the report on stdout
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: ReportFormat,
    /// Print errors only
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
    /// Returns whether the report is a document on stdout.
    pub fn json(&self) -> bool {
        self.format == ReportFormat::Json
    }

    /// Prints the report on stdout as a JSON document, if `--format json` is given.
    pub fn print(&self, document: &impl Serialize) -> Result<(), Failure> {
        if self.json() {
            console::to_stdout(|output| write_document(document, output))?;
        }
        Ok(())
    }

    /// Returns the options that determine how a failure is reported.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: self.json() }
    }
}
