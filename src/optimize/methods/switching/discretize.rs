//! Conversion of a continuous extremal to the discrete optimum on a grid.

use super::arcs::Arcs;
use super::extremal::{Extremal, TorqueLimit};
use super::flow::{Course, Node};
use super::grid_step::Torque;
use super::on_grid::OnGrid;
use super::sequence::Step;
use super::smooth::Smoothed;
use super::tuning::grid::*;
use super::tuning::limits::MOST_CORRECTIONS;
use super::tuning::smooth::ON_THE_WAY;
use super::tuning::{NEAR_ITERATIONS, NOTHING, SMALLER};
use crate::Vector3;

/// Distributes `steps` steps over arcs in proportion to their lengths. Every arc gets at least
/// `LEAST_STEPS`, even if the total then exceeds `steps`.
pub(crate) fn shares(lengths: &[f64], steps: usize) -> Vec<usize> {
    let total: f64 = lengths.iter().sum();
    let mut counts: Vec<usize> =
        lengths.iter().map(|length| ((length / total * steps as f64) as usize).max(LEAST_STEPS)).collect();
    loop {
        let sum: usize = counts.iter().sum();
        // The arc with the longest steps gets one more; the arc with the shortest steps loses one.
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

/// Places arcs on a grid with the given number of steps for each; arcs with no steps are omitted.
pub(crate) fn of_arcs(extremal: &Extremal, arcs: &Arcs, counts: &[usize]) -> OnGrid {
    let (mut lengths, mut steps, mut nodes) = (Vec::new(), Vec::new(), vec![arcs.first]);
    let (mut all_signs, course) = (Vec::new(), Course::of(extremal, &arcs.m));
    for ((from, start, end, signs), count) in arcs.arcs().into_iter().zip(counts) {
        if *count == 0 {
            continue;
        }
        let law = extremal.on_arc(&signs);
        let part = 1.0 / *count as f64;
        let mut node = from;
        for _ in 0..*count {
            node = course.reached(&node, (end - start) * part, |_, e| law.at(e));
            nodes.push(node);
            steps.push(Step { arc: lengths.len(), part, torque: Torque::Arc(law) });
        }
        lengths.push(end - start);
        all_signs.push(signs);
    }
    OnGrid::new(arcs.m, lengths, steps, all_signs, nodes)
}

/// Arrangement of arcs on a grid; it is revised after each solution of the discrete problem.
///
/// If two inputs switch together, as at the middle of a rest-to-rest maneuver, the arc between them
/// stays in the equations with zero length, because without it the costates would not be
/// determined. If its length is negative in the solution, the two inputs switch in the other order.
/// If it is negative in both orders, the optimum of the grid has both switches at one node, and the
/// arc is omitted.
pub(super) struct Layout {
    lengths: Vec<f64>,
    common: Vec<bool>,
    exchanged: Vec<bool>,
    /// For each arc, true if the arc is omitted because the switches at its ends are joined.
    pub joined: Vec<bool>,
}

impl Layout {
    pub fn of(arcs: &Arcs) -> Self {
        let lengths = arcs.lengths();
        let common = lengths.iter().map(|length| length.abs() < NOTHING * arcs.duration).collect();
        let none = vec![false; lengths.len()];
        Self { lengths, common, exchanged: none.clone(), joined: none }
    }

    /// Returns the number of steps of every arc. If `steps` is too small, the error is the number
    /// of steps that the arcs need.
    pub fn counts(&self, steps: usize) -> Result<Vec<usize>, usize> {
        let all = 0..self.lengths.len();
        let is_proper = |arc: &usize| !self.common[*arc] && !self.joined[*arc];
        let proper: Vec<f64> = all.clone().filter(is_proper).map(|arc| self.lengths[arc]).collect();
        if proper.len() * LEAST_STEPS > steps {
            return Err(proper.len() * LEAST_STEPS);
        }
        let mut shares = shares(&proper, steps).into_iter();
        let of_arc = |arc: usize| match (self.joined[arc], self.common[arc]) {
            (true, _) => Some(0),
            (false, true) => Some(1),
            (false, false) => shares.next(),
        };
        Ok(all.filter_map(of_arc).collect())
    }

    /// Returns the indices of the arcs that have steps.
    pub fn kept(&self) -> Vec<usize> {
        (0..self.lengths.len()).filter(|arc| !self.joined[*arc]).collect()
    }

    /// Returns whether an arc is the first or the last.
    pub fn is_outer(&self, arc: usize) -> bool {
        arc == 0 || arc + 1 == self.lengths.len()
    }

    /// Exchanges the switches at both ends of an arc with negative length. If they have been
    /// exchanged before, or the arc is the first or last one, omits the arc instead. Returns
    /// whether the switches were exchanged.
    pub fn mend(&mut self, arc: usize, arcs: &mut Arcs) -> bool {
        let exchanges = !self.exchanged[arc] && !self.is_outer(arc);
        if exchanges {
            self.exchanged[arc] = true;
            let (before, after) = (arcs.switches[arc - 1].input, arcs.switches[arc].input);
            (arcs.switches[arc - 1].input, arcs.switches[arc].input) = (after, before);
        } else {
            self.joined[arc] = true;
        }
        exchanges
    }
}

/// Solves for the discrete optimum of arcs on `steps` steps; `None` if none is found.
pub(crate) fn arcs_on_grid(extremal: &Extremal, arcs: &Arcs, steps: usize) -> Option<OnGrid> {
    let (mut arcs, mut layout) = (arcs.clone(), Layout::of(arcs));
    for _ in 0..MOST_CORRECTIONS {
        let found = of_arcs(extremal, &arcs, &layout.counts(steps).ok()?).solve(extremal)?;
        let Some(negative) = found.shorter_than_nothing() else {
            return Some(found);
        };
        layout.mend(layout.kept()[negative], &mut arcs);
    }
    None
}

/// Solves for the discrete optimum of the smoothed problem on a uniform grid of `steps` steps. Also
/// returns its ε: the smallest for which Newton converges, at least `least`.
pub(crate) fn smooth_on_grid(
    extremal: &Extremal,
    smooth: &Smoothed,
    least: f64,
    steps: usize,
) -> Option<(OnGrid, f64)> {
    let start = of_smooth(extremal, smooth, steps);
    // The direction of a torque of given norm turns smoothly; inputs jump, and so does a norm that
    // has a price.
    let jumps = matches!(extremal.law, TorqueLimit::Inputs(_)) || extremal.counts_fuel();
    let wish = if jumps { smooth.epsilon.max(FOLLOWED / steps as f64) } else { smooth.epsilon };
    let at = |grid: &OnGrid, epsilon: f64, most: usize| {
        let mut grid = grid.clone();
        for step in &mut grid.steps {
            step.torque = Torque::Smooth(epsilon);
        }
        grid.newton(1, ON_THE_WAY * epsilon, most, extremal)
    };
    let mut known = vec![(at(&start, wish, MOST_ITERATIONS)?, wish)];
    while let Some((found, epsilon)) = known.last()
        && *epsilon > least
    {
        let next = (SMALLER * epsilon).max(least);
        let Some(better) = at(found, next, NEAR_ITERATIONS) else { break };
        known.push((better, next));
    }
    // Solves to round-off; if the last ε does not converge, the previous one is used.
    known.into_iter().rev().find_map(|(found, epsilon)| Some((found.solve(extremal)?, epsilon)))
}

/// Places a smoothed extremal on a uniform grid.
pub(crate) fn of_smooth(extremal: &Extremal, smooth: &Smoothed, steps: usize) -> OnGrid {
    let path = &smooth.path;
    let course = Course::of(extremal, &path.m);
    let part = 1.0 / steps as f64;
    // Each node is integrated from the nearest earlier node of the path, over a short time.
    let node = |k: usize| -> Node {
        let (index, share) = path.interval_at(k as f64 / steps as f64);
        let length = share * (path.parts[index + 1] - path.parts[index]) * path.duration;
        let law = |_: f64, e: &Vector3| extremal.smooth(e, smooth.epsilon, &Vector3::zeros());
        course.reached(&path.nodes[index], length, law)
    };
    let nodes = (0..=steps).map(node).collect();
    let step = Step { arc: 0, part, torque: Torque::Smooth(smooth.epsilon) };
    OnGrid::new(path.m, vec![path.duration], vec![step; steps], Vec::new(), nodes)
}
