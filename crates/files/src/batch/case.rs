//! One case, and what cases come from.
//!
//! # What is a case?
//!
//! The base spec with keys set, whether they come from a row, a grid or a random draw. So there is one way from a case to its
//! plan, that of `slew plan --set`, and any case is planned again by the command that its line of results spells out, to the
//! last bit. The base is parsed once; per case its tree is copied, changed and checked as a whole, with the messages of any
//! spec. A column that no spec has, a row of another length and a value that no key takes are refused before the first case;
//! what only shows in the whole spec, such as a start within a cone, is the result of that case.

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
