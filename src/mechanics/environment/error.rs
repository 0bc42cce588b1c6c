//! Errors of the constructors of environments, and a check that they share.

use crate::Vector3;
use crate::mechanics::number::{NumberError, finite_vector};
use thiserror::Error;

/// The reason for which numbers do not describe an environment.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EnvironmentError {
    /// A number has a wrong value.
    #[error(transparent)]
    Number(#[from] NumberError),
    /// A direction has no length.
    #[error("{name} is the zero vector and has no direction")]
    NoDirection {
        /// The name of the vector.
        name: &'static str,
    },
    /// A body of point masses has no points.
    #[error("the body has no point masses")]
    NoPoints,
    /// The point masses do not balance about the origin of the body axes.
    #[error(
        "the mass center of the point masses is at ({}, {}, {}) m in body axes; it must be the origin",
        center[0], center[1], center[2]
    )]
    OffCenter {
        /// The position of their mass center, body axes \[m\].
        center: [f64; 3],
    },
}

/// Returns the vector scaled to length one.
pub(super) fn direction(name: &'static str, value: Vector3) -> Result<Vector3, EnvironmentError> {
    let size = finite_vector(name, value)?.amax();
    // Scaled first: the square of a very long or short vector would leave the range of f64.
    if size > 0.0 { Ok((value / size).normalize()) } else { Err(EnvironmentError::NoDirection { name }) }
}
