//! What acts on the body, as both witnesses see it: the field, the actuators, the turning frame.

use super::WitnessError;
use crate::maneuver::problem::{Motion, Problem, Scheme, State};
use crate::maneuver::solution::TerminalError;
use crate::mechanics::actuators::{AxisFrame, Channel};
use crate::mechanics::environment::{Pose, Wrench};
use crate::{Matrix3, Vector3, lie};

/// Where the body is and how it moves, with momenta instead of velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Position `x`, reference frame \[m\].
    pub position: Vector3,
    /// Linear momentum `γ = m ẋ`, reference frame [N·s].
    pub linear_momentum: Vector3,
    /// Attitude `R`, body → reference.
    pub attitude: Matrix3,
    /// Angular momentum `Π = JΩ`, body axes [N·m·s].
    pub momentum: Vector3,
    /// Momentum `μ = Σ a_i h_i` that the wheels store, body axes [N·m·s]; zero without wheels.
    pub stored: Vector3,
}

impl Phase {
    /// The phase of a boundary state of `problem`, with the wheels as they are at the start.
    pub fn of(problem: &Problem, state: &State) -> Self {
        Self {
            position: state.position,
            linear_momentum: problem.body.mass.unwrap_or(0.0) * state.velocity,
            attitude: state.attitude,
            momentum: problem.body.inertia.j() * state.angular_velocity,
            stored: problem.actuation.stored_momentum(),
        }
    }

    /// Angular velocity `Ω = J⁻¹Π`, body axes [rad/s].
    pub fn angular_velocity(&self, problem: &Problem) -> Vector3 {
        let inertia = &problem.body.inertia;
        angular_velocity(inertia.j(), inertia.j_inverse(), &self.momentum)
    }

    /// Velocity `γ/m`, reference frame [m/s]; zero without a mass.
    pub fn velocity(&self, problem: &Problem) -> Vector3 {
        problem.body.mass.map_or_else(Vector3::zeros, |mass| self.linear_momentum / mass)
    }

    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [&self.position, &self.linear_momentum, &self.momentum, &self.stored];
        vectors.into_iter().flatten().chain(self.attitude.iter()).all(|value| value.is_finite())
    }
}

/// `Ω` of `JΩ = Π`, with one step of refinement.
///
/// The plain product `J⁻¹Π` misses by ε·cond(J): for a thin rod that is a gyroscopic torque `Π × Ω`
/// about its axis which is not there, and spins it up by a radian a second.
pub(super) fn angular_velocity(j: &Matrix3, j_inverse: &Matrix3, momentum: &Vector3) -> Vector3 {
    let rate = j_inverse * momentum;
    rate + j_inverse * (momentum - j * rate)
}

/// Units in which `T = 1`, the mean principal moment is 1, the mass is 1 and lengths are of order 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) time: f64,
    pub(crate) inertia: f64,
    pub(crate) mass: f64,
    pub(crate) length: f64,
}

impl Scale {
    pub(crate) fn of(problem: &Problem) -> Self {
        let time = problem.duration;
        let ends = [&problem.start, &problem.end];
        let lengths = ends.map(|state| state.position.norm().max(time * state.velocity.norm()));
        let length = lengths[0].max(lengths[1]);
        Self {
            time,
            inertia: problem.body.inertia.mean(),
            mass: problem.body.mass.unwrap_or(1.0),
            length: if length > 0.0 { length } else { 1.0 },
        }
    }

    /// Units of torque and force [N·m, N].
    pub(crate) fn loads(&self) -> (f64, f64) {
        let per_time = 1.0 / self.time;
        (self.inertia * per_time * per_time, self.mass * self.length * per_time * per_time)
    }

    /// Distance between two phases in scaled units.
    pub(crate) fn distance(&self, a: &Phase, b: &Phase, motion: Motion) -> TerminalError {
        let moves = motion == Motion::RigidBody;
        let linear = self.mass * self.length / self.time;
        TerminalError {
            attitude_rad: lie::log(&(b.attitude.transpose() * a.attitude)).norm(),
            momentum_relative: (a.momentum - b.momentum).norm() * self.time / self.inertia,
            position_relative: moves.then(|| (a.position - b.position).norm() / self.length),
            linear_momentum_relative: moves.then(|| (a.linear_momentum - b.linear_momentum).norm() / linear),
        }
    }
}

/// `B u` of both channels, each in the axes in which its columns are fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Output {
    pub(crate) force: Vector3,
    pub(crate) torque: Vector3,
}

impl Output {
    pub(crate) fn of(problem: &Problem, inputs: &[f64]) -> Self {
        let force = problem.actuation.force.as_ref();
        let (force_inputs, torque_inputs) = inputs.split_at(force.map_or(0, Channel::count));
        Self {
            force: force.map_or_else(Vector3::zeros, |channel| channel.output(force_inputs)),
            torque: problem.actuation.torque.output(torque_inputs),
        }
    }

