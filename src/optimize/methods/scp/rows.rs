//! Limits and constraints as inequality rows of the stages, relative to their limits.
//!
//! A row is a half space `c ≤ 0` or a ball `|v| ≤ 1` and knows its derivatives. What must hold between
//! the nodes is a row of the arc of its own: on one step the body turns about one axis at one rate.
//!
//! Where the duration is sought limits grow with it, as `s`, `s²` or `s³` (`model`).
//!
//! What has a kink in the cost is a row as well: `p |v|`, with `v` an input or what the torque inputs give, as a part of
//! its limit. Its multiplier is a slope of the cost,
//!
//! ```text
//! p |v| = max ν·v  over  |ν| ≤ p ;      v = 0 where |ν| < p ,      ν = p v/|v| elsewhere ,
//! ```
//!
//! and an input that pushes to one side only costs `p v` for `v ≥ 0`, with `ν ≤ p`: any slope holds it at 0.

use super::model::{Arc, ChainState, Model};
use crate::lie;
use crate::maneuver::constraint::{Direction, Rule, Side};
use crate::maneuver::problem::Problem;
use crate::mechanics::actuators::{InputLimit, LimitKind};
use crate::{Matrix3, Vector3};
use nalgebra::{DVector, Matrix3xX};
use std::ops::Range;

/// What one row bounds.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// `sign u_i ≤ limit`.
    InputSize { input: usize, sign: f64, limit: f64 },
    /// `sign (u⁺_i − u_i) ≤ limit`, from this stage to the next.
    InputRate { input: usize, sign: f64, limit: f64 },
    /// `|B u| ≤ limit`, forces or torques.
    InputNorm { forces: bool, limit: f64 },
    /// `|Ω| ≤ limit`, at the node or on the arc that begins here.
    RateNorm { arc: bool, limit: f64 },
    /// `sign Ω_axis ≤ limit`.
    RateAxis { arc: bool, axis: usize, sign: f64, limit: f64 },
    /// `sign (w·R b) ≤ sign cos α`.
    Cone { arc: bool, boresight: Vector3, direction: Direction, sign: f64, half_angle: f64 },
    /// `sign h_i ≤ limit` of a wheel's momentum.
    Wheel { wheel: usize, sign: f64, limit: f64 },
    /// An input as a part of its limit, which has a kink at 0 and may have no other side.
    Burn { input: usize, limit: f64, one_sided: bool },
    /// The same of a component of the force or the torque.
    BurnOfNorm { forces: bool, component: usize, limit: f64 },
}

/// A row at its stage.
#[derive(Clone, Debug)]
pub(crate) struct LimitRow {
    /// Index of its constraint in [`LimitRows::groups`].
    pub group: usize,
    pub stage: usize,
    pub what: What,
}

/// A constraint or limit, with all its rows.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub name: String,
    /// Limits of the inputs hold throughout; the others may be violated on the way to a solution.
    pub hard: bool,
    /// Whether violations are angles \[rad\]; otherwise they are shares of the limit.
    pub is_angle: bool,
}

/// All rows of a maneuver, stage after stage.
#[derive(Clone, Debug, Default)]
pub(crate) struct LimitRows {
    pub groups: Vec<Group>,
    pub rows: Vec<LimitRow>,
    /// Kinks of the cost, in the order of their rows.
    pub kinks: Vec<Kink>,
}

/// A kink of the cost: `price |v|`, or `price v` where `v ≥ 0`.
#[derive(Clone, Debug)]
pub(crate) struct Kink {
    /// Rows of the components of v.
    pub rows: Range<usize>,
    pub price: f64,
    pub one_sided: bool,
}

impl Kink {
    /// What it costs.
    pub fn cost(&self, v: &[f64]) -> f64 {
        self.price * if self.one_sided { v[0] } else { size(v) }
    }

    /// Whether v stays at 0 under a slope.
    pub fn holds(&self, slope: &[f64]) -> bool {
        if self.one_sided { slope[0] <= self.price } else { size(slope) <= self.price }
    }
}

