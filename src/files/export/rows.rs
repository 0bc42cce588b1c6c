//! The trajectory as a table: CSV, or one JSON object a line.
//!
//! One row per node, `N + 1` in all. Inputs, torques, forces and costates stand in the row of the node
//! at which the input acts, the costate beside the input that it determines (`u = −W⁻¹ Bᵀ λ`). Lie–Euler
//! has no input at the first node: its fields are empty in CSV and absent in JSON lines.

use super::ExportError;
use super::trajectory::{check_finite, costate_width, wheel_count};
use crate::Vector3;
use crate::maneuver::Trajectory;
use serde::Serialize;
use std::io::Write;

/// One row of the table.
#[derive(Serialize)]
struct Row<'a> {
    time_s: f64,
    quaternion_wxyz: [f64; 4],
    angular_velocity_rad_s: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_m_s: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    input: Option<&'a [f64]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    torque_n_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    force_n: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wheel_momentum_n_m_s: Option<&'a [f64]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    costates: Option<&'a [f64]>,
}

fn row(trajectory: &Trajectory, index: usize) -> Row<'_> {
    let at = |rows: &[Vector3], index: usize| rows.get(index).map(|v| [v.x, v.y, v.z]);
    // Lie–Euler has one input fewer than nodes, none at the first.
    let input_row = (index + trajectory.torque.len()).checked_sub(trajectory.time.len());
    let chunk = |flat, width: usize| {
        let flat: &[f64] = flat;
        input_row.and_then(|row| flat.get(row * width..(row + 1) * width)).filter(|row| !row.is_empty())
    };
    let v = trajectory.angular_velocity[index];
    Row {
        time_s: trajectory.time[index],
        quaternion_wxyz: trajectory.quaternion[index],
        angular_velocity_rad_s: [v.x, v.y, v.z],
        position_m: at(&trajectory.position, index),
        velocity_m_s: at(&trajectory.velocity, index),
        input: chunk(&trajectory.input, trajectory.input_count),
        torque_n_m: input_row.and_then(|row| at(&trajectory.torque, row)),
        force_n: input_row.and_then(|row| at(&trajectory.force, row)),
        wheel_momentum_n_m_s: wheel_momentum(trajectory, index),
        costates: chunk(&trajectory.costates, costate_width(trajectory)),
    }
}

/// Momenta of the wheels at a node.
fn wheel_momentum(trajectory: &Trajectory, index: usize) -> Option<&[f64]> {
    let wheels = wheel_count(trajectory);
    trajectory.wheel_momentum.get(index * wheels..(index + 1) * wheels).filter(|row| !row.is_empty())
}

/// Writes one JSON object a line, the keys as in a plan.
///
/// # Errors
/// A number that is not finite, or the stream.
pub fn write_jsonl(trajectory: &Trajectory, mut output: impl Write) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    for index in 0..trajectory.time.len() {
        serde_json::to_writer(&mut output, &row(trajectory, index))?;
        output.write_all(b"\n")?;
    }
    Ok(output.flush()?)
}

/// Writes CSV: a header with units, then one line a node; decimal points, no quotes.
///
/// # Errors
/// A number that is not finite, or the stream.
pub fn write_csv(trajectory: &Trajectory, mut output: impl Write) -> Result<(), ExportError> {
    check_finite(trajectory)?;
    let moving = !trajectory.position.is_empty();
    let controlled = !trajectory.torque.is_empty();
    let costates = if trajectory.costates.is_empty() { 0 } else { costate_width(trajectory) };
    let mut header: Vec<String> = vec!["time_s".into()];
    header.extend(["w", "x", "y", "z"].map(|part| format!("quaternion_{part}")));
    let mut vector = |name: &str, unit: &str| {
        header.extend(["x", "y", "z"].map(|part| format!("{name}_{part}_{unit}")));
    };
    vector("angular_velocity", "rad_s");
    if moving {
        vector("position", "m");
        vector("velocity", "m_s");
    }
    if controlled {
        vector("torque", "n_m");
    }
    if controlled && moving {
        vector("force", "n");
    }
    header.extend((1..=trajectory.input_count).map(|index| format!("input_{index}")));
    let wheels = wheel_count(trajectory);
    header.extend((1..=wheels).map(|index| format!("wheel_momentum_{index}_n_m_s")));
    header.extend((1..=costates).map(|index| format!("costate_{index}")));
    writeln!(output, "{}", header.join(","))?;

    for index in 0..trajectory.time.len() {
        let row = row(trajectory, index);
        // The debug form of a float is the shortest that reads back to the same bits.
        write!(output, "{:?}", row.time_s)?;
        let mut numbers = |values: Option<&[f64]>, width: usize| -> std::io::Result<()> {
            match values {
                Some(values) => values.iter().try_for_each(|value| write!(output, ",{value:?}")),
                None => (0..width).try_for_each(|_| output.write_all(b",")),
            }
        };
        numbers(Some(&row.quaternion_wxyz), 4)?;
        numbers(Some(&row.angular_velocity_rad_s), 3)?;
        if moving {
            numbers(row.position_m.as_ref().map(<[f64; 3]>::as_slice), 3)?;
            numbers(row.velocity_m_s.as_ref().map(<[f64; 3]>::as_slice), 3)?;
        }
        if controlled {
            numbers(row.torque_n_m.as_ref().map(<[f64; 3]>::as_slice), 3)?;
        }
        if controlled && moving {
            numbers(row.force_n.as_ref().map(<[f64; 3]>::as_slice), 3)?;
        }
        numbers(row.input, trajectory.input_count)?;
        numbers(row.wheel_momentum_n_m_s, wheels)?;
        numbers(row.costates, costates)?;
        writeln!(output)?;
    }
    Ok(output.flush()?)
}
