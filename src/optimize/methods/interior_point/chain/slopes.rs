//! First derivatives of a stage, and what its rows add to the second ones.

use super::super::program::{Derivatives, Duals, Point, Shape};
use super::curvature::congruent;
use super::space::{Space, bend_limit, both};
use super::stage::Stage;
use super::{Bound, ChainProgram, POWER};
use crate::lie::{self, hat};
use crate::mechanics::environment::Blocks;
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::{Cone, What};
use crate::{Matrix3, Vector3};

/// A stage at a point.
#[derive(Clone, Copy)]
struct Here<'a> {
    at: &'a Point,
    k: usize,
    stage: &'a Stage,
}

/// How a kick changes with the pose: the gradient of what acts from outside, and the same with
/// inputs that turn against the momenta.
struct Kick {
    gradient: Blocks,
    turned: Blocks,
    /// Whether it changes at all.
    bent: bool,
}

/// A row as its derivatives are formed.
struct Bent<'a> {
    multiplier: f64,
    /// Power of the duration with which its limit grows, and `s` to that power.
    power: f64,
    grown: f64,
    /// The unknowns that it depends on, and the duration among all.
    places: &'a [u16],
    duration: Option<usize>,
}

impl Bent<'_> {
    fn is_duration(&self, place: usize) -> bool {
        Some(place) == self.duration
    }

    /// Writes the slope by each of its unknowns.
    fn slopes(&self, out: &mut [f64], of: impl Fn(usize) -> f64) {
        for (to, place) in out.iter_mut().zip(self.places) {
            *to = of(usize::from(*place));
        }
    }
}

/// Sums over the rows of a stage of multiplier times gradient: by the physical rate at the node, by
/// the arc `log F`, by the attitude and by the duration after the kick.
#[derive(Default)]
struct Sums {
    node: Vector3,
    arc: Vector3,
    attitude: Vector3,
    duration: f64,
}

