//! Output formats of a plan, and the file name extensions that select them.

use crate::epoch::Epoch;
use crate::exchange::{self, AemVersion, Lacking, Record, Tables};
use crate::export::{ExportError, PlanFile, SequenceFile, write_csv, write_jsonl};
use crate::flown::FeedbackRecord;
use crate::identity::Identity;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::numerics::figures::error;
use slewkit::sequence::joined::Joined;
use slewkit::verify::Verification;
use std::borrow::Cow;
use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// An output format of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Plan file: one JSON document with the whole plan.
    Json,
    /// Trajectory as JSON lines, one object per node.
    Jsonl,
    /// Trajectory as a comma-separated table with a header.
    Csv,
    /// A format of another program.
    Exchange(exchange::Format),
}

impl Format {
    /// All formats. If several formats share a file name extension, the extension selects the first
    /// of these formats.
    pub const ALL: [Self; 17] = {
        use exchange::Format as Other;
        [
            Self::Json,
            Self::Jsonl,
            Self::Csv,
            Self::Exchange(Other::Aem(AemVersion::Two)),
            Self::Exchange(Other::AemXml),
            Self::Exchange(Other::Aem(AemVersion::One)),
            Self::Exchange(Other::Apm),
            Self::Exchange(Other::Stk),
            Self::Exchange(Other::Ck),
            Self::Exchange(Other::Sclk),
            Self::Exchange(Other::Fk),
            Self::Exchange(Other::Npz),
            Self::Exchange(Other::Mat),
            Self::Exchange(Other::Parquet),
            Self::Exchange(Other::Basilisk),
            Self::Exchange(Other::FortyTwo),
            Self::Exchange(Other::Flight),
        ]
    };

    /// Returns the name of the format and the file name extensions that it may have.
    fn terms(self) -> (&'static str, &'static [&'static str]) {
        use exchange::Format as Other;
        match self {
            Self::Json => ("json", &["json"]),
            Self::Jsonl => ("jsonl", &["jsonl", "ndjson"]),
            Self::Csv => ("csv", &["csv"]),
            Self::Exchange(Other::Aem(AemVersion::Two)) => ("aem", &["aem"]),
            Self::Exchange(Other::AemXml) => ("aem-xml", &["xml"]),
            Self::Exchange(Other::Aem(AemVersion::One)) => ("aem1", &["aem"]),
            Self::Exchange(Other::Apm) => ("apm", &["apm"]),
            Self::Exchange(Other::Stk) => ("stk", &["a"]),
            Self::Exchange(Other::Ck) => ("ck", &["bc"]),
            Self::Exchange(Other::Sclk) => ("sclk", &["tsc"]),
            Self::Exchange(Other::Fk) => ("fk", &["tf"]),
            Self::Exchange(Other::Npz) => ("npz", &["npz"]),
            Self::Exchange(Other::Mat) => ("mat", &["mat"]),
            Self::Exchange(Other::Parquet) => ("parquet", &["parquet"]),
            Self::Exchange(Other::Basilisk) => ("basilisk", &["csv"]),
            Self::Exchange(Other::FortyTwo) => ("42", &["42"]),
            Self::Exchange(Other::Flight) => ("flight", &["flight", "csv"]),
        }
    }

    /// Returns the name of the format on the command line.
    pub fn name(self) -> &'static str {
        self.terms().0
    }

    /// Returns the file name extensions that the format may have.
    pub fn endings(self) -> &'static [&'static str] {
        self.terms().1
    }

    /// Returns the format with the command-line name `name`; `None` if no format has this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Returns the format that a file name extension such as `json` selects; `None` if it selects
    /// none.
    pub fn of_ending(ending: &str) -> Option<Self> {
        let ending = ending.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.endings().contains(&&*ending))
    }

    /// Checks that the maneuver has all data that the format requires.
    ///
    /// # Errors
    /// Returns the first requirement of the format that is not met.
    pub fn check(self, problem: &Problem, identity: &Identity) -> Result<(), Lacking> {
        let Self::Exchange(format) = self else { return Ok(()) };
        format.check(&record(
            problem,
            identity,
            &Trajectory::default(),
            Vec::new(),
            Tables::default(),
            Vec::new(),
            None,
        ))
    }

    /// Returns whether the format can hold the margins to limits and constraints.
    pub fn tells_margins(self) -> bool {
        matches!(self, Self::Csv | Self::Exchange(exchange::Format::Parquet))
    }

    /// Writes the plan of `file`, which is a plan of `problem`, in this format.
    ///
    /// # Errors
    /// Returns an error if data that the format requires are missing, if a number is not finite, or
    /// if the output stream fails.
    pub fn write(
        self,
        file: &PlanFile<'_>,
        problem: &Problem,
        identity: &Identity,
        tables: Tables,
        output: &mut dyn Write,
    ) -> Result<(), ExportError> {
        let trajectory = &*file.trajectory.0;
        match self {
            Self::Json => file.clone().with_identity(identity).write(output),
            Self::Jsonl => write_jsonl(trajectory, output),
            Self::Csv => write_csv(trajectory, problem, identity, tables.margins, output),
            Self::Exchange(format) => {
                let notes = notes(file.verified.as_ref());
                let gains = file.feedback.as_ref();
                format.write(
                    &record(problem, identity, trajectory, switches(file), tables, notes, gains),
                    output,
                )
            }
        }
    }
}

