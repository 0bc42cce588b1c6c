//! Bang-bang extremals: Newton on costates, duration and switching times.
//!
//! The unknowns are the costates `M` and `e_0` at the start, the times `t_j` at each of which one
//! input switches from one limit to the other, and the duration `T` if it is free. The equations
//! are the six terminal conditions, `s_j(t_j) = 0` for the switching function of the input that
//! switches and, if `T` is free, `H(0) = 0` for the Hamiltonian. Each arc is integrated from its
//! own stored node (`sequence`), as in the smoothed problem, so that errors do not grow along a
//! long maneuver. If fewer inputs switch than there are terminal conditions, the costates are not
//! unique, and the Newton step is the shortest one.

use super::extremal::Extremal;
use super::flow::{Course, Node};
use super::grid_step::Torque;
use super::sequence::{Sequence, Step, SweptArcs};
use super::smooth::Path;
use super::tuning::arcs::*;
use super::tuning::smooth::TIME_STEP;
use super::tuning::{COARSER, FAR_ITERATIONS, FINE, NOTHING, SAME, UNDETERMINED, ZERO};
use crate::Vector3;
use crate::optimize::nlp::kkt::{KktSystem, NewtonSteps, untied};
use nalgebra::{DMatrix, DVector, Vector6};

/// A switch: the time at which one input changes to its other limit, and the node at this time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Switch {
    pub input: usize,
    pub time: f64,
    pub node: Node,
}

/// A maneuver of bang-bang arcs, with its costates.
#[derive(Clone, Debug)]
pub(crate) struct Arcs {
    /// Attitude costate `M`, reference axes.
    pub m: Vector3,
    pub duration: f64,
    pub first: Node,
    /// Signs of the inputs on the first arc.
    pub signs: Vec<f64>,
    /// Switches in order of time.
    pub switches: Vec<Switch>,
}

