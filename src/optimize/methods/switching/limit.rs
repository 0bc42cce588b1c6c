//! What a branch of extremals comes to: arcs at the limits of the inputs, corrected until their signs are right, or a smoothed
//! extremal.
//!
//! # What if no list of arcs is exact?
//!
//! A singular arc is a dozen pulses and more before hardly anything is to be gained. The certificate tells where an input has
//! the wrong sign; how long it should have the other is not how long it has the wrong one, so the worst three runs are put
//! right for all of their time and for smaller parts of it about where they are most wrong, and what leaves less of the gap
//! is kept (`switching/limit`, `refined`). All arcs on that path are kept too: those with the fewest gaps may have no room on
//! the grid, whose optimum needs two steps for every arc, and fewer pulses cost far less than what is smoothed. Where no arcs
//! are good, the cheaper of both is the plan. The smoothed law comes to the grid from its smallest ε, or, where its Newton
//! fails there, from the ε at which branches were compared.

use super::arcs::Arcs;
use super::branches::tips;
use super::certificate::Certificate;
use super::extremal::Extremal;
use super::least_gap::with_less_gap;
use super::smooth::{Smooth, Smoothed, descend};
use super::tuning::arcs::MOST_SWITCHES;
use super::tuning::branches::ALIKE;
use super::tuning::limits::*;
use super::tuning::smooth::ON_THE_WAY;
use super::tuning::{FAR_ITERATIONS, SAME};
use super::work::{Work, count};
use crate::Vector3;

/// What a branch becomes.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    /// The smoothed extremal that it comes from, and the same at the smallest ε.
    pub branch: Smoothed,
    pub smooth: Smoothed,
    /// Arcs at the limits, where there are any; the certificate tells whether they are exact.
    pub arcs: Option<(Arcs, Certificate)>,
    /// Arcs of larger gaps, as a rule with fewer switches, the last the best: for grids on which those have no room,
    /// or none are good enough and what is smoothed is dearer.
    pub looser: Vec<(Arcs, Certificate)>,
}

impl Limit {
    pub(super) fn of_arcs(branch: &Smoothed, smooth: Smoothed, arcs: (Arcs, Certificate)) -> Self {
        Self { branch: branch.clone(), smooth, arcs: Some(arcs), looser: Vec::new() }
    }

    /// Exact arcs of the reversed maneuver as those of `extremal`.
    pub(super) fn reversed(self, extremal: &Extremal, work: &Work) -> Option<Self> {
        let (arcs, certificate) = polish(extremal, self.arcs?.0.reversed(extremal), work)?;
        let reversed = |one: &Smoothed| Smoothed { path: one.path.reversed(extremal), ..*one };
        let limit = Self::of_arcs(&reversed(&self.branch), reversed(&self.smooth), (arcs, certificate));
        limit.is_exact(extremal).then_some(limit)
    }

    /// Returns what it becomes where the maneuver ends nearby; `None` where Newton leads to no such plan.
    pub fn led(&self, extremal: &Extremal, work: &Work) -> Option<Self> {
        if let Some((arcs, _)) = &self.arcs {
            let arcs = polish(extremal, arcs.clone(), work).filter(|arcs| is_small(extremal, arcs))?;
            return Some(Self { arcs: Some(arcs), ..self.clone() });
        }
        let epsilon = self.smooth.epsilon;
        let smooth = Smooth::of(extremal, epsilon);
        let path = smooth.solve(self.smooth.path.clone(), smooth.tolerance(), FAR_ITERATIONS, work)?;
        Some(Self { smooth: Smoothed { path, epsilon }, ..self.clone() })
    }

    /// Returns the costate of the attitude in body axes and that of the momentum, at the end.
    pub fn costates_at_end(&self, extremal: &Extremal) -> [Vector3; 2] {
        let (m, end) = match &self.arcs {
            Some((arcs, _)) => (arcs.m, arcs.end(extremal)),
            None => (self.smooth.path.m, self.smooth.path.nodes[self.smooth.path.intervals()]),
        };
        [end.r.tr_mul(&m), end.e]
    }

    /// The same with arcs of larger gaps, the best first.
    pub fn loosened(&self) -> impl Iterator<Item = Self> {
        let with = |arcs: &(Arcs, Certificate)| Self { arcs: Some(arcs.clone()), ..self.clone() };
        self.looser.iter().rev().map(with)
    }

    pub fn duration(&self) -> f64 {
        self.arcs.as_ref().map_or(self.smooth.path.duration, |(arcs, _)| arcs.duration)
    }

