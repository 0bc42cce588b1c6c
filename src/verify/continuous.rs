//! The continuous witness integrates the equations of motion. It uses a Taylor series if forces and
//! torques do not depend on the pose. It uses Verner's 9(8) pair for a force field, for axes fixed
//! in the reference frame, and for thrusters fixed in the body.
//!
//! ```text
//! q̇ = ½ q ∘ (0, Ω) ,   Π̇ = (Π + μ) × Ω + M + τ ,   ẋ = γ/m ,   γ̇ = f + f_u ,   Ω = J⁻¹Π
//! ```
//! and `μ̇ = −τ` for wheels with the torque τ. If the torque is linear in time, μ is quadratic. q
//! is the inertial attitude quaternion. Field and frame are evaluated at every stage. The torque
//! jumps at the nodes of the plan, so each step of the plan is one series or one integration. The
//! integrated quantity is the change over that step, in units of `T`, the mean moment of inertia,
//! the mass and the length of the maneuver. The sum of the changes is compensated. Rounding errors
//! are then relative to the changes, and the end is accurate to 1e-13 after 10 steps and after 10⁶.

use super::compensated::Compensated;
use super::motion::{Phase, Scale, angular_velocity};
use super::series::{Stretch, change};
use super::verification::WitnessError;
use crate::mechanics::environment::{Pose, Wrench};
use crate::propagate::adaptive::integrate;
use crate::propagate::plant::{Output, Plant};
use crate::{Matrix3, Vector3, lie};
use differential_equations::methods::{Adaptive, ExplicitRungeKutta, Ordinary};
use differential_equations::ode::ODE;
use differential_equations::tolerance::Tolerance;
use nalgebra::SVector;

/// Tolerance per unit of scaled time, relative to the speed of each change.
const TOLERANCE: f64 = 1e-14;

/// Maximum number of internal steps of Verner's pair within one step of the plan. A step that turns
/// the body by a fraction of a turn needs one. No step of a plan turns it by half a turn, so this
/// number suffices.
const MAX_STEPS: usize = 4096;
/// Maximum number of Taylor series within one step of the plan.
const MOST_PARTS: u32 = 4096;

/// Dimension of the integrated vector `[δq (4), δΠ (3)]` of a body that only rotates.
const ATTITUDE: usize = 7;
/// Dimension of the integrated vector `[δq (4), δΠ (3), δx (3), δγ (3)]` of a body that translates.
const RIGID_BODY: usize = 13;

type Verner98<const D: usize> = ExplicitRungeKutta<Ordinary, Adaptive, f64, [f64; D], 9, 16, 21>;

/// The continuous motion of a body on SO(3) or SE(3).
pub(crate) struct Continuous<'a> {
    base: Base<'a>,
    road: Road,
}

/// The method that computes the change over a step of the plan.
enum Road {
    /// Taylor series; `parts` is the number of parts into which the last step was divided.
    Series {
        parts: u32,
    },
    Attitude(Box<Verner98<ATTITUDE>>),
    RigidBody(Box<Verner98<RIGID_BODY>>),
}

impl<'a> Continuous<'a> {
    /// Builds the witness with the Taylor series if it applies, otherwise with Verner's pair.
    pub(crate) fn new(plant: &'a Plant<'a>, start: &Phase) -> Self {
        if plant.needs_pose() {
            Self::adaptive(plant, start)
        } else {
            Self { base: Base::new(plant, start), road: Road::Series { parts: 1 } }
        }
    }

    /// Builds the witness with Verner's pair, which applies to any forces and torques.
    pub(crate) fn adaptive(plant: &'a Plant<'a>, start: &Phase) -> Self {
        let road = if plant.moves {
            Road::RigidBody(Box::new(verner98()))
        } else {
            Road::Attitude(Box::new(verner98()))
        };
        Self { base: Base::new(plant, start), road }
    }

