//! The maneuver to plan: a plain value in SI units. The solvers check it by [`Problem::check`].

mod check;
mod clock;
mod ends;
mod error;
mod formulation;
mod plane;
mod unsuited;

pub use crate::maneuver::grid::Scheme;
pub use ends::EndCondition;
pub use error::ProblemError;
pub use formulation::{Formulation, Stepping};
pub use unsuited::Unsuited;

use crate::lie::Rotation;
use crate::maneuver::constraint::{Alternatives, Constraint, Rule, Turns};
use crate::maneuver::duration::Duration;
use crate::maneuver::grid::Grid;
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::reserve::Reserve;
use crate::maneuver::settings::Method;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Environment, Free};
use crate::{Matrix3, Vector3};
use std::sync::Arc;

/// Pose and velocities at one end of the maneuver, SI units. Frames as in the crate's conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Position of the mass centre, reference frame \[m\]; zero on SO(3).
    pub position: Vector3,
    /// Velocity of the mass centre, reference frame [m/s]; zero on SO(3).
    pub velocity: Vector3,
    /// Attitude `R`, body → reference.
    pub attitude: Matrix3,
    /// Inertial angular velocity `Ω`, body axes [rad/s].
    pub angular_velocity: Vector3,
}

impl State {
    /// Builds a state on SO(3): a rotation of nalgebra or a matrix, and the inertial angular
    /// velocity `Ω`, body axes [rad/s].
    pub fn attitude(attitude: impl Into<Rotation>, angular_velocity: Vector3) -> Self {
        let rotation: Rotation = attitude.into();
        let still = Vector3::zeros();
        Self { position: still, velocity: still, attitude: *rotation.matrix(), angular_velocity }
    }

    /// Builds a state at rest in `attitude`, on SO(3).
    ///
    /// ```
    /// use slewkit::{State, Vector3, lie};
    ///
    /// let quarter_turn = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2)));
    /// assert!((quarter_turn.attitude * Vector3::x() - Vector3::y()).norm() < 1e-15);
    /// ```
    pub fn at_rest(attitude: impl Into<Rotation>) -> Self {
        Self::attitude(attitude, Vector3::zeros())
    }
}

/// The degrees of freedom of a maneuver: the attitude alone, or position and attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Attitude only, SO(3), tangent dimension 6.
    Attitude,
    /// Position and attitude, SE(3), tangent dimension 12.
    RigidBody,
}

/// The choice of the homotopy class of the rotation from the start to the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// All directions of rotation and numbers of turns are searched, and the cheapest plan is kept.
    Best,
    /// The homotopy class of the short way, relative to the end point of the ballistic motion. The
    /// plan is the cheapest one that was found in this class.
    Shortest,
    /// The homotopy class of the long way.
    Long,
    /// A given rotation from the start: a rotation vector in the body axes of the start \[rad\], of
    /// any angle. For minimum time and minimum fuel it determines the number of whole turns, and
    /// the plan chooses their axes.
    AsGiven(Vector3),
}

