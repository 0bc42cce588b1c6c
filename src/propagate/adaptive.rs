//! An integration by a solver of the crate `differential-equations`, in internal steps ("parts")
//! that this module controls.

use differential_equations::interpolate::Interpolation;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use differential_equations::traits::State;

/// Smallest length of a part that is repeated because a number was not finite, relative to the
/// whole length.
const LEAST: f64 = 1e-12;

/// Integrates `change` from `start` over `length`, in at most `most` parts; returns `None` if the
/// solver fails. A part that produces a number that is not finite is repeated with a tenth of its
/// length, down to [`LEAST`]. `part` receives the length that the solver suggests for the next
/// part, and `rejected` is increased by the number of rejected parts.
pub(crate) fn integrate<Y, M>(
    solver: &mut M,
    change: &impl ODE<f64, Y>,
    length: f64,
    start: &Y,
    most: usize,
    part: &mut f64,
    rejected: &mut u64,
) -> Option<Y>
where
    Y: State<f64> + AsRef<[f64]>,
    M: OrdinaryNumericalMethod<f64, Y> + Interpolation<f64, Y>,
{
    solver.init(change, 0.0, length, start).ok()?;
    for _ in 0..most {
        let rest = length - solver.t();
        let last = solver.h() > 0.9999 * rest;
        if last {
            solver.set_h(rest);
        } else {
            *part = solver.h();
        }
        let tried = solver.h();
        solver.step(change).ok()?;
        // The crate's error norm ignores NaN and accepts a NaN state, so the last finite state is
        // restored.
        if !solver.y().as_ref().iter().all(|value| value.is_finite()) {
            let (before, y, shorter) = (solver.t_prev(), solver.y_prev().clone(), 0.1 * tried);
            if shorter < LEAST * length {
                return None;
            }
            solver.init(change, before, length, &y).ok()?;
            solver.set_h(shorter);
            *rejected += 1;
            continue;
        }
        if matches!(solver.status(), Status::RejectedStep) {
            *rejected += 1;
        } else if last {
            *part = solver.h().max(*part);
            return Some(solver.y().clone());
        }
    }
    None
}
