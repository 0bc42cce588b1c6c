//! The planner: every sense and winding, each up the ladder, the extremals compared.

mod constrained;
pub(crate) mod continuation;
mod detour;
pub(crate) mod geodesic;
mod guess;
mod ladder;
pub(crate) mod record;
mod saturated;
mod shortfall;

pub use guess::Guess;

use crate::maneuver::infeasible;
use crate::maneuver::problem::{Motion, Problem, ProblemError};
use crate::maneuver::settings::{Method, Settings, SettingsError};
use crate::maneuver::solution::{Optimality, Outcome, Rung, RungReport, Solution, Trajectory};
use crate::optimize::control_law;
use crate::optimize::methods::driver::Report;
use crate::optimize::methods::scp::Options;
use constrained::Hint;
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
    /// A grid beyond the memory of the convex road.
    #[error(
        "what limits this maneuver is planned on {MAX_CONVEX_STEPS} steps at most, and it has {steps}: take fewer"
    )]
    TooManySteps {
        /// Steps of the maneuver.
        steps: usize,
    },
    /// A guess has the wrong number of costates, or one that is not finite.
    #[error("the guess has {found} usable costates, the problem needs {needed}")]
    Guess {
        /// Finite costates found.
        found: usize,
        /// Costates needed.
        needed: usize,
    },
    /// A guess has a path that is none.
    #[error(
        "the path of the guess is unusable: it takes two or more unit quaternions, and as many positions or none"
    )]
    GuessPath,
}

/// Most steps of the convex road: subproblem and Newton matrix hold all of them at once, some gigabytes of memory.
pub const MAX_CONVEX_STEPS: usize = 100_000;

/// What an observer of a solve is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The rung at work.
    pub rung: Rung,
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
    at: RefCell<(Rung, String, usize)>,
    stopped: Cell<Option<Outcome>>,
    ladder: RefCell<Vec<RungReport>>,
}

impl<'a> Context<'a> {
    fn new(settings: &'a Settings, observer: &'a mut dyn Observer) -> Self {
        Self {
            settings,
            observer: RefCell::new(observer),
            began: Instant::now(),
            at: RefCell::new((Rung::Newton, "ballistic".into(), 0)),
            stopped: Cell::new(None),
            ladder: RefCell::default(),
        }
    }

    /// Announces a rung.
    pub fn enter(&self, rung: Rung, start: &str, steps: usize) {
        *self.at.borrow_mut() = (rung, start.into(), steps);
    }

    /// When the time limit is over.
    pub fn deadline(&self) -> Option<Instant> {
        self.settings.time_limit.and_then(|limit| self.began.checked_add(limit))
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
            let progress = Progress { rung: at.0, start: &at.1, steps: at.2, elapsed: elapsed.as_secs_f64() };
            if self.observer.borrow_mut().on_progress(&progress) == Control::Stop {
                self.stopped.set(Some(Outcome::Interrupted));
            } else if self.settings.time_limit.is_some_and(|limit| elapsed >= limit) {
                self.stopped.set(Some(Outcome::TimeLimit));
            }
        }
        self.stopped.get()
    }
}

fn check(problem: &Problem, settings: &Settings) -> Result<(), PlanError> {
    problem.check()?;
    settings.check()?;
    Ok(())
}

fn check_costates(problem: &Problem, costates: &[f64]) -> Result<(), PlanError> {
    let found = costates.iter().filter(|value| value.is_finite()).count();
    let needed = problem.dimension();
    let usable = found == needed && costates.len() == needed;
    if usable { Ok(()) } else { Err(PlanError::Guess { found, needed }) }
}

fn check_for_convex_road(problem: &Problem) -> Result<(), PlanError> {
    let steps = problem.steps;
    if steps <= MAX_CONVEX_STEPS { Ok(()) } else { Err(PlanError::TooManySteps { steps }) }
}

/// Whether the shooting can take what limits a maneuver.
fn check_for_shooting(problem: &Problem) -> Result<(), PlanError> {
    control_law::obstacle(problem).map_or(Ok(()), |reason| Err(PlanError::NotForShooting { reason }))
}

/// Polishes a costate guess, as [`Solution::costates_0`] gives it (SI units; `λ_0` for Lie–Euler, `λ_{−1}` for
/// Lie–Verlet), by the shooting's Newton alone, without the ladder: what the duals of another method need.
///
/// Limits of the inputs act through the saturated control law, so that a guess within Newton's reach is
/// brought to the tolerance in a step or two.
///
/// # Errors
/// [`PlanError`] when problem, settings or guess cannot be used. A Newton that stops is no error.
pub fn polish(
    problem: &Problem,
    settings: &Settings,
    guess: &[f64],
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    check_costates(problem, guess)?;
    check_for_shooting(problem)?;
    let context = Context::new(settings, observer);
    Ok(match problem.motion {
        Motion::Attitude => ladder::polish::<6>(problem, &context, guess, "guess"),
        Motion::RigidBody => ladder::polish::<12>(problem, &context, guess, "guess"),
    })
}

