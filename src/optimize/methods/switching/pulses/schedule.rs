//! Pulses of inputs that are off or at a limit, and the bounds of their times.
//!
//! The times of every input increase, `0 ≤ on_1 < off_1 ≤ on_2 < … ≤ T`, and a pulse lasts at least
//! the minimum pulse width. These are bounds on differences of times, independent of the other
//! inputs. A two-sided input is represented by two inputs (levels) of the extremal, whose pulses do
//! not overlap. If the duration is free, it is one more time, after all others.

use super::super::arcs::Arcs;
use super::super::extremal::Extremal;
use crate::optimize::nlp::bounds::Bound;
use nalgebra::{DVector, Vector6};

/// Requirements on the pulses that a search may use.
#[derive(Clone, Debug)]
pub(crate) struct PulseRequest {
    /// Minimum pulse width, scaled.
    pub shortest: f64,
    /// Index of the maneuver's input for each level of the extremal.
    pub input_of: Vec<usize>,
    /// True for a thorough search, which tries many more schedules.
    pub thorough: bool,
    /// True if the duration is free.
    pub sought: bool,
}

impl PulseRequest {
    /// Creates requirements without a minimum pulse width, in which every level of the extremal
    /// counts as a separate input.
    pub fn free(extremal: &Extremal) -> Self {
        let input_of = (0..extremal.switching_count()).collect();
        Self { shortest: 0.0, input_of, thorough: false, sought: extremal.given_duration.is_none() }
    }
}

/// A pulse: the interval of time on which one input (level) of the extremal is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pulse {
    pub level: usize,
    pub on: f64,
    pub off: f64,
}

impl Pulse {
    pub fn length(&self) -> f64 {
        self.off - self.on
    }

    pub fn middle(&self) -> f64 {
        0.5 * (self.on + self.off)
    }

    /// Returns one pulse with the total area and the centroid of two pulses.
    pub fn merged(&self, other: &Self) -> Self {
        let length = self.length() + other.length();
        let middle = (self.length() * self.middle() + other.length() * other.middle()) / length;
        Self { on: middle, off: middle, ..*self }.with_length(length)
    }

    /// Returns a pulse of another length about the same centre.
    pub fn with_length(self, length: f64) -> Self {
        Self { on: self.middle() - 0.5 * length, off: self.middle() + 0.5 * length, ..self }
    }
}

/// Pulses in the order of the inputs, then of time.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    pub pulses: Vec<Pulse>,
    pub duration: f64,
    /// True if the duration is free.
    pub sought: bool,
}

/// A schedule at its optimal times, with costates and cost.
#[derive(Clone, Debug)]
pub(crate) struct Best {
    pub schedule: Schedule,
    /// Costates `M` and `e` at the start.
    pub costates: Vector6<f64>,
    pub cost: f64,
}

impl Schedule {
    /// Creates a schedule that meets the requirements: pulses are sorted, merged where they
    /// overlap, lengthened to the minimum pulse width and moved apart. Returns `None` if the pulses
    /// of an input need more than the duration.
    pub fn kept(mut pulses: Vec<Pulse>, duration: f64, ask: &PulseRequest) -> Option<Self> {
        pulses.sort_by(|a, b| {
            let key = |pulse: &Pulse| ask.input_of[pulse.level];
            key(a).cmp(&key(b)).then(a.middle().total_cmp(&b.middle()))
        });
        let mut joined: Vec<Pulse> = Vec::with_capacity(pulses.len());
        for pulse in pulses {
            let pulse = pulse.with_length(pulse.length().max(ask.shortest));
            match joined.last_mut() {
                Some(last) if last.level == pulse.level && pulse.on < last.off => {
                    let length = last.length() + pulse.length();
                    let middle = 0.5 * (last.on + pulse.off);
                    (last.on, last.off) = (middle - 0.5 * length, middle + 0.5 * length);
                }
                _ => joined.push(pulse),
            }
        }
        for group in joined.chunk_by_mut(|a, b| ask.input_of[a.level] == ask.input_of[b.level]) {
            let total: f64 = group.iter().map(Pulse::length).sum();
            // If they do not all fit, they are shortened by equal parts, down to the minimum pulse
            // width.
            let least = group.len() as f64 * ask.shortest;
            if least > duration {
                return None;
            }
            if total > duration {
                let part = (duration - least) / (total - least);
                for pulse in &mut *group {
                    *pulse = pulse.with_length(ask.shortest + part * (pulse.length() - ask.shortest));
                }
            }
            let mut from = 0.0_f64;
            for pulse in &mut *group {
                let later = (from - pulse.on).max(0.0);
                (pulse.on, pulse.off) = (pulse.on + later, pulse.off + later);
                from = pulse.off;
            }
            let mut to = duration;
            for pulse in group.iter_mut().rev() {
                let sooner = (pulse.off - to).max(0.0);
                (pulse.on, pulse.off) = (pulse.on - sooner, pulse.off - sooner);
                to = pulse.on;
            }
            if let Some(first) = group.first_mut() {
                first.on = first.on.max(0.0);
            }
        }
        Some(Self { pulses: joined, duration, sought: ask.sought })
    }

