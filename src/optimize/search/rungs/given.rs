//! The rung of costates that are given.

use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::shots::shoot_from;
use crate::optimize::search::starts::GUESS;

/// Newton from a costate guess, on the requested grid.
pub(super) struct Given;

impl<const N: usize> Climb<N> for Given {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.shooting
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        if let Some(guess) = search.ask.guess.filter(|guess| !guess.costates.is_empty()) {
            shoot_from(search, found, &guess.costates, GUESS);
        }
    }
}
