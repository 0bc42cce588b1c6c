//! Whether arcs satisfy the maximum principle, and by how much they fail it.
//!
//! Every input must be `−sign(s_j)` all along. The cost still to be gained, a duration where only time counts, is to first
//! order
//!
//! ```text
//! gap = ∫ Σ_j (|s_j| + s_j v_j) dt
//! ```
//!
//! # When is a plan of minimum time called an extremal?
//!
//! The maximum principle is tested along every arc: an input must be at the limit opposite to its switching function. Where
//! it is not, the integral of what is missing is the time still to be gained, to first order; it is the `gap`. With equal
//! moments of inertia a quarter of all maneuvers has a singular arc, at whose ends inputs chatter: no finite list of switches
//! is exact. They end as arcs with a small gap, or as a smoothed law with its ε, and the plan says which. A certificate says
//! nothing of other branches: how often the answer is the best known is counted (`cargo run --release -p evidence --
//! minimum_time`).

use super::arcs::{Arcs, Switch};
use super::extremal::{ArcLaw, Extremal};
use super::flow::{Course, Node};
use super::sequence::steps;
use super::tuning::arcs::{TOGETHER, ZERO};
use super::tuning::{FINE, POINTS};
use crate::numerics::widest::widest;
use std::f64::consts::PI;

/// What is found along a maneuver of arcs.
#[derive(Clone, Debug)]
pub(crate) struct Certificate {
    /// Cost still to be gained, to first order.
    pub gap: f64,
    /// Where an input has the wrong sign.
    pub wrong: Vec<Wrong>,
    /// The same maneuver with the costates of the least gap, and where inputs have the wrong sign by those.
    pub least: Option<(Arcs, Vec<Wrong>)>,
}

/// An input has the wrong sign from one time to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrong {
    pub input: usize,
    pub from: (f64, Node),
    pub to: (f64, Node),
    /// Where it is most wrong, and by how much.
    pub peak: (f64, Node),
    pub largest: f64,
    pub at_start: bool,
    pub at_end: bool,
    pub gap: f64,
}

impl Certificate {
    pub fn of(extremal: &Extremal, arcs: &Arcs) -> Self {
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
            // A switch ends a run of the input that switches.
            if let Some(switch) = arcs.switches.get(index)
                && let Some(run) = open[switch.input].take()
            {
                wrong.push(run);
            }
        }
        wrong.extend(open.into_iter().flatten());
        // A sum of nothing would be −0.
        let gap = wrong.iter().fold(0.0, |sum, run| sum + run.gap);
        Self { gap, wrong, least: None }
    }

    /// Takes the gap of the same maneuver with other costates, where that is smaller.
    pub fn bound_by(&mut self, extremal: &Extremal, moved: Arcs) {
        let least = Self::of(extremal, &moved);
        if least.gap < self.gap {
            self.gap = least.gap;
            self.least = Some((moved, least.wrong));
        }
    }

    /// The inputs with a wrong sign somewhere, from 0, by the costates that the gap is measured with.
    pub fn singular(&self) -> Vec<usize> {
        let wrong = self.least.as_ref().map_or(&self.wrong, |(_, wrong)| wrong);
        let mut inputs: Vec<usize> = wrong.iter().map(|wrong| wrong.input).collect();
        inputs.sort_unstable();
        inputs.dedup();
        inputs
    }

    /// The arcs with one of the wrong signs put right, the worst at rank 0, on this part of its time about where it is most
    /// wrong: how long an input should have the other sign is not how long it has the wrong one.
    pub fn mended(&self, arcs: &Arcs, rank: usize, part: f64) -> Option<Arcs> {
        Some(put_right(arcs, by_gap(&self.wrong).get(rank..=rank)?, part))
    }

    /// The same with the worst and all of a fifth of its gap put right: the pulses of a singular arc lack others on all sides.
    pub fn worst_mended(&self, arcs: &Arcs, part: f64) -> Option<Arcs> {
        let worst = with_the_worst(&self.wrong);
        (!worst.is_empty()).then(|| put_right(arcs, &worst, part))
    }

    /// The same by the costates of the least gap.
    pub fn least_mended(&self, part: f64) -> Option<Arcs> {
        let (arcs, wrong) = self.least.as_ref()?;
        Some(put_right(arcs, &with_the_worst(wrong), part))
    }

    /// The same by both, each run once.
    pub fn all_mended(&self, arcs: &Arcs, part: f64) -> Option<Arcs> {
        let mut worst = with_the_worst(&self.wrong);
        if let Some((_, wrong)) = &self.least {
            let meet = |a: &Wrong, b: &Wrong| a.input == b.input && a.from.0 < b.to.0 && b.from.0 < a.to.0;
            let apart = |run: &&Wrong| !self.wrong.iter().any(|own| meet(own, run));
            worst.extend(with_the_worst(wrong).into_iter().filter(apart));
        }
        (!worst.is_empty()).then(|| put_right(arcs, &worst, part))
    }
}

/// When an arc of this length is looked at, and half of the time for which each look stands: close together towards its ends, as
/// costates that do not vanish at a switch do so a little beside it.
pub(super) fn looks(extremal: &Extremal, from: &Node, (length, duration): (f64, f64)) -> Vec<(f64, f64)> {
    let count = POINTS * steps(extremal, from, (length, duration), 2.0 * FINE);
    let edge = |k: usize| 0.5 * length * (1.0 - (PI * k as f64 / count as f64).cos());
    (0..count).map(|k| (0.5 * (edge(k) + edge(k + 1)), 0.5 * (edge(k + 1) - edge(k)))).collect()
}

/// The nodes of an arc when it is looked at.
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

/// The worst first.
fn by_gap(wrong: &[Wrong]) -> Vec<&Wrong> {
    let mut wrong: Vec<&Wrong> = wrong.iter().collect();
    wrong.sort_by(|a, b| b.gap.total_cmp(&a.gap));
    wrong
}

/// The worst, and those whose gap is a fifth of its or more.
fn with_the_worst(wrong: &[Wrong]) -> Vec<&Wrong> {
    let mut wrong = by_gap(wrong);
    let largest = wrong.first().map_or(0.0, |run| run.gap);
    wrong.retain(|run| run.gap >= TOGETHER * largest);
    wrong
}

/// Arcs whose inputs have the other sign on a part of the time of each run.
fn put_right(arcs: &Arcs, runs: &[&Wrong], part: f64) -> Arcs {
    let mut mended = arcs.clone();
    for run in runs {
        let switch = |(time, node): (f64, Node)| Switch { input: run.input, time, node };
        let half = 0.5 * part * (run.to.0 - run.from.0);
        let near = |time: f64, end: (f64, Node)| if part < 1.0 { (time, run.peak.1) } else { end };
        let (from, to) = (run.peak.0 - half, run.peak.0 + half);
        if run.at_start && (part >= 1.0 || from <= run.from.0) {
            mended.signs[run.input] *= -1.0;
        } else {
            mended.switches.push(switch(near(from.max(run.from.0), run.from)));
        }
        if !(run.at_end && (part >= 1.0 || to >= run.to.0)) {
            mended.switches.push(switch(near(to.min(run.to.0), run.to)));
        }
    }
    mended.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
    mended
}
