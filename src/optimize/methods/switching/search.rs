//! From branches to the answer: each rival branch is brought to its limit, and the shortest is taken.

use super::arcs::Arcs;
use super::branches::{Ask, branches, tips};
use super::certificate::Certificate;
use super::eigenaxis;
use super::extremal::{Bias, Extremal, Law};
use super::fuel::fuel_limit;
use super::least_gap::with_least_gap;
use super::smooth::{Smooth, Smoothed, descend, settle};
use crate::maneuver::problem::Path as Way;
use crate::maneuver::settings::Thoroughness;

/// A gap below this part of the cost is none, and one below that can stay.
pub(crate) const NO_GAP: f64 = 1e-7;
const SMALL_GAP: f64 = 1e-4;

/// A branch that costs more than the best by this is no rival, in time and in fuel.
const RIVAL: f64 = 1.015;
const RIVAL_FUEL: f64 = 1.1;

/// Less than this part of a duration is no gain, and durations that differ by less are one.
const NO_GAIN: f64 = 1e-6;
const SAME: f64 = 1e-9;
/// Switching functions of this part of the largest are those of inputs that are not used.
const UNUSED: f64 = 1e-6;

/// Most corrections of the sequence of switches; one after which the gap is the same, to this part, led back.
const MOST_CHANGES: usize = 8;
const SAME_GAP: f64 = 1e-9;

/// Further corrections of arcs with a gap that is not small: so many of the worst signs, on these parts of their time, in so
/// many Newtons; each must leave less of the gap than this.
const WORST: usize = 3;
const PARTS: [f64; 4] = [1.0, 0.2, 0.04, 0.008];
const MOST_REFINEMENTS: usize = 40;
pub(super) const LESS: f64 = 0.98;

/// How often a branch without arcs is followed to a smaller ε, and by what factor.
const MOST_DESCENTS: usize = 3;
/// The same where fuel counts: short pulses show late; and where that of the norm does, whose switching function can be
/// near zero all along.
const MOST_DESCENTS_FUEL: usize = 6;
const MOST_DESCENTS_NORM: usize = 12;
const SMALLER: f64 = 0.4;

/// ε at which a branch with a singular arc ends on equal intervals, and that to which it is then carried.
pub(super) const LAST: f64 = 5e-4;
pub(super) const SMALLEST: f64 = 2e-5;

/// Iterations after a bias is taken away.
const TIPPED_ITERATIONS: usize = 20;

/// Intervals, residual and iterations of an extremal under a limit of the norm.
const TURNING: usize = 256;
const EXACT: f64 = 1e-11;
const TURNING_ITERATIONS: usize = 12;

/// Arcs may cost more than their smoothed extremal by this part: the interpolation on its intervals, of a duration; and
/// of fuel what smoothing lets through.
const DEARER: f64 = 1e-4;
const DEARER_FUEL: f64 = 0.05;

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

/// Searches the best extremals; what is found before `stop` says so is kept. A plan that is no quicker than the turn about a
/// fixed axis is a saddle as a rule: then the search becomes a thorough one.
pub(crate) fn search(extremal: &Extremal, ask: &Ask, stop: &dyn Fn() -> bool) -> Found {
    let mut found = search_once(extremal, ask, stop);
    let again = ask.thoroughness == Thoroughness::Default && ask.path == Way::Best && extremal.seeks_time();
    if !again || stop() {
        return found;
    }
    found.eigenaxis = eigenaxis::duration(extremal);
    let slow = |quickest: &Limit| Some(quickest.duration() >= found.eigenaxis? * (1.0 - NO_GAIN));
    if found.limits.first().and_then(slow) != Some(true) {
        return found;
    }
    let mut more = search_once(extremal, &Ask { thoroughness: Thoroughness::Thorough, ..*ask }, stop);
    more.limits.extend(found.limits);
    more.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    more.limits.dedup_by(|a, b| (a.cost(extremal) - b.cost(extremal)).abs() <= SAME * b.cost(extremal));
    let [sweeps, newtons] = [more.sweeps + found.sweeps, more.newtons + found.newtons];
    Found { sweeps, newtons, eigenaxis: found.eigenaxis, ..more }
}

fn search_once(extremal: &Extremal, ask: &Ask, stop: &dyn Fn() -> bool) -> Found {
    let mut found = Found::default();
    let rivals = branches(extremal, ask, stop, &mut found.sweeps);
    found.branches = rivals.len();
    let Some(best) = rivals.first().map(|first| first.cost(extremal)) else { return found };
    let limit = best * if extremal.counts_fuel() { RIVAL_FUEL } else { RIVAL };
    for rival in rivals.iter().filter(|rival| rival.cost(extremal) <= limit) {
        if stop() {
            break;
        }
        let limit = end_game(extremal, rival, ask, stop, &mut found);
        found.limits.push(limit);
        // Branches may part below the ε at which they were compared.
        if ask.thoroughness != Thoroughness::Quick
            && rests_on_a_symmetry(extremal, rival)
            && let Some(tipped) = tipped(extremal, rival, stop, &mut found)
        {
            let limit = end_game(extremal, &tipped, ask, stop, &mut found);
            found.limits.push(limit);
        }
    }
    found.limits.sort_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)));
    found
}

