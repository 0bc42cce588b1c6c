//! The motion near a plan, linearised: `A_k`, `B_k`, the curvature `H_k` of the Lagrangian, and the
//! authority that the inputs still have.
//!
//! ```text
//! z_k = [log(R*_kᵀ R_k); Π_k − Π*_k]          z_{k+1} = A_k z_k + B_k δτ_k + E_k p          δλ_{k−1} = A_kᵀ δλ_k + H_k z_k
//! ```
//!
//! A step is a kick of weight `w₀`, a drift and a kick of weight `w₁`, so that with the drift's
//! `D = [[Fᵀ, B], [0, C]]` (`step::drift`) and `K_i = [[I, 0], [w_i ∂M/∂R, I]]`
//!
//! ```text
//! A = K₁ D K₀ ,     B = K₁ D [0; w₀ I] + [0; w₁ I] ,     H = w₀ K_qq + K₀ᵀ (H_free + Dᵀ w₁ K_qq D) K₀
//! ```
//!
//! The effect of a torque in the first kick on the costates, and of the state on the optimal
//! torque, is derived in `linear_plan::stage`. Bodies that translate and torques fixed in the
//! reference frame are treated in `linear_plan::posed`.
//!
//! - [`Timing::Held`]: `w₀ = w₁ = h/2`, a torque held over the step. This is the linearised
//!   Lie–Verlet flow of the flown motion, of second order in the step, and its `z` has the physical
//!   momenta at the nodes.
//! - [`Timing::AtNodes`]: `w₀ = 0`, and `w₁` is the full kick at the node at the end of the step.
//!   This is exactly the discrete problem. Its momenta are those after a full kick; half a kick
//!   leads to them from the physical start, and half a kick back from them at the end.

//!
//! Reaction wheels store the reaction to the torques that they exert. Their momentum `μ`, body
//! axes, is then an additional state besides `z`:
//!
//! ```text
//! z_{k+1} = A_k z_k + B_k δτ_k + M_k δμ_k ,     δμ_{k+1} = δμ_k − h δτ_k
//! ```
//!
//! with the drift of a gyrostat (`step::gyrostat`) in place of that of a body: `ζ' = Fᵀζ + ξ`,
//! `H' = FᵀH`, `H = Π + μ`, `ξ = ξ_H δH + ξ_μ δμ`.

mod authority;
mod linearise;
mod posed;
mod stage;
pub(crate) mod ticks;

use crate::flight::Flight;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::solution::Trajectory;
use crate::mechanics::actuators::AxisFrame;
use crate::optimize::discrete::step::drift::Drift;
use crate::optimize::discrete::step::{StepError, Units};
use crate::{Matrix3, Vector3};
use linearise::Beside;
use nalgebra::{DMatrix, Matrix3xX, SMatrix, SVector};
pub use posed::PosedPlan;
pub(crate) use posed::Stages;
pub(crate) use stage::{Parts, Stage};
use thiserror::Error;

/// 6×6 matrix that acts on tangent vectors `[ζ, δΠ]`.
pub type Matrix6 = SMatrix<f64, 6, 6>;
/// 9×9 matrix that acts on tangent vectors with wheel momentum, `[ζ, δΠ, δμ]`.
pub type Matrix9 = SMatrix<f64, 9, 9>;
/// 6×3 matrix: derivative of the state with respect to torques.
pub type Matrix6x3 = SMatrix<f64, 6, 3>;
/// Tangent vector `[ζ, δΠ]`.
pub type Vector6 = SVector<f64, 6>;

/// Time at which a correction of the torque acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// The correction is held over the step that begins with the measurement, as in flight.
    Held,
    /// The correction is a full kick at the node at the end of the step, as in the discrete problem
    /// of the planner.
    AtNodes,
}

