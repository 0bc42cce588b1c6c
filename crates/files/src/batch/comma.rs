//! Results as a comma-separated table (RFC 4180) for spreadsheets. It has one row for each case and
//! the columns of the Parquet table.

use super::columns::{AFTER, BEFORE};
use super::{CaseResult, Header};
use crate::cells::quoted;
use crate::export::ExportError;
use serde_json::Value;
use std::io::Write;

/// A comma-separated table of results that is being written.
pub struct CommaTable<'o> {
    output: &'o mut dyn Write,
    /// Path of each column's value in a result.
    paths: Vec<Vec<String>>,
}

impl<'o> CommaTable<'o> {
    /// Begins the table and writes its header: one column for every value that a result can have,
    /// and one for every key that the cases set.
    ///
    /// # Errors
    /// Returns an error if the stream cannot be written.
    pub fn begin(header: &Header, output: &'o mut dyn Write) -> Result<Self, ExportError> {
        let fixed = |(path, _): &(&str, _)| -> Vec<String> { path.split('/').map(String::from).collect() };
        let set = header.keys.iter().map(|key| vec!["set".into(), key.clone()]);
        let paths: Vec<_> = BEFORE.iter().map(fixed).chain(set).chain(AFTER.iter().map(fixed)).collect();
        let head = paths.iter().map(|path| match &path[..] {
            [set, key] if set == "set" => quoted(key),
            path => quoted(&path.join("_")),
        });
        let head: Vec<String> = head.collect();
        let mut table = Self { output, paths };
        table.row(&head)?;
        Ok(table)
    }

    /// Appends the row of a result.
    ///
    /// # Errors
    /// Returns an error if the stream cannot be written.
    pub fn add(&mut self, result: &CaseResult) -> Result<(), ExportError> {
        let result = serde_json::to_value(result)?;
        let cell = |path: &Vec<String>| match path.iter().try_fold(&result, |value, key| value.get(key)) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => quoted(text),
            Some(value) => quoted(&value.to_string()),
        };
        let cells: Vec<String> = self.paths.iter().map(cell).collect();
        self.row(&cells)
    }

    fn row(&mut self, cells: &[String]) -> Result<(), ExportError> {
        Ok(writeln!(self.output, "{}", cells.join(","))?)
    }
}
