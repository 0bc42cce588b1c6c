//! The continuous witness: the equations of motion themselves, integrated by Verner's 9(8) pair.
//!
//! ```text
//! q̇ = ½ q ∘ (0, Ω) ,   Π̇ = (Π + μ) × Ω + M + τ ,   ẋ = γ/m ,   γ̇ = f + f_u ,   Ω = J⁻¹Π
//! ```
//! and `μ̇ = −τ` where wheels make the torque τ: under a torque linear in time, a quadratic;
//! with q the inertial attitude quaternion, and field and frame evaluated at every stage. The torque
//! jumps at the nodes of the plan, so each of its steps is an integration of its own. What is
//! integrated is the change over that step, in units of `T`, the mean moment of inertia, the mass and
//! the length of the maneuver; the sum of the changes is compensated. Rounding is then relative to
//! the changes, and the end is good to 1e-13 after 10 steps as after 10⁶.

use super::WitnessError;
use super::compensated::Compensated;
use super::motion::{Phase, Scale, angular_velocity};
use crate::mechanics::environment::{Pose, Wrench};
use crate::propagate::adaptive::integrate;
use crate::propagate::plant::{Output, Plant};
use crate::{Matrix3, Vector3, lie};
use differential_equations::methods::{Adaptive, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::ODE;
use differential_equations::tolerance::Tolerance;
use nalgebra::SVector;

/// Error allowed per unit of scaled time, relative to the speed of each change.
const TOLERANCE: f64 = 1e-14;

/// Internal steps within one step of the plan; a fraction of a turn takes one.
const MAX_STEPS: usize = 100_000;

/// Tangent and embedding: `[δq (4), δΠ (3)]`, and `[δx (3), δγ (3)]` where the body moves.
const ATTITUDE: usize = 7;
const RIGID_BODY: usize = 13;

type Verner98<const D: usize> = ExplicitRungeKutta<Ordinary, Adaptive, f64, [f64; D], 9, 16, 21>;

/// A body on its way, on SO(3) or SE(3).
pub(crate) enum Continuous<'a> {
    Attitude(Box<Propagation<'a, ATTITUDE>>),
    RigidBody(Box<Propagation<'a, RIGID_BODY>>),
}

impl<'a> Continuous<'a> {
    pub(crate) fn new(plant: &'a Plant<'a>, start: &Phase) -> Self {
        if plant.moves {
            Self::RigidBody(Box::new(Propagation::new(plant, start)))
        } else {
            Self::Attitude(Box::new(Propagation::new(plant, start)))
        }
    }

    /// From `time` over `step` \[s\], the outputs linear in time between `start` and `end`.
    pub(crate) fn advance(
        &mut self,
        time: f64,
        step: f64,
        start: &Output,
        end: &Output,
    ) -> Result<(), WitnessError> {
        match self {
            Self::Attitude(propagation) => propagation.advance(time, step, (*start, *end)),
            Self::RigidBody(propagation) => propagation.advance(time, step, (*start, *end)),
        }
    }

    /// Attitude at the end of the last step, body → inertial.
    pub(super) fn inertial_attitude(&self) -> Matrix3 {
        let quaternion = match self {
            Self::Attitude(propagation) => propagation.base.quaternion.value(),
            Self::RigidBody(propagation) => propagation.base.quaternion.value(),
        };
        lie::rotation_from_quaternion(&quaternion.data.0[0])
    }

    /// The phase at `time` \[s\], which must be the end of the last step.
    pub(crate) fn phase(&self, time: f64) -> Phase {
        match self {
            Self::Attitude(propagation) => propagation.base.phase(time),
            Self::RigidBody(propagation) => propagation.base.phase(time),
        }
    }
}

/// The motion up to the last node, and the integrator that advances it.
pub(crate) struct Propagation<'a, const D: usize> {
    base: Base<'a>,
    solver: Verner98<D>,
}

/// Phase at the last node, scaled.
struct Base<'a> {
    plant: &'a Plant<'a>,
    scale: Scale,
    /// Factors from N·m and N to scaled moment and force.
    moment_unit: f64,
    force_unit: f64,
    j: Matrix3,
    j_inverse: Matrix3,
    /// Body → inertial.
    quaternion: Compensated<4, 1>,
    momentum: Compensated<3, 1>,
    /// What the wheels store, where there are any.
    stored: Option<Compensated<3, 1>>,
    position: Compensated<3, 1>,
    linear_momentum: Compensated<3, 1>,
}

