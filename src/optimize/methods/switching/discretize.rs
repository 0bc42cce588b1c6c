//! From a continuous extremal to the discrete optimum on a grid.

use super::arcs::Arcs;
use super::extremal::{Bias, Extremal, Law};
use super::flow::{COOPER_VERNER, Course, Lanes, Node, advance};
use super::grid_step::Torque;
use super::on_grid::{MOST_ITERATIONS, OnGrid, Step};
use super::smooth::Smoothed;
use crate::Vector3;

/// Fewest steps of an arc.
pub(crate) const LEAST_STEPS: usize = 2;

/// Steps of arcs of these lengths, `steps` in all where that allows every arc its least number.
pub(crate) fn shares(lengths: &[f64], steps: usize) -> Vec<usize> {
    let total: f64 = lengths.iter().sum();
    let mut counts: Vec<usize> =
        lengths.iter().map(|length| ((length / total * steps as f64) as usize).max(LEAST_STEPS)).collect();
    loop {
        let sum: usize = counts.iter().sum();
        // The arc with the longest steps gets one more, that with the shortest gives one.
        let longest = |a: &usize, b: &usize| {
            (lengths[*a] / counts[*a] as f64).total_cmp(&(lengths[*b] / counts[*b] as f64))
        };
        let all = 0..counts.len();
        let changed = if sum < steps {
            all.max_by(longest).map(|arc| (arc, counts[arc] + 1))
        } else if sum > steps {
            all.filter(|arc| counts[*arc] > LEAST_STEPS).min_by(longest).map(|arc| (arc, counts[arc] - 1))
        } else {
            None
        };
        match changed {
            Some((arc, count)) => counts[arc] = count,
            None => return counts,
        }
    }
}

/// Arcs on a grid of so many steps for each; one without steps is left out.
pub(crate) fn of_arcs(extremal: &Extremal, arcs: &Arcs, counts: &[usize]) -> OnGrid {
    let (mut lengths, mut steps, mut nodes) = (Vec::new(), Vec::new(), vec![arcs.first]);
    let mut all_signs = Vec::new();
    for ((from, start, end, signs), count) in arcs.arcs().into_iter().zip(counts) {
        if *count == 0 {
            continue;
        }
        let law = extremal.on_arc(&signs);
        let torque = match law.held() {
            Some(held) => Torque::Given { torque: held.torque, running: held.running },
            None => Torque::Turning(law),
        };
        let part = 1.0 / *count as f64;
        let mut node = from;
        for _ in 0..*count {
            let mut none = Lanes::<3>::zero();
            let length = (end - start) * part;
            node =
                advance(&Course::of(extremal, &arcs.m), &COOPER_VERNER, &node, length, &mut none, |_, e| {
                    law.at(e)
                });
            nodes.push(node);
            steps.push(Step { arc: lengths.len(), part, torque });
        }
        lengths.push(end - start);
        all_signs.push(signs);
    }
    OnGrid::new(arcs.m, lengths, steps, all_signs, nodes)
}

/// An arc shorter than this part of the duration has no length: two inputs switch together.
pub(crate) const NO_LENGTH: f64 = 1e-14;

/// An arc shorter than this part of the duration has one step, beside those of the others.
const COMMON: f64 = 1e-6;

/// How often switches are exchanged or joined, in all.
const MOST_CHANGES: usize = 6;

