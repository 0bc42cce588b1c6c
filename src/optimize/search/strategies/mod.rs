//! The rungs of the ladder, each a type in a file of its own, and their order.

pub mod advice;
mod authority;
pub mod chains;
mod descents;
mod effort;
mod extremals;
mod further;
mod given;
mod interior;
mod minima;
mod requested;
mod saturated;
pub mod seeds;
mod shortest;
pub mod shots;

use crate::optimize::search::ladder::{Climb, Ladder};

/// All steps of the ladder, for the tangent dimension of a motion.
struct Steps<const N: usize>;

impl<const N: usize> Steps<N> {
    /// A guess, `Saturated` and `Shortest` work on the requested grid, the others on a coarse one
    /// first.
    const LADDER: [&'static dyn Climb<N>; 8] = [
        // guess
        &given::Given,
        // newton, descent and lifted
        &extremals::Extremals,
        // saturated, and interior_point where only the shooting is asked for
        &saturated::Saturated,
        // interior_point: of time, fuel and a duration that is sought
        &interior::Interior,
        // interior_point, or scp and polish: of effort in a given duration
        &effort::Effort,
        // the same from a plan in less time
        &shortest::Shortest,
        // the plan of a guess beside all of these
        &given::Beside,
        // descent and lifted, from a saddle
        &further::Further,
    ];
}

/// The ladder.
pub const fn ladder<const N: usize>() -> Ladder<N> {
    &Steps::<N>::LADDER
}
