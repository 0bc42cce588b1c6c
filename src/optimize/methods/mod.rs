//! The methods that improve a candidate.

pub(crate) mod lifted;
pub(crate) mod scp;
pub(crate) mod shooting;
