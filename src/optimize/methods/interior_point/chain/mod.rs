//! The chain of a maneuver (`optimize/chain/model`) with the rows of its limits
//! (`optimize/chain/rows`) as a program of stages.
//!
//! The states are those **before** the kick of their node, so that a stage contains everything that
//! its inputs affect:
//!
//! ```text
//! x_0 = start ,    y = x + κ_k (M(R) + B u) ,   x⁺ = drift(y)
//! at the last node the kick alone ,  e(x_{N+1}) = 0
//! ```
//!
//! With `Y = [κB, I + κG]` of the kick and `D` of the drift, `[B A] = D Y`. The attitude rows of
//! `D` are expressed in the tangent space of the defect: they are rotated by `E = exp S(δ)`, with
//! `δ` the attitude's defect, since `log(R⁺ᵀ R F exp ξ) = δ + E ξ` to first order. With the costate
//! between kick and drift, `λ⁺ = Dᵀλ + Σ z ∂c/∂y`,
//!
//! ```text
//! ∂²(λ·x⁺ + Σ z c) = Yᵀ Φ Y + ∂²(κ λ⁺·(M + Bu)) ,   Φ = ∂²(λ·drift + Σ z c) by y
//! ```
//!
//! `Φ` is the symmetric part of the drift's derivative of the costates along the group
//! (`discrete/step/gyrostat`; a body without wheels is a gyrostat with wheels at rest). A row of
//! the mean rate on an arc, `w·log F`, adds `q = J_r⁻ᵀ(log F) w` to the costate that weights the
//! rotation of the drift.
//!
//! # What differs from the rows of the chain?
//!
//! - A cone is one row on every closed arc, at its largest value. The chain has rows of nodes and
//!   of arcs instead, which become active and inactive.
//! - A two-sided input whose fuel is charged by its magnitude is split into two inputs, one for
//!   each sign. A set whose fuel is charged by the norm of its output has one additional input.
//! - Inputs are in units of their limits. If their rates are limited, the previous inputs are part
//!   of the state.
//! - Multipliers are reported for the chain's rows ([`ChainProgram::found`]), and costates are
//!   those after the kick, `λ^y = (I + κG)⁻ᵀ λ^x`.

pub(crate) mod conditions;
mod curvature;
mod ends;
pub(crate) mod family;
mod layout;
mod point;
mod row_slopes;
mod slopes;
mod space;
mod stage;
#[cfg(test)]
mod testing;
pub(crate) mod warm;

use super::program::{Derivatives, Duals, Increment, Point, Program, RowKind, Shape, Values};
use super::tuning::{OfProgram, Tuning};
use crate::lie;
use crate::maneuver::shortfall::{Excess, Violation};
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::{ChainState, Model};
use crate::optimize::chain::rows::{Group, LimitRows, What};
use crate::optimize::methods::method::Attempt;
use crate::{Matrix3, Vector3};
use family::Family;
use space::Space;
use std::cell::{Cell, RefCell};

/// Exponent of the duration `s` in its increment ζ: `s ← s (1 + POWER ζ)^(1/POWER)`. The limits of
/// inputs are linear in `s^POWER`. The first derivative `f'` with respect to `ln s` is also that
/// with respect to ζ, and the second derivative becomes `f'' − POWER f'`.
const POWER: f64 = 2.0;

/// Input of the program: an input of the chain in units of its limit, or the positive or negative
/// part of such an input.
#[derive(Clone, Copy, Debug)]
struct Lane {
    input: usize,
    factor: f64,
}

/// Set of inputs whose fuel is charged by the norm of its force or torque. An additional input `σ`
/// is an upper bound of this norm, relative to its limit:
///
/// ```text
/// |B u| ≤ limit σ :     ½ ((|B u|²/limit² + ε²)/σ − σ) ≤ 0 ,   cost κ c limit σ/s
/// ```
///
/// with `ε²` proportional to the barrier parameter, or to the mean complementarity while that is
/// larger. Without `ε` the row has a corner at zero, where Newton's method diverges.
#[derive(Clone, Copy, Debug)]
struct Norm {
    forces: bool,
    limit: f64,
    /// Scaled price of the fuel per unit of `σ` and of time.
    price: f64,
    /// Index of `σ` among the inputs of a stage.
    place: usize,
}

