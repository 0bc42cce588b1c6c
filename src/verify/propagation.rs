//! Propagation by the equations of the witnesses, including reaction wheels.
//!
//! This is a second method for the result of [`crate::propagate::simulate::Simulation`]. It uses
//! inertial axes and the exponential form of the implicit equation. It is the only method for a
//! body with wheels.

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

/// The numerical method of a propagation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Propagator {
    /// Lie–Verlet: second order, symplectic, without drift of energy or momentum. This is the
    /// default.
    #[default]
    LieVerlet,
    /// Verner 9(8) with tolerance 1e-14, restarted at every step: accurate to round-off, about ten
    /// times slower than Lie–Verlet.
    Verner98,
    /// The method of the continuous witness. A free body is propagated by a Taylor series to
    /// round-off, as fast as by Lie–Verlet. Verner's pair is used if forces or moments depend on
    /// the pose.
    Continuous,
}

/// A propagation over the duration of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Propagation<'a> {
    /// The numerical method.
    pub propagator: Propagator,
    /// Number of steps, at least 1; independent of the steps of the problem. Default: 1000.
    pub steps: u64,
    /// Number of steps between two rows; the start and the end always have a row. Default: 1.
    pub stride: u64,
    /// Constant inputs for the whole motion: one input row, with its components in the same order
    /// as in a plan (forces before torques). `None`, the default, means no actuation.
    pub inputs: Option<&'a [f64]>,
}

impl Default for Propagation<'_> {
    fn default() -> Self {
        Self { propagator: Propagator::LieVerlet, steps: 1000, stride: 1, inputs: None }
    }
}

/// Propagates from the start of `problem` and passes rows to `observer`. Returns true at the end,
/// and false if the observer stops the propagation.
///
/// No rows are stored, so memory does not grow with the number of steps. The end state, the scheme
/// and the number of steps of the problem are not used. The momenta in the rows include the
/// momentum of the wheels; the energy does not include the wheels.
///
/// # Errors
/// A [`WitnessError`] if the problem is unusable or the motion cannot be propagated further. The
/// observer has received all earlier rows.
pub fn propagate(
    problem: &Problem,
    settings: &Propagation,
    observer: &mut impl Observer,
) -> Result<bool, WitnessError> {
    match problem.check_numbers() {
        // This error concerns the steps of the problem. The propagator reports it for its own
        // steps.
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
            // The row at the start contains the given start.
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
