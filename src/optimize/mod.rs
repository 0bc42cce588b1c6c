//! The optimiser: the discrete problem, the methods that improve a candidate of it, and the search.

mod chain;
mod convex;
pub mod discrete;
mod landing;
#[cfg(feature = "sdp")]
pub mod lower_bound;
pub(crate) mod methods;
mod nlp;
pub mod search;

/// Returns why the shooting method cannot solve a problem; `None` if it can.
pub use discrete::control_law::{Obstacle, obstacle as shooting_obstacle};

#[doc(hidden)]
pub use methods::interior_point::method::with_cold_solve;
