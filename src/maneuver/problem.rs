//! The maneuver to plan: a plain value in SI units, checked by [`Problem::check`] where it is
//! solved.

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
    /// Position of the mass center, reference frame \[m\]; zero on SO(3).
    pub position: Vector3,
    /// Velocity of the mass center, reference frame [m/s]; zero on SO(3).
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

/// The moving quantities: the attitude alone, or position and attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Attitude only, SO(3), tangent dimension 6.
    Attitude,
    /// Position and attitude, SE(3), tangent dimension 12.
    RigidBody,
}

/// The homotopy class of the rotation from the start to the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// Solve every sense and winding, keep the lowest cost.
    Best,
    /// The rotation sense of the shorter way, counted from the ballistic end point; of this sense
    /// the lowest cost that is found.
    Shortest,
    /// The other sense.
    Long,
    /// The rotation from the start as written: a rotation vector in the body axes of the start
    /// \[rad\], of any angle. For least time and fuel it determines the number of whole turns;
    /// the plan chooses their axes.
    AsGiven(Vector3),
}

/// A maneuver: who moves, where from, where to, in what time, on which grid.
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
    /// The name of the maneuver, for people.
    pub name: String,
    /// Attitude only, or position and attitude.
    pub motion: Motion,
    /// The body.
    pub body: Body,
    /// The field that acts on the body.
    pub environment: Arc<dyn Environment>,
    /// The actuators of the body.
    pub actuation: Actuation,
    /// The objective.
    pub objective: Objective,
    /// State at `t = 0`.
    pub start: State,
    /// State at `t = T`. An attitude that is not given ([`Problem::end_condition`]) is a guess
    /// until a plan has found it.
    pub end: State,
    /// The given part of the end state.
    pub end_condition: EndCondition,
    /// Duration `T`: given, or chosen by the plan.
    pub duration: Duration,
    /// Number of steps `N`; the step is `h = T/N`.
    pub steps: usize,
    /// Whether a plan that lands may take more steps where it needs them: until they are given
    /// ([`Problem::with_steps`]).
    pub chooses_steps: bool,
    /// The discretisation.
    pub scheme: Scheme,
    /// The steps of a plan of minimum time or fuel ([`Formulation`]).
    #[doc(hidden)]
    pub stepping: Stepping,
    /// The homotopy class of the rotation.
    pub path: Path,
    /// The pointing constraints and the limits of the rate.
    pub constraints: Vec<Constraint>,
    /// Sets of these constraints that alternate. A constraint that is in no set holds at all
    /// times.
    pub alternatives: Vec<Alternatives>,
    /// The part of the limits that the plan leaves to corrections in flight.
    pub reserve: Reserve,
}

impl Problem {
    /// The fewest steps.
    pub const MIN_STEPS: usize = 2;
    /// The most steps.
    pub const MAX_STEPS: usize = 1_000_000;
    /// The most constraints.
    pub const MAX_CONSTRAINTS: usize = 1_000;

    /// Builds an attitude maneuver of a free body. It has three body torques of unit weight, and
    /// `duration` \[s\] or a free one ([`Duration::SOUGHT`]). The second-order scheme has 100
    /// steps, or as many as landing needs. All homotopy classes are searched.
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

    /// Builds a maneuver of position and attitude, with three forces of unit weight along the
    /// reference axes added. The body needs a mass.
    pub fn rigid_body(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        let mut problem = Self::attitude(body, start, end, duration);
        problem.motion = Motion::RigidBody;
        problem.actuation.force = Some(ActuatorSet::three_axes(AxisFrame::Reference));
        problem
    }

    /// Puts the body into another environment.
    pub fn with_environment(mut self, environment: impl Environment + 'static) -> Self {
        self.environment = Arc::new(environment);
        self
    }

    /// Replaces the actuators.
    pub fn with_actuation(mut self, actuation: Actuation) -> Self {
        self.actuation = actuation;
        self
    }

    /// Replaces the objective by an [`Objective`], or by the [`Weights`](crate::Weights) of the
    /// effort.
    pub fn with_objective(mut self, objective: impl Into<Objective>) -> Self {
        self.objective = objective.into();
        self
    }

    /// Sets the number of steps, [`Problem::MIN_STEPS`] to [`Problem::MAX_STEPS`]: a plan takes
    /// neither more nor fewer.
    pub fn with_steps(mut self, steps: usize) -> Self {
        (self.steps, self.chooses_steps) = (steps, false);
        self
    }

    /// Chooses the discretisation.
    pub fn with_scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// Builds the maneuver under the limits of the craft: nothing is held in reserve, and cones
    /// have no margins.
    pub fn of_craft(&self) -> Self {
        let mut craft = Self { reserve: Reserve::default(), ..self.clone() };
        craft.actuation.torque = self.reserve.given_back(&self.actuation.torque);
        craft.constraints.iter_mut().for_each(|constraint| self.reserve.give_back(constraint));
        craft
    }

    /// Chooses which way round.
    pub fn with_path(mut self, path: Path) -> Self {
        self.path = path;
        self
    }

    /// Adds a constraint.
    pub fn with_constraint(mut self, constraint: Constraint) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Lets sets of constraints hold in turns.
    pub fn with_alternatives(mut self, alternatives: Alternatives) -> Self {
        self.alternatives.push(alternatives);
        self
    }