/// The length of a vector.
pub(crate) fn size(v: &[f64]) -> f64 {
    v.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// A row at an iterate. `next` is the derivative with respect to the inputs of the stage after.
#[derive(Clone, Debug)]
pub(crate) enum RowValue {
    /// `c ≤ 0`.
    Half { c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>, next: Option<DVector<f64>> },
    /// `|v| ≤ 1`, 3×n and 3×m derivatives.
    Ball { v: Vector3, state: Option<Matrix3xX<f64>>, inputs: Option<Matrix3xX<f64>> },
    /// `v`, or a component of it, where the cost has a kink.
    Kink { v: f64, state: Option<DVector<f64>>, inputs: DVector<f64> },
    /// The arc has no extremum of its own: its ends bound it.
    Idle,
}

impl RowValue {
    /// A half space by the state, and by the inputs of its own stage.
    fn half(c: f64, state: Option<DVector<f64>>, inputs: Option<DVector<f64>>) -> Self {
        Self::Half { c, state, inputs, next: None }
    }

    /// The same with a limit that grows as `s^power`: `c ≤ s^power − 1`, or `|v| ≤ s^power`.
    fn grown(self, model: &Model, duration: usize, stretch: f64, power: i32) -> Self {
        let (limit, slope) = (stretch.powi(power), f64::from(power));
        match self {
            Self::Half { c, state, inputs, next } => {
                let mut state = state.unwrap_or_else(|| DVector::zeros(model.n));
                state[duration] -= slope * limit;
                Self::Half { c: c + 1.0 - limit, state: Some(state), inputs, next }
            }
            Self::Ball { v, state, inputs } => {
                let v = v / limit;
                let mut state = state.map_or_else(|| Matrix3xX::zeros(model.n), |state| state / limit);
                let mut column = state.column_mut(duration);
                column -= v * slope;
                Self::Ball { v, state: Some(state), inputs: inputs.map(|inputs| inputs / limit) }
            }
            Self::Kink { .. } | Self::Idle => self,
        }
    }

    /// The violation: positive where the row does not hold.
    pub fn violation(&self) -> f64 {
        match self {
            Self::Half { c, .. } => *c,
            Self::Ball { v, .. } => v.norm() - 1.0,
            Self::Kink { .. } | Self::Idle => -1.0,
        }
    }

    /// Derivatives with respect to the state, the inputs, and those of the stage after, of a row that is smooth.
    pub fn slopes(&self) -> [Option<&DVector<f64>>; 3] {
        match self {
            Self::Half { state, inputs, next, .. } => [state.as_ref(), inputs.as_ref(), next.as_ref()],
            Self::Kink { state, inputs, .. } => [state.as_ref(), Some(inputs), None],
            Self::Ball { .. } | Self::Idle => [None; 3],
        }
    }

    /// `v` of a kink.
    pub fn kinked(&self) -> f64 {
        if let Self::Kink { v, .. } = self { *v } else { 0.0 }
    }

    /// The row as `c ≤ 0` with a smooth `c`: a ball as `(|v|² − 1)/2`.
    pub fn smooth(&self) -> Self {
        match self {
            Self::Ball { v, state, inputs } => {
                let row = |slope: &Matrix3xX<f64>| slope.tr_mul(v);
                Self::half(0.5 * (v.norm_squared() - 1.0), state.as_ref().map(row), inputs.as_ref().map(row))
            }
            other => other.clone(),
        }
    }
}

/// What a row is evaluated at.
pub(crate) struct Place<'a> {
    pub state: &'a ChainState,
    pub inputs: &'a [f64],
    pub next: &'a [f64],
    /// The arc that begins here; none at the last node, whose rows ask for none.
    pub arc: Option<&'a Arc>,
}

impl What {
    /// What a constraint bounds at a node or on an arc; `duration` is the unit of time \[s\].
    fn of(rule: &Rule, arc: bool, duration: f64) -> Vec<Self> {
        match rule {
            Rule::RateNorm(limit) => vec![Self::RateNorm { arc, limit: limit * duration }],
            Rule::RateAxes(limits) => {
                let row = |axis: usize, sign: f64| Self::RateAxis {
                    arc,
                    axis,
                    sign,
                    limit: limits[axis] * duration,
                };
                (0..3).flat_map(|axis| [row(axis, 1.0), row(axis, -1.0)]).collect()
            }
            Rule::Pointing(pointing) => {
                let sign = if pointing.side == Side::KeepOut { 1.0 } else { -1.0 };
                let half_angle = pointing.effective_half_angle();
                let cone = |(boresight, direction): (&Vector3, &Direction)| Self::Cone {
                    arc,
                    boresight: *boresight,
                    direction: *direction,
                    sign,
                    half_angle,
                };
                pointing.pairs().map(cone).collect()
            }
        }
    }

