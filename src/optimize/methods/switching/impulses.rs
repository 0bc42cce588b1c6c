//! Least fuel in a long duration between rates, from its impulsive limit.
//!
//! As `T → ∞` burns become impulses, between which the body is free. Of two impulses three numbers are open, the momentum of the coast: with
//! it the free motion has to come to the attitude at the end. The longer the duration the more such coasts there are, as the body may turn
//! any number of times on the way; a smoothed law, whose inputs never rest, comes near none of them. Newton finds one from each of
//! many momenta. The cheapest are given burns as long as limits ask for, all times are laid out for the least fuel, and burns are
//! added where the certificate lacks them. It is asked too where a smoothed law has led to a spin that burns far more than two impulses.

use super::arcs::Arcs;
use super::certificate::Certificate;
use super::extremal::Extremal;
use super::flow::Node;
use super::fuel::{laid, mended};
use super::limit::Limit;
use super::pulses::motion::Motion;
use super::pulses::schedule::{Ask, Pulse, Schedule};
use super::pulses::search::cheapest;
use super::smooth::{Path, Smoothed};
use super::tuning::impulses::*;
use super::tuning::limits::LAST;
use super::tuning::paths::LONG;
use super::tuning::{COARSER, FAR_ITERATIONS, FINE, GAINED, SAME};
use super::work::{Work, count};
use crate::numerics::random::Stream;
use crate::{Matrix3, Vector3, lie};
use std::f64::consts::{PI, TAU};

/// Two impulses, at the start and at the end: the levels that are on for each, and for how long.
struct Transfer {
    momentum: Vector3,
    burns: [Vec<(usize, f64)>; 2],
    cost: f64,
}

/// Whether the body moves at an end and has a duration that is long beside the time that a turn takes and what moves takes to stop.
fn is_long(extremal: &Extremal) -> bool {
    let moves = (extremal.j * extremal.start_rate).norm() + (extremal.j * extremal.end_rate).norm();
    let quick = 2.0 * lie::log(&extremal.end_attitude).norm().sqrt() + moves;
    extremal.given_duration.is_some_and(|given| moves > 0.0 && given > LONG * quick)
}

/// Whether impulses may lead to what is cheaper than the best that is known: where the body moves for long, or where two of them cost
/// less than half of it. About one axis burns of any length cost at most twice as much as impulses in the same duration,
/// `2 √(J θ u)` in the shortest one.
pub(super) fn are_of_use(extremal: &Extremal, best: Option<&Limit>, work: &Work) -> bool {
    let Some(duration) = extremal.given_duration.filter(|_| extremal.times_pulses()) else { return false };
    if is_long(extremal) {
        return true;
    }
    let slow = slow_momenta(extremal, duration).into_iter();
    let costs = slow.filter_map(|momentum| Some(transfer(extremal, momentum, duration, work)?.cost));
    let least = costs.fold(f64::INFINITY, f64::min);
    least.is_finite() && best.is_none_or(|best| best.cost(extremal) > 2.0 * least)
}

/// What two impulses and those that are added to them come to, the cheapest first.
pub(super) fn limits(extremal: &Extremal, work: &Work) -> Vec<Limit> {
    let Some(duration) = extremal.given_duration.filter(|_| extremal.times_pulses()) else {
        return Vec::new();
    };
    let momenta = first_momenta(extremal, duration);
    let found = momenta.into_iter().take_while(|_| !work.stopped());
    let mut transfers: Vec<Transfer> =
        found.filter_map(|momentum| transfer(extremal, momentum, duration, work)).collect();
    transfers.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    transfers.dedup_by(|a, b| (a.momentum - b.momentum).norm() <= SAME.sqrt() * b.momentum.norm());
    let ask = Ask::free(extremal);
    let burnt = |transfer: &Transfer| {
        let [first, last] = &transfer.burns;
        let begin = first.iter().map(|(level, length)| Pulse { level: *level, on: 0.0, off: *length });
        let end = last.iter();
        let end = end.map(|(level, length)| Pulse { level: *level, on: duration - length, off: duration });
        let schedule = Schedule::kept(begin.chain(end).collect(), duration, &ask)?;
        laid(extremal, &Motion::of(extremal, &schedule, &[0.0; 6])?.arcs, work)
    };
    let mut burns: Vec<(Arcs, Certificate)> =
        transfers.iter().take(TRIED).take_while(|_| !work.stopped()).filter_map(burnt).collect();
    burns.sort_by(|(a, _), (b, _)| a.cost(extremal).total_cmp(&b.cost(extremal)));
    burns.dedup_by(|(a, _), (b, _)| (a.cost(extremal) / b.cost(extremal) - 1.0).abs() < GAINED);
    burns.truncate(MENDED);
    let limit = |burns: (Arcs, Certificate)| {
        let mut looser = mended(extremal, burns, work);
        let best = looser.pop()?;
        let smooth = Smoothed { path: path_of(extremal, &best.0)?, epsilon: LAST };
        Some(Limit { looser, ..Limit::of_arcs(&smooth, smooth.clone(), best) })
    };
    let mut limits: Vec<Limit> =
        burns.into_iter().take_while(|_| !work.stopped()).filter_map(limit).collect();
    limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    limits
}

