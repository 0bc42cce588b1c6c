//! Flights of a plan: the motion of the true craft, which differs from the planned one, under the
//! plan's torques and gains.
//!
//! The plant is not the planner's step: it is the continuous motion of a craft of another inertia,
//! under torques held over a tick (`flight`). A step of the loop:
//!
//! ```text
//! measure  R exp S(β) exp S(ν) ,  (1 + g) Ω + c + ν     z = [log(R*ᵀR) ; J (Ω − Ω*)]     u = u* − K z
//! within limits ─▶ quantum ─▶ delay ─▶ lag  v += (1 − e^{−h/τ})(c − v) ─▶ τ = exp S(α) B (1 + s) v + b + η
//! ```
//!
//! Every case of a seed has its own random numbers, from a key and a counter
//! (`numerics::random`): the bits do not depend on the number of threads, the order, or the other
//! cases. Constant errors are drawn once for each case. If an inertia is impossible, because two
//! of its moments are less than the third, it is drawn again, and the number of such draws is
//! reported.

mod campaign;
mod craft;
mod draws;
mod feedforward;
mod statistics;

pub use campaign::Campaign;
pub use statistics::{Proportion, Sampled, quantile};

use crate::optimize::discrete::linear_plan::Vector6;
use crate::{Matrix3, Vector3};

/// The response of the actuators to commands; by default immediate, within the limits of the
/// plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// The time constant of the lag of the actuators \[s\].
    pub lag: f64,
    /// Time from a command to its effect \[s\].
    pub delay: f64,
    /// The quantum of commands, in the unit of an input; 0: any number.
    pub quantum: f64,
    /// Time between two changes of the torque \[s\]; 0: the step of the plan.
    pub tick: f64,
    /// Whether the plan's commands lead a lag and a delay, which are known.
    pub leads: bool,
    /// The capacity of the actuators, as a multiple of the limits that the plan keeps. The part
    /// above 1 is reserved for gains.
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

/// The result of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// `[ζ; δΩ]` at the end, rad and rad/s: true minus planned, body axes.
    pub end: Vector6,
    /// `[ζ; δΩ]` in the same form at each of [`LinearPlan::stops`].
    ///
    /// [`LinearPlan::stops`]: crate::optimize::discrete::linear_plan::LinearPlan::stops
    pub stops: Vec<Vector6>,
    /// The smallest room to each constraint without its margin, along the whole motion: \[rad\]
    /// for cones, relative to the limit for rates; negative for a violation.
    pub room: Vec<f64>,
    /// The smallest room of the commands to each limit of the torques, along the whole motion,
    /// SI: of the size of each input, of the norm, of the rate of each input, for the limits that
    /// exist; negative for a violation.
    pub input_room: Vec<f64>,
    /// Part of the steps in which a limit of the inputs cut a command.
    pub saturated: f64,
    /// The number of impossible inertias that were drawn.
    pub rejected: u32,
    /// The parameters that were drawn, in the order of
    /// [`Uncertainty::parameters`](crate::uncertainty::Uncertainty::parameters).
    pub parameters: Vec<f64>,
}

/// One step of a case, for tables and pictures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// Attitude, body → reference.
    pub attitude: Matrix3,
    /// Angular velocity [rad/s].
    pub angular_velocity: Vector3,
    /// `[ζ; δΩ]` relative to the plan, rad and rad/s.
    pub beside: Vector6,
    /// Inputs that were commanded in the step that begins here, SI; empty at the end.
    pub commanded: Vec<f64>,
}

/// A case that failed: it turned too fast to be propagated, or no drawn inertia was possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

#[cfg(test)]
mod tests;
