//! Compares the order of stops that the planner finds with all orders of the legs, or with a proved
//! bound.
//!
//! `cargo run --release -p evidence -- orders [COUNT [STOPS]]`: COUNT (200 by default) random sets
//! of STOPS attitudes (8 by default), uniform on SO(3). The body has moments in a ratio of up to 3
//! about random axes, and limited torques about its body axes. It turns from rest to rest in
//! minimum time.
//!
//! Up to 8 stops, every leg is planned in both directions by the default search. The best order
//! counts as missed if another order of these legs is shorter by more than 1e-6, relative. For more
//! than 8 stops, the gap to the proved bound is printed. The table ends with the number of plans
//! that an order needs, and its computing time. The command ends with 1 if an order is missed.

use evidence::words::Words;
use evidence::{Random, median};
use slewkit::maneuver::{Outcome, Settings};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use slewkit::sequence::order::Proof;
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Actuation, ActuatorSet, AxisFrame, Body, Limits, Matrix3, Problem, State};
use std::error::Error;
use std::time::Instant;

/// The largest number of stops for which all orders are tried.
const ALL: usize = 8;
/// The relative difference below which two sums of legs count as equal.
const NEAR: f64 = 1e-6;

fn sequence(index: usize, count: usize) -> Result<Sequence, Box<dyn Error>> {
    let mut random = Random::of_case(71, index);
    let body = Body { inertia: random.inertia(3.0), mass: None };
    let size = (0..3).map(|_| random.within(0.5, 2.0)).collect();
    let limits = Limits { size: Some(size), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
    let at = |attitude: Matrix3| State::at_rest(attitude);
    let craft = Problem::minimum_time(body, at(random.uniform_rotation()), at(Matrix3::identity()))
        .with_actuation(Actuation::torques(torques))
        .with_steps(100);
    let stop = |index: usize| Stop::at(&index.to_string(), Place::Attitude(random.uniform_rotation()));
    Ok(Sequence { craft, stops: (1..=count).map(stop).collect(), order: Ordering::Free })
}

/// Plans all legs in both directions, and returns the total time of an order of stops (from 1), and
/// the shortest total time of all orders of the same legs.
fn totals(sequence: &Sequence, order: &[usize]) -> Result<[f64; 2], Box<dyn Error>> {
    let attitude = |stop: &Stop| match &stop.place {
        Place::Attitude(attitude) => Ok(State::at_rest(*attitude)),
        Place::Aim(_) => Err("a stop without an attitude"),
    };
    let mut states = vec![sequence.craft.start];
    for stop in &sequence.stops {
        states.push(attitude(stop)?);
    }
    let mut legs = vec![vec![0.0; states.len()]; states.len()];
    for from in 0..states.len() {
        for to in 0..from {
            let mut best = f64::INFINITY;
            for (start, end) in [(states[from], states[to]), (states[to], states[from])] {
                let leg = Problem { start, end, ..sequence.craft.clone() };
                let found = solve(&leg, &Settings::discrete(), None, &mut Silent)?;
                let continuous = found.switching.as_ref().map(|found| found.continuous_cost);
                if found.outcome == Outcome::Converged {
                    best = best.min(continuous.unwrap_or(found.cost));
                }
            }
            (legs[from][to], legs[to][from]) = (best, best);
        }
    }
    let before = std::iter::once(&0).chain(order);
    let of_order = before.zip(order).map(|(from, to)| legs[*from][*to]).sum();
    Ok([of_order, least(&legs, 0, &mut (1..states.len()).collect())])
}

/// Returns the smallest total time of the legs from a stop through all remaining stops.
fn least(legs: &[Vec<f64>], from: usize, left: &mut Vec<usize>) -> f64 {
    if left.is_empty() {
        return 0.0;
    }
    let mut best = f64::INFINITY;
    for index in 0..left.len() {
        let to = left.remove(index);
        best = best.min(legs[from][to] + least(legs, to, left));
        left.insert(index, to);
    }
    best
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of sets", 200)?;
    let stops: usize = words.number("number of stops", 8)?;
    words.end()?;
    let (mut missed, mut seconds, mut gaps, mut exact) = (0, Vec::new(), Vec::new(), 0);
    for index in 0..count {
        let sequence = sequence(index, stops)?;
        let began = Instant::now();
        let order = sequence.best_order(&Settings::discrete(), &mut Silent)?;
        seconds.push(began.elapsed().as_secs_f64());
        gaps.push(order.gap());
        exact += usize::from(order.proof == Proof::AllOrders);
        if stops <= ALL {
            let [found, known] = totals(&sequence, &order.stops)?;
            if found > known * (1.0 + NEAR) {
                println!("set {index}: {found:.6} s, and an order of {known:.6} s exists");
                missed += 1;
            }
        }
    }
    let worst = gaps.iter().copied().fold(0.0, f64::max);
    println!("{count} sets of {stops} stops: {exact} orders exact, {missed} missed");
    println!("gap, median and worst: {:.2} %, {:.2} %", 100.0 * median(&mut gaps), 100.0 * worst);
    println!("seconds for an order, median: {:.2}", median(&mut seconds));
    if missed > 0 { Err("see above".into()) } else { Ok(()) }
}