    /// Returns the name of the integration method.
    pub(super) fn method(&self) -> &'static str {
        match self.road {
            Road::Series { .. } => "Taylor series",
            Road::Attitude(_) | Road::RigidBody(_) => "Verner 9(8)",
        }
    }

    /// Advances from `time` over `step` \[s\]. The actuator outputs are linear in time between
    /// `start` and `end`.
    pub(crate) fn advance(
        &mut self,
        time: f64,
        step: f64,
        start: &Output,
        end: &Output,
    ) -> Result<(), WitnessError> {
        let base = &mut self.base;
        let advanced = match &mut self.road {
            Road::Series { parts } => base.expand(parts, step, start, end),
            Road::Attitude(solver) => base.integrate(solver, time, step, (*start, *end)),
            Road::RigidBody(solver) => base.integrate(solver, time, step, (*start, *end)),
        };
        advanced.ok_or(WitnessError::Continuous { time })
    }

    /// Returns the attitude at the end of the last step, from body to inertial axes.
    pub(super) fn inertial_attitude(&self) -> Matrix3 {
        lie::rotation_from_quaternion(&self.base.quaternion.value().data.0[0])
    }

    /// Returns the state at `time` \[s\], which must be the end of the last step.
    pub(crate) fn phase(&self, time: f64) -> Phase {
        self.base.phase(time)
    }
}

fn verner98<const D: usize>() -> Verner98<D> {
    // The crate limits the steps over all integrations; this module limits them per step of the
    // plan.
    let mut solver = Verner98::rkv988e().rtol(TOLERANCE).max_steps(usize::MAX);
    solver.atol = Tolerance::Vector(vec![TOLERANCE; D]);
    solver
}

/// The state at the last node, in scaled units.
struct Base<'a> {
    plant: &'a Plant<'a>,
    scale: Scale,
    /// Factor that converts a moment in N·m to scaled units.
    moment_unit: f64,
    /// Factor that converts a force in N to scaled units.
    force_unit: f64,
    j: Matrix3,
    j_inverse: Matrix3,
    /// Attitude quaternion, from body to inertial axes.
    quaternion: Compensated<4, 1>,
    momentum: Compensated<3, 1>,
    /// The momentum stored in the wheels; `None` if the body has no wheels.
    stored: Option<Compensated<3, 1>>,
    position: Compensated<3, 1>,
    linear_momentum: Compensated<3, 1>,
}

/// The equations for the changes since the last node, as an ODE in the scaled time since that node.
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
    /// Returns the impulse `∫τ dt` of body-fixed torques since the last node, scaled.
    fn spent(&self, t: f64) -> Vector3 {
        let (from, to) = (self.outputs.0.torque, self.outputs.1.torque);
        self.base.moment_unit * (t * from + 0.5 * t * t / self.length * (to - from))
    }

    /// Returns two scaled wrenches, of the force field and of the actuators, after a turn `[w, v]`
    /// (quaternion) and a change of position.
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