/// The changes since the last node, as an ODE in the scaled time since then.
struct Change<'a> {
    base: &'a Base<'a>,
    attitude: Matrix3,
    start: f64,
    length: f64,
    outputs: (Output, Output),
}

fn vector(y: &[f64], at: usize) -> Vector3 {
    Vector3::new(y[at], y[at + 1], y[at + 2])
}

impl Change<'_> {
    /// `∫τ dt` of body-fixed torques since the last node, scaled.
    fn spent(&self, t: f64) -> Vector3 {
        let (from, to) = (self.outputs.0.torque, self.outputs.1.torque);
        self.base.moment_unit * (t * from + 0.5 * t * t / self.length * (to - from))
    }

    /// Scaled force and moment of field and actuators after a turn `[w, v]` and a change of position.
    fn loads(&self, t: f64, w: f64, v: &Vector3, position: &Vector3) -> [Wrench; 2] {
        let Base { plant, scale, moment_unit, force_unit, .. } = self.base;
        let output = Output::between(&self.outputs.0, &self.outputs.1, t / self.length);
        let scaled = |wrench: Wrench| Wrench {
            force: *force_unit * wrench.force,
            moment: *moment_unit * wrench.moment,
        };
        if !plant.needs_pose() {
            return [Wrench::zero(), scaled(Wrench { force: output.force, moment: output.torque })];
        }
        let mut attitude = self.attitude * lie::rotation_from_quaternion(&[w, v.x, v.y, v.z]);
        if let Some(frame) = plant.to_reference((self.start + t) * scale.time) {
            attitude = frame * attitude;
        }
        let position = scale.length * (self.base.position.value() + position);
        let field = plant.field(&Pose { position, attitude });
        [scaled(field), scaled(plant.actuators(&attitude, &output))]
    }
}

impl<const D: usize> ODE<f64, [f64; D]> for Change<'_> {
    fn diff(&self, t: f64, y: &[f64; D], dydt: &mut [f64; D]) {
        let base = self.base;
        let momentum = base.momentum.value() + vector(y, 4);
        let rate = angular_velocity(&base.j, &base.j_inverse, &momentum);
        let total = base.stored.as_ref().map_or(momentum, |stored| momentum + stored.value() - self.spent(t));
        let (w, v) = (1.0 + y[0], vector(y, 1));
        let moves = D == RIGID_BODY;
        let shift = if moves { vector(y, 7) } else { Vector3::zeros() };
        let [field, actuators] = self.loads(t, w, &v, &shift);
        let momentum_dot = total.cross(&rate) + field.moment + actuators.moment;
        dydt[0] = -0.5 * v.dot(&rate);
        dydt[1..4].copy_from_slice((0.5 * (w * rate + v.cross(&rate))).as_slice());
        dydt[4..7].copy_from_slice(momentum_dot.as_slice());
        if moves {
            let velocity = base.linear_momentum.value() + vector(y, 10);
            dydt[7..10].copy_from_slice(velocity.as_slice());
            dydt[10..13].copy_from_slice((field.force + actuators.force).as_slice());
        }
    }
}

impl<'a, const D: usize> Propagation<'a, D> {
    fn new(plant: &'a Plant<'a>, start: &Phase) -> Self {
        // The crate counts steps over all integrations; ours counts them per step of the plan.
        let mut solver = Verner98::rkv988e().rtol(TOLERANCE).max_steps(usize::MAX);
        solver.atol = Tolerance::Vector(vec![TOLERANCE; D]);
        Self { base: Base::new(plant, start), solver }
    }

