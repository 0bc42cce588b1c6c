//! The true motion under the inputs of a plan, which are held over each step. The planner lands its
//! plans on this motion.
//!
//! ```text
//! Ȧ = A S(Ω) ,   Π̇ = (Π + μ) × Ω + M(R) + τ ,   μ̇ = −τ (wheels) ,   ẋ = γ/m ,   γ̇ = f(x, R) + f_u ,   Ω = J⁻¹Π
//! R(t) = exp(−t S(n)) A(t)    in a reference frame that turns at n
//! ```
//!
//! with the force and torque that the plan holds over a step. For Lie–Verlet they are the mean of
//! the rows at both ends of the step, for Lie–Euler the row at its end. For switching inputs they
//! are the row of the step.
//!
//! The flow is an explicit Runge–Kutta method on the Lie group (Munthe-Kaas 1999). On a part of a
//! step `A = A_0 exp S(u)` with `u̇ = J_r⁻¹(u) Ω`, and `(u, Π, x, γ)` are integrated as vectors
//! (`numerics/tableau`). The witnesses (`verify::continuous`, `verify::symplectic`) use other
//! flows, and share no code with this module.
//!
//! In a part the body turns and nutates by at most [`Flight::PART`]. Over a turn of a few radians
//! this leaves errors of some 1e-11, as a test checks. Nutation counts because the momentum of
//! wheels makes even a body nutate that hardly turns. Force fields may change faster than the body
//! turns; in a field, parts are halved until two runs agree ([`Flight::settle`]).

mod limits;

pub(crate) use limits::Excess;

use crate::maneuver::problem::{Motion, Problem, State};
use crate::maneuver::solution::Trajectory;
use crate::mechanics::actuators::{ActuatorSet, AxisFrame};
use crate::mechanics::environment::Pose;
use crate::numerics::tableau::{FOURTH, SIXTH, Tableau};
use crate::{Matrix3, Vector3, lie};

/// The outputs of the actuators over a step [N, N·m], each in the axes in which its actuator set is
/// fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Held {
    pub force: Vector3,
    pub torque: Vector3,
    /// A torque that no actuator produces, body axes [N·m]. The wheels do not store its reaction.
    pub outside: Vector3,
}

/// The state of the body in flight, SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body {
    /// Attitude, from body to inertial.
    attitude: Matrix3,
    momentum: Vector3,
    /// The momentum in the wheels, body axes.
    stored: Vector3,
    position: Vector3,
    linear_momentum: Vector3,
}

/// The derivative, or a change, of `(u, Π, x, γ)`.
#[derive(Clone, Copy, Debug)]
struct Change {
    turn: Vector3,
    momentum: Vector3,
    position: Vector3,
    linear_momentum: Vector3,
}

/// The true (continuous-time) motion of a maneuver.
#[derive(Clone, Debug)]
pub(crate) struct Flight<'a> {
    problem: &'a Problem,
    j_inverse: Matrix3,
    per_mass: f64,
    moves: bool,
    /// Whether the force or the moment depends on attitude or position.
    posed: bool,
    has_wheels: bool,
    torque_frame: AxisFrame,
    force_frame: AxisFrame,
    frame_rate: Option<Vector3>,
    start: Body,
    /// Smallest number of parts into which every step is divided.
    parts: usize,
}

impl<'a> Flight<'a> {
    /// Largest angle of turn plus nutation in a part of a step \[rad\].
    const PART: f64 = 0.04;

    /// Angle of turn plus nutation in a step \[rad\] below which the fourth-order method suffices.
    /// Its error is of fifth power in this angle, some 1e-13 per step.
    const SLOW: f64 = 8e-3;

    /// Scaled difference below which two computed ends count as equal.
    const SETTLED: f64 = 1e-10;

    /// Largest number of parts into which a step is divided.
    const MOST_PARTS: usize = 256;

    /// Builds the motion that starts at the start of `problem`.
    pub fn new(problem: &'a Problem) -> Self {
        let moves = problem.motion == Motion::RigidBody;
        let torque_frame = problem.actuation.torque.frame();
        let force_frame = problem.actuation.force.as_ref().map_or(AxisFrame::Reference, ActuatorSet::frame);
        let rate = problem.environment.frame_rate();
        let State { position, velocity, attitude, angular_velocity } = problem.start;
        let posed = !problem.environment.is_free()
            || torque_frame == AxisFrame::Reference
            || moves && force_frame == AxisFrame::Body;
        Self {
            problem,
            j_inverse: *problem.body.inertia.j_inverse(),
            per_mass: problem.body.mass.map_or(0.0, f64::recip),
            moves,
            posed,
            has_wheels: problem.actuation.wheels.is_some(),
            torque_frame,
            force_frame,
            frame_rate: (rate != Vector3::zeros()).then_some(rate),
            start: Body {
                attitude,
                momentum: problem.body.inertia.j() * angular_velocity,
                stored: problem.actuation.stored_momentum(),
                position,
                linear_momentum: problem.body.mass.unwrap_or(0.0) * velocity,
            },
            parts: 1,
        }
    }

