//! The first order of arcs, read off a plan on equal steps.
//!
//! A node of the plan stands for the cell half a step about it. Where neighbours of a cell are at two limits its input is between,
//! and divides the cell so that its impulse is kept. An input that is between for long is singular, or has more than it needs: it is cut
//! into pulses, or takes its means. A limit of the state that acts at some nodes in a row is held along an arc, by as
//! many inputs as are within their limits; one of second order that acts at one or two is touched.

use super::constraint::Limit;
use super::motion::{Input, Law, Level, Maneuver};
use super::newton::Arcs;
use super::ramps::{Course, courses};
use super::state::State;
use crate::maneuver::problem as planned;
use crate::maneuver::solution::{Solution, Trajectory};
use crate::{Vector3, lie};

/// An input is at a limit within this part of it.
const AT_LIMIT: f64 = 1e-3;

/// A limit is near within this share of it, or \[rad\].
const NEAR: f64 = 0.03;

/// Multipliers below this part of the largest are none.
const PRESSES: f64 = 1e-6;

/// Nodes in a row between two at which a limit acts that count as acting too.
const GAP: usize = 2;

/// Nodes less one from which on a limit of second order is held.
const RUN: usize = 3;

/// Steps in which one pulse stands for an input that is between its limits, and pulses in the whole duration of finer grids: what a grid
/// says more exactly is not more arcs.
const BETWEEN: usize = 8;
const MOST_PULSES: usize = 12;

/// Parts of the duration on each of which an input that has more than it needs takes its mean: the same for all inputs, so that there
/// are few arcs, and enough for lengths to meet twelve conditions.
const PARTS: f64 = 4.0;

/// Part of a step below which a pulse is none.
const NO_PULSE: f64 = 0.02;

/// An input holds a limit that gives this part of what the one gives that says most of it.
const SAYS: f64 = 0.1;

/// Steps of one piece of what is held, which is held by the same inputs.
const PIECE: f64 = 3.0;

/// What stands for an input that is between its limits for long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    /// Pulses of the same impulse.
    Pulses,
    /// Its means on parts of the duration.
    Means,
}

/// A limit held from one time to another.
struct Held {
    limit: usize,
    from: f64,
    to: f64,
}

/// What inputs hold from one time to another.
struct Stretch {
    from: f64,
    to: f64,
    free: Vec<usize>,
    holds: Vec<usize>,
}

/// A plan in the unit of time, with its inputs as parts of their limits.
struct Read<'a> {
    maneuver: &'a Maneuver,
    between: Between,
    step: f64,
    states: Vec<State>,
    /// Node after node.
    levels: Vec<Vec<f64>>,
}

/// The order of arcs that a plan may stand for; none where it has no rows of inputs at its nodes.
pub(crate) fn arcs(maneuver: &Maneuver, plan: &Solution, between: Between) -> Option<Arcs> {
    let read = Read::of(maneuver, &plan.trajectory, between)?;
    let (held, touched) = match maneuver.ramps().next() {
        Some(_) => (read.held_by_ramps(), Vec::new()),
        None => read.acting(plan),
    };
    Some(read.arcs(&read.stretches(&held), &touched))
}

impl<'a> Read<'a> {
    fn of(maneuver: &'a Maneuver, plan: &Trajectory, between: Between) -> Option<Self> {
        let (nodes, count) = (plan.time.len(), plan.input_count);
        if nodes < 3 || count == 0 || plan.input.len() != nodes * count {
            return None;
        }
        let unit = maneuver.units.time;
        let zero = Vector3::zeros();
        let at = |of: &[Vector3], node: usize| of.get(node).copied().unwrap_or(zero);
        let wheels = plan.wheel_momentum.len() / nodes;
        let state = |node: usize| {
            let attitude = lie::rotation_from_quaternion(&plan.quaternion[node]);
            let angular_velocity = plan.angular_velocity[node];
            let (position, velocity) = (at(&plan.position, node), at(&plan.velocity, node));
            let stored = &plan.wheel_momentum[wheels * node..wheels * (node + 1)];
            let state = planned::State { position, velocity, attitude, angular_velocity };
            maneuver.scaled(&state, stored, plan.time[node])
        };
        let part = |(input, own): (&f64, &Input)| input / own.size;
        let row = |node: usize| plan.inputs(node).iter().zip(&maneuver.inputs).map(part).collect();
        Some(Self {
            maneuver,
            between,
            step: plan.time.last()? / unit / (nodes - 1) as f64,
            states: (0..nodes).map(state).collect(),
            levels: (0..nodes).map(row).collect(),
        })
    }

    fn last(&self) -> usize {
        self.states.len() - 1
    }

