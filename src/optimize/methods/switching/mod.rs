//! Minimum time and fuel: extremals whose inputs switch from one limit to the other, or off and on.
//!
//! The answer is found in four layers, each of which takes away a way to fail:
//!
//! 1. **Smoothed extremals** ([`extremal`], [`flow`], [`smooth`]). The inputs cost a little near
//!    their limits, so that the law is smooth; ε goes to zero. Newton has all nodes of the path for
//!    unknowns and condenses them to seven.
//! 2. **Branches** ([`base`], [`branches`]). From a polynomial path for either way round, through
//!    the isotropic body, with the law tipped to one side and to the other where branches part.
//! 3. **Switching times** ([`arcs`], `sequence`, [`certificate`]). Newton on costates, duration and
//!    switching times; a certificate tells where an input has the wrong sign, and how much that
//!    could cost; what is wrong is put right, by short pulses too.
//! 4. **The grid** ([`grid_step`], [`on_grid`], [`discretize`]). The discrete optimum of Lie–Verlet
//!    on steps that end where the inputs switch.
//!
//! What the theory leaves open stands in [`tuning`].
//!
//! Singular arcs are common (an axis of inertia along an axis of torque makes them of second order,
//! and inputs chatter at their ends): no finite list of switches is exact then. Such a branch ends
//! as arcs with a small gap, or as a smoothed law.
//!
//! Bilimoria and Wie, *Time-Optimal Three-Axis Reorientation of a Rigid Spacecraft*, 1993; Zhu,
//! Trélat and Cerf, *Planar tilting maneuver of a spacecraft: singular arcs in the minimum time
//! problem and chattering*, 2016.

pub(crate) mod arcs;
pub(crate) mod base;
pub(crate) mod branches;
pub(crate) mod certificate;
pub(crate) mod discretize;
pub(crate) mod eigenaxis;
pub(crate) mod extremal;
pub(crate) mod flow;
pub(crate) mod fuel;
pub(crate) mod grid_step;
mod impulses;
pub(crate) mod least_gap;
pub(crate) mod limit;
pub(crate) mod long;
pub(crate) mod moved;
pub(crate) mod on_grid;
pub(crate) mod pulses;
pub(crate) mod scaled;
pub(crate) mod search;
pub(crate) mod sequence;
pub(crate) mod smooth;
#[cfg(test)]
mod tests;
pub(crate) mod tuning;
pub(crate) mod work;
