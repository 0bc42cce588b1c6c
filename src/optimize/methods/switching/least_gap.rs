//! The costates along a maneuver of arcs that give the smallest gap.
//!
//! Costates that satisfy their equations bound the cost that could still be saved, whatever their
//! initial values: to first order, inputs within their limits that keep the boundary conditions
//! cost at most the gap less than the maneuver. If the inputs are held, a change `δ` of the initial
//! costates changes every switching function by `g_j(t)·δ`, and
//!
//! ```text
//! gap(δ) = ∫ Σ_j (|s_j + g_j·δ| + (s_j + g_j·δ) v_j) dt
//! ```
//!
//! is convex. It is the dual of the linear program over all inputs along the path, whose optimum is
//! the gap without slack. The costates that vanish where the inputs switch need not give the
//! minimum: a few switches close together determine them badly, and between the pulses that replace
//! a singular arc they are all slightly wrong. The smallest gap is found by Newton on `√(s² + μ²)`.
//!
//! A free duration is one more variable of the linear program, and the Hamiltonian is its reduced
//! cost. It must vanish at the start, as along the whole path, which leaves five numbers.

use super::arcs::Arcs;
use super::certificate::looks;
use super::extremal::Extremal;
use super::flow::{Course, Lanes};
use super::tuning::arcs::*;
use super::tuning::{FAR_ITERATIONS, NOTHING};
use nalgebra::{SMatrix, SVector};

/// Change of `M` and of the costate `e` at the start.
type CostateChange = SVector<f64, 6>;

/// The switching function of one input at a sample point, with the part of the duration that the
/// sample represents.
struct Piece {
    length: f64,
    /// Sign of the input.
    sign: f64,
    /// Value of the switching function.
    value: f64,
    /// Derivative of the switching function with respect to the costates at the start.
    slope: CostateChange,
}

/// Returns the arcs with the costates that give the smallest gap. If the duration is given, the
/// second element has these costates reduced until no input that is off should be on. Returns an
/// empty vector if fuel is not a sum over pulses of separate inputs.
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

/// Samples all switching functions along the path; also returns the derivatives of the node at the
/// end of each arc.
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

/// Returns the change of the costates that minimises the gap. With `vanishing`, a linear function
/// of the change, given by its value and slope, is held at zero.
fn least(pieces: &[Piece], vanishing: Option<(f64, CostateChange)>) -> CostateChange {
    let total: f64 = pieces.iter().map(|piece| piece.length).sum();
    let along = vanishing.map(|(_, slope)| slope);
    // The smallest change for which the function vanishes; not a number if the function does not
    // depend on the change.
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

/// Returns the change after which all costates are reduced by a common factor, so that no input
/// that is off should be on. `own` are the costates before the change.
///
/// In a long duration nearly all is coast, and an input that should be on for all of the coast, by
/// however little, is worth more than the cost of the plan. Reduced costates add an equally small
/// fraction of the burns' cost.
fn without_excess(pieces: &[Piece], own: &CostateChange, change: &CostateChange) -> CostateChange {
    let excess = |piece: &Piece| {
        let price = piece.value - piece.slope.dot(own);
        let lacks = -(piece.value + piece.slope.dot(change));
        if piece.sign < 0.0 && lacks > 0.0 { lacks / (price + lacks) } else { 0.0 }
    };
    let largest = pieces.iter().map(excess).fold(0.0, f64::max);
    change - largest * (own + change)
}

/// Returns the gap, with the absolute values smoothed by `mu`.
fn gap(pieces: &[Piece], change: &CostateChange, mu: f64) -> f64 {
    let of = |piece: &Piece| {
        let s = piece.value + piece.slope.dot(change);
        piece.length * ((s * s + mu * mu).sqrt() + s * piece.sign)
    };
    pieces.iter().map(of).sum()
}

/// Minimises the smoothed gap by Newton from a change of the costates, orthogonal to the direction
/// `across`.
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
        // A maneuver with few inputs does not determine all costates.
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
