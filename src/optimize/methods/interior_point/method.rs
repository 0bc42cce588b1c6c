//! The interior-point method as an implementation of `Method`: it improves a candidate, starting
//! from the path and, if present, the inputs of the candidate, it finds an optimum within all
//! limits.

use super::chain::ChainProgram;
use super::chain::family::Family;
use super::chain::warm::Warm;
use super::iteration::{End, Run, Solver};
use super::program::{Point, Program, Values};
use super::tuning::Tuning;
use crate::maneuver::problem::Problem;
use crate::maneuver::settings;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::Outcome;
use crate::mechanics::environment::Pose;
use crate::numerics::hermite::hermite;
use crate::optimize::chain::Multipliers;
use crate::optimize::chain::first_iterate;
use crate::optimize::chain::iterate::Iterate;
use crate::optimize::chain::model::Goal;
use crate::optimize::chain::rows::LimitRows;
use crate::optimize::chain::{Chain, path, with_iterate};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point as Node;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::method::{Attempt, Budget, Method, Watch};
use crate::{Vector3, lie};
use nalgebra::DVector;

/// The interior-point method on a chain.
pub(crate) struct InteriorPoint<'a> {
    pub chain: &'a Chain,
    pub tuning: &'a Tuning,
    /// Family of possible ends; `None` if the end is that of the chain.
    pub family: Option<&'a Family>,
    /// Warm start from a solve of nearly the same maneuver; `None` for a cold start.
    pub warm: Option<&'a Warm>,
    /// Known optima of the chain: a run that converges to one of them ends early.
    pub known: &'a [Attempt],
}

impl<'a> InteriorPoint<'a> {
    /// Builds the method for the end of a chain, without a warm start and without known optima.
    pub fn of(chain: &'a Chain, tuning: &'a Tuning) -> Self {
        Self { chain, tuning, family: None, warm: None, known: &[] }
    }
}

impl Method for InteriorPoint<'_> {
    fn improve(&self, candidate: Candidate, budget: &Budget) -> Attempt {
        let Chain { model, rows } = self.chain;
        let start = self.start(&candidate, &budget.watch);
        let unsolved =
            |candidate, outcome| Attempt { runs: Vec::new(), ..Attempt::failed(candidate, outcome) };
        let mut program = ChainProgram::of(model, rows, self.family, &start, self.tuning);
        if let Some(nothing) = self.costs_nothing(&program, &candidate, &start) {
            return nothing;
        }
        program.known = self.known;
        let mut solver = Solver::of(program.shape());
        program.point(&start, &mut solver.point);
        let most = self.tuning.for_each.saturating_mul(budget.iterations);
        let resumes =
            self.warm.is_some_and(|warm| program.resume(warm, &mut solver.point, &mut solver.duals));
        let mut run = self.run(&program, &mut solver, (most, resumes), &budget.watch);
        if let End::Known(known) = run.end {
            // The run converged to a known optimum.
            let Attempt { runs, .. } = Attempt::of(
                candidate,
                Report {
                    outcome: Outcome::Converged,
                    iterations: run.iterations,
                    residuals: vec![f64::NAN, run.dual],
                },
            );
            return Attempt { runs, work: Default::default(), ..self.known[known].clone() };
        }
        if !run.dual.is_finite() {
            let stopped = (budget.watch.interrupt)().filter(|_| run.end == End::Stopped);
            return unsolved(candidate, stopped.unwrap_or(Outcome::Stalled));
        }
        let found = |solver: &Solver| program.found(&solver.point, &solver.duals, &solver.at.values.rows);
        let (mut iterate, mut multipliers) = found(&solver);
        // If the motion is unstable, the simulation of the inputs from the start misses the end by
        // amplified round-off.
        for _ in 0..self.tuning.replays {
            // The end of a family is not an end of the chain.
            let Some(replayed) = iterate.replayed(model).ok().filter(|_| self.family.is_none()) else {
                break;
            };
            let missed = replayed.states.last().map_or(0.0, |last| model.terminal_error(last).amax());
            if run.end != End::Converged || missed <= self.tuning.round_off {
                break;
            }
            program.point(&replayed, &mut solver.point);
            let mut again = Run { end: End::Stalled, ..run };
            solver.correct(&program, self.tuning, run.barrier, &mut again, &budget.watch);
            if again.end != End::Converged {
                break;
            }
            run = again;
            (iterate, multipliers) = found(&solver);
        }
        let (excess, tuning) = (run.violation.max(run.miss), self.tuning);
        let kept = excess <= tuning.violated.max(tuning.tolerance);
        let outcome = match run.end {
            End::Converged if kept => Outcome::Converged,
            End::Converged | End::Stalled | End::Known(_) => Outcome::Stalled,
            End::NotFinite => Outcome::NotFinite,
            // The method's own iteration limit was reached before the user's: it counts as stalled.
            End::Iterations if most >= tuning.iterations => Outcome::Stalled,
            End::Iterations => Outcome::IterationLimit,
            End::Stopped => (budget.watch.interrupt)().unwrap_or(Outcome::Interrupted),
        };
        let shortfall =
            (outcome != Outcome::Converged).then(|| self.lacking(&program, &solver.at.values, &run, outcome));
        let residual = run.primal.max(excess);
        // Without rows the complementarity products belong to the terminal equations, which are
        // satisfied.
        let complementarity = if program.shape().rows() == 0 { 0.0 } else { run.complementarity };
        let stationarity = run.dual.max(run.primal).max(complementarity);
        let residuals = vec![f64::NAN, run.dual.max(residual)];
        let pairs = program.shape().rows() + 2 * program.shape().terminal;
        let warm = Some(Box::new(program.left(&solver.point, &solver.duals)));
        let scaled = solver.at.values.cost.abs();
        let least = scaled.max(f64::MIN_POSITIVE);
        let barrier =
            [run.barrier, pairs as f64 * run.barrier / least, solver.excess(program.shape()) / least];
        let cost = if outcome == Outcome::Converged { iterate.cost(model) } else { f64::NAN };
        let mut candidate = with_iterate(candidate, iterate, multipliers);
        candidate.provenance.method = settings::Method::InteriorPoint;
        let report = Report { outcome, iterations: run.iterations, residuals };
        let attempt = Attempt::of(candidate, report);
        Attempt { cost, residual, stationarity, shortfall, barrier: Some(barrier), warm, ..attempt }
    }
}

