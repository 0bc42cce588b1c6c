//! A file of results that is written line by line; an interrupted run can continue it.
//!
//! A line is complete when its line break is written. An incomplete line, left by a killed process,
//! is removed when the file is continued. Every other line is read and checked, so that no case is
//! lost, duplicated or from another batch.

use super::error::shown;
use super::results::{Line, Lines, damaged, no_results, read_header, read_result};
use super::{BatchError, CaseResult, Header, Shard};
use crate::export::{ExportError, Target};
use serde::{Serialize, de::DeserializeOwned};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// An entry of a file of results: the result of one case, stored as one line.
pub trait Entry: DeserializeOwned {
    /// First line of the file: the data on which all other lines depend.
    type Header: Serialize + PartialEq;

    /// Remedy that an error message suggests if the file holds results of another batch.
    const REMEDY: &'static str;

    /// Parses the first line of the file at `path`.
    ///
    /// # Errors
    /// Returns an error if the line is not a header of such results.
    fn header(path: &Path, line: &[u8]) -> Result<Self::Header, BatchError>;

    /// Checks that the entry belongs in the file after the first `done` entries.
    ///
    /// # Errors
    /// Returns the reason if the line is not the expected entry.
    fn check(&self, header: &Self::Header, done: u64) -> Result<(), String>;

    /// Returns a text that states how the header `found` in the file differs from the header
    /// `wanted`.
    fn another(found: &Self::Header, wanted: &Self::Header) -> String;
}

/// A file of results that is being written. While this value exists, the file is locked against
/// other processes.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Total length of the complete lines \[bytes\].
    whole: u64,
}

/// Results that a file contained when it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Number of results in the file.
    pub done: u64,
    /// Length of an incomplete last line that was removed \[bytes\]; 0 if the last line was
    /// complete.
    pub torn: u64,
}

impl Journal {
    /// Opens the file at `path` for the results that belong to `header`. The file may be new, or
    /// may already hold some of these results; each of them is passed to `take`. If `anew` is true,
    /// the contents of the file are discarded.
    ///
    /// # Errors
    /// Returns an error if the file holds another batch, is damaged or in use, or cannot be
    /// written.
    pub fn open<E: Entry>(
        path: &Path,
        header: &E::Header,
        anew: bool,
        take: &mut dyn FnMut(&E),
    ) -> Result<(Self, Found), BatchError> {
        // The file name and the folder are checked as for any other output.
        Target::new(path, true)?;
        let failed = |error| BatchError::unwritable(path, &error);
        let create = |error: io::Error| {
            let reason = format!("cannot open {} for writing: {error}", shown(path));
            BatchError::file("E0096", reason, "choose another folder, or change its permissions")
        };
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(path).map_err(create)?;
        // On systems without file locks, the file is used without a lock.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let reason = format!("another process writes {}", shown(path));
            return Err(BatchError::file("E0118", reason, "wait for it, or give another file"));
        }
        if anew {
            file.set_len(0).map_err(failed)?;
        }
        let mut first = serde_json::to_string(header).map_err(ExportError::from)?;
        first.push('\n');
        let (found, whole) = check(path, &mut file, header, &first, take)?;
        file.set_len(whole).map_err(failed)?;
        file.seek(SeekFrom::Start(whole)).map_err(failed)?;
        let mut journal = Self { path: path.into(), file, whole };
        if whole == 0 {
            journal.append(&first)?;
        }
        Ok((journal, found))
    }

    /// Appends a result; `line` is its text without a line break.
    ///
    /// # Errors
    /// Returns an error if writing fails. The incomplete line is then removed, if the system allows
    /// it.
    pub fn line(&mut self, line: &str) -> Result<(), BatchError> {
        let mut text = String::with_capacity(line.len() + 1);
        text.push_str(line);
        text.push('\n');
        self.append(&text)
    }

    fn append(&mut self, text: &str) -> Result<(), BatchError> {
        if let Err(error) = self.file.write_all(text.as_bytes()) {
            // A full disk may leave an incomplete line. If it cannot be removed now, the next run
            // removes it.
            let _ = self.file.set_len(self.whole);
            return Err(BatchError::unwritable(&self.path, &error));
        }
        self.whole += text.len() as u64;
        Ok(())
    }

    /// Appends a result as one line of JSON.
    ///
    /// # Errors
    /// Returns the errors of [`Journal::line`].
    pub fn add(&mut self, entry: &impl Serialize) -> Result<(), BatchError> {
        self.line(&serde_json::to_string(entry).map_err(ExportError::from)?)
    }

    /// Closes the file after all its data have been stored on the disk.
    ///
    /// # Errors
    /// Returns an error if the system reports that the data could not be stored.
    pub fn close(self) -> Result<(), BatchError> {
        self.file.sync_all().map_err(|error| BatchError::unwritable(&self.path, &error))
    }
}

