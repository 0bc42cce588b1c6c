//! Reading of the keys of a target: angles, vectors, places and coefficients.

use super::super::{Section, orbit, short, show};
use slewkit::mechanics::direction::Track;
use slewkit::{Direction, Vector3};
use slewkit_sky::Target;

/// Reads a fixed direction, which is given by angles or as a vector.
pub(in crate::spec) fn star(section: &Section) -> Option<Vector3> {
    let (angles, vector) = (["ra_deg", "dec_deg"], "vector");
    let given: Vec<&str> = angles.into_iter().filter(|name| section.has(name)).collect();
    match (&given[..], section.has(vector)) {
        ([name, ..], true) => {
            let reason = format!("the direction is given twice, by `{name}` and by `vector`");
            section.refuse("E0028", vector, reason, "give only one of the two")
        }
        ([], true) => {
            let vector = section.vector(vector)?;
            if vector.amax() == 0.0 {
                let reason = "a vector of length zero has no direction";
                return section.refuse("E0054", "vector", reason, "give a nonzero vector");
            }
            Some(section.unit(vector))
        }
        ([_, _], false) => {
            let range = |name: &str, least: f64, most: f64, what: &str| {
                let angle = section.number(name)?;
                if (least..=most).contains(&angle) {
                    return Some(angle.to_radians());
                }
                let reason =
                    format!("`{name}`: {what} of {} deg is outside {least} to {most} deg", show(angle));
                let remedy = "check the order and the unit of the angles";
                section.refuse("E0074", name, reason, remedy)
            };
            let ra = range("ra_deg", -180.0, 360.0, "a right ascension");
            let dec = range("dec_deg", -90.0, 90.0, "a declination");
            let ((sin_ra, cos_ra), (sin_dec, cos_dec)) = (ra?.sin_cos(), dec?.sin_cos());
            Some(section.unit(Vector3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec)))
        }
        ([name], false) => {
            let other = if *name == "ra_deg" { "dec_deg" } else { "ra_deg" };
            let reason = format!("`{name}` needs `{other}`");
            section.refuse_here("E0021", reason, format!("add {other} = 0"))
        }
        (_, false) => {
            // The error that a celestial body needs another key has already been reported.
            if !section.has("body") {
                let reason = "the direction is empty";
                section.error_here("E0021", reason, "add ra_deg = 231.0, dec_deg = -18.3");
            }
            None
        }
    }
}

/// Returns the keys that belong to a target whose key `at` has the word `word`.
fn keys_of(word: &str) -> &'static [&'static str] {
    match word {
        "ground" => &["latitude_deg", "longitude_deg", "height_m"],
        "limb" => &["azimuth_deg", "height_m"],
        "satellite" => orbit::KEYS,
        "orbit_vector" => &["orbit_vector"],
        "turning" => &["turning_vector", "turning_rate_deg_s"],
        "track" => &["from_s", "piece_s", "terms", "coefficients", "disc_radius"],
        _ => &[],
    }
}

/// Reports an error for each key that belongs to another word of the key `at`. A key without effect
/// is probably a mistake.
pub(super) fn own_keys(section: &Section, word: &str) -> Option<()> {
    let own = keys_of(word);
    for owner in ["ground", "limb", "satellite", "orbit_vector", "turning", "track"] {
        if let Some(key) = keys_of(owner).iter().find(|key| section.has(key) && !own.contains(key)) {
            let reason = format!("`{key}` belongs to at = \"{owner}\", not to \"{word}\"");
            return section.refuse("E0029", key, reason, "remove the key, or name the other target");
        }
    }
    Some(())
}

pub(super) fn named(word: &str, section: &Section) -> String {
    if word != "ground" {
        return word.replace('_', " ");
    }
    let number = |name: &str| section.number(name).map_or_else(String::new, short);
    format!("ground {}, {}", number("latitude_deg"), number("longitude_deg"))
}

pub(super) fn axis(section: &Section, name: &str) -> Option<Vector3> {
    let axis = section.vector(name)?;
    if axis.amax() == 0.0 {
        return section.refuse(
            "E0054",
            name,
            "a vector of length zero has no direction",
            "give a nonzero vector",
        );
    }
    Some(section.unit(axis))
}

pub(super) fn station(section: &Section) -> Option<Target> {
    let range = |name: &str, most: f64| {
        if !section.has(name) {
            let reason = format!("`at = \"ground\"` needs `{name}`");
            return section.refuse_here("E0021", reason, format!("add {name} = 48.1"));
        }
        let value = section.number(name)?;
        if value.abs() <= most {
            return Some(value);
        }
        let reason = format!("`{name}` of {} deg is outside −{most} to {most} deg", short(value));
        section.refuse("E0074", name, reason, "check the order and the unit of the angles")
    };
    let (latitude_deg, longitude_deg) = (range("latitude_deg", 90.0), range("longitude_deg", 360.0));
    let height_m = section.number("height_m").unwrap_or(0.0);
    Some(Target::Ground { latitude_deg: latitude_deg?, longitude_deg: longitude_deg?, height_m })
}

/// Reads a moving direction that is given by Chebyshev coefficients, as in plan files.
pub(super) fn track(section: &Section) -> Option<Direction> {
    let (from, piece) = (section.number("from_s").unwrap_or(0.0), section.number("piece_s"));
    let (terms, all) = (section.count("terms"), section.vectors("coefficients"));
    let (Some(piece), Some(all)) = (piece, all) else {
        let reason = "`at = \"track\"` needs `piece_s` and `coefficients`";
        return section.refuse_here(
            "E0021",
            reason,
            "give the length of a piece, and its Chebyshev coefficients",
        );
    };
    let terms = terms.unwrap_or(all.len());
    if terms == 0 || all.len() % terms != 0 {
        let reason =
            format!("the number of coefficients, {}, is not a multiple of `terms`, {terms}", all.len());
        return section.refuse("E0026", "coefficients", reason, "give as many for each piece");
    }
    let pieces = all.chunks(terms).map(<[Vector3]>::to_vec).collect();
    let track = Track::of_pieces(from, piece, pieces);
    let track = track
        .map_err(|error| section.error("E0076", "coefficients", error.to_string(), "check the numbers"))
        .ok()?;
    let radius = if section.knows("disc_radius") { section.number("disc_radius") } else { None };
    Some(match radius {
        Some(radius) => Direction::Disc { centre: track, radius },
        None => Direction::Moving(track),
    })
}
