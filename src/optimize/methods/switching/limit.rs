//! What a branch of extremals comes to: arcs at the limits of the inputs, corrected until their
//! signs are right, or a smoothed extremal.
//!
//! # What if no list of arcs is exact?
//!
//! A singular arc is a dozen pulses and more before hardly anything is to be gained. The
//! certificate tells where an input has the wrong sign; how long it should have the other is not
//! how long it has the wrong one, so the worst three runs are put right for all of their time and
//! for smaller parts of it about where they are most wrong, and what leaves less of the gap is kept
//! (`switching/limit`, `refined`). All arcs on that path are kept too: those with the fewest gaps
//! may have no room on the grid, whose optimum needs two steps for every arc, and fewer pulses cost
//! far less than what is smoothed. Where no arcs are good, the cheaper of both is the plan. The
//! smoothed law comes to the grid from its smallest ε, or, where its Newton fails there, from the ε
//! at which branches were compared.

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

/// What a branch becomes.
#[derive(Clone, Debug)]
pub(crate) struct BranchEnd {
    /// The smoothed extremal that it comes from, and the same at the smallest ε.
    pub branch: Smoothed,
    pub smooth: Smoothed,
    /// Arcs at the limits, where there are any; their certificate tells whether they are exact.
    pub arcs: Option<Certified>,
    /// Arcs of larger gaps, as a rule with fewer switches, the last the best: for grids on which
    /// those have no room, or none are good enough and what is smoothed is dearer.
    pub looser: Vec<Certified>,
}

impl BranchEnd {
    /// Of arcs whose gaps fall, the last where these are `taken` for the limit.
    pub(super) fn of(branch: &Smoothed, smooth: Smoothed, mut all: Vec<Certified>, taken: bool) -> Self {
        let arcs = if taken { all.pop() } else { None };
        Self { branch: branch.clone(), smooth, arcs, looser: all }
    }

    /// Exact arcs of the reversed maneuver as those of `extremal`.
    pub(super) fn reversed(self, extremal: &Extremal, work: &Work) -> Option<Self> {
        let arcs = polish(extremal, self.arcs?.arcs.reversed(extremal), work)?;
        let reversed = |one: &Smoothed| Smoothed { path: one.path.reversed(extremal), ..*one };
        let limit = Self::of(&reversed(&self.branch), reversed(&self.smooth), vec![arcs], true);
        limit.is_exact(extremal).then_some(limit)
    }

    /// Returns what it becomes where the maneuver ends nearby; `None` where Newton leads to no such
    /// plan.
    pub fn led(&self, extremal: &Extremal, work: &Work) -> Option<Self> {
        if let Some(found) = &self.arcs {
            let arcs = polish(extremal, found.arcs.clone(), work).filter(|arcs| arcs.is_small(extremal))?;
            return Some(Self { arcs: Some(arcs), ..self.clone() });
        }
        let tolerance = Smooth::of(extremal, self.smooth.epsilon).tolerance();
        let smooth = self.smooth.solved(extremal, tolerance, FAR_ITERATIONS, work)?;
        Some(Self { smooth, ..self.clone() })
    }

    /// Returns the costate of the attitude in body axes and that of the momentum, at the end.
    pub fn costates_at_end(&self, extremal: &Extremal) -> [Vector3; 2] {
        let (m, end) = match &self.arcs {
            Some(found) => (found.arcs.m, found.arcs.end(extremal)),
            None => (self.smooth.path.m, self.smooth.path.nodes[self.smooth.path.intervals()]),
        };
        [end.r.tr_mul(&m), end.e]
    }

    /// The same with arcs of larger gaps, the best first.
    pub fn loosened(&self) -> impl Iterator<Item = Self> {
        let with = |arcs: &Certified| Self { arcs: Some(arcs.clone()), ..self.clone() };
        self.looser.iter().rev().map(with)
    }

    pub fn duration(&self) -> f64 {
        self.arcs.as_ref().map_or(self.smooth.path.duration, |found| found.arcs.duration)
    }

    /// What it costs: its duration where only time counts.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        self.arcs.as_ref().map_or_else(|| self.smooth.cost(extremal), |found| found.arcs.cost(extremal))
    }

    /// Whether every input is where the maximum principle wants it.
    pub fn is_exact(&self, extremal: &Extremal) -> bool {
        self.arcs.as_ref().is_some_and(|arcs| arcs.is_exact(extremal))
    }

    pub fn name(&self) -> &'static str {
        if self.arcs.is_some() { "arcs" } else { "smooth" }
    }
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub(crate) struct BranchEnds {
    /// The best first.
    pub limits: Vec<BranchEnd>,
    pub branches: usize,
    /// Duration of the turn about the eigenaxis, where it was compared.
    pub eigenaxis: Option<f64>,
}

impl BranchEnds {
    /// Adds limits, and puts the cheapest first.
    pub(super) fn extend(&mut self, extremal: &Extremal, limits: impl IntoIterator<Item = BranchEnd>) {
        self.limits.extend(limits);
        self.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    }
}

/// Whether arcs can be the limit of a smoothed extremal: Newton may have gone to a dearer one.
pub(super) fn bounded(extremal: &Extremal, arcs: &Arcs, smooth: &Smoothed) -> bool {
    arcs.cost(extremal) <= smooth.cost(extremal) * (1.0 + DEARER)
}

/// Whether arcs are the limit of a smoothed extremal. Of time this is never less than its limit.
pub(super) fn is_limit(extremal: &Extremal, arcs: &Arcs, smooth: &Smoothed) -> bool {
    let dearer = if extremal.counts_fuel() { DEARER } else { ALIKE.0 };
    arcs.cost(extremal) <= smooth.cost(extremal) * (1.0 + dearer)
}

/// The best extremal at the last ε that biases lead to, for a branch that ends before.
pub(super) fn tipped(extremal: &Extremal, rival: &Smoothed, work: &Work) -> Option<Smoothed> {
    let reached = directions(extremal, &ASKEW).take_while(|_| !work.stopped()).filter_map(|bias| {
        let reached = descend(extremal, rival, LAST, &bias, work).ok()?;
        reached.solved(extremal, ON_THE_WAY * LAST, FAR_ITERATIONS, work)
    });
    reached.min_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)))
}

/// Arcs to their switching times, corrected until every sign is right or no correction helps.
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

/// Arcs by Newton on their switching times.
fn certified(extremal: &Extremal, arcs: Arcs, work: &Work) -> Option<Certified> {
    if work.stopped() {
        return None;
    }
    count(&work.newtons);
    Some(by_least_gap(extremal, arcs.solve(extremal)?))
}

/// Arcs with the best times of their pulses, and to the last digits where Newton keeps all of them.
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

/// Arcs corrected further, each time by what makes their gap smaller: the worst of the wrong signs,
/// or the next ones, for all of their time or a part of it. Of fuel pulses are added where they
/// lack, and all times are laid out anew for the least of it. Returns all of them, the best last.
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

/// Returns arcs with their certificate, by the costates of the least gap where their own leave
/// more.
fn by_least_gap(extremal: &Extremal, arcs: Arcs) -> Certified {
    let mut found = Certified::of(extremal, arcs);
    if !found.is_exact(extremal) {
        for moved in with_less_gap(extremal, &found.arcs) {
            found.bound_by(extremal, moved);
        }
    }
    found
}