impl ChainProgram<'_> {
    /// Writes the derivatives of stage k.
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
        // The costate after the kick, with what rows add.
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

    /// Writes the columns of `Y`, the derivative of the kick.
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
        // What counts fuel moves nothing.
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

    /// Writes the columns of `D`, the derivative of the drift, with the attitude's rows in the
    /// defect's tangent space, and the derivative of the arc `log F`.
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
        // From the turn to its logarithm.
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

    /// Returns the step after a node, zero after the last.
    pub(super) fn step_of(&self, k: usize) -> f64 {
        if k < self.model.steps { self.model.dynamics.grid.step(k) } else { 0.0 }
    }

    /// Writes `[B A] = D Y`.
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

    /// Writes the derivative of the physical rate at the node.
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

    /// Writes the slopes of the rows of a stage and what they add to the second derivatives;
    /// returns what they add to the gradient.
    fn rows(&self, here: &Here, duals: &Duals, space: &mut Space, out: &mut Derivatives) -> Sums {
        let (model, z) = (self.model, self.shape.z());
        let duration = model.duration.map(|duration| self.shape.m + duration);
        let block = here.k * z * z..(here.k + 1) * z * z;
        let (curvature, hessian) = (&mut out.curvatures[block.clone()], &mut out.hessians[block]);
        let mut sums = Sums::default();
        for index in self.shape.rows_of(here.k) {
            let row = &self.rows[index];
            let slopes = self.shape.slopes_of(index);
            if let (Bound::Roll(side), Some(family)) = (row.bound, self.family) {
                out.slopes[slopes].fill(side / family.within());
                continue;
            }
            let what = &self.limits.rows[row.row].what;
            let bent = Bent {
                multiplier: duals.rows[index],
                power: f64::from(what.growth()),
                grown: here.stage.stretch.powi(what.growth()),
                places: &self.shape.unknowns[slopes.clone()],
                duration,
            };
            let slopes = &mut out.slopes[slopes];
            match (row.bound, what) {
                (Bound::Side(_), _) => slopes[0] = -1.0,
                (Bound::Norm(norm), _) => self.burning(here, norm, &bent, space, (slopes, hessian)),
                (_, What::Cone(cone)) => {
                    // Where it does not act it is far from its bound.
                    let value = self.cone(here, cone, &bent, space, &mut sums, slopes);
                    let idle = if what.is_equation() { 0.0 } else { -1.0 };
                    out.values.rows[index] = value.unwrap_or(idle);
                }
                (_, What::RateAxis { .. } | What::RateNorm { .. }) => {
                    self.rate_limit(here, what, &bent, space, &mut sums, (slopes, curvature));
                }
                _ => self.input_limit(here, what, &bent, (slopes, curvature)),
            }
        }
        sums
    }

    /// Writes the slopes of a limit of inputs or wheels, and adds its curvature.
    fn input_limit(&self, here: &Here, what: &What, row: &Bent, (out, curvature): (&mut [f64], &mut [f64])) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let (stage, multiplier, power) = (here.stage, row.multiplier, row.power);
        let of_limit = -power * row.grown;
        let factor = |place: usize| self.lanes[place].factor;
        match what {
            What::InputSize { sign, limit, .. } => {
                row.slopes(
                    out,
                    |place| {
                        if row.is_duration(place) { of_limit } else { sign / limit * factor(place) }
                    },
                )
            }
            What::InputRate { input, sign, limit } => row.slopes(out, |place| {
                if row.is_duration(place) {
                    of_limit
                } else if place < m {
                    sign / limit * factor(place)
                } else {
                    -sign / limit * self.units[*input]
                }
            }),
            What::Wheel { sign, limit, .. } => row.slopes(out, |place| {
                if row.is_duration(place) {
                    of_limit
                } else if place < m {
                    -stage.physical * sign / limit * factor(place)
                } else {
                    sign / limit
                }
            }),
            What::InputNorm { forces, limit } => {
                let size = limit * row.grown;
                let given = if *forces { stage.given.force } else { stage.given.moment } / size;
                let (axes, first) = model.channel(*forces);
                let turns = model.turning(*forces).is_some();
                let r = &stage.pose.attitude;
                let axis = |place: usize| -> Vector3 {
                    let lane = self.lanes[place];
                    let axis = lane.input.checked_sub(first).and_then(|index| axes.get(index));
                    let axis = axis.copied().unwrap_or_else(Vector3::zeros) * (lane.factor / size);
                    match (turns, *forces) {
                        (false, _) => axis,
                        (true, true) => r * axis,
                        (true, false) => r.tr_mul(&axis),
                    }
                };
                row.slopes(out, |place| {
                    if row.is_duration(place) {
                        -power * given.norm_squared()
                    } else if place < m {
                        given.dot(&axis(place))
                    } else {
                        0.0
                    }
                });
                for i in 0..self.lanes.len() {
                    for j in 0..=i {
                        both(curvature, z, i, j, multiplier * axis(i).dot(&axis(j)));
                    }
                    if let Some(d) = row.duration {
                        both(curvature, z, i, d, -2.0 * power * multiplier * given.dot(&axis(i)));
                    }
                }
                let bend = 2.0 * power * power * multiplier * given.norm_squared();
                bend_limit(curvature, z, row.duration, bend);
                return;
            }
            _ => return,
        }
        bend_limit(curvature, z, row.duration, multiplier * power * of_limit);
    }

    /// Writes the slopes of the row of a norm. The row is convex, so its second derivatives belong
    /// to the Hessian that Gauss–Newton keeps.
    fn burning(
        &self,
        here: &Here,
        norm: usize,
        row: &Bent,
        space: &Space,
        (out, hessian): (&mut [f64], &mut [f64]),
    ) {
        let (m, z) = (self.shape.m, self.shape.z());
        let norm = &self.norms[norm];
        let sigma = here.at.inputs[here.k * m + norm.place];
        let burnt = self.burnt(norm, &space.inputs) / sigma;
        let squared = burnt.norm_squared() + self.round.get() / (sigma * sigma);
        let (axes, first) = self.model.channel(norm.forces);
        let axis = |place: usize| {
            let lane = self.lanes[place];
            axes[lane.input - first] * (lane.factor / norm.limit)
        };
        let by = row.multiplier / sigma;
        row.slopes(
            out,
            |place| {
                if place == norm.place { -0.5 * (squared + 1.0) } else { burnt.dot(&axis(place)) }
            },
        );
        for (index, place) in row.places.iter().enumerate() {
            let place = usize::from(*place);
            if place == norm.place {
                both(hessian, z, place, place, by * squared);
                continue;
            }
            let own = axis(place);
            both(hessian, z, place, norm.place, -by * burnt.dot(&own));
            for other in &row.places[..=index] {
                let other = usize::from(*other);
                both(hessian, z, place, other, by * axis(other).dot(&own));
            }
        }
    }

    /// Writes the slopes of a limit of the rate at a node or on an arc, and adds its curvature.
    fn rate_limit(
        &self,
        here: &Here,
        what: &What,
        row: &Bent,
        space: &mut Space,
        sums: &mut Sums,
        (out, curvature): (&mut [f64], &mut [f64]),
    ) {
        let (model, n, z) = (self.model, self.shape.n, self.shape.z());
        let Here { k, stage, .. } = *here;
        let (multiplier, grown, h) = (row.multiplier, row.grown, self.step_of(k));
        let moving = model.pi()..model.pi() + 3 + model.wheels;
        match what {
            What::RateAxis { arc, axis, sign, limit } => {
                let (slopes, by) =
                    if *arc { (&space.arc_by_z, sign / limit / h) } else { (&space.rate, sign / limit) };
                row.slopes(out, |place| {
                    by * slopes[place][*axis] - if row.is_duration(place) { grown } else { 0.0 }
                });
                bend_limit(curvature, z, row.duration, -multiplier * grown);
                if *arc {
                    sums.arc[*axis] += multiplier * by;
                    sums.duration -= multiplier * grown;
                } else {
                    sums.node[*axis] += multiplier * by;
                }
            }
            What::RateNorm { arc: false, limit } => {
                let size = limit * grown;
                let v = stage.rate / size;
                let slope = |place: usize| {
                    let of_limit = if row.is_duration(place) { v } else { Vector3::zeros() };
                    space.rate[place] / size - of_limit
                };
                row.slopes(out, |place| v.dot(&slope(place)));
                for (index, i) in row.places.iter().enumerate() {
                    for j in &row.places[..=index] {
                        let (i, j) = (usize::from(*i), usize::from(*j));
                        let mut value = slope(i).dot(&slope(j));
                        if row.is_duration(i) || row.is_duration(j) {
                            let other = if row.is_duration(i) { j } else { i };
                            value -= if row.is_duration(other) {
                                2.0 * v.dot(&space.rate[other]) / size - v.norm_squared()
                            } else {
                                v.dot(&space.rate[other]) / size
                            };
                        }
                        both(curvature, z, i, j, multiplier * value);
                    }
                }
                sums.node += v * (multiplier / size);
            }
            What::RateNorm { arc: true, limit } => {
                let size = limit * grown * h;
                let v = stage.arc / size;
                row.slopes(out, |place| {
                    let of_limit = if row.is_duration(place) { v.norm_squared() } else { 0.0 };
                    v.dot(&space.arc_by_z[place]) / size - of_limit
                });
                for i in moving.clone() {
                    for j in moving.start..=i {
                        let value = space.arc[i].dot(&space.arc[j]) / (size * size);
                        both(&mut space.phi, n, i, j, multiplier * value);
                    }
                }
                if let Some(duration) = model.duration {
                    for i in moving {
                        let value = -2.0 * multiplier * v.dot(&space.arc[i]) / size;
                        both(&mut space.phi, n, i, duration, value);
                    }
                    space.phi[duration * n + duration] += 2.0 * multiplier * v.norm_squared();
                }
                sums.arc += v * (multiplier / size);
                sums.duration -= multiplier * v.norm_squared();
            }
            _ => {}
        }
    }

    /// Writes the slopes of a cone and returns its value, `None` where it is not active.
    fn cone(
        &self,
        here: &Here,
        cone: &Cone,
        row: &Bent,
        space: &mut Space,
        sums: &mut Sums,
        out: &mut [f64],
    ) -> Option<f64> {
        let (multiplier, first) = (row.multiplier, self.shape.m + self.model.zeta());
        out.fill(0.0);
        let felt = multiplier.abs() > self.tuning.felt;
        let (found, bend) = self.cone_bent(cone, here.k, here.stage, felt)?;
        row.slopes(out, |place| {
            let of_arc = if cone.is_of_arc() { found.by_arc.dot(&space.arc_by_z[place]) } else { 0.0 };
            let own = (first..first + 3).contains(&place);
            let of_attitude = if own { found.by_attitude[place - first] } else { 0.0 };
            of_arc + of_attitude + if row.is_duration(place) { found.by_duration } else { 0.0 }
        });
        sums.arc += found.by_arc * multiplier;
        sums.attitude += found.by_attitude * multiplier;
        sums.duration += found.by_duration * multiplier;
        if let Some(bend) = bend {
            self.bend_cone(cone, here.k, here.stage, (multiplier, &bend), space);
        }
        Some(found.c)
    }

    /// Turns the second derivatives by `ln s` into those by the duration's increment.
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

    /// Adds gradient and Hessian of the cost of the inputs of a stage.
    fn costs(&self, at: &Point, k: usize, stage: &Stage, space: &Space, out: &mut Derivatives) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let gradient = &mut out.gradients[k * z..][..z];
        let hessian = &mut out.hessians[k * z * z..][..z * z];
        if k < model.first_input() {
            // No such inputs: any weight keeps them where they are.
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