    /// Whether it depends on the state, and is not linear.
    pub fn is_curved(&self, model: &Model) -> bool {
        let linear = matches!(
            self,
            Self::InputSize { .. }
                | Self::InputRate { .. }
                | Self::Wheel { .. }
                | Self::Burn { .. }
                | Self::BurnOfNorm { .. }
        );
        !linear || model.duration.is_some()
    }

    /// Power of the duration with which the limit grows.
    pub fn growth(&self) -> i32 {
        match self {
            Self::Cone { .. } | Self::Burn { .. } | Self::BurnOfNorm { .. } => 0,
            Self::RateNorm { .. } | Self::RateAxis { .. } | Self::Wheel { .. } => 1,
            Self::InputSize { .. } | Self::InputNorm { .. } => 2,
            Self::InputRate { .. } => 3,
        }
    }

    /// The input it bounds, if it bounds one.
    pub fn input(&self) -> Option<usize> {
        match self {
            Self::InputSize { input, .. } | Self::InputRate { input, .. } | Self::Burn { input, .. } => {
                Some(*input)
            }
            _ => None,
        }
    }

    /// Whether it is one of an arc.
    pub fn is_of_arc(&self) -> bool {
        matches!(
            self,
            Self::RateNorm { arc: true, .. }
                | Self::RateAxis { arc: true, .. }
                | Self::Cone { arc: true, .. }
        )
    }

    /// Whether it knows of the state nothing but the duration.
    pub fn is_of_inputs(&self) -> bool {
        self.input().is_some() || matches!(self, Self::InputNorm { .. } | Self::BurnOfNorm { .. })
    }

    /// Whether it bounds the size of one input, or how fast that changes.
    pub fn is_of_one_input(&self) -> bool {
        matches!(self, Self::InputSize { .. } | Self::InputRate { .. })
    }

    /// Whether it is a ball.
    pub fn is_ball(&self) -> bool {
        matches!(self, Self::InputNorm { .. } | Self::RateNorm { .. })
    }

    /// Whether it is a kink of the cost.
    pub fn is_kink(&self) -> bool {
        matches!(self, Self::Burn { .. } | Self::BurnOfNorm { .. })
    }

    /// Whether it depends on (state, inputs of its stage).
    pub fn depends(&self, model: &Model) -> (bool, bool) {
        let lag = model.lag(1) > 0.0;
        match self {
            Self::InputSize { .. }
            | Self::InputNorm { .. }
            | Self::InputRate { .. }
            | Self::Burn { .. }
            | Self::BurnOfNorm { .. } => (model.duration.is_some(), true),
            Self::RateNorm { arc, .. } | Self::RateAxis { arc, .. } => (true, !arc && lag),
            Self::Cone { .. } => (true, false),
            Self::Wheel { .. } => (true, lag),
        }
    }

    /// The row at a place of stage `stage`.
    pub fn at(&self, model: &Model, stage: usize, place: &Place) -> RowValue {
        let row = self.of_stated(model, stage, place);
        match model.duration.filter(|_| self.growth() > 0) {
            Some(duration) => row.grown(model, duration, place.state.stretch, self.growth()),
            None => row,
        }
    }

