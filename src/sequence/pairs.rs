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
//!
//! To and from targets that move, or past cones that do, a leg depends on when it begins. It is
//! planned at the times of the best order so far, and lies on a straight line between two of them;
//! the best order is then that of the times that were tried.

use super::carried;
use super::joint::Joint;
use super::leg::Leg;
use super::order::{Order, Proof, Stops, Visit};
use super::{Ordering, Part, Place, Sequence, SequenceError, Stop, tracked};
use crate::Vector3;
use crate::maneuver::aim::{Aim, AimRate};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Problem, State};
use crate::maneuver::settings::{Settings, Target, Thoroughness};
use crate::optimize::search::Observer;

/// What a quick plan counts for, as a part of it: less of it asks for more plans (`evidence --
/// orders`).
const SHORTER: f64 = 0.98;

/// Rounds of a search for each stop, where legs depend on when they begin: more rounds know them
/// better at the times of the best order.
const ROUNDS: usize = 2;

/// Returns the best order of the stops of a sequence.
pub fn ordered(
    sequence: &Sequence,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Order, SequenceError> {
    if let Some(order) = pinned(sequence) {
        return Ok(order);
    }
    let mut pairs = Pairs::of(sequence)?;
    let discrete = Settings { target: Target::Discrete, ..settings.clone() };
    let quick = Settings { search: Thoroughness::Quick, ..discrete.clone() };
    for from in 0..pairs.count {
        for to in (1..pairs.count).filter(|to| *to != from) {
            if !(pairs.mirrored(from, to) && to < from) {
                let part = format!("pair {} of {}", from * pairs.count + to, pairs.count * pairs.count);
                let observer = &mut Part { observer, part };
                let begins = pairs.first(from, to);
                let weight = pairs.planned((from, to, begins), &quick, observer)?;
                pairs.know((from, to), Known { begins, weight: SHORTER * weight, sure: false });
            }
        }
    }
    let visits: Vec<Visit> = sequence.stops.iter().map(|stop| stop.visit).collect();
    let last =
        Some(sequence.stops.len()).filter(|last| sequence.order == Ordering::FreeBeforeLast && *last > 0);
    let mut rounds = 0;
    loop {
        rounds += 1;
        let leg = |from: usize, to: usize, begins: f64| pairs.weight(from, to, begins);
        let least = |from: usize, to: usize| pairs.least(from, to);
        let stops = Stops { visits: &visits, leg: &leg, least: &least, last };
        let mut order = stops.best_order();
        let mut unsure = Vec::new();
        let (mut from, mut time) = (0, 0.0);
        for to in &order.stops {
            if !pairs.is_sure(from, *to, time) {
                unsure.push((from, *to, time));
            }
            (from, time) = (*to, visits[*to - 1].after(time + leg(from, *to, time)).0);
        }
        if pairs.is_timed() {
            (order.proof, order.bound) = (Proof::None, f64::NEG_INFINITY);
        }
        // What depends on the begin of every leg may be known ever better.
        if unsure.is_empty() || pairs.is_timed() && rounds > ROUNDS * pairs.count {
            return Ok(order);
        }
        for (from, to, begins) in unsure {
            let mut weight = pairs.planned((from, to, begins), &discrete, observer)?;
            if pairs.mirrored(from, to) {
                weight = weight.min(pairs.planned((to, from, begins), &discrete, observer)?);
            }
            if !pairs.is_timed() {
                weight = weight.min(pairs.least(from, to) / SHORTER);
            }
            pairs.know((from, to), Known { begins, weight, sure: true });
        }
    }
}

/// Returns the order of effort or fuel where the begin of every hold is given: no other keeps them.
fn pinned(sequence: &Sequence) -> Option<Order> {
    let visit = |stop: &usize| sequence.stops[stop - 1].visit;
    let mut stops: Vec<usize> = (1..=sequence.stops.len()).collect();
    if matches!(sequence.craft.objective, Objective::Time) || !stops.iter().all(|stop| visit(stop).pinned) {
        return None;
    }
    let free = stops.len() - usize::from(sequence.order == Ordering::FreeBeforeLast && !stops.is_empty());
    stops[..free].sort_by(|a, b| visit(a).window[0].total_cmp(&visit(b).window[0]));
    let end = visit(stops.last()?).after(0.0).0;
    Some(Order { stops, end, late: 0.0, bound: end, proof: Proof::AllOrders })
}

/// What a leg adds to an order if it begins at a time.
#[derive(Clone, Copy, Debug)]
struct Known {
    begins: f64,
    weight: f64,
    /// Whether it was planned as the settings ask for.
    sure: bool,
}

/// What all legs add to an order.
struct Pairs<'a> {
    sequence: &'a Sequence,
    /// The start and all stops, and whether each is given wholly.
    states: Vec<(State, bool)>,
    count: usize,
    /// What is known of each leg, by the time at which it begins.
    known: Vec<Vec<Known>>,
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
        Ok(Self { sequence, states, count, known: vec![Vec::new(); count * count] })
    }

    fn place(&self, from: usize, to: usize) -> usize {
        from * self.count + to
    }

    /// Returns whether legs depend on when they begin.
    fn is_timed(&self) -> bool {
        self.sequence.craft.is_timed() || self.sequence.stops.iter().any(tracked::moves)
    }

    /// Returns whether the way back takes as long as the way there.
    fn mirrored(&self, from: usize, to: usize) -> bool {
        let still = |stop: usize| {
            let (state, given) = self.states[stop];
            given && state.angular_velocity == Vector3::zeros()
        };
        let momentum = carried::momentum(&self.sequence.craft);
        let turns_back = momentum == Vector3::zeros() && !self.is_timed();
        from > 0 && to > 0 && still(from) && still(to) && turns_back
    }

    /// Notes what is known of a leg: beside what is known of it at other times, in place of that
    /// where it does not depend on the time.
    fn know(&mut self, (from, to): (usize, usize), known: Known) {
        let back = self.mirrored(from, to).then_some((to, from));
        let timed = self.is_timed();
        for (from, to) in std::iter::once((from, to)).chain(back) {
            let place = self.place(from, to);
            let all = &mut self.known[place];
            all.retain(|other| timed && other.begins != known.begins);
            let next = all.partition_point(|other| other.begins < known.begins);
            all.insert(next, known);
        }
    }

    /// Returns what a leg adds that begins at a time: between two times that are known by a straight
    /// line.
    fn weight(&self, from: usize, to: usize, begins: f64) -> f64 {
        let all = &self.known[self.place(from, to)];
        let next = all.partition_point(|known| known.begins < begins);
        match (next.checked_sub(1).and_then(|before| all.get(before)), all.get(next)) {
            (Some(before), Some(after)) if before.weight.is_finite() && after.weight.is_finite() => {
                let part = (begins - before.begins) / (after.begins - before.begins);
                before.weight + part * (after.weight - before.weight)
            }
            (Some(before), None) => before.weight,
            (_, Some(after)) => after.weight,
            (None, None) => f64::INFINITY,
        }
    }

    /// Returns the least that a leg adds at any time that is known.
    fn least(&self, from: usize, to: usize) -> f64 {
        self.known[self.place(from, to)].iter().map(|known| known.weight).fold(f64::INFINITY, f64::min)
    }

    /// Returns whether a leg was planned as the settings ask for, for a begin that is no further away
    /// than the leg lasts.
    fn is_sure(&self, from: usize, to: usize, begins: f64) -> bool {
        let near = |known: &Known| !self.is_timed() || (known.begins - begins).abs() <= known.weight;
        self.known[self.place(from, to)].iter().any(|known| known.sure && near(known))
    }

    /// Returns a time at which a leg may begin \[s\]: for its first plan.
    fn first(&self, from: usize, to: usize) -> f64 {
        let visit = |stop: usize| stop.checked_sub(1).map(|stop| self.sequence.stops[stop].visit);
        let left = visit(from).map_or(0.0, |visit| visit.window[0].max(0.0) + visit.hold);
        visit(to).map_or(left, |visit| left.max(visit.window[0]))
    }

    /// Returns the state in which a leg begins at a time \[s\].
    fn begun(&self, from: usize, begins: f64) -> Result<State, SequenceError> {
        let stop = from.checked_sub(1).map(|from| &self.sequence.stops[from]);
        let Some(Stop { name, place: Place::Aim(aim), .. }) = stop.filter(|stop| tracked::moves(stop)) else {
            return Ok(self.states[from].0);
        };
        let at = self.sequence.craft.start.attitude;
        let ends = aim.ends(begins, &at, &Vector3::zeros());
        let ends = ends.map_err(|error| SequenceError::Aim { stop: name.clone(), error })?;
        let (attitude, rate) = ends.at(ends.nearest(&at));
        Ok(State::attitude(attitude, rate))
    }

    /// Plans a leg that begins at a time \[s\]; infinite if no plan is found.
    fn planned(
        &self,
        (from, to, begins): (usize, usize, f64),
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<f64, SequenceError> {
        let sequence = self.sequence;
        if to == 0 {
            return Ok(f64::INFINITY);
        }
        let (start, end) = (self.begun(from, begins)?, self.states[to].0);
        let mut problem = Problem { start, end, ..sequence.leg() };
        carried::carry(&mut problem, &carried::momentum(&sequence.craft), None);
        if let Some(total) = sequence.shared()? {
            problem = problem.with_duration(total / sequence.stops.len() as f64);
        }
        let stop = &sequence.stops[to - 1];
        if let Place::Aim(aim) = &stop.place
            && (aim.has_roll() || tracked::moves(stop))
        {
            let rate = if tracked::moves(stop) { AimRate::Matched } else { AimRate::Zero };
            problem = problem.with_aim_at_end(Aim { rate, ..aim.clone() });
        }
        let leg = Leg::of(problem.later(begins), settings, None, observer);
        let leg = leg.map_err(|error| error.at(&stop.name))?;
        // Of effort c/T³ in a total the fourth roots add up.
        let weight = |leg: Leg| match sequence.craft.objective {
            Objective::Time => leg.cost,
            _ => leg.cost.powf(0.25),
        };
        Ok(leg.map_or(f64::INFINITY, weight))
    }
}
