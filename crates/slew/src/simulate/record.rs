//! Output of the rows of a simulation as CSV, JSON lines or a single JSON document. All three
//! formats use the same list of fields.
//!
//! Columns and keys have no prefix if the simulation has a single body. If it has several bodies,
//! the columns of a table have the prefixes `body1_`, `body2_` and so on, and JSON has a list
//! `bodies`.

use super::layout::Layout;
use super::report::Seen;
use crate::Exit;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use slewkit::propagate::integrator::Invariants;
use slewkit::propagate::simulate::{Encounter, Run, SimulationRow};
use slewkit_files::export::{ExportError, write_document};
use std::io::Write;

/// A quantity in each row of a simulation.
#[derive(Clone, Debug, PartialEq)]
struct Field {
    /// Index of the body to which the quantity belongs; `None` for a quantity of the whole
    /// system.
    body: Option<usize>,
    /// The key of the quantity in JSON.
    key: String,
    /// The names of the quantity's columns in a table.
    columns: Vec<String>,
    /// True if the quantity is a single number, false if it is a list of numbers.
    scalar: bool,
    /// Index of the first number of the quantity in a row.
    at: usize,
}

/// Returns the fields that every row of a simulation has.
fn fields(layout: &Layout) -> Vec<Field> {
    let mut fields: Vec<Field> = Vec::new();
    let prefix =
        |body: usize| if layout.bodies.len() > 1 { format!("body{}_", body + 1) } else { String::new() };
    let mut add = |body: Option<usize>, name: &str, unit: &str, parts: &[&str]| {
        let (key, prefix) = (format!("{name}_{unit}"), body.map_or_else(String::new, prefix));
        let column = |part: &&str| match unit {
            "wxyz" => format!("{prefix}{name}_{part}"),
            unit => format!("{prefix}{name}_{part}_{unit}"),
        };
        let scalar = parts.is_empty();
        let columns = if scalar { vec![key.clone()] } else { parts.iter().map(column).collect() };
        let at = fields.last().map_or(0, |last| last.at + last.columns.len());
        fields.push(Field { body, key, columns, scalar, at });
    };
    const AXES: &[&str] = &["x", "y", "z"];
    add(None, "time", "s", &[]);
    for (body, moves) in layout.moves.iter().enumerate() {
        add(Some(body), "quaternion", "wxyz", &["w", "x", "y", "z"]);
        add(Some(body), "angular_velocity", "rad_s", AXES);
        if *moves {
            add(Some(body), "position", "m", AXES);
            add(Some(body), "velocity", "m_s", AXES);
        }
    }
    let wheels: Vec<String> = (1..=layout.wheels.len()).map(|wheel| wheel.to_string()).collect();
    if !wheels.is_empty() {
        add(None, "wheel_momentum", "n_m_s", &wheels.iter().map(String::as_str).collect::<Vec<_>>());
    }
    add(None, "energy", "j", &[]);
    if layout.anything_moves() {
        add(None, "linear_momentum", "n_s", AXES);
    }
    add(None, "angular_momentum", "n_m_s", AXES);
    add(None, "orthogonality", "error", &[]);
    fields
}

/// Appends the numbers of a row to `numbers`, in the order of the fields.
fn add_numbers(layout: &Layout, row: &SimulationRow, numbers: &mut Vec<f64>) {
    numbers.push(row.time);
    for (body, moves) in row.bodies.iter().zip(&layout.moves) {
        numbers.extend(body.quaternion);
        numbers.extend(&body.angular_velocity);
        if *moves {
            numbers.extend(&body.position);
            numbers.extend(&body.velocity);
        }
    }
    let Invariants { energy, linear_momentum, angular_momentum, orthogonality, .. } = &row.invariants;
    numbers.extend(layout.wheel_momenta(row.time));
    numbers.push(*energy);
    if layout.anything_moves() {
        numbers.extend(linear_momentum);
    }
    numbers.extend(angular_momentum);
    numbers.push(*orthogonality);
}

/// Writer of the rows of a simulation. For a JSON document, it stores the rows in memory.
pub struct Recorder<'a> {
    layout: &'a Layout,
    fields: Vec<Field>,
    /// The number of values in a row.
    width: usize,
    /// Values of the last row or, for a JSON document, of all rows.
    numbers: Vec<f64>,
}

impl<'a> Recorder<'a> {
    pub fn new(layout: &'a Layout) -> Self {
        let fields = fields(layout);
        let width = fields.iter().map(|field| field.columns.len()).sum();
        Self { layout, fields, width, numbers: Vec::new() }
    }

    /// Writes the header of the table.
    pub fn write_header(&self, output: &mut dyn Write) -> Result<(), ExportError> {
        let columns: Vec<&str> =
            self.fields.iter().flat_map(|field| &field.columns).map(String::as_str).collect();
        Ok(writeln!(output, "{}", columns.join(","))?)
    }

