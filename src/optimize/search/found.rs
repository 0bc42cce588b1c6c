//! State of a search: its results so far, which every strategy reads and extends.

use crate::maneuver::solution::{ConvexWork, Solution};
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::pool::{Pool, SAME};
use crate::optimize::search::starts::GUESS;

/// Relative cost difference below which two results of the interior-point method or SCP are the
/// same optimum.
pub(super) const SAME_COST: f64 = 1e-9;

/// Results so far. A strategy reads the results of earlier ones, and adds its own.
#[derive(Default)]
pub(super) struct Found<const N: usize> {
    /// Attempts that converged, without duplicates.
    plans: Vec<Attempt>,
    /// The attempt with the smallest residual among those that did not converge.
    missed: Option<Attempt>,
    /// Plans found from a guess that is used in addition to the search.
    pub aside: Vec<Attempt>,
    /// Coarse-grid results of the strategies without limits.
    pub pool: Pool<N>,
    /// Work spent on convex subproblems, summed over all initial paths.
    pub work: ConvexWork,
    /// The complete solution, if a strategy has one: the solution of the maneuver without limits
    /// that satisfies all limits.
    pub answer: Option<Solution>,
    /// The solution in its reported form, if a strategy had to compute it.
    pub told: Option<Solution>,
    /// Shortest duration for which a plan was found \[s\], if none was found for the requested
    /// duration.
    pub shortest: Option<f64>,
}

impl<const N: usize> Found<N> {
    /// Keeps an attempt that converged, unless it is a duplicate; otherwise keeps it if its
    /// residual is the smallest so far. Returns whether it converged.
    pub fn keep(&mut self, attempt: Attempt) -> bool {
        self.add_work(&attempt);
        let converged = attempt.converged();
        if converged {
            if !self.plans.iter().any(|other| same::<N>(other, &attempt)) {
                self.plans.push(attempt);
            }
        } else if attempt.began()
            && self.missed.as_ref().is_none_or(|missed| attempt.residual < missed.residual)
        {
            self.missed = Some(attempt);
        }
        converged
    }

    /// Adds the work of an attempt on convex subproblems.
    pub fn add_work(&mut self, attempt: &Attempt) {
        self.work.all_subproblems += attempt.work.all_subproblems;
        self.work.cone_iterations += attempt.work.cone_iterations;
        self.work.cone_seconds += attempt.work.cone_seconds;
    }

    /// Returns whether any attempt converged.
    pub fn is_done(&self) -> bool {
        !self.plans.is_empty()
    }

    /// Returns the attempts that converged, in the order in which they were found or ranked.
    pub fn plans(&self) -> &[Attempt] {
        &self.plans
    }

    /// Returns the first of the attempts that converged; after ranking this is the best.
    pub fn best(&self) -> Option<&Attempt> {
        self.plans.first()
    }

    /// Reorders the attempts that converged, or removes some.
    pub fn reorder(&mut self, order: impl FnOnce(Vec<Attempt>) -> Vec<Attempt>) {
        self.plans = order(std::mem::take(&mut self.plans));
    }

    /// Removes and returns the attempts that converged.
    pub fn take_plans(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.plans)
    }

    /// Returns the attempt with the smallest residual that did not converge.
    pub fn missed(&self) -> Option<&Attempt> {
        self.missed.as_ref()
    }

    /// Removes and returns the attempt with the smallest residual that did not converge, so that
    /// the caller can replace it.
    pub fn take_missed(&mut self) -> Option<Attempt> {
        self.missed.take()
    }

    /// Replaces the attempt that is reported if no plan converged.
    pub fn tell_missed(&mut self, missed: Option<Attempt>) {
        self.missed = missed;
    }

    /// Returns whether a given costate led to a plan. If so, no other strategy is tried.
    pub fn is_guessed(&self) -> bool {
        self.best().is_some_and(|found| found.candidate.provenance.start == GUESS)
    }
}

/// Sorts attempts by cost, the cheapest first.
pub(super) fn cheapest_first(mut plans: Vec<Attempt>) -> Vec<Attempt> {
    plans.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    plans
}

/// Returns whether two attempts ended at the same plan.
pub(super) fn same<const N: usize>(a: &Attempt, b: &Attempt) -> bool {
    if b.candidate.provenance.method.is_on_equal_steps() {
        return (a.cost - b.cost).abs() <= SAME_COST * b.cost.abs().max(1e-12);
    }
    let (a, b) = (a.candidate.costate::<N>(), b.candidate.costate::<N>());
    (a - b).amax() < SAME * a.amax().max(1.0)
}
