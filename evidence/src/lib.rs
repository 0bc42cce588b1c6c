//! The common code of tests, counts and benchmarks: reference files, random maneuvers, and laws
//! that relate the plans of different maneuvers.

#![forbid(unsafe_code)]

pub mod attitude_files;
pub mod combinations;
pub mod constrained;
pub mod damaged;
pub mod ends;
pub mod everyday;
pub mod families;
pub mod figures;
pub mod held;
pub mod hostile;
pub mod measured;
pub mod metamorphic;
pub mod motions;
pub mod process;
mod random;
pub mod random_specs;
mod references;
pub mod switching;
mod turning;
pub mod validation;
pub mod words;

pub use random::Random;
pub use references::{
    difference, largest, list, matrix, matrix3, median, number, numbers, reference, vector,
};
pub use turning::Turning;

/// The top folder of the repository.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
