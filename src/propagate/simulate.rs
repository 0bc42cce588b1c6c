//! Propagation without optimisation: one or many rigid bodies, propagated from their start with one
//! row of output after another.
//!
//! ```
//! use slewkit::propagate::integrator::{Kind, System};
//! use slewkit::propagate::simulate::SimulationRow;
//! use slewkit::{Body, Inertia, Matrix3, Simulation, State, Vector3};
//! use std::ops::ControlFlow;
//!
//! let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5))?, mass: None };
//! let system = System::new(vec![body], None)?;
//! let start = system.state(&[State::attitude(Matrix3::identity(), Vector3::new(0.01, 1.0, 0.0))])?;
//! let simulation = Simulation { stride: 100, ..Simulation::new(system, start, Kind::LieVerlet, 20.0, 2000) };
//! let (mut first, mut drift) = (None, 0.0_f64);
//! simulation.run(&mut |row: &SimulationRow| {
//!     let first = *first.get_or_insert(row.invariants.angular_momentum);
//!     drift = drift.max((row.invariants.angular_momentum - first).norm());
//!     ControlFlow::Continue(())
//! })?;
//! assert!(drift < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Simulation::of`] builds a simulation from a maneuver. Simulations do not support reaction
//! wheels; the discrete and the continuous witness can propagate them.

pub use super::row::{BodyState, Observer, SimulationRow};

use crate::maneuver::problem::{Motion, Problem, ProblemError};
use crate::numerics::figures;
use crate::propagate::integrator::{
    ErrorControl, Facts, Kind, StepError, System, SystemError, SystemState, Work,
};
use crate::propagate::plant::{HeldLoad, Output};
use crate::{Vector3, lie};
use std::sync::Arc;
use std::time::{Duration, Instant};
use thiserror::Error;

/// The bodies, their start, the method and the duration of a simulation.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// The name of the simulation.
    pub name: String,
    /// The names of the bodies, in the order of the system.
    pub bodies: Vec<String>,
    /// The bodies and the forces on them.
    pub system: System,
    /// State of all bodies at `t = 0`.
    pub start: SystemState,
    /// The integration method.
    pub kind: Kind,
    /// The tolerance of methods that choose their own step.
    pub settings: ErrorControl,
    /// Duration `T` \[s\].
    pub duration: f64,
    /// Number of steps `N`, at least 1; the step is `h = T/N`.
    pub steps: u64,
    /// Number of steps between two rows; the start and the end always have a row.
    pub stride: u64,
    /// Radius of each body: the largest distance of its points from its mass centre \[m\], in the
    /// order of the system. Empty if unknown.
    pub reach: Vec<f64>,
}

/// An encounter of two bodies: their distance is less than the sum of their [`Simulation::reach`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Encounter {
    /// Time of the encounter \[s\].
    pub time: f64,
    /// Indices of the two bodies, from 0.
    pub bodies: [usize; 2],
    /// Distance of their mass centres \[m\].
    pub distance: f64,
}

/// The result of running a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// Whether the run reached its end; false if the observer ended it.
    pub finished: bool,
    /// The theoretical properties of the method.
    pub facts: Facts,
    /// The work that the steps required.
    pub work: Work,
    /// The computing time of the steps, excluding the observer.
    pub stepping: Duration,
    /// The first step after which two bodies were within [`Simulation::reach`] of one another.
    /// Pairs that are within reach at the start are not considered.
    pub encounter: Option<Encounter>,
}

/// The reason why a simulation cannot start or cannot reach its end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SimulationError {
    /// The system, the state or the settings are invalid, or do not fit each other.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The maneuver is invalid.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The number of inputs differs from the number of actuators, or an input is not finite.
    #[error("{found} inputs are given, and the maneuver has {expected}; each must be finite")]
    Inputs {
        /// The number of inputs given.
        found: usize,
        /// The number of inputs of the maneuver.
        expected: usize,
    },
    /// The integrators do not support reaction wheels.
    #[error(
        "the integrators do not support reaction wheels; propagate the maneuver by `verify::propagation`"
    )]
    Wheels,
    /// The duration of the maneuver is free, so the length of its motion is unknown.
    #[error("the duration of the maneuver is free, so the length of its motion is unknown")]
    Sought,
    /// Duration, number of steps or stride is not positive.
    #[error("duration, steps and stride must be positive, and the duration finite")]
    Grid,
    /// A step failed; the observer has received the rows before it.
    #[error("at t = {} s: {error}", figures::rounded(*time, 9))]
    Step {
        /// Start of the step \[s\].
        time: f64,
        /// The reason why the step failed.
        error: StepError,
    },
}

