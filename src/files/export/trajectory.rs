//! The trajectory as JSON, streamed both ways: no tree of values is built.

use crate::Vector3;
use crate::maneuver::{Motion, Problem, Scheme, Trajectory};
use serde::de::{DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{SerializeStruct, Serializer};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Why a trajectory is not written, or not accepted.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum TrajectoryError {
    /// A number is NaN or infinite.
    #[error("{key} of the trajectory is not finite in row {row}")]
    NotFinite {
        /// The key in the file.
        key: &'static str,
        /// Which row, from 0.
        row: usize,
    },
    /// An array has another length than the maneuver needs.
    #[error("{key} of the trajectory has {found} {of}, the maneuver needs {needed}")]
    Shape {
        /// The key in the file.
        key: &'static str,
        /// "rows" or "numbers in a row".
        of: &'static str,
        /// What it has.
        found: usize,
        /// What it needs.
        needed: usize,
    },
}

/// Checks that every number is finite and every array as long as the maneuver needs.
///
/// # Errors
/// The first [`TrajectoryError`].
pub fn check_trajectory(trajectory: &Trajectory, problem: &Problem) -> Result<(), TrajectoryError> {
    let dimension = problem.dimension();
    let inputs = problem.actuation.count();
    check_shape(trajectory, problem.steps, problem.scheme, problem.motion)?;
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

fn check_shape(
    trajectory: &Trajectory,
    steps: usize,
    scheme: Scheme,
    motion: Motion,
) -> Result<(), TrajectoryError> {
    let (nodes, rows) = (steps + 1, scheme.input_rows(steps));
    let (moving_nodes, moving_rows) = match motion {
        Motion::Attitude => (0, 0),
        Motion::RigidBody => (nodes, rows),
    };
    for (key, found, needed) in [
        ("time_s", trajectory.time.len(), nodes),
        ("quaternion_wxyz", trajectory.quaternion.len(), nodes),
        ("angular_velocity_rad_s", trajectory.angular_velocity.len(), nodes),
        ("position_m", trajectory.position.len(), moving_nodes),
        ("velocity_m_s", trajectory.velocity.len(), moving_nodes),
        ("torque_n_m", trajectory.torque.len(), rows),
        ("force_n", trajectory.force.len(), moving_rows),
    ] {
        expect(key, "rows", found, needed)?;
    }
    let count = trajectory.input_count.max(1);
    expect("input", "rows", trajectory.input.len() / count, rows)
}

/// Checks that every number is finite.
pub(super) fn check_finite(trajectory: &Trajectory) -> Result<(), TrajectoryError> {
    fn scan<'a, R: IntoIterator<Item = &'a f64>>(
        key: &'static str,
        rows: impl Iterator<Item = R>,
    ) -> Result<(), TrajectoryError> {
        for (row, values) in rows.enumerate() {
            if values.into_iter().any(|value| !value.is_finite()) {
                return Err(TrajectoryError::NotFinite { key, row });
            }
        }
        Ok(())
    }
    scan("time_s", trajectory.time.iter().map(std::slice::from_ref))?;
    scan("quaternion_wxyz", trajectory.quaternion.iter())?;
    scan("angular_velocity_rad_s", trajectory.angular_velocity.iter())?;
    scan("position_m", trajectory.position.iter())?;
    scan("velocity_m_s", trajectory.velocity.iter())?;
    scan("input", trajectory.input.chunks(trajectory.input_count.max(1)))?;
    scan("torque_n_m", trajectory.torque.iter())?;
    scan("force_n", trajectory.force.iter())?;
    scan("wheel_momentum_n_m_s", trajectory.wheel_momentum.chunks(wheel_count(trajectory).max(1)))?;
    scan("costates", trajectory.costates.chunks(costate_width(trajectory)))
}

/// 6 or 12: positions are there or not.
pub(super) fn costate_width(trajectory: &Trajectory) -> usize {
    if trajectory.position.is_empty() { 6 } else { 12 }
}

/// Number of reaction wheels: a row of their momenta at every node.
pub(super) fn wheel_count(trajectory: &Trajectory) -> usize {
    trajectory.wheel_momentum.len() / trajectory.time.len().max(1)
}

/// A [`Trajectory`] with the keys of the file format.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryDocument<'a>(pub Cow<'a, Trajectory>);

impl Serialize for TrajectoryDocument<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::Error;
        let trajectory = &*self.0;
        check_finite(trajectory).map_err(S::Error::custom)?;
        let moving = !trajectory.position.is_empty();
        let wheels = wheel_count(trajectory);
        let fields = if moving { 9 } else { 6 } + usize::from(wheels > 0);
        let mut keys = serializer.serialize_struct("Trajectory", fields)?;
        keys.serialize_field("time_s", &trajectory.time)?;
        keys.serialize_field("quaternion_wxyz", &trajectory.quaternion)?;
        keys.serialize_field("angular_velocity_rad_s", &Vectors(&trajectory.angular_velocity))?;
        if moving {
            keys.serialize_field("position_m", &Vectors(&trajectory.position))?;
            keys.serialize_field("velocity_m_s", &Vectors(&trajectory.velocity))?;
        }
        keys.serialize_field("input", &Rows(&trajectory.input, trajectory.input_count))?;
        keys.serialize_field("torque_n_m", &Vectors(&trajectory.torque))?;
        if moving {
            keys.serialize_field("force_n", &Vectors(&trajectory.force))?;
        }
        if wheels > 0 {
            keys.serialize_field("wheel_momentum_n_m_s", &Rows(&trajectory.wheel_momentum, wheels))?;
        }
        keys.serialize_field("costates", &Rows(&trajectory.costates, costate_width(trajectory)))?;
        keys.end()
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
        }
        let keys = Keys::deserialize(deserializer)?;
        let trajectory = Trajectory {
            time: keys.time_s,
            quaternion: keys.quaternion_wxyz,
            angular_velocity: vectors(keys.angular_velocity_rad_s),
            position: vectors(keys.position_m),
            velocity: vectors(keys.velocity_m_s),
            input: keys.input.values,
            input_count: keys.input.width,
            torque: vectors(keys.torque_n_m),
            force: vectors(keys.force_n),
            wheel_momentum: keys.wheel_momentum_n_m_s.values,
            costates: keys.costates.values,
        };
        // Rows and columns that have changed places would fit as well.
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

/// Same size and alignment: the collect happens in place.
fn vectors(rows: Vec<[f64; 3]>) -> Vec<Vector3> {
    rows.into_iter().map(Vector3::from).collect()
}

/// Vectors as rows of three numbers.
struct Vectors<'a>(&'a [Vector3]);

impl Serialize for Vectors<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|v| [v.x, v.y, v.z]))
    }
}

/// A flat array as rows of a given width.
struct Rows<'a>(&'a [f64], usize);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.chunks(self.1.max(1)))
    }
}

/// Rows of equal width, read into one flat array.
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

        /// Appends one row and returns its width.
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
