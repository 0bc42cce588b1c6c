//! Simulations as written by `slew simulate --format json`, read back for pictures.

use super::{ExportError, TrajectoryError};
use serde::Deserialize;
use serde_json::Value;
use std::io::{BufReader, Read};

/// Contents of a simulation document that pictures need.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SimulationFile {
    /// Status: "simulated", or the reason for which the simulation ended early.
    pub status: String,
    /// Name of the simulation.
    pub name: String,
    /// Name of the integrator.
    pub integrator: String,
    /// Duration of the simulation \[s\].
    pub duration_s: f64,
    /// Number of integration steps.
    pub steps: u64,
    /// Integration step \[s\].
    pub step_s: f64,
    /// Largest error over all rows, for each kind of error, with the key of the kind.
    #[serde(default)]
    pub errors: serde_json::Map<String, Value>,
    /// Rows of the simulation.
    pub trajectory: SimulationRows,
}

/// Rows of a simulation. The states of a single body are in `body`, those of several bodies in
/// `bodies`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct SimulationRows {
    /// Times of the rows \[s\].
    pub time_s: Vec<f64>,
    /// States of the single body; empty if the simulation has several bodies.
    #[serde(flatten)]
    pub body: BodyRows,
    /// States of each of several bodies; empty if the simulation has a single body.
    #[serde(default)]
    pub bodies: Vec<BodyRows>,
    /// Total energy in each row \[J\].
    pub energy_j: Vec<f64>,
    /// Total angular momentum in each row, in inertial axes \[N·m·s\].
    pub angular_momentum_n_m_s: Vec<[f64; 3]>,
    /// Largest orthogonality error `‖I − RᵀR‖` of the rotation matrices in each row.
    pub orthogonality_error: Vec<f64>,
}

/// States of one body in SI units, row by row. Positions exist only if the body translates.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct BodyRows {
    /// Name of the body, if the simulation has several bodies.
    #[serde(default)]
    pub name: String,
    /// Attitude quaternion `[w, x, y, z]` in each row.
    #[serde(default)]
    pub quaternion_wxyz: Vec<[f64; 4]>,
    /// Angular velocity in each row, in body axes \[rad/s\].
    #[serde(default)]
    pub angular_velocity_rad_s: Vec<[f64; 3]>,
    /// Position in each row \[m\]; empty if the body does not translate.
    #[serde(default)]
    pub position_m: Vec<[f64; 3]>,
}

impl SimulationFile {
    /// Reads the JSON document of a simulation.
    ///
    /// # Errors
    /// Returns an error if the stream fails, if the text is not a simulation, or if the lengths of
    /// the lists differ.
    pub fn read(input: impl Read) -> Result<Self, ExportError> {
        let mut file: Self = serde_json::from_reader(BufReader::new(input))?;
        let rows = &mut file.trajectory;
        if rows.bodies.is_empty() {
            rows.bodies = vec![std::mem::take(&mut rows.body)];
        }
        let needed = rows.time_s.len();
        let fit = |key, found: usize| {
            if found == needed {
                Ok(())
            } else {
                Err(TrajectoryError::Shape { key, of: "rows", found, needed })
            }
        };
        fit("energy_j", rows.energy_j.len())?;
        fit("angular_momentum_n_m_s", rows.angular_momentum_n_m_s.len())?;
        fit("orthogonality_error", rows.orthogonality_error.len())?;
        for body in &rows.bodies {
            fit("quaternion_wxyz", body.quaternion_wxyz.len())?;
            fit("angular_velocity_rad_s", body.angular_velocity_rad_s.len())?;
            if !body.position_m.is_empty() {
                fit("position_m", body.position_m.len())?;
            }
        }
        Ok(file)
    }
}
