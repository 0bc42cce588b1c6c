//! Times that stand at their bounds: each hangs on another time, or on an end of the maneuver.

use super::super::extremal::Extremal;
use super::super::tuning::pulses::*;
use super::super::tuning::{MET, NEAR_ITERATIONS, UNDETERMINED};
use super::motion::Motion;
use super::quadratic::Bound;
use super::schedule::{Ask, Best, Schedule};
use crate::optimize::nlp::kkt::Steps;
use nalgebra::{DMatrix, DVector, Vector6};

/// What a time is: a free number, if any, and what is added to it.
#[derive(Clone, Copy, Debug)]
struct Hung {
    free: Option<usize>,
    offset: f64,
}

/// How times follow from those that are free, `t = t_0 + G y`.
#[derive(Clone, Debug)]
pub(super) struct Ties {
    hung: Vec<Hung>,
    free: usize,
}

impl Ties {
    /// Those of the bounds that act; one of them for each of `bounds`.
    pub fn of(schedule: &Schedule, bounds: &[Bound], acting: &[bool]) -> Self {
        let none = Hung { free: None, offset: 0.0 };
        let mut ties = Self { hung: vec![none; schedule.times().len()], free: 0 };
        let end = schedule.end();
        if let Some(end) = end {
            ties.hung[end].free = Some(0);
            ties.free = 1;
        }
        for (bound, acts) in bounds.iter().zip(acting) {
            match (bound.a, bound.b) {
                // An end that is sought has its number already; a pulse may last to it.
                (Some(a), Some(b)) if end == Some(b) && *acts => ties.join(a, b),
                (Some(_), Some(b)) if end == Some(b) => {}
                (a, Some(b)) if *acts => {
                    let from = a.map_or(none, |a| ties.hung[a]);
                    ties.hung[b] = Hung { offset: from.offset + bound.least, ..from };
                }
                (_, Some(b)) => {
                    ties.hung[b] = Hung { free: Some(ties.free), offset: 0.0 };
                    ties.free += 1;
                }
                (Some(a), None) if *acts => ties.fix(ties.hung[a], -bound.least),
                _ => {}
            }
        }
        ties
    }

    /// Makes a time stand still.
    fn fix(&mut self, which: Hung, at: f64) {
        let Some(free) = which.free else { return };
        for hung in &mut self.hung {
            if hung.free == Some(free) {
                *hung = Hung { free: None, offset: at - which.offset + hung.offset };
            }
        }
    }

    /// Makes two times one.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.hung[a], self.hung[b]);
        match (a.free, b.free) {
            (None, Some(_)) => self.fix(b, a.offset),
            (Some(_), None) => self.fix(a, b.offset),
            (Some(of_a), Some(of_b)) if of_a != of_b => {
                for hung in &mut self.hung {
                    if hung.free == Some(of_b) {
                        *hung = Hung { free: Some(of_a), offset: a.offset - b.offset + hung.offset };
                    }
                }
            }
            _ => {}
        }
    }

    /// `G`.
    pub fn matrix(&self) -> DMatrix<f64> {
        // Numbers that were fixed later have no time.
        let mut used: Vec<usize> = self.hung.iter().filter_map(|hung| hung.free).collect();
        used.sort_unstable();
        used.dedup();
        DMatrix::from_fn(self.hung.len(), used.len(), |time, column| {
            if self.hung[time].free == Some(used[column]) { 1.0 } else { 0.0 }
        })
    }

    /// Times that hang as they should, near the given ones.
    pub fn snapped(&self, times: &DVector<f64>) -> DVector<f64> {
        let mut first = vec![None; self.free];
        DVector::from_fn(times.len(), |time, _| {
            let Hung { free, offset } = self.hung[time];
            free.map_or(offset, |free| *first[free].get_or_insert(times[time] - offset) + offset)
        })
    }
}

/// A schedule whose times stand exactly at the bounds that act, with its bounds and which of them do.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    pub schedule: Schedule,
    pub costates: [f64; 6],
    pub bounds: Vec<Bound>,
    pub acting: Vec<bool>,
}

/// Puts the times at the bounds that they are near to, and brings the others to where the end is met and the Lagrangian is stationary;
/// where Newton finds no such times near by, to where the end is met alone.
pub(super) fn settled(extremal: &Extremal, best: &Best, ask: &Ask) -> Option<Settled> {
    let bounds = best.schedule.bounds(ask);
    let times = best.schedule.times();
    let at = |time: Option<usize>, times: &DVector<f64>| time.map_or(0.0, |time| times[time]);
    let slack = |bound: &Bound, times: &DVector<f64>| at(bound.b, times) - at(bound.a, times) - bound.least;
    let all = [Steps::Shortest, Steps::Feasible].into_iter();
    all.flat_map(|steps| NEAR.map(|near| (steps, near))).find_map(|(steps, near)| {
        let acting: Vec<bool> =
            bounds.iter().map(|bound| slack(bound, &times) < near * best.schedule.duration).collect();
        let ties = Ties::of(&best.schedule, &bounds, &acting);
        let (schedule, costates) = newton(extremal, best, &ties, steps)?;
        let times = schedule.times();
        let kept = bounds.iter().all(|bound| slack(bound, &times) >= -KEPT * best.schedule.duration);
        kept.then(|| Settled { schedule, costates, bounds: bounds.clone(), acting })
    })
}

/// Newton on costates and free times.
fn newton(extremal: &Extremal, best: &Best, ties: &Ties, steps: Steps) -> Option<(Schedule, [f64; 6])> {
    let (matrix, first) = (ties.matrix(), ties.snapped(&best.schedule.times()));
    let (mut times, mut costates) = (first.clone(), Vector6::from(best.costates));
    let mut last = f64::INFINITY;
    for _ in 0..NEAR_ITERATIONS {
        let schedule = best.schedule.at(&times);
        let kkt = Motion::fine(extremal, &schedule, &costates.into())?.kkt.tied(&matrix);
        let size = kkt.merit(steps);
        if size < SHARP || size < MET && size >= 0.5 * last {
            let moved = (&times - &first).amax();
            return (moved < NEARBY * schedule.duration).then_some((schedule, costates.into()));
        }
        last = size;
        let step = kkt.newton_step(steps, UNDETERMINED)?;
        costates += step.fixed_rows::<6>(0);
        times += &matrix * step.rows(6, matrix.ncols());
    }
    None
}
