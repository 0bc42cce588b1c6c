//! The maneuver as a chain of stages: states, inputs, one step with its matrices, in scaled units.
//!
//! ```text
//! y_0 = kick_0(start, u_0) ,    y_{k+1} = kick_{k+1}(drift(y_k), u_{k+1}) ,    y_N = target
//! cost Σ κ_k ½ u_kᵀ W u_k
//! ```
//!
//! Kick k has the weight κ_k of the grid; Lie–Euler has no `u_0`. The map is the planner's own, so a trajectory
//! without defects is variational. Between kicks a Lie–Verlet state is half a step's kick ahead of the physical one.
//!
//! Tangent vectors are ordered as in the rest of the crate, the wheels' momenta appended.
//!
//! Where the duration is sought it is a state more: `s`, as a multiple of the stated one, which every step leaves as it is
//! and which is free at the start. All other quantities are in the units that go with the duration itself, so that a step
//! of a free body does not know it. What does are the ends, what acts on the body, how far the reference frame turns, and
//! the limits:
//!
//! ```text
//! Π_0 = s Π_start ,   Π_N = s Π_end ,   the same of wheels ;     torque of the environment s² M(R) ;
//! R_{k+1} = exp(−h s S(n)) R_k F_k in a frame that turns by n in the stated duration ;
//! |u| ≤ s² u_max ,    |Δu| ≤ s³ u̇_max h ,    |Ω| ≤ s Ω_max ,    |h_i| ≤ s h_max
//! ```
//!
//! The last component of a tangent vector is the change of `ln s`. The cost is `w s`, or that of fuel as well,
//!
//! ```text
//! Σ κ_k Σ_j c_j |u_j| / s + w s ,     with c |B u| in the place of the terms of a set under a limit of its norm,
//! ```
//!
//! and a little effort beside it, which decides where these leave a choice. Where effort itself is the cost it goes in these
//! units as `Σ κ_k ½ u_kᵀ W u_k / s³`.

use crate::lie::{self, hat};
use crate::maneuver::objective::{self, Fuel, Objective};
use crate::maneuver::problem::{Motion, Problem};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, InputLimit, LimitKind};
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::numerics::compensated::Sum;
use crate::optimize::step::{Costate, Dynamics, Point, StepError};
use crate::optimize::terminal::TerminalCondition;
use crate::{Matrix3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix3xX, SVector};

/// What the stated duration costs where time is all that counts: costs are of order ten.
const TIME_PRICE: f64 = 100.0;
/// What a unit of impulse of the dearest input costs where fuel counts: a turn by about a radian takes a few units.
const FUEL_PRICE: f64 = 10.0;
/// Scaled effort of a turn by about a radian.
const TYPICAL_EFFORT: f64 = 10.0;
/// Change of `ln s` that counts as much as a turn by a radian.
pub(crate) const STRETCHED: f64 = 0.5;

/// What a chain minimises in place of the effort.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// Time or fuel, or effort with a price of time. The duration is sought where time counts.
    pub objective: Objective,
    /// Share of the effort beside time or fuel.
    pub share: f64,
}

impl Goal {
    /// The same for the duration that a plan has; none where time alone counts.
    pub fn in_given_duration(&self) -> Option<Self> {
        let fuel = self.objective.fuel()?;
        let objective = Objective::Fuel(Fuel { time_price: None, ..fuel.clone() });
        Some(Self { objective, ..self.clone() })
    }
}

/// What fuel costs in a chain.
#[derive(Clone, Debug)]
pub(crate) struct FuelPrice {
    /// Of each input; of a set that is counted by its norm each has the price of that.
    pub inputs: Vec<f64>,
    /// Whether it is `c |B u|` instead of `Σ c_j |u_j|`: of the torques, and of the forces.
    pub of_norm: [bool; 2],
}

impl FuelPrice {
    /// Whether forces or torques are counted by their norm.
    pub fn is_of_norm(&self, forces: bool) -> bool {
        self.of_norm[usize::from(forces)]
    }
}

