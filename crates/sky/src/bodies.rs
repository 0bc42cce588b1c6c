//! Geocentric positions of the Sun and the Moon, in the axes of the GCRS \[m\].

use crate::frames::ARCSECOND;
use crate::time::Clock;
use slewkit::Vector3;

/// Astronomical unit \[m\].
const AU: f64 = 149_597_870_700.0;
/// Obliquity of the ecliptic at J2000.0 \[″\].
const OBLIQUITY: f64 = 84_381.406;

/// Returns the geocentric position of the Sun \[m\] at `time` \[s\] after the epoch. It is computed
/// from a series of 30 terms, which agrees with DE421 within 3.8″ from 2000 to 2050.
pub(crate) fn sun(clock: &Clock, time: f64) -> Vector3 {
    let t = clock.centuries(time);
    let degrees = |at_zero: f64, rate: f64| ((at_zero + rate * t) % 360.0).to_radians();
    let e = degrees(100.466_457, 35_999.372_853);
    let v = degrees(181.979_801, 58_517.815_676);
    let a = degrees(355.433, 19_140.299_331);
    let j = degrees(34.351_519, 3_034.905_675);
    let d = degrees(297.850_2, 445_267.111_517);
    let m = degrees(357.529_11, 35_999.050_29);
    let seconds = 7.939 * t * t
        + (6892.44 - 17.03 * t) * m.sin()
        + (0.739 * t - 0.356) * m.cos()
        + 71.878 * (2.0 * m).sin()
        + 1.038 * (3.0 * m).sin()
        + 7.240 * (j - e).sin()
        + 6.468 * d.sin()
        - 5.508 * (2.0 * (v - e)).sin()
        + 4.875 * (v - e).sin()
        - 2.800 * (2.0 * (j - e)).sin()
        - 2.595 * j.sin()
        + 0.416 * j.cos()
        + 2.496 * (2.0 * v - 3.0 * e).cos()
        + 2.081 * (2.0 * (a - e)).sin()
        + 0.933 * (2.0 * j - e).sin()
        + 1.350 * (2.0 * j - e).cos()
        + 1.289 * (2.0 * a - e).sin()
        + 1.119 * (2.0 * a - e).cos()
        + 1.335 * (3.0 * v - 4.0 * e).cos()
        - 1.011 * (3.0 * v - 5.0 * e).sin();
    let longitude = degrees(280.464_255, 35_999.370_881_7) + seconds * ARCSECOND;
    let latitude = (46.83 * t * e.sin() + 4.37 * t * e.cos() - 0.695 * t) * ARCSECOND;
    let distance = 1.000_14 - 0.016_707_9 * m.cos() - 0.000_139_54 * (2.0 * m).cos()
        + 4.5e-5 * t * m.cos()
        + 3.1e-5 * d.cos()
        + 1.6e-5 * (j - e).cos();
    let ((sin_l, cos_l), (sin_b, cos_b)) = (longitude.sin_cos(), latitude.sin_cos());
    let (sin, cos) = (OBLIQUITY * ARCSECOND).sin_cos();
    let (x, y, z) = (cos_b * cos_l, cos_b * sin_l, sin_b);
    Vector3::new(x, cos * y - sin * z, sin * y + cos * z) * (distance * AU)
}

/// Returns the geocentric position of the Sun \[m\] at `time` \[s\] after the epoch, computed by
/// VSOP2000 with an error below 0.01″. Returns `None` outside of the years 1900 to 2100.
pub(crate) fn sun_by_vsop(clock: &Clock, time: f64) -> Option<Vector3> {
    let (day, part) = clock.julian_tt(time);
    let (earth, _) = sofars::eph::epv00(day, part)?;
    Some(Vector3::from(earth[0]) * -AU)
}

/// Returns the velocity of the Earth relative to the barycentre of the solar system \[m/s\] at
/// `time` \[s\] after the epoch, computed by VSOP2000. Returns `None` outside of the years 1900 to
/// 2100. Aberration is computed with this velocity, as if the Sun and the stars were at rest
/// relative to the barycentre.
pub(crate) fn earth_by_vsop(clock: &Clock, time: f64) -> Option<Vector3> {
    let (day, part) = clock.julian_tt(time);
    let (_, barycentric) = sofars::eph::epv00(day, part)?;
    Some(Vector3::from(barycentric[1]) * (AU / 86_400.0))
}

/// Returns the geocentric position of the Moon \[m\] at `time` \[s\] after the epoch. It is
/// computed by an abridged ELP 2000-82, which agrees with DE421 within 9.6″ from 2024 to 2030, and
/// within 12″ from 2000 to 2050.
pub(crate) fn moon(clock: &Clock, time: f64) -> Vector3 {
    let (day, part) = clock.julian_tt(time);
    Vector3::from(sofars::eph::moon98(day, part)[0]) * AU
}
