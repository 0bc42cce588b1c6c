//! Strategy for given costates.

use crate::optimize::search::asked::goes_round_as_asked;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Climb, Search};
use crate::optimize::search::starts::GUESS;
use crate::optimize::search::strategies::shots::shoot_from;

/// Shoots by Newton from a costate guess, on the requested grid. The plan of a guess that is used
/// in addition to the search is put aside, so that the other strategies run as they do without a
/// guess.
pub struct Given;

impl<const N: usize> Climb<N> for Given {
    fn applies(&self, search: &Search<N>, _: &Found<N>) -> bool {
        search.ask.shooting
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        if let Some(guess) = search.ask.guess.filter(|guess| !guess.costates.is_empty()) {
            shoot_from(search, found, &guess.costates, GUESS);
            if guess.beside {
                found.aside = found.take_plans();
            }
        }
    }
}

/// Adds the plan of a guess, which was put aside, to the results of the search.
pub struct Beside;

impl<const N: usize> Climb<N> for Beside {
    fn applies(&self, _: &Search<N>, found: &Found<N>) -> bool {
        !found.aside.is_empty()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        for plan in std::mem::take(&mut found.aside) {
            let cost = plan.cost;
            // Plans on a uniform grid are sorted already, and the first of them is the best.
            let wins = goes_round_as_asked(search, &plan.candidate)
                && found.best().is_none_or(|best| cost < best.cost);
            found.keep(plan);
            if wins {
                found.reorder(|mut plans| {
                    let own = plans.iter().position(|plan| plan.cost == cost);
                    plans[..=own.unwrap_or(0)].rotate_right(1);
                    plans
                });
            }
        }
    }
}
