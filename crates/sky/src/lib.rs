//! Directions of targets: orbits, Sun and Moon, stations on the ground, frames and time scales.
//!
//! Vectors have the axes of the GCRS, with the centre of the Earth as the origin. Times are seconds
//! since the epoch of a [`Clock`], and lengths are in metres. A [`Sky`] is a spacecraft on its
//! orbit from this epoch on. It converts a [`Target`] to a [`Direction`](slewkit::Direction), which
//! contains the vector to the target, fitted once by Chebyshev polynomials. The fit makes the
//! derivatives consistent with the vector: the velocity of SGP4 differs from the derivative of its
//! position by up to 2e-4. For the witnesses, [`Sky::seen`] evaluates a target without a fit and,
//! if possible, by another theory.
//!
//! | | planner | witness |
//! |---|---|---|
//! | precession and nutation | seven arguments, 0.063″ | IAU 2006/2000A |
//! | Sun | series of 30 terms, 3.8″ | VSOP2000 (`epv00`), 0.01″ |
//! | Moon | ELP abridged (`moon98`), 9.6″ from 2024 to 2030, 12″ from 2000 to 2050 | the same |
//! | orbit | SGP4, two-body, J2, a table | the planner's theories, not fitted |
//!
//! Directions are geometric by default, because star trackers and payloads apply different
//! corrections. [`Light`] includes the effects of light: aberration is 20.5″ for the Sun and stars,
//! and 5″ for all targets seen from a low orbit; light time shifts ground stations by 1″ and the
//! Moon by 0.7″. UT1 − UTC and polar motion affect only ground stations. If they are assumed to be
//! zero, the errors are at most 120 m and 15 m.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod bodies;
mod frames;
mod light;
mod mean_elements;
mod orbit;
mod target;
mod time;
mod two_lines;
mod visibility;

pub use frames::{
    EARTH_RADIUS_M, EARTH_RATE_RAD_S, EarthRotation, earth_to_gcrs, geodetic, meets_ground, station,
    teme_to_gcrs, true_of_date_to_gcrs,
};
pub use light::Light;
pub use mean_elements::MeanElements;
pub use orbit::{Between, Elements, Model, Orbit, OrbitError, Table, two_body};
pub use target::{Sky, SkyError, Target};
pub use time::{Clock, DATE_OF_LAST_LEAP_SECOND};
pub use two_lines::TwoLinesError;
pub use visibility::{Condition, Window, elevation};

#[cfg(test)]
mod tests;
