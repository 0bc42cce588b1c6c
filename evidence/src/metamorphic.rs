//! Laws that relate the plans of two maneuvers: the second maneuver is the first one in another
//! description, or must not cost more.
//!
//! A law derives another maneuver from a planned one, and states the ratio of the two costs. It
//! needs no reference solution: planner and witnesses are compared with themselves for two
//! descriptions.

use super::Random;
use nalgebra::DMatrix;
use slewkit::maneuver::{
    Constraint, Duration, Fuel, Objective, Path, Problem, Rule, Scheme, Settings, State, Target, Weights,
};
use slewkit::mechanics::environment::{CentralGravity, GravityGradient, SecondOrderGravity, UniformGravity};
use slewkit::mechanics::{ActuatorSet, AxisFrame, Body, Description, Inertia, Limits};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{Direction, Matrix3, Vector3, lie};
use slewkit_files::spec::SpecDocument;
use std::f64::consts::PI;
use std::sync::Arc;

/// The relative tolerance of costs.
pub const TOLERANCE: f64 = 1e-9;

/// A maneuver with its plan.
pub struct Planned {
    pub problem: Problem,
    pub settings: Settings,
    pub plan: Plan,
}

impl Planned {
    /// Plans the maneuver; `None` if the planner refuses it. The laws concern the discrete
    /// problem, whose end is met to round-off.
    pub fn new(problem: Problem, settings: Settings) -> Option<Self> {
        let settings = Settings { target: Target::Discrete, ..settings };
        let plan = plan(&problem, &settings, None, &mut Silent).ok()?;
        Some(Self { problem, settings, plan })
    }
}

/// The maneuver that a law derives, and its expected cost.
pub struct Related {
    problem: Problem,
    /// The expected cost, relative to the cost of the first plan.
    factor: f64,
    /// True if the expected cost is an upper bound, which holds only if the first maneuver is
    /// solved. False if cost and status of both plans must be equal.
    at_most: bool,
}

/// A law: its name, and the function that derives the other maneuver and returns `None` if the law
/// does not apply.
pub type Law = (&'static str, fn(&Planned, &mut Random) -> Option<Related>);

/// All laws.
pub const LAWS: [Law; 12] = [
    ("other units", other_units),
    ("another reference frame", another_frame),
    ("other body axes", other_body_axes),
    ("permuted body axes", permuted_axes),
    ("in a mirror", in_a_mirror),
    ("backwards in time", backwards),
    ("inputs in another order", inputs_reordered),
    ("the way round by its rotation", way_by_rotation),
    ("limits that do not act", idle_limits),
    ("written and read back", written_and_read),
    ("more time costs less", more_time),
    ("wider limits cost no more", wider_limits),
];

/// Plans the maneuver that a law derives. Describes the violation of the law; `None` if the law
/// holds, and `Err` if it does not apply.
pub fn complaint(law: &Law, planned: &Planned, random: &mut Random) -> Result<Option<String>, NotApplicable> {
    let related = law.1(planned, random).ok_or(NotApplicable)?;
    let (first, steps) = (&planned.plan, related.problem.steps);
    let other = Planned::new(related.problem, planned.settings.clone()).ok_or(NotApplicable)?.plan;
    let expected = related.factor * cost(first);
    let excess = cost(&other) / expected - 1.0;
    let tolerance = TOLERANCE + inexact(first) + inexact(&other);
    let (solved, also) = (first.status == Status::Solved, other.status == Status::Solved);
    let words = |what: String| Ok(Some(format!("{what}, {steps} steps")));
    if related.at_most {
        return match (solved, also) {
            (false, _) => Err(NotApplicable),
            (true, false) => words(format!("solved, then {}", other.status.name())),
            (true, true) if excess > tolerance => words(format!("costs {excess:.1e} too much")),
            (true, true) => Ok(None),
        };
    }
    if first.status != other.status {
        return words(format!("{}, then {}", first.status.name(), other.status.name()));
    }
    // The comparison is written so that a NaN counts as a violation.
    let same = excess.abs() <= tolerance;
    if solved && !same { words(format!("cost differs by {excess:+.1e}")) } else { Ok(None) }
}

/// Returns the cost of a plan. For a bang-bang plan it is the cost of the continuous extremal,
/// because the cost on the grid depends on how its arcs are placed on steps, and on whether a
/// singular arc is smoothed or replaced.
fn cost(plan: &Plan) -> f64 {
    plan.solution.switching.as_ref().map_or(plan.solution.cost, |found| found.continuous_cost)
}

/// Returns the relative gap of a plan, by which its cost may exceed the optimum; 0 without a gap.
fn inexact(plan: &Plan) -> f64 {
    plan.solution.switching.as_ref().map_or(0.0, |found| found.gap / cost(plan))
}

/// The error that a law does not apply to a maneuver.
pub struct NotApplicable;

/// Returns the symmetric maneuvers that exist, with their names: the time-reversed maneuver, three
/// mirror images, and the maneuver in permuted axes. All have the same optimal cost.
pub fn images(problem: &Problem) -> Vec<(&'static str, Problem)> {
    let mirror = |at: usize| {
        let mut matrix = Matrix3::identity();
        matrix[(at, at)] = -1.0;
        View { reference: matrix, body: matrix, ..PLAIN }.of(problem)
    };
    let permuted = View { body: Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0), ..PLAIN };
    let all = [
        ("backwards", reversed(problem)),
        ("x mirrored", mirror(0)),
        ("y mirrored", mirror(1)),
        ("z mirrored", mirror(2)),
        ("axes permuted", permuted.of(problem)),
    ];
    all.into_iter().filter_map(|(name, image)| Some((name, image?))).collect()
}