impl Arcs {
    /// Returns the cost of the maneuver: the integral of the time price and the input costs.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        let arc = |(_, start, end, signs): &(Node, f64, f64, Vec<f64>)| {
            (end - start) * (extremal.time_price + extremal.on_arc(signs).running())
        };
        self.arcs().iter().map(arc).sum()
    }

    /// Converts arcs of the time-reversed maneuver to arcs of `extremal`.
    pub fn reversed(&self, extremal: &Extremal) -> Self {
        let switched = |switch: &Switch| Switch {
            time: self.duration - switch.time,
            node: switch.node.reversed(extremal),
            ..*switch
        };
        Self {
            m: -extremal.end_attitude * self.m,
            duration: self.duration,
            first: Node::at_start(extremal, self.end(extremal).e),
            signs: self.last_signs(),
            switches: self.switches.iter().rev().map(switched).collect(),
        }
    }

    /// Returns the node at the end of the last arc.
    pub fn end(&self, extremal: &Extremal) -> Node {
        let (node, start) = self.switches.last().map_or((self.first, 0.0), |last| (last.node, last.time));
        let (law, course) = (extremal.on_arc(&self.last_signs()), Course::of(extremal, &self.m));
        course.reached(&node, self.duration - start, |_, e| law.at(e))
    }

    /// Returns the signs of the inputs on the last arc.
    fn last_signs(&self) -> Vec<f64> {
        let mut signs = self.signs.clone();
        for switch in &self.switches {
            signs[switch.input] = -signs[switch.input];
        }
        signs
    }

    /// Extracts the pulses of the inputs along a smoothed path, for inputs that are mostly off.
    /// Each pulse has the area and the centroid of the smoothed input, so that a pulse is not lost
    /// if its switching function only grazes zero. A time through which an input stays between its
    /// limits, as on a singular arc, is replaced by `cells` pulses.
    pub fn of_pulses(extremal: &Extremal, path: &Path, epsilon: f64, cells: usize) -> Self {
        let levels: Vec<Vec<f64>> = path.nodes.iter().map(|node| extremal.inputs(&node.e, epsilon)).collect();
        let at = |time: f64| {
            let (index, share) = path.interval_at(time / path.duration);
            between(&path.nodes[index], &path.nodes[index + 1], share)
        };
        let mut signs = vec![-1.0; extremal.switching_count()];
        let mut switches = Vec::new();
        for (input, sign) in signs.iter_mut().enumerate() {
            let on: Vec<f64> = levels.iter().map(|levels| 0.5 + 0.5 * levels[input]).collect();
            for (from, to) in pulses(path, &on, cells) {
                if from > 0.0 {
                    switches.push(Switch { input, time: from, node: at(from) });
                } else {
                    *sign = 1.0;
                }
                if to < path.duration {
                    switches.push(Switch { input, time: to, node: at(to) });
                }
            }
        }
        switches.sort_by(|a, b| a.time.total_cmp(&b.time));
        Self { m: path.m, duration: path.duration, first: path.nodes[0], signs, switches }
    }

    /// Extracts the arcs of a smoothed path: the signs and the zero crossings of the switching
    /// functions.
    pub fn of_path(extremal: &Extremal, path: &Path) -> Self {
        let inputs = extremal.switching_count();
        let switching = |node: &Node| -> Vec<f64> {
            (0..inputs).map(|input| extremal.switching(input, &node.e)).collect()
        };
        let values: Vec<Vec<f64>> = path.nodes.iter().map(switching).collect();
        let mut switches = Vec::new();
        for k in 0..path.intervals() {
            for (input, (a, b)) in values[k].iter().zip(&values[k + 1]).enumerate() {
                if (*a < 0.0) != (*b < 0.0) {
                    let part = a / (a - b);
                    let node = between(&path.nodes[k], &path.nodes[k + 1], part);
                    let at = path.parts[k] + part * (path.parts[k + 1] - path.parts[k]);
                    switches.push(Switch { input, time: at * path.duration, node });
                }
            }
        }
        switches.sort_by(|a, b| a.time.total_cmp(&b.time));
        let signs = values[0].iter().map(|s| if *s < 0.0 { 1.0 } else { -1.0 }).collect();
        Self { m: path.m, duration: path.duration, first: path.nodes[0], signs, switches }
    }

    /// Returns the arcs in order: first node, start time, end time and the signs of the inputs.
    pub fn arcs(&self) -> Vec<(Node, f64, f64, Vec<f64>)> {
        let mut signs = self.signs.clone();
        let (mut node, mut start) = (self.first, 0.0);
        let mut arcs = Vec::with_capacity(self.switches.len() + 1);
        for switch in &self.switches {
            arcs.push((node, start, switch.time, signs.clone()));
            signs[switch.input] = -signs[switch.input];
            (node, start) = (switch.node, switch.time);
        }
        arcs.push((node, start, self.duration, signs));
        arcs
    }

    /// Returns the durations of the arcs.
    pub fn lengths(&self) -> Vec<f64> {
        self.arcs().iter().map(|(_, start, end, _)| end - start).collect()
    }

    /// Returns the costates `(M, e_0)` at the start.
    pub fn costates(&self) -> Vector6<f64> {
        Vector6::from_iterator(self.m.iter().chain(self.first.e.iter()).copied())
    }

    /// Sweeps over the arcs and returns the KKT system in costates and times. `longest` is the
    /// longest integration step, as a fraction of the duration.
    pub(super) fn swept(&self, extremal: &Extremal, longest: f64) -> Option<(SweptArcs, KktSystem)> {
        let (mut lengths, mut nodes, mut steps) = (Vec::new(), Vec::new(), Vec::new());
        for (arc, (node, start, end, signs)) in self.arcs().into_iter().enumerate() {
            lengths.push(end - start);
            nodes.push(node);
            steps.push(Step { arc, part: 1.0, torque: Torque::Arc(extremal.on_arc(&signs)) });
        }
        let (m, beside, longest) = (&self.m, Sequence::AT_THE_NODE, Some(longest));
        let sequence = Sequence { m, lengths: &lengths, steps: &steps, nodes: &nodes, beside, longest };
        let (swept, of_times) = (sequence.swept(extremal)?, self.of_times(extremal));
        let mut kkt = swept.kkt.tied(&of_times);
        // The condition on a switch is the jump of the Hamiltonian, which vanishes with the
        // switching function. Newton converges from farther away with the switching function.
        for (j, switch) in self.switches.iter().enumerate() {
            let slope = extremal.switching_slope(switch.input, &switch.node.e);
            let value = extremal.switching(switch.input, &switch.node.e);
            kkt.replace(6 + j, value, &swept.costate(j + 1).tr_mul(&slope), &of_times);
        }
        if extremal.given_duration.is_none() {
            let at_start = swept.kkt.jacobian.row(6).transpose().push(0.0);
            kkt.replace(6 + self.switches.len(), swept.kkt.residual[6], &at_start, &of_times);
        }
        Some((swept, kkt))
    }

    /// Returns the derivatives of the arc lengths with respect to the switching times and, if the
    /// duration is free, with respect to the duration.
    fn of_times(&self, extremal: &Extremal) -> DMatrix<f64> {
        let arcs = self.switches.len() + 1;
        let times = arcs - usize::from(extremal.given_duration.is_some());
        let of = |arc: usize, time: usize| {
            if arc == time { 1.0 } else { -f64::from(arc == time + 1) }
        };
        DMatrix::from_fn(arcs, times, of)
    }

    /// Solves for the switching times by Newton; if pulses vanish, removes them and solves again.
    /// Returns `None` if Newton does not converge or too few switches remain.
    pub fn solve(self, extremal: &Extremal) -> Option<Self> {
        let mut found = self.solved(extremal)?;
        while found.drop_pulses(SAME * found.duration) {
            found = found.solved(extremal)?;
        }
        Some(found)
    }

    /// Removes pulses that last at most `longest`, scaled; returns whether any were removed.
    fn drop_pulses(&mut self, longest: f64) -> bool {
        let count = self.switches.len();
        let short = |this: &Self| {
            let length = |(a, b): (usize, usize)| this.switches[b].time - this.switches[a].time;
            this.pairs().find(|pair| length(*pair) <= longest)
        };
        while let Some((a, b)) = short(self) {
            self.switches.remove(b);
            self.switches.remove(a);
        }
        self.switches.len() < count
    }

    fn solved(mut self, extremal: &Extremal) -> Option<Self> {
        if let Some(given) = extremal.given_duration {
            let factor = given / self.duration;
            self.switches.iter_mut().for_each(|switch| switch.time *= factor);
            self.duration = given;
        }
        let mut longest = COARSER * FINE;
        for _ in 0..FAR_ITERATIONS {
            let count = self.switches.len();
            if !(extremal.fewest_switches()..=MOST_SWITCHES).contains(&count) {
                return None;
            }
            let (swept, kkt) = self.swept(extremal, longest)?;
            let merit = kkt.residual.norm_squared() + swept.gaps;
            if merit < ZERO.powi(2) && longest <= FINE {
                return Some(self);
            }
            if merit < NOTHING.powi(2) && longest > FINE {
                longest = FINE;
                continue;
            }
            let steps = if count >= DETERMINED { NewtonSteps::Determined } else { NewtonSteps::Shortest };
            self.take(&kkt.newton_step(steps, UNDETERMINED)?, &swept, extremal)?;
        }
        None
    }

    /// Applies a limited Newton step to costates and times, then restores the order of the
    /// switches.
    fn take(&mut self, step: &DVector<f64>, swept: &SweptArcs, extremal: &Extremal) -> Option<()> {
        let count = self.switches.len();
        let costate = (self.m.norm_squared() + self.first.e.norm_squared()).sqrt();
        let longest = step.rows(6, step.len() - 6).amax();
        let mut factor = (costate / step.rows(0, 6).norm()).min(1.0);
        factor = factor.min(TIME_STEP * self.duration / longest);
        if !factor.is_finite() {
            return None;
        }
        // True if neighbouring switches of one input would exchange their order.
        let crosses = |factor: f64| {
            let after = |j: usize| self.switches[j].time + factor * step[6 + j];
            self.pairs().any(|(a, b)| after(a) >= after(b))
        };
        for _ in 0..2 {
            if crosses(factor) {
                factor *= 0.5;
            }
        }
        let disturbances = swept.disturbances(&untied(&self.of_times(extremal), step));
        self.m += factor * step.fixed_rows::<3>(0);
        self.first.e += factor * step.fixed_rows::<3>(3);
        self.duration += factor * step.get(6 + count).unwrap_or(&0.0);
        for (j, (switch, moved)) in self.switches.iter_mut().zip(disturbances.skip(1)).enumerate() {
            switch.time += factor * step[6 + j];
            switch.node = switch.node.plus(&moved, factor);
        }
        self.order();
        Some(())
    }

    /// Returns the pairs of indices of consecutive switches of the same input, for all inputs.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.switches.len()).filter_map(|a| {
            let input = self.switches[a].input;
            (a + 1..self.switches.len()).find(|b| self.switches[*b].input == input).map(|b| (a, b))
        })
    }

    /// Removes pulses that have vanished and switches outside of the duration, and sorts the
    /// remaining switches by time.
    fn order(&mut self) {
        self.drop_pulses(0.0);
        let duration = self.duration;
        for switch in self.switches.iter().filter(|switch| switch.time <= 0.0) {
            self.signs[switch.input] = -self.signs[switch.input];
        }
        self.switches.retain(|switch| switch.time > 0.0 && switch.time < duration);
        self.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
    }
}

