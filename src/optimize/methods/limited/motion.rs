//! The motion along arcs, in continuous time.
//!
//! ```text
//! q̇ = ½ q ∘ (0, Ω − Rᵀn) ,   J Ω̇ = (JΩ + Σ a_i h_i) × Ω + M(x, R) + A v ,   ḣ_i = −u_i v_i ,   ḃ = Σ c_j |v_j|
//! ẋ = γ ,   m γ̇ = f(x, R) + F v
//! ```
//!
//! with the inputs `v` as parts of their limits `u`, what they have burnt `b`, a reference frame that turns at `n`, and what wheels store.
//! Inputs that hold limits are those for which the last derivative of these vanishes, `N E_f v_f = −N ẏ_0 − r`, where `E` says what inputs do
//! to the derivative `ẏ` of the state. The flow is that of [`EIGHTH`].
//!
//! An input `w`, as a part of its limit, that changes at a limited rate `ρ` is part of the state, and what is chosen is how fast it changes:
//!
//! ```text
//! ẇ = (ρ/u) v ,   |w| ≤ 1
//! ```
//!
//! An arc on which it holds its limit has `v = 0`, and what it begins with is free. With such inputs, limits of rates and of momenta would be
//! of second order and cones of third: none of these are taken together.

use super::constraint::Limit;
use super::state::{CHANGES, Change, DISTURBANCE, MOST_RAMPS, MOST_WHEELS, Numbers, PLAIN, State, at};
use crate::maneuver::duration::Duration;
use crate::maneuver::problem::{self as planned, Motion, Problem};
use crate::mechanics::actuators::{ActuatorSet, AxisFrame, LimitKind};
use crate::mechanics::environment::{Environment, Pose};
use crate::numerics::tableau::EIGHTH;
use crate::{Matrix3, Vector3};
use nalgebra::SMatrix;
use std::cell::Cell;
use std::sync::Arc;

/// Longest step, in the unit of time and in turns by the present rate \[rad\]: halves of it lead to the same end within 1e-13
/// (`cargo test --lib -- limited::tests::steps`).
const LONGEST: f64 = 0.08;

/// Most inputs that hold limits of the motion at once.
const MOST_TIED: usize = 3;

/// Most inputs that hold anything: limits of the motion, or each its own.
const MOST_FREE: usize = MOST_RAMPS;

/// What an input does on an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// This part of its limit, one that the maximum principle may ask for.
    At(f64),
    /// This part of its limit for the time being: of a singular input, or of one that has more than it needs.
    Loose(f64),
    /// What holds the limits of the arc.
    Free,
}

impl Level {
    /// Its part of the limit, where it has one.
    pub fn part(self) -> Option<f64> {
        match self {
            Self::At(level) | Self::Loose(level) => Some(level),
            Self::Free => None,
        }
    }
}

/// What the inputs do on an arc, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Law {
    pub levels: Vec<Level>,
    /// Limits of the state that it holds, as many as inputs are free.
    pub holds: Vec<usize>,
}

/// How fast an input changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ramp {
    /// Its number among those that change at limited rates.
    pub number: usize,
    /// Limit of its rate [N·m/s or N/s], and the part of its limit that it changes by in a unit of time at that rate.
    pub limit: f64,
    pub rate: f64,
}

/// An input, by what it gives at its limit.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    /// The limit itself [N·m or N].
    pub size: f64,
    /// Where its rate is limited, of which the levels of an arc are parts then.
    pub ramp: Option<Ramp>,
    /// `J⁻¹` times the torque, where torques are fixed to the body; else the torque.
    torque: Vector3,
    /// What a force does to the velocity, in the axes in which forces are fixed.
    force: Vector3,
    /// The wheel behind it, with what that takes up.
    wheel: Option<(usize, f64)>,
    /// What it costs.
    pub price: f64,
    /// Its least level: 0 of a thruster, or else −1.
    pub lowest: f64,
}

