//! The planner: every sense and winding, each up the ladder, the extremals compared.

mod constrained;
pub(crate) mod continuation;
mod detour;
pub(crate) mod geodesic;
mod ladder;
pub(crate) mod record;
mod shortfall;

use crate::problem::{Motion, Problem, ProblemError};
use crate::reachability;
use crate::scp::Options;
use crate::settings::{Method, Settings, SettingsError};
use crate::shooting::driver::Report;
use crate::solution::{Outcome, RungReport, Solution, Trajectory};
use std::cell::{Cell, RefCell};
use std::time::Instant;
use thiserror::Error;

/// Why a plan was not attempted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// The maneuver cannot be planned as it stands.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A setting is out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The shooting cannot take what limits the maneuver.
    #[error("the shooting cannot plan this maneuver: {reason}; use method = \"scp\" or \"auto\"")]
    NotForShooting {
        /// What it cannot take.
        reason: &'static str,
    },
    /// A guess has the wrong number of costates, or one that is not finite.
    #[error("the guess has {found} usable costates, the problem needs {needed}")]
    Guess {
        /// Finite costates found.
        found: usize,
        /// Costates needed.
        needed: usize,
    },
}

/// What an observer of a solve is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The rung at work.
    pub rung: &'a str,
    /// The start it works on.
    pub start: &'a str,
    /// Steps of its grid.
    pub steps: usize,
    /// Seconds since the solve began.
    pub elapsed: f64,
}

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop at the next iteration; the best iterate is kept.
    Stop,
}

/// Watches a solve, and may stop it.
pub trait Observer {
    /// Called at every rung and between iterations.
    fn on_progress(&mut self, _progress: &Progress) -> Control {
        Control::Continue
    }
}

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// What every rung shares: settings, the clock, the observer, the record of what was tried.
pub(crate) struct Context<'a> {
    pub settings: &'a Settings,
    observer: RefCell<&'a mut dyn Observer>,
    began: Instant,
    at: RefCell<(String, String, usize)>,
    stopped: Cell<Option<Outcome>>,
    ladder: RefCell<Vec<RungReport>>,
}

impl<'a> Context<'a> {
    fn new(settings: &'a Settings, observer: &'a mut dyn Observer) -> Self {
        Self {
            settings,
            observer: RefCell::new(observer),
            began: Instant::now(),
            at: RefCell::new(("start".into(), "ballistic".into(), 0)),
            stopped: Cell::new(None),
            ladder: RefCell::default(),
        }
    }

    /// Announces a rung.
    pub fn enter(&self, rung: &str, start: &str, steps: usize) {
        *self.at.borrow_mut() = (rung.into(), start.into(), steps);
    }

    /// Notes how a run of the announced rung went, on `steps` steps.
    pub fn note(&self, steps: usize, report: &Report) {
        let (rung, start, _) = self.at.borrow().clone();
        self.ladder.borrow_mut().push(RungReport {
            rung,
            start,
            steps,
            outcome: report.outcome,
            iterations: report.iterations,
            residuals: report.residuals.clone(),
        });
    }

    /// Whether something asks to stop; sticky.
    pub fn interrupt(&self) -> Option<Outcome> {
        if self.stopped.get().is_none() {
            let elapsed = self.began.elapsed();
            let at = self.at.borrow();
            let progress =
                Progress { rung: &at.0, start: &at.1, steps: at.2, elapsed: elapsed.as_secs_f64() };
            if self.observer.borrow_mut().on_progress(&progress) == Control::Stop {
                self.stopped.set(Some(Outcome::Interrupted));
            } else if self.settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                self.stopped.set(Some(Outcome::TimeLimit));
            }
        }
        self.stopped.get()
    }
}

/// Solves a maneuver. The solution says how the solve ended; it is not yet verified.
///
/// `guess` is a costate to try first, as [`Solution::costates_0`] gives it, SI units.
///
/// # Errors
/// [`PlanError`] when problem, settings or guess cannot be used. A solver that stops is no error.
pub fn solve(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&[f64]>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    problem.check()?;
    settings.check()?;
    if problem.is_constrained() && settings.method == Method::Shooting {
        return Err(PlanError::NotForShooting { reason: "it has limits or constraints" });
    }
    if let Some(guess) = guess {
        let found = guess.iter().filter(|value| value.is_finite()).count();
        let needed = problem.dimension();
        if found != needed || guess.len() != needed {
            return Err(PlanError::Guess { found, needed });
        }
    }
    if let Some(obstruction) = reachability::obstruction(problem) {
        let unsolved = Solution::unsolved(problem, settings.tolerance);
        return Ok(Solution {
            outcome: Outcome::Unreachable,
            obstruction: Some(obstruction.reason),
            ..unsolved
        });
    }
    let context = Context::new(settings, observer);
    if settings.method == Method::Scp || (problem.is_constrained() && settings.method == Method::Auto) {
        let mut solution = constrained::solve(problem, &context, &Options::default(), None);
        if solution.outcome != Outcome::Converged
            && context.interrupt().is_none()
            && let Some(violated) = &mut solution.shortfall
        {
            match shortfall::longer(problem, &context) {
                Some(duration) => violated.push_str(&format!("; a plan of {duration:.4} s was found")),
                None => violated.push_str("; none was found for up to three times the duration either"),
            }
        }
        return Ok(solution);
    }
    let solution = match problem.motion {
        Motion::Attitude => ladder::solve::<6>(problem, &context, guess),
        Motion::RigidBody => ladder::solve::<12>(problem, &context, guess),
    };
    let rescue = solution.outcome != Outcome::Converged && settings.method == Method::Auto;
    if !rescue || context.interrupt().is_some() {
        return Ok(solution);
    }
    // The last rung: the convex road needs no costates to start from.
    let mut second = constrained::solve(problem, &context, &Options::default(), None);
    if second.outcome != Outcome::Converged {
        return Ok(solution);
    }
    second.ladder = solution.ladder.into_iter().chain(second.ladder).collect();
    Ok(second)
}

/// Solves a maneuver by the convex road, limited or not, from its own seeds or along a trajectory on the
/// same grid.
///
/// Without `polish` the iteration on the requested grid goes on to its own convergence, and Newton does
/// not touch what it returns: the costates are the duals of the last subproblem, and
/// [`Solution::optimality`] has the residual of all the conditions.
///
/// # Errors
/// [`PlanError`] when problem or settings cannot be used.
pub(crate) fn solve_convex(
    problem: &Problem,
    settings: &Settings,
    polish: bool,
    along: Option<&Trajectory>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    problem.check()?;
    let settings = Settings { method: Method::Scp, ..settings.clone() };
    settings.check()?;
    if let Some(obstruction) = reachability::obstruction(problem) {
        let unsolved = Solution::unsolved(problem, settings.tolerance);
        let (method, outcome) = (Method::Scp, Outcome::Unreachable);
        return Ok(Solution { method, outcome, obstruction: Some(obstruction.reason), ..unsolved });
    }
    let context = Context::new(&settings, observer);
    let last = if polish { Options::default() } else { Options::unpolished() };
    Ok(constrained::solve(problem, &context, &last, along))
}