/// Kind of a row (constraint) of the program.
#[derive(Clone, Copy, Debug)]
enum Bound {
    /// A row of the chain, at the stage to which the chain assigns it.
    Row,
    /// Limit of an input rate, at the later of the two stages.
    Change,
    /// Nonnegativity of one sign of an input that burns fuel; holds the index of the program's
    /// input.
    Side(usize),
    /// Upper bound `σ`, the fuel variable, on the norm of a set of inputs; holds the index of the
    /// norm.
    Norm(usize),
    /// Limit of the roll of the end on one side of its allowed band; holds the sign of the side.
    Roll(f64),
}

/// Row of the program: its kind, and the index of the corresponding row of the chain.
#[derive(Clone, Copy, Debug)]
struct Row {
    bound: Bound,
    row: usize,
}

/// Index of a row that corresponds to no row of the chain.
const NO_ROW: usize = usize::MAX;

/// A chain with its limits, formulated as a program of the interior-point method.
pub(crate) struct ChainProgram<'a> {
    model: &'a Model,
    limits: &'a LimitRows,
    shape: Shape,
    lanes: Vec<Lane>,
    norms: Vec<Norm>,
    /// Smoothing `ε²` of the norms.
    round: Cell<f64>,
    rows: Vec<Row>,
    /// Units in which the program measures the chain's inputs.
    units: Vec<f64>,
    /// Number of state components that hold the previous inputs: 0 without rate limits.
    before: usize,
    /// Family of possible ends; `None` if the end is fixed.
    family: Option<&'a Family>,
    /// Index of the roll of the end in a tangent vector; `None` if the end has no free roll.
    roll: Option<usize>,
    /// Known optima of the chain.
    pub known: &'a [Attempt],
    /// Indices of the prescribed components of the terminal error.
    given: Vec<usize>,
    /// Factor from the cost of the chain to the cost of the program.
    scale: f64,
    /// Penalties of the terminal equations.
    prices: Vec<f64>,
    tuning: OfProgram,
    space: RefCell<Space>,
}