impl InteriorPoint<'_> {
    /// Returns the initial iterate of a candidate. If the candidate has no inputs, they are
    /// computed to follow its path, in a duration in which they are within the limits.
    fn start(&self, candidate: &Candidate, watch: &Watch) -> Iterate {
        let Chain { model, rows } = self.chain;
        let sought = candidate.inputs.is_empty() && model.duration.is_some();
        let own = Some(candidate.grid.duration()).filter(|own| *own != 1.0);
        let stretch = sought.then(|| own.or_else(|| self.fitting(candidate, watch))).flatten();
        let mut start = match stretch {
            Some(stretch) => {
                let poses: Vec<Pose> = candidate.states.iter().map(Node::pose).collect();
                first_iterate::along(model, rows, &poses, stretch, watch)
            }
            None => self.chain.iterate(candidate, watch),
        };
        if candidate.inputs.is_empty() {
            start.inputs.iter_mut().flatten().for_each(|u| *u *= self.tuning.centred);
        }
        start
    }

    /// Runs the solver, and repeats it with higher penalties while violations or terminal errors
    /// remain: with too small a penalty a violation may reduce the merit although a feasible
    /// maneuver exists.
    fn run(
        &self,
        program: &ChainProgram,
        solver: &mut Solver,
        (most, resumes): (usize, bool),
        watch: &Watch,
    ) -> Run {
        let iterations = self.tuning.iterations.min(most);
        let mut tuning = Tuning { iterations, ..self.tuning.clone() };
        let mut run = if resumes {
            solver.resume(program, &tuning, watch)
        } else {
            solver.run(program, &tuning, watch)
        };
        for _ in 0..tuning.raises {
            let lacks = run.violation.max(run.miss) > tuning.violated.max(tuning.tolerance);
            if !lacks || !matches!(run.end, End::Converged | End::Stalled) {
                break;
            }
            tuning.price *= tuning.dearer;
            tuning.terminal_price *= tuning.dearer;
            tuning.iterations = iterations.saturating_sub(run.iterations);
            let again = solver.run(program, &tuning, watch);
            run = Run { iterations: run.iterations + again.iterations, ..again };
        }
        run
    }

    /// Returns the candidate as an optimum if it has zero cost and satisfies all conditions,
    /// because no maneuver costs less than zero; otherwise `None`.
    fn costs_nothing(
        &self,
        program: &ChainProgram,
        candidate: &Candidate,
        start: &Iterate,
    ) -> Option<Attempt> {
        let Chain { model, rows } = self.chain;
        if start.cost(model) != 0.0 {
            return None;
        }
        let (mut point, mut at) = (Point::of(program.shape()), Values::of(program.shape()));
        program.point(start, &mut point);
        let exists = program.values(&point, &mut at) && at.are_finite();
        let met = exists
            && at.defects.iter().chain(&at.terminal).all(|lack| *lack == 0.0)
            && program.violations(&at).iter().all(|violation| *violation <= 0.0);
        let multipliers = Multipliers {
            costates: vec![DVector::zeros(model.n); model.steps + 1],
            terminal: DVector::zeros(model.terminal_count()),
            rows: vec![0.0; rows.rows.len()],
        };
        let mut candidate = with_iterate(candidate.clone(), start.clone(), multipliers);
        candidate.provenance.method = settings::Method::InteriorPoint;
        let report = Report { outcome: Outcome::Converged, iterations: 0, residuals: vec![0.0] };
        let found = Attempt { cost: 0.0, residual: 0.0, stationarity: 0.0, ..Attempt::of(candidate, report) };
        met.then_some(Attempt { barrier: Some([0.0; 3]), ..found })
    }

    /// Returns the duration that the path of a candidate requires, as a multiple of the stated one;
    /// `None` if it cannot be determined.
    fn fitting(&self, candidate: &Candidate, watch: &Watch) -> Option<f64> {
        let Chain { model, rows } = self.chain;
        let poses: Vec<Pose> = candidate.states.iter().map(Node::pose).collect();
        let mut stretch = candidate.grid.duration();
        for _ in 0..self.tuning.fitted {
            let along = first_iterate::along(model, &LimitRows::default(), &poses, stretch, watch);
            let program = ChainProgram::of(model, rows, None, &along, self.tuning);
            let mut point = Point::of(program.shape());
            program.point(&along, &mut point);
            let next = program.fitting(&point)?;
            let settled = (next / stretch - 1.0).abs() < self.tuning.close;
            stretch = next;
            if settled || model.is_free() && model.start.momentum == Vector3::zeros() {
                break;
            }
        }
        Some(stretch)
    }

    /// Describes what an unsuccessful run lacks, with the names of the violated limits.
    fn lacking(&self, program: &ChainProgram, at: &Values, run: &Run, outcome: Outcome) -> Shortfall {
        Shortfall::Violated {
            cut_short_after: (outcome == Outcome::IterationLimit).then_some(run.iterations),
            violations: program.noticed(at, self.tuning.violated),
            reaches_end: run.primal.max(run.miss) <= self.tuning.violated,
        }
    }
}

