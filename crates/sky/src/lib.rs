//! Directions of targets: orbits, Sun and Moon, stations on the ground, frames and time scales.
//!
//! Axes are the axes of the GCRS, the origin is the centre of the Earth, time is elapsed seconds
//! since the epoch of a [`Clock`], and lengths are metres. A [`Sky`] is a spacecraft on its orbit
//! from an epoch on. It converts a [`Target`] to a [`Direction`](slewkit::Direction): the vector to
//! it, fitted once by Chebyshev polynomials, so that its derivatives are consistent (the velocity
//! of SGP4 differs from the derivative of its position by up to 2e-4). [`Sky::seen`] evaluates a
//! target without a fit and, if available, by another theory, for witnesses.
//!
//! | | planner | witness |
//! |---|---|---|
//! | precession and nutation | seven arguments, 0.063″ | IAU 2006/2000A |
//! | Sun | series of 30 terms, 3.8″ | VSOP2000 (`epv00`), 0.01″ |
//! | Moon | ELP abridged (`moon98`), 9.6″ from 2024 to 2030, 12″ from 2000 to 2050 | the same |
//! | orbit | SGP4, two-body, J2, a table | the planner's theories, not fitted |
//!
//! Directions are geometric by default, because star trackers and payloads differ in their
//! corrections. A [`Light`] changes this: aberration is 20.5″ for the Sun and stars, and 5″ for
//! everything in a low orbit; light time is 1″ for stations and 0.7″ for the Moon. UT1 − UTC and
//! the motion of the pole affect stations only, by at most 120 m and 15 m if they are assumed
//! zero.

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
