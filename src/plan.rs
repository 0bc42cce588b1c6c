//! The planning of a maneuver: solve it, then verify the result.
//!
//! [`plan`] solves a [`Problem`] with [`Settings`] and returns a [`Plan`]: the [`Solution`], the
//! results of the witnesses ([`Verification`]), and a [`Status`] that summarises both. A solver
//! that fails returns a status; only a problem that cannot be attempted is an error
//! ([`PlanError`]).
//!
//! # What does a user of the library compile?
//!
//! Without default features only the code for solving and verifying is compiled. Files (TOML, JSON,
//! temporary files), argmin, threads and the command line are features, each of which builds alone
//! (`.ci/run`). serde, serde_json and thiserror remain: the cone solver needs them, and does not
//! compile without its own default features. Results do not depend on features: sums have the same
//! order on one thread and on many.

pub use crate::feedback::replan::{Left, NotReplanned, Replanner};
pub use crate::optimize::search::memory::PeakMemory;
pub use crate::optimize::search::{Control, Guess, Observer, PlanError, Progress, Silent};

use crate::maneuver::solution::Rung;
use crate::maneuver::{Outcome, Problem, SecondOrder, Settings, Solution};
use crate::optimize::search;
use crate::verify::{self, Verification};
use serde::{Deserialize, Serialize};
use std::cell::{Cell, RefCell};
use std::time::Instant;
use thiserror::Error;

/// The status of a plan. Each status has an exit code of the command line
/// ([`Status::exit_code`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A plan was found, and the independent witnesses agree.
    Solved,
    /// The maneuver is proved infeasible; [`Solution::infeasible`] has the proof.
    Infeasible,
    /// No extremal was found, which proves nothing. [`Solution::shortfall`] and
    /// [`Solution::longer`] name possible remedies.
    NotConverged,
    /// The time limit ended the solve before a solution was found, or ended the verification.
    LimitReached,
    /// A plan was found, but a witness disagrees.
    VerificationFailed,
    /// The caller stopped the solve.
    Interrupted,
}

impl Status {
    /// Returns the name of the status in files, `"solved"` and so on.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::NotConverged => "not_converged",
            Self::LimitReached => "limit_reached",
            Self::VerificationFailed => "verification_failed",
            Self::Interrupted => "interrupted",
        }
    }

    /// Builds the status of a solve that ended without a converged solution.
    fn without_solution(outcome: Outcome) -> Self {
        match outcome {
            Outcome::TimeLimit => Self::LimitReached,
            Outcome::Interrupted => Self::Interrupted,
            Outcome::Infeasible => Self::Infeasible,
            _ => Self::NotConverged,
        }
    }

    /// Returns whether a solve with `outcome` and the results of the witnesses can have this
    /// status.
    #[doc(hidden)]
    pub fn agrees_with(self, outcome: Outcome, found: Option<&Verification>) -> bool {
        match found {
            None => outcome != Outcome::Converged && self == Self::without_solution(outcome),
            Some(_) if outcome != Outcome::Converged => false,
            Some(found) if found.passed() => self == Self::Solved,
            Some(found) if found.was_stopped() => matches!(self, Self::LimitReached | Self::Interrupted),
            Some(_) => self == Self::VerificationFailed,
        }
    }

    /// Returns the exit code: 0 solved, 4 infeasible, 5 not converged, 6 limit reached, 7
    /// verification failed, 130 interrupted.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Solved => 0,
            Self::Infeasible => 4,
            Self::NotConverged => 5,
            Self::LimitReached => 6,
            Self::VerificationFailed => 7,
            Self::Interrupted => 130,
        }
    }
}

/// A solution, the results of the witnesses, and the status.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// The solution, converged or the best iterate.
    pub solution: Solution,
    /// The results of the witnesses; `None` if no converged solution was found.
    pub verification: Option<Verification>,
    /// The status of the plan.
    pub status: Status,
}

impl Plan {
    /// Builds a plan from its three parts, as a plan file stores them.
    #[doc(hidden)]
    pub fn new(solution: Solution, verification: Option<Verification>, status: Status) -> Self {
        Self { solution, verification, status }
    }
}

/// Plans a maneuver: searches all requested homotopy classes, tries the fallback sequence in hard
/// cases, and verifies the result.
///
/// `guess` is an additional start of the search: its costates start the shooting, and its path the
/// other methods. The result is the cheapest plan; the other plans are its rivals. If a guess is
/// [`Guess::alone`] and leads to a plan, it replaces the search. `observer` receives the progress
/// between iterations and may stop the solve; [`Silent`] ignores the progress and does not stop it.
/// Equal inputs give bit-identical outputs, unless a time limit or the observer ends the solve.
///
/// The discretisation and its discrete necessary conditions come from Lee, Leok and McClamroch,
/// *Optimal Attitude Control of a Rigid Body using Geometrically Exact Computations on SO(3)*,
/// 2006 (arXiv math/0601424).
///
/// # Errors
/// Returns a [`PlanError`] if the problem, the settings or the guess are invalid. A solver that
/// stops is not an error: see [`Plan::status`].
///
/// # Example
/// The plan of an easier maneuver is the guess for a harder one:
///
/// ```
/// use slewkit::{Body, Guess, Inertia, Matrix3, Problem, Settings, Silent, State, Vector3, lie, plan};
///
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
/// let start = State::at_rest(Matrix3::identity());
/// let to = |angle: f64| State::at_rest(lie::exp(&Vector3::new(0.0, 0.6 * angle, 0.8 * angle)));
/// let problem = |angle| Problem::attitude(body.clone(), start, to(angle), 30.0);
///
/// let easy = plan(&problem(1.0), &Settings::default(), None, &mut Silent)?;
/// let guess = Guess::of(&easy.solution, &problem(1.0));
/// let hard = plan(&problem(1.2), &Settings::default(), Some(&guess), &mut Silent)?;
/// assert!(hard.solution.cost > easy.solution.cost);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plan(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Plan, PlanError> {
    let began = Instant::now();
    let guess = guess.map(Guess::beside_the_search);
    let solution = search::solve(problem, settings, guess.as_ref(), observer)?;
    Ok(judged(problem, settings, solution, began, observer))
}

