//! Optima on grids with a node at every event.
//!
//! An input that switches has one node between its two levels. At an optimum of the discrete
//! maneuver, such an input is at one of its limits or has a switching function of zero; at most as
//! many inputs have a zero as there are terminal equations. If there are more switches than
//! equations, a quadratic term therefore pulls the input to the mean of both sides:
//!
//! ```text
//! ½ w (u − ū)² ,     w = |ṡ| κ²/|u_L − u_R|
//! ```
//!
//! With the rate `ṡ` of the switching function and the weight `κ` of the kick, the node takes the
//! value of a switch that Newton's step moves by `−s/ṡ`. At the fixed point `u = ū` the term and
//! its slope are zero and the switching function vanishes at the node, so that the plan is a
//! discrete optimum without the term.

use super::events::{Event, Read};
use super::fixed_point::Anderson;
use super::settings::ON_EVENTS;
use crate::lie;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Problem, Scheme};
use crate::maneuver::solution::{Rung, Trajectory};
use crate::mechanics::environment::Pose;
use crate::optimize::chain::model::{Goal, Pull};
use crate::optimize::chain::{Chain, path};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::interior_point::chain::warm::Warm;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::context::Context;
use crate::optimize::search::starts::transfer::{Interpolant, transfer};
use crate::optimize::search::strategies::chains::{along, resampled};
use std::cell::Cell;
use std::rc::Rc;

/// A discrete optimum and its events. After the iteration has converged, the grid has a node at
/// each event.
#[derive(Clone)]
pub(super) struct OnGrid {
    chain: Rc<Chain>,
    found: Attempt,
    pub events: Vec<Event>,
}

impl OnGrid {
    /// Returns the same optimum with other events.
    pub fn with_events(&self, events: Vec<Event>) -> Self {
        Self { events, ..self.clone() }
    }

    /// Returns the cost in the user's unit.
    pub fn cost(&self) -> f64 {
        self.chain.price(&self.found.candidate)
    }

    /// Returns the duration as a multiple of the stated problem's duration.
    pub fn stretch(&self) -> f64 {
        self.found.candidate.grid.duration()
    }

    /// Returns the times of the events, as fractions of the duration.
    pub fn times(&self) -> Vec<f64> {
        self.events.iter().map(|event| event.at).collect()
    }

    /// Returns an upper bound, from the barrier parameter, on the relative excess of the cost over
    /// the discrete optimum.
    pub fn gap(&self) -> Option<f64> {
        self.found.barrier.map(|[_, gap, _]| gap)
    }

    /// Returns the name of the limit or constraint of a group of rows.
    pub fn name(&self, group: usize) -> String {
        self.chain.rows.groups[group].name.clone()
    }

    /// Returns the number of inputs.
    pub fn inputs(&self) -> usize {
        self.chain.model.m
    }

    /// Returns the number of force inputs, which precede the torque inputs.
    pub fn forces(&self) -> usize {
        self.chain.model.forces
    }
}

/// Grids of one attempt to find arcs.
pub(super) struct Grids<'a, 'c> {
    /// The maneuver with the duration of its plan.
    pub stated: &'a Problem,
    goal: &'a Goal,
    context: &'a Context<'c>,
    /// Total number of steps of the first grid.
    steps: usize,
    /// Chain on a uniform grid, on which the events are first read.
    equal: Rc<Chain>,
    /// Largest magnitudes of the inputs for the duration of `stated`, scaled.
    bounds: Vec<f64>,
    /// Remaining budget of the interior-point method, as iterations times steps.
    left: &'a Cell<usize>,
}

