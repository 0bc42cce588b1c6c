//! Branches of smoothed extremals: continuation of each base to a small ε, without and with
//! symmetry-breaking perturbations of the control law. A base is an initial smoothed extremal
//! (`base`).
//!
//! The unperturbed path of a symmetric maneuver stays on its symmetric branch, which is a saddle. A
//! perturbation of the switching functions leads off this branch where branches part, and vanishes
//! with ε.
//!
//! # How is the shortest maneuver found?
//!
//! The method has four layers, each of which removes one cause of failure
//! (`optimize/methods/switching`).
//!
//! 1. Smoothed extremals. The unknowns of Newton's method are all nodes, so that no error grows
//!    along the maneuver.
//! 2. Branches. The initial guess is a polynomial path for either homotopy class, by way of the
//!    isotropic body. Symmetry-breaking perturbations of both signs are applied where branches
//!    part. Without them, the path of a symmetric maneuver would stay on its saddle, the turn about
//!    the fixed axis.
//! 3. Newton on the switching times, which converges without an existing switch.
//! 4. The grid: arcs with equal steps each, whose lengths are unknowns. Stationarity in the length
//!    of an arc (the mean of its discrete Hamiltonians is zero) replaces the switching functions,
//!    so that the plan is the exact optimum of its own grid and its error series is even in the
//!    step. If two inputs switch together, the arc between them stays in the equations with zero
//!    length, because five lengths could not meet six conditions.
//!
//! A perturbation is oblique to the body axes, since along them it would have the symmetry too. It
//! acts equally on each input, whatever its limit and the body axes. If inputs or moments of
//! inertia differ more, several and larger sets of perturbations are tried.
//!
//! The other homotopy class may be far quicker about an axis of its own than about the axis of the
//! short way. Initial paths therefore also include whole turns about the two fastest axes of the
//! inputs. Of so many bases only the first and the cheapest are perturbed. For eight of 300 random
//! maneuvers the thorough search formerly knew shorter plans, by up to a fifth; now for one
//! (`cargo run --release -p evidence -- dearer thorough`).
//!
//! Branches may part below the ε at which they are compared. If the best plan is no quicker than
//! the turn about a fixed axis, which is known in closed form, the search becomes a thorough one.
//!
//! To continue perturbed starts on half of the intervals is quicker, since most lead to a known
//! extremal, but lost a branch of one public case and of a box
//! (`cargo run --release -p evidence -- minimum_time plain`). Their perturbation is removed before
//! the last level of ε, when branches have parted. Unless a body is fast, the intermediate levels
//! are further apart, which takes fewer iterations in total. The distance between levels
//! occasionally decides which branch is found, in either direction; so far no case of the public
//! set was lost.
//!
//! If nothing converges to a small ε, as with fast bodies whose gyroscopic torques are comparable
//! to the limits, initial paths come by way of given durations. There the smoothed extremal is
//! nearly a minimum-effort one, which a cubic path approximates. With costates and ε multiplied by
//! a factor it is an extremal of a free duration.

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

/// Requirements on a search for extremals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchRequest {
    pub path: Way,
    pub thoroughness: Thoroughness,
    /// True if bang-bang arcs are required; false if smoothed extremals are the result.
    pub arcs: bool,
}

/// The distinct smoothed extremals of a maneuver at a small ε.
pub(super) struct Branches {
    /// Extremals of the maneuver, the best first.
    pub found: Vec<Smoothed>,
    /// Extremals of the time-reversed maneuver from which Newton does not converge in the forward
    /// direction.
    pub one_way: Vec<Smoothed>,
}

/// Returns the perturbations of the control law with which branches are continued: zero and, except
/// in a quick search, further ones.
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

/// Returns ten perturbations: constant ones of both signs along each of three axes, and mixed ones.
/// Their size acts equally on each input, whatever its limit.
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

/// Returns the turns to the target that the search starts from. A requested path determines them.
/// For the best path they are the short way and, if it may be quicker, the long way. About another
/// axis, the long way can take a fifth less time than about the axis of the short way. One-sided
/// thrusters may be far stronger about one axis, or in one direction of rotation; they, and a
/// thorough search, start with whole turns about all axes.
fn ways(extremal: &Extremal, ask: &SearchRequest) -> Vec<Turn> {
    let phi = lie::log(&extremal.end_attitude);
    let angle = phi.norm();
    // A zero turn has no axis: the long way is then about the first axis.
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
                // No short plan turns about the slowest axis.
                ways.extend(rounded(extremal, &phi, 1.0).take(if all { 6 } else { 4 }));
            }
            ways
        }
        // The short way is counted from the motion without inputs; if that turns far, either may be
        // the short one.
        Way::Shortest if !fast => straight(&[phi]),
        Way::Long if !fast => {
            let mut ways: Vec<Turn> = straight(&[other]);
            ways.extend(rounded(extremal, &phi, 1.0));
            ways
        }
        Way::Shortest | Way::Long => straight(&[phi, other]),
    }
}

