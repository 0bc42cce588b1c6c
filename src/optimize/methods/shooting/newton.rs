//! Newton's method with Armijo line search on the costate `λ_{−1}`; the sensitivity Ψ of the
//! terminal error e to the costate is reused while it gives good steps.
//!
//! ```text
//! Ψ d = −e ,    |e(λ + c d)| ≤ (1 − 2αc) |e(λ)| ,   c = 1, ½, ¼, …
//! ```
//!
//! The terminal error contains a logarithm, so its derivative is `blockdiag(J_r⁻¹(e_R), I) Ψ`; but
//! `J_r(e_R) e_R = e_R`, so the direction does not need `J_r`. A sweep with sensitivities costs as
//! much as several sweeps without. A factor whose step reduced the error well is therefore used
//! again (a chord step), and the factor of a coarser grid may start a finer one.

use crate::lie;
use crate::maneuver::solution::Outcome;
use crate::numerics::factor::Factor;
use crate::optimize::discrete::step::StepError;
use crate::optimize::discrete::sweep::{BoundaryValueProblem, End, Node};
use crate::optimize::methods::ARMIJO;
use crate::optimize::methods::driver::Iteration;
use crate::optimize::methods::method::Swept;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Ratio of the new to the old error below which the factorised sensitivity of a step is used
/// again.
const KEEP_FACTOR: f64 = 0.05;
/// Shortest fraction of a Newton step that is tried before damped steps.
const SHORTEST: f64 = 1.0 / 16.0;
/// Damping parameters of the damped least-squares step, relative to the largest singular value of
/// the sensitivity: from nearly Newton steps to nearly gradient steps.
const DAMPING: [f64; 7] = [1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0];
/// Ratio of the new to the old error below which a damped step is accepted at once; otherwise all
/// damping parameters are tried and the best step is accepted.
const GOOD_STEP: f64 = 0.9;
/// Number of iterations in which the error must halve; otherwise the iteration has stalled.
const PATIENCE: usize = 16;
/// Fraction of the tolerance below which the iteration has converged; the rest is left for the
/// round-off of the witnesses.
const ACCEPT: f64 = 0.9;
/// Fraction of the tolerance to which the iteration continues while chord steps suffice.
const POLISH: f64 = 0.5;

/// State of the shooting iteration: the costate, its sweep and the sensitivity.
#[derive(Clone, Debug)]
pub(crate) struct Newton<'a, const N: usize> {
    bvp: &'a BoundaryValueProblem<'a, N>,
    tolerance: f64,
    /// Residual below which no further step is made.
    enough: f64,
    /// Costate `λ_{−1}`, scaled.
    pub costate: SVector<f64, N>,
    /// End of the sweep from the costate.
    pub end: End<N>,
    factor: Option<Factor<N>>,
    /// Sensitivity `Ψ₁₂` of the current iterate, if it was computed.
    psi: Option<SMatrix<f64, N, N>>,
    /// Norms of the terminal error at the last iterates, oldest first.
    recent: [f64; PATIENCE],
    /// Nodes of the current iterate and of the last trial, if nodes are kept.
    nodes: Option<[Vec<Node>; 2]>,
}

impl<'a, const N: usize> Newton<'a, N> {
    /// Starts at `costate`, with the factorised sensitivity of a coarser grid; with `None`, the
    /// first step computes the sensitivity.
    pub fn new(
        bvp: &'a BoundaryValueProblem<'a, N>,
        tolerance: f64,
        costate: SVector<f64, N>,
        factor: Option<Factor<N>>,
    ) -> Result<Self, StepError> {
        let end = match bvp.sweep(&costate) {
            // A stopped search keeps this iterate if it has no better one.
            Err(StepError::Stopped) if bvp.is_kept_after_stop() => bvp.undisturbed().sweep(&costate)?,
            swept => swept?,
        };
        Ok(Self::at(bvp, tolerance, costate, end, factor))
    }

    /// Keeps the nodes of all iterates except the first, which is seldom the last.
    pub fn keeping(self) -> Self {
        let nodes = Vec::with_capacity(self.bvp.dynamics.grid.steps() + 1);
        Self { nodes: Some([Vec::new(), nodes]), ..self }
    }

