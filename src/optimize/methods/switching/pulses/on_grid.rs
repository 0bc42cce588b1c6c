//! The discrete optimum of pulses on their grid, with the active bounds of their times.
//!
//! With the arc lengths `d = d_0 + D y` and the free times `y`, the optimum satisfies the terminal
//! conditions and `Dᵀ𝓗 = 0`, where `𝓗` holds the mean discrete Hamiltonians of the arcs: the
//! discrete action is stationary in every time that is not at an active bound.

use super::super::arcs::Arcs;
use super::super::discretize::{Layout, of_arcs};
use super::super::extremal::Extremal;
use super::super::on_grid::OnGrid;
use super::super::tuning::limits::MOST_CORRECTIONS;
use super::super::tuning::pulses::{FINE, KEPT};
use super::motion::Motion;
use super::optimum::{Settled, acts, settled};
use super::schedule::{Best, PulseRequest, Schedule};
use crate::optimize::nlp::bounds::{Bound, Ties};
use nalgebra::DMatrix;

/// Pulses, both as arcs of the continuous motion and on their grid.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub schedule: Schedule,
    pub arcs: Arcs,
    pub grid: OnGrid,
}

/// Reason why pulses have no discrete optimum on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unplaced {
    /// The grid has too few steps; the arcs need this many.
    Steps(usize),
    /// No discrete optimum was found.
    NoOptimum,
}

/// Solves for the discrete optimum of pulses on a grid with the given number of steps.
pub(crate) fn placed(
    extremal: &Extremal,
    best: &Best,
    ask: &PulseRequest,
    steps: usize,
) -> Result<Placed, Unplaced> {
    let none = Unplaced::NoOptimum;
    let Settled { schedule, costates, bounds, mut acting } = settled(extremal, best, ask).ok_or(none)?;
    let continuous = Motion::of(extremal, &schedule, &costates, FINE).ok_or(none)?.arcs;
    let mut arcs = continuous.clone();
    let times = schedule.times();
    let inside = |time: &usize| times[*time] > 0.0 && times[*time] < schedule.duration;
    // Indices of the switching times, in order of time.
    let mut order: Vec<usize> = (0..2 * schedule.pulses.len()).filter(inside).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    let mut layout = Layout::of(&arcs);
    for _ in 0..MOST_CORRECTIONS {
        let mut ties = Ties::of(times.len(), acts(&bounds, &acting));
        for arc in (1..order.len()).filter(|arc| layout.joined[*arc]) {
            ties.add(&Bound { a: Some(order[arc - 1]), b: Some(order[arc]), least: 0.0 });
        }
        let (counts, kept) = (layout.counts(steps).map_err(Unplaced::Steps)?, layout.kept());
        let matrix = ties.matrix();
        // Rows of D: end minus start of an arc. The ends of the maneuver are fixed, except for a
        // free duration.
        let of_length = DMatrix::from_fn(kept.len(), matrix.ncols(), |row, free| {
            let arc = kept[row];
            let end = order.get(arc).copied().or(schedule.end()).map_or(0.0, |time| matrix[(time, free)]);
            let start = arc.checked_sub(1).map_or(0.0, |before| matrix[(order[before], free)]);
            end - start
        });
        let snapped = ties.snapped(&times);
        for (switch, time) in arcs.switches.iter_mut().zip(&order) {
            switch.time = snapped[*time];
        }
        if let Some(end) = schedule.end() {
            arcs.duration = snapped[end];
        }
        let first = OnGrid { of_free_times: Some(of_length), ..of_arcs(extremal, &arcs, &counts) };
        let solved = [false, true]
            .into_iter()
            .find_map(|beside_optimum| OnGrid { beside_optimum, ..first.clone() }.solve(extremal));
        let grid = solved.ok_or(none)?;
        if let Some(negative) = grid.shorter_than_nothing() {
            let arc = kept[negative];
            if layout.is_outer(arc) {
                // If the first or last arc has negative length, its switch is held at the start or
                // the end of the maneuver.
                let outside =
                    if arc == 0 { (None, Some(order[0])) } else { (Some(order[arc - 1]), schedule.end()) };
                let held = bounds.iter().position(|bound| (bound.a, bound.b) == outside).ok_or(none)?;
                acting[held] = true;
            }
            if layout.mend(arc, &mut arcs) {
                order.swap(arc - 1, arc);
            }
            continue;
        }
        // Times on the grid; those at the ends do not change.
        let mut found = times.clone();
        let mut clock = 0.0;
        let mut lengths = grid.lengths.iter();
        for (arc, time) in order.iter().enumerate() {
            if !layout.joined[arc] {
                clock += lengths.next().unwrap_or(&0.0);
            }
            found[*time] = clock;
        }
        if let Some(end) = schedule.end() {
            found[end] = grid.duration();
        }
        let least = -KEPT * schedule.duration;
        let violated =
            bounds.iter().zip(&acting).position(|(bound, acts)| !acts && bound.slack(&found) < least);
        match violated {
            Some(violated) => acting[violated] = true,
            None => return Ok(Placed { schedule, arcs: continuous, grid }),
        }
    }
    Err(none)
}

/// Solves for arcs of minimum fuel on the given number of steps, with times at their active bounds
/// and pulses of any length. It is used if the discrete optimum of the arcs lacks one of the pulses
/// or has another order of switches. Returns `None` if no solution is found.
pub(crate) fn arcs_placed(extremal: &Extremal, arcs: &Arcs, steps: usize) -> Option<OnGrid> {
    if !extremal.times_pulses() {
        return None;
    }
    let ask = PulseRequest::free(extremal);
    let schedule = Schedule::kept(Schedule::of_arcs(arcs), arcs.duration, &ask)?;
    let best = Best { schedule, costates: arcs.costates(), cost: arcs.cost(extremal) };
    placed(extremal, &best, &ask, steps).ok().map(|placed| placed.grid)
}