    /// The row with the limit of the stated duration.
    fn of_stated(&self, model: &Model, stage: usize, place: &Place) -> RowValue {
        let unit = |input: usize, value: f64| {
            let mut row = DVector::zeros(model.m);
            row[input] = value;
            Some(row)
        };
        match self {
            Self::InputSize { input, sign, limit } => {
                RowValue::half(sign * place.inputs[*input] / limit - 1.0, None, unit(*input, sign / limit))
            }
            Self::InputRate { input, sign, limit } => RowValue::Half {
                c: sign * (place.next[*input] - place.inputs[*input]) / limit - 1.0,
                state: None,
                inputs: unit(*input, -sign / limit),
                next: unit(*input, sign / limit),
            },
            Self::InputNorm { forces, limit } => {
                let (axes, first) = model.channel(*forces);
                let mut slope = Matrix3xX::zeros(model.m);
                for (index, axis) in axes.iter().enumerate() {
                    slope.set_column(first + index, &(axis / *limit));
                }
                let v = &slope * DVector::from_column_slice(place.inputs);
                RowValue::Ball { v, state: None, inputs: Some(slope) }
            }
            Self::RateNorm { arc, limit } => {
                let (rate, state, inputs) = rate(model, stage, place, *arc);
                let inputs = inputs.map(|slope| slope / *limit);
                RowValue::Ball { v: rate / *limit, state: Some(state / *limit), inputs }
            }
            Self::RateAxis { arc, axis, sign, limit } => {
                let (rate, state, inputs) = rate(model, stage, place, *arc);
                let row = |slope: &Matrix3xX<f64>| slope.row(*axis).transpose() * (sign / limit);
                RowValue::half(sign * rate[*axis] / limit - 1.0, Some(row(&state)), inputs.as_ref().map(row))
            }
            Self::Cone { arc, boresight, direction, sign, half_angle } => {
                let (frame_rate, grid) = (model.frame_rate() * place.state.stretch, &model.dynamics.grid);
                let along = place.arc.filter(|_| *arc);
                let turns = along.filter(|_| direction.turns_with_frame);
                let pointing = BoresightArc {
                    attitude: place.state.attitude,
                    boresight: *boresight,
                    direction: direction.at(grid.after(stage), &frame_rate),
                    turn: turns.map_or_else(Vector3::zeros, |_| frame_rate * grid.step(stage)),
                    arc: along.map_or_else(Vector3::zeros, |arc| arc.turn),
                    sign: *sign,
                };
                let fraction = if *arc { pointing.extremum() } else { Some(0.0) };
                let Some(fraction) = fraction else { return RowValue::Idle };
                let (cosine, slope) = pointing.at(fraction);
                // Near the edge of the cone this is the violation in rad.
                let scale = 1.0 / half_angle.sin();
                let mut state = DVector::zeros(model.n);
                let mut by_zeta = state.rows_mut(model.zeta(), 3);
                match along {
                    Some(Arc { turn, slope: of_turn }) => {
                        let arrived = lie::exp(&(turn * -fraction));
                        by_zeta.copy_from(&(arrived.tr_mul(&slope) * scale));
                        let along = lie::right_jacobian(&(turn * fraction)) * fraction;
                        state += of_turn.tr_mul(&along.tr_mul(&slope)) * scale;
                    }
                    None => by_zeta.copy_from(&(slope * scale)),
                }
                if let Some(duration) = model.duration {
                    let fallen = if direction.turns_with_frame { 0.0 } else { -grid.after(stage) };
                    let passed = frame_rate * fallen + pointing.turn * fraction;
                    state[duration] += pointing.along(fraction, &passed) * scale;
                }
                RowValue::half((cosine - sign * half_angle.cos()) * scale, Some(state), None)
            }
            Self::Wheel { wheel, sign, limit } => {
                let lag = model.lag(stage);
                let momentum = place.state.wheels[*wheel] + lag * place.inputs[model.forces + wheel];
                let mut state = DVector::zeros(model.n);
                state[6 + wheel] = sign / limit;
                let inputs = if lag > 0.0 { unit(model.forces + wheel, sign * lag / limit) } else { None };
                RowValue::half(sign * momentum / limit - 1.0, Some(state), inputs)
            }
            Self::Burn { input, limit, .. } => {
                let mut slope = DVector::zeros(model.m);
                slope[*input] = 1.0 / limit;
                burnt(model, place, slope)
            }
            Self::BurnOfNorm { forces, component, limit } => {
                let (axes, first) = model.channel(*forces);
                let mut slope = DVector::zeros(model.m);
                for (index, axis) in axes.iter().enumerate() {
                    slope[first + index] = axis[*component] / limit;
                }
                burnt(model, place, slope)
            }
        }
    }
}

/// `v = slope·u / s`: what is burnt at a stage, in a unit that does not go with the duration.
fn burnt(model: &Model, place: &Place, slope: DVector<f64>) -> RowValue {
    let inputs = slope / place.state.stretch;
    let v: f64 = inputs.iter().zip(place.inputs).map(|(slope, u)| slope * u).sum();
    let state = model.duration.map(|duration| {
        let mut state = DVector::zeros(model.n);
        state[duration] = -v;
        state
    });
    RowValue::Kink { v, state, inputs }
}