    /// Starts at `costate`, and computes the sensitivity `Ψ₁₂` of the terminal error to it.
    pub fn derived(
        bvp: &'a BoundaryValueProblem<'a, N>,
        tolerance: f64,
        costate: SVector<f64, N>,
    ) -> Result<Self, StepError> {
        let (end, psi) = match bvp.sweep_linearized(&costate) {
            Err(StepError::Stopped) => return Self::new(bvp, tolerance, costate, None),
            swept => swept?,
        };
        let factor = Some(Factor::new(&psi));
        Ok(Self { psi: Some(psi), ..Self::at(bvp, tolerance, costate, end, factor) })
    }

    /// Starts at `costate`, whose sweep is known to end at `end`.
    pub fn at(
        bvp: &'a BoundaryValueProblem<'a, N>,
        tolerance: f64,
        costate: SVector<f64, N>,
        end: End<N>,
        factor: Option<Factor<N>>,
    ) -> Self {
        let (tolerance, enough) = (ACCEPT * tolerance, POLISH * tolerance);
        let recent = [f64::INFINITY; PATIENCE];
        Self { bvp, tolerance, enough, costate, end, factor, psi: None, recent, nodes: None }
    }

    /// Returns the result of the sweep of the current iterate; `None` if its nodes were not kept.
    pub fn swept(self) -> Option<Swept> {
        let [nodes, _] = self.nodes?;
        let complete = nodes.len() == self.bvp.dynamics.grid.steps() + 1;
        let error = DVector::from_column_slice(self.end.error.as_slice());
        complete.then_some(Swept { nodes, error, cost: self.end.cost })
    }

    /// Returns the sensitivity `Ψ₁₂` of the terminal error to the costate at the current iterate.
    pub fn sensitivity(&self) -> Result<SMatrix<f64, N, N>, StepError> {
        match &self.psi {
            Some(psi) => Ok(*psi),
            None => self.bvp.sweep_linearized(&self.costate).map(|(_, psi)| psi),
        }
    }

    /// Sets the residual `enough` to which the iteration continues below the tolerance, as long as
    /// chord steps suffice.
    pub fn polished_to(self, enough: f64) -> Self {
        Self { enough, ..self }
    }

    fn refresh(&mut self) -> Result<(), StepError> {
        let (_, psi) = self.bvp.sweep_linearized(&self.costate)?;
        self.factor = Some(Factor::new(&psi));
        self.psi = Some(psi);
        Ok(())
    }

    /// Accepts the costate `trial` if it decreases the error enough for the given fraction of a
    /// Newton step; returns whether it was accepted.
    fn try_step(&mut self, trial: SVector<f64, N>, fraction: f64) -> bool {
        let norm = self.end.error.norm();
        // A failed sweep is treated like an error that does not decrease: the step is too long.
        let nodes = self.nodes.as_mut().map(|[_, nodes]| nodes);
        let Ok(end) = swept(self.bvp, &trial, nodes) else { return false };
        if end.error.norm() > (1.0 - 2.0 * ARMIJO * fraction) * norm {
            return false;
        }
        self.accept(trial, end);
        true
    }

    fn accept(&mut self, costate: SVector<f64, N>, end: End<N>) {
        // Under limits the next iterate may have other unsaturated inputs, and therefore another Ψ.
        if self.bvp.dynamics.is_limited() || end.error.norm() > KEEP_FACTOR * self.end.error.norm() {
            self.factor = None;
        }
        (self.costate, self.end, self.psi) = (costate, end, None);
        if let Some([nodes, trial]) = &mut self.nodes {
            std::mem::swap(nodes, trial);
        }
    }

    /// Makes a line search along the Newton direction of the current factor, down to the fraction
    /// `shortest` of the step. Returns whether a step was accepted.
    fn search(&mut self, shortest: f64) -> bool {
        let Some(factor) = &self.factor else { return false };
        let direction = -factor.solve(&self.end.error);
        let mut fraction = 1.0;
        while fraction >= shortest {
            if self.try_step(self.costate + direction * fraction, fraction) {
                return true;
            }
            fraction *= 0.5;
        }
        false
    }