/// A change of the description of a maneuver: of axes and units.
struct View {
    mass: f64,
    length: f64,
    time: f64,
    cost: f64,
    /// The map from old to new reference axes: a rotation, or a reflection if `body` is a
    /// reflection.
    reference: Matrix3,
    /// The map from old to new body axes.
    body: Matrix3,
}

/// The identity, which changes nothing.
const PLAIN: View = View {
    mass: 1.0,
    length: 1.0,
    time: 1.0,
    cost: 1.0,
    reference: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    body: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
};

impl View {
    fn torque(&self) -> f64 {
        self.mass * (self.length / self.time).powi(2)
    }

    fn force(&self) -> f64 {
        self.torque() / self.length
    }

    /// Transforms an axial vector (a rotation axis, a torque or a rate) to the new axes. A
    /// reflection reverses its sign.
    fn axial(matrix: &Matrix3, vector: &Vector3) -> Vector3 {
        matrix.determinant().signum() * (matrix * vector)
    }

    fn state(&self, state: &State) -> State {
        State {
            position: self.reference * state.position * self.length,
            velocity: self.reference * state.velocity * (self.length / self.time),
            attitude: lie::project_to_rotation(&(self.reference * state.attitude * self.body.transpose())),
            angular_velocity: Self::axial(&self.body, &state.angular_velocity) / self.time,
        }
    }

    fn inertia(&self, j: &Matrix3) -> Option<Inertia> {
        let j = self.body * j * self.body.transpose() * (self.mass * self.length * self.length);
        Inertia::new(0.5 * (j + j.transpose())).ok()
    }