impl Change<'_> {
    /// Returns the magnitude of each component's rate of change, to which rounding errors are
    /// relative.
    fn speeds(&self, dimension: usize) -> impl IntoIterator<Item = f64> {
        let base = self.base;
        let [field, actuators] = self.loads(0.0, 1.0, &Vector3::zeros(), &Vector3::zeros());
        let [rate, torque] = base.speeds(field.moment.norm() + actuators.moment.norm());
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

    /// Returns the magnitudes of the angular velocity and of the rate of change of the momentum,
    /// under a torque with the norm `torque`.
    fn speeds(&self, torque: f64) -> [f64; 2] {
        let momentum = self.momentum.value();
        // Absolute values are used because the products cancel if the inertia is ill-conditioned.
        let rate = (self.j_inverse.abs() * momentum.abs()).norm();
        let stored = self.stored.as_ref().map_or(0.0, |stored| stored.value().norm());
        [rate, (momentum.norm() + stored) * rate + torque]
    }

    /// Advances by a step of the plan with Verner's pair; `None` if the integrator fails.
    fn integrate<const D: usize>(
        &mut self,
        solver: &mut Verner98<D>,
        time: f64,
        step: f64,
        outputs: (Output, Output),
    ) -> Option<()> {
        let (start, length) = (time / self.scale.time, step / self.scale.time);
        let attitude = lie::rotation_from_quaternion(&self.quaternion.value().data.0[0]);
        let change = Change { base: self, attitude, start, length, outputs };
        for (index, speed) in change.speeds(D).into_iter().enumerate() {
            solver.atol[index] = TOLERANCE * length * speed;
        }
        // Usually one internal step covers the whole length; the crate's own initial guess
        // allocates.
        solver.h0 = length;
        let (mut part, mut rejected) = (length, 0);
        let y = integrate(solver, &change, length, &[0.0; D], MAX_STEPS, &mut part, &mut rejected)?;
        let spent = change.spent(length);
        self.add(&y);
        if let Some(stored) = &mut self.stored {
            stored.add(&-spent);
        }
        Some(())
    }

    /// Advances by a step of the plan with one series, or with several in succession; `None` if
    /// they do not converge.
    fn expand(&mut self, parts: &mut u32, step: f64, from: &Output, to: &Output) -> Option<()> {
        let (mut at, mut count) = (0, (*parts / 2).max(1));
        while at < count {
            let length = step / self.scale.time / f64::from(count);
            let ends = [at, at + 1].map(|end| Output::between(from, to, f64::from(end) / f64::from(count)));
            if self.expand_part(length, &ends) {
                at += 1;
            } else if count < MOST_PARTS {
                (at, count) = (2 * at, 2 * count);
            } else {
                return None;
            }
        }
        *parts = count;
        Some(())
    }

    /// Advances by a part of a step, of the scaled length `length`. Returns false and changes
    /// nothing if the series does not converge.
    fn expand_part(&mut self, length: f64, ends: &[Output; 2]) -> bool {
        let [from, to] = ends.map(|end| self.moment_unit * end.torque);
        let speeds = self.speeds(from.norm().max(to.norm())).map(|speed| 1.0 + speed);
        let stored = self.stored.as_ref().map(|stored| *stored.value());
        let torque = [from, to - from];
        let stretch = Stretch { length, momentum: *self.momentum.value(), stored, torque, speeds };
        let Some((turn, momentum)) = change(&self.j, &self.j_inverse, &stretch) else { return false };
        self.add_rotation(&turn, &momentum);
        if let Some(stored) = &mut self.stored {
            stored.add(&(-0.5 * length * (from + to)));
        }
        if self.plant.moves {
            let [from, to] = ends.map(|end| self.force_unit * end.force);
            let momentum = self.linear_momentum.value();
            self.position.add(&(length * (momentum + length * (from / 3.0 + to / 6.0))));
            self.linear_momentum.add(&(0.5 * length * (from + to)));
        }
        true
    }

    fn add(&mut self, y: &[f64]) {
        self.add_rotation(&[y[0], y[1], y[2], y[3]], &vector(y, 4));
        if y.len() == RIGID_BODY {
            self.position.add(&vector(y, 7));
            self.linear_momentum.add(&vector(y, 10));
        }
    }

    /// Applies a turn, given as `q − 1`, and a change of the momentum.
    fn add_rotation(&mut self, turn: &[f64; 4], momentum: &Vector3) {
        // q ∘ (1 + y₀, v) = q + q ∘ (y₀, v)
        let q = self.quaternion.value();
        let (w, v) = (q[0], Vector3::new(q[1], q[2], q[3]));
        let (dw, dv) = (turn[0], vector(turn, 1));
        let vector_part = w * dv + dw * v + v.cross(&dv);
        let turn = [w * dw - v.dot(&dv), vector_part.x, vector_part.y, vector_part.z];
        self.quaternion.add(&SVector::from(turn));
        self.momentum.add(momentum);
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
