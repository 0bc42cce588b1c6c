//! From branches to the answer: each rival branch is brought to its limit, and the shortest is taken.

use super::arcs::Arcs;
use super::branches::{Ask, Branches, branches};
use super::certificate::Certificate;
use super::eigenaxis;
use super::extremal::{Bias, Extremal, Law};
use super::fuel::{fuel_limit, mended};
use super::grid_step::Torque;
use super::impulses;
use super::limit::{Found, Limit, bounded, is_limit, is_small, polish, refined, tipped};
use super::long;
use super::moved::is_saddle;
use super::on_grid::OnGrid;
use super::sequence::{Over, Step};
use super::smooth::{Path, Smooth, Smoothed, descend, settle};
use super::tuning::limits::*;
use super::tuning::smooth::{ENOUGH, MOST_TRIALS};
use super::tuning::{FINE, GAINED, MET, NEAR_ITERATIONS, SAME, SMALLER};
use super::work::Work;
use crate::Vector3;
use crate::maneuver::problem::Path as Way;
use crate::maneuver::settings::Thoroughness;

/// Searches the best extremals; what is found before `stop` says so is kept. Where the best is a saddle, or no quicker than the turn
/// about a fixed axis, which is one as a rule, the search becomes a thorough one.
pub(crate) fn search(extremal: &Extremal, ask: &Ask, stop: &dyn Fn() -> bool) -> Found {
    let work = Work::until(stop);
    let found = search_all(extremal, ask, &work);
    Found { sweeps: work.sweeps.get(), newtons: work.newtons.get(), ..found }
}

/// The same, what it took aside.
fn search_all(extremal: &Extremal, ask: &Ask, work: &Work) -> Found {
    let mut found = search_once(extremal, ask, work);
    if ask.thoroughness != Thoroughness::Default || work.stopped() {
        return found;
    }
    if ask.path == Way::Best && extremal.seeks_time() {
        found.eigenaxis = eigenaxis::duration(extremal);
    }
    let slow = |best: &Limit| found.eigenaxis.is_some_and(|turn| best.duration() >= turn * (1.0 - GAINED));
    let saddle = |best: &Limit| {
        let arcs = best.arcs.as_ref().filter(|_| best.is_exact(extremal));
        arcs.is_some_and(|(arcs, _)| is_saddle(extremal, arcs))
    };
    if !found.limits.first().is_some_and(|best| slow(best) || saddle(best)) {
        return found;
    }
    let mut more = search_once(extremal, &Ask { thoroughness: Thoroughness::Thorough, ..*ask }, work);
    more.limits.extend(found.limits);
    more.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    more.limits.dedup_by(|a, b| (a.cost(extremal) - b.cost(extremal)).abs() <= SAME * b.cost(extremal));
    Found { eigenaxis: found.eigenaxis, ..more }
}

fn search_once(extremal: &Extremal, ask: &Ask, work: &Work) -> Found {
    let mut found = search_here(extremal, ask, work);
    if ask.arcs && ask.thoroughness != Thoroughness::Quick {
        add_slowed(extremal, ask, &mut found, work);
    }
    found
}

/// Adds what plans of shorter durations become in that of `extremal` where they are cheaper, slowed down, than what is known: first paths
/// of thrusters that push unequally may lead nowhere in a long duration.
fn add_slowed(extremal: &Extremal, ask: &Ask, found: &mut Found, work: &Work) {
    for (quicker, part) in long::quicker(extremal).take_while(|_| !work.stopped()) {
        let best = found.limits.first().map_or(f64::INFINITY, |best| best.cost(extremal));
        let of_quicker = search_here(&quicker, ask, work);
        found.branches += of_quicker.branches;
        // A motion that is slower by a factor takes inputs that are smaller by its square.
        let cheaper = |limit: &&Limit| limit.cost(&quicker) * part < best * (1.0 - GAINED);
        let slowed = of_quicker.limits.iter().filter(cheaper);
        found.limits.extend(slowed.filter_map(|limit| long::followed(extremal, limit, work)));
        found.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    }
}

