//! Minimum time and minimum fuel: extremals with bang-bang inputs, or inputs that are off or on.
//!
//! A solution is found in four layers, each of which removes one cause of failure:
//!
//! 1. **Smoothed extremals** ([`extremal`], [`flow`], [`smooth`]). A small cost of inputs near
//!    their limits makes the control law smooth; its weight ε goes to zero. The unknowns of
//!    Newton's method are all nodes of the path; they are condensed to seven unknowns.
//! 2. **Branches** ([`base`], [`branches`]). The initial guess is a polynomial path in either
//!    homotopy class. A homotopy leads from an isotropic body to the actual one, and
//!    symmetry-breaking perturbations of the control law, of both signs, separate branches where
//!    they part.
//! 3. **Switching times** ([`arcs`], `sequence`, [`certificate`]). Newton solves for costates,
//!    duration and switching times. A certificate reports where an input has the wrong sign, and
//!    bounds the cost that this adds. Wrong signs are corrected, also by adding short pulses.
//! 4. **The grid** ([`grid_step`], [`on_grid`], [`discretize`]). The discrete Lie–Verlet optimum,
//!    on steps that end where the inputs switch.
//!
//! The numbers that the theory does not determine are in [`tuning`].
//!
//! Singular arcs are common: where a principal axis of inertia is parallel to a torque axis they
//! are of second order, and inputs chatter at their ends. No finite switching structure is exact
//! then. Such a branch ends as arcs with a small gap, or as a smoothed extremal.
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
mod nearby;
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
