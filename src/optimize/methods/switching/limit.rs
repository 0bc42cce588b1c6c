//! The limit of a branch of extremals as ε → 0: bang-bang arcs, corrected until their signs are
//! right, or a smoothed extremal.
//!
//! # What if no switching structure is exact?
//!
//! A singular arc takes a dozen pulses or more before hardly any cost can be saved. The certificate
//! reports where an input has the wrong sign. The time for which the input should be changed is not
//! the time for which it has the wrong sign. Therefore the worst three runs are corrected over
//! their full time and over smaller parts about the worst instant, and a correction that reduces
//! the gap is kept (`switching/limit`, `refined`). All intermediate arcs are kept too: the arcs
//! with the smallest gap may not fit the grid, whose optimum needs two steps for every arc, and
//! fewer pulses cost far less than the smoothed extremal. If no arcs are acceptable, the plan is
//! the cheaper of the best arcs and the smoothed extremal. The smoothed law is placed on the grid
//! from its smallest ε or, if Newton fails there, from the ε at which branches were compared.

use super::arcs::Arcs;
use super::branches::directions;
use super::certificate::{Certified, Runs};
use super::extremal::Extremal;
use super::least_gap::with_less_gap;
use super::pulses::optimum::best_arcs;
use super::smooth::{Smooth, Smoothed, descend};
use super::tuning::arcs::MOST_SWITCHES;
use super::tuning::branches::{ALIKE, ASKEW};
use super::tuning::limits::*;
use super::tuning::smooth::ON_THE_WAY;
use super::tuning::{FAR_ITERATIONS, SAME};
use super::work::{Work, count};
use crate::Vector3;

/// The limit of a branch as ε → 0: arcs, or a smoothed extremal at the smallest ε.
#[derive(Clone, Debug)]
pub(crate) struct BranchEnd {
    /// The smoothed extremal of the branch at the ε of the comparison; the limit is continued from
    /// it.
    pub branch: Smoothed,
    /// The smoothed extremal at the smallest ε that was reached.
    pub smooth: Smoothed,
    /// Bang-bang arcs with a certificate that states whether they are exact; `None` if no arcs were
    /// accepted.
    pub arcs: Option<Certified>,
    /// Arcs with larger gaps and usually fewer switches, in order of decreasing gap. They are used
    /// for grids that the best arcs do not fit, or if no arcs are accepted and the smoothed
    /// extremal costs more.
    pub looser: Vec<Certified>,
}

impl BranchEnd {
    /// Creates the limit from arcs in order of decreasing gap. If `taken`, the last arcs are
    /// accepted as the arcs of the limit.
    pub(super) fn of(branch: &Smoothed, smooth: Smoothed, mut all: Vec<Certified>, taken: bool) -> Self {
        let arcs = if taken { all.pop() } else { None };
        Self { branch: branch.clone(), smooth, arcs, looser: all }
    }

    /// Converts exact arcs of the time-reversed maneuver to those of `extremal`; `None` if the
    /// result is not exact.
    pub(super) fn reversed(self, extremal: &Extremal, work: &Work) -> Option<Self> {
        let arcs = polish(extremal, self.arcs?.arcs.reversed(extremal), work)?;
        let reversed = |one: &Smoothed| Smoothed { path: one.path.reversed(extremal), ..*one };
        let limit = Self::of(&reversed(&self.branch), reversed(&self.smooth), vec![arcs], true);
        limit.is_exact(extremal).then_some(limit)
    }

    /// Solves for the limit of this branch for a maneuver with a nearby terminal state, starting
    /// from this limit; `None` if Newton does not converge or the gap of its arcs is not small.
    pub fn led(&self, extremal: &Extremal, work: &Work) -> Option<Self> {
        if let Some(found) = &self.arcs {
            let arcs = polish(extremal, found.arcs.clone(), work).filter(|arcs| arcs.is_small(extremal))?;
            return Some(Self { arcs: Some(arcs), ..self.clone() });
        }
        let tolerance = Smooth::of(extremal, self.smooth.epsilon).tolerance();
        let smooth = self.smooth.solved(extremal, tolerance, FAR_ITERATIONS, work)?;
        Some(Self { smooth, ..self.clone() })
    }

