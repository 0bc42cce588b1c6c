//! Targets to which a body axis can point, as seen from a satellite on its orbit.

use crate::bodies;
use crate::frames::{self, EARTH_RADIUS_M, EarthRotation, Theory};
use crate::light::{self, Light};
use crate::orbit::{Orbit, OrbitError};
use crate::time::Clock;
use slewkit::mechanics::direction::{Track, TrackError};
use slewkit::{Direction, Matrix3, Vector3};
use thiserror::Error;

/// A target to which a body axis can point. If no orbit is given, the Sun and the Moon are seen
/// from the centre of the Earth.
#[derive(Clone, Debug)]
pub enum Target {
    /// The centre of the Sun.
    Sun,
    /// The direction opposite to the Sun.
    AntiSun,
    /// The centre of the Moon.
    Moon,
    /// The centre of the Earth.
    Nadir,
    /// The direction away from the centre of the Earth.
    Zenith,
    /// The downward normal of the WGS 84 ellipsoid below the satellite.
    GeodeticNadir,
    /// The direction of the satellite's inertial velocity, or the opposite direction.
    Velocity {
        /// True for the direction opposite to the velocity.
        reversed: bool,
    },
    /// The forward horizontal direction in the orbital plane, perpendicular to nadir and to the
    /// orbit normal.
    AlongTrack,
    /// The orbit normal `r × v`, or the opposite direction.
    OrbitNormal {
        /// True for the direction opposite to `r × v`.
        reversed: bool,
    },
    /// A ground station.
    Ground {
        /// Geodetic latitude of the station \[deg\].
        latitude_deg: f64,
        /// East longitude of the station \[deg\].
        longitude_deg: f64,
        /// Height of the station above the WGS 84 ellipsoid \[m\].
        height_m: f64,
    },
    /// A point on the limb of a spherical Earth, where a line of sight from the satellite touches
    /// the sphere.
    Limb {
        /// Azimuth about the nadir direction \[deg\], right-handed from the along-track direction.
        /// At 90°, the point lies opposite to the orbit normal.
        azimuth_deg: f64,
        /// Height of the sphere above the equatorial radius of the Earth \[m\].
        height_m: f64,
    },
    /// A fixed inertial direction, as a unit vector in the axes of the GCRS.
    Fixed(Vector3),
    /// A direction that is fixed in the orbital frame. Its components are along-track, along the
    /// orbit normal, and outward.
    InOrbit(Vector3),
    /// Another satellite, whose orbit is given.
    Satellite(Box<Orbit>),
}

