//! Strategies of the fallback sequence, each a type in its own file, and their order.

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

/// All steps of the fallback sequence, for the tangent dimension `N` of a motion.
struct Steps<const N: usize>;

impl<const N: usize> Steps<N> {
    /// The steps in order. A guess, `Saturated` and `Shortest` work on the requested grid, the
    /// others first on a coarse one.
    const LADDER: [&'static dyn Climb<N>; 8] = [
        // guess
        &given::Given,
        // newton, descent and lifted
        &extremals::Extremals,
        // saturated, and interior_point if only shooting is requested
        &saturated::Saturated,
        // interior_point: for time, fuel and a free duration
        &interior::Interior,
        // interior_point, or scp and polish: for effort with a given duration
        &effort::Effort,
        // the previous strategies again, from a plan with a shorter duration
        &shortest::Shortest,
        // the plan of a guess in addition to all of these
        &given::Beside,
        // descent and lifted, from a saddle
        &further::Further,
    ];
}

/// Returns the fallback sequence of strategies.
pub const fn ladder<const N: usize>() -> Ladder<N> {
    &Steps::<N>::LADDER
}
