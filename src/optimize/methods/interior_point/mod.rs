//! The interior-point method: optimal maneuvers within limits, with attitudes on the rotation
//! group.
//!
//! [`iteration`] is the algorithm and [`riccati`] its linear algebra. Neither knows a spacecraft:
//! they see a [`program`] of stages. [`chain`] is the maneuver as such a program, and [`tuning`]
//! has every number that the theory does not give.

pub(crate) mod chain;
pub(crate) mod iteration;
pub(crate) mod method;
pub(crate) mod program;
pub(crate) mod riccati;
pub(crate) mod tuning;

#[cfg(test)]
mod chain_tests;
#[cfg(test)]
mod everyday_tests;
#[cfg(test)]
mod tests;
