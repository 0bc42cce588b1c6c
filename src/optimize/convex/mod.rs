//! Convex programs: a checked interface to the cone solver, and its sparse matrices.

// The lower bounds (feature `sdp`) use all of this module, the rest of the crate only a part.
#![cfg_attr(not(feature = "sdp"), allow(dead_code))]

pub(crate) mod cone;
pub(crate) mod sparse;
