//! Things side by side: methods or objectives on one maneuver, integrators on one motion.

pub mod integrators;
pub mod methods;
pub mod objectives;