    /// The limits that are held, and those touched at a time.
    fn acting(&self, plan: &Solution) -> (Vec<Held>, Vec<(usize, f64)>) {
        let mut at_nodes = vec![vec![false; self.states.len()]; self.maneuver.limits.len()];
        for active in &plan.active {
            let largest = active.multiplier.iter().copied().fold(0.0, f64::max);
            let stage = |time: &f64| (time / (self.step * self.maneuver.units.time)).round() as usize;
            let entries = active.time_s.iter().zip(&active.multiplier);
            let stages: Vec<usize> = entries
                .filter(|(_, multiplier)| **multiplier > PRESSES * largest)
                .map(|(time, _)| stage(time))
                .collect();
            // Of one name may be limits of several axes, or wheels: as many of them act as it has multipliers.
            let own: Vec<usize> = (0..at_nodes.len())
                .filter(|limit| self.maneuver.limits[*limit].name == active.name)
                .collect();
            for run in stages.chunk_by(|a, b| a == b) {
                let nodes = [run[0], run[0] + 1].map(|node| node.min(self.last()));
                let nearest = |limit: &usize| {
                    let value = |node: usize| self.maneuver.limits[*limit].value(&self.states[node]);
                    let values = nodes.map(|node| (value(node), node));
                    let (value, node) = if values[0].0 > values[1].0 { values[0] } else { values[1] };
                    (value, *limit, node)
                };
                let mut places: Vec<(f64, usize, usize)> =
                    own.iter().map(nearest).filter(|(value, ..)| *value > -NEAR).collect();
                places.sort_by(|a, b| b.0.total_cmp(&a.0));
                for (_, limit, node) in places.into_iter().take(run.len()) {
                    at_nodes[limit][node] = true;
                }
            }
        }
        let (mut held, mut touched) = (Vec::new(), Vec::new());
        for (limit, acts) in at_nodes.iter().enumerate() {
            let nodes: Vec<usize> = (0..acts.len()).filter(|node| acts[*node]).collect();
            for run in nodes.chunk_by(|a, b| b - a <= GAP + 1) {
                let (first, last) = (run[0], run[run.len() - 1]);
                let at = |node: usize| node as f64 * self.step;
                if self.maneuver.limits[limit].order() == 1 {
                    let to = at(last).max(at(first) + self.step).min(at(self.last()));
                    held.push(Held { limit, from: at(first), to });
                } else if last - first >= RUN {
                    held.push(Held { limit, from: at(first), to: at(last) });
                } else {
                    touched.push((limit, 0.5 * (at(first) + at(last))));
                }
            }
        }
        (held, touched)
    }

    /// What inputs that change at limited rates do, each from a time on.
    fn courses(&self, input: usize) -> Option<Vec<(f64, Course)>> {
        let ramp = self.maneuver.inputs[input].ramp?;
        let values: Vec<f64> = self.levels.iter().map(|levels| levels[input]).collect();
        Some(courses(&values, self.step, ramp.rate))
    }

    /// The limits of inputs that change at limited rates, where these hold them.
    fn held_by_ramps(&self) -> Vec<Held> {
        let end = self.step * self.last() as f64;
        let mut held = Vec::new();
        for (index, input) in self.maneuver.inputs.iter().enumerate() {
            let (Some(ramp), Some(courses)) = (input.ramp, self.courses(index)) else { continue };
            for (at, (from, course)) in courses.iter().enumerate() {
                let to = courses.get(at + 1).map_or(end, |(to, _)| *to);
                let Course::Hold(side) = *course else { continue };
                let own = |limit: &Limit| limit.ramp() == Some((ramp.number, side));
                let limit = self.maneuver.limits.iter().position(own);
                held.extend(limit.map(|limit| Held { limit, from: *from, to }));
            }
        }
        held
    }

    /// By how much an input is within its limits on average.
    fn within(&self, input: usize, from: f64, to: f64) -> f64 {
        let [first, last] = [(from / self.step).ceil(), (to / self.step).floor()].map(|node| node as usize);
        let inner = if last > first + 2 { first + 1..=last - 1 } else { first.min(last)..=last };
        let count = inner.clone().count().max(1);
        let levels = self.choices(input);
        let off = |node: usize| {
            let level = self.levels[node.min(self.last())][input];
            levels.iter().map(|at| (level - at).abs()).fold(f64::INFINITY, f64::min)
        };
        inner.map(off).sum::<f64>() / count as f64
    }

    /// The levels that an input may have for long.
    fn choices(&self, input: usize) -> Vec<f64> {
        let Input { lowest, price, .. } = self.maneuver.inputs[input];
        match (lowest == 0.0, price != 0.0) {
            (true, _) => vec![0.0, 1.0],
            (false, true) => vec![-1.0, 0.0, 1.0],
            (false, false) => vec![-1.0, 1.0],
        }
    }

