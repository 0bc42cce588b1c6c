//! The ends of a chain, and the cost of time.

use super::super::program::{Derivatives, Duals, Point, Shape};
use super::{ChainProgram, POWER};
use crate::lie;
use crate::{Matrix3, Vector3};

impl ChainProgram<'_> {
    /// Writes the terminal error.
    pub(super) fn terminal(&self, at: &Point, out: &mut [f64]) {
        let (model, c) = (self.model, self.shape.coordinates);
        let last = &at.states[(model.steps + 1) * c..][..c];
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(last[at], last[at + 1], last[at + 2]);
        let s = last[zeta + 12 + model.wheels];
        let target = &model.target;
        let off = lie::minus(&Matrix3::from_column_slice(&last[zeta..zeta + 9]), &target.attitude);
        let mut momentum = vector(zeta + 9) - target.momentum * s;
        let (axes, _) = model.channel(false);
        for (axis, stored) in axes.iter().zip(&last[zeta + 12..][..model.wheels]) {
            momentum -= axis * *stored;
        }
        for (to, row) in out.iter_mut().zip(&self.given) {
            *to = match *row {
                row if row >= pi => momentum[row - pi],
                row if row >= zeta => off[row - zeta],
                row if row >= 3 => last[row] - target.linear_momentum[row - 3] * s,
                row => last[row] - target.position[row],
            };
        }
    }

    /// Returns the cost of time.
    pub(super) fn time(&self, at: &Point) -> f64 {
        let c = self.shape.coordinates;
        let stretch = at.states[(self.model.steps + 2) * c - self.before - 1];
        self.scale * self.model.time_price * stretch
    }

    /// Writes the derivatives of start, end and the cost of time.
    pub(super) fn ends(&self, at: &Point, duals: &Duals, out: &mut Derivatives) {
        let Shape { n, coordinates: c, .. } = self.shape;
        let model = self.model;
        let (zeta, pi, z) = (model.zeta(), model.pi(), self.shape.z());
        let target = &model.target;
        out.last_gradient.fill(0.0);
        out.last_hessian.fill(0.0);
        out.last_curvature.fill(0.0);
        out.terminal_slopes.fill(0.0);
        let s = at.states[(model.steps + 1) * c + zeta + 12 + model.wheels];
        let (axes, _) = model.channel(false);
        let mut bend = 0.0;
        let slopes = out.terminal_slopes.chunks_exact_mut(n);
        for ((slope, row), nu) in slopes.zip(&self.given).zip(&duals.terminal) {
            slope[*row] = 1.0;
            let momentum = match *row {
                row if row >= pi => {
                    axes.iter().take(model.wheels).enumerate().for_each(|(wheel, axis)| {
                        slope[6 + wheel] = -axis[row - pi];
                    });
                    target.momentum[row - pi]
                }
                row if row >= 3 && row < zeta => target.linear_momentum[row - 3],
                _ => 0.0,
            };
            if let Some(duration) = model.duration {
                slope[duration] = -momentum * s;
                bend -= nu * momentum * s;
            }
        }
        let Some(duration) = model.duration else { return };
        out.last_curvature[duration * n + duration] = (1.0 - POWER) * bend;
        let time = self.time(at);
        out.last_gradient[duration] = time;
        out.last_hessian[duration * n + duration] = (1.0 - POWER) * time;
        // The start goes with the duration.
        let start = &mut out.start_slopes[..n];
        start.fill(0.0);
        start[duration] = 1.0;
        let first = &at.states[..c];
        start[3.min(zeta)..zeta].copy_from_slice(&first[3.min(zeta)..zeta]);
        start[pi..pi + 3 + model.wheels].copy_from_slice(&first[zeta + 9..][..3 + model.wheels]);
        let bend: f64 = (0..duration).map(|i| duals.costates[i] * start[i]).sum();
        let place = self.shape.m + duration;
        out.curvatures[place * z + place] += (1.0 - POWER) * bend;
    }
}
