//! Rows of a simulation as CSV, JSON lines and one JSON document.
//!
//! A single body has its columns and keys without a prefix; several are `body1_…`, `body2_…` in a table, and a list
//! `bodies` in JSON.

use super::layout::Layout;
use super::report::{Seen, Totals};
use crate::cli::failure::Exit;
use serde::Serialize;
use slewkit::files::export::ExportError;
use slewkit::propagate::integrator::Invariants;
use slewkit::propagate::simulate::{BodyState, Row, Run};
use std::io::Write;

impl Layout {
    /// The names of the columns.
    pub fn header(&self) -> String {
        let vector =
            |name: &str, unit: &str| ["x", "y", "z"].map(|part| format!("{name}_{part}_{unit}")).join(",");
        let mut columns = vec!["time_s".to_string()];
        for (index, moves) in self.moves.iter().enumerate() {
            let prefix = if self.moves.len() == 1 { String::new() } else { format!("body{}_", index + 1) };
            columns.push(["w", "x", "y", "z"].map(|part| format!("{prefix}quaternion_{part}")).join(","));
            columns.push(vector(&format!("{prefix}angular_velocity"), "rad_s"));
            if *moves {
                columns.push(vector(&format!("{prefix}position"), "m"));
                columns.push(vector(&format!("{prefix}velocity"), "m_s"));
            }
        }
        columns.extend((1..=self.wheels.len()).map(|wheel| format!("wheel_momentum_{wheel}_n_m_s")));
        columns.push("energy_j".into());
        if self.anything_moves() {
            columns.push(vector("linear_momentum", "n_s"));
        }
        columns.extend([vector("angular_momentum", "n_m_s"), "orthogonality_error".into()]);
        columns.join(",")
    }

    /// One line of the table.
    pub fn write_csv(&self, row: &Row, output: &mut dyn Write) -> Result<(), ExportError> {
        // The debug form of a float is the shortest that reads back to the same bits.
        write!(output, "{:?}", row.time)?;
        let mut list = |values: &[f64]| values.iter().try_for_each(|value| write!(output, ",{value:?}"));
        for (body, moves) in row.bodies.iter().zip(&self.moves) {
            list(&body.quaternion)?;
            list(body.angular_velocity.as_slice())?;
            if *moves {
                list(body.position.as_slice())?;
                list(body.velocity.as_slice())?;
            }
        }
        let Invariants { energy, linear_momentum, angular_momentum, orthogonality } = &row.invariants;
        list(&self.wheel_momenta(row.time))?;
        list(&[*energy])?;
        if self.anything_moves() {
            list(linear_momentum.as_slice())?;
        }
        list(angular_momentum.as_slice())?;
        list(&[*orthogonality])?;
        Ok(writeln!(output)?)
    }

    /// One line, an object.
    pub fn write_jsonl(&self, row: &Row, output: &mut dyn Write) -> Result<(), ExportError> {
        serde_json::to_writer(&mut *output, &Line::new(row, self))?;
        Ok(writeln!(output)?)
    }
}

/// One row, keys with units.
#[derive(Serialize)]
struct Line {
    time_s: f64,
    #[serde(flatten)]
    alone: Option<BodyLine>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bodies: Vec<BodyLine>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wheel_momentum_n_m_s: Vec<f64>,
    energy_j: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    linear_momentum_n_s: Option<[f64; 3]>,
    angular_momentum_n_m_s: [f64; 3],
    orthogonality_error: f64,
}

#[derive(Serialize)]
struct BodyLine {
    quaternion_wxyz: [f64; 4],
    angular_velocity_rad_s: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_m_s: Option<[f64; 3]>,
}

impl BodyLine {
    fn new(body: &BodyState, moves: bool) -> Self {
        Self {
            quaternion_wxyz: body.quaternion,
            angular_velocity_rad_s: body.angular_velocity.into(),
            position_m: moves.then(|| body.position.into()),
            velocity_m_s: moves.then(|| body.velocity.into()),
        }
    }
}

impl Line {
    fn new(row: &Row, layout: &Layout) -> Self {
        let lines = row.bodies.iter().zip(&layout.moves).map(|(body, moves)| BodyLine::new(body, *moves));
        let mut bodies: Vec<_> = lines.collect();
        let alone = if bodies.len() == 1 { bodies.pop() } else { None };
        Self {
            time_s: row.time,
            alone,
            bodies,
            wheel_momentum_n_m_s: layout.wheel_momenta(row.time),
            energy_j: row.invariants.energy,
            linear_momentum_n_s: layout.anything_moves().then(|| row.invariants.linear_momentum.into()),
            angular_momentum_n_m_s: row.invariants.angular_momentum.into(),
            orthogonality_error: row.invariants.orthogonality,
        }
    }
}

