//! The optimal times of given pulses: minimum fuel subject to the terminal conditions and to the
//! bounds on the times.
//!
//! The method is sequential quadratic programming that stays on the terminal conditions. A step
//! minimises the quadratic model of the Lagrangian subject to the linearised terminal conditions.
//! Its curvature is the exact second derivative with negative eigenvalues replaced by their
//! absolute values. Gauss–Newton then restores the terminal conditions, within the bounds.

use super::super::arcs::Arcs;
use super::super::extremal::Extremal;
use super::super::tuning::grid::MOST_ITERATIONS;
use super::super::tuning::pulses::*;
use super::super::tuning::{MET, NEAR_ITERATIONS, NO_LENGTH, NOTHING, UNDETERMINED};
use super::motion::Motion;
use super::schedule::{Best, PulseRequest, Schedule};
use crate::numerics::least_squares::shortest;
use crate::optimize::methods::PROMISED;
use crate::optimize::nlp::bounds::{Bound, Ties};
use crate::optimize::nlp::kkt::NewtonSteps;
use crate::optimize::nlp::quadratic::Quadratic;
use nalgebra::{DMatrix, DMatrixView, DVector, Vector6};

/// Returns the bounds of a step from the given times. They keep the bounds of the times and let no
/// time change by more than `trust`.
fn bounds_of_step(bounds: &[Bound], times: &DVector<f64>, trust: f64) -> Vec<Bound> {
    // A bound that is violated by round-off is treated as met.
    let kept = bounds.iter().map(|bound| Bound { least: (-bound.slack(times)).min(0.0), ..*bound });
    let limits = (0..times.len()).flat_map(|time| {
        let (later, sooner) = ((None, Some(time)), (Some(time), None));
        [later, sooner].map(|(a, b)| Bound { a, b, least: -trust })
    });
    kept.chain(limits).collect()
}

/// Changes the times until the terminal conditions are met, by Gauss–Newton; `None` if that fails
/// within `iterations` iterations.
fn met(extremal: &Extremal, first: &Schedule, ask: &PulseRequest, iterations: usize) -> Option<Schedule> {
    let bounds = first.bounds(ask);
    let mut schedule = first.clone();
    let mut trust = TRUST * schedule.duration;
    let mut miss = Motion::of(extremal, &schedule, &Vector6::zeros(), COARSE)?.kkt;
    let mut acting = vec![false; bounds.len() + 2 * schedule.times().len()];
    let mut slow = 0;
    for _ in 0..iterations {
        let size = miss.constraints().norm();
        if size < MET {
            return Some(schedule);
        }
        let times = schedule.times();
        // The residual that a step leaves is unknown too: its elimination would give an
        // ill-conditioned matrix.
        let count = times.len();
        let weights = DVector::from_fn(count + 6, |row, _| if row < count { 1.0 } else { STIFF });
        let (hessian, gradient) = (DMatrix::from_diagonal(&weights), DVector::zeros(count + 6));
        let mut rows = DMatrix::zeros(6, count + 6);
        rows.columns_mut(0, count).copy_from(&miss.by_unknowns());
        rows.columns_mut(count, 6).fill_diagonal(-1.0);
        let right = -miss.constraints();
        let limits = bounds_of_step(&bounds, &times, trust);
        let program = Quadratic {
            hessian: &hessian,
            gradient: &gradient,
            equations: Some((&rows, &right)),
            bounds: &limits,
        };
        let step = program.solve(&acting)?;
        acting = step.acting;
        let moved = step.p.rows(0, count);
        let next = schedule.at(&(times + moved));
        let after = Motion::of(extremal, &next, &Vector6::zeros(), COARSE).map(|motion| motion.kkt);
        match after {
            Some(after) if after.constraints().norm() < size => {
                let left = after.constraints().norm() / size;
                slow = if left < LESS { 0 } else { slow + 1 };
                (schedule, miss) = (next, after);
            }
            _ => {
                trust = LESS_TRUST * moved.amax();
                slow += 1;
            }
        }
        if slow > ITERATIONS || trust < NO_TRUST * schedule.duration {
            return None;
        }
    }
    None
}

