//! Directions as functions of time: fixed in inertial space, fixed in the reference frame, or along
//! a moving vector.

mod aligned;
mod track;

pub use aligned::AlignedFrame;
pub use track::{LineOfSight, Track, TrackError};

use crate::lie;
use crate::{Matrix3, Vector3};

/// A direction as a function of the time since the start of the maneuver.
#[derive(Clone, Debug, PartialEq)]
pub enum Direction {
    /// Fixed in inertial space: a unit vector, axes of the reference frame at `t = 0`.
    Fixed(Vector3),
    /// Fixed in the reference frame, and turning with it: a unit vector, axes of the reference
    /// frame.
    InFrame(Vector3),
    /// Along a moving vector, in the axes that the reference frame has at `t = 0`.
    Moving(Track),
    /// A sphere whose centre is the end of a moving vector, seen as a disc. The angles of cones are
    /// measured from the limb of the disc.
    Disc {
        /// The vector to the centre, in the unit of the radius.
        centre: Track,
        /// Radius of the sphere.
        radius: f64,
    },
}

/// The largest number of quarter turns of a turning direction. Its coefficients then take five
/// megabytes.
const MOST_QUARTERS: f64 = 1e4;

impl Direction {
    /// Builds a direction along `vector`, a function of time of any length in inertial axes, over
    /// `from … to` \[s\]. The vector is approximated by Chebyshev polynomials of degree `degree` on
    /// pieces of at most `piece` \[s\]; the derivatives are the derivatives of the polynomials.
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

    /// Builds a direction that turns at the constant rate `rate` \[rad/s\], inertial axes, over
    /// `0 … to` \[s\]. It is along `vector` at time zero.
    ///
    /// # Errors
    /// Returns a [`TrackError`] for an invalid vector or span.
    pub fn turning(vector: Vector3, rate: Vector3, to: f64) -> Result<Self, TrackError> {
        // On a quarter of a turn, the error of a polynomial of this degree is round-off.
        const DEGREE: usize = 18;
        let piece = (0.25 * std::f64::consts::TAU / rate.norm()).min(to);
        if to / piece > MOST_QUARTERS {
            return Err(TrackError::Turns);
        }
        Self::along(0.0, to, piece, DEGREE, |time| lie::exp(&(rate * time)) * vector)
    }

    /// Returns the unit vector in axes of the reference frame at `time` \[s\]. The frame turns at
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

    /// Returns the unit vector and its inertial derivatives at `time` \[s\], in the axes that the
    /// reference frame has at `t = 0`.
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

    /// Returns this direction in other axes. `rotation` converts vectors from the old axes to the
    /// new ones.
    #[must_use]
    pub fn turned(&self, rotation: &Matrix3) -> Self {
        match self {
            Self::Fixed(vector) => Self::Fixed(rotation * vector),
            Self::InFrame(vector) => Self::InFrame(rotation * vector),
            Self::Moving(_) | Self::Disc { .. } => self.with_track(|track| track.turned(rotation)),
        }
    }

    /// Returns this direction for a clock that starts `by` \[s\] later. The reference frame must
    /// not turn.
    #[must_use]
    pub fn later(&self, by: f64) -> Self {
        self.with_track(|track| track.later(by))
    }

    /// Returns this direction with only the pieces of its vector that overlap the time span \[s\].
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

    /// Returns the time \[s\] up to which the direction is known; infinite if it is not along a
    /// moving vector.
    pub fn known_until(&self) -> f64 {
        match self {
            Self::Fixed(_) | Self::InFrame(_) => f64::INFINITY,
            Self::Moving(track) | Self::Disc { centre: track, .. } => track.span().1,
        }
    }

    /// Returns the angular radius of the target \[rad\], the angle between its centre and its limb;
    /// 0 for a point. From inside of a sphere it is 90°.
    pub fn angular_radius(&self, time: f64) -> f64 {
        match self {
            Self::Disc { centre, radius } => (radius / centre.at(time)[0].norm()).min(1.0).asin(),
            Self::Fixed(_) | Self::InFrame(_) | Self::Moving(_) => 0.0,
        }
    }

    /// Returns the rate of [`Direction::angular_radius`] [rad/s]; 0 inside of a sphere.
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

    /// Returns the length of the moving vector, in its own unit; `None` for a direction without a
    /// distance.
    pub fn distance(&self, time: f64) -> Option<f64> {
        match self {
            Self::Moving(track) | Self::Disc { centre: track, .. } => Some(track.at(time)[0].norm()),
            Self::Fixed(_) | Self::InFrame(_) => None,
        }
    }

    /// Returns whether the direction is constant in axes of the reference frame, which turns at
    /// `frame_rate`.
    pub fn is_still(&self, frame_rate: &Vector3) -> bool {
        match self {
            Self::InFrame(_) => true,
            Self::Fixed(_) => *frame_rate == Vector3::zeros(),
            Self::Moving(_) | Self::Disc { .. } => false,
        }
    }

    /// Returns the constant vector of a direction that is fixed in inertial space or in the
    /// reference frame; `None` for a moving vector.
    pub fn constant(&self) -> Option<&Vector3> {
        match self {
            Self::Fixed(vector) | Self::InFrame(vector) => Some(vector),
            Self::Moving(_) | Self::Disc { .. } => None,
        }
    }

    /// Returns the invalid length of a direction: the length of a vector that is not a unit vector,
    /// or a radius that is not positive and finite. Returns `None` for a valid direction.
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