/// Returns the start and end times of the pulses of an input with the levels `on`, from 0 to 1, at
/// the nodes of a path.
fn pulses(path: &Path, on: &[f64], cells: usize) -> Vec<(f64, f64)> {
    let n = path.intervals();
    // By the trapezoidal rule each node of a run represents half of both adjacent intervals.
    let part = |node: usize| 0.5 * (path.parts[(node + 1).min(n)] - path.parts[node.saturating_sub(1)]);
    let idle = |node: &usize| on[*node] <= IDLE;
    let mut pulses: Vec<(f64, f64)> = Vec::new();
    let mut node = 0;
    while node <= n {
        let first = node;
        node = (first..=n).find(idle).unwrap_or(n + 1);
        let run = first..node;
        let (begin, length) = (path.parts[first], run.clone().map(part).sum::<f64>());
        let area = |range: std::ops::Range<usize>| range.map(|node| on[node] * part(node)).sum::<f64>();
        let pieces = if area(run.clone()) < BETWEEN * length { cells } else { 1 };
        let mut cut = first;
        for piece in 1..=pieces {
            let limit = begin + length * piece as f64 / pieces as f64;
            let next = if piece == pieces {
                node
            } else {
                (cut..node).find(|node| path.parts[*node] >= limit).unwrap_or(node)
            };
            let own = area(cut..next) * path.duration;
            if own > SHORTEST_PULSE * path.duration {
                let moment: f64 = (cut..next).map(|node| on[node] * part(node) * path.parts[node]).sum();
                let middle = moment * path.duration * path.duration / own;
                let pulse = if cut == 0 && on[0] > 0.5 {
                    (0.0, own)
                } else if next > n && on[n] > 0.5 {
                    (path.duration - own, path.duration)
                } else {
                    (middle - 0.5 * own, middle + 0.5 * own)
                };
                match pulses.last_mut() {
                    // Pulses of adjacent cells at full level have no pause between them.
                    Some(last) if cut > first && pulse.0 <= last.1 + SHORTEST_PULSE * path.duration => {
                        last.1 += own;
                    }
                    _ => pulses.push(pulse),
                }
            }
            cut = next;
        }
        node += 1;
    }
    pulses
}

/// Returns the node interpolated between `a` (`part` = 0) and `b` (`part` = 1).
pub(super) fn between(a: &Node, b: &Node, part: f64) -> Node {
    a.plus(&b.minus(a), part)
}
