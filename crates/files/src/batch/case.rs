//! A case of a batch, and the kinds of sources of cases.
//!
//! # What is a case?
//!
//! A case is the base spec with some keys set, by a row of a table, a point of a grid or a random
//! draw. Its plan is therefore the plan of `slew plan --set`. The result line holds the command
//! that plans the case again, to the last bit. The base is parsed once. For each case, its tree is
//! copied, changed and checked as a whole, with the messages of any spec. Some errors stop the
//! batch before the first case: an unknown column, a row of a wrong length, a value of a wrong
//! type. Errors of the whole spec, such as a start within a cone, are the result of that case.

use crate::spec::Override;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A case: the base spec with some keys set, or a spec of a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Number of the case, counted from 1.
    pub number: u64,
    /// Name of the case in the table, or file name in the folder.
    pub name: Option<String>,
    /// Keys that the case sets in the spec, in the order of the columns.
    pub set: Vec<Override>,
    /// Path of the spec of the case, if the cases are the specs of a folder; otherwise `None`.
    pub spec: Option<PathBuf>,
}

/// Kind of the source of the cases of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Each case is a row of a table.
    Table,
    /// Each case is a spec of a folder.
    Folder,
    /// Each case is a point of a grid.
    Sweep,
    /// Each case is one random draw.
    MonteCarlo,
}
