//! Errors that prevent a batch from starting or continuing. An error of one case is a result, not
//! an error of the batch.

use crate::export::{ExportError, FileError};
use crate::spec::{Diagnostics, escape};
use std::io;
use std::path::Path;
use thiserror::Error;

/// Reason why a batch cannot start or continue.
#[derive(Debug, Error)]
pub enum BatchError {
    /// Errors of the spec or of the table of cases, each with its line, reason and remedy.
    #[error("{0}")]
    Spec(#[from] Diagnostics),
    /// Error in an argument: the request is impossible, such as shard 5 of 4.
    #[error("{reason}")]
    Argument {
        /// Stable code of the error.
        code: &'static str,
        /// Reason why the request is impossible.
        reason: String,
        /// Remedy for the error.
        remedy: String,
    },
    /// Error of a file of cases or of results that cannot be used.
    #[error("{reason}")]
    File {
        /// Stable code of the error.
        code: &'static str,
        /// Reason why the file cannot be used.
        reason: String,
        /// Remedy for the error.
        remedy: String,
    },
    /// The program that reads the output stream has closed it, so no further results can be
    /// written.
    #[error("the reader of the results has closed the stream")]
    Closed,
}

impl BatchError {
    /// Creates the error for an impossible argument.
    pub(super) fn argument(code: &'static str, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Argument { code, reason: reason.into(), remedy: remedy.into() }
    }

    /// Creates the error for a file that cannot be used.
    pub(super) fn file(code: &'static str, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::File { code, reason: reason.into(), remedy: remedy.into() }
    }

    /// Creates the error for a file that cannot be read.
    pub(super) fn unreadable(path: &Path, error: &io::Error) -> Self {
        Self::file("E0090", format!("cannot read {}: {error}", shown(path)), "check the path")
    }

    /// Creates the error for a file of results that could not be written completely.
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

/// Converts a path to text for messages.
pub(super) fn shown(path: &Path) -> String {
    escape(&path.to_string_lossy())
}