/// A state of the chain, scaled. With wheels, `momentum` is the total one.
#[derive(Clone, Debug)]
pub(crate) struct ChainState {
    pub position: Vector3,
    pub linear_momentum: Vector3,
    pub attitude: Matrix3,
    pub momentum: Vector3,
    pub wheels: DVector<f64>,
    /// Duration as a multiple of the stated one: 1 where it is not sought.
    pub stretch: f64,
}

/// The chain.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub dynamics: Dynamics,
    /// The same without inputs.
    pub unforced: Dynamics,
    /// Tangent dimension of a state.
    pub n: usize,
    /// Number of inputs.
    pub m: usize,
    /// Where `ln s` stands in a tangent vector, if the duration is sought.
    pub duration: Option<usize>,
    /// What a unit of time costs.
    pub time_price: f64,
    /// What fuel costs, where it does.
    pub fuel: Option<FuelPrice>,
    /// The user's unit of cost where that is not the effort: a cost of the chain is this times the user's.
    pub cost_scale: f64,
    /// Number of wheels.
    pub wheels: usize,
    pub steps: usize,
    /// Mean step.
    pub h: f64,
    /// Start and end in the stated duration.
    pub start: ChainState,
    pub target: ChainState,
    terminal: TerminalCondition,
    /// `W`, m×m, scaled.
    pub weight: DMatrix<f64>,
    /// Power of the duration with which the effort goes: 0 where that is a share beside another cost.
    pub effort_power: i32,
    /// Units of the inputs [N or N·m].
    pub input_unit: Vec<f64>,
    /// Number of force inputs, which come first.
    pub forces: usize,
    force: Option<ActuatorSet>,
    /// Of thrusters the same inputs in the unit of force.
    torque: ActuatorSet,
    /// The first of the torque inputs.
    first_torque: usize,
    /// Axes of the wheels, those of the torque inputs; none without wheels.
    wheel_axes: Matrix3xX<f64>,
    moves: bool,
}

/// One step and its matrices: `z⁺ = A z + B δu`.
pub(crate) struct Step {
    pub end: ChainState,
    pub a: DMatrix<f64>,
    pub b: DMatrix<f64>,
    pub arc: Arc,
}

/// How the body turns on a step.
pub(crate) struct Arc {
    /// Rotation vector, `log F`.
    pub turn: Vector3,
    /// Its derivative with respect to the state before, 3×n.
    pub slope: Matrix3xX<f64>,
}

/// The opening kick: `y_0`, and its derivatives with respect to `u_0`, n×m, and to `ln s`.
pub(crate) struct Opening {
    pub end: ChainState,
    pub by_inputs: DMatrix<f64>,
    pub by_duration: DVector<f64>,
}

/// The relative attitude `F` of a drift, and `ξ` of `δF = F S(ξ)` by the state before, 3×n.
struct DriftArc {
    f: Matrix3,
    turn: Matrix3xX<f64>,
}

/// A kick at one pose: `momenta += κ (value)`, with derivatives before the weight κ.
struct Kick {
    wrench: Wrench,
    /// What the environment has in it.
    field: Wrench,
    gradient: Blocks,
    /// n×m.
    inputs: DMatrix<f64>,
}

impl Model {
    /// The chain of a maneuver on `steps` steps of equal length.
    pub fn new(problem: &Problem, steps: usize) -> Self {
        Self::of(problem, Dynamics::new(problem, steps))
    }

