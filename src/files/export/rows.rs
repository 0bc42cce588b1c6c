//! The trajectory as a table: CSV, or one JSON object a line.
//!
//! One row per node, `N + 1` in all. Inputs, torques, forces and costates stand in the row of the node
//! at which the input acts, the costate beside the input that it determines (`u = −W⁻¹ Bᵀ λ`). Lie–Euler
//! has no input at the first node: its fields are empty in CSV and absent in JSON lines. Inputs that are held over steps, as
//! where they switch, stand in the row of the node at which their step starts; the last node has none.

use super::ExportError;
use super::columns::{Column, Values, check_finite, columns, costate_width};
use crate::files::identity::Identity;
use crate::maneuver::Trajectory;
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::io::Write;

/// One row of the table.
struct Row<'a> {
    columns: &'a [Column<'a>],
    node: usize,
    nodes: usize,
    /// The row of the input at the node: Lie–Euler has one fewer than nodes, none at the first, and held inputs none at the
    /// last, where costates have as many rows as nodes.
    input: Option<usize>,
}

impl<'a> Row<'a> {
    fn all(trajectory: &Trajectory, columns: &'a [Column<'a>]) -> impl Iterator<Item = Self> {
        let (nodes, inputs) = (trajectory.time.len(), trajectory.torque.len());
        let held = inputs + 1 == nodes && trajectory.costates.len() == nodes * costate_width(trajectory);
        let input = move |node: usize| {
            if held { Some(node).filter(|node| *node < inputs) } else { (node + inputs).checked_sub(nodes) }
        };
        (0..nodes).map(move |node| Self { columns, node, nodes, input: input(node) })
    }

    /// The numbers of a column, if it has any here.
    fn numbers(&self, column: &Column<'a>) -> Option<&'a [f64]> {
        let at_node = !column.of_input || column.values.len() == self.nodes;
        column.values.row(if at_node { self.node } else { self.input? })
    }
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut keys = serializer.serialize_map(None)?;
        for column in self.columns {
            match (self.numbers(column), column.values) {
                (Some([number]), Values::Numbers(_)) => keys.serialize_entry(column.key, number)?,
                (Some(numbers), _) => keys.serialize_entry(column.key, numbers)?,
                (None, _) => {}
            }
        }
        keys.end()
    }
}

/// Writes one JSON object a line, the keys as in a plan.
///
/// # Errors
/// A number that is not finite, or the stream.
pub fn write_jsonl(trajectory: &Trajectory, mut output: impl Write) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    for row in Row::all(trajectory, &columns(trajectory)) {
        serde_json::to_writer(&mut output, &row)?;
        output.write_all(b"\n")?;
    }
    Ok(output.flush()?)
}

/// Writes CSV: a header with units, then one line a node; decimal points, no quotes. Inputs are called as `identity`
/// does, else by their numbers.
///
/// # Errors
/// A number that is not finite, or the stream.
pub fn write_csv(
    trajectory: &Trajectory,
    identity: &Identity,
    mut output: impl Write,
) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    // Inputs, as many as the maneuver has, come after the vectors.
    let mut ordered = columns(trajectory);
    ordered.sort_by_key(Column::is_flat);
    let header: Vec<String> = ordered.iter().flat_map(|column| column.headers(&identity.inputs)).collect();
    writeln!(output, "{}", header.join(","))?;
    for row in Row::all(trajectory, &ordered) {
        let cells = ordered.iter().flat_map(|column| (0..column.width).map(move |part| (column, part)));
        for (index, (column, part)) in cells.enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match row.numbers(column) {
                // The debug form of a float is the shortest that reads back to the same bits.
                Some(numbers) => write!(output, "{comma}{:?}", numbers[part])?,
                None => write!(output, "{comma}")?,
            }
        }
        writeln!(output)?;
    }
    Ok(output.flush()?)
}
