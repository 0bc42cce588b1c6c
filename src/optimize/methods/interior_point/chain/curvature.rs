//! Second derivatives of a stage: of its drift, its cones and its kick.

use super::ChainProgram;
use super::space::{Space, add_symmetric, both};
use super::stage::Stage;
use crate::lie::{self, hat};
use crate::mechanics::environment::Blocks;
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::{Bend, Cone};
use crate::optimize::discrete::step::{Costate, GyrostatDrift};
use crate::{Matrix3, Vector3};
use nalgebra::SMatrix;

/// Adds `Yᵀ Φ Y` to the curvature of a stage.
pub(super) fn congruent(space: &mut Space, n: usize, curvature: &mut [f64]) {
    let mut product = std::mem::take(&mut space.phi_kick);
    let z = product.len() / n;
    for (to, column) in product.chunks_exact_mut(n).zip(space.columns()) {
        to.fill(0.0);
        for (row, value) in column {
            for (to, from) in to.iter_mut().zip(&space.phi[row * n..][..n]) {
                *to += value * from;
            }
        }
    }
    for (to, from) in curvature.chunks_exact_mut(z).zip(product.chunks_exact(n)) {
        for (to, column) in to.iter_mut().zip(space.columns()) {
            *to += column.iter().map(|(row, value)| value * from[*row]).sum::<f64>();
        }
    }
    space.phi_kick = product;
}

