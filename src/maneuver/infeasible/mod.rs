//! Proofs that no plan exists: what no input can change, and what limited inputs cannot do in time.
//!
//! - `conserved`: momenta that no input changes, at odds with the terminal conditions;
//! - cones that leave no attitude at some moment ([`conflict`]);
//! - `storage`: momentum that the wheels must hold in the end and cannot;
//! - `impulse`: momentum to gain, or a distance to go, for which torque or force and time do not suffice;
//! - `demand`: an angle to turn by, or the way of a boresight, for which they do not. The bounds are those of `envelope`, for the discrete maneuver as it is planned and for the
//!   continuous one alike: a claim is made where both are impossible.
//!
//! A maneuver for which nothing is proved may be infeasible all the same.
//!
//! # How far the proofs reach
//!
//! Conserved quantities that differ at the two ends are the momentum about an axis of symmetry without torque, the subspace
//! that holds all momenta that inputs reach, the spatial momentum about an axis that torques in the reference frame leave
//! alone, the translation along an axis without force. Two torques steer an asymmetric body anywhere, so the rank of the
//! linearisation proves nothing. The arguments are for free bodies: in a field they would have to hold for every pose. The
//! premises (a symmetry, an axis without torque, a start in the subspace) must hold to 1e-14, because an unstable rotation
//! makes a visible momentum of an asymmetry of 1e-9 (`tests/it/infeasible` has such maneuvers).
//!
//! Bounds of torque and time are those of the discrete maneuver, step by step, and of the continuous one, whichever allows
//! more. The argument with the kinetic energy, and for the way of each principal axis and boresight on the sphere (also
//! around a cone), is sharper than that with the momentum: over random bodies by 14 % in the median (`cargo run --release -p
//! evidence --bin infeasible`). Under limits of each input near two thirds of the unconstrained peak, where even a bang-bang
//! torque hardly reaches the end, the corner of the box is too weak a bound, and the answer is `not_converged` with the
//! shortest duration that was found. With cones beside such limits the same holds: of the slews that `constrained_robustness`
//! leaves unsolved most are solved when their cones are left out.

mod capability;
mod conserved;
mod demand;
mod detour;
mod envelope;
mod impulse;
mod outputs;
mod storage;
mod words;

pub(crate) use capability::strongest;

use crate::maneuver::constraint::{Conflict, conflict};
use crate::maneuver::problem::Problem;
use std::fmt;

/// Why a maneuver is infeasible.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Proof {
    /// The reason in words, with the figures that miss and, where they are known, those that could do.
    pub reason: String,
    /// A duration \[s\] below which there is no plan, all else being equal; `None` where none is known.
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

/// A proof that the maneuver is infeasible, as it is discretised and in continuous time; `None` where
/// nothing is proved. The problem must be one that [`Problem::check`] accepts.
pub fn proof(problem: &Problem) -> Option<Proof> {
    if problem.ends_in_any_attitude() {
        // What the others prove, they prove of one attitude.
        return exclusive_cones(problem).map(Proof::from).or_else(|| impulse::proof(problem));
    }
    let wheels = problem.actuation.wheels.is_some();
    let conserved = || if wheels { None } else { conserved::proof(problem) };
    (conserved().map(Proof::from))
        .or_else(|| exclusive_cones(problem).map(Proof::from))
        .or_else(|| storage::proof(problem))
        .or_else(|| impulse::proof(problem))
        .or_else(|| demand::proof(problem))
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
