//! The discrete dynamics and its linearisation, split into a drift and a kick.
//!
//! One step of the controlled variational integrator is a *drift*, the free rigid body
//!
//! ```text
//! h S(Π) = F J_d − J_d Fᵀ ,   R⁺ = R F ,   Π' = Fᵀ Π            (x⁺ = x + (h/m) γ)
//! ```
//!
//! followed by a *kick* at the new pose, `Π⁺ = Π' + h (M⁺ + B u⁺)`, `γ⁺ = γ + h (f⁺ + B_f u⁺)`.
//! Both are lifted to the costates: the drift by `A0⁻ᵀ`, the kick as the flow of a Hamiltonian (see
//! the module `kick`). Theory and code are the same for SO(3) and SE(3), for any environment, and
//! for actuators that are fixed to the body or to the reference frame.

pub(crate) mod drift;
mod gyrostat;
pub(crate) mod inputs;
pub(crate) mod kick;
pub(crate) mod lanes;
mod linearization;
mod units;

pub(crate) use gyrostat::GyrostatDrift;
pub use linearization::Linearization;
pub use units::Units;

use crate::lie;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Problem, State};
use crate::mechanics::actuators::AxisFrame;
use crate::mechanics::environment::{Blocks, Environment, Pose, Wrench};
use crate::numerics::compensated::{Sum, Sum3, SumMatrix};
use crate::optimize::discrete::control_law::ControlLaw;
use crate::optimize::discrete::control_law::effort::Effort;
use crate::{Matrix3, Vector3};
use lanes::Rows;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Reason why a sweep was aborted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepError {
    /// The implicit equation has no physical solution at this step: the step is too long.
    TooLong,
    /// A number is not finite.
    NotFinite,
    /// The user interrupted the sweep, or the time limit was reached.
    Stopped,
}

/// The discretised maneuver in scaled units, the input of a sweep.
#[derive(Clone, Debug)]
pub struct Dynamics {
    pub(crate) units: Units,
    /// Grid in the unit of time, which is the duration of the problem.
    pub(crate) grid: Grid,
    pub(crate) j: Matrix3,
    pub(crate) j_d: Matrix3,
    pub(crate) j_inverse: Matrix3,
    /// Environment of forces and moments; `None` if only the actuators act on the body.
    environment: Option<Arc<dyn Environment>>,
    /// `exp S(−h_k n) − I` of a reference frame that rotates at the angular velocity n: one matrix
    /// for all steps of equal length, or one for each step; empty if the frame does not rotate.
    frame_turns: Vec<Matrix3>,
    torque: Authority,
    force: Authority,
    /// Control laws with limits; `None` if no input has a limit, so that the authorities are the
    /// whole law.
    laws: Option<Box<ControlLaws>>,
}

/// Authority `B W⁻¹ Bᵀ` of the forces or of the torques, scaled, and the frame in which their axes
/// are fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Authority {
    pub matrix: Matrix3,
    pub frame: AxisFrame,
}

/// Control laws of forces and torques, scaled.
#[derive(Clone, Debug)]
pub(crate) struct ControlLaws {
    pub force: ControlLaw,
    pub torque: ControlLaw,
}

/// State of the sweep: pose and momenta, each with the round-off that its sum has lost so far.
///
/// Sums over many steps are compensated (Kahan): momentum and orthogonality then hold to a few ulps
/// over 10⁶ steps, which naive updates miss, at no measurable cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub position: Sum3,
    pub linear_momentum: Sum3,
    pub attitude: SumMatrix,
    pub momentum: Sum3,
}

impl ControlLaws {
    fn boxed(self) -> Option<Box<Self>> {
        (self.force.is_limited() || self.torque.is_limited()).then(|| Box::new(self))
    }
}

impl Point {
    pub fn pose(&self) -> Pose {
        Pose { position: self.position.value, attitude: self.attitude.value }
    }

    /// Returns the difference `self ⊖ other` in the tangent space at `other`, in the blocks of a
    /// costate.
    pub fn minus(&self, other: &Self) -> Costate {
        Costate {
            x: self.position.value - other.position.value,
            gamma: self.linear_momentum.value - other.linear_momentum.value,
            zeta: lie::minus(&self.attitude.value, &other.attitude.value),
            pi: self.momentum.value - other.momentum.value,
        }
    }
}

/// A costate in blocks; the blocks of the translation are unused on SO(3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Costate {
    pub x: Vector3,
    pub gamma: Vector3,
    pub zeta: Vector3,
    pub pi: Vector3,
}