/// Returns an orthonormal basis of the row space of a matrix `A`, and the right-hand side of `A p =
/// b` in this basis.
fn independent(matrix: DMatrixView<f64>, right: &DVector<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let svd = matrix.into_owned().svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let least = UNDETERMINED * svd.singular_values.max();
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|k| svd.singular_values[*k] > least).collect();
    let rows = v_t.select_rows(&kept);
    let along = u.tr_mul(right);
    let values = kept.iter().map(|k| along[*k] / svd.singular_values[*k]).collect();
    Some((rows, DVector::from_vec(values)))
}

/// Returns a positive definite matrix that agrees with `hessian` in the null space of `rows` where
/// the projected Hessian is positive.
fn convex(hessian: DMatrixView<f64>, rows: &DMatrix<f64>) -> DMatrix<f64> {
    let count = hessian.nrows();
    let along = DMatrix::identity(count, count) - rows.tr_mul(rows);
    let projected = &along * (hessian + hessian.transpose()) * &along * 0.5;
    let eigen = projected.symmetric_eigen();
    let floor = NOTHING * eigen.eigenvalues.amax().max(NOTHING);
    let mut weighted = eigen.eigenvectors.clone();
    for (index, value) in eigen.eigenvalues.iter().enumerate() {
        let value = value.abs().max(floor);
        weighted.column_mut(index).scale_mut(value);
    }
    weighted * eigen.eigenvectors.transpose()
}

/// Finds the optimal times near the times of a schedule; `None` if the terminal conditions cannot
/// be met near these times.
pub(crate) fn best_times(extremal: &Extremal, first: &Schedule, ask: &PulseRequest) -> Option<Best> {
    let mut schedule = met(extremal, first, ask, MOST_ITERATIONS)?;
    let start = Motion::of(extremal, &schedule, &Vector6::zeros(), COARSE)?.kkt;
    // At zero costates the slope of the Lagrangian is the gradient of the cost.
    let gradient = start.slope().into_owned();
    let costates = shortest(&start.by_multipliers().into_owned(), &-&gradient, UNDETERMINED)?;
    let mut costates = costates.fixed_rows::<6>(0).into_owned();
    let bounds = schedule.bounds(ask);
    let mut trust = TRUST * schedule.duration;
    let mut acting = vec![false; bounds.len() + 2 * schedule.times().len()];
    for _ in 0..MOST_STEPS {
        let cost = schedule.cost(extremal);
        let kkt = Motion::of(extremal, &schedule, &costates, COARSE)?.kkt;
        let (rows, right) = independent(kkt.by_unknowns(), &-kkt.constraints())?;
        let hessian = convex(kkt.hessian(), &rows);
        let times = schedule.times();
        let limits = bounds_of_step(&bounds, &times, trust);
        let program = Quadratic {
            hessian: &hessian,
            gradient: &gradient,
            equations: Some((&rows, &right)),
            bounds: &limits,
        };
        let Some(step) = program.solve(&acting) else { break };
        acting = step.acting;
        if let Some(next) = shortest(&kkt.by_multipliers().into_owned(), &-&step.pull, UNDETERMINED) {
            costates.copy_from(&next);
        }
        let predicted = -(gradient.dot(&step.p) + 0.5 * step.p.dot(&(&hessian * &step.p)));
        if predicted < NO_GAIN * cost {
            break;
        }
        let trial = met(extremal, &schedule.at(&(times + &step.p)), ask, ITERATIONS);
        let gained = trial.as_ref().map_or(f64::NEG_INFINITY, |trial| cost - trial.cost(extremal));
        if gained > GOOD * predicted {
            trust = (2.0 * trust).min(TRUST * schedule.duration);
        }
        match trial {
            Some(trial) if gained > PROMISED * predicted => schedule = trial,
            _ => trust = LESS_TRUST * step.p.amax().min(trust),
        }
        if trust < NO_TRUST * schedule.duration {
            break;
        }
    }
    let cost = schedule.cost(extremal);
    Some(Best { schedule, costates, cost })
}