    /// Returns the attitude costate and the momentum costate at the end of the maneuver, both in
    /// body axes.
    pub fn costates_at_end(&self, extremal: &Extremal) -> [Vector3; 2] {
        let (m, end) = match &self.arcs {
            Some(found) => (found.arcs.m, found.arcs.end(extremal)),
            None => (self.smooth.path.m, self.smooth.path.nodes[self.smooth.path.intervals()]),
        };
        [end.r.tr_mul(&m), end.e]
    }

    /// Returns copies of this limit whose arcs are replaced by those with larger gaps, in order of
    /// increasing gap.
    pub fn loosened(&self) -> impl Iterator<Item = Self> {
        let with = |arcs: &Certified| Self { arcs: Some(arcs.clone()), ..self.clone() };
        self.looser.iter().rev().map(with)
    }

    pub fn duration(&self) -> f64 {
        self.arcs.as_ref().map_or(self.smooth.path.duration, |found| found.arcs.duration)
    }

    /// Returns the cost, scaled; it is proportional to the duration if only time counts.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        self.arcs.as_ref().map_or_else(|| self.smooth.cost(extremal), |found| found.arcs.cost(extremal))
    }

    /// Returns whether the limit has arcs on which every input satisfies the maximum principle;
    /// false for a smoothed extremal.
    pub fn is_exact(&self, extremal: &Extremal) -> bool {
        self.arcs.as_ref().is_some_and(|arcs| arcs.is_exact(extremal))
    }

    pub fn name(&self) -> &'static str {
        if self.arcs.is_some() { "arcs" } else { "smooth" }
    }
}

/// The result of a search of extremals.
#[derive(Clone, Debug, Default)]
pub(crate) struct BranchEnds {
    /// Limits of the branches, the best first.
    pub limits: Vec<BranchEnd>,
    pub branches: usize,
    /// Duration of the turn about the eigenaxis, scaled; `None` if it was not computed for
    /// comparison.
    pub eigenaxis: Option<f64>,
}

impl BranchEnds {
    /// Adds limits and sorts all by cost.
    pub(super) fn extend(&mut self, extremal: &Extremal, limits: impl IntoIterator<Item = BranchEnd>) {
        self.limits.extend(limits);
        self.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    }
}

/// Returns whether arcs cost little enough to be the limit of a smoothed extremal. Newton may have
/// converged to arcs of a costlier extremal.
pub(super) fn bounded(extremal: &Extremal, arcs: &Arcs, smooth: &Smoothed) -> bool {
    arcs.cost(extremal) <= smooth.cost(extremal) * (1.0 + DEARER)
}

/// Returns whether the cost of arcs agrees with being the limit of a smoothed extremal. A smoothed
/// duration is never shorter than its limit.
pub(super) fn is_limit(extremal: &Extremal, arcs: &Arcs, smooth: &Smoothed) -> bool {
    let dearer = if extremal.counts_fuel() { DEARER } else { ALIKE.0 };
    arcs.cost(extremal) <= smooth.cost(extremal) * (1.0 + dearer)
}

/// Returns the cheapest smoothed extremal at ε = `LAST` to which perturbations lead, for a branch
/// that ends at a larger ε.
pub(super) fn tipped(extremal: &Extremal, rival: &Smoothed, work: &Work) -> Option<Smoothed> {
    let reached = directions(extremal, &ASKEW).take_while(|_| !work.stopped()).filter_map(|bias| {
        let reached = descend(extremal, rival, LAST, &bias, work).ok()?;
        reached.solved(extremal, ON_THE_WAY * LAST, FAR_ITERATIONS, work)
    });
    reached.min_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)))
}