/// Reason why the motion near a plan cannot be linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unlinearised {
    /// The body translates, which this type does not support.
    #[error("the body translates: covariances support only attitude and rate")]
    Translation,
    /// Reaction wheels drive the body, which is not supported for torques at nodes.
    #[error(
        "reaction wheels drive the body: the discrete problem of torques at nodes has no costates of them"
    )]
    Wheels,
    /// The torques are fixed in the reference frame, which this type does not support.
    #[error("the torques are fixed in the reference frame")]
    Frame,
    /// Thrusters exert force and torque at once.
    #[error(
        "its thrusters give force and torque at once: forces and torques need separate inputs for the \
        corrections"
    )]
    Thrusters,
    /// The plan has no trajectory, or one that does not fit the maneuver.
    #[error("the plan has no trajectory on the grid of the maneuver")]
    Trajectory,
    /// The implicit equation of a step has no solution.
    #[error("a step of the plan is too long for its momentum, or a number is not finite")]
    Step,
    /// The plan has more than 100,000 steps.
    #[error("the plan has more than {MOST_STEPS} steps: each has matrices of some kilobytes")]
    Fine,
    /// The inputs are bang-bang, but the discrete problem with torques at nodes was requested.
    #[error("inputs that switch are held over steps, and have no values at nodes")]
    Switching,
}

/// Largest number of steps of a plan for which matrices are stored.
pub(crate) const MOST_STEPS: usize = 100_000;

impl From<StepError> for Unlinearised {
    fn from(_: StepError) -> Self {
        Self::Step
    }
}

/// One linearised step of a plan, in the solver's units.
#[derive(Clone, Debug)]
pub(crate) struct LinearStep {
    /// Matrices of the step for torques about the body axes; the authority counts only inputs that
    /// are not at their limits.
    pub stage: Stage<6, 3>,
    /// `W⁻¹Bᵀ` of the inputs that are not at their limits, m×3: it maps a scaled dual torque to
    /// inputs in SI units.
    pub to_inputs: DMatrix<f64>,
    /// Inputs and torque of the plan in the kicks of the step.
    applied: Applied,
    /// Weights of the kicks before and after the drift.
    kicks: [f64; 2],
    /// Length, relative attitude `F` and momentum `Π'` of the drift.
    drift: Drift,
    drift_b: Matrix3,
    /// `K₁ D`, the part of the step after the first kick.
    after: Matrix6,
    /// `M_k`, the derivative with respect to the wheel momentum; zero without wheels.
    pub wheels: Matrix6x3,
    /// Matrices of the step with the wheel momentum as additional states, `δμ' = δμ − h δτ`; `None`
    /// without wheels.
    pub with_wheels: Option<Box<Stage<9, 3>>>,
    /// Gradient `∂M/∂R` of the environment's moment in the second kick.
    gradient: Matrix3,
}

/// Torque inputs in SI units, and the resulting torque in body axes, scaled.
#[derive(Clone, Debug)]
struct Applied {
    inputs: Vec<f64>,
    torque: Vector3,
}

/// Half kick between the physical state at one end of the plan and the adjacent linearised state
/// `z`.
#[derive(Clone, Debug)]
struct HalfKick {
    /// Weight of the kick; 0 if torques are held.
    weight: f64,
    applied: Applied,
    /// Gradient `∂M/∂R` of the environment's moment at this end.
    gradient: Matrix3,
}

/// Linearised motion near a plan of a body that only rotates.
#[derive(Clone, Debug)]
pub struct LinearPlan {
    timing: Timing,
    units: Units,
    /// Inertia `J`, scaled.
    j: Matrix3,
    steps: Vec<LinearStep>,
    /// Half kicks between the physical start and the first `z`, and between the last `z` and the
    /// physical end.
    outer: [HalfKick; 2],
    times: Vec<f64>,
    /// Attitude (body to reference frame) and angular velocity of the plan at its nodes, SI units.
    nodes: Vec<(Matrix3, Vector3)>,
    /// Axes `B` of the inputs, 3×m, SI.
    axes: Matrix3xX<f64>,
    /// Wheel momentum at the nodes, body axes, scaled; empty without wheels.
    stored: Vec<Vector3>,
    /// Indices of the nodes, other than the last, at which the craft has to meet the motion, in
    /// ascending order.
    stops: Vec<usize>,
}

