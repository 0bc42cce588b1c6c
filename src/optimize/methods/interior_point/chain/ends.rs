//! The start and the end of a chain, and the cost of time.

use super::super::program::{Derivatives, Duals, Point, Shape};
use super::family::End;
use super::{ChainProgram, POWER};
use crate::lie;
use crate::{Matrix3, Vector3};

impl ChainProgram<'_> {
    /// Writes the terminal error of a point; NaN if the family of ends does not determine the end.
    pub(super) fn terminal(&self, at: &Point, out: &mut [f64]) {
        let (model, c) = (self.model, self.shape.coordinates);
        let last = &at.states[(model.steps + 1) * c..][..c];
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(last[at], last[at + 1], last[at + 2]);
        let s = last[zeta + 12 + model.wheels];
        let target = &model.target;
        let Some(end) = self.end(s, self.roll_of(last)) else { return out.fill(f64::NAN) };
        let off = lie::minus(&Matrix3::from_column_slice(&last[zeta..zeta + 9]), &end.attitude);
        let mut momentum = vector(zeta + 9) - end.momentum * s;
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

    /// Returns the roll of a state; zero if the end has no free roll.
    fn roll_of(&self, state: &[f64]) -> f64 {
        if self.roll.is_some() { state[self.shape.coordinates - 1] } else { 0.0 }
    }

    /// Returns the cost of the duration of a point, scaled.
    pub(super) fn time(&self, at: &Point) -> f64 {
        let (model, c) = (self.model, self.shape.coordinates);
        let stretch = at.states[(model.steps + 1) * c + model.zeta() + 12 + model.wheels];
        self.scale * model.time_price * stretch
    }

    /// Writes the derivatives of start, end and cost of time; returns `false` if the end is not
    /// determined.
    pub(super) fn ends(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool {
        let Shape { n, coordinates: c, starts, .. } = self.shape;
        let model = self.model;
        let (zeta, pi, z) = (model.zeta(), model.pi(), self.shape.z());
        let target = &model.target;
        out.last_gradient.fill(0.0);
        out.last_hessian.fill(0.0);
        out.last_curvature.fill(0.0);
        out.terminal_slopes.fill(0.0);
        let last = &at.states[(model.steps + 1) * c..][..c];
        let (s, roll) = (last[zeta + 12 + model.wheels], self.roll_of(last));
        let Some(end) = self.end(s, roll) else { return false };
        let (axes, _) = model.channel(false);
        let slopes = out.terminal_slopes.chunks_exact_mut(n);
        for (slope, row) in slopes.zip(&self.given) {
            slope[*row] = 1.0;
            let (by_roll, by_time) = match *row {
                row if row >= pi => {
                    axes.iter().take(model.wheels).enumerate().for_each(|(wheel, axis)| {
                        slope[6 + wheel] = -axis[row - pi];
                    });
                    let by_time = end.momentum + end.by_time.momentum;
                    (end.by_roll.momentum[row - pi] * s, by_time[row - pi] * s)
                }
                row if row >= zeta => (end.by_roll.turn[row - zeta], end.by_time.turn[row - zeta]),
                row if row >= 3 => (0.0, target.linear_momentum[row - 3] * s),
                _ => (0.0, 0.0),
            };
            if let Some(roll) = self.roll {
                slope[roll] = -by_roll;
            }
            if let Some(duration) = model.duration {
                slope[duration] = -by_time;
            }
        }
        self.bend_end((s, roll), &end, duals, out);
        if let Some(roll) = self.roll {
            out.start_slopes[(starts - 1) * n..].fill(0.0);
            out.start_slopes[(starts - 1) * n + roll] = 1.0;
        }
        let Some(duration) = model.duration else { return true };
        let time = self.time(at);
        out.last_gradient[duration] = time;
        out.last_hessian[duration * n + duration] = (1.0 - POWER) * time;
        // The start state depends on the duration.
        let start = &mut out.start_slopes[..n];
        start.fill(0.0);
        start[duration] = 1.0;
        let first = &at.states[..c];
        start[3.min(zeta)..zeta].copy_from_slice(&first[3.min(zeta)..zeta]);
        start[pi..pi + 3 + model.wheels].copy_from_slice(&first[zeta + 9..][..3 + model.wheels]);
        let bend: f64 = (0..duration).map(|i| duals.costates[i] * start[i]).sum();
        let place = self.shape.m + duration;
        out.curvatures[place * z + place] += (1.0 - POWER) * bend;
        true
    }

    /// Writes the second derivatives of the terminal equations.
    fn bend_end(&self, (s, roll): (f64, f64), end: &End, duals: &Duals, out: &mut Derivatives) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let (mut nu, mut of_momentum, mut pushed) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (row, value) in self.given.iter().zip(&duals.terminal) {
            match *row {
                row if row >= pi => of_momentum[row - pi] = *value,
                row if row >= zeta => nu[row - zeta] = *value,
                row if row >= 3 => pushed += value * model.target.linear_momentum[row - 3],
                _ => {}
            }
        }
        let mut put = |i: usize, j: usize, value: f64| {
            out.last_curvature[i * n + j] = value;
            out.last_curvature[j * n + i] = value;
        };
        // Derivative of the weighted end with respect to the logarithm of the duration.
        let by_time = |end: &End, s: f64| {
            nu.dot(&end.by_time.turn) + s * (of_momentum.dot(&(end.momentum + end.by_time.momentum)) + pushed)
        };
        if let Some(place) = self.roll {
            let turned = nu.cross(&end.by_roll.turn) * -0.5;
            (0..3).for_each(|i| put(zeta + i, place, turned[i]));
            put(place, place, -s * of_momentum.dot(&end.bend[0]));
            if let Some(duration) = model.duration {
                let turned = 0.5 * nu.dot(&end.by_roll.turn.cross(&end.by_time.turn));
                put(place, duration, turned - s * of_momentum.dot(&(end.by_roll.momentum + end.bend[1])));
            }
        }
        let Some(duration) = model.duration else { return };
        let turned = nu.cross(&end.by_time.turn) * -0.5;
        (0..3).for_each(|i| put(zeta + i, duration, turned[i]));
        let slope = by_time(end, s);
        // The motion of a target is an arbitrary function of time: finite difference.
        let step = self.tuning.difference;
        let beside = |sign: f64| {
            let s = s * (sign * step).exp();
            self.end(s, roll).map_or(f64::NAN, |end| by_time(&end, s))
        };
        let moves = end.by_time.turn != Vector3::zeros() || end.by_time.momentum != Vector3::zeros();
        let bend = if moves {
            let bend = (beside(1.0) - beside(-1.0)) / (2.0 * step);
            if bend.is_finite() { bend } else { slope }
        } else {
            slope
        };
        put(duration, duration, POWER * slope - bend);
    }
}
