//! The methods that improve a candidate, and what drives their iterations.

pub(crate) mod continuation;
pub(crate) mod descent;
pub(crate) mod driver;
pub(crate) mod lifted;
pub(crate) mod method;
pub(crate) mod scp;
pub(crate) mod shooting;
pub(crate) mod switching;