/// The discrete optimum for arcs, on `steps` steps.
///
/// Where two inputs switch together, as rest to rest at the middle, the arc between them stays in the equations with
/// no length: without it the costates would not be determined. Where it comes out negative the two switch in the other
/// order; where it does so in both orders, the optimum of the grid has them at the same node, and the arc is left out.
pub(crate) fn arcs_on_grid(extremal: &Extremal, arcs: &Arcs, steps: usize) -> Option<OnGrid> {
    let mut arcs = arcs.clone();
    let lengths: Vec<f64> = arcs.arcs().iter().map(|(_, start, end, _)| end - start).collect();
    let (mut exchanged, mut joined) = (vec![false; lengths.len()], vec![false; lengths.len()]);
    let common = |length: f64| length.abs() < COMMON * arcs.duration;
    let common: Vec<bool> = lengths.iter().map(|length| common(*length)).collect();
    for _ in 0..=MOST_CHANGES {
        let is_proper = |arc: &usize| !common[*arc] && !joined[*arc];
        let proper: Vec<f64> = (0..lengths.len()).filter(is_proper).map(|arc| lengths[arc]).collect();
        if proper.len() * LEAST_STEPS > steps {
            return None;
        }
        let mut shares = shares(&proper, steps).into_iter();
        let of_arc = |arc: usize| match (joined[arc], common[arc]) {
            (true, _) => Some(0),
            (false, true) => Some(1),
            (false, false) => shares.next(),
        };
        let counts: Vec<usize> = (0..lengths.len()).filter_map(of_arc).collect();
        let found = of_arcs(extremal, &arcs, &counts).solve(extremal)?;
        let least = -NO_LENGTH * found.duration();
        let Some(negative) = found.lengths.iter().position(|length| *length < least) else {
            return Some(found);
        };
        // The arc with that length, among those that have steps.
        let arc = (0..lengths.len()).filter(|arc| counts[*arc] > 0).nth(negative)?;
        if exchanged[arc] || arc == 0 || arc + 1 == lengths.len() {
            joined[arc] = true;
        } else {
            exchanged[arc] = true;
            let (before, after) = (arcs.switches[arc - 1].input, arcs.switches[arc].input);
            (arcs.switches[arc - 1].input, arcs.switches[arc].input) = (after, before);
        }
    }
    None
}

/// ε that a step of the grid can follow, times the number of steps.
const FOLLOWED: f64 = 0.3;

/// On the way to a smaller ε: residual over ε at which Newton ends, and most iterations. Where the grid cannot follow it takes
/// all of them.
const ON_THE_WAY: f64 = 1e-2;
const MOST_ON_THE_WAY: usize = 12;

/// ε that is tried after none at all.
const LEAST_SMOOTHING: f64 = 1e-4;

/// The discrete optimum of the smoothed problem on `steps` equal steps, and its ε: the smallest that is found, not below
/// `least`.
pub(crate) fn smooth_on_grid(
    extremal: &Extremal,
    smooth: &Smoothed,
    least: f64,
    steps: usize,
) -> Option<(OnGrid, f64)> {
    let start = of_smooth(extremal, smooth, steps);
    // The direction of a torque of given norm turns smoothly; inputs jump, and so does a norm that costs.
    let jumps = matches!(extremal.law, Law::Inputs(_)) || extremal.counts_fuel();
    let wish = if jumps { smooth.epsilon.max(FOLLOWED / steps as f64) } else { smooth.epsilon };
    let at = |grid: &OnGrid, epsilon: f64, most: usize| {
        let mut grid = grid.clone();
        for step in &mut grid.steps {
            step.torque = Torque::Smooth(epsilon);
        }
        grid.solve_to(ON_THE_WAY * epsilon, most, extremal)
    };
    let (mut epsilon, mut found) = (wish, at(&start, wish, MOST_ITERATIONS));
    for _ in 0..4 {
        if found.is_some() {
            break;
        }
        epsilon = (2.5 * epsilon).max(LEAST_SMOOTHING);
        found = at(&start, epsilon, MOST_ITERATIONS);
    }
    let mut known = vec![(found?, epsilon)];
    while epsilon > least {
        let next = (0.4 * epsilon).max(least);
        let Some(better) = known.last().and_then(|(found, _)| at(found, next, MOST_ON_THE_WAY)) else {
            break;
        };
        known.push((better, next));
        epsilon = next;
    }
    // To all digits; where the last has none, the one before.
    known.into_iter().rev().find_map(|(found, epsilon)| Some((found.solve(extremal)?, epsilon)))
}

/// A smoothed extremal on equal steps.
pub(crate) fn of_smooth(extremal: &Extremal, smooth: &Smoothed, steps: usize) -> OnGrid {
    let path = &smooth.path;
    let part = 1.0 / steps as f64;
    let bias = Bias::default();
    // From the nearest node before, so that nothing is integrated far.
    let node = |k: usize| -> Node {
        let (index, share) = path.interval_at(k as f64 / steps as f64);
        let mut none = Lanes::<3>::zero();
        let length = share * (path.parts[index + 1] - path.parts[index]) * path.duration;
        let law = |_: f64, e: &Vector3| extremal.smooth(e, smooth.epsilon, &bias.constant);
        advance(&Course::of(extremal, &path.m), &COOPER_VERNER, &path.nodes[index], length, &mut none, law)
    };
    let nodes = (0..=steps).map(node).collect();
    let step = Step { arc: 0, part, torque: Torque::Smooth(smooth.epsilon) };
    OnGrid::new(path.m, vec![path.duration], vec![step; steps], Vec::new(), nodes)
}
