//! MATLAB files of version 5, with one matrix for each quantity under its key in plan files.

use super::Record;
use crate::export::{ExportError, table};
use std::io::{self, Write};

/// Codes of the types of data elements.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Code of the class of matrices of doubles.
const DOUBLES: u32 = 6;
/// Largest length of a variable name.
const NAME: usize = 63;

/// Writes every quantity of the trajectory, and the feedback gains if the plan has gains.
pub(super) fn write(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    // The header consists of a text, empty subsystem data, the version and the byte-order mark.
    let text = format!("MATLAB 5.0 MAT-file, by slewkit: {}", record.name());
    let text: String = text.chars().take(116).collect();
    let mut header = format!("{text:<116}").into_bytes();
    header.extend([0; 8]);
    header.extend(0x0100_u16.to_le_bytes());
    header.extend(b"IM");
    output.write_all(&header)?;
    for (key, rows, width, numbers) in table(record.trajectory) {
        matrix(key, rows, width, &numbers, output)?;
    }
    if let Some((width, numbers)) = record.gain_rows() {
        matrix("gains", numbers.len() / width.max(1), width, &numbers, output)?;
    }
    if let Some(numbers) = record.arc_rows() {
        matrix("arc_gains", numbers.len() / 7, 7, &numbers, output)?;
    }
    Ok(())
}

fn matrix(name: &str, rows: usize, width: usize, numbers: &[f64], output: &mut dyn Write) -> io::Result<()> {
    let fits = |value: usize| {
        u32::try_from(value)
            .map_err(|_| io::Error::other("more than a MATLAB file of version 5 can hold, 4 GiB"))
    };
    let name = &name.as_bytes()[..name.len().min(NAME)];
    let mut inner = Vec::with_capacity(64 + 8 * numbers.len());
    element(&mut inner, UINT32, &[DOUBLES.to_le_bytes(), [0; 4]].concat());
    element(&mut inner, INT32, &[fits(rows)?.to_le_bytes(), fits(width)?.to_le_bytes()].concat());
    element(&mut inner, INT8, name);
    // MATLAB stores matrices column by column.
    let columns = (0..width).flat_map(|column| numbers.iter().skip(column).step_by(width));
    let doubles: Vec<u8> = columns.flat_map(|number| number.to_le_bytes()).collect();
    fits(doubles.len())?;
    element(&mut inner, DOUBLE, &doubles);
    output.write_all(&MATRIX.to_le_bytes())?;
    output.write_all(&fits(inner.len())?.to_le_bytes())?;
    output.write_all(&inner)
}

/// Writes a data element: its type, its size in bytes, and the bytes padded to a multiple of eight.
fn element(to: &mut Vec<u8>, kind: u32, bytes: &[u8]) {
    to.extend(kind.to_le_bytes());
    to.extend((bytes.len() as u32).to_le_bytes());
    to.extend(bytes);
    to.resize(to.len().next_multiple_of(8), 0);
}
