//! The chain of a maneuver (`scp/model`) with the rows of its limits (`scp/rows`) as a program of stages.
//!
//! States are those **before** the kick of their node, so that a stage has all that its inputs act on:
//!
//! ```text
//! x_0 = start ,    y = x + κ_k (M(R) + B u) ,   x⁺ = drift(y) ,    at the last node the kick alone,  e(x_{N+1}) = 0
//! ```
//!
//! With `Y = [κB, I + κG]` of the kick and `D` of the drift, `[B A] = D Y`. The attitude's rows of `D` are those of the defect's own
//! tangent space: turned by `E = exp S(δ)`, `δ` the attitude's defect, since `log(R⁺ᵀ R F exp ξ) = δ + E ξ` to first order. With
//! `λ⁺ = Dᵀλ + Σ z ∂c/∂y`, the costate between kick and drift,
//!
//! ```text
//! ∂²(λ·x⁺ + Σ z c) = Yᵀ Φ Y + ∂²(κ λ⁺·(M + Bu)) ,   Φ = ∂²(λ·drift + Σ z c) by y
//! ```
//!
//! `Φ` is the symmetric part of the drift's own derivative of costates along the group (`discrete/step/gyrostat`; a body without wheels
//! is a gyrostat whose wheels stand). A row of the mean rate on an arc, `w·log F`, adds `q = J_r⁻ᵀ(log F) w` to what the drift's turn is
//! weighed with there.
//!
//! # What differs from the rows of SCP?
//!
//! A cone is one row on every closed arc, at its highest point, in the place of rows of nodes and of arcs that come and go. An input
//! whose fuel is counted by its size is two, one to each side. Inputs are in units of their limits, and where their changes are
//! limited the last ones are part of the state. Multipliers are told in the terms of SCP's rows ([`ChainProgram::found`]), and costates
//! are those after the kick, `λ^y = (I + κG)⁻ᵀ λ^x`.

use super::program::{Derivatives, Duals, Increment, Point, Program, RowKind, Shape, Values};
use crate::lie::{self, hat};
use crate::mechanics::environment::{Blocks, Pose, Wrench};
use crate::optimize::discrete::step::{Costate, GyrostatDrift};
use crate::optimize::methods::scp::Multipliers;
use crate::optimize::methods::scp::iterate::Iterate;
use crate::optimize::methods::scp::model::{ChainState, Model, step};
use crate::optimize::methods::scp::rows::{Bend, Cone, ConeAt, LimitRows, What};
use crate::{Matrix3, Vector3};
use nalgebra::{DVector, SMatrix};
use std::cell::RefCell;

/// What the cost is where the iteration begins.
const COST: f64 = 3.0;
/// Step of the central differences of a cone's gradient, and of the weight of an arc: angles and logarithms, of order one.
const STEP: f64 = 1e-5;
/// Largest turn of a state in one step \[rad\], and how much the duration may shrink and grow: to a half, to three times as much.
const LONGEST_TURN: f64 = 1.0;
const LONGEST_STRETCH: [f64; 2] = [0.5, 3.0];
/// The duration's increment is one of `s^POWER`, in which the limits of inputs are linear: `s ← s (1 + POWER ζ)^(1/POWER)`. A first
/// derivative `f'` by `ln s` is one by ζ too, and a second one becomes `f'' − POWER f'`.
const POWER: f64 = 2.0;
/// A multiplier below this adds no curvature that a step would feel.
const FELT: f64 = 1e-9;
/// A duration in which a path is just within the limits is stretched by this.
const ROOM: f64 = 1.1;

/// An input as the program sees it: a chain's input, in units of its limit, or one side of it.
#[derive(Clone, Copy, Debug)]
struct Lane {
    input: usize,
    factor: f64,
}

/// What a row of the program bounds.
#[derive(Clone, Copy, Debug)]
enum Bound {
    /// As a row of the chain says, at its own stage.
    Row,
    /// How fast an input changes, at the later of the two stages.
    Change,
    /// A side of an input that burns: not less than nothing.
    Side(usize),
}

/// A row of the program: what it bounds, and the chain's row that it stands for.
#[derive(Clone, Copy, Debug)]
struct Row {
    bound: Bound,
    row: usize,
}

/// The program.
pub(crate) struct ChainProgram<'a> {
    model: &'a Model,
    limits: &'a LimitRows,
    shape: Shape,
    lanes: Vec<Lane>,
    rows: Vec<Row>,
    /// Units of the inputs of the chain.
    units: Vec<f64>,
    /// Numbers of the state that hold the inputs before.
    before: usize,
    /// Components of the terminal error that are given.
    given: Vec<usize>,
    /// A cost of the program is this times that of the chain.
    scale: f64,
    /// Prices of the terminal equations.
    prices: Vec<f64>,
    space: RefCell<Space>,
}

/// Space for one stage.
#[derive(Default)]
struct Space {
    inputs: Vec<f64>,
    wheels: Vec<f64>,
    /// Columns of the drift's derivative, n×n, and of how its attitude and its arc turn by `y`.
    drift: Vec<f64>,
    turn: Vec<Vector3>,
    arc: Vec<Vector3>,
    /// How the physical rate changes by `z`.
    rate: Vec<Vector3>,
    /// Columns of `Y`: elements (row, value), and where each column begins.
    kick: Vec<(usize, f64)>,
    kick_first: Vec<usize>,
    /// `Φ`, `Φ Y`; a gradient by `y`, one by `z`, and `λ⁺`.
    phi: Vec<f64>,
    phi_kick: Vec<f64>,
    by_y: Vec<f64>,
    by_z: Vec<f64>,
    after: Vec<f64>,
}

/// The values of one stage.
struct Stage {
    pose: Pose,
    stretch: f64,
    /// Weight of the kick, and that of the part of it that the physical state has.
    weight: f64,
    physical: f64,
    /// Environment, scaled, in this duration.
    field: Wrench,
    /// Force and torque of the inputs.
    given: Wrench,
    /// After the kick.
    momentum: Vector3,
    linear: Vector3,
    carried: Vector3,
    /// Physical angular velocity at the node.
    rate: Vector3,
    /// The drift; its turn, the logarithm of that, momentum and attitude after.
    drift: Option<GyrostatDrift>,
    turned: Matrix3,
    arc: Vector3,
    momentum_after: Vector3,
    attitude_after: Matrix3,
    position_after: Vector3,
}

