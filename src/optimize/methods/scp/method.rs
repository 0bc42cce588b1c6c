//! SCP as an implementation of `Method`: from the path of a candidate, and from its inputs if it
//! has them, to an optimum within all limits.

use super::tuning::{DEARER, LAST_BARRIER, VIOLATED};
use super::{Convex, ScpOptions, largest_defect, run};
use crate::maneuver::settings;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{ConvexWork, Outcome, Rung};
use crate::optimize::chain::{Chain, with_iterate};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::interior_point::chain::ChainProgram;
use crate::optimize::methods::interior_point::chain::conditions::Conditions;
use crate::optimize::methods::interior_point::method::InteriorPoint;
use crate::optimize::methods::interior_point::program::{Point, Program};
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::{Attempt, Budget, Method, Run, Watch};

/// The convex iteration, followed by a refinement with the interior-point method.
pub(crate) struct ConvexIteration<'a> {
    pub chain: &'a Chain,
    pub options: &'a ScpOptions,
}

impl Method for ConvexIteration<'_> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let Chain { model, rows } = self.chain;
        let start = self.chain.iterate(&candidate, &budget.watch);
        let program = ChainProgram::of(model, rows, None, &start, &Tuning::default());
        let mut point = Point::of(program.shape());
        program.point(&start, &mut point);
        let found = match run(&program, point, self.options, &budget.watch) {
            Some(convex) => attempt(self.chain, &program, candidate, convex),
            None => Attempt { runs: Vec::new(), ..Attempt::failed(candidate, Outcome::Stalled) },
        };
        if self.options.polish && found.converged() { self.polished(found, budget) } else { found }
    }
}

impl ConvexIteration<'_> {
    /// Refines a point to which the convex iteration has converged. A result with a higher cost is
    /// a different optimum and is rejected.
    fn polished(&self, found: Attempt, budget: &Budget) -> Attempt {
        let ended =
            |tuning: &Tuning| InteriorPoint::of(self.chain, tuning).improve(found.candidate.clone(), budget);
        let mut next = ended(&Tuning { last: LAST_BARRIER, ..Tuning::near() });
        if !next.converged() {
            next = ended(&Tuning::near());
        }
        let report = next.runs.pop().map(|run| Run { rung: Some(Rung::Polish), ..run });
        let runs = found.runs.into_iter().chain(report).collect();
        if !next.converged() || next.cost > found.cost * (1.0 + DEARER) {
            let stopped = (budget.watch.interrupt)().unwrap_or(Outcome::Stalled);
            let outcome = if next.converged() { Outcome::Stalled } else { stopped };
            return Attempt { runs, work: found.work, ..Attempt::failed(found.candidate, outcome) };
        }
        next.candidate.provenance.method = settings::Method::Scp;
        Attempt { runs, work: found.work, ..next }
    }
}

/// Converts the result of the convex iteration to an attempt.
fn attempt(chain: &Chain, program: &ChainProgram, candidate: Candidate, convex: Convex) -> Attempt {
    let Convex { outcome, point, duals, values, subproblems, residuals, .. } = convex;
    let converged = outcome == Outcome::Converged;
    let defect = largest_defect(&values);
    let shortfall = (!converged).then(|| Shortfall::Violated {
        cut_short_after: (outcome == Outcome::IterationLimit).then_some(subproblems),
        violations: program.noticed(&values, VIOLATED),
        reaches_end: defect <= VIOLATED,
    });
    let residual = program.violations(&values).into_iter().fold(defect, f64::max);
    let report = Report { outcome, iterations: subproblems, residuals };
    let runs = vec![Run { rung: None, steps: candidate.steps(), report }];
    let (iterate, multipliers) = program.found(&point, &duals, &values.rows);
    let cost = if converged { iterate.cost(&chain.model) } else { f64::NAN };
    let conditions = || Conditions::of(chain, &iterate, &multipliers, &Watch::NONE);
    let stationarity = converged.then(conditions).flatten().map_or(f64::NAN, |at| at.stationarity());
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
