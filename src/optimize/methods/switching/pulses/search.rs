//! Search for the best schedule of pulses: initial schedules, in which pulses are then removed,
//! merged or added to reduce the fuel.
//!
//! For given pulses the optimal times are a local minimum, but very many sets of pulses are
//! possible. Initial schedules come from three sources. First, the extremals without a minimum
//! pulse width, whose short pulses are dropped, lengthened or merged. Second, two impulses that
//! turn the body slowly to the end. Third, some of these schedules with random changes of the times
//! and additional pairs of pulses; more of them are tried if no schedule meets the terminal
//! conditions. The best schedules are then changed by one pulse at a time, as long as that reduces
//! the fuel.

use super::super::arcs::Arcs;
use super::super::certificate::Certified;
use super::super::extremal::Extremal;
use super::super::impulses;
use super::super::limit::BranchEnd;
use super::super::tuning::NOTHING;
use super::super::tuning::pulses::*;
use super::super::work::Work;
use super::motion::Motion;
use super::optimum::best_times;
use super::schedule::{Best, Pulse, PulseRequest, Schedule};
use crate::numerics::random::Stream;

/// Result of the search: schedules with optimal times, the best first, and the number of schedules
/// tried.
#[derive(Clone, Debug, Default)]
pub(crate) struct PulsesFound {
    pub best: Vec<Best>,
    pub tried: usize,
}

impl PulsesFound {
    fn try_out(&mut self, extremal: &Extremal, schedule: &Schedule, ask: &PulseRequest) -> Option<Best> {
        if schedule.pulses.is_empty() || schedule.pulses.len() > MOST_PULSES {
            return None;
        }
        self.tried += 1;
        let best = best_times(extremal, schedule, ask)?;
        let touching = DISTINCT * schedule.duration;
        let joined = best.schedule.clone().joined(touching);
        if joined.pulses.len() < best.schedule.pulses.len() {
            // Two pulses that touch are one pulse, which may be shorter than two minimum pulse
            // widths.
            return best_times(extremal, &joined, ask).or(Some(best));
        }
        Some(best)
    }

    fn keep(&mut self, best: Best) {
        let same = |known: &Best| {
            (known.cost / best.cost - 1.0).abs() < DISTINCT
                && known.schedule.pulses.len() == best.schedule.pulses.len()
        };
        if !self.best.iter().any(same) {
            self.best.push(best);
            self.best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        }
    }
}

/// Searches for minimum-fuel pulses near the extremals of the maneuver without a minimum pulse
/// width.
pub(crate) fn search(
    extremal: &Extremal,
    limits: &[BranchEnd],
    ask: &PulseRequest,
    work: &Work,
) -> PulsesFound {
    let mut found = PulsesFound::default();
    let starts = starts(extremal, limits, ask, work);
    let times = if ask.thorough { THOROUGH } else { 1 };
    for schedule in starts.iter().take(times * MOST_STARTS).take_while(|_| !work.stopped()) {
        if let Some(best) = found.try_out(extremal, schedule, ask) {
            found.keep(best);
        }
    }
    at_random(extremal, &starts, ask, work, &mut found);
    changed(extremal, ask, work, &mut found);
    found
}

/// Returns the initial schedules; of similar schedules only the first is kept.
fn starts(extremal: &Extremal, limits: &[BranchEnd], ask: &PulseRequest, work: &Work) -> Vec<Schedule> {
    let Some(best) = limits.first() else { return Vec::new() };
    let mut sources: Vec<(Vec<Pulse>, f64)> = Vec::new();
    let of = |arcs: &Arcs| (Schedule::of_arcs(arcs), arcs.duration);
    for limit in limits.iter().take(MOST_EXTREMALS) {
        sources.extend(limit.arcs.iter().map(|found| of(&found.arcs)));
    }
    for limit in limits.iter().take(MOST_EXTREMALS).filter(|limit| limit.arcs.is_none()) {
        sources.extend(limit.looser.last().map(|found| of(&found.arcs)));
        sources.push(of(&Arcs::of_pulses(extremal, &limit.smooth.path, limit.smooth.epsilon, 1)));
    }
    let mut starts: Vec<Schedule> = Vec::new();
    let mut add = |pulses: Vec<Pulse>, duration: f64| {
        if let Some(schedule) = Schedule::kept(pulses, duration, ask)
            && !starts.iter().any(|known| alike(known, &schedule))
        {
            starts.push(schedule);
        }
    };
    let mut burns = impulses::slow_turns(extremal, best.duration(), work);
    for joined in &JOINED {
        for dropped in &DROPPED {
            for (source, duration) in &sources {
                add(quantised(source, joined * ask.shortest, dropped * ask.shortest), *duration);
            }
        }
        burns.by_ref().for_each(|turn| add(turn.pulses(best.duration()), best.duration()));
    }
    starts
}

/// Returns whether two schedules have the same pulses at nearly the same times.
fn alike(a: &Schedule, b: &Schedule) -> bool {
    let near = |(a, b): (&Pulse, &Pulse)| {
        a.level == b.level
            && (a.middle() - b.middle()).abs() + (a.length() - b.length()).abs() < ALIKE * (1.0 + a.length())
    };
    let last = (a.duration - b.duration).abs() < ALIKE * a.duration;
    last && a.pulses.len() == b.pulses.len() && a.pulses.iter().zip(&b.pulses).all(near)
}

