//! Newton–Armijo on the costate `λ_{−1}`, with a sensitivity that is kept while it serves.
//!
//! ```text
//! Ψ d = −e ,    |e(λ + c d)| ≤ (1 − 2αc) |e(λ)| ,   c = 1, ½, ¼, …
//! ```
//!
//! The terminal error holds a logarithm, so its derivative is `blockdiag(J_r⁻¹(e_R), I) Ψ`; but
//! `J_r(e_R) e_R = e_R`, and the direction needs no `J_r`. A sweep with sensitivities costs several
//! without: a factor whose step shrank the error well is used again (a chord step), and a coarser
//! grid's factor may start a finer one.

use super::driver::Iteration;
use super::factor::Factor;
use crate::dynamics::StepError;
use crate::extremal::{End, Extremal};
use crate::solution::Outcome;
use nalgebra::SVector;

/// Sufficient decrease of the line search.
const ARMIJO: f64 = 1e-4;
/// A step that shrinks the error to less than this fraction keeps its factor.
const KEEP_FACTOR: f64 = 0.1;
/// Shortest fraction of a Newton step that is tried.
const SHORTEST: f64 = 1.0 / 4096.0;
/// Below the tolerance the iteration goes on to this fraction of it, as long as that is cheap.
const POLISH: f64 = 0.5;

/// The iterate of a shooting.
#[derive(Clone, Debug)]
pub(crate) struct Newton<'a, const N: usize> {
    extremal: &'a Extremal<N>,
    tolerance: f64,
    /// Residual at which no further step is worth its sweep.
    enough: f64,
    /// `λ_{−1}`, scaled.
    pub costate: SVector<f64, N>,
    /// Where its sweep ended.
    pub end: End<N>,
    factor: Option<Factor<N>>,
    /// Whether the factor is that of the present iterate.
    exact: bool,
}

impl<'a, const N: usize> Newton<'a, N> {
    /// Starts at `costate`, with a factor from elsewhere if there is one.
    pub fn new(
        extremal: &'a Extremal<N>,
        tolerance: f64,
        costate: SVector<f64, N>,
        factor: Option<Factor<N>>,
    ) -> Result<Self, StepError> {
        let end = extremal.sweep(&costate)?;
        let enough = POLISH * tolerance;
        Ok(Self { extremal, tolerance, enough, costate, end, factor, exact: false })
    }

    /// The same, polished to `enough` as long as every step with the factor at hand gains a digit.
    pub fn polished_to(self, enough: f64) -> Self {
        Self { enough, ..self }
    }

    fn refresh(&mut self) -> Result<(), StepError> {
        let (_, psi) = self.extremal.sweep_linearized(&self.costate)?;
        self.factor = Some(Factor::new(&psi));
        self.exact = true;
        Ok(())
    }

    /// Tries the direction of the present factor; whether it led anywhere.
    fn search(&mut self, shortest: f64) -> bool {
        let Some(factor) = &self.factor else { return false };
        let direction = -factor.solve(&self.end.error);
        let norm = self.end.error.norm();
        let mut fraction = 1.0;
        while fraction >= shortest {
            let trial = self.costate + direction * fraction;
            // A sweep that fails is a step too long, like an error that does not fall.
            if let Ok(end) = self.extremal.sweep(&trial)
                && end.error.norm() <= (1.0 - 2.0 * ARMIJO * fraction) * norm
            {
                let kept = end.error.norm() <= KEEP_FACTOR * norm;
                (self.costate, self.end, self.exact) = (trial, end, false);
                if !kept {
                    self.factor = None;
                }
                return true;
            }
            fraction *= 0.5;
        }
        false
    }
}

impl<const N: usize> Iteration for Newton<'_, N> {
    fn residual(&self) -> f64 {
        self.end.error.amax()
    }

    fn converged(&self) -> bool {
        self.residual() <= self.enough
    }

    fn advance(&mut self) -> Option<Outcome> {
        let converged = self.residual() <= self.tolerance;
        // An old factor gets one try at full length, a fresh one the whole line search.
        let mut moved = self.factor.is_some() && !self.exact && self.search(1.0);
        if !moved && !converged {
            if !self.exact
                && let Err(error) = self.refresh()
            {
                return Some(outcome_of(error));
            }
            moved = self.search(SHORTEST);
        }
        if !moved {
            return Some(if converged { Outcome::Converged } else { Outcome::Stalled });
        }
        // Below the tolerance only cheap steps go on: those whose factor was worth keeping.
        let polishing = self.residual() <= self.tolerance && self.factor.is_some();
        let done = self.converged() || (converged && !polishing);
        done.then_some(Outcome::Converged)
    }
}

/// The outcome that a broken sweep stands for.
pub(crate) fn outcome_of(error: StepError) -> Outcome {
    match error {
        StepError::TooLong => Outcome::StepTooLong,
        StepError::NotFinite => Outcome::NotFinite,
    }
}
