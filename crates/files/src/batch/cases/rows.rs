//! Rows of comma-separated values (RFC 4180, but a quoted cell ends on its line), with the places of their cells.

use crate::batch::BatchError;
use crate::batch::error::shown;
use crate::batch::fingerprint::Fingerprint;
use crate::spec::{Diagnostic, Diagnostics, MAX_BYTES, Origin};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// One cell.
#[derive(Debug)]
pub(super) struct Cell {
    pub text: String,
    /// Where it begins: column of its line in characters, from 1.
    pub column: usize,
}

/// One row.
#[derive(Debug)]
pub(super) struct Row {
    /// Its line, from 1.
    pub line: usize,
    pub cells: Vec<Cell>,
}

/// The rows of a file; blank lines are none.
#[derive(Debug)]
pub(super) struct Rows {
    path: PathBuf,
    name: String,
    input: BufReader<File>,
    line: usize,
    fingerprint: Fingerprint,
}

impl Rows {
    /// Opens a file that can be read more than once; what is read is added to the hash.
    pub fn open(path: &Path, fingerprint: Fingerprint) -> Result<Self, BatchError> {
        let unreadable = |error| BatchError::unreadable(path, &error);
        let file = File::open(path).map_err(unreadable)?;
        if !file.metadata().map_err(unreadable)?.is_file() {
            let reason = format!("{}: cases are read twice, and this is no file", shown(path));
            return Err(BatchError::file("E0014", reason, "write the cases to a file first"));
        }
        let name = path.display().to_string();
        Ok(Self { path: path.into(), name, input: BufReader::new(file), line: 0, fingerprint })
    }

    /// The hash of what has been read.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// The place of a cell, for messages.
    pub fn origin(&self, row: &Row, cell: &Cell) -> Origin {
        Origin { file: self.name.clone(), line: row.line, column: cell.column }
    }

    /// An error of a row, or of the whole file before there is one.
    pub fn refuse(&self, row: Option<&Row>, code: &'static str, reason: String, remedy: &str) -> BatchError {
        let origin = Origin { file: self.name.clone(), line: row.map_or(1, |row| row.line), column: 1 };
        let text = row.and_then(|row| row.cells.first()).map_or("", |cell| cell.text.as_str());
        BatchError::Spec(Diagnostics(vec![Diagnostic::in_text(code, &origin, text, reason, remedy)]))
    }

    /// The next row that is not blank.
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
                return Err(self.refuse(Some(&here), "E0004", reason, "a row is one case"));
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
            return match cells(text) {
                Ok(cells) => Ok(Some(Row { line: self.line, cells })),
                Err(reason) => {
                    let remedy =
                        "put a cell that holds commas between two quotes, and write \"\" for a quote in it";
                    Err(self.refuse(Some(&here), "E0116", reason.into(), remedy))
                }
            };
        }
    }
}

/// The cells of a line, without the blanks around them.
fn cells(line: &str) -> Result<Vec<Cell>, &'static str> {
    let mut cells = Vec::new();
    let mut signs = line.chars().enumerate().peekable();
    loop {
        while signs.next_if(|(_, sign)| *sign == ' ' || *sign == '\t').is_some() {}
        let mut text = String::new();
        let mut column = signs.peek().map_or(line.chars().count(), |(at, _)| *at) + 1;
        if signs.next_if(|(_, sign)| *sign == '"').is_some() {
            column += 1;
            loop {
                match signs.next() {
                    None => return Err("a quote is opened and never closed on its line"),
                    Some((_, '"')) if signs.next_if(|(_, sign)| *sign == '"').is_some() => text.push('"'),
                    Some((_, '"')) => break,
                    Some((_, sign)) => text.push(sign),
                }
            }
            while signs.next_if(|(_, sign)| *sign == ' ' || *sign == '\t').is_some() {}
            if signs.peek().is_some_and(|(_, sign)| *sign != ',') {
                return Err("after a quoted cell there is more than a comma");
            }
        } else {
            while let Some((_, sign)) = signs.next_if(|(_, sign)| *sign != ',') {
                text.push(sign);
            }
            text.truncate(text.trim_end().len());
        }
        cells.push(Cell { text, column });
        if signs.next().is_none() {
            return Ok(cells);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::cells;

    #[test]
    fn cells_keep_their_places() {
        let read = |line: &str| -> Vec<(String, usize)> {
            cells(line).unwrap().into_iter().map(|cell| (cell.text, cell.column)).collect()
        };
        let expected = |cells: &[(&str, usize)]| -> Vec<(String, usize)> {
            cells.iter().map(|(text, column)| (text.to_string(), *column)).collect()
        };
        assert_eq!(read("a, 2.5 ,\"[1, \"\"x\"\"]\""), expected(&[("a", 1), ("2.5", 4), ("[1, \"x\"]", 10)]));
        assert_eq!(read("a,,"), expected(&[("a", 1), ("", 3), ("", 4)]));
        assert_eq!(read("é,1"), expected(&[("é", 1), ("1", 3)]));
        assert!(cells("\"a").is_err() && cells("\"a\"b,c").is_err());
    }
}
