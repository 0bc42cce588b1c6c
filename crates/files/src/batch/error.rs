//! The reasons for which a batch cannot start or continue. An error of one case is a result, not
//! an error of the batch.

use crate::export::{ExportError, FileError};
use crate::spec::{Diagnostics, escape};
use std::io;
use std::path::Path;
use thiserror::Error;

/// The reason for which a batch cannot start or continue.
#[derive(Debug, Error)]
pub enum BatchError {
    /// The spec, or the table of cases; with line, reason and remedy.
    #[error("{0}")]
    Spec(#[from] Diagnostics),
    /// The request is impossible, such as shard 5 of 4.
    #[error("{reason}")]
    Argument {
        /// Stable code.
        code: &'static str,
        /// The reason.
        reason: String,
        /// The remedy.
        remedy: String,
    },
    /// A file of cases or results.
    #[error("{reason}")]
    File {
        /// Stable code.
        code: &'static str,
        /// The reason.
        reason: String,
        /// The remedy.
        remedy: String,
    },
    /// The stream that results go to has been closed by its reader.
    #[error("the reader of the results has closed the stream")]
    Closed,
}

impl BatchError {
    /// Builds the error of an impossible argument.
    pub(super) fn argument(code: &'static str, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Argument { code, reason: reason.into(), remedy: remedy.into() }
    }

    /// Builds the error of a file that cannot be used.
    pub(super) fn file(code: &'static str, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::File { code, reason: reason.into(), remedy: remedy.into() }
    }

    /// Builds the error of a file that cannot be read.
    pub(super) fn unreadable(path: &Path, error: &io::Error) -> Self {
        Self::file("E0090", format!("cannot read {}: {error}", shown(path)), "check the path")
    }

    /// Builds the error of a file of results that cannot be written completely.
    pub(super) fn unwritable(path: &Path, error: &io::Error) -> Self {
        let reason = format!("writing {} failed, finished cases are kept: {error}", shown(path));
        Self::file("E0097", reason, "free some space; this command then continues the run")
    }
}

impl From<FileError> for BatchError {
    fn from(error: FileError) -> Self {
        Self::file(error.code(), error.to_string(), error.remedy())
    }
}

impl From<ExportError> for BatchError {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::File(error) => error.into(),
            other => Self::file(other.code(), other.to_string(), other.remedy()),
        }
    }
}

/// Returns a path for messages.
pub(super) fn shown(path: &Path) -> String {
    escape(&path.to_string_lossy())
}
