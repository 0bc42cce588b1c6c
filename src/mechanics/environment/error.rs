//! Errors of the constructors of environments, and a check that the constructors share.

use crate::Vector3;
use crate::mechanics::number::{NumberError, finite_vector};
use thiserror::Error;

/// The reason why numbers do not describe an environment.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EnvironmentError {
    /// A number is not finite, or is negative or zero where this is not allowed.
    #[error(transparent)]
    Number(#[from] NumberError),
    /// A direction is the zero vector.
    #[error("{name} is the zero vector and has no direction")]
    NoDirection {
        /// The name of the vector.
        name: &'static str,
    },
    /// A body of point masses has no points.
    #[error("the body has no point masses")]
    NoPoints,
    /// The mass centre of the point masses is not at the origin of the body axes.
    #[error(
        "the mass center of the point masses is at ({}, {}, {}) m in body axes; it must be the origin",
        center[0], center[1], center[2]
    )]
    OffCenter {
        /// The position of the mass centre, body axes \[m\].
        center: [f64; 3],
    },
}

/// Returns the vector scaled to length one.
pub(super) fn direction(name: &'static str, value: Vector3) -> Result<Vector3, EnvironmentError> {
    let size = finite_vector(name, value)?.amax();
    // The vector is scaled first: the square of a very long or short vector would overflow or
    // underflow.
    if size > 0.0 { Ok((value / size).normalize()) } else { Err(EnvironmentError::NoDirection { name }) }
}