    /// What it costs: its duration where only time counts.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        self.arcs.as_ref().map_or_else(|| self.smooth.cost(extremal), |(arcs, _)| arcs.cost(extremal))
    }

    /// Whether every input is where the maximum principle wants it.
    pub fn is_exact(&self, extremal: &Extremal) -> bool {
        self.arcs.as_ref().is_some_and(|(arcs, certificate)| certificate.gap <= NO_GAP * arcs.cost(extremal))
    }

    pub fn name(&self) -> &'static str {
        if self.arcs.is_some() { "arcs" } else { "smooth" }
    }
}

/// What was found, and what it took.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// The best first.
    pub limits: Vec<Limit>,
    pub branches: usize,
    /// Sweeps of smoothed problems, and Newtons on switching times.
    pub sweeps: usize,
    pub newtons: usize,
    /// Duration of the turn about the eigenaxis, where it was compared.
    pub eigenaxis: Option<f64>,
}

/// Whether the gap of arcs can stay.
pub(super) fn is_small(extremal: &Extremal, (arcs, certificate): &(Arcs, Certificate)) -> bool {
    certificate.gap <= SMALL_GAP * arcs.cost(extremal)
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
    let reached = tips(extremal).take_while(|_| !work.stopped()).filter_map(|bias| {
        let reached = descend(extremal, rival, LAST, &bias, work).ok()?;
        let path = Smooth::of(extremal, LAST).solve(reached.path, ON_THE_WAY * LAST, FAR_ITERATIONS, work)?;
        Some(Smoothed { path, epsilon: LAST })
    });
    reached.min_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)))
}

/// Arcs to their switching times, corrected until every sign is right or no correction helps.
pub(super) fn polish(extremal: &Extremal, mut arcs: Arcs, work: &Work) -> Option<(Arcs, Certificate)> {
    let mut best: Option<(Arcs, Certificate)> = None;
    let mut last = f64::NAN;
    for _ in 0..=MOST_CORRECTIONS {
        let Some((solved, certificate)) = certified(extremal, arcs, work) else { break };
        let exact = certificate.gap <= NO_GAP * solved.cost(extremal);
        let again = (certificate.gap - last).abs() <= SAME * last;
        last = certificate.gap;
        let mended = certificate.mended(&solved, 0, 1.0);
        if best.as_ref().is_none_or(|(_, known)| certificate.gap < known.gap) {
            best = Some((solved, certificate));
        }
        match mended {
            Some(next) if !exact && !again && next.switches.len() <= MOST_SWITCHES => arcs = next,
            _ => break,
        }
    }
    best
}

fn certified(extremal: &Extremal, arcs: Arcs, work: &Work) -> Option<(Arcs, Certificate)> {
    if work.stopped() {
        return None;
    }
    count(&work.newtons);
    Some(measured(extremal, arcs.solve(extremal)?))
}

/// Arcs with their certificate, by the costates of the least gap where their own leave more.
pub(super) fn measured(extremal: &Extremal, arcs: Arcs) -> (Arcs, Certificate) {
    let mut certificate = Certificate::of(extremal, &arcs);
    if certificate.gap > NO_GAP * arcs.cost(extremal) {
        for moved in with_less_gap(extremal, &arcs) {
            certificate.bound_by(extremal, moved);
        }
    }
    (arcs, certificate)
}

/// Arcs corrected further, each time by what makes their gap smaller: the worst of the wrong signs, or the next ones,
/// for all of their time or a part of it. All of them, the best last.
pub(super) fn refined(
    extremal: &Extremal,
    first: (Arcs, Certificate),
    work: &Work,
) -> Vec<(Arcs, Certificate)> {
    let (mut path, mut newtons) = (vec![first], 0);
    while let Some((arcs, certificate)) = path.last()
        && certificate.gap > NO_GAP * arcs.cost(extremal)
        && !work.stopped()
    {
        let all = (0..WORST).flat_map(|rank| PARTS.map(|part| (rank, part)));
        let corrections = all
            .filter_map(|(rank, part)| certificate.mended(arcs, rank, part))
            .filter(|next| next.switches.len() <= MOST_SWITCHES);
        let better = corrections.take(MOST_CORRECTIONS - newtons).find_map(|next| {
            newtons += 1;
            certified(extremal, next, work).filter(|(_, next)| next.gap < certificate.gap)
        });
        match better {
            Some(better) => path.push(better),
            None => break,
        }
    }
    path
}
