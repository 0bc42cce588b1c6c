//! The interior-point method: optimal maneuvers within limits, with attitudes on the rotation
//! group.
//!
//! [`iteration`] is the algorithm and [`riccati`] its linear algebra. Both work on a [`program`] of
//! stages and contain nothing specific to spacecraft. [`chain`] formulates the maneuver as such a
//! program, and [`tuning`] has every constant that the theory does not determine.

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