impl Costate {
    /// Splits a vector of N numbers, in the order x, γ, ζ, Π, into blocks; for N = 6 it has only ζ
    /// and Π.
    pub fn from_vector<const N: usize>(vector: &SVector<f64, N>) -> Self {
        let part = |row: usize| Vector3::new(vector[row], vector[row + 1], vector[row + 2]);
        let zero = Vector3::zeros();
        let (x, gamma) = if N == 12 { (part(0), part(3)) } else { (zero, zero) };
        Self { x, gamma, zeta: part(N - 6), pi: part(N - 3) }
    }

    /// Joins the blocks into a vector of N numbers, in the order x, γ, ζ, Π; for N = 6 only ζ and
    /// Π.
    pub fn to_vector<const N: usize>(self) -> SVector<f64, N> {
        SVector::from_fn(|row, _| {
            let block = if N == 6 { row / 3 + 2 } else { row / 3 };
            [self.x, self.gamma, self.zeta, self.pi][block][row % 3]
        })
    }
}

/// Derivatives of state and costate with respect to N parameters, in blocks of size 3×N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sensitivity<const N: usize> {
    pub x: Rows<N>,
    pub gamma: Rows<N>,
    pub zeta: Rows<N>,
    pub pi: Rows<N>,
    pub costate_x: Rows<N>,
    pub costate_gamma: Rows<N>,
    pub costate_zeta: Rows<N>,
    pub costate_pi: Rows<N>,
}

impl<const N: usize> Sensitivity<N> {
    /// Returns zero derivatives.
    pub fn zero() -> Self {
        let zero = Rows::zero();
        Self {
            x: zero,
            gamma: zero,
            zeta: zero,
            pi: zero,
            costate_x: zero,
            costate_gamma: zero,
            costate_zeta: zero,
            costate_pi: zero,
        }
    }

    /// Returns the identity in the four blocks of a state or of a costate.
    fn identity() -> [Rows<N>; 4] {
        let zero = Rows::zero();
        let (x, gamma) = if N == 12 { (Rows::identity_at(0), Rows::identity_at(3)) } else { (zero, zero) };
        [x, gamma, Rows::identity_at(N - 6), Rows::identity_at(N - 3)]
    }

    /// Starts the derivatives with respect to the costate: `z = 0`, `δλ = I`.
    pub fn of_costate() -> Self {
        let [costate_x, costate_gamma, costate_zeta, costate_pi] = Self::identity();
        Self { costate_x, costate_gamma, costate_zeta, costate_pi, ..Self::zero() }
    }

    /// Starts the derivatives with respect to the state: `z = I`, `δλ = 0`.
    pub fn of_state() -> Self {
        let [x, gamma, zeta, pi] = Self::identity();
        Self { x, gamma, zeta, pi, ..Self::zero() }
    }

    /// Returns the derivative of the state, N×N.
    pub fn state(&self) -> SMatrix<f64, N, N> {
        stack([&self.x, &self.gamma, &self.zeta, &self.pi])
    }

    /// Returns the derivative of the costate, N×N.
    pub fn costate(&self) -> SMatrix<f64, N, N> {
        stack([&self.costate_x, &self.costate_gamma, &self.costate_zeta, &self.costate_pi])
    }
}

/// Computes `exp S(−h_k n) − I` for a reference frame that rotates at the angular velocity n: one
/// matrix for all steps of equal length, or one for each step; empty if the frame does not rotate.
fn frame_turns(environment: &dyn Environment, units: &Units, grid: &Grid) -> Vec<Matrix3> {
    let rate = environment.frame_rate();
    let turn = |step: usize| lie::exp_minus_identity(&(rate * (-grid.step(step) * units.time)));
    let turning = if rate.amax() > 0.0 { grid.different_steps() } else { 0 };
    (0..turning).map(turn).collect()
}

fn stack<const N: usize>(blocks: [&Rows<N>; 4]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|row, column| {
        let block = if N == 6 { row / 3 + 2 } else { row / 3 };
        blocks[block].0[row % 3][column]
    })
}

