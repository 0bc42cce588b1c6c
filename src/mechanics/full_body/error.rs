//! Errors of the constructors of bodies and potentials, and the checks that the constructors share.

use crate::Vector3;
use crate::mechanics::number::NumberError;
use thiserror::Error;

/// The reason why numbers do not describe attracting bodies.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FullBodyError {
    /// A number is not finite, or is negative or zero where this is not allowed.
    #[error(transparent)]
    Number(#[from] NumberError),
    /// A count is zero, or larger than memory and time allow.
    #[error("{name}: {count}; the number must be from 1 to {limit}")]
    Count {
        /// The name of the counted items.
        name: &'static str,
        /// The number of items.
        count: usize,
        /// The largest possible number.
        limit: usize,
    },
    /// A body has no mass. It would not translate, and would neither attract nor be attracted.
    #[error("a body has no mass: each of several bodies needs one")]
    NoMass,
    /// The mass centre is not the origin of the body axes.
    #[error(
        "the mass center is at ({}, {}, {}) m in body axes; it must be the origin: shift the body by its negative",
        center[0], center[1], center[2]
    )]
    OffCenter {
        /// The position of the mass centre, body axes \[m\].
        center: [f64; 3],
    },
}

pub(super) type Checked<T> = Result<T, FullBodyError>;

pub(super) fn count(name: &'static str, count: usize, limit: usize) -> Checked<usize> {
    if (1..=limit).contains(&count) { Ok(count) } else { Err(FullBodyError::Count { name, count, limit }) }
}

/// Largest distance of a mass centre from the origin, relative to the farthest point of the body,
/// that counts as round-off of the input.
pub(super) const OFF_CENTER: f64 = 1e-6;

/// Checks that the mass centre is the origin, on the scale of the farthest point.
pub(super) fn centered(center: &Vector3, farthest: f64) -> Checked<()> {
    if center.norm() <= OFF_CENTER * farthest {
        Ok(())
    } else {
        Err(FullBodyError::OffCenter { center: (*center).into() })
    }
}