/// A maneuver to plan: body, actuators, start and end states, duration, objective, limits and grid.
///
/// [`Problem::attitude`], [`Problem::rigid_body`] and the `with_` methods build a problem. The
/// solvers check it by [`Problem::check`]. The default [`Objective`] is the effort `∫ ½ uᵀu dt`.
///
/// ```
/// use slewkit::{Body, Inertia, Matrix3, Path, Problem, Scheme, State, Vector3, lie};
///
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
/// let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
/// let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 30.0)
///     .with_steps(300)
///     .with_scheme(Scheme::LieEuler)
///     .with_path(Path::Shortest);
/// problem.check()?;
/// assert_eq!((problem.dimension(), problem.step()), (6, 0.1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Problem {
    /// Name of the maneuver in reports and files.
    pub name: String,
    /// The degrees of freedom: attitude only, or position and attitude.
    pub motion: Motion,
    /// Inertia and mass of the body.
    pub body: Body,
    /// The force field that acts on the body, and the rate of the reference frame.
    pub environment: Arc<dyn Environment>,
    /// The actuators of the body.
    pub actuation: Actuation,
    /// The objective that the plan minimises.
    pub objective: Objective,
    /// State at `t = 0`.
    pub start: State,
    /// State at `t = T`. If [`Problem::end_condition`] leaves the attitude free, the attitude is a
    /// guess until a plan has found it.
    pub end: State,
    /// The condition at the end: it states which part of the end state is given.
    pub end_condition: EndCondition,
    /// Duration `T`: given, or chosen by the plan.
    pub duration: Duration,
    /// Number of steps `N`; the step is `h = T/N`.
    pub steps: usize,
    /// Whether a plan that lands may have more than [`Problem::steps`] steps, if landing needs
    /// them. [`Problem::with_steps`] turns this choice off.
    pub chooses_steps: bool,
    /// The integration scheme of the discretisation.
    pub scheme: Scheme,
    /// The kind of steps of a minimum-time or minimum-fuel plan ([`Formulation`]).
    #[doc(hidden)]
    pub stepping: Stepping,
    /// The choice of the homotopy class of the rotation.
    pub path: Path,
    /// The pointing constraints and the rate limits.
    pub constraints: Vec<Constraint>,
    /// Alternative sets of these constraints, of which one holds at each time. A constraint that is
    /// in no set holds at all times.
    pub alternatives: Vec<Alternatives>,
    /// The part of the limits that is reserved for corrections in flight.
    pub reserve: Reserve,
}

impl Problem {
    /// The smallest allowed number of steps.
    pub const MIN_STEPS: usize = 2;
    /// The largest allowed number of steps.
    pub const MAX_STEPS: usize = 1_000_000;
    /// The largest allowed number of constraints.
    pub const MAX_CONSTRAINTS: usize = 1_000;

    /// Builds an attitude maneuver of a free body with three torques of unit weight along the body
    /// axes. `duration` is in seconds, or [`Duration::SOUGHT`] for a free duration. The scheme is
    /// Lie–Verlet with 100 steps, or as many as landing needs. All homotopy classes are searched.
    pub fn attitude(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        Self {
            name: String::new(),
            motion: Motion::Attitude,
            body,
            environment: Arc::new(Free),
            actuation: Actuation::torques(ActuatorSet::three_axes(AxisFrame::Body)),
            objective: Objective::default(),
            start,
            end,
            end_condition: EndCondition::State,
            duration: duration.into(),
            steps: 100,
            chooses_steps: true,
            scheme: Scheme::LieVerlet,
            stepping: Stepping::Formulated,
            path: Path::Best,
            constraints: Vec::new(),
            alternatives: Vec::new(),
            reserve: Reserve::default(),
        }
    }

    /// Builds a maneuver of position and attitude. In addition to the torques of
    /// [`Problem::attitude`] it has three forces of unit weight along the axes of the reference
    /// frame. The body needs a mass.
    pub fn rigid_body(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        let mut problem = Self::attitude(body, start, end, duration);
        problem.motion = Motion::RigidBody;
        problem.actuation.force = Some(ActuatorSet::three_axes(AxisFrame::Reference));
        problem
    }

    /// Replaces the environment of the body.
    pub fn with_environment(mut self, environment: impl Environment + 'static) -> Self {
        self.environment = Arc::new(environment);
        self
    }

    /// Replaces the actuators.
    pub fn with_actuation(mut self, actuation: Actuation) -> Self {
        self.actuation = actuation;
        self
    }

    /// Replaces the objective by an [`Objective`], or by the effort with the given
    /// [`Weights`](crate::Weights).
    pub fn with_objective(mut self, objective: impl Into<Objective>) -> Self {
        self.objective = objective.into();
        self
    }

    /// Sets the number of steps, [`Problem::MIN_STEPS`] to [`Problem::MAX_STEPS`]. The planner then
    /// does not choose the number.
    pub fn with_steps(mut self, steps: usize) -> Self {
        (self.steps, self.chooses_steps) = (steps, false);
        self
    }

    /// Sets the integration scheme.
    pub fn with_scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// Builds the maneuver under the full limits of the craft: no part of a limit is reserved, and
    /// cones have no margins.
    pub fn of_craft(&self) -> Self {
        let mut craft = Self { reserve: Reserve::default(), ..self.clone() };
        craft.actuation.torque = self.reserve.given_back(&self.actuation.torque);
        craft.constraints.iter_mut().for_each(|constraint| self.reserve.give_back(constraint));
        craft
    }

