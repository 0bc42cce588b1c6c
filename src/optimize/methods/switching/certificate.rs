//! Certificate of bang-bang arcs: whether they satisfy the maximum principle, and how much cost is
//! lost where they do not.
//!
//! Every input must be `−sign(s_j)` at all times. To first order, the cost that could still be
//! saved (a duration if only time counts) is
//!
//! ```text
//! gap = ∫ Σ_j (|s_j| + s_j v_j) dt
//! ```
//!
//! # When is a minimum-time plan called an extremal?
//!
//! The maximum principle is tested along every arc: an input must be at the limit opposite to the
//! sign of its switching function. Where it is not, the integral of the violation is, to first
//! order, the time that could still be saved; this is the `gap`. With equal moments of inertia a
//! quarter of all maneuvers has a singular arc, at whose ends inputs chatter: no finite switching
//! structure is exact. Such maneuvers end as arcs with a small gap, or as a smoothed law with its
//! ε, and the plan states which. A certificate does not compare with other branches: the frequency
//! with which the plan is the best known one is measured by
//! `cargo run --release -p evidence -- minimum_time`.

use super::arcs::{Arcs, Switch};
use super::extremal::{ArcLaw, Extremal};
use super::flow::{Course, Node};
use super::sequence::steps;
use super::tuning::arcs::TOGETHER;
use super::tuning::limits::{NO_GAP, SMALL_GAP};
use super::tuning::{FINE, POINTS, ZERO};
use crate::numerics::widest::widest;
use std::f64::consts::PI;

/// Bang-bang arcs with their certificate.
#[derive(Clone, Debug)]
pub(crate) struct Certified {
    pub arcs: Arcs,
    /// Cost that could still be saved, to first order.
    pub gap: f64,
    /// Runs in which an input has the wrong sign.
    pub wrong: Vec<Wrong>,
    /// The arcs with the costates of the smallest gap, and the runs with a wrong sign according to
    /// these costates; `None` if the arcs' own costates have the smallest gap.
    pub least: Option<(Arcs, Vec<Wrong>)>,
}

/// A run: an interval of time on which one input has the wrong sign.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrong {
    pub input: usize,
    pub from: (f64, Node),
    pub to: (f64, Node),
    /// Time and node of the largest violation.
    pub peak: (f64, Node),
    /// Absolute value of the switching function at the largest violation.
    pub largest: f64,
    pub at_start: bool,
    pub at_end: bool,
    pub gap: f64,
}

impl Certified {
    /// Tests the signs of the inputs along the arcs, with the arcs' own costates.
    pub fn of(extremal: &Extremal, arcs: Arcs) -> Self {
        let inputs = extremal.switching_count();
        let mut open: Vec<Option<Wrong>> = vec![None; inputs];
        let mut wrong = Vec::new();
        let (all, course) = (arcs.arcs(), Course::of(extremal, &arcs.m));
        let last = all.len() - 1;
        for (index, (from, start, stop, signs)) in all.iter().enumerate() {
            let law = extremal.on_arc(signs);
            let looks = looks(extremal, from, (stop - start, arcs.duration));
            let most = looks.len() - 1;
            let nodes = seen(&course, from, &law, &looks);
            for (look, ((past, half), node)) in looks.into_iter().zip(nodes).enumerate() {
                let time = start + past;
                for input in 0..inputs {
                    let s = extremal.switching(input, &node.e) * signs[input];
                    if s > ZERO {
                        let run = open[input].get_or_insert(Wrong {
                            input,
                            from: (time - half, node),
                            to: (time, node),
                            peak: (time, node),
                            largest: 0.0,
                            at_start: index == 0 && look == 0,
                            at_end: false,
                            gap: 0.0,
                        });
                        run.gap += 4.0 * half * s;
                        run.to = (time + half, node);
                        if s > run.largest {
                            (run.peak, run.largest) = ((time, node), s);
                        }
                        run.at_end = index == last && look == most;
                    } else if let Some(run) = open[input].take() {
                        wrong.push(run);
                    }
                }
            }
            // A switch ends the run of the input that switches.
            if let Some(switch) = arcs.switches.get(index)
                && let Some(run) = open[switch.input].take()
            {
                wrong.push(run);
            }
        }
        wrong.extend(open.into_iter().flatten());
        // An empty sum of floats would be −0.
        let gap = wrong.iter().fold(0.0, |sum, run| sum + run.gap);
        Self { arcs, gap, wrong, least: None }
    }

    /// Returns whether every input satisfies the maximum principle at all times, that is, the gap
    /// is negligible.
    pub fn is_exact(&self, extremal: &Extremal) -> bool {
        self.gap <= NO_GAP * self.arcs.cost(extremal)
    }

    /// Returns whether the gap is small enough to accept the arcs.
    pub fn is_small(&self, extremal: &Extremal) -> bool {
        self.gap <= SMALL_GAP * self.arcs.cost(extremal)
    }

    /// Replaces the gap by that of `moved`, the same arcs with other costates, if this gap is
    /// smaller.
    pub fn bound_by(&mut self, extremal: &Extremal, moved: Arcs) {
        let least = Self::of(extremal, moved);
        if least.gap < self.gap {
            self.gap = least.gap;
            self.least = Some((least.arcs, least.wrong));
        }
    }

