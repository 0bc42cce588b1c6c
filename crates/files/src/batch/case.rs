//! One case, and what cases come from.

use crate::spec::Override;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// One case: a spec with keys set.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its number, from 1.
    pub number: u64,
    /// What the table or the folder calls it.
    pub name: Option<String>,
    /// Keys that it sets in the spec, in the order of the columns.
    pub set: Vec<Override>,
    /// Its own spec, where each case has one.
    pub spec: Option<PathBuf>,
}

/// What the cases of a batch come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A row of a table each.
    Table,
    /// A spec of a folder each.
    Folder,
    /// A point of a grid each.
    Sweep,
    /// A random draw each.
    MonteCarlo,
}
