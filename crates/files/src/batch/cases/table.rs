//! A table as a source of cases: its header names keys of the spec, and each row is a case.
//!
//! The table is read twice. The first pass reads all of it, so that an error in row 9000 is
//! reported before the first case is planned. The second pass reads row by row. Only the names are
//! stored in memory.

use super::rows::{Row, Rows};
use super::{Fingerprint, MAX_CASES, check_distinct};
use crate::batch::{BatchError, Case};
use crate::spec::{Base, Diagnostics, Override};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Header of the column with the names of the cases.
const NAME: &str = "name";
/// Header of a column that is ignored: some programs write row indices in a column without a
/// header.
const UNNAMED: &str = "";
/// Largest length of the name of a case, equal to the limit on names in specs.
const LONGEST_NAME: usize = 200;
/// Largest number of errors of a table that are reported.
const MOST_FINDINGS: usize = 100;

/// A table whose rows have been checked.
#[derive(Debug)]
pub(super) struct Table {
    path: PathBuf,
    /// Header of each column: a key, or the name of a special column.
    columns: Vec<String>,
    /// Number of cases, and the hashes before and after the text of the table was added.
    count: u64,
    hashes: [Fingerprint; 2],
}

impl Table {
    /// Reads the whole table at `path` once, checks its keys and rows, counts the rows and adds the
    /// text to the hash `fingerprint`.
    pub fn open(
        path: &Path,
        base: &Base,
        begun: Fingerprint,
    ) -> Result<(Self, u64, Fingerprint), BatchError> {
        let mut rows = Rows::open(path, begun)?;
        let Some(head) = rows.next()? else {
            let remedy = "write a header of keys, as in `name,maneuver.duration_s`, then a row for each case";
            return Err(rows.refuse(None, "E0116", "the file is empty: it has no cases".into(), remedy));
        };
        let columns: Vec<String> = head.cells.iter().map(|cell| cell.text.clone()).collect();
        let mut findings = Vec::new();
        for cell in head.cells.iter().filter(|cell| cell.text != NAME && cell.text != UNNAMED) {
            let at = rows.origin(&head, cell);
            findings
                .extend(base.check_key(&cell.text, Some(&at)).err().into_iter().flat_map(|found| found.0));
        }
        if !findings.is_empty() {
            return Err(Diagnostics(findings).into());
        }
        let mut table = Self { path: path.into(), columns, count: 0, hashes: [begun; 2] };
        let named: Vec<String> = table.columns.iter().filter(|column| *column != UNNAMED).cloned().collect();
        check_distinct(&named, &rows.origin(&head, &head.cells[0]).file)?;
        let (mut count, mut names) = (0, HashSet::new());
        while let Some(row) = rows.next()? {
            count += 1;
            if count > MAX_CASES {
                let reason = format!("more than {MAX_CASES} cases");
                return Err(rows.refuse(Some(&row), "E0034", reason, "use several tables"));
            }
            let case = table.case(count, &row, &rows)?;
            for set in &case.set {
                findings.extend(base.check_value(set).err().into_iter().flat_map(|found| found.0));
            }
            if let Some(name) = case.name
                && !names.insert(name.clone().into_boxed_str())
            {
                let reason = format!("two cases have the name `{}`", crate::spec::escape(&name));
                return Err(rows.refuse(Some(&row), "E0011", reason, "give each case a different name"));
            }
            if findings.len() >= MOST_FINDINGS {
                break;
            }
        }
        if !findings.is_empty() {
            findings.truncate(MOST_FINDINGS);
            return Err(Diagnostics(findings).into());
        }
        if count == 0 {
            let reason = "the table has a header but no cases".into();
            return Err(rows.refuse(Some(&head), "E0116", reason, "write a row for each case"));
        }
        (table.count, table.hashes[1]) = (count, rows.fingerprint());
        let hash = table.hashes[1];
        Ok((table, count, hash))
    }

    /// Returns the keys of the spec that the columns of the table set.
    pub fn keys(&self) -> Vec<String> {
        self.columns.iter().filter(|column| *column != NAME && *column != UNNAMED).cloned().collect()
    }

    /// Reads the cases from the file a second time, one row at a time. If the file has changed
    /// since it was opened, an error is returned in place of the last case.
    pub fn cases(&self) -> Result<impl Iterator<Item = Result<Case, BatchError>> + Send, BatchError> {
        let mut rows = Rows::open(&self.path, self.hashes[0])?;
        rows.next()?;
        let mut number = 0;
        Ok(std::iter::from_fn(move || {
            if number == self.count {
                return None;
            }
            number += 1;
            Some(self.read(number, &mut rows))
        }))
    }

    /// Reads the next row and returns its case, which gets the number `number`.
    fn read(&self, number: u64, rows: &mut Rows) -> Result<Case, BatchError> {
        let Some(row) = rows.next()? else { return Err(changed(rows)) };
        let case = self.case(number, &row, rows)?;
        if number == self.count {
            let more = rows.next()?.is_some();
            if more || rows.fingerprint() != self.hashes[1] {
                return Err(changed(rows));
            }
        }
        Ok(case)
    }

    fn case(&self, number: u64, row: &Row, rows: &Rows) -> Result<Case, BatchError> {
        let (found, wanted) = (row.cells.len(), self.columns.len());
        if found != wanted {
            let reason = format!("the row has {found} cells, but the header has {wanted}");
            let remedy = "write one cell for each column; a list such as [1, 2, 3] needs quotes";
            return Err(rows.refuse(Some(row), "E0116", reason, remedy));
        }
        let mut case = Case { number, name: None, set: Vec::new(), spec: None };
        for (column, cell) in self.columns.iter().zip(&row.cells).filter(|(_, cell)| !cell.text.is_empty()) {
            if column == UNNAMED {
                continue;
            }
            if column == NAME {
                if cell.text.chars().count() > LONGEST_NAME {
                    let reason = format!("a name is longer than {LONGEST_NAME} characters");
                    return Err(rows.refuse(Some(row), "E0034", reason, "shorten it"));
                }
                case.name = Some(cell.text.clone());
                continue;
            }
            let set = Override::new(column, &cell.text)
                .map_err(|reason| rows.refuse(Some(row), "E0116", reason, "shorten the cell"))?;
            case.set.push(set.at(rows.origin(row, cell)));
        }
        Ok(case)
    }
}

fn changed(rows: &Rows) -> BatchError {
    let reason =
        "the table changed while its cases were planned: the file holds results of both versions".into();
    rows.refuse(None, "E0112", reason, "run it again with --force, and do not change the table")
}
