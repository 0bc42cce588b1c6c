//! Search for extremals: each branch whose cost is near the best one is continued to its limit as ε
//! → 0, and the limits are sorted by cost.

use super::arcs::Arcs;
use super::branches::{Branches, SearchRequest, branches};
use super::certificate::Certified;
use super::eigenaxis;
use super::extremal::{Bias, Extremal, TorqueLimit};
use super::fuel::fuel_limit;
use super::impulses;
use super::limit::{BranchEnd, BranchEnds, bounded, is_limit, polish, refined, tipped};
use super::long;
use super::moved::is_saddle;
use super::nearby;
use super::smooth::{Smooth, Smoothed, descend, settle};
use super::tuning::limits::*;
use super::tuning::smooth::ENOUGH;
use super::tuning::{MET, NEAR_ITERATIONS, NOTHING, SAME, SMALLER};
use super::work::Work;
use crate::Vector3;
use crate::maneuver::problem::Path as Way;
use crate::maneuver::settings::Thoroughness;

/// Searches for the best extremals; a stopped search returns those found so far. If the body turns
/// about a fixed axis along the best extremal, which is usually a saddle then, the extremals of
/// nearby maneuvers are tried. The search is repeated as a thorough one if the best extremal is a
/// saddle, if it is no quicker than the turn about the fixed axis, or if no nearby maneuver leads to
/// a quicker one. A small maneuver would gain nothing from that.
pub(crate) fn search(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> BranchEnds {
    let mut found = search_once(extremal, ask, work);
    if ask.thoroughness != Thoroughness::Default || work.stopped() {
        return found;
    }
    let seeks_best_time = ask.path == Way::Best && extremal.seeks_time();
    if seeks_best_time {
        found.eigenaxis = eigenaxis::duration(extremal);
    }
    let Some(best) = found.limits.first() else { return found };
    let cost = best.cost(extremal);
    let slow = found.eigenaxis.is_some_and(|turn| best.duration() >= turn * (1.0 - NOTHING));
    let exact = best.arcs.as_ref().filter(|found| found.is_exact(extremal));
    let saddle = exact.is_some_and(|found| is_saddle(extremal, &found.arcs));
    let about_an_axis = seeks_best_time && nearby::turns_about_an_axis(extremal, best);
    if about_an_axis {
        let search = |extremal: &Extremal, ask: &SearchRequest| search_once(extremal, ask, work);
        let limits = nearby::limits(extremal, ask, search, work);
        found.extend(extremal, limits);
    }
    let gains = found.limits[0].cost(extremal) < cost * (1.0 - NOTHING);
    if !(slow || saddle || about_an_axis && !gains) || about_an_axis && nearby::is_small(extremal) {
        return found;
    }
    let mut more =
        search_once(extremal, &SearchRequest { thoroughness: Thoroughness::Thorough, ..*ask }, work);
    more.extend(extremal, found.limits);
    more.limits.dedup_by(|a, b| (a.cost(extremal) - b.cost(extremal)).abs() <= SAME * b.cost(extremal));
    BranchEnds { eigenaxis: found.eigenaxis, ..more }
}

fn search_once(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> BranchEnds {
    let mut found = search_here(extremal, ask, work);
    if ask.arcs && ask.thoroughness != Thoroughness::Quick {
        add_slowed(extremal, ask, &mut found, work);
    }
    found
}

/// Adds plans of shorter durations that are slowed down to the duration of `extremal`, if they are
/// cheaper than the plans found so far. They are needed because the initial paths of unequal
/// thrusters may fail for a long duration.
fn add_slowed(extremal: &Extremal, ask: &SearchRequest, found: &mut BranchEnds, work: &Work) {
    for (quicker, part) in long::quicker(extremal).take_while(|_| !work.stopped()) {
        let best = found.limits.first().map_or(f64::INFINITY, |best| best.cost(extremal));
        let of_quicker = search_here(&quicker, ask, work);
        found.branches += of_quicker.branches;
        // A motion that is slower by a factor needs inputs that are smaller by the square of this
        // factor.
        let cheaper = |limit: &&BranchEnd| limit.cost(&quicker) * part < best * (1.0 - NOTHING);
        let slowed = of_quicker.limits.iter().filter(cheaper);
        found.extend(extremal, slowed.filter_map(|limit| long::followed(extremal, limit, work)));
    }
}

/// Searches the given maneuver, without `add_slowed`. For a long duration, plans of a moderate one
/// are followed first.
fn search_here(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> BranchEnds {
    let mut found = BranchEnds::default();
    if let Some(shorter) = long::shorter(extremal).filter(|_| ask.arcs) {
        let of_shorter = search_once(&shorter, ask, work);
        found.branches = of_shorter.branches;
        let limits = of_shorter.limits.iter().filter_map(|limit| {
            let mut limit = long::followed(extremal, limit, work)?;
            if let Some(arcs) = limit.arcs.take_if(|arcs| !arcs.is_small(extremal)) {
                limit.looser = refined(extremal, arcs, work);
                limit.arcs = limit.looser.pop();
            }
            Some(limit)
        });
        found.extend(extremal, limits);
        // From rest to rest, one path is optimal for all long durations, and smoothed extremals are
        // not needed.
        if !found.limits.is_empty() {
            return found;
        }
    }
    let Branches { found: rivals, one_way } = branches(extremal, ask, work);
    found.branches += rivals.len() + one_way.len();
    let costs = rivals.iter().chain(&one_way).map(|rival| rival.cost(extremal));
    let best = costs.fold(f64::INFINITY, f64::min);
    let one_sided = extremal.middle != Vector3::zeros();
    let dearest = best * if extremal.counts_fuel() || one_sided { FAR_RIVAL } else { RIVAL };
    let near = |rival: &&Smoothed| rival.cost(extremal) <= dearest;
    // Only exact arcs of the time-reversed maneuver can be converted to arcs of this one.
    let mut limits = Vec::new();
    for rival in one_way.iter().filter(near).take_while(|_| !work.stopped()) {
        let limit = end_game(&extremal.reversed(), rival, ask, work);
        limits.extend(limit.reversed(extremal, work));
    }
    for rival in rivals.iter().filter(near).take_while(|_| !work.stopped()) {
        limits.push(end_game(extremal, rival, ask, work));
    }
    found.extend(extremal, limits);
    if ask.arcs && impulses::are_of_use(extremal, found.limits.first(), work) {
        found.extend(extremal, impulses::limits(extremal, work));
        found.branches = found.branches.max(found.limits.len());
    }
    found
}

/// Continues a branch to its limit as ε → 0: bang-bang arcs, extracted at the ε of `rival` or at a
/// smaller ε, or a smoothed extremal.
fn end_game(extremal: &Extremal, rival: &Smoothed, ask: &SearchRequest, work: &Work) -> BranchEnd {
    let mut at = rival.clone();
    let fuel = extremal.counts_fuel();
    // Newton may converge to arcs of a costlier branch; they are kept if no others are found.
    let (mut best, mut of_another): (Option<Certified>, Option<Certified>) = (None, None);
    let attempts = match &extremal.law {
        _ if !ask.arcs => 0,
        _ if fuel => MOST_DESCENTS_FUEL,
        TorqueLimit::Norm(_) => 0,
        TorqueLimit::Inputs(_) => MOST_DESCENTS,
    };
    for _ in 0..attempts {
        if work.stopped() {
            break;
        }
        // Arcs are extracted by zero crossings of the switching functions. For minimum fuel, pulses
        // are also extracted by area: some switching functions only graze zero, while other pulses
        // are separated by very short pauses.
        for by_pulses in if fuel { &[true, false][..] } else { &[false] } {
            let (path, epsilon) = (&at.path, at.epsilon);
            let first = if *by_pulses {
                Arcs::of_pulses(extremal, path, epsilon, 1)
            } else {
                Arcs::of_path(extremal, path)
            };
            let Some(found) = polish(extremal, first, work) else { continue };
            let exact = found.is_exact(extremal);
            if exact && is_limit(extremal, &found.arcs, &at) {
                return BranchEnd::of(rival, at, vec![found], true);
            }
            if exact && !fuel {
                of_another.get_or_insert(found);
            } else if best.as_ref().is_none_or(|known| found.gap < known.gap) {
                best = Some(found);
            }
        }
        let next = descend(extremal, &at, SMALLER * at.epsilon, &Bias::default(), work);
        let failed = next.is_err();
        at = next.unwrap_or_else(|last| last);
        if failed {
            break;
        }
    }
    if fuel {
        return fuel_limit(extremal, rival, at, best, ask, work);
    }
    let mut all = Vec::from_iter(of_another);
    if let Some(best) = best {
        let small = best.is_small(extremal);
        all.extend(if small { vec![best] } else { refined(extremal, best, work) });
    }
    all.retain(|found| bounded(extremal, &found.arcs, &at));
    if all.last().is_some_and(|best| best.is_small(extremal) && is_limit(extremal, &best.arcs, &at)) {
        return BranchEnd::of(rival, at, all, true);
    }
    let smooth = match descend(extremal, &at, LAST, &Bias::default(), work) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, work).unwrap_or(end),
    };
    let smooth = match &extremal.law {
        TorqueLimit::Norm(_) => turning(extremal, smooth, work),
        TorqueLimit::Inputs(_) => settle(extremal, smooth, SMALLEST, work),
    };
    // Short arcs appear only at small ε.
    let late =
        (attempts > 0).then(|| polish(extremal, Arcs::of_path(extremal, &smooth.path), work)).flatten();
    let late = late.filter(|late| late.is_exact(extremal) && is_limit(extremal, &late.arcs, &smooth));
    let taken = late.is_some();
    all.extend(late);
    BranchEnd::of(rival, smooth, all, taken)
}

/// Solves for the extremal without smoothing, for a limit on the norm of the torque: its control
/// law is smooth as long as the costate does not vanish. Returns `from` if Newton does not
/// converge.
fn turning(extremal: &Extremal, from: Smoothed, work: &Work) -> Smoothed {
    let exact = Smooth::of(extremal, 0.0);
    let mut path = from.path.clone();
    while path.intervals() < ENOUGH {
        path = exact.doubled(&path);
    }
    let found = exact.solve(path, MET, NEAR_ITERATIONS, work);
    found.map_or(from, |path| Smoothed { path, epsilon: 0.0 })
}
