//! Bang-bang extremals, followed from one terminal state of a maneuver to others.
//!
//! The terminal state depends on the roll and, for a moving target, on the arrival time. A complete
//! search for one terminal state finds all extremals. Newton on the arcs of each leads to nearby
//! terminal states.

use super::{Extremals, Scaled};
use crate::Vector3;
use crate::maneuver::problem::{Path, Problem};
use crate::optimize::methods::switching::limit::BranchEnd;
use crate::optimize::methods::switching::work::Work;
use crate::optimize::search::context::Context;
use crate::optimize::search::halt::Halt;
use std::iter::once;

/// An extremal of a maneuver to one terminal state.
#[derive(Clone)]
pub(in crate::optimize::search) struct Followed {
    limit: BranchEnd,
    /// Cost in continuous time, in the unit of the objective.
    pub cost: f64,
    /// Duration of the extremal \[s\].
    pub duration: f64,
    /// Costates of attitude (body axes) and momentum at the end, in cost per radian and per N·m·s.
    pub costates: [Vector3; 2],
}

impl Followed {
    /// Returns the extremals in the requested homotopy class, the cheapest first, whose cost
    /// exceeds that of the cheapest by at most the fraction `close`.
    ///
    /// # Errors
    /// The solution of the search, if a stop was requested. Without extremals the result is empty.
    pub fn all(problem: &Problem, context: &Context, close: f64) -> Result<Vec<Self>, Halt> {
        let extremals = match Extremals::of(problem, context, true) {
            Ok(extremals) => extremals,
            Err(_) if context.interrupt().is_none() => return Ok(Vec::new()),
            Err(ended) => return Err(Halt::Stopped(ended)),
        };
        context.ladder.take();
        let goes = |limit: &&BranchEnd| problem.path == Path::Best || extremals.planned(limit).is_some();
        let goes = extremals.allowed().filter(goes);
        let mut found = goes.map(|limit| Self::of(limit.clone(), &extremals.of));
        let Some(best) = found.next() else { return Ok(Vec::new()) };
        let dearest = best.cost * (1.0 + close);
        Ok(once(best).chain(found.take_while(|next| next.cost <= dearest)).collect())
    }

    /// Returns the extremal to another terminal state, found from this one; `None` if Newton's
    /// method does not converge.
    pub fn led(&self, problem: &Problem, context: &Context) -> Option<Self> {
        let of = Scaled::of(problem, context)?;
        let limit = context.within(|budget| self.limit.led(&of.extremal, &Work::of(budget.watch)))?;
        Some(Self::of(limit, &of))
    }

    fn of(limit: BranchEnd, Scaled { extremal, units, .. }: &Scaled) -> Self {
        let [turn, momentum] = limit.costates_at_end(extremal);
        Self {
            cost: limit.cost(extremal) * units.cost(),
            duration: limit.duration() * units.time,
            costates: [turn * units.cost(), momentum * (units.cost() / units.momentum())],
            limit,
        }
    }
}
