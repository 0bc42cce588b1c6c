//! Pulses of least fuel: inputs that are off or at a limit, and on for a shortest time at least.
//!
//! 1. **Schedules** ([`schedule`], [`search`]): which inputs are on, how often and in which order, from extremals without a shortest pulse.
//! 2. **Times** ([`motion`], [`quadratic`], [`optimum`]): the best times of a schedule, by sequential quadratic programming.
//! 3. **The grid** ([`ties`], [`on_grid`]): the discrete optimum of the same pulses, with the same bounds acting.

pub(crate) mod motion;
pub(crate) mod on_grid;
pub(crate) mod optimum;
pub(crate) mod quadratic;
pub(crate) mod schedule;
pub(crate) mod search;
#[cfg(test)]
mod tests;
mod ties;
