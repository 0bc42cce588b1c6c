//! Proofs that no plan exists: quantities that no input can change, and changes that limited inputs
//! cannot make in time.
//!
//! - `conserved`: momenta that no input changes, and that differ from the terminal conditions;
//! - cones that exclude every attitude at some moment ([`conflict`]);
//! - `storage`: momentum that the wheels must hold at the end and cannot;
//! - `impulse`: a change of momentum, or a distance, for which torque or force and time do not
//!   suffice;
//! - `demand`: an angle, or the path of a boresight, for which torque, rate and time do not
//!   suffice. The bounds of `envelope` hold for the discrete maneuver and for the continuous
//!   one: a claim is made if both are impossible;
//! - `full_wheels`: an angle or a path, as for `demand`, for which full wheels turn the body too
//!   slowly. It holds only for the continuous motion, so it is used only for plans that land.
//!
//! Some infeasible maneuvers have no such proof.
//!
//! # How far the proofs reach
//!
//! A proof compares one of these conserved quantities at both ends: the momentum about an axis of
//! symmetry without torque, the subspace of all momenta that inputs reach, the spatial momentum
//! about an axis without torque in the reference frame, and the translation along an axis without
//! force. Two torques can turn an asymmetric body to any attitude, so the rank of the linearisation
//! proves nothing. The arguments hold for free bodies; in a field they would have to hold for every
//! pose. The premises (a symmetry, an axis without torque, a start in the subspace) must hold to
//! 1e-14, because an unstable rotation amplifies an asymmetry of 1e-9 to a visible momentum
//! (`tests/laws/infeasible` has such maneuvers).
//!
//! Bounds on torque and time hold for the discrete maneuver, step by step, and for the continuous
//! one; the weaker bound is used. The argument with the kinetic energy, applied to the path of each
//! principal axis and boresight on the sphere (also around a cone), is sharper than the argument
//! with the momentum: over random bodies by 14 % in the median
//! (`cargo run --release -p evidence -- infeasible`). If each input is limited to about two thirds
//! of its unconstrained peak, even a bang-bang torque barely reaches the end. The corner of the box
//! of limits is then too weak a bound, and the result is `not_converged` with the shortest duration
//! that was found. This also applies to cones together with such limits: most of the slews that
//! `constrained_robustness` leaves unsolved are solved without their cones.

mod capability;
mod conserved;
mod demand;
mod detour;
mod envelope;
mod full_wheels;
mod impulse;
mod outputs;
mod storage;
mod sufficient;
mod words;

pub(crate) use capability::strongest;
pub(crate) use full_wheels::proof as of_motion;
pub(crate) use outputs::Outputs;
pub use sufficient::fixed_axis_duration;
pub(crate) use sufficient::sufficient;

use crate::maneuver::constraint::{Conflict, conflict};
use crate::maneuver::problem::Problem;
use std::fmt;

/// The proof that a maneuver is infeasible.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Proof {
    /// The reason in words, with the limits that do not suffice and, if known, limits that could
    /// suffice.
    pub reason: String,
    /// A duration \[s\] below which no plan exists with all other values unchanged; `None` if no
    /// bound is known.
    pub duration_lower_bound: Option<f64>,
}

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl From<String> for Proof {
    fn from(reason: String) -> Self {
        Self { reason, duration_lower_bound: None }
    }
}

/// Returns a proof that the maneuver is infeasible, both discretised and in continuous time; `None`
/// if nothing is proved. The problem must be one that [`Problem::check`] accepts.
pub fn proof(problem: &Problem) -> Option<Proof> {
    if problem.ends_in_any_attitude() {
        // The other proofs need a given end attitude.
        return exclusive_cones(problem)
            .map(Proof::from)
            .or_else(|| storage::storable(problem))
            .or_else(|| impulse::proof(problem));
    }
    let wheels = problem.actuation.wheels.is_some();
    let conserved = || if wheels { None } else { conserved::proof(problem) };
    (conserved().map(Proof::from))
        .or_else(|| exclusive_cones(problem).map(Proof::from))
        .or_else(|| storage::proof(problem))
        .or_else(|| impulse::proof(problem))
        .or_else(|| demand::proof(problem))
}

/// Returns a proof that the maneuver is infeasible in any duration; `None` if nothing is proved.
pub(crate) fn in_any_time(problem: &Problem) -> Option<Proof> {
    storage::storable(problem)
}

fn exclusive_cones(problem: &Problem) -> Option<String> {
    let frame_turn = problem.environment.frame_rate() * problem.seconds();
    let Conflict { names: [first, second], part, missing } = conflict(&problem.constraints, &frame_turn)?;
    Some(format!(
        "\"{first}\" and \"{second}\" allow no attitude at t = {} s: their cones miss each other by \
        {} deg; enlarge their half angles by this angle in total",
        words::about(part * problem.seconds()),
        words::at_least(missing.to_degrees())
    ))
}
