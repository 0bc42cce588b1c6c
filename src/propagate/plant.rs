//! The forces and torques on the body of a maneuver: force field, actuators and rotating reference
//! frame.

use crate::maneuver::problem::{Motion, Problem};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame};
use crate::mechanics::environment::{Pose, Wrench};
use crate::mechanics::full_body::Potential;
use crate::{Matrix3, Vector3, lie};
use std::sync::{Mutex, PoisonError};

/// The actuator outputs `B u`, a force and a torque, each in the axes in which its actuator set is
/// fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Output {
    pub(crate) force: Vector3,
    pub(crate) torque: Vector3,
}

impl Output {
    pub(crate) fn of(problem: &Problem, inputs: &[f64]) -> Self {
        let force = problem.actuation.force.as_ref();
        let (force_inputs, torque_inputs) = problem.actuation.split(inputs);
        Self {
            force: force.map_or_else(Vector3::zeros, |set| set.output(force_inputs)),
            torque: problem.actuation.torque.output(torque_inputs),
        }
    }

    pub(crate) fn none() -> Self {
        Self { force: Vector3::zeros(), torque: Vector3::zeros() }
    }

    /// Interpolates linearly between two outputs: `(1 − part) a + part b`.
    pub(crate) fn between(a: &Self, b: &Self, part: f64) -> Self {
        Self { force: a.force + part * (b.force - a.force), torque: a.torque + part * (b.torque - a.torque) }
    }
}

/// The force field, the actuators and the reference frame of a problem.
#[derive(Clone, Debug)]
pub(crate) struct Plant<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) free: bool,
    pub(crate) moves: bool,
    pub(crate) torque_frame: AxisFrame,
    pub(crate) force_frame: AxisFrame,
    frame_rate: Option<Vector3>,
}

impl<'a> Plant<'a> {
    pub(crate) fn new(problem: &'a Problem) -> Self {
        let rate = problem.environment.frame_rate();
        Self {
            problem,
            free: problem.environment.is_free(),
            moves: problem.motion == Motion::RigidBody,
            torque_frame: problem.actuation.torque.frame(),
            force_frame: problem.actuation.force.as_ref().map_or(AxisFrame::Reference, ActuatorSet::frame),
            frame_rate: (rate != Vector3::zeros()).then_some(rate),
        }
    }

    /// Returns the rotation from inertial to reference axes at time `t`, `exp(−t S(n))`; `None` if
    /// the frame does not rotate.
    ///
    /// The step `R_{k+1} = exp(−h S(n)) R_k F_k` is equivalent to `R_k = exp(−kh S(n)) A_k`,
    /// `A_{k+1} = A_k F_k`. The witnesses propagate the inertial attitude A, to which a step adds
    /// one small rotation.
    pub(crate) fn to_reference(&self, time: f64) -> Option<Matrix3> {
        self.frame_rate.map(|rate| lie::exp(&(-time * rate)))
    }

    /// Returns whether the reference frame rotates.
    pub(crate) fn turns(&self) -> bool {
        self.frame_rate.is_some()
    }

    /// Returns the angular velocity of the reference frame in its own axes [rad/s].
    pub(crate) fn frame_rate(&self) -> Vector3 {
        self.frame_rate.unwrap_or_else(Vector3::zeros)
    }

    /// Returns whether forces or torques depend on the attitude or the position.
    pub(crate) fn needs_pose(&self) -> bool {
        let body_force = self.moves && self.force_frame == AxisFrame::Body;
        !self.free || self.torque_frame == AxisFrame::Reference || body_force
    }

    /// Returns the force and moment of the force field.
    pub(crate) fn field(&self, pose: &Pose) -> Wrench {
        if self.free { Wrench::zero() } else { self.problem.environment.wrench(pose) }
    }

    /// Returns the actuator force (reference axes) and torque (body axes).
    pub(crate) fn actuators(&self, attitude: &Matrix3, output: &Output) -> Wrench {
        Wrench {
            force: self.force_frame.to_reference(attitude, &output.force),
            moment: self.torque_frame.to_body(attitude, &output.torque),
        }
    }
}

/// Force field and actuators of a maneuver, combined into one load on one body. The actuator output
/// is held until another one is set.
///
/// Actuators fixed in the reference frame produce a torque `Rᵀ B u` that depends on the attitude.
/// Actuators fixed in the body produce a force `R B u` that also depends on it. Torque and force
/// are evaluated together with the field, so they are exact in every method.
#[derive(Debug)]
pub(crate) struct HeldLoad {
    problem: Problem,
    output: Mutex<Output>,
}

impl HeldLoad {
    pub(crate) fn new(problem: &Problem, output: Output) -> Self {
        Self { problem: problem.clone(), output: Mutex::new(output) }
    }

    /// Sets the actuator output that is held from now on.
    pub(crate) fn hold(&self, output: Output) {
        *self.output.lock().unwrap_or_else(PoisonError::into_inner) = output;
    }
}

impl Potential for HeldLoad {
    /// Returns the potential energy of the field. Actuators do work but have no potential energy.
    fn energy(&self, poses: &[Pose]) -> f64 {
        self.problem.environment.potential(&poses[0])
    }

    fn wrenches(&self, poses: &[Pose], wrenches: &mut [Wrench]) {
        let plant = Plant::new(&self.problem);
        let output = *self.output.lock().unwrap_or_else(PoisonError::into_inner);
        let (field, actuators) = (plant.field(&poses[0]), plant.actuators(&poses[0].attitude, &output));
        wrenches[0] =
            Wrench { force: field.force + actuators.force, moment: field.moment + actuators.moment };
    }

    fn depends_on_poses(&self) -> bool {
        Plant::new(&self.problem).needs_pose()
    }
}
