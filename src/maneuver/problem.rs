//! The maneuver to plan: a plain value in SI units, checked by [`Problem::check`] where it is solved.

mod check;
mod formulation;
mod plane;
mod unsuited;

pub use crate::maneuver::grid::Scheme;
pub use formulation::{Formulation, Stepping};
pub use unsuited::Unsuited;

use crate::lie::Rotation;
use crate::maneuver::aim::{Aim, AimError, Ends, Meeting};
use crate::maneuver::constraint::{
    Alternatives, AlternativesError, Constraint, ConstraintError, Rule, Turns,
};
use crate::maneuver::duration::Duration;
use crate::maneuver::grid::Grid;
use crate::maneuver::objective::{Fuel, Objective, WeightError};
use crate::maneuver::reserve::Reserve;
use crate::maneuver::settings::Method;
use crate::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use crate::mechanics::body::Body;
use crate::mechanics::environment::{Environment, Free};
use crate::{Matrix3, Vector3};
use std::sync::Arc;
use thiserror::Error;

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
    /// A state on SO(3): a rotation of nalgebra or a matrix, and the inertial angular velocity `Ω`, body axes [rad/s].
    pub fn attitude(attitude: impl Into<Rotation>, angular_velocity: Vector3) -> Self {
        let rotation: Rotation = attitude.into();
        let still = Vector3::zeros();
        Self { position: still, velocity: still, attitude: *rotation.matrix(), angular_velocity }
    }

    /// At rest in `attitude`, on SO(3).
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

/// What moves: the attitude alone, or position and attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Attitude only, SO(3), tangent dimension 6.
    Attitude,
    /// Position and attitude, SE(3), tangent dimension 12.
    RigidBody,
}

/// Which way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// Solve every sense and winding, keep the lowest cost.
    Best,
    /// The rotation sense of the shorter way, counted from the ballistic end point; of this sense the lowest cost that is found.
    Shortest,
    /// The other sense.
    Long,
    /// The rotation from the start as written: a rotation vector in the body axes of the start \[rad\],
    /// any angle. In least time and fuel that tells how many whole turns are made, about whatever axes are the cheapest.
    AsGiven(Vector3),
}

/// What is given of the end; the rest is the plan's to choose, by transversality.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EndCondition {
    /// Attitude and angular velocity, and of a body that moves position and velocity.
    #[default]
    State,
    /// All but the attitude: a body is to come to rest, or to a rate in body axes, in any attitude (detumbling).
    AnyAttitude,
    /// A body axis points at a target, which may move; the roll about it may be free.
    Aim(Aim),
    /// The state that [`Problem::end`] is, moved on to where a target is when the plan arrives: what the search for ends on targets asks
    /// for.
    #[doc(hidden)]
    Met(Meeting),
}

/// A maneuver: who moves, where from, where to, in what time, on which grid.
///
/// Built by [`Problem::attitude`] or [`Problem::rigid_body`] and the `with_` methods, checked by
/// [`Problem::check`], which the solvers call. What is minimised is its [`Objective`], by default the effort
/// `∫ ½ uᵀu dt`.
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
    /// What is planned, for people.
    pub name: String,
    /// Attitude only, or position and attitude.
    pub motion: Motion,
    /// The body.
    pub body: Body,
    /// What acts on it.
    pub environment: Arc<dyn Environment>,
    /// Its actuators.
    pub actuation: Actuation,
    /// What is minimised.
    pub objective: Objective,
    /// State at `t = 0`.
    pub start: State,
    /// State at `t = T`. An attitude that is not given ([`Problem::end_condition`]) is a guess until a plan has found it.
    pub end: State,
    /// What is given of the end.
    pub end_condition: EndCondition,
    /// Duration `T`: given, or the plan's to choose.
    pub duration: Duration,
    /// Number of steps `N`; the step is `h = T/N`.
    pub steps: usize,
    /// Whether a plan that lands may take more steps where it needs them: until they are given ([`Problem::with_steps`]).
    pub chooses_steps: bool,
    /// The discretisation.
    pub scheme: Scheme,
    /// Which steps a plan of minimum time or fuel is to have ([`Formulation`]).
    #[doc(hidden)]
    pub stepping: Stepping,
    /// Which way round.
    pub path: Path,
    /// Where the body may point and how fast it may turn.
    pub constraints: Vec<Constraint>,
    /// Sets of these constraints that hold in turns; what is in no set holds at all times.
    pub alternatives: Vec<Alternatives>,
    /// What the plan leaves of limits to who flies it.
    pub reserve: Reserve,
}

