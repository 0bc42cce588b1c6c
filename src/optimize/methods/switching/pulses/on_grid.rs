//! The discrete optimum of pulses: that of their grid, with the bounds that act on their times.
//!
//! With the lengths of the arcs `d = d_0 + D y`, free `y`, it meets the terminal conditions and `Dᵀ𝓗 = 0`, where `𝓗` are the means of the
//! discrete Hamiltonians of the arcs: the discrete action is stationary in every time that no bound holds.

use super::super::arcs::Arcs;
use super::super::discretize::{Layout, of_arcs};
use super::super::extremal::Extremal;
use super::super::on_grid::{OnGrid, Sweep, is_round_off};
use super::super::tuning::UNDETERMINED;
use super::super::tuning::grid::{CONVERGED, MOST_CHANGES, MOST_ITERATIONS};
use super::super::tuning::pulses::{KEPT, NEARBY_ON_GRID};
use super::motion::Motion;
use super::schedule::{Ask, Best, Schedule};
use super::ties::{Settled, Ties, settled};
use crate::numerics::least_squares::shortest;
use nalgebra::{DMatrix, DVector};

/// Pulses as arcs of the equations of motion, and on their grid.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub schedule: Schedule,
    pub arcs: Arcs,
    pub grid: OnGrid,
}

/// Why pulses have no place on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unplaced {
    /// The arcs need so many steps.
    Steps(usize),
    /// No discrete optimum was found.
    NoOptimum,
}