/// Merges pulses separated by a pause shorter than `joined` into one pulse of equal area and
/// centroid. Then drops the pulses shorter than `dropped`.
fn quantised(pulses: &[Pulse], joined: f64, dropped: f64) -> Vec<Pulse> {
    let mut kept: Vec<Pulse> = Vec::with_capacity(pulses.len());
    // End of the previous pulse before it was merged.
    let mut last_off = f64::NEG_INFINITY;
    for pulse in pulses {
        match kept.last_mut() {
            Some(last) if last.level == pulse.level && pulse.on - last_off < joined => {
                *last = last.merged(pulse);
            }
            _ => kept.push(*pulse),
        }
        last_off = pulse.off;
    }
    kept.retain(|pulse| pulse.length() >= dropped);
    kept
}

/// Tries schedules with random changes of the times and additional pulses: a few, and more until
/// one meets the terminal conditions.
fn at_random(
    extremal: &Extremal,
    starts: &[Schedule],
    ask: &PulseRequest,
    work: &Work,
    found: &mut PulsesFound,
) {
    let mut random = Stream::new(0, 0, 0);
    let few = if ask.thorough { MOST_RANDOM } else { RANDOM };
    for index in 0..MOST_RANDOM {
        if work.stopped() || (index >= few && !found.best.is_empty()) || starts.is_empty() {
            return;
        }
        let Schedule { mut pulses, duration, .. } = starts[index % starts.len()].clone();
        for pulse in &mut pulses {
            let (later, longer) = (random.unit() - 0.5, random.unit());
            let moved = 2.0 * TRUST * duration * later;
            *pulse = Pulse { on: pulse.on + moved, off: pulse.off + moved, ..*pulse };
            *pulse = pulse.with_length(pulse.length() * (0.5 + longer));
        }
        let levels = extremal.switching_count();
        for _ in 0..2 * (1 + index / starts.len()) {
            let level = ((random.unit() * levels as f64) as usize).min(levels - 1);
            let at = random.unit() * duration;
            pulses.push(Pulse { level, on: at, off: at }.with_length(ask.shortest));
        }
        if let Some(schedule) = Schedule::kept(pulses, duration, ask)
            && let Some(best) = found.try_out(extremal, &schedule, ask)
        {
            found.keep(best);
        }
    }
}

/// Changes the best schedules by one pulse at a time, as long as that reduces the fuel.
fn changed(extremal: &Extremal, ask: &PulseRequest, work: &Work, found: &mut PulsesFound) {
    let times = if ask.thorough { THOROUGH } else { 1 };
    let first: Vec<Best> = found.best.iter().take(times * CHANGED).cloned().collect();
    let mut changes = 0;
    for start in first {
        let mut best = start;
        while let Some(better) = neighbours(extremal, &best, ask).iter().find_map(|next| {
            changes += 1;
            let tried = changes <= times * MOST_CHANGES && !work.stopped();
            let next = tried.then(|| found.try_out(extremal, next, ask)).flatten()?;
            (next.cost < best.cost * (1.0 - NOTHING)).then_some(next)
        }) {
            found.keep(better.clone());
            best = better;
        }
    }
}

/// Returns the schedules that differ from the best one by one pulse: one pulse removed, two pulses
/// merged, or one pulse added where a switching function has the wrong sign.
fn neighbours(extremal: &Extremal, best: &Best, ask: &PulseRequest) -> Vec<Schedule> {
    let Schedule { pulses, duration, .. } = &best.schedule;
    let mut all = Vec::new();
    let shortest = |pulse: &Pulse| pulse.length() < ask.shortest + DISTINCT * duration;
    // Indices of the pulses at the minimum pulse width that the optimum would shorten, the shortest
    // first.
    let mut order: Vec<usize> = (0..pulses.len()).collect();
    order.sort_by(|a, b| pulses[*a].length().total_cmp(&pulses[*b].length()));
    for index in order.iter().filter(|index| shortest(&pulses[**index])) {
        let mut fewer = pulses.clone();
        fewer.remove(*index);
        all.push(fewer);
    }
    for index in 1..pulses.len() {
        let (before, after) = (pulses[index - 1], pulses[index]);
        if before.level == after.level {
            let mut fewer = pulses.clone();
            fewer[index - 1] = before.merged(&after);
            fewer.remove(index);
            all.push(fewer);
        }
    }
    let motion = Motion::of(extremal, &best.schedule, &best.costates, COARSE);
    let mut wrong = motion.map_or_else(Vec::new, |motion| Certified::of(extremal, motion.arcs).wrong);
    wrong.sort_by(|a, b| b.gap.total_cmp(&a.gap));
    for wrong in &wrong {
        let at = wrong.peak.0;
        let on = |pulse: &Pulse| pulse.level == wrong.input && pulse.on <= at && at <= pulse.off;
        if !pulses.iter().any(on) {
            let mut more = pulses.clone();
            more.push(Pulse { level: wrong.input, on: at, off: at }.with_length(ask.shortest));
            all.push(more);
        }
    }
    all.into_iter().filter_map(|pulses| Schedule::kept(pulses, *duration, ask)).collect()
}