    /// The chain of a discretised maneuver.
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
            terminal: TerminalCondition::State(dynamics.point(&problem.end)),
            weight,
            effort_power: 0,
            input_unit,
            forces,
            force: force.cloned(),
            wheel_axes: Matrix3xX::from_columns(torque.axes()).columns(0, wheels).into_owned(),
            torque,
            first_torque,
            moves,
            unforced: dynamics.without_inputs(),
            dynamics,
        };
        model.start.wheels = DVector::from_column_slice(stored) / units.momentum();
        model.start.momentum += model.wheel_momentum(&model.start.wheels);
        model
    }

    /// The chain of a maneuver with a goal. Of least time or fuel its cost is what these cost, scaled, and a share of what the inputs
    /// cost, as a part of what they would cost at their limits throughout.
    pub fn with_goal(problem: &Problem, steps: usize, goal: &Goal) -> Self {
        let mut model = Self::new(problem, steps);
        let (stated, time_price) = (model.dynamics.units.time, goal.objective.time_price());
        if goal.objective.counts_time() {
            model.duration = Some(model.n);
            model.n += 1;
        }
        if let Objective::Effort(_) = goal.objective {
            model.cost_scale = 1.0 / model.dynamics.units.cost;
            model.time_price = model.cost_scale * time_price * stated;
            model.effort_power = -3;
            return model;
        }
        let prices = goal.objective.fuel().map(|fuel| model.fuel_prices(fuel));
        let dearest = prices.iter().flatten().copied().fold(0.0, f64::max);
        model.cost_scale = TIME_PRICE / (TIME_PRICE / FUEL_PRICE * dearest + time_price * stated);
        model.time_price = model.cost_scale * time_price * stated;
        model.fuel = prices.map(|prices| FuelPrice {
            inputs: prices.iter().map(|price| price * model.cost_scale).collect(),
            of_norm: [Fuel::is_of_norm(&model.torque), model.force.as_ref().is_some_and(Fuel::is_of_norm)],
        });
        let limits = model.input_bounds(problem);
        let most: f64 = (0..model.m).map(|i| 0.5 * model.weight[(i, i)] * limits[i] * limits[i]).sum();
        model.weight *= goal.share * TIME_PRICE / if most.is_finite() { most } else { TYPICAL_EFFORT };
        model
    }

    /// What a unit of each input costs over the stated duration, in the user's unit.
    fn fuel_prices(&self, fuel: &Fuel) -> Vec<f64> {
        let price = |input: usize| match input.checked_sub(self.forces) {
            Some(torque) => fuel.price(torque),
            None => fuel.force_price(input),
        };
        (0..self.m).map(|input| price(input) * self.input_unit[input] * self.dynamics.units.time).collect()
    }

    /// How large each input can be, scaled; infinite where nothing limits it.
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

    /// The start of a maneuver that takes `stretch` times the stated duration.
    pub fn start_in(&self, stretch: f64) -> ChainState {
        self.start.hastened(stretch)
    }

    /// Its end.
    pub fn target_in(&self, stretch: f64) -> ChainState {
        self.target.hastened(stretch)
    }

    /// Row of ζ in a tangent vector.
    pub fn zeta(&self) -> usize {
        if self.moves { 6 } else { 0 }
    }

    /// Row of δΠ in a tangent vector.
    pub fn pi(&self) -> usize {
        self.zeta() + 3
    }

    /// First stage that has inputs.
    pub fn first_input(&self) -> usize {
        self.dynamics.grid.first_input()
    }

    /// Weight κ_k of kick k.
    pub fn kick_weight(&self, stage: usize) -> f64 {
        self.dynamics.grid.kick(stage)
    }

    /// What a stage's effort is multiplied by in a maneuver that takes `stretch` times the stated duration.
    pub fn effort_weight(&self, stage: usize, stretch: f64) -> f64 {
        self.kick_weight(stage) * stretch.powi(self.effort_power)
    }

    /// `κ_k W`, the curvature of the cost of a stage's inputs. Lie–Euler has no `u_0`: any weight keeps it where it is.
    pub fn input_weight(&self, stage: usize, stretch: f64) -> DMatrix<f64> {
        let weight = self.effort_weight(stage, stretch);
        if weight > 0.0 { &self.weight * weight } else { DMatrix::identity(self.m, self.m) }
    }

    /// How much of kick k the physical state lags behind the chain's.
    pub fn lag(&self, stage: usize) -> f64 {
        if stage < self.steps { self.dynamics.grid.ahead(stage) } else { 0.0 }
    }

    /// `Σ a_i h_i`, scaled.
    pub fn wheel_momentum(&self, momenta: &DVector<f64>) -> Vector3 {
        self.wheel_axes.column_iter().zip(momenta.iter()).map(|(axis, momentum)| axis * *momentum).sum()
    }

    /// Axes of the force inputs or of the torque inputs, and where these begin among all.
    pub fn channel(&self, forces: bool) -> (&[Vector3], usize) {
        if forces {
            (self.force.as_ref().map_or(&[], ActuatorSet::axes), 0)
        } else {
            (self.torque.axes(), self.first_torque)
        }
    }

    /// The axes of the force inputs or of the torque inputs, and where these begin among all, if they turn against the
    /// coordinates of their momenta.
    pub fn turning(&self, forces: bool) -> Option<(&[Vector3], usize)> {
        let turns = if forces {
            self.force.as_ref().is_some_and(|set| set.frame() == AxisFrame::Body)
        } else {
            self.torque.frame() == AxisFrame::Reference
        };
        turns.then(|| self.channel(forces))
    }

    /// Whether nothing but the inputs acts on the body.
    pub fn is_free(&self) -> bool {
        self.dynamics.is_free()
    }

    /// Whether input j acts on component i of a state at once.
    pub fn reaches(&self, i: usize, j: usize) -> bool {
        if self.wheels > 0 {
            i == 6 + j
        } else {
            let (pushes, turns) = (j < self.forces, j >= self.first_torque);
            pushes && (3..6).contains(&i) || turns && (self.pi()..self.pi() + 3).contains(&i)
        }
    }

    /// Number of terminal conditions.
    pub fn terminal_count(&self) -> usize {
        self.terminal.count(if self.moves { 12 } else { 6 })
    }

    /// Terminal error of a chain's last state, and its derivative, up to `J_r⁻¹` of the attitude error.
    pub fn terminal(&self, state: &ChainState) -> (DVector<f64>, DMatrix<f64>) {
        let count = self.terminal_count();
        // The multipliers of these equations are the costate: none is asked for.
        let costate = Costate::from_vector(&SVector::<f64, 12>::zeros());
        let error = self.terminal.value::<12>(&state.point(), &costate);
        let mut error = DVector::from_column_slice(&error.as_slice()[12 - count..]);
        let mut slope = DMatrix::identity(count, self.n);
        if let Some(duration) = self.duration {
            let (momenta, stated) =
                (self.momenta(&self.target_in(state.stretch)), self.momenta(&self.target));
            error -= (&momenta - stated).rows(0, count);
            slope.set_column(duration, &-momenta.rows(0, count));
        }
        if self.wheels > 0 {
            let mut rows = error.rows_mut(3, 3);
            rows -= self.wheel_momentum(&state.wheels);
            slope.view_mut((3, 6), (3, self.wheels)).copy_from(&-&self.wheel_axes);
        }
        (error, slope)
    }

    /// `a ⊖ b` in the tangent space at `b`.
    pub fn difference(&self, a: &ChainState, b: &ChainState) -> DVector<f64> {
        let mut out = DVector::zeros(self.n);
        let (zeta, pi) = (self.zeta(), self.pi());
        let blocks = a.point().minus(&b.point());
        if self.moves {
            out.rows_mut(0, 3).copy_from(&blocks.x);
            out.rows_mut(3, 3).copy_from(&blocks.gamma);
        }
        out.rows_mut(zeta, 3).copy_from(&blocks.zeta);
        out.rows_mut(pi, 3).copy_from(&blocks.pi);
        if self.wheels > 0 {
            out.rows_mut(6, self.wheels).copy_from(&(&a.wheels - &b.wheels));
        }
        if let Some(duration) = self.duration {
            out[duration] = (a.stretch / b.stretch).ln();
        }
        out
    }

    /// `state ⊕ z`.
    pub fn moved(&self, state: &ChainState, z: &DVector<f64>) -> ChainState {
        let part = |row: usize| Vector3::new(z[row], z[row + 1], z[row + 2]);
        let mut out = state.clone();
        if self.moves {
            out.position += part(0);
            out.linear_momentum += part(3);
        }
        out.attitude = lie::project_to_rotation(&(state.attitude * lie::exp(&part(self.zeta()))));
        out.momentum += part(self.pi());
        if self.wheels > 0 {
            out.wheels += z.rows(6, self.wheels);
        }
        if let Some(duration) = self.duration {
            out.stretch *= z[duration].exp();
        }
        out
    }

    /// The momenta of a state as a tangent vector.
    fn momenta(&self, state: &ChainState) -> DVector<f64> {
        let mut momenta = DVector::zeros(self.n);
        if self.moves {
            momenta.rows_mut(3, 3).copy_from(&state.linear_momentum);
        }
        momenta.rows_mut(self.pi(), 3).copy_from(&state.momentum);
        momenta.rows_mut(6, self.wheels).copy_from(&state.wheels);
        momenta
    }

    /// The kick at a state under `inputs`.
    fn kick(&self, state: &ChainState, inputs: &[f64]) -> Kick {
        let (pose, squared) = (state.pose(), state.stretch * state.stretch);
        let r = &pose.attitude;
        let mut columns = DMatrix::zeros(self.n, self.m);
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for (index, axis) in self.torque.axes().iter().enumerate() {
            let input = self.first_torque + index;
            let axis = self.torque.frame().to_body(r, axis);
            torque += axis * inputs[input];
            if self.wheels > 0 {
                columns[(6 + index, input)] = -1.0;
            } else {
                columns.view_mut((self.pi(), input), (3, 1)).copy_from(&axis);
            }
        }
        if let Some(set) = &self.force {
            for (input, axis) in set.axes().iter().enumerate() {
                let axis = set.frame().to_reference(r, axis);
                force += axis * inputs[input];
                columns.view_mut((3, input), (3, 1)).copy_from(&axis);
            }
        }
        // Wheels exchange their torque with the body: the total momentum gains nothing.
        let given = Wrench { force, moment: if self.wheels > 0 { Vector3::zeros() } else { torque } };
        let in_stated_units = Wrench { force: given.force / squared, moment: given.moment / squared };
        let (wrench, gradient) = self.dynamics.kick_of_inputs(&pose, &in_stated_units);
        let wrench = Wrench { force: wrench.force * squared, moment: wrench.moment * squared };
        let gradient = gradient.scaled(squared);
        let field = Wrench { force: wrench.force - given.force, moment: wrench.moment - given.moment };
        Kick { wrench, field, gradient, inputs: columns }
    }

    /// The costate of a stage as the shooting knows it: after a full kick, also at the end of a Lie–Verlet
    /// chain, whose last kick is a half one. `λ ← (I − ½h G)ᵀ λ` there.
    pub fn after_full_kick(
        &self,
        stage: usize,
        state: &ChainState,
        inputs: &[f64],
        costate: &DVector<f64>,
    ) -> DVector<f64> {
        if stage < self.steps || !self.dynamics.grid.has_half_kicks() {
            return costate.clone();
        }
        let mut rest = DMatrix::identity(self.n, self.n);
        let kick = self.kick(state, inputs);
        self.add_gradient(&mut rest, &kick.gradient, -self.kick_weight(stage));
        rest.tr_mul(costate)
    }

    /// Applies a kick of weight `weight`.
    fn kicked(&self, state: &ChainState, kick: &Kick, inputs: &[f64], weight: f64) -> ChainState {
        let mut out = state.clone();
        out.momentum += kick.wrench.moment * weight;
        if self.moves {
            out.linear_momentum += kick.wrench.force * weight;
        }
        for wheel in 0..self.wheels {
            out.wheels[wheel] -= inputs[self.forces + wheel] * weight;
        }
        out
    }

    /// The derivative of a kick of weight `weight` with respect to `ln s`.
    fn by_duration(&self, kick: &Kick, weight: f64) -> DVector<f64> {
        let mut slope = DVector::zeros(self.n);
        slope.rows_mut(self.pi(), 3).copy_from(&(kick.field.moment * (2.0 * weight)));
        if self.moves {
            slope.rows_mut(3, 3).copy_from(&(kick.field.force * (2.0 * weight)));
        }
        slope
    }

    /// `G z` of a kick's gradient, added with `weight` to the rows of the momenta: `A ← (I + κ G) A`.
    fn add_gradient(&self, matrix: &mut DMatrix<f64>, gradient: &Blocks, weight: f64) {
        let (zeta, pi) = (self.zeta(), self.pi());
        let rotation = matrix.rows(zeta, 3).into_owned();
        let mut to_momentum = gradient.rr * &rotation;
        if self.moves {
            let shift = matrix.rows(0, 3).into_owned();
            to_momentum += gradient.rx * &shift;
            let to_force = gradient.xx * &shift + gradient.xr * &rotation;
            let mut rows = matrix.rows_mut(3, 3);
            rows += to_force * weight;
        }
        let mut rows = matrix.rows_mut(pi, 3);
        rows += to_momentum * weight;
    }

    /// The opening kick of a maneuver that takes `stretch` times the stated duration.
    pub fn opening(&self, stretch: f64, inputs: &[f64]) -> Opening {
        let (start, weight) = (self.start_in(stretch), self.kick_weight(0));
        let kick = self.kick(&start, inputs);
        let mut by_duration = DVector::zeros(self.n);
        if let Some(duration) = self.duration {
            by_duration = self.momenta(&start) + self.by_duration(&kick, weight);
            by_duration[duration] = 1.0;
        }
        let end = self.kicked(&start, &kick, inputs, weight);
        Opening { end, by_inputs: kick.inputs * weight, by_duration }
    }

    /// Second derivatives with respect to `ln s` of `λ·y_0` after the opening kick, and of `η·e` of the terminal error.
    pub fn bends_of_ends(
        &self,
        at: [&ChainState; 2],
        costate: &DVector<f64>,
        terminal: &DVector<f64>,
    ) -> [f64; 2] {
        let [first, last] = at;
        let start = self.start_in(first.stretch);
        let field = self.kick(&start, &vec![0.0; self.m]);
        let opening = self.momenta(&start) + self.by_duration(&field, 2.0 * self.kick_weight(0));
        let end = self.momenta(&self.target_in(last.stretch));
        [opening.dot(costate), -end.rows(0, terminal.len()).dot(terminal)]
    }

    /// Step k: from `y_k` under `u_{k+1}` to `y_{k+1}`.
    pub fn step(&self, stage: usize, state: &ChainState, inputs: &[f64]) -> Result<Step, StepError> {
        let (zeta, pi) = (self.zeta(), self.pi());
        let (mut end, drift) = self.drift(stage, state)?;
        // z' = A0 z: ζ' = Fᵀζ + ξ and δΠ' = FᵀδΠ + S(Π')ξ, where ξ is how far the arc itself is turned.
        let turn = drift.turn;
        let mut a = DMatrix::identity(self.n, self.n);
        a.rows_mut(zeta, 3).copy_from(&turn);
        a.view_mut((zeta, zeta), (3, 3)).copy_from(&drift.f.transpose());
        if let Some(duration) = self.duration {
            let passed = self.frame_rate() * (end.stretch * self.dynamics.grid.step(stage));
            let mut back = a.fixed_view_mut::<3, 1>(zeta, duration);
            back -= end.attitude.tr_mul(&passed);
        }
        a.rows_mut(pi, 3).copy_from(&(hat(&end.momentum) * &turn));
        let mut block = a.view_mut((pi, pi), (3, 3));
        block += drift.f.transpose();
        if self.moves {
            let h = self.dynamics.grid.step(stage);
            (0..3).for_each(|axis| a[(axis, axis + 3)] = h);
        }
        let weight = self.kick_weight(stage + 1);
        let kick = self.kick(&end, inputs);
        self.add_gradient(&mut a, &kick.gradient, weight);
        if let Some(duration) = self.duration {
            let mut column = a.column_mut(duration);
            column += self.by_duration(&kick, weight);
        }
        end = self.kicked(&end, &kick, inputs, weight);
        Ok(Step { end, a, b: kick.inputs * weight, arc: Arc::of(&drift.f, turn) })
    }

    /// The arc of step k alone.
    pub fn arc(&self, stage: usize, state: &ChainState) -> Result<Arc, StepError> {
        let (_, drift) = self.drift(stage, state)?;
        Ok(Arc::of(&drift.f, drift.turn))
    }

    /// The drift of step k: the state between drift and kick, and how the relative attitude turns.
    fn drift(&self, stage: usize, state: &ChainState) -> Result<(ChainState, DriftArc), StepError> {
        let mut turn = Matrix3xX::zeros(self.n);
        let mut by_momentum = turn.view_mut((0, self.pi()), (3, 3));
        if self.wheels == 0 {
            let mut point = state.point();
            let drift = self.dynamics.drift::<12>(stage, &mut point)?;
            let e = self.dynamics.drift_matrix(&drift);
            by_momentum.copy_from(&self.dynamics.drift_block(&drift, &e));
            let attitude = self.hastened_frame(stage, state.stretch) * point.attitude.value;
            let end = ChainState::of(&point, state.wheels.clone());
            let end = ChainState { attitude, stretch: state.stretch, ..end };
            return Ok((end, DriftArc { f: drift.f, turn }));
        }
        let carried = self.wheel_momentum(&state.wheels);
        let drift = self.dynamics.gyrostat_drift(stage, &state.momentum, &carried)?;
        by_momentum.copy_from(&drift.by_momentum);
        turn.view_mut((0, 6), (3, self.wheels)).copy_from(&(drift.by_wheels * &self.wheel_axes));
        let attitude = self.dynamics.turned(stage, &(state.attitude * drift.f));
        let attitude = self.hastened_frame(stage, state.stretch) * attitude;
        let end = ChainState { attitude, momentum: drift.momentum_after, ..state.clone() };
        Ok((end, DriftArc { f: drift.f, turn }))
    }

    /// Rotation of the reference frame in the stated duration, in its axes.
    pub fn frame_rate(&self) -> Vector3 {
        self.dynamics.frame_rate()
    }

    /// How much less than in the stated duration a turning frame lets attitudes fall back on step k of one that is `stretch`
    /// times as long.
    fn hastened_frame(&self, stage: usize, stretch: f64) -> Matrix3 {
        if stretch == 1.0 || self.frame_rate() == Vector3::zeros() {
            return Matrix3::identity();
        }
        lie::exp(&(self.frame_rate() * (self.dynamics.grid.step(stage) * (1.0 - stretch))))
    }

    /// `R_k F_k` of an attitude at the end of step k: without the turn of the reference frame over it.
    pub fn unturned(&self, stage: usize, attitude: &Matrix3, stretch: f64) -> Matrix3 {
        self.dynamics.unturned(stage, &self.hastened_frame(stage, stretch).tr_mul(attitude))
    }

    /// Physical angular velocity at stage k, and its derivatives with respect to state and inputs.
    pub fn rate(
        &self,
        stage: usize,
        state: &ChainState,
        inputs: &[f64],
    ) -> (Vector3, Matrix3xX<f64>, Matrix3xX<f64>) {
        let (zeta, pi, lag) = (self.zeta(), self.pi(), self.lag(stage));
        let kick = self.kick(state, inputs);
        let physical = self.kicked(state, &kick, inputs, -lag);
        let momentum = physical.momentum - self.wheel_momentum(&physical.wheels);
        let mut by_state = Matrix3xX::zeros(self.n);
        by_state.view_mut((0, pi), (3, 3)).fill_with_identity();
        by_state.view_mut((0, zeta), (3, 3)).copy_from(&(kick.gradient.rr * -lag));
        if self.moves {
            by_state.view_mut((0, 0), (3, 3)).copy_from(&(kick.gradient.rx * -lag));
        }
        let mut by_inputs: Matrix3xX<f64> = kick.inputs.fixed_rows::<3>(pi) * -lag;
        if self.wheels > 0 {
            by_state.view_mut((0, 6), (3, self.wheels)).copy_from(&-&self.wheel_axes);
            let mut of_wheels = by_inputs.columns_mut(self.forces, self.wheels);
            of_wheels -= &self.wheel_axes * lag;
        }
        if let Some(duration) = self.duration {
            by_state.set_column(duration, &self.by_duration(&kick, -lag).fixed_rows::<3>(pi));
        }
        let inverse = &self.dynamics.j_inverse;
        (inverse * momentum, inverse * by_state, inverse * by_inputs)
    }

    /// The physical state at stage k.
    pub fn physical(&self, stage: usize, state: &ChainState, inputs: &[f64]) -> ChainState {
        if stage == 0 {
            return self.start_in(state.stretch);
        }
        let kick = self.kick(state, inputs);
        self.kicked(state, &kick, inputs, -self.lag(stage))
    }

    /// Actuator force (reference frame) and torque (body axes) at a state, scaled.
    pub fn output(&self, state: &ChainState, inputs: &[f64]) -> Wrench {
        let (forces, torques) = (&inputs[..self.forces], &inputs[self.first_torque..]);
        let r = &state.attitude;
        let force = self.force.as_ref().map(|set| set.frame().to_reference(r, &set.output(forces)));
        Wrench {
            force: force.unwrap_or_else(Vector3::zeros),
            moment: self.torque.frame().to_body(r, &self.torque.output(torques)),
        }
    }

    /// Length of a move of one state: its rotation \[rad\], or the change of the duration in the same measure.
    pub fn length(&self, z: &DVector<f64>) -> f64 {
        let turn = z.rows(self.zeta(), 3).norm();
        self.duration.map_or(turn, |duration| turn.max(z[duration].abs() / STRETCHED))
    }

    /// What fuel costs in a unit of time under `inputs`.
    pub fn fuel_rate(&self, inputs: &[f64]) -> f64 {
        let Some(fuel) = &self.fuel else { return 0.0 };
        let (forces, torques) = inputs.split_at(self.forces);
        let (of_forces, of_torques) = fuel.inputs.split_at(self.forces);
        let burnt = |set: &ActuatorSet, of_norm: bool, prices: &[f64], inputs: &[f64]| -> f64 {
            if of_norm {
                return prices[0] * set.output(inputs).norm();
            }
            prices.iter().zip(inputs).map(|(price, u)| price * u.abs()).sum()
        };
        let force = self.force.as_ref();
        force.map_or(0.0, |set| burnt(set, fuel.is_of_norm(true), of_forces, forces))
            + burnt(&self.torque, fuel.is_of_norm(false), of_torques, torques)
    }

    /// `½ uᵀ W u`.
    pub fn effort(&self, inputs: &[f64]) -> f64 {
        objective::effort(&self.weight, inputs)
    }
}