    fn advance(&mut self, time: f64, step: f64, outputs: (Output, Output)) -> Result<(), WitnessError> {
        let (start, length) = (time / self.base.scale.time, step / self.base.scale.time);
        let attitude = lie::rotation_from_quaternion(&self.base.quaternion.value().data.0[0]);
        let change = Change { base: &self.base, attitude, start, length, outputs };
        for (index, speed) in change.speeds(D).into_iter().enumerate() {
            self.solver.atol[index] = TOLERANCE * length * speed;
        }
        // One step over the whole length is the common case; the crate's own guess allocates.
        self.solver.h0 = length;
        let (mut part, mut rejected) = (length, 0);
        let y = integrate(&mut self.solver, &change, length, &[0.0; D], MAX_STEPS, &mut part, &mut rejected)
            .ok_or(WitnessError::Continuous { time })?;
        let spent = change.spent(length);
        self.base.add(&y);
        if let Some(stored) = &mut self.base.stored {
            stored.add(&-spent);
        }
        Ok(())
    }
}

impl Change<'_> {
    /// Sizes of the rates of change, one per component, that rounding is relative to.
    fn speeds(&self, dimension: usize) -> impl IntoIterator<Item = f64> {
        let base = self.base;
        let [field, actuators] = self.loads(0.0, 1.0, &Vector3::zeros(), &Vector3::zeros());
        let momentum = base.momentum.value();
        // Absolute values: with an ill-conditioned inertia the products cancel.
        let rate = (base.j_inverse.abs() * momentum.abs()).norm();
        let stored = base.stored.as_ref().map_or(0.0, |stored| stored.value().norm());
        let torque = (momentum.norm() + stored) * rate + field.moment.norm() + actuators.moment.norm();
        let force = field.force.norm() + actuators.force.norm();
        let speeds = [rate, torque, base.linear_momentum.value().norm(), force];
        let block = |index: usize| [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3][index];
        (0..dimension).map(move |index| 1.0 + speeds[block(index)])
    }
}

impl<'a> Base<'a> {
    fn new(plant: &'a Plant<'a>, start: &Phase) -> Self {
        let scale = Scale::of(plant.problem);
        let inertia = &plant.problem.body.inertia;
        let quaternion = lie::quaternion_from_rotation(&start.attitude);
        let linear = scale.mass * scale.length / scale.time;
        Self {
            plant,
            scale,
            moment_unit: scale.time * (scale.time / scale.inertia),
            force_unit: scale.time / linear,
            j: inertia.j() / scale.inertia,
            j_inverse: inertia.j_inverse() * scale.inertia,
            quaternion: Compensated::new(SVector::from(quaternion)),
            momentum: Compensated::new(start.momentum * (scale.time / scale.inertia)),
            stored: (plant.problem.actuation.wheels.is_some())
                .then(|| Compensated::new(start.stored * (scale.time / scale.inertia))),
            position: Compensated::new(start.position / scale.length),
            linear_momentum: Compensated::new(start.linear_momentum / linear),
        }
    }

    fn add(&mut self, y: &[f64]) {
        // q ∘ (1 + y₀, v) = q + q ∘ (y₀, v)
        let q = self.quaternion.value();
        let (w, v) = (q[0], Vector3::new(q[1], q[2], q[3]));
        let dv = vector(y, 1);
        let vector_part = w * dv + y[0] * v + v.cross(&dv);
        let turn = [w * y[0] - v.dot(&dv), vector_part.x, vector_part.y, vector_part.z];
        self.quaternion.add(&SVector::from(turn));
        self.momentum.add(&vector(y, 4));
        if y.len() == RIGID_BODY {
            self.position.add(&vector(y, 7));
            self.linear_momentum.add(&vector(y, 10));
        }
    }

    fn phase(&self, time: f64) -> Phase {
        let scale = &self.scale;
        let attitude = lie::rotation_from_quaternion(&self.quaternion.value().data.0[0]);
        Phase {
            position: scale.length * self.position.value(),
            linear_momentum: scale.mass * scale.length / scale.time * self.linear_momentum.value(),
            attitude: self.plant.to_reference(time).map_or(attitude, |frame| frame * attitude),
            momentum: scale.inertia / scale.time * self.momentum.value(),
            stored: self
                .stored
                .as_ref()
                .map_or_else(Vector3::zeros, |stored| scale.inertia / scale.time * stored.value()),
        }
    }
}
