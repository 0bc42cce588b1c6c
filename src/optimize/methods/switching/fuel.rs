//! The end game of minimum fuel: arcs for a branch whose pulses are not plain to read.
//!
//! Along a singular arc an input is between its limits, and the best that arcs can do is a train of
//! pulses. Newton on switching times finds the best train of given pulses where it begins near it,
//! and drops what is added to a train that it does not see the use of. So trains are read from a
//! smoothed extremal that is known well, of more and more pulses; where that is not enough, pulses
//! are added where the certificate lacks them and all times are laid out anew for the least fuel,
//! which keeps what is of use.
//!
//! # What if no list of arcs is exact?
//!
//! Fuel counted by inputs has more to it (`switching/fuel`). How much its gap is depends on the
//! costates it is measured with, and those that vanish at the switches are not the best: six
//! switches hardly apart determine them badly, and between the pulses of a singular arc they are a
//! little off everywhere. Weak duality allows any: the least gap over all costates at the start is
//! a convex problem in six numbers, the dual of the linear program over all inputs along the way,
//! and no looser a bound (`switching/least_gap`). A duration that is sought is one more variable of
//! that program, without a sign, and its reduced cost is the Hamiltonian: costates count that make
//! it vanish, five numbers. Then the arcs. Newton on the switching functions drops most pulses that
//! are added to a train: it looks for where they vanish, not for less fuel. So trains of one to
//! eight pulses for each singular arc are read from a smoothed extremal on intervals that follow
//! its inputs; and where their gap is not small, pulses are added where the certificate lacks them,
//! by the own costates and by those of the least gap, and all times are laid out anew by the
//! quadratic programming that pulses with a shortest length have, which burns less at every step.
//! Equal intervals are no place to look from: at ε = 1e-4 the pulses are shorter than they, and the
//! fuel that is read there is off by per cents.
//!
//! On few steps there may be no discrete optimum with the pulses of the equations of motion: a
//! short one has no place in it, or comes in another order. The plan is then what pulses of a
//! shortest length get, with a shortest length of nothing: times at the bounds that act and, where
//! Newton finds no stationary times either, those that meet the end next to the continuous ones.
//! The stationarity that is left is told, and that it is no discrete optimum (`beside_optimum` in
//! the plan file). The smoothed law, which took that place before, burns per cents more.

use super::arcs::Arcs;
use super::branches::SearchRequest;
use super::certificate::Certified;
use super::extremal::{Bias, Extremal};
use super::limit::{BranchEnd, bounded, laid, polish, refined, tipped};
use super::smooth::{Intervals, Smoothed, descend, descend_by, settle};
use super::tuning::arcs::MOST_SWITCHES;
use super::tuning::limits::*;
use super::tuning::smooth::RATIO;
use super::work::Work;

/// A branch to its limit from what Newton on switching times has found of it on the way to a
/// smaller ε.
pub(super) fn fuel_limit(
    extremal: &Extremal,
    rival: &Smoothed,
    at: Smoothed,
    best: Option<Certified>,
    ask: &SearchRequest,
    work: &Work,
) -> BranchEnd {
    if !ask.arcs {
        let (Ok(smooth) | Err(smooth)) = descend(extremal, &at, LAST, &Bias::default(), work);
        return BranchEnd::of(rival, smooth, Vec::new(), false);
    }
    let small = |best: &Certified| best.is_small(extremal);
    let near = best.as_ref().filter(|best| bounded(extremal, &best.arcs, &at));
    let taken = near.is_some_and(small);
    if taken || work.stopped() {
        let all = near.cloned().into_iter().collect();
        return BranchEnd::of(rival, at, all, taken);
    }
    // At the smallest ε that it is found for, on intervals that follow its inputs.
    let settled = match descend_by(RATIO, Intervals::Close, extremal, rival, LAST, &Bias::default(), work) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, work).unwrap_or(end),
    };
    let settled = settle(extremal, settled, SMALLEST, work);
    // Newton may have gone to arcs of a dearer branch, however small their gap.
    let of_branch =
        |found: &Certified| [&at, &settled].iter().any(|smooth| bounded(extremal, &found.arcs, smooth));
    let mut all = Vec::from_iter(train(extremal, &settled, best.filter(of_branch), &of_branch, work));
    if let Some(best) = all.pop_if(|best| !small(best)) {
        all.extend(refined(extremal, best, work));
    }
    all.retain(of_branch);
    let taken = all.last().is_some_and(small);
    BranchEnd::of(rival, settled, all, taken)
}

/// The arcs of the smallest gap among those known and those with trains of pulses, no more of them
/// than make it small, and none of another branch.
fn train(
    extremal: &Extremal,
    settled: &Smoothed,
    known: Option<Certified>,
    of_branch: &dyn Fn(&Certified) -> bool,
    work: &Work,
) -> Option<Certified> {
    let mut best = known;
    for cells in CELLS {
        let arcs = Arcs::of_pulses(extremal, &settled.path, settled.epsilon, cells);
        if arcs.switches.len() > MOST_SWITCHES || work.stopped() {
            break;
        }
        let next = polish(extremal, arcs.clone(), work).or_else(|| laid(extremal, &arcs, work));
        let Some(next) = next.filter(of_branch) else { continue };
        if best.as_ref().is_none_or(|known| next.gap < known.gap) {
            best = Some(next);
        }
        if best.as_ref().is_some_and(|best| best.is_small(extremal)) {
            break;
        }
    }
    best
}