/// A law with what its inputs give, so that a step of the flow asks for no memory.
pub(crate) struct Driven<'a> {
    maneuver: &'a Maneuver,
    /// What is given whatever the state, as [`Input`] says.
    torque: Vector3,
    force: Vector3,
    wheels: [f64; MOST_WHEELS],
    ramps: [f64; MOST_RAMPS],
    /// What inputs at a level burn.
    burning: f64,
    free: [Option<&'a Input>; MOST_FREE],
    held: [Option<&'a Limit>; MOST_FREE],
}

/// Units of a maneuver: of time, torque, length, and what a unit of time costs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Units {
    pub time: f64,
    torque: f64,
    length: f64,
    rate: f64,
}

impl Units {
    /// Unit of the cost.
    pub fn cost(&self) -> f64 {
        self.rate * self.time
    }

    /// Unit of momentum [N·m·s].
    pub fn momentum(&self) -> f64 {
        self.torque * self.time
    }

    fn state(&self, of: &planned::State, moves: bool, stored: &[f64], time: f64) -> State {
        let momentum = self.momentum();
        let state = State::of(&of.attitude, &(of.angular_velocity * self.time));
        let state = state.storing(stored.iter().map(|stored| stored / momentum)).at_time(time / self.time);
        if !moves {
            return state;
        }
        state.moving(&(of.position / self.length), &(of.velocity * (self.time / self.length)))
    }
}

/// A scaled maneuver.
pub(crate) struct Maneuver {
    j: Matrix3,
    j_inverse: Matrix3,
    pub inputs: Vec<Input>,
    torque_frame: AxisFrame,
    force_frame: AxisFrame,
    wheel_axes: Vec<Vector3>,
    /// What acts on the body, with the mass that it moves.
    field: Option<(Arc<dyn Environment>, f64)>,
    /// Of the reference frame.
    frame_rate: Vector3,
    moves: bool,
    timed: bool,
    /// What a unit of time costs.
    pub time_price: f64,
    pub given_duration: Option<f64>,
    pub limits: Vec<Limit>,
    pub start: State,
    pub end: State,
    pub units: Units,
    /// Steps of the flow taken so far, and the most that a search for arcs may take.
    steps: Cell<usize>,
    pub most_steps: usize,
}

impl Maneuver {
    /// Returns whether a search for arcs has taken all the steps of the flow that it may take.
    pub fn is_spent(&self) -> bool {
        self.steps.get() >= self.most_steps
    }

    /// That of a problem; `None` where arcs of this kind do not describe it.
    pub fn of(problem: &Problem) -> Option<Self> {
        let (torques, forces) = (&problem.actuation.torque, problem.actuation.force.as_ref());
        let moves = problem.motion == Motion::RigidBody;
        let forces = forces.filter(|_| moves);
        let within_limits_of_each = |set: &ActuatorSet| {
            let limits = set.limits();
            let ramps = limits.rate.is_some();
            limits.size.is_some() && limits.norm.is_none() && !(ramps && problem.objective.fuel().is_some())
        };
        // What limits of the torques alone shape has arcs of its own (`switching`).
        let shaped = !problem.is_free_turn() || problem.has_shaping_limits();
        let frame_rate = problem.environment.frame_rate();
        let wheels = problem.actuation.wheels.as_ref();
        let taken = problem.objective.switches()
            && shaped
            && !problem.ends_in_any_attitude()
            && within_limits_of_each(torques)
            && forces.is_none_or(within_limits_of_each)
            && problem.shortest_pulse().is_none()
            && !(moves && frame_rate != Vector3::zeros())
            && wheels.is_none_or(|wheels| wheels.momentum.len() <= MOST_WHEELS);
        if !taken {
            return None;
        }
        let units = units(problem)?;
        let inertia = units.torque * units.time * units.time;
        let j = problem.body.inertia.j() / inertia;
        let j_inverse = j.try_inverse()?;
        let mass = problem.body.mass.unwrap_or(f64::NAN);
        let inputs = inputs(problem, &units, &j_inverse, mass);
        let mut limits = Limit::all(problem, units.time, units.torque)?;
        let of_ramp = |(index, input): (usize, &Input)| {
            let of_force = forces.is_some_and(|set| index < set.count());
            let name = problem.actuation.limit_name(LimitKind::Size, of_force);
            Some(Limit::of_ramp(name, input.ramp?.number))
        };
        let ramps: Vec<Limit> = inputs.iter().enumerate().filter_map(of_ramp).flatten().collect();
        if !ramps.is_empty() && (!limits.is_empty() || ramps.len() > 2 * MOST_RAMPS) {
            return None;
        }
        limits.extend(ramps);
        let stored = wheels.map_or(&[][..], |wheels| &wheels.momentum);
        let acts = !problem.environment.is_free();
        Some(Self {
            inputs,
            torque_frame: torques.frame(),
            force_frame: forces.map_or(AxisFrame::Reference, ActuatorSet::frame),
            wheel_axes: wheels.map_or(Vec::new(), |_| torques.axes().to_vec()),
            field: acts.then(|| (Arc::clone(&problem.environment), mass)),
            frame_rate: frame_rate * units.time,
            moves,
            timed: limits.iter().any(Limit::moves),
            time_price: problem.objective.time_price() / units.rate,
            given_duration: match problem.duration {
                Duration::Given(duration) => Some(duration / units.time),
                Duration::Sought { .. } | Duration::Found { .. } => None,
            },
            limits,
            start: units.state(&problem.start, moves, stored, 0.0),
            end: units.state(&problem.end, moves, &[], 0.0),
            j,
            j_inverse,
            units,
            steps: Cell::new(0),
            most_steps: usize::MAX,
        })
    }