/// Uncertain parameter of a maneuver, with the effect of one unit of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// Change of inertia: the symmetric matrix `δJ` per unit of the parameter, body axes. The
    /// moments of a force field remain those of the nominal body.
    Inertia(Matrix3),
    /// Relative error of the output of the input with this index; positive if the output is too
    /// large.
    InputScale(usize),
    /// Misalignment of all actuators by a rotation about a body axis \[rad\]: `τ = exp S(α) B u`.
    ActuatorTurn(Vector3),
    /// A constant torque, body axes [N·m].
    ConstantTorque(Vector3),
    /// Misalignment of the attitude sensor by a rotation about a body axis \[rad\]: `R exp S(β)` is
    /// measured.
    SensorTurn(Vector3),
    /// Relative error of the measured rate about body axis `i`: positive if the measurement is too
    /// large.
    RateScale(usize),
    /// A constant error of the measured rate [rad/s].
    RateBias(Vector3),
}

impl LinearPlan {
    /// Linearises the motion about `plan`, a trajectory of `problem` on its own grid
    /// ([`Solution::on_grid`]). If torques are held ([`Timing::Held`]), the costates of the plan
    /// are used as the costates at its nodes.
    ///
    /// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
    ///
    /// # Errors
    /// [`Unlinearised`] if the body translates, if the torques are fixed in the reference frame, if
    /// wheels or bang-bang inputs are combined with [`Timing::AtNodes`], or if the trajectory does
    /// not fit the problem.
    pub fn new(problem: &Problem, plan: &Trajectory, timing: Timing) -> Result<Self, Unlinearised> {
        Self::fits(problem, plan)?;
        if problem.switches() && timing == Timing::AtNodes {
            return Err(Unlinearised::Switching);
        }
        if problem.actuation.wheels.is_some() && timing == Timing::AtNodes {
            return Err(Unlinearised::Wheels);
        }
        Beside { problem, plan, timing, count: plan.time.len() - 1, beyond: false }.linearise()
    }

    /// Checks whether the motion about a plan can be linearised.
    fn fits(problem: &Problem, plan: &Trajectory) -> Result<(), Unlinearised> {
        if problem.motion == Motion::RigidBody {
            return Err(Unlinearised::Translation);
        }
        if problem.actuation.torque.frame() != AxisFrame::Body {
            return Err(Unlinearised::Frame);
        }
        let count = plan.time.len().saturating_sub(1);
        let m = problem.actuation.torque.count();
        let rows = plan.torque.len();
        let fits = count > 0
            && plan.quaternion.len() == count + 1
            && plan.angular_velocity.len() == count + 1
            && plan.wheel_momentum.len() == problem.actuation.wheels.as_ref().map_or(0, |_| (count + 1) * m)
            && plan.input_count >= m
            && plan.input.len() == rows * plan.input_count
            && rows >= if problem.switches() { count } else { problem.scheme.input_rows(count) };
        if count > MOST_STEPS {
            return Err(Unlinearised::Fine);
        }
        if fits { Ok(()) } else { Err(Unlinearised::Trajectory) }
    }

    /// Linearises the motion about the flown motion: the true motion under the plan's inputs, held
    /// over the steps.
    ///
    /// # Errors
    /// The errors of [`LinearPlan::new`].
    pub fn flown(problem: &Problem, plan: &Trajectory) -> Result<Self, Unlinearised> {
        Self::fits(problem, plan)?;
        let recorded = Flight::recorded(problem, plan).ok_or(Unlinearised::Step)?;
        let beyond = records_beyond_nodes(problem);
        Beside { problem, plan: &recorded, timing: Timing::Held, count: plan.time.len() - 1, beyond }
            .linearise()
    }

