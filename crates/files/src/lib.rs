//! Files of [`slewkit`]: maneuver specs, plan files, trajectories in the formats of other programs,
//! and batches of maneuvers.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod batch;
mod cells;
pub mod epoch;
pub mod exchange;
pub mod export;
mod fingerprint;
pub mod flown;
pub mod formats;
pub mod identity;
pub mod pointing;
mod rounding;
pub mod scenery;
pub mod spec;
pub mod table;

/// The Parquet crate. Tests use it to read the files that [`exchange`] writes.
#[cfg(feature = "parquet")]
#[doc(hidden)]
pub use ::parquet;
