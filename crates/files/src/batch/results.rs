//! Reading of files of results.
//!
//! # How is a file continued?
//!
//! The first line of a file has a hash of the spec, all set keys, the cases and the version of the
//! program. Every line is read and checked; an incomplete last line is removed. A lock excludes a
//! second process. Lines have no checksum. A killed process leaves a prefix of the file, which the
//! checks recognise. If a user edits a line into another valid result of the case, the edit is not
//! detected.

use super::error::shown;
use super::{BatchError, CaseResult, Header};
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Largest length of a line in a file of results \[bytes\]. The keys that a case sets take less
/// space than a spec.
const LONGEST_LINE: u64 = 4 << 20;

/// A complete line, which ends with a line break, or an incomplete line.
pub(super) enum Line {
    Whole(Vec<u8>),
    Torn(Vec<u8>),
}

/// Reader of the lines of a file.
#[derive(Debug)]
pub(super) struct Lines<R> {
    path: PathBuf,
    input: BufReader<R>,
    /// Number of the last line read, counted from 1.
    pub number: usize,
}

impl<R: Read> Lines<R> {
    pub fn new(path: &Path, input: R) -> Self {
        Self { path: path.into(), input: BufReader::with_capacity(1 << 16, input), number: 0 }
    }

    pub fn next(&mut self) -> Result<Option<Line>, BatchError> {
        let mut bytes = Vec::new();
        let input = self.input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes);
        input.map_err(|error| BatchError::unreadable(&self.path, &error))?;
        self.number += 1;
        Ok(match bytes.last() {
            None => None,
            Some(b'\n') => Some(Line::Whole(bytes)),
            Some(_) if bytes.len() as u64 == LONGEST_LINE => {
                return Err(damaged(&self.path, self.number, "the line is cut off"));
            }
            Some(_) => Some(Line::Torn(bytes)),
        })
    }
}

pub(super) fn read_header(path: &Path, line: &[u8]) -> Result<Header, BatchError> {
    // The version is read first, because another version may have other keys.
    #[derive(serde::Deserialize)]
    struct Version {
        slew_results: u32,
    }
    let Version { slew_results } = serde_json::from_slice(line).map_err(|_| no_results(path))?;
    if slew_results != Header::FORMAT {
        let reason = format!(
            "{}: the results have format {slew_results}, and this program reads {}",
            shown(path),
            Header::FORMAT
        );
        return Err(BatchError::file(
            "E0112",
            reason,
            "use the version of slew that wrote it, or start again with another file",
        ));
    }
    serde_json::from_slice(line).map_err(|_| no_results(path))
}

pub(super) fn read_result<E: DeserializeOwned>(
    path: &Path,
    line: &[u8],
    number: usize,
) -> Result<E, BatchError> {
    serde_json::from_slice(line).map_err(|error| damaged(path, number, &error.to_string()))
}

pub(super) fn no_results(path: &Path) -> BatchError {
    let reason = format!("{} exists, but is not a file of results", shown(path));
    BatchError::file("E0112", reason, "give another name; --force replaces the file")
}

pub(super) fn damaged(path: &Path, line: usize, why: &str) -> BatchError {
    let reason = format!("{}, line {line} is not the expected result: {why}", shown(path));
    BatchError::file("E0114", reason, "the file was edited, or its disk fails: start again with another file")
}

/// A file of results that is read line by line.
#[derive(Debug)]
pub struct Results {
    lines: Lines<File>,
    header: Header,
}

impl Results {
    /// Opens the file at `path` and reads its header.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or does not hold results.
    pub fn open(path: &Path) -> Result<Self, BatchError> {
        let file = File::open(path).map_err(|error| BatchError::unreadable(path, &error))?;
        let mut lines = Lines::new(path, file);
        match lines.next()? {
            Some(Line::Whole(head)) => Ok(Self { header: read_header(path, &head)?, lines }),
            _ => Err(no_results(path)),
        }
    }

    /// Returns the header of the file.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.lines.path
    }

    /// Returns the next result together with its line. Returns `None` at the end of the file, or at
    /// an incomplete line, which a continued run will write again.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or if a line is not a valid result.
    pub fn next_result(&mut self) -> Result<Option<(CaseResult, Vec<u8>)>, BatchError> {
        match self.lines.next()? {
            Some(Line::Whole(line)) => {
                let result = read_result(&self.lines.path, &line, self.lines.number)?;
                Ok(Some((result, line)))
            }
            Some(Line::Torn(_)) | None => Ok(None),
        }
    }
}
