//! Gap between the cost of a plan and a global lower bound, on the grid of the maneuver or on a
//! coarser grid.
//!
//! The bound is valid for one discrete problem, and a coarser grid is a different problem. The
//! maneuver is therefore also planned on the grid of the bound, so that cost and bound belong to
//! the same problem. The bound ignores limits and constraints, which can only increase the cost. A
//! plan without them shows the part of the gap that they cause.

use serde::Serialize;
use slewkit::maneuver::{Method, Outcome, Problem, Settings};
use slewkit::optimize::lower_bound::{
    BoundError, BoundSettings, Coverage, Relaxation, SolverEnd, covered, lower_bound,
};
use slewkit::optimize::search::{self, Observer, PlanError};
use thiserror::Error;

/// Default number of steps of the bound, if the maneuver has more steps.
pub const BOUND_STEPS: usize = 8;

/// A global lower bound on the cost of a discrete problem, with plans of this problem.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Global {
    /// Number of steps of the discrete problem.
    pub steps: usize,
    /// True if the grid of the bound is the grid of the maneuver. Otherwise bound and gap belong to
    /// a coarser problem.
    pub same_grid: bool,
    /// Lower bound on the cost of all plans of the discrete problem that the bound covers.
    pub lower_bound: f64,
    /// The cost of the plan of the discrete problem.
    pub cost: f64,
    /// The cost of the plan without limits and constraints; `None` if the maneuver has none.
    pub cost_without_limits: Option<f64>,
    /// Largest possible relative saving, `(cost − lower_bound)/cost`.
    pub gap: f64,
    /// Gap without limits and constraints, which is due to the relaxation alone.
    pub gap_without_limits: f64,
    /// True if the plan without limits and constraints is proved globally optimal within
    /// [`Global::TIGHT`]. Otherwise the bound is not sharp, or a cheaper plan exists.
    pub tight: bool,
    /// The class of plans that the bound covers.
    pub coverage: Coverage,
    /// The relaxation from which the bound is computed.
    pub relaxation: Relaxation,
    /// Outcome of the conic solver, on which the validity of the bound does not depend.
    pub solver: SolverEnd,
    /// Largest ratio of the second to the first eigenvalue over all moment matrices. A value near
    /// zero means that the relaxation is exact.
    pub rank_one_defect: Option<f64>,
    /// Number of moment variables in the relaxation.
    pub moments: usize,
    /// The number of iterations of the conic solver.
    pub iterations: u32,
    /// The elapsed time in the conic solver \[s\]. It differs from run to run.
    pub solve_time_s: f64,
}

impl Global {
    /// Largest relative gap at which a plan counts as globally optimal.
    pub const TIGHT: f64 = 1e-6;
}

/// The reason why no gap can be computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GlobalError {
    /// The maneuver cannot be planned on the grid of the bound.
    #[error("no lower bound on {steps} steps: {error}")]
    Plan {
        /// The number of steps of the grid.
        steps: usize,
        /// The reason why the maneuver cannot be planned.
        error: PlanError,
    },
    /// The search found no plan on the grid of the bound, with which the bound could be compared.
    #[error("no lower bound on {steps} steps: the maneuver was not solved there ({outcome:?})")]
    NotSolved {
        /// The number of steps of the grid.
        steps: usize,
        /// Outcome of the unsuccessful search.
        outcome: Outcome,
    },
    /// The lower bound cannot be computed.
    #[error(transparent)]
    Bound(#[from] BoundError),
}

/// Computes the lower bound for the discrete problem with `steps` steps, and plans this problem. If
/// `steps` is `None`, the grid has [`BOUND_STEPS`] steps, or fewer if the maneuver has fewer.
///
/// # Errors
/// Returns a [`GlobalError`] if the bound does not cover the maneuver, or if no plan is found on
/// this grid.
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
    // Wheels are kept, although the bound then rejects the maneuver: their torques are not external
    // torques.
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