/// Returns the largest value of a row on a path (positive if a row is violated), with the inputs of
/// the path or, if it has none, with inputs that follow it. Returns `None` if the path cannot be
/// evaluated.
pub(crate) fn worst_violation(chain: &Chain, path: &Candidate) -> Option<f64> {
    let iterate = chain.iterate(path, &Watch::NONE);
    let tuning = Tuning::default();
    let program = ChainProgram::of(&chain.model, &chain.rows, None, &iterate, &tuning);
    let (mut point, mut at) = (Point::of(program.shape()), Values::of(program.shape()));
    program.point(&iterate, &mut point);
    let exists = program.values(&point, &mut at) && at.are_finite();
    exists.then(|| at.rows.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// Prepares the solution of a maneuver from the fixed-axis path, and passes to `work` a closure
/// that solves it and returns the number of iterations. Every call uses the same memory. For
/// benchmarks and for counting allocations.
#[doc(hidden)]
pub fn with_cold_solve<T>(problem: &Problem, work: impl FnOnce(&mut dyn FnMut() -> usize) -> T) -> T {
    let (steps, objective) = (problem.steps, &problem.objective);
    let chain = if objective.switches() || objective.counts_time() {
        let goal = Goal { objective: objective.clone() };
        Chain::with_goal(problem, steps, &goal)
    } else {
        Chain::new(problem, steps)
    };
    let (model, tuning) = (&chain.model, Tuning::default());
    let turn = lie::minus(&model.target.attitude, &model.start.attitude);
    let pose = |stage: usize| {
        let along = hermite(model.dynamics.grid.time(stage), 1.0, [&0.0, &1.0], [&0.0, &0.0]);
        let attitude = model.start.attitude * lie::exp(&(turn * along));
        Pose { position: Vector3::zeros(), attitude }
    };
    let path = path("short", &model.dynamics.grid, (0..=steps).map(pose));
    let start = InteriorPoint::of(&chain, &tuning).start(&path, &Watch::NONE);
    let program = ChainProgram::of(model, &chain.rows, None, &start, &tuning);
    let mut solver = Solver::of(program.shape());
    program.point(&start, &mut solver.point);
    let first = solver.point.clone();
    work(&mut || {
        solver.point.states.copy_from_slice(&first.states);
        solver.point.inputs.copy_from_slice(&first.inputs);
        solver.run(&program, &tuning, &Watch::NONE).iterations
    })
}
