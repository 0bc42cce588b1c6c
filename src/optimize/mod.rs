//! The optimiser: the discrete step and its linearisation, the control law, the methods and the search.

pub(crate) mod candidate;
pub(crate) mod control_law;
mod convex;
mod landing;
pub mod linear_plan;
#[cfg(feature = "sdp")]
pub mod lower_bound;
pub mod memory;
pub(crate) mod methods;
pub mod search;
pub(crate) mod second_order;
pub mod step;
pub mod sweep;
pub(crate) mod terminal;

/// Why the shooting cannot take a problem; `None` where it can.
pub use control_law::{Obstacle, obstacle as shooting_obstacle};
