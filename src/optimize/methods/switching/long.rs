//! Minimum-fuel rest-to-rest maneuvers of long duration, continued from a shorter one.
//!
//! As `T → ∞` the optimum becomes impulsive: it coasts for nearly all of the time, with rates and
//! pulse lengths that decrease as `1/T`, along one fixed path. A smoothed law, whose inputs never
//! rest, does not approximate it. The maneuver is therefore solved for a moderate duration, and its
//! arcs are followed as the duration grows: coasts are stretched and pulses shortened, and Newton
//! corrects costates and switching times. Fuel never grows with the duration, since a slower motion
//! along the same path is always feasible; a solution with more fuel has left the branch. If the
//! price of time is small, the duration grows as the inverse of its square root, and the arcs are
//! followed as the price decreases.

use super::arcs::Arcs;
use super::extremal::Extremal;
use super::limit::{BranchEnd, polish};
use super::smooth::Smoothed;
use super::tuning::paths::{LONG, QUICKER, STRETCH, STRETCHING};
use super::work::Work;
use crate::optimize::methods::continuation::{Step, follow};
use crate::{Vector3, lie};

/// Returns the maneuver with a moderate duration instead of its long one or, if the duration is
/// free, with a price of time that makes it moderate. Returns `None` if the duration is not long,
/// or the maneuver is not a minimum-fuel maneuver from rest to rest.
pub(super) fn shorter(extremal: &Extremal) -> Option<Extremal> {
    let angle = lie::log(&extremal.end_attitude).norm();
    let rests = extremal.start_rate.norm() + extremal.end_rate.norm() == 0.0;
    if !(extremal.counts_fuel() && rests && angle > 0.0) {
        return None;
    }
    let quick = 2.0 * angle.sqrt();
    match extremal.given_duration {
        Some(given) => (given > LONG * quick).then(|| extremal.lasting(Some(LONG * quick))),
        // Two impulses about the axis cost `2 θ c/T`; with `p T` added, the cost is minimal at
        // `T² = 2 θ c/p`.
        None => {
            let price = 2.0 * angle * extremal.price_of_impulse() / (LONG * quick).powi(2);
            (extremal.price_of_time() < price).then(|| extremal.priced(price))
        }
    }
}

/// Returns the maneuver with shorter durations, each with its fraction of the given duration, for
/// rest-to-rest maneuvers by one-sided thrusters; otherwise nothing. Their plans, slowed down, may
/// burn less fuel.
pub(super) fn quicker(extremal: &Extremal) -> impl Iterator<Item = (Extremal, f64)> {
    let rests = extremal.start_rate.norm() + extremal.end_rate.norm() == 0.0;
    let asked = extremal.counts_fuel() && rests && extremal.middle != Vector3::zeros();
    let given = extremal.given_duration.filter(|_| asked);
    given.into_iter().flat_map(|given| QUICKER.map(|part| (extremal.lasting(Some(part * given)), part)))
}

/// Follows a limit of the shorter maneuver to the duration of `extremal`; `None` if the
/// continuation fails before it reaches this duration.
pub(super) fn followed(extremal: &Extremal, limit: &BranchEnd, work: &Work) -> Option<BranchEnd> {
    let first = limit.arcs.clone()?;
    // Factor by which the duration grows, or by which the square root of the price of time
    // decreases.
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

/// Returns the arcs at rates smaller by a factor: burns are shorter by this factor, and coasts fill
/// the rest.
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