/// The whole simulation as one document, a list per key.
#[derive(Serialize)]
pub struct Document<'a> {
    status: &'static str,
    exit_code: u8,
    name: &'a str,
    integrator: &'static str,
    duration_s: f64,
    steps: u64,
    /// Where interrupted.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps_made: Option<u64>,
    step_s: f64,
    stride: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    symplectic: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    force_evaluations: Option<u64>,
    /// The only key that differs between two runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    stepping_time_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<Totals>,
    /// Two bodies that came within reach of one another.
    #[serde(skip_serializing_if = "Option::is_none")]
    encounter: Option<Meeting<'a>>,
    trajectory: Columns<'a>,
    #[serde(skip)]
    layout: &'a Layout,
}

#[derive(Serialize)]
struct Meeting<'a> {
    time_s: f64,
    bodies: [&'a str; 2],
    distance_m: f64,
}

#[derive(Serialize)]
struct Columns<'a> {
    time_s: Vec<f64>,
    #[serde(flatten)]
    alone: Option<BodyColumns<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bodies: Vec<BodyColumns<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wheel_momentum_n_m_s: Vec<Vec<f64>>,
    energy_j: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    linear_momentum_n_s: Vec<[f64; 3]>,
    angular_momentum_n_m_s: Vec<[f64; 3]>,
    orthogonality_error: Vec<f64>,
}

#[derive(Default, Serialize)]
struct BodyColumns<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    quaternion_wxyz: Vec<[f64; 4]>,
    angular_velocity_rad_s: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    position_m: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    velocity_m_s: Vec<[f64; 3]>,
}

impl<'a> Document<'a> {
    pub fn new(layout: &'a Layout) -> Self {
        let columns = |name| BodyColumns { name: Some(name), ..BodyColumns::default() };
        let several = layout.bodies.len() > 1;
        let trajectory = Columns {
            time_s: Vec::new(),
            alone: (!several).then(BodyColumns::default),
            bodies: layout.bodies.iter().filter(|_| several).map(|name| columns(name.as_str())).collect(),
            wheel_momentum_n_m_s: Vec::new(),
            energy_j: Vec::new(),
            linear_momentum_n_s: Vec::new(),
            angular_momentum_n_m_s: Vec::new(),
            orthogonality_error: Vec::new(),
        };
        Self {
            status: "simulated",
            exit_code: 0,
            name: &layout.name,
            integrator: layout.integrator,
            duration_s: layout.duration,
            steps: layout.steps,
            steps_made: None,
            step_s: layout.duration / layout.steps as f64,
            stride: layout.stride,
            order: None,
            symplectic: None,
            force_evaluations: None,
            stepping_time_s: None,
            errors: None,
            encounter: None,
            trajectory,
            layout,
        }
    }

    pub fn push(&mut self, row: &Row) {
        let Columns { time_s, alone, bodies, .. } = &mut self.trajectory;
        time_s.push(row.time);
        for ((columns, body), moves) in
            alone.iter_mut().chain(bodies).zip(&row.bodies).zip(&self.layout.moves)
        {
            columns.quaternion_wxyz.push(body.quaternion);
            columns.angular_velocity_rad_s.push(body.angular_velocity.into());
            if *moves {
                columns.position_m.push(body.position.into());
                columns.velocity_m_s.push(body.velocity.into());
            }
        }
        let Invariants { energy, linear_momentum, angular_momentum, orthogonality } = &row.invariants;
        if !self.layout.wheels.is_empty() {
            self.trajectory.wheel_momentum_n_m_s.push(self.layout.wheel_momenta(row.time));
        }
        self.trajectory.energy_j.push(*energy);
        if self.layout.anything_moves() {
            self.trajectory.linear_momentum_n_s.push((*linear_momentum).into());
        }
        self.trajectory.angular_momentum_n_m_s.push((*angular_momentum).into());
        self.trajectory.orthogonality_error.push(*orthogonality);
    }

    /// With what the run came to; `interrupted`: how the program will end, and the steps made.
    pub fn finished(self, run: Option<&Run>, seen: Option<&Seen>, interrupted: Option<(Exit, u64)>) -> Self {
        Self {
            status: interrupted.map_or(self.status, |(exit, _)| exit.status()),
            exit_code: interrupted.map_or(self.exit_code, |(exit, _)| exit.code()),
            steps_made: interrupted.map(|(_, steps)| steps),
            order: run.map(|run| run.facts.order),
            symplectic: run.map(|run| run.facts.symplectic),
            force_evaluations: run.map(|run| run.work.force_evaluations),
            stepping_time_s: run.map(|run| run.stepping.as_secs_f64()),
            errors: seen.map(|seen| seen.totals),
            encounter: run.and_then(|run| run.encounter).map(|encounter| Meeting {
                time_s: encounter.time,
                bodies: encounter.bodies.map(|body| self.layout.bodies[body].as_str()),
                distance_m: encounter.distance,
            }),
            ..self
        }
    }
}