/// The discrete optimum on so many steps.
pub(crate) fn placed(extremal: &Extremal, best: &Best, ask: &Ask, steps: usize) -> Result<Placed, Unplaced> {
    let none = Unplaced::NoOptimum;
    let Settled { schedule, costates, bounds, mut acting } = settled(extremal, best, ask).ok_or(none)?;
    let continuous = Motion::fine(extremal, &schedule, &costates).arcs();
    let mut arcs = continuous.clone();
    let times = schedule.times();
    let inside = |time: &usize| times[*time] > 0.0 && times[*time] < schedule.duration;
    // The times of the switches, in their order.
    let mut order: Vec<usize> = (0..2 * schedule.pulses.len()).filter(inside).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    let mut layout = Layout::of(&arcs);
    for _ in 0..MOST_CHANGES {
        let mut ties = Ties::of(&schedule, &bounds, &acting);
        for arc in (1..order.len()).filter(|arc| layout.joined[*arc]) {
            ties.join(order[arc - 1], order[arc]);
        }
        let (counts, kept) = (layout.counts(steps).map_err(Unplaced::Steps)?, layout.kept());
        let matrix = ties.matrix();
        // Rows of D: the end of an arc less its start; the ends of the maneuver stand still, but for one that is sought.
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
        let first = of_arcs(extremal, &arcs, &counts);
        let solved = stationary(first.clone(), extremal, &of_length, true);
        let solved = solved.or_else(|| stationary(first, extremal, &of_length, false));
        let grid = solved.ok_or(none)?;
        if let Some(negative) = grid.shorter_than_nothing() {
            let arc = kept[negative];
            if layout.is_outer(arc) {
                // Beyond an end: it is held there.
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
        // The times of the grid, those at the ends as they are.
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
        let at = |time: Option<usize>| time.map_or(0.0, |time| found[time]);
        let violated = bounds.iter().zip(&acting).position(|(bound, acts)| {
            !acts && at(bound.b) - at(bound.a) - bound.least < -KEPT * schedule.duration
        });
        match violated {
            Some(violated) => acting[violated] = true,
            None => return Ok(Placed { schedule, arcs: continuous, grid }),
        }
    }
    Err(none)
}

/// Arcs of fuel on so many steps, whose own discrete optimum may lack one of the pulses or have them in another order: with times at the
/// bounds that act, however short pulses become.
pub(crate) fn arcs_placed(extremal: &Extremal, arcs: &Arcs, steps: usize) -> Option<OnGrid> {
    if !extremal.times_pulses() {
        return None;
    }
    let ask = Ask::free(extremal);
    let schedule = Schedule::kept(Schedule::of_arcs(arcs), arcs.duration, &ask)?;
    let (m, e) = (arcs.m, arcs.first.e);
    let best = Best { schedule, costates: [m.x, m.y, m.z, e.x, e.y, e.z], cost: arcs.cost(extremal) };
    placed(extremal, &best, &ask, steps).ok().map(|placed| placed.grid)
}

/// The same grid for a maneuver that ends a little elsewhere, warm; `None` where Newton does not get there, or an arc would have
/// less than no length.
pub(crate) fn again(grid: &OnGrid, extremal: &Extremal) -> Option<OnGrid> {
    let found = match &grid.of_free_times {
        Some(of_length) => stationary(grid.clone(), extremal, of_length, !grid.beside_optimum),
        None => grid.clone().solve(extremal),
    }?;
    found.shorter_than_nothing().is_none().then_some(found)
}

/// Newton on costates and free times, to round-off. Where it does not get there, on the times alone, that they meet the end, with the
/// costates that come nearest to making the Lagrangian stationary.
fn stationary(
    mut grid: OnGrid,
    extremal: &Extremal,
    of_length: &DMatrix<f64>,
    together: bool,
) -> Option<OnGrid> {
    let arcs = grid.lengths.len();
    let free = of_length.ncols();
    // Of every arc its own Hamiltonian.
    let each = extremal.lasting(None);
    let first = grid.lengths.clone();
    let mut last = f64::INFINITY;
    for iteration in 0..MOST_ITERATIONS {
        let Sweep { equations, torques } = grid.swept(&each)?;
        let (ends, means) = (equations.residual.rows(0, 6), equations.residual.rows(6, arcs));
        let mut residual = DVector::zeros(6 + free);
        residual.rows_mut(0, 6).copy_from(&ends);
        residual.rows_mut(6, free).copy_from(&of_length.tr_mul(&means));
        let size = |residual: &DVector<f64>| (residual.norm_squared() + equations.gaps).sqrt();
        let whole = size(&residual);
        let merit = if together { whole } else { size(&residual.rows(0, 6).into_owned()) };
        if is_round_off(merit, last, CONVERGED) {
            grid.torques = torques;
            grid.of_free_times = Some(of_length.clone());
            (grid.residual, grid.iterations, grid.beside_optimum) = (whole, iteration, !together);
            let near = grid
                .lengths
                .iter()
                .zip(&first)
                .all(|(length, first)| (length - first).abs() < NEARBY_ON_GRID * grid.duration());
            return near.then_some(grid);
        }
        last = merit;
        let jacobian = &equations.jacobian;
        let of_ends = jacobian.view((0, 6), (6, arcs)) * of_length;
        let of_costates = of_length.tr_mul(&jacobian.view((6, 0), (arcs, 6)));
        let of_lengths = of_length.tr_mul(&(jacobian.view((6, 6), (arcs, arcs)) * of_length));
        let (costates, lengths) = if together {
            let mut reduced = DMatrix::zeros(6 + free, 6 + free);
            reduced.view_mut((0, 0), (6, 6)).copy_from(&jacobian.view((0, 0), (6, 6)));
            reduced.view_mut((0, 6), (6, free)).copy_from(&of_ends);
            reduced.view_mut((6, 0), (free, 6)).copy_from(&of_costates);
            reduced.view_mut((6, 6), (free, free)).copy_from(&of_lengths);
            let step = shortest(&reduced, &-residual, UNDETERMINED)?;
            (step.rows(0, 6).into_owned(), step.rows(6, free).into_owned())
        } else {
            let lengths = shortest(&of_ends, &-residual.rows(0, 6), UNDETERMINED)?;
            let left = residual.rows(6, free) + of_lengths * &lengths;
            (shortest(&of_costates, &-left, UNDETERMINED)?, lengths)
        };
        let mut step = DVector::zeros(6 + arcs);
        step.rows_mut(0, 6).copy_from(&costates);
        step.rows_mut(6, arcs).copy_from(&(of_length * lengths));
        grid.take(&step, &equations, 1.0);
    }
    None
}