    /// Linearises the motion about a recorded motion of `problem`, which holds one row of inputs
    /// over each of its steps ([`Stepping::Recorded`]). The craft has to meet this motion at its
    /// end and at the nodes `stops`, in ascending order.
    ///
    /// [`Stepping::Recorded`]: crate::maneuver::Stepping::Recorded
    ///
    /// # Errors
    /// The errors of [`LinearPlan::new`].
    pub fn recorded(problem: &Problem, motion: &Trajectory, stops: Vec<usize>) -> Result<Self, Unlinearised> {
        Self::fits(problem, motion)?;
        let count = motion.time.len() - 1;
        let beside = Beside { problem, plan: motion, timing: Timing::Held, count, beyond: false };
        Ok(Self { stops, ..beside.linearise()? })
    }

    /// Returns the indices of the nodes, other than the last, at which the craft has to meet the
    /// motion, in ascending order; empty for the plan of a single maneuver.
    pub fn stops(&self) -> &[usize] {
        &self.stops
    }

    /// Returns the number of steps.
    pub fn count(&self) -> usize {
        self.steps.len()
    }

    /// Returns the time at which corrections of the torque act.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Returns the times of the nodes \[s\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns whether reaction wheels exert the torques.
    pub fn has_wheels(&self) -> bool {
        !self.stored.is_empty()
    }

    /// Returns the wheel momentum at a node, body axes [N·m·s]; zero without wheels.
    pub fn wheel_momentum(&self, node: usize) -> Vector3 {
        self.stored.get(node).map_or_else(Vector3::zeros, |stored| stored * self.units.momentum())
    }

    /// Returns attitude and angular velocity [rad/s] of the plan at a node.
    pub fn node(&self, index: usize) -> (&Matrix3, &Vector3) {
        let (attitude, rate) = &self.nodes[index];
        (attitude, rate)
    }

    /// Returns the torque inputs of the plan in a step, SI.
    pub fn inputs(&self, step: usize) -> &[f64] {
        &self.steps[step].applied.inputs
    }

    /// Returns the axes of the inputs, `B`, 3×m, SI.
    pub fn axes(&self) -> &Matrix3xX<f64> {
        &self.axes
    }

    /// Returns `A_k`, the derivative of the next state with respect to the state; states are in rad
    /// and N·m·s.
    pub fn a(&self, step: usize) -> Matrix6 {
        let scaled = &self.steps[step].stage.a;
        Matrix6::from_fn(|row, column| scaled[(row, column)] * self.unit(row) / self.unit(column))
    }

    /// Returns `B_k`, the derivative of the next state (rad and N·m·s) with respect to the torque
    /// [N·m].
    pub fn b(&self, step: usize) -> Matrix6x3 {
        let scaled = &self.steps[step].stage.b;
        Matrix6x3::from_fn(|row, column| scaled[(row, column)] * self.unit(row) / self.units.torque())
    }

    /// Returns `H_k`, the curvature of the Lagrangian with respect to the state (rad and N·m·s), in
    /// units of the cost.
    pub fn h(&self, step: usize) -> Matrix6 {
        let scaled = &self.steps[step].stage.h;
        Matrix6::from_fn(|row, column| {
            scaled[(row, column)] * self.units.cost / self.unit(row) / self.unit(column)
        })
    }

    pub(crate) fn units(&self) -> &Units {
        &self.units
    }

    pub(crate) fn steps(&self) -> &[LinearStep] {
        &self.steps
    }

    /// Returns `K₊`, which maps a deviation of the physical start to the first state `z` of the
    /// linearised motion, scaled.
    pub(crate) fn first(&self) -> Matrix6 {
        kick(&(self.outer[0].weight * self.outer[0].gradient))
    }

