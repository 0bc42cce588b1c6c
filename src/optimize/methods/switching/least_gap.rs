//! Of all costates along a maneuver of arcs, those that leave the smallest gap.
//!
//! Costates that follow their equations bound what is still to be gained whatever they are at the start: to first order no inputs
//! within their limits that keep the ends cost less than the maneuver does by more than the gap. Where the inputs are held, a
//! change `δ` of the costates at the start changes every switching function by `g_j(t)·δ`, and
//!
//! ```text
//! gap(δ) = ∫ Σ_j (|s_j + g_j·δ| + (s_j + g_j·δ) v_j) dt
//! ```
//!
//! is convex: the dual of the linear program over all inputs along the way, whose optimum is the gap without slack. Costates that
//! vanish where the inputs switch need not be those: of a few switches hardly apart they are determined badly, and between the
//! pulses that stand for a singular arc they are all a little off. The least gap is found by Newton on `√(s² + μ²)`.
//!
//! Where the duration is sought the program has it for one more variable, with the Hamiltonian for its reduced cost: that must vanish, at
//! the start as along all of the way, which leaves five numbers.

use super::arcs::Arcs;
use super::extremal::Extremal;
use super::flow::{Course, Lanes, Node};
use super::tuning::arcs::*;
use super::tuning::{FINE, POINTS};
use crate::Vector3;
use crate::numerics::hermite::hermite;
use nalgebra::{SMatrix, SVector};

/// A change of `M` and of the costate at the start.
type Change = SVector<f64, 6>;

/// A switching function on a short piece of its arc.
struct Piece {
    length: f64,
    /// Sign of the input, the function, and how it answers to the costates at the start.
    sign: f64,
    value: f64,
    slope: Change,
}

/// The same maneuver with the costates of the least gap, and that gap, of points that stand close together at the ends of arcs;
/// `None` where its inputs are not held.
pub(crate) fn with_least_gap(extremal: &Extremal, arcs: &Arcs) -> Option<(Arcs, f64)> {
    if !extremal.times_pulses() {
        return None;
    }
    let (pieces, lanes) = pieces(extremal, arcs);
    let law = extremal.on_arc(&arcs.signs);
    let at_start = || extremal.hamiltonian_at_start(&arcs.m, &arcs.first, &law);
    let change = least(&pieces, extremal.given_duration.is_none().then(at_start));
    let mut moved = arcs.clone();
    moved.m += change.fixed_rows::<3>(0);
    moved.first.e += change.fixed_rows::<3>(3);
    for (switch, lanes) in moved.switches.iter_mut().zip(&lanes) {
        switch.node.e += lanes.times(change.as_slice())[2];
    }
    Some((moved, gap(&pieces, &change, 0.0)))
}

/// All switching functions along the way, and how the nodes answer at the end of each arc.
fn pieces(extremal: &Extremal, arcs: &Arcs) -> (Vec<Piece>, Vec<Lanes<8>>) {
    let (mut pieces, mut at_ends) = (Vec::new(), Vec::new());
    let mut lanes = Lanes::<8>::of_costate();
    for (from, start, end, signs) in arcs.arcs() {
        let law = extremal.on_arc(&signs);
        let steps = ((end - start) / (2.0 * FINE * arcs.duration)).ceil().clamp(1.0, MOST_STEPS) as usize;
        let length = (end - start) / steps as f64;
        let (course, torque) = (Course::of(extremal, &arcs.m), law.at(&from.e).torque);
        let mut node = from;
        let mut before = Costates::at(extremal, &arcs.m, &node, &lanes, &torque);
        for step in 0..steps {
            node = course.carried(&node, length, &mut lanes, |_, e| law.at(e));
            let after = Costates::at(extremal, &arcs.m, &node, &lanes, &torque);
            for (x, part) in points(step == 0, step + 1 == steps) {
                let costates = before.between(&after, length, x);
                for (input, sign) in signs.iter().enumerate() {
                    let along = extremal.switching_slope(input, &costates[6]);
                    pieces.push(Piece {
                        length: part * length,
                        sign: *sign,
                        value: extremal.switching(input, &costates[6]),
                        slope: Change::from_fn(|lane, _| along.dot(&costates[lane])),
                    });
                }
            }
            before = after;
        }
        at_ends.push(lanes);
    }
    (pieces, at_ends)
}

/// Where a step is looked at and for what part of it, close together towards the ends of an arc: there a crossing is a little
/// beside the switch.
fn points(first: bool, last: bool) -> impl Iterator<Item = (f64, f64)> {
    let edge = move |k: usize| {
        let x = k as f64 / (2 * POINTS) as f64;
        match (first, last) {
            (true, true) => 0.5 - 0.5 * (std::f64::consts::PI * x).cos(),
            (true, false) => x * x,
            (false, true) => x * (2.0 - x),
            (false, false) => x,
        }
    };
    (0..(2 * POINTS)).map(move |k| (0.5 * (edge(k) + edge(k + 1)), edge(k + 1) - edge(k)))
}

