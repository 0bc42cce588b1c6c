//! Results as a Parquet table for analysis, with one row for each case. A batch itself writes JSON
//! lines, because lines can be appended and continued, whereas a Parquet file is complete only when
//! its end is written.

use super::columns::{self, AFTER, BEFORE};
use super::{CaseResult, Header};
use crate::exchange::parquet::{Cells, Kind, ParquetTable};
use crate::export::ExportError;
use serde_json::Value;
use std::io::Write;

/// Number of rows that are held in memory before they are written.
const ROWS: usize = 1 << 16;

/// A column: its heading, the path of its value in a result, and the type of its cells.
#[derive(Clone)]
struct Column {
    head: String,
    path: Vec<String>,
    kind: Kind,
}

/// Columns of the table of a batch: the columns of every result, and a column for every key that
/// the cases set.
pub(super) struct Columns(Vec<Column>);

impl Columns {
    /// Creates the columns for the keys in `header`. The column of a key is numeric until a result
    /// has a value for this key that is not a number.
    pub fn new(header: &Header) -> Self {
        let fixed = |(path, kind): &(&str, columns::Kind)| Column {
            head: path.replace('/', "_"),
            path: path.split('/').map(String::from).collect(),
            kind: match kind {
                columns::Kind::Number => Kind::Number,
                columns::Kind::Integer => Kind::Integer,
                columns::Kind::Flag => Kind::Flag,
                columns::Kind::Text => Kind::Text,
            },
        };
        let key = |key: &String| Column {
            head: key.clone(),
            path: vec!["set".into(), key.clone()],
            kind: Kind::Number,
        };
        let set = header.keys.iter().map(key);
        Self(BEFORE.iter().map(fixed).chain(set).chain(AFTER.iter().map(fixed)).collect())
    }

    /// Changes the type of a key's column to text if `result` has a value for this key that is not
    /// a number.
    pub fn meet(&mut self, result: &CaseResult) {
        for column in self.0.iter_mut().filter(|column| column.path[0] == "set") {
            let value = result.set.get(&column.path[1]);
            if value.is_some_and(|value| !value.is_number()) {
                column.kind = Kind::Text;
            }
        }
    }

    /// Begins a Parquet table with these columns in `output`.
    pub fn begin<'o>(self, header: &Header, output: &'o mut dyn Write) -> Result<Table<'o>, ExportError> {
        let columns: Vec<_> = self.0.iter().map(|column| (column.head.clone(), column.kind)).collect();
        let notes = [("slew_results", serde_json::to_string(header)?)];
        let file = ParquetTable::new(output, &columns, &notes)?;
        Ok(Table { file, columns: self.0, waiting: Vec::new() })
    }
}

/// A Parquet table of results that is being written.
pub(super) struct Table<'o> {
    file: ParquetTable<'o>,
    columns: Vec<Column>,
    waiting: Vec<Value>,
}

impl Table<'_> {
    /// Appends the row of a result to the table.
    pub fn add(&mut self, result: &CaseResult) -> Result<(), ExportError> {
        self.waiting.push(serde_json::to_value(result)?);
        if self.waiting.len() == ROWS { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), ExportError> {
        let cells: Vec<Cells> = self.columns.iter().map(|column| column.cells(&self.waiting)).collect();
        self.waiting.clear();
        Ok(self.file.rows(&cells)?)
    }

    /// Writes the buffered rows and the end of the file.
    pub fn close(mut self) -> Result<(), ExportError> {
        self.write()?;
        Ok(self.file.close()?)
    }
}

impl Column {
    fn cells(&self, rows: &[Value]) -> Cells {
        let found = rows.iter().map(|row| self.path.iter().try_fold(row, |value, key| value.get(key)));
        match self.kind {
            Kind::Number => Cells::Numbers(found.map(|value| value?.as_f64()).collect()),
            Kind::Integer => Cells::Integers(found.map(|value| value?.as_i64()).collect()),
            Kind::Flag => Cells::Flags(found.map(|value| value?.as_bool()).collect()),
            Kind::Text => Cells::Texts(found.map(|value| Some(text(value?))).collect()),
        }
    }
}

/// Returns a text value unchanged, and any other value as JSON.
fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::{CaseError, Verdict};
    use slewkit::maneuver::{Outcome, Proved, SecondOrder, Sense, TerminalError};

    /// Checks that every value of a result, except its set keys, has a column.
    #[test]
    fn nothing_of_a_result_is_left_out() {
        let mut terminal = TerminalError::default();
        terminal.position_relative = Some(0.0);
        terminal.linear_momentum_relative = Some(0.0);
        let number = Some(1.0);
        let verified = Verdict {
            passed: false,
            failed: vec!["order".into()],
            discrete_attitude_rad: number,
            continuous_attitude_deg: number,
            order: number,
            peak_torque_n_m: number,
            peak_rate_deg_s: number,
        };
        let text = || String::from("text");
        let error = CaseError { code: text(), key: text(), reason: text(), remedy: text(), more: 1 };
        let full = CaseResult {
            case: 1,
            name: Some(text()),
            set: serde_json::Map::new(),
            status: text(),
            exit_code: 7,
            objective: Some(text()),
            error: Some(error),
            cost: number,
            duration_s: number,
            stops: Some(vec![text()]),
            late_s: number,
            steps: Some(1),
            method: Some(text()),
            outcome: Some(Outcome::Converged),
            iterations: Some(1),
            sense: Some(Sense::Short),
            turned_deg: number,
            terminal: Some(terminal),
            second_order: Some(SecondOrder::Minimum),
            proof: Some(Proved::Minimum),
            gap: number,
            verified: Some(verified),
            obstruction: Some(text()),
            shortest_duration_s: number,
            shortfall: Some(text()),
            solve_time_s: number,
        };
        fn leaves(value: &Value, path: &str, found: &mut Vec<String>) {
            match value.as_object() {
                Some(keys) => keys.iter().for_each(|(key, value)| {
                    leaves(value, &format!("{path}{}{key}", if path.is_empty() { "" } else { "_" }), found);
                }),
                None => found.push(path.into()),
            }
        }
        let mut found = Vec::new();
        leaves(&serde_json::to_value(&full).unwrap(), "", &mut found);
        let mut heads: Vec<String> =
            BEFORE.iter().chain(&AFTER).map(|(path, _)| path.replace('/', "_")).collect();
        found.sort();
        heads.sort();
        assert_eq!(found, heads);
    }
}