impl<'a> ChainProgram<'a> {
    /// Builds the program of a chain, with the end of the chain or a family of ends. It is scaled
    /// for a first point of about the size of `start`.
    pub fn of(
        model: &'a Model,
        limits: &'a LimitRows,
        family: Option<&'a Family>,
        start: &Iterate,
        tuning: &Tuning,
    ) -> Self {
        let mut units = vec![0.0f64; model.m];
        let mut split = vec![false; model.m];
        for row in &limits.rows {
            match row.what {
                What::InputSize { input, limit, .. } => units[input] = limit,
                What::Push { input, limit } => units[input] = limit,
                What::Burn { input, limit } => {
                    if limit.is_finite() {
                        units[input] = limit;
                    }
                    split[input] = true;
                }
                _ => {}
            }
        }
        // An input without a limit is scaled by its largest value in the first iterate.
        for (input, unit) in units.iter_mut().enumerate() {
            let largest = start.inputs.iter().map(|inputs| inputs[input].abs()).fold(0.0, f64::max);
            if *unit <= 0.0 {
                *unit = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        let mut lanes = Vec::new();
        for (input, unit) in units.iter().enumerate() {
            lanes.push(Lane { input, factor: *unit });
            if split[input] {
                lanes.push(Lane { input, factor: -unit });
            }
        }
        let norms = layout::norms(model, limits, lanes.len());
        let changes = limits.rows.iter().any(|row| matches!(row.what, What::InputRate { .. }));
        let before = if changes { model.m } else { 0 };
        let roll = family.filter(|family| family.has_roll()).map(|_| model.n + before);
        let free = usize::from(roll.is_some());
        let n = model.n + before + free;
        let fixed = if model.zeta() == 6 { 6 } else { 0 } + 9 + 3 + model.wheels + 1;
        let given = model.given();
        let mut shape = Shape {
            terminal: given.len(),
            starts: usize::from(model.duration.is_some()) + free,
            ..Shape::new(n, lanes.len() + norms.len(), fixed + before + free, model.steps + 1)
        };
        let (mut rows, space) = (Vec::new(), Space::of(&shape, model.m));
        for stage in 0..=model.steps {
            layout::describe(model, limits, (&lanes, &norms), stage, &mut shape, &mut rows);
            if let Some(roll) = roll.filter(|_| stage == model.steps && family.is_some_and(Family::is_band)) {
                layout::hold_roll(roll, &mut shape, &mut rows);
            }
            shape.end_stage();
        }
        let mut program = Self {
            model,
            limits,
            shape,
            lanes,
            norms,
            round: Cell::new(0.0),
            rows,
            units,
            before,
            family,
            roll,
            known: &[],
            scale: 1.0,
            prices: vec![1.0; given.len()],
            given,
            tuning: tuning.program.clone(),
            space: RefCell::new(space),
        };
        let cost = start.cost(model);
        if cost > 0.0 && cost.is_finite() {
            program.scale = program.tuning.cost / cost;
        }
        program.prices(start);
        program
    }

    /// Returns the duration, as a multiple of the stated one, in which a path keeps a margin from
    /// the limits that grow with the duration; `None` if the path cannot be evaluated or reaches no
    /// such limit.
    pub fn fitting(&self, at: &Point) -> Option<f64> {
        let mut values = Values::of(&self.shape);
        if !(self.values(at, &mut values) && values.are_finite()) {
            return None;
        }
        let zeta = self.model.zeta();
        let s = at.states[zeta + 12 + self.model.wheels];
        let mut needed = 0.0f64;
        for (row, c) in self.rows.iter().zip(&values.rows) {
            let Some(what) = self.what_of(row) else { continue };
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
        (needed > 0.0).then_some(self.tuning.room * needed)
    }

    /// Sets the penalties of the terminal equations for a maneuver of the size of `start`.
    fn prices(&mut self, start: &Iterate) {
        let first = start.states[0].attitude;
        let least = self.tuning.least_size;
        let largest = |of: &dyn Fn(&ChainState) -> f64| start.states.iter().map(of).fold(least, f64::max);
        let turned = largest(&|state| lie::minus(&state.attitude, &first).norm());
        // Momentum of the body: with wheels the total momentum may be zero.
        let of_body = |state: &ChainState| state.momentum - self.model.wheel_momentum(&state.wheels);
        let momentum = largest(&|state| of_body(state).norm());
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

    /// Returns the chain's row that corresponds to a row of the program; `None` if none does.
    fn what_of(&self, row: &Row) -> Option<&What> {
        self.limits.rows.get(row.row).map(|row| &row.what)
    }

    /// Returns the number of groups of the chain's rows.
    pub fn groups(&self) -> usize {
        self.limits.groups.len()
    }

    /// Returns the index of the group to which a row of the program belongs; the row must
    /// correspond to a row of the chain.
    pub fn group_of(&self, row: usize) -> usize {
        self.limits.rows[self.rows[row].row].group
    }

    /// Returns whether the iterates of a method that keeps linear limits of the inputs may violate
    /// a row.
    pub fn may_be_violated(&self, row: usize) -> bool {
        self.shape.kinds[row] != RowKind::Hard || self.what_of(&self.rows[row]).is_some_and(What::is_ball)
    }

    /// Returns the index of the first attitude component in a tangent vector.
    pub fn attitude(&self) -> usize {
        self.model.zeta()
    }

    /// Returns the largest violation in each group of rows; zero if the group is satisfied.
    pub fn violations(&self, values: &Values) -> Vec<f64> {
        let mut worst = vec![0.0f64; self.groups()];
        for ((row, c), kind) in self.rows.iter().zip(&values.rows).zip(&self.shape.kinds) {
            let Some(limit) = self.limits.rows.get(row.row) else { continue };
            let off = if *kind == RowKind::Equation { c.abs() } else { *c };
            worst[limit.group] = worst[limit.group].max(off);
        }
        worst
    }

    /// Returns the violations larger than `above`, with the names of their groups.
    pub fn noticed(&self, values: &Values, above: f64) -> Vec<Violation> {
        let named = self.limits.groups.iter().zip(self.violations(values));
        let noticed = named.filter(|(_, violation)| *violation > above);
        // Violations of cones are angles, violations of limits are relative.
        let excess = |is_angle: bool| if is_angle { Excess::Angle } else { Excess::Share };
        let violation = |(group, by): (&Group, f64)| Violation {
            name: group.name.clone(),
            excess: excess(group.is_angle)(by),
        };
        noticed.map(violation).collect()
    }

    /// Returns the index of the first previous input among the coordinates of a state.
    fn held(&self) -> usize {
        self.model.zeta() + 13 + self.model.wheels
    }

    /// Returns the force or torque of a set relative to its limit, in the axes of the set.
    fn burnt(&self, norm: &Norm, inputs: &[f64]) -> Vector3 {
        let (axes, first) = self.model.channel(norm.forces);
        let given: Vector3 = axes.iter().zip(&inputs[first..]).map(|(axis, u)| axis * *u).sum();
        given / norm.limit
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
                // The values of cones are computed together with their derivatives.
                if !matches!(self.what_of(&self.rows[row]), Some(What::Cone(_))) {
                    out.values.rows[row] = self.value(&self.rows[row], k, at, &stage, space);
                }
            }
            out.gradients[k * z..][..z].fill(0.0);
            out.hessians[k * z * z..][..z * z].fill(0.0);
            out.curvatures[k * z * z..][..z * z].fill(0.0);
            self.slopes(at, k, &stage, duals, space, out);
        }
        self.terminal(at, &mut out.values.terminal);
        self.ends(at, duals, out)
    }

    fn known(&self, at: &Point, excess: f64) -> Option<usize> {
        let cost = (self.cost_of(at) - excess) / self.scale;
        self.known.iter().position(|known| {
            cost >= known.foreseen() * (1.0 - self.tuning.same_cost)
                && self.apart(at, &known.candidate) <= self.tuning.same
        })
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
            // Restore orthogonality, to second order in the round-off.
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
            if let Some(roll) = self.roll {
                to[c - 1] = from[c - 1] + part * z[roll];
            }
        }
        // The start state is a function of the duration.
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

    fn at_barrier(&self, barrier: f64) {
        self.round.set(self.tuning.rounding * barrier);
    }

    fn longest(&self, at: &Point, by: &Increment) -> f64 {
        let (model, n, m) = (self.model, self.shape.n, self.shape.m);
        let zeta = model.zeta();
        let longest = self.tuning.longest_turn;
        let mut part = 1.0f64;
        for (norm, stage) in self.norms.iter().flat_map(|norm| (0..self.shape.stages).map(move |k| (norm, k)))
        {
            let place = stage * m + norm.place;
            if by.inputs[place] < 0.0 {
                part = part.min(-self.tuning.to_nothing * at.inputs[place] / by.inputs[place]);
            }
        }
        for z in by.states.chunks_exact(n) {
            let turn = Vector3::new(z[zeta], z[zeta + 1], z[zeta + 2]).norm();
            part = part.min(longest / turn.max(longest));
            if let Some(duration) = model.duration {
                let [least, most] =
                    self.tuning.longest_stretch.map(|grown| (grown.powf(POWER) - 1.0) / POWER);
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
