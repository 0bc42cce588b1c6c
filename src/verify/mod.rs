//! Independent witnesses of a plan. They share no solver, sweep or derivative code with the planner.

use serde::{Deserialize, Serialize};

/// What the witnesses found. All errors are at `t = T`, against the terminal conditions of the problem
/// unless the name says otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// Discrete equations re-propagated with the exponential form: attitude error [rad].
    pub discrete_attitude_rad: f64,
    /// The same: momentum error, `|ΔΠ| T / J_mean`.
    pub discrete_momentum_relative: f64,
    /// The same on SE(3): position error over the unit of length.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_position_relative: Option<f64>,
    /// The same on SE(3): linear momentum error over mass · length / `T`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_linear_momentum_relative: Option<f64>,
    /// Continuous equations of motion, torque held over each step: attitude error [rad].
    pub continuous_attitude_rad: f64,
    /// The same: rate error [rad/s].
    pub continuous_rate_rad_s: f64,
    /// The same with the torque interpolated linearly over each step: attitude error [rad].
    pub interpolated_attitude_rad: f64,
    /// The same, interpolated: rate error [rad/s].
    pub interpolated_rate_rad_s: f64,
    /// The same, held, on SE(3): position error [m].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_position_m: Option<f64>,
    /// The same, held, on SE(3): velocity error [m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_velocity_m_s: Option<f64>,
    /// Observed order at which the discrete witness, with the held torque at h, h/2, h/4, converges to
    /// the continuous end state; `None` when it agrees to round-off already.
    pub order: Option<f64>,
    /// Largest norm of the actuator torque at the nodes [N·m].
    pub peak_torque_n_m: f64,
    /// Largest norm of the angular velocity at the nodes [rad/s].
    pub peak_rate_rad_s: f64,
    /// Every check, with value, limit and verdict.
    pub checks: Vec<Check>,
}

/// One named check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// The value found.
    pub value: f64,
    /// The limit it was held against.
    pub limit: f64,
    /// Whether it holds.
    pub passed: bool,
}

impl Verification {
    /// Whether every check holds.
    pub fn passed(&self) -> bool {
        !self.checks.is_empty() && self.checks.iter().all(|check| check.passed)
    }
}
