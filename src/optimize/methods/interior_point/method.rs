//! The interior point as a method: from the path of a candidate, and its inputs where it has them, to an optimum within all limits.

use super::chain::ChainProgram;
use super::iteration::{End, Run, Solver};
use super::program::Program;
use super::tuning::Tuning;
use crate::Vector3;
use crate::maneuver::settings;
use crate::maneuver::shortfall::{Excess, Shortfall, Violation};
use crate::maneuver::solution::Outcome;
use crate::mechanics::environment::Pose;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method, Watch};
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::methods::scp::first_iterate;
use crate::optimize::methods::scp::iterate::Iterate;
use crate::optimize::methods::scp::polish::{Told, polish};
use crate::optimize::methods::scp::road::{Chain, with_iterate};
use crate::optimize::methods::scp::rows::LimitRows;

/// Violations above this, relative or in radians, and misses of the end are told: what an elastic row gives way by is the barrier term
/// over its price elsewhere.
const VIOLATED: f64 = 1e-8;
/// Newton on the active set may change the cost by this part: more is another optimum.
const NEAR: f64 = 1e-6;
/// Part of the inputs that a path asks for with which the iteration begins: between what the path needs and the middle of its limits.
const CENTRED: f64 = 0.5;
/// Rounds in which the first duration is fitted to a path whose ends move, and where they end.
const FITTED: usize = 3;
const CLOSE: f64 = 0.05;

/// The interior point on a chain.
pub(crate) struct InteriorPoint<'a> {
    pub chain: &'a Chain,
    pub tuning: &'a Tuning,
    /// How Newton on the active set ends the digits, where it may: of a cost that bends along all that its rows leave.
    pub polish: Option<&'a ScpOptions>,
}

impl Method for InteriorPoint<'_> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let Chain { model, rows } = self.chain;
        let start = self.start(&candidate, &budget.watch);
        let unsolved =
            |candidate, outcome| Attempt { runs: Vec::new(), ..Attempt::failed(candidate, outcome) };
        let Some(program) = ChainProgram::of(model, rows, &start) else {
            return unsolved(candidate, Outcome::Stalled);
        };
        let mut solver = Solver::of(program.shape());
        program.point(&start, &mut solver.point);
        let run = solver.run(&program, self.tuning, &budget.watch);
        if !run.dual.is_finite() {
            let stopped = (budget.watch.interrupt)().filter(|_| run.end == End::Stopped);
            return unsolved(candidate, stopped.unwrap_or(Outcome::Stalled));
        }
        let (mut iterate, mut multipliers) = program.found(&solver.point, &solver.duals);
        let (excess, tuning) = (run.violation.max(run.miss), self.tuning);
        let kept = excess <= VIOLATED.max(tuning.tolerance);
        let outcome = match run.end {
            End::Converged if kept => Outcome::Converged,
            End::Converged | End::Stalled => Outcome::Stalled,
            End::NotFinite => Outcome::NotFinite,
            End::Iterations => Outcome::IterationLimit,
            End::Stopped => (budget.watch.interrupt)().unwrap_or(Outcome::Interrupted),
        };
        let shortfall = (outcome != Outcome::Converged).then(|| self.lacking(&iterate, &run));
        let mut residual = run.primal.max(excess);
        let mut stationarity = run.dual.max(run.primal).max(run.complementarity);
        let residuals = vec![f64::NAN, run.dual.max(residual)];
        let mut cost = if outcome == Outcome::Converged { iterate.cost(model) } else { f64::NAN };
        let polished = self.polish.filter(|_| outcome == Outcome::Converged).and_then(|options| {
            polish(model, rows, &iterate, &multipliers, options, Told::Roughly, &budget.watch)
        });
        if let Some(polished) = polished.filter(|polished| (polished.cost - cost).abs() <= NEAR * cost.abs())
        {
            (iterate, multipliers, cost) = (polished.iterate, polished.multipliers, polished.cost);
            (residual, stationarity) = (polished.residual, polished.residual);
        }
        let mut candidate = with_iterate(candidate, iterate, multipliers);
        candidate.provenance.method = settings::Method::InteriorPoint;
        let report = Report { outcome, iterations: run.iterations, residuals };
        let attempt = Attempt::of(candidate, report);
        Attempt { cost, residual, stationarity, shortfall, ..attempt }
    }
}

impl InteriorPoint<'_> {
    /// The iterate of a candidate: as it is, or the first one along its path, in a duration in which that is within the limits.
    fn start(&self, candidate: &Candidate, watch: &Watch) -> Iterate {
        let Chain { model, rows } = self.chain;
        let sought = candidate.inputs.is_empty() && model.duration.is_some();
        let stretch = sought.then(|| self.fitting(candidate, watch)).flatten();
        let mut start = match stretch {
            Some(stretch) => {
                let poses: Vec<Pose> = candidate.states.iter().map(Point::pose).collect();
                first_iterate::along(model, rows, &poses, stretch, watch)
            }
            None => self.chain.iterate(candidate, watch),
        };
        if candidate.inputs.is_empty() {
            start.inputs.iter_mut().flatten().for_each(|u| *u *= CENTRED);
        }
        start
    }

    /// The duration, as a multiple of the stated one, that the path of a candidate asks for.
    fn fitting(&self, candidate: &Candidate, watch: &Watch) -> Option<f64> {
        let Chain { model, rows } = self.chain;
        let poses: Vec<Pose> = candidate.states.iter().map(Point::pose).collect();
        let mut stretch = candidate.grid.duration();
        for _ in 0..FITTED {
            let along = first_iterate::along(model, &LimitRows::default(), &poses, stretch, watch);
            let program = ChainProgram::of(model, rows, &along)?;
            let mut point = super::program::Point::of(program.shape());
            program.point(&along, &mut point);
            let next = program.fitting(&point)?;
            let settled = (next / stretch - 1.0).abs() < CLOSE;
            stretch = next;
            if settled || model.is_free() && model.start.momentum == Vector3::zeros() {
                break;
            }
        }
        Some(stretch)
    }

    /// What stays violated, by name.
    fn lacking(&self, iterate: &Iterate, run: &Run) -> Shortfall {
        let Chain { model, rows } = self.chain;
        let worst = iterate.evaluate(model, rows, Watch::NONE).map(|at| at.violations());
        let worst = worst.unwrap_or_else(|_| vec![0.0; rows.groups.len()]);
        let noticed = rows.groups.iter().zip(&worst).filter(|(_, violation)| **violation > VIOLATED);
        let violations = noticed.map(|(group, violation)| Violation {
            name: group.name.clone(),
            excess: if group.is_angle { Excess::Angle(*violation) } else { Excess::Share(*violation) },
        });
        Shortfall::Violated {
            cut_short_after: (run.end == End::Iterations).then_some(run.iterations),
            violations: violations.collect(),
            reaches_end: run.primal.max(run.miss) <= VIOLATED,
        }
    }
}