/// Reason why a direction cannot be computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// The target depends on the position of the satellite, but no orbit is given.
    #[error("it depends on the position of the satellite: [orbit] is missing")]
    NoOrbit,
    /// The satellite is inside the sphere of the limb, so no line of sight touches the sphere. The
    /// numbers are the time after the epoch \[s\] and the height of the satellite \[km\].
    #[error("{0:.1} s after the epoch the satellite is below that limb, at a height of {1:.0} km")]
    BelowLimb(f64, f64),
    /// The position on the orbit cannot be computed.
    #[error(transparent)]
    Orbit(#[from] OrbitError),
    /// The Chebyshev fit of the direction failed.
    #[error(transparent)]
    Track(#[from] TrackError),
}

/// A spacecraft on its orbit, and the positions of celestial bodies, from an epoch on.
#[derive(Clone, Debug)]
pub struct Sky {
    clock: Clock,
    orbit: Option<Orbit>,
    rotation: EarthRotation,
    light: Light,
}

/// Duration of a piece of a track \[s\]. With polynomials over such pieces, the fit error for a low
/// orbit by SGP4 is 3e-8 m.
const PIECE: f64 = 600.0;
const DEGREE: usize = 14;

impl Target {
    /// Returns true if the target is at a finite distance, and false if it is only a direction.
    pub fn is_place(&self) -> bool {
        matches!(
            self,
            Self::Sun
                | Self::Moon
                | Self::Nadir
                | Self::Ground { .. }
                | Self::Limb { .. }
                | Self::Satellite(_)
        )
    }
}

impl Sky {
    /// Creates a sky that begins at the epoch of `clock`. If `orbit` is `None`, only the Sun, the
    /// Moon and fixed directions can be targets.
    pub fn new(clock: Clock, orbit: Option<Orbit>, rotation: EarthRotation) -> Self {
        Self { clock, orbit, rotation, light: Light::default() }
    }

    /// Returns the sky with the effects of light `light` included in its directions.
    #[must_use]
    pub fn with_light(self, light: Light) -> Self {
        Self { light, ..self }
    }

    /// Returns the effects of light that directions include.
    pub fn light(&self) -> Light {
        self.light
    }

    /// Returns the clock; its epoch is time zero.
    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Returns the orbit of the spacecraft; `None` if no orbit is given.
    pub fn orbit(&self) -> Option<&Orbit> {
        self.orbit.as_ref()
    }

    /// Returns the position of the spacecraft at `time` \[s\], in the axes of the GCRS \[m\].
    pub(crate) fn place(&self, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        Ok(self.orbit.as_ref().ok_or(SkyError::NoOrbit)?.position_by(time, theory)?)
    }

    /// Returns the velocity of the spacecraft relative to the centre of the Earth at `time` \[s\],
    /// in GCRS axes \[m/s\].
    fn velocity(&self, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        self.rate_of(time, &|time| self.place(time, theory))
    }

    /// Returns the time derivative of a position by finite differences. They are central
    /// differences, except at the ends of a table, where they are one-sided.
    fn rate_of(
        &self,
        time: f64,
        place: &dyn Fn(f64) -> Result<Vector3, SkyError>,
    ) -> Result<Vector3, SkyError> {
        // The differences are of fourth order. For a low orbit their error is 1e-7 m/s.
        const H: f64 = 0.5;
        let at = |steps: f64| place(time + steps * H);
        let centred = || {
            let near = at(1.0)? - at(-1.0)?;
            let far = at(2.0)? - at(-2.0)?;
            Ok((near * 8.0 - far) / (12.0 * H))
        };
        let to_side = |side: f64| {
            let near = at(side)? * 48.0 - at(2.0 * side)? * 36.0;
            let far = at(3.0 * side)? * 16.0 - at(4.0 * side)? * 3.0;
            Ok((near + far - at(0.0)? * 25.0) / (12.0 * H * side))
        };
        match centred() {
            Err(SkyError::Orbit(OrbitError::Beyond(_))) => to_side(1.0).or_else(|_: SkyError| to_side(-1.0)),
            found => found,
        }
    }

    /// Returns the axes of the orbital frame at `time` \[s\] as columns: along-track, orbit normal,
    /// outward.
    fn orbit_axes(&self, time: f64, theory: Theory) -> Result<Matrix3, SkyError> {
        let (r, v) = (self.place(time, theory)?, self.velocity(time, theory)?);
        let outward = r.normalize();
        let normal = r.cross(&v).normalize();
        Ok(Matrix3::from_columns(&[normal.cross(&outward), normal, outward]))
    }

    /// Returns the apparent vector from the spacecraft to a target at `time` \[s\], in metres. If
    /// the target is only a direction, the vector has an arbitrary length.
    pub(crate) fn vector(&self, target: &Target, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        let seen = match target {
            // The antisolar direction is opposite to the apparent Sun.
            Target::AntiSun => return Ok(-self.vector(&Target::Sun, time, theory)?),
            Target::Sun | Target::Moon | Target::Ground { .. } | Target::Limb { .. } => true,
            Target::Fixed(_) | Target::Satellite(_) => true,
            _ => false,
        };
        let vector = match (self.light.takes_time, self.of_earth(target, time, theory)?) {
            (true, Some(there)) => self.by_old_light(target, &there, time, theory)?,
            _ => self.geometric(target, time, theory)?,
        };
        if !(self.light.aberrates && seen) {
            return Ok(vector);
        }
        let velocity = self.velocity_against(target, time, theory)?;
        Ok(match theory {
            Theory::Series => light::aberrated(&vector, &velocity),
            Theory::Full => light::aberrated_fully(&vector, &velocity),
        })
    }

    /// Returns the position of the Moon, a ground station or a satellite at `time` \[s\] in GCRS
    /// axes \[m\]; `None` for all other targets.
    fn of_earth(&self, target: &Target, time: f64, theory: Theory) -> Result<Option<Vector3>, SkyError> {
        Ok(match target {
            Target::Moon => Some(bodies::moon(&self.clock, time)),
            Target::Ground { latitude_deg, longitude_deg, height_m } => {
                let earth = frames::to_earth(&self.clock, time, &self.rotation, theory);
                Some(earth.tr_mul(&frames::station(*latitude_deg, *longitude_deg, *height_m)))
            }
            Target::Satellite(orbit) => Some(orbit.position_by(time, theory)?),
            _ => None,
        })
    }

    /// Returns the vector to the position that an object had when it emitted the light that is seen
    /// now; `there` is its present position. The series theory extrapolates the earlier position
    /// from the velocity of the object. The full theory evaluates the position at the earlier time.
    fn by_old_light(
        &self,
        target: &Target,
        there: &Vector3,
        time: f64,
        theory: Theory,
    ) -> Result<Vector3, SkyError> {
        let here = self.orbit.as_ref().map_or(Ok(Vector3::zeros()), |_| self.place(time, theory))?;
        let was = |time: f64| {
            let place = self.of_earth(target, time, theory)?;
            Ok(place.unwrap_or(*there))
        };
        if theory == Theory::Full {
            let direct = light::delay(|delay| Ok::<_, SkyError>((was(time - delay)? - here).norm()))
                .and_then(|delay| was(time - delay));
            match direct {
                // If the table of positions begins after the earlier time, the earlier position is
                // extrapolated from the velocity.
                Err(SkyError::Orbit(OrbitError::Beyond(_))) => {}
                found => return Ok(found? - here),
            }
        }
        let velocity = self.rate_of(time, &was)?;
        let mut delay = (there - here).norm() / light::C;
        for _ in 0..3 {
            delay = (there - velocity * delay - here).norm() / light::C;
        }
        Ok(there - velocity * delay - here)
    }

    /// Returns the velocity of the spacecraft with which the aberration of a target is computed. It
    /// is relative to the frame of the Sun for the Sun and fixed directions, and relative to the
    /// frame of the Earth for all other targets.
    fn velocity_against(&self, target: &Target, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        let about = self.orbit.as_ref().map_or(Ok(Vector3::zeros()), |_| self.velocity(time, theory))?;
        if !matches!(target, Target::Sun | Target::Fixed(_)) {
            return Ok(about);
        }
        let by_difference = || {
            const MINUTE: f64 = 60.0;
            let sun = |time: f64| bodies::sun(&self.clock, time);
            (sun(time - MINUTE) - sun(time + MINUTE)) / (2.0 * MINUTE)
        };
        let earth = match theory {
            Theory::Series => by_difference(),
            Theory::Full => bodies::earth_by_vsop(&self.clock, time).unwrap_or_else(by_difference),
        };
        Ok(earth + about)
    }

    /// Returns the angle between the apparent and the geometric direction to a target at `time`
    /// \[s\] after the epoch, in radians.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn moved_by_light(&self, target: &Target, time: f64) -> Result<f64, SkyError> {
        let with = |light: Light| self.clone().with_light(light).vector(target, time, Theory::Series);
        let (plain, seen) = (with(Light::default())?, with(Light::APPARENT)?);
        Ok(plain.cross(&seen).norm().atan2(plain.dot(&seen)))
    }

    /// Returns the geometric vector from the spacecraft to a target at `time` \[s\], in metres. If
    /// the target is only a direction, the vector has an arbitrary length.
    pub(crate) fn geometric(&self, target: &Target, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        let from = |far: Vector3| match &self.orbit {
            Some(_) => Ok::<_, SkyError>(far - self.place(time, theory)?),
            None => Ok(far),
        };
        let sun = || match theory {
            Theory::Series => bodies::sun(&self.clock, time),
            Theory::Full => {
                bodies::sun_by_vsop(&self.clock, time).unwrap_or_else(|| bodies::sun(&self.clock, time))
            }
        };
        Ok(match target {
            Target::Sun => from(sun())?,
            Target::AntiSun => -from(sun())?,
            Target::Nadir => -self.place(time, theory)?,
            Target::Zenith => self.place(time, theory)?,
            Target::GeodeticNadir => {
                let earth = frames::to_earth(&self.clock, time, &self.rotation, theory);
                let up = frames::geodetic_up(&(earth * self.place(time, theory)?));
                -(earth.transpose() * up) * EARTH_RADIUS_M
            }
            Target::Velocity { reversed } => {
                self.velocity(time, theory)? * if *reversed { -1.0 } else { 1.0 }
            }
            Target::AlongTrack => self.orbit_axes(time, theory)?.column(0).into_owned(),
            Target::OrbitNormal { reversed } => {
                self.orbit_axes(time, theory)?.column(1) * if *reversed { -1.0 } else { 1.0 }
            }
            Target::Limb { azimuth_deg, height_m } => {
                let (axes, r) = (self.orbit_axes(time, theory)?, self.place(time, theory)?.norm());
                let sine = (EARTH_RADIUS_M + height_m) / r;
                let touches = sine > 0.0 && sine < 1.0;
                if !touches {
                    return Err(SkyError::BelowLimb(time, (r - EARTH_RADIUS_M) / 1e3));
                }
                let cosine = (1.0 - sine * sine).sqrt();
                let (sin, cos) = azimuth_deg.to_radians().sin_cos();
                axes * Vector3::new(sine * cos, -sine * sin, -cosine) * (r * cosine)
            }
            Target::Fixed(vector) => *vector,
            Target::InOrbit(vector) => self.orbit_axes(time, theory)? * vector,
            // A ground station or a satellite is seen from the spacecraft, so an orbit is required.
            // The Moon can also be seen from the centre of the Earth.
            Target::Moon | Target::Ground { .. } | Target::Satellite(_) => {
                let there = self.of_earth(target, time, theory)?.unwrap_or_default();
                if matches!(target, Target::Moon) {
                    from(there)?
                } else {
                    there - self.place(time, theory)?
                }
            }
        })
    }

    /// Returns the direction to a target as a function of time, for use in planners. It is fitted
    /// between `from` and `to` \[s\] after the epoch.
    ///
    /// # Errors
    /// Returns a [`SkyError`] if the target requires an orbit but none is given, or if the orbit
    /// does not cover the interval.
    pub fn direction(&self, target: &Target, from: f64, to: f64) -> Result<Direction, SkyError> {
        if let (Target::Fixed(vector), false) = (target, self.light.aberrates) {
            return Ok(Direction::Fixed(*vector));
        }
        Ok(Direction::Moving(self.track(target, from, to)?))
    }

    /// Returns the disc of the Earth as a direction, fitted between `from` and `to` \[s\] after the
    /// epoch. The angle of a cone about it is measured from the limb of the Earth.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn earth_disc(&self, from: f64, to: f64) -> Result<Direction, SkyError> {
        Ok(Direction::Disc { centre: self.track(&Target::Nadir, from, to)?, radius: EARTH_RADIUS_M })
    }

    /// Returns the geometric vector from the spacecraft to a target \[m\] as a function of time. It
    /// is fitted between `from` and `to` \[s\] after the epoch.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn way(&self, target: &Target, from: f64, to: f64) -> Result<Track, SkyError> {
        Track::fitted(from, to, PIECE, DEGREE, |time| self.geometric(target, time, Theory::Series))
    }

    /// Returns the rotation that maps components in the GCRS to components in Earth-fixed axes
    /// (ITRF), at `time` \[s\] after the epoch.
    pub fn earth_axes(&self, time: f64) -> Matrix3 {
        frames::to_earth(&self.clock, time, &self.rotation, Theory::Series)
    }

    fn track(&self, target: &Target, from: f64, to: f64) -> Result<Track, SkyError> {
        let scale = self.vector(target, from, Theory::Series)?.norm();
        // The scale is a power of two, so that scaling causes no rounding errors.
        let scale = 2f64.powi(scale.log2().floor() as i32);
        Track::fitted(from, to, PIECE, DEGREE, |time| Ok(self.vector(target, time, Theory::Series)? / scale))
            .map(|track| if matches!(target, Target::Nadir) { track.scaled(scale) } else { track })
    }

    /// Returns the unit vector from the spacecraft to a target at `time` \[s\] after the epoch, for
    /// use in witnesses. It is computed without a fit and by the full theories.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn seen(&self, target: &Target, time: f64) -> Result<Vector3, SkyError> {
        Ok(self.vector(target, time, Theory::Full)?.normalize())
    }

    /// Returns the geometric distance from the spacecraft to a target at `time` \[s\] after the
    /// epoch, in metres.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn range(&self, target: &Target, time: f64) -> Result<f64, SkyError> {
        Ok(self.geometric(target, time, Theory::Series)?.norm())
    }
}
