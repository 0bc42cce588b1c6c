//! Evaluation of one stage at a point: its motion, rows, cost and defect.

use super::super::program::{Point, Shape};
use super::space::Space;
use super::{Bound, ChainProgram, Row};
use crate::lie;
use crate::mechanics::environment::{Pose, Wrench};
use crate::optimize::chain::model::step;
use crate::optimize::chain::rows::{Bend, Cone, ConeAt, What};
use crate::optimize::discrete::step::GyrostatDrift;
use crate::{Matrix3, Vector3};

/// Values of one stage.
pub(super) struct Stage {
    pub pose: Pose,
    pub stretch: f64,
    /// Weight of the kick: the scaled time over which its forces act.
    pub weight: f64,
    /// Weight of the part of the kick up to the physical state.
    pub physical: f64,
    /// Force and moment of the environment, scaled by the square of the duration of the point.
    pub field: Wrench,
    /// Force and torque of the inputs.
    pub given: Wrench,
    /// Angular momentum after the kick.
    pub momentum: Vector3,
    /// Linear momentum after the kick.
    pub linear: Vector3,
    /// Momentum of the wheels after the kick.
    pub carried: Vector3,
    /// Physical angular velocity at the node.
    pub rate: Vector3,
    /// Drift to the next node; `None` at the last node.
    pub drift: Option<GyrostatDrift>,
    /// Rotation `F` of the drift.
    pub turned: Matrix3,
    /// Rotation vector `log F` of the drift.
    pub arc: Vector3,
    /// Angular momentum after the drift.
    pub momentum_after: Vector3,
    /// Attitude after the drift.
    pub attitude_after: Matrix3,
    /// Position after the drift.
    pub position_after: Vector3,
}

