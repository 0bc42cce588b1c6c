//! The discrete problem: its step, its control law, its necessary conditions and what they prove.
//!
//! What every method solves and none of them owns. A step of the variational integrator with its
//! linearisation ([`step`]), the inputs that a costate asks for (`control_law`), where a maneuver
//! may end (`terminal`), the sweep that joins them ([`sweep`]), the second order of what it finds
//! (`second_order`), and the motion beside a plan to first order ([`linear_plan`]). A `candidate`
//! is a maneuver of this problem, whole or in part, that methods take and give.

pub(crate) mod candidate;
pub(crate) mod control_law;
pub mod linear_plan;
pub(crate) mod second_order;
pub mod step;
pub mod sweep;
pub(crate) mod terminal;
