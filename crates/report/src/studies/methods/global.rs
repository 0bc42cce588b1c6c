//! The gap to the global lower bound, on the grid of the maneuver or a coarser one.
//!
//! The bound belongs to a discrete problem. A coarser grid is another problem, so the maneuver is
//! planned on it too, and the gap is between two numbers of one problem. The bound ignores limits
//! and constraints, which only raise the cost; the plan without them gives their part of the gap.

use serde::Serialize;
use slewkit::maneuver::{Method, Outcome, Problem, Settings};
use slewkit::optimize::lower_bound::{
    BoundError, BoundSettings, Coverage, Relaxation, SolverEnd, covered, lower_bound,
};
use slewkit::optimize::search::{self, Observer, PlanError};
use thiserror::Error;

/// The default number of steps for the bound of a maneuver with more steps.
pub const BOUND_STEPS: usize = 8;

/// A global lower bound and the plans of its discrete problem.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Global {
    /// Steps of the discrete problem that is bounded and planned here.
    pub steps: usize,
    /// Whether the bound has the grid of the maneuver; otherwise bound and gap belong to the
    /// coarser problem.
    pub same_grid: bool,
    /// No covered maneuver of that discrete problem costs less.
    pub lower_bound: f64,
    /// Cost of the plan of the discrete problem.
    pub cost: f64,
    /// Cost without limits and constraints, if the maneuver has any.
    pub cost_without_limits: Option<f64>,
    /// `(cost − lower_bound)/cost`: the largest possible gain.
    pub gap: f64,
    /// The part of the gap that the relaxation causes: the gap without limits.
    pub gap_without_limits: f64,
    /// Whether the plan without limits is proved globally optimal to [`Global::TIGHT`]; otherwise
    /// the bound is loose, or a cheaper maneuver exists.
    pub tight: bool,
    /// The maneuvers that the bound covers.
    pub coverage: Coverage,
    /// The relaxation.
    pub relaxation: Relaxation,
    /// The outcome of the cone solver; the bound is proved for any outcome.
    pub solver: SolverEnd,
    /// Second over first eigenvalue of the moment matrices, the largest: near zero the relaxation
    /// is exact.
    pub rank_one_defect: Option<f64>,
    /// Number of moments.
    pub moments: usize,
    /// Iterations of the cone solver.
    pub iterations: u32,
    /// Wall time inside the cone solver \[s\]: differs between two runs.
    pub solve_time_s: f64,
}

impl Global {
    /// A gap up to this, relative, counts as none.
    pub const TIGHT: f64 = 1e-6;
}

/// The reason for which no gap exists.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GlobalError {
    /// The maneuver cannot be planned on the grid of the bound.
    #[error("no lower bound on {steps} steps: {error}")]
    Plan {
        /// Steps.
        steps: usize,
        /// The reason.
        error: PlanError,
    },
    /// No plan was found on that grid for a comparison with the bound.
    #[error("no lower bound on {steps} steps: the maneuver was not solved there ({outcome:?})")]
    NotSolved {
        /// Steps.
        steps: usize,
        /// The outcome of the solve.
        outcome: Outcome,
    },
    /// No bound was found.
    #[error(transparent)]
    Bound(#[from] BoundError),
}

/// Returns the bounds the discrete problem on `steps` steps from below ([`BOUND_STEPS`], or fewer
/// if the maneuver has fewer), and plans that discrete problem.
///
/// # Errors
/// A [`GlobalError`] when the maneuver is not covered, or not solved on that grid.
pub fn global(
    problem: &Problem,
    settings: &Settings,
    steps: Option<usize>,
    observer: &mut dyn Observer,
) -> Result<Global, GlobalError> {
    let steps = steps.unwrap_or(BOUND_STEPS.min(problem.steps));
    let there = problem.clone().with_steps(steps);
    let mut relaxed = there.clone();
    relaxed.constraints.clear();
    // Wheels stay, and are refused: they are no limit of an external torque.
    relaxed.actuation = problem.actuation.without_limits();
    relaxed.actuation.wheels = problem.actuation.wheels.clone();
    covered(&relaxed)?;
    let mut solved = |problem: &Problem| {
        let settings = Settings { method: Method::Auto, ..settings.clone() };
        let found = search::solve(problem, &settings, None, observer)
            .map_err(|error| GlobalError::Plan { steps, error })?;
        let outcome = found.outcome;
        if outcome == Outcome::Converged { Ok(found) } else { Err(GlobalError::NotSolved { steps, outcome }) }
    };
    let planned = solved(&there)?;
    let without_limits = if problem.is_constrained() { Some(solved(&relaxed)?) } else { None };
    // The bound covers paths of all homotopy classes, so the requested class is ignored.
    let free = without_limits.as_ref().unwrap_or(&planned);
    let known = free.rivals.iter().map(|rival| rival.cost).fold(free.cost.min(planned.cost), f64::min);
    let (cost, cost_without_limits) = (planned.cost, without_limits.as_ref().map(|found| found.cost));
    let bound_settings = BoundSettings {
        known_cost: Some(known),
        time_limit: settings.time_limit.map(|limit| limit.as_secs_f64()),
        ..BoundSettings::default()
    };
    let bound = lower_bound(&relaxed, &bound_settings)?;
    let gap = |cost: f64| if cost > 0.0 { (cost - bound.cost) / cost } else { 0.0 };
    let gap_without_limits = gap(cost_without_limits.unwrap_or(cost));
    Ok(Global {
        steps,
        same_grid: steps == problem.steps,
        lower_bound: bound.cost,
        cost,
        cost_without_limits,
        gap: gap(cost),
        gap_without_limits,
        tight: gap_without_limits <= Global::TIGHT,
        coverage: bound.coverage,
        relaxation: bound.relaxation,
        solver: bound.solver,
        rank_one_defect: bound.rank_one_defect,
        moments: bound.moments,
        iterations: bound.iterations,
        solve_time_s: bound.solve_time,
    })
}
