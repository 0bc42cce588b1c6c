//! Newton shooting on the initial costate `λ_{−1}`, and the transfer of an extremal from a coarse
//! grid to a fine one. `Ψ₁₂` is the sensitivity of the terminal error to `λ_{−1}`.

pub(crate) mod newton;
pub(crate) mod refine;

use super::driver::run;
use super::method::{Attempt, Budget, Method};
use crate::maneuver::solution::Outcome;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, End};
use nalgebra::{DMatrix, SVector};
use newton::{Newton, outcome_of};

/// Largest number of steps of a grid for which nodes are kept; a node takes half a kilobyte.
const MOST_KEPT: usize = 4096;

/// Residual below which an intermediate grid counts as solved.
const GRID_TOLERANCE: f64 = 1e-6;

/// Newton shooting on the initial costate of a candidate. It returns an extremal, or the iterate
/// with the smallest terminal error.
pub(crate) struct Shooting<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    tolerance: f64,
    /// Residual to which the iteration continues below the tolerance, as long as chord steps
    /// suffice; `None` for the default, a fixed fraction of the tolerance.
    polish: Option<f64>,
    /// True if the sensitivity `Ψ₁₂` of the terminal error to the initial costate is computed at
    /// the end.
    derive: bool,
    /// Factorised sensitivity `Ψ₁₂` of a coarser grid for the first steps; `None` if not available.
    factor: Option<Factor<N>>,
    /// End of the sweep from the candidate's costate; `None` if it has not been computed yet.
    end: Option<End<N>>,
    /// True if the nodes of the last sweep are returned with the attempt.
    keep: bool,
}

impl<'a, const N: usize> Shooting<'a, N> {
    /// Creates a shooting method that converges to `tolerance` on the requested grid.
    pub fn new(bvp: &'a BoundaryValueProblem<'a, N>, tolerance: f64) -> Self {
        let keep = bvp.dynamics.grid.steps() <= MOST_KEPT;
        Self { keep, ..Self::to(bvp, tolerance) }
    }

    fn to(bvp: &'a BoundaryValueProblem<'a, N>, tolerance: f64) -> Self {
        Self { bvp, tolerance, polish: None, derive: false, factor: None, end: None, keep: false }
    }

    /// Creates a shooting method on a coarse grid. It continues to the residual `polish` as long as
    /// chord steps suffice. If `derive`, it computes the sensitivity `Ψ₁₂` at the end.
    pub fn on_coarse_grid(bvp: &'a BoundaryValueProblem<'a, N>, derive: bool, polish: f64) -> Self {
        // The solutions of first-order grids extrapolate too inaccurately to be worth a polish.
        let polish = (bvp.dynamics.grid.has_half_kicks()).then_some(polish);
        Self { polish, derive, ..Self::to(bvp, GRID_TOLERANCE) }
    }

    /// Uses the factorised sensitivity of a coarser grid for the first steps.
    pub fn with_factor(self, factor: Factor<N>) -> Self {
        Self { factor: Some(factor), ..self }
    }

    /// Uses `end`, the end of the sweep from the candidate's costate, so that the sweep is not
    /// repeated.
    pub fn swept(self, end: Option<End<N>>) -> Self {
        Self { end, ..self }
    }

    /// Starts the iteration. Without a factor, the first step needs `Ψ₁₂`; if it is also needed at
    /// the end, one sweep computes both.
    fn begun(&self, costate: SVector<f64, N>) -> Result<Newton<'a, N>, StepError> {
        match (self.end, &self.factor) {
            (Some(end), factor) => Ok(Newton::at(self.bvp, self.tolerance, costate, end, factor.clone())),
            (None, None) if self.derive => Newton::derived(self.bvp, self.tolerance, costate),
            (None, factor) => Newton::new(self.bvp, self.tolerance, costate, factor.clone()),
        }
    }
}

impl<const N: usize> Method for Shooting<'_, N> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let newton = match self.begun(candidate.costate()) {
            Ok(newton) => newton,
            Err(error) => return Attempt::failed(candidate, outcome_of(error)),
        };
        let newton = if self.keep { newton.keeping() } else { newton };
        let newton = match self.polish {
            Some(enough) => newton.polished_to(enough),
            None => newton,
        };
        let (newton, mut report) = run(newton, budget.iterations, budget.watch.interrupt);
        let mut candidate = candidate.with_costate(&newton.costate);
        if self.derive && report.outcome == Outcome::Converged {
            match newton.sensitivity() {
                Ok(psi) => {
                    candidate.sensitivity = Some(DMatrix::from_column_slice(N, N, psi.as_slice()));
                }
                Err(error) => report.outcome = outcome_of(error),
            }
        }
        let (cost, residual) = (newton.end.cost, newton.end.residual());
        Attempt { cost, residual, swept: newton.swept(), ..Attempt::of(candidate, report) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maneuver::problem::{Problem, State};
    use crate::mechanics::body::Body;
    use crate::optimize::discrete::sweep::Node;
    use crate::optimize::methods::method::Watch;
    use crate::testing::{Random, full_inertia};
    use crate::{Matrix3, lie};

    /// Claim: the kept nodes are those of the final iterate, for near and for far initial guesses,
    /// where trials fail and steps are damped.
    #[test]
    fn kept_nodes_are_those_of_the_last_iterate() {
        let mut random = Random(5);
        let (mut converged, mut without) = (0, 0);
        for case in 0..40 {
            let body = Body { inertia: full_inertia(), mass: None };
            let (start, turn) = (State::at_rest(Matrix3::identity()), random.vector3());
            let problem = Problem::attitude(body, start, State::at_rest(lie::exp(&turn)), 1.0).with_steps(30);
            let bvp = BoundaryValueProblem::<6>::new(&problem, 30);
            let size = if case % 2 == 0 { 1.0 } else { 60.0 };
            let far = SVector::<f64, 6>::from_fn(|_, _| size * random.uniform());
            let candidate = Candidate::of_costate("far", &bvp.dynamics.grid, &far);
            let budget = Budget { iterations: 1 + case / 2, watch: Watch::NONE };
            let attempt = Shooting::new(&bvp, 1e-12).improve(candidate, &budget);
            converged += usize::from(attempt.converged());
            let Some(swept) = attempt.swept else {
                without += 1;
                continue;
            };
            let mut nodes: Vec<Node> = Vec::new();
            let end = bvp.sweep_observed(&attempt.candidate.costate::<6>(), |node| nodes.push(node)).unwrap();
            assert_eq!((swept.error.as_slice(), swept.cost), (end.error.as_slice(), end.cost));
            assert_eq!(swept.nodes.len(), 31);
            for (kept, node) in swept.nodes.iter().zip(&nodes) {
                assert_eq!((kept.index, kept.point, kept.costate), (node.index, node.point, node.costate));
            }
        }
        assert!(converged > 10 && without < 25, "{converged} converged, {without} without nodes");
    }
}
