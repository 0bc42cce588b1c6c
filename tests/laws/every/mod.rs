//! Laws of every Lie kernel and every environment, one table each: a new one is a line there.
//!
//! The tables of private items are in `src`: every integrator (`propagate/integrator/tests`: order,
//! momentum, reversal, symplectic form, by `Kind::all`), every control law
//! (`optimize/discrete/control_law/tests`), every step (`optimize/discrete/step/tests`: derivatives
//! against dual numbers).

mod environments;
mod kernels;
