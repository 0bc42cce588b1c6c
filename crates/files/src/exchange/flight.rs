//! A table for on-board use with equally spaced rows and a checksum over all preceding lines.
//!
//! Rows are one tick apart. A row holds the attitude and rate at its time, and the mean torque and
//! mean inputs of the plan over the following tick, so that their impulse equals the impulse of the
//! plan. If the tick differs from the step of the plan, attitudes are interpolated between the
//! nodes of the plan by a cubic. The table states the error of this interpolation, and the error of
//! interpolating between the rows of the table.
//!
//! If the plan has gains, each row ends with the gains of the step of the plan in which the tick
//! begins (version 2 of the table). The gains are not interpolated.
//!
//! # Why is the interpolation error measured by leaving rows out?
//!
//! Only the rows are available for the measurement. Every second row is left out and interpolated
//! from its neighbours, which gives the error for twice the spacing. For both kinds of
//! interpolation this error is larger than the error for the actual spacing, so it is a bound that
//! needs no model.

use super::numpy::crc32;
use super::{Lacking, Record, digits};
use crate::export::ExportError;
use slewkit::lie::interpolation::{Row, cubic, missed};
use slewkit::{Vector3, lie};
use std::fmt::Write as _;
use std::io::Write;

/// Largest relative deviation of the duration from a whole number of ticks.
const WHOLE: f64 = 1e-6;
/// Smallest number of rows for which the interpolation error can be measured: one row is left out
/// and interpolated from its two neighbours.
const LEFT_OUT: usize = 3;
/// Largest number of rows of a table.
const MAX_ROWS: f64 = 1e7;

/// Writes the table for on-board use.
pub(super) fn write(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let time = &record.trajectory.time;
    let steps = time.len() - 1;
    if record.trajectory.torque.len() < steps {
        return Err(Lacking::Inputs.into());
    }
    let nodes: Vec<Row> = (0..=steps)
        .map(|k| Row {
            attitude: lie::rotation_from_quaternion(&record.trajectory.quaternion[k]),
            rate: record.rate(k),
        })
        .collect();
    let (start, duration) = (time[0], time[steps] - time[0]);
    let equal =
        time.windows(2).all(|pair| (pair[1] - pair[0] - duration / steps as f64).abs() < 1e-9 * duration);
    let tick = match record.tables.tick {
        Some(tick) => tick,
        None if equal => duration / steps as f64,
        None => return Err(Lacking::Tick.into()),
    };
    let ticks = (duration / tick).round();
    if !(1.0..=MAX_ROWS).contains(&ticks) || (duration / tick - ticks).abs() > WHOLE * ticks.max(1.0) {
        return Err(Lacking::Tick.into());
    }
    let on_nodes = equal && ticks as usize == steps;
    let mut rows = Vec::with_capacity(ticks as usize + 1);
    let mut step = 0;
    for index in 0..=ticks as usize {
        let at = start + duration * (index as f64 / ticks);
        if on_nodes {
            rows.push(nodes[index]);
            continue;
        }
        while step + 1 < steps && time[step + 1] <= at {
            step += 1;
        }
        let h = time[step + 1] - time[step];
        rows.push(cubic(&nodes[step], &nodes[step + 1], h, (at - time[step]) / h));
    }
    let times: Vec<f64> = (0..rows.len()).map(|index| index as f64 * tick).collect();
    let mut text = head(record, tick, rows.len())?;
    if rows.len() < LEFT_OUT {
        writeln!(text, "# between rows: not known, since none of {} rows can be left out", rows.len())?;
    } else {
        let (by_line, by_cubic) = missed(&rows, &times);
        writeln!(text, "# between rows, at one rate: at most {by_line:.1e} rad")?;
        writeln!(text, "# between rows, cubic with rates: at most {by_cubic:.1e} rad")?;
    }
    if on_nodes || nodes.len() >= LEFT_OUT {
        let of_nodes = if on_nodes { 0.0 } else { missed(&nodes, time).1 };
        writeln!(text, "# rows against the plan: at most {of_nodes:.1e} rad")?;
    } else {
        writeln!(
            text,
            "# rows against the plan: not known, since none of its {} nodes can be left out",
            nodes.len()
        )?;
    }
    let inputs = record.input_heads();
    let (gains, units) = (record.gain_rows(), record.input_units());
    let mut heads: Vec<String> = inputs.iter().map(|head| format!("held_{head}")).collect();
    if let Some((width, _)) = &gains {
        let states = record.gain_states();
        let input = |input: usize| states.iter().map(move |state| format!("gain_{}_{state}", input + 1));
        heads.extend((0..width / states.len().max(1)).flat_map(input));
    }
    writeln!(
        text,
        "tick,time_s,quaternion_w,quaternion_x,quaternion_y,quaternion_z,angular_velocity_x_rad_s,\
         angular_velocity_y_rad_s,angular_velocity_z_rad_s,held_torque_x_n_m,held_torque_y_n_m,\
         held_torque_z_n_m{}{}",
        if heads.is_empty() { "" } else { "," },
        heads.join(",")
    )?;
    let mut last = record.trajectory.quaternion[0];
    for (index, row) in rows.iter().enumerate() {
        let mut q = if on_nodes {
            record.trajectory.quaternion[index]
        } else {
            lie::quaternion_from_rotation(&row.attitude)
        };
        // The sign of each quaternion is chosen so that the table is continuous.
        if q.iter().zip(last).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
            q = q.map(|part| -part);
        }
        last = q;
        let at = start + times[index];
        // The last row has no following tick, so its torque and inputs are zero.
        let (torque, inputs) = mean(record, at, if index + 1 < rows.len() { tick } else { 0.0 });
        let inputs: Vec<f64> = inputs.iter().zip(&units).map(|(input, unit)| input * unit).collect();
        write!(text, "{index},{}", digits(times[index]))?;
        for number in q.iter().chain(row.rate.iter()).chain(torque.iter()).chain(&inputs) {
            write!(text, ",{}", digits(*number))?;
        }
        if let Some((width, numbers)) = &gains {
            // A tick that begins at a node, within rounding, uses the gains of the step that begins
            // at this node. The last row has no such step.
            let within = at + WHOLE * tick;
            let step = time.partition_point(|node| *node <= within).saturating_sub(1);
            let zeros = vec![0.0; *width];
            let row =
                if index + 1 < rows.len() { numbers.get(step * width..(step + 1) * width) } else { None };
            // The gains of one input are adjacent in the row.
            let states = (width / units.len().max(1)).max(1);
            for (number, unit) in row
                .unwrap_or(&zeros)
                .iter()
                .zip(units.iter().flat_map(|unit| std::iter::repeat_n(unit, states)))
            {
                write!(text, ",{}", digits(number * unit))?;
            }
        }
        text.push('\n');
    }
    writeln!(text, "# crc32 {:08x} of all bytes before this line", crc32(text.as_bytes()))?;
    Ok(output.write_all(text.as_bytes())?)
}

