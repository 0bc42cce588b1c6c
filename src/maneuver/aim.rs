//! An end on a target: a body axis points at it, which may move, and the roll about that axis is the plan's to choose, all of
//! it or within a band.
//!
//! A spin s about the boresight may be asked besides, `Ω = s b` or `Ω = R(ρ)ᵀ ω + s b`: its phase is the roll.
//!
//! Such ends are a family of states over the roll ρ and the time T. With the direction `d(t)` and its rate in
//! inertial space, axes of the reference frame as it stands at that time:
//!
//! ```text
//! R(ρ) b = d ,   R(ρ) = R_0 exp(ρ S(b)) ,   Ω = 0   or   Ω = R(ρ)ᵀ ω ,   ω = d × ḋ
//! ```
//!
//! where `R_0` is the attitude of the start, turned the shortest way until b points to d. Where a second axis `b₂` is to point
//! towards a second direction as well as it can, `R_0 = [t₁ t₂ t₃][s₁ s₂ s₃]ᵀ` with `t₁ = d₁`, `t₂ ∥ d₁ × d₂` and `s` the same of
//! `b, b₂` ("align and constrain"), ω is the rate of that frame, and the roll is zero or within a band about it.
//!
//! The least cost V of the family is stationary in its parameters. With the costates `μ` of the physical state at the end,
//!
//! ```text
//! dV/dρ = −(μ^R·b + μ^Π·J(Ω × b)) ,     dV/dT = ℋ − μ^R·v' − μ^Π·J v'' ,     v' = Rᵀω ,  v'' = Rᵀω̇ ,
//! ```
//!
//! of which the first is the transversality of a free roll (for a target that moves *not* `μ^R·b = 0`: the matched rate turns
//! with the roll).

use crate::lie;
use crate::maneuver::constraint::angle_between;
use crate::mechanics::direction::{AlignedFrame, Direction, LineOfSight};
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;
use thiserror::Error;

/// An end at which a body axis points at a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// The axis, a unit vector in body axes.
    pub boresight: Vector3,
    /// Where it points, in axes of the reference frame.
    pub at: Direction,
    /// What the roll about it is.
    pub roll: Roll,
    /// At which rate the body turns.
    pub rate: AimRate,
    /// At which rate it turns about the boresight besides \[rad/s\]: a spin that is kept.
    pub roll_rate: f64,
}

/// The roll about the axis that points.
#[derive(Clone, Debug, PartialEq)]
pub enum Roll {
    /// Where it costs least.
    Free,
    /// A second axis points towards a second direction as well as it can, or up to an angle to either side of that.
    Towards {
        /// The second axis, a unit vector in body axes.
        axis: Vector3,
        /// Where it points as well as it can.
        at: Direction,
        /// The angle about the boresight \[rad\], in [0, π]: 0 where the roll is given.
        within: f64,
    },
}

/// The rate at an end on a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AimRate {
    /// That of the direction: the boresight stays on the target, without a rate of roll, or with that of the aligned frame.
    Matched,
    /// None.
    Zero,
}

/// Why an end on a target cannot be used.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum AimError {
    /// An axis is not a unit vector.
    #[error("an axis that is to point has length {length}, it must be 1")]
    Axis {
        /// Its length.
        length: f64,
    },
    /// The second axis is the first, or its opposite.
    #[error("the axis that keeps the roll lies along the one that points: it must be another")]
    Parallel,
    /// The band of the roll is none.
    #[error("the roll is to stay within {degrees} deg: from 0 to 180 are possible")]
    Band {
        /// Its half width \[deg\].
        degrees: f64,
    },
    /// The two directions are as good as parallel where the maneuver ends: they leave the roll open, and its rate has no bound.
    #[error(
        "at t = {time} s the two directions are {degrees} deg apart: within {LEAST_APART} deg they do not keep the roll"
    )]
    Undefined {
        /// When \[s\].
        time: f64,
        /// The angle between them, or between one and the opposite of the other \[deg\].
        degrees: f64,
    },
}

