//! A case, and the kinds of sources of cases.
//!
//! # What is a case?
//!
//! A case is the base spec with keys set, from a row, a grid or a random draw. Its plan is
//! therefore the plan of `slew plan --set`, and the command in its line of results plans it
//! again, to the last bit. The base is parsed once; for each case its tree is copied, changed and
//! checked as a whole, with the messages of any spec. An unknown column, a row of another length
//! and a value of the wrong type stop the batch before the first case. Errors of the whole spec,
//! such as a start within a cone, are the result of that case.

use crate::spec::Override;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// One case: a spec with keys set.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Number of the case, from 1.
    pub number: u64,
    /// The name in the table or the folder.
    pub name: Option<String>,
    /// Keys that the case sets in the spec, in the order of the columns.
    pub set: Vec<Override>,
    /// The spec of the case, if each case has its own.
    pub spec: Option<PathBuf>,
}

/// The kind of the source of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A row of a table each.
    Table,
    /// A spec of a folder each.
    Folder,
    /// A point of a grid each.
    Sweep,
    /// Each case is one random draw.
    MonteCarlo,
}
