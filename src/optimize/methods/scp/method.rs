//! SCP as a method: from the path of a candidate, and its inputs and multipliers where it has them,
//! to an optimum within all limits.

use super::tuning::VIOLATED;
use super::{Convex, ScpOptions, run};
use crate::maneuver::shortfall::{Excess, Shortfall, Violation};
use crate::maneuver::solution::{ConvexWork, Outcome, Rung};
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::chain::{Chain, multipliers, with_iterate};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method, Run};

/// The convex iteration, then Newton on the active set.
pub(crate) struct ConvexIteration<'a> {
    pub chain: &'a Chain,
    pub options: &'a ScpOptions,
}

impl Method for ConvexIteration<'_> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let Chain { model, rows } = self.chain;
        let multipliers = (!candidate.costates.is_empty()).then(|| multipliers(&candidate));
        let start = self.chain.iterate(&candidate, &budget.watch);
        let found = run(model, rows, start, multipliers, self.options, &budget.watch);
        attempt(self.chain, candidate, found)
    }
}

/// What an iteration made of a candidate; without runs where it could not be evaluated at all.
fn attempt(chain: &Chain, candidate: Candidate, convex: Option<Convex>) -> Attempt {
    let Some(convex) = convex else {
        return Attempt { runs: Vec::new(), ..Attempt::failed(candidate, Outcome::Stalled) };
    };
    let shortfall = convex.polished.is_none().then(|| violated(&convex, &chain.rows));
    let (steps, residual) = (candidate.steps(), convex.miss());
    let Convex { subproblems, residuals, .. } = convex;
    let last = residuals.last().copied().unwrap_or(f64::NAN);
    let report = Report { outcome: convex.outcome, iterations: subproblems, residuals };
    let mut runs = vec![Run { rung: None, steps, report }];
    let (outcome, cost, stationarity, iterate, multipliers) = match convex.polished {
        Some(polished) => {
            if polished.iterations > 0 {
                let residuals = vec![last, polished.residual];
                let (outcome, iterations) = (Outcome::Converged, polished.iterations);
                let report = Report { outcome, iterations, residuals };
                runs.push(Run { rung: Some(Rung::Polish), steps, report });
            }
            let (cost, residual) = (polished.cost, polished.residual);
            (Outcome::Converged, cost, residual, polished.iterate, polished.multipliers)
        }
        None => {
            let settled = convex.outcome == Outcome::Converged;
            let outcome = if settled { Outcome::Stalled } else { convex.outcome };
            (outcome, f64::NAN, f64::NAN, convex.iterate, convex.multipliers)
        }
    };
    let work = ConvexWork {
        subproblems,
        all_subproblems: subproblems,
        cone_iterations: convex.cone_iterations,
        cone_seconds: convex.cone_seconds,
    };
    let candidate = with_iterate(candidate, iterate, multipliers);
    let ended = Attempt::failed(candidate, outcome);
    Attempt { cost, residual, stationarity, runs, work, shortfall, ..ended }
}

/// What stays violated at the last iterate.
fn violated(convex: &Convex, rows: &LimitRows) -> Shortfall {
    let cut_short_after = (convex.outcome == Outcome::IterationLimit).then_some(convex.subproblems);
    let noticed = rows.groups.iter().zip(&convex.violations).filter(|(_, violation)| **violation > VIOLATED);
    // Cones are violated by an angle, limits by a share of themselves.
    let excess = |is_angle: bool| if is_angle { Excess::Angle } else { Excess::Share };
    let violations = noticed.map(|(group, violation)| Violation {
        name: group.name.clone(),
        excess: excess(group.is_angle)(*violation),
    });
    let defect = convex.residuals.last().copied().unwrap_or(f64::NAN);
    Shortfall::Violated { cut_short_after, violations: violations.collect(), reaches_end: defect <= VIOLATED }
}
