//! Coarse to fine: an extremal found on few steps is carried to the requested grid.
//!
//! `λ_{−1}` and `Ψ₁₂` of the discrete optimum have an expansion in `h` (Lie–Euler) or `h²` (Lie–Verlet).
//! Solved on two or three coarse grids and extrapolated, they meet the fine grid so closely that a few
//! plain sweeps with the extrapolated factor finish it: the fine grid sees no sensitivities at all.

use super::newton::{Newton, outcome_of};
use crate::maneuver::problem::{Problem, Scheme};
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::Outcome;
use crate::numerics::factor::Factor;
use crate::optimize::methods::driver::{Interrupt, Report, run};
use crate::optimize::sweep::BoundaryValueProblem;
use nalgebra::{SMatrix, SVector};

/// Residual at which an intermediate grid counts as solved.
const GRID_TOLERANCE: f64 = 1e-6;
/// Residual to which it is polished where that is cheap: extrapolation passes on what is left.
const GRID_POLISH: f64 = 1e-13;
/// Residual from which one chord step with an extrapolated factor reaches the polish unseen.
const PREDICTED: f64 = 1e-7;
/// The coarse grids, in units of half the coarsest: errors fall as the product of all `h^p`.
const GRIDS: [usize; 5] = [2, 3, 4, 6, 8];
/// A coarse grid is worth solving while it has this many times fewer steps than the requested one.
const WORTH: usize = 3;

/// An extremal on one grid.
#[derive(Clone, Debug)]
pub(crate) struct GridPoint<const N: usize> {
    pub steps: usize,
    pub costate: SVector<f64, N>,
    /// `Ψ₁₂`; the finest of the coarse grids goes without: the others extrapolate it well enough.
    pub psi: Option<SMatrix<f64, N, N>>,
}

/// What a refinement ended with.
#[derive(Clone, Debug)]
pub(crate) struct Refined<const N: usize> {
    pub costate: SVector<f64, N>,
    pub residual: f64,
    pub cost: f64,
    pub outcome: Outcome,
    /// Every grid's run.
    pub reports: Vec<(usize, Report)>,
}

/// Solves on one grid from `costate`, then adds `Ψ₁₂` there if wanted.
pub(crate) fn solve_grid<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: SVector<f64, N>,
    factor: Option<Factor<N>>,
    derive: bool,
    settings: &Settings,
    interrupt: Interrupt,
) -> (Option<GridPoint<N>>, Report) {
    let newton = match Newton::new(bvp, GRID_TOLERANCE, costate, factor) {
        // The grids of the first-order scheme extrapolate too badly to deserve a polish.
        Ok(newton) if bvp.dynamics.grid.scheme() == Scheme::LieEuler => newton,
        Ok(newton) => newton.polished_to(GRID_POLISH),
        Err(error) => return (None, failed(outcome_of(error))),
    };
    let (newton, mut report) = run(newton, settings.max_iterations, interrupt);
    if report.outcome != Outcome::Converged {
        return (None, report);
    }
    let steps = bvp.dynamics.grid.steps();
    if !derive {
        return (Some(GridPoint { steps, costate: newton.costate, psi: None }), report);
    }
    match bvp.sweep_linearized(&newton.costate) {
        Ok((_, psi)) => (Some(GridPoint { steps, costate: newton.costate, psi: Some(psi) }), report),
        Err(error) => {
            report.outcome = outcome_of(error);
            (None, report)
        }
    }
}

/// One chord step on a grid that coarser ones have predicted: the next residual is round-off and not
/// looked at. `None` where the prediction is not that good.
fn correct<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
    factor: &Factor<N>,
) -> Option<(Option<GridPoint<N>>, Report)> {
    let end = bvp.sweep(costate).ok()?;
    let residual = end.error.amax();
    if residual > PREDICTED {
        return None;
    }
    let costate = costate - factor.solve(&end.error);
    let report = Report { outcome: Outcome::Converged, iterations: 1, residuals: vec![residual] };
    Some((Some(GridPoint { steps: bvp.dynamics.grid.steps(), costate, psi: None }), report))
}

