//! Meaning of the names of frames: body frames, orbital frames with their axes, inertial frames.
//!
//! The names come from the registries of SANA (celestial body, orbit-relative and spacecraft body
//! reference frames) and from SPICE. Case is ignored; blanks, hyphens and underscores are
//! equivalent.
//!
//! The axes of orbital frames are expressed in the orbital axes of this program: `e₁` along the
//! velocity, `e₂` along the orbit normal, `e₃` outward. The environment has a circular orbit.
//!
//! | name | x | y | z |
//! |---|---|---|---|
//! | VNC | e₁ | e₂ | e₃ |
//! | LVLH, VVLH | e₁ | −e₂ | −e₃ |
//! | RTN, RSW, QSW, NTW | e₃ | e₁ | e₂ |
//! | TNW | e₁ | −e₃ | e₂ |
//!
//! ICRF and J2000 (EME2000) differ by the frame bias of IAU 2006, 23 milliarcseconds. ECLIPJ2000 is
//! J2000 turned by the obliquity of IAU 1976, as in SPICE.

use slewkit::{Matrix3, Vector3, lie};

/// Meaning of a frame name in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// A frame fixed to the spacecraft.
    Body,
    /// An inertial frame, with the rotation from components in this frame to the ICRF.
    Inertial(Matrix3),
    /// An orbital frame, which turns with the orbit. The matrix maps components in the axes
    /// `e₁, e₂, e₃` (along the velocity, along the orbit normal, outward) to components in this
    /// frame.
    Orbit(Matrix3),
    /// A frame that turns with a celestial body, a frozen orbital frame, or a frame whose axes
    /// depend on a date.
    Moving,
    /// A frame whose name is not in the registries.
    Unknown,
}

/// Names of spacecraft frames in the SANA registry, and older spellings. A number or letters may
/// follow the name.
const BODY: [&str; 18] = [
    "ACC",
    "AST",
    "CSS",
    "DSS",
    "ESA",
    "GYRO",
    "GYRO_FRAME",
    "IMU",
    "IMU_FRAME",
    "INSTRUMENT",
    "MTA",
    "RW",
    "SA",
    "SC",
    "SC_BODY",
    "SENSOR",
    "STARTRACKER",
    "TAM",
];
/// Names of frames whose rotation relative to inertial space this program does not compute.
const MOVING: [&str; 32] = [
    "ALIGN_CB",
    "ALIGN_EARTH",
    "ATF",
    "B1950",
    "CIRS",
    "DTRF",
    "EFG",
    "EME1950",
    "EQW",
    "FIXED",
    "FK4",
    "GTOD",
    "IAU",
    "ITRF",
    "MCI",
    "MDR",
    "MOD",
    "MOE",
    "NSW",
    "PEF",
    "PQW",
    "SEZ",
    "TDR",
    "TEME",
    "TEMEOFDATE",
    "TIRF",
    "TIRS",
    "TOD",
    "TOE",
    "UTOD",
    "WGS84",
    "WGS",
];

/// Returns the meaning of the frame `name`.
pub fn meaning(name: &str) -> Meaning {
    let name: String = name
        .trim()
        .chars()
        .map(|c| if c == ' ' || c == '-' { '_' } else { c.to_ascii_uppercase() })
        .collect();
    // An orbital frame either rotates or is frozen at each time. In a frozen frame, rates are not
    // defined.
    let (axes, frozen) = match name.strip_suffix("_INERTIAL") {
        Some(axes) => (axes, true),
        None => (name.strip_suffix("_ROTATING").unwrap_or(&name), false),
    };
    if let Some(orbit) = of_orbit(axes) {
        return if frozen { Meaning::Moving } else { Meaning::Orbit(orbit) };
    }
    let numbered = |base: &str| {
        let digits = name.strip_prefix(base).map(|rest| rest.trim_start_matches('_'));
        digits.is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()))
    };
    if ["ICRF", "ICRS", "GCRF", "GCRS", "BCRF", "BCRS"].into_iter().any(numbered) {
        return Meaning::Inertial(Matrix3::identity());
    }
    match name.as_str() {
        "J2000" | "EME2000" | "MJ2000EQ" => return Meaning::Inertial(frame_bias()),
        "ECLIPJ2000" => return Meaning::Inertial(frame_bias() * lie::exp(&(Vector3::x() * OBLIQUITY))),
        _ => {}
    }
    let moving = |base: &&str| {
        let rest = name.strip_prefix(*base);
        rest.is_some_and(|rest| {
            rest.is_empty() || rest.starts_with('_') || rest.as_bytes()[0].is_ascii_digit()
        })
    };
    if MOVING.iter().any(moving) {
        return Meaning::Moving;
    }
    // A number or one or two characters may follow the name, as in AST_1 and SC_BODY_A.
    let of_body = |base: &&str| {
        let rest = name.strip_prefix(*base);
        rest.is_some_and(|rest| {
            let label = rest.strip_prefix('_').unwrap_or(rest);
            rest.is_empty()
                || (label.len() <= 2
                    && label.bytes().all(|byte| byte.is_ascii_alphanumeric())
                    && rest != label)
                || (!label.is_empty() && label.bytes().all(|byte| byte.is_ascii_digit()))
        })
    };
    if BODY.iter().any(of_body) { Meaning::Body } else { Meaning::Unknown }
}