impl Simulation {
    /// Builds a simulation with a row for each step and bodies named "body 1", "body 2", ….
    pub fn new(system: System, start: SystemState, kind: Kind, duration: f64, steps: u64) -> Self {
        let bodies = (1..=system.bodies().len()).map(|number| format!("body {number}")).collect();
        Self {
            name: "simulation".into(),
            bodies,
            system,
            start,
            kind,
            settings: ErrorControl::default(),
            duration,
            steps,
            stride: 1,
            reach: Vec::new(),
        }
    }

    /// Builds the simulation of a maneuver's body from the maneuver's start, over its duration and
    /// in its number of steps. `inputs` is one input row with its components in the same order as
    /// in a plan, forces before torques. It is constant over the whole motion; `None` means no
    /// actuation. The end of the maneuver is not used.
    ///
    /// # Errors
    /// A [`SimulationError`], also if the maneuver has reaction wheels.
    pub fn of(problem: &Problem, inputs: Option<&[f64]>) -> Result<Self, SimulationError> {
        match problem.check_numbers() {
            // This error concerns the steps of the planner. The method reports it for the steps of
            // the simulation.
            Ok(()) | Err(ProblemError::StepTooLong { .. }) => {}
            Err(error) => return Err(error.into()),
        }
        if problem.actuation.wheels.is_some() {
            return Err(SimulationError::Wheels);
        }
        let Some(duration) = problem.duration.known() else { return Err(SimulationError::Sought) };
        let mut body = problem.body.clone();
        body.mass = body.mass.filter(|_| problem.motion == Motion::RigidBody);
        let environment = Arc::clone(&problem.environment);
        if let Some(inputs) = inputs {
            let (found, expected) = (inputs.len(), problem.actuation.count());
            if found != expected || !inputs.iter().all(|input| input.is_finite()) {
                return Err(SimulationError::Inputs { found, expected });
            }
        }
        let acting = inputs.filter(|inputs| inputs.iter().any(|input| input.abs() > 0.0));
        let system = match acting {
            None => System::single(body, environment)?,
            Some(inputs) => {
                let frame_rate = environment.frame_rate();
                System::turning(
                    vec![body],
                    Some(Arc::new(HeldLoad::new(problem, Output::of(problem, inputs)))),
                    frame_rate,
                )?
            }
        };
        let start = system.state(&[problem.start])?;
        let mut simulation = Self::new(system, start, Kind::LieVerlet, duration, problem.steps as u64);
        simulation.name.clone_from(&problem.name);
        Ok(simulation)
    }

    /// Returns the step `h = T/N` \[s\].
    pub fn step(&self) -> f64 {
        self.duration / self.steps as f64
    }

    /// Propagates the bodies and passes rows to `observer`, until the end or until the observer
    /// stops.
    ///
    /// No rows are stored, so memory does not grow with the number of steps.
    ///
    /// # Errors
    /// A [`SimulationError`]. The observer has received all earlier rows.
    pub fn run(&self, observer: &mut impl Observer) -> Result<Run, SimulationError> {
        let positive = self.duration > 0.0 && self.duration.is_finite();
        if !positive || self.steps == 0 || self.stride == 0 {
            return Err(SimulationError::Grid);
        }
        let mut method = self.kind.start(&self.system, &self.start, self.step(), &self.settings)?;
        let mut row = self.row(0.0, method.state());
        self.finite(&row, 0)?;
        let mut stepping = Duration::ZERO;
        let mut finished = observer.on_row(&row).is_continue();
        let mut made = 0;
        let apart = self.apart();
        let mut encounter = None;
        while finished && made < self.steps {
            let next = (made + self.stride).min(self.steps);
            let began = Instant::now();
            while finished && made < next {
                let time = self.time(made);
                method.step(&[]).map_err(|error| SimulationError::Step { time, error })?;
                made += 1;
                encounter = encounter.or_else(|| self.meeting(&apart, made, method.state()));
                // Signs are continued in every step, because a turn of more than 180° between rows
                // would lose them.
                for (body, pose) in row.bodies.iter_mut().zip(method.state().poses()) {
                    let quaternion = lie::quaternion_from_rotation(&pose.attitude);
                    body.quaternion = lie::continued(Some(&body.quaternion), quaternion);
                }
                finished = observer.on_step(made).is_continue();
            }
            stepping += began.elapsed();
            self.fill(&mut row, self.time(made), method.state());
            self.finite(&row, made)?;
            finished &= observer.on_row(&row).is_continue();
            finished |= made == self.steps;
        }
        Ok(Run { finished, facts: method.facts(), work: method.work(), stepping, encounter })
    }