    /// Transforms actuators to the new axes and to units of `size`. `axial` is true for torques,
    /// whose axes are axial vectors, and false for forces.
    fn actuators(&self, set: &ActuatorSet, axial: bool, size: f64) -> Option<ActuatorSet> {
        let matrix = if set.frame() == AxisFrame::Body { &self.body } else { &self.reference };
        let turned = |axis: &Vector3| if axial { Self::axial(matrix, axis) } else { matrix * axis };
        let limits = set.limits();
        let scaled = |values: &Option<Vec<f64>>, unit: f64| {
            values.as_ref().map(|values| values.iter().map(|value| value * unit).collect())
        };
        let limits = Limits {
            size: scaled(&limits.size, size),
            norm: limits.norm.map(|norm| norm * size),
            rate: scaled(&limits.rate, size / self.time),
            one_sided: limits.one_sided,
            shortest_pulse: limits.shortest_pulse.map(|pulse| pulse * self.time),
        };
        ActuatorSet::new(set.axes().iter().map(turned).collect(), set.frame()).ok()?.with_limits(limits).ok()
    }

    /// Returns the maneuver in the new description; `None` if it cannot be described so, such as an
    /// orbit frame with other axes.
    fn of(&self, problem: &Problem) -> Option<Problem> {
        let Self { mass, length, time, cost, reference, body } = self;
        let mut told = problem.clone();
        told.body = Body {
            inertia: self.inertia(problem.body.inertia.j())?,
            mass: problem.body.mass.map(|m| m * mass),
        };
        (told.start, told.end) = (self.state(&problem.start), self.state(&problem.end));
        told.duration = match problem.duration {
            Duration::Given(duration) => Duration::Given(duration * time),
            Duration::Sought { at_most } | Duration::Found { at_most, .. } => {
                Duration::Sought { at_most: at_most.map(|longest| longest * time) }
            }
        };
        let acceleration = length / (time * time);
        let parameter = length * length * acceleration;
        told.environment = match problem.environment.describe() {
            Description::Free => problem.environment.clone(),
            Description::UniformGravity { mass: m, gravity, direction, pivot_to_mass_center } => {
                let arm = body * pivot_to_mass_center * *length;
                Arc::new(
                    UniformGravity::new(m * mass, gravity * acceleration, reference * direction, arm).ok()?,
                )
            }
            Description::GravityGradient { orbital_rate, .. } => {
                let moved = (reference * Vector3::z() - Vector3::z()).norm()
                    + (Self::axial(reference, &Vector3::y()) - Vector3::y()).norm();
                if moved > 0.0 {
                    return None;
                }
                Arc::new(GravityGradient::new(orbital_rate / time, &told.body.inertia).ok()?)
            }
            Description::CentralGravity { gravitational_parameter, points } => {
                let points: Vec<_> = points.iter().map(|(m, x)| (m * mass, body * x * *length)).collect();
                Arc::new(CentralGravity::of_masses(gravitational_parameter * parameter, points).ok()?)
            }
            Description::SecondOrderGravity { gravitational_parameter, .. } => {
                let mass = told.body.mass?;
                let mu = gravitational_parameter * parameter;
                Arc::new(SecondOrderGravity::new(mu, mass, &told.body.inertia).ok()?)
            }
            Description::Custom => return None,
        };
        let time_price = problem.objective.given_time_price().map(|price| price * cost / time);
        told.objective = match &problem.objective {
            Objective::Effort(weights) => {
                let weight = |weight: DMatrix<f64>, unit: f64| Some(weight * (cost / (unit * unit * time)));
                Objective::Effort(Weights {
                    torque: weight(weights.torque(&problem.actuation).weight, self.torque()),
                    force: weights.force(&problem.actuation).and_then(|set| weight(set.weight, self.force())),
                    time_price,
                })
            }
            Objective::Time => Objective::Time,
            Objective::Fuel(fuel) => {
                let prices = |count: usize, of: &dyn Fn(usize) -> f64, unit: f64| {
                    Some((0..count).map(|input| of(input) * cost / (unit * time)).collect())
                };
                let forces = problem.actuation.force.as_ref();
                Objective::Fuel(Fuel {
                    prices: prices(
                        problem.actuation.torque.count(),
                        &|input| fuel.price(input),
                        self.torque(),
                    ),
                    force_prices: forces
                        .and_then(|set| prices(set.count(), &|input| fuel.force_price(input), self.force())),
                    time_price,
                })
            }
        };
        told.actuation.torque = self.actuators(&problem.actuation.torque, true, self.torque())?;
        if let Some(force) = &problem.actuation.force {
            told.actuation.force = Some(self.actuators(force, false, self.force())?);
        }
        if let Some(wheels) = &mut told.actuation.wheels {
            let stored = wheels.momentum.iter_mut().chain(&mut wheels.momentum_limit);
            stored.for_each(|momentum| *momentum *= self.torque() * time);
        }
        if let Path::AsGiven(turn) = &problem.path {
            told.path = Path::AsGiven(Self::axial(body, turn));
        }
        for Constraint { rule, .. } in &mut told.constraints {
            match rule {
                Rule::RateNorm(limit) => *limit /= time,
                Rule::RateAxes(limits) => {
                    // Limits on each axis do not transform to axes that are not a permutation of
                    // the old ones.
                    if body.iter().any(|entry| entry.abs() > 0.0 && (entry.abs() - 1.0).abs() > 0.0) {
                        return None;
                    }
                    *limits = body.abs() * *limits / *time;
                }
                Rule::Pointing(pointing) => {
                    pointing.boresights.iter_mut().for_each(|b| *b = (body * *b).normalize());
                    let directions = pointing.directions.iter_mut();
                    directions.for_each(|to| *to = to.turned(reference));
                }
            }
        }
        Some(told)
    }
}

