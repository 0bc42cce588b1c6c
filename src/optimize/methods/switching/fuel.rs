//! The end game of minimum fuel: arcs for a branch whose pulses are not plain to read.
//!
//! Along a singular arc an input is between its limits, and the best that arcs can do is a train of pulses. Newton on switching times
//! finds the best train of given pulses where it begins near it, and drops what is added to a train that it does not see the use of. So
//! trains are read from a smoothed extremal that is known well, of more and more pulses; where that is not enough, pulses are
//! added where the certificate lacks them and all times are laid out anew for the least fuel, which keeps what is of use.
//!
//! # What if no list of arcs is exact?
//!
//! Fuel counted by inputs has more to it (`switching/fuel`). How much its gap is depends on the costates it is measured with,
//! and those that vanish at the switches are not the best: six switches hardly apart determine them badly, and between the
//! pulses of a singular arc they are a little off everywhere. Weak duality allows any: the least gap over all costates at the
//! start is a convex problem in six numbers, the dual of the linear program over all inputs along the way, and no looser a
//! bound (`switching/least_gap`). A duration that is sought is one more variable of that program, without a sign, and its
//! reduced cost is the Hamiltonian: costates count that make it vanish, five numbers. Then the arcs. Newton on the switching
//! functions drops most pulses that are added to a train: it looks for where they vanish, not for less fuel. So trains of one
//! to eight pulses for each singular arc are read from a smoothed extremal on intervals that follow its inputs; and where
//! their gap is not small, pulses are added where the certificate lacks them, by the own costates and by those of the least
//! gap, and all times are laid out anew by the quadratic programming that pulses with a shortest length have, which burns
//! less at every step. Equal intervals are no place to look from: at ε = 1e-4 the pulses are shorter than they, and the fuel
//! that is read there is off by per cents.
//!
//! On few steps there may be no discrete optimum with the pulses of the equations of motion: a short one has no place in it,
//! or comes in another order. The plan is then what pulses of a shortest length get, with a shortest length of nothing: times
//! at the bounds that act and, where Newton finds no stationary times either, those that meet the end next to the continuous
//! ones. The stationarity that is left is told, and that it is no discrete optimum (`beside_optimum` in the plan file). The
//! smoothed law, which took that place before, burns per cents more.

use super::arcs::Arcs;
use super::branches::Ask;
use super::certificate::Certificate;
use super::extremal::{Bias, Extremal};
use super::limit::{Limit, bounded, is_small, measured, polish, refined, tipped};
use super::pulses::optimum::best_arcs;
use super::smooth::{Intervals, Smoothed, descend, descend_by, settle};
use super::tuning::arcs::MOST_SWITCHES;
use super::tuning::limits::*;
use super::tuning::smooth::RATIO;
use super::work::{Work, count};

/// A branch to its limit from what Newton on switching times has found of it on the way to a smaller ε.
pub(super) fn fuel_limit(
    extremal: &Extremal,
    rival: &Smoothed,
    at: Smoothed,
    best: Option<(Arcs, Certificate)>,
    ask: &Ask,
    work: &Work,
) -> Limit {
    if !ask.arcs {
        let end = descend(extremal, &at, LAST, &Bias::default(), work);
        let (Ok(smooth) | Err(smooth)) = end;
        return Limit { branch: rival.clone(), smooth, arcs: None, looser: Vec::new() };
    }
    if let Some(best) =
        best.as_ref().filter(|best| is_small(extremal, best) && bounded(extremal, &best.0, &at))
    {
        return Limit::of_arcs(rival, at, best.clone());
    }
    let of_branch = |arcs: &Arcs| bounded(extremal, arcs, &at);
    if work.stopped() {
        let looser = best.into_iter().filter(|(arcs, _)| of_branch(arcs)).collect();
        return Limit { branch: rival.clone(), smooth: at, arcs: None, looser };
    }
    let settled = settled(extremal, rival, work);
    // Newton may have gone to arcs of a dearer branch, however small their gap.
    let of_branch = |arcs: &Arcs| of_branch(arcs) || bounded(extremal, arcs, &settled);
    let best = best.filter(|(arcs, _)| of_branch(arcs));
    let mut looser = Vec::from_iter(train(extremal, &settled, best, &of_branch, work));
    if let Some(best) = looser.pop_if(|best| !is_small(extremal, best)) {
        looser.extend(mended(extremal, best, work));
    }
    looser.retain(|(arcs, _)| of_branch(arcs));
    match looser.pop_if(|best| is_small(extremal, best)) {
        Some(arcs) => Limit { looser, ..Limit::of_arcs(rival, settled, arcs) },
        None => Limit { branch: rival.clone(), smooth: settled, arcs: None, looser },
    }
}

