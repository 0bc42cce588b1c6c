//! The reasons why a maneuver cannot be planned.

use super::Unsuited;
use crate::maneuver::aim::AimError;
use crate::maneuver::constraint::{AlternativesError, ConstraintError};
use crate::maneuver::objective::WeightError;
use thiserror::Error;

/// The reason why a maneuver cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProblemError {
    /// A number is NaN, infinite or out of range.
    #[error("{what} is {value}: {reason}")]
    Value {
        /// The name of the quantity.
        what: &'static str,
        /// Value of the number.
        value: f64,
        /// The allowed values, in words.
        reason: &'static str,
    },
    /// An attitude is not a rotation.
    #[error("the {end} attitude is not a rotation matrix: residual {residual:.1e}")]
    NotRotation {
        /// The invalid boundary state: "start" or "end".
        end: &'static str,
        /// The deviation from a rotation: `max |RᵀR − I|`, or 2 for a reflection.
        residual: f64,
    },
    /// A boundary rate is too fast for the step: `h |J⁻¹Π| ≥ 1`.
    #[error(
        "the {end} rate turns {angle:.3} rad in one step, and the implicit equation needs less than \
        {limit}: use at least {steps} steps"
    )]
    StepTooLong {
        /// The invalid boundary state: "start" or "end".
        end: &'static str,
        /// Angle per step `h |Ω|` \[rad\].
        angle: f64,
        /// The upper bound on the angle per step \[rad\].
        limit: f64,
        /// The number of steps that would suffice.
        steps: usize,
    },
    /// A quantity that the motion needs is missing.
    #[error("{0}")]
    Missing(&'static str),
    /// A constraint is invalid.
    #[error("constraint \"{name}\": {error}")]
    Constraint {
        /// The name of the constraint.
        name: String,
        /// The reason why the constraint is invalid.
        error: ConstraintError,
    },
    /// The start or the end violates a constraint, so that no plan can satisfy it.
    #[error("the {end} violates \"{name}\": {found}")]
    Violated {
        /// The invalid boundary state: "start" or "end".
        end: &'static str,
        /// Name of the constraint.
        name: String,
        /// The value and the limit, in words.
        found: String,
    },
    /// Alternative sets of constraints are invalid.
    #[error("\"{name}\": {error}")]
    Alternatives {
        /// The name of the alternatives.
        name: String,
        /// The reason why the alternatives are invalid.
        error: AlternativesError,
    },
    /// Wheels and torque inputs do not match.
    #[error("{0}")]
    Wheels(String),
    /// The objective contradicts the actuators, the limits or the end of the maneuver.
    #[error(transparent)]
    Unsuited(#[from] Unsuited),
    /// The end on a target is invalid.
    #[error("the end: {0}")]
    Aim(#[from] AimError),
    /// A weight of the objective does not match the inputs.
    #[error("{inputs} inputs: {error}")]
    Weight {
        /// The kind of the inputs: "torque" or "force".
        inputs: &'static str,
        /// The reason why the weight is invalid.
        error: WeightError,
    },
}
