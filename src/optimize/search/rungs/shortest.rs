//! The rung of a plan in less time, where none was found in the time that is given.

use crate::optimize::search::cheapest;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};

/// SCP from the plan of the shortest duration that it finds.
pub(super) struct Shortest;

impl<const N: usize> Climb<N> for Shortest {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        search.ask.convex && cheapest::may_be_too_short(search, found)
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        cheapest::from_the_shortest(search, found);
    }
}
