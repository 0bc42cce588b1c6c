//! From one order of arcs to the next, until the maximum principle holds.
//!
//! Every round solves for stationary arcs, looks where these fail, and puts the worst right: limits that are exceeded first, as what
//! exceeds them is no plan, and then signs. An order in which nothing is wrong is an answer. Along a singular arc inputs chatter, and no
//! finite list of arcs is exact: then it is the order with the least gap of those that fail by signs alone.

use super::certificate::{Certificate, Wrong};
use super::linear_programs::descended;
use super::motion::{Law, Level, Maneuver};
use super::newton::{Arcs, Stationary};
use super::state::State;

/// Most iterations of Newton from one first order: some ten for each of as many exchanges as pay.
const MOST_ITERATIONS: usize = 120;

/// Arcs shorter than this part of a step are left out at first: none of them, those that one cell makes, those that two do.
const WITHOUT: [f64; 3] = [0.0, 0.6, 1.6];

/// Of what is wrong so much is tried to be put right in a round.
const MOST_TRIED: usize = 3;

/// Part of a stretch with the wrong level that gets the other one at first: Newton finds how long it should be.
const FIRST_PART: f64 = 0.5;

/// Gap of arcs, as a part of their cost, up to which they are exact: plans are built on them, and those that linear programs lead to are
/// told. Their vertex is one of many orders of pulses, and far from others where inputs chatter.
pub(crate) const EXACT: f64 = 1e-6;

/// Arcs that satisfy the maximum principle.
pub(crate) struct Optimum {
    pub stationary: Stationary,
    /// What plans near by may gain, to first order, in the unit of cost.
    pub gap: f64,
    /// Inputs whose sign is not the right one somewhere.
    pub chattering: Vec<usize>,
}

impl Optimum {
    fn cost(&self) -> f64 {
        self.stationary.followed.cost
    }
}

/// The arcs that satisfy the maximum principle and come of one of the first orders of them, of the same without what is shorter than
/// some part of `step`, or of what linear programs make of it; where none do, those that come nearest to it; `None` where there are none
/// of these either.
pub(crate) fn improved(
    maneuver: &Maneuver,
    firsts: &[Arcs],
    step: f64,
    stop: &dyn Fn() -> bool,
) -> Option<Optimum> {
    let mut nearest: Option<Optimum> = None;
    let mut tried: Vec<Arcs> = Vec::new();
    for (first, part) in firsts.iter().flat_map(|first| WITHOUT.map(|part| (first, part))) {
        let first = first.without_shorter(part * step);
        if tried.contains(&first) {
            continue;
        }
        tried.push(first.clone());
        match from(maneuver, first, stop) {
            Some(found) if found.chattering.is_empty() => return Some(found),
            found => nearest = nearer(nearest, found),
        }
    }
    for first in firsts.iter().filter_map(|first| descended(first, maneuver, stop)).flatten() {
        if tried.contains(&first) {
            continue;
        }
        tried.push(first.clone());
        let found = from(maneuver, first, stop).filter(|found| found.gap <= EXACT * found.cost());
        match found {
            Some(found) if found.chattering.is_empty() => return Some(found),
            found => nearest = nearer(nearest, found),
        }
    }
    nearest
}

/// The one with less of a gap.
fn nearer(one: Option<Optimum>, other: Option<Optimum>) -> Option<Optimum> {
    one.into_iter().chain(other).min_by(|a, b| a.gap.total_cmp(&b.gap))
}

