//! Reading of `[body]`: inertia and mass.

use super::quantity as q;
use super::{Section, short, show};
use crate::rounding;
use slewkit::Matrix3;
use slewkit::mechanics::{Inertia, InertiaError};
use slewkit::numerics::figures::{rounded, told_apart};

/// Largest relative asymmetry of an inertia for which no warning is given: a unit in the last digit
/// of an element.
const SILENT_ASYMMETRY: f64 = 1e-15;
/// Smallest principal moment of inertia \[kg·m²\], smallest weight and smallest length of an axis.
/// With smaller numbers, products in the solvers could underflow.
pub(crate) const SMALLEST: f64 = 1e-30;
/// Smallest plausible density of a body within its radius of gyration \[kg/m³\]. A lower density
/// suggests that the inertia has another unit.
const THINNEST: f64 = 1e-5;

/// Reads the inertia, checks it and returns it.
pub(crate) fn inertia(body: &Section) -> Option<Inertia> {
    let name = "inertia_kg_m2";
    checked(body.matrix(name)?, body, name)
}

/// Checks the inertia matrix under the key `key`, and returns it as an inertia.
pub(crate) fn checked(matrix: Matrix3, section: &Section, key: &str) -> Option<Inertia> {
    let (inertia, excess) = match Inertia::of_rounded(matrix, rounding::MOMENT) {
        Ok(found) => found,
        Err(error) => {
            let (code, reason, remedy) = refusal(&error);
            return section.refuse(code, key, reason, remedy);
        }
    };
    let smallest = inertia.principal()[0];
    if smallest < SMALLEST {
        let reason = format!(
            "the smallest principal moment, {} kg·m², is outside the range of an inertia, {SMALLEST:e} to {:e} kg·m²",
            short(smallest),
            q::INERTIA.largest
        );
        return section.refuse("E0031", key, reason, "check the exponent and the unit");
    }
    let asymmetry = (matrix - matrix.transpose()).amax() / matrix.amax();
    if asymmetry > SILENT_ASYMMETRY {
        let reason =
            format!("the inertia is asymmetric by {} of its size; its mean is used", short(asymmetry));
        section.warn("W0040", key, reason, "write the same number on both sides of the diagonal");
    }
    if excess > 0.0 {
        let reason = format!(
            "the largest principal moment exceeds the sum of the others by {} of itself: it is \
            reduced to the sum, as for a flat plate",
            short(excess)
        );
        section.warn("W0042", key, reason, "write more digits; a step may then turn at most 0.5 rad");
    } else if inertia.is_degenerate() {
        let [a, b, c] = <[f64; 3]>::from(*inertia.principal()).map(short);
        let reason = format!("the principal moments {a}, {b}, {c} are those of a flat plate or a thin rod");
        let remedy = "no action is needed if this is intended; a step may then turn at most 0.5 rad";
        section.warn("W0042", key, reason, remedy);
    }
    Some(inertia)
}

/// Returns the code, the reason and the remedy for an impossible inertia.
fn refusal(error: &InertiaError) -> (&'static str, String, &'static str) {
    match error {
        InertiaError::NotSymmetric { row, column, upper, lower } => (
            "E0040",
            format!(
                "the inertia is not symmetric: row {row} column {column} is {}, row {column} column {row} is {}",
                show(*upper),
                show(*lower)
            ),
            "write the same number on both sides of the diagonal",
        ),
        InertiaError::NotPositive { smallest } => (
            "E0041",
            format!("the smallest principal moment of inertia is {}: it must be positive", short(*smallest)),
            "check the diagonal, and the signs of the off-diagonal elements: Jxy = −∫xy dm",
        ),
        InertiaError::Triangle { principal: [a, b, c] } => {
            let [largest, sum] = told_apart([*c, a + b], 6, rounded);
            let reason = format!(
                "no body has the principal moments {}, {}, {largest}: the largest exceeds the sum of the others, {sum}",
                rounded(*a, 6),
                rounded(*b, 6),
            );
            let remedy = "check the moments and the signs of the off-diagonal elements: Jxy = −∫xy dm";
            ("E0042", reason, remedy)
        }
        InertiaError::IllConditioned { ratio } => (
            "E0045",
            format!(
                "the principal moments differ by a factor of {}: it must be at most {:e}",
                short(*ratio),
                Inertia::CONDITION
            ),
            "give the thin axis a realistic moment",
        ),
        InertiaError::NotFinite => ("E0030", "the inertia is not finite".into(), "write finite numbers"),
    }
}

/// Warns if the inertia does not fit the mass, for example if it is in g·cm² instead of kg·m².
pub(crate) fn warn_density(body: &Section, inertia: &Inertia, mass: f64) {
    let radius = (inertia.mean() / mass).sqrt();
    let density = mass / radius.powi(3);
    if density < THINNEST {
        let reason =
            format!("{} kg with this inertia spread over {} m: a very thin body", show(mass), short(radius));
        body.warn("W0043", "inertia_kg_m2", reason, "is the inertia in g·cm²? 1 g·cm² is 1e-7 kg·m²");
    }
}
