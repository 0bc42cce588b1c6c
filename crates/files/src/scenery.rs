//! The surroundings of a spacecraft while it turns: the Earth below, Sun, Moon, and the target of
//! the end.
//!
//! The scenery does not change a plan: pictures and summaries show it. A plan file holds it as
//! coefficients, so that a report needs no orbit and no ephemeris.

use slewkit::mechanics::direction::Track;
use slewkit::{Matrix3, Vector3};
use slewkit_sky::{EARTH_RADIUS_M, EARTH_RATE_RAD_S, geodetic, meets_ground, station};

/// Radii of Sun and Moon \[m\].
const SUN_RADIUS_M: f64 = 6.957e8;
const MOON_RADIUS_M: f64 = 1.7374e6;

/// The surroundings.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// The vector from the centre of the Earth to the spacecraft, GCRS \[m\]; `None` without an
    /// orbit.
    pub spacecraft: Option<Track>,
    /// The vector to the centre of the Sun \[m\]: from the spacecraft, or from the centre of the
    /// Earth without an orbit.
    pub sun: Track,
    /// The vector to the centre of the Moon.
    pub moon: Track,
    /// The rotation from GCRS to the axes that turn with the Earth, at time zero.
    pub earth: Matrix3,
    /// The target of the end, if it has a name.
    pub target: Option<TargetShown>,
}

/// The target of the end of a maneuver.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetShown {
    /// The name, as in "ground 48.1, 11.6".
    pub name: String,
    /// Geodetic latitude, east longitude \[deg\] and height \[m\] of a station.
    pub station: Option<[f64; 3]>,
    /// Metres in the unit of the vector that the end points along; `None` for a direction without
    /// a distance.
    pub unit_m: Option<f64>,
}

/// A disc among the directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// The name, as in "Sun".
    pub name: &'static str,
    /// The direction to its middle, a unit vector, GCRS.
    pub direction: Vector3,
    /// The angle from its middle to its limb \[rad\].
    pub angular_radius: f64,
}

impl Scenery {
    /// Returns Earth, Moon and Sun as seen at `time` \[s\], the nearest first.
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

    /// Returns the components along the axes that turn with the Earth.
    fn earth_fixed(&self, vector: &Vector3, time: f64) -> Vector3 {
        let (sin, cos) = (EARTH_RATE_RAD_S * time).sin_cos();
        let v = self.earth * vector;
        Vector3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
    }

    /// Returns the geodetic latitude and east longitude below the spacecraft \[deg\].
    pub fn below(&self, time: f64) -> Option<[f64; 2]> {
        let place = self.spacecraft.as_ref()?.at(time)[0];
        Some(geodetic(&self.earth_fixed(&place, time)))
    }

    /// Returns the geodetic latitude and east longitude \[deg\] of where a line of sight, GCRS,
    /// meets the ground; `None` if it passes the Earth.
    pub fn on_ground(&self, direction: &Vector3, time: f64) -> Option<[f64; 2]> {
        let place = self.spacecraft.as_ref()?.at(time)[0];
        let along = self.earth_fixed(direction, time);
        Some(geodetic(&meets_ground(&self.earth_fixed(&place, time), &along)?))
    }

    /// Returns the distance of a targeted station \[m\], and the elevation of the spacecraft
    /// above its horizon \[rad\].
    pub fn station_at(&self, time: f64) -> Option<[f64; 2]> {
        let [latitude, longitude, height] = self.target.as_ref()?.station?;
        let place = self.earth_fixed(&self.spacecraft.as_ref()?.at(time)[0], time);
        let there = station(latitude, longitude, height);
        let up = station(latitude, longitude, height + 1e3) - there;
        let away = place - there;
        Some([away.norm(), std::f64::consts::FRAC_PI_2 - away.cross(&up).norm().atan2(away.dot(&up))])
    }
}