impl Dynamics {
    /// Discretises a maneuver on a uniform grid of `steps` steps: `problem.steps`, or fewer for a
    /// coarser grid.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        Self::on(problem, Grid::uniform(problem.scheme, 1.0, steps))
    }

    /// Discretises a maneuver on a grid in the unit of time, which is the duration of the problem.
    pub(crate) fn on(problem: &Problem, grid: Grid) -> Self {
        let units = Units::of(problem);
        let inertia = &problem.body.inertia;
        let weights = problem.objective.weights();
        let (torque, force) = (weights.torque(&problem.actuation), weights.force(&problem.actuation));
        let rotation = units.cost / units.momentum() / units.torque();
        let translation = units.cost / units.linear_momentum() / units.force();
        let zero = Authority { matrix: Matrix3::zeros(), frame: AxisFrame::Reference };
        let environment = (!problem.environment.is_free()).then(|| problem.environment.clone());
        Self {
            units,
            j: inertia.j() / units.inertia,
            j_d: inertia.j_d() / units.inertia,
            j_inverse: inertia.j_inverse() * units.inertia,
            environment,
            frame_turns: frame_turns(problem.environment.as_ref(), &units, &grid),
            grid,
            torque: Authority { matrix: torque.authority * rotation, frame: torque.set.frame() },
            force: force.as_ref().map_or(zero, |force| Authority {
                matrix: force.authority * translation,
                frame: force.set.frame(),
            }),
            laws: ControlLaws {
                force: force.as_ref().map_or(ControlLaw::Effort(Effort(zero.matrix)), |force| {
                    ControlLaw::of(force).scaled(translation, units.force())
                }),
                torque: ControlLaw::of(&torque).scaled(rotation, units.torque()),
            }
            .boxed(),
        }
    }

    /// Returns the maneuver on another grid.
    pub(crate) fn on_grid(&self, grid: Grid) -> Self {
        let turns = self.environment.as_ref().map(|field| frame_turns(field.as_ref(), &self.units, &grid));
        Self { frame_turns: turns.unwrap_or_default(), grid, ..self.clone() }
    }

    /// Returns whether only the inputs act on the body.
    pub(crate) fn is_free(&self) -> bool {
        self.environment.is_none()
    }

    /// Returns whether any input has a limit.
    pub(crate) fn is_limited(&self) -> bool {
        self.laws.is_some()
    }

    /// Returns the dynamics with the reference frame rotating in the opposite direction, for
    /// motions that run backward on a uniform grid.
    pub(crate) fn reversed(&self) -> Self {
        let frame_turns = self.frame_turns.iter().map(Matrix3::transpose).collect();
        Self { frame_turns, ..self.clone() }
    }

    /// Returns the dynamics with every input limit multiplied by `factor`.
    pub(crate) fn relaxed(&self, factor: f64) -> Self {
        let relaxed = |laws: &ControlLaws| ControlLaws {
            force: laws.force.relaxed(factor),
            torque: laws.torque.relaxed(factor),
        };
        Self { laws: self.laws.as_deref().map(|laws| Box::new(relaxed(laws))), ..self.clone() }
    }

    /// Converts a boundary state to scaled units.
    pub(crate) fn point(&self, state: &State) -> Point {
        let units = &self.units;
        Point {
            position: Sum::new(state.position / units.length),
            linear_momentum: Sum::new(state.velocity * (units.time / units.length)),
            attitude: Sum::new(state.attitude),
            momentum: Sum::new(self.j * state.angular_velocity * units.time),
        }
    }

    /// Propagates the start of `problem` on SO(3) over all steps under a small constant torque (0.1
    /// on each body axis, scaled), and returns the final attitude and momentum (scaled). It takes
    /// bare steps, without costates or optimal inputs; benchmarks compare the cost of a sweep with
    /// it.
    ///
    /// # Errors
    /// [`StepError`] where the implicit equation has no solution.
    pub fn propagate(&self, problem: &Problem) -> Result<(Matrix3, Vector3), StepError> {
        let start = self.point(&problem.start);
        let end =
            if self.grid.is_uniform() { self.coast::<true>(start) } else { self.coast::<false>(start) }?;
        Ok((end.attitude.value, end.momentum.value))
    }

    /// Runs the steps of [`Dynamics::propagate`]; `UNIFORM` states that all steps have one length.
    /// A function call in the loop would spill its registers.
    #[inline]
    fn coast<const UNIFORM: bool>(&self, mut point: Point) -> Result<Point, StepError> {
        let input = Wrench { force: Vector3::zeros(), moment: Vector3::repeat(0.1) };
        let length = self.grid.full_kick(0);
        for step in 0..self.grid.steps() {
            self.drift::<6>(step, &mut point)?;
            let weight = if UNIFORM { length } else { self.grid.full_kick(step + 1) };
            self.bare_kick::<6>(&mut point, weight, &input);
        }
        Ok(point)
    }

    /// Returns whether a body in the state `point` keeps its attitude without inputs, because no
    /// environment acts and its momentum is zero.
    pub(crate) fn stands(&self, point: &Point) -> bool {
        self.environment.is_none() && point.momentum.value == Vector3::zeros()
    }

    /// Returns the angular velocity of the reference frame, in its own axes, scaled.
    pub(crate) fn frame_rate(&self) -> Vector3 {
        let rate = self.environment.as_ref().map_or_else(Vector3::zeros, |field| field.frame_rate());
        rate * self.units.time
    }

    /// Returns `exp S(−h_k n) − I` of step k, where n is the frame's angular velocity; `None` if
    /// the reference frame does not rotate.
    #[inline(always)]
    fn frame_turn(&self, step: usize) -> Option<&Matrix3> {
        self.frame_turns.get(step).or(self.frame_turns.first())
    }

    /// Removes the rotation of the reference frame over step `step` from the attitude at its end;
    /// the result is `R_k F_k`.
    pub(crate) fn unturned(&self, step: usize, attitude: &Matrix3) -> Matrix3 {
        match self.frame_turn(step) {
            Some(turn) => attitude + turn.tr_mul(attitude),
            None => *attitude,
        }
    }

    /// Converts `R_k F_k` to `R⁺` in the axes of the reference frame at the end of step `step`.
    pub(crate) fn turned(&self, step: usize, attitude: &Matrix3) -> Matrix3 {
        match self.frame_turn(step) {
            Some(turn) => attitude + turn * attitude,
            None => *attitude,
        }
    }

    /// Computes force and moment of the environment and their gradient, scaled; zero for a free
    /// body.
    pub(crate) fn field(&self, pose: &Pose) -> (Wrench, Blocks) {
        match &self.environment {
            Some(environment) => {
                (self.wrench(environment.as_ref(), pose), self.gradient(environment.as_ref(), pose))
            }
            None => (Wrench::zero(), Blocks::zero()),
        }
    }

    /// Computes the derivative `∂M/∂R` of the environment's moment, and the second derivative of
    /// `λ^Π · M`, scaled; zero for a free body.
    pub(crate) fn field_derivatives(&self, pose: &Pose, costate: &Vector3) -> (Matrix3, Matrix3) {
        let Some(environment) = &self.environment else { return (Matrix3::zeros(), Matrix3::zeros()) };
        let costates = Wrench { force: Vector3::zeros(), moment: *costate };
        let gradient = self.gradient(environment.as_ref(), pose).rr;
        (gradient, self.curvature(environment.as_ref(), pose, &costates).rr)
    }

    /// Computes the second derivatives of `λ^γ · f + λ^Π · M` of the environment, scaled; zero for
    /// a free body.
    pub(crate) fn field_curvature(&self, pose: &Pose, costate: &Costate) -> Blocks {
        let costates = Wrench { force: costate.gamma, moment: costate.pi };
        let curvature =
            |environment: &Arc<dyn Environment>| self.curvature(environment.as_ref(), pose, &costates);
        self.environment.as_ref().map_or_else(Blocks::zero, curvature)
    }

    /// Computes force and moment of the environment, scaled; zero for a free body.
    #[inline(always)]
    pub(crate) fn environment_wrench(&self, pose: &Pose) -> Wrench {
        self.environment
            .as_ref()
            .map_or_else(Wrench::zero, |environment| self.wrench(environment.as_ref(), pose))
    }

    /// Computes force and moment of `environment` at a pose, scaled.
    #[inline(always)]
    fn wrench(&self, environment: &dyn Environment, pose: &Pose) -> Wrench {
        let wrench = environment.wrench(&self.pose_si(pose));
        Wrench { force: wrench.force / self.units.force(), moment: wrench.moment / self.units.torque() }
    }

    /// Computes the gradient of force and moment of `environment` at a pose, scaled.
    fn gradient(&self, environment: &dyn Environment, pose: &Pose) -> Blocks {
        let (force, torque, length) = (self.units.force(), self.units.torque(), self.units.length);
        let gradient = environment.gradient(&self.pose_si(pose));
        Blocks {
            xx: gradient.xx * (length / force),
            xr: gradient.xr / force,
            rx: gradient.rx * (length / torque),
            rr: gradient.rr / torque,
        }
    }

    /// Computes the second derivatives of force and moment of `environment`, contracted with the
    /// costates `(λ^γ, λ^Π)`, scaled.
    fn curvature(&self, environment: &dyn Environment, pose: &Pose, costates: &Wrench) -> Blocks {
        let length = self.units.length;
        let dual = Wrench {
            force: costates.force / self.units.force(),
            moment: costates.moment / self.units.torque(),
        };
        let curvature = environment.curvature(&self.pose_si(pose), &dual);
        Blocks {
            xx: curvature.xx * (length * length),
            xr: curvature.xr * length,
            rx: curvature.rx * length,
            rr: curvature.rr,
        }
    }

    fn pose_si(&self, pose: &Pose) -> Pose {
        Pose { position: pose.position * self.units.length, attitude: pose.attitude }
    }
}

#[cfg(test)]
mod tests;
