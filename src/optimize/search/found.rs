//! What a search knows so far: a value that every rung takes and gives.

use crate::maneuver::solution::{ConvexWork, Solution};
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::pool::{Pool, SAME};
use crate::optimize::search::starts::GUESS;

/// Costs of one optimum of a chain differ by less, relative.
pub(super) const SAME_COST: f64 = 1e-9;

/// What is known so far. A rung reads what the ones below it have left, and adds to it.
#[derive(Default)]
pub(super) struct Found<const N: usize> {
    /// What converged, each once.
    plans: Vec<Attempt>,
    /// The nearest miss.
    missed: Option<Attempt>,
    /// The plan of a guess that is one more start beside the search.
    pub aside: Vec<Attempt>,
    /// What was found of a coarse grid by the rungs without limits.
    pub pool: Pool<N>,
    /// What the convex subproblems of all seeds took.
    pub work: ConvexWork,
    /// The whole answer, where a rung has it: that of the maneuver without limits, which meets them all.
    pub answer: Option<Solution>,
    /// The answer as it is written, where a rung had to read it.
    pub told: Option<Solution>,
    /// The shortest duration that was found \[s\], where none was for the one asked for.
    pub shortest: Option<f64>,
}

impl<const N: usize> Found<N> {
    /// Keeps what converged, once, or else the nearest miss. Whether it converged.
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

    /// Adds what an attempt took.
    pub fn add_work(&mut self, attempt: &Attempt) {
        self.work.all_subproblems += attempt.work.all_subproblems;
        self.work.cone_iterations += attempt.work.cone_iterations;
        self.work.cone_seconds += attempt.work.cone_seconds;
    }

    /// Whether anything converged.
    pub fn is_done(&self) -> bool {
        !self.plans.is_empty()
    }

    /// All that converged: in the order in which it was found, or as it was ranked.
    pub fn plans(&self) -> &[Attempt] {
        &self.plans
    }

    /// The first of what converged: the winner, once that is ranked.
    pub fn best(&self) -> Option<&Attempt> {
        self.plans.first()
    }

    /// Puts what converged into an order, or leaves some of it out.
    pub fn reorder(&mut self, order: impl FnOnce(Vec<Attempt>) -> Vec<Attempt>) {
        self.plans = order(std::mem::take(&mut self.plans));
    }

    /// Takes what converged away.
    pub fn take_plans(&mut self) -> Vec<Attempt> {
        std::mem::take(&mut self.plans)
    }

    /// The nearest miss.
    pub fn missed(&self) -> Option<&Attempt> {
        self.missed.as_ref()
    }

    /// Takes the nearest miss away, so that another is told, or this one again.
    pub fn take_missed(&mut self) -> Option<Attempt> {
        self.missed.take()
    }

    /// Tells this miss in place of any other.
    pub fn tell_missed(&mut self, missed: Option<Attempt>) {
        self.missed = missed;
    }

    /// Whether a costate that was given has led to a plan: then nothing else is tried.
    pub fn is_guessed(&self) -> bool {
        self.best().is_some_and(|found| found.candidate.provenance.start == GUESS)
    }
}

/// The cheapest first.
pub(super) fn cheapest_first(mut plans: Vec<Attempt>) -> Vec<Attempt> {
    plans.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    plans
}

/// Whether two attempts ended at the same plan.
pub(super) fn same<const N: usize>(a: &Attempt, b: &Attempt) -> bool {
    if b.candidate.provenance.method.is_on_equal_steps() {
        return (a.cost - b.cost).abs() <= SAME_COST * b.cost.abs().max(1e-12);
    }
    let (a, b) = (a.candidate.costate::<N>(), b.candidate.costate::<N>());
    (a - b).amax() < SAME * a.amax().max(1.0)
}
