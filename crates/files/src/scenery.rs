//! Surroundings of a spacecraft during a maneuver: the Earth, the Sun, the Moon, and the target at
//! the end of the maneuver.
//!
//! The scenery does not affect the plan; it is shown in pictures and summaries. A plan file stores
//! it as polynomial coefficients, so that a report needs neither an orbit nor an ephemeris.

use slewkit::mechanics::direction::Track;
use slewkit::{Matrix3, Vector3};
use slewkit_sky::{EARTH_RADIUS_M, EARTH_RATE_RAD_S, geodetic, meets_ground, station};

/// Radius of the Sun \[m\].
const SUN_RADIUS_M: f64 = 6.957e8;
/// Radius of the Moon \[m\].
const MOON_RADIUS_M: f64 = 1.7374e6;

/// Directions and distances of the Earth, the Sun and the Moon over time, the rotation of the
/// Earth, and the target of the maneuver.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// Position of the spacecraft relative to the centre of the Earth over time, in GCRS axes
    /// \[m\]; `None` if the spec has no orbit.
    pub spacecraft: Option<Track>,
    /// Position of the centre of the Sun over time, in GCRS axes \[m\]. It is relative to the
    /// spacecraft or, if the spec has no orbit, to the centre of the Earth.
    pub sun: Track,
    /// Position of the centre of the Moon over time \[m\], with the origin and axes of `sun`.
    pub moon: Track,
    /// Rotation from GCRS axes to Earth-fixed axes at time zero.
    pub earth: Matrix3,
    /// Target at the end of the maneuver; `None` if the target has no name.
    pub target: Option<TargetShown>,
}

/// Target at the end of a maneuver, as shown in pictures and summaries.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetShown {
    /// Name of the target, such as "ground 48.1, 11.6".
    pub name: String,
    /// Geodetic latitude \[deg\], east longitude \[deg\] and height \[m\], if the target is a
    /// ground station.
    pub station: Option<[f64; 3]>,
    /// Length of one unit of the vector to the target \[m\]; `None` if the target is a direction
    /// without a distance.
    pub unit_m: Option<f64>,
}

/// A celestial body as seen from the spacecraft, which is a disc on the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Name of the body, such as "Sun".
    pub name: &'static str,
    /// Direction to the centre of the disc, as a unit vector in GCRS axes.
    pub direction: Vector3,
    /// Angular radius of the disc \[rad\].
    pub angular_radius: f64,
}

impl Scenery {
    /// Returns the discs of the Earth, the Moon and the Sun at `time` \[s\], in this order. The
    /// Earth is omitted if the spec has no orbit.
    pub fn discs(&self, time: f64) -> Vec<Disc> {
        let disc = |name, to: Vector3, radius: f64| Disc {
            name,
            direction: to.normalize(),
            angular_radius: (radius / to.norm()).min(1.0).asin(),
        };
        let earth = self.spacecraft.as_ref().map(|track| disc("Earth", -track.at(time)[0], EARTH_RADIUS_M));
        let moon = disc("Moon", self.moon.at(time)[0], MOON_RADIUS_M);
        let sun = disc("Sun", self.sun.at(time)[0], SUN_RADIUS_M);
        earth.into_iter().chain([moon, sun]).collect()
    }

    /// Converts the components of `vector` from GCRS axes to Earth-fixed axes at `time` \[s\].
    fn earth_fixed(&self, vector: &Vector3, time: f64) -> Vector3 {
        let (sin, cos) = (EARTH_RATE_RAD_S * time).sin_cos();
        let v = self.earth * vector;
        Vector3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
    }

    /// Returns the geodetic latitude and east longitude \[deg\] of the point on the ground below
    /// the spacecraft at `time` \[s\]; `None` if the spec has no orbit.
    pub fn below(&self, time: f64) -> Option<[f64; 2]> {
        let place = self.spacecraft.as_ref()?.at(time)[0];
        Some(geodetic(&self.earth_fixed(&place, time)))
    }

    /// Returns the geodetic latitude and east longitude \[deg\] of the point at which a line of
    /// sight from the spacecraft in `direction` (GCRS axes) meets the ground at `time` \[s\].
    /// Returns `None` if the spec has no orbit, or if the line misses the Earth.
    pub fn on_ground(&self, direction: &Vector3, time: f64) -> Option<[f64; 2]> {
        let place = self.spacecraft.as_ref()?.at(time)[0];
        let along = self.earth_fixed(direction, time);
        Some(geodetic(&meets_ground(&self.earth_fixed(&place, time), &along)?))
    }

    /// Returns the distance from the spacecraft to the ground station \[m\], and the elevation of
    /// the spacecraft above the horizon of the station \[rad\]. Returns `None` if the target is not
    /// a ground station, or if the spec has no orbit.
    pub fn station_at(&self, time: f64) -> Option<[f64; 2]> {
        let [latitude, longitude, height] = self.target.as_ref()?.station?;
        let place = self.earth_fixed(&self.spacecraft.as_ref()?.at(time)[0], time);
        let there = station(latitude, longitude, height);
        let up = station(latitude, longitude, height + 1e3) - there;
        let away = place - there;
        Some([away.norm(), std::f64::consts::FRAC_PI_2 - away.cross(&up).norm().atan2(away.dot(&up))])
    }
}
