//! Least fuel in a long duration between rates, from its impulsive limit.
//!
//! As `T → ∞` burns become impulses, between which the body is free. Of two impulses three numbers are open, the momentum of the coast: with
//! it the free motion has to come to the attitude at the end. The longer the duration the more such coasts there are, as the body may turn
//! any number of times on the way; a smoothed law, whose inputs never rest, comes near none of them. Newton finds one from each of
//! many momenta. The cheapest are given burns as long as limits ask for, all times are laid out for the least fuel, and burns are
//! added where the certificate lacks them.

use super::arcs::{Arcs, over_arc};
use super::extremal::{ArcLaw, Extremal};
use super::flow::{Lanes, Node};
use super::fuel::{laid, mended};
use super::limit::Limit;
use super::pulses::motion::Motion;
use super::pulses::schedule::{Ask, Pulse, Schedule};
use super::pulses::search::cheapest;
use super::smooth::{Path, Smoothed};
use super::tuning::impulses::*;
use super::tuning::limits::LAST;
use super::tuning::paths::LONG;
use super::tuning::{COARSER, FAR_ITERATIONS, FINE, SAME};
use super::work::{Work, count};
use crate::numerics::random::Stream;
use crate::{Matrix3, Vector3, lie};
use std::f64::consts::PI;

/// Two impulses, at the start and at the end: the levels that are on for each, and for how long.
struct Transfer {
    momentum: Vector3,
    burns: [Vec<(usize, f64)>; 2],
    cost: f64,
}

/// The duration of a maneuver whose burns are impulses as good as: long beside the time that a turn takes and what moves takes to stop.
fn long_duration(extremal: &Extremal) -> Option<f64> {
    let moves = (extremal.j * extremal.start_rate).norm() + (extremal.j * extremal.end_rate).norm();
    let quick = 2.0 * lie::log(&extremal.end_attitude).norm().sqrt() + moves;
    extremal.given_duration.filter(|given| extremal.times_pulses() && moves > 0.0 && *given > LONG * quick)
}

/// What two impulses and those that are added to them come to, the cheapest first; none where the duration is not long or the body rests
/// at both ends.
pub(super) fn limits(extremal: &Extremal, work: &Work) -> Vec<Limit> {
    let Some(duration) = long_duration(extremal) else { return Vec::new() };
    let coast = extremal.on_arc(&vec![-1.0; extremal.switching_count()]);
    let momenta = first_momenta(extremal, duration);
    let found = momenta.into_iter().take_while(|_| !work.stopped());
    let mut transfers: Vec<Transfer> =
        found.filter_map(|momentum| transfer(extremal, &coast, momentum, duration, work)).collect();
    transfers.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    transfers.dedup_by(|a, b| (a.momentum - b.momentum).norm() <= SAME.sqrt() * b.momentum.norm());
    let ask = Ask::free(extremal);
    let burnt = |transfer: &Transfer| {
        let [first, last] = &transfer.burns;
        let begin = first.iter().map(|(level, length)| Pulse { level: *level, on: 0.0, off: *length });
        let end = last.iter();
        let end = end.map(|(level, length)| Pulse { level: *level, on: duration - length, off: duration });
        let schedule = Schedule::kept(begin.chain(end).collect(), duration, &ask)?;
        let arcs = Motion::of(extremal, &schedule, &[0.0; 6]).arcs();
        let mut looser = mended(extremal, laid(extremal, &arcs, work)?, work);
        let best = looser.pop()?;
        let smooth = Smoothed { path: path_of(extremal, &best.0), epsilon: LAST };
        Some(Limit { looser, ..Limit::of_arcs(&smooth, smooth.clone(), best) })
    };
    let mut limits: Vec<Limit> =
        transfers.iter().take(TRIED).take_while(|_| !work.stopped()).filter_map(burnt).collect();
    limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    limits
}

/// Momenta to begin with: of a slow turn either way round, of the motion at the start and, at random, about it and about none.
fn first_momenta(extremal: &Extremal, duration: f64) -> Vec<Vector3> {
    let phi = lie::log(&extremal.end_attitude);
    let back = phi - std::f64::consts::TAU * phi.try_normalize(SAME).unwrap_or_else(Vector3::x);
    let slow = |turn: Vector3| extremal.j * turn / duration;
    let start = extremal.j * extremal.start_rate;
    let ends = [start.norm(), (extremal.j * extremal.end_rate).norm(), PI * extremal.j.trace() / (3.0 * duration)];
    let size = SPREAD * ends.into_iter().fold(0.0, f64::max);
    let mut random = Stream::new(0, 0, 0);
    let mut momenta = vec![slow(phi), slow(back), start];
    for index in 0..RANDOM {
        let about = if index % 2 == 0 { start } else { Vector3::zeros() };
        momenta.push(about + size * Vector3::from_column_slice(&random.in_ball(3)));
    }
    momenta
}

/// The transfer to which Newton leads from a momentum.
fn transfer(
    extremal: &Extremal,
    coast: &ArcLaw,
    mut momentum: Vector3,
    duration: f64,
    work: &Work,
) -> Option<Transfer> {
    count(&work.newtons);
    // A step turns the end by about a radian at most: beyond that the coast says nothing of another.
    let longest = extremal.j.trace() / (3.0 * duration);
    for _ in 0..FAR_ITERATIONS {
        let mut lanes = Lanes::<6>::zero();
        for axis in 0..3 {
            lanes.0[3 + axis][3 + axis] = 1.0;
        }
        let first = Node { r: Matrix3::identity(), pi: momentum, e: Vector3::zeros() };
        let none = Vector3::zeros();
        let end =
            over_arc(extremal, &none, &first, coast, (duration, duration), COARSER * FINE, &mut lanes);
        let miss = lie::log(&(end.r * extremal.end_attitude.transpose()));
        if miss.norm() < NEAR {
            let start = momentum - extremal.j * extremal.start_rate;
            let stop = extremal.j * extremal.end_rate - end.pi;
            let burns = [cheapest(extremal, &start)?, cheapest(extremal, &stop)?];
            let price = |(level, length): &(usize, f64)| extremal.costs[*level] * length;
            let cost = burns.iter().flatten().map(price).sum();
            return Some(Transfer { momentum, burns, cost });
        }
        let slope = Matrix3::from_fn(|row, axis| lanes.0[row][3 + axis]);
        let step = -slope.lu().solve(&miss)?;
        momentum += step * (longest / step.norm()).min(1.0);
    }
    None
}

/// The nodes of arcs for a path.
fn path_of(extremal: &Extremal, arcs: &Arcs) -> Path {
    let all = arcs.arcs();
    let (mut nodes, mut parts): (Vec<Node>, Vec<f64>) =
        all.iter().map(|(node, start, ..)| (*node, start / arcs.duration)).unzip();
    if let Some((node, start, end, signs)) = all.last() {
        let (law, lengths) = (extremal.on_arc(signs), (end - start, arcs.duration));
        nodes.push(over_arc(extremal, &arcs.m, node, &law, lengths, FINE, &mut Lanes::<3>::zero()));
        parts.push(1.0);
    }
    Path { m: arcs.m, duration: arcs.duration, nodes, parts }
}