    /// Sets the homotopy class of the rotation.
    pub fn with_path(mut self, path: Path) -> Self {
        self.path = path;
        self
    }

    /// Adds a constraint.
    pub fn with_constraint(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Adds alternative sets of constraints, of which one holds at each time.
    pub fn with_alternatives(mut self, alternatives: Alternatives) -> Self {
        self.alternatives.push(alternatives);
        self
    }

    /// Builds the maneuver in which each alternative set of cones is active during its shifts only.
    pub(crate) fn in_turns(&self, turns: &[Turns]) -> Self {
        let mut problem = Self { alternatives: Vec::new(), ..self.clone() };
        for Turns { of, shifts } in turns {
            for (set, members) in of.sets.iter().enumerate() {
                let own = shifts.iter().filter(|shift| shift.set == set);
                let times: Vec<[f64; 2]> = own.map(|shift| [shift.from, shift.to]).collect();
                for constraint in &mut problem.constraints {
                    if let (true, Rule::Pointing(cone)) =
                        (members.contains(&constraint.name), &mut constraint.rule)
                    {
                        cone.during = cone.during.within(&times);
                    }
                }
            }
        }
        problem
    }

    /// Returns whether inputs are held over steps of unequal lengths. This is the case for a plan
    /// whose inputs switch ([`Formulation::Switching`]): minimum time and minimum fuel of a free
    /// body with a given end attitude if only the torques are limited. It is also the case for a
    /// recorded motion ([`Stepping::Recorded`]).
    pub fn switches(&self) -> bool {
        self.stepping == Stepping::Recorded || Formulation::of(self) == Formulation::Switching
    }

    /// Returns whether a minimum-time or minimum-fuel plan has its inputs at the nodes of a uniform
    /// grid, as a minimum-effort plan has. This is the case for forces and force fields, for limits
    /// of more than the torques, and if SCP or the interior point is requested.
    pub fn is_shaped(&self) -> bool {
        self.objective.switches() && !self.switches()
    }

    /// Builds the maneuver on the grid that `method` uses: SCP and the interior point use a uniform
    /// grid.
    #[doc(hidden)]
    pub fn planned_by(self, method: Method) -> Self {
        let stepping = if method.is_on_equal_steps() { Stepping::Equal } else { self.stepping };
        Self { stepping, ..self }
    }

    /// Builds the maneuver as a plan of arcs, with no active constraint.
    #[doc(hidden)]
    pub fn planned_on_arcs(self) -> Self {
        Self { stepping: Stepping::Arcs, ..self }
    }

    /// Returns whether a longer duration never has a higher cost. This holds from rest to rest for
    /// a body on which only its inputs act, because the body can wait.
    pub(crate) fn can_wait(&self) -> bool {
        let rests = |state: &State| {
            state.angular_velocity.norm() == 0.0
                && (self.motion == Motion::Attitude || state.velocity.norm() == 0.0)
        };
        let still = self.environment.frame_rate().amax() == 0.0;
        still && self.environment.is_free() && rests(&self.start) && rests(&self.end)
    }

    /// Returns whether only the attitude is planned and only the torques of the body act on it.
    pub(crate) fn is_free_turn(&self) -> bool {
        let still = self.environment.frame_rate().amax() == 0.0;
        self.motion == Motion::Attitude && still && self.environment.is_free()
    }

    /// Returns whether the problem has limits other than limits on each torque or on the torque
    /// norm. The shooting does not support such limits.
    pub(crate) fn has_shaping_limits(&self) -> bool {
        self.has_shaping_inputs() || !self.constraints.is_empty()
    }

    /// Returns whether the limits of the inputs exclude bang-bang arcs. This is the case with
    /// limits of the torque rates, with a norm limit together with limits of each input, and with
    /// wheels.
    pub(crate) fn has_shaping_inputs(&self) -> bool {
        let limits = self.actuation.torque.limits();
        let jumping = limits.rate.is_none() && !(limits.size.is_some() && limits.norm.is_some());
        !jumping || self.actuation.wheels.is_some()
    }

    /// Returns whether inputs, rates or pointing are limited.
    pub fn is_constrained(&self) -> bool {
        !self.constraints.is_empty() || self.actuation.is_limited()
    }

    /// Builds a minimum-time maneuver of a free body with three body torques of unit weight. The
    /// torques need limits ([`Problem::with_actuation`]).
    ///
    /// ```
    /// use slewkit::{
    ///     Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Matrix3, Problem, Silent,
    ///     State, Vector3, lie, plan,
    /// };
    ///
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 1.0, 1.0))?, mass: None };
    /// let end = State::at_rest(lie::exp(&Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2)));
    /// let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    /// let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
    /// let problem = Problem::minimum_time(body, State::at_rest(Matrix3::identity()), end)
    ///     .with_actuation(Actuation::torques(torques));
    /// let plan = plan(&problem, &Default::default(), None, &mut Silent)?;
    /// let switching = plan.solution.switching.expect("a plan of minimum time has arcs");
    /// // Bilimoria and Wie 1993; about the axis alone it takes 2.5066 s.
    /// assert!((switching.continuous_duration_s - 2.4211).abs() < 5e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn minimum_time(body: Body, start: State, end: State) -> Self {
        Self { objective: Objective::Time, ..Self::attitude(body, start, end, Duration::SOUGHT) }
    }

    /// Builds a minimum-fuel maneuver, `∫ Σ |u_j| dt`, of a free body with three body torques in a
    /// given duration \[s\]. The torques need limits ([`Problem::with_actuation`]).
    pub fn minimum_fuel(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        Self { objective: Objective::Fuel(Fuel::default()), ..Self::attitude(body, start, end, duration) }
    }

    /// Sets the duration: a number of seconds, or [`Duration::SOUGHT`] for a free duration.
    pub fn with_duration(self, duration: impl Into<Duration>) -> Self {
        Self { duration: duration.into(), ..self }
    }

    /// Returns the problem with the duration `duration` \[s\], marked as found if it was free.
    pub(crate) fn lasting(self, duration: f64) -> Self {
        Self { duration: self.duration.lasting(duration), ..self }
    }

    /// Requests the best duration up to `longest` \[s\].
    ///
    /// From rest to rest a longer duration never costs more, and the plan uses all of it. If the
    /// body moves at an end, the plan may use less.
    pub fn with_duration_at_most(self, longest: f64) -> Self {
        Self { duration: Duration::Sought { at_most: Some(longest) }, ..self }
    }

    /// Returns the minimum pulse width \[s\] of inputs that are off or at a limit; `None` if pulses
    /// may have any width.
    pub fn shortest_pulse(&self) -> Option<f64> {
        self.actuation.torque.limits().shortest_pulse
    }

    /// Returns whether the plan chooses the duration, even if the duration has been found already.
    pub fn seeks_duration(&self) -> bool {
        !matches!(self.duration, Duration::Given(_))
    }

    /// Returns the duration `T` \[s\], given or found.
    ///
    /// # Panics
    /// Panics if the duration is free: solvers and witnesses need a known duration
    /// ([`Problem::with_duration`]).
    pub fn seconds(&self) -> f64 {
        self.duration.known().expect("the duration is free, and no plan has determined it yet")
    }

    /// Returns the number of rows of inputs in a plan: one for each node that has inputs, or one
    /// for each step if inputs switch.
    pub fn input_rows(&self) -> usize {
        if self.switches() { self.steps } else { self.scheme.input_rows(self.steps) }
    }

    /// Returns the uniform time grid of the problem \[s\]. A plan whose inputs switch has its own
    /// grid.
    ///
    /// # Panics
    /// Panics if the duration is free and not yet found.
    pub fn grid(&self) -> Grid {
        Grid::uniform(self.scheme, self.seconds(), self.steps)
    }

    /// Returns the step `h = T/N` \[s\].
    ///
    /// # Panics
    /// Panics if the duration is free and not yet found.
    pub fn step(&self) -> f64 {
        self.seconds() / self.steps as f64
    }

    /// Returns the tangent dimension: 6 on SO(3), 12 on SE(3).
    pub fn dimension(&self) -> usize {
        match self.motion {
            Motion::Attitude => 6,
            Motion::RigidBody => 12,
        }
    }
}
