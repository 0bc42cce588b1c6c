//! Alternative sets of cones, of which one holds at each time.

use super::{Constraint, Rule};
use thiserror::Error;

/// Alternative sets of cones. At each time all cones of one set hold; for example, one of two star
/// trackers must see the sky.
///
/// A plan states the times at which each set holds ([`Shift`]). A set holds throughout its shift,
/// including both ends of the shift.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alternatives {
    /// The name of the alternatives in reports and messages.
    pub name: String,
    /// The sets, at least two, each as the names of its constraints. A constraint belongs to one
    /// set.
    pub sets: Vec<Vec<String>>,
}

/// The time interval in which one of the sets holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// Index of the set in [`Alternatives::sets`], from 0.
    pub set: usize,
    /// The start of the shift \[s\].
    pub from: f64,
    /// The end of the shift \[s\].
    pub to: f64,
}

/// Alternatives with the time intervals in which each of their sets holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Turns {
    /// The alternative sets.
    pub of: Alternatives,
    /// The shifts in order of time.
    pub shifts: Vec<Shift>,
}

/// The reason why alternatives are invalid.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum AlternativesError {
    /// Fewer than two sets are given, or a set is empty.
    #[error("alternatives need at least two sets, each with at least one constraint")]
    Few,
    /// A set names a constraint that does not exist.
    #[error("no constraint has the name \"{0}\"")]
    Unknown(String),
    /// A constraint is named twice. It cannot alternate with itself.
    #[error("\"{0}\" occurs twice")]
    Twice(String),
    /// A set names a rate limit. Rate limits hold at all times.
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
    /// Returns the [`AlternativesError`] of the first wrong set or name.
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
