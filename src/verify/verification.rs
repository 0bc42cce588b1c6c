//! The results of the witnesses, in the form in which a plan file stores them.

use super::margins::Margin;
use crate::maneuver::problem::{Motion, ProblemError};
use crate::maneuver::solution::TerminalError;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The results of all witnesses. Errors are at `t = T`, relative to the terminal conditions of the
/// problem unless the name states otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Verification {
    /// Discrete witness (exponential form of the equations): terminal attitude error \[rad\].
    pub discrete_attitude_rad: f64,
    /// Discrete witness: terminal momentum error `|ΔΠ| T / J_mean`.
    pub discrete_momentum_relative: f64,
    /// Discrete witness, SE(3) only: terminal position error, relative to the unit of length.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_position_relative: Option<f64>,
    /// Discrete witness, SE(3) only: terminal linear momentum error, relative to mass · length /
    /// `T`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub discrete_linear_momentum_relative: Option<f64>,
    /// Continuous witness, torque held over each step: terminal attitude error \[rad\].
    pub continuous_attitude_rad: f64,
    /// Continuous witness, torque held over each step: terminal rate error [rad/s].
    pub continuous_rate_rad_s: f64,
    /// Continuous witness, torque interpolated linearly over each step: terminal attitude error
    /// \[rad\].
    pub interpolated_attitude_rad: f64,
    /// Continuous witness, torque interpolated linearly over each step: terminal rate error
    /// [rad/s].
    pub interpolated_rate_rad_s: f64,
    /// Continuous witness, inputs held over each step, SE(3) only: terminal position error \[m\].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_position_m: Option<f64>,
    /// Continuous witness, inputs held over each step, SE(3) only: terminal velocity error [m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub continuous_velocity_m_s: Option<f64>,
    /// Symplectic witness, torque held over each step: terminal attitude error \[rad\]. It starts
    /// from the state of the continuous witness at the start of the last window. `None` if it
    /// cannot check the plan; [`Verification::witnesses`] states the reason.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_attitude_rad: Option<f64>,
    /// Symplectic witness: terminal rate error [rad/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_rate_rad_s: Option<f64>,
    /// Symplectic witness, SE(3) only: terminal position error \[m\].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_position_m: Option<f64>,
    /// Symplectic witness, SE(3) only: terminal velocity error [m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_velocity_m_s: Option<f64>,
    /// Largest scaled distance between the ends of the symplectic and the continuous witness in a
    /// window.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub symplectic_to_continuous: Option<f64>,
    /// Observed order of convergence of the discrete witness to the continuous one over the
    /// windows, with the held torque at h, h/2, h/4. `None` at round-off, or if it could not be
    /// computed.
    pub order: Option<f64>,
    /// Largest norm of the actuator torque at the nodes [N·m].
    pub peak_torque_n_m: f64,
    /// Largest norm of the angular velocity at the nodes [rad/s].
    pub peak_rate_rad_s: f64,
    /// Smallest margin to every limit and constraint, in the order of the problem.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub margins: Vec<Margin>,
    /// The witnesses that ran, their methods, and the numbers of steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub witnesses: Vec<Testimony>,
    /// The reason why a witness could not reach the end; its results are then NaN. `None` if all
    /// witnesses reached it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub failure: Option<String>,
    /// All checks, each with value, limit and result.
    pub checks: Vec<Check>,
}

/// The method of a witness, and the number of steps of the plan over which it ran.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Testimony {
    /// Name of the witness: "discrete", "continuous, held torque", "continuous, linear torque",
    /// "order" or "symplectic".
    pub witness: String,
    /// The method of the witness, or the reason why it cannot check the plan.
    pub method: String,
    /// Number of steps of the plan over which the witness ran: all steps, or the steps in the
    /// windows.
    pub steps: usize,
    /// Number of windows over which the witness ran.
    pub windows: usize,
}