impl ChainProgram<'_> {
    /// Evaluates stage k; `None` if its duration is not positive or its implicit equation has no
    /// solution. Stores the inputs of the chain and the wheel momenta after the kick in `space`.
    pub(super) fn stage(&self, at: &Point, k: usize, space: &mut Space) -> Option<Stage> {
        let Shape { m, coordinates: c, .. } = self.shape;
        let model = self.model;
        let from = &at.states[k * c..][..c];
        let body = if model.zeta() == 6 { 6 } else { 0 };
        let vector = |at: usize| Vector3::new(from[at], from[at + 1], from[at + 2]);
        let attitude = Matrix3::from_column_slice(&from[body..body + 9]);
        let (position, linear) =
            if body > 0 { (vector(0), vector(3)) } else { (Vector3::zeros(), Vector3::zeros()) };
        let pose = Pose { position, attitude };
        let momentum = vector(body + 9);
        let wheels = &from[body + 12..][..model.wheels];
        let stretch = from[body + 12 + model.wheels];
        if !(stretch > 0.0 && stretch.is_finite()) {
            return None;
        }
        space.inputs.fill(0.0);
        for (lane, w) in self.lanes.iter().zip(&at.inputs[k * m..][..m]) {
            space.inputs[lane.input] += lane.factor * w;
        }
        let (weight, lag) = (model.kick_weight(k), model.lag(k));
        let physical = if k == 0 { 0.0 } else { weight - lag };
        let mut given = Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
        let (axes, first) = model.channel(false);
        for (axis, u) in axes.iter().zip(&space.inputs[first..]) {
            given.moment += axis * *u;
        }
        if model.turning(false).is_some() {
            given.moment = attitude.tr_mul(&given.moment);
        }
        let (axes, _) = model.channel(true);
        for (axis, u) in axes.iter().zip(&space.inputs) {
            given.force += axis * *u;
        }
        if model.turning(true).is_some() {
            given.force = attitude * given.force;
        }
        let squared = stretch * stretch;
        let mut field = Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
        if !model.is_free() {
            let found = model.dynamics.environment_wrench(&pose);
            field = Wrench { force: found.force * squared, moment: found.moment * squared };
        }
        let mut moment = field.moment;
        let (mut carried, mut carried_physical) = (Vector3::zeros(), Vector3::zeros());
        if model.wheels > 0 {
            let (axes, first) = model.channel(false);
            for (wheel, (axis, stored)) in axes.iter().zip(wheels).enumerate() {
                let u = space.inputs[first + wheel];
                space.wheels[wheel] = stored - weight * u;
                carried += axis * space.wheels[wheel];
                carried_physical += axis * (stored - physical * u);
            }
        } else {
            moment += given.moment;
        }
        let after = momentum + moment * weight;
        let rate = model.dynamics.j_inverse * (momentum + moment * physical - carried_physical);
        let linear = linear + (field.force + given.force) * if body > 0 { weight } else { 0.0 };
        let mut stage = Stage {
            pose,
            stretch,
            weight,
            physical,
            field,
            given,
            momentum: after,
            linear,
            carried,
            rate,
            drift: None,
            turned: Matrix3::identity(),
            arc: Vector3::zeros(),
            momentum_after: after,
            attitude_after: attitude,
            position_after: position,
        };
        if k < model.steps {
            let drift = model.dynamics.gyrostat_drift(k, &after, &carried).ok()?;
            let h = model.dynamics.grid.step(k);
            stage.turned = drift.f;
            stage.arc = lie::log(&drift.f);
            stage.momentum_after = drift.momentum_after;
            stage.attitude_after = attitude * drift.f;
            let passed = step::frame_rate(model);
            if passed != Vector3::zeros() {
                stage.attitude_after = lie::exp(&(passed * (-h * stretch))) * stage.attitude_after;
            }
            stage.position_after = position + linear * h;
            stage.drift = Some(drift);
        }
        Some(stage)
    }

    /// Returns the value of a row at its stage.
    pub(super) fn value(&self, row: &Row, k: usize, at: &Point, stage: &Stage, space: &Space) -> f64 {
        let Shape { m, coordinates: c, .. } = self.shape;
        let model = self.model;
        if let (Bound::Roll(side), Some(family)) = (row.bound, self.family) {
            return side * at.states[(k + 1) * c - 1] / family.within() - 1.0;
        }
        let what = &self.limits.rows[row.row].what;
        if let Bound::Side(lane) = row.bound {
            return -at.inputs[k * m + lane];
        }
        if let Bound::Norm(index) = row.bound {
            let norm = &self.norms[index];
            let sigma = at.inputs[k * m + norm.place];
            let squared = self.burnt(norm, &space.inputs).norm_squared() + self.round.get();
            // NaN, because for a negative σ the inequality would hold.
            return if sigma > 0.0 { 0.5 * (squared / sigma - sigma) } else { f64::NAN };
        }
        let s = stage.stretch;
        match what {
            What::InputSize { input, sign, limit } => sign * space.inputs[*input] / limit - s * s,
            What::InputRate { input, sign, limit } => {
                let before = at.states[k * c + self.held() + input] * self.units[*input];
                sign * (space.inputs[*input] - before) / limit - s * s * s
            }
            What::InputNorm { forces, limit } => {
                let norm = if *forces { stage.given.force } else { stage.given.moment }.norm_squared();
                0.5 * (norm / (limit * s * s).powi(2) - 1.0)
            }
            What::RateNorm { arc, limit } => {
                0.5 * (self.rate(*arc, k, stage).norm_squared() / (limit * s).powi(2) - 1.0)
            }
            What::RateAxis { arc, axis, sign, limit } => sign * self.rate(*arc, k, stage)[*axis] / limit - s,
            What::Wheel { wheel, sign, limit } => {
                let u = space.inputs[model.forces + wheel];
                sign * (space.wheels[*wheel] + (stage.weight - stage.physical) * u) / limit - s
            }
            What::Cone(cone) => {
                // An inactive cone gets a value far from its bound.
                let equation = what.is_equation();
                self.cone_value(cone, k, stage).unwrap_or(if equation { 0.0 } else { -1.0 })
            }
            What::Push { .. } | What::Burn { .. } | What::BurnOfNorm { .. } => -1.0,
        }
    }

    pub(super) fn cone_at(&self, cone: &Cone, k: usize, stage: &Stage) -> Option<ConeAt> {
        self.cone_in(cone, k, stage, stage.stretch)
    }

    /// Evaluates the row of a cone for the duration `stretch`, as a multiple of the stated one.
    pub(super) fn cone_in(&self, cone: &Cone, k: usize, stage: &Stage, stretch: f64) -> Option<ConeAt> {
        let arc = cone.is_of_arc().then_some(&stage.arc);
        cone.met(self.model, k, (&stage.pose.attitude, stretch), arc, true)
    }

    /// Evaluates the row of a cone; if `bent`, with its second derivatives.
    pub(super) fn cone_bent(
        &self,
        cone: &Cone,
        k: usize,
        stage: &Stage,
        bent: bool,
    ) -> Option<(ConeAt, Option<Bend>)> {
        if !bent {
            return self.cone_at(cone, k, stage).map(|found| (found, None));
        }
        let arc = cone.is_of_arc().then_some(&stage.arc);
        let (found, bend) = cone.bent(self.model, k, (&stage.pose.attitude, stage.stretch), arc)?;
        Some((found, Some(bend)))
    }

    pub(super) fn cone_value(&self, cone: &Cone, k: usize, stage: &Stage) -> Option<f64> {
        let arc = cone.is_of_arc().then_some(&stage.arc);
        cone.value(self.model, k, (&stage.pose.attitude, stage.stretch), arc)
    }

    /// Returns the mean angular velocity of the arc after the node if `arc` is true, otherwise the
    /// angular velocity at the node.
    pub(super) fn rate(&self, arc: bool, k: usize, stage: &Stage) -> Vector3 {
        if arc { stage.arc / self.model.dynamics.grid.step(k) } else { stage.rate }
    }

    /// Returns the cost of the inputs of a stage.
    pub(super) fn cost(&self, k: usize, at: &Point, stage: &Stage, space: &Space) -> f64 {
        let (model, m) = (self.model, self.shape.m);
        if k < model.first_input() {
            return 0.0;
        }
        let mut cost = 0.0;
        for (column, own) in model.weight.column_iter().zip(&space.inputs) {
            let slope: f64 = column.iter().zip(&space.inputs).map(|(w, u)| w * u).sum();
            cost += 0.5 * slope * own;
        }
        cost *= model.effort_weight(k, stage.stretch);
        for pull in model.pulls_of(k) {
            cost += 0.5 * pull.weight * (space.inputs[pull.input] - pull.at).powi(2);
        }
        if let Some(fuel) = &model.fuel {
            let burnt = self.lanes.iter().zip(&at.inputs[k * m..]);
            let burnt = burnt.filter(|(lane, _)| !fuel.is_of_norm(lane.input < model.forces));
            let mut rate: f64 = burnt.map(|(lane, w)| fuel.inputs[lane.input] * lane.factor.abs() * w).sum();
            rate += self.norms.iter().map(|norm| norm.price * at.inputs[k * m + norm.place]).sum::<f64>();
            cost += model.kick_weight(k) * rate / stage.stretch;
        }
        cost * self.scale
    }

    /// Computes the defect of stage k: the end of its step minus the next state.
    pub(super) fn defect(&self, k: usize, at: &Point, stage: &Stage, space: &Space, out: &mut [f64]) {
        let (model, c) = (self.model, self.shape.coordinates);
        let next = &at.states[(k + 1) * c..][..c];
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(next[at], next[at + 1], next[at + 2]);
        if zeta == 6 {
            out[..3].copy_from_slice((stage.position_after - vector(0)).as_slice());
            out[3..6].copy_from_slice((stage.linear - vector(3)).as_slice());
        }
        let attitude = Matrix3::from_column_slice(&next[zeta..zeta + 9]);
        let off = lie::minus(&stage.attitude_after, &attitude);
        out[zeta..zeta + 3].copy_from_slice(off.as_slice());
        out[pi..pi + 3].copy_from_slice((stage.momentum_after - vector(zeta + 9)).as_slice());
        for wheel in 0..model.wheels {
            out[6 + wheel] = space.wheels[wheel] - next[zeta + 12 + wheel];
        }
        if let Some(duration) = model.duration {
            out[duration] = (stage.stretch / next[zeta + 12 + model.wheels]).ln();
        }
        for input in 0..self.before {
            out[model.n + input] = space.inputs[input] / self.units[input] - next[self.held() + input];
        }
        if let Some(roll) = self.roll {
            out[roll] = at.states[(k + 1) * c - 1] - next[c - 1];
        }
    }
}