fn same(problem: Problem, factor: f64) -> Option<Related> {
    Some(Related { problem, factor, at_most: false })
}

fn rotation(random: &mut Random) -> Matrix3 {
    let axis = Vector3::from_fn(|_, _| random.uniform());
    lie::exp(&(axis.normalize() * random.within(0.2, PI)))
}

fn other_units(planned: &Planned, random: &mut Random) -> Option<Related> {
    let mut unit = |decades: f64| 10.0_f64.powf(decades * random.uniform());
    let view = View { mass: unit(3.0), length: unit(2.0), time: unit(2.0), cost: unit(3.0), ..PLAIN };
    let factor = if planned.problem.objective == Objective::Time { view.time } else { view.cost };
    same(view.of(&planned.problem)?, factor)
}

fn another_frame(planned: &Planned, random: &mut Random) -> Option<Related> {
    same(View { reference: rotation(random), ..PLAIN }.of(&planned.problem)?, 1.0)
}

fn other_body_axes(planned: &Planned, random: &mut Random) -> Option<Related> {
    same(View { body: rotation(random), ..PLAIN }.of(&planned.problem)?, 1.0)
}

/// Permutes the body axes: x → y → z → x, or two axes exchanged and the third reversed.
fn permuted_axes(planned: &Planned, random: &mut Random) -> Option<Related> {
    let body = match random.below(2) {
        0 => Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0),
        _ => Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0),
    };
    same(View { body, ..PLAIN }.of(&planned.problem)?, 1.0)
}

/// Mirrors the maneuver in the x-z plane, which on an orbit contains its radius and velocity.
fn in_a_mirror(planned: &Planned, _: &mut Random) -> Option<Related> {
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    same(View { reference: mirror, body: mirror, ..PLAIN }.of(&planned.problem)?, 1.0)
}

/// Derives the time-reversed maneuver as [`reversed`] does. The terminal error of the true motion
/// does not transform: held torques act over the step after their node, so the reversed plan has
/// another error.
fn backwards(planned: &Planned, _: &mut Random) -> Option<Related> {
    let judged = planned.settings.continuous_tolerance.is_some();
    if judged { None } else { same(reversed(&planned.problem)?, 1.0) }
}

