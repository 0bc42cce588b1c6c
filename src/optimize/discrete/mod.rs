//! The discrete optimal control problem: its step, control law, necessary conditions and
//! second-order conditions.
//!
//! All methods solve this problem, and none of them owns it. The parts are:
//!
//! - [`step`]: a step of the variational integrator and its linearisation;
//! - `control_law`: the optimal inputs for a given costate;
//! - `terminal`: the terminal condition of a maneuver;
//! - [`sweep`]: the forward sweep that joins these three;
//! - `second_order`: the second-order conditions of an extremal that was found;
//! - [`linear_plan`]: the motion near a plan to first order;
//! - `candidate`: a maneuver of this problem, complete or partial, that the methods accept and
//!   return.

pub(crate) mod candidate;
pub(crate) mod control_law;
pub mod linear_plan;
pub(crate) mod second_order;
pub mod step;
pub mod sweep;
pub(crate) mod terminal;
