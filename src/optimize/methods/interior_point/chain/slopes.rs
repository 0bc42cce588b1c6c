//! First derivatives of a stage: of its kick, its drift and its cost.

use super::super::program::{Derivatives, Duals, Point, Shape};
use super::curvature::congruent;
use super::space::{Space, both};
use super::stage::Stage;
use super::{ChainProgram, POWER};
use crate::lie::{self, hat};
use crate::mechanics::environment::Blocks;
use crate::optimize::chain::model::step;
use crate::{Matrix3, Vector3};

/// Stage with its index `k` and the point `at` at which it is evaluated.
#[derive(Clone, Copy)]
pub(super) struct Here<'a> {
    pub at: &'a Point,
    pub k: usize,
    pub stage: &'a Stage,
}

/// Derivatives of a kick with respect to the pose: the gradient of the environment, and the sum of
/// that and of the gradient of inputs whose axes rotate relative to the momenta.
struct Kick {
    gradient: Blocks,
    turned: Blocks,
    /// True if the kick depends on the pose.
    bent: bool,
}

impl ChainProgram<'_> {
    /// Writes the first derivatives of the step, rows and cost of stage k to `out`.
    pub(super) fn slopes(
        &self,
        at: &Point,
        k: usize,
        stage: &Stage,
        duals: &Duals,
        space: &mut Space,
        out: &mut Derivatives,
    ) {
        let Shape { n, .. } = self.shape;
        let (model, z) = (self.model, self.shape.z());
        let zeta = model.zeta();
        let here = Here { at, k, stage };
        let kick = self.kick(stage, space);
        let defect = &out.values.defects[k * n..][..n];
        let frame = lie::exp(&Vector3::new(defect[zeta], defect[zeta + 1], defect[zeta + 2]));
        self.drift(k, stage, &frame, space);
        self.steps(space, &mut out.steps[k * n * z..][..n * z]);
        self.costs(at, k, stage, space, out);
        self.rates(stage, &kick, space);
        let next = &duals.costates[(k + 1) * n..][..n];
        for (to, column) in space.after.iter_mut().zip(space.drift.chunks_exact(n)) {
            *to = column.iter().zip(next).map(|(a, b)| a * b).sum();
        }
        space.phi.fill(0.0);
        let sums = self.rows(&here, duals, space, out);
        // The costate after the kick, including the contributions of the rows.
        for (to, arc) in space.after.iter_mut().zip(&space.arc) {
            *to += sums.arc.dot(arc);
        }
        for i in 0..3 {
            space.after[zeta + i] += sums.attitude[i];
        }
        if let Some(duration) = model.duration {
            space.after[duration] += sums.duration;
        }
        if let Some(drift) = &stage.drift {
            self.bend_drift(k, stage, drift, (&frame, next), sums.arc, space);
            self.bend_frame(k, stage, (&frame, next), space);
        }
        let curvature = &mut out.curvatures[k * z * z..][..z * z];
        congruent(space, n, curvature);
        if kick.bent {
            let own = model.dynamics.j_inverse.tr_mul(&sums.node) * stage.physical;
            self.bend_kick(stage, &kick.gradient, own, space, curvature);
        }
        self.to_increment(k, duals, out);
    }

    /// Writes the columns of `Y`, the derivative of the kick, to `space`.
    fn kick(&self, stage: &Stage, space: &mut Space) -> Kick {
        let model = self.model;
        let (zeta, pi, weight) = (model.zeta(), model.pi(), stage.weight);
        let r = &stage.pose.attitude;
        let gradient = if model.is_free() {
            Blocks::zero()
        } else {
            model.dynamics.field(&stage.pose).1.scaled(stage.stretch * stage.stretch)
        };
        let mut turned = gradient;
        let [torques_turn, forces_turn] = [false, true].map(|forces| model.turning(forces).is_some());
        if torques_turn && model.wheels == 0 {
            turned.rr += hat(&stage.given.moment);
        }
        if forces_turn {
            turned.xr -= hat(&stage.given.force) * r;
        }
        let bent = !model.is_free() || torques_turn || forces_turn;
        space.kick.clear();
        space.kick_first.clear();
        let (torque_axes, first_torque) = model.channel(false);
        let (force_axes, _) = model.channel(true);
        for lane in &self.lanes {
            space.kick_first.push(space.kick.len());
            if let Some(index) = lane.input.checked_sub(first_torque) {
                if model.wheels > 0 {
                    space.kick.push((6 + index, -weight * lane.factor));
                } else {
                    let axis = torque_axes[index];
                    let axis = if torques_turn { r.tr_mul(&axis) } else { axis };
                    space.kick.extend((0..3).map(|i| (pi + i, weight * lane.factor * axis[i])));
                }
            }
            if let Some(axis) = force_axes.get(lane.input).filter(|_| zeta == 6) {
                let axis = if forces_turn { r * axis } else { *axis };
                space.kick.extend((0..3).map(|i| (3 + i, weight * lane.factor * axis[i])));
            }
        }
        // The fuel variables do not affect the motion.
        self.norms.iter().for_each(|_| space.kick_first.push(space.kick.len()));
        for i in 0..self.shape.n {
            space.kick_first.push(space.kick.len());
            if i >= model.n {
                continue;
            }
            space.kick.push((i, 1.0));
            let column = |block: &Matrix3, i: usize| block.column(i) * weight;
            let [moment, force] = if !bent {
                continue;
            } else if (zeta..zeta + 3).contains(&i) {
                [&turned.rr, &turned.xr].map(|block| column(block, i - zeta))
            } else if zeta == 6 && i < 3 {
                [&turned.rx, &turned.xx].map(|block| column(block, i))
            } else if Some(i) == model.duration {
                [stage.field.moment, stage.field.force].map(|acting| acting * (2.0 * weight))
            } else {
                continue;
            };
            space.kick.extend((0..3).map(|row| (pi + row, moment[row])));
            if zeta == 6 {
                space.kick.extend((0..3).map(|row| (3 + row, force[row])));
            }
        }
        space.kick_first.push(space.kick.len());
        Kick { gradient, turned, bent }
    }

    /// Writes the columns of `D`, the derivative of the drift, with the attitude rows in the
    /// tangent space of the defect, and the derivative of the arc `log F`.
    fn drift(&self, k: usize, stage: &Stage, frame: &Matrix3, space: &mut Space) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let (torque_axes, _) = model.channel(false);
        let f_t = stage.turned.transpose();
        let moving = pi..pi + 3 + model.wheels;
        let h = self.step_of(k);
        space.drift.fill(0.0);
        space.turn.fill(Vector3::zeros());
        space.arc.fill(Vector3::zeros());
        for i in 0..3 {
            space.turn[zeta + i] = f_t.column(i).into_owned();
        }
        if let Some(drift) = &stage.drift {
            for i in 0..3 {
                space.arc[pi + i] = drift.by_momentum.column(i).into_owned();
            }
            for (wheel, axis) in torque_axes.iter().take(model.wheels).enumerate() {
                space.arc[6 + wheel] = drift.by_wheels * axis;
            }
            for i in moving.clone() {
                space.turn[i] = space.arc[i];
            }
        }
        if let Some(duration) = model.duration {
            space.turn[duration] =
                -stage.attitude_after.tr_mul(&step::frame_rate(model)) * (h * stage.stretch);
        }
        for i in 0..model.n {
            let column = &mut space.drift[i * n..][..n];
            let turn = frame * space.turn[i];
            column[zeta..zeta + 3].copy_from_slice(turn.as_slice());
            let mut momentum = stage.momentum_after.cross(&space.arc[i]);
            if (pi..pi + 3).contains(&i) {
                momentum += f_t.column(i - pi);
            } else if !(zeta..zeta + 3).contains(&i) {
                column[i] = 1.0;
            }
            column[pi..pi + 3].copy_from_slice(momentum.as_slice());
            if zeta == 6 && (3..6).contains(&i) {
                column[i - 3] = h;
            }
        }
        // From the rotation to its logarithm.
        let log_slope = lie::right_jacobian_inverse(&stage.arc);
        for arc in &mut space.arc[moving] {
            *arc = log_slope * *arc;
        }
        let mut arc_by_z = std::mem::take(&mut space.arc_by_z);
        for (to, column) in arc_by_z.iter_mut().zip(space.columns()) {
            *to = column.iter().map(|(row, value)| space.arc[*row] * *value).sum();
        }
        space.arc_by_z = arc_by_z;
    }

    /// Returns the length of the step after a node; zero after the last node.
    pub(super) fn step_of(&self, k: usize) -> f64 {
        if k < self.model.steps { self.model.dynamics.grid.step(k) } else { 0.0 }
    }

    /// Writes the derivative of a step, `[B A] = D Y`: the derivative `D` of the drift times the
    /// derivative `Y` of the kick.
    fn steps(&self, space: &Space, steps: &mut [f64]) {
        let n = self.shape.n;
        for (to, column) in steps.chunks_exact_mut(n).zip(space.columns()) {
            to.fill(0.0);
            for (row, value) in column {
                for (to, from) in to.iter_mut().zip(&space.drift[row * n..][..n]) {
                    *to += value * from;
                }
            }
        }
        if self.before > 0 {
            for (place, lane) in self.lanes.iter().enumerate() {
                steps[place * n + self.model.n + lane.input] += lane.factor / self.units[lane.input];
            }
        }
        if let Some(roll) = self.roll {
            steps[(self.shape.m + roll) * n + roll] = 1.0;
        }
    }

    /// Computes the derivative of the physical angular velocity at the node.
    fn rates(&self, stage: &Stage, kick: &Kick, space: &mut Space) {
        let (model, m) = (self.model, self.shape.m);
        let (zeta, pi) = (model.zeta(), model.pi());
        let j_inverse = &model.dynamics.j_inverse;
        let (torque_axes, first_torque) = model.channel(false);
        let turns = model.turning(false).is_some() && model.wheels == 0;
        space.rate.fill(Vector3::zeros());
        for (place, lane) in self.lanes.iter().enumerate() {
            if let Some(index) = lane.input.checked_sub(first_torque) {
                let axis = torque_axes[index];
                let axis = if turns { stage.pose.attitude.tr_mul(&axis) } else { axis };
                space.rate[place] = j_inverse * axis * (stage.physical * lane.factor);
            }
        }
        for i in 0..3 {
            space.rate[m + pi + i] = j_inverse.column(i).into_owned();
            if kick.bent {
                space.rate[m + zeta + i] = j_inverse * kick.turned.rr.column(i) * stage.physical;
                if zeta == 6 {
                    space.rate[m + i] = j_inverse * kick.turned.rx.column(i) * stage.physical;
                }
            }
        }
        for (wheel, axis) in torque_axes.iter().take(model.wheels).enumerate() {
            space.rate[m + 6 + wheel] = -(j_inverse * axis);
        }
        if let Some(duration) = model.duration.filter(|_| kick.bent) {
            space.rate[m + duration] = j_inverse * stage.field.moment * (2.0 * stage.physical);
        }
    }

    /// Converts the second derivatives with respect to `ln s`, the logarithm of the duration, to
    /// second derivatives with respect to the increment of the duration.
    fn to_increment(&self, k: usize, duals: &Duals, out: &mut Derivatives) {
        let Some(duration) = self.model.duration else { return };
        let (n, z) = (self.shape.n, self.shape.z());
        let place = self.shape.m + duration;
        let next = &duals.costates[(k + 1) * n..][..n];
        let step = &out.steps[(k * z + place) * n..][..n];
        let mut slope: f64 = step.iter().zip(next).map(|(a, b)| a * b).sum();
        slope -= step[duration] * next[duration];
        for row in self.shape.rows_of(k) {
            let slopes = self.shape.slopes_of(row);
            let known = self.shape.unknowns[slopes.clone()].iter().zip(&out.slopes[slopes]);
            let own = known.filter(|(known, _)| usize::from(**known) == place);
            slope += own.map(|(_, value)| value * duals.rows[row]).sum::<f64>();
        }
        let corner = (k * z + place) * z + place;
        out.curvatures[corner] -= POWER * slope;
        out.hessians[corner] -= POWER * out.gradients[k * z + place];
    }

    /// Adds the gradient and the Hessian of the cost of a stage's inputs.
    fn costs(&self, at: &Point, k: usize, stage: &Stage, space: &Space, out: &mut Derivatives) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let gradient = &mut out.gradients[k * z..][..z];
        let hessian = &mut out.hessians[k * z * z..][..z * z];
        if k < model.first_input() {
            // The stage has no inputs: any positive weight keeps these unknowns constant.
            (0..m).for_each(|i| hessian[i * z + i] = 1.0);
            return;
        }
        let weight = model.effort_weight(k, stage.stretch) * self.scale;
        let power = f64::from(model.effort_power);
        let duration = model.duration.map(|duration| m + duration);
        let mut effort = 0.0;
        for (place, lane) in self.lanes.iter().enumerate() {
            let column = model.weight.column(lane.input);
            let slope: f64 = column.iter().zip(&space.inputs).map(|(w, u)| w * u).sum();
            gradient[place] += weight * slope * lane.factor;
            for (other, second) in self.lanes.iter().enumerate() {
                hessian[place * z + other] += weight * column[second.input] * lane.factor * second.factor;
            }
            if let Some(d) = duration.filter(|_| power != 0.0) {
                both(hessian, z, place, d, power * weight * slope * lane.factor);
            }
        }
        if let Some(d) = duration {
            for (column, own) in model.weight.column_iter().zip(&space.inputs) {
                let slope: f64 = column.iter().zip(&space.inputs).map(|(w, u)| w * u).sum();
                effort += 0.5 * weight * slope * own;
            }
            gradient[d] += power * effort;
            hessian[d * z + d] += power * power * effort;
        }
        for pull in model.pulls_of(k) {
            let weight = pull.weight * self.scale;
            let slope = weight * (space.inputs[pull.input] - pull.at);
            let own = || self.lanes.iter().enumerate().filter(|(_, lane)| lane.input == pull.input);
            for (place, lane) in own() {
                gradient[place] += slope * lane.factor;
                for (other, second) in own() {
                    hessian[place * z + other] += weight * lane.factor * second.factor;
                }
            }
        }
        if let Some(fuel) = &model.fuel {
            let each = model.kick_weight(k) * self.scale / stage.stretch;
            let own = self.lanes.iter().enumerate();
            let own = own.filter(|(_, lane)| !fuel.is_of_norm(lane.input < model.forces));
            let own = own.map(|(place, lane)| (place, fuel.inputs[lane.input] * lane.factor.abs()));
            for (place, price) in own.chain(self.norms.iter().map(|norm| (norm.place, norm.price))) {
                let price = each * price;
                gradient[place] += price;
                if let Some(d) = duration {
                    let burnt = price * at.inputs[k * m + place];
                    gradient[d] -= burnt;
                    hessian[d * z + d] += burnt;
                    both(hessian, z, place, d, -price);
                }
            }
        }
    }
}