impl<'a, 'c> Grids<'a, 'c> {
    /// Creates the grids of an attempt with `steps` steps on the first grid and the remaining
    /// budget `left`.
    pub fn of(
        stated: &'a Problem,
        goal: &'a Goal,
        context: &'a Context<'c>,
        (steps, left): (usize, &'a Cell<usize>),
    ) -> Self {
        let equal = Chain::with_goal(stated, ON_EVENTS.read * steps, goal);
        let bounds = equal.model.input_bounds(stated);
        Self { stated, goal, context, steps, equal: Rc::new(equal), bounds, left }
    }

    /// Returns the limit of an input \[N or N·m\].
    pub fn size(&self, input: usize) -> f64 {
        self.bounds[input] * self.equal.model.input_unit[input]
    }

    /// Returns the optimum near a plan on the uniform grid, with its events.
    pub fn first(&self, plan: &Trajectory) -> Option<OnGrid> {
        let start = resampled(&self.equal, "arcs", plan).pop()?;
        let found = self.optimised(&self.equal, start, None, Tuning::default())?;
        let mut first = OnGrid { chain: self.equal.clone(), found, events: Vec::new() };
        first.events = self.read(&first)?.events();
        Some(first)
    }

    /// Prepares an optimum for reading its events; `None` if it has no barrier parameter.
    pub fn read<'b>(&self, at: &'b OnGrid) -> Option<Read<'b>> {
        let [barrier, ..] = at.found.barrier?;
        Some(Read::of(&at.chain, &at.found.candidate, &self.bounds, barrier))
    }

    /// Returns the number of steps of the first grid on each interval: from the start to the first
    /// event, between events, and from the last event to the end.
    pub fn counts(&self, events: &[Event]) -> Vec<usize> {
        let times = with_ends(events);
        let steps = |pair: &[f64]| ((pair[1] - pair[0]) * self.steps as f64).ceil() as usize;
        times.windows(2).map(|pair| steps(pair).max(ON_EVENTS.of_arc)).collect()
    }

    /// Iterates to the optimum on the grid of its own events, from an optimum on a similar grid.
    /// `counts` gives the steps of the first grid on each interval and the refinement factor of
    /// this grid; no new event is allowed then. Returns `None` if the iteration does not converge.
    pub fn settled(&self, from: &OnGrid, counts: Option<(&[usize], usize)>) -> Option<OnGrid> {
        let (mut at, mut rounds) = (from.clone(), Anderson::default());
        let mut moved = None;
        for round in 0..ON_EVENTS.rounds {
            let (own, finer) =
                counts.map_or_else(|| (self.counts(&at.events), 1), |(own, finer)| (own.to_vec(), finer));
            let chain = Rc::new(self.chain(&at, &own, finer)?);
            let found = self.carried(&at, &chain, moved)?;
            let next = OnGrid { chain, found, events: at.events.clone() };
            let events = self.read(&next)?.events();
            let is_new =
                |event: &Event| at.events.iter().all(|old| (old.at - event.at).abs() > ON_EVENTS.near);
            let comes = events.iter().any(is_new);
            if comes && counts.is_some() {
                return None;
            }
            let free = round < ON_EVENTS.free && events.len() != at.events.len();
            if comes || free && counts.is_none() {
                // A node without a switch does no harm, so no event is dropped after the first
                // rounds.
                let events = if free { events } else { together(&at.events, &events) };
                (at, rounds, moved) = (OnGrid { events, ..next }, Anderson::default(), None);
                continue;
            }
            let events = nearest(&at.events, &events);
            let by = events.iter().zip(&at.events).map(|(a, b)| (a.at - b.at).abs()).fold(0.0, f64::max);
            if by <= ON_EVENTS.settled {
                // The new events are more accurate than the grid.
                return Some(OnGrid { events, ..next });
            }
            let events = in_order(rounds.next(&times(&at.events), &times(&events)), events);
            (at, moved) = (OnGrid { events, ..next }, Some(by));
        }
        None
    }

    /// Improves a candidate by the interior-point method; `None` if it does not converge or the
    /// budget is exhausted.
    fn optimised(
        &self,
        chain: &Chain,
        start: Candidate,
        warm: Option<&Warm>,
        tuning: Tuning,
    ) -> Option<Attempt> {
        if self.left.get() == 0 {
            return None;
        }
        let tuning = Tuning { last: ON_EVENTS.barrier, tolerable: 0.0, ..tuning };
        let method = InteriorPoint { warm, ..InteriorPoint::of(chain, &tuning) };
        let found = self.context.tried(Rung::InteriorPoint, &method, start);
        let iterations: usize = found.runs.iter().map(|run| run.report.iterations).sum();
        self.left.set(self.left.get().saturating_sub(iterations * chain.model.steps));
        found.converged().then_some(found)
    }

    /// Creates the chain on a grid with a node at every event. `counts` are the steps between
    /// events, each multiplied by `finer`.
    ///
    /// A cone is touched in the middle of a group of equal steps, and therefore in the middle of
    /// one step, or at a node, on every grid with three times as many steps.
    fn chain(&self, at: &OnGrid, counts: &[usize], finer: usize) -> Option<Chain> {
        let ends = with_ends(&at.events);
        // Times, each with the number of steps that precede it.
        let (mut places, mut passed) = (vec![(0.0, 0)], 0);
        let mut stages = Vec::new();
        for (index, event) in at.events.iter().enumerate() {
            passed += counts[index];
            let half = 0.5 * event.about as f64;
            let step = |from: f64, to: f64, count: usize| (to - from) / (count as f64 + half);
            let before = step(ends[index], event.at, counts[index]);
            let after = step(event.at, ends[index + 2], counts[index + 1]);
            let width = half * before.min(after);
            stages.push(passed * finer);
            places.push((event.at - width, passed));
            if event.about > 0 {
                passed += event.about;
                places.push((event.at + width, passed));
            }
        }
        passed += counts.last()?;
        places.push((1.0, passed));
        let pieces = places.windows(2).flat_map(|pair| {
            let [(from, first), (to, last)] = [pair[0], pair[1]];
            let count = (last - first) * finer;
            vec![(to - from) / count as f64; count]
        });
        let grid = Grid::of_lengths(Scheme::LieVerlet, &pieces.collect::<Vec<_>>()).ok()?.with_duration(1.0);
        let mut chain = Chain::with_goal_on(self.stated, grid, self.goal);
        chain.model.pulls = self.pulls(at, &chain, &stages);
        Some(chain)
    }

    /// Returns the quadratic penalties that pull the switching inputs to the mean of both sides, at
    /// the nodes of their events.
    fn pulls(&self, at: &OnGrid, chain: &Chain, stages: &[usize]) -> Vec<Pull> {
        let grid = &chain.model.dynamics.grid;
        let grown = at.stretch().powi(2);
        let of = |(event, stage): (&Event, &usize)| -> Vec<Pull> {
            let (stage, kick) = (*stage, grid.kick(*stage));
            let [before, after] = [grid.step(stage - 1), grid.step(stage)];
            let pull = |input: usize, levels: [f64; 2], slope: f64| {
                let unit = self.bounds[input] * grown;
                let mean = (before * levels[0] + after * levels[1]) / (before + after);
                let weight = slope * kick * kick / ((levels[0] - levels[1]).abs() * unit * unit);
                Pull { stage, input, at: mean * unit, weight }
            };
            event.switches.iter().map(|switch| pull(switch.input, switch.levels, switch.slope)).collect()
        };
        at.events.iter().zip(stages).flat_map(of).collect()
    }

    /// Solves for the optimum on another grid, from the optimum on a grid with nearly the same
    /// events.
    fn carried(&self, from: &OnGrid, chain: &Chain, moved: Option<f64>) -> Option<Attempt> {
        let (few, many) = (from.chain.model.steps, chain.model.steps);
        let known = &from.found.candidate;
        if many.is_multiple_of(few) {
            let tuning = moved.map_or_else(Tuning::near, Tuning::beside);
            let start = transfer([&from.chain, chain], known);
            let found = self.optimised(chain, start, from.found.warm.as_deref(), tuning);
            if found.is_some() {
                return found;
            }
        }
        let times: Vec<f64> = (0..=few).map(|node| known.grid.time(node) / known.grid.duration()).collect();
        let nodes = Interpolant::of(known.states.iter().map(Point::pose).collect());
        let pose = |node: usize| -> Pose {
            let (low, share) = place(&times, chain.model.dynamics.grid.time(node));
            nodes.at(low, share)
        };
        let along = path("arcs", &chain.model.dynamics.grid, (0..=many).map(pose));
        self.optimised(chain, along, None, Tuning::default())
    }
}

