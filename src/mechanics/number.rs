//! Errors for single numbers that constructors reject, and the checks that the constructors share.

use crate::Vector3;
use thiserror::Error;

/// The reason why a number has a wrong value.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NumberError {
    /// A number is NaN or infinite, or a sum or product of numbers overflows.
    #[error("{name} is not finite")]
    NotFinite {
        /// The name of the number.
        name: &'static str,
    },
    /// A quantity that must be positive is zero or negative.
    #[error("{name} is {value}; it must be positive")]
    NotPositive {
        /// The name of the number.
        name: &'static str,
        /// Value of the quantity, SI units.
        value: f64,
    },
    /// A quantity that may be zero is negative.
    #[error("{name} is {value}; it must not be negative")]
    Negative {
        /// The name of the number.
        name: &'static str,
        /// Value of the quantity, SI units.
        value: f64,
    },
}

type Checked<T> = Result<T, NumberError>;

pub(super) fn finite(name: &'static str, value: f64) -> Checked<f64> {
    if value.is_finite() { Ok(value) } else { Err(NumberError::NotFinite { name }) }
}

pub(super) fn positive(name: &'static str, value: f64) -> Checked<f64> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(NumberError::NotPositive { name, value }) }
}

pub(super) fn not_negative(name: &'static str, value: f64) -> Checked<f64> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(NumberError::Negative { name, value }) }
}

pub(super) fn finite_vector(name: &'static str, value: Vector3) -> Checked<Vector3> {
    value.iter().try_for_each(|component| finite(name, *component).map(drop)).map(|()| value)
}