/// What the six costates at the start make of the costate `e` at a node, and that itself, with their time derivatives.
struct Costates {
    values: [Vector3; 7],
    rates: [Vector3; 7],
}

impl Costates {
    fn at(extremal: &Extremal, m: &Vector3, node: &Node, lanes: &Lanes<8>, torque: &Vector3) -> Self {
        let rate = |m: &Vector3, e: &Vector3| extremal.rate(m, &Node { e: *e, ..*node }, torque)[2];
        let own = rate(m, &node.e);
        // Costates follow linear equations.
        let of_lane = |lane: usize| {
            let unit = if lane < 3 { Vector3::ith(lane, 1.0) } else { Vector3::zeros() };
            rate(&unit, &lanes.block(2, lane))
        };
        let value = |lane: usize| if lane < 6 { lanes.block(2, lane) } else { node.e };
        Self {
            values: std::array::from_fn(value),
            rates: std::array::from_fn(|lane| if lane < 6 { of_lane(lane) } else { own }),
        }
    }

    /// By the cubic with these values and derivatives.
    fn between(&self, next: &Self, length: f64, x: f64) -> [Vector3; 7] {
        std::array::from_fn(|lane| {
            hermite(
                x,
                length,
                [&self.values[lane], &next.values[lane]],
                [&self.rates[lane], &next.rates[lane]],
            )
        })
    }
}

/// The change of the costates that makes the gap least, where a number that is linear in it, given by its value and slope, vanishes.
fn least(pieces: &[Piece], vanishing: Option<(f64, Change)>) -> Change {
    let total: f64 = pieces.iter().map(|piece| piece.length).sum();
    let along = vanishing.map(|(_, slope)| slope);
    // The smallest change with which it does; none where it does not depend on the change.
    let nearest = |(value, slope): (f64, Change)| -value / slope.norm_squared() * slope;
    let dependent = vanishing.filter(|(_, slope)| slope.norm_squared() > 0.0);
    let first = dependent.map_or_else(Change::zeros, nearest);
    let (mut best, mut least) = (first, gap(pieces, &first, 0.0));
    let (mut change, mut mu) = (best, FIRST);
    while mu > LAST && mu * total > ADDED * least {
        change = newton(pieces, change, along.as_ref(), mu);
        let found = gap(pieces, &change, 0.0);
        if found < least {
            (best, least) = (change, found);
        }
        mu *= REDUCED;
    }
    best
}

/// The gap, with the absolute values smoothed.
fn gap(pieces: &[Piece], change: &Change, mu: f64) -> f64 {
    let of = |piece: &Piece| {
        let s = piece.value + piece.slope.dot(change);
        piece.length * ((s * s + mu * mu).sqrt() + s * piece.sign)
    };
    pieces.iter().map(of).sum()
}

/// Newton on the smoothed gap, from a change of the costates and across a direction.
fn newton(pieces: &[Piece], from: Change, across: Option<&Change>, mu: f64) -> Change {
    let mut change = from;
    let mut last = gap(pieces, &change, mu);
    for _ in 0..MOST_STEPS_OF_GAP {
        let (mut gradient, mut hessian) = (Change::zeros(), SMatrix::<f64, 6, 6>::zeros());
        for piece in pieces {
            let s = piece.value + piece.slope.dot(&change);
            let root = (s * s + mu * mu).sqrt();
            gradient += piece.length * (s / root + piece.sign) * piece.slope;
            let bend = piece.length * mu * mu / (root * root * root);
            hessian += (bend * piece.slope) * piece.slope.transpose();
        }
        if let Some(unit) = across.and_then(|across| across.try_normalize(0.0)) {
            let along = unit * unit.transpose();
            let flat = SMatrix::<f64, 6, 6>::identity() - along;
            (gradient, hessian) = (flat * gradient, flat * hessian * flat + hessian.trace() * along);
        }
        let open = OPEN * hessian.trace();
        hessian += SMatrix::<f64, 6, 6>::identity() * open;
        let Some(step) = hessian.lu().solve(&-gradient) else { break };
        let mut factor = 1.0;
        let better = (0..=MOST_HALVINGS).find_map(|_| {
            let next = change + factor * step;
            let found = gap(pieces, &next, mu);
            factor *= 0.5;
            (found < last).then_some((next, found))
        });
        let Some((next, found)) = better else { break };
        let gained = last - found;
        (change, last) = (next, found);
        if gained <= NO_GAIN * found {
            break;
        }
    }
    change
}
