//! Coarse to fine: an extremal on few steps is transferred to the requested grid.
//!
//! `λ_{−1}` and `Ψ₁₂` of the discrete optimum have an expansion in `h` (Lie–Euler) or `h²`
//! (Lie–Verlet). Solved on two or three coarse grids and extrapolated, they approximate the fine
//! grid so closely that a few sweeps without sensitivities, with the extrapolated factor, finish
//! the solution. The fine grid needs no sensitivities.
//!
//! # Why coarse to fine over five grids?
//!
//! λ₋₁ of the discrete optimum has an expansion in `h²` (in `h` for Lie–Euler). Solved on coarse
//! grids of 2, 3, 4, 6 and 8 units and extrapolated to `h`, it is almost the solution on the
//! requested grid, and so is Ψ₁₂. Sweeps with sensitivities are made on the two coarsest grids, and
//! on a third if these have few steps; usually on no other. The fine grid gets sweeps without
//! sensitivities, with an extrapolated factor. The nodes of the last one are recorded, for up to
//! some thousand steps.
//!
//! The first grid has as many steps as the fastest part of the turn needs. From rest to rest fewer
//! are enough: a search in one homotopy class begins on as few as eight steps. A search for the
//! best path, whose descents take half of the time of a plan with a hundred steps, begins on as few
//! as twelve. The minima are the same there, and the error of their costs, some percent, is far
//! below the margin within which minima are refined; a rival that is not refined is reported with
//! this error. The error of Lie–Euler would be larger, and below 64 steps its search is on finer
//! grids. A coarse grid is visited only if the requested one has at least three times as many
//! steps, and Lie–Euler stops after two grids because first-order terms decrease too slowly for
//! more to pay.

use super::Shooting;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::{Problem, Scheme};
use crate::maneuver::solution::Outcome;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, End};
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method};
use nalgebra::{SMatrix, SVector};

/// Residual below which one chord step with an extrapolated factor reaches the polish; its result
/// is not checked.
const PREDICTED: f64 = 1e-7;
/// Numbers of steps of the coarse grids, in units of half the number of the coarsest grid. The
/// error of the extrapolation is proportional to the product of `h^p` over the grids, with the step
/// length `h` and the order `p` of the scheme.
const GRIDS: [usize; 5] = [2, 3, 4, 6, 8];
/// Bounds of the residual to which a coarse grid is polished: round-off, and a value at which its
/// extremals can still be distinguished.
const GRID_POLISH: [f64; 2] = [1e-13, 1e-9];
/// Product of `h^p` (step length, order of the scheme) over the grids with sensitivities, below
/// which no further sensitivities are computed. It measures the error of their extrapolation: below
/// this value a chord step on the requested grid gains more digits than the prediction lacks.
const TELLING: f64 = 1e-5;
/// Smallest estimate of the error of the extrapolated extremals, as a multiple of the product of
/// `h^p` over all coarse grids, with the step length `h` and the order `p` of the scheme.
const MISSED: f64 = 100.0;
/// Smallest ratio of the requested number of steps to that of a coarse grid at which the coarse
/// grid is worth solving.
const WORTH: usize = 3;

/// Transfers an extremal from a coarse grid, with its `Ψ₁₂`, to the requested grid.
pub(crate) struct CoarseToFine<'a, const N: usize> {
    pub problem: &'a Problem,
    /// Boundary value problem on the requested grid.
    pub fine: &'a BoundaryValueProblem<'a, N>,
    pub tolerance: f64,
}

/// Returns the numbers of steps of the coarse grids of a problem, from the coarsest one.
fn coarse_grids(problem: &Problem, coarsest: usize) -> impl Iterator<Item = usize> {
    // First-order errors decrease too slowly for the later grids to pay.
    let useful = if problem.scheme == Scheme::LieEuler { 2 } else { GRIDS.len() };
    let finer = GRIDS[1..useful].iter().map(move |multiple| multiple * (coarsest / 2));
    let most = problem.steps / WORTH;
    [coarsest].into_iter().chain(finer.take_while(move |steps| *steps <= most))
}

/// Returns the residual to which the coarse grids of a problem are polished. The extrapolation
/// transfers the residual and adds a larger error.
pub(crate) fn polish(problem: &Problem, coarsest: usize) -> f64 {
    let missed = MISSED * product(problem, coarse_grids(problem, coarsest));
    missed.clamp(GRID_POLISH[0], GRID_POLISH[1])
}