/// Returns the header lines that precede the column headings.
fn head(record: &Record<'_>, tick: f64, rows: usize) -> Result<String, ExportError> {
    let version = if record.gains.is_some() { 2 } else { 1 };
    let mut text = format!("# slewkit flight table {version}\n# {}\n", record.name());
    for note in &record.notes {
        writeln!(text, "# {note}")?;
    }
    if let Some(epoch) = record.identity.epoch {
        writeln!(text, "# epoch {epoch}")?;
    }
    let (reference, body) = (record.reference(), record.identity.body_frame());
    writeln!(text, "# quaternion: Hamilton, scalar first, from {body} to {reference} components")?;
    writeln!(
        text,
        "# rate and torque: axes of {body}; torque and inputs are held over the tick that begins at the row"
    )?;
    if let Some(gains) = &record.gains {
        let held = match gains.every_steps {
            1 => "measured at the tick, held over it".into(),
            every => format!("gains [z; dw] measured at every {every} steps of the plan, held over them"),
        };
        writeln!(
            text,
            "# input = held input of the row - gains [z; dw]: z = log(R*^T R) of the row in rad, dw = w - w* in \
                rad/s, body axes; {held}"
        )?;
        let states = record.gain_states();
        if states.len() == 9 {
            writeln!(
                text,
                "# after dw: momentum that the wheels store less that of the plan, body axes, N m s"
            )?;
        }
        if states.len() == 12 {
            writeln!(
                text,
                "# before z: position in m and velocity in m/s less those of the plan, reference axes"
            )?;
        }
        writeln!(
            text,
            "# gains of step {} of the plan are held to its end",
            gains.frozen_from.saturating_sub(1)
        )?;
        for (index, arc) in gains.arcs.iter().enumerate() {
            let gain = arc.gain.map(digits).join(", ");
            writeln!(
                text,
                "# arc {} lasts {} s + [{gain}] [z; dw] of the start",
                index + 1,
                digits(arc.length_s)
            )?;
        }
    }
    writeln!(text, "# tick_s {}\n# rows {rows}", digits(tick))?;
    Ok(text)
}

/// Returns the torque and the inputs of the plan, averaged over the tick that begins at time `at`
/// \[s\]; zeros if `tick` is 0.
fn mean(record: &Record<'_>, at: f64, tick: f64) -> (Vector3, Vec<f64>) {
    let (time, count) = (&record.trajectory.time, record.trajectory.input_count);
    let (mut torque, mut inputs) = (Vector3::zeros(), vec![0.0; count]);
    if tick == 0.0 {
        return (torque, inputs);
    }
    let first = time.partition_point(|node| *node <= at).saturating_sub(1);
    // A tick that ends at a node, within rounding, does not use the step that begins at this
    // node.
    let end = at + tick * (1.0 - WHOLE);
    for step in (first..time.len() - 1).take_while(|step| time[*step] < end) {
        let share = ((at + tick).min(time[step + 1]) - at.max(time[step])) / tick;
        torque += share * record.trajectory.held_torque(step);
        for (input, held) in inputs.iter_mut().zip(record.trajectory.held_inputs(step)) {
            *input += share * held;
        }
    }
    (torque, inputs)
}
