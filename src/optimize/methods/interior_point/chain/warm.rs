//! What a solve leaves to a later one of nearly the same maneuver, or of the same on another grid: its multipliers.

use super::super::program::{Duals, Point, Shape};
use super::ChainProgram;
use crate::optimize::discrete::candidate::Candidate;
use crate::{Matrix3, Vector3, lie};

/// Multipliers of a program, and the inputs that count the norms of sets.
#[derive(Clone, Debug)]
pub(crate) struct Warm {
    duals: Duals,
    /// `σ` of each stage and norm.
    norms: Vec<f64>,
    /// Sizes of the program.
    n: usize,
    terminal: usize,
    first_row: Vec<usize>,
    scale: f64,
}

impl ChainProgram<'_> {
    /// Returns the cost at a point whose stages exist.
    pub(super) fn cost_of(&self, at: &Point) -> f64 {
        let space = &mut *self.space.borrow_mut();
        let mut cost = self.time(at);
        for k in 0..self.shape.stages {
            let Some(stage) = self.stage(at, k, space) else { return f64::NAN };
            cost += self.cost(k, at, &stage, space);
        }
        cost
    }

    /// Returns how far a path is from that of a candidate: the largest turn between two nodes, or the difference of their durations.
    pub(super) fn apart(&self, at: &Point, from: &Candidate) -> f64 {
        let (c, zeta) = (self.shape.coordinates, self.model.zeta());
        let s = at.states[zeta + 12 + self.model.wheels];
        let mut apart = (s / from.grid.duration()).ln().abs();
        for (state, other) in at.states.chunks_exact(c).zip(&from.states) {
            let attitude = Matrix3::from_column_slice(&state[zeta..zeta + 9]);
            apart = apart.max(lie::minus(&attitude, &other.attitude.value).norm());
            if zeta == 6 {
                let moved = Vector3::from_column_slice(&state[..3]) - other.position.value;
                apart = apart.max(moved.norm());
            }
        }
        apart
    }

    /// Returns what a solution leaves to a later solve.
    pub fn left(&self, at: &Point, duals: &Duals) -> Warm {
        let Shape { m, n, terminal, .. } = self.shape;
        let of_stage = |inputs: &[f64]| self.norms.iter().map(|norm| inputs[norm.place]).collect::<Vec<_>>();
        Warm {
            duals: duals.clone(),
            norms: at.inputs.chunks_exact(m).flat_map(of_stage).collect(),
            n,
            terminal,
            first_row: self.shape.first_row.clone(),
            scale: self.scale,
        }
    }

    /// Writes multipliers, and the inputs that count norms, from those of an earlier solve, in proportion to the steps; returns `false`
    /// where that was one of another kind.
    ///
    /// Multipliers of rows are those of the nearest stage, and the others are linear between the stages.
    pub fn resume(&self, warm: &Warm, at: &mut Point, duals: &mut Duals) -> bool {
        let Shape { m, n, stages, terminal, .. } = self.shape;
        let known = warm.first_row.len() - 1;
        if warm.n != n || warm.terminal != terminal || known < 2 || stages < 2 {
            return false;
        }
        let scale = self.scale / warm.scale;
        let ratio = (known - 1) as f64 / (stages - 1) as f64;
        let fill = |to: &mut [f64], from: &[f64], size: usize| {
            for (stage, to) in to.chunks_exact_mut(size).enumerate() {
                let place = stage as f64 * ratio;
                let low = (place.floor() as usize).min(from.len() / size - 2);
                let share = (place - low as f64).min(1.0);
                for (i, to) in to.iter_mut().enumerate() {
                    let [a, b] = [low, low + 1].map(|stage| from[stage * size + i]);
                    *to = a + share * (b - a);
                }
            }
        };
        fill(&mut duals.costates, &warm.duals.costates, n);
        duals.costates.iter_mut().for_each(|value| *value *= scale);
        duals.terminal.iter_mut().zip(&warm.duals.terminal).for_each(|(to, from)| *to = scale * from);
        duals.rows.fill(0.0);
        for stage in 0..stages {
            let near = ((stage as f64 * ratio).round() as usize).min(known - 1);
            let (own, from) = (self.shape.rows_of(stage), warm.first_row[near]..warm.first_row[near + 1]);
            if own.len() == from.len() {
                let pairs = duals.rows[own].iter_mut().zip(&warm.duals.rows[from]);
                pairs.for_each(|(to, from)| *to = scale * ratio * from);
            }
        }
        let count = self.norms.len();
        if count > 0 && warm.norms.len() == count * known {
            for (stage, inputs) in at.inputs.chunks_exact_mut(m).enumerate() {
                let place = stage as f64 * ratio;
                let low = (place.floor() as usize).min(known - 2);
                let share = (place - low as f64).min(1.0);
                for (index, norm) in self.norms.iter().enumerate() {
                    let [a, b] = [low, low + 1].map(|stage| warm.norms[stage * count + index]);
                    inputs[norm.place] = a + share * (b - a);
                }
            }
        }
        true
    }
}
