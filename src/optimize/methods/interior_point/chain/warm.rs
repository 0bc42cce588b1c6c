//! The warm start that a solve provides for a later solve of nearly the same maneuver on the same
//! grid: its multipliers.

use super::super::program::{Duals, Point, Shape};
use super::ChainProgram;
use crate::optimize::discrete::candidate::Candidate;
use crate::{Matrix3, Vector3, lie};

/// Multipliers of a program, and the fuel variables of its sets.
#[derive(Clone, Debug)]
pub(crate) struct Warm {
    duals: Duals,
    /// Fuel variables `σ`, for each stage and norm.
    norms: Vec<f64>,
    // Dimensions and scale of the program. The warm start can be used only for a program with equal
    // dimensions.
    n: usize,
    terminal: usize,
    first_row: Vec<usize>,
    scale: f64,
}

impl ChainProgram<'_> {
    /// Returns the cost at a point; NaN if a stage cannot be evaluated.
    pub(super) fn cost_of(&self, at: &Point) -> f64 {
        let space = &mut *self.space.borrow_mut();
        let mut cost = self.time(at);
        for k in 0..self.shape.stages {
            let Some(stage) = self.stage(at, k, space) else { return f64::NAN };
            cost += self.cost(k, at, &stage, space);
        }
        cost
    }

    /// Returns the distance between a path and the path of a candidate: the largest of the
    /// rotations \[rad\] and displacements between corresponding nodes and of the difference of the
    /// logarithms of the durations.
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

    /// Returns the warm start that a solution provides for a later solve.
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

    /// Writes the multipliers and fuel variables of an earlier solve; returns `false` if the
    /// program of that solve had another shape.
    pub fn resume(&self, warm: &Warm, at: &mut Point, duals: &mut Duals) -> bool {
        let Shape { m, n, terminal, .. } = self.shape;
        let count = self.norms.len() * self.shape.stages;
        let same = (n, terminal, count) == (warm.n, warm.terminal, warm.norms.len());
        if !same || self.shape.first_row != warm.first_row {
            return false;
        }
        let scale = self.scale / warm.scale;
        let fill =
            |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to = scale * from);
        fill(&mut duals.costates, &warm.duals.costates);
        fill(&mut duals.terminal, &warm.duals.terminal);
        fill(&mut duals.rows, &warm.duals.rows);
        let places = self.norms.iter().map(|norm| norm.place);
        let mut known = warm.norms.iter();
        for inputs in at.inputs.chunks_exact_mut(m) {
            places.clone().zip(known.by_ref()).for_each(|(place, known)| inputs[place] = *known);
        }
        true
    }
}