impl Format {
    /// Writes the plan of a sequence on one time axis, with one segment for each leg and each hold.
    /// `craft` supplies the names and limits of the spacecraft, which all legs share.
    ///
    /// # Errors
    /// Returns an error if data that the format requires are missing, if a number is not finite, or
    /// if the output stream fails.
    pub fn write_sequence(
        self,
        file: &SequenceFile<'_>,
        craft: &Problem,
        identity: &Identity,
        tables: Tables,
        output: &mut dyn Write,
    ) -> Result<(), ExportError> {
        if self == Self::Json {
            return file.write(output);
        }
        let Joined { path, parts } = file.joined();
        match self {
            Self::Json => Ok(()),
            Self::Jsonl => write_jsonl(&path, output),
            Self::Csv => write_csv(&path, craft, identity, tables.margins, output),
            Self::Exchange(format) => {
                let inner = parts.iter().filter(|part| !part.rests).flat_map(|part| {
                    switches(&file.legs[part.leg]).into_iter().map(|node| part.nodes[0] + node)
                });
                let mut breaks: Vec<usize> = parts.iter().skip(1).map(|part| part.nodes[0]).collect();
                breaks.extend(inner);
                breaks.sort_unstable();
                breaks.dedup();
                let notes = vec![generated(), verified_legs(file)];
                format.write(&record(craft, identity, &path, breaks, tables, notes, None), output)
            }
        }
    }
}

/// Returns a comment that states whether the witnesses verified every leg of the sequence.
fn verified_legs(file: &SequenceFile<'_>) -> String {
    let passed = |leg: &PlanFile<'_>| leg.verified.as_ref().is_some_and(Verification::passed);
    if file.legs.iter().all(passed) { "verified: every leg" } else { "not verified" }.into()
}

/// Returns a comment that names this program and its version.
fn generated() -> String {
    format!("planned by slewkit {}", env!("CARGO_PKG_VERSION"))
}

/// Builds the record from which files for other programs are written.
fn record<'a>(
    problem: &'a Problem,
    identity: &'a Identity,
    trajectory: &'a Trajectory,
    switches: Vec<usize>,
    tables: Tables,
    notes: Vec<String>,
    gains: Option<&'a FeedbackRecord>,
) -> Record<'a> {
    Record {
        problem,
        identity: Cow::Borrowed(identity),
        trajectory,
        switches,
        created: now(),
        tables,
        notes,
        gains: gains.map(Cow::Borrowed),
    }
}

/// Returns the indices of the nodes at which inputs switch; empty if the plan does not consist of
/// arcs.
fn switches(file: &PlanFile<'_>) -> Vec<usize> {
    let trajectory = &*file.trajectory.0;
    let arcs = file.switching.as_ref().map_or(&[][..], |switching| &switching.arcs);
    // The direction of a torque with a norm limit may change in every step. Such a torque counts as
    // switching only where it is turned on or off.
    let turns = arcs.iter().any(|arc| arc.input.is_empty());
    let is_off = |k: usize| trajectory.inputs(k).iter().all(|input| *input == 0.0);
    let switches = |k: &usize| {
        if turns { is_off(k - 1) != is_off(*k) } else { trajectory.inputs(k - 1) != trajectory.inputs(*k) }
    };
    // If the inputs are given at the nodes, as for Lie–Verlet, an input changes from one limit to
    // the other within a step, and no node is a switching time.
    let held = trajectory.torque.len() < trajectory.time.len();
    let nodes = if arcs.is_empty() || !held { 0 } else { trajectory.torque.len() };
    (1..nodes).filter(switches).collect()
}

/// Returns the comments for a plan: the program that wrote it, and whether it is verified.
fn notes(verification: Option<&Verification>) -> Vec<String> {
    let mut notes = vec![generated()];
    notes.push(match verification {
        Some(found) if found.passed() => format!(
            "verified: the motion under the held torque ends within {} rad of the target",
            error(found.continuous_attitude_rad)
        ),
        _ => "not verified".into(),
    });
    notes
}

/// Returns the creation date for messages: the current time or, for reproducible files, the time in
/// the environment variable `SOURCE_DATE_EPOCH`.
pub fn now() -> Epoch {
    let said = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    Epoch::of_unix(said.unwrap_or_else(clock))
}