/// The same without plans of shorter durations beside that of a long one.
fn search_here(extremal: &Extremal, ask: &Ask, work: &Work) -> Found {
    let mut found = Found::default();
    if let Some(shorter) = long::shorter(extremal).filter(|_| ask.arcs) {
        let of_shorter = search_once(&shorter, ask, work);
        found = Found { limits: Vec::new(), ..of_shorter };
        let limits = of_shorter.limits.iter();
        found.limits = limits.filter_map(|limit| long::followed(extremal, limit, work)).collect();
        for limit in &mut found.limits {
            let arcs = limit.arcs.take_if(|arcs| !is_small(extremal, arcs));
            if let Some(arcs) = arcs {
                limit.looser = mended(extremal, arcs, work);
                limit.arcs = limit.looser.pop();
            }
        }
        found.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
        // From rest to rest one path is the best in all long durations, and what is smoothed there of no use.
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
    // Their arcs are exact, and turned round as such.
    for rival in one_way.iter().filter(near).take_while(|_| !work.stopped()) {
        let limit = end_game(&extremal.reversed(), rival, ask, work);
        found.limits.extend(limit.reversed(extremal, work));
    }
    for rival in rivals.iter().filter(near) {
        if work.stopped() {
            break;
        }
        let limit = end_game(extremal, rival, ask, work);
        found.limits.push(limit);
        // Branches may part below the ε at which they were compared.
        if ask.thoroughness != Thoroughness::Quick
            && rests_on_a_symmetry(extremal, rival)
            && let Some(tipped) = tipped(extremal, rival, work)
        {
            let limit = end_game(extremal, &tipped, ask, work);
            found.limits.push(limit);
        }
    }
    found.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    if ask.arcs && impulses::are_of_use(extremal, found.limits.first(), work) {
        found.limits.extend(impulses::limits(extremal, work));
        found.branches = found.branches.max(found.limits.len());
        found.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    }
    found
}

/// Whether a branch of minimum time has inputs that a symmetry alone keeps out of use: as a rule it is a saddle.
fn rests_on_a_symmetry(extremal: &Extremal, branch: &Smoothed) -> bool {
    let size = |input: usize| {
        let nodes = branch.path.nodes.iter();
        nodes.map(|node| extremal.switching(input, &node.e).abs()).fold(0.0, f64::max)
    };
    let sizes: Vec<f64> = (0..extremal.axes().len()).map(size).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    extremal.seeks_time() && sizes.iter().any(|size| *size <= UNUSED * largest)
}

/// A branch to its limit: as arcs, at once or from a smaller ε, or as a smoothed extremal.
fn end_game(extremal: &Extremal, rival: &Smoothed, ask: &Ask, work: &Work) -> Limit {
    let mut at = rival.clone();
    let mut best: Option<(Arcs, Certificate)> = None;
    // Newton may go to arcs of a dearer branch; they are better than none.
    let mut of_another: Option<(Arcs, Certificate)> = None;
    let attempts = match &extremal.law {
        _ if !ask.arcs => 0,
        _ if extremal.counts_fuel() => MOST_DESCENTS_FUEL,
        Law::Norm(_) => 0,
        Law::Inputs(_) => MOST_DESCENTS,
    };
    for _ in 0..attempts {
        if work.stopped() {
            break;
        }
        for first in readings(extremal) {
            let Some((arcs, certificate)) = polish(extremal, first(extremal, &at), work) else { continue };
            if certificate.gap <= NO_GAP * arcs.cost(extremal) {
                if is_limit(extremal, &arcs, &at) {
                    return Limit::of_arcs(rival, at, (arcs, certificate));
                }
                if !extremal.counts_fuel() {
                    of_another.get_or_insert((arcs, certificate));
                    continue;
                }
            }
            if best.as_ref().is_none_or(|(_, known)| certificate.gap < known.gap) {
                best = Some((arcs, certificate));
            }
        }
        match descend(extremal, &at, SMALLER * at.epsilon, &Bias::default(), work) {
            Ok(next) => at = next,
            Err(next) => {
                at = next;
                break;
            }
        }
    }
    if extremal.counts_fuel() {
        return fuel_limit(extremal, rival, at, best, ask, work);
    }
    let mut looser = Vec::from_iter(of_another.filter(|(arcs, _)| bounded(extremal, arcs, &at)));
    if let Some(best) = best {
        let refined = if is_small(extremal, &best) { vec![best] } else { refined(extremal, best, work) };
        looser.extend(refined.into_iter().filter(|(arcs, _)| bounded(extremal, arcs, &at)));
    }
    if let Some(arcs) = looser.pop_if(|best| is_small(extremal, best) && is_limit(extremal, &best.0, &at)) {
        return Limit { looser, ..Limit::of_arcs(rival, at, arcs) };
    }
    let smooth = match descend(extremal, &at, LAST, &Bias::default(), work) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, work).unwrap_or(end),
    };
    let smooth = match &extremal.law {
        Law::Norm(_) => turning(extremal, smooth),
        Law::Inputs(_) => settle(extremal, smooth, SMALLEST, work),
    };
    // Short arcs show late.
    let late =
        if attempts > 0 { polish(extremal, Arcs::of_path(extremal, &smooth.path), work) } else { None };
    let ends_it = |(arcs, certificate): &(Arcs, Certificate)| {
        certificate.gap <= NO_GAP * arcs.cost(extremal) && is_limit(extremal, arcs, &smooth)
    };
    if let Some(late) = late.filter(ends_it) {
        return Limit { looser, ..Limit::of_arcs(rival, smooth, late) };
    }
    Limit { branch: rival.clone(), smooth, arcs: None, looser }
}

