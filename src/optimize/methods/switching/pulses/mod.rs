//! Minimum-fuel pulses: inputs that are off or at a limit, and on for at least the minimum pulse
//! width.
//!
//! 1. **Schedules** ([`schedule`], [`search`]): which inputs are on, how often and in which order,
//!    derived from extremals without a minimum pulse width.
//! 2. **Times** ([`motion`], [`optimum`]): the optimal times of a schedule, by sequential quadratic
//!    programming.
//! 3. **The grid** ([`on_grid`]): the discrete optimum of the same pulses, with the same active
//!    bounds.
//!
//! # How are thrusters quantised that are only on or off?
//!
//! The minimum-fuel plan is converted to pulses, and these are not rounded but optimised again:
//! which pulses exist is a discrete choice, while their begin and end times form a smooth problem
//! (`switching/pulses`). With the pulses of each input in order and the minimum pulse width `d`,
//! the bounds are `0 ≤ on_1`, `off_1 − on_1 ≥ d`, `on_2 ≥ off_1`, …, `off_n ≤ T`. The fuel is
//! linear in the times and the six terminal conditions are smooth in them, even where the switches
//! of two inputs exchange their order. The linearised flow of states and costates is carried along
//! the path (twelve lanes for any number of pulses). It gives the derivative of the end with
//! respect to every time and, because `∂L/∂t` is `∓2 s(t)` with the switching function `s`, the
//! exact second derivative of the Lagrangian. The SQP iteration stays on the terminal conditions,
//! which are restored after each step, so that the fuel is the merit function of a step. Its
//! programs are small and dense (`optimize/nlp`). They are solved by an active-set method, and by
//! an interior-point method if the active set cycles, because the last digits of the interior-point
//! solution change the times by more than they save. Newton on costates and on the times that no
//! bound holds finishes the solution, for the continuous motion and, with the mean Hamiltonians of
//! the arcs in place of switching functions, for the grid, whose optimum has the same active
//! bounds.
//!
//! A free duration is one more time, after all others, whose price is the price of time. Its
//! derivative is the Hamiltonian at the end, which needs no additional sweep. To delay all times is
//! to wait at the start; therefore it is the Hamiltonian before the first pulse minus all other
//! derivatives, in first and in second order. For pulses that last to the end, this time is the
//! upper bound.
//!
//! The initial schedules are the pulses of the extremals without a minimum pulse width, whose short
//! pulses are dropped, lengthened or merged in a dozen ways; two impulses for either homotopy
//! class; and some of these with random changes of the times and additional pulses, more of them if
//! none meets the terminal conditions. The best are changed by one pulse at a time (dropped,
//! merged, or added where a switching function has the wrong sign) as long as that reduces the
//! fuel. Two opposite pulses of width d turn the body by as little as `a d²`, with the acceleration
//! `a`, so that a plan nearly always exists. It may cost several times as much if pulses should be
//! much shorter than d. The only lower bound is the fuel without a minimum pulse width, and the gap
//! is reported relative to it.

pub(crate) mod motion;
pub(crate) mod on_grid;
pub(crate) mod optimum;
pub(crate) mod schedule;
pub(crate) mod search;
#[cfg(test)]
mod tests;