    /// Returns the outputs that a recorded plan holds over each step, each with the length of the
    /// step \[s\].
    pub fn of_plan(problem: &Problem, plan: &Trajectory) -> Vec<(Held, f64)> {
        let output = |row: usize| {
            let (force, torque) = problem.actuation.split(plan.inputs(row));
            let set = problem.actuation.force.as_ref();
            Held {
                force: set.map_or_else(Vector3::zeros, |set| set.output(force)),
                torque: problem.actuation.torque.output(torque),
                outside: Vector3::zeros(),
            }
        };
        let steps = plan.time.len().saturating_sub(1);
        let equal = plan.time.last().copied().unwrap_or(f64::NAN) / steps as f64;
        let switches = problem.switches();
        (0..steps)
            .map(|k| {
                if switches {
                    (output(k), plan.time[k + 1] - plan.time[k])
                } else {
                    let (from, to) = (output(k), output(k + 1 - problem.scheme.first_input()));
                    (from.mean(&to), equal)
                }
            })
            .collect()
    }

    /// Chooses the number of parts per step that the force field requires. `steps` should be
    /// similar to the steps that will be flown.
    pub fn settle(&mut self, steps: &[(Held, f64)]) {
        if !self.posed {
            return;
        }
        let mut before = self.fly(steps, None);
        while self.parts < Self::MOST_PARTS {
            let finer = Flight { parts: 2 * self.parts, ..self.clone() };
            let after = finer.fly(steps, None);
            let apart = before.zip(after).map(|(a, b)| self.apart(&a, &b, steps));
            if apart.is_some_and(|apart| apart <= Self::SETTLED) {
                return;
            }
            (self.parts, before) = (finer.parts, after);
        }
    }

    /// Returns the scaled difference between two terminal states.
    fn apart(&self, a: &State, b: &State, steps: &[(Held, f64)]) -> f64 {
        let duration: f64 = steps.iter().map(|(_, step)| step).sum();
        let turn = lie::minus(&a.attitude, &b.attitude).norm();
        let rate = (a.angular_velocity - b.angular_velocity).norm() * duration;
        let size = b.position.norm().max(b.velocity.norm() * duration).max(f64::MIN_POSITIVE);
        let way = (a.position - b.position).norm() + (a.velocity - b.velocity).norm() * duration;
        turn.max(rate).max(if self.moves { way / size } else { 0.0 })
    }

    /// Returns the state of the body after `steps`; `None` if a number is not finite. `excess`
    /// records the violations of constraints by this motion.
    pub fn fly(&self, steps: &[(Held, f64)], excess: Option<&mut Excess>) -> Option<State> {
        self.pass(steps, excess, |_, _| ())
    }

    /// Returns a plan whose nodes hold the true motion instead of the discrete one, with torques
    /// and forces in the axes of the true motion; `None` if the motion cannot be propagated.
    pub fn recorded(problem: &Problem, plan: &Trajectory) -> Option<Trajectory> {
        let steps = Self::of_plan(problem, plan);
        let mut flight = Flight::new(problem);
        flight.settle(&steps);
        let mut states = Vec::with_capacity(steps.len());
        flight.pass(&steps, None, |time, body| states.push(flight.state(time, body)))?;
        let mut flown = plan.clone();
        // The first node keeps the start of the maneuver.
        for (node, state) in (1..).zip(states) {
            let quaternion = lie::quaternion_from_rotation(&state.attitude);
            let same_sign =
                quaternion.iter().zip(&plan.quaternion[node]).map(|(a, b)| a * b).sum::<f64>() >= 0.0;
            flown.quaternion[node] = if same_sign { quaternion } else { quaternion.map(|part| -part) };
            flown.angular_velocity[node] = state.angular_velocity;
            if flight.moves {
                (flown.position[node], flown.velocity[node]) = (state.position, state.velocity);
            }
        }
        // Row k of switching inputs belongs to the step that begins at node k. Lie–Euler has no row
        // at the first node.
        let first = if problem.switches() { 0 } else { plan.time.len() - plan.torque.len() };
        for row in 0..plan.torque.len() {
            let node = row + first;
            let attitude = lie::rotation_from_quaternion(&flown.quaternion[node]);
            let (force, torque) = problem.actuation.split(plan.inputs(row));
            let set = &problem.actuation.torque;
            flown.torque[row] = flight.torque_frame.to_body(&attitude, &set.output(torque));
            if let (Some(set), true) = (&problem.actuation.force, flight.moves) {
                flown.force[row] = flight.force_frame.to_reference(&attitude, &set.output(force));
            }
        }
        Some(flown)
    }