    /// The inputs that change at limited rates, in their order.
    pub fn ramps(&self) -> impl Iterator<Item = (&Input, Ramp)> {
        self.inputs.iter().filter_map(|input| Some((input, input.ramp?)))
    }

    /// A state of a plan, with what its wheels store, at a time \[s\].
    pub fn scaled(&self, state: &planned::State, stored: &[f64], time: f64) -> State {
        self.units.state(state, self.moves, stored, time)
    }

    /// How many of the first parts of a change are given at the end.
    pub fn ends(&self) -> usize {
        if self.moves { at::TIME } else { at::POSITION }
    }

    /// How many of the first numbers of a state it has.
    fn numbers(&self) -> usize {
        1 + self.parts().last().map_or(0, |part| part + PLAIN[0] - PLAIN[1])
    }

    /// The parts of a change that it has.
    pub fn parts(&self) -> impl Iterator<Item = usize> {
        let time = if self.timed { at::TIME..at::WHEELS } else { 0..0 };
        let wheels = at::WHEELS..at::WHEELS + self.wheel_axes.len();
        (0..self.ends()).chain(time).chain(wheels).chain(at::RAMPS..at::RAMPS + self.ramps().count())
    }

    /// What an input at its limit does to the derivative of a state.
    pub fn effect(&self, input: &Input, state: &State) -> Change {
        let mut effect = Change::zeros();
        if let Some(ramp) = input.ramp {
            effect[at::RAMPS + ramp.number] = ramp.rate;
            return effect;
        }
        effect.fixed_rows_mut::<3>(at::RATE).copy_from(&self.answer(&input.torque, state));
        if self.moves {
            effect.fixed_rows_mut::<3>(at::VELOCITY).copy_from(&self.push(&input.force, state));
        }
        if let Some((wheel, size)) = input.wheel {
            effect[at::WHEELS + wheel] = -size;
        }
        effect
    }

    /// `J⁻¹` times a torque as [`Input`] has it.
    fn answer(&self, torque: &Vector3, state: &State) -> Vector3 {
        match self.torque_frame {
            AxisFrame::Body => *torque,
            AxisFrame::Reference => self.j_inverse * state.in_body_axes(torque),
        }
    }

    /// What a force as [`Input`] has it does to the velocity.
    fn push(&self, force: &Vector3, state: &State) -> Vector3 {
        match self.force_frame {
            AxisFrame::Body => state.in_reference_axes(force),
            AxisFrame::Reference => *force,
        }
    }

