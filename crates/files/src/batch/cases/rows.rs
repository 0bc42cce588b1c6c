//! Rows of a table of cases, with the positions of their cells for error messages.

use crate::batch::BatchError;
use crate::batch::error::shown;
use crate::cells::{self, separator};
use crate::fingerprint::Fingerprint;
use crate::spec::{Diagnostic, Diagnostics, MAX_BYTES, Origin};
use slewkit::numerics::encoding;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// A cell of the table, with its position.
#[derive(Debug)]
pub(super) struct Cell {
    pub text: String,
    /// Column at which the cell begins, in characters, counted from 1.
    pub column: usize,
}

/// A row of the table, with its line number.
#[derive(Debug)]
pub(super) struct Row {
    /// Line number of the row, counted from 1.
    pub line: usize,
    pub cells: Vec<Cell>,
}

/// Reader of the rows of a table; it skips blank lines.
#[derive(Debug)]
pub(super) struct Rows {
    path: PathBuf,
    name: String,
    input: BufReader<File>,
    line: usize,
    /// Separator of the cells, or `Some(None)` for a table with one column; `None` until the header
    /// has been read.
    separator: Option<Option<char>>,
    fingerprint: Fingerprint,
}

impl Rows {
    /// Opens the table at `path` for reading. The text of every row that is read is added to the
    /// hash `fingerprint`.
    pub fn open(path: &Path, fingerprint: Fingerprint) -> Result<Self, BatchError> {
        let unreadable = |error| BatchError::unreadable(path, &error);
        let file = File::open(path).map_err(unreadable)?;
        if !file.metadata().map_err(unreadable)?.is_file() {
            let reason = format!("{}: cases are read twice, so the input must be a file", shown(path));
            return Err(BatchError::file("E0014", reason, "write the cases to a file first"));
        }
        let name = path.display().to_string();
        Ok(Self {
            path: path.into(),
            name,
            input: BufReader::new(file),
            line: 0,
            separator: None,
            fingerprint,
        })
    }

    /// Returns the hash, including the text read so far.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// Returns the position of a cell in the file, for error messages.
    pub fn origin(&self, row: &Row, cell: &Cell) -> Origin {
        Origin { file: self.name.clone(), line: row.line, column: cell.column }
    }

    /// Creates an error message for a row, or for the whole file if `row` is `None`.
    pub fn refuse(&self, row: Option<&Row>, code: &'static str, reason: String, remedy: &str) -> BatchError {
        let origin = Origin { file: self.name.clone(), line: row.map_or(1, |row| row.line), column: 1 };
        let text = row.and_then(|row| row.cells.first()).map_or("", |cell| cell.text.as_str());
        BatchError::Spec(Diagnostics(vec![Diagnostic::in_text(code, &origin, text, reason, remedy)]))
    }

    /// Returns the next row that is not blank; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Row>, BatchError> {
        loop {
            let mut bytes = Vec::new();
            let most = MAX_BYTES as u64 + 1;
            let input = self.input.by_ref().take(most).read_until(b'\n', &mut bytes);
            input.map_err(|error| BatchError::unreadable(&self.path, &error))?;
            if bytes.is_empty() {
                return Ok(None);
            }
            self.line += 1;
            self.fingerprint.add(&bytes);
            let here = Row { line: self.line, cells: vec![] };
            if bytes.len() > MAX_BYTES {
                let reason = "the line is longer than 1 MiB".to_string();
                return Err(self.refuse(Some(&here), "E0004", reason, "write each case in a row of its own"));
            }
            if self.line == 1 && encoding::is_utf16(&bytes) {
                return Err(self.refuse(None, "E0003", "the table is in UTF-16".into(), "save it as UTF-8"));
            }
            let Ok(text) = std::str::from_utf8(&bytes) else {
                let reason = "the line is not UTF-8".to_string();
                return Err(self.refuse(Some(&here), "E0002", reason, "save the file as UTF-8"));
            };
            let text = if self.line == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
            let text = text.trim_end_matches(['\n', '\r']);
            if text.chars().any(|sign| sign.is_control() && sign != '\t') {
                let reason = "the line holds a control character".to_string();
                return Err(self.refuse(Some(&here), "E0005", reason, "remove it"));
            }
            if text.trim().is_empty() {
                continue;
            }
            let separator = *self.separator.get_or_insert_with(|| separator(text));
            return match cells(text, separator) {
                Ok(cells) => Ok(Some(Row { line: self.line, cells })),
                Err(reason) => {
                    let remedy = "put a cell that holds the separator between two quotes, and write \"\" for a \
                     quote in it";
                    Err(self.refuse(Some(&here), "E0116", reason.into(), remedy))
                }
            };
        }
    }
}

/// Splits a line into cells and records the column at which each cell begins.
fn cells(line: &str, separator: Option<char>) -> Result<Vec<Cell>, &'static str> {
    // A table with one column has no separator, and its cells may contain blanks.
    let cells = cells::cells(line, Some(separator.unwrap_or(',')))?;
    let column = |start: usize| line[..start.min(line.len())].chars().count() + 1;
    Ok(cells
        .into_iter()
        .map(|cell| Cell { column: column(cell.start), text: cell.text.into_owned() })
        .collect())
}
