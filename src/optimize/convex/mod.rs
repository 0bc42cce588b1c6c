//! Convex programs: a checked interface to the cone solver, and what is built on it.

// Lower bounds need all of it, the rest of the crate less.
#![cfg_attr(not(feature = "sdp"), allow(dead_code))]

pub(crate) mod cone;
pub(crate) mod sparse;