    /// Returns `K₋`, which maps the last state `z` of the linearised motion to the deviation of the
    /// physical end, scaled.
    pub(crate) fn last(&self) -> Matrix6 {
        kick(&(-self.outer[1].weight * self.outer[1].gradient))
    }

    /// Returns the weight of the outer half kick, scaled: of the kick before the first `z`
    /// (`end = 0`), or of the part of the last kick after the physical end (`end = 1`).
    pub(crate) fn half_kick(&self, end: usize) -> f64 {
        self.outer[end].weight
    }

    /// Returns `∂M/∂R`, the gradient of the environment's moment at a node, scaled.
    pub(crate) fn field_gradient(&self, node: usize) -> &Matrix3 {
        node.checked_sub(1).map_or(&self.outer[0].gradient, |before| &self.steps[before].gradient)
    }

    /// Returns the SI unit of component `row` of the state `z = [ζ, δΠ]`.
    pub(crate) fn unit(&self, row: usize) -> f64 {
        if row < 3 { 1.0 } else { self.units.momentum() }
    }

    /// Returns `J`, which maps rates in rad/s, as a controller measures them, to scaled momenta.
    pub(crate) fn momentum_of_rate(&self) -> Matrix3 {
        self.j * self.units.time
    }

    /// Converts `δJ` so that it maps rates in rad/s to scaled momenta.
    pub(crate) fn scaled_inertia(&self, delta: &Matrix3) -> Matrix3 {
        delta * (self.units.time / self.units.inertia)
    }

    /// Computes `E_k` of a parameter: the change of the state in a step per unit of the parameter
    /// (SI), scaled.
    pub(crate) fn disturbance(&self, step: usize, parameter: &Parameter) -> Vector6 {
        let step = &self.steps[step];
        let error = self.torque_error(&step.applied, parameter);
        // Wheels do not store an external torque.
        let outside = matches!(parameter, Parameter::ConstantTorque(_));
        let stored = if outside { Vector3::zeros() } else { step.kicks[0] * error };
        let mut out = step.after * momenta(&(step.kicks[0] * error)) + momenta(&(step.kicks[1] * error));
        out -= step.wheels * stored;
        if let Parameter::Inertia(delta) = parameter {
            let turned = self.turned(step, delta);
            let attitude: Vector3 = turned.fixed_rows::<3>(0).into_owned();
            out += turned + momenta(&(step.kicks[1] * (step.gradient * attitude)));
        }
        out
    }

    /// Returns the decrease of the wheel momentum in a step per unit of a parameter, scaled.
    pub(crate) fn stored(&self, step: usize, parameter: &Parameter) -> Vector3 {
        match parameter {
            Parameter::ConstantTorque(_) => Vector3::zeros(),
            _ => {
                let step = &self.steps[step];
                self.torque_error(&step.applied, parameter) * step.stage.length
            }
        }
    }

    /// Returns the change of the state per unit of a parameter in the half kick before the first
    /// `z` (`end = 0`) or after the physical end (`end = 1`), scaled.
    pub(crate) fn outer_disturbance(&self, end: usize, parameter: &Parameter) -> Vector6 {
        let HalfKick { weight, applied, .. } = &self.outer[end];
        momenta(&(*weight * self.torque_error(applied, parameter)))
    }

    /// Computes the effect of a change of inertia on a drift: `[ξ; S(Π') ξ]`,
    /// `ξ = −(1/h) B vee(F δJ_d − δJ_d Fᵀ)`.
    fn turned(&self, step: &LinearStep, delta: &Matrix3) -> Vector6 {
        let delta = delta / self.units.inertia;
        let delta_d = Matrix3::from_diagonal_element(0.5 * delta.trace()) - delta;
        let skew = step.drift.f * delta_d - delta_d * step.drift.f.transpose();
        let vee = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
        let xi = -(step.drift_b * vee) / step.drift.h;
        let pi = step.drift.momentum_after.cross(&xi);
        Vector6::new(xi.x, xi.y, xi.z, pi.x, pi.y, pi.z)
    }

