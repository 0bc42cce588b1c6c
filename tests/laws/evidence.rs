//! The part of the crate `evidence` that these tests use. Its sources are included: as a
//! dependency, `evidence` would delay the unit tests of the library, because it needs the finished
//! library.

#![allow(dead_code, reason = "the sources have more than these tests use")]

#[path = "../../evidence/src/random.rs"]
mod random;
#[path = "../../evidence/src/references.rs"]
mod references;
#[path = "../../evidence/src/turning.rs"]
mod turning;

pub use random::Random;
pub use references::{difference, largest, list, matrix, matrix3, number, numbers, reference, vector};
pub use turning::Turning;

/// The top folder of the repository.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");