fn from(maneuver: &Maneuver, first: Arcs, stop: &dyn Fn() -> bool) -> Option<Optimum> {
    let mut left = MOST_ITERATIONS;
    let mut found = first.solve(maneuver, &mut left)?;
    let mut nearest: Option<Optimum> = None;
    // Every round takes some of the iterations that are left.
    while !stop() {
        let Certificate { wrong, gap } = Certificate::of(maneuver, &found)?;
        let chattering = chattering(&wrong);
        let arcs = found.arcs.clone();
        // Stationary is a saddle too.
        if found.curvature > 0.0
            && let Some(chattering) = chattering
        {
            let optimum = Optimum { stationary: found, gap, chattering };
            if wrong.is_empty() {
                return Some(optimum);
            }
            nearest = nearer(nearest, Some(optimum));
        } else if wrong.is_empty() {
            break;
        }
        // The worst that can be put right.
        let next = wrong
            .iter()
            .take(MOST_TRIED)
            .find_map(|worst| arcs.exchanged(maneuver, worst, &wrong)?.solve(maneuver, &mut left));
        match next {
            // What leads back to where it came from does so again.
            Some(next) if next.arcs.laws != arcs.laws || next.arcs.contacts != arcs.contacts => found = next,
            _ => break,
        }
    }
    nearest
}

/// The inputs that are wrong, where only signs of inputs are.
fn chattering(wrong: &[Wrong]) -> Option<Vec<usize>> {
    let inputs = wrong.iter().map(|wrong| match wrong {
        Wrong::Level { input, .. } | Wrong::Loose { input } => Some(*input),
        _ => None,
    });
    let mut inputs = inputs.collect::<Option<Vec<_>>>()?;
    inputs.sort_unstable();
    inputs.dedup();
    Some(inputs)
}

/// What is done to an order of arcs.
trait Exchange: Sized {
    fn exchanged(&self, maneuver: &Maneuver, worst: &Wrong, all: &[Wrong]) -> Option<Self>;
    fn without_shorter(&self, least: f64) -> Self;
    fn with(&self, arc: usize, from: f64, to: f64, law: Law) -> Self;
    fn holding(&self, maneuver: &Maneuver, arc: usize, limit: usize, from: f64, to: f64) -> Option<Self>;
    fn held_by_another(
        &self,
        maneuver: &Maneuver,
        arc: usize,
        held: (usize, f64),
        from: f64,
        to: f64,
    ) -> Option<Self>;
    fn leaving(&self, maneuver: &Maneuver, arc: usize, of: (usize, f64), from: f64, to: f64) -> Option<Self>;
    fn state(&self, maneuver: &Maneuver, arc: usize, after: f64) -> Option<State>;
    fn touching(&self, maneuver: &Maneuver, arc: usize, limit: usize) -> Option<Self>;
}

impl Exchange for Arcs {
    /// With something put right; `None` where nobody knows how.
    fn exchanged(&self, maneuver: &Maneuver, worst: &Wrong, all: &[Wrong]) -> Option<Self> {
        match *worst {
            Wrong::Level { arc, input, wanted, from, to } => {
                let mut law = self.laws[arc].clone();
                law.levels[input] = Level::At(wanted);
                let (middle, half) = (0.5 * (from + to), 0.5 * FIRST_PART * (to - from));
                // At an end of the arc it begins, or ends, with it.
                let at_start = from <= 0.0;
                let at_end = to >= self.lengths[arc];
                let (from, to) = match (at_start, at_end) {
                    (true, true) => (from, to),
                    (true, false) => (from, from + 2.0 * half),
                    (false, true) => (to - 2.0 * half, to),
                    (false, false) => (middle - half, middle + half),
                };
                Some(self.with(arc, from, to, law).joined())
            }
            Wrong::Exceeded { arc, limit, at, from, to } if maneuver.limits[limit].order() == 2 => {
                let touches = |junction: Option<usize>| {
                    junction
                        .and_then(|junction| self.contacts.get(junction))
                        .is_some_and(|own| own.contains(&limit))
                };
                if touches(arc.checked_sub(1)) || touches(Some(arc)) {
                    self.holding(maneuver, arc, limit, from, to)
                } else {
                    let mut split = self.clone();
                    split.laws.insert(arc, self.laws[arc].clone());
                    split.lengths[arc] = at;
                    split.lengths.insert(arc + 1, self.lengths[arc] - at);
                    split.contacts.insert(arc, vec![limit]);
                    Some(split)
                }
            }
            Wrong::Exceeded { limit, .. } => {
                // All arcs on which it is exceeded, the last first, so that numbers stay what they are.
                let mut stretches: Vec<(usize, f64, f64)> = all
                    .iter()
                    .filter_map(|wrong| match *wrong {
                        Wrong::Exceeded { arc, limit: other, from, to, .. } if other == limit => {
                            Some((arc, from, to))
                        }
                        _ => None,
                    })
                    .collect();
                stretches.sort_by_key(|stretch| std::cmp::Reverse(stretch.0));
                stretches.iter().try_fold(self.clone(), |arcs, (arc, from, to)| {
                    arcs.holding(maneuver, *arc, limit, *from, *to)
                })
            }
            // Newton has its level already.
            Wrong::Loose { .. } => None,
            Wrong::Repelled { arc, limit } => {
                let mut left = self.clone();
                left.contacts[arc - 1].retain(|own| *own != limit);
                Some(left.joined())
            }
            Wrong::Released { arc, limit, from, to } => match maneuver.limits[limit].ramp() {
                Some((_, side)) => self.leaving(maneuver, arc, (limit, side), from, to),
                None => self.touching(maneuver, arc, limit),
            },
            Wrong::Beyond { arc, input, level, from, to } => {
                self.held_by_another(maneuver, arc, (input, level), from, to)
            }
        }
    }

