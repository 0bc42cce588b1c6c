//! From a continuous extremal to the discrete optimum on a grid.

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

/// How arcs lie on a grid, as its discrete optima tell it one after the other.
///
/// Where two inputs switch together, as rest to rest at the middle, the arc between them stays in
/// the equations with no length: without it the costates would not be determined. Where it comes
/// out negative the two switch in the other order; where it does so in both orders, the optimum of
/// the grid has them at the same node, and the arc is left out.
pub(super) struct Layout {
    lengths: Vec<f64>,
    common: Vec<bool>,
    exchanged: Vec<bool>,
    /// Left out.
    pub joined: Vec<bool>,
}

impl Layout {
    pub fn of(arcs: &Arcs) -> Self {
        let lengths = arcs.lengths();
        let common = lengths.iter().map(|length| length.abs() < NOTHING * arcs.duration).collect();
        let none = vec![false; lengths.len()];
        Self { lengths, common, exchanged: none.clone(), joined: none }
    }

    /// The steps of every arc; how many they need, where there are fewer.
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

    /// The arcs that have steps.
    pub fn kept(&self) -> Vec<usize> {
        (0..self.lengths.len()).filter(|arc| !self.joined[*arc]).collect()
    }

    /// Whether an arc is the first or the last.
    pub fn is_outer(&self, arc: usize) -> bool {
        arc == 0 || arc + 1 == self.lengths.len()
    }

    /// Has the inputs about an arc of negative length switch in the other order or, the second
    /// time, together. Whether in the other.
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

/// The discrete optimum for arcs, on `steps` steps.
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

/// The discrete optimum of the smoothed problem on `steps` equal steps, and its ε: the smallest
/// that is found, not below `least`.
pub(crate) fn smooth_on_grid(
    extremal: &Extremal,
    smooth: &Smoothed,
    least: f64,
    steps: usize,
) -> Option<(OnGrid, f64)> {
    let start = of_smooth(extremal, smooth, steps);
    // The direction of a torque of given norm turns smoothly; inputs jump, and so does a norm that
    // costs.
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
    // To all digits; where the last has none, the one before.
    known.into_iter().rev().find_map(|(found, epsilon)| Some((found.solve(extremal)?, epsilon)))
}

/// A smoothed extremal on equal steps.
pub(crate) fn of_smooth(extremal: &Extremal, smooth: &Smoothed, steps: usize) -> OnGrid {
    let path = &smooth.path;
    let course = Course::of(extremal, &path.m);
    let part = 1.0 / steps as f64;
    // From the nearest node before, so that nothing is integrated far.
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