/// Optimises the times of the pulses of arcs, without a minimum pulse width, and removes pulses
/// that have vanished. Returns `None` if the terminal conditions cannot be met near the initial
/// times.
pub(crate) fn best_arcs(extremal: &Extremal, arcs: &Arcs) -> Option<Arcs> {
    let ask = PulseRequest::free(extremal);
    let vanished = NOTHING * arcs.duration;
    let first = Schedule::kept(Schedule::of_arcs(arcs), arcs.duration, &ask)?;
    let mut best = best_times(extremal, &first, &ask)?;
    let mut kept = best.schedule.clone().joined(vanished);
    kept.pulses.retain(|pulse| pulse.length() > vanished);
    if kept.pulses.len() < best.schedule.pulses.len() {
        best = best_times(extremal, &kept, &ask)?;
    }
    // An input that is on from the start or to the end has no switch there.
    let (schedule, costates) = match settled(extremal, &best, &ask) {
        Some(settled) => (settled.schedule, settled.costates),
        None => (best.schedule, best.costates),
    };
    Some(Motion::of(extremal, &schedule, &costates, FINE)?.arcs)
}

/// A schedule whose times are exactly at the active bounds, with its bounds and a flag for each
/// that is active.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    pub schedule: Schedule,
    pub costates: Vector6<f64>,
    pub bounds: Vec<Bound>,
    pub acting: Vec<bool>,
}

/// Returns the bounds that are active, those whose flag in `acting` is true.
pub(super) fn acts<'a>(bounds: &'a [Bound], acting: &'a [bool]) -> impl Iterator<Item = &'a Bound> {
    bounds.iter().zip(acting).filter(|(_, acts)| **acts).map(|(bound, _)| bound)
}

/// Moves times that are near bounds exactly to these bounds. Newton then moves the other times
/// until the terminal conditions are met and the Lagrangian is stationary or, if that fails nearby,
/// until only the terminal conditions are met. Returns `None` if both fail.
pub(super) fn settled(extremal: &Extremal, best: &Best, ask: &PulseRequest) -> Option<Settled> {
    let bounds = best.schedule.bounds(ask);
    let times = best.schedule.times();
    let all = [NewtonSteps::Shortest, NewtonSteps::Feasible].into_iter();
    all.flat_map(|steps| NEAR.map(|near| (steps, near))).find_map(|(steps, near)| {
        let acting: Vec<bool> =
            bounds.iter().map(|bound| bound.slack(&times) < near * best.schedule.duration).collect();
        let ties = Ties::of(times.len(), acts(&bounds, &acting));
        let (schedule, costates) = newton(extremal, best, &ties, steps)?;
        let times = schedule.times();
        let kept = bounds.iter().all(|bound| bound.slack(&times) >= -KEPT * best.schedule.duration);
        kept.then(|| Settled { schedule, costates, bounds: bounds.clone(), acting })
    })
}

/// Solves by Newton for the costates and the free times; `None` if it does not converge near the
/// initial times.
fn newton(
    extremal: &Extremal,
    best: &Best,
    ties: &Ties,
    steps: NewtonSteps,
) -> Option<(Schedule, Vector6<f64>)> {
    let (matrix, first) = (ties.matrix(), ties.snapped(&best.schedule.times()));
    let (mut times, mut costates) = (first.clone(), best.costates);
    let mut last = f64::INFINITY;
    for _ in 0..NEAR_ITERATIONS {
        let schedule = best.schedule.at(&times);
        let kkt = Motion::of(extremal, &schedule, &costates, FINE)?.kkt.tied(&matrix);
        let size = kkt.merit(steps);
        if size < NO_LENGTH || size < MET && size >= 0.5 * last {
            let moved = (&times - &first).amax();
            return (moved < NEARBY * schedule.duration).then_some((schedule, costates));
        }
        last = size;
        let step = kkt.newton_step(steps, UNDETERMINED)?;
        costates += step.fixed_rows::<6>(0);
        times += &matrix * step.rows(6, matrix.ncols());
    }
    None
}