    /// Checks that a row is finite before it is output. Near the limits of a method the energy can
    /// overflow although the state is finite.
    fn finite(&self, row: &SimulationRow, made: u64) -> Result<(), SimulationError> {
        let time = self.time(made.saturating_sub(1));
        if row.is_finite() {
            Ok(())
        } else {
            Err(SimulationError::Step { time, error: StepError::NotFinite })
        }
    }

    /// Returns the pairs of bodies that are not in contact at the start, each with the square of
    /// the sum of their reaches.
    fn apart(&self) -> Vec<([usize; 2], f64)> {
        let poses = self.start.poses();
        let pairs = (0..self.reach.len()).flat_map(|second| (0..second).map(move |first| [first, second]));
        let with_reach =
            pairs.map(|pair| (pair, pair.map(|body| self.reach[body]).iter().sum::<f64>().powi(2)));
        let distance = |[a, b]: [usize; 2]| (poses[a].position - poses[b].position).norm_squared();
        with_reach.filter(|(pair, reach)| *reach > 0.0 && distance(*pair) >= *reach).collect()
    }

    /// Returns the first encounter among `pairs`; `None` if no pair is within reach.
    fn meeting(&self, pairs: &[([usize; 2], f64)], made: u64, state: &SystemState) -> Option<Encounter> {
        let poses = state.poses();
        let distance = |[a, b]: [usize; 2]| (poses[a].position - poses[b].position).norm_squared();
        let (bodies, _) = pairs.iter().find(|(pair, reach)| distance(*pair) < *reach)?;
        Some(Encounter { time: self.time(made), bodies: *bodies, distance: distance(*bodies).sqrt() })
    }

    /// Builds the row of a state. The signs of its quaternions are not continued from earlier rows.
    pub fn row(&self, time: f64, state: &SystemState) -> SimulationRow {
        let body = |pose: &crate::mechanics::environment::Pose| BodyState {
            quaternion: lie::quaternion_from_rotation(&pose.attitude),
            angular_velocity: Vector3::zeros(),
            position: pose.position,
            velocity: Vector3::zeros(),
            stored_momentum: Vector3::zeros(),
        };
        let bodies = state.poses().iter().map(body).collect();
        let mut row = SimulationRow { time, bodies, invariants: self.system.invariants(state) };
        self.fill(&mut row, time, state);
        row
    }

    fn time(&self, steps: u64) -> f64 {
        if steps == self.steps { self.duration } else { steps as f64 * self.step() }
    }

    /// Sets all fields of a row except the quaternions.
    fn fill(&self, row: &mut SimulationRow, time: f64, state: &SystemState) {
        row.time = time;
        row.invariants = self.system.invariants(state);
        let rate = self.system.frame_rate();
        if rate != Vector3::zeros() {
            let frame = lie::exp(&(time * rate));
            row.invariants.linear_momentum = frame * row.invariants.linear_momentum;
            row.invariants.angular_momentum = frame * row.invariants.angular_momentum;
        }
        let states = state.poses().iter().zip(state.momenta());
        for ((row, body), (pose, momentum)) in row.bodies.iter_mut().zip(self.system.bodies()).zip(states) {
            row.position = pose.position;
            row.velocity = body.mass.map_or_else(Vector3::zeros, |mass| momentum.linear / mass);
            // One step of iterative refinement, because the plain product has a relative error of
            // ε·cond(J).
            let (j, inverse) = (body.inertia.j(), body.inertia.j_inverse());
            let rate = inverse * momentum.angular;
            row.angular_velocity = rate + inverse * (momentum.angular - j * rate);
        }
    }
}