    /// Times at which the same limits are held, with the inputs that hold them.
    fn stretches(&self, held: &[Held]) -> Vec<Stretch> {
        let mut times: Vec<f64> = held.iter().flat_map(|held| [held.from, held.to]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let mut stretches: Vec<Stretch> = Vec::new();
        for pair in times.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let middle = 0.5 * (from + to);
            let holds: Vec<usize> = held
                .iter()
                .filter(|held| held.from < middle && middle < held.to)
                .map(|held| held.limit)
                .collect();
            if holds.is_empty() {
                continue;
            }
            // Inputs take turns in holding a limit: a few nodes tell which it is.
            let pieces = ((to - from) / (PIECE * self.step)).floor().max(1.0) as usize;
            for piece in 0..pieces {
                let at = |piece: usize| from + (to - from) * piece as f64 / pieces as f64;
                let [from, to] = [at(piece), if piece + 1 == pieces { to } else { at(piece + 1) }];
                let free = self.holding(&holds, from, to);
                match stretches.last_mut() {
                    Some(last) if last.to == from && last.holds == holds && last.free == free => last.to = to,
                    _ => stretches.push(Stretch { from, to, free, holds: holds.clone() }),
                }
            }
        }
        stretches
    }

    /// The inputs that hold limits from one time to another: those with most room that have something to say.
    fn holding(&self, holds: &[usize], from: f64, to: f64) -> Vec<usize> {
        let inputs = self.maneuver.inputs.len();
        let mut by_room: Vec<(f64, usize)> =
            (0..inputs).map(|input| (self.within(input, from, to), input)).collect();
        by_room.sort_by(|a, b| b.0.total_cmp(&a.0));
        let middle = 0.5 * (from + to);
        let state = &self.states[((middle / self.step).round() as usize).min(self.last())];
        let mut free = Vec::new();
        for limit in holds {
            let (normal, _) = self.maneuver.limits[*limit].held(state);
            let effect = |input: usize| self.maneuver.effect(&self.maneuver.inputs[input], state);
            let gain = |input: usize| normal.dot(&effect(input)).abs();
            let most = (0..inputs).map(gain).fold(0.0, f64::max);
            let says = |(_, input): &&(f64, usize)| gain(*input) > SAYS * most && !free.contains(input);
            free.extend(by_room.iter().find(says).map(|(_, input)| *input));
        }
        free.sort_unstable();
        free
    }

