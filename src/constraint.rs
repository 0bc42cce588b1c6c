//! Constraints on where the body may point and how fast it may turn.
//!
//! A constraint holds along the whole discrete trajectory: at the nodes and on the arcs between them,
//! on each of which the body turns about one fixed axis at one fixed rate.

mod arc;

pub use arc::{Approach, Arc, Target, angle_between};

use crate::Vector3;
use thiserror::Error;

/// One constraint, with the name under which reports speak of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Its name, for people.
    pub name: String,
    /// What it asks.
    pub rule: Rule,
}

/// What a constraint asks.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// Boresights stay outside of, or inside, cones about directions.
    Pointing(Pointing),
    /// The angular velocity `|Ω|` stays below a limit [rad/s].
    RateNorm(f64),
    /// Each component of the angular velocity, body axes, stays below its limit [rad/s] in size.
    RateAxes(Vector3),
}

/// Outside or inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Every boresight stays at least the angle away from every direction.
    KeepOut,
    /// Every boresight stays within the angle of every direction.
    KeepIn,
}

/// Cones about directions, for every pair of a boresight and a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointing {
    /// Outside or inside.
    pub side: Side,
    /// Unit vectors, body axes.
    pub boresights: Vec<Vector3>,
    /// What the cones are about.
    pub directions: Vec<Direction>,
    /// Half angle of the cones \[rad\], in (0, π).
    pub half_angle: f64,
    /// Margin \[rad\]: added to the half angle of a keep-out cone, taken from that of a keep-in cone.
    pub margin: f64,
}

/// A direction in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Unit vector at `t = 0`, axes of the reference frame.
    pub vector: Vector3,
    /// Whether it turns with the reference frame; otherwise it is fixed in inertial space.
    pub turns_with_frame: bool,
}

/// Why a constraint cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ConstraintError {
    /// A boresight or direction is not a unit vector.
    #[error("a vector of a pointing constraint has length {length}, it must be 1")]
    Vector {
        /// Its length.
        length: f64,
    },
    /// There is nothing to point, or nothing to point at.
    #[error("a pointing constraint needs at least one boresight and one direction")]
    Nothing,
    /// The angle is not one of a cone.
    #[error(
        "a cone of {degrees} deg: half angle and margin together must give more than 0 and less than 180"
    )]
    Angle {
        /// Half angle with margin \[deg\].
        degrees: f64,
    },
    /// A rate limit is not positive and finite.
    #[error("a rate limit is {value} rad/s, it must be positive and finite")]
    Rate {
        /// The limit [rad/s].
        value: f64,
    },
}

impl Pointing {
    /// Half angle of the cone that counts \[rad\]: with the margin.
    pub fn effective_half_angle(&self) -> f64 {
        match self.side {
            Side::KeepOut => self.half_angle + self.margin,
            Side::KeepIn => self.half_angle - self.margin,
        }
    }

    /// Every pair of a boresight and a direction.
    pub fn pairs(&self) -> impl Iterator<Item = (&Vector3, &Direction)> {
        self.boresights.iter().flat_map(|b| self.directions.iter().map(move |w| (b, w)))
    }
}

impl Direction {
    /// The direction at time `t` \[s\] in the axes of a reference frame that turns at `frame_rate`.
    pub fn at(&self, time: f64, frame_rate: &Vector3) -> Vector3 {
        if self.turns_with_frame { self.vector } else { crate::lie::exp(&(frame_rate * -time)) * self.vector }
    }

    /// The direction on the arc of `step` \[s\] that begins at `time` \[s\], in inertial axes: those of the
    /// reference frame, which turns at `frame_rate`, at `t = 0`.
    pub fn on_arc(&self, time: f64, step: f64, frame_rate: &Vector3) -> Target {
        if !self.turns_with_frame || *frame_rate == Vector3::zeros() {
            return Target { start: self.vector, turn: Vector3::zeros() };
        }
        Target { start: crate::lie::exp(&(frame_rate * time)) * self.vector, turn: frame_rate * step }
    }
}

impl Constraint {
    /// Checks the numbers.
    ///
    /// # Errors
    /// A [`ConstraintError`] that says which.
    pub fn check(&self) -> Result<(), ConstraintError> {
        let positive = |value: f64| {
            if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ConstraintError::Rate { value }) }
        };
        match &self.rule {
            Rule::RateNorm(limit) => positive(*limit),
            Rule::RateAxes(limits) => limits.iter().try_for_each(|limit| positive(*limit)),
            Rule::Pointing(pointing) => {
                if pointing.boresights.is_empty() || pointing.directions.is_empty() {
                    return Err(ConstraintError::Nothing);
                }
                let directions = pointing.directions.iter().map(|direction| &direction.vector);
                for vector in pointing.boresights.iter().chain(directions) {
                    let length = vector.norm();
                    let unit = (length - 1.0).abs() <= 1e-9;
                    if !unit {
                        return Err(ConstraintError::Vector { length });
                    }
                }
                let angle = pointing.effective_half_angle();
                let usable = angle > 0.0 && angle < std::f64::consts::PI && pointing.margin >= 0.0;
                if usable { Ok(()) } else { Err(ConstraintError::Angle { degrees: angle.to_degrees() }) }
            }
        }
    }
}
