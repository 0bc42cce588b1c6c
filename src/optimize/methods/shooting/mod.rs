//! Newton shooting on the costate `λ_{−1}`, and what carries an extremal from a coarse grid to a
//! fine one.

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

/// Most steps whose nodes are kept: half a kilobyte each.
const MOST_KEPT: usize = 4096;

/// Residual at which an intermediate grid counts as solved.
const GRID_TOLERANCE: f64 = 1e-6;

/// Newton on the first costate of a candidate; it leaves an extremal, or the nearest miss.
pub(crate) struct Shooting<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    tolerance: f64,
    /// Residual to which the iteration goes on as long as that is cheap.
    polish: Option<f64>,
    /// Whether `Ψ₁₂` is derived at the end.
    derive: bool,
    /// A factor of `Ψ₁₂` from elsewhere.
    factor: Option<Factor<N>>,
    /// Where the sweep of the candidate ends, if that is known.
    end: Option<End<N>>,
    /// Whether the nodes of the last sweep are kept, to be recorded.
    keep: bool,
}

impl<'a, const N: usize> Shooting<'a, N> {
    /// To the tolerance, on the requested grid.
    pub fn new(bvp: &'a BoundaryValueProblem<'a, N>, tolerance: f64) -> Self {
        let keep = bvp.dynamics.grid.steps() <= MOST_KEPT;
        Self { keep, ..Self::to(bvp, tolerance) }
    }

    fn to(bvp: &'a BoundaryValueProblem<'a, N>, tolerance: f64) -> Self {
        Self { bvp, tolerance, polish: None, derive: false, factor: None, end: None, keep: false }
    }

    /// On a grid that is not the requested one, to the residual `polish` where that is cheap.
    pub fn on_coarse_grid(bvp: &'a BoundaryValueProblem<'a, N>, derive: bool, polish: f64) -> Self {
        // The grids of the first-order scheme extrapolate too badly to deserve a polish.
        let polish = (bvp.dynamics.grid.has_half_kicks()).then_some(polish);
        Self { polish, derive, ..Self::to(bvp, GRID_TOLERANCE) }
    }

    /// With a factor from elsewhere for the first steps.
    pub fn with_factor(self, factor: Factor<N>) -> Self {
        Self { factor: Some(factor), ..self }
    }

    /// The same from a candidate whose sweep has been made.
    pub fn swept(self, end: Option<End<N>>) -> Self {
        Self { end, ..self }
    }

    /// The iteration at its start. Without a factor its first step takes `Ψ₁₂`: where the last
    /// takes it as well, one sweep gives both.
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

    /// Claim: the nodes that are kept are those of the iterate that is left, from near starts as
    /// from far ones, where trials fail and steps are damped.
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