/// Angular velocity at the node, or on the arc, with its derivatives.
fn rate(
    model: &Model,
    stage: usize,
    place: &Place,
    arc: bool,
) -> (Vector3, Matrix3xX<f64>, Option<Matrix3xX<f64>>) {
    if let Some(arc) = place.arc.filter(|_| arc) {
        let h = model.dynamics.grid.step(stage);
        return (arc.turn / h, &arc.slope / h, None);
    }
    let (rate, state, inputs) = model.rate(stage, place.state, place.inputs);
    (rate, state, (model.lag(stage) > 0.0).then_some(inputs))
}

/// A boresight on one arc, `sign w(τ)·R exp(τ S(f)) b`, where the direction turns in the reference
/// frame's axes if it is fixed to that frame.
struct BoresightArc {
    attitude: Matrix3,
    boresight: Vector3,
    direction: Vector3,
    turn: Vector3,
    arc: Vector3,
    sign: f64,
}

impl BoresightArc {
    /// Value at a fraction of the arc, and derivative with respect to ζ there.
    fn at(&self, fraction: f64) -> (f64, Vector3) {
        let attitude = self.attitude * lie::exp(&(self.arc * fraction));
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        let seen = attitude.tr_mul(&direction);
        (self.sign * self.boresight.dot(&seen), self.boresight.cross(&seen) * self.sign)
    }

    /// Change of the value at a fraction of the arc as the direction is turned by a rotation vector.
    fn along(&self, fraction: f64, turned: &Vector3) -> f64 {
        let boresight = self.attitude * (lie::exp(&(self.arc * fraction)) * self.boresight);
        let direction = lie::exp(&(self.turn * fraction)) * self.direction;
        self.sign * boresight.dot(&turned.cross(&direction))
    }

    /// First and second derivative along the arc.
    fn slopes(&self, fraction: f64) -> (f64, f64) {
        let attitude = self.attitude * lie::exp(&(self.arc * fraction));
        let w = lie::exp(&(self.turn * fraction)) * self.direction;
        let (w1, w2) = (self.turn.cross(&w), self.turn.cross(&self.turn.cross(&w)));
        let b1 = self.arc.cross(&self.boresight);
        let (p, p1, p2) = (attitude * self.boresight, attitude * b1, attitude * self.arc.cross(&b1));
        let first = w1.dot(&p) + w.dot(&p1);
        let second = w2.dot(&p) + 2.0 * w1.dot(&p1) + w.dot(&p2);
        (self.sign * first, self.sign * second)
    }

    /// Where inside the arc the value is largest; `None` where that is at an end. An arc turns far less
    /// than half a turn, so the slope changes its sign once at most.
    fn extremum(&self) -> Option<f64> {
        let (mut low, mut high) = (0.0, 1.0);
        if self.slopes(low).0 <= 0.0 || self.slopes(high).0 >= 0.0 {
            return None;
        }
        let mut at = 0.5;
        for _ in 0..60 {
            let (first, second) = self.slopes(at);
            if first > 0.0 {
                low = at
            } else {
                high = at
            }
            let newton = at - first / second;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - at).abs() <= 1e-15 {
                return Some(next);
            }
            at = next;
        }
        Some(at)
    }
}

impl LimitRows {
    /// Where the rows of one stage stand.
    pub fn range(&self, stage: usize) -> Range<usize> {
        let first = |stage: usize| self.rows.partition_point(|row| row.stage < stage);
        first(stage)..first(stage + 1)
    }

    /// The rows of a maneuver on the grid of `model`.
    pub fn of(problem: &Problem, model: &Model) -> Self {
        let mut rows = Self::default();
        rows.input_limits(problem, model);
        for constraint in &problem.constraints {
            let group = rows.group(&constraint.name, false);
            rows.groups[group].is_angle = matches!(constraint.rule, Rule::Pointing(_));
            // At every inner node and on every arc.
            for (stage, arc) in (0..model.steps).flat_map(|stage| [(stage, false), (stage, true)]) {
                if arc || stage > 0 {
                    let whats = What::of(&constraint.rule, arc, problem.duration);
                    rows.rows.extend(whats.into_iter().map(|what| LimitRow { group, stage, what }));
                }
            }
        }
        rows.burns(problem, model);
        rows.rows.sort_by_key(|row| row.stage);
        rows.find_kinks(model);
        rows
    }

