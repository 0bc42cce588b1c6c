//! Minimum-fuel maneuvers of long duration with nonzero boundary rates, from their impulsive limit.
//!
//! As `T → ∞` burns become impulses, between which the body moves freely. Two impulses leave three
//! unknowns, the momentum of the coast, with which the free motion must reach the terminal
//! attitude. The longer the duration, the more such coasts exist, because the body may make any
//! number of turns in between. A smoothed law, whose inputs never rest, is near none of them.
//! Newton finds one coast from each of many initial momenta. The cheapest transfers are given burns
//! of the lengths that the limits require, all times are optimised for minimum fuel, and burns are
//! added where the certificate lacks them. The method is also used if a smoothed law has led to a
//! spin that burns far more than two impulses.

use super::arcs::Arcs;
use super::certificate::Certified;
use super::extremal::Extremal;
use super::flow::Node;
use super::limit::{BranchEnd, laid, refined};
use super::pulses::motion::Motion;
use super::pulses::schedule::{Pulse, PulseRequest, Schedule};
use super::smooth::{Path, Smoothed};
use super::tuning::impulses::*;
use super::tuning::limits::LAST;
use super::tuning::paths::LONG;
use super::tuning::pulses::{COARSE, MOST_COMBINED};
use super::tuning::{COARSER, FAR_ITERATIONS, FINE, NOTHING, SAME};
use super::work::{Work, count};
use crate::numerics::random::Stream;
use crate::{Matrix3, Vector3, lie};
use nalgebra::Vector6;
use std::f64::consts::{PI, TAU};

/// A transfer by two impulses, at the start and at the end. For each impulse it holds the inputs of
/// the extremal that are on, with their on-times.
pub(super) struct Transfer {
    momentum: Vector3,
    burns: [Vec<(usize, f64)>; 2],
    cost: f64,
}

impl Transfer {
    /// Returns the burns of the transfer as pulses.
    pub fn pulses(&self, duration: f64) -> Vec<Pulse> {
        let [first, last] = &self.burns;
        let begin = first.iter().map(|(level, length)| Pulse { level: *level, on: 0.0, off: *length });
        let end = last.iter();
        let end = end.map(|(level, length)| Pulse { level: *level, on: duration - length, off: duration });
        begin.chain(end).collect()
    }
}

/// Returns whether the body moves at an end and the given duration is long compared with the time
/// of a turn and of stopping the body.
fn is_long(extremal: &Extremal) -> bool {
    let moves = (extremal.j * extremal.start_rate).norm() + (extremal.j * extremal.end_rate).norm();
    let quick = 2.0 * lie::log(&extremal.end_attitude).norm().sqrt() + moves;
    extremal.given_duration.is_some_and(|given| moves > 0.0 && given > LONG * quick)
}

/// Returns whether impulses may lead to a cheaper plan than the best known one: if the body moves
/// and the duration is long, or if two impulses cost less than half of the best plan. About one
/// axis, burns of any length cost at most twice as much as impulses in the same duration. They do
/// so in the shortest duration, where they cost `2 √(J θ u)`.
pub(super) fn are_of_use(extremal: &Extremal, best: Option<&BranchEnd>, work: &Work) -> bool {
    let Some(duration) = extremal.given_duration.filter(|_| extremal.times_pulses()) else { return false };
    if is_long(extremal) {
        return true;
    }
    let costs = slow_turns(extremal, duration, work).map(|turn| turn.cost);
    let least = costs.fold(f64::INFINITY, f64::min);
    least.is_finite() && best.is_none_or(|best| best.cost(extremal) > 2.0 * least)
}

/// Finds extremals by starting from transfers by two impulses and adding further pulses.
pub(super) fn limits(extremal: &Extremal, work: &Work) -> Vec<BranchEnd> {
    let Some(duration) = extremal.given_duration.filter(|_| extremal.times_pulses()) else {
        return Vec::new();
    };
    let momenta = first_momenta(extremal, duration);
    let found = momenta.into_iter().take_while(|_| !work.stopped());
    let mut transfers: Vec<Transfer> =
        found.filter_map(|momentum| transfer(extremal, momentum, duration, work)).collect();
    transfers.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    transfers.dedup_by(|a, b| (a.momentum - b.momentum).norm() <= SAME.sqrt() * b.momentum.norm());
    let ask = PulseRequest::free(extremal);
    let burnt = |transfer: &Transfer| {
        let schedule = Schedule::kept(transfer.pulses(duration), duration, &ask)?;
        laid(extremal, &Motion::of(extremal, &schedule, &Vector6::zeros(), COARSE)?.arcs, work)
    };
    let mut burns: Vec<Certified> =
        transfers.iter().take(TRIED).take_while(|_| !work.stopped()).filter_map(burnt).collect();
    let cost = |burns: &Certified| burns.arcs.cost(extremal);
    burns.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    burns.dedup_by(|a, b| (cost(a) / cost(b) - 1.0).abs() < NOTHING);
    burns.truncate(MENDED);
    let limit = |burns: Certified| {
        let all = refined(extremal, burns, work);
        let smooth = Smoothed { path: path_of(extremal, &all.last()?.arcs)?, epsilon: LAST };
        Some(BranchEnd::of(&smooth, smooth.clone(), all, true))
    };
    burns.into_iter().take_while(|_| !work.stopped()).filter_map(limit).collect()
}

