//! Coarse to fine: an extremal found on few steps is carried to the requested grid.
//!
//! `λ_{−1}` and `Ψ₁₂` of the discrete optimum have an expansion in `h` (Lie–Euler) or `h²` (Lie–Verlet).
//! Solved on two or three coarse grids and extrapolated, they meet the fine grid so closely that a few
//! plain sweeps with the extrapolated factor finish it: the fine grid sees no sensitivities at all.

use super::driver::{Interrupt, Report, run};
use super::factor::Factor;
use super::newton::{Newton, outcome_of};
use crate::extremal::Extremal;
use crate::problem::{Problem, Scheme};
use crate::settings::Settings;
use crate::solution::Outcome;
use nalgebra::{SMatrix, SVector};

/// Residual on the intermediate grids: far below what extrapolation can use.
const GRID_TOLERANCE: f64 = 1e-10;

/// An extremal on one grid.
#[derive(Clone, Debug)]
pub(crate) struct GridPoint<const N: usize> {
    pub steps: usize,
    pub costate: SVector<f64, N>,
    pub psi: SMatrix<f64, N, N>,
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

/// Solves on one grid from `costate`, then adds `Ψ₁₂` there.
pub(crate) fn solve_grid<const N: usize>(
    extremal: &Extremal<N>,
    costate: SVector<f64, N>,
    factor: Option<Factor<N>>,
    settings: &Settings,
    interrupt: Interrupt,
) -> (Option<GridPoint<N>>, Report) {
    let steps = extremal.dynamics.steps;
    let newton = match Newton::new(extremal, GRID_TOLERANCE, costate, factor) {
        Ok(newton) => newton,
        Err(error) => return (None, failed(outcome_of(error))),
    };
    let (newton, mut report) = run(newton, settings.max_iterations, interrupt);
    if report.outcome != Outcome::Converged {
        return (None, report);
    }
    match extremal.sweep_linearized(&newton.costate) {
        Ok((_, psi)) => (Some(GridPoint { steps, costate: newton.costate, psi }), report),
        Err(error) => {
            report.outcome = outcome_of(error);
            (None, report)
        }
    }
}

/// Carries an extremal from a coarse grid to the problem's own.
pub(crate) fn refine<const N: usize>(
    problem: &Problem,
    fine: &Extremal<N>,
    coarse: GridPoint<N>,
    settings: &Settings,
    interrupt: Interrupt,
) -> Refined<N> {
    let mut grids = vec![coarse];
    let mut reports = Vec::new();
    // A further grid pays while it is well below the requested one.
    while grids.len() < 3 && 4 * grids[grids.len() - 1].steps < problem.steps {
        let steps = 2 * grids[grids.len() - 1].steps;
        let extremal = Extremal::new(problem, steps);
        let (costate, psi) = extrapolate(problem.scheme, &grids, steps);
        let (grid, report) =
            solve_grid(&extremal, costate, Some(Factor::new(&psi)), settings, interrupt);
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

/// Lagrange interpolation in `h^p` through the grids, evaluated at `steps`.
fn extrapolate<const N: usize>(
    scheme: Scheme,
    grids: &[GridPoint<N>],
    steps: usize,
) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let abscissa = |steps: usize| (1.0 / steps as f64).powi(scheme.order() as i32);
    let at = abscissa(steps);
    let (mut costate, mut psi) = (SVector::zeros(), SMatrix::zeros());
    for (i, grid) in grids.iter().enumerate() {
        let mut weight = 1.0;
        for (j, other) in grids.iter().enumerate() {
            if i != j {
                weight *= (at - abscissa(other.steps)) / (abscissa(grid.steps) - abscissa(other.steps));
            }
        }
        costate += grid.costate * weight;
        psi += grid.psi * weight;
    }
    (costate, psi)
}