/// Solves a maneuver. The solution says how the solve ended; it is not yet verified.
///
/// The shooting takes limits of the size of the inputs, or of the norm of what they give, through the
/// saturated control law. By default ([`Method::Auto`]) it is tried first wherever it applies; where it finds
/// nothing the convex road does, whose duals then start the shooting once more. Everything else (constraints
/// on pointing or rates, limits of how fast inputs change, reaction wheels) takes the convex road.
///
/// `guess` is tried first: its costates by the shooting, its path by the convex road.
///
/// # Errors
/// [`PlanError`] when problem, settings or guess cannot be used. A solver that stops is no error.
pub fn solve(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    if let Some(guess) = guess {
        check_costates(problem, &guess.costates)?;
        if !guess.path_is_sound() {
            return Err(PlanError::GuessPath);
        }
    }
    let obstacle = check_for_shooting(problem);
    if settings.method == Method::Shooting {
        obstacle.clone()?;
    }
    let convex = settings.method == Method::Scp || obstacle.is_err();
    if convex {
        check_for_convex_road(problem)?;
    }
    // From here on the clock runs.
    let context = Context::new(settings, observer);
    if let Some(proof) = infeasible::proof(problem) {
        let unsolved = Solution::unsolved(problem, settings.tolerance);
        return Ok(Solution { outcome: Outcome::Infeasible, infeasible: Some(proof), ..unsolved });
    }
    if convex {
        let solution = constrained::solve(problem, &context, &options(settings), Hint::of(guess));
        return Ok(with_advice(problem, &context, held_to(settings.tolerance, solution)));
    }
    let costates = guess.map(|guess| guess.costates.as_slice());
    let solution = match problem.motion {
        Motion::Attitude => ladder::solve::<6>(problem, &context, costates),
        Motion::RigidBody => ladder::solve::<12>(problem, &context, costates),
    };
    let rescue = solution.outcome != Outcome::Converged && settings.method == Method::Auto;
    if !rescue || context.interrupt().is_some() || check_for_convex_road(problem).is_err() {
        return Ok(solution);
    }
    // The last rung: the convex road needs no costates to start from, and its duals are some.
    let second = constrained::solve(problem, &context, &options(settings), Hint::of(guess));
    let mut second = held_to(settings.tolerance, confirmed(problem, &context, second));
    if second.outcome != Outcome::Converged {
        if !problem.is_constrained() {
            return Ok(solution);
        }
        second = with_advice(problem, &context, second);
    }
    second.ladder = solution.ladder.into_iter().chain(second.ladder).collect();
    Ok(second)
}

/// A solution that counts as converged only where its terminal error, replayed from the start, is within the
/// tolerance.
fn held_to(tolerance: f64, mut solution: Solution) -> Solution {
    let met = solution.terminal.largest() <= tolerance;
    if solution.outcome == Outcome::Converged && !met {
        solution.outcome = Outcome::Stalled;
        solution.shortfall = Some(format!(
            "the conditions of the optimum are met, but the inputs replayed from the start miss the end by {:.1e}, \
             scaled; the tolerance is {tolerance:.1e}",
            solution.terminal.largest()
        ));
    }
    solution
}

/// An answer of the convex road with the shooting's word on it, started from its duals: whether it is an
/// extremal, and of which second order. Where its terminal error is above the tolerance, the shooting's own.
fn confirmed(problem: &Problem, context: &Context, solution: Solution) -> Solution {
    if solution.outcome != Outcome::Converged || context.interrupt().is_some() {
        return solution;
    }
    let duals = solution.costates_0(problem);
    let mut shot = match problem.motion {
        Motion::Attitude => ladder::polish::<6>(problem, context, duals, "duals"),
        Motion::RigidBody => ladder::polish::<12>(problem, context, duals, "duals"),
    };
    let same = (shot.cost - solution.cost).abs() <= SAME_COST * solution.cost.abs();
    let agrees = shot.outcome == Outcome::Converged && same;
    let ladder = solution.ladder.iter().cloned().chain(std::mem::take(&mut shot.ladder)).collect();
    if !agrees {
        return Solution { ladder, ..solution };
    }
    let met = solution.terminal.largest() <= context.settings.tolerance;
    if !met {
        let Solution { convex, rivals, .. } = solution;
        return Solution { ladder, convex, rivals, ..shot };
    }
    let stationarity = solution.optimality.stationarity.max(shot.optimality.stationarity);
    let optimality = Optimality { stationarity, ..shot.optimality };
    Solution { ladder, optimality, solve_time: shot.solve_time, ..solution }
}

/// What the settings allow the convex road.
fn options(settings: &Settings) -> Options {
    Options::default().within(settings.max_iterations)
}

/// Costs of one extremal differ by less, relative.
const SAME_COST: f64 = 1e-9;

/// An unsolved maneuver with the duration for which a plan was found.
fn with_advice(problem: &Problem, context: &Context, mut solution: Solution) -> Solution {
    // A search that was cut short says nothing about the maneuver.
    let searched = !matches!(solution.outcome, Outcome::Converged | Outcome::IterationLimit);
    if searched
        && context.interrupt().is_none()
        && let Some(violated) = &mut solution.shortfall
    {
        solution.longer = shortfall::longer(problem, context);
        match solution.longer {
            Some(duration) => violated.push_str(&format!("; a plan of {duration} s was found")),
            None => violated.push_str("; none was found for up to three times the duration either"),
        }
    }
    solution
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
    check_for_convex_road(problem)?;
    if let Some(proof) = infeasible::proof(problem) {
        let unsolved = Solution::unsolved(problem, settings.tolerance);
        let (method, outcome) = (Method::Scp, Outcome::Infeasible);
        return Ok(Solution { method, outcome, infeasible: Some(proof), ..unsolved });
    }
    let context = Context::new(&settings, observer);
    let last = if polish { Options::default() } else { Options::unpolished() };
    let last = last.within(settings.max_iterations);
    let solution = constrained::solve(problem, &context, &last, along.map_or(Hint::None, Hint::Only));
    Ok(if polish { held_to(settings.tolerance, solution) } else { solution })
}
