//! Search for the order of stops, from plans of the legs between all pairs.
//!
//! Every pair is first planned by a quick search. A quick plan may be longer than the best one,
//! usually by at most the factor [`SHORTER`]. Its cost is therefore multiplied by this factor until
//! the leg is planned with the requested settings. In each round the legs of the best order so far
//! are planned with the requested settings, until one order consists of such legs only. No other
//! order is then better, unless a quick plan was still longer than assumed.
//!
//! From rest to rest, and without stored momentum, the return leg takes as long as the outward leg
//! for any inputs: `R(T−t), −Ω(T−t), u(T−t)` solves the same equations. The search for one of the
//! two legs usually finds what the other search misses, so the shorter duration applies to both
//! legs.
//!
//! If targets or cones move, a leg depends on its start time. It is planned at the times of the
//! best order so far, and interpolated linearly between two such times. The result is then the best
//! order for the times that were tried.

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

/// Factor on the cost of a quick plan. A smaller factor causes more plans (`evidence -- orders`).
const SHORTER: f64 = 0.98;

/// Rounds of the search per stop if legs depend on their start times. More rounds give more
/// accurate costs at the times of the best order.
const ROUNDS: usize = 2;

/// Finds the best order of the stops of a sequence.
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
        // If legs depend on their start times, further rounds would always refine their costs.
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

/// Returns the only possible order of a minimum-effort or minimum-fuel sequence in which the start
/// of every hold is given: the order of these times. Returns `None` for other sequences.
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

/// The weight of a leg in an order, if the leg begins at a known time.
#[derive(Clone, Copy, Debug)]
struct Known {
    begins: f64,
    weight: f64,
    /// Whether the leg was planned with the requested settings.
    sure: bool,
}

/// The weights of the legs between all pairs of stops.
struct Pairs<'a> {
    sequence: &'a Sequence,
    /// The states of the start and of all stops, and whether each state is given completely.
    states: Vec<(State, bool)>,
    count: usize,
    /// The known weights of each leg, in the order of its start time.
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

    /// Returns whether the weights of legs depend on their start times.
    fn is_timed(&self) -> bool {
        self.sequence.craft.is_timed() || self.sequence.stops.iter().any(tracked::moves)
    }

    /// Returns whether the return leg takes as long as the outward leg.
    fn mirrored(&self, from: usize, to: usize) -> bool {
        let still = |stop: usize| {
            let (state, given) = self.states[stop];
            given && state.angular_velocity == Vector3::zeros()
        };
        let momentum = carried::momentum(&self.sequence.craft);
        let turns_back = momentum == Vector3::zeros() && !self.is_timed();
        from > 0 && to > 0 && still(from) && still(to) && turns_back
    }

    /// Records the weight of a leg. If legs depend on their start times, the weights for other
    /// start times are kept; otherwise the new weight replaces the old one.
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

    /// Returns the weight of a leg that begins at the time `begins`, interpolated linearly between
    /// known start times.
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

    /// Returns the smallest known weight of a leg over its start times.
    fn least(&self, from: usize, to: usize) -> f64 {
        self.known[self.place(from, to)].iter().map(|known| known.weight).fold(f64::INFINITY, f64::min)
    }

    /// Returns whether a leg was planned with the requested settings, for a start time that differs
    /// by no more than the duration of the leg.
    fn is_sure(&self, from: usize, to: usize, begins: f64) -> bool {
        let near = |known: &Known| !self.is_timed() || (known.begins - begins).abs() <= known.weight;
        self.known[self.place(from, to)].iter().any(|known| known.sure && near(known))
    }

    /// Returns the start time \[s\] for the first plan of a leg.
    fn first(&self, from: usize, to: usize) -> f64 {
        let visit = |stop: usize| stop.checked_sub(1).map(|stop| self.sequence.stops[stop].visit);
        let left = visit(from).map_or(0.0, |visit| visit.window[0].max(0.0) + visit.hold);
        visit(to).map_or(left, |visit| left.max(visit.window[0]))
    }

    /// Returns the state from which a leg begins at the time `begins` \[s\].
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

    /// Plans a leg that begins at the time `begins` \[s\], and returns its weight; infinite if no
    /// plan is found.
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
        let stays = match from.checked_sub(1) {
            Some(from) => sequence.stays(from, to - 1),
            None => sequence.is_at(to - 1, &sequence.craft.start),
        };
        if stays {
            return Ok(0.0);
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
        // For efforts c/T³ in a total time, the weights that add up are the fourth roots of the
        // costs.
        let weight = |leg: Leg| match sequence.craft.objective {
            Objective::Time => leg.cost,
            _ => leg.cost.powf(0.25),
        };
        Ok(leg.map_or(f64::INFINITY, weight))
    }
}
