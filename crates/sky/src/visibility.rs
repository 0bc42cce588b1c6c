//! Visibility over time: when a ground station sees the satellite above its horizon, and when the
//! Earth hides the Sun or another target from the satellite.
//!
//! The Earth is a sphere with its equatorial radius R. r is the distance of the satellite from the
//! centre of the Earth, d its distance from the Sun, and R_S the radius of the Sun. φ is the angle
//! at the satellite between the centres of the Earth and the Sun. α and σ are the apparent angular
//! radii of the Earth and the Sun, `sin α = R/r` and `sin σ = R_S/d`:
//!
//! ```text
//! φ < α − σ : umbra, the Sun is hidden        φ < α + σ : penumbra or umbra, a part is hidden
//! ```
//!
//! In a low orbit, the times of entry and exit have errors of some ten seconds. The errors are
//! larger if the Sun grazes the limb, because the atmosphere refracts and absorbs light, and
//! because the Earth is oblate.

use crate::bodies;
use crate::frames::{self, EARTH_RADIUS_M, Theory};
use crate::target::{Sky, SkyError, Target};
use slewkit::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Radius of the Sun \[m\] (nominal value of IAU 2015 Resolution B3).
const SUN_RADIUS_M: f64 = 6.957e8;

/// Sampling interval of the search for time intervals of visibility and shadow \[s\]. Shorter
/// intervals may be missed, but a pass above the horizon or through the shadow lasts minutes.
const LOOK: f64 = 20.0;

/// A time interval in which a condition holds, in seconds after the epoch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Time at which the condition begins to hold, or the start of the search \[s\].
    pub from: f64,
    /// Time at which the condition ceases to hold, or the end of the search \[s\].
    pub to: f64,
}

/// A condition of illumination or visibility, which holds during some time intervals.
#[derive(Clone, Debug)]
pub enum Condition {
    /// At least a part of the Sun is visible: the satellite is not in the umbra.
    Sunlit,
    /// The Earth hides at least a part of the Sun: the satellite is in the penumbra or the umbra.
    Eclipsed,
    /// The Earth does not hide the target from the satellite. If the target is a ground station,
    /// the satellite is above its horizon.
    Visible(Target),
}

impl Condition {
    /// Returns the time intervals between `from` and `to` \[s\] after the epoch in which the
    /// condition holds.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn windows(&self, sky: &Sky, from: f64, to: f64) -> Result<Vec<Window>, SkyError> {
        intervals(from, to, &|time| self.holds(sky, time))
    }

    /// Returns whether the condition holds at `time` \[s\] after the epoch.
    ///
    /// # Errors
    /// Returns the errors of [`Sky::direction`].
    pub fn holds(&self, sky: &Sky, time: f64) -> Result<bool, SkyError> {
        let place = sky.place(time, Theory::Series)?;
        let limb = (EARTH_RADIUS_M / place.norm()).min(1.0).asin();
        let sun = || {
            let to = bodies::sun(sky.clock(), time) - place;
            (angle_between(&-place, &to), (SUN_RADIUS_M / to.norm()).asin())
        };
        Ok(match self {
            Self::Sunlit => {
                let (apart, radius) = sun();
                apart > limb - radius
            }
            Self::Eclipsed => {
                let (apart, radius) = sun();
                apart < limb + radius
            }
            Self::Visible(Target::Ground { latitude_deg, longitude_deg, height_m }) => {
                elevation(sky, *latitude_deg, *longitude_deg, *height_m, time)? > 0.0
            }
            Self::Visible(Target::Nadir | Target::GeodeticNadir | Target::Limb { .. }) => true,
            Self::Visible(target) => {
                let to = sky.vector(target, time, Theory::Series)?;
                let before_limb = matches!(target, Target::Satellite(_))
                    && to.norm_squared() < place.norm_squared() - EARTH_RADIUS_M.powi(2);
                before_limb || angle_between(&-place, &to) > limb
            }
        })
    }
}

/// Returns the elevation of the satellite above the horizon of a ground station \[rad\] at `time`
/// \[s\] after the epoch. The latitude is geodetic, the longitude is measured to the east, and the
/// height is relative to the WGS 84 ellipsoid.
///
/// # Errors
/// Returns the errors of [`Sky::direction`].
pub fn elevation(
    sky: &Sky,
    latitude_deg: f64,
    longitude_deg: f64,
    height_m: f64,
    time: f64,
) -> Result<f64, SkyError> {
    let station = Target::Ground { latitude_deg, longitude_deg, height_m };
    let up = sky.earth_axes(time).tr_mul(&frames::up(latitude_deg, longitude_deg));
    let away = -sky.geometric(&station, time, Theory::Series)?;
    Ok(FRAC_PI_2 - angle_between(&away, &up))
}

fn angle_between(a: &Vector3, b: &Vector3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Returns the time intervals in which a condition holds. The error of their ends is at most a
/// millisecond.
fn intervals(
    from: f64,
    to: f64,
    holds: &dyn Fn(f64) -> Result<bool, SkyError>,
) -> Result<Vec<Window>, SkyError> {
    let border = |mut low: f64, mut high: f64, at_low: bool| {
        while high - low > 1e-3 {
            let middle = 0.5 * (low + high);
            if holds(middle)? == at_low { low = middle } else { high = middle }
        }
        Ok::<_, SkyError>(0.5 * (low + high))
    };
    let mut found = Vec::new();
    let (mut time, mut now) = (from, holds(from)?);
    let mut since = from;
    while time < to {
        let next = (time + LOOK).min(to);
        let then = holds(next)?;
        match (now, then) {
            (false, true) => since = border(time, next, false)?,
            (true, false) => found.push(Window { from: since, to: border(time, next, true)? }),
            _ => {}
        }
        (time, now) = (next, then);
    }
    if now {
        found.push(Window { from: since, to });
    }
    Ok(found)
}
