//! A trajectory as one wide table for CSV and Parquet. Every number of a node has its own column,
//! with name and unit.

use super::ExportError;
use super::columns::{Column, Names, check_finite, columns, plain};
use super::rows::Rows;
use crate::cells::quoted;
use crate::identity::Identity;
use slewkit::maneuver::{Problem, Trajectory};
use slewkit::verify::{cone_angles, margins_at_nodes};
use std::io::Write;

/// A column of the wide table: its heading, and a function that returns its number at a node, or
/// `None` if the cell is empty.
pub(crate) struct WideColumn<'a> {
    pub head: String,
    pub cell: Box<dyn Fn(usize) -> Option<f64> + 'a>,
}

/// Returns all columns of the trajectory, optionally followed by the columns of the margins and of
/// the angles to cones.
pub(crate) fn wide_table<'a>(
    trajectory: &'a Trajectory,
    problem: &Problem,
    identity: &Identity,
    margins: bool,
) -> Vec<WideColumn<'a>> {
    let names = Names::new(problem, identity);
    // The columns of inputs are last, because their number depends on the maneuver.
    let mut ordered = columns(trajectory);
    ordered.sort_by_key(Column::is_flat);
    let mut table = Vec::new();
    for column in ordered {
        for (part, head) in column.headers(&names).into_iter().enumerate() {
            let rows = Rows::of(trajectory);
            let one = if column.key == "input" { names.in_its_unit(part, 1.0) } else { 1.0 };
            let cell = move |node| Some(one * rows.numbers(&column, node)?[part]);
            table.push(WideColumn { head, cell: Box::new(cell) });
        }
    }
    if margins {
        table.extend(of_limits(trajectory, problem));
    }
    table
}

/// Writes a trajectory as CSV: a header with units, then one line for each node, with decimal
/// points and without quotes. Inputs have the names of `identity`, or numbers if they have no
/// names. If `margins` is true, columns are added for the margin to every limit and constraint of
/// `problem` at each node, and for the angle between each boresight and each direction.
///
/// # Errors
/// Returns an error if a number is not finite, or if the stream fails.
pub fn write_csv(
    trajectory: &Trajectory,
    problem: &Problem,
    identity: &Identity,
    margins: bool,
    mut output: impl Write,
) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    let table = wide_table(trajectory, problem, identity, margins);
    let heads: Vec<String> = table.iter().map(|column| quoted(&column.head)).collect();
    writeln!(output, "{}", heads.join(","))?;
    for node in 0..trajectory.time.len() {
        for (index, column) in table.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match (column.cell)(node) {
                // The `Debug` format of a float is the shortest text that reads back to the same
                // bits.
                Some(number) => write!(output, "{comma}{number:?}")?,
                None => write!(output, "{comma}")?,
            }
        }
        writeln!(output)?;
    }
    Ok(output.flush()?)
}

/// Returns the columns of the margins to limits and constraints, followed by the columns of the
/// angles between boresights and directions \[deg\].
fn of_limits(trajectory: &Trajectory, problem: &Problem) -> Vec<WideColumn<'static>> {
    let rows = Rows::of(trajectory);
    let margins = margins_at_nodes(problem, trajectory, |node| rows.input(node));
    let margins =
        margins.into_iter().map(|of| (format!("margin_{}_{}", word(&of.name), key(of.unit)), of.values));
    let angles = cone_angles(problem, trajectory).into_iter().map(|cone| {
        let pair = if cone.only { String::new() } else { format!("_{}_{}", cone.boresight, cone.direction) };
        (format!("angle_{}{pair}_deg", word(&cone.name)), cone.degrees)
    });
    let column = |(head, values): (String, Vec<f64>)| {
        let cell = move |node: usize| values.get(node).copied().filter(|value| value.is_finite());
        WideColumn { head, cell: Box::new(cell) }
    };
    margins.chain(angles).map(column).collect()
}

/// Returns a name in which blanks are replaced by underscores.
fn word(name: &str) -> String {
    plain(name).replace(' ', "_")
}

/// Returns the notation of a unit in the keys of specs.
fn key(unit: &str) -> &'static str {
    match unit {
        "N·m" => "n_m",
        "N·m/s" => "n_m_per_s",
        "N·m·s" => "n_m_s",
        "N" => "n",
        "N/s" => "n_per_s",
        "deg/s" => "deg_s",
        "deg" => "deg",
        _ => "si",
    }
}