/// Returns the largest distance between the path of a plan and that of an optimum \[rad\].
pub(super) fn distance(found: &OnGrid, plan: &Trajectory) -> f64 {
    let candidate = &found.found.candidate;
    let path = along("plan", plan, &found.chain.model.dynamics);
    let scale = plan.time.last().map_or(f64::NAN, |last| last / candidate.grid.duration());
    let off = |node: usize| {
        let (low, share) = place(&plan.time, candidate.grid.time(node) * scale);
        let [from, to] = [low, low + 1].map(|row| path.states[row].attitude.value);
        let planned = from * lie::exp(&(lie::minus(&to, &from) * share));
        lie::minus(&candidate.states[node].attitude.value, &planned).norm()
    };
    (0..=candidate.steps())
        .map(off)
        .fold(0.0, |worst, off| if off > worst || off.is_nan() { off } else { worst })
}

/// Returns the index of the interval of `times` that contains the time `at`, and the position
/// within the interval, from 0 to 1.
fn place(times: &[f64], at: f64) -> (usize, f64) {
    let after = times.partition_point(|time| *time <= at).clamp(1, times.len() - 1);
    (after - 1, ((at - times[after - 1]) / (times[after] - times[after - 1])).clamp(0.0, 1.0))
}

/// Returns the times of events, as fractions of the duration.
fn times(events: &[Event]) -> Vec<f64> {
    events.iter().map(|event| event.at).collect()
}

