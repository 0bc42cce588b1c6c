//! Convex programs: a checked interface to the cone solver, and what is built on it.

// Whole interface of a layer that its users come to need one after the other.
#![allow(dead_code)]

pub(crate) mod cone;
pub(crate) mod sparse;
