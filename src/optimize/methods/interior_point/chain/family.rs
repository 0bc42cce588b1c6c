//! Families of ends of a chain, over the roll about an axis that points at a target, and over the
//! time of arrival.
//!
//! The roll ρ is one more unknown of the start that no step changes, like the duration. The end is
//! then a member of the family, and the terminal equations are those of a fixed end:
//!
//! ```text
//! log(R_f(ρ, T)ᵀ R_N) = 0 ,     H_N − Σ a_i h_i − s Π_f(ρ, T) = 0 ,     Π_f = J Ω_f
//! ```
//!
//! With the rates `v_ρ = b` and `v_T` at which the end rotates in its own axes, to second order
//! about the solution,
//!
//! ```text
//! log(exp(−b dρ) exp(−v_T dT) exp(ζ)) = ζ − b dρ − v_T dT − ½ b×ζ dρ − ½ v_T×ζ dT + ½ b×v_T dρ dT
//! ∂Ω_f/∂ρ = Ω_f × b ,     ∂²Ω_f/∂ρ² = (Ω_f × b) × b
//! ```

use super::ChainProgram;
use crate::maneuver::aim::{Aim, Ends, Roll};
use crate::maneuver::problem::Problem;
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Family of ends of a maneuver on a target.
#[derive(Clone, Debug)]
pub(crate) struct Family {
    aim: Aim,
    /// Attitude relative to which rolls are measured.
    from: Matrix3,
    frame_rate: Vector3,
    /// Ends at all times, if they do not depend on the duration; `None` if they do.
    standing: Option<Ends>,
}

impl Family {
    /// Builds the family of ends of `problem` on `aim`, with rolls relative to the attitude `from`;
    /// `None` if the directions do not determine the end.
    pub fn of(problem: &Problem, aim: &Aim, from: &Matrix3) -> Option<Self> {
        let frame_rate = problem.environment.frame_rate();
        let mut family = Self { aim: aim.clone(), from: *from, frame_rate, standing: None };
        match problem.duration.known() {
            Some(duration) => family.standing = Some(family.ends(duration)?),
            None if !aim.moves(&frame_rate) => family.standing = Some(family.ends(0.0)?),
            None => {}
        }
        Some(family)
    }

    /// Returns whether the roll is free, completely or within a band.
    pub(super) fn has_roll(&self) -> bool {
        self.within() > 0.0
    }

    /// Returns whether the roll is free only within a band.
    pub(super) fn is_band(&self) -> bool {
        self.within() < PI
    }

    /// Returns the largest deviation of the roll on either side \[rad\]; π if the roll is free.
    pub(super) fn within(&self) -> f64 {
        match self.aim.roll {
            Roll::Free => PI,
            Roll::Towards { within, .. } => within,
        }
    }

    /// Returns the ends at `time` \[s\]; `None` if the directions do not determine them.
    fn ends(&self, time: f64) -> Option<Ends> {
        let moving = || self.aim.ends(time, &self.from, &self.frame_rate).ok();
        self.standing.or_else(moving)
    }
}

/// Change of the end: its rotation in body axes, and the change of its momentum in the units of the
/// stated duration.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Change {
    pub turn: Vector3,
    pub momentum: Vector3,
}

/// The end for a duration and a roll, with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub attitude: Matrix3,
    /// Momentum of the body, in the units of the stated duration.
    pub momentum: Vector3,
    pub by_roll: Change,
    /// Derivative of the end with respect to the logarithm of the duration.
    pub by_time: Change,
    /// Second derivatives of the momentum: with respect to the roll twice, and with respect to roll
    /// and time.
    pub bend: [Vector3; 2],
}

impl ChainProgram<'_> {
    /// Returns the end after `stretch` times the stated duration, at a roll \[rad\]; `None` if the
    /// directions do not determine it.
    pub(super) fn end(&self, stretch: f64, roll: f64) -> Option<End> {
        let (model, none) = (self.model, Change::default());
        let (target, dynamics) = (&model.target, &model.dynamics);
        let Some(family) = self.family else {
            let (attitude, momentum) = (target.attitude, target.momentum);
            return Some(End { attitude, momentum, by_roll: none, by_time: none, bend: [none.turn; 2] });
        };
        let unit = dynamics.units.time;
        let ends = family.ends(stretch * unit)?;
        let (attitude, rate) = ends.at(roll);
        let momentum = |rate: Vector3| dynamics.j * rate * unit;
        let change = |(turn, rate): (Vector3, Vector3)| Change { turn, momentum: momentum(rate) };
        let (axis, slope) = ends.along_roll(&rate);
        let (turn, slope_in_time) = match family.standing {
            Some(_) => (none.turn, none.turn),
            None => {
                let (turn, rate) = ends.along_time(roll);
                (turn * (stretch * unit), rate * (stretch * unit))
            }
        };
        Some(End {
            attitude,
            momentum: momentum(rate),
            by_roll: change((axis, slope)),
            by_time: change((turn, slope_in_time)),
            bend: [slope, slope_in_time].map(|slope| momentum(slope.cross(&axis))),
        })
    }

    /// Returns the roll whose end is nearest to the final attitude of a path that takes `stretch`
    /// times the stated duration; zero without a family.
    pub(super) fn nearest_roll(&self, stretch: f64, attitude: &Matrix3) -> f64 {
        let time = stretch * self.model.dynamics.units.time;
        let ends = self.family.and_then(|family| family.ends(time));
        ends.map_or(0.0, |ends| ends.nearest(attitude))
    }
}
