//! Propagation by the witnesses' own equations, reaction wheels included.
//!
//! A second method for the result of [`crate::propagate::simulate::Simulation`], in inertial axes
//! and with the implicit equation in its exponential form. It is the only method for a body with
//! wheels.

use super::continuous::Continuous;
use super::discrete::Discrete;
use super::motion::{Phase, judgeable};
use super::verification::WitnessError;
use crate::maneuver::problem::{Problem, ProblemError, Scheme};
use crate::mechanics::environment::Pose;
use crate::propagate::integrator::Invariants;
use crate::propagate::plant::{Output, Plant};
use crate::propagate::row::{BodyState, Observer, SimulationRow};
use crate::{Matrix3, lie};

/// The method of a propagation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Propagator {
    /// Lie–Verlet: second order, symplectic, no drift of energy or momentum. Default.
    #[default]
    LieVerlet,
    /// Verner 9(8) at tolerance 1e-14, restarted at every step: exact to round-off, about ten times
    /// slower.
    Verner98,
    /// The method of the continuous witness: the motion of a free body as a Taylor series to
    /// round-off, as fast as the discrete one, and Verner's pair if forces or moments depend on
    /// the pose.
    Continuous,
}

/// A propagation over the duration of its problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Propagation<'a> {
    /// The method.
    pub propagator: Propagator,
    /// Number of steps, at least 1; independent of the problem's. Default 1000.
    pub steps: u64,
    /// The number of steps for each row; the start and the end always have a row. Default 1.
    pub stride: u64,
    /// Inputs held throughout, one row in the order of the crate's plans; none: no actuation.
    /// Default.
    pub inputs: Option<&'a [f64]>,
}

impl Default for Propagation<'_> {
    fn default() -> Self {
        Self { propagator: Propagator::LieVerlet, steps: 1000, stride: 1, inputs: None }
    }
}

/// Propagates the start of `problem` and passes rows to `observer`. Returns true at the end, and
/// false if the observer stops.
///
/// Nothing is kept: memory does not grow with the steps. The end state of the problem, its scheme
/// and its own number of steps play no part. The momenta of the rows count the wheels', the energy
/// does not.
///
/// # Errors
/// A [`WitnessError`] when the problem is unusable or the motion cannot be propagated further; rows
/// up to there have been handed out.
pub fn propagate(
    problem: &Problem,
    settings: &Propagation,
    observer: &mut impl Observer,
) -> Result<bool, WitnessError> {
    match problem.check_numbers() {
        // This error is about the problem's own steps. The propagator reports it for the steps of
        // this function.
        Ok(()) | Err(ProblemError::StepTooLong { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    let plant = judgeable(problem)?;
    let output = match settings.inputs {
        Some(inputs) if inputs.len() != problem.actuation.count() => {
            let expected = problem.actuation.count();
            return Err(WitnessError::Rows { what: "inputs in a row", found: inputs.len(), expected });
        }
        Some(inputs) => Output::of(problem, inputs),
        None => Output::none(),
    };
    let (steps, stride) = (settings.steps.max(1), settings.stride.max(1));
    let duration = problem.seconds();
    let step = duration / steps as f64;
    let start = Phase::of(problem, &problem.start);
    let mut body = match settings.propagator {
        Propagator::LieVerlet => {
            Carrier::Discrete(Box::new(Discrete::new(&plant, &start, Scheme::LieVerlet, step)))
        }
        Propagator::Verner98 => Carrier::Continuous(Box::new(Continuous::adaptive(&plant, &start))),
        Propagator::Continuous => Carrier::Continuous(Box::new(Continuous::new(&plant, &start))),
    };
    let mut quaternion = lie::quaternion_from_rotation(&start.attitude);
    let mut told_to_stop = false;
    for k in 0..=steps {
        let time = if k == steps { duration } else { k as f64 * step };
        let phase = match &body {
            Carrier::Discrete(body) => body.phase(),
            Carrier::Continuous(body) => body.phase(time),
        };
        if !phase.is_finite() {
            return Err(WitnessError::NotFinite { time });
        }
        quaternion = lie::continued(Some(&quaternion), lie::quaternion_from_rotation(&phase.attitude));
        let due = k % stride == 0 || k == steps || told_to_stop;
        if due {
            let row = row(&plant, time, quaternion, &phase);
            // The start is as it was given.
            if k > 0 && !row.is_finite() {
                return Err(WitnessError::NotFinite { time });
            }
            if observer.on_row(&row).is_break() || told_to_stop {
                return Ok(k == steps);
            }
        }
        if k < steps {
            match &mut body {
                Carrier::Discrete(body) => body.advance(&output, &output)?,
                Carrier::Continuous(body) => body.advance(time, step, &output, &output)?,
            }
            told_to_stop = observer.on_step(k + 1).is_break();
        }
    }
    Ok(true)
}

enum Carrier<'a> {
    Discrete(Box<Discrete<'a>>),
    Continuous(Box<Continuous<'a>>),
}

fn row(plant: &Plant, time: f64, quaternion: [f64; 4], phase: &Phase) -> SimulationRow {
    let problem = plant.problem;
    let (rate, velocity) = (phase.angular_velocity(problem), phase.velocity(problem));
    let spin = phase.attitude * phase.momentum;
    let pose = Pose { position: phase.position, attitude: phase.attitude };
    let potential = problem.environment.potential(&pose);
    let momentum = spin + phase.attitude * phase.stored + phase.position.cross(&phase.linear_momentum);
    let inertial = plant.to_reference(time).map_or_else(Matrix3::identity, |frame| frame.transpose());
    SimulationRow {
        time,
        bodies: vec![BodyState {
            quaternion,
            angular_velocity: rate,
            position: phase.position,
            velocity,
            stored_momentum: phase.stored,
        }],
        invariants: Invariants {
            energy: 0.5 * (phase.momentum.dot(&rate) + phase.linear_momentum.dot(&velocity)) + potential
                - plant.frame_rate().dot(&spin),
            linear_momentum: inertial * phase.linear_momentum,
            angular_momentum: inertial * momentum,
            orthogonality: lie::orthogonality(&phase.attitude),
        },
    }
}