    /// A law, ready to be followed; `None` where too many or too few inputs are free.
    pub fn driven<'a>(&'a self, law: &'a Law) -> Option<Driven<'a>> {
        let mut driven = Driven {
            maneuver: self,
            torque: Vector3::zeros(),
            force: Vector3::zeros(),
            wheels: [0.0; MOST_WHEELS],
            ramps: [0.0; MOST_RAMPS],
            burning: 0.0,
            free: [None; MOST_FREE],
            held: [None; MOST_FREE],
        };
        let mut free = 0;
        for (level, input) in law.levels.iter().zip(&self.inputs) {
            match (level.part(), input.ramp) {
                (Some(level), Some(ramp)) => driven.ramps[ramp.number] = level * ramp.rate,
                (Some(level), None) => {
                    driven.torque += level * input.torque;
                    driven.force += level * input.force;
                    driven.burning += input.price * level.abs();
                    if let Some((wheel, size)) = input.wheel {
                        driven.wheels[wheel] -= level * size;
                    }
                }
                (None, _) => {
                    *driven.free.get_mut(free)? = Some(input);
                    free += 1;
                }
            }
        }
        for (held, limit) in driven.held.iter_mut().zip(&law.holds) {
            *held = Some(&self.limits[*limit]);
        }
        let most = if self.ramps().next().is_some() { MOST_FREE } else { MOST_TIED };
        (free == law.holds.len() && free <= most).then_some(driven)
    }
}

/// The units of a maneuver; `None` where a number is out of range.
fn units(problem: &Problem) -> Option<Units> {
    let torques = &problem.actuation.torque;
    let sizes = torques.limits().size.as_ref()?;
    let squared: f64 =
        torques.axes().iter().zip(sizes).map(|(axis, size)| (*size * axis).norm_squared()).sum();
    let torque = (squared / 3.0).sqrt();
    let time = (problem.body.inertia.j().determinant().cbrt() / torque).sqrt();
    let forces = problem.actuation.force.as_ref().zip(problem.body.mass);
    let pushed = forces.and_then(|(set, mass)| {
        let sizes = set.limits().size.as_ref()?;
        let push = set.axes().iter().zip(sizes).map(|(axis, size)| (*size * axis).norm());
        Some(push.fold(0.0, f64::max) / mass * time * time)
    });
    let way = (problem.end.position - problem.start.position).norm();
    let length = pushed.into_iter().chain([way, 1.0]).find(|length| *length > 0.0)?;
    let fuel = problem.objective.fuel();
    let of_torques =
        sizes.iter().enumerate().map(|(input, size)| fuel.map_or(0.0, |fuel| fuel.price(input)) * size);
    let of_forces =
        problem.actuation.force.iter().flat_map(|set| set.limits().size.iter().flatten()).enumerate();
    let of_forces = of_forces.map(|(input, size)| fuel.map_or(0.0, |fuel| fuel.force_price(input)) * size);
    let dearest = of_torques.chain(of_forces).fold(0.0, f64::max);
    let rate = if dearest > 0.0 { dearest } else { 1.0 };
    let usable = [time, torque, length, rate].iter().all(|unit| unit.is_finite() && *unit > 0.0);
    usable.then_some(Units { time, torque, length, rate })
}