/// Returns the product of `h^p` over the grids with these numbers of steps, where `h` is one over
/// the number of steps and `p` the order of the scheme.
fn product(problem: &Problem, steps: impl Iterator<Item = usize>) -> f64 {
    let order = problem.scheme.order() as i32;
    steps.map(|steps| (steps as f64).powi(-order)).product()
}

impl<const N: usize> Method for CoarseToFine<'_, N> {
    fn improve(&self, coarse: Candidate, budget: &Budget) -> Attempt {
        let Self { problem, fine, tolerance } = *self;
        let coarsest = coarse.steps();
        let polish = polish(problem, coarsest);
        let mut grids = vec![coarse];
        let mut runs = Vec::new();
        for steps in coarse_grids(problem, coarsest).skip(1) {
            let bvp = fine.on_steps(steps);
            let (predicted, factor) = extrapolate(&grids, &bvp.dynamics.grid);
            let derived = grids.iter().filter(|grid| grid.sensitivity.is_some()).map(Candidate::steps);
            let derive = grids.len() < 2 || product(problem, derived) > TELLING;
            let swept = if derive { None } else { bvp.sweep(&predicted.costate()).ok() };
            let attempt = match swept {
                Some(end) if end.error.amax() <= PREDICTED => corrected(predicted, &end, &factor),
                _ => {
                    let shooting = Shooting::on_coarse_grid(&bvp, derive, polish);
                    shooting.with_factor(factor).swept(swept).improve(predicted, budget)
                }
            };
            let converged = attempt.converged();
            runs.extend(attempt.runs);
            if !converged {
                break;
            }
            grids.push(attempt.candidate);
        }
        let (predicted, factor) = extrapolate::<N>(&grids, &fine.dynamics.grid);
        let mut last = Shooting::new(fine, tolerance).with_factor(factor).improve(predicted, budget);
        if !last.began() {
            // The extrapolation may leave the region in which Newton converges, although the last
            // grid's costate is within it.
            let nearest = grids[grids.len() - 1].clone().on_grid(&fine.dynamics.grid);
            last = Shooting::new(fine, tolerance).improve(nearest, budget);
        }
        runs.append(&mut last.runs);
        Attempt { runs, ..last }
    }
}

/// Makes one chord step from the end of the sweep of a prediction; the new residual is near
/// round-off and is not computed.
fn corrected<const N: usize>(predicted: Candidate, end: &End<N>, factor: &Factor<N>) -> Attempt {
    let costate = predicted.costate() - factor.solve(&end.error);
    let (outcome, residuals) = (Outcome::Converged, vec![end.error.amax()]);
    Attempt::of(predicted.with_costate(&costate), Report { outcome, iterations: 1, residuals })
}

/// Extrapolates the extremal and the factor of `Ψ₁₂` from coarser grids to `grid`.
fn extrapolate<const N: usize>(grids: &[Candidate], grid: &Grid) -> (Candidate, Factor<N>) {
    let with_psi = grids.iter().filter(|grid| grid.sensitivity.is_some()).count();
    let (mut costate, mut psi) = (SVector::<f64, N>::zeros(), SMatrix::<f64, N, N>::zeros());
    for (known, weight) in grids.iter().zip(weights(grids, grid)) {
        costate += known.costate::<N>() * weight;
    }
    for (known, weight) in grids.iter().zip(weights(&grids[..with_psi], grid)) {
        psi += known.sensitivity::<N>().unwrap_or_else(SMatrix::zeros) * weight;
    }
    (grids[0].clone().on_grid(grid).with_costate(&costate), Factor::new(&psi))
}

/// Returns the weight of each grid in the Lagrange interpolation in `h^p`, evaluated at `grid`,
/// with the step length `h` and the order `p` of the scheme.
fn weights(grids: &[Candidate], grid: &Grid) -> Vec<f64> {
    let abscissa = |grid: &Grid| (1.0 / grid.steps() as f64).powi(grid.scheme().order() as i32);
    let at = abscissa(grid);
    let weight = |i: usize| -> f64 {
        let others = (0..grids.len()).filter(|j| *j != i).map(|j| abscissa(&grids[j].grid));
        others.map(|other| (at - other) / (abscissa(&grids[i].grid) - other)).product()
    };
    (0..grids.len()).map(weight).collect()
}