/// Returns the time-reversed maneuver: exchanges the ends and reverses the rates. A reversed orbit
/// is the orbit seen from the other side of its plane. Returns `None` for Lie–Euler, which is not
/// symmetric in time, and for wheels, whose final momenta are unknown.
fn reversed(problem: &Problem) -> Option<Problem> {
    if problem.scheme == Scheme::LieEuler || problem.actuation.wheels.is_some() {
        return None;
    }
    let frame_rate = problem.environment.frame_rate();
    let still = frame_rate == Vector3::zeros();
    // For a free duration, the rotation of the frame from start to end is unknown.
    let duration = problem.duration.known().or(still.then_some(0.0))?;
    let turned = if still { PLAIN.reference } else { lie::exp(&Vector3::new(0.0, 0.0, PI)) };
    let back = |state: &State| State {
        attitude: lie::project_to_rotation(&(turned * state.attitude)),
        angular_velocity: -state.angular_velocity,
        velocity: -state.velocity,
        ..*state
    };
    let mut reversed = problem.clone();
    (reversed.start, reversed.end) = (back(&problem.end), back(&problem.start));
    if problem.actuation.torque.frame() == AxisFrame::Reference && turned != PLAIN.reference {
        return None;
    }
    reversed.path = match &problem.path {
        // The rotation vector has the same components in body and reference axes, at both ends.
        Path::AsGiven(turn) => Path::AsGiven(-turn),
        Path::Best => Path::Best,
        // The short and the long way are counted from the motion without inputs. The time-reversed
        // maneuver has another such motion if a rate at an end is not zero or a field acts.
        path if is_free_slew(problem) => *path,
        _ => return None,
    };
    for Constraint { rule, .. } in &mut reversed.constraints {
        if let Rule::Pointing(pointing) = rule {
            for to in &mut pointing.directions {
                let seen = (turned * to.at(duration, &frame_rate)).normalize();
                match to {
                    Direction::Fixed(vector) | Direction::InFrame(vector) => *vector = seen,
                    Direction::Moving(_) | Direction::Disc { .. } => return None,
                }
            }
        }
    }
    Some(reversed)
}

fn inputs_reordered(planned: &Planned, _: &mut Random) -> Option<Related> {
    let mut problem = planned.problem.clone();
    let set = &problem.actuation.torque;
    let count = set.count();
    let next = |input: usize| (input + 1) % count;
    let turned = |values: &[f64]| (0..count).map(|input| values[next(input)]).collect();
    let limits = Limits {
        size: set.limits().size.as_deref().map(turned),
        rate: set.limits().rate.as_deref().map(turned),
        ..set.limits().clone()
    };
    let axes = (0..count).map(|input| set.axes()[next(input)]).collect();
    problem.actuation.torque = ActuatorSet::new(axes, set.frame()).ok()?.with_limits(limits).ok()?;
    if let Some(wheels) = &mut problem.actuation.wheels {
        (wheels.momentum, wheels.momentum_limit) = (turned(&wheels.momentum), turned(&wheels.momentum_limit));
    }
    problem.objective = match &planned.problem.objective {
        Objective::Effort(weights) => {
            let weight = weights.torque(&planned.problem.actuation).weight;
            let weight = DMatrix::from_fn(count, count, |row, column| weight[(next(row), next(column))]);
            Objective::Effort(Weights { torque: Some(weight), ..weights.clone() })
        }
        Objective::Time => Objective::Time,
        Objective::Fuel(fuel) => {
            Objective::Fuel(Fuel { prices: fuel.prices.as_deref().map(turned), ..fuel.clone() })
        }
    };
    same(problem, 1.0)
}

fn is_still(problem: &Problem) -> bool {
    let State { angular_velocity, velocity, .. } = problem.start;
    let end = &problem.end;
    let still = [angular_velocity, velocity, end.angular_velocity, end.velocity];
    still.iter().all(|rate| *rate == Vector3::zeros())
}

/// Returns whether the maneuver is a rest-to-rest slew of a free body without spinning wheels,
/// which has no natural time scale.
fn is_free_slew(problem: &Problem) -> bool {
    let free = matches!(problem.environment.describe(), Description::Free);
    free && is_still(problem) && problem.actuation.stored_momentum() == Vector3::zeros()
}