/// Solves for the switching times and corrects the arcs until every sign is right or no correction
/// helps. Returns the arcs with the smallest gap.
pub(super) fn polish(extremal: &Extremal, mut arcs: Arcs, work: &Work) -> Option<Certified> {
    let mut best: Option<Certified> = None;
    let mut last = f64::NAN;
    for _ in 0..=MOST_CORRECTIONS {
        let Some(found) = certified(extremal, arcs, work) else { break };
        let ended = found.is_exact(extremal) || (found.gap - last).abs() <= SAME * last;
        last = found.gap;
        let next = found.corrected(Runs::Rank(0), 1.0);
        if best.as_ref().is_none_or(|known| found.gap < known.gap) {
            best = Some(found);
        }
        match next {
            Some(next) if !ended && next.switches.len() <= MOST_SWITCHES => arcs = next,
            _ => break,
        }
    }
    best
}

/// Solves for the switching times by Newton and certifies the arcs.
fn certified(extremal: &Extremal, arcs: Arcs, work: &Work) -> Option<Certified> {
    if work.stopped() {
        return None;
    }
    count(&work.newtons);
    Some(by_least_gap(extremal, arcs.solve(extremal)?))
}

/// Optimises the times of the pulses of arcs, then polishes by Newton if that keeps all pulses;
/// `None` if fuel is not a sum of pulses.
pub(super) fn laid(extremal: &Extremal, arcs: &Arcs, work: &Work) -> Option<Certified> {
    if !extremal.times_pulses() || work.stopped() {
        return None;
    }
    count(&work.newtons);
    let laid = best_arcs(extremal, arcs)?;
    let count = laid.switches.len();
    let solved = laid.clone().solve(extremal).filter(|solved| solved.switches.len() == count);
    Some(by_least_gap(extremal, solved.unwrap_or(laid)))
}

/// Corrects arcs repeatedly, each time by a correction that reduces their gap: runs of a wrong sign
/// are corrected one at a time or together, over all or a part of their time. For minimum fuel,
/// pulses are added where the certificate lacks them, and all times are optimised again. Returns
/// all arcs, the best last.
pub(super) fn refined(extremal: &Extremal, first: Certified, work: &Work) -> Vec<Certified> {
    let (by_times, [_, long, short, _]) = (extremal.times_pulses(), PARTS);
    let by_rank = (0..WORST).flat_map(|rank| PARTS.map(|part| (Runs::Rank(rank), part)));
    let by_gap = [
        (Runs::All, long),
        (Runs::OfLeast, long),
        (Runs::Worst, short),
        (Runs::Rank(0), long),
        (Runs::Rank(0), short),
    ];
    let corrections = if by_times { by_gap.to_vec() } else { by_rank.collect() };
    let mut left = MOST_CORRECTIONS * if by_times { by_gap.len() } else { 1 };
    let mut path = vec![first];
    while let Some(last) = path.last()
        && !(if by_times { last.is_small(extremal) } else { last.is_exact(extremal) })
    {
        let all = corrections.iter().filter_map(|(runs, part)| last.corrected(*runs, *part));
        let short_enough = all.filter(|next| next.switches.len() <= MOST_SWITCHES);
        let better = short_enough.take(left).find_map(|next| {
            left -= 1;
            let next = if by_times { laid(extremal, &next, work) } else { certified(extremal, next, work) };
            next.filter(|next| next.gap < last.gap)
        });
        match better {
            Some(better) => path.push(better),
            None => break,
        }
    }
    path
}

/// Certifies arcs; if other costates than those of the arcs give a smaller gap, with the costates
/// of the smallest gap.
fn by_least_gap(extremal: &Extremal, arcs: Arcs) -> Certified {
    let mut found = Certified::of(extremal, arcs);
    if !found.is_exact(extremal) {
        for moved in with_less_gap(extremal, &found.arcs) {
            found.bound_by(extremal, moved);
        }
    }
    found
}