/// Under a limit of the norm the law is smooth where the costate does not vanish: the extremal without smoothing, where
/// Newton finds it.
fn turning(extremal: &Extremal, from: Smoothed) -> Smoothed {
    let exact = Smooth::of(extremal, 0.0);
    let mut path = from.path.clone();
    while path.intervals() < ENOUGH {
        path = exact.doubled(&path);
    }
    let torque = Torque::Arc(extremal.on_arc(&[]));
    let step = |ends: &[f64]| Step { arc: 0, part: ends[1] - ends[0], torque };
    let steps = path.parts.windows(2).map(step).collect();
    let flow = OnGrid::new(path.m, vec![path.duration], steps, Vec::new(), path.nodes);
    let flow = OnGrid { over: Over::Flow { longest: FINE }, ..flow };
    match flow.newton(MOST_TRIALS, MET, NEAR_ITERATIONS, extremal) {
        Some(found) => {
            let (m, duration, parts) = (found.m, found.duration(), path.parts);
            Smoothed { path: Path { m, duration, nodes: found.nodes, parts }, epsilon: 0.0 }
        }
        None => from,
    }
}

/// How arcs are read from a smoothed path.
type Reading = fn(&Extremal, &Smoothed) -> Arcs;

/// By the crossings of the switching functions; where fuel counts by pulses too, of which some only graze zero, while
/// others have hardly a gap between them.
fn readings(extremal: &Extremal) -> &'static [Reading] {
    const CROSSINGS: Reading = |extremal, from| Arcs::of_path(extremal, &from.path);
    const PULSES: Reading = |extremal, from| Arcs::of_pulses(extremal, &from.path, from.epsilon, 1);
    match extremal.law {
        Law::Norm(_) => &[CROSSINGS, PULSES],
        Law::Inputs(_) if extremal.counts_fuel() => &[PULSES, CROSSINGS],
        Law::Inputs(_) => &[CROSSINGS],
    }
}
