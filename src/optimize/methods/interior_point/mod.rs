//! The interior point: optima within limits, on the group.
//!
//! [`iteration`] is the algorithm, [`riccati`] its linear algebra, and neither knows a spacecraft: they see a [`program`] of stages.
//! [`chain`] is the maneuver as such a program, and [`tuning`] has every number that the theory does not give.

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
