//! A simulation as `slew simulate --format json` writes it, read back for pictures.

use super::{ExportError, TrajectoryError};
use serde::Deserialize;
use serde_json::Value;
use std::io::{BufReader, Read};

/// The part of the document of a simulation that is read.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SimulationFile {
    /// "simulated", or how it ended before its time.
    pub status: String,
    /// Name of the simulation.
    pub name: String,
    /// The integrator.
    pub integrator: String,
    /// Duration \[s\].
    pub duration_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// The step \[s\].
    pub step_s: f64,
    /// The largest errors at the rows, by their key.
    #[serde(default)]
    pub errors: serde_json::Map<String, Value>,
    /// The rows.
    pub trajectory: SimulationRows,
}

/// The rows of a simulation: the states of one body, or of several in `bodies`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct SimulationRows {
    /// Times \[s\].
    pub time_s: Vec<f64>,
    /// The one body.
    #[serde(flatten)]
    pub body: BodyRows,
    /// The rows of several bodies.
    #[serde(default)]
    pub bodies: Vec<BodyRows>,
    /// Energy \[J\].
    pub energy_j: Vec<f64>,
    /// Angular momentum, inertial [N·m·s].
    pub angular_momentum_n_m_s: Vec<[f64; 3]>,
    /// `‖I − RᵀR‖`.
    pub orthogonality_error: Vec<f64>,
}

/// The rows of one body, SI units; positions and velocities if the body moves.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct BodyRows {
    /// The name of the body, if the simulation has several.
    #[serde(default)]
    pub name: String,
    /// Attitudes `[w, x, y, z]`.
    #[serde(default)]
    pub quaternion_wxyz: Vec<[f64; 4]>,
    /// Angular velocities, body axes.
    #[serde(default)]
    pub angular_velocity_rad_s: Vec<[f64; 3]>,
    /// Positions.
    #[serde(default)]
    pub position_m: Vec<[f64; 3]>,
}

impl SimulationFile {
    /// Reads a document.
    ///
    /// # Errors
    /// Returns an error of the stream, of a text that is not a simulation, or of lists of
    /// different length.
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