/// The momenta of a slow turn to the end, either way round.
fn slow_momenta(extremal: &Extremal, duration: f64) -> [Vector3; 2] {
    let phi = lie::log(&extremal.end_attitude);
    let back = phi - TAU * phi.try_normalize(SAME).unwrap_or_else(Vector3::x);
    [phi, back].map(|turn| extremal.j * turn / duration)
}

/// Momenta to begin with: of a slow turn either way round, of the motion at the start and, at random, about it and about none.
fn first_momenta(extremal: &Extremal, duration: f64) -> Vec<Vector3> {
    let start = extremal.j * extremal.start_rate;
    let ends =
        [start.norm(), (extremal.j * extremal.end_rate).norm(), PI * extremal.j.trace() / (3.0 * duration)];
    let size = SPREAD * ends.into_iter().fold(0.0, f64::max);
    let mut random = Stream::new(0, 0, 0);
    let mut momenta = slow_momenta(extremal, duration).to_vec();
    momenta.push(start);
    for index in 0..RANDOM {
        let about = if index % 2 == 0 { start } else { Vector3::zeros() };
        momenta.push(about + size * Vector3::from_column_slice(&random.in_ball(3)));
    }
    momenta
}

/// The transfer to which Newton leads from a momentum.
fn transfer(extremal: &Extremal, mut momentum: Vector3, duration: f64, work: &Work) -> Option<Transfer> {
    count(&work.newtons);
    let coast = extremal.on_arc(&vec![-1.0; extremal.switching_count()]);
    // A step turns the end by about a radian at most: beyond that the coast says nothing of another.
    let longest = extremal.j.trace() / (3.0 * duration);
    for _ in 0..FAR_ITERATIONS {
        let first = Node { r: Matrix3::identity(), pi: momentum, e: Vector3::zeros() };
        let end = extremal.flow_step(&Vector3::zeros(), &first, &coast, (duration, duration), COARSER * FINE);
        let miss = lie::log(&(end.f * extremal.end_attitude.transpose()));
        if miss.norm() < NEAR {
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

/// The nodes of arcs for a path.
fn path_of(extremal: &Extremal, arcs: &Arcs) -> Option<Path> {
    let (swept, _) = arcs.swept(extremal, FINE)?;
    let times = arcs.switches.iter().map(|switch| switch.time / arcs.duration);
    let parts = std::iter::once(0.0).chain(times).chain([1.0]).collect();
    Some(Path { m: arcs.m, duration: arcs.duration, nodes: swept.nodes, parts })
}

#[cfg(test)]
mod tests {
    use super::super::extremal::Law;
    use super::super::flow::Course;
    use super::super::work::Halt;
    use super::*;
    use crate::testing::full_inertia;

    fn moving() -> Extremal {
        let units = [Vector3::x(), Vector3::y(), Vector3::z()];
        let inertia = full_inertia();
        Extremal {
            j: *inertia.j(),
            j_inverse: *inertia.j_inverse(),
            law: Law::Inputs(units.into_iter().flat_map(|axis| [0.5 * axis, -0.5 * axis]).collect()),
            costs: vec![1.0; 6],
            time_price: 6.0,
            given_duration: Some(60.0),
            middle: Vector3::zeros(),
            start_rate: Vector3::new(0.2, -0.1, 0.15),
            end_rate: Vector3::new(-0.05, 0.1, 0.02),
            end_attitude: lie::exp(&Vector3::new(0.9, -0.5, 0.7)),
            halt: Halt::default(),
        }
    }

    #[test]
    fn two_impulses_turn_a_free_body_to_the_end_with_the_momentum_that_it_should_have() {
        let given = moving();
        let work = Work::until(&|| false);
        let momenta = first_momenta(&given, 60.0);
        let all: Vec<Transfer> =
            momenta.into_iter().filter_map(|momentum| transfer(&given, momentum, 60.0, &work)).collect();
        assert!(all.len() > 10, "{}", all.len());
        let (none, still) = (Vector3::zeros(), Extremal::holding(&Vector3::zeros(), 0.0));
        for Transfer { momentum, burns, cost } in all {
            let course = Course::of(&given, &none);
            let mut node = Node { r: Matrix3::identity(), pi: momentum, e: none };
            for _ in 0..4000 {
                node = course.reached(&node, 60.0 / 4000.0, |_, e| still.at(e));
            }
            assert!(lie::log(&given.end_attitude.tr_mul(&node.r)).norm() < 2.0 * NEAR);
            let pushed = burns.map(|burn| {
                burn.iter().fold(none, |sum, (level, length)| sum + 2.0 * *length * given.axes()[*level])
            });
            let start = momentum - given.j * given.start_rate;
            let stop = given.j * given.end_rate - node.pi;
            assert!((pushed[0] - start).norm() < 1e-9 && (pushed[1] - stop).norm() < 1e-6);
            // Each axis costs two for a unit of impulse.
            assert!((cost - 2.0 * (start.lp_norm(1) + stop.lp_norm(1))).abs() < 1e-5, "{cost}");
        }
    }

    #[test]
    fn impulses_are_of_use_between_rates_for_long_alone() {
        let work = Work::until(&|| false);
        let long = moving();
        let short = long.lasting(Some(4.0));
        let rests = Extremal { start_rate: Vector3::zeros(), end_rate: Vector3::zeros(), ..moving() };
        assert!([&long, &short, &rests].map(is_long) == [true, false, false]);
        assert!(are_of_use(&long, None, &work) && !are_of_use(&long.lasting(None), None, &work));
    }
}
