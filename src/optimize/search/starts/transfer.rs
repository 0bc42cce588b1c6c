//! Transfer between grids: a solution on a coarse grid becomes the initial guess on a fine grid.

use crate::Vector3;
use crate::lie;
use crate::mechanics::environment::Pose;
use crate::numerics::hermite::hermite;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::ChainState;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::chain::{Chain, iterate, multipliers, with_iterate};
use crate::optimize::chain::{Multipliers, first_iterate};
use crate::optimize::discrete::candidate::Candidate;
use nalgebra::DVector;

/// Returns a candidate on the second of two grids, from an optimum on the first.
pub fn transfer(grids: [&Chain; 2], found: &Candidate) -> Candidate {
    let [coarse, fine] = grids.map(|chain| &chain.model);
    let (known, multipliers) = (iterate(found), multipliers(found));
    let between = |stage: usize| between([coarse.steps, fine.steps], stage);
    let states = &known.states;
    let poses = Interpolant::of(states.iter().map(ChainState::pose).collect()).on(fine.steps);
    let path = first_iterate::states_along(fine, &poses, known.stretch());
    let mut start = Iterate { states: path, inputs: vec![vec![0.0; fine.m]; fine.steps + 1] };
    for (stage, state) in start.states.iter_mut().enumerate() {
        let (low, share) = between(stage);
        state.wheels = &states[low].wheels * (1.0 - share) + &states[low + 1].wheels * share;
    }
    // Inputs of the coarse solution are smoother than inputs derived from its piecewise path.
    for stage in fine.first_input()..=fine.steps {
        let (low, share) = between(stage);
        let low = low.max(coarse.first_input());
        let (a, b) = (&known.inputs[low], &known.inputs[(low + 1).min(coarse.steps)]);
        start.inputs[stage] = a.iter().zip(b).map(|(a, b)| a + (b - a) * share).collect();
    }
    let costates: Vec<DVector<f64>> = (0..=fine.steps)
        .map(|stage| {
            let (low, share) = between(stage);
            let (a, b) = (&multipliers.costates[low], &multipliers.costates[low + 1]);
            a + (b - a) * share
        })
        .collect();
    let multipliers =
        Multipliers { costates, rows: carried(grids, &multipliers.rows), terminal: multipliers.terminal };
    with_iterate(found.clone().on_grid(&fine.dynamics.grid), start, multipliers)
}

/// Returns the position of a node of one grid on another grid: the index of the step, and the
/// fraction of the step.
fn between([from, to]: [usize; 2], node: usize) -> (usize, f64) {
    let at = (node as f64 * (from as f64 / to as f64)).min(from as f64);
    let low = (at.floor() as usize).min(from - 1);
    (low, at - low as f64)
}

/// A path with continuous rates through the nodes of a coarse path: cubic Hermite interpolation on
/// each step, of the rotation vector from its first node.
pub struct Interpolant {
    nodes: Vec<Pose>,
    /// Rotation vector from each node to the next.
    turns: Vec<Vector3>,
    /// Displacement from each node to the next.
    ways: Vec<Vector3>,
}

impl Interpolant {
    pub fn of(nodes: Vec<Pose>) -> Self {
        let turns = nodes.windows(2).map(|pair| lie::minus(&pair[1].attitude, &pair[0].attitude));
        let ways = nodes.windows(2).map(|pair| pair[1].position - pair[0].position);
        let (turns, ways) = (turns.collect(), ways.collect());
        Self { nodes, turns, ways }
    }

    /// Returns the poses at the nodes of a uniform grid of `steps` steps.
    pub fn on(&self, steps: usize) -> Vec<Pose> {
        let pose = |node: usize| {
            let (low, share) = between([self.turns.len(), steps], node);
            self.at(low, share)
        };
        (0..=steps).map(pose).collect()
    }

    /// Returns the pose at the fraction `share` of the step that begins at node `low`.
    pub fn at(&self, low: usize, share: f64) -> Pose {
        let node = &self.nodes[low];
        let turn = cubic(&self.turns, low, share);
        Pose {
            position: node.position + cubic(&self.ways, low, share),
            attitude: lie::project_to_rotation(&(node.attitude * lie::exp(&turn))),
        }
    }
}

/// Returns the displacement within a step by cubic interpolation; the rate at a node is the mean of
/// both adjacent steps.
fn cubic(ways: &[Vector3], low: usize, share: f64) -> Vector3 {
    let way = ways[low];
    let before = if low > 0 { 0.5 * (ways[low - 1] + way) } else { way };
    let after = ways.get(low + 1).map_or(way, |next| 0.5 * (way + next));
    // At the ends the rate is extrapolated.
    let before = if low > 0 { before } else { 2.0 * way - after };
    let after = if low + 1 < ways.len() { after } else { 2.0 * way - before };
    hermite(share, 1.0, [&Vector3::zeros(), &way], [&before, &after])
}

/// Returns the multipliers of the rows on the fine grid: of the corresponding row at the nearest
/// stage of the coarse grid, in proportion to the step.
fn carried([coarse, fine]: [&Chain; 2], multipliers: &[f64]) -> Vec<f64> {
    let slices = |rows: &LimitRows, steps: usize| -> Vec<std::ops::Range<usize>> {
        let first = |stage: usize| rows.rows.partition_point(|row| row.stage < stage);
        (0..=steps).map(|stage| first(stage)..first(stage + 1)).collect()
    };
    let from = slices(&coarse.rows, coarse.model.steps);
    let ratio = coarse.model.steps as f64 / fine.model.steps as f64;
    let mut out = vec![0.0; fine.rows.rows.len()];
    for (stage, slice) in slices(&fine.rows, fine.model.steps).into_iter().enumerate() {
        let near = from[(stage as f64 * ratio).round() as usize].clone();
        if near.len() == slice.len() {
            for (to, from) in slice.zip(near) {
                out[to] = ratio * multipliers[from];
            }
        }
    }
    out
}
