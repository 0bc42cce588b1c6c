//! What a constructor of an environment rejects, and the checks they share.

use crate::Vector3;
use thiserror::Error;

/// Why numbers do not describe an environment.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EnvironmentError {
    /// A number is NaN or infinite, or a product of the numbers overflows.
    #[error("{name} is not finite")]
    NotFinite {
        /// What was given.
        name: &'static str,
    },
    /// A quantity that must be positive is zero or negative.
    #[error("{name} is {value}; it must be positive")]
    NotPositive {
        /// What was given.
        name: &'static str,
        /// Its value, SI units.
        value: f64,
    },
    /// A quantity that may be zero is negative.
    #[error("{name} is {value}; it must not be negative")]
    Negative {
        /// What was given.
        name: &'static str,
        /// Its value, SI units.
        value: f64,
    },
    /// A direction has no length.
    #[error("{name} is the zero vector and has no direction")]
    NoDirection {
        /// What was given.
        name: &'static str,
    },
    /// A body of point masses has none.
    #[error("the body has no point masses")]
    NoPoints,
    /// The point masses do not balance about the origin of the body axes.
    #[error(
        "the mass center of the point masses is at ({}, {}, {}) m in body axes; it must be the origin",
        center[0], center[1], center[2]
    )]
    OffCenter {
        /// Where their mass center is, body axes \[m\].
        center: [f64; 3],
    },
}

type Checked<T> = Result<T, EnvironmentError>;

pub(super) fn finite(name: &'static str, value: f64) -> Checked<f64> {
    if value.is_finite() { Ok(value) } else { Err(EnvironmentError::NotFinite { name }) }
}

pub(super) fn positive(name: &'static str, value: f64) -> Checked<f64> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(EnvironmentError::NotPositive { name, value }) }
}

pub(super) fn not_negative(name: &'static str, value: f64) -> Checked<f64> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(EnvironmentError::Negative { name, value }) }
}

pub(super) fn finite_vector(name: &'static str, value: Vector3) -> Checked<Vector3> {
    if value.iter().all(|component| component.is_finite()) {
        Ok(value)
    } else {
        Err(EnvironmentError::NotFinite { name })
    }
}

/// The vector scaled to length one.
pub(super) fn direction(name: &'static str, value: Vector3) -> Checked<Vector3> {
    let size = finite_vector(name, value)?.amax();
    // Scaled first: the square of a very long or short vector would leave the range of f64.
    if size > 0.0 { Ok((value / size).normalize()) } else { Err(EnvironmentError::NoDirection { name }) }
}
