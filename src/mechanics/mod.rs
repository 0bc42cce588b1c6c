//! What moves, what acts on it, and what drives it.

pub mod actuators;
pub mod body;
pub(crate) mod drift_equation;
pub mod environment;
pub mod full_body;
pub mod number;
