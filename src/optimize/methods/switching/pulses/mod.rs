//! Pulses of least fuel: inputs that are off or at a limit, and on for a shortest time at least.
//!
//! 1. **Schedules** ([`schedule`], [`search`]): which inputs are on, how often and in which order,
//!    from extremals without a shortest pulse.
//! 2. **Times** ([`motion`], [`optimum`]): the best times of a schedule, by sequential quadratic
//!    programming.
//! 3. **The grid** ([`on_grid`]): the discrete optimum of the same pulses, with the same bounds
//!    acting.
//!
//! # How are thrusters quantised that are only on or off?
//!
//! The plan of least fuel is made into pulses, and then it is not rounded but optimised again:
//! which pulses there are is a choice, when they begin and end is a smooth problem
//! (`switching/pulses`). With the pulses of each input in order, `0 ≤ on_1`, `off_1 − on_1 ≥ d`,
//! `on_2 ≥ off_1`, …, `off_n ≤ T`, the fuel is linear in their times and the six terminal
//! conditions are smooth in them, also where two inputs change places. The linearised flow of state
//! and costates is carried along the way (twelve lanes, however many pulses); it gives the
//! derivative of the end with respect to every time and, because `∂L/∂t` is `∓2 s(t)` with the
//! switching function `s`, the exact second derivative of the Lagrangian. SQP stays on the terminal
//! conditions, which are met again after each step, so that fuel alone tells whether a step is
//! good; its programs, small and dense (`optimize/nlp`), are solved by exchange of the bounds that
//! act, and by an interior point where that goes round in circles: its last digits alone move the
//! times by more than they gain. Newton on costates and those times that no bound holds ends it,
//! for the equations of motion and, with the mean Hamiltonians of the arcs for switching functions,
//! for the grid, whose optimum has the same bounds acting.
//!
//! A duration that is sought is one more time, after all others, whose price is that of time. Its
//! derivative is the Hamiltonian at the end, and that needs no sweep of its own: moving all times
//! later is to wait at the start, so it is the Hamiltonian before the first pulse less all other
//! derivatives, in first order and in second. Whichever pulses last to the end hang on it as others
//! do on their bounds.
//!
//! Schedules to start from are the pulses of the extremals without a shortest pulse, of which short
//! ones are dropped, made longer or joined in a dozen ways, two impulses for either way round, and
//! some of these with times moved at random and pulses added; more of the last where none meets the
//! end. The best are changed by one pulse at a time, dropped, joined, or added where a switching
//! function has the wrong sign, as long as that burns less. Two opposite pulses of length d turn by
//! as little as `a d²`, so that nearly always there is a plan; it may be several times as dear
//! where pulses would be much shorter than d. There is no bound from below but the fuel without a
//! shortest pulse, and the gap is told against that.

pub(crate) mod motion;
pub(crate) mod on_grid;
pub(crate) mod optimum;
pub(crate) mod schedule;
pub(crate) mod search;
#[cfg(test)]
mod tests;
