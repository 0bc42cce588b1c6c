//! The targets of a body axis, seen from a satellite on its orbit.

use crate::bodies;
use crate::frames::{self, EARTH_RADIUS_M, EarthRotation, Theory};
use crate::light::{self, Light};
use crate::orbit::{Orbit, OrbitError};
use crate::time::Clock;
use slewkit::mechanics::direction::{Track, TrackError};
use slewkit::{Direction, Matrix3, Vector3};
use thiserror::Error;

/// The target of a body axis. Sun and Moon are seen from the spacecraft, or from the centre of
/// the Earth without an orbit.
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
    /// The direction down along the normal of the ellipsoid of WGS 84.
    GeodeticNadir,
    /// The direction of the satellite's velocity relative to the stars, or the opposite direction.
    Velocity {
        /// Whether the direction is reversed.
        reversed: bool,
    },
    /// Normal to nadir and orbit normal, forward.
    AlongTrack,
    /// The normal of the orbit `r × v`; or against it.
    OrbitNormal {
        /// Whether the direction is reversed.
        reversed: bool,
    },
    /// A station on the ground.
    Ground {
        /// Geodetic \[deg\].
        latitude_deg: f64,
        /// East \[deg\].
        longitude_deg: f64,
        /// Above the ellipsoid \[m\].
        height_m: f64,
    },
    /// The limb of the Earth, a sphere: where a line of sight touches it.
    Limb {
        /// The azimuth about nadir, right-handed, from the direction along the track \[deg\]; 90 is
        /// opposite to the orbit normal.
        azimuth_deg: f64,
        /// The height of the sphere above the equatorial radius \[m\].
        height_m: f64,
    },
    /// A fixed direction, GCRS, a unit vector.
    Fixed(Vector3),
    /// A vector that is fixed in the orbit: along the track, the orbit normal, outward.
    InOrbit(Vector3),
    /// Another satellite.
    Satellite(Box<Orbit>),
}

