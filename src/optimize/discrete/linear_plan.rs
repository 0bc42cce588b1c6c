//! The motion beside a plan, to first order: `A_k`, `B_k`, the curvature `H_k` of the Lagrangian,
//! and what the inputs can still give.
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
//! What a torque in the first kick adds to the costates, and what the state adds to its optimum,
//! stands in `linear_plan::stage`; bodies that translate and torques fixed in the reference frame
//! in `linear_plan::posed`.
//!
//! [`Timing::Held`]: `w₀ = w₁ = h/2`, a torque held over the step. It is the linearised Lie–Verlet
//! flow of the motion that is flown, of second order in the step, and its `z` has the physical
//! momenta at the nodes.
//! [`Timing::AtNodes`]: `w₀ = 0`, and `w₁` the full kick at the node that the step leads to. It is
//! the discrete problem itself, exactly; its momenta are those after a full kick, and half a kick
//! leads there from the physical start, and back at the end.

//!
//! Reaction wheels store the reaction of what they give. Their momentum `μ`, body axes, is then a
//! state of its own beside `z`:
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

/// Six by six: tangent vectors `[ζ, δΠ]`.
pub type Matrix6 = SMatrix<f64, 6, 6>;
/// Nine by nine: with what wheels store, `[ζ, δΠ, δμ]`.
pub type Matrix9 = SMatrix<f64, 9, 9>;
/// Six by three: the answer of the state to torques.
pub type Matrix6x3 = SMatrix<f64, 6, 3>;
/// A tangent vector `[ζ, δΠ]`.
pub type Vector6 = SVector<f64, 6>;

/// When a correction of the torque acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Held over the step that begins with the measurement: what is flown.
    Held,
    /// A full kick at the node that the step leads to: the discrete problem of the planner.
    AtNodes,
}

/// Why the motion beside a plan is not linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unlinearised {
    /// The body translates.
    #[error("the body translates: covariances are those of attitude and rate")]
    Translation,
    /// Wheels drive it, and torques act at nodes.
    #[error(
        "reaction wheels drive the body: the discrete problem of torques at nodes has no costates of them"
    )]
    Wheels,
    /// Torques are fixed in the reference frame.
    #[error("the torques are fixed in the reference frame")]
    Frame,
    /// Thrusters give force and torque at once.
    #[error(
        "its thrusters give force and torque at once: forces and torques are corrected by inputs of their own"
    )]
    Thrusters,
    /// The plan has no trajectory, or one that does not fit the maneuver.
    #[error("the plan has no trajectory on the grid of the maneuver")]
    Trajectory,
    /// A step of it has no drift.
    #[error("a step of the plan is too long for its momentum, or a number is not finite")]
    Step,
    /// The plan has more than 100,000 steps.
    #[error("the plan has more than {MOST_STEPS} steps: each has matrices of some kilobytes")]
    Fine,
    /// Inputs switch on a grid of the discrete problem.
    #[error("inputs that switch are held over steps, and have no values at nodes")]
    Switching,
}

/// The largest number of steps of a plan that is linearised.
pub(crate) const MOST_STEPS: usize = 100_000;

impl From<StepError> for Unlinearised {
    fn from(_: StepError) -> Self {
        Self::Step
    }
}

/// One step beside a plan, in the solver's units.
#[derive(Clone, Debug)]
pub(crate) struct LinearStep {
    /// Its matrices, for torques about the body axes; the authority is that of the inputs that are
    /// not at their limits.
    pub stage: Stage<6, 3>,
    /// `W⁻¹Bᵀ` of these, m×3: of a scaled dual torque, in SI.
    pub to_inputs: DMatrix<f64>,
    /// What the plan gives in its kicks.
    applied: Applied,
    /// Weights of the kicks before and after the drift.
    kicks: [f64; 2],
    /// Length, relative attitude `F`, `B` and momentum `Π'` of the drift.
    drift: Drift,
    drift_b: Matrix3,
    /// `K₁ D`, what follows the first kick.
    after: Matrix6,
    /// `M_k`, the answer to the momentum of wheels; zero where there are none.
    pub wheels: Matrix6x3,
    /// Its matrices with what wheels store as states beside, where there are some:
    /// `δμ' = δμ − h δτ`.
    pub with_wheels: Option<Box<Stage<9, 3>>>,
    /// `∂M/∂R` in the second kick.
    gradient: Matrix3,
}

/// Inputs of the torques, SI, and the torque that they give, body axes, scaled.
#[derive(Clone, Debug)]
struct Applied {
    inputs: Vec<f64>,
    torque: Vector3,
}

/// Half a kick between a physical state and the `z` beside it.
#[derive(Clone, Debug)]
struct HalfKick {
    /// Its weight, 0 where torques are held.
    weight: f64,
    applied: Applied,
    /// `∂M/∂R` there.
    gradient: Matrix3,
}

