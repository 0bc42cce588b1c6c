//! An end of a maneuver on a target: a body axis (the boresight) points at the target, which may
//! move. The plan chooses the roll about the boresight, in full or within a band.
//!
//! A spin s about the boresight may be requested: `Ω = s b` or `Ω = R(ρ)ᵀ ω + s b`. The roll is
//! then the phase of the spin.
//!
//! The end states on a target are a family over the roll ρ and the time T. The target has the
//! direction `d(t)` and a rate, both in inertial axes (the axes of the reference frame at that
//! time):
//!
//! ```text
//! R(ρ) b = d ,   R(ρ) = R_0 exp(ρ S(b)) ,   Ω = 0   or   Ω = R(ρ)ᵀ ω ,   ω = d × ḋ
//! ```
//!
//! Here `R_0` is the attitude of the start, turned the shortest way until b points to d. If a
//! second axis `b₂` should point towards a second direction as closely as possible, then
//! `R_0 = [t₁ t₂ t₃][s₁ s₂ s₃]ᵀ` with `t₁ = d₁`, `t₂ ∥ d₁ × d₂`, and `s` built from `b, b₂` like
//! `t` from the directions ("align and constrain"). ω is then the rate of this frame, and the roll
//! is zero or within a band about it.
//!
//! The minimum cost V over the family is stationary in its parameters. Let `μ^R`, `μ^Π` be the
//! costates of attitude and momentum at the end, and ℋ the Hamiltonian. Then
//!
//! ```text
//! dV/dρ = −(μ^R·b + μ^Π·J(Ω × b)) ,     dV/dT = ℋ − μ^R·v' − μ^Π·J v'' ,     v' = Rᵀω ,  v'' = Rᵀω̇ ,
//! ```
//!
//! The first condition is the transversality of a free roll. For a moving target it is *not*
//! `μ^R·b = 0`, because the matched rate turns with the roll.

use crate::lie;
use crate::maneuver::constraint::angle_between;
use crate::mechanics::direction::{AlignedFrame, Direction, LineOfSight};
use crate::{Matrix3, Vector3};
use std::f64::consts::PI;
use thiserror::Error;

/// An end at which a body axis points at a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// The body axis that points at the target, a unit vector in body axes.
    pub boresight: Vector3,
    /// Direction of the target, in axes of the reference frame.
    pub at: Direction,
    /// The condition on the roll about the boresight.
    pub roll: Roll,
    /// The angular velocity of the body at the end, apart from the spin.
    pub rate: AimRate,
    /// Spin: additional rate about the boresight at the end \[rad/s\].
    pub roll_rate: f64,
}

/// The condition on the roll about the boresight at the end.
#[derive(Clone, Debug, PartialEq)]
pub enum Roll {
    /// The plan chooses the roll with the lowest cost.
    Free,
    /// A second body axis points as closely as possible towards a second direction. The roll may
    /// deviate from this by a given angle to either side.
    Towards {
        /// The second axis, a unit vector in body axes.
        axis: Vector3,
        /// The direction towards which the second axis points as closely as possible.
        at: Direction,
        /// Largest deviation of the roll to either side \[rad\], in [0, π]; 0 fixes the roll.
        within: f64,
    },
}

/// The angular velocity of the body at an end on a target, apart from a spin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AimRate {
    /// The body turns with the target direction, so the boresight stays on the target. The rate
    /// about the boresight is zero if the roll is free, and otherwise the rate of the aligned
    /// frame.
    Matched,
    /// The angular velocity is zero, apart from a spin.
    Zero,
}

/// The reason why an end on a target is invalid.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum AimError {
    /// An axis is not a unit vector.
    #[error("the pointing axis has length {length}: give a vector of length 1")]
    Axis {
        /// Length of the axis.
        length: f64,
    },
    /// The second axis is parallel or antiparallel to the boresight.
    #[error("the axis that fixes the roll is parallel to the pointing axis: give another one")]
    Parallel,
    /// The band of the roll is not an angle from 0 to 180°.
    #[error("the roll band is {degrees} deg: give a value from 0 to 180")]
    Band {
        /// Half width of the band \[deg\].
        degrees: f64,
    },
    /// The two directions are nearly parallel or antiparallel at the end. They do not determine the
    /// roll, and the rate of the roll has no bound.
    #[error(
        "at t = {time} s the two directions are {degrees} deg apart: within {LEAST_APART} deg they \
        do not determine the roll"
    )]
    Undefined {
        /// The time of the end \[s\].
        time: f64,
        /// The angle between the two directions, or between one of them and the opposite of the
        /// other \[deg\].
        degrees: f64,
    },
}

