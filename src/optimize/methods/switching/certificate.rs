//! Whether arcs satisfy the maximum principle, and by how much they fail it.
//!
//! Every input must be `−sign(s_j)` all along. The cost still to be gained, a duration where only time counts, is to first
//! order
//!
//! ```text
//! gap = ∫ Σ_j (|s_j| + s_j v_j) dt
//! ```

use super::arcs::{Arcs, Switch, between};
use super::extremal::Extremal;
use super::flow::{COOPER_VERNER, Course, Lanes, Node, advance};

/// Longest part of the duration between two nodes, and points of the cubic between them.
const STEP: f64 = 0.03;
const POINTS: usize = 4;

/// A switching function of this size is zero: the cubic between two nodes is as good as that.
const ZERO: f64 = 1e-6;

/// What is found along a maneuver of arcs.
#[derive(Clone, Debug)]
pub(crate) struct Certificate {
    /// Cost still to be gained, to first order.
    pub gap: f64,
    /// Where an input has the wrong sign.
    pub wrong: Vec<Wrong>,
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
        let all = arcs.arcs();
        let last = all.len() - 1;
        for (index, (from, start, stop, signs)) in all.iter().enumerate() {
            let law = extremal.on_arc(signs);
            let steps = ((stop - start) / (STEP * arcs.duration)).ceil().clamp(1.0, 1e3) as usize;
            let length = (stop - start) / steps as f64;
            let mut node = *from;
            for step in 0..steps {
                let mut none = Lanes::<3>::zero();
                let next = advance(
                    &Course::of(extremal, &arcs.m),
                    &COOPER_VERNER,
                    &node,
                    length,
                    &mut none,
                    |_, e| law.at(e),
                );
                let rates =
                    [&node, &next].map(|node| extremal.rate(&arcs.m, node, &law.at(&node.e).torque)[2]);
                for point in 0..POINTS {
                    let x = (point as f64 + 0.5) / POINTS as f64;
                    let e = hermite(x, length, [&node.e, &next.e], [&rates[0], &rates[1]]);
                    let time = start + (step as f64 + x) * length;
                    for input in 0..inputs {
                        let s = extremal.switching(input, &e) * signs[input];
                        let half = 0.5 * length / POINTS as f64;
                        if s > ZERO {
                            let here = between(&node, &next, x);
                            let run = open[input].get_or_insert(Wrong {
                                input,
                                from: (time - half, here),
                                to: (time, here),
                                peak: (time, here),
                                largest: 0.0,
                                at_start: index == 0 && step == 0 && point == 0,
                                at_end: false,
                                gap: 0.0,
                            });
                            run.gap += 4.0 * half * s;
                            run.to = (time + half, here);
                            if s > run.largest {
                                (run.peak, run.largest) = ((time, here), s);
                            }
                            run.at_end = index == last && step + 1 == steps && point + 1 == POINTS;
                        } else if let Some(run) = open[input].take() {
                            wrong.push(run);
                        }
                    }
                }
                node = next;
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
        Self { gap, wrong }
    }

    /// The inputs with a wrong sign somewhere, from 0.
    pub fn singular(&self) -> Vec<usize> {
        let mut inputs: Vec<usize> = self.wrong.iter().map(|wrong| wrong.input).collect();
        inputs.sort_unstable();
        inputs.dedup();
        inputs
    }

    /// The arcs with one of the wrong signs put right, the worst at rank 0, on this part of its time about where it is most
    /// wrong: how long an input should have the other sign is not how long it has the wrong one.
    pub fn mended(&self, arcs: &Arcs, rank: usize, part: f64) -> Option<Arcs> {
        let mut wrong: Vec<&Wrong> = self.wrong.iter().collect();
        wrong.sort_by(|a, b| b.gap.total_cmp(&a.gap));
        let worst = wrong.get(rank)?;
        let mut mended = arcs.clone();
        let switch = |(time, node): (f64, Node)| Switch { input: worst.input, time, node };
        let half = 0.5 * part * (worst.to.0 - worst.from.0);
        let near = |time: f64, end: (f64, Node)| if part < 1.0 { (time, worst.peak.1) } else { end };
        let (from, to) = (worst.peak.0 - half, worst.peak.0 + half);
        if worst.at_start && (part >= 1.0 || from <= worst.from.0) {
            mended.signs[worst.input] *= -1.0;
        } else {
            mended.switches.push(switch(near(from.max(worst.from.0), worst.from)));
        }
        if !(worst.at_end && (part >= 1.0 || to >= worst.to.0)) {
            mended.switches.push(switch(near(to.min(worst.to.0), worst.to)));
        }
        mended.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
        Some(mended)
    }
}

fn hermite<V>(x: f64, length: f64, ends: [&V; 2], rates: [&V; 2]) -> V
where
    V: Clone + std::ops::Add<V, Output = V> + std::ops::Mul<f64, Output = V>,
{
    let (x2, x3) = (x * x, x * x * x);
    ends[0].clone() * (2.0 * x3 - 3.0 * x2 + 1.0)
        + rates[0].clone() * (length * (x3 - 2.0 * x2 + x))
        + ends[1].clone() * (3.0 * x2 - 2.0 * x3)
        + rates[1].clone() * (length * (x3 - x2))
}
