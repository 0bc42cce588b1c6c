//! Least fuel from rest to rest in a long duration, from a shorter one.
//!
//! As `T → ∞` the optimum becomes impulsive: it coasts nearly all of the time, at rates and with
//! pulses that fall as `1/T`, along one and the same path. A smoothed law, whose inputs never rest,
//! has nothing to do with that. So the maneuver is solved in a moderate duration, and its arcs are
//! followed from there as the duration grows: coasts are stretched, pulses shortened, Newton on
//! costates and switching times does the rest. Fuel never grows with the duration, since a slower
//! motion along the same path is always one: what grows has left its branch. Where a second has a
//! small price the duration grows as one over its square root, and the arcs are followed as the
//! price falls.

use super::arcs::Arcs;
use super::extremal::Extremal;
use super::limit::{BranchEnd, polish};
use super::smooth::Smoothed;
use super::tuning::paths::{LONG, QUICKER, STRETCH, STRETCHING};
use super::work::Work;
use crate::optimize::methods::continuation::{Step, follow};
use crate::{Vector3, lie};

/// The same maneuver in a moderate duration, where its own is long; or at a price of time that
/// makes it so.
pub(super) fn shorter(extremal: &Extremal) -> Option<Extremal> {
    let angle = lie::log(&extremal.end_attitude).norm();
    let rests = extremal.start_rate.norm() + extremal.end_rate.norm() == 0.0;
    if !(extremal.counts_fuel() && rests && angle > 0.0) {
        return None;
    }
    let quick = 2.0 * angle.sqrt();
    match extremal.given_duration {
        Some(given) => (given > LONG * quick).then(|| extremal.lasting(Some(LONG * quick))),
        // Two impulses about the axis cost `2 θ c/T`, and with `p T` the least at `T² = 2 θ c/p`.
        None => {
            let price = 2.0 * angle * extremal.price_of_impulse() / (LONG * quick).powi(2);
            (extremal.price_of_time() < price).then(|| extremal.priced(price))
        }
    }
}

/// The same maneuver in shorter durations, and what parts of its own they are, where fuel that
/// one-sided thrusters spend from rest to rest may be less along a plan of these, slowed down.
pub(super) fn quicker(extremal: &Extremal) -> impl Iterator<Item = (Extremal, f64)> {
    let rests = extremal.start_rate.norm() + extremal.end_rate.norm() == 0.0;
    let asked = extremal.counts_fuel() && rests && extremal.middle != Vector3::zeros();
    let given = extremal.given_duration.filter(|_| asked);
    given.into_iter().flat_map(|given| QUICKER.map(|part| (extremal.lasting(Some(part * given)), part)))
}

/// What a limit of the shorter maneuver becomes in the duration of `extremal`; `None` where it
/// cannot be followed so far.
pub(super) fn followed(extremal: &Extremal, limit: &BranchEnd, work: &Work) -> Option<BranchEnd> {
    let first = limit.arcs.clone()?;
    // By what factor the duration grows, or the square root of the price of time falls.
    let (least, total) = match extremal.given_duration {
        Some(given) => (f64::NAN, given / first.arcs.duration),
        None => {
            let least = extremal.price_of_time();
            (least, (shorter(extremal)?.price_of_time() / least).sqrt())
        }
    };
    let at_factor = |factor: f64| match extremal.given_duration {
        Some(given) => extremal.lasting(Some(given * (factor / total))),
        None => extremal.priced(least * (total / factor).powi(2)),
    };
    let arrived = |(_, factor): &(_, f64)| *factor >= total;
    let reached = follow(&STRETCHING, (first, 1.0), arrived, |(at, factor), length| {
        if work.stopped() {
            return Step::Stopped;
        }
        let next_factor = (factor * STRETCH.powf(length)).min(total);
        let (here, there) = (at_factor(*factor), at_factor(next_factor));
        let next = polish(&there, stretched(&at.arcs, extremal, next_factor / factor), work);
        let cheaper = next.filter(|next| next.arcs.cost(&there) <= at.arcs.cost(&here));
        cheaper.map(|next| (next, next_factor)).into()
    });
    let (arcs, _) = reached.ok()?;
    let whole = arcs.arcs.duration / limit.branch.path.duration;
    let slower = |smoothed: &Smoothed| Smoothed { path: smoothed.path.slower(whole), ..*smoothed };
    Some(BranchEnd::of(&slower(&limit.branch), slower(&limit.smooth), vec![arcs], true))
}

/// Arcs at rates that are smaller by a factor: burns are shorter by it, and coasts take what that
/// leaves.
fn stretched(arcs: &Arcs, extremal: &Extremal, factor: f64) -> Arcs {
    let burns =
        |signs: &[f64]| extremal.on_arc(signs).held().is_none() || signs.iter().any(|sign| *sign > 0.0);
    let lengths: Vec<(f64, bool)> =
        arcs.arcs().iter().map(|(_, start, end, signs)| (end - start, burns(signs))).collect();
    let burning: f64 = lengths.iter().filter(|(_, burns)| *burns).map(|(length, _)| length).sum();
    let coasts = (factor * arcs.duration - burning / factor) / (arcs.duration - burning);
    let mut next = arcs.clone();
    let mut time = 0.0;
    for (switch, (length, burns)) in next.switches.iter_mut().zip(&lengths) {
        time += length * if *burns { 1.0 / factor } else { coasts };
        switch.time = time;
        switch.node.pi /= factor;
    }
    next.m /= factor;
    next.duration *= factor;
    next
}