    /// Propagates as [`Flight::fly`] does, and calls `visit` with the time and the state of the
    /// body after each step.
    fn pass(
        &self,
        steps: &[(Held, f64)],
        mut excess: Option<&mut Excess>,
        mut visit: impl FnMut(f64, &Body),
    ) -> Option<State> {
        let mut body = self.start;
        let mut time = 0.0;
        if let Some(excess) = &mut excess {
            excess.rate(&self.problem.start.angular_velocity);
        }
        for (held, step) in steps {
            let least = if excess.is_some() { Excess::PIECES } else { 1 };
            self.carry(&mut body, time, held, *step, least, excess.as_deref_mut())?;
            time += step;
            visit(time, &body);
        }
        let state = self.state(time, &body);
        let vectors = [state.position, state.velocity, state.angular_velocity];
        let finite = vectors.iter().flatten().chain(&state.attitude).all(|value| value.is_finite());
        finite.then_some(state)
    }

    /// Propagates a body over a step that begins at `time`, in at least `least` parts. Returns
    /// `None` if the body turns too fast for the largest number of parts.
    pub fn carry(
        &self,
        body: &mut Body,
        time: f64,
        held: &Held,
        step: f64,
        least: usize,
        mut excess: Option<&mut Excess>,
    ) -> Option<()> {
        let rate = |body: &Body| self.j_inverse * body.momentum;
        let mut turn = step * (rate(body).norm() + 0.5 * step * (self.j_inverse * held.torque).norm());
        if self.has_wheels {
            let nutation = |stored: &Vector3| self.problem.body.inertia.nutation(stored);
            turn += step * (nutation(&body.stored) + 0.5 * step * nutation(&held.torque));
        }
        let needed = (turn / Self::PART).ceil();
        // NaN counts as too many parts.
        if needed.is_nan() || needed >= Self::MOST_PARTS as f64 {
            return None;
        }
        let parts = (needed as usize).max(self.parts).max(least);
        let part = step / parts as f64;
        for index in 0..parts {
            let before = body.attitude;
            let now = time + index as f64 * part;
            if self.posed {
                self.advance::<true, 7>(&SIXTH, now, part, held, body);
            } else if turn < Self::SLOW {
                self.advance::<false, 4>(&FOURTH, now, part, held, body);
            } else {
                self.advance::<false, 7>(&SIXTH, now, part, held, body);
            }
            if let Some(excess) = &mut excess {
                excess.piece(now, part, &before, &body.attitude);
                excess.rate(&rate(body));
            }
        }
        Some(())
    }

    /// Returns the state of the body at the start.
    pub fn start(&self) -> Body {
        self.start
    }

    /// Returns the momentum stored in the wheels, body axes [N·m·s].
    pub fn stored(body: &Body) -> Vector3 {
        body.stored
    }

    /// Returns this motion with the number of parts per step that another flight has chosen.
    pub fn refined_as(&self, other: &Self) -> Self {
        Self { parts: other.parts, ..self.clone() }
    }

    /// Returns the state of the body at `time` as a state of the maneuver, in its reference frame.
    pub fn state(&self, time: f64, body: &Body) -> State {
        let attitude = self.frame(time).map_or(body.attitude, |frame| frame * body.attitude);
        State {
            position: body.position,
            velocity: body.linear_momentum * self.per_mass,
            attitude: lie::project_to_rotation(&attitude),
            angular_velocity: self.j_inverse * body.momentum,
        }
    }

    /// Returns the rotation from inertial to reference at `time`; `None` if the frame does not
    /// rotate.
    fn frame(&self, time: f64) -> Option<Matrix3> {
        self.frame_rate.map(|rate| lie::exp(&(-time * rate)))
    }

