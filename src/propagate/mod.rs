//! Propagation without optimisation: integrators and simulations.

pub(crate) mod adaptive;
pub mod integrator;
pub(crate) mod plant;
pub(crate) mod row;
pub mod simulate;