/// A check of a verification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The name of the check.
    pub name: String,
    /// The measured value.
    pub value: f64,
    /// The limit of the value: an upper limit, or a lower limit for the order.
    pub limit: f64,
    /// Whether the value is within the limit.
    pub passed: bool,
}

/// The reason why a witness could not reach the end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WitnessError {
    /// The problem itself is unusable.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The recorded rows do not fit the problem.
    #[error("the plan has {found} {what}, the problem needs {expected}")]
    Rows {
        /// Name of the quantity that has the wrong number of rows.
        what: &'static str,
        /// Number of rows in the plan.
        found: usize,
        /// Number of rows that the problem requires.
        expected: usize,
    },
    /// A translating body is given in a rotating reference frame; its scheme supports only inertial
    /// frames.
    #[error("a body that translates cannot be judged in a turning reference frame")]
    TurningFrame,
    /// The implicit equation has no solution with a turn below 90° in a step.
    #[error(
        "at t = {time} s the body turns too far for one step of {step} s: the implicit equation has no \
            physical solution"
    )]
    StepTooLong {
        /// Start of the step \[s\].
        time: f64,
        /// Length of the step \[s\].
        step: f64,
    },
    /// The times of the nodes are not increasing.
    #[error("the step at t = {time} s has the length {step} s: it must be positive and finite")]
    Step {
        /// Start of the step \[s\].
        time: f64,
        /// Length of the step \[s\].
        step: f64,
    },
    /// The integrator of the continuous witness failed.
    #[error("at t = {time} s the continuous equations of motion could not be integrated to the tolerance")]
    Continuous {
        /// Start of the step of the plan \[s\].
        time: f64,
    },
    /// The caller requested a stop, or the time limit was reached.
    #[error("the witnesses were stopped before they finished")]
    Stopped,
    /// A number became NaN or infinite.
    #[error("at t = {time} s a number is no longer finite")]
    NotFinite {
        /// Time of the first such number \[s\].
        time: f64,
    },
}

impl Verification {
    /// Returns whether every check passed; false if no check was made.
    pub fn passed(&self) -> bool {
        !self.checks.is_empty() && self.checks.iter().all(|check| check.passed)
    }

    /// Returns whether the witnesses were stopped before they finished.
    pub fn was_stopped(&self) -> bool {
        self.failure.as_ref().is_some_and(|failure| *failure == WitnessError::Stopped.to_string())
    }

    /// Returns the terminal error of the discrete witness.
    pub fn discrete(&self) -> TerminalError {
        TerminalError {
            attitude_rad: self.discrete_attitude_rad,
            momentum_relative: self.discrete_momentum_relative,
            position_relative: self.discrete_position_relative,
            linear_momentum_relative: self.discrete_linear_momentum_relative,
        }
    }

    pub(super) fn unknown(motion: Motion) -> Self {
        let on_se3 = (motion == Motion::RigidBody).then_some(f64::NAN);
        Self {
            discrete_attitude_rad: f64::NAN,
            discrete_momentum_relative: f64::NAN,
            discrete_position_relative: on_se3,
            discrete_linear_momentum_relative: on_se3,
            continuous_attitude_rad: f64::NAN,
            continuous_rate_rad_s: f64::NAN,
            interpolated_attitude_rad: f64::NAN,
            interpolated_rate_rad_s: f64::NAN,
            continuous_position_m: on_se3,
            continuous_velocity_m_s: on_se3,
            peak_torque_n_m: f64::NAN,
            peak_rate_rad_s: f64::NAN,
            ..Self::default()
        }
    }

    /// Adds a check that passes if `value ≤ limit`. NaN never passes.
    pub(super) fn at_most(&mut self, name: &str, value: f64, limit: f64) {
        self.checks.push(Check { name: name.into(), value, limit, passed: value <= limit });
    }

    pub(super) fn ran(&mut self, witness: &str, method: impl Into<String>, steps: usize, windows: usize) {
        self.witnesses.push(Testimony { witness: witness.into(), method: method.into(), steps, windows });
    }
}
