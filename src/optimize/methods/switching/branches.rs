//! Branches of smoothed extremals: from each base down to a small ε, unbiased and tipped by biases
//! of the law.
//!
//! A symmetric maneuver's unbiased path stays on its symmetric branch, a saddle; a bias of the
//! switching functions tips it off where branches part, and vanishes with ε.
//!
//! # How is the shortest maneuver found?
//!
//! In four layers, each of which takes away a way to fail (`optimize/methods/switching`). Smoothed
//! extremals, by a Newton that has every node for unknown, so that nothing grows along the
//! maneuver. Branches: from a polynomial path for either way round, by way of the isotropic body,
//! with the law tipped to each side where branches part; an unbiased path of a symmetric maneuver
//! would stay on its saddle, the turn about the axis. What tips it lies askew to the axes of the
//! body, since along them it would have the symmetry as well, and tips each input alike, whatever
//! its limit and the axes of the body; where inputs or moments differ more, and larger, sets of it
//! are tried. The other way round may be far quicker about an axis of its own than about that of
//! the short one: first paths lie beside whole turns about the two fastest axes of the inputs too,
//! and of so many bases the first and the cheapest are tipped.
//! `cargo run --release -p evidence -- dearer thorough` counts: for eight of 300 random maneuvers
//! the thorough search knew shorter ones before, by up to a fifth, now for one. Branches may part
//! below the ε at which they are compared: where the best is no quicker than the turn about a fixed
//! axis, which is known in closed form, the search becomes a thorough one.
//! `cargo run --release -p evidence -- minimum_time plain` counts. To let tipped starts go down on
//! half of the intervals, since most lead to an extremal that is known, is quicker and lost a
//! branch of one public case and of a box. Their bias is left before the last level of ε, when
//! branches have parted, and unless a body is fast levels are further apart on the way: fewer
//! iterations in all. How far apart decides a branch now and then, to either side; so far, none of
//! the public set was lost. Where nothing comes to a small ε, as with fast bodies whose gyroscopic
//! torques are of the size of the limits, first paths come by way of given durations: there the
//! smoothed extremal is one of nearly least effort, which a cubic path is near, and times a factor
//! for its costates and ε it is an extremal of a sought duration. Newton on the switching times,
//! which does not need a switch to exist to converge to it. And the grid: arcs of equal steps each,
//! whose lengths are unknowns; stationarity in the length of an arc (the mean of its discrete
//! Hamiltonians is zero) replaces the switching functions, so that the plan is the exact optimum of
//! its own grid and its error series is even in the step. Where two inputs switch together the arc
//! between them stays in the equations without length: five lengths could not meet six conditions.

use super::base::{Turn, bases, by_durations};
use super::eigenaxis::other_way_may_be_shorter;
use super::extremal::{Bias, Extremal};
use super::smooth::{Intervals, Smooth, Smoothed, descend, descend_by};
use super::tuning::branches::*;
use super::tuning::smooth::{INTERVALS, STEEP};
use super::tuning::{FAR_ITERATIONS, NOTHING};
use super::work::Work;
use crate::maneuver::problem::Path as Way;
use crate::maneuver::settings::Thoroughness;
use crate::maneuver::solution::Outcome;
use crate::numerics::parallel;
use crate::optimize::methods::driver::Interrupt;
use crate::optimize::methods::method::Watch;
use crate::{Vector3, lie};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is searched for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchRequest {
    pub path: Way,
    pub thoroughness: Thoroughness,
    /// Whether arcs at the limits are looked for, or smoothed extremals are the answer.
    pub arcs: bool,
}

/// Distinct extremals at a small ε.
pub(super) struct Branches {
    /// The best first.
    pub found: Vec<Smoothed>,
    /// Those of the maneuver backwards that few intervals hold from its own start alone.
    pub one_way: Vec<Smoothed>,
}

/// What branches are tried with: nothing, and where more than the quickest answer is wanted,
/// biases.
fn biases(extremal: &Extremal, thoroughness: Thoroughness) -> Vec<Bias> {
    let along_axes = Vector3::zeros();
    let sets: &[(f64, Vector3)] = match thoroughness {
        Thoroughness::Quick => &[],
        Thoroughness::Default if extremal.unlikeness() < UNLIKE && extremal.roundness() < UNLIKE => {
            &[(1.0, ASKEW)]
        }
        Thoroughness::Default if extremal.unlikeness() < UNLIKE => &[(2.0, ASKEW)],
        Thoroughness::Default => &[(1.0, ASKEW), (2.0, OTHERWISE), (2.0, ASKEW)],
        Thoroughness::Thorough => &[
            (1.0, ASKEW),
            (2.0, OTHERWISE),
            (2.0, ASKEW),
            (0.5, ASKEW),
            (1.0, OTHERWISE),
            (1.0, along_axes),
            (2.0, along_axes),
        ],
    };
    let of_set = |(size, askew): &(f64, Vector3)| {
        let size = *size;
        directions(extremal, askew)
            .map(move |bias| Bias { constant: size * bias.constant, linear: size * bias.linear })
    };
    std::iter::once(Bias::default()).chain(sets.iter().flat_map(of_set)).collect()
}