/// Why a maneuver cannot be planned as it stands.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProblemError {
    /// A number is NaN, infinite or out of range.
    #[error("{what} is {value}: {reason}")]
    Value {
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        reason: &'static str,
    },
    /// An attitude is not a rotation.
    #[error("the {end} attitude is not a rotation matrix: residual {residual:.1e}")]
    NotRotation {
        /// "start" or "end".
        end: &'static str,
        /// `max |RᵀR − I|`, or 2 for a reflection.
        residual: f64,
    },
    /// A boundary rate is too fast for the step: `h |J⁻¹Π| ≥ 1`.
    #[error(
        "the {end} rate turns {angle:.3} rad in one step, the implicit equation needs less than {limit}: raise the steps to at least {steps}"
    )]
    StepTooLong {
        /// "start" or "end".
        end: &'static str,
        /// `h |Ω|` \[rad\].
        angle: f64,
        /// The bound.
        limit: f64,
        /// The number of steps that would do.
        steps: usize,
    },
    /// Something that the motion needs is absent.
    #[error("{0}")]
    Missing(&'static str),
    /// A constraint cannot be used.
    #[error("constraint \"{name}\": {error}")]
    Constraint {
        /// Its name.
        name: String,
        /// Why not.
        error: ConstraintError,
    },
    /// The start or the end violates a constraint: no plan can hold it.
    #[error("the {end} violates \"{name}\": {found}")]
    Violated {
        /// "start" or "end".
        end: &'static str,
        /// Name of the constraint.
        name: String,
        /// The value and the limit, in words.
        found: String,
    },
    /// Alternatives cannot be used.
    #[error("\"{name}\": {error}")]
    Alternatives {
        /// Their name.
        name: String,
        /// Why not.
        error: AlternativesError,
    },
    /// Wheels and torque inputs do not fit together.
    #[error("{0}")]
    Wheels(String),
    /// What is minimised does not go with what the maneuver has, or lacks.
    #[error(transparent)]
    Unsuited(#[from] Unsuited),
    /// The end is on a target, and that cannot be used.
    #[error("the end: {0}")]
    Aim(#[from] AimError),
    /// A weight of the objective does not fit the inputs.
    #[error("{inputs} inputs: {error}")]
    Weight {
        /// "torque" or "force".
        inputs: &'static str,
        /// Why not.
        error: WeightError,
    },
}

impl Problem {
    /// The fewest steps.
    pub const MIN_STEPS: usize = 2;
    /// The most steps.
    pub const MAX_STEPS: usize = 1_000_000;
    /// The most constraints.
    pub const MAX_CONSTRAINTS: usize = 1_000;

    /// An attitude maneuver of a free body with three body torques of unit weight, in `duration` \[s\] or one that is
    /// sought ([`Duration::SOUGHT`]), 100 steps of the second-order scheme or as many as landing needs, every way round.
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

    /// A maneuver of position and attitude, with three forces of unit weight along the reference axes added. The body
    /// needs a mass.
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

    /// Replaces what is minimised: an [`Objective`], or the [`Weights`](crate::Weights) of the effort.
    pub fn with_objective(mut self, objective: impl Into<Objective>) -> Self {
        self.objective = objective.into();
        self
    }

    /// Sets the number of steps, [`Problem::MIN_STEPS`] to [`Problem::MAX_STEPS`]: a plan takes neither more nor fewer.
    pub fn with_steps(mut self, steps: usize) -> Self {
        (self.steps, self.chooses_steps) = (steps, false);
        self
    }

    /// Chooses the discretisation.
    pub fn with_scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// The maneuver under the limits of the craft: nothing is held in reserve, and cones have no margins.
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

    /// The maneuver with the sets of alternatives acting in their shifts alone.
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

    /// Leaves the attitude at the end to the plan: detumbling.
    ///
    /// ```
    /// use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Vector3, plan};
    ///
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0))?, mass: None };
    /// let start = State::attitude(Matrix3::identity(), Vector3::new(0.3, -0.2, 0.1));
    /// let rest = State::at_rest(Matrix3::identity());
    /// let detumbling = Problem::attitude(body, start, rest, 20.0).with_any_attitude_at_end();
    /// let plan = plan(&detumbling, &Settings::default(), None, &mut Silent)?;
    /// // With equal weights the torque brakes along the momentum: the effort is |Π|²/2T, whatever the inertia.
    /// let momentum = Vector3::new(0.3, -0.4, 0.3);
    /// assert!((plan.solution.cost / (momentum.norm_squared() / 40.0) - 1.0).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_any_attitude_at_end(self) -> Self {
        Self { end_condition: EndCondition::AnyAttitude, ..self }
    }

    /// Ends with a body axis on a target, in place of the attitude and the rate of [`Problem::end`].
    ///
    /// ```
    /// use slewkit::{Aim, Body, Direction, Inertia, Matrix3, Problem, Settings, Silent, State, Vector3, plan};
    ///
    /// let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 3.0))?, mass: None };
    /// let start = State::at_rest(Matrix3::identity());
    /// let star = Direction::Fixed(Vector3::new(1.0, 2.0, -1.0).normalize());
    /// let problem = Problem::attitude(body, start, start, 4.0).with_aim_at_end(Aim::new(Vector3::z(), star).at_rest());
    /// let plan = plan(&problem, &Settings::discrete(), None, &mut Silent)?;
    /// // The best of all rolls about the boresight, on 100 steps.
    /// assert!((plan.solution.cost - 0.47766).abs() < 5e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_aim_at_end(self, aim: Aim) -> Self {
        Self { end_condition: EndCondition::Aim(aim), ..self }
    }

    /// The target on which it ends, where it ends on one.
    pub fn aim(&self) -> Option<&Aim> {
        match &self.end_condition {
            EndCondition::Aim(aim) => Some(aim),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Met(_) => None,
        }
    }

    /// What it meets, where the state at the end moves on with the duration.
    pub(crate) fn met(&self) -> Option<&Meeting> {
        match &self.end_condition {
            EndCondition::Met(meeting) => Some(meeting),
            EndCondition::State | EndCondition::AnyAttitude | EndCondition::Aim(_) => None,
        }
    }

    /// The same to one of the ends on a target: that at a roll \[rad\].
    pub(crate) fn facing(&self, ends: &Ends, roll: f64) -> Self {
        let (attitude, angular_velocity) = ends.at(roll);
        let end = State { attitude, angular_velocity, ..self.end };
        Self { end, end_condition: EndCondition::State, ..self.clone() }
    }

    /// The same to a target where it is at `time` \[s\], at the roll nearest to that of an attitude; a plan that lands moves its end on to where the target is when
    /// it arrives. `slope` is how the time by which plans are late changes with the time.
    pub(crate) fn meeting(
        &self,
        aim: &Aim,
        attitude: &Matrix3,
        time: f64,
        slope: f64,
    ) -> Result<Self, AimError> {
        let ends = self.ends_on(aim, time)?;
        let facing = self.facing(&ends, ends.nearest(attitude));
        let meeting = Meeting { aim: aim.clone(), time, slope };
        Ok(Self { end_condition: EndCondition::Met(meeting), ..facing })
    }

    /// The ends on `aim` that it may have at `time` \[s\].
    pub(crate) fn ends_on(&self, aim: &Aim, time: f64) -> Result<Ends, AimError> {
        aim.ends(time, &self.start.attitude, &self.environment.frame_rate())
    }

    /// The end of a plan that takes `duration` \[s\]: where the target is then, of one that it meets.
    pub(crate) fn end_after(&self, duration: f64) -> State {
        let ends = self.met().and_then(|meeting| {
            let ends = self.ends_on(&meeting.aim, duration).ok()?;
            // The roll is kept in space: that against the shortest way there turns fast where the target is almost behind.
            Some(ends.at(ends.nearest(&self.end.attitude)))
        });
        let Some((attitude, angular_velocity)) = ends else { return self.end };
        State { attitude, angular_velocity, ..self.end }
    }

    /// Whether inputs switch, and are held over steps of unequal lengths: those of minimum time and fuel where nothing but
    /// limits of the torques shapes the plan.
    pub fn switches(&self) -> bool {
        Formulation::of(self) == Formulation::Switching
    }

    /// Whether the attitude at the end is the plan's to choose.
    pub fn ends_in_any_attitude(&self) -> bool {
        self.end_condition == EndCondition::AnyAttitude
    }

    /// Whether a plan of minimum time or fuel has its inputs at the nodes of equal steps, as those of effort do: where more than
    /// limits of the torques shapes it, or forces or what acts on the body, and where SCP is asked for.
    pub fn is_shaped(&self) -> bool {
        self.objective.switches() && !self.switches()
    }

    /// The maneuver as `method` plans it: by SCP and by the interior point on equal steps.
    #[doc(hidden)]
    pub fn planned_by(self, method: Method) -> Self {
        let stepping = if method.is_on_equal_steps() { Stepping::Equal } else { self.stepping };
        Self { stepping, ..self }
    }

    /// The maneuver as arcs plan it along which none of its constraints acts.
    #[doc(hidden)]
    pub fn planned_on_arcs(self) -> Self {
        Self { stepping: Stepping::Arcs, ..self }
    }

    /// Whether more time is never worse: from rest to rest where nothing acts on the body, it can wait.
    pub(crate) fn can_wait(&self) -> bool {
        let rests = |state: &State| {
            state.angular_velocity.norm() == 0.0
                && (self.motion == Motion::Attitude || state.velocity.norm() == 0.0)
        };
        let still = self.environment.frame_rate().amax() == 0.0;
        still && self.environment.is_free() && rests(&self.start) && rests(&self.end)
    }

    /// Whether the attitude alone is planned, of a body that nothing acts on but its torques.
    pub(crate) fn is_free_turn(&self) -> bool {
        let still = self.environment.frame_rate().amax() == 0.0;
        self.motion == Motion::Attitude && still && self.environment.is_free()
    }

    /// Whether it has more than limits of each torque, or of the norm of the torque: what the shooting does not take.
    pub(crate) fn has_shaping_limits(&self) -> bool {
        self.has_shaping_inputs() || !self.constraints.is_empty()
    }

    /// Whether limits of what the inputs do, or wheels, are more than arcs at the limits take.
    pub(crate) fn has_shaping_inputs(&self) -> bool {
        let limits = self.actuation.torque.limits();
        let jumping = limits.rate.is_none() && !(limits.size.is_some() && limits.norm.is_some());
        !jumping || self.actuation.wheels.is_some()
    }

    /// Whether anything limits inputs, rates or pointing.
    pub fn is_constrained(&self) -> bool {
        !self.constraints.is_empty() || self.actuation.is_limited()
    }

    /// A maneuver of minimum time: of a free body with three body torques of unit weight, which need limits.
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

    /// A maneuver of least fuel `∫ Σ |u_j| dt` in a given duration \[s\]: of a free body with three body torques, which
    /// need limits.
    pub fn minimum_fuel(body: Body, start: State, end: State, duration: impl Into<Duration>) -> Self {
        Self { objective: Objective::Fuel(Fuel::default()), ..Self::attitude(body, start, end, duration) }
    }

    /// Sets the duration: that in seconds, or [`Duration::SOUGHT`].
    pub fn with_duration(self, duration: impl Into<Duration>) -> Self {
        Self { duration: duration.into(), ..self }
    }

    /// In `duration` \[s\], which is found where it was sought.
    pub(crate) fn lasting(self, duration: f64) -> Self {
        Self { duration: self.duration.lasting(duration), ..self }
    }

    /// Asks for the best duration up to `longest` \[s\].
    ///
    /// From rest to rest more time is never worse, and the plan takes all of it; where the body moves at an end it may
    /// not.
    pub fn with_duration_at_most(self, longest: f64) -> Self {
        Self { duration: Duration::Sought { at_most: Some(longest) }, ..self }
    }

    /// The shortest pulse \[s\] where inputs are off or at a limit alone.
    pub fn shortest_pulse(&self) -> Option<f64> {
        self.actuation.torque.limits().shortest_pulse
    }

    /// Whether the duration is the plan's to choose, be it found already.
    pub fn seeks_duration(&self) -> bool {
        !matches!(self.duration, Duration::Given(_))
    }

    /// The duration `T` \[s\], given or found.
    ///
    /// # Panics
    /// While it is sought: solvers and witnesses work in a duration that is known ([`Problem::with_duration`]).
    pub fn seconds(&self) -> f64 {
        self.duration
            .known()
            .expect("a maneuver whose duration is sought has none before a plan has found it")
    }

    /// Rows of inputs of a plan: one for each node that has inputs, or one for each step where they switch.
    pub fn input_rows(&self) -> usize {
        if self.switches() { self.steps } else { self.scheme.input_rows(self.steps) }
    }

    /// The time grid \[s\]: steps of equal length. A plan whose inputs switch has a grid of its own.
    ///
    /// # Panics
    /// As [`Problem::seconds`].
    pub fn grid(&self) -> Grid {
        Grid::uniform(self.scheme, self.seconds(), self.steps)
    }

    /// Step `h = T/N` \[s\].
    ///
    /// # Panics
    /// As [`Problem::seconds`].
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
