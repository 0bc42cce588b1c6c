//! What was asked, as a plan file remembers it: the maneuver and the settings, in SI units.

use crate::actuation::{AxisFrame, Channel};
use crate::environment::{Description, Environment};
use crate::problem::{Motion, Path, Problem, State};
use crate::settings::{Method, Settings};
use crate::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// The maneuver of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProblemRecord {
    /// "attitude" or "rigid_body".
    pub motion: String,
    /// Inertia, body axes.
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// Mass, when the body moves too.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mass_kg: Option<f64>,
    /// What acts on the body besides its actuators.
    pub environment: EnvironmentRecord,
    /// Torque inputs.
    pub torque: ChannelRecord,
    /// Force inputs.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub force: Option<ChannelRecord>,
    /// State at the start.
    pub start: StateRecord,
    /// State at the end.
    pub end: StateRecord,
    /// Duration.
    pub duration_s: f64,
    /// "best", "shortest", "long" or "as_given".
    pub path: String,
    /// With "as_given": the rotation vector from the start, body axes of the start.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub rotation_from_start_rad: Option<[f64; 3]>,
}

/// The environment and its numbers, for people and for comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentRecord {
    /// "free", "uniform_gravity", …, or "custom" for a field of the caller's own.
    pub kind: String,
    /// Its numbers, by name.
    #[serde(flatten)]
    pub numbers: BTreeMap<String, Value>,
}

/// Inputs of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelRecord {
    /// "body" or "reference".
    pub frame: String,
    /// One axis per input, a column of `B`.
    pub axes: Vec<[f64; 3]>,
    /// Effort weight `W`, rows.
    pub effort_weight: Vec<Vec<f64>>,
}

/// The state at one end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateRecord {
    /// Attitude `R`, rows.
    pub matrix: [[f64; 3]; 3],
    /// Angular velocity, body axes.
    pub angular_velocity_rad_s: [f64; 3],
    /// Position, when the body moves too.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub position_m: Option<[f64; 3]>,
    /// Velocity, when the body moves too.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub velocity_m_s: Option<[f64; 3]>,
}

/// The settings of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettingsRecord {
    /// "auto" or "shooting".
    pub method: String,
    /// Tolerance of the scaled discrete terminal error.
    pub tolerance: f64,
    /// Limit on the continuous terminal attitude error.
    pub continuous_tolerance_rad: Option<f64>,
    /// Wall-clock limit.
    pub time_limit_s: Option<f64>,
    /// Iteration limit of one Newton run.
    pub max_iterations: usize,
}

fn rows(matrix: &Matrix3) -> [[f64; 3]; 3] {
    matrix.transpose().into()
}

fn row(vector: &Vector3) -> [f64; 3] {
    (*vector).into()
}

impl From<&dyn Environment> for EnvironmentRecord {
    fn from(environment: &dyn Environment) -> Self {
        let Description { kind, numbers } = environment.describe();
        let number = |numbers: Vec<f64>| match numbers[..] {
            [number] => number.into(),
            _ => numbers.into(),
        };
        let numbers = numbers.into_iter().map(|(name, numbers)| (name.into(), number(numbers))).collect();
        Self { kind, numbers }
    }
}

impl From<&Channel> for ChannelRecord {
    fn from(channel: &Channel) -> Self {
        let frame = match channel.frame() {
            AxisFrame::Body => "body",
            AxisFrame::Reference => "reference",
        };
        let weight = channel.weight();
        Self {
            frame: frame.into(),
            axes: channel.axes().iter().map(row).collect(),
            effort_weight: weight.row_iter().map(|row| row.iter().copied().collect()).collect(),
        }
    }
}

impl From<&Problem> for ProblemRecord {
    fn from(problem: &Problem) -> Self {
        let moving = problem.motion == Motion::RigidBody;
        let state = |state: &State| StateRecord {
            matrix: rows(&state.attitude),
            angular_velocity_rad_s: row(&state.angular_velocity),
            position_m: moving.then(|| row(&state.position)),
            velocity_m_s: moving.then(|| row(&state.velocity)),
        };
        let (path, rotation) = match &problem.path {
            Path::Best => ("best", None),
            Path::Shortest => ("shortest", None),
            Path::Long => ("long", None),
            Path::AsGiven(rotation) => ("as_given", Some(row(rotation))),
        };
        Self {
            motion: if moving { "rigid_body" } else { "attitude" }.into(),
            inertia_kg_m2: rows(problem.body.inertia.j()),
            mass_kg: problem.body.mass,
            environment: problem.environment.as_ref().into(),
            torque: (&problem.actuation.torque).into(),
            force: problem.actuation.force.as_ref().map(Into::into),
            start: state(&problem.start),
            end: state(&problem.end),
            duration_s: problem.duration,
            path: path.into(),
            rotation_from_start_rad: rotation,
        }
    }
}

impl From<&Settings> for SettingsRecord {
    fn from(settings: &Settings) -> Self {
        let method = match settings.method {
            Method::Auto => "auto",
            Method::Shooting => "shooting",
            Method::Scp => "scp",
        };
        Self {
            method: method.into(),
            tolerance: settings.tolerance,
            continuous_tolerance_rad: settings.continuous_tolerance,
            time_limit_s: settings.time_limit.map(|limit| limit.as_secs_f64()),
            max_iterations: settings.max_iterations,
        }
    }
}

impl ProblemRecord {
    /// The keys in which two maneuvers differ beyond round-off, each with both values.
    pub fn differences(&self, other: &Self) -> Vec<Difference> {
        let tree = |record: &Self| serde_json::to_value(record).unwrap_or(Value::Null);
        let mut found = Vec::new();
        compare("", &tree(self), &tree(other), &mut found);
        found
    }
}

/// One key in which two maneuvers differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The key, dotted.
    pub key: String,
    /// Its value in the first, as JSON.
    pub first: String,
    /// Its value in the second.
    pub second: String,
}

/// A rounding of an angle on another machine is no difference.
const ROUND_OFF: f64 = 1e-12;

fn compare(key: &str, first: &Value, second: &Value, found: &mut Vec<Difference>) {
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            for name in a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))) {
                let path = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                let value = |map: &serde_json::Map<String, Value>| map.get(name).cloned();
                compare(&path, &value(a).unwrap_or_default(), &value(b).unwrap_or_default(), found);
            }
        }
        _ if agree(first, second) => {}
        _ => found.push(Difference { key: key.into(), first: first.to_string(), second: second.to_string() }),
    }
}

fn agree(first: &Value, second: &Value) -> bool {
    match (first, second) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(first, second)| agree(first, second))
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= ROUND_OFF * a.abs().max(b.abs()).max(1.0)
        }
        _ => first == second,
    }
}
