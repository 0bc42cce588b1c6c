//! Directions as functions of time: fixed, turning with the reference frame, or to something that
//! moves.

mod aligned;
mod track;

pub use aligned::AlignedFrame;
pub use track::{LineOfSight, Track, TrackError};

use crate::lie;
use crate::{Matrix3, Vector3};

/// A direction in space as a function of the time since the maneuver began.
#[derive(Clone, Debug, PartialEq)]
pub enum Direction {
    /// Fixed in inertial space: a unit vector, axes of the reference frame at `t = 0`.
    Fixed(Vector3),
    /// Fixed in the reference frame, and turning with it: a unit vector, its axes.
    InFrame(Vector3),
    /// Along a moving vector, in the axes that the reference frame has at `t = 0`.
    Moving(Track),
    /// To the limb of a sphere whose centre is the end of a moving vector: cones are measured
    /// from its limb.
    Disc {
        /// The vector to the centre, in the unit of the radius.
        centre: Track,
        /// Radius of the sphere.
        radius: f64,
    },
}

/// Most quarters of a turn of what turns: five megabytes of coefficients.
const MOST_QUARTERS: f64 = 1e4;

impl Direction {
    /// Builds a direction along a moving vector, of any length, inertial axes, over `from … to`
    /// \[s\]. It is fitted by Chebyshev polynomials of degree `degree` on pieces of at most
    /// `piece` \[s\], and has the derivatives of the polynomials.
    ///
    /// # Errors
    /// Returns a [`TrackError`] for an empty span, or a vector that is not finite or vanishes.
    pub fn along(
        from: f64,
        to: f64,
        piece: f64,
        degree: usize,
        mut vector: impl FnMut(f64) -> Vector3,
    ) -> Result<Self, TrackError> {
        Track::fitted(from, to, piece, degree, |time| Ok(vector(time))).map(Self::Moving)
    }

    /// Fixed in something that turns at a constant rate \[rad/s\], inertial axes, over `0 … to`
    /// \[s\]: along `vector` at time zero.
    ///
    /// # Errors
    /// Returns a [`TrackError`] for an invalid vector or span.
    pub fn turning(vector: Vector3, rate: Vector3, to: f64) -> Result<Self, TrackError> {
        // Polynomials of this degree have round-off errors over a quarter of a turn.
        const DEGREE: usize = 18;
        let piece = (0.25 * std::f64::consts::TAU / rate.norm()).min(to);
        if to / piece > MOST_QUARTERS {
            return Err(TrackError::Turns);
        }
        Self::along(0.0, to, piece, DEGREE, |time| lie::exp(&(rate * time)) * vector)
    }

    /// Returns the unit vector in axes of the reference frame at `time` \[s\]; the frame turns at
    /// `frame_rate` \[rad/s\].
    pub fn at(&self, time: f64, frame_rate: &Vector3) -> Vector3 {
        match self {
            Self::InFrame(vector) => *vector,
            Self::Fixed(vector) if *frame_rate == Vector3::zeros() => *vector,
            Self::Fixed(_) | Self::Moving(_) | Self::Disc { .. } => {
                lie::exp(&(frame_rate * -time)) * self.in_space(time, frame_rate).direction
            }
        }
    }

    /// Returns the unit vector with its derivatives in inertial space, axes of the reference frame
    /// at `t = 0`.
    pub fn in_space(&self, time: f64, frame_rate: &Vector3) -> LineOfSight {
        let zero = Vector3::zeros();
        match self {
            Self::Fixed(vector) => LineOfSight { direction: *vector, rate: zero, acceleration: zero },
            Self::InFrame(vector) => {
                let direction = lie::exp(&(frame_rate * time)) * vector;
                let rate = frame_rate.cross(&direction);
                LineOfSight { direction, rate, acceleration: frame_rate.cross(&rate) }
            }
            Self::Moving(track) | Self::Disc { centre: track, .. } => track.pointing(time),
        }
    }

    /// This direction in other axes: turned by a rotation from the old axes to the new ones.
    #[must_use]
    pub fn turned(&self, rotation: &Matrix3) -> Self {
        match self {
            Self::Fixed(vector) => Self::Fixed(rotation * vector),
            Self::InFrame(vector) => Self::InFrame(rotation * vector),
            Self::Moving(_) | Self::Disc { .. } => self.with_track(|track| track.turned(rotation)),
        }
    }

    /// This direction for a clock that begins `by` \[s\] later, while the reference frame does not
    /// turn.
    #[must_use]
    pub fn later(&self, by: f64) -> Self {
        self.with_track(|track| track.later(by))
    }

    /// This direction from the pieces of its vector alone that a span \[s\] meets.
    #[must_use]
    pub fn within(&self, span: [f64; 2]) -> Self {
        self.with_track(|track| track.within(span))
    }

    fn with_track(&self, change: impl Fn(&Track) -> Track) -> Self {
        match self {
            Self::Fixed(_) | Self::InFrame(_) => self.clone(),
            Self::Moving(track) => Self::Moving(change(track)),
            Self::Disc { centre, radius } => Self::Disc { centre: change(centre), radius: *radius },
        }
    }

