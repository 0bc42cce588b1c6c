//! Figures in messages: four digits, or more if two figures would not differ, rounded to the side
//! that keeps a claim true.

pub(super) use crate::numerics::figures::{about, at_least, at_most, exceeding};

use crate::Vector3;

/// Returns a direction in words, each component to four decimals.
pub(super) fn direction(axis: &Vector3) -> String {
    // Adding zero avoids −0.
    let [x, y, z] = [axis.x, axis.y, axis.z].map(|part| (part * 1e4).round() / 1e4 + 0.0);
    format!("({x}, {y}, {z})")
}
