//! The maneuver as a chain of stages with states, inputs and a step map, in scaled units.
//!
//! ```text
//! y_0 = kick_0(start, u_0) ,    y_{k+1} = kick_{k+1}(drift(y_k), u_{k+1}) ,    y_N = target
//! cost Σ κ_k ½ u_kᵀ W u_k
//! ```
//!
//! Kick k has the weight κ_k of the grid; Lie–Euler has no `u_0`. The step map is that of the
//! planner, so a trajectory without defects satisfies the variational integrator. Between kicks a
//! Lie–Verlet state is half a kick ahead of the physical state.
//!
//! Tangent vectors are ordered as in the rest of the crate, the wheels' momenta appended.
//!
//! If the duration is free, the state has one more component: `s`, the duration as a multiple of
//! the stated one. Every step keeps it constant, and it is free at the start. All other quantities
//! are in units that scale with the duration itself, so that a step of a free body does not depend
//! on it. The ends, the environment, the rotation of the reference frame and the limits do:
//!
//! ```text
//! Π_0 = s Π_start ,   Π_N = s Π_end ,   the same of wheels ;     torque of the environment s² M(R) ;
//! R_{k+1} = exp(−h s S(n)) R_k F_k in a frame that turns by n in the stated duration ;
//! |u| ≤ s² u_max ,    |Δu| ≤ s³ u̇_max h ,    |Ω| ≤ s Ω_max ,    |h_i| ≤ s h_max
//! ```
//!
//! The last component of a tangent vector is the change of `ln s`. The cost is `w s`, or with fuel
//!
//! ```text
//! Σ κ_k Σ_j c_j |u_j| / s + w s ,     with c |B u| in the place of the terms of a set under a limit of its norm,
//! ```
//!
//! If effort itself is the cost, it scales in these units as `Σ κ_k ½ u_kᵀ W u_k / s³`.
//!
//! # Where do step and kick of the chain come from?
//!
//! They come from `optimize/discrete/step`, as those of the shooting do: the drift and the
//! gyrostat's drift, their derivative ξ, and the kick of given inputs with its gradient. Two things
//! differ: force and moment are variables here and follow from an optimal law there, and wheels are
//! states here. Both run on nonuniform grids. The kick of the optimal law computes its gradient
//! separately, adding the derivative of the inputs before that of the force field: the sum is equal
//! except for its last bits.

pub(crate) mod goal;
pub(crate) mod state;
pub(crate) mod step;

use crate::Vector3;
use crate::maneuver::problem::{Motion, Problem, State};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, InputLimit, LimitKind};
use crate::optimize::discrete::step::{Costate, Dynamics};
use crate::optimize::discrete::terminal::TerminalCondition;
pub(crate) use goal::{FuelPrice, Goal};
use nalgebra::{DMatrix, DVector, Matrix3xX, SVector};
pub(crate) use state::{ChainState, costate_blocks};

/// Quadratic penalty on an input of one stage: `½ weight (u − at)²` is added to the objective of a
/// solver, but not to the cost of a plan. The penalty vanishes if the input has the value `at`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    pub stage: usize,
    pub input: usize,
    pub at: f64,
    pub weight: f64,
}

/// Model of the chain: dynamics, dimensions, objective and boundary conditions.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub dynamics: Dynamics,
    /// Dimension of the tangent space of a state.
    pub n: usize,
    /// Number of inputs of a stage.
    pub m: usize,
    /// Index of `ln s` in a tangent vector; `None` if the duration is fixed.
    pub duration: Option<usize>,
    /// Scaled cost of one unit of time (the time weight).
    pub time_price: f64,
    /// Prices of fuel; `None` if fuel is not part of the objective.
    pub fuel: Option<FuelPrice>,
    /// Factor from the user's cost to the cost of the chain; 1 if the objective is effort in a
    /// fixed duration.
    pub cost_scale: f64,
    /// Number of wheels.
    pub wheels: usize,
    pub steps: usize,
    /// Mean length of the steps, scaled.
    pub h: f64,
    /// Start and end state for the duration of the problem, scaled.
    pub start: ChainState,
    pub target: ChainState,
    terminal: TerminalCondition,
    /// Weight `W` of the effort, m×m, scaled.
    pub weight: DMatrix<f64>,
    /// Quadratic penalties on inputs, ordered by stage.
    pub pulls: Vec<Pull>,
    /// Exponent of the duration `s` in the effort.
    pub effort_power: i32,
    /// SI units of the inputs [N or N·m].
    pub input_unit: Vec<f64>,
    /// Number of force inputs, which come first.
    pub forces: usize,
    force: Option<ActuatorSet>,
    /// Torque inputs. If thrusters produce force and torque at once, these are also the force
    /// inputs, scaled by the unit of force.
    torque: ActuatorSet,
    /// Index of the first torque input.
    first_torque: usize,
    /// Axes of the wheels, equal to the axes of the torque inputs; no columns if the body has no
    /// wheels.
    pub(in crate::optimize::chain) wheel_axes: Matrix3xX<f64>,
    pub(in crate::optimize::chain) moves: bool,
}

