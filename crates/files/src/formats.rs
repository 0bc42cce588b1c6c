//! The formats in which a plan is written, and their endings of file names.

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

/// A format in which a plan is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The plan file: one JSON document with the whole plan.
    Json,
    /// The trajectory, one JSON object a line.
    Jsonl,
    /// The trajectory as a table with a header.
    Csv,
    /// A format of other programs.
    Exchange(exchange::Format),
}

impl Format {
    /// Every format. If several formats share an ending, the ending selects the first.
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

    /// Returns the name of the format, and the endings of the names of files that may hold it.
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

    /// Returns the name of the format on a command line.
    pub fn name(self) -> &'static str {
        self.terms().0
    }

    /// Returns the endings of the names of files that may hold it.
    pub fn endings(self) -> &'static [&'static str] {
        self.terms().1
    }

    /// Returns the format of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Returns the format that the ending of a file name selects, as in `json`.
    pub fn of_ending(ending: &str) -> Option<Self> {
        let ending = ending.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.endings().contains(&&*ending))
    }

    /// Checks that the maneuver has all data that the format needs.
    ///
    /// # Errors
    /// Returns the first missing item.
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

    /// Returns whether the format can hold margins of limits and constraints.
    pub fn tells_margins(self) -> bool {
        matches!(self, Self::Csv | Self::Exchange(exchange::Format::Parquet))
    }

    /// Writes the plan of `file`, a plan of `problem`.
    ///
    /// # Errors
    /// Returns missing data of the maneuver, numbers that are not finite, or the error of the
    /// stream.
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
    /// Writes the plan of a sequence: a segment for each leg and each rest, on one axis of time.
    /// `craft` has the names and limits of all legs.
    ///
    /// # Errors
    /// Returns missing data of the maneuver, numbers that are not finite, or the error of the
    /// stream.
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

/// Returns the comment about the witnesses of all legs.
fn verified_legs(file: &SequenceFile<'_>) -> String {
    let passed = |leg: &PlanFile<'_>| leg.verified.as_ref().is_some_and(Verification::passed);
    if file.legs.iter().all(passed) { "verified: every leg" } else { "not verified" }.into()
}

/// Returns the comment about the program.
fn generated() -> String {
    format!("planned by slewkit {}", env!("CARGO_PKG_VERSION"))
}

/// Builds the record from which formats of other programs are written.
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

/// Returns the nodes at which inputs of a plan switch, where it consists of arcs.
fn switches(file: &PlanFile<'_>) -> Vec<usize> {
    let trajectory = &*file.trajectory.0;
    let arcs = file.switching.as_ref().map_or(&[][..], |switching| &switching.arcs);
    // A torque of full norm that turns is another one on every step: it switches where it is turned
    // on and off.
    let turns = arcs.iter().any(|arc| arc.input.is_empty());
    let is_off = |k: usize| trajectory.inputs(k).iter().all(|input| *input == 0.0);
    let switches = |k: &usize| {
        if turns { is_off(k - 1) != is_off(*k) } else { trajectory.inputs(k - 1) != trajectory.inputs(*k) }
    };
    // Inputs at the nodes of equal steps go from one limit to the other within a step.
    let held = trajectory.torque.len() < trajectory.time.len();
    let nodes = if arcs.is_empty() || !held { 0 } else { trajectory.torque.len() };
    (1..nodes).filter(switches).collect()
}

/// Returns comments about a plan.
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

/// Returns the creation date of messages: now, or the value of `SOURCE_DATE_EPOCH`, for equal
/// files of equal inputs.
pub fn now() -> Epoch {
    let said = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    Epoch::of_unix(said.unwrap_or_else(clock))
}