    /// Advances the body over one part of a step by an explicit Runge–Kutta method.
    #[inline(always)]
    fn advance<const POSED: bool, const S: usize>(
        &self,
        tableau: &Tableau<S>,
        time: f64,
        h: f64,
        held: &Held,
        body: &mut Body,
    ) {
        let zero = Vector3::zeros();
        let mut slopes = [Change { turn: zero, momentum: zero, position: zero, linear_momentum: zero }; S];
        for stage in 0..S {
            let at = weighted::<POSED, S>(&tableau.a[stage], stage, h, &slopes);
            slopes[stage] = self.slope::<POSED>(time, tableau.c[stage] * h, held, body, &at);
        }
        let change = weighted::<POSED, S>(&tableau.b, S, h, &slopes);
        body.attitude += body.attitude * lie::exp_minus_identity(&change.turn);
        body.momentum += change.momentum;
        if self.has_wheels {
            body.stored -= h * held.torque;
        }
        if POSED {
            body.position += change.position;
            body.linear_momentum += change.linear_momentum;
        } else if self.moves {
            body.position += (h * self.per_mass) * (body.linear_momentum + (0.5 * h) * held.force);
            body.linear_momentum += h * held.force;
        }
    }

    /// Evaluates the equations of motion at the time `since` after the start of a part, where the
    /// body has changed by `change` since that start.
    #[inline(always)]
    fn slope<const POSED: bool>(
        &self,
        time: f64,
        since: f64,
        held: &Held,
        body: &Body,
        change: &Change,
    ) -> Change {
        let momentum = body.momentum + change.momentum;
        let rate = self.j_inverse * momentum;
        let total = if self.has_wheels { momentum + body.stored - since * held.torque } else { momentum };
        let mut slope = Change {
            turn: of_rate(&change.turn, &rate),
            momentum: total.cross(&rate),
            position: Vector3::zeros(),
            linear_momentum: Vector3::zeros(),
        };
        if !POSED {
            slope.momentum += held.torque + held.outside;
            return slope;
        }
        let mut attitude = body.attitude * lie::exp(&change.turn);
        if let Some(frame) = self.frame(time + since) {
            attitude = frame * attitude;
        }
        slope.momentum += self.torque_frame.to_body(&attitude, &held.torque) + held.outside;
        let position = body.position + change.position;
        if !self.problem.environment.is_free() {
            let field = self.problem.environment.wrench(&Pose { position, attitude });
            slope.momentum += field.moment;
            slope.linear_momentum = field.force;
        }
        if self.moves {
            slope.position = self.per_mass * (body.linear_momentum + change.linear_momentum);
            slope.linear_momentum += self.force_frame.to_reference(&attitude, &held.force);
        } else {
            slope.linear_momentum = Vector3::zeros();
        }
        slope
    }
}

impl Held {
    /// Returns the mean of two outputs.
    pub fn mean(&self, other: &Self) -> Self {
        Self {
            force: 0.5 * (self.force + other.force),
            torque: 0.5 * (self.torque + other.torque),
            outside: 0.5 * (self.outside + other.outside),
        }
    }
}

/// Returns the increment `h Σ a_j k_j` over the first `count` stages.
#[inline(always)]
fn weighted<const POSED: bool, const S: usize>(
    weights: &[f64; S],
    count: usize,
    h: f64,
    slopes: &[Change; S],
) -> Change {
    let zero = Vector3::zeros();
    let mut sum = Change { turn: zero, momentum: zero, position: zero, linear_momentum: zero };
    for (weight, slope) in weights.iter().zip(slopes).take(count) {
        let weight = h * weight;
        sum.turn += weight * slope.turn;
        sum.momentum += weight * slope.momentum;
        if POSED {
            sum.position += weight * slope.position;
            sum.linear_momentum += weight * slope.linear_momentum;
        }
    }
    sum
}

/// Returns the derivative `J_r⁻¹(u) Ω = Ω + ½ u × Ω + g u × (u × Ω)` of the rotation vector. The
/// factor `g = (1 − (t/2) cot(t/2))/t²`, `t = |u|`, is a series for `t` below a tenth.
#[inline(always)]
fn of_rate(u: &Vector3, rate: &Vector3) -> Vector3 {
    let t2 = u.norm_squared();
    let g = 1.0 / 12.0 + t2 * (1.0 / 720.0 + t2 * (1.0 / 30_240.0 + t2 / 1_209_600.0));
    let once = u.cross(rate);
    rate + 0.5 * once + g * u.cross(&once)
}

#[cfg(test)]
mod tests;
