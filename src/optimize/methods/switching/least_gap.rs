//! Of all costates along a maneuver of arcs, those that leave the smallest gap.
//!
//! Costates that follow their equations bound what is still to be gained whatever they are at the
//! start: to first order no inputs within their limits that keep the ends cost less than the
//! maneuver does by more than the gap. Where the inputs are held, a change `δ` of the costates at
//! the start changes every switching function by `g_j(t)·δ`, and
//!
//! ```text
//! gap(δ) = ∫ Σ_j (|s_j + g_j·δ| + (s_j + g_j·δ) v_j) dt
//! ```
//!
//! is convex: the dual of the linear program over all inputs along the way, whose optimum is the
//! gap without slack. Costates that vanish where the inputs switch need not be those: of a few
//! switches hardly apart they are determined badly, and between the pulses that stand for a
//! singular arc they are all a little off. The least gap is found by Newton on `√(s² + μ²)`.
//!
//! Where the duration is sought the program has it for one more variable, with the Hamiltonian for
//! its reduced cost: that must vanish, at the start as along all of the way, which leaves five
//! numbers.

use super::arcs::Arcs;
use super::certificate::looks;
use super::extremal::Extremal;
use super::flow::{Course, Lanes};
use super::tuning::arcs::*;
use super::tuning::{FAR_ITERATIONS, NOTHING};
use nalgebra::{SMatrix, SVector};

/// A change of `M` and of the costate at the start.
type CostateChange = SVector<f64, 6>;

/// A switching function on a short piece of its arc.
struct Piece {
    length: f64,
    /// Sign of the input, the function, and how it answers to the costates at the start.
    sign: f64,
    value: f64,
    slope: CostateChange,
}

/// The same maneuver with the costates of the least gap and, in a given duration, with those that
/// are smaller by what an input lacks of being off. None where its inputs are not held.
pub(crate) fn with_less_gap(extremal: &Extremal, arcs: &Arcs) -> Vec<Arcs> {
    if !extremal.times_pulses() {
        return Vec::new();
    }
    let (pieces, lanes) = pieces(extremal, arcs);
    let law = extremal.on_arc(&arcs.signs);
    let at_start = || extremal.hamiltonian_at_start(&arcs.m, &arcs.first, &law);
    let given = extremal.given_duration.is_some();
    let change = least(&pieces, (!given).then(at_start));
    let slower = given.then(|| without_excess(&pieces, &arcs.costates(), &change));
    let moved = |change: CostateChange| {
        let mut moved = arcs.clone();
        moved.m += change.fixed_rows::<3>(0);
        moved.first.e += change.fixed_rows::<3>(3);
        for (switch, lanes) in moved.switches.iter_mut().zip(&lanes) {
            switch.node.e += lanes.folded(&std::array::from_fn(|lane| *change.get(lane).unwrap_or(&0.0)))[2];
        }
        moved
    };
    [change].into_iter().chain(slower).map(moved).collect()
}

/// All switching functions along the way, and how the nodes answer at the end of each arc.
fn pieces(extremal: &Extremal, arcs: &Arcs) -> (Vec<Piece>, Vec<Lanes<8>>) {
    let (mut pieces, mut at_ends) = (Vec::new(), Vec::new());
    let mut lanes = Lanes::<8>::of_costate();
    for (from, start, end, signs) in arcs.arcs() {
        let (law, course) = (extremal.on_arc(&signs), Course::of(extremal, &arcs.m));
        let (mut node, mut at) = (from, 0.0);
        for (past, half) in looks(extremal, &from, (end - start, arcs.duration)) {
            node = course.carried(&node, past - at, &mut lanes, |_, e| law.at(e));
            at = past;
            for (input, sign) in signs.iter().enumerate() {
                let along = extremal.switching_slope(input, &node.e);
                pieces.push(Piece {
                    length: 2.0 * half,
                    sign: *sign,
                    value: extremal.switching(input, &node.e),
                    slope: CostateChange::from_fn(|lane, _| along.dot(&lanes.block(2, lane))),
                });
            }
        }
        course.carried(&node, end - start - at, &mut lanes, |_, e| law.at(e));
        at_ends.push(lanes);
    }
    (pieces, at_ends)
}

/// The change of the costates that makes the gap least, where a number that is linear in it, given
/// by its value and slope, vanishes.
fn least(pieces: &[Piece], vanishing: Option<(f64, CostateChange)>) -> CostateChange {
    let total: f64 = pieces.iter().map(|piece| piece.length).sum();
    let along = vanishing.map(|(_, slope)| slope);
    // The smallest change with which it does; none where it does not depend on the change.
    let nearest = |(value, slope): (f64, CostateChange)| -value / slope.norm_squared() * slope;
    let dependent = vanishing.filter(|(_, slope)| slope.norm_squared() > 0.0);
    let first = dependent.map_or_else(CostateChange::zeros, nearest);
    let (mut best, mut least) = (first, gap(pieces, &first, 0.0));
    let (mut change, mut mu) = (best, FIRST);
    while mu > f64::EPSILON && mu * total > ADDED * least {
        change = newton(pieces, change, along.as_ref(), mu);
        let found = gap(pieces, &change, 0.0);
        if found < least {
            (best, least) = (change, found);
        }
        mu *= REDUCED;
    }
    best
}

/// Changes after which all costates are smaller by one factor, by which no input that is off should
/// be on; `own` are those without a change.
///
/// In a long duration nearly all is coast, and an input that should be on for all of it, by however
/// little, is worth more than the plan costs. What smaller costates add along the burns is as
/// little of their cost.
fn without_excess(pieces: &[Piece], own: &CostateChange, change: &CostateChange) -> CostateChange {
    let excess = |piece: &Piece| {
        let price = piece.value - piece.slope.dot(own);
        let lacks = -(piece.value + piece.slope.dot(change));
        if piece.sign < 0.0 && lacks > 0.0 { lacks / (price + lacks) } else { 0.0 }
    };
    let largest = pieces.iter().map(excess).fold(0.0, f64::max);
    change - largest * (own + change)
}

/// The gap, with the absolute values smoothed.
fn gap(pieces: &[Piece], change: &CostateChange, mu: f64) -> f64 {
    let of = |piece: &Piece| {
        let s = piece.value + piece.slope.dot(change);
        piece.length * ((s * s + mu * mu).sqrt() + s * piece.sign)
    };
    pieces.iter().map(of).sum()
}

/// Newton on the smoothed gap, from a change of the costates and across a direction.
fn newton(pieces: &[Piece], from: CostateChange, across: Option<&CostateChange>, mu: f64) -> CostateChange {
    let mut change = from;
    let mut last = gap(pieces, &change, mu);
    for _ in 0..FAR_ITERATIONS {
        let (mut gradient, mut hessian) = (CostateChange::zeros(), SMatrix::<f64, 6, 6>::zeros());
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
        // A maneuver of few inputs leaves costates open.
        hessian += SMatrix::from_diagonal(&(OPEN * hessian.diagonal()));
        let Some(step) = hessian.lu().solve(&-gradient) else { break };
        let halved = std::iter::successors(Some(1.0), |factor| Some(0.5 * factor));
        let better = halved.take_while(|factor| *factor > NOTHING).find_map(|factor| {
            let next = change + factor * step;
            let found = gap(pieces, &next, mu);
            (found < last).then_some((next, found))
        });
        let Some((next, found)) = better else { break };
        let gained = last - found;
        (change, last) = (next, found);
        if gained <= NOTHING * found {
            break;
        }
    }
    change
}