    /// Arcs with the levels that the cells have.
    fn arcs(&self, stretches: &[Stretch], touched: &[(usize, f64)]) -> Arcs {
        let end = self.step * self.last() as f64;
        let segments: Vec<Vec<(f64, f64)>> =
            (0..self.maneuver.inputs.len()).map(|input| self.segments(input, stretches)).collect();
        let mut times: Vec<f64> = segments.iter().flatten().map(|(from, _)| *from).collect();
        times.extend(stretches.iter().flat_map(|stretch| [stretch.from, stretch.to]));
        times.extend(touched.iter().map(|(_, time)| *time));
        times.extend([0.0, end]);
        times.retain(|time| (0.0..=end).contains(time));
        times.sort_by(f64::total_cmp);
        times.dedup();
        let first = self.maneuver.inputs.iter().zip(&self.levels[0]);
        let first = first.filter(|(input, _)| input.ramp.is_some()).map(|(_, level)| *level).collect();
        let mut arcs = Arcs { laws: Vec::new(), lengths: Vec::new(), contacts: Vec::new(), first };
        for pair in times.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let stretch = stretches.iter().find(|stretch| stretch.from < middle && middle < stretch.to);
            let level = |(input, segments): (usize, &Vec<(f64, f64)>)| {
                if stretch.is_some_and(|stretch| stretch.free.contains(&input)) {
                    return Level::Free;
                }
                let found = segments.iter().rev().find(|(from, _)| *from <= middle);
                let level = found.or(segments.first()).map_or(0.0, |(_, level)| *level);
                if self.choices(input).contains(&level) { Level::At(level) } else { Level::Loose(level) }
            };
            arcs.laws.push(Law {
                levels: segments.iter().enumerate().map(level).collect(),
                holds: stretch.map_or(Vec::new(), |stretch| stretch.holds.clone()),
            });
            arcs.lengths.push(pair[1] - pair[0]);
            let touching = touched.iter().filter(|(_, time)| *time == pair[1]).map(|(limit, _)| *limit);
            arcs.contacts.push(touching.collect());
        }
        arcs.contacts.pop();
        arcs.joined()
    }

    /// The levels of an input, each from a time on.
    fn segments(&self, input: usize, stretches: &[Stretch]) -> Vec<(f64, f64)> {
        if let Some(courses) = self.courses(input) {
            let rate = |course: &Course| if let Course::Ramp(sense) = course { *sense } else { 0.0 };
            return courses.iter().map(|(from, course)| (*from, rate(course))).collect();
        }
        let choices = self.choices(input);
        let decided = |node: usize| {
            let level = self.levels[node][input];
            choices.iter().copied().find(|at| (level - at).abs() < AT_LIMIT)
        };
        let free = |node: usize| {
            let time = node as f64 * self.step;
            let slack = 0.5 * self.step;
            let inside = |stretch: &Stretch| {
                stretch.free.contains(&input) && (stretch.from - slack..=stretch.to + slack).contains(&time)
            };
            stretches.iter().any(inside)
        };
        let mut segments: Vec<(f64, f64)> = Vec::new();
        let mut node = 0;
        while node <= self.last() {
            let begin = self.begin(node);
            if let Some(level) = decided(node).filter(|_| !free(node)) {
                segments.push((begin, level));
                node += 1;
                continue;
            }
            if free(node) {
                // What follows begins with its own level; what comes before goes on.
                node += 1;
                continue;
            }
            let first = node;
            while node <= self.last() && !free(node) && decided(node).is_none() {
                node += 1;
            }
            let before = first.checked_sub(1).filter(|before| !free(*before)).and_then(decided);
            let after = Some(node).filter(|after| *after <= self.last() && !free(*after)).and_then(decided);
            self.divide(input, first..node, before, after, &mut segments);
        }
        // What comes after an arc along a limit has its own level where that ends.
        segments.dedup_by(|next, before| next.1 == before.1);
        segments
    }

    fn begin(&self, node: usize) -> f64 {
        if node == 0 { 0.0 } else { (node as f64 - 0.5) * self.step }
    }

    /// Levels for nodes at which an input is between.
    fn divide(
        &self,
        input: usize,
        nodes: std::ops::Range<usize>,
        before: Option<f64>,
        after: Option<f64>,
        segments: &mut Vec<(f64, f64)>,
    ) {
        let weight = |node: usize| if node == 0 || node == self.last() { 0.5 } else { 1.0 };
        let length = nodes.clone().map(weight).sum::<f64>() * self.step;
        let mean = nodes.clone().map(|node| weight(node) * self.levels[node][input]).sum::<f64>() * self.step
            / length;
        let begin = self.begin(nodes.start);
        if self.between == Between::Means && nodes.len() > RUN {
            self.take_means(input, nodes, segments);
            return;
        }
        let choices = self.choices(input);
        // The level on the other side of the mean.
        let beyond = |level: f64| {
            let above = choices.iter().copied().find(|at| *at > level.max(mean - AT_LIMIT) && *at > level);
            let below = choices.iter().rev().copied().find(|at| *at < level);
            if mean > level { above } else { below }.unwrap_or(level)
        };
        let nearest = || choices.iter().copied().min_by(|a, b| (a - mean).abs().total_cmp(&(b - mean).abs()));
        let (p, q) = match (before, after) {
            (Some(p), Some(q)) => (p, q),
            (Some(p), None) if nodes.end > self.last() => (p, beyond(p)),
            (None, Some(q)) if nodes.start == 0 => (beyond(q), q),
            (Some(one), None) | (None, Some(one)) => (one, one),
            (None, None) => {
                let level = nearest().unwrap_or(0.0);
                (level, level)
            }
        };
        if p != q {
            let three = choices.len() == 3 && (p - q).abs() > 1.5;
            if three {
                let own = |level: f64| (level * mean).max(0.0) * length;
                segments.extend([(begin, p), (begin + own(p), 0.0), (begin + length - own(q), q)]);
            } else {
                let part = ((mean - q) / (p - q)).clamp(0.0, 1.0);
                segments.extend([(begin, p), (begin + part * length, q)]);
            }
            return;
        }
        let other = beyond(p);
        let pieces = nodes.len().div_ceil(BETWEEN.max(self.last() / MOST_PULSES));
        let piece = length / pieces as f64;
        let pulse = if other == p { 0.0 } else { ((mean - p) / (other - p)).clamp(0.0, 1.0) * piece };
        segments.push((begin, p));
        if pulse > NO_PULSE * self.step {
            for index in 0..pieces {
                let middle = begin + (index as f64 + 0.5) * piece;
                segments.extend([(middle - 0.5 * pulse, other), (middle + 0.5 * pulse, p)]);
            }
        }
    }

    /// Means of an input on parts of the duration.
    fn take_means(&self, input: usize, nodes: std::ops::Range<usize>, segments: &mut Vec<(f64, f64)>) {
        let part = |node: &usize| (*node as f64 * PARTS / self.last() as f64).floor().min(PARTS - 1.0);
        let mut first = nodes.start;
        for run in nodes.collect::<Vec<_>>().chunk_by(|a, b| part(a) == part(b)) {
            let mean = run.iter().map(|node| self.levels[*node][input]).sum::<f64>() / run.len() as f64;
            segments.push((self.begin(first), mean));
            first += run.len();
        }
    }
}