/// Names of the orbital frames that files can be written in, as a list for messages.
pub const ORBIT_NAMES: &str = "VNC, LVLH, VVLH, RTN, RSW, QSW, NTW, TNW";

/// Returns the rotation from components in `e₁, e₂, e₃` (along the velocity, along the orbit
/// normal, outward) to components in the orbital frame `name`; `None` if the name is not that of an
/// orbital frame.
fn of_orbit(name: &str) -> Option<Matrix3> {
    let rows = match name {
        "VNC" => [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "LVLH" | "VVLH" => [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
        "RTN" | "RSW" | "QSW" | "NTW" => [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
        "TNW" => [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        _ => return None,
    };
    Some(Matrix3::from_fn(|row, column| f64::from(rows[row][column])))
}

/// One milliarcsecond \[rad\].
const MILLIARCSECOND: f64 = std::f64::consts::PI / (180.0 * 3600.0 * 1000.0);
/// Obliquity of the ecliptic at J2000 according to IAU 1976 \[rad\].
const OBLIQUITY: f64 = 84_381_448.0 * MILLIARCSECOND;

/// Returns the rotation from the mean equator and equinox of J2000 to the ICRF. It is computed from
/// the offsets of the pole ξ₀, η₀ and of the equinox dα₀ (IERS Conventions 2010, 5.6) to first
/// order, with an error of 1e-14.
fn frame_bias() -> Matrix3 {
    let [ascension, xi, eta] = [-14.6, -16.617, -6.8192].map(|angle| angle * MILLIARCSECOND);
    // ICRF components are mapped to J2000 components by R₁(−η₀) R₂(ξ₀) R₃(dα₀), in which each
    // factor rotates the axes.
    lie::exp(&Vector3::new(-eta, xi, ascension))
}

#[cfg(test)]
mod tests {
    use super::{Meaning, frame_bias, meaning};
    use slewkit::{Vector3, lie};

    #[test]
    fn names_of_the_registries_have_their_meaning() {
        for name in [
            "AST_1",
            "SC_BODY_1",
            "sc_body",
            "SC BODY 1",
            "IMU_FRAME_1",
            "STARTRACKER_2",
            "GYRO_FRAME_3",
            "RW_12",
            "INSTRUMENT_A",
            "ACC",
            "SENSOR_1",
        ] {
            assert_eq!(meaning(name), Meaning::Body, "{name}");
        }
        for name in
            ["ITRF2000", "ITRF-97", "TEME", "TOD_EARTH", "LVLH_INERTIAL", "IAU_MARS", "PQW_INERTIAL", "B1950"]
        {
            assert_eq!(meaning(name), Meaning::Moving, "{name}");
        }
        for name in ["ICRF", "GCRF", "icrf3", "EME2000", "J2000", "ECLIPJ2000"] {
            assert!(matches!(meaning(name), Meaning::Inertial(_)), "{name}");
        }
        for name in ["MYFRAME", "SCIENCE", "ACCELERATION", "", "SAT"] {
            assert_eq!(meaning(name), Meaning::Unknown, "{name}");
        }
    }

    /// Each orbital frame has the tabulated axes and is right-handed.
    #[test]
    fn frames_of_the_orbit_have_their_axes() {
        let [velocity, normal, outward] = [Vector3::x(), Vector3::y(), Vector3::z()];
        for (name, axes) in [
            ("LVLH", [velocity, -normal, -outward]),
            ("RTN", [outward, velocity, normal]),
            ("RSW_ROTATING", [outward, velocity, normal]),
            ("TNW", [velocity, -outward, normal]),
            ("VNC", [velocity, normal, outward]),
        ] {
            let Meaning::Orbit(to) = meaning(name) else { panic!("{name}") };
            assert_eq!(to.determinant(), 1.0, "{name}");
            for (k, axis) in axes.iter().enumerate() {
                assert_eq!((to * axis)[k], 1.0, "{name} axis {k}");
            }
        }
    }

    /// Reference: the pole of J2000 in the ICRF is at ξ₀ = −16.617 mas, η₀ = −6.8192 mas (IERS
    /// Conventions 2010, 5.4.4).
    #[test]
    fn the_bias_of_j2000_is_that_of_the_conventions() {
        let pole = frame_bias() * Vector3::z();
        let mas = (1e-3_f64 / 3600.0).to_radians();
        assert!((pole.x / mas + 16.617).abs() < 1e-3 && (pole.y / mas + 6.8192).abs() < 1e-3, "{pole}");
        assert!((lie::log(&frame_bias()).norm() / mas - 23.1).abs() < 0.1);
    }
}