/// Carries an extremal from a coarse grid to the problem's own.
pub(crate) fn refine<const N: usize>(
    problem: &Problem,
    fine: &BoundaryValueProblem<N>,
    coarse: GridPoint<N>,
    settings: &Settings,
    interrupt: Interrupt,
) -> Refined<N> {
    let mut grids = vec![coarse];
    let mut reports = Vec::new();
    // First-order errors fall too slowly for the later grids to pay.
    let useful = if problem.scheme == Scheme::LieEuler { 2 } else { GRIDS.len() };
    let half = grids[0].steps / 2;
    for multiple in &GRIDS[1..useful] {
        let steps = multiple * half;
        if WORTH * steps > problem.steps {
            break;
        }
        let bvp = BoundaryValueProblem::new(problem, steps);
        let (costate, psi) = extrapolate(problem.scheme, &grids, steps);
        let factor = Factor::new(&psi);
        // Two sensitivities extrapolate well enough for all finer grids.
        let derive = grids.len() < 2;
        let corrected = if derive { None } else { correct(&bvp, &costate, &factor) };
        let (grid, report) =
            corrected.unwrap_or_else(|| solve_grid(&bvp, costate, Some(factor), derive, settings, interrupt));
        reports.push((steps, report));
        let Some(grid) = grid else { break };
        grids.push(grid);
    }
    let (costate, psi) = extrapolate(problem.scheme, &grids, problem.steps);
    let newton = Newton::new(fine, settings.tolerance, costate, Some(Factor::new(&psi))).or_else(|_| {
        // The extrapolation may leave the solvable region where the last grid's costate does not.
        Newton::new(fine, settings.tolerance, grids[grids.len() - 1].costate, None)
    });
    let newton = match newton {
        Ok(newton) => newton,
        Err(error) => {
            let outcome = outcome_of(error);
            reports.push((problem.steps, failed(outcome)));
            return Refined { costate, residual: f64::INFINITY, cost: f64::INFINITY, outcome, reports };
        }
    };
    let (newton, report) = run(newton, settings.max_iterations, interrupt);
    let outcome = report.outcome;
    reports.push((problem.steps, report));
    let (residual, cost) = (newton.end.error.amax(), newton.end.cost);
    Refined { costate: newton.costate, residual, cost, outcome, reports }
}

/// A run that could not begin.
pub(crate) fn failed(outcome: Outcome) -> Report {
    Report { outcome, iterations: 0, residuals: Vec::new() }
}

/// `λ_{−1}` and `Ψ₁₂` extrapolated to `steps` steps.
fn extrapolate<const N: usize>(
    scheme: Scheme,
    grids: &[GridPoint<N>],
    steps: usize,
) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let with_psi = grids.iter().filter(|grid| grid.psi.is_some()).count();
    let (mut costate, mut psi) = (SVector::zeros(), SMatrix::zeros());
    for (grid, weight) in grids.iter().zip(weights(scheme, grids, steps)) {
        costate += grid.costate * weight;
    }
    for (grid, weight) in grids.iter().zip(weights(scheme, &grids[..with_psi], steps)) {
        psi += grid.psi.unwrap_or_else(SMatrix::zeros) * weight;
    }
    (costate, psi)
}

/// Weights of the Lagrange interpolation in `h^p` through the grids, evaluated at `steps`.
fn weights<const N: usize>(scheme: Scheme, grids: &[GridPoint<N>], steps: usize) -> Vec<f64> {
    let abscissa = |steps: usize| (1.0 / steps as f64).powi(scheme.order() as i32);
    let at = abscissa(steps);
    let weight = |i: usize| -> f64 {
        let others = (0..grids.len()).filter(|j| *j != i).map(|j| abscissa(grids[j].steps));
        others.map(|other| (at - other) / (abscissa(grids[i].steps) - other)).product()
    };
    (0..grids.len()).map(weight).collect()
}