/// The smallest angle between two directions at which they define a roll \[deg\]: the rate of the
/// roll grows as the inverse of this angle. Nearly opposite directions are excluded too.
const LEAST_APART: f64 = 0.6;

/// The end states on a target at one time, parametrised by the roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    boresight: Vector3,
    /// End attitude at zero roll.
    attitude: Matrix3,
    /// Angular velocity of the end attitude at zero roll relative to the reference frame, in axes
    /// of that frame \[rad/s\].
    carried: Vector3,
    /// The rate of the reference frame, in its own axes \[rad/s\].
    frame_rate: Vector3,
    /// Inertial angular velocity of the body at the end without spin \[rad/s\], in axes of the
    /// reference frame; zero for an end at rest.
    rate: Vector3,
    /// Time derivative of that angular velocity \[rad/s²\], in axes of the reference frame; zero
    /// for an end at rest.
    acceleration: Vector3,
    /// The largest deviation of the roll to either side \[rad\].
    within: f64,
    /// Spin: additional rate about the boresight \[rad/s\].
    roll_rate: f64,
}

/// An end state that depends on the duration of the plan: a minimum-time plan meets a moving target
/// at the position that the target has on arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    pub(crate) aim: Aim,
    /// The assumed arrival time \[s\], for which the end state of the maneuver was computed.
    pub(crate) time: f64,
    /// Derivative of the delay with respect to the assumed arrival time. The delay is the duration
    /// of the plan minus the assumed arrival time; for a fixed target the derivative is −1.
    pub(crate) slope: f64,
}

impl Meeting {
    /// Returns the next assumed arrival time \[s\], by a Newton step on the delay. `duration` \[s\]
    /// is the duration of the plan to the position that the target has at `time` \[s\].
    pub(crate) fn next(&self, time: f64, duration: f64) -> f64 {
        let next = time - (duration - time) / self.slope;
        if next.is_finite() && next > 0.0 { next } else { duration }
    }
}

impl Aim {
    /// Builds an end at which a body axis points along a direction and moves with it. The plan
    /// chooses the roll.
    pub fn new(boresight: Vector3, at: Direction) -> Self {
        Self { boresight, at, roll: Roll::Free, rate: AimRate::Matched, roll_rate: 0.0 }
    }

    /// Returns this end with a second axis that points as closely as possible towards a second
    /// direction. The roll may deviate from this by `within` \[rad\].
    pub fn with_roll_towards(self, axis: Vector3, at: Direction, within: f64) -> Self {
        Self { roll: Roll::Towards { axis, at, within }, ..self }
    }

    /// Returns this end with the body at rest.
    pub fn at_rest(self) -> Self {
        Self { rate: AimRate::Zero, ..self }
    }

    /// Returns this end with a spin about the boresight \[rad/s\].
    pub fn spinning(self, roll_rate: f64) -> Self {
        Self { roll_rate, ..self }
    }

    /// Returns this end with `change` applied to each of its directions.
    pub(crate) fn with_directions(&self, change: impl Fn(&Direction) -> Direction) -> Self {
        let roll = match &self.roll {
            Roll::Free => Roll::Free,
            Roll::Towards { axis, at, within } => {
                Roll::Towards { axis: *axis, at: change(at), within: *within }
            }
        };
        Self { at: change(&self.at), roll, ..self.clone() }
    }

    /// Returns the directions of the boresight and of the second axis.
    pub(crate) fn directions(&self) -> impl Iterator<Item = &Direction> {
        let second = match &self.roll {
            Roll::Free => None,
            Roll::Towards { at, .. } => Some(at),
        };
        std::iter::once(&self.at).chain(second)
    }

    /// Returns whether the end state, in axes of a reference frame that turns at `frame_rate`,
    /// depends on the arrival time.
    pub fn moves(&self, frame_rate: &Vector3) -> bool {
        self.directions().any(|direction| !direction.is_still(frame_rate))
            || (self.rate == AimRate::Matched && *frame_rate != Vector3::zeros())
    }

    /// Returns whether the plan chooses the roll about the boresight, in full or within a band.
    pub fn has_roll(&self) -> bool {
        match &self.roll {
            Roll::Free => true,
            Roll::Towards { within, .. } => *within > 0.0,
        }
    }

