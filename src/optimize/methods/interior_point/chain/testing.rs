//! Access to a program for tests.

use super::super::program::{Increment, Point, Program, Shape, Values};
use super::ChainProgram;
use crate::Matrix3;
use crate::optimize::chain::rows::What;

impl ChainProgram<'_> {
    /// Returns the factor from the cost of the chain to the cost of the program.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the rows of the program, each with the index of the corresponding row of the chain.
    pub fn of_rows(&self) -> impl Iterator<Item = (usize, usize)> {
        self.rows.iter().map(|row| row.row).enumerate()
    }

    /// Returns the quantity that a row of the chain bounds.
    pub fn what(&self, row: usize) -> &What {
        &self.limits.rows[self.rows[row].row].what
    }

    /// Returns the attitude of a family's end at the duration and roll of a point.
    pub fn end_at(&self, at: &Point) -> Matrix3 {
        let last = &at.states[self.shape.stages * self.shape.coordinates..];
        let stretch = last[self.model.zeta() + 12 + self.model.wheels];
        self.end(stretch, last[self.shape.coordinates - 1]).unwrap().attitude
    }

    /// Reduces every fuel variable to its lower bound, the norm of the inputs of its set.
    pub fn burn_no_more(&self, at: &mut Point) {
        let m = self.shape.m;
        for inputs in at.inputs.chunks_exact_mut(m) {
            let mut own = vec![0.0; self.model.m];
            self.lanes.iter().zip(inputs.iter()).for_each(|(lane, w)| own[lane.input] += lane.factor * w);
            for norm in &self.norms {
                inputs[norm.place] = self.burnt(norm, &own).norm();
            }
        }
    }

    /// Replaces the states by the simulation of the inputs.
    pub fn follow(&self, at: &mut Point) {
        let Shape { n, coordinates: c, .. } = self.shape;
        let mut values = Values::of(&self.shape);
        for k in 0..self.shape.stages {
            for _ in 0..2 {
                assert!(self.values(at, &mut values));
                let mut by = Increment::of(&self.shape);
                by.states[(k + 1) * n..][..n].copy_from_slice(&values.defects[k * n..][..n]);
                let mut next = Point::of(&self.shape);
                self.moved(at, &by, 1.0, &mut next);
                at.states[(k + 1) * c..][..c].copy_from_slice(&next.states[(k + 1) * c..][..c]);
            }
        }
    }
}