/// The motion beside a plan, to first order.
#[derive(Clone, Debug)]
pub struct LinearPlan {
    timing: Timing,
    units: Units,
    /// `J`, scaled.
    j: Matrix3,
    steps: Vec<LinearStep>,
    /// Between the physical start and the first `z`, and between the last `z` and the physical end.
    outer: [HalfKick; 2],
    times: Vec<f64>,
    /// Attitude and angular velocity of the plan at its nodes, SI.
    nodes: Vec<(Matrix3, Vector3)>,
    /// Axes of the inputs, 3×m, SI.
    axes: Matrix3xX<f64>,
    /// What wheels store at the nodes, body axes, scaled; none without any.
    stored: Vec<Vector3>,
    /// Nodes before the last one at which the craft has to meet the motion, in ascending order.
    stops: Vec<usize>,
}

/// What an uncertain number of a maneuver multiplies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// The symmetric `δJ` per unit, body axes; the moments of a field are taken to be those of the
    /// nominal body.
    Inertia(Matrix3),
    /// Part by which input `i` gives more than it should.
    InputScale(usize),
    /// Turn of all actuators about a body axis \[rad\]: `τ = exp S(α) B u`.
    ActuatorTurn(Vector3),
    /// A constant torque, body axes [N·m].
    ConstantTorque(Vector3),
    /// Turn of the attitude sensor about a body axis \[rad\]: `R exp S(β)` is measured.
    SensorTurn(Vector3),
    /// Part by which the rate about an axis is measured too large.
    RateScale(usize),
    /// A constant error of the measured rate [rad/s].
    RateBias(Vector3),
}

impl LinearPlan {
    /// Linearises the motion beside `plan`, a trajectory of `problem` on its own grid
    /// ([`Solution::on_grid`]). Where torques are held ([`Timing::Held`]) its costates are taken
    /// for those at its nodes.
    ///
    /// [`Solution::on_grid`]: crate::maneuver::Solution::on_grid
    ///
    /// # Errors
    /// [`Unlinearised`]: of bodies that translate, wheels, torques fixed in the reference frame, or
    /// a trajectory that does not fit.
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

    /// Whether a plan can be linearised beside.
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

    /// The motion beside the one that is flown: the true motion under the plan's inputs, held over
    /// the steps.
    ///
    /// # Errors
    /// As [`LinearPlan::new`].
    pub fn flown(problem: &Problem, plan: &Trajectory) -> Result<Self, Unlinearised> {
        Self::fits(problem, plan)?;
        let recorded = Flight::recorded(problem, plan).ok_or(Unlinearised::Step)?;
        let beyond = records_beyond_nodes(problem);
        Beside { problem, plan: &recorded, timing: Timing::Held, count: plan.time.len() - 1, beyond }
            .linearise()
    }

    /// Linearises the motion about a recorded motion of `problem`, which holds one row of inputs
    /// over each of its steps ([`Stepping::Recorded`]). The craft has to meet it at its end and at
    /// `stops`, nodes in ascending order.
    ///
    /// [`Stepping::Recorded`]: crate::maneuver::Stepping::Recorded
    ///
    /// # Errors
    /// As [`LinearPlan::new`].
    pub fn recorded(problem: &Problem, motion: &Trajectory, stops: Vec<usize>) -> Result<Self, Unlinearised> {
        Self::fits(problem, motion)?;
        let count = motion.time.len() - 1;
        let beside = Beside { problem, plan: motion, timing: Timing::Held, count, beyond: false };
        Ok(Self { stops, ..beside.linearise()? })
    }

    /// Returns the nodes before the last one at which the craft has to meet the motion, in ascending
    /// order; none along the plan of one maneuver.
    pub fn stops(&self) -> &[usize] {
        &self.stops
    }

    /// Number of steps.
    pub fn count(&self) -> usize {
        self.steps.len()
    }

    /// When corrections act.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Times of the nodes \[s\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Whether reaction wheels give the torques.
    pub fn has_wheels(&self) -> bool {
        !self.stored.is_empty()
    }

    /// What the wheels store at a node, body axes [N·m·s]; zero without any.
    pub fn wheel_momentum(&self, node: usize) -> Vector3 {
        self.stored.get(node).map_or_else(Vector3::zeros, |stored| stored * self.units.momentum())
    }

    /// Attitude and angular velocity [rad/s] of the plan at a node.
    pub fn node(&self, index: usize) -> (&Matrix3, &Vector3) {
        let (attitude, rate) = &self.nodes[index];
        (attitude, rate)
    }

    /// Inputs of the plan in a step, those of the torques, SI.
    pub fn inputs(&self, step: usize) -> &[f64] {
        &self.steps[step].applied.inputs
    }