    /// Returns the time \[s\] until which it is known: infinite for one that does not move.
    pub fn known_until(&self) -> f64 {
        match self {
            Self::Fixed(_) | Self::InFrame(_) => f64::INFINITY,
            Self::Moving(track) | Self::Disc { centre: track, .. } => track.span().1,
        }
    }

    /// Returns the angle between the centre and the limb of the target \[rad\]: 0 for a point.
    /// Inside of a sphere every direction is limb.
    pub fn angular_radius(&self, time: f64) -> f64 {
        match self {
            Self::Disc { centre, radius } => (radius / centre.at(time)[0].norm()).min(1.0).asin(),
            Self::Fixed(_) | Self::InFrame(_) | Self::Moving(_) => 0.0,
        }
    }

    /// Returns the rate of [`Direction::angular_radius`] [rad/s]: 0 inside of a sphere too.
    pub fn angular_radius_rate(&self, time: f64) -> f64 {
        match self {
            Self::Disc { centre, radius } => {
                let [at, velocity, ..] = centre.at(time);
                let sine = radius / at.norm();
                // d/dt asin(R/d) = −(R/d) ḋ/d / √(1 − (R/d)²)
                let receding = at.dot(&velocity) / at.norm_squared();
                if sine < 1.0 { -sine * receding / (1.0 - sine * sine).sqrt() } else { 0.0 }
            }
            Self::Fixed(_) | Self::InFrame(_) | Self::Moving(_) => 0.0,
        }
    }

    /// Returns the length of the vector that it leads along, in its unit; `None` of one that is
    /// only a direction.
    pub fn distance(&self, time: f64) -> Option<f64> {
        match self {
            Self::Moving(track) | Self::Disc { centre: track, .. } => Some(track.at(time)[0].norm()),
            Self::Fixed(_) | Self::InFrame(_) => None,
        }
    }

    /// Returns whether it stands still in axes of the reference frame, which turns at `frame_rate`.
    pub fn is_still(&self, frame_rate: &Vector3) -> bool {
        match self {
            Self::InFrame(_) => true,
            Self::Fixed(_) => *frame_rate == Vector3::zeros(),
            Self::Moving(_) | Self::Disc { .. } => false,
        }
    }

    /// Returns the vector where it is one number for all times, in either frame.
    pub fn constant(&self) -> Option<&Vector3> {
        match self {
            Self::Fixed(vector) | Self::InFrame(vector) => Some(vector),
            Self::Moving(_) | Self::Disc { .. } => None,
        }
    }

    /// Returns the invalid length of a direction: of a vector that is not of length 1, or a
    /// radius that is not positive and finite. Returns `None` for a valid direction.
    pub fn length_defect(&self) -> Option<f64> {
        match self {
            Self::Fixed(vector) | Self::InFrame(vector) => {
                let length = vector.norm();
                let is_unit = (length - 1.0).abs() <= 1e-9;
                (!is_unit).then_some(length)
            }
            Self::Moving(_) => None,
            Self::Disc { radius, .. } => (!(*radius > 0.0 && radius.is_finite())).then_some(*radius),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::track::tests::passing;
    use super::*;

    #[test]
    fn derivatives_of_a_direction_are_those_of_differences() {
        let direction = Direction::Moving(passing());
        let (zero, h) = (Vector3::zeros(), 1e-3);
        for t in [5.0, 58.0, 61.0, 120.0] {
            let at = |t: f64| direction.in_space(t, &zero);
            let (before, here, after) = (at(t - h), at(t), at(t + h));
            let rate = (after.direction - before.direction) / (2.0 * h);
            let acceleration = (after.rate - before.rate) / (2.0 * h);
            assert!((here.rate - rate).amax() < 1e-9, "{t}");
            assert!((here.acceleration - acceleration).amax() < 1e-9, "{t}");
        }
    }

    #[test]
    fn what_turns_has_the_derivatives_of_a_rotation() {
        let (vector, rate) = (Vector3::new(0.6, -0.64, 0.48), Vector3::new(0.0, 0.2, 0.1));
        let direction = Direction::turning(vector, rate, 60.0).expect("it turns");
        for t in [0.0, 3.7, 31.0, 60.0] {
            let seen = direction.in_space(t, &Vector3::zeros());
            let wanted = lie::exp(&(rate * t)) * vector;
            let first = rate.cross(&wanted);
            assert!((seen.direction - wanted).amax() < 1e-14, "{t}");
            assert!((seen.rate - first).amax() < 1e-13, "{t} {:e}", (seen.rate - first).amax());
            assert!((seen.acceleration - rate.cross(&first)).amax() < 1e-12, "{t}");
        }
        assert!(Direction::turning(Vector3::zeros(), rate, 60.0).is_err());
    }

    #[test]
    fn the_rate_of_a_radius_is_that_of_differences() {
        let disc = Direction::Disc { centre: passing(), radius: 3e5 };
        for t in [5.0, 58.0, 61.0, 120.0] {
            let [before, after] = [t - 1e-3, t + 1e-3].map(|t| disc.angular_radius(t));
            let found = disc.angular_radius_rate(t);
            assert!((found - (after - before) / 2e-3).abs() < 1e-9, "{t} {found}");
        }
    }
}
