//! Dense nonlinear programs with a handful of unknowns, such as the lengths of arcs and the times
//! of pulses.

pub(crate) mod bounds;
pub(crate) mod kkt;
pub(crate) mod quadratic;