/// The inputs, in their order.
fn inputs(problem: &Problem, units: &Units, j_inverse: &Matrix3, mass: f64) -> Vec<Input> {
    let actuation = &problem.actuation;
    let torques = &actuation.torque;
    let force_unit = mass * units.length / (units.time * units.time);
    let fuel = problem.objective.fuel();
    let mut ramps = 0..;
    (0..actuation.count())
        .map(|index| {
            let of_torque = index.checked_sub(actuation.first_torque());
            let forces = actuation.force.as_ref().filter(|set| index < set.count());
            let size_of = |set: &ActuatorSet, input: usize| {
                set.limits().size.as_ref().map_or(f64::NAN, |size| size[input])
            };
            let size = match (forces, of_torque) {
                (Some(set), _) => size_of(set, index),
                (None, Some(input)) => size_of(torques, input),
                (None, None) => f64::NAN,
            };
            let torque = of_torque.map_or_else(Vector3::zeros, |input| {
                let torque = torques.axes()[input] * (size / units.torque);
                if torques.frame() == AxisFrame::Body { j_inverse * torque } else { torque }
            });
            let price = fuel.map_or(0.0, |fuel| match (forces, of_torque) {
                (Some(_), _) => fuel.force_price(index),
                (None, input) => fuel.price(input.unwrap_or(0)),
            });
            let one_sided = forces.unwrap_or(torques).limits().one_sided;
            let wheel = of_torque.filter(|_| actuation.wheels.is_some());
            let rates = forces.unwrap_or(torques).limits().rate.as_ref();
            let of_set = if forces.is_some() { Some(index) } else { of_torque };
            let limit = rates.zip(of_set).map(|(rates, input)| rates[input]);
            let ramp = limit.and_then(|limit| {
                Some(Ramp { number: ramps.next()?, limit, rate: limit * units.time / size })
            });
            Input {
                size,
                ramp,
                lowest: if one_sided { 0.0 } else { -1.0 },
                torque,
                force: forces.map_or_else(Vector3::zeros, |set| set.axes()[index] * (size / force_unit)),
                wheel: wheel.map(|wheel| (wheel, size / units.torque)),
                price: price * size / units.rate,
            }
        })
        .collect()
}