/// The plan of the rest of a maneuver, found from another plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WarmPlan {
    /// The remaining maneuver, with its own start, duration and steps.
    pub problem: Problem,
    /// The new plan.
    pub plan: Plan,
    /// The number of Newton steps from the other plan, or the reason why that plan was not used and
    /// a new search was made.
    pub warm: Result<usize, Left>,
}

/// The reason why replanning failed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReplanError {
    /// Replanning is impossible from this plan, or at this time.
    #[error(transparent)]
    Unfit(#[from] NotReplanned),
    /// The rest of the maneuver cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Replans the rest of a maneuver at the time `at` \[s\] of its plan: from the start of `problem`
/// to its end, on the remaining steps. Duration and steps come from the plan, not from `problem`.
///
/// A few Newton steps move the plan to its neighbour. If they fail, or do not reach a minimum,
/// [`plan`] searches again, and [`WarmPlan::warm`] states the reason. A neighbour keeps the
/// homotopy class of its plan, even if another one costs less.
///
/// # Errors
/// Returns a [`ReplanError`] if the plan does not fit the maneuver, if fewer than two of its steps
/// remain, or if [`plan`] returns an error.
///
/// # Example
/// After a third of the maneuver the attitude deviates by half a degree:
///
/// ```
/// use slewkit::plan::{Replanner, replan};
/// use slewkit::{Body, Inertia, Matrix3, Problem, Settings, Silent, State, Status, Vector3, lie, plan};
///
/// let body = Body { inertia: Inertia::diagonal(Vector3::new(12.0, 10.0, 8.0))?, mass: None };
/// let end = State::at_rest(lie::exp(&Vector3::new(0.4, -0.8, 1.2)));
/// let problem = Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 30.0);
/// let first = plan(&problem, &Settings::default(), None, &mut Silent)?;
///
/// let replanner = Replanner::new(&problem, &first.solution)?;
/// let mut found = replanner.planned(&replanner.at(9.9)?);
/// found.attitude *= lie::exp(&Vector3::new(0.0, 0.5_f64.to_radians(), 0.0));
/// let beside = Problem { start: found, ..problem };
/// let again = replan(&beside, &replanner, 9.9, &Settings::default(), &mut Silent)?;
/// assert_eq!(again.plan.status, Status::Solved);
/// assert!(again.warm.is_ok_and(|steps| steps <= 3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn replan(
    problem: &Problem,
    from: &Replanner,
    at: f64,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<WarmPlan, ReplanError> {
    let began = Instant::now();
    from.fits(problem)?;
    let moment = from.at(at)?;
    let moved = (problem.end != from.problem().end).then_some(&problem.end);
    let rest = from.remaining(problem, &moment);
    rest.check().map_err(PlanError::from)?;
    let left = match from.replan(&problem.start, &moment, moved) {
        Ok(replanned) => {
            let solution = from.solution(&rest, &replanned, settings, observer)?;
            let stopped = matches!(solution.outcome, Outcome::Interrupted | Outcome::TimeLimit);
            let saddle = solution.optimality.second_order() == SecondOrder::Saddle;
            if stopped || solution.outcome == Outcome::Converged && !saddle {
                let plan = judged(&rest, settings, solution, began, observer);
                return Ok(WarmPlan { problem: rest, plan, warm: Ok(replanned.newton_steps) });
            }
            Left::NoMinimum
        }
        Err(left) => left,
    };
    let plan = plan(&rest, settings, None, observer)?;
    Ok(WarmPlan { problem: rest, plan, warm: Err(left) })
}

/// Adds the results of the witnesses to a solution, if it converged. The witnesses stop at the time
/// limit, which is counted from `began`, or when `observer` requests a stop.
#[doc(hidden)]
pub fn judged(
    problem: &Problem,
    settings: &Settings,
    solution: Solution,
    began: Instant,
    observer: &mut dyn Observer,
) -> Plan {
    if solution.outcome != Outcome::Converged {
        let status = Status::without_solution(solution.outcome);
        return Plan { solution, verification: None, status };
    }
    let (observer, stopped) = (RefCell::new(observer), Cell::new(Status::VerificationFailed));
    let stop = || {
        let elapsed = began.elapsed();
        let (start, steps, seconds) = (&solution.start, problem.steps, elapsed.as_secs_f64());
        let progress = Progress { rung: Rung::Witnesses, start, steps, elapsed: seconds, part: "" };
        if observer.borrow_mut().on_progress(&progress) == Control::Stop {
            stopped.set(Status::Interrupted);
        } else if settings.time_limit.is_some_and(|limit| elapsed >= limit) {
            stopped.set(Status::LimitReached);
        }
        stopped.get() != Status::VerificationFailed
    };
    let (tolerance, continuous) = (settings.tolerance, settings.continuous_limit());
    let problem = &solution.on_grid(problem);
    let verification = verify::verify_until(problem, &solution.trajectory, tolerance, continuous, &stop);
    let status = if verification.passed() {
        Status::Solved
    } else if verification.was_stopped() {
        stopped.get()
    } else {
        Status::VerificationFailed
    };
    Plan { solution, verification: Some(verification), status }
}