    /// Returns the cost of the fuel, plus the cost of the duration if the duration is free.
    pub fn cost(&self, extremal: &Extremal) -> f64 {
        let fuel: f64 =
            self.pulses.iter().map(|pulse| 2.0 * extremal.costs[pulse.level] * pulse.length()).sum();
        if self.sought { fuel + extremal.price_of_time() * self.duration } else { fuel }
    }

    /// Returns the times in the order of the pulses, the start of each pulse before its end. If the
    /// duration is free, it comes last.
    pub fn times(&self) -> DVector<f64> {
        let times = self.pulses.iter().flat_map(|pulse| [pulse.on, pulse.off]);
        DVector::from_vec(times.chain(self.sought.then_some(self.duration)).collect())
    }

    /// Returns the index of the time that is the duration; `None` if the duration is given.
    pub fn end(&self) -> Option<usize> {
        self.sought.then_some(2 * self.pulses.len())
    }

    /// Returns the schedule with the given times.
    pub fn at(&self, times: &DVector<f64>) -> Self {
        let mut next = self.clone();
        for (index, pulse) in next.pulses.iter_mut().enumerate() {
            (pulse.on, pulse.off) = (times[2 * index], times[2 * index + 1]);
        }
        if let Some(end) = self.end() {
            next.duration = times[end];
        }
        next
    }

    /// Returns the bounds of the times: between neighbouring times of an input, and for its first
    /// and last time.
    pub(super) fn bounds(&self, ask: &PulseRequest) -> Vec<Bound> {
        let mut bounds = Vec::with_capacity(4 * self.pulses.len());
        for index in 0..self.pulses.len() {
            let (on, off) = (2 * index, 2 * index + 1);
            let same = |other: &Pulse| ask.input_of[other.level] == ask.input_of[self.pulses[index].level];
            let follows = index > 0 && same(&self.pulses[index - 1]);
            let a = follows.then(|| on - 1);
            bounds.push(Bound { a, b: Some(on), least: 0.0 });
            bounds.push(Bound { a: Some(on), b: Some(off), least: ask.shortest });
            if !self.pulses.get(index + 1).is_some_and(same) {
                let least = if self.sought { 0.0 } else { -self.duration };
                bounds.push(Bound { a: Some(off), b: self.end(), least });
            }
        }
        bounds
    }

    /// Merges successive pulses of one level if the pause between them is at most `touching`.
    pub fn joined(mut self, touching: f64) -> Self {
        let mut index = 1;
        while index < self.pulses.len() {
            let (before, after) = (self.pulses[index - 1], self.pulses[index]);
            if before.level == after.level && after.on - before.off <= touching {
                self.pulses[index - 1].off = after.off;
                self.pulses.remove(index);
            } else {
                index += 1;
            }
        }
        self
    }

    /// Returns the pulses of bang-bang arcs.
    pub fn of_arcs(arcs: &Arcs) -> Vec<Pulse> {
        let mut pulses = Vec::new();
        for (level, first) in arcs.signs.iter().enumerate() {
            let mut on = (*first > 0.0).then_some(0.0);
            for switch in arcs.switches.iter().filter(|switch| switch.input == level) {
                on = match on {
                    Some(on) => {
                        pulses.push(Pulse { level, on, off: switch.time });
                        None
                    }
                    None => Some(switch.time),
                };
            }
            if let Some(on) = on {
                pulses.push(Pulse { level, on, off: arcs.duration });
            }
        }
        pulses
    }
}
