//! Limits of minimum-fuel branches whose pulses cannot be extracted directly.
//!
//! Along a singular arc an input is between its limits, and the best approximation by arcs is a
//! train of pulses. Newton on switching times finds the best train near its initial guess, and
//! drops pulses that are added to a train and do not satisfy its equations. Trains with more and
//! more pulses are therefore extracted from an accurate smoothed extremal. If that does not
//! suffice, pulses are added where the certificate lacks them, and all times are optimised again
//! for minimum fuel, which keeps the useful pulses.
//!
//! # What if no switching structure is exact?
//!
//! For fuel that is a sum over inputs (`switching/fuel`), the gap depends on the costates that
//! measure it. The costates that vanish at the switches are not the best: six switches close
//! together determine them badly, and between the pulses of a singular arc they are slightly wrong
//! everywhere. Weak duality allows any costates. The smallest gap over all costates at the start is
//! a convex problem in six numbers, the dual of the linear program over all inputs along the path,
//! and no looser bound (`switching/least_gap`). A free duration is one more variable of this
//! program, without a sign, whose reduced cost is the Hamiltonian; only costates that make it
//! vanish are allowed, which leaves five numbers.
//!
//! Next, the arcs. Newton on the switching functions drops most pulses that are added to a train,
//! because it solves for zeros and does not minimise fuel. Trains of one to eight pulses for each
//! singular arc are therefore extracted from a smoothed extremal on intervals that resolve its
//! inputs. If their gap is not small, pulses are added where the certificate lacks them, by the
//! arcs' own costates and by the costates of the smallest gap. All times are then optimised by the
//! sequential quadratic programming of pulses with a minimum pulse width, which reduces the fuel at
//! every step. A uniform grid is not accurate enough for extraction: at ε = 1e-4 the pulses are
//! shorter than its intervals, and the extracted fuel is wrong by some per cent.
//!
//! On few steps no discrete optimum may exist with the pulses of the continuous motion: a short
//! pulse does not fit, or the order differs. The plan is then computed like pulses with a minimum
//! pulse width of zero: times at their active bounds and, if Newton finds no stationary times
//! either, the times nearest to the continuous ones that meet the terminal conditions. The
//! remaining stationarity residual is reported, and the plan file states that the plan is no
//! discrete optimum (`beside_optimum`). The smoothed law, which was used before, burns some per
//! cent more.

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

/// Continues a branch to its limit, given the best arcs that Newton on switching times found at
/// larger ε.
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
    // The smallest ε that converges, on intervals that resolve the inputs.
    let settled = match descend_by(RATIO, Intervals::Close, extremal, rival, LAST, &Bias::default(), work) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, work).unwrap_or(end),
    };
    let settled = settle(extremal, settled, SMALLEST, work);
    // Newton may have converged to arcs of a costlier branch, however small their gap.
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

/// Returns the arcs with the smallest gap among `known` and the trains of pulses that are extracted
/// from a smoothed extremal. The number of pulses grows until the gap is small. Arcs of other
/// branches are excluded.
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