/// Requests the short way by its rotation vector. For rest-to-rest slews the short way is the
/// shortest rotation. The long way is not tested: its plan is the cheapest of its homotopy class,
/// while a given long rotation selects the nearest plan, so the two differ.
fn way_by_rotation(planned: &Planned, _: &mut Random) -> Option<Related> {
    let mut problem = planned.problem.clone();
    let turn = lie::minus(&problem.end.attitude, &problem.start.attitude);
    let unclear = turn.norm() > PI - 1e-3 || turn.norm() < 1e-3;
    if problem.path != Path::Shortest || !is_free_slew(&problem) || unclear {
        return None;
    }
    problem.path = Path::AsGiven(turn);
    same(problem, 1.0)
}

/// Adds limits that are 1.5 times as wide as the plan without them needs, and must not change it.
fn idle_limits(planned: &Planned, _: &mut Random) -> Option<Related> {
    let Planned { problem, plan, .. } = planned;
    let actuation = &problem.actuation;
    let other = actuation.force.is_some() || actuation.wheels.is_some() || actuation.is_limited();
    if other || !problem.constraints.is_empty() || plan.status != Status::Solved {
        return None;
    }
    let count = actuation.torque.count();
    let peak = plan.solution.trajectory.input.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
    let limits = Limits { size: Some(vec![1.5 * peak; count]), ..Limits::default() };
    let mut problem = problem.clone();
    problem.actuation.torque = actuation.torque.clone().with_limits(limits).ok()?;
    same(problem, 1.0)
}

fn written_and_read(planned: &Planned, _: &mut Random) -> Option<Related> {
    let written = SpecDocument::new(&planned.problem, &planned.settings).ok()?;
    same(written.read("written", &[]).ok()?.problem, 1.0)
}

/// Derives the maneuver with c times the duration. The same path then needs c⁻² of each torque, c⁻³
/// of the effort and c⁻¹ of the fuel. Rates, and the rates of torques, decrease too.
fn more_time(planned: &Planned, random: &mut Random) -> Option<Related> {
    let mut problem = planned.problem.clone();
    let Duration::Given(duration) = problem.duration else { return None };
    if !is_free_slew(&problem) {
        return None;
    }
    let longer = random.within(1.05, 2.0);
    problem.duration = Duration::Given(duration * longer);
    let factor = if problem.objective.fuel().is_some() { longer.recip() } else { longer.powi(-3) };
    Some(Related { problem, factor, at_most: true })
}

fn wider_limits(planned: &Planned, random: &mut Random) -> Option<Related> {
    let mut problem = planned.problem.clone();
    if !problem.is_constrained() {
        return None;
    }
    let wider = random.within(1.02, 1.5);
    let widen = |set: &ActuatorSet| {
        let limits = set.limits();
        let each = |values: &Option<Vec<f64>>| values.as_ref().map(|v| v.iter().map(|v| v * wider).collect());
        let (size, rate) = (each(&limits.size), each(&limits.rate));
        let norm = limits.norm.map(|norm| norm * wider);
        set.clone().with_limits(Limits { size, rate, norm, ..limits.clone() }).ok()
    };
    problem.actuation.torque = widen(&problem.actuation.torque)?;
    problem.actuation.force = match &problem.actuation.force {
        Some(force) => Some(widen(force)?),
        None => None,
    };
    if let Some(wheels) = &mut problem.actuation.wheels {
        wheels.momentum_limit.iter_mut().for_each(|limit| *limit *= wider);
    }
    for Constraint { rule, .. } in &mut problem.constraints {
        match rule {
            Rule::RateNorm(limit) => *limit *= wider,
            Rule::RateAxes(limits) => *limits *= wider,
            Rule::Pointing(_) => {}
        }
    }
    Some(Related { problem, factor: 1.0, at_most: true })
}
