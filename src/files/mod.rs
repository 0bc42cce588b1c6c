//! Files: specs, plans, trajectories, and those of other programs.

pub mod epoch;
pub mod exchange;
pub mod export;
pub mod formats;
pub mod identity;
pub mod spec;
