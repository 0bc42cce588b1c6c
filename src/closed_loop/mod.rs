//! A plan flown: the true craft under the plan's torques and its gains, with all that it differs by.
//!
//! The plant is not the planner's step: it is the continuous motion of a craft of another inertia, under torques held over a tick
//! (`flight`). A step of the loop:
//!
//! ```text
//! measure  R exp S(β) exp S(ν) ,  (1 + g) Ω + c + ν     z = [log(R*ᵀR) ; J (Ω − Ω*)]     u = u* − K z
//! within limits ─▶ quantum ─▶ delay ─▶ lag  v += (1 − e^{−h/τ})(c − v) ─▶ τ = exp S(α) B (1 + s) v + b + η
//! ```
//!
//! Every case of a seed has random numbers of its own, from a key and a counter (`numerics::random`): the same bits for any number
//! of threads, in any order, alone or among others. Constant errors are drawn once a case; an inertia that is none, because two
//! of its moments are less than the third, is drawn again, and how often is told.

mod campaign;
mod craft;
mod draws;
mod feedforward;
mod statistics;

pub use campaign::Campaign;
pub use statistics::{Proportion, Sampled, quantile};

use crate::optimize::discrete::linear_plan::Vector6;
use crate::{Matrix3, Vector3};

/// How the actuators follow what they are told; by default at once, within the limits of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Time constant of their lag \[s\].
    pub lag: f64,
    /// Time from a command to its effect \[s\].
    pub delay: f64,
    /// What commands are multiples of, in the unit of an input; 0: any number.
    pub quantum: f64,
    /// Time between two changes of the torque \[s\]; 0: the step of the plan.
    pub tick: f64,
    /// Whether the plan's commands lead a lag and a delay, which are known.
    pub leads: bool,
    /// What the actuators can give, as a multiple of the limits that the plan keeps: what is above 1 is held back for gains.
    pub authority: f64,
}

impl Default for Plant {
    fn default() -> Self {
        Self { lag: 0.0, delay: 0.0, quantum: 0.0, tick: 0.0, leads: false, authority: 1.0 }
    }
}

/// What became of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// `[ζ; δΩ]` at the end, rad and rad/s: true minus planned, body axes.
    pub end: Vector6,
    /// What is least left of each constraint without its margin, along the whole motion: \[rad\] of cones, of rates a part of the
    /// limit; negative where it is violated.
    pub room: Vec<f64>,
    /// What commands leave of each limit of the torques, along the whole motion, SI: of the size of each input, of the norm, of how fast
    /// each changes, of those there are; negative where it is exceeded.
    pub input_room: Vec<f64>,
    /// Part of the steps in which a limit of the inputs cut a command.
    pub saturated: f64,
    /// Inertias that were drawn and are none.
    pub rejected: u32,
    /// The parameters that were drawn, in the order of [`Uncertainty::parameters`](crate::uncertainty::Uncertainty::parameters).
    pub parameters: Vec<f64>,
}

/// One step of a case, for people.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Moment {
    /// Time \[s\].
    pub time: f64,
    /// Attitude, body → reference.
    pub attitude: Matrix3,
    /// Angular velocity [rad/s].
    pub angular_velocity: Vector3,
    /// `[ζ; δΩ]` beside the plan, rad and rad/s.
    pub beside: Vector6,
    /// Inputs that were commanded in the step that begins here, SI; none at the end.
    pub commanded: Vec<f64>,
}

/// A case that cannot be told: it turned faster than can be followed, or no inertia was one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

#[cfg(test)]
mod tests;