impl Arc {
    /// Of a relative attitude, and how that turns.
    fn of(f: &Matrix3, turn: Matrix3xX<f64>) -> Self {
        let arc = lie::log(f);
        Self { turn: arc, slope: lie::right_jacobian_inverse(&arc) * turn }
    }
}

impl ChainState {
    /// From the planner's point.
    pub fn of(point: &Point, wheels: DVector<f64>) -> Self {
        Self {
            position: point.position.value,
            linear_momentum: point.linear_momentum.value,
            attitude: point.attitude.value,
            momentum: point.momentum.value,
            wheels,
            stretch: 1.0,
        }
    }

    /// A state in the stated duration, in the units of one that is `stretch` times as long.
    fn hastened(&self, stretch: f64) -> Self {
        let (linear_momentum, momentum) = (self.linear_momentum * stretch, self.momentum * stretch);
        Self { linear_momentum, momentum, wheels: &self.wheels * stretch, stretch, ..self.clone() }
    }

    /// To the planner's point.
    pub fn point(&self) -> Point {
        Point {
            position: Sum::new(self.position),
            linear_momentum: Sum::new(self.linear_momentum),
            attitude: Sum::new(self.attitude),
            momentum: Sum::new(self.momentum),
        }
    }

    /// Position and attitude.
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, attitude: self.attitude }
    }
}

/// A costate of the chain as the planner orders it.
pub(crate) fn costate_blocks(model: &Model, costate: &DVector<f64>) -> Costate {
    let part = |row: usize| Vector3::new(costate[row], costate[row + 1], costate[row + 2]);
    let zero = Vector3::zeros();
    let (x, gamma) = if model.zeta() == 6 { (part(0), part(3)) } else { (zero, zero) };
    Costate { x, gamma, zeta: part(model.zeta()), pi: part(model.pi()) }
}
