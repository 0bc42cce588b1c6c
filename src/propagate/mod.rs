//! Propagation without optimisation: integrators and simulations.

pub mod integrator;
pub mod simulate;