/// Arcs with a gap that is not small, and what corrections make of them, the best last.
pub(super) fn mended(
    extremal: &Extremal,
    arcs: (Arcs, Certificate),
    work: &Work,
) -> Vec<(Arcs, Certificate)> {
    let more = if extremal.times_pulses() { laid_out } else { refined };
    more(extremal, arcs, work)
}

/// The smoothed extremal of a branch at the smallest ε that it is found for, on intervals that follow its inputs.
fn settled(extremal: &Extremal, rival: &Smoothed, work: &Work) -> Smoothed {
    let end = match descend_by(RATIO, Intervals::Close, extremal, rival, LAST, &Bias::default(), work) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, work).unwrap_or(end),
    };
    settle(extremal, end, SMALLEST, work)
}

/// The arcs of the smallest gap among those known and those with trains of pulses, no more of them than make it small, and none of
/// another branch.
fn train(
    extremal: &Extremal,
    settled: &Smoothed,
    known: Option<(Arcs, Certificate)>,
    of_branch: &dyn Fn(&Arcs) -> bool,
    work: &Work,
) -> Option<(Arcs, Certificate)> {
    let mut best = known;
    for cells in CELLS {
        let arcs = Arcs::of_pulses(extremal, &settled.path, settled.epsilon, cells);
        if arcs.switches.len() > MOST_SWITCHES || work.stopped() {
            break;
        }
        let next = polish(extremal, arcs.clone(), work).or_else(|| laid(extremal, &arcs, work));
        let Some(next) = next.filter(|(arcs, _)| of_branch(arcs)) else { continue };
        if best.as_ref().is_none_or(|(_, known)| next.1.gap < known.gap) {
            best = Some(next);
        }
        if best.as_ref().is_some_and(|best| is_small(extremal, best)) {
            break;
        }
    }
    best
}

/// Arcs whose times are laid out anew for the least fuel after pulses have been added where they lack, as long as that makes the gap
/// smaller. All of them, the best last.
fn laid_out(extremal: &Extremal, first: (Arcs, Certificate), work: &Work) -> Vec<(Arcs, Certificate)> {
    let mut path = vec![first];
    for _ in 0..MOST_CORRECTIONS {
        let Some((arcs, certificate)) =
            path.last().filter(|last| !is_small(extremal, last) && !work.stopped())
        else {
            break;
        };
        let corrections: [&dyn Fn() -> Option<Arcs>; 5] = [
            &|| certificate.all_mended(arcs, PARTS[1]),
            &|| certificate.least_mended(PARTS[1]),
            &|| certificate.worst_mended(arcs, PARTS[2]),
            &|| certificate.mended(arcs, 0, PARTS[1]),
            &|| certificate.mended(arcs, 0, PARTS[2]),
        ];
        let better = corrections.iter().take_while(|_| !work.stopped()).find_map(|correction| {
            let next = correction().filter(|next| next.switches.len() <= MOST_SWITCHES)?;
            laid(extremal, &next, work).filter(|(_, next)| next.gap < certificate.gap)
        });
        match better {
            Some(better) => path.push(better),
            None => break,
        }
    }
    path
}

/// Arcs with the best times of their pulses, and to the last digits where Newton keeps all of them.
pub(super) fn laid(extremal: &Extremal, arcs: &Arcs, work: &Work) -> Option<(Arcs, Certificate)> {
    if !extremal.times_pulses() {
        return None;
    }
    count(&work.newtons);
    let laid = best_arcs(extremal, arcs)?;
    let count = laid.switches.len();
    let solved = laid.clone().solve(extremal).filter(|solved| solved.switches.len() == count);
    Some(measured(extremal, solved.unwrap_or(laid)))
}
