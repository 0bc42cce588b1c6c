//! The times at which a target is visible: a station above its horizon, the Sun past the Earth.
//!
//! The Earth is a sphere of its equatorial radius. Let r be the position of the satellite, φ the
//! angle at it between the centres of the Earth and of the Sun, and let α and σ be the angles under
//! which their radii are seen, `sin α = R/r` and `sin σ = R_S/d`,
//!
//! ```text
//! φ < α − σ : umbra, nothing of the Sun is seen        φ < α + σ : a part of it is hidden
//! ```
//!
//! The edges in a low orbit are accurate to some ten seconds. It is less accurate if the Sun grazes
//! the limb, because air bends and dims light, and the Earth is flattened.

use crate::bodies;
use crate::frames::{self, EARTH_RADIUS_M, Theory};
use crate::target::{Sky, SkyError, Target};
use slewkit::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Radius of the Sun \[m\] (IAU 2015 B3).
const SUN_RADIUS_M: f64 = 6.957e8;

/// The sampling interval for windows and shadows \[s\]: a pass above the horizon or through the
/// shadow lasts minutes.
const LOOK: f64 = 20.0;

/// The window of time \[s\] after the epoch in which a condition holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The start of the interval: a station rises.
    pub from: f64,
    /// The end of the interval, or the end of the searched time.
    pub to: f64,
}

/// A condition that holds at some times.
#[derive(Clone, Debug)]
pub enum Condition {
    /// A part of the Sun is seen at least: not in the umbra.
    Sunlit,
    /// A part of the Sun is hidden by the Earth at least: in the penumbra or the umbra.
    Eclipsed,
    /// A target is not hidden by the Earth: of a station, it is above its horizon.
    Visible(Target),
}

impl Condition {
    /// Returns the windows between `from` and `to` \[s\] in which the condition holds.
    ///
    /// # Errors
    /// Passes on the errors of [`Sky::direction`].
    pub fn windows(&self, sky: &Sky, from: f64, to: f64) -> Result<Vec<Window>, SkyError> {
        intervals(from, to, &|time| self.holds(sky, time))
    }

    /// Returns whether it holds at `time` \[s\].
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

/// Returns the elevation of the satellite above the horizon of a station \[rad\].
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

/// Returns the windows in which a condition holds, with borders to a millisecond.
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