/// Two directions that are less than this from parallel \[deg\] do not define a roll: its rate grows as the inverse of the angle.
const LEAST_APART: f64 = 0.6;

/// The states at which a maneuver may end at one time, over the roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    boresight: Vector3,
    /// Attitude without roll.
    attitude: Matrix3,
    /// How fast the end turns as time goes on, axes of the reference frame \[rad/s\].
    turning: Vector3,
    /// Angular velocity of the body there, and how fast that changes, same axes \[rad/s\], \[rad/s²\]: as the end turns, or none.
    rate: Vector3,
    acceleration: Vector3,
    /// How far the roll may go to either side \[rad\].
    within: f64,
    /// The rate about the boresight besides \[rad/s\].
    roll_rate: f64,
}

/// An end that moves on with the duration that is found: a plan of least time meets its target where that is when it arrives.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    pub(crate) aim: Aim,
    /// When the target is where the end of the maneuver has it \[s\].
    pub(crate) time: f64,
    /// How the time by which a plan is late changes with the time of its end: −1 for a target that stands.
    pub(crate) slope: f64,
}

impl Meeting {
    /// Where a plan that takes `duration` \[s\] to where the target is at `time` \[s\] is aimed at next \[s\]: the root of how late it is,
    /// by its slope.
    pub(crate) fn next(&self, time: f64, duration: f64) -> f64 {
        let next = time - (duration - time) / self.slope;
        if next.is_finite() && next > 0.0 { next } else { duration }
    }
}

impl Aim {
    /// A body axis that points along a direction, moves with it, and has its roll where it costs least.
    pub fn new(boresight: Vector3, at: Direction) -> Self {
        Self { boresight, at, roll: Roll::Free, rate: AimRate::Matched, roll_rate: 0.0 }
    }

    /// This end with a second axis towards a second direction, as well as it can or `within` \[rad\] of that.
    pub fn with_roll_towards(self, axis: Vector3, at: Direction, within: f64) -> Self {
        Self { roll: Roll::Towards { axis, at, within }, ..self }
    }

    /// This end with the body at rest.
    pub fn at_rest(self) -> Self {
        Self { rate: AimRate::Zero, ..self }
    }

    /// This end with a spin about the boresight [rad/s].
    pub fn spinning(self, roll_rate: f64) -> Self {
        Self { roll_rate, ..self }
    }

    /// Whether the end depends on the time at which it is come to, in axes of a reference frame that turns at `frame_rate`.
    pub fn moves(&self, frame_rate: &Vector3) -> bool {
        let second = match &self.roll {
            Roll::Free => None,
            Roll::Towards { at, .. } => Some(at),
        };
        let moves = |direction: &Direction| !direction.is_still(frame_rate);
        moves(&self.at)
            || second.is_some_and(moves)
            || (self.rate == AimRate::Matched && *frame_rate != Vector3::zeros())
    }

