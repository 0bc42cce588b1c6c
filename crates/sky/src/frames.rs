//! Rotations between orbital axes, Earth-fixed axes and the axes of the GCRS.
//!
//! ```text
//! r_ITRF = W R₃(ERA) C r_GCRS ,      r_GCRS = Cᵀ R₃(GMST82 − ERA) r_TEME ,
//! R₃(θ) = [[c, s, 0], [−s, c, 0], [0, 0, 1]]
//! ```
//!
//! C is computed from the position (X, Y) of the celestial intermediate pole and the locator s of
//! its origin. ERA is the Earth rotation angle, a function of UT1. W is the polar motion. The
//! second equation depends on neither UT1 nor polar motion.

use crate::time::Clock;
use slewkit::{Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// Equatorial radius of the WGS 84 ellipsoid of the Earth \[m\].
pub const EARTH_RADIUS_M: f64 = 6_378_137.0;
/// Flattening of the WGS 84 ellipsoid.
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// The rotation rate of the Earth relative to the stars \[rad/s\].
pub const EARTH_RATE_RAD_S: f64 = 7.292_115_146_7e-5;

/// One arcsecond \[rad\].
pub(crate) const ARCSECOND: f64 = PI / 648_000.0;

/// Parameters of the Earth's rotation that IERS bulletins publish.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EarthRotation {
    /// UT1 − UTC \[s\].
    pub ut1_minus_utc_s: f64,
    /// Polar motion x_p, y_p \[″\].
    pub polar_motion_arcsec: [f64; 2],
}

/// Theory with which precession, nutation, and the positions of the Sun and the Earth are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Theory {
    /// Truncated series, in which nutation has terms of seven arguments. The error of the pole is
    /// below 0.063″ from 1990 to 2050.
    Series,
    /// The full theories: IAU 2006/2000A, and VSOP2000 for the Sun.
    Full,
}

