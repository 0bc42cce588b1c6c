//! Branches of smoothed extremals: from each base down to a small ε, unbiased and tipped by biases of the law.
//!
//! A symmetric maneuver's unbiased path stays on its symmetric branch, a saddle; a bias of the switching functions tips
//! it off where branches part, and vanishes with ε.

use super::base::{BRANCHING, base};
use super::extremal::{Bias, Extremal};
use super::smooth::{Smooth, Smoothed, descend};
use crate::maneuver::problem::Path as Way;
use crate::maneuver::settings::Thoroughness;
use crate::{Vector3, lie};
use std::f64::consts::TAU;

/// What is searched for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ask {
    pub path: Way,
    pub thoroughness: Thoroughness,
    /// Whether arcs at the limits are looked for, or smoothed extremals are the answer.
    pub arcs: bool,
}

/// Beyond this angle the other way round is a rival \[rad\].
const OTHER_SENSE: f64 = 1.745;

/// Boundary rates in the unit of time beyond which it is at any angle.
const FAST: f64 = 0.3;

/// ε at which branches are compared, for an angle of a radian and more.
const COMPARED: f64 = 0.008;

/// The same where fuel counts.
const COMPARED_FUEL: f64 = 0.02;

/// A base that costs more than the best by this is no rival.
const RIVAL_BASE: f64 = 1.15;

/// What branches are tried with: nothing, and where more than the quickest answer is wanted, biases.
fn biases(thoroughness: Thoroughness) -> Vec<Bias> {
    let sizes: &[f64] = match thoroughness {
        Thoroughness::Quick => &[],
        Thoroughness::Default => &[1.0],
        Thoroughness::Thorough => &[1.0, 0.5, 2.0],
    };
    let scaled = |size: &f64| {
        let size = *size;
        directions().map(move |bias| Bias { constant: size * bias.constant, linear: size * bias.linear })
    };
    std::iter::once(Bias::default()).chain(sizes.iter().flat_map(scaled)).collect()
}

/// Constant biases along each axis, and mixed ones.
pub(super) fn directions() -> impl Iterator<Item = Bias> {
    let constant = (0..6).map(|k| Bias {
        constant: Vector3::ith(k / 2, if k % 2 == 0 { 2.0 } else { -2.0 }),
        linear: Vector3::zeros(),
    });
    let mixed = (0..4).map(|k| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let a = k % 3;
        let constant = Vector3::ith(a, 2.0 * sign(0)) + Vector3::ith((a + 2) % 3, 1.4);
        Bias { constant, linear: Vector3::ith((a + 1) % 3, 2.0 * sign(1)) }
    });
    constant.chain(mixed)
}

/// Rotation vectors to the target: those that are asked for; of the best the short way, and the other where it may be
/// shorter in time.
fn ways(extremal: &Extremal, path: &Way) -> Vec<Vector3> {
    let phi = lie::log(&extremal.end_attitude);
    let angle = phi.norm();
    // No turn at all has no axis: any other way round is about the first.
    let axis = if angle > 0.0 { phi / angle } else { Vector3::x() };
    let other = axis * (angle - TAU);
    let fast = extremal.start_rate.norm() + extremal.end_rate.norm() > FAST;
    match path {
        Way::AsGiven(vector) => vec![*vector],
        Way::Best if angle > OTHER_SENSE || fast => vec![phi, other],
        Way::Best => vec![phi],
        // Against the motion without inputs; where that turns far, either may be it.
        Way::Shortest if !fast => vec![phi],
        Way::Long if !fast => vec![other],
        Way::Shortest | Way::Long => vec![phi, other],
    }
}

/// Distinct extremals at a small ε, the best first.
pub(super) fn branches(
    extremal: &Extremal,
    ask: &Ask,
    stop: &dyn Fn() -> bool,
    sweeps: &mut usize,
) -> Vec<Smoothed> {
    let mut bases: Vec<Smoothed> = Vec::new();
    for phi in ways(extremal, &ask.path) {
        if let Some(found) = base(extremal, &phi, sweeps)
            && !bases.iter().any(|known| same(extremal, known, &found))
        {
            bases.push(found);
        }
    }
    let least = |found: &[Smoothed]| found.iter().map(|one| one.cost(extremal)).fold(f64::INFINITY, f64::min);
    let limit = RIVAL_BASE * least(&bases);
    bases.retain(|one| one.cost(extremal) <= limit);
    let angle = lie::log(&extremal.end_attitude).norm();
    // Switching functions of minimum time grow with the angle; those of fuel are of the size of its price.
    let target = if extremal.counts_fuel() { COMPARED_FUEL } else { COMPARED * angle.clamp(0.03, 1.0) };
    let mut found: Vec<Smoothed> = Vec::new();
    for from in &bases {
        for bias in biases(ask.thoroughness) {
            if stop() {
                break;
            }
            let Ok(reached) = descend(extremal, from, target.min(BRANCHING), &bias, sweeps) else { continue };
            let smooth =
                Smooth { extremal, epsilon: reached.epsilon, bias: Bias::default(), accurate: false };
            // Fuel tells branches apart less sharply than time.
            let tolerance =
                if extremal.counts_fuel() { 1e-5 } else { (0.1 * reached.epsilon).clamp(1e-4, 1e-2) };
            let Some(path) = smooth.solve(reached.path, tolerance, 20, sweeps) else {
                continue;
            };
            let one = Smoothed { path, epsilon: reached.epsilon };
            if !found.iter().any(|known| same(extremal, known, &one)) {
                found.push(one);
            }
        }
    }
    found.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    found
}

/// Whether two paths are one extremal.
fn same(extremal: &Extremal, a: &Smoothed, b: &Smoothed) -> bool {
    let (cost_a, cost_b) = (a.cost(extremal), b.cost(extremal));
    let costate = |one: &Smoothed| (one.path.m, one.path.nodes[0].e);
    let ((am, ae), (bm, be)) = (costate(a), costate(b));
    // A sum of fuel is known less well than a duration.
    let (costs, costates) = if extremal.counts_fuel() { (2e-3, 2e-2) } else { (1e-4, 1e-2) };
    (cost_a - cost_b).abs() < costs * cost_a.abs()
        && (am - bm).norm() + (ae - be).norm() < costates * (am.norm() + ae.norm())
}