    /// Without arcs that hold nothing and are shorter than this, the shortest first: half of each goes to either neighbour.
    fn without_shorter(&self, least: f64) -> Self {
        let mut rest = self.clone();
        loop {
            let lengths = rest.lengths.iter().enumerate().filter(|(arc, _)| rest.laws[*arc].holds.is_empty());
            let Some((arc, length)) = lengths.min_by(|a, b| a.1.total_cmp(b.1)) else { return rest };
            if *length >= least || rest.laws.len() < 2 {
                return rest;
            }
            let half = 0.5 * length;
            let before = arc.checked_sub(1).unwrap_or(arc + 1);
            let after = if arc + 1 < rest.lengths.len() { arc + 1 } else { before };
            rest.lengths[before] += half;
            rest.lengths[after] += half;
            rest = rest.without(arc);
        }
    }

    /// With another law on a stretch of an arc.
    fn with(&self, arc: usize, from: f64, to: f64, law: Law) -> Self {
        let mut cut = self.clone();
        let rest = self.lengths[arc] - to;
        cut.lengths[arc] = from;
        cut.laws.splice(arc + 1..arc + 1, [law, self.laws[arc].clone()]);
        cut.lengths.splice(arc + 1..arc + 1, [to - from, rest]);
        cut.contacts.splice(arc..arc, [Vec::new(), Vec::new()]);
        // What has no length was not there.
        if rest <= 0.0 {
            cut.laws.remove(arc + 2);
            cut.lengths.remove(arc + 2);
            cut.contacts.remove(arc + 1);
        }
        if from <= 0.0 {
            cut.laws.remove(arc);
            cut.lengths.remove(arc);
            cut.contacts.remove(arc);
        }
        cut
    }