impl<'a> ChainProgram<'a> {
    /// The program of a chain; `None` where a kink of the cost is that of a norm.
    pub fn of(model: &'a Model, limits: &'a LimitRows, start: &Iterate) -> Option<Self> {
        if limits.rows.iter().any(|row| matches!(row.what, What::BurnOfNorm { .. })) {
            return None;
        }
        let mut units = vec![0.0f64; model.m];
        let mut sides = vec![(false, false); model.m];
        for row in &limits.rows {
            match row.what {
                What::InputSize { input, limit, .. } => units[input] = limit,
                What::Burn { input, limit, one_sided } => {
                    if limit.is_finite() {
                        units[input] = limit;
                    }
                    sides[input] = (true, one_sided);
                }
                _ => {}
            }
        }
        // Without a limit of its own an input is measured by what the first path asks for.
        for (input, unit) in units.iter_mut().enumerate() {
            let largest = start.inputs.iter().map(|inputs| inputs[input].abs()).fold(0.0, f64::max);
            if *unit <= 0.0 {
                *unit = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        let mut lanes = Vec::new();
        for (input, unit) in units.iter().enumerate() {
            lanes.push(Lane { input, factor: *unit });
            if let (true, false) = sides[input] {
                lanes.push(Lane { input, factor: -unit });
            }
        }
        let changes = limits.rows.iter().any(|row| matches!(row.what, What::InputRate { .. }));
        let before = if changes { model.m } else { 0 };
        let n = model.n + before;
        let fixed = if model.zeta() == 6 { 6 } else { 0 } + 9 + 3 + model.wheels + 1;
        let given = model.given();
        let mut shape = Shape {
            terminal: given.len(),
            starts: usize::from(model.duration.is_some()),
            ..Shape::new(n, lanes.len(), fixed + before, model.steps + 1)
        };
        let (mut rows, space) = (Vec::new(), Space::of(&shape));
        for stage in 0..=model.steps {
            describe(model, limits, &lanes, stage, &mut shape, &mut rows);
        }
        let mut program = Self {
            model,
            limits,
            shape,
            lanes,
            rows,
            units,
            before,
            scale: 1.0,
            prices: vec![1.0; given.len()],
            given,
            space: RefCell::new(space),
        };
        let cost = start.cost(model);
        if cost > 0.0 && cost.is_finite() {
            program.scale = COST / cost;
        }
        program.prices(start);
        Some(program)
    }

    /// The duration, as a multiple of the stated one, in which a path with the inputs that it asks for is well within the limits that
    /// grow with it.
    pub fn fitting(&self, at: &Point) -> Option<f64> {
        let mut values = Values::of(&self.shape);
        if !(self.values(at, &mut values) && values.are_finite()) {
            return None;
        }
        let zeta = self.model.zeta();
        let s = at.states[zeta + 12 + self.model.wheels];
        let mut needed = 0.0f64;
        for (row, c) in self.rows.iter().zip(&values.rows) {
            let what = &self.limits.rows[row.row].what;
            let growth = what.growth();
            if growth == 0 || matches!(row.bound, Bound::Change) {
                continue;
            }
            let reached = if what.is_ball() {
                (2.0 * c + 1.0).max(0.0).sqrt() * s.powi(growth)
            } else {
                c + s.powi(growth)
            };
            needed = needed.max(reached.max(0.0).powf(1.0 / f64::from(growth)));
        }
        (needed > 0.0).then_some(ROOM * needed)
    }

    /// Prices of the terminal equations, for a maneuver of the size of `start`.
    fn prices(&mut self, start: &Iterate) {
        let first = start.states[0].attitude;
        let largest = |of: &dyn Fn(&ChainState) -> f64| start.states.iter().map(of).fold(1e-12, f64::max);
        let turned = largest(&|state| lie::minus(&state.attitude, &first).norm());
        let momentum = largest(&|state| state.momentum.norm());
        let moved = largest(&|state| (state.position - start.states[0].position).norm());
        let pushed = largest(&|state| state.linear_momentum.norm());
        let (zeta, pi) = (self.model.zeta(), self.model.pi());
        for (price, row) in self.prices.iter_mut().zip(&self.given) {
            let size = match *row {
                row if row >= pi => momentum,
                row if row >= zeta => turned,
                row if row >= 3 => pushed,
                _ => moved,
            };
            *price = (1.0 / size).max(1.0);
        }
    }

    /// The point of an iterate.
    pub fn point(&self, iterate: &Iterate, out: &mut Point) {
        let (model, c) = (self.model, self.shape.coordinates);
        for stage in 0..=model.steps + 1 {
            let after = stage == model.steps + 1;
            let node = stage.min(model.steps);
            let (state, inputs) = (&iterate.states[node], &iterate.inputs[node]);
            let state = if stage == 0 {
                model.start_in(iterate.stretch())
            } else if after {
                state.clone()
            } else {
                step::before_kick(model, node, state, inputs)
            };
            self.write(&state, &mut out.states[stage * c..][..c]);
            if self.before > 0 {
                let before = &mut out.states[(stage + 1) * c - self.before..][..self.before];
                before.fill(0.0);
                if stage > 0 {
                    let inputs = &iterate.inputs[stage - 1];
                    before.iter_mut().zip(inputs).zip(&self.units).for_each(|((to, u), unit)| *to = u / unit);
                }
            }
            if !after {
                for (lane, to) in self.lanes.iter().zip(&mut out.inputs[stage * self.shape.m..]) {
                    let part = inputs[lane.input] / lane.factor;
                    let split = self.lanes.iter().filter(|other| other.input == lane.input).count() > 1;
                    *to = if stage < model.first_input() {
                        0.0
                    } else if split {
                        part.max(0.0)
                    } else {
                        part
                    };
                }
            }
        }
    }

    /// Writes a state into its coordinates, but for the inputs before.
    fn write(&self, state: &ChainState, out: &mut [f64]) {
        let mut at = 0;
        let mut put = |values: &[f64]| {
            out[at..at + values.len()].copy_from_slice(values);
            at += values.len();
        };
        if self.model.zeta() == 6 {
            put(state.position.as_slice());
            put(state.linear_momentum.as_slice());
        }
        put(state.attitude.as_slice());
        put(state.momentum.as_slice());
        put(state.wheels.as_slice());
        put(&[state.stretch]);
    }

    /// The state at coordinates.
    fn read(&self, from: &[f64]) -> ChainState {
        let body = if self.model.zeta() == 6 { 6 } else { 0 };
        let vector = |at: usize| Vector3::from_column_slice(&from[at..at + 3]);
        let zero = Vector3::zeros();
        ChainState {
            position: if body > 0 { vector(0) } else { zero },
            linear_momentum: if body > 0 { vector(3) } else { zero },
            attitude: Matrix3::from_column_slice(&from[body..body + 9]),
            momentum: vector(body + 9),
            wheels: DVector::from_column_slice(&from[body + 12..][..self.model.wheels]),
            stretch: from[body + 12 + self.model.wheels],
        }
    }

    /// What was found, as SCP knows it: states after their kicks, inputs, costates, and multipliers of the chain's rows.
    pub fn found(&self, at: &Point, duals: &Duals) -> (Iterate, Multipliers) {
        let Shape { n, m, coordinates: c, .. } = self.shape;
        let model = self.model;
        let by = 1.0 / self.scale;
        let (mut states, mut inputs, mut costates) = (Vec::new(), Vec::new(), Vec::new());
        for stage in 0..=model.steps {
            let mut own = vec![0.0; model.m];
            for (lane, w) in self.lanes.iter().zip(&at.inputs[stage * m..][..m]) {
                own[lane.input] += lane.factor * w;
            }
            let before = self.read(&at.states[stage * c..][..c]);
            let state = if stage == model.steps {
                self.read(&at.states[(stage + 1) * c..][..c])
            } else {
                step::after_kick(model, stage, &before, &own)
            };
            let costate = DVector::from_column_slice(&duals.costates[stage * n..][..model.n]) * by;
            costates.push(step::costate_after_kick(model, stage, &before, &own, &costate));
            states.push(state);
            inputs.push(own);
        }
        let mut rows = vec![0.0; self.limits.rows.len()];
        for (row, index) in self.rows.iter().zip(0..) {
            let multiplier = duals.rows[index] * by;
            match row.bound {
                Bound::Row | Bound::Change => rows[row.row] += multiplier,
                Bound::Side(_) => {}
            }
        }
        self.kinks(&inputs, states[0].stretch, duals, &mut rows);
        self.to_nodes(at, &mut rows);
        let terminal = DVector::from_column_slice(&duals.terminal) * by;
        (Iterate { states, inputs }, Multipliers { costates, terminal, rows })
    }

    /// The slope of each kink: the price less the multiplier of its side.
    fn kinks(&self, inputs: &[Vec<f64>], stretch: f64, duals: &Duals, rows: &mut [f64]) {
        for (row, multiplier) in self.rows.iter().zip(&duals.rows) {
            let Bound::Side(lane) = row.bound else { continue };
            let limit = &self.limits.rows[row.row];
            let What::Burn { limit: most, .. } = limit.what else { continue };
            let lane = self.lanes[lane];
            let kinks = &self.limits.kinks;
            let place = kinks.binary_search_by_key(&row.row, |kink| kink.rows.start);
            let price = place.map_or(0.0, |place| kinks[place].price);
            // The side that the input is on, or the first.
            let input = inputs[limit.stage][lane.input];
            if (lane.factor > 0.0) == (input >= 0.0) {
                // v = u/(limit s), and the multiplier is one of u/factor.
                let of_v = multiplier / self.scale * most * stretch / lane.factor.abs();
                rows[row.row] = lane.factor.signum() * (price - of_v);
            }
        }
    }

    /// Gives the multipliers of arcs whose highest point is at an end to the rows of the node there.
    fn to_nodes(&self, at: &Point, rows: &mut [f64]) {
        for row in &self.rows {
            let limit = &self.limits.rows[row.row];
            let What::Cone(cone) = &limit.what else { continue };
            if !cone.is_of_arc() || rows[row.row] == 0.0 {
                continue;
            }
            let mut space = self.space.borrow_mut();
            let Some(stage) = self.stage(at, limit.stage, &mut space) else { continue };
            let Some(found) = self.cone_at(cone, limit.stage, &stage) else { continue };
            let node = match found.fraction {
                fraction if fraction <= 0.0 => limit.stage,
                fraction if fraction >= 1.0 => limit.stage + 1,
                _ => continue,
            };
            let multiplier = std::mem::take(&mut rows[row.row]);
            let same = |other: &usize| matches!(&self.limits.rows[*other].what, What::Cone(other) if other.is_node_of(cone));
            if let Some(other) = self.limits.range(node).find(same) {
                rows[other] += multiplier;
            }
        }
    }

    fn cone_at(&self, cone: &Cone, k: usize, stage: &Stage) -> Option<ConeAt> {
        self.cone_in(cone, k, stage, stage.stretch)
    }

    /// A cone's row in another duration.
    fn cone_in(&self, cone: &Cone, k: usize, stage: &Stage, stretch: f64) -> Option<ConeAt> {
        let arc = cone.is_of_arc().then_some(&stage.arc);
        cone.met(self.model, k, (&stage.pose.attitude, stretch), arc, true)
    }

    /// A cone's row, with its second derivatives if these are asked for.
    fn cone_bent(&self, cone: &Cone, k: usize, stage: &Stage, bent: bool) -> Option<(ConeAt, Option<Bend>)> {
        if !bent {
            return self.cone_at(cone, k, stage).map(|found| (found, None));
        }
        let arc = cone.is_of_arc().then_some(&stage.arc);
        let (found, bend) = cone.bent(self.model, k, (&stage.pose.attitude, stage.stretch), arc)?;
        Some((found, Some(bend)))
    }

    fn cone_value(&self, cone: &Cone, k: usize, stage: &Stage) -> Option<f64> {
        let arc = cone.is_of_arc().then_some(&stage.arc);
        cone.value(self.model, k, (&stage.pose.attitude, stage.stretch), arc)
    }

    /// The values of stage k. The inputs of the chain and the wheels after the kick are left in `space`.
    fn stage(&self, at: &Point, k: usize, space: &mut Space) -> Option<Stage> {
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

    /// The value of a row of the program at its stage.
    fn value(&self, row: &Row, k: usize, at: &Point, stage: &Stage, space: &Space) -> f64 {
        let Shape { m, coordinates: c, .. } = self.shape;
        let model = self.model;
        let what = &self.limits.rows[row.row].what;
        if let Bound::Side(lane) = row.bound {
            return -at.inputs[k * m + lane];
        }
        let s = stage.stretch;
        match what {
            What::InputSize { input, sign, limit } => sign * space.inputs[*input] / limit - s * s,
            What::InputRate { input, sign, limit } => {
                let before = at.states[(k + 1) * c - self.before + input] * self.units[*input];
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
                // Where it does not act it is far from its bound.
                let equation = what.is_equation();
                self.cone_value(cone, k, stage).unwrap_or(if equation { 0.0 } else { -1.0 })
            }
            What::Burn { .. } | What::BurnOfNorm { .. } => -1.0,
        }
    }

    /// Angular velocity at the node, or the mean one of the arc.
    fn rate(&self, arc: bool, k: usize, stage: &Stage) -> Vector3 {
        if arc { stage.arc / self.model.dynamics.grid.step(k) } else { stage.rate }
    }

    /// The cost of the inputs of a stage.
    fn cost(&self, k: usize, at: &Point, stage: &Stage, space: &Space) -> f64 {
        let (model, m) = (self.model, self.shape.m);
        if k < model.first_input() {
            return 0.0;
        }
        let mut cost = 0.0;
        for (j, column) in model.weight.column_iter().enumerate() {
            let slope: f64 = column.iter().zip(&space.inputs).map(|(w, u)| w * u).sum();
            cost += 0.5 * slope * space.inputs[j];
        }
        cost *= model.effort_weight(k, stage.stretch);
        if let Some(fuel) = &model.fuel {
            let burnt = self.lanes.iter().zip(&at.inputs[k * m..]);
            let rate: f64 = burnt.map(|(lane, w)| fuel.inputs[lane.input] * lane.factor.abs() * w).sum();
            cost += model.kick_weight(k) * rate / stage.stretch;
        }
        cost * self.scale
    }

    /// What the end of stage k is off the state after it.
    fn defect(&self, k: usize, at: &Point, stage: &Stage, space: &Space, out: &mut [f64]) {
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
            out[model.n + input] = space.inputs[input] / self.units[input] - next[c - self.before + input];
        }
    }

    /// The terminal error.
    fn terminal(&self, at: &Point, out: &mut [f64]) {
        let (model, c) = (self.model, self.shape.coordinates);
        let last = &at.states[(model.steps + 1) * c..][..c];
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(last[at], last[at + 1], last[at + 2]);
        let s = last[zeta + 12 + model.wheels];
        let target = &model.target;
        let off = lie::minus(&Matrix3::from_column_slice(&last[zeta..zeta + 9]), &target.attitude);
        let mut momentum = vector(zeta + 9) - target.momentum * s;
        let (axes, _) = model.channel(false);
        for (axis, stored) in axes.iter().zip(&last[zeta + 12..][..model.wheels]) {
            momentum -= axis * *stored;
        }
        for (to, row) in out.iter_mut().zip(&self.given) {
            *to = match *row {
                row if row >= pi => momentum[row - pi],
                row if row >= zeta => off[row - zeta],
                row if row >= 3 => last[row] - target.linear_momentum[row - 3] * s,
                row => last[row] - target.position[row],
            };
        }
    }

    /// The cost of time.
    fn time(&self, at: &Point) -> f64 {
        let c = self.shape.coordinates;
        let stretch = at.states[(self.model.steps + 2) * c - self.before - 1];
        self.scale * self.model.time_price * stretch
    }
}

#[cfg(test)]
impl ChainProgram<'_> {
    /// A cost of the program over that of the chain.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Rows of the program, and those of the chain that they stand for where both are the same.
    pub fn of_rows(&self) -> impl Iterator<Item = (usize, usize)> {
        self.rows.iter().map(|row| row.row).enumerate()
    }

    /// What a row bounds.
    pub fn what(&self, row: usize) -> &What {
        &self.limits.rows[self.rows[row].row].what
    }

    /// Makes the states those that the inputs lead to.
    pub fn follow(&self, at: &mut Point) {
        let Shape { n, coordinates: c, .. } = self.shape;
        let mut values = Values::of(&self.shape);
        for k in 0..self.shape.stages {
            for _ in 0..2 {
                assert!(self.values(at, &mut values));
                let mut by = Increment::of(&self.shape);
                by.states[(k + 1) * n..][..n].copy_from_slice(&values.defects[k * n..][..n]);
                let mut next = Point::of(&self.shape);
                self.moved(at, &by, 1.0, &mut next);
                at.states[(k + 1) * c..][..c].copy_from_slice(&next.states[(k + 1) * c..][..c]);
            }
        }
    }
}

/// The rows of a stage, and what they depend on.
fn describe(
    model: &Model,
    limits: &LimitRows,
    lanes: &[Lane],
    stage: usize,
    shape: &mut Shape,
    rows: &mut Vec<Row>,
) {
    let m = lanes.len();
    let (zeta, pi, duration) = (m + model.zeta(), m + model.pi(), model.duration.map(|d| m + d));
    let of_input = |input: usize| {
        lanes.iter().enumerate().filter(move |(_, lane)| lane.input == input).map(|(place, _)| place)
    };
    let kind = |row: usize, hard: bool| {
        if limits.rows[row].what.is_equation() {
            RowKind::Equation
        } else if hard || limits.groups[limits.rows[row].group].hard {
            RowKind::Hard
        } else {
            RowKind::Elastic
        }
    };
    let turning = !model.is_free() || model.turning(false).is_some() || model.turning(true).is_some();
    // What moves a body on the arc after a stage.
    let kicked = |attitude: bool| -> Vec<usize> {
        let mut all: Vec<usize> = (0..m).collect();
        if turning && zeta > m {
            all.extend(m..m + 3);
        }
        if attitude || turning {
            all.extend(zeta..zeta + 3);
        }
        all.extend(pi..pi + 3);
        all.extend(pi + 3..pi + 3 + model.wheels);
        all.extend(duration);
        all
    };
    for row in limits.range(stage) {
        let what = &limits.rows[row].what;
        let mut put = |kind: RowKind, unknowns: Vec<usize>| {
            shape.row(kind, unknowns);
            rows.push(Row { bound: Bound::Row, row });
        };
        match what {
            What::InputSize { input, .. } => {
                put(kind(row, true), of_input(*input).chain(duration).collect());
            }
            What::InputNorm { .. } => {
                let attitude = if turning { Some(zeta..zeta + 3) } else { None };
                put(kind(row, true), (0..m).chain(attitude.into_iter().flatten()).chain(duration).collect());
            }
            What::RateNorm { .. } | What::RateAxis { .. } => put(kind(row, false), kicked(false)),
            What::Wheel { wheel, .. } => {
                let own = [pi + 3 + wheel];
                let inputs = of_input(model.forces + wheel);
                put(kind(row, false), inputs.chain(own).chain(duration).collect());
            }
            What::Cone(cone) if cone.is_of_arc() => put(kind(row, false), kicked(true)),
            What::Cone(_) if what.is_equation() => {
                put(kind(row, false), (zeta..zeta + 3).chain(duration).collect());
            }
            What::Burn { input, .. } => {
                for place in of_input(*input) {
                    shape.row(RowKind::Hard, [place]);
                    rows.push(Row { bound: Bound::Side(place), row });
                }
            }
            What::Cone(_) | What::InputRate { .. } | What::BurnOfNorm { .. } => {}
        }
    }
    // How fast inputs change from the stage before to this one.
    for row in stage.checked_sub(1).map_or(0..0, |before| limits.range(before)) {
        let What::InputRate { input, .. } = limits.rows[row].what else { continue };
        let before = m + model.n + input;
        shape.row(RowKind::Hard, of_input(input).chain(duration).chain([before]));
        rows.push(Row { bound: Bound::Change, row });
    }
    shape.end_stage();
}

impl Space {
    fn of(shape: &Shape) -> Self {
        let (n, z) = (shape.n, shape.z());
        Self {
            inputs: vec![0.0; z],
            wheels: vec![0.0; n],
            drift: vec![0.0; n * n],
            turn: vec![Vector3::zeros(); n],
            arc: vec![Vector3::zeros(); n],
            rate: vec![Vector3::zeros(); z],
            kick: Vec::with_capacity(z * 7),
            kick_first: Vec::with_capacity(z + 1),
            phi: vec![0.0; n * n],
            phi_kick: vec![0.0; n * z],
            by_y: vec![0.0; n],
            by_z: vec![0.0; z],
            after: vec![0.0; n],
        }
    }

