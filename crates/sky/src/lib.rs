//! Where targets are: orbits, Sun and Moon, stations on the ground, frames and time scales.
//!
//! Axes are those of the GCRS, origin the centre of the Earth, time is elapsed seconds since the epoch of a [`Clock`], lengths are
//! metres. A [`Sky`] is a spacecraft on its orbit from an epoch on; it makes a [`Direction`](slewkit::Direction) of a [`Target`]: the vector to it,
//! fitted once by Chebyshev polynomials, so that its derivatives belong to it (the velocity that SGP4 states is not the derivative
//! of the position that it states, by up to 2e-4). [`Sky::seen`] evaluates the same without a fit and, where there is one, by another theory:
//! what a witness asks.
//!
//! | | planner | witness |
//! |---|---|---|
//! | precession and nutation | seven arguments, 0.063″ | IAU 2006/2000A |
//! | Sun | series of 30 terms, 3.8″ | VSOP2000 (`epv00`), 0.01″ |
//! | Moon | ELP abridged (`moon98`), 9.6″ from 2024 to 2030, 12″ from 2000 to 2050 | the same |
//! | orbit | SGP4, two-body, J2, a table | the same, not fitted |
//!
//! By default directions are geometric: what a star tracker or a payload corrects differs. A [`Light`] says otherwise: aberration is
//! 20.5″ of the Sun and of stars, and 5″ of all in a low orbit; light time is 1″ of stations and 0.7″ of the Moon. UT1 − UTC and the
//! motion of the pole move stations alone, by 120 m and 15 m at most where they are taken for zero.

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