impl Model {
    /// Builds the chain of a maneuver on a uniform grid of `steps` steps.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        Self::of(problem, Dynamics::new(problem, steps))
    }

    /// Builds the chain of a discretised maneuver.
    pub fn of(problem: &Problem, dynamics: Dynamics) -> Self {
        let units = dynamics.units;
        let moves = problem.motion == Motion::RigidBody;
        let weights = problem.objective.weights();
        let force = weights.force(&problem.actuation).filter(|_| moves).map(|force| (force, units.force()));
        let both = moves && problem.actuation.thrusters.is_some();
        let torque = Some((weights.torque(&problem.actuation), units.torque())).filter(|_| !both);
        let sets = force.into_iter().chain(torque);
        let force = problem.actuation.force.as_ref().filter(|_| moves);
        let forces = force.map_or(0, ActuatorSet::count);
        let first_torque = if both { 0 } else { forces };
        let m = first_torque + problem.actuation.torque.count();
        let mut input_unit = Vec::with_capacity(m);
        let mut weight = DMatrix::zeros(m, m);
        let scale = units.time / units.cost;
        for (inputs, unit) in sets {
            let (first, count) = (input_unit.len(), inputs.set.count());
            input_unit.resize(first + count, unit);
            let own = inputs.weight * (unit * unit * scale);
            weight.view_mut((first, first), (count, count)).copy_from(&own);
        }
        let stored = problem.actuation.wheels.as_ref().map_or(&[][..], |wheels| &wheels.momentum);
        let wheels = stored.len();
        let torque = &problem.actuation.torque;
        let torque = if both { torque.scaled(units.force() / units.torque()) } else { torque.clone() };
        let mut model = Self {
            n: if moves { 12 } else { 6 + wheels },
            m,
            duration: None,
            time_price: 0.0,
            fuel: None,
            cost_scale: 1.0,
            wheels,
            steps: dynamics.grid.steps(),
            h: dynamics.grid.mean_step(),
            start: ChainState::of(&dynamics.point(&problem.start), DVector::zeros(wheels)),
            target: ChainState::of(&dynamics.point(&problem.end), DVector::zeros(wheels)),
            terminal: TerminalCondition::of(&problem.end_condition, dynamics.point(&problem.end)),
            weight,
            pulls: Vec::new(),
            effort_power: 0,
            input_unit,
            forces,
            force: force.cloned(),
            wheel_axes: Matrix3xX::from_columns(torque.axes()).columns(0, wheels).into_owned(),
            torque,
            first_torque,
            moves,
            dynamics,
        };
        model.start.wheels = DVector::from_column_slice(stored) / units.momentum();
        model.start.momentum += model.wheel_momentum(&model.start.wheels);
        model
    }

    /// Replaces the end state, given in SI units.
    pub fn aim(&mut self, end: &State) {
        let point = self.dynamics.point(end);
        self.target = ChainState::of(&point, DVector::zeros(self.wheels));
        self.terminal = self.terminal.aimed(point);
    }

    /// Returns the largest allowed magnitude of each input, scaled; infinite if the input has no
    /// limit.
    pub fn input_bounds(&self, problem: &Problem) -> Vec<f64> {
        let mut limits = vec![f64::INFINITY; self.m];
        for InputLimit { kind, of_force, bounds, .. } in problem.actuation.limits() {
            let (axes, first) = self.channel(of_force);
            for (index, axis) in axes.iter().enumerate() {
                let bound = match kind {
                    LimitKind::Size => bounds[index],
                    LimitKind::Norm => bounds[0] / axis.norm(),
                    LimitKind::Rate | LimitKind::WheelMomentum => f64::INFINITY,
                };
                limits[first + index] = limits[first + index].min(bound / self.input_unit[first + index]);
            }
        }
        limits
    }

    /// Returns the start state of a maneuver that takes `stretch` times the duration of the
    /// problem.
    pub fn start_in(&self, stretch: f64) -> ChainState {
        self.start.hastened(stretch)
    }

    /// Returns the end state of a maneuver that takes `stretch` times the duration of the problem.
    pub fn target_in(&self, stretch: f64) -> ChainState {
        self.target.hastened(stretch)
    }

    /// Returns the index of the first component of the rotation ζ in a tangent vector.
    pub fn zeta(&self) -> usize {
        if self.moves { 6 } else { 0 }
    }

    /// Returns the index of the first component of the momentum change δΠ in a tangent vector.
    pub fn pi(&self) -> usize {
        self.zeta() + 3
    }

    /// Returns the index of the first stage that has inputs.
    pub fn first_input(&self) -> usize {
        self.dynamics.grid.first_input()
    }

    /// Returns the quadratic penalties on the inputs of a stage.
    pub fn pulls_of(&self, stage: usize) -> &[Pull] {
        let first = |stage: usize| self.pulls.partition_point(|pull| pull.stage < stage);
        &self.pulls[first(stage)..first(stage + 1)]
    }

    /// Returns the weight κ_k of kick k.
    pub fn kick_weight(&self, stage: usize) -> f64 {
        self.dynamics.grid.kick(stage)
    }

    /// Returns the factor of a stage's effort in a maneuver that takes `stretch` times the duration
    /// of the problem.
    pub fn effort_weight(&self, stage: usize, stretch: f64) -> f64 {
        self.kick_weight(stage) * stretch.powi(self.effort_power)
    }

    /// Returns the weight of the part of kick k that the chain's state includes and the physical
    /// state does not.
    pub fn lag(&self, stage: usize) -> f64 {
        if stage < self.steps { self.dynamics.grid.ahead(stage) } else { 0.0 }
    }

    /// Returns the momentum of all wheels, `Σ a_i h_i`, scaled.
    pub fn wheel_momentum(&self, momenta: &DVector<f64>) -> Vector3 {
        self.wheel_axes.column_iter().zip(momenta.iter()).map(|(axis, momentum)| axis * *momentum).sum()
    }

    /// Returns the axes of the force inputs or of the torque inputs, and the index of the first of
    /// them among all inputs.
    pub fn channel(&self, forces: bool) -> (&[Vector3], usize) {
        if forces {
            (self.force.as_ref().map_or(&[], ActuatorSet::axes), 0)
        } else {
            (self.torque.axes(), self.first_torque)
        }
    }

    /// Returns [`Model::channel`] if the axes of the inputs rotate relative to the coordinates of
    /// their momenta; `None` otherwise.
    pub fn turning(&self, forces: bool) -> Option<(&[Vector3], usize)> {
        let turns = if forces {
            self.force.as_ref().is_some_and(|set| set.frame() == AxisFrame::Body)
        } else {
            self.torque.frame() == AxisFrame::Reference
        };
        turns.then(|| self.channel(forces))
    }

    /// Returns whether only the inputs act on the body.
    pub fn is_free(&self) -> bool {
        self.dynamics.is_free()
    }

    /// Returns the number of terminal conditions.
    pub fn terminal_count(&self) -> usize {
        self.given().len()
    }

    /// Returns the components of a chain's state, without wheel momenta, that are prescribed at the
    /// end.
    pub fn given(&self) -> Vec<usize> {
        self.terminal.given(if self.moves { 12 } else { 6 })
    }

    /// Returns the terminal error of a chain's last state: 6 components on SO(3) and 12 on SE(3),
    /// zero for free components.
    pub fn terminal_error(&self, state: &ChainState) -> DVector<f64> {
        let body = if self.moves { 12 } else { 6 };
        // The multipliers of these equations are the costate, so the transversality conditions are
        // left out.
        let costate = Costate::from_vector(&SVector::<f64, 12>::zeros());
        let error = self.terminal.value::<12>(&state.point(), &costate);
        let mut error = DVector::from_column_slice(&error.as_slice()[12 - body..]);
        if self.duration.is_some() {
            let [momenta, stated] =
                [&self.target_in(state.stretch), &self.target].map(|target| state::momenta(self, target));
            error -= (momenta - stated).rows(0, body);
        }
        if self.wheels > 0 {
            let mut rows = error.rows_mut(3, 3);
            rows -= self.wheel_momentum(&state.wheels);
        }
        error
    }
}