/// The reason for which a direction is unknown.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// The target depends on the position of the satellite, and no orbit is given.
    #[error("it depends on the position of the satellite: [orbit] is missing")]
    NoOrbit,
    /// No line of sight touches a sphere from within.
    #[error("{0:.1} s after the epoch the satellite is below that limb, at a height of {1:.0} km")]
    BelowLimb(f64, f64),
    /// The orbit.
    #[error(transparent)]
    Orbit(#[from] OrbitError),
    /// The vector.
    #[error(transparent)]
    Track(#[from] TrackError),
}

/// A spacecraft on its orbit from an epoch on.
#[derive(Clone, Debug)]
pub struct Sky {
    clock: Clock,
    orbit: Option<Orbit>,
    rotation: EarthRotation,
    light: Light,
}

/// Pieces of a track \[s\] and their degree: 3e-8 m of a low orbit by SGP4.
const PIECE: f64 = 600.0;
const DEGREE: usize = 14;

impl Target {
    /// Returns whether it is a place, at a distance, and not only a direction.
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
    /// Builds a sky from an epoch on; without an orbit only Sun, Moon and stars are known.
    pub fn new(clock: Clock, orbit: Option<Orbit>, rotation: EarthRotation) -> Self {
        Self { clock, orbit, rotation, light: Light::default() }
    }

    /// Returns the sky with these effects of light.
    #[must_use]
    pub fn with_light(self, light: Light) -> Self {
        Self { light, ..self }
    }

    /// Returns the effects of light that directions include.
    pub fn light(&self) -> Light {
        self.light
    }

    /// Returns the clock, whose epoch is time zero.
    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Returns the orbit.
    pub fn orbit(&self) -> Option<&Orbit> {
        self.orbit.as_ref()
    }

    /// Returns the position of the spacecraft, GCRS \[m\].
    pub(crate) fn place(&self, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        Ok(self.orbit.as_ref().ok_or(SkyError::NoOrbit)?.position_by(time, theory)?)
    }

    /// Returns the velocity about the Earth.
    fn velocity(&self, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        self.rate_of(time, &|time| self.place(time, theory))
    }

    /// Returns the rate of a position by differences: to both sides, and where a table of them
    /// begins or ends to one.
    fn rate_of(
        &self,
        time: f64,
        place: &dyn Fn(f64) -> Result<Vector3, SkyError>,
    ) -> Result<Vector3, SkyError> {
        // The differences are of fourth order: 1e-7 m/s in a low orbit.
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

    /// Returns the axes of the orbit, columns: along the track, its normal, outward.
    fn orbit_axes(&self, time: f64, theory: Theory) -> Result<Matrix3, SkyError> {
        let (r, v) = (self.place(time, theory)?, self.velocity(time, theory)?);
        let outward = r.normalize();
        let normal = r.cross(&v).normalize();
        Ok(Matrix3::from_columns(&[normal.cross(&outward), normal, outward]))
    }

    /// Returns the vector to the apparent position of a target \[m\], or a vector of any length
    /// along a direction.
    pub(crate) fn vector(&self, target: &Target, time: f64, theory: Theory) -> Result<Vector3, SkyError> {
        let seen = match target {
            // The direction is opposite to the apparent Sun.
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

    /// Returns the position of an object of the Earth that moves by itself, GCRS \[m\]; `None`
    /// for all others.
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

    /// Returns the vector to the position that an object, now at `there`, had when its light left
    /// it. The position follows from the velocity, or, for the full theory, from the position at
    /// that time.
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
                // The table of positions begins later.
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

    /// Returns the velocity of the spacecraft relative to the frame of a target: the frame of the
    /// Earth, or of Sun and stars.
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

    /// Returns the angle by which light moves a target \[rad\], which geometric directions omit.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn moved_by_light(&self, target: &Target, time: f64) -> Result<f64, SkyError> {
        let with = |light: Light| self.clone().with_light(light).vector(target, time, Theory::Series);
        let (plain, seen) = (with(Light::default())?, with(Light::APPARENT)?);
        Ok(plain.cross(&seen).norm().atan2(plain.dot(&seen)))
    }

    /// Returns the vector to a target \[m\], or along a direction, of any length.
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
            // These targets need the position of the satellite.
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

    /// Returns the direction to a target over `from … to` \[s\] after the epoch, for plans.
    ///
    /// # Errors
    /// A [`SkyError`]: no orbit, or none that reaches so far.
    pub fn direction(&self, target: &Target, from: f64, to: f64) -> Result<Direction, SkyError> {
        if let (Target::Fixed(vector), false) = (target, self.light.aberrates) {
            return Ok(Direction::Fixed(*vector));
        }
        Ok(Direction::Moving(self.track(target, from, to)?))
    }

    /// Returns the disc of the Earth over `from … to` \[s\]: cones about it begin at its limb.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn earth_disc(&self, from: f64, to: f64) -> Result<Direction, SkyError> {
        Ok(Direction::Disc { centre: self.track(&Target::Nadir, from, to)?, radius: EARTH_RADIUS_M })
    }

    /// Returns the geometric vector to a target \[m\] over `from … to` \[s\] after the epoch.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn way(&self, target: &Target, from: f64, to: f64) -> Result<Track, SkyError> {
        Track::fitted(from, to, PIECE, DEGREE, |time| self.geometric(target, time, Theory::Series))
    }

    /// Returns the rotation from components in GCRS to components in the axes of the Earth (ITRF),
    /// `time` \[s\] after the epoch.
    pub fn earth_axes(&self, time: f64) -> Matrix3 {
        frames::to_earth(&self.clock, time, &self.rotation, Theory::Series)
    }

    fn track(&self, target: &Target, from: f64, to: f64) -> Result<Track, SkyError> {
        let scale = self.vector(target, from, Theory::Series)?.norm();
        // Lengths that are exact powers of two: the digits stay.
        let scale = 2f64.powi(scale.log2().floor() as i32);
        Track::fitted(from, to, PIECE, DEGREE, |time| Ok(self.vector(target, time, Theory::Series)? / scale))
            .map(|track| if matches!(target, Target::Nadir) { track.scaled(scale) } else { track })
    }

    /// Returns the unit vector to a target, for a witness: not fitted, and by the full theories.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn seen(&self, target: &Target, time: f64) -> Result<Vector3, SkyError> {
        Ok(self.vector(target, time, Theory::Full)?.normalize())
    }

    /// Returns the distance to a target \[m\].
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn range(&self, target: &Target, time: f64) -> Result<f64, SkyError> {
        Ok(self.geometric(target, time, Theory::Series)?.norm())
    }
}