    /// Builds the maneuver with the sets of alternatives acting in their shifts alone.
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

    /// Returns whether inputs are held over steps of unequal lengths. This holds for minimum time
    /// and fuel if the only limits of the plan are limits of the torques, whose inputs switch, and
    /// for a recorded motion ([`Stepping::Recorded`]).
    pub fn switches(&self) -> bool {
        self.stepping == Stepping::Recorded || Formulation::of(self) == Formulation::Switching
    }

    /// Returns whether a plan of minimum time or fuel has its inputs at the nodes of equal steps,
    /// as for effort. This holds for forces and fields, for limits of more than the torques, and
    /// if SCP is requested.
    pub fn is_shaped(&self) -> bool {
        self.objective.switches() && !self.switches()
    }

    /// Builds the maneuver as `method` plans it: by SCP and by the interior point on equal steps.
    #[doc(hidden)]
    pub fn planned_by(self, method: Method) -> Self {
        let stepping = if method.is_on_equal_steps() { Stepping::Equal } else { self.stepping };
        Self { stepping, ..self }
    }

    /// Builds the maneuver as arcs plan it along which none of its constraints acts.
    #[doc(hidden)]
    pub fn planned_on_arcs(self) -> Self {
        Self { stepping: Stepping::Arcs, ..self }
    }

    /// Returns whether more time is never worse: from rest to rest where nothing acts on the body,
    /// it can wait.
    pub(crate) fn can_wait(&self) -> bool {
        let rests = |state: &State| {
            state.angular_velocity.norm() == 0.0
                && (self.motion == Motion::Attitude || state.velocity.norm() == 0.0)
        };
        let still = self.environment.frame_rate().amax() == 0.0;
        still && self.environment.is_free() && rests(&self.start) && rests(&self.end)
    }

    /// Returns whether the attitude alone is planned, of a body that nothing acts on but its
    /// torques.
    pub(crate) fn is_free_turn(&self) -> bool {
        let still = self.environment.frame_rate().amax() == 0.0;
        self.motion == Motion::Attitude && still && self.environment.is_free()
    }

    /// Returns whether it has more limits than those of each torque, or of the norm of the
    /// torque. The shooting does not support more.
    pub(crate) fn has_shaping_limits(&self) -> bool {
        self.has_shaping_inputs() || !self.constraints.is_empty()
    }

    /// Returns whether limits of the outputs of the inputs, or wheels, need more than arcs at the
    /// limits.
    pub(crate) fn has_shaping_inputs(&self) -> bool {
        let limits = self.actuation.torque.limits();
        let jumping = limits.rate.is_none() && !(limits.size.is_some() && limits.norm.is_some());
        !jumping || self.actuation.wheels.is_some()
    }

    /// Returns whether anything limits inputs, rates or pointing.
    pub fn is_constrained(&self) -> bool {
        !self.constraints.is_empty() || self.actuation.is_limited()
    }

    /// Builds a maneuver of minimum time: of a free body with three body torques of unit weight,
    /// which need limits.
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

    /// Builds a maneuver of least fuel `∫ Σ |u_j| dt` in a given duration \[s\]: of a free body
    /// with three body torques, which need limits.
    pub fn minimum_fuel(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        Self { objective: Objective::Fuel(Fuel::default()), ..Self::attitude(body, start, end, duration) }
    }

    /// Sets the duration: that in seconds, or [`Duration::SOUGHT`].
    pub fn with_duration(self, duration: impl Into<Duration>) -> Self {
        Self { duration: duration.into(), ..self }
    }

    /// Returns the problem with `duration` \[s\], which is found if it was free.
    pub(crate) fn lasting(self, duration: f64) -> Self {
        Self { duration: self.duration.lasting(duration), ..self }
    }

    /// Requests the best duration up to `longest` \[s\].
    ///
    /// From rest to rest more time never costs more, and the plan uses all of it. If the body
    /// moves at an end, the plan may use less.
    pub fn with_duration_at_most(self, longest: f64) -> Self {
        Self { duration: Duration::Sought { at_most: Some(longest) }, ..self }
    }

    /// Returns the shortest pulse \[s\] where inputs are off or at a limit alone.
    pub fn shortest_pulse(&self) -> Option<f64> {
        self.actuation.torque.limits().shortest_pulse
    }

    /// Returns whether the duration is the plan's to choose, be it found already.
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

    /// Returns the rows of inputs of a plan: one for each node that has inputs, or one for each
    /// step where they switch.
    pub fn input_rows(&self) -> usize {
        if self.switches() { self.steps } else { self.scheme.input_rows(self.steps) }
    }

    /// Returns the time grid \[s\]: steps of equal length. A plan whose inputs switch has a grid of
    /// its own.
    ///
    /// # Panics
    /// Panics as [`Problem::seconds`] does.
    pub fn grid(&self) -> Grid {
        Grid::uniform(self.scheme, self.seconds(), self.steps)
    }

    /// Returns the step `h = T/N` \[s\].
    ///
    /// # Panics
    /// Panics as [`Problem::seconds`] does.
    pub fn step(&self) -> f64 {
        self.seconds() / self.steps as f64
    }

    /// Tangent dimension: 6 on SO(3), 12 on SE(3).
    pub fn dimension(&self) -> usize {
        match self.motion {
            Motion::Attitude => 6,
            Motion::RigidBody => 12,
        }
    }
}