    /// Checks that axes have unit length and determine a roll, and that the roll band is in range.
    ///
    /// # Errors
    /// Returns the [`AimError`] of the first violated condition. [`Aim::ends`] reports
    /// [`AimError::Undefined`].
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

    /// Returns the end states on the target at `time` \[s\], for a body that starts in the attitude
    /// `start`. The reference frame turns at `frame_rate` \[rad/s\], in its own axes.
    ///
    /// # Errors
    /// [`AimError::Undefined`] if two directions are nearly parallel at that time.
    pub fn ends(&self, time: f64, start: &Matrix3, frame_rate: &Vector3) -> Result<Ends, AimError> {
        // Rates are inertial, in the axes of the reference frame at that time.
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
        let (attitude, turning, acceleration, carried, within) = match &self.roll {
            Roll::Free => {
                let d = &first.direction;
                let (turning, acceleration) = (d.cross(&first.rate), d.cross(&first.acceleration));
                let passing = first.rate - frame_rate.cross(d);
                // As `d` moves, the shortest rotation from `from` to `d` also turns about `d`.
                let from = start * self.boresight;
                let about = -from.cross(d).dot(&passing) / (1.0 + from.dot(d));
                let about = if about.is_finite() { about } else { 0.0 };
                let carried = d.cross(&passing) + d * about;
                (onto(start, &self.boresight, d), turning, acceleration, carried, PI)
            }
            Roll::Towards { axis, at, within } => {
                let second = seen(at);
                let apart = angle_between(&first.direction, &second.direction);
                let degrees = apart.min(PI - apart).to_degrees();
                // NaN does not count as defined.
                let defined = degrees >= LEAST_APART;
                if !defined {
                    return Err(AimError::Undefined { time, degrees });
                }
                let frame = AlignedFrame::of([&self.boresight, axis], [&first, &second]);
                (frame.attitude, frame.rate, frame.acceleration, frame.rate - frame_rate, *within)
            }
        };
        let (rate, acceleration) = match self.rate {
            AimRate::Matched => (turning, acceleration),
            AimRate::Zero => (Vector3::zeros(), Vector3::zeros()),
        };
        let (boresight, roll_rate, frame_rate) = (self.boresight, self.roll_rate, *frame_rate);
        Ok(Ends { boresight, attitude, carried, frame_rate, rate, acceleration, within, roll_rate })
    }
}

impl Ends {
    /// Returns whether the plan chooses the roll.
    pub fn has_roll(&self) -> bool {
        self.within > 0.0
    }

    /// Returns the largest deviation of the roll to either side \[rad\]: π for a free roll.
    pub fn within(&self) -> f64 {
        self.within
    }

    /// Returns the attitude and angular velocity, body axes \[rad/s\], at a roll \[rad\].
    pub fn at(&self, roll: f64) -> (Matrix3, Vector3) {
        let attitude = lie::project_to_rotation(&(self.attitude * lie::exp(&(self.boresight * roll))));
        (attitude, attitude.tr_mul(&self.rate) + self.boresight * self.roll_rate)
    }

    /// Returns the roll \[rad\] within the band at which the end is nearest to `attitude`.
    pub fn nearest(&self, attitude: &Matrix3) -> f64 {
        let turn = self.attitude.tr_mul(attitude);
        // The roll ρ maximises tr(exp(−ρS(b)) Q): it is the part of the turn Q about b.
        let b = &self.boresight;
        let cosine = turn.trace() - b.dot(&(turn * b));
        let sine = 2.0 * b.dot(&lie::vee(&turn));
        sine.atan2(cosine).clamp(-self.within, self.within)
    }

    /// Returns the derivative of an end state with angular velocity `rate` with respect to the
    /// roll: the changes `(ζ, δΩ)` of attitude and rate per radian, body axes.
    pub fn along_roll(&self, rate: &Vector3) -> (Vector3, Vector3) {
        (self.boresight, rate.cross(&self.boresight))
    }

    /// Returns the derivative of the end state at a roll with respect to time: the changes
    /// `(ζ, δΩ)` of attitude and rate per second, body axes.
    pub(crate) fn along_time(&self, roll: f64) -> (Vector3, Vector3) {
        let (attitude, _) = self.at(roll);
        let change = self.acceleration - (self.frame_rate + self.carried).cross(&self.rate);
        (attitude.tr_mul(&self.carried), attitude.tr_mul(&change))
    }
}

/// Returns an attitude turned the shortest way until the body axis `b` points along `d`. The axis
/// of the turn is arbitrary if `b` points opposite to `d`.
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
