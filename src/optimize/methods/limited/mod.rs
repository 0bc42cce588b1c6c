//! Minimum time and fuel that more than limits of the torques shapes: plans of arcs, whose ends are exact in continuous time.
//!
//! What shapes them is cones, limits of rates and of what wheels store, fields, frames that turn, forces, and limits of how fast inputs
//! change.
//!
//! On an arc each input is at a limit, or off where that is what fuel asks for, or it holds a constraint. Unknown are the lengths
//! of the arcs, and nothing else: the motion follows from them. Equations are the conditions of the end, six or with position twelve, and those of contact,
//! where an arc begins to hold a constraint or the motion touches one. Least is the duration, or the fuel. So
//!
//! ```text
//! minimise  J(ℓ)    where    g(ℓ) = 0 ,        ∇J + Gᵀλ = 0 ,   G = ∂g/∂ℓ
//! ```
//!
//! is a small problem of nonlinear programming ([`newton`]) over the flow of continuous time ([`motion`]), and its multipliers
//! are the costates at the end and their jumps at contacts. From these follow the switching functions along every arc
//! ([`certificate`]), whose signs tell whether the order of arcs is the right one, and what to exchange where it is not
//! ([`exchange`]). The first order of arcs is read off a plan of the convex chain on its equal steps ([`structure`]).
//!
//! # Why lengths of arcs, and not costates and switching times as without constraints?
//!
//! Because the costates of a constrained maneuver jump by amounts that are unknown too, and on an arc along a constraint they are not
//! unique. With lengths alone as unknowns none of that is to be guessed: every motion of a structure is feasible but for `g`, and
//! multipliers come out of least squares. The price is that an arc must have inputs that need no costate: a limit of the norm of the
//! torque, whose direction follows the costate, has no such arcs.
//!
//! # What of a first order that is far off?
//!
//! Newton knows of limits that arcs hold or touch, and of no others: from a first order that a coarse grid tells it goes where these are
//! exceeded, and arcs vanish on the way that the plan needs. Where it comes to nothing, linear programs ([`linear_programs`]) lead
//! there first: they look at all limits along all arcs, and an arc that their optimum leaves no length is none.
//!
//! # What of inputs that are at no limit?
//!
//! A singular input, and one that has more than it needs, as forces have where the turn takes longer, is within its limits in the plan
//! of the chain. Pulses stand for it first, and are exchanged until signs are right: along a singular arc they chatter, and the gap says
//! what they leave. Else it is loose: its means on parts of the duration are unknown as well, and the equations alone are solved.
//!
//! # What of inputs that change at limited rates?
//!
//! They are part of the state, and how fast they change is what is chosen ([`motion`]): their own limits are limits of the state then, of
//! first order, held along arcs as others are. Two things are theirs alone. What they begin with is free, and unknown beside the lengths.
//! And ramps of one length that begin together end together: two contacts that say the same, whose multipliers would not be unique. Arcs
//! of no length between what changes at once keep them apart, and where such an arc is to become shorter than nothing, the two change
//! places ([`newton`]). The first order is read off a plan by impulses ([`ramps`]).
//!
//! Hartl, Sethi and Vickson, *A survey of the maximum principles for optimal control problems with state constraints*, 1995;
//! Kaya and Noakes, *Computational method for time-optimal switching control*, 2003.

pub(crate) mod certificate;
pub(crate) mod constraint;
pub(crate) mod exchange;
mod linear_programs;
pub(crate) mod motion;
pub(crate) mod newton;
mod ramps;
pub(crate) mod state;
pub(crate) mod structure;
#[cfg(test)]
mod tests;