/// Constant biases along each of three axes, and mixed ones, of a size that tips each input alike
/// whatever its limit.
pub(super) fn directions(extremal: &Extremal, askew: &Vector3) -> impl Iterator<Item = Bias> + use<> {
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
    let tipped = extremal.alike() * lie::exp(askew);
    let turned = move |bias: Bias| Bias { constant: tipped * bias.constant, linear: tipped * bias.linear };
    constant.chain(mixed).map(turned)
}

fn is_fast(extremal: &Extremal) -> bool {
    extremal.start_rate.norm() + extremal.end_rate.norm() > FAST
}

/// Turns to the target: those that are asked for; of the best the short way, and where it may be
/// shorter in time the other, which about an axis of its own can take a fifth less than about that
/// of the short one. Thrusters may be far stronger about one axis, and to one side of it, than
/// another: theirs begin about all of them, and so does a thorough search.
fn ways(extremal: &Extremal, ask: &SearchRequest) -> Vec<Turn> {
    let phi = lie::log(&extremal.end_attitude);
    let angle = phi.norm();
    // No turn at all has no axis: any other way round is about the first.
    let axis = if angle > 0.0 { phi / angle } else { Vector3::x() };
    let other = axis * (angle - TAU);
    let fast = is_fast(extremal);
    let straight = |vectors: &[Vector3]| vectors.iter().copied().map(Turn::straight).collect();
    match &ask.path {
        Way::AsGiven(vector) => {
            let (angle, mut ways): (_, Vec<Turn>) = (vector.norm(), straight(&[*vector]));
            let rounds = (angle / TAU).round();
            if rounds > 0.0 {
                ways.extend(rounded(extremal, &(vector * (1.0 - rounds * TAU / angle)), rounds));
            }
            ways
        }
        Way::Best => {
            let all = ask.thoroughness == Thoroughness::Thorough || extremal.middle != Vector3::zeros();
            if !(all || fast || other_way_may_be_shorter(extremal, &phi)) {
                return straight(&[phi]);
            }
            let mut ways: Vec<Turn> = straight(&[phi, other]);
            if all || extremal.seeks_time() && ask.thoroughness != Thoroughness::Quick {
                // About the slowest axis nothing is short.
                ways.extend(rounded(extremal, &phi, 1.0).take(if all { 6 } else { 4 }));
            }
            ways
        }
        // Against the motion without inputs; where that turns far, either may be it.
        Way::Shortest if !fast => straight(&[phi]),
        Way::Long if !fast => {
            let mut ways: Vec<Turn> = straight(&[other]);
            ways.extend(rounded(extremal, &phi, 1.0));
            ways
        }
        Way::Shortest | Way::Long => straight(&[phi, other]),
    }
}

/// The rotation vector `phi` beside whole turns about other axes than its own, to either side:
/// first those about which the inputs turn the body the fastest, then those across. All are of one
/// class, and a turn that is nearly whole anyway is one about any axis.
fn rounded(extremal: &Extremal, phi: &Vector3, rounds: f64) -> impl Iterator<Item = Turn> {
    let eigen = (extremal.j_inverse * extremal.authority() * extremal.j_inverse).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let phi = *phi;
    (0..6).map(move |index| {
        let side = if index % 2 == 0 { rounds * TAU } else { -rounds * TAU };
        Turn { phi, whole: side * eigen.eigenvectors.column(order[index / 2]) }
    })
}