impl Driven<'_> {
    /// The derivative of a state without the free inputs.
    fn unheld(&self, state: &State) -> Change {
        let maneuver = self.maneuver;
        let rate = state.rate();
        let mut total = maneuver.j * rate;
        for (wheel, axis) in maneuver.wheel_axes.iter().enumerate() {
            total += state.stored(wheel) * axis;
        }
        let mut moment = total.cross(&rate);
        let mut change = Change::zeros();
        let (mut torque, mut force, mut wheels) = (self.torque, self.force, self.wheels);
        for (input, ramp) in maneuver.ramps() {
            let given = state.given(ramp.number);
            torque += given * input.torque;
            force += given * input.force;
            if let Some((wheel, size)) = input.wheel {
                wheels[wheel] = -given * size;
            }
        }
        let mut push = if maneuver.moves { maneuver.push(&force, state) } else { Vector3::zeros() };
        if let Some((field, mass)) = &maneuver.field {
            let Units { time, torque, length, .. } = maneuver.units;
            let pose = Pose { position: length * state.position(), attitude: state.attitude() };
            let wrench = field.wrench(&pose);
            moment += wrench.moment / torque;
            push += wrench.force * (time * time / (mass * length));
        }
        let turning = rate - state.in_body_axes(&maneuver.frame_rate);
        change.fixed_rows_mut::<3>(0).copy_from(&turning);
        let answer = maneuver.j_inverse * moment + maneuver.answer(&torque, state);
        change.fixed_rows_mut::<3>(at::RATE).copy_from(&answer);
        if maneuver.moves {
            change.fixed_rows_mut::<3>(at::POSITION).copy_from(&state.velocity());
            change.fixed_rows_mut::<3>(at::VELOCITY).copy_from(&push);
        }
        if maneuver.timed {
            change[at::TIME] = 1.0;
        }
        change.fixed_rows_mut::<MOST_WHEELS>(at::WHEELS).copy_from_slice(&wheels);
        change.fixed_rows_mut::<MOST_RAMPS>(at::RAMPS).copy_from_slice(&self.ramps);
        change
    }

    /// The free inputs, in their order, that make up for a change of the derivative and for so much of `r`; NaN where they cannot.
    fn making_up_for(&self, state: &State, change: &Change, rests: f64) -> [f64; MOST_FREE] {
        // What holds a limit of its own stays as it is, whatever changes.
        if self.free[0].is_none_or(|input| input.ramp.is_some()) {
            return [0.0; MOST_FREE];
        }
        let mut matrix = Matrix3::identity();
        let mut wanted = Vector3::zeros();
        for (row, limit) in self.held.iter().flatten().enumerate() {
            let (normal, rest) = limit.held(state);
            for (column, input) in self.free.iter().flatten().enumerate() {
                matrix[(row, column)] = normal.dot(&self.maneuver.effect(input, state));
            }
            wanted[row] = -(normal.dot(change) + rests * rest);
        }
        let mut levels = [f64::NAN; MOST_FREE];
        if let Some(inverse) = matrix.try_inverse() {
            levels[..MOST_TIED].copy_from_slice((inverse * wanted).as_slice());
        }
        levels
    }

    /// The free inputs, in their order; NaN where they cannot hold what they should.
    pub fn free_levels(&self, state: &State) -> [f64; MOST_FREE] {
        self.making_up_for(state, &self.unheld(state), 1.0)
    }

    /// How the free inputs answer to a change of the derivative, so that what is held stays held.
    pub fn compensation(&self, state: &State, change: &Change) -> [f64; MOST_FREE] {
        self.making_up_for(state, change, 0.0)
    }

    /// What burns, and the derivative of a state: what one more unit of time does to it.
    pub fn rates(&self, state: &State) -> (f64, Change) {
        let mut change = self.unheld(state);
        let mut burning = self.burning;
        let levels = self.making_up_for(state, &change, 1.0);
        for (input, level) in self.free.iter().flatten().zip(levels) {
            change += level * self.maneuver.effect(input, state);
            burning += input.price * level.abs();
        }
        (burning, change)
    }

    /// One step of the flow, in place.
    fn step(&self, numbers: &mut Numbers, length: f64) {
        let used = self.maneuver.numbers();
        let mut slopes = [Numbers::zeros(); EIGHTH.b.len()];
        let add = |to: &mut Numbers, weights: &[f64], slopes: &[Numbers]| {
            for (weight, slope) in weights.iter().zip(slopes).filter(|(weight, _)| **weight != 0.0) {
                let weight = length * weight;
                for (number, slope) in to.as_mut_slice()[..used].iter_mut().zip(slope.as_slice()) {
                    *number += weight * slope;
                }
            }
        };
        for stage in 0..slopes.len() {
            let mut at = State(*numbers);
            add(&mut at.0, &EIGHTH.a[stage][..stage], &slopes);
            let (burning, change) = self.rates(&at);
            at.along(&change, burning, used, &mut slopes[stage]);
        }
        add(numbers, &EIGHTH.b, &slopes);
    }

    /// How many steps an arc takes from a state.
    pub fn steps(&self, from: &State, length: f64) -> usize {
        (length * (1.0 + from.rate().norm()) / LONGEST).ceil().clamp(1.0, 1000.0) as usize
    }

    /// Where a state comes to in `length`, in so many steps.
    pub fn flow(&self, from: &State, length: f64, steps: usize) -> State {
        self.maneuver.steps.set(self.maneuver.steps.get().saturating_add(steps));
        let mut numbers = from.0;
        for _ in 0..steps {
            self.step(&mut numbers, length / steps as f64);
        }
        let size = numbers.fixed_rows::<4>(0).norm();
        numbers.fixed_rows_mut::<4>(0).scale_mut(1.0 / size);
        State(numbers)
    }

    /// The same with the derivative of where it comes to, and of what is burnt in the last row, by the state it comes from.
    pub fn linearised(
        &self,
        from: &State,
        length: f64,
        steps: usize,
    ) -> (State, SMatrix<f64, { CHANGES + 1 }, CHANGES>) {
        let to = self.flow(from, length, steps);
        let mut slope = SMatrix::<f64, { CHANGES + 1 }, CHANGES>::zeros();
        for column in self.maneuver.parts() {
            let [ahead, behind] = [DISTURBANCE, -DISTURBANCE]
                .map(|size| self.flow(&from.plus(&Change::ith(column, size)), length, steps));
            let change = (ahead.minus(&to) - behind.minus(&to)) / (2.0 * DISTURBANCE);
            slope.fixed_view_mut::<CHANGES, 1>(0, column).copy_from(&change);
            slope[(CHANGES, column)] = (ahead.burnt() - behind.burnt()) / (2.0 * DISTURBANCE);
        }
        (to, slope)
    }
}