    /// Writes a row as one line of the table.
    pub fn write_csv(&mut self, row: &SimulationRow, output: &mut dyn Write) -> Result<(), ExportError> {
        self.only(row);
        // The debug format of a float is the shortest text that reads back to the same bits.
        write!(output, "{:?}", self.numbers[0])?;
        self.numbers[1..].iter().try_for_each(|number| write!(output, ",{number:?}"))?;
        Ok(writeln!(output)?)
    }

    /// Writes a row as one line with a JSON object.
    pub fn write_jsonl(&mut self, row: &SimulationRow, output: &mut dyn Write) -> Result<(), ExportError> {
        self.only(row);
        serde_json::to_writer(&mut *output, &self.object(false))?;
        Ok(writeln!(output)?)
    }

    /// Stores a row in memory for the JSON document.
    pub fn hold(&mut self, row: &SimulationRow) {
        add_numbers(self.layout, row, &mut self.numbers);
    }

    fn only(&mut self, row: &SimulationRow) {
        self.numbers.clear();
        self.hold(row);
    }

    fn object(&self, several: bool) -> Object<'_> {
        let rows = Rows { numbers: &self.numbers, width: self.width, several };
        Object { fields: &self.fields, rows, bodies: &self.layout.bodies, name: None }
    }

    /// Writes the JSON document with all stored rows and the result of the run. `interrupted`
    /// contains the exit code and the number of steps of a run that ended early.
    pub fn write_document(
        &self,
        run: Option<&Run>,
        seen: Option<&Seen>,
        interrupted: Option<(Exit, u64)>,
        output: &mut dyn Write,
    ) -> Result<(), ExportError> {
        let layout = self.layout;
        let meeting = |met: Encounter| {
            let bodies = met.bodies.map(|body| layout.bodies[body].as_str());
            document! { time_s: met.time, bodies: bodies, distance_m: met.distance }
        };
        let document = document! {
            status: interrupted.map_or("simulated", |(exit, _)| exit.status()),
            exit_code: interrupted.map_or(0, |(exit, _)| exit.code()),
            name: &layout.name,
            integrator: layout.integrator,
            duration_s: layout.duration,
            steps: layout.steps,
            steps_made if some: interrupted.map(|(_, steps)| steps),
            step_s: layout.duration / layout.steps as f64,
            stride: layout.stride,
            order if some: run.map(|run| run.facts.order),
            symplectic if some: run.map(|run| run.facts.symplectic),
            force_evaluations if some: run.map(|run| run.work.force_evaluations),
            // No other key has a different value in each run.
            stepping_time_s if some: run.map(|run| run.stepping.as_secs_f64()),
            errors if some: seen.map(|seen| seen.totals),
            // First encounter of two bodies, at which their distance becomes less than the sum of
            // their sizes.
            encounter if some: run.and_then(|run| run.encounter).map(meeting),
            trajectory: self.object(true),
        };
        write_document(&document, output)
    }
}

/// Values of a single row, or of several rows in their order.
#[derive(Clone, Copy)]
struct Rows<'a> {
    numbers: &'a [f64],
    width: usize,
    /// True to write a list of values for each key, false to write the values of a single row.
    several: bool,
}

/// JSON object with the fields of a row. The fields of several bodies form a list of objects within
/// it.
struct Object<'a> {
    fields: &'a [Field],
    rows: Rows<'a>,
    bodies: &'a [String],
    /// Name of the body, which is written before its fields; `None` for the whole system.
    name: Option<&'a str>,
}

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = self.rows;
        let mut map = serializer.serialize_map(None)?;
        self.name.iter().try_for_each(|name| map.serialize_entry("name", name))?;
        for fields in self.fields.chunk_by(|a, b| a.body.is_some() == b.body.is_some()) {
            if self.bodies.len() > 1 && fields[0].body.is_some() {
                let each = fields.chunk_by(|a, b| a.body == b.body).zip(self.bodies);
                let objects = each.map(|(fields, name)| {
                    let name = rows.several.then_some(name.as_str());
                    Object { fields, rows, bodies: &[], name }
                });
                map.serialize_entry("bodies", &objects.collect::<Vec<_>>())?;
            } else {
                fields
                    .iter()
                    .try_for_each(|field| map.serialize_entry(&field.key, &Values { field, rows }))?;
            }
        }
        map.end()
    }
}

/// Values of a key in one row or in several rows.
struct Values<'a> {
    field: &'a Field,
    rows: Rows<'a>,
}

impl<'a> Serialize for Values<'a> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { field, rows } = self;
        let list = |row: &'a [f64]| &row[field.at..][..field.columns.len()];
        let each = rows.numbers.chunks(rows.width).map(list);
        match (rows.several, field.scalar) {
            (true, true) => serializer.collect_seq(each.map(|list| list[0])),
            (true, false) => serializer.collect_seq(each),
            (false, true) => rows.numbers[field.at].serialize(serializer),
            (false, false) => list(rows.numbers).serialize(serializer),
        }
    }
}
