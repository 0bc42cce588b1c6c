//! Files of results, read.
//!
//! # How is a file continued?
//!
//! Its first line has a hash of the spec, of all set keys, of the cases and of the version of the
//! program. Every line is read and checked; an incomplete last line is removed. A lock excludes a
//! second process. Lines have no checksum: a kill leaves a prefix, and an edit into another valid
//! result of the case is the responsibility of the editor.

use super::error::shown;
use super::{BatchError, CaseResult, Header};
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// The longest line of a file of results: the set keys of a case are shorter than a spec.
const LONGEST_LINE: u64 = 4 << 20;

/// A line with its end, or an incomplete line.
pub(super) enum Line {
    Whole(Vec<u8>),
    Torn(Vec<u8>),
}

/// The lines of a file.
#[derive(Debug)]
pub(super) struct Lines<R> {
    path: PathBuf,
    input: BufReader<R>,
    /// The number of the last line read, from 1.
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
                return Err(damaged(&self.path, self.number, "it has no end"));
            }
            Some(_) => Some(Line::Torn(bytes)),
        })
    }
}

pub(super) fn read_header(path: &Path, line: &[u8]) -> Result<Header, BatchError> {
    // The version first: another one may have other keys.
    #[derive(serde::Deserialize)]
    struct Version {
        slew_results: u32,
    }
    let Version { slew_results } = serde_json::from_slice(line).map_err(|_| no_results(path))?;
    if slew_results != Header::FORMAT {
        let reason = format!(
            "{}: results of format {slew_results}, this program reads {}",
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
    let reason = format!("{} exists and holds no results", shown(path));
    BatchError::file("E0112", reason, "give another name; --force replaces the file")
}

pub(super) fn damaged(path: &Path, line: usize, why: &str) -> BatchError {
    let reason = format!("{}, line {line} is not the expected result: {why}", shown(path));
    BatchError::file("E0114", reason, "the file was edited, or its disk fails: start again with another file")
}

/// A file of results, read line by line.
#[derive(Debug)]
pub struct Results {
    lines: Lines<File>,
    header: Header,
}

impl Results {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// It cannot be read, or holds no results.
    pub fn open(path: &Path) -> Result<Self, BatchError> {
        let file = File::open(path).map_err(|error| BatchError::unreadable(path, &error))?;
        let mut lines = Lines::new(path, file);
        match lines.next()? {
            Some(Line::Whole(head)) => Ok(Self { header: read_header(path, &head)?, lines }),
            _ => Err(no_results(path)),
        }
    }

    /// Returns the header of the batch of the results.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Returns the file.
    pub fn path(&self) -> &Path {
        &self.lines.path
    }

    /// Returns the next result, with its line in the file. An incomplete line is no result: a
    /// continued run will write it.
    ///
    /// # Errors
    /// Fails when the file cannot be read, or a line is not a result.
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
