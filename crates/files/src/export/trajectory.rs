//! Serialisation of trajectories as JSON: they are written and read without an intermediate tree of
//! values.

use super::columns::{TrajectoryError, check_finite, columns, costate_width};
use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use slewkit::maneuver::{Motion, Problem, State, Trajectory};
use slewkit::{Matrix3, Vector3};
use std::borrow::Cow;
use std::fmt;

/// Checks that every number is finite and that every array has the length that the maneuver
/// requires.
///
/// # Errors
/// Returns the first [`TrajectoryError`].
pub fn check_trajectory(trajectory: &Trajectory, problem: &Problem) -> Result<(), TrajectoryError> {
    let dimension = problem.dimension();
    let inputs = problem.actuation.count();
    check_shape(trajectory, problem)?;
    expect("input", "numbers in a row", trajectory.input_count, inputs)?;
    let rows = problem.scheme.input_rows(problem.steps);
    expect("costates", "numbers in all", trajectory.costates.len(), rows * dimension)?;
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let momenta = trajectory.wheel_momentum.len();
    expect("wheel_momentum_n_m_s", "numbers in all", momenta, (problem.steps + 1) * wheels)?;
    check_finite(trajectory)
}

fn expect(key: &'static str, of: &'static str, found: usize, needed: usize) -> Result<(), TrajectoryError> {
    if found == needed { Ok(()) } else { Err(TrajectoryError::Shape { key, of, found, needed }) }
}

fn check_shape(trajectory: &Trajectory, problem: &Problem) -> Result<(), TrajectoryError> {
    let (nodes, rows, motion) = (problem.steps + 1, problem.input_rows(), problem.motion);
    for column in columns(trajectory).iter().filter(|column| !column.is_flat()) {
        let moves = ["position_m", "velocity_m_s", "force_n"].contains(&column.key);
        let rows = if column.of_input { rows } else { nodes };
        let needed = if moves && motion == Motion::Attitude { 0 } else { rows };
        expect(column.key, "rows", column.values.len(), needed)?;
    }
    let count = trajectory.input_count.max(1);
    expect("input", "rows", trajectory.input.len() / count, rows)
}

/// Wrapper that serialises a [`Trajectory`] with the keys of the file format.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryDocument<'a>(pub Cow<'a, Trajectory>);

/// Target of the discrete motion of a plan, which landing has shifted from the target of the spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct TargetDocument {
    attitude: Matrix,
    angular_velocity_rad_s: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position_m: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    velocity_m_s: Option<[f64; 3]>,
}

/// An attitude as a rotation matrix, row by row, in the notation of a spec. Unlike a quaternion, a
/// matrix is restored without rounding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Matrix {
    matrix: [[f64; 3]; 3],
}

impl TargetDocument {
    /// Largest absolute element of `RᵀR − I` for which a matrix R is accepted as a rotation.
    const ROTATION: f64 = 1e-9;

    fn of(target: &State, moves: bool) -> Self {
        Self {
            attitude: Matrix { matrix: target.attitude.transpose().into() },
            angular_velocity_rad_s: target.angular_velocity.into(),
            position_m: moves.then(|| target.position.into()),
            velocity_m_s: moves.then(|| target.velocity.into()),
        }
    }

    /// Returns the target as a state; `None` if the matrix is not a rotation.
    fn state(&self) -> Option<State> {
        let attitude = Matrix3::from(self.attitude.matrix).transpose();
        let is_rotation = (attitude.transpose() * attitude - Matrix3::identity()).amax() <= Self::ROTATION
            && attitude.determinant() > 0.0;
        let vector = |row: Option<[f64; 3]>| row.map_or_else(Vector3::zeros, Vector3::from);
        is_rotation.then(|| State {
            position: vector(self.position_m),
            velocity: vector(self.velocity_m_s),
            attitude,
            angular_velocity: self.angular_velocity_rad_s.into(),
        })
    }
}

