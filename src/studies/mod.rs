//! Things side by side: methods on one maneuver, integrators on one motion.

pub mod integrators;
pub mod methods;