    /// Returns the torque error `δτ` per unit of a parameter, scaled.
    fn torque_error(&self, applied: &Applied, parameter: &Parameter) -> Vector3 {
        match parameter {
            Parameter::InputScale(input) => {
                let axis: Vector3 = self.axes.fixed_columns::<1>(*input).into_owned();
                axis * (applied.inputs[*input] / self.units.torque())
            }
            Parameter::ActuatorTurn(axis) => axis.cross(&applied.torque),
            Parameter::ConstantTorque(torque) => torque / self.units.torque(),
            _ => Vector3::zeros(),
        }
    }

    /// Computes `C_k` of a parameter: the change of the measured `z` at a node per unit of the
    /// parameter (SI), scaled. The controller multiplies the measured rate by the nominal inertia.
    /// With torques at nodes it adds half of the commanded kick, whatever kick was really exerted.
    pub(crate) fn measured(&self, node: usize, parameter: &Parameter) -> Vector6 {
        let rate = self.nodes[node].1;
        let (half, applied, gradient) = match (self.timing, node) {
            (Timing::Held, _) => (0.0, &self.outer[0].applied, Matrix3::zeros()),
            (_, 0) => (self.outer[0].weight, &self.outer[0].applied, self.outer[0].gradient),
            _ => {
                let step = &self.steps[node - 1];
                let half = if self.outer[0].weight > 0.0 { 0.5 * step.kicks[1] } else { 0.0 };
                (half, &step.applied, step.gradient)
            }
        };
        let mut out = momenta(&match parameter {
            Parameter::SensorTurn(axis) => half * (gradient * axis),
            Parameter::RateScale(axis) => self.momentum_of_rate().column(*axis) * rate[*axis],
            Parameter::RateBias(bias) => self.momentum_of_rate() * bias,
            Parameter::Inertia(delta) => -(self.scaled_inertia(delta) * rate),
            _ => -half * self.torque_error(applied, parameter),
        });
        if let Parameter::SensorTurn(axis) = parameter {
            out.fixed_rows_mut::<3>(0).copy_from(axis);
        }
        out
    }
}

/// Returns whether a plan records the costates after a full kick at each node (Lie–Verlet), which
/// are half a kick beyond the costates of the motion at the node. Without a force field, and with
/// torques in body axes, the two are equal.
fn records_beyond_nodes(problem: &Problem) -> bool {
    !problem.switches() && problem.scheme.first_input() == 0
}

/// Returns the 6-vector `[0; vector]`, a change of the momentum only.
fn momenta(vector: &Vector3) -> Vector6 {
    Vector6::new(0.0, 0.0, 0.0, vector.x, vector.y, vector.z)
}

/// Returns the 6×6 matrix `[[I, 0], [block, I]]` of a kick.
pub(crate) fn kick(block: &Matrix3) -> Matrix6 {
    let identity = Matrix3::identity();
    blocks([[&identity, &Matrix3::zeros()], [block, &identity]])
}

impl LinearStep {
    /// Returns a step in which only the applied torque is set and all matrices are zero.
    fn of(applied: Applied) -> Self {
        let zero = Matrix3::zeros();
        let still = Vector3::zeros();
        Self {
            stage: Stage::none(),
            to_inputs: DMatrix::zeros(applied.inputs.len(), 3),
            applied,
            kicks: [0.0; 2],
            drift: Drift { h: 0.0, f: zero, momentum: still, momentum_after: still },
            drift_b: zero,
            after: Matrix6::zeros(),
            wheels: Matrix6x3::zeros(),
            with_wheels: None,
            gradient: zero,
        }
    }
}

fn blocks(of: [[&Matrix3; 2]; 2]) -> Matrix6 {
    Matrix6::from_fn(|row, column| of[row / 3][column / 3][(row % 3, column % 3)])
}