/// Whether a branch of minimum time has inputs that a symmetry alone keeps out of use: as a rule it is a saddle.
fn rests_on_a_symmetry(extremal: &Extremal, branch: &Smoothed) -> bool {
    let size = |input: usize| {
        let nodes = branch.path.nodes.iter();
        nodes.map(|node| extremal.switching(input, &node.e).abs()).fold(0.0, f64::max)
    };
    let sizes: Vec<f64> = (0..extremal.axes().len()).map(size).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    extremal.seeks_time() && sizes.iter().any(|size| *size <= UNUSED * largest)
}

/// A branch to its limit: as arcs, at once or from a smaller ε, or as a smoothed extremal.
fn end_game(
    extremal: &Extremal,
    rival: &Smoothed,
    ask: &Ask,
    stop: &dyn Fn() -> bool,
    found: &mut Found,
) -> Limit {
    let mut at = rival.clone();
    let mut best: Option<(Arcs, Certificate)> = None;
    let attempts = match &extremal.law {
        _ if !ask.arcs => 0,
        Law::Norm(_) if extremal.counts_fuel() => MOST_DESCENTS_NORM,
        Law::Norm(_) => 0,
        Law::Inputs(_) if extremal.counts_fuel() => MOST_DESCENTS_FUEL,
        Law::Inputs(_) => MOST_DESCENTS,
    };
    for _ in 0..attempts {
        if stop() {
            break;
        }
        for first in readings(extremal) {
            let Some((arcs, certificate)) = polish(extremal, first(extremal, &at), found) else { continue };
            if certificate.gap <= NO_GAP * arcs.cost(extremal) && bounded(extremal, &arcs, &at) {
                return Limit::of_arcs(rival, at, (arcs, certificate));
            }
            if best.as_ref().is_none_or(|(_, known)| certificate.gap < known.gap) {
                best = Some((arcs, certificate));
            }
        }
        match descend(extremal, &at, SMALLER * at.epsilon, &Bias::default(), &mut found.sweeps) {
            Ok(next) => at = next,
            Err(next) => {
                at = next;
                break;
            }
        }
    }
    if extremal.counts_fuel() {
        return fuel_limit(extremal, rival, at, best, ask, stop, found);
    }
    let mut looser = Vec::new();
    if let Some(best) = best {
        let refined =
            if is_small(extremal, &best) { vec![best] } else { refined(extremal, best, stop, found) };
        looser.extend(refined.into_iter().filter(|(arcs, _)| bounded(extremal, arcs, &at)));
    }
    if let Some(arcs) = looser.pop_if(|best| is_small(extremal, best)) {
        return Limit { looser, ..Limit::of_arcs(rival, at, arcs) };
    }
    let smooth = match descend(extremal, &at, LAST, &Bias::default(), &mut found.sweeps) {
        Ok(end) => end,
        Err(end) => tipped(extremal, rival, stop, found).unwrap_or(end),
    };
    let smooth = match &extremal.law {
        Law::Norm(_) => turning(extremal, smooth, found),
        Law::Inputs(_) => settle(extremal, smooth, SMALLEST, &mut found.sweeps),
    };
    Limit { branch: rival.clone(), smooth, arcs: None, looser }
}

/// Whether the gap of arcs can stay.
pub(super) fn is_small(extremal: &Extremal, (arcs, certificate): &(Arcs, Certificate)) -> bool {
    certificate.gap <= SMALL_GAP * arcs.cost(extremal)
}

/// Whether arcs can be the limit of a smoothed extremal: Newton may have gone to a dearer one.
pub(super) fn bounded(extremal: &Extremal, arcs: &Arcs, smooth: &Smoothed) -> bool {
    let dearer = if extremal.counts_fuel() { DEARER_FUEL } else { DEARER };
    arcs.cost(extremal) <= smooth.cost(extremal) * (1.0 + dearer)
}

