//! Files of plans as JSON and trajectories as CSV or JSON lines, written completely or not at all.
//!
//! Every number is printed with enough digits to read back to the same bits. A trajectory with a
//! number that is not finite is rejected. Elsewhere such a number is written as `null`, which reads
//! back as NaN.

mod attitude;
mod checksum;
mod columns;
mod file;
mod judged;
mod judged_sequence;
pub(crate) mod nulls;
mod plan_file;
mod recorded;
mod restored;
mod rows;
mod sequence_file;
mod simulation_file;
mod trajectory;
mod wide;

pub use attitude::{EULER_SEQUENCES, EulerAngles, Notations, euler_angles};
pub use checksum::Seal;
pub use columns::TrajectoryError;
pub(crate) use columns::{Names, check_finite, table};
pub use file::{FileError, Target, distinct, remove_temporaries};
pub use judged::Judgement;
pub(crate) use judged_sequence::Own;
pub use judged_sequence::SequenceJudgement;
pub use plan_file::{ConvexRecord, PlanFile, read_guess, write_document};
pub use recorded::NOT_JUDGED;
pub use rows::write_jsonl;
pub use sequence_file::{OrderProof, SequenceFile, SequenceRecord, StopRecord};
pub use simulation_file::{BodyRows, SimulationFile, SimulationRows};
pub use trajectory::{TrajectoryDocument, check_trajectory};
#[cfg(feature = "parquet")]
pub(crate) use wide::wide_table;
pub use wide::write_csv;

use crate::exchange::Lacking;
use thiserror::Error;

/// The JSON Schema of plan files (draft 2020-12).
pub const PLAN_SCHEMA: &str = include_str!("plan.schema.json");

/// Reason why a plan or a trajectory could not be written or read.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The output file could not be created or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The trajectory has wrong lengths or numbers that are not finite.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// The file describes a solve that ended without a plan, so it has no trajectory.
    #[error("the solve ended without a plan, so the file has no motion")]
    NoMotion,
    /// Writing to or reading from a stream failed.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The text is not a plan file.
    #[error("not a plan file: {0}")]
    Json(serde_json::Error),
    /// The file has a version of the plan file format that is not supported.
    #[error("the plan file has format {found}, this program reads {}{}", PlanFile::FORMAT, older(*.found))]
    Format {
        /// Version of the format that the file states.
        found: u32,
    },
    /// The file has no spec, because a caller of the library defined a maneuver that no spec can
    /// express.
    #[error("the plan file holds no spec: specs cannot express its maneuver (a custom environment, say)")]
    NoSpec,
    /// The file contains the plan of a sequence, but the plan of a single maneuver is required.
    #[error("the plan is a sequence, and the plan of a single maneuver is needed")]
    Sequence,
    /// The maneuver lacks data that the format of another program requires.
    #[error(transparent)]
    Lacking(#[from] Lacking),
    /// The file names an unknown integration scheme.
    #[error("the plan file names the unknown scheme \"{}\"", crate::spec::escape(.0))]
    Scheme(String),
}

fn older(found: u32) -> &'static str {
    if found < PlanFile::FORMAT { ": older plan files do not hold their spec" } else { "" }
}

impl ExportError {
    /// Returns the stable code of the error.
    pub fn code(&self) -> &'static str {
        match self {
            Self::File(error) => error.code(),
            Self::Lacking(lacking) => lacking.code(),
            Self::Json(_) | Self::Format { .. } | Self::NoSpec | Self::Sequence | Self::Scheme(_) => "E0102",
            Self::NoMotion | Self::Trajectory(TrajectoryError::Shape { .. }) => "E0103",
            Self::Trajectory(TrajectoryError::NotFinite { .. }) => "E0104",
            Self::Io(_) => "E0097",
        }
    }

    /// Returns the remedy for an error that occurred while a plan file was read.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Format { found } if *found < PlanFile::FORMAT => "plan again: `slew plan SPEC -o FILE`",
            Self::Lacking(lacking) => lacking.remedy(),
            Self::NoMotion => "`slew report` shows the reason; plan again, and give a solved plan",
            Self::NoSpec => "give its spec: `--spec SPEC`",
            Self::Sequence => "take one leg: `jq '.legs[0]' FILE > leg.json`",
            _ => "give a file that `slew plan SPEC -o FILE` wrote",
        }
    }

    /// Returns whether the program that reads the output stream has closed it, as `head` does. This
    /// is not treated as an error.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Io(error) if error.kind() == std::io::ErrorKind::BrokenPipe)
    }
}

impl From<serde_json::Error> for ExportError {
    fn from(error: serde_json::Error) -> Self {
        if error.is_io() { Self::Io(error.into()) } else { Self::Json(error) }
    }
}