/// Returns the times of start, events and end, as fractions of the duration.
fn with_ends(events: &[Event]) -> Vec<f64> {
    [vec![0.0], times(events), vec![1.0]].concat()
}

/// Returns the events with the given new times, or with their old times if the new ones are not in
/// increasing order.
fn in_order(times: Vec<f64>, events: Vec<Event>) -> Vec<Event> {
    let ends = [vec![0.0], times, vec![1.0]].concat();
    if ends.windows(2).any(|pair| pair[1] - pair[0] < 0.5 * ON_EVENTS.apart) {
        return events;
    }
    events.into_iter().zip(&ends[1..]).map(|(event, at)| Event { at: *at, ..event }).collect()
}

/// Merges two lists of events. Of two events that are close together, the one of `found` is kept.
fn together(known: &[Event], found: &[Event]) -> Vec<Event> {
    let alone = |event: &&Event| found.iter().all(|other| (event.at - other.at).abs() > ON_EVENTS.near);
    let mut all: Vec<Event> = known.iter().filter(alone).chain(found).cloned().collect();
    all.sort_by(|a, b| a.at.total_cmp(&b.at));
    all
}

/// Returns for each event of `known` the nearest event of `found` in its neighbourhood, or the
/// known event if none is near.
fn nearest(known: &[Event], found: &[Event]) -> Vec<Event> {
    let ends = with_ends(known);
    let of = |(index, event): (usize, &Event)| {
        let [before, after] = [index, index + 2].map(|end| 0.5 * (ends[end] + event.at));
        let between = |other: &&Event| other.at > before && other.at < after;
        let off = |other: &Event| (other.at - event.at).abs();
        let nearest = found.iter().filter(between).min_by(|a, b| off(a).total_cmp(&off(b)));
        Event { about: event.about, ..nearest.unwrap_or(event).clone() }
    };
    known.iter().enumerate().map(of).collect()
}
