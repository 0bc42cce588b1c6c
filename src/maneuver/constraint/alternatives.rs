//! Sets of cones, one of which holds at every time.

use super::{Constraint, Rule};
use thiserror::Error;

/// Sets of cones. At every time one whole set holds; for example, one of two star trackers must
/// see the sky.
///
/// A plan states the times at which each set holds ([`Shift`]). Over the whole of each shift a
/// set holds, also at its ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alternatives {
    /// The name for people.
    pub name: String,
    /// At least two sets: the names of the constraints of each. A constraint belongs to one set.
    pub sets: Vec<Vec<String>>,
}

/// The time over which one of the sets holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// The number of the set.
    pub set: usize,
    /// The start of the shift \[s\].
    pub from: f64,
    /// Until when \[s\].
    pub to: f64,
}

/// The sets of one alternative and their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Turns {
    /// The alternatives.
    pub of: Alternatives,
    /// One shift after another.
    pub shifts: Vec<Shift>,
}

/// The reason for which alternatives cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum AlternativesError {
    /// There is nothing to choose from.
    #[error("alternatives need at least two sets, each with at least one constraint")]
    Few,
    /// No constraint has that name.
    #[error("no constraint has the name \"{0}\"")]
    Unknown(String),
    /// A constraint is named twice: it cannot alternate with itself.
    #[error("\"{0}\" occurs twice")]
    Twice(String),
    /// The constraint limits a rate. Rates are limited at all times.
    #[error("\"{0}\" is not a cone: alternatives must be cones")]
    NoCone(String),
}

impl Alternatives {
    /// Returns the names of all constraints of the sets.
    pub fn members(&self) -> impl Iterator<Item = &str> {
        self.sets.iter().flatten().map(String::as_str)
    }

    /// Checks the names against the constraints of a maneuver.
    ///
    /// # Errors
    /// Returns an [`AlternativesError`] that names the wrong set.
    pub fn check(&self, constraints: &[Constraint]) -> Result<(), AlternativesError> {
        if self.sets.len() < 2 || self.sets.iter().any(Vec::is_empty) {
            return Err(AlternativesError::Few);
        }
        for (index, name) in self.members().enumerate() {
            if self.members().take(index).any(|other| other == name) {
                return Err(AlternativesError::Twice(name.into()));
            }
            match constraints.iter().find(|constraint| constraint.name == name) {
                None => return Err(AlternativesError::Unknown(name.into())),
                Some(Constraint { rule: Rule::Pointing(_), .. }) => {}
                Some(_) => return Err(AlternativesError::NoCone(name.into())),
            }
        }
        Ok(())
    }
}