    /// Returns the indices of the inputs that have a wrong sign somewhere, according to the
    /// costates of the reported gap.
    pub fn singular(&self) -> Vec<usize> {
        let wrong = self.least.as_ref().map_or(&self.wrong, |(_, wrong)| wrong);
        let mut inputs: Vec<usize> = wrong.iter().map(|wrong| wrong.input).collect();
        inputs.sort_unstable();
        inputs.dedup();
        inputs
    }

    /// Returns the arcs with the signs of some runs corrected, each over the fraction `part` of its
    /// time about the largest violation. The time for which an input should be changed is not the
    /// time for which it has the wrong sign. Returns `None` if no sign is wrong.
    pub fn corrected(&self, runs: Runs, part: f64) -> Option<Arcs> {
        let arcs = &self.arcs;
        let (arcs, runs) = match (runs, &self.least) {
            (Runs::Rank(rank), _) => (arcs, by_gap(&self.wrong).get(rank..=rank)?.to_vec()),
            (Runs::Worst, _) | (Runs::All, None) => (arcs, with_the_worst(&self.wrong)),
            (Runs::OfLeast, least) => least.as_ref().map(|(arcs, wrong)| (arcs, with_the_worst(wrong)))?,
            (Runs::All, Some((_, wrong))) => {
                let meet =
                    |a: &Wrong, b: &Wrong| a.input == b.input && a.from.0 < b.to.0 && b.from.0 < a.to.0;
                let apart = |run: &&Wrong| !self.wrong.iter().any(|own| meet(own, run));
                let others = with_the_worst(wrong).into_iter().filter(apart);
                (arcs, with_the_worst(&self.wrong).into_iter().chain(others).collect())
            }
        };
        let mut corrected = arcs.clone();
        for run in &runs {
            let switch = |(time, node): (f64, Node)| Switch { input: run.input, time, node };
            let half = 0.5 * part * (run.to.0 - run.from.0);
            let near = |time: f64, end: (f64, Node)| if part < 1.0 { (time, run.peak.1) } else { end };
            let (from, to) = (run.peak.0 - half, run.peak.0 + half);
            if run.at_start && (part >= 1.0 || from <= run.from.0) {
                corrected.signs[run.input] *= -1.0;
            } else {
                corrected.switches.push(switch(near(from.max(run.from.0), run.from)));
            }
            if !(run.at_end && (part >= 1.0 || to >= run.to.0)) {
                corrected.switches.push(switch(near(to.min(run.to.0), run.to)));
            }
        }
        corrected.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
        (!runs.is_empty()).then_some(corrected)
    }
}

/// Selection of the runs of wrong signs that are corrected together.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Runs {
    /// The run with this rank in order of decreasing gap, counted from 0.
    Rank(usize),
    /// The run with the largest gap, and all runs with at least a fifth of its gap: the pulses of a
    /// singular arc need further pulses on all sides.
    Worst,
    /// The runs of `Self::Worst`, according to the costates of the smallest gap.
    OfLeast,
    /// The runs of `Self::Worst` according to both sets of costates, each run once.
    All,
}

/// Returns the times at which an arc is sampled, counted from its start, each with half of the time
/// that the sample represents. Samples are denser towards the ends of the arc, because a switching
/// function that is not zero at a switch is zero shortly before or after it.
pub(super) fn looks(extremal: &Extremal, from: &Node, (length, duration): (f64, f64)) -> Vec<(f64, f64)> {
    let count = POINTS * steps(extremal, from, (length, duration), 2.0 * FINE);
    let edge = |k: usize| 0.5 * length * (1.0 - (PI * k as f64 / count as f64).cos());
    (0..count).map(|k| (0.5 * (edge(k) + edge(k + 1)), 0.5 * (edge(k + 1) - edge(k)))).collect()
}

/// Returns the nodes of an arc at its sample times.
fn seen(course: &Course, from: &Node, law: &ArcLaw, looks: &[(f64, f64)]) -> Vec<Node> {
    widest(
        #[inline(always)]
        || {
            let (mut node, mut at) = (*from, 0.0);
            let mut nodes = Vec::with_capacity(looks.len());
            for (past, _) in looks {
                node = course.reached(
                    &node,
                    past - at,
                    #[inline(always)]
                    |_, e| law.at(e),
                );
                at = *past;
                nodes.push(node);
            }
            nodes
        },
    )
}

/// Sorts runs by their gap, the largest first.
fn by_gap(wrong: &[Wrong]) -> Vec<&Wrong> {
    let mut wrong: Vec<&Wrong> = wrong.iter().collect();
    wrong.sort_by(|a, b| b.gap.total_cmp(&a.gap));
    wrong
}

/// Returns the run with the largest gap and all runs with at least a fifth of this gap, in order of
/// decreasing gap.
fn with_the_worst(wrong: &[Wrong]) -> Vec<&Wrong> {
    let mut wrong = by_gap(wrong);
    let largest = wrong.first().map_or(0.0, |run| run.gap);
    wrong.retain(|run| run.gap >= TOGETHER * largest);
    wrong
}
