//! Propagation without optimisation: a body from its start, under the field and constant inputs.
//!
//! ```
//! use slewkit::body::{Body, Inertia};
//! use slewkit::problem::{Problem, State};
//! use slewkit::simulate::{Simulation, simulate};
//! use slewkit::{Matrix3, Vector3};
//!
//! let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 2.0, 2.5))?, mass: None };
//! let start = State::attitude(Matrix3::identity(), Vector3::new(0.01, 1.0, 0.0));
//! let problem = Problem::attitude(body, start, State::at_rest(Matrix3::identity()), 20.0);
//! let (mut first, mut drift) = (None, 0.0_f64);
//! simulate(&problem, &Simulation { steps: 2000, stride: 100, ..Simulation::default() }, |row| {
//!     let first = *first.get_or_insert(row.momentum);
//!     drift = drift.max((row.momentum - first).norm());
//!     true
//! })?;
//! assert!(drift < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::Vector3;
use crate::environment::Pose;
use crate::lie;
use crate::problem::{Problem, ProblemError, Scheme};
use crate::verify::{Continuous, Discrete, Output, Phase, Plant, WitnessError, same_sign};

/// How to propagate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Propagator {
    /// Lie–Verlet: second order, symplectic, no drift of energy or momentum. Default.
    #[default]
    LieVerlet,
    /// Verner 9(8) at tolerance 1e-14, restarted at every step: exact to round-off, about ten times
    /// slower.
    Continuous,
}

/// Settings of a simulation over the duration of its problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulation<'a> {
    /// How to propagate.
    pub propagator: Propagator,
    /// Number of steps, at least 1; independent of the problem's. Default 1000.
    pub steps: u64,
    /// A row every so many steps; the start and the end always have one. Default 1.
    pub stride: u64,
    /// Inputs held throughout, one row in the order of the crate's plans; none: no actuation. Default.
    pub inputs: Option<&'a [f64]>,
}

impl Default for Simulation<'_> {
    fn default() -> Self {
        Self { propagator: Propagator::LieVerlet, steps: 1000, stride: 1, inputs: None }
    }
}

/// One moment of the motion, SI units, frames as in the crate's conventions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time \[s\].
    pub time: f64,
    /// Attitude quaternion `[w, x, y, z]`, continuous along the motion.
    pub quaternion: [f64; 4],
    /// Angular velocity, body axes [rad/s].
    pub angular_velocity: Vector3,
    /// Position, reference frame \[m\]; zero on SO(3).
    pub position: Vector3,
    /// Velocity, reference frame [m/s]; zero on SO(3).
    pub velocity: Vector3,
    /// Momentum that the wheels store, body axes [N·m·s]; zero without wheels.
    pub stored_momentum: Vector3,
    /// Kinetic plus potential energy of the body \[J\], without the spin of wheels. In a turning frame minus `n · RΠ`: Jacobi's integral, which
    /// is what a field fixed in that frame conserves.
    pub energy: f64,
    /// Angular momentum `R(Π + μ) + x × γ` about the origin, inertial axes [N·m·s].
    pub momentum: Vector3,
}

/// Propagates the start of `problem` and hands rows to `sink` until the end or until it returns false.
///
/// Nothing is kept: memory does not grow with the steps. The end state of the problem, its scheme and
/// its own number of steps play no part.
///
/// # Errors
/// A [`WitnessError`] when the problem is unusable or the motion cannot be propagated further; rows up
/// to there have been handed out.
pub fn simulate(
    problem: &Problem,
    settings: &Simulation,
    mut sink: impl FnMut(&Row) -> bool,
) -> Result<(), WitnessError> {
    match problem.check_numbers() {
        // That is about the problem's own steps, and the propagator will say it of ours.
        Ok(()) | Err(ProblemError::StepTooLong { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    let plant = Plant::new(problem).judgeable()?;
    let output = match settings.inputs {
        Some(inputs) if inputs.len() != problem.actuation.count() => {
            let expected = problem.actuation.count();
            return Err(WitnessError::Rows { what: "inputs in a row", found: inputs.len(), expected });
        }
        Some(inputs) => Output::of(problem, inputs),
        None => Output::none(),
    };
    let (steps, stride) = (settings.steps.max(1), settings.stride.max(1));
    let step = problem.duration / steps as f64;
    let start = Phase::of(problem, &problem.start);
    let mut body = match settings.propagator {
        Propagator::LieVerlet => {
            Carrier::Discrete(Box::new(Discrete::new(&plant, &start, Scheme::LieVerlet, step)))
        }
        Propagator::Continuous => Carrier::Continuous(Continuous::new(&plant, &start)),
    };
    let mut quaternion = lie::quaternion_from_rotation(&start.attitude);
    for k in 0..=steps {
        let time = if k == steps { problem.duration } else { k as f64 * step };
        let phase = match &body {
            Carrier::Discrete(body) => body.phase(),
            Carrier::Continuous(body) => body.phase(time),
        };
        if !phase.is_finite() {
            return Err(WitnessError::NotFinite { time });
        }
        quaternion = same_sign(lie::quaternion_from_rotation(&phase.attitude), &quaternion);
        if (k % stride == 0 || k == steps) && !sink(&row(&plant, time, quaternion, &phase)) {
            return Ok(());
        }
        if k < steps {
            match &mut body {
                Carrier::Discrete(body) => body.advance(&output, &output)?,
                Carrier::Continuous(body) => body.advance(time, step, &output, &output)?,
            }
        }
    }
    Ok(())
}

enum Carrier<'a> {
    Discrete(Box<Discrete<'a>>),
    Continuous(Continuous<'a>),
}

fn row(plant: &Plant, time: f64, quaternion: [f64; 4], phase: &Phase) -> Row {
    let problem = plant.problem;
    let (rate, velocity) = (phase.angular_velocity(problem), phase.velocity(problem));
    let spin = phase.attitude * phase.momentum;
    let pose = Pose { position: phase.position, attitude: phase.attitude };
    let potential = problem.environment.potential(&pose);
    let momentum = spin + phase.attitude * phase.stored + phase.position.cross(&phase.linear_momentum);
    Row {
        time,
        quaternion,
        angular_velocity: rate,
        position: phase.position,
        velocity,
        stored_momentum: phase.stored,
        energy: 0.5 * (phase.momentum.dot(&rate) + phase.linear_momentum.dot(&velocity)) + potential
            - plant.frame_rate().dot(&spin),
        momentum: plant.to_reference(time).map_or(momentum, |frame| frame.tr_mul(&momentum)),
    }
}
