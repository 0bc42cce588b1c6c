//! What was asked, as a plan file remembers it: the maneuver and the settings, in SI units.

use crate::maneuver::constraint::{Constraint, Direction, Rule, Side};
use crate::maneuver::problem::{Motion, Path, Problem, State};
use crate::maneuver::settings::Settings;
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, Limits, Wheels};
use crate::mechanics::environment::{Description, Environment};
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
    /// The wheels behind the torque inputs.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub wheels: Option<WheelsRecord>,
    /// Where the body may point and how fast it may turn.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub constraints: Vec<ConstraintRecord>,
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
    /// Limit of the size of each input.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit: Option<Vec<f64>>,
    /// Limit of the norm of `B u`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub norm_limit: Option<f64>,
    /// Limit of the rate of change of each input, per second.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub rate_limit: Option<Vec<f64>>,
}

/// Reaction wheels; their axes and torque limits are those of the torque inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelsRecord {
    /// Momentum of each wheel at the start.
    pub momentum_n_m_s: Vec<f64>,
    /// Limit of its size; `null` where there is none.
    pub momentum_limit_n_m_s: Vec<Option<f64>>,
}

/// One constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstraintRecord {
    /// Its name.
    pub name: String,
    /// What it asks.
    #[serde(flatten)]
    pub rule: RuleRecord,
}

/// What a constraint asks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RuleRecord {
    /// Boresights outside of cones.
    KeepOut(ConeRecord),
    /// Boresights inside of cones.
    KeepIn(ConeRecord),
    /// The norm of the angular velocity.
    RateNorm {
        /// Its limit.
        angular_velocity_limit_rad_s: f64,
    },
    /// The components of the angular velocity, body axes.
    RateAxes {
        /// Their limits.
        angular_velocity_limit_rad_s: [f64; 3],
    },
}

/// Cones about directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConeRecord {
    /// Unit vectors, body axes.
    pub boresights_body: Vec<[f64; 3]>,
    /// Unit vectors fixed in inertial space, axes of the reference frame at the start.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub directions_inertial: Vec<[f64; 3]>,
    /// Unit vectors fixed to the reference frame.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub directions_reference: Vec<[f64; 3]>,
    /// Half angle, without the margin.
    pub half_angle_rad: f64,
    /// Margin.
    pub margin_rad: f64,
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
    /// "auto", "shooting" or "scp".
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

impl From<&ActuatorSet> for ChannelRecord {
    fn from(channel: &ActuatorSet) -> Self {
        let frame = match channel.frame() {
            AxisFrame::Body => "body",
            AxisFrame::Reference => "reference",
        };
        let weight = channel.weight();
        let Limits { size, norm, rate } = channel.limits().clone();
        Self {
            frame: frame.into(),
            axes: channel.axes().iter().map(row).collect(),
            effort_weight: weight.row_iter().map(|row| row.iter().copied().collect()).collect(),
            limit: size,
            norm_limit: norm,
            rate_limit: rate,
        }
    }
}

impl From<&Wheels> for WheelsRecord {
    fn from(wheels: &Wheels) -> Self {
        let limit = |limit: &f64| limit.is_finite().then_some(*limit);
        Self {
            momentum_n_m_s: wheels.momentum.clone(),
            momentum_limit_n_m_s: wheels.momentum_limit.iter().map(limit).collect(),
        }
    }
}

impl From<&Constraint> for ConstraintRecord {
    fn from(constraint: &Constraint) -> Self {
        let rule = match &constraint.rule {
            Rule::RateNorm(limit) => RuleRecord::RateNorm { angular_velocity_limit_rad_s: *limit },
            Rule::RateAxes(limits) => RuleRecord::RateAxes { angular_velocity_limit_rad_s: row(limits) },
            Rule::Pointing(pointing) => {
                let directions = |turning: bool| {
                    let of_kind = move |direction: &&Direction| direction.turns_with_frame == turning;
                    pointing
                        .directions
                        .iter()
                        .filter(of_kind)
                        .map(|direction| row(&direction.vector))
                        .collect()
                };
                let cone = ConeRecord {
                    boresights_body: pointing.boresights.iter().map(row).collect(),
                    directions_inertial: directions(false),
                    directions_reference: directions(true),
                    half_angle_rad: pointing.half_angle,
                    margin_rad: pointing.margin,
                };
                match pointing.side {
                    Side::KeepOut => RuleRecord::KeepOut(cone),
                    Side::KeepIn => RuleRecord::KeepIn(cone),
                }
            }
        };
        Self { name: constraint.name.clone(), rule }
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
            wheels: problem.actuation.wheels.as_ref().map(Into::into),
            constraints: problem.constraints.iter().map(Into::into).collect(),
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
        Self {
            method: settings.method.name().into(),
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
        // Tables of a list, such as constraints, one by one.
        (Value::Array(a), Value::Array(b))
            if a.len() == b.len() && a.iter().chain(b).all(Value::is_object) =>
        {
            for (index, (first, second)) in a.iter().zip(b).enumerate() {
                compare(&format!("{key}.{index}"), first, second, found);
            }
        }
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
        (Value::Object(a), Value::Object(b)) => {
            let has = |(key, first): (&String, &Value)| b.get(key).is_some_and(|second| agree(first, second));
            a.len() == b.len() && a.iter().all(has)
        }
        _ => first == second,
    }
}
