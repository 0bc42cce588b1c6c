//! The order of stops, by plans of all pairs.
//!
//! Every pair is planned by a quick search. A quick plan may be longer than the best one, by
//! [`SHORTER`] as a rule at most, so it counts as that much shorter until it is planned as the settings
//! ask for. The best order then asks for its own legs, and the next best order again, until one has
//! such legs alone: no other order is better, unless a quick plan was longer still.
//!
//! From rest to rest, without stored momentum, the way back takes as long as the way there for any
//! inputs: `R(T−t), −Ω(T−t), u(T−t)` solves the same equations. What one search misses the other
//! finds as a rule, so the shorter one counts for both.

use super::carried;
use super::joint::Joint;
use super::leg::Leg;
use super::order::{Order, Stops, Visit};
use super::{Ordering, Part, Place, Sequence, SequenceError};
use crate::Vector3;
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::optimize::search::Observer;

/// What a quick plan counts for, as a part of it: less of it asks for more plans (`evidence --
/// orders`).
const SHORTER: f64 = 0.98;

/// Returns the best order of the stops of a sequence.
pub fn ordered(
    sequence: &Sequence,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Order, SequenceError> {
    let mut pairs = Pairs::of(sequence)?;
    let discrete = Settings { target: Target::Discrete, ..settings.clone() };
    let quick = Settings { search: Thoroughness::Quick, ..discrete.clone() };
    for from in 0..pairs.count {
        for to in (1..pairs.count).filter(|to| *to != from) {
            if !(pairs.mirrored(from, to) && to < from) {
                let part = format!("pair {} of {}", from * pairs.count + to, pairs.count * pairs.count);
                let observer = &mut Part { observer, part };
                let weight = pairs.planned(from, to, &quick, observer)?;
                pairs.know(from, to, weight, SHORTER);
            }
        }
    }
    let visits: Vec<Visit> = sequence.stops.iter().map(|stop| stop.visit).collect();
    let last =
        Some(sequence.stops.len()).filter(|last| sequence.order == Ordering::FreeBeforeLast && *last > 0);
    loop {
        let weights = &pairs.weights;
        let leg = |from: usize, to: usize, _: f64| weights[pairs.place(from, to)];
        let least = |from: usize, to: usize| weights[pairs.place(from, to)];
        let best = Stops { visits: &visits, leg: &leg, least: &least, last }.best_order();
        let legs: Vec<(usize, usize)> =
            std::iter::once(0).chain(best.stops.iter().copied()).zip(best.stops.iter().copied()).collect();
        let unsure: Vec<_> =
            legs.into_iter().filter(|(from, to)| !pairs.sure[pairs.place(*from, *to)]).collect();
        if unsure.is_empty() {
            return Ok(best);
        }
        for (from, to) in unsure {
            let mut weight = pairs.planned(from, to, &discrete, observer)?;
            if pairs.mirrored(from, to) {
                weight = weight.min(pairs.planned(to, from, &discrete, observer)?);
            }
            let quick = pairs.weights[pairs.place(from, to)] / SHORTER;
            pairs.know(from, to, weight.min(quick), 1.0);
        }
    }
}

/// What all legs add to an order.
struct Pairs<'a> {
    sequence: &'a Sequence,
    /// The start and all stops, and whether each is given wholly.
    states: Vec<(State, bool)>,
    count: usize,
    weights: Vec<f64>,
    /// Whether a leg was planned as the settings ask for.
    sure: Vec<bool>,
}

impl<'a> Pairs<'a> {
    fn of(sequence: &'a Sequence) -> Result<Self, SequenceError> {
        let mut states = vec![(sequence.craft.start, true)];
        for stop in &sequence.stops {
            let joint = sequence.joint(stop)?;
            let given = matches!(joint, Joint::Given(_));
            states.push((joint.state(&vec![0.0; joint.size()]), given));
        }
        let count = states.len();
        let (weights, sure) = (vec![f64::INFINITY; count * count], vec![false; count * count]);
        Ok(Self { sequence, states, count, weights, sure })
    }

    fn place(&self, from: usize, to: usize) -> usize {
        from * self.count + to
    }

    /// Returns whether the way back takes as long as the way there.
    fn mirrored(&self, from: usize, to: usize) -> bool {
        let still = |stop: usize| {
            let (state, given) = self.states[stop];
            given && state.angular_velocity == Vector3::zeros()
        };
        let momentum = carried::momentum(&self.sequence.craft);
        from > 0 && to > 0 && still(from) && still(to) && momentum == Vector3::zeros()
    }

    /// Notes what a leg adds to an order, as a part of `weight`.
    fn know(&mut self, from: usize, to: usize, weight: f64, part: f64) {
        let back = self.mirrored(from, to).then_some((to, from));
        for (from, to) in std::iter::once((from, to)).chain(back) {
            let place = self.place(from, to);
            self.weights[place] = part * weight;
            self.sure[place] = part == 1.0;
        }
    }

    /// Plans a leg; infinite if no plan is found.
    fn planned(
        &self,
        from: usize,
        to: usize,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<f64, SequenceError> {
        let (sequence, [(start, _), (end, _)]) = (self.sequence, [from, to].map(|stop| self.states[stop]));
        let mut problem = Problem { start, end, ..sequence.leg() };
        carried::carry(&mut problem, &carried::momentum(&sequence.craft), None);
        if to == 0 {
            return Ok(f64::INFINITY);
        }
        if let Some(total) = sequence.shared()? {
            problem = problem.with_duration(total / sequence.stops.len() as f64);
        }
        let stop = &sequence.stops[to - 1];
        if let Place::Aim(aim) = &stop.place
            && aim.has_roll()
        {
            problem = problem.with_aim_at_end(aim.clone().at_rest());
        }
        let told = |error| SequenceError::Leg { stop: stop.name.clone(), error };
        let leg = Leg::of(problem, settings, None, observer).map_err(told)?;
        // Of effort c/T³ in a total the fourth roots add up.
        let weight = |leg: Leg| match sequence.craft.objective {
            Objective::Time => leg.cost,
            _ => leg.cost.powf(0.25),
        };
        Ok(leg.map_or(f64::INFINITY, weight))
    }
}