    /// The columns of `Y`.
    fn columns(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        self.kick_first.windows(2).map(|pair| &self.kick[pair[0]..pair[1]])
    }
}

/// Adds `value` to an element of a symmetric matrix, and to its mirror image.
fn both(matrix: &mut [f64], size: usize, i: usize, j: usize, value: f64) {
    matrix[i * size + j] += value;
    if i != j {
        matrix[j * size + i] += value;
    }
}

/// Adds the symmetric part of a block of a symmetric matrix on its diagonal.
fn add_symmetric(matrix: &mut [f64], size: usize, at: usize, block: &Matrix3) {
    for i in 0..3 {
        for j in 0..3 {
            matrix[(at + j) * size + at + i] += 0.5 * (block[(i, j)] + block[(j, i)]);
        }
    }
}

impl Program for ChainProgram<'_> {
    fn shape(&self) -> &Shape {
        &self.shape
    }

    fn values(&self, at: &Point, out: &mut Values) -> bool {
        let n = self.shape.n;
        let space = &mut *self.space.borrow_mut();
        out.cost = self.time(at);
        for k in 0..self.shape.stages {
            let Some(stage) = self.stage(at, k, space) else { return false };
            out.cost += self.cost(k, at, &stage, space);
            self.defect(k, at, &stage, space, &mut out.defects[k * n..][..n]);
            for row in self.shape.rows_of(k) {
                out.rows[row] = self.value(&self.rows[row], k, at, &stage, space);
            }
        }
        self.terminal(at, &mut out.terminal);
        true
    }