impl Serialize for TrajectoryDocument<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let trajectory = &*self.0;
        check_finite(trajectory).map_err(serde::ser::Error::custom)?;
        let shown = columns(trajectory).into_iter().filter(|column| column.shown);
        let mut map = serializer.serialize_map(None)?;
        for column in shown {
            map.serialize_entry(column.key, &column.values)?;
        }
        if let Some(target) = &trajectory.target {
            map.serialize_entry("target", &TargetDocument::of(target, !trajectory.position.is_empty()))?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for TrajectoryDocument<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Keys {
            time_s: Vec<f64>,
            quaternion_wxyz: Vec<[f64; 4]>,
            angular_velocity_rad_s: Vec<[f64; 3]>,
            #[serde(default)]
            position_m: Vec<[f64; 3]>,
            #[serde(default)]
            velocity_m_s: Vec<[f64; 3]>,
            input: Flat,
            torque_n_m: Vec<[f64; 3]>,
            #[serde(default)]
            force_n: Vec<[f64; 3]>,
            #[serde(default)]
            wheel_momentum_n_m_s: Flat,
            costates: Flat,
            #[serde(default)]
            target: Option<TargetDocument>,
        }
        let keys = Keys::deserialize(deserializer)?;
        let mut trajectory = Trajectory::default();
        trajectory.time = keys.time_s;
        trajectory.quaternion = keys.quaternion_wxyz;
        trajectory.angular_velocity = vectors(keys.angular_velocity_rad_s);
        trajectory.position = vectors(keys.position_m);
        trajectory.velocity = vectors(keys.velocity_m_s);
        trajectory.input = keys.input.values;
        trajectory.input_count = keys.input.width;
        trajectory.torque = vectors(keys.torque_n_m);
        trajectory.force = vectors(keys.force_n);
        trajectory.wheel_momentum = keys.wheel_momentum_n_m_s.values;
        trajectory.costates = keys.costates.values;
        if let Some(target) = &keys.target {
            let refused = || D::Error::custom("`trajectory.target.attitude.matrix` is not a rotation matrix");
            trajectory.target = Some(target.state().ok_or_else(refused)?);
        }
        // The number of values alone does not show whether rows and columns were exchanged.
        let nodes = trajectory.time.len().max(trajectory.quaternion.len());
        let (width, count) = (keys.wheel_momentum_n_m_s.width, trajectory.wheel_momentum.len());
        if width * nodes != count {
            let (found, needed) = (count / width.max(1), nodes);
            let (key, of) = ("wheel_momentum_n_m_s", "rows");
            return Err(D::Error::custom(TrajectoryError::Shape { key, of, found, needed }));
        }
        let needed = costate_width(&trajectory);
        if keys.costates.width != needed && !trajectory.costates.is_empty() {
            let found = keys.costates.width;
            let error = TrajectoryError::Shape { key: "costates", of: "numbers in a row", found, needed };
            return Err(D::Error::custom(error));
        }
        Ok(Self(Cow::Owned(trajectory)))
    }
}

/// Converts rows to vectors without copying, because the two types have the same memory layout.
fn vectors(rows: Vec<[f64; 3]>) -> Vec<Vector3> {
    rows.into_iter().map(Vector3::from).collect()
}

/// Rows of equal length, read into one flat array.
#[derive(Default)]
struct Flat {
    values: Vec<f64>,
    width: usize,
}

impl<'de> Deserialize<'de> for Flat {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Outer;
        impl<'de> Visitor<'de> for Outer {
            type Value = Flat;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("rows of numbers")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Flat, A::Error> {
                let mut flat = Flat { values: Vec::new(), width: 0 };
                let mut row = 0;
                while let Some(width) = rows.next_element_seed(Row(&mut flat.values))? {
                    if row == 0 {
                        flat.width = width;
                    } else if width != flat.width {
                        return Err(A::Error::custom(format_args!(
                            "row {row} has {width} numbers, row 0 has {}",
                            flat.width
                        )));
                    }
                    row += 1;
                }
                Ok(flat)
            }
        }

        /// Deserialises one row: appends its numbers to the array and returns their number.
        struct Row<'a>(&'a mut Vec<f64>);
        impl<'de> DeserializeSeed<'de> for Row<'_> {
            type Value = usize;
            fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
                deserializer.deserialize_seq(self)
            }
        }
        impl<'de> Visitor<'de> for Row<'_> {
            type Value = usize;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a row of numbers")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut row: A) -> Result<usize, A::Error> {
                let before = self.0.len();
                while let Some(value) = row.next_element()? {
                    self.0.push(value);
                }
                Ok(self.0.len() - before)
            }
        }
        deserializer.deserialize_seq(Outer)
    }
}