    /// Whether the roll about the boresight, or a part of it, is the plan's to choose.
    pub fn has_roll(&self) -> bool {
        match &self.roll {
            Roll::Free => true,
            Roll::Towards { within, .. } => *within > 0.0,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// An [`AimError`] that says which; [`AimError::Undefined`] is told by [`Aim::ends`].
    pub fn check(&self) -> Result<(), AimError> {
        let unit = |axis: &Vector3| {
            let length = axis.norm();
            if (length - 1.0).abs() <= 1e-9 { Ok(()) } else { Err(AimError::Axis { length }) }
        };
        unit(&self.boresight)?;
        if let Roll::Towards { axis, within, .. } = &self.roll {
            unit(axis)?;
            if self.boresight.cross(axis).norm() < LEAST_APART.to_radians().sin() {
                return Err(AimError::Parallel);
            }
            if !(0.0..=PI).contains(within) {
                return Err(AimError::Band { degrees: within.to_degrees() });
            }
        }
        Ok(())
    }

    /// The ends at `time` \[s\] of a body that starts in `start`; the reference frame turns at `frame_rate`, axes of itself.
    ///
    /// # Errors
    /// [`AimError::Undefined`].
    pub fn ends(&self, time: f64, start: &Matrix3, frame_rate: &Vector3) -> Result<Ends, AimError> {
        // Rates are those in inertial space, axes those of the reference frame as it stands at that time.
        let turned = lie::exp(&(frame_rate * -time));
        let seen = |direction: &Direction| {
            let LineOfSight { direction, rate, acceleration } = direction.in_space(time, frame_rate);
            LineOfSight {
                direction: turned * direction,
                rate: turned * rate,
                acceleration: turned * acceleration,
            }
        };
        let first = seen(&self.at);
        let (attitude, turning, acceleration, within) = match &self.roll {
            Roll::Free => {
                let d = &first.direction;
                (onto(start, &self.boresight, d), d.cross(&first.rate), d.cross(&first.acceleration), PI)
            }
            Roll::Towards { axis, at, within } => {
                let second = seen(at);
                let apart = angle_between(&first.direction, &second.direction);
                let degrees = apart.min(PI - apart).to_degrees();
                // Written so that what is not a number is refused.
                let defined = degrees >= LEAST_APART;
                if !defined {
                    return Err(AimError::Undefined { time, degrees });
                }
                let frame = AlignedFrame::of([&self.boresight, axis], [&first, &second]);
                (frame.attitude, frame.rate, frame.acceleration, *within)
            }
        };
        let (rate, acceleration) = match self.rate {
            AimRate::Matched => (turning, acceleration),
            AimRate::Zero => (Vector3::zeros(), Vector3::zeros()),
        };
        let (boresight, roll_rate) = (self.boresight, self.roll_rate);
        Ok(Ends { boresight, attitude, turning, rate, acceleration, within, roll_rate })
    }
}

impl Ends {
    /// Whether there is a roll to choose.
    pub fn has_roll(&self) -> bool {
        self.within > 0.0
    }

    /// How far the roll may go to either side \[rad\]: π where it is free.
    pub fn within(&self) -> f64 {
        self.within
    }

    /// Attitude and angular velocity, body axes \[rad/s\], at a roll \[rad\].
    pub fn at(&self, roll: f64) -> (Matrix3, Vector3) {
        let attitude = lie::project_to_rotation(&(self.attitude * lie::exp(&(self.boresight * roll))));
        (attitude, attitude.tr_mul(&self.rate) + self.boresight * self.roll_rate)
    }

    /// The roll \[rad\] at which the end comes nearest to an attitude, within the band.
    pub fn nearest(&self, attitude: &Matrix3) -> f64 {
        let turn = self.attitude.tr_mul(attitude);
        // max over ρ of tr(exp(−ρS(b)) Q): the rotation about b alone.
        let b = &self.boresight;
        let cosine = turn.trace() - b.dot(&(turn * b));
        let sine = 2.0 * b.dot(&lie::vee(&turn));
        sine.atan2(cosine).clamp(-self.within, self.within)
    }

    /// How a state at a roll moves with the roll: `(ζ, δΩ)` per \[rad\], body axes.
    pub fn along_roll(&self, rate: &Vector3) -> (Vector3, Vector3) {
        (self.boresight, rate.cross(&self.boresight))
    }

    /// How the end in `attitude` moves with the time, but for a roll: `(ζ, δΩ)` per \[s\], body axes.
    pub fn along_time(&self, attitude: &Matrix3) -> (Vector3, Vector3) {
        (attitude.tr_mul(&self.turning), attitude.tr_mul(&self.acceleration))
    }
}

/// An attitude turned the shortest way until the body axis `b` points along `d`; about any axis where that is opposite.
fn onto(attitude: &Matrix3, b: &Vector3, d: &Vector3) -> Matrix3 {
    let from = attitude * b;
    let axis = from.cross(d);
    let angle = angle_between(&from, d);
    let axis = axis.try_normalize(1e-12).unwrap_or_else(|| {
        let least = from.iamin();
        from.cross(&Vector3::ith(least, 1.0)).normalize()
    });
    lie::project_to_rotation(&(lie::exp(&(axis * angle)) * attitude))
}
