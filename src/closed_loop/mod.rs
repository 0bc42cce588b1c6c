//! Simulated flights of a plan: the motion of a true craft, which differs from the model of the
//! plan, under the torques of the plan and its feedback gains.
//!
//! The plant does not use the planner's step. It computes the continuous motion of a craft with
//! another inertia, under torques that are held over a tick (`flight`). One step of the loop is:
//!
//! ```text
//! measure  R exp S(β) exp S(ν) ,  (1 + g) Ω + c + ν     z = [log(R*ᵀR) ; J (Ω − Ω*)]     u = u* − K z
//! within limits ─▶ quantum ─▶ delay ─▶ lag  v += (1 − e^{−h/τ})(c − v) ─▶ τ = exp S(α) B (1 + s) v + b + η
//! ```
//!
//! Every case of a seed has its own random numbers, computed from a key and a counter
//! (`numerics::random`). The results are therefore bit-identical for any number of threads, any
//! order, and any set of other cases. Constant errors are drawn once per case. A drawn inertia is
//! impossible if two of its moments add up to less than the third. It is then drawn again, and the
//! number of such draws is reported.

mod campaign;
mod craft;
mod draws;
mod feedforward;
mod statistics;

pub use campaign::Campaign;
pub use statistics::{Proportion, Sampled, quantile};

use crate::optimize::discrete::linear_plan::Vector6;
use crate::{Matrix3, Vector3};

/// The response of the actuators to commands. By default the response is immediate, within the
/// limits of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Time constant of the actuator lag \[s\].
    pub lag: f64,
    /// Time from a command to its effect on the torque \[s\].
    pub delay: f64,
    /// Quantum of the commands, in the unit of an input: commands are multiples of it. 0: commands
    /// are not quantised.
    pub quantum: f64,
    /// Time between two updates of the torque \[s\]; 0 selects the step of the plan.
    pub tick: f64,
    /// `true` if the feedforward commands compensate the known lag and delay.
    pub leads: bool,
    /// Capacity of the actuators, as a multiple of the limits that the plan keeps. The capacity
    /// above 1 is reserved for the feedback gains.
    pub authority: f64,
}

impl Plant {
    /// The largest number of ticks in a step of the plan.
    const MOST_TICKS: usize = 1000;

    /// Returns the number of ticks in a step of the plan \[s\].
    fn ticks(&self, step: f64) -> usize {
        if self.tick > 0.0 { ((step / self.tick).round() as usize).clamp(1, Self::MOST_TICKS) } else { 1 }
    }
}

impl Default for Plant {
    fn default() -> Self {
        Self { lag: 0.0, delay: 0.0, quantum: 0.0, tick: 0.0, leads: false, authority: 1.0 }
    }
}

/// The result of one simulated flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// Terminal error `[ζ; δΩ]`, true minus planned, rad and rad/s, body axes.
    pub end: Vector6,
    /// Error `[ζ; δΩ]` at each of [`LinearPlan::stops`], true minus planned, rad and rad/s, body
    /// axes.
    ///
    /// [`LinearPlan::stops`]: crate::optimize::discrete::linear_plan::LinearPlan::stops
    pub stops: Vec<Vector6>,
    /// Smallest distance of the motion from each constraint, without the constraint's margin, over
    /// the whole motion: \[rad\] for cones, and a fraction of the limit for rates. Negative if
    /// violated.
    pub room: Vec<f64>,
    /// Smallest distance of the commands from each torque limit that exists, over the whole motion,
    /// SI: from the size limit of each input, the norm limit, and the rate limit of each input, in
    /// this order. Negative if violated.
    pub input_room: Vec<f64>,
    /// Fraction of the steps in which a limit cut the command.
    pub saturated: f64,
    /// Number of draws that were discarded because the inertia was impossible.
    pub rejected: u32,
    /// Drawn values of the uncertain parameters, in the order of
    /// [`Uncertainty::parameters`](crate::uncertainty::Uncertainty::parameters).
    pub parameters: Vec<f64>,
}

/// The state of a flight at one step, for tables and pictures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moment {
    /// Time since the start of the plan \[s\].
    pub time: f64,
    /// Attitude, from body to reference.
    pub attitude: Matrix3,
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vector3,
    /// Deviation `[ζ; δΩ]` from the plan, rad and rad/s.
    pub beside: Vector6,
    /// The inputs commanded in the step that begins at this time, SI; empty at the end of the
    /// motion.
    pub commanded: Vec<f64>,
}

/// A case without a result: the craft turned too fast to be propagated, or every drawn inertia was
/// impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

#[cfg(test)]
mod tests;
