//! Newton shooting on the coarse grid and on the requested one, and the transfer between them.

use crate::maneuver::solution::Rung;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::Attempt;
use crate::optimize::methods::shooting::Shooting;
use crate::optimize::methods::shooting::refine::{CoarseToFine, polish};
use crate::optimize::search::found::Found;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::pool::Pool;
use crate::optimize::search::starts;

/// Shoots by Newton's method on the coarse grid from one start. Returns the cost of the extremal
/// found, whether it is new or not; `None` if shooting does not converge.
pub fn shoot<const N: usize>(
    search: &Search<N>,
    pool: &mut Pool<N>,
    rung: Rung,
    start: Candidate,
) -> Option<f64> {
    let polish = polish(search.problem, search.coarse.dynamics.grid.steps());
    let shooting = Shooting::on_coarse_grid(&search.coarse, true, polish);
    let attempt = search.context.attempt(rung, &shooting, start);
    let cost = attempt.cost;
    attempt.converged().then(|| pool.add(attempt))?;
    Some(cost)
}

/// Shoots by Newton's method on the requested grid. Returns the cost of the extremal found; `None`
/// if shooting does not converge.
pub fn shoot_fine<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    rung: Rung,
    start: Candidate,
) -> Option<f64> {
    let shooting = Shooting::new(&search.fine, search.context.settings.tolerance);
    let attempt = search.context.attempt(rung, &shooting, start.on_grid(&search.fine.dynamics.grid));
    let cost = attempt.cost;
    found.keep(attempt).then_some(cost)
}

/// Transfers a coarse extremal to the requested grid, and keeps the result. Returns whether it
/// converged and satisfies `near`.
pub fn finish<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    coarse: Candidate,
    near: impl FnOnce(&Attempt) -> bool,
) -> bool {
    let (problem, tolerance) = (search.problem, search.context.settings.tolerance);
    let refinement = CoarseToFine { problem, fine: &search.fine, tolerance };
    let attempt = search.context.attempt(Rung::CoarseToFine, &refinement, coarse);
    let near = near(&attempt);
    found.keep(attempt) && near
}

/// Shoots by Newton's method on the requested grid from costates in the form of a solution (SI
/// units, `λ_0` for Lie–Euler, `λ_{−1}` for Lie–Verlet). Returns whether shooting converged.
pub fn shoot_from<const N: usize>(
    search: &Search<N>,
    found: &mut Found<N>,
    costates: &[f64],
    start: &str,
) -> bool {
    match starts::given(search.problem, &search.fine, costates) {
        Ok(costate) => {
            let guess = Candidate::of_costate(start, &search.fine.dynamics.grid, &costate);
            shoot_fine(search, found, Rung::Guess, guess).is_some()
        }
        Err(outcome) => {
            search.context.note(Rung::Guess, start, search.problem.steps, Report::failed(outcome));
            false
        }
    }
}