impl ChainProgram<'_> {
    /// Adds the second derivatives of the rotation of the reference frame, which depends on the
    /// duration.
    pub(super) fn bend_frame(
        &self,
        k: usize,
        stage: &Stage,
        (frame, next): (&Matrix3, &[f64]),
        space: &mut Space,
    ) {
        let (model, n, zeta) = (self.model, self.shape.n, self.model.zeta());
        let passed = step::frame_rate(model);
        let Some(duration) = model.duration.filter(|_| passed != Vector3::zeros()) else { return };
        let seen = stage.attitude_after.tr_mul(&passed) * (self.step_of(k) * stage.stretch);
        let mu = frame.tr_mul(&Vector3::new(next[zeta], next[zeta + 1], next[zeta + 2]));
        let across = seen.cross(&mu) * 0.5;
        for i in 0..duration {
            let value = across.dot(&space.turn[i]);
            both(&mut space.phi, n, i, duration, value);
        }
        space.phi[duration * n + duration] -= mu.dot(&seen);
    }

    /// Adds the second derivatives of the drift, weighted by the costate after it, and the second
    /// derivatives of the arc.
    pub(super) fn bend_drift(
        &self,
        k: usize,
        stage: &Stage,
        drift: &GyrostatDrift,
        (frame, next): (&Matrix3, &[f64]),
        of_arc: Vector3,
        space: &mut Space,
    ) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(next[at], next[at + 1], next[at + 2]);
        let (mu, momentum) = (frame.tr_mul(&vector(zeta)), vector(pi));
        let weighed = lie::left_jacobian_inverse(&stage.arc) * of_arc;
        let zero = Vector3::zeros();
        let after = Costate { x: zero, gamma: zero, zeta: mu + weighed, pi: momentum };
        let bend: SMatrix<f64, 9, 9> =
            model.dynamics.gyrostat_curvature(k, drift, [&stage.momentum, &stage.carried], &after);
        let (axes, _) = model.channel(false);
        let by_momentum = bend.fixed_view::<3, 3>(3, 3).into_owned();
        add_symmetric(&mut space.phi, n, pi, &by_momentum);
        let across = drift.f * hat(&mu) * 0.5;
        let mixed = (bend.fixed_view::<3, 3>(3, 6) + bend.fixed_view::<3, 3>(6, 3).transpose()) * 0.5;
        let of_wheels = bend.fixed_view::<3, 3>(6, 6).into_owned();
        let of_wheels = (of_wheels + of_wheels.transpose()) * 0.5;
        let momenta = across * drift.by_momentum;
        for i in 0..3 {
            for j in 0..3 {
                both(&mut space.phi, n, zeta + i, pi + j, -momenta[(i, j)]);
            }
        }
        let by_wheels = across * drift.by_wheels;
        for (wheel, axis) in axes.iter().take(model.wheels).enumerate() {
            let (turned, mixed, own) = (by_wheels * axis, mixed * axis, of_wheels * axis);
            for i in 0..3 {
                both(&mut space.phi, n, zeta + i, 6 + wheel, -turned[i]);
                both(&mut space.phi, n, pi + i, 6 + wheel, mixed[i]);
            }
            for (other, second) in axes.iter().take(wheel + 1).enumerate() {
                both(&mut space.phi, n, 6 + wheel, 6 + other, second.dot(&own));
            }
        }
        if of_arc == zero {
            return;
        }
        // Derivative of the arc's weight along the arc.
        let slope = lie::left_jacobian_inverse_directional(&stage.arc, &of_arc);
        // `∂(ξᵀ q) = ξᵀ ∂q`, with `ξ = J_r ∂log F`.
        let slope = lie::right_jacobian(&stage.arc).tr_mul(&slope);
        let slope = (slope + slope.transpose()) * 0.5;
        for i in pi..pi + 3 + model.wheels {
            let own = slope * space.arc[i];
            for j in pi..=i {
                both(&mut space.phi, n, i, j, space.arc[j].dot(&own));
            }
        }
    }

    /// Adds the second derivatives of a cone with respect to attitude, arc and duration.
    pub(super) fn bend_cone(
        &self,
        cone: &Cone,
        k: usize,
        stage: &Stage,
        (multiplier, bend): (f64, &Bend),
        space: &mut Space,
    ) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let bend = bend.scaled(multiplier);
        add_symmetric(&mut space.phi, n, zeta, &bend.attitude);
        let of_arc = pi..pi + if cone.is_of_arc() { 3 + model.wheels } else { 0 };
        for i in of_arc.clone() {
            let (own, turned) = (bend.arc * space.arc[i], bend.mixed * space.arc[i]);
            for j in pi..=i {
                both(&mut space.phi, n, i, j, space.arc[j].dot(&own));
            }
            for j in 0..3 {
                both(&mut space.phi, n, i, zeta + j, turned[j]);
            }
        }
        let Some(duration) = model.duration.filter(|_| !cone.stands(model)) else { return };
        // Directions are arbitrary functions of time, so their second derivatives are finite
        // differences.
        let gradient = |by: f64| self.cone_in(cone, k, stage, stage.stretch * by.exp());
        // No difference exists at a time at which the cone begins or ceases to be active.
        let (Some(plus), Some(minus)) = (gradient(self.tuning.difference), gradient(-self.tuning.difference))
        else {
            return;
        };
        let by = multiplier / (2.0 * self.tuning.difference);
        let of_attitude = (plus.by_attitude - minus.by_attitude) * by;
        let by_arc = (plus.by_arc - minus.by_arc) * by;
        for i in 0..3 {
            both(&mut space.phi, n, zeta + i, duration, of_attitude[i]);
        }
        for i in of_arc {
            both(&mut space.phi, n, i, duration, by_arc.dot(&space.arc[i]));
        }
        space.phi[duration * n + duration] += (plus.by_duration - minus.by_duration) * by;
    }

    /// Adds the second derivatives of the kick to `curvature`. The weights are the costate after
    /// the kick, plus `own` for the contribution of the physical momentum.
    pub(super) fn bend_kick(
        &self,
        stage: &Stage,
        gradient: &Blocks,
        own: Vector3,
        space: &Space,
        curvature: &mut [f64],
    ) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(space.after[at], space.after[at + 1], space.after[at + 2]);
        let momentum = vector(pi) * stage.weight + own;
        let gamma = if zeta == 6 { vector(3) * stage.weight } else { Vector3::zeros() };
        let (r, squared) = (&stage.pose.attitude, stage.stretch * stage.stretch);
        let at_zeta = m + zeta;
        if !model.is_free() {
            let zero = Vector3::zeros();
            let costate = Costate { x: zero, gamma, zeta: zero, pi: momentum };
            let bend = model.dynamics.field_curvature(&stage.pose, &costate);
            add_symmetric(curvature, z, at_zeta, &(bend.rr * squared));
            if zeta == 6 {
                add_symmetric(curvature, z, m, &(bend.xx * squared));
                for i in 0..3 {
                    for j in 0..3 {
                        let value = 0.5 * (bend.xr[(i, j)] + bend.rx[(j, i)]) * squared;
                        both(curvature, z, m + i, at_zeta + j, value);
                    }
                }
            }
            if let Some(duration) = model.duration {
                let by_turn = gradient.rr.tr_mul(&momentum) + gradient.xr.tr_mul(&gamma);
                let by_place = gradient.rx.tr_mul(&momentum) + gradient.xx.tr_mul(&gamma);
                for i in 0..3 {
                    both(curvature, z, m + duration, at_zeta + i, 2.0 * by_turn[i]);
                    if zeta == 6 {
                        both(curvature, z, m + duration, m + i, 2.0 * by_place[i]);
                    }
                }
                let power = momentum.dot(&stage.field.moment) + gamma.dot(&stage.field.force);
                curvature[(m + duration) * z + m + duration] += 4.0 * power;
            }
        }
        let in_body = r.tr_mul(&gamma);
        let sets = [
            (model.turning(false).filter(|_| model.wheels == 0), false),
            (model.turning(true).filter(|_| zeta == 6), true),
        ];
        for (set, forces) in sets {
            let Some((axes, first)) = set else { continue };
            let slope = |given: &Vector3| {
                if forces { given.cross(&in_body) } else { momentum.cross(&r.tr_mul(given)) }
            };
            let bend = if forces {
                hat(&r.tr_mul(&stage.given.force)) * hat(&in_body)
            } else {
                hat(&momentum) * hat(&stage.given.moment)
            };
            add_symmetric(curvature, z, at_zeta, &bend);
            for (place, lane) in self.lanes.iter().enumerate() {
                let axis = lane.input.checked_sub(first).and_then(|index| axes.get(index));
                let Some(axis) = axis else { continue };
                let by = slope(axis) * lane.factor;
                for i in 0..3 {
                    both(curvature, z, place, at_zeta + i, by[i]);
                }
            }
        }
    }
}
