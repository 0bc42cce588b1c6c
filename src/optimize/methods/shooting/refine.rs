//! Coarse to fine: an extremal found on few steps is carried to the requested grid.
//!
//! `λ_{−1}` and `Ψ₁₂` of the discrete optimum have an expansion in `h` (Lie–Euler) or `h²`
//! (Lie–Verlet). Solved on two or three coarse grids and extrapolated, they meet the fine grid so
//! closely that a few plain sweeps with the extrapolated factor finish it: the fine grid sees no
//! sensitivities at all.
//!
//! # Why coarse to fine over five grids?
//!
//! λ₋₁ of the discrete optimum has an expansion in `h²` (in `h` for Lie–Euler). Solved on coarse
//! grids of 2, 3, 4, 6 and 8 units and extrapolated to `h`, it is almost the solution on the
//! requested grid, and so is Ψ₁₂. Sweeps with sensitivities are made on the two coarsest grids, and
//! on a third where these have few steps; as a rule on no other: the fine grid gets plain sweeps
//! with an extrapolated factor. The nodes of the last one are what is recorded, up to some thousand
//! steps. The first grid has as many steps as the fastest moment of the turn needs. From rest to
//! rest less will do: one way begins on as few as eight steps, and the best one, whose descents are
//! half of what a plan of a hundred steps takes, on as few as twelve. The minima are the same
//! there, and what their costs are wrong by is far below the margin that carries them on: some
//! percent, which a rival that is not carried on is told with. Lie–Euler's would be off by more,
//! and below 64 steps the search is on finer grids. A coarse grid is visited only if the requested
//! one has at least three times as many steps, and Lie–Euler stops after two grids because
//! first-order terms fall too slowly for more to pay.

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

/// Residual from which one chord step with an extrapolated factor reaches the polish unseen.
const PREDICTED: f64 = 1e-7;
/// The coarse grids, in units of half the coarsest: errors fall as the product of all `h^p`.
const GRIDS: [usize; 5] = [2, 3, 4, 6, 8];
/// Bounds of the residual to which a coarse grid is polished: what its extremals may differ by and
/// be told apart, and round-off.
const GRID_POLISH: [f64; 2] = [1e-13, 1e-9];
/// Sensitivities are derived until what their extrapolation misses, the product of all their `h^p`,
/// is below this: a chord step on the requested grid then gains more digits than the prediction
/// lacks.
const TELLING: f64 = 1e-5;
/// How many times the product of all `h^p` the extrapolation of the extremals misses, at least.
const MISSED: f64 = 100.0;
/// A coarse grid is worth solving while it has this many times fewer steps than the requested one.
const WORTH: usize = 3;

/// Carries an extremal from a coarse grid, with its `Ψ₁₂`, to the requested one.
pub(crate) struct CoarseToFine<'a, const N: usize> {
    pub problem: &'a Problem,
    /// On the requested grid.
    pub fine: &'a BoundaryValueProblem<'a, N>,
    pub tolerance: f64,
}

/// Steps of the coarse grids of a problem, from the coarsest on.
fn coarse_grids(problem: &Problem, coarsest: usize) -> impl Iterator<Item = usize> {
    // First-order errors fall too slowly for the later grids to pay.
    let useful = if problem.scheme == Scheme::LieEuler { 2 } else { GRIDS.len() };
    let finer = GRIDS[1..useful].iter().map(move |multiple| multiple * (coarsest / 2));
    let most = problem.steps / WORTH;
    [coarsest].into_iter().chain(finer.take_while(move |steps| *steps <= most))
}

/// Residual to which the coarse grids of a problem are polished: extrapolation passes on what is
/// left, and misses more by itself.
pub(crate) fn polish(problem: &Problem, coarsest: usize) -> f64 {
    let missed = MISSED * product(problem, coarse_grids(problem, coarsest));
    missed.clamp(GRID_POLISH[0], GRID_POLISH[1])
}

/// The product of `h^p` over some grids.
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
            // The extrapolation may leave the solvable region where the last grid's costate does
            // not.
            let nearest = grids[grids.len() - 1].clone().on_grid(&fine.dynamics.grid);
            last = Shooting::new(fine, tolerance).improve(nearest, budget);
        }
        runs.append(&mut last.runs);
        Attempt { runs, ..last }
    }
}

/// One chord step from where the sweep of a prediction ends: the next residual is round-off and not
/// looked at.
fn corrected<const N: usize>(predicted: Candidate, end: &End<N>, factor: &Factor<N>) -> Attempt {
    let costate = predicted.costate() - factor.solve(&end.error);
    let (outcome, residuals) = (Outcome::Converged, vec![end.error.amax()]);
    Attempt::of(predicted.with_costate(&costate), Report { outcome, iterations: 1, residuals })
}

/// The extremal and the factor of `Ψ₁₂` that coarser grids predict on `steps` steps.
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

/// Weights of the Lagrange interpolation in `h^p` through the grids, evaluated at `grid`.
fn weights(grids: &[Candidate], grid: &Grid) -> Vec<f64> {
    let abscissa = |grid: &Grid| (1.0 / grid.steps() as f64).powi(grid.scheme().order() as i32);
    let at = abscissa(grid);
    let weight = |i: usize| -> f64 {
        let others = (0..grids.len()).filter(|j| *j != i).map(|j| abscissa(&grids[j].grid));
        others.map(|other| (at - other) / (abscissa(&grids[i].grid) - other)).product()
    };
    (0..grids.len()).map(weight).collect()
}