    /// Rows of what has a kink in the cost: inputs that cost fuel or push to one side only, or what they give together.
    fn burns(&mut self, problem: &Problem, model: &Model) {
        let bounds = model.input_bounds(problem);
        let sets = [(true, problem.actuation.force.as_ref(), 0..model.forces)];
        let sets = sets.into_iter().chain([(false, Some(&problem.actuation.torque), model.forces..model.m)]);
        for (forces, set, inputs) in sets {
            let Some(set) = set.filter(|_| !inputs.is_empty()) else { continue };
            let one_sided = set.limits().one_sided;
            let whats: Vec<What> = match (&model.fuel, set.limits().norm) {
                (None, _) if !one_sided => continue,
                (Some(fuel), Some(norm)) if fuel.is_of_norm(forces) => {
                    let limit = norm / model.input_unit[inputs.start];
                    (0..3).map(|component| What::BurnOfNorm { forces, component, limit }).collect()
                }
                _ => inputs.map(|input| What::Burn { input, limit: bounds[input], one_sided }).collect(),
            };
            let group = self.group(problem.actuation.limit_name(LimitKind::Size, forces), true);
            for stage in model.first_input()..=model.steps {
                self.rows.extend(whats.iter().map(|what| LimitRow { group, stage, what: what.clone() }));
            }
        }
    }

    /// The kinks that their rows make.
    fn find_kinks(&mut self, model: &Model) {
        let price = |input: usize| model.fuel.as_ref().map_or(0.0, |fuel| fuel.inputs[input]);
        for (index, row) in self.rows.iter().enumerate() {
            let (count, rate, one_sided) = match row.what {
                What::Burn { input, limit, one_sided } => (1, price(input) * limit, one_sided),
                What::BurnOfNorm { forces, component: 0, limit } => {
                    (3, price(model.channel(forces).1) * limit, false)
                }
                _ => continue,
            };
            let price = model.kick_weight(row.stage) * rate;
            self.kinks.push(Kink { rows: index..index + count, price, one_sided });
        }
    }

    fn group(&mut self, name: &str, hard: bool) -> usize {
        self.groups.push(Group { name: name.into(), hard, is_angle: false });
        self.groups.len() - 1
    }

    /// Rows for both signs of everything that is bounded, at every stage that has it; forces first.
    fn input_limits(&mut self, problem: &Problem, model: &Model) {
        let mut limits: Vec<_> = problem.actuation.limits().collect();
        limits.retain(|limit| !limit.of_force || model.forces > 0);
        limits.sort_by_key(|limit| limit.first);
        for InputLimit { kind, name, of_force: forces, set, bounds, .. } in limits {
            let group = self.group(name, kind != LimitKind::WheelMomentum);
            let (_, offset) = model.channel(forces);
            let (unit, momentum) = (model.input_unit[offset], model.dynamics.units.momentum());
            // What pushes to one side only is held at 0 by the kink of its cost.
            let one_sided = kind == LimitKind::Size && set.limits().one_sided;
            let signs = if one_sided || kind == LimitKind::Norm { &[1.0][..] } else { &[1.0, -1.0] };
            let stages = match kind {
                LimitKind::Size | LimitKind::Norm => model.first_input()..=model.steps,
                LimitKind::Rate => model.first_input()..=model.steps - 1,
                LimitKind::WheelMomentum => 1..=model.steps,
            };
            for stage in stages {
                for (index, bound) in bounds.iter().enumerate().filter(|(_, bound)| bound.is_finite()) {
                    let input = offset + index;
                    let what = |sign: f64| match kind {
                        LimitKind::Size => What::InputSize { input, sign, limit: bound / unit },
                        LimitKind::Norm => What::InputNorm { forces, limit: bound / unit },
                        LimitKind::Rate => {
                            let limit = bound * problem.duration * model.dynamics.grid.step(stage) / unit;
                            What::InputRate { input, sign, limit }
                        }
                        LimitKind::WheelMomentum => {
                            What::Wheel { wheel: index, sign, limit: bound / momentum }
                        }
                    };
                    self.rows.extend(signs.iter().map(|sign| LimitRow { group, stage, what: what(*sign) }));
                }
            }
        }
    }
}