/// Distinct extremals at a small ε of the maneuver and, but where a quick answer is asked for, of
/// the same backwards: what a search of one misses, that of the other finds as a rule. What Newton
/// does not find of these from here is brought to its limit there.
pub(super) fn branches(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> Branches {
    if ask.thoroughness == Thoroughness::Quick {
        return Branches { found: branches_forward(extremal, ask, work), one_way: Vec::new() };
    }
    let way_back = match ask.path {
        // About one axis in body and space: the same vector at both ends.
        Way::AsGiven(vector) => Way::AsGiven(-vector),
        way => way,
    };
    let (reversed, back) = (extremal.reversed(), SearchRequest { path: way_back, ..*ask });
    // Only this thread may ask whether to stop: once before the other one begins.
    let stopped = AtomicBool::new(work.stopped());
    let asks = || {
        let stops = work.stopped();
        stopped.fetch_or(stops, Ordering::Relaxed);
        stops.then_some(Outcome::Interrupted)
    };
    let searched = |extremal: &Extremal, ask: &SearchRequest, interrupt: Interrupt| {
        let work = Work::of(Watch { interrupt, ..Watch::NONE });
        (branches_forward(extremal, ask, &work), work.sweeps.get())
    };
    let told = || stopped.load(Ordering::Relaxed).then_some(Outcome::Interrupted);
    let ((mut found, swept), (backwards, swept_back)) = parallel::both(
        || searched(extremal, ask, &asks),
        || searched(&reversed, &back, &told),
        || {
            asks();
        },
    );
    work.sweeps.set(work.sweeps.get() + swept + swept_back);
    let mut one_way = Vec::new();
    for one in backwards {
        match unbiased(extremal, &Smoothed { path: one.path.reversed(extremal), ..one.clone() }, work) {
            Some(one) => found.push(one),
            None => one_way.push(one),
        }
    }
    Branches { found: cheapest_first(extremal, distinct(extremal, found)), one_way }
}

/// Distinct extremals at a small ε of the maneuver alone, the best first.
fn branches_forward(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> Vec<Smoothed> {
    // A turn that is asked for may be far, and has many extremals.
    let all = ask.thoroughness == Thoroughness::Thorough
        || extremal.seeks_time() && !matches!(ask.path, Way::Best | Way::Shortest);
    let ways = ways(extremal, ask);
    let each = |bases: &dyn Fn(&Turn) -> Vec<Smoothed>| {
        distinct(extremal, ways.iter().take_while(|_| !work.stopped()).flat_map(bases))
    };
    let mut from = each(&|turn| bases(extremal, turn, all, work));
    let rival = RIVAL_BASE * least(extremal, &from);
    from.retain(|one| one.cost(extremal) <= rival);
    let found = descended(extremal, ask, &from, work);
    if !found.is_empty() || extremal.counts_fuel() || extremal.given_duration.is_some() {
        return found;
    }
    let more = each(&|turn| by_durations(extremal, turn, INTERVALS, work));
    descended(extremal, ask, &more, work)
}

/// Distinct extremals at a small ε that bases lead to, unbiased and tipped.
fn descended(extremal: &Extremal, ask: &SearchRequest, from: &[Smoothed], work: &Work) -> Vec<Smoothed> {
    let angle = lie::log(&extremal.end_attitude).norm();
    // Switching functions of minimum time grow with the angle; those of fuel are of the size of its
    // price.
    let target =
        if extremal.counts_fuel() { COMPARED_FUEL } else { COMPARED * angle.clamp(SMALLEST_ANGLE, 1.0) };
    let target = target.min(BRANCHING);
    let mut found = Vec::new();
    let least = least(extremal, from);
    for (index, from) in from.iter().enumerate() {
        // Of many bases the first and the cheapest are tipped: that tells nearly all branches
        // apart, and takes the most time.
        let one_of_few = index == 0 || from.cost(extremal) <= least;
        let tips = one_of_few || !extremal.seeks_time() || ask.thoroughness == Thoroughness::Thorough;
        for bias in biases(extremal, ask.thoroughness).into_iter().take_while(|bias| tips || !bias.tips()) {
            if work.stopped() {
                break;
            }
            // Fast bodies have many branches, and small turns branches that hardly differ: steep
            // descents lose some of them.
            let close = is_fast(extremal) || angle < SMALL;
            let reached = if extremal.counts_fuel() || close || !bias.tips() {
                descend(extremal, from, target, &bias, work)
            } else {
                let parted = (PARTED * target).min(BRANCHING);
                descend_by(STEEP, Intervals::Following, extremal, from, parted, &bias, work)
            };
            if let Ok(reached) = reached {
                found.extend(unbiased(extremal, &Smoothed { epsilon: target, ..reached }, work));
            }
        }
    }
    cheapest_first(extremal, distinct(extremal, found))
}

/// An extremal without the bias that led to it.
fn unbiased(extremal: &Extremal, from: &Smoothed, work: &Work) -> Option<Smoothed> {
    // Fuel tells branches apart less sharply than time.
    let tolerance = Smooth::of(extremal, from.epsilon).tolerance();
    let tolerance = if extremal.counts_fuel() { NOTHING } else { tolerance };
    from.solved(extremal, tolerance, FAR_ITERATIONS, work)
}

/// Each extremal once.
fn distinct(extremal: &Extremal, all: impl IntoIterator<Item = Smoothed>) -> Vec<Smoothed> {
    let mut known: Vec<Smoothed> = Vec::new();
    for one in all {
        if !known.iter().any(|known| same(extremal, known, &one)) {
            known.push(one);
        }
    }
    known
}

fn cheapest_first(extremal: &Extremal, mut all: Vec<Smoothed>) -> Vec<Smoothed> {
    all.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    all
}

fn least(extremal: &Extremal, all: &[Smoothed]) -> f64 {
    all.iter().map(|one| one.cost(extremal)).fold(f64::INFINITY, f64::min)
}

/// Whether two paths are one extremal.
fn same(extremal: &Extremal, a: &Smoothed, b: &Smoothed) -> bool {
    let (cost_a, cost_b) = (a.cost(extremal), b.cost(extremal));
    let costate = |one: &Smoothed| (one.path.m, one.path.nodes[0].e);
    let ((am, ae), (bm, be)) = (costate(a), costate(b));
    // A sum of fuel is known less well than a duration.
    let (costs, costates) = if extremal.counts_fuel() { ALIKE_FUEL } else { ALIKE };
    (cost_a - cost_b).abs() < costs * cost_a.abs()
        && (am - bm).norm() + (ae - be).norm() < costates * (am.norm() + ae.norm())
}