    /// Tries damped least-squares (Levenberg–Marquardt) steps. If Ψ₁₂ is nearly singular, the
    /// Newton step is long and wrong, and these shorter steps still reduce the error. Returns
    /// whether a step was accepted.
    fn damped(&mut self) -> bool {
        let Some(psi) = &self.psi else { return false };
        let attitude = self.end.error.fixed_rows::<3>(N - 6).into_owned();
        let inverse = lie::right_jacobian_inverse(&attitude);
        let mut jacobian = DMatrix::from_fn(N, N, |row, column| psi[(row, column)]);
        let turned = inverse * psi.fixed_rows::<3>(N - 6);
        jacobian.rows_mut(N - 6, 3).copy_from(&turned);
        let Some(svd) = jacobian.try_svd(true, true, f64::EPSILON, 1000) else { return false };
        let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else { return false };
        let error = DVector::from_column_slice(self.end.error.as_slice());
        let along = u.tr_mul(&error);
        let largest = svd.singular_values.amax();
        let norm = self.end.error.norm();
        let mut best: Option<(SVector<f64, N>, End<N>)> = None;
        for damping in DAMPING {
            let squared = (damping * largest) * (damping * largest);
            let weights = svd.singular_values.map(|value| value / (value * value + squared));
            let direction = v_t.tr_mul(&along.component_mul(&weights));
            let trial = self.costate - SVector::<f64, N>::from_column_slice(direction.as_slice());
            let Ok(end) = self.bvp.sweep(&trial) else { continue };
            let reached = end.error.norm();
            if reached < best.as_ref().map_or(norm, |(_, end)| end.error.norm()) {
                best = Some((trial, end));
                if reached <= GOOD_STEP * norm {
                    break;
                }
            }
        }
        let Some((trial, end)) = best else { return false };
        // The last of several trials may not be the best.
        if let Some([_, nodes]) = &mut self.nodes {
            nodes.clear();
        }
        self.accept(trial, end);
        true
    }
}

impl<const N: usize> Iteration for Newton<'_, N> {
    /// Returns the largest of the errors of attitude, momentum, position and linear momentum.
    fn residual(&self) -> f64 {
        self.end.residual()
    }

    fn converged(&self) -> bool {
        self.residual() <= self.enough
    }

    fn advance(&mut self) -> Option<Outcome> {
        let converged = self.residual() <= self.tolerance;
        // An old factor gets one trial at full length, a new one the whole line search.
        let mut moved = self.factor.is_some() && self.psi.is_none() && self.search(1.0);
        if !moved {
            if self.psi.is_none()
                && let Err(error) = self.refresh()
            {
                return Some(if converged { Outcome::Converged } else { outcome_of(error) });
            }
            moved = if converged { self.search(1.0) } else { self.search(SHORTEST) || self.damped() };
        }
        let norm = self.end.error.norm();
        let stuck = norm > 0.5 * self.recent[0];
        self.recent.rotate_left(1);
        self.recent[PATIENCE - 1] = norm;
        if !moved || (stuck && !converged) {
            return Some(if converged { Outcome::Converged } else { Outcome::Stalled });
        }
        // Below the tolerance the iteration continues only with chord steps, which are cheap.
        let polishing = self.residual() <= self.tolerance && self.factor.is_some();
        let done = self.converged() || (converged && !polishing);
        done.then_some(Outcome::Converged)
    }
}

/// Sweeps from a costate, and stores all nodes if `nodes` is given.
fn swept<const N: usize>(
    bvp: &BoundaryValueProblem<N>,
    costate: &SVector<f64, N>,
    nodes: Option<&mut Vec<Node>>,
) -> Result<End<N>, StepError> {
    let Some(nodes) = nodes else { return bvp.sweep(costate) };
    nodes.clear();
    bvp.sweep_into(costate, nodes)
}

/// Returns the outcome for a failed sweep.
pub(crate) fn outcome_of(error: StepError) -> Outcome {
    match error {
        StepError::TooLong => Outcome::StepTooLong,
        StepError::NotFinite => Outcome::NotFinite,
        // The search determines whether this is an interrupt or the time limit.
        StepError::Stopped => Outcome::Interrupted,
    }
}