    /// With a limit held on a stretch of an arc by the input that would exceed it most.
    fn holding(&self, maneuver: &Maneuver, arc: usize, limit: usize, from: f64, to: f64) -> Option<Self> {
        let law = &self.laws[arc];
        let state = self.state(maneuver, arc, 0.5 * (from + to))?;
        let (normal, _) = maneuver.limits[limit].held(&state);
        let pushes = |(input, level): (usize, &Level)| {
            let level = level.part()?;
            let gain = normal.dot(&maneuver.effect(&maneuver.inputs[input], &state));
            Some((if level == 0.0 { gain.abs() } else { gain * level }, input))
        };
        let pushing = law.levels.iter().enumerate().filter_map(pushes).max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, input) = pushing.filter(|(push, _)| *push > 0.0)?;
        let mut held = law.clone();
        held.levels[input] = Level::Free;
        held.holds.push(limit);
        held.holds.sort_unstable();
        Some(self.with(arc, from, to, held))
    }

    /// With what an arc holds held by another input on a stretch of it, and the one that held it at a limit of its own.
    fn held_by_another(
        &self,
        maneuver: &Maneuver,
        arc: usize,
        (input, level): (usize, f64),
        from: f64,
        to: f64,
    ) -> Option<Self> {
        let law = &self.laws[arc];
        let [limit] = law.holds[..] else { return None };
        let state = self.state(maneuver, arc, 0.5 * (from + to))?;
        let (normal, _) = maneuver.limits[limit].held(&state);
        let gain = |other: &usize| normal.dot(&maneuver.effect(&maneuver.inputs[*other], &state)).abs();
        let others = (0..law.levels.len()).filter(|other| law.levels[*other] != Level::Free);
        let other = others.max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
        let mut held = law.clone();
        held.levels[input] = Level::At(level);
        held.levels[other] = Level::Free;
        (to > from).then(|| self.with(arc, from, to, held))
    }

    /// With the input that holds its own limit leaving it and coming back on a stretch of an arc, or only one of both where the maneuver
    /// begins or ends.
    fn leaving(
        &self,
        maneuver: &Maneuver,
        arc: usize,
        (limit, side): (usize, f64),
        from: f64,
        to: f64,
    ) -> Option<Self> {
        let (ramp, _) = maneuver.limits[limit].ramp()?;
        let input =
            maneuver.inputs.iter().position(|input| input.ramp.is_some_and(|own| own.number == ramp))?;
        let changing = |rate: f64| {
            let mut law = self.laws[arc].clone();
            law.levels[input] = Level::At(rate);
            law.holds.retain(|held| *held != limit);
            law
        };
        let begins = arc == 0 && from <= 0.0;
        let ends = arc + 1 == self.laws.len() && to >= self.lengths[arc];
        let middle = match (begins, ends) {
            (true, _) => from,
            (_, true) => to,
            _ => 0.5 * (from + to),
        };
        // The later one first, so that the number of the arc stays what it is.
        let mut left = self.clone();
        if middle < to {
            left = left.with(arc, middle, to, changing(side));
        }
        if middle > from {
            // What comes after it is an arc of its own already, but for the length that is left of this one.
            left = left.with(arc, from, middle, changing(-side));
        }
        Some(left.joined())
    }

    /// The state a time after an arc begins.
    fn state(&self, maneuver: &Maneuver, arc: usize, after: f64) -> Option<State> {
        let mut state = self.start(maneuver);
        for before in 0..arc {
            let driven = maneuver.driven(&self.laws[before])?;
            state = driven.flow(&state, self.lengths[before], driven.steps(&state, self.lengths[before]));
        }
        let driven = maneuver.driven(&self.laws[arc])?;
        Some(driven.flow(&state, after, driven.steps(&state, after)))
    }

    /// With a limit of second order touched in the middle of the arc that holds it, where the input that held it goes from what it is
    /// before to what it is after.
    fn touching(&self, maneuver: &Maneuver, arc: usize, limit: usize) -> Option<Self> {
        let law = &self.laws[arc];
        let (before, after) = (self.laws.get(arc.checked_sub(1)?)?, self.laws.get(arc + 1)?);
        let alone = law.holds == [limit] && maneuver.limits[limit].order() == 2;
        let changed = |neighbour: &Law| {
            let levels = law.levels.iter().zip(&neighbour.levels);
            let levels = levels.map(|(own, other)| if *own == Level::Free { *other } else { *own }).collect();
            Law { levels, holds: Vec::new() }
        };
        let (first, second) = (changed(before), changed(after));
        if !alone || [&first, &second].iter().any(|law| law.levels.contains(&Level::Free)) {
            return None;
        }
        let mut touched = self.clone();
        let half = 0.5 * self.lengths[arc];
        touched.laws.splice(arc..=arc, [first, second]);
        touched.lengths.splice(arc..=arc, [half, half]);
        touched.contacts.insert(arc, vec![limit]);
        Some(touched.joined())
    }
}
