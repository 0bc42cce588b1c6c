//! Files: specs, plans, trajectories.

pub mod export;
pub mod spec;