    fn derivatives(&self, at: &Point, duals: &Duals, out: &mut Derivatives) -> bool {
        let (n, z) = (self.shape.n, self.shape.z());
        let space = &mut *self.space.borrow_mut();
        out.values.cost = self.time(at);
        for k in 0..self.shape.stages {
            let Some(stage) = self.stage(at, k, space) else { return false };
            out.values.cost += self.cost(k, at, &stage, space);
            self.defect(k, at, &stage, space, &mut out.values.defects[k * n..][..n]);
            for row in self.shape.rows_of(k) {
                out.values.rows[row] = self.value(&self.rows[row], k, at, &stage, space);
            }
            out.gradients[k * z..][..z].fill(0.0);
            out.hessians[k * z * z..][..z * z].fill(0.0);
            out.curvatures[k * z * z..][..z * z].fill(0.0);
            if self.derivatives_of(at, k, &stage, duals, space, out).is_none() {
                return false;
            }
        }
        self.terminal(at, &mut out.values.terminal);
        self.ends(at, duals, out);
        true
    }

    fn moved(&self, at: &Point, by: &Increment, part: f64, out: &mut Point) {
        let Shape { n, coordinates: c, .. } = self.shape;
        let model = self.model;
        let (zeta, pi) = (model.zeta(), model.pi());
        for (k, (from, to)) in at.states.chunks_exact(c).zip(out.states.chunks_exact_mut(c)).enumerate() {
            let z = &by.states[k * n..][..n];
            for i in 0..zeta {
                to[i] = from[i] + part * z[i];
            }
            let turn = Vector3::new(z[zeta], z[zeta + 1], z[zeta + 2]) * part;
            let attitude = Matrix3::from_column_slice(&from[zeta..zeta + 9]) * lie::exp(&turn);
            // Orthogonal again, to second order in what round-off has left.
            let attitude = attitude * (Matrix3::identity() * 1.5 - attitude.tr_mul(&attitude) * 0.5);
            to[zeta..zeta + 9].copy_from_slice(attitude.as_slice());
            for i in 0..3 + model.wheels {
                to[zeta + 9 + i] = from[zeta + 9 + i] + part * z[pi + i];
            }
            let place = zeta + 12 + model.wheels;
            let grown = |duration: usize| (1.0 + POWER * part * z[duration]).max(0.0).powf(1.0 / POWER);
            to[place] = from[place] * model.duration.map_or(1.0, grown);
            for i in 0..self.before {
                to[place + 1 + i] = from[place + 1 + i] + part * z[model.n + i];
            }
        }
        // The start is what its duration makes of it.
        let s = out.states[zeta + 12 + model.wheels];
        let first = &mut out.states[..c];
        for (to, from) in first[3.min(zeta)..zeta].iter_mut().zip(model.start.linear_momentum.iter()) {
            *to = from * s;
        }
        for i in 0..3 {
            first[zeta + 9 + i] = model.start.momentum[i] * s;
        }
        for i in 0..model.wheels {
            first[zeta + 12 + i] = model.start.wheels[i] * s;
        }
        for ((to, from), by) in out.inputs.iter_mut().zip(&at.inputs).zip(&by.inputs) {
            *to = from + part * by;
        }
    }