/// Returns the momenta of slow turns to the end, in both homotopy classes.
fn slow_momenta(extremal: &Extremal, duration: f64) -> [Vector3; 2] {
    let phi = lie::log(&extremal.end_attitude);
    let back = phi - TAU * phi.try_normalize(SAME).unwrap_or_else(Vector3::x);
    [phi, back].map(|turn| extremal.j * turn / duration)
}

/// Finds transfers by two impulses that turn the body slowly to the end, in both homotopy classes.
pub(super) fn slow_turns(extremal: &Extremal, duration: f64, work: &Work) -> impl Iterator<Item = Transfer> {
    let slow = slow_momenta(extremal, duration).into_iter();
    slow.filter_map(move |momentum| transfer(extremal, momentum, duration, work))
}

/// Returns the momenta from which coasts are searched for: those of slow turns in both homotopy
/// classes, that of the body at the start, and random momenta about this one and about zero.
fn first_momenta(extremal: &Extremal, duration: f64) -> Vec<Vector3> {
    let start = extremal.j * extremal.start_rate;
    let ends =
        [start.norm(), (extremal.j * extremal.end_rate).norm(), PI * extremal.j.trace() / (3.0 * duration)];
    let size = ends.into_iter().fold(0.0, f64::max);
    let mut random = Stream::new(0, 0, 0);
    let mut momenta = slow_momenta(extremal, duration).to_vec();
    momenta.push(start);
    for index in 0..RANDOM {
        let about = if index % 2 == 0 { start } else { Vector3::zeros() };
        momenta.push(about + size * Vector3::from_column_slice(&random.in_ball(3)));
    }
    momenta
}

/// Solves by Newton for the transfer whose coast has a momentum near `momentum`; `None` if Newton
/// does not converge.
fn transfer(extremal: &Extremal, mut momentum: Vector3, duration: f64, work: &Work) -> Option<Transfer> {
    count(&work.newtons);
    let coast = extremal.on_arc(&vec![-1.0; extremal.switching_count()]);
    // A step changes the terminal attitude by about a radian at most; farther away the
    // linearisation is not valid.
    let longest = extremal.j.trace() / (3.0 * duration);
    for _ in 0..FAR_ITERATIONS {
        let first = Node { r: Matrix3::identity(), pi: momentum, e: Vector3::zeros() };
        let end = extremal.flow_step(&Vector3::zeros(), &first, &coast, (duration, duration), COARSER * FINE);
        let miss = lie::log(&(end.f * extremal.end_attitude.transpose()));
        if miss.norm() < NOTHING {
            let start = momentum - extremal.j * extremal.start_rate;
            let stop = extremal.j * extremal.end_rate - end.pi;
            let burns = [cheapest(extremal, &start)?, cheapest(extremal, &stop)?];
            let price = |(level, length): &(usize, f64)| 2.0 * extremal.costs[*level] * length;
            let cost = burns.iter().flatten().map(price).sum();
            return Some(Transfer { momentum, burns, cost });
        }
        let slope = Matrix3::from_fn(|row, axis| end.jacobian[row][3 + axis]);
        let step = -slope.lu().solve(&miss)?;
        momentum += step * (longest / step.norm()).min(1.0);
    }
    None
}

/// Returns the inputs of the extremal that together produce the impulse `push` at minimum cost,
/// each with its on-time; `None` if no three inputs can produce it.
fn cheapest(extremal: &Extremal, push: &Vector3) -> Option<Vec<(usize, f64)>> {
    let axes = extremal.axes();
    let count = axes.len().min(MOST_COMBINED);
    let mut best: Option<(f64, Vec<(usize, f64)>)> = None;
    for a in 0..count {
        for b in 0..a {
            for c in 0..b {
                let matrix = 2.0 * Matrix3::from_columns(&[axes[a], axes[b], axes[c]]);
                let Some(shares) = matrix.lu().solve(push) else { continue };
                if !shares.iter().all(|share| *share > -1e-9 * shares.amax() && share.is_finite()) {
                    continue;
                }
                let levels = [a, b, c];
                let cost: f64 =
                    levels.iter().zip(&shares).map(|(level, share)| extremal.costs[*level] * share).sum();
                if best.as_ref().is_none_or(|(known, _)| cost < *known) {
                    let used = levels.into_iter().zip(shares.iter().copied());
                    let used = used.filter(|(_, share)| *share > 1e-6 * shares.amax()).collect();
                    best = Some((cost, used));
                }
            }
        }
    }
    best.map(|(_, used)| used)
}

/// Returns the path whose nodes are those at the switches of arcs.
fn path_of(extremal: &Extremal, arcs: &Arcs) -> Option<Path> {
    let (swept, _) = arcs.swept(extremal, FINE)?;
    let times = arcs.switches.iter().map(|switch| switch.time / arcs.duration);
    let parts = std::iter::once(0.0).chain(times).chain([1.0]).collect();
    Some(Path { m: arcs.m, duration: arcs.duration, nodes: swept.nodes, parts })
}

#[cfg(test)]
mod tests;