/// Checks every line of the file, whose header must be `header`. Returns the number of its results
/// and the length of its complete lines \[bytes\].
fn check<E: Entry>(
    path: &Path,
    file: &mut File,
    header: &E::Header,
    first: &str,
    take: &mut dyn FnMut(&E),
) -> Result<(Found, u64), BatchError> {
    let mut lines = Lines::new(path, file);
    let head = match lines.next()? {
        None => return Ok((Found::default(), 0)),
        // The process was killed while it wrote the first line; no result is lost.
        Some(Line::Torn(text)) if first.as_bytes().starts_with(&text) => {
            return Ok((Found { done: 0, torn: text.len() as u64 }, 0));
        }
        Some(Line::Torn(_)) => return Err(no_results(path)),
        Some(Line::Whole(text)) => text,
    };
    let found = E::header(path, &head)?;
    if found != *header {
        let why = E::another(&found, header);
        let reason = format!("{} holds results of another batch: {why}", shown(path));
        return Err(BatchError::file("E0112", reason, E::REMEDY));
    }
    let (mut whole, mut done) = (head.len() as u64, 0);
    loop {
        match lines.next()? {
            None => return Ok((Found { done, torn: 0 }, whole)),
            Some(Line::Torn(text)) => return Ok((Found { done, torn: text.len() as u64 }, whole)),
            Some(Line::Whole(text)) => {
                let result: E = read_result(path, &text, lines.number)?;
                result.check(header, done).map_err(|why| damaged(path, lines.number, &why))?;
                take(&result);
                done += 1;
                whole += text.len() as u64;
            }
        }
    }
}

impl Entry for CaseResult {
    type Header = Header;

    const REMEDY: &'static str = "give another file; --force discards these results";

    fn header(path: &Path, line: &[u8]) -> Result<Header, BatchError> {
        read_header(path, line)
    }

    fn check(&self, header: &Header, done: u64) -> Result<(), String> {
        let shard = header.shard.unwrap_or(Shard::ALL);
        let expected = shard.case(done);
        let belongs = self.case == expected && done < shard.count(header.cases);
        if belongs { Ok(()) } else { Err(format!("it is case {}, not {expected}", self.case)) }
    }

    fn another(found: &Header, wanted: &Header) -> String {
        let told =
            |shard: Option<Shard>| shard.map_or("all cases".to_string(), |shard| format!("shard {shard}"));
        if found.generator != wanted.generator {
            format!("they were written by {}, and this program is {}", found.generator, wanted.generator)
        } else if found.kind != wanted.kind || found.keys != wanted.keys || found.cases != wanted.cases {
            format!(
                "they cover {} cases over {}, not {} over {}",
                found.cases,
                of(found),
                wanted.cases,
                of(wanted)
            )
        } else if found.fingerprint != wanted.fingerprint {
            "the spec, a key set on the command line, or a case differs".into()
        } else if found.shard != wanted.shard {
            format!("they cover {}, not {}", told(found.shard), told(wanted.shard))
        } else if found.times != wanted.times {
            "only one of the two batches has wall times".into()
        } else {
            format!(
                "the name of their spec is {}, not {}",
                shown(found.spec.as_ref()),
                shown(wanted.spec.as_ref())
            )
        }
    }
}

fn of(header: &Header) -> String {
    if header.keys.is_empty() { "specs of a folder".into() } else { shown(header.keys.join(", ").as_ref()) }
}