    fn longest(&self, by: &Increment) -> f64 {
        let (model, n) = (self.model, self.shape.n);
        let zeta = model.zeta();
        let mut part = 1.0f64;
        for z in by.states.chunks_exact(n) {
            let turn = Vector3::new(z[zeta], z[zeta + 1], z[zeta + 2]).norm();
            part = part.min(LONGEST_TURN / turn.max(LONGEST_TURN));
            if let Some(duration) = model.duration {
                let [least, most] = LONGEST_STRETCH.map(|grown| (grown.powf(POWER) - 1.0) / POWER);
                let bound = if z[duration] < 0.0 { least } else { most };
                part = part.min((bound / z[duration]).abs());
            }
        }
        part
    }

    fn terminal_prices(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.prices);
    }
}

impl ChainProgram<'_> {
    /// Start, end and the cost of time.
    fn ends(&self, at: &Point, duals: &Duals, out: &mut Derivatives) {
        let Shape { n, coordinates: c, .. } = self.shape;
        let model = self.model;
        let (zeta, pi, z) = (model.zeta(), model.pi(), self.shape.z());
        let target = &model.target;
        out.last_gradient.fill(0.0);
        out.last_hessian.fill(0.0);
        out.last_curvature.fill(0.0);
        out.terminal_slopes.fill(0.0);
        let s = at.states[(model.steps + 1) * c + zeta + 12 + model.wheels];
        let (axes, _) = model.channel(false);
        let mut bend = 0.0;
        let slopes = out.terminal_slopes.chunks_exact_mut(n);
        for ((slope, row), nu) in slopes.zip(&self.given).zip(&duals.terminal) {
            slope[*row] = 1.0;
            let momentum = match *row {
                row if row >= pi => {
                    axes.iter().take(model.wheels).enumerate().for_each(|(wheel, axis)| {
                        slope[6 + wheel] = -axis[row - pi];
                    });
                    target.momentum[row - pi]
                }
                row if row >= 3 && row < zeta => target.linear_momentum[row - 3],
                _ => 0.0,
            };
            if let Some(duration) = model.duration {
                slope[duration] = -momentum * s;
                bend -= nu * momentum * s;
            }
        }
        let Some(duration) = model.duration else { return };
        out.last_curvature[duration * n + duration] = (1.0 - POWER) * bend;
        let time = self.time(at);
        out.last_gradient[duration] = time;
        out.last_hessian[duration * n + duration] = (1.0 - POWER) * time;
        // The start goes with the duration.
        let start = &mut out.start_slopes[..n];
        start.fill(0.0);
        start[duration] = 1.0;
        let first = &at.states[..c];
        start[3.min(zeta)..zeta].copy_from_slice(&first[3.min(zeta)..zeta]);
        start[pi..pi + 3 + model.wheels].copy_from_slice(&first[zeta + 9..][..3 + model.wheels]);
        let bend: f64 = (0..duration).map(|i| duals.costates[i] * start[i]).sum();
        let place = self.shape.m + duration;
        out.curvatures[place * z + place] += (1.0 - POWER) * bend;
    }

    /// Derivatives of stage k.
    fn derivatives_of(
        &self,
        at: &Point,
        k: usize,
        stage: &Stage,
        duals: &Duals,
        space: &mut Space,
        out: &mut Derivatives,
    ) -> Option<()> {
        let Shape { n, m, .. } = self.shape;
        let model = self.model;
        let z = n + m;
        let (zeta, pi) = (model.zeta(), model.pi());
        let (s, squared) = (stage.stretch, stage.stretch * stage.stretch);
        let r = &stage.pose.attitude;
        let h = if k < model.steps { model.dynamics.grid.step(k) } else { 0.0 };
        // The kick, `Y`.
        let gradient = if model.is_free() {
            Blocks::zero()
        } else {
            model.dynamics.field(&stage.pose).1.scaled(squared)
        };
        let mut turned = gradient;
        let (torques_turn, forces_turn) = (model.turning(false).is_some(), model.turning(true).is_some());
        if torques_turn && model.wheels == 0 {
            turned.rr += hat(&stage.given.moment);
        }
        if forces_turn {
            turned.xr -= hat(&stage.given.force) * r;
        }
        space.kick.clear();
        space.kick_first.clear();
        let weight = stage.weight;
        let (torque_axes, first_torque) = model.channel(false);
        let (force_axes, _) = model.channel(true);
        for lane in &self.lanes {
            space.kick_first.push(space.kick.len());
            if lane.input >= first_torque {
                let index = lane.input - first_torque;
                if model.wheels > 0 {
                    space.kick.push((6 + index, -weight * lane.factor));
                } else {
                    let axis = torque_axes[index];
                    let axis = if torques_turn { r.tr_mul(&axis) } else { axis };
                    space.kick.extend((0..3).map(|i| (pi + i, weight * lane.factor * axis[i])));
                }
            }
            if let Some(axis) = force_axes.get(lane.input).filter(|_| zeta == 6) {
                let axis = if forces_turn { r * axis } else { *axis };
                space.kick.extend((0..3).map(|i| (3 + i, weight * lane.factor * axis[i])));
            }
        }
        let bent = !model.is_free() || torques_turn || forces_turn;
        for i in 0..n {
            space.kick_first.push(space.kick.len());
            if i >= model.n {
                continue;
            }
            space.kick.push((i, 1.0));
            if bent && (zeta..zeta + 3).contains(&i) {
                space.kick.extend((0..3).map(|row| (pi + row, weight * turned.rr[(row, i - zeta)])));
                if zeta == 6 {
                    space.kick.extend((0..3).map(|row| (3 + row, weight * turned.xr[(row, i - zeta)])));
                }
            }
            if bent && zeta == 6 && i < 3 {
                space.kick.extend((0..3).map(|row| (pi + row, weight * turned.rx[(row, i)])));
                space.kick.extend((0..3).map(|row| (3 + row, weight * turned.xx[(row, i)])));
            }
            if bent && Some(i) == model.duration {
                space.kick.extend((0..3).map(|row| (pi + row, 2.0 * weight * stage.field.moment[row])));
                if zeta == 6 {
                    space.kick.extend((0..3).map(|row| (3 + row, 2.0 * weight * stage.field.force[row])));
                }
            }
        }
        space.kick_first.push(space.kick.len());
        // The drift.
        let drift = stage.drift.as_ref();
        let defect = &out.values.defects[k * n..][..n];
        let off = Vector3::new(defect[zeta], defect[zeta + 1], defect[zeta + 2]);
        let frame = lie::exp(&off);
        let passed = step::frame_rate(model);
        let seen = stage.attitude_after.tr_mul(&passed);
        let f_t = stage.turned.transpose();
        space.drift.fill(0.0);
        space.turn.fill(Vector3::zeros());
        space.arc.fill(Vector3::zeros());
        for i in 0..3 {
            space.turn[zeta + i] = f_t.column(i).into_owned();
        }
        if let Some(drift) = drift {
            for i in 0..3 {
                space.arc[pi + i] = drift.by_momentum.column(i).into_owned();
            }
            for (wheel, axis) in torque_axes.iter().take(model.wheels).enumerate() {
                space.arc[6 + wheel] = drift.by_wheels * axis;
            }
            for i in pi..pi + 3 + model.wheels {
                space.turn[i] = space.arc[i];
            }
        }
        if let Some(duration) = model.duration {
            space.turn[duration] = -seen * (h * s);
        }
        for i in 0..model.n {
            let column = &mut space.drift[i * n..][..n];
            let turn = frame * space.turn[i];
            column[zeta..zeta + 3].copy_from_slice(turn.as_slice());
            let mut momentum = stage.momentum_after.cross(&space.arc[i]);
            if (pi..pi + 3).contains(&i) {
                momentum += f_t.column(i - pi);
            } else if !(zeta..zeta + 3).contains(&i) {
                column[i] = 1.0;
            }
            column[pi..pi + 3].copy_from_slice(momentum.as_slice());
            if zeta == 6 && (3..6).contains(&i) {
                column[i - 3] = h;
            }
        }
        // `[B A] = D Y`.
        let steps = &mut out.steps[k * n * z..][..n * z];
        for (to, column) in steps.chunks_exact_mut(n).zip(space.columns()) {
            to.fill(0.0);
            for (row, value) in column {
                for (to, from) in to.iter_mut().zip(&space.drift[row * n..][..n]) {
                    *to += value * from;
                }
            }
        }
        if self.before > 0 {
            for (place, lane) in self.lanes.iter().enumerate() {
                steps[place * n + model.n + lane.input] += lane.factor / self.units[lane.input];
            }
        }
        self.costs(at, k, stage, space, out);
        // The physical rate by `z`.
        let j_inverse = &model.dynamics.j_inverse;
        space.rate.fill(Vector3::zeros());
        for (place, lane) in self.lanes.iter().enumerate() {
            if lane.input >= first_torque {
                let axis = torque_axes[lane.input - first_torque];
                let axis = if torques_turn && model.wheels == 0 { r.tr_mul(&axis) } else { axis };
                space.rate[place] = j_inverse * axis * (stage.physical * lane.factor);
            }
        }
        for i in 0..3 {
            space.rate[m + pi + i] = j_inverse.column(i).into_owned();
            if bent {
                space.rate[m + zeta + i] = j_inverse * turned.rr.column(i) * stage.physical;
                if zeta == 6 {
                    space.rate[m + i] = j_inverse * turned.rx.column(i) * stage.physical;
                }
            }
        }
        for (wheel, axis) in torque_axes.iter().take(model.wheels).enumerate() {
            space.rate[m + 6 + wheel] = -(j_inverse * axis);
        }
        if let Some(duration) = model.duration.filter(|_| bent) {
            space.rate[m + duration] = j_inverse * stage.field.moment * (2.0 * stage.physical);
        }
        // Rows: their slopes, and what they add to the curvature.
        let next = &duals.costates[(k + 1) * n..][..n];
        for (to, column) in space.after.iter_mut().zip(space.drift.chunks_exact(n)) {
            *to = column.iter().zip(next).map(|(a, b)| a * b).sum();
        }
        space.phi.fill(0.0);
        let (mut of_node, mut of_arc) = (Vector3::zeros(), Vector3::zeros());
        let log_slope = lie::right_jacobian_inverse(&stage.arc);
        for arc in &mut space.arc {
            // From here on the derivative of `log F`.
            if *arc != Vector3::zeros() {
                *arc = log_slope * *arc;
            }
        }
        let curvature = &mut out.curvatures[k * z * z..][..z * z];
        for index in self.shape.rows_of(k) {
            let row = &self.rows[index];
            let what = &self.limits.rows[row.row].what;
            let multiplier = duals.rows[index];
            let growth = what.growth();
            let power = f64::from(growth);
            let grown = s.powi(growth);
            let slopes = self.shape.slopes_of(index);
            let places = &self.shape.unknowns[slopes.clone()];
            let out = &mut out.slopes[slopes];
            let duration = model.duration.map(|duration| m + duration);
            let is_duration = |place: usize| Some(place) == duration;
            match (row.bound, what) {
                (Bound::Side(_), _) => out[0] = -1.0,
                (_, What::InputSize { input, sign, limit }) => {
                    for (to, place) in out.iter_mut().zip(places) {
                        let place = usize::from(*place);
                        *to = if is_duration(place) {
                            -power * grown
                        } else {
                            debug_assert_eq!(self.lanes[place].input, *input);
                            sign / limit * self.lanes[place].factor
                        };
                    }
                    bend_limit(curvature, z, duration, -multiplier * power * power * grown);
                }
                (_, What::InputRate { input, sign, limit }) => {
                    for (to, place) in out.iter_mut().zip(places) {
                        let place = usize::from(*place);
                        *to = if is_duration(place) {
                            -power * grown
                        } else if place < m {
                            sign / limit * self.lanes[place].factor
                        } else {
                            -sign / limit * self.units[*input]
                        };
                    }
                    bend_limit(curvature, z, duration, -multiplier * power * power * grown);
                }
                (_, What::Wheel { wheel, sign, limit }) => {
                    for (to, place) in out.iter_mut().zip(places) {
                        let place = usize::from(*place);
                        *to = if is_duration(place) {
                            -power * grown
                        } else if place < m {
                            -stage.physical * sign / limit * self.lanes[place].factor
                        } else {
                            debug_assert_eq!(place, m + 6 + wheel);
                            sign / limit
                        };
                    }
                    bend_limit(curvature, z, duration, -multiplier * power * power * grown);
                }
                (_, What::InputNorm { forces, limit }) => {
                    let size = limit * grown;
                    let given = if *forces { stage.given.force } else { stage.given.moment } / size;
                    let (axes, first) = model.channel(*forces);
                    let turns = if *forces { forces_turn } else { torques_turn };
                    let axis = |place: usize| -> Vector3 {
                        let lane = self.lanes[place];
                        let axis = lane.input.checked_sub(first).and_then(|index| axes.get(index));
                        let axis = axis.copied().unwrap_or_else(Vector3::zeros) * (lane.factor / size);
                        match (turns, *forces) {
                            (false, _) => axis,
                            (true, true) => r * axis,
                            (true, false) => r.tr_mul(&axis),
                        }
                    };
                    for (to, place) in out.iter_mut().zip(places) {
                        let place = usize::from(*place);
                        *to = if is_duration(place) {
                            -power * given.norm_squared()
                        } else if place < m {
                            given.dot(&axis(place))
                        } else {
                            0.0
                        };
                    }
                    for i in 0..m {
                        for j in 0..=i {
                            both(curvature, z, i, j, multiplier * axis(i).dot(&axis(j)));
                        }
                        if let Some(d) = duration {
                            both(curvature, z, i, d, -2.0 * power * multiplier * given.dot(&axis(i)));
                        }
                    }
                    let bend = 2.0 * power * power * multiplier * given.norm_squared();
                    bend_limit(curvature, z, duration, bend);
                }
                (_, What::RateAxis { arc: false, axis, sign, limit }) => {
                    for (to, place) in out.iter_mut().zip(places) {
                        let place = usize::from(*place);
                        *to = sign / limit * space.rate[place][*axis];
                        if is_duration(place) {
                            *to -= grown;
                        }
                    }
                    of_node[*axis] += multiplier * sign / limit;
                    bend_limit(curvature, z, duration, -multiplier * grown);
                }
                (_, What::RateNorm { arc: false, limit }) => {
                    let size = limit * grown;
                    let v = stage.rate / size;
                    let slope = |place: usize| {
                        let of_limit = if is_duration(place) { v } else { Vector3::zeros() };
                        space.rate[place] / size - of_limit
                    };
                    for (to, place) in out.iter_mut().zip(places) {
                        *to = v.dot(&slope(usize::from(*place)));
                    }
                    for (index, i) in places.iter().enumerate() {
                        for j in &places[..=index] {
                            let (i, j) = (usize::from(*i), usize::from(*j));
                            let mut value = slope(i).dot(&slope(j));
                            if is_duration(i) || is_duration(j) {
                                let other = if is_duration(i) { j } else { i };
                                value -= if is_duration(other) {
                                    2.0 * v.dot(&space.rate[other]) / size - v.norm_squared()
                                } else {
                                    v.dot(&space.rate[other]) / size
                                };
                            }
                            both(curvature, z, i, j, multiplier * value);
                        }
                    }
                    of_node += v * (multiplier / size);
                }
                (_, What::RateAxis { arc: true, axis, sign, limit }) => {
                    let by = sign / limit / h;
                    for (to, arc) in space.by_y.iter_mut().zip(&space.arc) {
                        *to = by * arc[*axis];
                    }
                    if let Some(duration) = model.duration {
                        space.by_y[duration] = -grown;
                    }
                    of_arc[*axis] += multiplier * by;
                    bend_limit(curvature, z, duration, -multiplier * grown);
                    through_kick(space, multiplier, m, places, out);
                }
                (_, What::RateNorm { arc: true, limit }) => {
                    let size = limit * grown * h;
                    let v = stage.arc / size;
                    for (to, arc) in space.by_y.iter_mut().zip(&space.arc) {
                        *to = v.dot(arc) / size;
                    }
                    for i in 0..model.n {
                        for j in 0..=i {
                            let value = space.arc[i].dot(&space.arc[j]) / (size * size);
                            if value != 0.0 {
                                both(&mut space.phi, n, i, j, multiplier * value);
                            }
                        }
                    }
                    if let Some(duration) = model.duration {
                        for i in 0..duration {
                            let value = -2.0 * multiplier * space.by_y[i];
                            both(&mut space.phi, n, i, duration, value);
                        }
                        let bend = 2.0 * multiplier * v.norm_squared();
                        space.phi[duration * n + duration] += bend;
                        space.by_y[duration] = -v.norm_squared();
                    }
                    of_arc += v * (multiplier / size);
                    through_kick(space, multiplier, m, places, out);
                }
                (_, What::Cone(cone)) => {
                    space.by_y.fill(0.0);
                    let felt = multiplier.abs() > FELT;
                    if let Some((found, bend)) = self.cone_bent(cone, k, stage, felt) {
                        for i in 0..3 {
                            space.by_y[zeta + i] = found.by_attitude[i];
                        }
                        for i in pi..pi + 3 + model.wheels {
                            space.by_y[i] = found.by_arc.dot(&space.arc[i]);
                        }
                        if let Some(duration) = model.duration {
                            space.by_y[duration] = found.by_duration;
                        }
                        of_arc += found.by_arc * multiplier;
                        if let Some(bend) = bend {
                            self.bend_cone(cone, k, stage, (multiplier, &bend), space);
                        }
                    }
                    if cone.is_of_arc() {
                        through_kick(space, multiplier, m, places, out);
                    } else {
                        for (to, place) in out.iter_mut().zip(places) {
                            *to = space.by_y[usize::from(*place) - m];
                        }
                        for (after, by) in space.after.iter_mut().zip(&space.by_y) {
                            *after += multiplier * by;
                        }
                    }
                }
                (_, What::Burn { .. } | What::BurnOfNorm { .. }) => {}
            }
        }
        if let Some(drift) = drift {
            self.bend_drift(k, stage, drift, (&frame, next), of_arc, space);
            if let Some(duration) = model.duration.filter(|_| passed != Vector3::zeros()) {
                let mu = frame.tr_mul(&Vector3::new(next[zeta], next[zeta + 1], next[zeta + 2]));
                let across = seen.cross(&mu) * (0.5 * h * s);
                for i in 0..duration {
                    let value = across.dot(&space.turn[i]);
                    both(&mut space.phi, n, i, duration, value);
                }
                space.phi[duration * n + duration] -= h * s * mu.dot(&seen);
            }
        }
        // `Yᵀ Φ Y`.
        let mut product = std::mem::take(&mut space.phi_kick);
        for (to, column) in product.chunks_exact_mut(n).zip(space.columns()) {
            to.fill(0.0);
            for (row, value) in column {
                for (to, from) in to.iter_mut().zip(&space.phi[row * n..][..n]) {
                    *to += value * from;
                }
            }
        }
        for (j, from) in product.chunks_exact(n).enumerate() {
            let to = &mut curvature[j * z..][..z];
            for (to, column) in to.iter_mut().zip(space.columns()) {
                *to += column.iter().map(|(row, value)| value * from[*row]).sum::<f64>();
            }
        }
        space.phi_kick = product;
        if bent {
            let own = j_inverse.tr_mul(&of_node) * stage.physical;
            self.bend_kick(stage, &gradient, own, space, curvature);
        }
        if let Some(duration) = model.duration {
            // From `ln s` to its increment.
            let place = m + duration;
            let step = &out.steps[(k * z + place) * n..][..n];
            let mut slope: f64 = step.iter().zip(next).map(|(a, b)| a * b).sum();
            slope -= step[duration] * next[duration];
            for row in self.shape.rows_of(k) {
                let slopes = self.shape.slopes_of(row);
                let known = self.shape.unknowns[slopes.clone()].iter().zip(&out.slopes[slopes]);
                let own = known.filter(|(known, _)| usize::from(**known) == place);
                slope += own.map(|(_, value)| value * duals.rows[row]).sum::<f64>();
            }
            curvature[place * z + place] -= POWER * slope;
            out.hessians[(k * z + place) * z + place] -= POWER * out.gradients[k * z + place];
        }
        Some(())
    }

    /// Gradient and Hessian of the cost of the inputs of a stage.
    fn costs(&self, at: &Point, k: usize, stage: &Stage, space: &Space, out: &mut Derivatives) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let gradient = &mut out.gradients[k * z..][..z];
        let hessian = &mut out.hessians[k * z * z..][..z * z];
        if k < model.first_input() {
            // No such inputs: any weight keeps them where they are.
            (0..m).for_each(|i| hessian[i * z + i] = 1.0);
            return;
        }
        let weight = model.effort_weight(k, stage.stretch) * self.scale;
        let power = f64::from(model.effort_power);
        let duration = model.duration.map(|duration| m + duration);
        let mut effort = 0.0;
        for (place, lane) in self.lanes.iter().enumerate() {
            let column = model.weight.column(lane.input);
            let slope: f64 = column.iter().zip(&space.inputs).map(|(w, u)| w * u).sum();
            gradient[place] += weight * slope * lane.factor;
            effort += 0.5 * weight * slope * lane.factor * at.inputs[k * m + place];
            for (other, second) in self.lanes.iter().enumerate() {
                hessian[place * z + other] += weight * column[second.input] * lane.factor * second.factor;
            }
            if let Some(d) = duration.filter(|_| power != 0.0) {
                both(hessian, z, place, d, power * weight * slope * lane.factor);
            }
        }
        if let Some(d) = duration {
            gradient[d] += power * effort;
            hessian[d * z + d] += power * power * effort;
        }
        if let Some(fuel) = &model.fuel {
            let each = model.kick_weight(k) * self.scale / stage.stretch;
            for (place, lane) in self.lanes.iter().enumerate() {
                let price = each * fuel.inputs[lane.input] * lane.factor.abs();
                gradient[place] += price;
                if let Some(d) = duration {
                    let burnt = price * at.inputs[k * m + place];
                    gradient[d] -= burnt;
                    hessian[d * z + d] += burnt;
                    both(hessian, z, place, d, -price);
                }
            }
        }
    }

    /// Second derivatives of the drift, weighed with the costate after it, and of the arc.
    fn bend_drift(
        &self,
        k: usize,
        stage: &Stage,
        drift: &GyrostatDrift,
        (frame, next): (&Matrix3, &[f64]),
        of_arc: Vector3,
        space: &mut Space,
    ) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(next[at], next[at + 1], next[at + 2]);
        let (mu, momentum) = (frame.tr_mul(&vector(zeta)), vector(pi));
        let weighed = |arc: &Vector3| lie::right_jacobian_inverse(arc).tr_mul(&of_arc);
        let zero = Vector3::zeros();
        let after = Costate { x: zero, gamma: zero, zeta: mu + weighed(&stage.arc), pi: momentum };
        let bend: SMatrix<f64, 9, 9> =
            model.dynamics.gyrostat_curvature(k, drift, [&stage.momentum, &stage.carried], &after);
        let (axes, _) = model.channel(false);
        let by_momentum = bend.fixed_view::<3, 3>(3, 3).into_owned();
        add_symmetric(&mut space.phi, n, pi, &by_momentum);
        let across = drift.f * hat(&mu) * 0.5;
        let mixed = (bend.fixed_view::<3, 3>(3, 6) + bend.fixed_view::<3, 3>(6, 3).transpose()) * 0.5;
        let of_wheels = bend.fixed_view::<3, 3>(6, 6).into_owned();
        let of_wheels = (of_wheels + of_wheels.transpose()) * 0.5;
        let momenta = across * drift.by_momentum;
        for i in 0..3 {
            for j in 0..3 {
                both(&mut space.phi, n, zeta + i, pi + j, -momenta[(i, j)]);
            }
        }
        let by_wheels = across * drift.by_wheels;
        for (wheel, axis) in axes.iter().take(model.wheels).enumerate() {
            let (turned, mixed, own) = (by_wheels * axis, mixed * axis, of_wheels * axis);
            for i in 0..3 {
                both(&mut space.phi, n, zeta + i, 6 + wheel, -turned[i]);
                both(&mut space.phi, n, pi + i, 6 + wheel, mixed[i]);
            }
            for (other, second) in axes.iter().take(wheel + 1).enumerate() {
                both(&mut space.phi, n, 6 + wheel, 6 + other, second.dot(&own));
            }
        }
        if of_arc == zero {
            return;
        }
        // How the weight of the arc changes along it.
        let mut slope = Matrix3::zeros();
        for i in 0..3 {
            let mut by = Vector3::zeros();
            by[i] = STEP;
            let change = (weighed(&(stage.arc + by)) - weighed(&(stage.arc - by))) / (2.0 * STEP);
            slope.set_column(i, &change);
        }
        // `∂(ξᵀ q) = ξᵀ ∂q`, with `ξ = J_r ∂log F`.
        let slope = lie::right_jacobian(&stage.arc).tr_mul(&slope);
        let slope = (slope + slope.transpose()) * 0.5;
        for i in pi..pi + 3 + model.wheels {
            let own = slope * space.arc[i];
            for j in pi..=i {
                both(&mut space.phi, n, i, j, space.arc[j].dot(&own));
            }
        }
    }

    /// Second derivatives of a cone by attitude, arc and duration.
    fn bend_cone(
        &self,
        cone: &Cone,
        k: usize,
        stage: &Stage,
        (multiplier, bend): (f64, &Bend),
        space: &mut Space,
    ) {
        let (model, n) = (self.model, self.shape.n);
        let (zeta, pi) = (model.zeta(), model.pi());
        let bend = bend.scaled(multiplier);
        add_symmetric(&mut space.phi, n, zeta, &bend.attitude);
        let of_arc = pi..pi + if cone.is_of_arc() { 3 + model.wheels } else { 0 };
        for i in of_arc.clone() {
            let (own, turned) = (bend.arc * space.arc[i], bend.mixed * space.arc[i]);
            for j in pi..=i {
                both(&mut space.phi, n, i, j, space.arc[j].dot(&own));
            }
            for j in 0..3 {
                both(&mut space.phi, n, i, zeta + j, turned[j]);
            }
        }
        let Some(duration) = model.duration.filter(|_| !cone.stands(model)) else { return };
        // Directions move as they like, so that their second derivatives by time are differences.
        let gradient = |by: f64| self.cone_in(cone, k, stage, stage.stretch * by.exp());
        // At a moment at which it begins or ends to act there is no difference.
        let (Some(plus), Some(minus)) = (gradient(STEP), gradient(-STEP)) else { return };
        let by = multiplier / (2.0 * STEP);
        let of_attitude = (plus.by_attitude - minus.by_attitude) * by;
        let by_arc = (plus.by_arc - minus.by_arc) * by;
        for i in 0..3 {
            both(&mut space.phi, n, zeta + i, duration, of_attitude[i]);
        }
        for i in of_arc {
            both(&mut space.phi, n, i, duration, by_arc.dot(&space.arc[i]));
        }
        space.phi[duration * n + duration] += (plus.by_duration - minus.by_duration) * by;
    }

    /// Second derivatives of the kick, weighed with the costate after it and with `own` of the physical momentum.
    fn bend_kick(
        &self,
        stage: &Stage,
        gradient: &Blocks,
        own: Vector3,
        space: &Space,
        curvature: &mut [f64],
    ) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let (zeta, pi) = (model.zeta(), model.pi());
        let vector = |at: usize| Vector3::new(space.after[at], space.after[at + 1], space.after[at + 2]);
        let momentum = vector(pi) * stage.weight + own;
        let gamma = if zeta == 6 { vector(3) * stage.weight } else { Vector3::zeros() };
        let (r, squared) = (&stage.pose.attitude, stage.stretch * stage.stretch);
        let at_zeta = m + zeta;
        if !model.is_free() {
            let zero = Vector3::zeros();
            let costate = Costate { x: zero, gamma, zeta: zero, pi: momentum };
            let bend = model.dynamics.field_curvature(&stage.pose, &costate);
            add_symmetric(curvature, z, at_zeta, &(bend.rr * squared));
            if zeta == 6 {
                add_symmetric(curvature, z, m, &(bend.xx * squared));
                for i in 0..3 {
                    for j in 0..3 {
                        let value = 0.5 * (bend.xr[(i, j)] + bend.rx[(j, i)]) * squared;
                        both(curvature, z, m + i, at_zeta + j, value);
                    }
                }
            }
            if let Some(duration) = model.duration {
                let by_turn = gradient.rr.tr_mul(&momentum) + gradient.xr.tr_mul(&gamma);
                let by_place = gradient.rx.tr_mul(&momentum) + gradient.xx.tr_mul(&gamma);
                for i in 0..3 {
                    both(curvature, z, m + duration, at_zeta + i, 2.0 * by_turn[i]);
                    if zeta == 6 {
                        both(curvature, z, m + duration, m + i, 2.0 * by_place[i]);
                    }
                }
                let power = momentum.dot(&stage.field.moment) + gamma.dot(&stage.field.force);
                curvature[(m + duration) * z + m + duration] += 4.0 * power;
            }
        }
        let in_body = r.tr_mul(&gamma);
        let sets = [
            (model.turning(false).filter(|_| model.wheels == 0), false),
            (model.turning(true).filter(|_| zeta == 6), true),
        ];
        for (set, forces) in sets {
            let Some((axes, first)) = set else { continue };
            let slope = |given: &Vector3| {
                if forces { given.cross(&in_body) } else { momentum.cross(&r.tr_mul(given)) }
            };
            let bend = if forces {
                hat(&r.tr_mul(&stage.given.force)) * hat(&in_body)
            } else {
                hat(&momentum) * hat(&stage.given.moment)
            };
            add_symmetric(curvature, z, at_zeta, &bend);
            for (place, lane) in self.lanes.iter().enumerate() {
                let axis = lane.input.checked_sub(first).and_then(|index| axes.get(index));
                let Some(axis) = axis else { continue };
                let by = slope(axis) * lane.factor;
                for i in 0..3 {
                    both(curvature, z, place, at_zeta + i, by[i]);
                }
            }
        }
    }
}

/// A row's gradient by `y`, in `space.by_y`, as one by `z`, and added to the costate after the kick.
fn through_kick(space: &mut Space, multiplier: f64, m: usize, places: &[u16], out: &mut [f64]) {
    let _ = m;
    let mut by_z = std::mem::take(&mut space.by_z);
    for (to, column) in by_z.iter_mut().zip(space.columns()) {
        *to = column.iter().map(|(row, value)| value * space.by_y[*row]).sum();
    }
    for (to, place) in out.iter_mut().zip(places) {
        *to = by_z[usize::from(*place)];
    }
    space.by_z = by_z;
    for (after, by) in space.after.iter_mut().zip(&space.by_y) {
        *after += multiplier * by;
    }
}

/// Second derivative of a limit by the logarithm of the duration.
fn bend_limit(curvature: &mut [f64], z: usize, duration: Option<usize>, value: f64) {
    if let Some(d) = duration {
        curvature[d * z + d] += value;
    }
}
