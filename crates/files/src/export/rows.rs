//! Rows of a trajectory, and trajectories as JSON lines.
//!
//! A table has one row for each node, `N + 1` in all. Inputs, torques, forces and costates are in
//! the row of the node at which the input acts. The costate in a row determines the input in the
//! same row (`u = −W⁻¹ Bᵀ λ`, with the weights W and the input matrix B). Lie–Euler has no input at
//! the first node: these cells are empty in CSV and absent in JSON lines. Inputs that are held over
//! steps, such as switching inputs, are in the row of the node at which their step starts; the last
//! node has no input.

use super::ExportError;
use super::columns::{Column, Values, check_finite, columns, costate_width};
use serde::ser::{Serialize, SerializeMap, Serializer};
use slewkit::maneuver::Trajectory;
use std::io::Write;

/// Relation between the nodes of a trajectory and its rows of inputs.
pub(super) struct Rows {
    nodes: usize,
    inputs: usize,
    /// True if a row of inputs belongs to the step that starts at its node.
    held: bool,
}

impl Rows {
    pub fn of(trajectory: &Trajectory) -> Self {
        let (nodes, inputs) = (trajectory.time.len(), trajectory.torque.len());
        let costates = trajectory.costates.len();
        // The joined motion of a sequence has no costates.
        let held = inputs + 1 == nodes && (costates == 0 || costates == nodes * costate_width(trajectory));
        Self { nodes, inputs, held }
    }

    /// Returns the index of the row of inputs that belongs to `node`; `None` if the node has no
    /// input. Inputs that are held over steps have no row for the last node. Inputs of the scheme
    /// Lie–Euler have no row for the first node.
    pub fn input(&self, node: usize) -> Option<usize> {
        if self.held {
            Some(node).filter(|node| *node < self.inputs)
        } else {
            (node + self.inputs).checked_sub(self.nodes)
        }
    }

    /// Returns the numbers of `column` at `node`; `None` if the quantity has no value at this node.
    pub fn numbers<'a>(&self, column: &Column<'a>, node: usize) -> Option<&'a [f64]> {
        let at_node = !column.of_input || column.values.len() == self.nodes;
        column.values.row(if at_node { node } else { self.input(node)? })
    }
}

/// A row of the trajectory that is serialised as a JSON object.
struct Row<'a> {
    columns: &'a [Column<'a>],
    rows: &'a Rows,
    node: usize,
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut keys = serializer.serialize_map(None)?;
        for column in self.columns {
            match (self.rows.numbers(column, self.node), column.values) {
                (Some([number]), Values::Numbers(_)) => keys.serialize_entry(column.key, number)?,
                (Some(numbers), _) => keys.serialize_entry(column.key, numbers)?,
                (None, _) => {}
            }
        }
        keys.end()
    }
}

/// Writes the trajectory as JSON lines, one object per node, with the keys of a plan file.
///
/// # Errors
/// Returns an error if a number is not finite, or if the stream fails.
pub fn write_jsonl(trajectory: &Trajectory, mut output: impl Write) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    let (columns, rows) = (columns(trajectory), Rows::of(trajectory));
    for node in 0..trajectory.time.len() {
        serde_json::to_writer(&mut output, &Row { columns: &columns, rows: &rows, node })?;
        output.write_all(b"\n")?;
    }
    Ok(output.flush()?)
}