/// Returns the matrix `R₃(θ)` of the module header for the angle θ \[rad\].
fn about_z(angle: f64) -> Matrix3 {
    let (s, c) = angle.sin_cos();
    Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Returns the coordinates X and Y of the pole and the locator s \[rad\], according to IAU 2006 and
/// the largest terms of IAU 2000A. `t` is the time since J2000.0 in Julian centuries of TT.
fn pole(t: f64) -> (f64, f64, f64) {
    let degrees = |at_zero: f64, rate: f64| ((at_zero + rate * t) % 360.0).to_radians();
    let node = degrees(125.044_555_01, -1_934.136_261_9);
    let anomaly = degrees(134.963_402_51, 477_198.867_560_5);
    let sun = degrees(357.529_109_18, 35_999.050_291_1);
    let latitude = degrees(93.272_090_62, 483_202.017_457_7);
    let elongation = degrees(297.850_195_47, 445_267.111_446_9);
    let longitude = latitude - elongation + node;
    let x = -0.0169 + (2004.2074 - 0.552_81 * t) * t - 6.8452 * node.sin() + 0.2059 * t * node.cos()
        - 0.5244 * (2.0 * longitude).sin()
        - 0.0908 * (2.0 * (latitude + node)).sin()
        + 0.0821 * (2.0 * node).sin()
        + 0.0510 * sun.sin()
        - 0.0206 * (sun + 2.0 * longitude).sin()
        + 0.0282 * anomaly.sin();
    let y = -0.0052 - (0.0269 + 22.404_65 * t) * t
        + 9.2052 * node.cos()
        + 0.1530 * t * node.sin()
        + 0.5729 * (2.0 * longitude).cos()
        + 0.0980 * (2.0 * (latitude + node)).cos()
        - 0.0896 * (2.0 * node).cos()
        - 0.0047 * sun.sin()
        + 0.0160 * sun.cos()
        + 0.0224 * (sun + 2.0 * longitude).cos();
    let (x, y) = (x * ARCSECOND, y * ARCSECOND);
    (x, y, -0.5 * x * y)
}

/// Returns the rotation C from the GCRS to the celestial intermediate frame of date, at `time`
/// \[s\] after the epoch.
pub(crate) fn intermediate(clock: &Clock, time: f64, theory: Theory) -> Matrix3 {
    let (x, y, s) = match theory {
        Theory::Series => pole(clock.centuries(time)),
        Theory::Full => {
            let (day, part) = clock.julian_tt(time);
            sofars::pnp::xys06a(day, part)
        }
    };
    let z = (1.0 - x * x - y * y).sqrt();
    let a = 1.0 / (1.0 + z);
    let turned = Matrix3::new(1.0 - a * x * x, -a * x * y, -x, -a * x * y, 1.0 - a * y * y, -y, x, y, z);
    about_z(-s) * turned
}

/// Returns the Earth rotation angle ERA \[rad\] at `time` \[s\] after the epoch.
fn rotation_angle(clock: &Clock, time: f64, rotation: &EarthRotation) -> f64 {
    let (days, part) = clock.days_of_ut1(time, rotation.ut1_minus_utc_s);
    // The angle is computed in turns, and whole turns are removed before the conversion to radians.
    let turns = 0.779_057_273_264 + part + 0.002_737_811_911_354_48 * (days + part);
    TAU * turns.rem_euclid(1.0)
}

/// Returns the rotation from the GCRS to Earth-fixed axes (ITRF), at `time` \[s\] after the epoch.
pub(crate) fn to_earth(clock: &Clock, time: f64, rotation: &EarthRotation, theory: Theory) -> Matrix3 {
    let [x, y] = rotation.polar_motion_arcsec.map(|angle| angle * ARCSECOND);
    // Polar motion: W = R₃(−s') R₂(x_p) R₁(y_p), s' = −47 µas T.
    let s = -47e-6 * ARCSECOND * clock.centuries(time);
    let ((sx, cx), (sy, cy)) = (x.sin_cos(), y.sin_cos());
    let second = Matrix3::new(cx, 0.0, -sx, 0.0, 1.0, 0.0, sx, 0.0, cx);
    let first = Matrix3::new(1.0, 0.0, 0.0, 0.0, cy, sy, 0.0, -sy, cy);
    let wobble = (about_z(s) * second.transpose() * first.transpose()).transpose();
    wobble.transpose() * about_z(rotation_angle(clock, time, rotation)) * intermediate(clock, time, theory)
}

/// Returns the rotation from Earth-fixed axes (ITRF) to the GCRS, at `time` \[s\] after the epoch.
pub fn earth_to_gcrs(clock: &Clock, time: f64, rotation: &EarthRotation) -> Matrix3 {
    to_earth(clock, time, rotation, Theory::Series).transpose()
}

/// Returns the rotation from the true equator and equinox of date (IAU 2006/2000A) to the GCRS, at
/// `time` \[s\] after the epoch.
pub fn true_of_date_to_gcrs(clock: &Clock, time: f64) -> Matrix3 {
    let (day, part) = clock.julian_tt(time);
    let of_date = sofars::pnp::pnm06a(day, part);
    Matrix3::from_fn(|row, column| of_date[column][row])
}

/// Returns the rotation from TEME of date, the frame of two-line elements, to the GCRS, at
/// `time` \[s\] after the epoch.
pub fn teme_to_gcrs(clock: &Clock, time: f64) -> Matrix3 {
    from_teme(clock, time, Theory::Series)
}

/// Returns the rotation from TEME of date (true equator, mean equinox) to the GCRS, at `time` \[s\]
/// after the epoch.
pub(crate) fn from_teme(clock: &Clock, time: f64, theory: Theory) -> Matrix3 {
    let t = clock.centuries(time);
    // Difference GMST82 − ERA at the same UT1. The rotation of the Earth cancels in the difference.
    let apart = (4612.432 * t + 1.3967 * t * t) * ARCSECOND;
    intermediate(clock, time, theory).transpose() * about_z(apart)
}

/// Returns the position of a ground station in Earth-fixed axes \[m\] from its geodetic latitude
/// and east longitude \[deg\] and its height above the WGS 84 ellipsoid \[m\].
pub fn station(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Vector3 {
    let ((sin, cos), (sl, cl)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
    let squared = FLATTENING * (2.0 - FLATTENING);
    let across = EARTH_RADIUS_M / (1.0 - squared * sin * sin).sqrt();
    Vector3::new(
        (across + height_m) * cos * cl,
        (across + height_m) * cos * sl,
        (across * (1.0 - squared) + height_m) * sin,
    )
}

/// Returns the outward normal of the ellipsoid at a geodetic latitude and east longitude \[deg\],
/// as a unit vector in Earth-fixed axes.
pub(crate) fn up(latitude_deg: f64, longitude_deg: f64) -> Vector3 {
    let ((sin, cos), (sl, cl)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
    Vector3::new(cos * cl, cos * sl, sin)
}

/// Returns the geodetic latitude and east longitude \[deg\] of a position in Earth-fixed
/// axes \[m\].
pub fn geodetic(position: &Vector3) -> [f64; 2] {
    let squared = FLATTENING * (2.0 - FLATTENING);
    let longitude = position.y.atan2(position.x);
    let across = position.x.hypot(position.y);
    let mut latitude = position.z.atan2(across * (1.0 - squared));
    // Each iteration multiplies the error by the squared eccentricity. After twelve iterations,
    // only round-off remains.
    for _ in 0..12 {
        let normal = EARTH_RADIUS_M / (1.0 - squared * latitude.sin().powi(2)).sqrt();
        latitude = (position.z + squared * normal * latitude.sin()).atan2(across);
    }
    [latitude.to_degrees(), longitude.to_degrees()]
}

/// Returns the outward normal of the ellipsoid below a position, as a unit vector in Earth-fixed
/// axes.
pub(crate) fn geodetic_up(position: &Vector3) -> Vector3 {
    let [latitude, longitude] = geodetic(position);
    up(latitude, longitude)
}

/// Returns the point at which the ray from `from` in direction `along` first meets the WGS 84
/// ellipsoid, in Earth-fixed axes \[m\]. Returns `None` if the ray misses the ellipsoid.
pub fn meets_ground(from: &Vector3, along: &Vector3) -> Option<Vector3> {
    // Stretching along the polar axis turns the ellipsoid into the unit sphere.
    let stretched = |v: &Vector3| Vector3::new(v.x, v.y, v.z / (1.0 - FLATTENING)) / EARTH_RADIUS_M;
    let (place, direction) = (stretched(from), stretched(along));
    let (square, half, rest) = (direction.norm_squared(), place.dot(&direction), place.norm_squared() - 1.0);
    let discriminant = half * half - square * rest;
    let ahead = half < 0.0 && rest >= 0.0 && discriminant >= 0.0;
    ahead.then(|| from + along * ((-half - discriminant.sqrt()) / square))
}
