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

/// Why the shooting cannot take a problem; `None` where it can.
pub use discrete::control_law::{Obstacle, obstacle as shooting_obstacle};

#[doc(hidden)]
pub use methods::interior_point::method::with_cold_solve;
