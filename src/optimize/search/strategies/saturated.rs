//! Strategy for limited inputs: extremals of the saturated control law.
//!
//! The maneuver is first solved without limits. From each extremal found, the cheapest first,
//! Newton continues with the saturated law. If that fails, the interior-point method is next; if
//! only shooting is requested, Newton starts from the costates of the interior-point method.
//! Tighter limits increase the cost of an extremal: one that costs more without limits than the
//! best plan within them is skipped.

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Method;
use crate::maneuver::solution::Rung;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::asked::ranked;
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::{Ask, Climb, Search};
use crate::optimize::search::strategies::shots::shoot_fine;

/// Factor on the limits with which they are never active.
const LIMITLESS: f64 = 1e12;

/// An extremal without limits, and the limits that it would need.
struct Unlimited {
    found: Attempt,
    /// Factor by which the limits would have to be larger for the extremal to satisfy them.
    demand: f64,
}

/// Shoots with the saturated law from all extremals without limits.
pub struct Saturated;

impl<const N: usize> Climb<N> for Saturated {
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool {
        search.ask.shooting && !found.is_guessed() && search.fine.dynamics.is_limited()
    }

    fn climb(&self, search: &Search<N>, found: &mut Found<N>) {
        for Unlimited { found: wide, demand } in unlimited_extremals(search) {
            let beaten = found.plans().iter().any(|best| best.cost <= wide.cost);
            if search.stopped() || beaten {
                break;
            }
            if demand <= 1.0 && wide.converged() && wide.candidate.steps() == search.problem.steps {
                // No limit is active, so the extremal is also one of the limited maneuver.
                found.keep(wide);
            } else {
                shoot_fine(search, found, Rung::Saturated, wide.candidate);
            }
        }
        if search.context.settings.method == Method::Shooting && !found.is_done() {
            from_interior_point(search, found);
        }
    }
}

/// Shoots with the saturated law from the costates of the interior-point method.
fn from_interior_point<const N: usize>(search: &Search<N>, found: &mut Found<N>) {
    let ask = Ask { shooting: false, convex: true, ..search.ask.clone() };
    let mut within = search.of(search.problem, ask).climb();
    // The remaining violation of the interior-point method says more than the last iterate of
    // Newton's method.
    if let Some(missed) = within.take_missed() {
        found.tell_missed(Some(missed));
    }
    for plan in within.take_plans().into_iter().filter(|plan| plan.candidate.steps() == search.problem.steps)
    {
        if search.stopped() || shoot_fine(search, found, Rung::Saturated, plan.candidate).is_some() {
            return;
        }
    }
}

/// Returns the extremals without limits, the cheapest first.
fn unlimited_extremals<const N: usize>(search: &Search<N>) -> Vec<Unlimited> {
    let actuation = search.problem.actuation.without_limits();
    let free = Problem { actuation, ..search.problem.clone() };
    let ask = Ask { guess: None, convex: false, ..search.ask.clone() };
    let limitless = search.fine.relaxed(LIMITLESS);
    let search = search.of(&free, ask);
    let mut found = search.climb();
    let extremals = ranked(&search, found.take_plans());
    let demand =
        |found: &Attempt| limitless.demand(&found.candidate.costate()).map(|demand| LIMITLESS * demand);
    let unlimited = extremals.into_iter().chain(found.pool.rivals);
    unlimited.filter_map(|found| demand(&found).ok().map(|demand| Unlimited { found, demand })).collect()
}