    /// The axes of the inputs, `B`, 3×m, SI.
    pub fn axes(&self) -> &Matrix3xX<f64> {
        &self.axes
    }

    /// `A_k`, in rad and N·m·s.
    pub fn a(&self, step: usize) -> Matrix6 {
        let scaled = &self.steps[step].stage.a;
        Matrix6::from_fn(|row, column| scaled[(row, column)] * self.unit(row) / self.unit(column))
    }

    /// `B_k`, in rad and N·m·s for each N·m.
    pub fn b(&self, step: usize) -> Matrix6x3 {
        let scaled = &self.steps[step].stage.b;
        Matrix6x3::from_fn(|row, column| scaled[(row, column)] * self.unit(row) / self.units.torque())
    }

    /// `H_k`: the curvature of the Lagrangian along the state, in the unit of the cost over rad and
    /// N·m·s.
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

    /// `K₊`, from the physical start to the first `z`, scaled.
    pub(crate) fn first(&self) -> Matrix6 {
        kick(&(self.outer[0].weight * self.outer[0].gradient))
    }

    /// `K₋`, from the last `z` to the physical end, scaled.
    pub(crate) fn last(&self) -> Matrix6 {
        kick(&(-self.outer[1].weight * self.outer[1].gradient))
    }

    /// What of a torque in the first half kick comes before the first `z` (0), or in the last kick
    /// after the end (1), scaled.
    pub(crate) fn half_kick(&self, end: usize) -> f64 {
        self.outer[end].weight
    }

    /// `∂M/∂R` at a node, scaled.
    pub(crate) fn field_gradient(&self, node: usize) -> &Matrix3 {
        node.checked_sub(1).map_or(&self.outer[0].gradient, |before| &self.steps[before].gradient)
    }

    /// Unit of component `row` of `z`.
    pub(crate) fn unit(&self, row: usize) -> f64 {
        if row < 3 { 1.0 } else { self.units.momentum() }
    }

    /// `J`, scaled, for rates in rad/s: a controller knows rates.
    pub(crate) fn momentum_of_rate(&self) -> Matrix3 {
        self.j * self.units.time
    }

    /// `δJ`, scaled, for rates in rad/s.
    pub(crate) fn scaled_inertia(&self, delta: &Matrix3) -> Matrix3 {
        delta * (self.units.time / self.units.inertia)
    }

    /// `E_k` of a parameter: what one unit of it (SI) adds to the state in a step, scaled.
    pub(crate) fn disturbance(&self, step: usize, parameter: &Parameter) -> Vector6 {
        let step = &self.steps[step];
        let error = self.torque_error(&step.applied, parameter);
        // Wheels do not store what comes from outside.
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

    /// What one unit of a parameter takes from the momentum of the wheels in a step, scaled.
    pub(crate) fn stored(&self, step: usize, parameter: &Parameter) -> Vector3 {
        match parameter {
            Parameter::ConstantTorque(_) => Vector3::zeros(),
            _ => {
                let step = &self.steps[step];
                self.torque_error(&step.applied, parameter) * step.stage.length
            }
        }
    }

    /// What one unit of a parameter adds in the half kick before the first `z` (0), or in that
    /// after the end (1), scaled.
    pub(crate) fn outer_disturbance(&self, end: usize, parameter: &Parameter) -> Vector6 {
        let HalfKick { weight, applied, .. } = &self.outer[end];
        momenta(&(*weight * self.torque_error(applied, parameter)))
    }

    /// What a change of the inertia alone does to a drift: `[ξ; S(Π') ξ]`,
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

    /// `δτ` of one unit of a parameter, scaled.
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

    /// `C_k` of a parameter: what one unit of it (SI) adds to the measured `z` at a node, scaled.
    /// Who measures multiplies the rate by the nominal inertia; beside torques at nodes, half of
    /// the kick that was commanded is added, whatever was given.
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

/// Whether a plan records the costates that follow a full kick at each node (Lie–Verlet), and not
/// those of the motion at the node: these are half a kick before. Without a field, and with torques
/// in body axes, the two are the same.
fn records_beyond_nodes(problem: &Problem) -> bool {
    !problem.switches() && problem.scheme.first_input() == 0
}

/// `[0; vector]`.
fn momenta(vector: &Vector3) -> Vector6 {
    Vector6::new(0.0, 0.0, 0.0, vector.x, vector.y, vector.z)
}

/// `[[I, 0], [block, I]]`.
pub(crate) fn kick(block: &Matrix3) -> Matrix6 {
    let identity = Matrix3::identity();
    blocks([[&identity, &Matrix3::zeros()], [block, &identity]])
}

impl LinearStep {
    /// A step of which only what is given is known.
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