    pub(crate) fn none() -> Self {
        Self { force: Vector3::zeros(), torque: Vector3::zeros() }
    }

    /// `(1 − part) a + part b`.
    pub(crate) fn between(a: &Self, b: &Self, part: f64) -> Self {
        Self { force: a.force + part * (b.force - a.force), torque: a.torque + part * (b.torque - a.torque) }
    }
}

/// The plan's inputs as the steps use them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs<'a> {
    pub(super) problem: &'a Problem,
    rows: &'a [f64],
}

impl<'a> Inputs<'a> {
    /// `rows` must hold [`Scheme::input_rows`] rows of `problem.actuation.count()` numbers.
    pub(crate) fn new(problem: &'a Problem, rows: &'a [f64]) -> Self {
        Self { problem, rows }
    }

    /// The same, once the number of rows is checked.
    pub(crate) fn checked(problem: &'a Problem, rows: &'a [f64]) -> Result<Self, WitnessError> {
        let expected = problem.scheme.input_rows(problem.steps) * problem.actuation.count();
        if rows.len() != expected {
            return Err(WitnessError::Rows { what: "input numbers", found: rows.len(), expected });
        }
        Ok(Self { problem, rows })
    }

    /// The numbers of a row.
    pub(crate) fn numbers(&self, index: usize) -> &'a [f64] {
        let count = self.problem.actuation.count();
        &self.rows[index * count..(index + 1) * count]
    }

    pub(crate) fn row(&self, index: usize) -> Output {
        Output::of(self.problem, self.numbers(index))
    }

    /// Outputs at both ends of step k. Lie–Euler has no `u_0`; `u_1` stands for it.
    pub(crate) fn ends(&self, k: usize) -> (Output, Output) {
        match self.problem.scheme {
            Scheme::LieEuler => (self.row(k.saturating_sub(1)), self.row(k)),
            Scheme::LieVerlet => (self.row(k), self.row(k + 1)),
        }
    }

    /// The output that the plan holds over step k: `B u_{k+1}`, or `½ B (u_k + u_{k+1})` for Verlet.
    pub(crate) fn held(&self, k: usize) -> Output {
        match self.problem.scheme {
            Scheme::LieEuler => self.row(k),
            Scheme::LieVerlet => Output::between(&self.row(k), &self.row(k + 1), 0.5),
        }
    }
}

/// Field, actuators and frame of a problem.
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
            force_frame: problem.actuation.force.as_ref().map_or(AxisFrame::Reference, Channel::frame),
            frame_rate: (rate != Vector3::zeros()).then_some(rate),
        }
    }

    /// Rotation inertial → reference at time `t`: `exp(−t S(n))`; `None` while the frame stands.
    ///
    /// `R_{k+1} = exp(−h S(n)) R_k F_k` is `R_k = exp(−kh S(n)) A_k`, `A_{k+1} = A_k F_k`: the witnesses
    /// carry the inertial attitude A, to which a step adds one small rotation only.
    pub(crate) fn to_reference(&self, time: f64) -> Option<Matrix3> {
        self.frame_rate.map(|rate| lie::exp(&(-time * rate)))
    }

    /// Itself, unless the body moves in a turning frame: the scheme then lacks the Coriolis force.
    pub(crate) fn judgeable(self) -> Result<Self, WitnessError> {
        if self.moves && self.frame_rate.is_some() {
            return Err(WitnessError::TurningFrame);
        }
        Ok(self)
    }

    /// Angular velocity of the reference frame, its own axes [rad/s].
    pub(crate) fn frame_rate(&self) -> Vector3 {
        self.frame_rate.unwrap_or_else(Vector3::zeros)
    }

    /// Whether forces and moments depend on the attitude or the position at all.
    pub(crate) fn needs_pose(&self) -> bool {
        let body_force = self.moves && self.force_frame == AxisFrame::Body;
        !self.free || self.torque_frame == AxisFrame::Reference || body_force
    }

    /// Force and moment of the field.
    pub(crate) fn field(&self, pose: &Pose) -> Wrench {
        if self.free { Wrench::zero() } else { self.problem.environment.wrench(pose) }
    }

    /// Force (reference frame) and torque (body axes) of the actuators.
    pub(crate) fn actuators(&self, attitude: &Matrix3, output: &Output) -> Wrench {
        Wrench {
            force: match self.force_frame {
                AxisFrame::Reference => output.force,
                AxisFrame::Body => attitude * output.force,
            },
            moment: match self.torque_frame {
                AxisFrame::Body => output.torque,
                AxisFrame::Reference => attitude.tr_mul(&output.torque),
            },
        }
    }
}