/// Adds whole turns about other axes to the rotation vector `phi`, in both directions: first about
/// the axis about which the inputs turn the body fastest. All are in one homotopy class, because a
/// turn by nearly 360° can be deformed into one about any other axis.
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

/// Finds the distinct extremals at a small ε of the maneuver and, except in a quick search, of the
/// time-reversed one: each search usually finds what the other misses. Reversed extremals from
/// which Newton does not converge in the forward direction are returned separately.
pub(super) fn branches(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> Branches {
    if ask.thoroughness == Thoroughness::Quick {
        return Branches { found: branches_forward(extremal, ask, work), one_way: Vec::new() };
    }
    let way_back = match ask.path {
        // A given rotation vector is the same in body and reference axes, so its negative is the
        // way back.
        Way::AsGiven(vector) => Way::AsGiven(-vector),
        way => way,
    };
    let (reversed, back) = (extremal.reversed(), SearchRequest { path: way_back, ..*ask });
    // Only this thread may poll the interrupt; it does so once before the other thread starts.
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

/// Finds the distinct extremals at a small ε of the maneuver in the forward direction, the best
/// first.
fn branches_forward(extremal: &Extremal, ask: &SearchRequest, work: &Work) -> Vec<Smoothed> {
    // A requested rotation may be large and has many extremals.
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

/// Continues bases to a small ε, without and with perturbations, and returns the distinct
/// extremals, the best first.
fn descended(extremal: &Extremal, ask: &SearchRequest, from: &[Smoothed], work: &Work) -> Vec<Smoothed> {
    let angle = lie::log(&extremal.end_attitude).norm();
    // Switching functions of minimum time grow with the angle; those of minimum fuel have the size
    // of the price.
    let target =
        if extremal.counts_fuel() { COMPARED_FUEL } else { COMPARED * angle.clamp(SMALLEST_ANGLE, 1.0) };
    let target = target.min(BRANCHING);
    let mut found = Vec::new();
    let least = least(extremal, from);
    for (index, from) in from.iter().enumerate() {
        // Of many bases only the first and the cheapest are perturbed: that separates nearly all
        // branches, and takes most of the time.
        let one_of_few = index == 0 || from.cost(extremal) <= least;
        let tips = one_of_few || !extremal.seeks_time() || ask.thoroughness == Thoroughness::Thorough;
        for bias in biases(extremal, ask.thoroughness).into_iter().take_while(|bias| tips || !bias.tips()) {
            if work.stopped() {
                break;
            }
            // Fast bodies have many branches, and the branches of small turns hardly differ:
            // continuations with large steps in ε lose some of them.
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

/// Solves for the unperturbed extremal near `from`, which was found with a perturbation; `None` if
/// Newton does not converge.
fn unbiased(extremal: &Extremal, from: &Smoothed, work: &Work) -> Option<Smoothed> {
    // Fuel separates branches less sharply than time.
    let tolerance = Smooth::of(extremal, from.epsilon).tolerance();
    let tolerance = if extremal.counts_fuel() { NOTHING } else { tolerance };
    from.solved(extremal, tolerance, FAR_ITERATIONS, work)
}

/// Returns the extremals without duplicates.
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

/// Returns whether two paths are the same extremal within the tolerances for costs and costates.
fn same(extremal: &Extremal, a: &Smoothed, b: &Smoothed) -> bool {
    let (cost_a, cost_b) = (a.cost(extremal), b.cost(extremal));
    let costate = |one: &Smoothed| (one.path.m, one.path.nodes[0].e);
    let ((am, ae), (bm, be)) = (costate(a), costate(b));
    // A sum of fuel is known less accurately than a duration.
    let (costs, costates) = if extremal.counts_fuel() { ALIKE_FUEL } else { ALIKE };
    (cost_a - cost_b).abs() < costs * cost_a.abs()
        && (am - bm).norm() + (ae - be).norm() < costates * (am.norm() + ae.norm())
}
