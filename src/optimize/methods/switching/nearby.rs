//! Extremals of nearby maneuvers, for a maneuver whose own search remains on a saddle.
//!
//! If the body turns about a fixed axis, the maneuver is symmetric, and its extremal is usually a
//! saddle: a motion that also turns about the other axes is quicker, by a fraction of the order of
//! the angle. Two kinds of nearby maneuvers lead to such a motion:
//!
//! - A **displaced** end breaks the symmetry. The arcs to it are corrected for the true end.
//! - A **larger** maneuver has a larger gain, while the smoothing parameter ε at which branches are
//!   compared hides the gain of a small one. The arcs of the larger maneuver are followed as it
//!   shrinks. In the limit of small sizes s, turns are proportional to s, rates and times to √s,
//!   and attitude costates to 1/√s.

use super::arcs::Arcs;
use super::branches::SearchRequest;
use super::extremal::Extremal;
use super::flow::Node;
use super::limit::{BranchEnd, BranchEnds, polish};
use super::smooth::{Path, Smoothed};
use super::tuning::NOTHING;
use super::tuning::branches::{ASKEW, SMALLEST_ANGLE};
use super::tuning::paths::{DISPLACED, STRETCH, STRETCHING};
use super::work::Work;
use crate::optimize::methods::continuation::{Step, follow};
use crate::{Vector3, lie};

/// Returns the turn of a maneuver, together with the turns that its rates at the ends require
/// (scaled).
fn size(extremal: &Extremal) -> f64 {
    let turn = lie::log(&extremal.end_attitude).norm();
    turn + extremal.start_rate.norm_squared() + extremal.end_rate.norm_squared()
}

/// Returns whether a maneuver is so small that the comparison of its branches hides their
/// differences.
pub(super) fn is_small(extremal: &Extremal) -> bool {
    size(extremal) < SMALLEST_ANGLE
}

/// Returns whether the body turns about a fixed axis along the smoothed extremal of a limit.
pub(super) fn turns_about_an_axis(extremal: &Extremal, limit: &BranchEnd) -> bool {
    let rates = || limit.smooth.path.nodes.iter().map(|node| extremal.j_inverse * node.pi);
    let Some(fastest) = rates().max_by(|a, b| a.norm().total_cmp(&b.norm())) else { return false };
    rates().all(|rate| rate.cross(&fastest).norm() <= NOTHING * fastest.norm_squared())
}

/// Returns limits of a minimum-time maneuver that start from those of nearby maneuvers, which
/// `search` finds.
pub(super) fn limits(
    extremal: &Extremal,
    ask: &SearchRequest,
    search: impl Fn(&Extremal, &SearchRequest) -> BranchEnds,
    work: &Work,
) -> Vec<BranchEnd> {
    if is_small(extremal) {
        let total = (SMALLEST_ANGLE / size(extremal)).sqrt();
        let larger = search(&resized(extremal, total), ask).limits;
        return larger.iter().filter_map(|limit| shrunk(extremal, limit, total, work)).collect();
    }
    let aside = size(extremal) * (lie::exp(&ASKEW) * Vector3::x());
    let displaced = DISPLACED.iter().take_while(|_| !work.stopped()).flat_map(|part| {
        let end_attitude = extremal.end_attitude * lie::exp(&(*part * aside));
        search(&Extremal { end_attitude, ..extremal.clone() }, ask).limits
    });
    displaced.filter_map(|limit| limit.led(extremal, work)).collect()
}

/// Returns the maneuver with rates that are multiplied by `factor`, and with its turn multiplied by
/// the square of `factor`.
fn resized(extremal: &Extremal, factor: f64) -> Extremal {
    Extremal {
        start_rate: factor * extremal.start_rate,
        end_rate: factor * extremal.end_rate,
        end_attitude: lie::exp(&(factor * factor * lie::log(&extremal.end_attitude))),
        ..extremal.clone()
    }
}

/// Follows a limit of the maneuver whose rates are larger by the factor `total`, as that maneuver
/// shrinks to `extremal`; `None` if a step of the continuation fails.
fn shrunk(extremal: &Extremal, limit: &BranchEnd, total: f64, work: &Work) -> Option<BranchEnd> {
    let first = limit.arcs.clone()?;
    let arrived = |(_, factor): &(_, f64)| *factor >= total;
    let reached = follow(&STRETCHING, (first, 1.0), arrived, |(at, factor), length| {
        if work.stopped() {
            return Step::Stopped;
        }
        let next_factor = (factor * STRETCH.powf(length)).min(total);
        let there = resized(extremal, total / next_factor);
        let found = polish(&there, with_times(&at.arcs, &there, factor / next_factor), work);
        found.filter(|found| found.is_small(&there)).map(|found| (found, next_factor)).into()
    });
    let (arcs, _) = reached.ok()?;
    let smaller = |smoothed: &Smoothed| {
        let nodes = smoothed.path.nodes.iter().map(|node| slower(node, 1.0 / total)).collect();
        let path = Path {
            m: total * smoothed.path.m,
            duration: smoothed.path.duration / total,
            nodes,
            ..smoothed.path.clone()
        };
        Smoothed { path, ..*smoothed }
    };
    Some(BranchEnd::of(&smaller(&limit.branch), smaller(&limit.smooth), vec![arcs], true))
}

/// Returns arcs for a maneuver of another size, with times multiplied by `factor`.
fn with_times(arcs: &Arcs, there: &Extremal, factor: f64) -> Arcs {
    let mut next = arcs.clone();
    next.m /= factor;
    next.duration *= factor;
    next.first = Node::at_start(there, arcs.first.e);
    for switch in &mut next.switches {
        switch.time *= factor;
        switch.node = slower(&switch.node, factor);
    }
    next
}

/// Returns a node of a maneuver whose rates are multiplied by `factor`.
fn slower(node: &Node, factor: f64) -> Node {
    Node { r: lie::exp(&(factor * factor * lie::log(&node.r))), pi: factor * node.pi, e: node.e }
}
