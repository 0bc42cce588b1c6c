//! Comparisons: methods, objectives, or methods for switching times on one maneuver; integrators on
//! one motion.

pub(crate) mod clock;
pub mod integrators;
pub mod methods;
pub mod objectives;
pub mod ways;
