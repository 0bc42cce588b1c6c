//! The maneuver: what is asked, how to solve it, what came out, and what can be proved impossible.

pub mod constraint;
pub mod grid;
pub mod infeasible;
pub mod objective;
pub mod problem;
pub mod settings;
pub mod solution;
