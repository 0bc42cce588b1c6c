//! Least fuel from rest to rest in a long duration, from a shorter one.
//!
//! As `T → ∞` the optimum becomes impulsive: it coasts nearly all of the time, at rates and with pulses that fall as `1/T`, along
//! one and the same path. A smoothed law, whose inputs never rest, has nothing to do with that. So the maneuver is solved in a
//! moderate duration, and its arcs are followed from there as the duration grows: coasts are stretched, pulses shortened, Newton on
//! costates and switching times does the rest. Fuel never grows with the duration, since a slower motion along the same path is
//! always one: what grows has left its branch.

use super::arcs::Arcs;
use super::certificate::Certificate;
use super::extremal::Extremal;
use super::limit::{Found, Limit, polish};
use super::smooth::Smoothed;
use super::tuning::paths::{LONG, STRETCH_OF_ARCS, STRETCHING};
use crate::lie;
use crate::optimize::methods::continuation::{Step, follow};

/// The same maneuver in a moderate duration, where its own is long.
pub(super) fn shorter(extremal: &Extremal) -> Option<Extremal> {
    let given = extremal.given_duration.filter(|_| extremal.counts_fuel())?;
    let angle = lie::log(&extremal.end_attitude).norm();
    let moderate = LONG * 2.0 * angle.sqrt();
    let rests = extremal.start_rate.norm() + extremal.end_rate.norm() == 0.0;
    (rests && angle > 0.0 && given > moderate).then(|| extremal.lasting(Some(moderate)))
}

/// What a limit of the shorter maneuver becomes in the duration of `extremal`; `None` where it cannot be followed so far.
pub(super) fn followed(
    extremal: &Extremal,
    limit: &Limit,
    stop: &dyn Fn() -> bool,
    found: &mut Found,
) -> Option<Limit> {
    let given = extremal.given_duration?;
    let arrived = |(at, _): &(Arcs, Certificate)| at.duration >= given;
    let reached = follow(&STRETCHING, limit.arcs.clone()?, arrived, |(at, _), length| {
        if stop() {
            return Step::Stopped;
        }
        let duration = (STRETCH_OF_ARCS.powf(length) * at.duration).min(given);
        let there = extremal.lasting(Some(duration));
        let next = polish(&there, stretched(at, extremal, duration / at.duration), found);
        next.filter(|(next, _)| next.cost(&there) <= at.cost(extremal)).into()
    });
    let arcs = reached.ok()?;
    let whole = arcs.0.duration / limit.branch.path.duration;
    let slower = |smoothed: &Smoothed| Smoothed { path: smoothed.path.slower(whole), ..*smoothed };
    Some(Limit {
        branch: slower(&limit.branch),
        smooth: slower(&limit.smooth),
        arcs: Some(arcs),
        looser: Vec::new(),
    })
}

/// Arcs at rates that are smaller by a factor: burns are shorter by it, and coasts take what that leaves.
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