/// The best extremal at the last ε that biases lead to, for a branch that ends before.
pub(super) fn tipped(
    extremal: &Extremal,
    rival: &Smoothed,
    stop: &dyn Fn() -> bool,
    found: &mut Found,
) -> Option<Smoothed> {
    let reached = tips(extremal).take_while(|_| !stop()).filter_map(|bias| {
        let reached = descend(extremal, rival, LAST, &bias, &mut found.sweeps).ok()?;
        let unbiased = Smooth { extremal, epsilon: LAST, bias: Bias::default(), accurate: false };
        let path = unbiased.solve(reached.path, 0.1 * LAST, TIPPED_ITERATIONS, &mut found.sweeps)?;
        Some(Smoothed { path, epsilon: LAST })
    });
    reached.min_by(|a, b| a.cost(extremal).total_cmp(&b.cost(extremal)))
}

/// Under a limit of the norm the law is smooth where the costate does not vanish: the extremal without smoothing, where
/// Newton finds it.
fn turning(extremal: &Extremal, from: Smoothed, found: &mut Found) -> Smoothed {
    let exact = Smooth { extremal, epsilon: 0.0, bias: Bias::default(), accurate: true };
    let mut path = from.path.clone();
    while path.intervals() < TURNING {
        path = exact.doubled(&path);
    }
    match exact.solve(path, EXACT, TURNING_ITERATIONS, &mut found.sweeps) {
        Some(path) => Smoothed { path, epsilon: 0.0 },
        None => from,
    }
}

/// How arcs are read from a smoothed path.
type Reading = fn(&Extremal, &Smoothed) -> Arcs;

/// By the crossings of the switching functions; where fuel counts by pulses too, of which some only graze zero, while
/// others have hardly a gap between them.
fn readings(extremal: &Extremal) -> &'static [Reading] {
    const CROSSINGS: Reading = |extremal, from| Arcs::of_path(extremal, &from.path);
    const PULSES: Reading = |extremal, from| Arcs::of_pulses(extremal, &from.path, from.epsilon, 1);
    match extremal.law {
        Law::Norm(_) => &[CROSSINGS, PULSES],
        Law::Inputs(_) if extremal.counts_fuel() => &[PULSES, CROSSINGS],
        Law::Inputs(_) => &[CROSSINGS],
    }
}

/// Arcs to their switching times, corrected until every sign is right or no correction helps.
pub(super) fn polish(extremal: &Extremal, mut arcs: Arcs, found: &mut Found) -> Option<(Arcs, Certificate)> {
    let mut best: Option<(Arcs, Certificate)> = None;
    let mut last = f64::NAN;
    for _ in 0..=MOST_CHANGES {
        let Some((solved, certificate)) = certified(extremal, arcs, found) else { break };
        let exact = certificate.gap <= NO_GAP * solved.cost(extremal);
        let again = (certificate.gap - last).abs() <= SAME_GAP * last;
        last = certificate.gap;
        let mended = certificate.mended(&solved, 0, 1.0);
        if best.as_ref().is_none_or(|(_, known)| certificate.gap < known.gap) {
            best = Some((solved, certificate));
        }
        match mended {
            Some(next) if !exact && !again && next.switches.len() <= extremal.most_switches() => arcs = next,
            _ => break,
        }
    }
    best
}

fn certified(extremal: &Extremal, arcs: Arcs, found: &mut Found) -> Option<(Arcs, Certificate)> {
    found.newtons += 1;
    Some(measured(extremal, arcs.solve(extremal)?))
}

/// Arcs with their certificate, by the costates of the least gap where their own leave more.
pub(super) fn measured(extremal: &Extremal, arcs: Arcs) -> (Arcs, Certificate) {
    let mut certificate = Certificate::of(extremal, &arcs);
    if certificate.gap > NO_GAP * arcs.cost(extremal)
        && let Some(moved) = with_least_gap(extremal, &arcs)
    {
        certificate.bound_by(extremal, moved);
    }
    (arcs, certificate)
}

/// Arcs corrected further, each time by what makes their gap smaller: the worst of the wrong signs, or the next ones,
/// for all of their time or a part of it. All of them, the best last.
pub(super) fn refined(
    extremal: &Extremal,
    first: (Arcs, Certificate),
    stop: &dyn Fn() -> bool,
    found: &mut Found,
) -> Vec<(Arcs, Certificate)> {
    let (mut path, mut newtons) = (vec![first], 0);
    while let Some((arcs, certificate)) = path.last()
        && certificate.gap > NO_GAP * arcs.cost(extremal)
        && !stop()
    {
        let all = (0..WORST).flat_map(|rank| PARTS.map(|part| (rank, part)));
        let corrections = all
            .filter_map(|(rank, part)| certificate.mended(arcs, rank, part))
            .filter(|next| next.switches.len() <= extremal.most_switches());
        let better = corrections.take(MOST_REFINEMENTS - newtons).find_map(|next| {
            newtons += 1;
            certified(extremal, next, found).filter(|(_, next)| next.gap < LESS * certificate.gap)
        });
        match better {
            Some(better) => path.push(better),
            None => break,
        }
    }
    path
}
