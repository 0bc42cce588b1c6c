//! The search: the strategies run in order for every homotopy class and winding, and their results
//! are compared.

mod asked;
mod context;
mod found;
mod given_duration;
mod guess;
mod halt;
mod ladder;
mod limited;
pub mod memory;
mod outer;
mod pool;
mod record;
mod settings;
pub(crate) mod starts;
mod strategies;
mod switching;
mod way;

pub use context::{Control, Observer, Progress, Silent};
pub use guess::Guess;
pub(crate) use starts::given as first_costate;

use crate::Vector3;
use crate::flight::Flight;
use crate::maneuver::infeasible;
use crate::maneuver::problem::{Formulation, Motion, Problem, ProblemError};
use crate::maneuver::settings::{Method, Settings, SettingsError, Target, Thoroughness};
use crate::maneuver::solution::{Outcome, Rung, Solution, Trajectory};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::control_law::{self, Obstacle};
use crate::optimize::discrete::linear_plan::Vector6;
use crate::optimize::methods::scp::ScpOptions;
use context::Context;
use found::Found;
use given_duration::{polished, search_of, searched};
use ladder::Ask;
use outer::{alternatives, cheapest, ends, known, steps};
use record::answer::conclude;
use std::f64::consts::PI;
use std::time::Instant;
use strategies::shots::shoot_fine;
use thiserror::Error;

/// Reason why no plan was attempted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// The maneuver is invalid.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A setting is out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Shooting does not support a limit of the maneuver.
    #[error("the shooting cannot plan this maneuver: {reason}; use method = \"interior_point\" or \"auto\"")]
    NotForShooting {
        /// The limit or constraint that shooting does not support.
        reason: Obstacle,
    },
    /// SCP was requested, but it supports only minimum effort with a given duration.
    #[error(
        "SCP supports only minimum effort with a given duration; remove `method` or use method = \
        \"interior_point\""
    )]
    NotForScp,
    /// A setting does not apply to a maneuver with switching inputs or free duration.
    #[error("the settings do not suit this maneuver: {0}")]
    Unsuited(Misfit),
    /// The grid has more steps than SCP or the interior-point method can hold in memory.
    #[error(
        "with its limits and constraints, this maneuver can have at most {MAX_CONVEX_STEPS} steps, and it \
        has {steps}: use fewer steps"
    )]
    TooManySteps {
        /// Number of steps of the maneuver.
        steps: usize,
    },
    /// A guess has the wrong number of costates, or one that is not finite.
    #[error("the guess has {found} usable costates, the problem needs {needed}")]
    Guess {
        /// Number of finite costates in the guess.
        found: usize,
        /// Number of costates that the problem needs.
        needed: usize,
    },
    /// The path of a guess is invalid.
    #[error(
        "the path of the guess is unusable: it needs two or more unit quaternions, and as many positions or \
        none"
    )]
    GuessPath,
}

/// Reason why a request does not apply to the maneuver.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Misfit {
    /// A guess was given, but the maneuver does not use one.
    #[error("it does not use a guess: remove the guess")]
    Guess,
    /// Costates were given to polish, but the maneuver is not minimum-effort with a given duration.
    #[error("only a minimum-effort maneuver of a given duration has costates to polish")]
    Polish,
    /// A single method was requested for a maneuver with alternative sets of cones. Only the search
    /// determines which set holds when.
    #[error("only the search chooses between alternative sets of cones: no single method can")]
    Turns,
    /// A comparison of the methods for switching inputs was requested, but the maneuver has no such
    /// inputs.
    #[error("this comparison needs a maneuver whose inputs switch, such as minimum time or minimum fuel")]
    Ways,
    /// A comparison of shooting and SCP was requested, but the maneuver is not minimum-effort.
    #[error("the comparison of methods needs a minimum-effort maneuver")]
    Methods,
}

/// Largest number of steps of a plan by the interior-point method or SCP, which hold all steps in
/// memory at once (some gigabytes).
pub const MAX_CONVEX_STEPS: usize = 100_000;

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

/// Checks that the costates and the path of a guess are usable.
fn check_guess(problem: &Problem, guess: Option<&Guess>) -> Result<(), PlanError> {
    let Some(guess) = guess else { return Ok(()) };
    // A guess may be a path without costates.
    if !guess.costates.is_empty() || guess.quaternion.is_empty() {
        check_costates(problem, &guess.costates)?;
    }
    if guess.path_is_sound() { Ok(()) } else { Err(PlanError::GuessPath) }
}

fn check_for_scp(problem: &Problem) -> Result<(), PlanError> {
    let steps = problem.steps;
    if steps <= MAX_CONVEX_STEPS { Ok(()) } else { Err(PlanError::TooManySteps { steps }) }
}

/// Reports an error if a guess is given that is not the plan of a finished search.
fn check_for_no_guess(guess: Option<&Guess>) -> Result<(), PlanError> {
    let given = guess.filter(|guess| !guess.is_known());
    given.map_or(Ok(()), |_| Err(PlanError::Unsuited(Misfit::Guess)))
}

/// Checks that settings and guess are compatible with minimum time, minimum fuel or a free duration
/// on a uniform grid.
fn check_for_chain(problem: &Problem, settings: &Settings, guess: Option<&Guess>) -> Result<(), PlanError> {
    match settings.method {
        Method::Shooting => return Err(PlanError::NotForShooting { reason: Obstacle::EqualSteps }),
        Method::Scp => return Err(PlanError::NotForScp),
        Method::Auto | Method::InteriorPoint => {}
    }
    check_for_no_guess(guess)?;
    check_for_scp(problem)
}

/// Reports an error unless the maneuver is minimum-effort with a given duration.
fn check_for_effort(problem: &Problem) -> Result<(), PlanError> {
    if !problem.alternatives.is_empty() {
        return Err(PlanError::Unsuited(Misfit::Turns));
    }
    let taken = Formulation::of(problem) == Formulation::Extremal && problem.aim().is_none();
    if !taken || problem.duration.known().is_none() {
        return Err(PlanError::Unsuited(Misfit::Polish));
    }
    Ok(())
}

/// Reports an error if shooting does not support a limit of the maneuver.
fn check_for_shooting(problem: &Problem) -> Result<(), PlanError> {
    control_law::obstacle(problem).map_or(Ok(()), |reason| Err(PlanError::NotForShooting { reason }))
}

/// Polishes a costate guess, as given by [`Solution::costates_0`] (SI units; `λ_0` for Lie–Euler,
/// `λ_{−1}` for Lie–Verlet), by Newton shooting alone, without the other strategies. It serves for
/// the dual variables of another method.
///
/// Limits of the inputs are included in the saturated control law, so that a guess within Newton's
/// region of convergence reaches the tolerance in one or two steps.
///
/// # Errors
/// [`PlanError`] if the problem, the settings or the guess cannot be used. A Newton iteration that
/// does not converge is reported in the solution, not as an error.
pub fn polish(
    problem: &Problem,
    settings: &Settings,
    guess: &[f64],
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    check_for_effort(problem)?;
    check_costates(problem, guess)?;
    check_for_shooting(problem)?;
    let context = Context::new(settings, observer);
    let guess = Guess::costates(guess);
    let ask = Ask { shooting: true, convex: false, guess: Some(&guess), ..Ask::of_goal(None, settings) };
    Ok(match problem.motion {
        Motion::Attitude => polished(&search_of::<6>(problem, &context, ask)),
        Motion::RigidBody => polished(&search_of::<12>(problem, &context, ask)),
    })
}

/// Polishes `λ_{−1}` (SI units) near an extremal by Newton's method alone, in at most `most` steps.
/// The plan is recorded and tested. Its true motion meets the end if `settings` require landing,
/// and it must be in the homotopy class that `problem` requests.
///
/// # Errors
/// [`PlanError`] if the problem or the settings cannot be used. A Newton iteration that does not
/// converge is reported in the solution, not as an error.
pub(crate) fn warm(
    problem: &Problem,
    settings: &Settings,
    costate: &[f64; 6],
    most: usize,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    check_for_effort(problem)?;
    check_for_shooting(problem)?;
    let settings = Settings { max_iterations: settings.max_iterations.min(most), ..settings.clone() };
    let context = Context::new(&settings, observer);
    let lands = context.lands();
    let ask = Ask { shooting: true, convex: false, lands, ..Ask::of_goal(None, &settings) };
    let search = search_of::<6>(problem, &context, ask);
    let grid = &search.fine.dynamics.grid;
    let scaled = Vector6::from_row_slice(costate).component_div(&search.fine.dynamics.units.costate());
    let mut found = Found::default();
    shoot_fine(&search, &mut found, Rung::Guess, Candidate::of_costate(starts::WARM, grid, &scaled));
    let solution = asked::held_to_its_way(&search, conclude(&search, &mut found));
    let ladder = context.ladder.take();
    Ok(with_true_motion(problem, &settings, Solution { ladder, ..solution }))
}

/// Solves a maneuver. The solution states how the solve ended; it is not yet verified.
///
/// Shooting includes limits on the size of the inputs, or on the norm of the torque, in the
/// saturated control law. By default ([`Method::Auto`]) it is tried first wherever it applies. If
/// it finds no plan, the interior-point method is used, and its costates then start shooting once
/// more. All other limits (constraints on pointing or rates, limits on the rate of change of
/// inputs, reaction wheels) require the interior-point method.
///
/// `guess` is tried first: its costates by shooting, its path by the interior-point method.
///
/// If a plan must land and no number of steps was given ([`Problem::with_steps`]), it may take more
/// steps than [`Problem::steps`]. [`Solution::steps`] states their number, and [`Solution::chosen`]
/// the reason.
///
/// # Errors
/// [`PlanError`] if the problem, the settings or the guess cannot be used. A solver that does not
/// converge is reported in the solution, not as an error.
pub fn solve(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    let began = Instant::now();
    let found = without_arcs(problem, settings, guess, observer)?;
    let left = settings.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
    let settings = Settings { time_limit: left, ..settings.clone() };
    Ok(limited::with_arcs(problem, &Context::new(&settings, observer), found))
}

/// Solves a maneuver without the extrapolation of its arcs to continuous time.
pub(crate) fn without_arcs(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    if !problem.alternatives.is_empty() {
        check(problem, settings)?;
        return alternatives::solve(problem, settings, guess, observer, &without_arcs);
    }
    let problem = &problem.clone().planned_by(settings.method);
    if let Some(aim) = problem.aim() {
        check(problem, settings)?;
        if problem.duration.known().is_none() || problem.objective.switches() {
            check_for_no_guess(guess)?;
        }
        return ends::solve_to(problem, aim, settings, guess, observer, &without_arcs);
    }
    if problem.chooses_steps && settings.target == Target::Motion {
        return steps::chosen(problem, settings, guess, observer, &solve_on)
            .map(|found| with_true_motion(problem, settings, found));
    }
    solve_on(problem, settings, guess, observer).map(|found| with_true_motion(problem, settings, found))
}

/// Replaces the trajectory of a landed plan by its true motion at the nodes.
fn with_true_motion(problem: &Problem, settings: &Settings, mut found: Solution) -> Solution {
    if settings.target == Target::Discrete {
        // A plan for the discrete target ends where its discrete motion does.
        (found.trajectory.target, found.landing) = (None, None);
    }
    if found.trajectory.target.is_some() {
        let problem = found.on_grid(problem);
        match Flight::recorded(&problem, &found.trajectory) {
            Some(flown) => {
                let rates = flown.angular_velocity.windows(2).zip(flown.time.windows(2));
                let turned = |(rate, time): (&[Vector3], &[f64])| {
                    0.5 * (time[1] - time[0]) * (rate[0].norm() + rate[1].norm())
                };
                found.turned_deg = rates.map(turned).sum::<f64>().to_degrees();
                found.trajectory = flown;
            }
            // If the true motion cannot be computed, the plan does not land.
            None => found.trajectory.target = None,
        }
    }
    found
}

/// Solves a maneuver on the number of steps of `problem`.
fn solve_on(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    if Formulation::of(problem) != Formulation::Extremal
        && let Some(proof) = infeasible::in_any_time(problem)
    {
        let unsolved = Solution::unsolved(problem, settings.tolerance);
        return Ok(Solution { outcome: Outcome::Infeasible, infeasible: Some(proof), ..unsolved });
    }
    if let Some(motion) = guess.and_then(Guess::motion)
        && let Some(found) = known::along(problem, &Context::new(settings, observer), &motion)
    {
        return Ok(found);
    }
    match Formulation::of(problem) {
        Formulation::Extremal => in_given_duration(problem, settings, guess, observer),
        Formulation::Switching => {
            check_for_no_guess(guess)?;
            let context = Context::new(settings, observer);
            let found = switching::solve(problem, &context);
            Ok(or_on_equal_steps(problem, &context, found, guess))
        }
        Formulation::Chain => {
            check_for_chain(problem, settings, guess)?;
            let context = Context::new(settings, observer);
            Ok(cheapest::solve(problem, &context, &Trajectory::default()))
        }
    }
}

/// Largest number of steps with which a uniform grid is tried unless the user requests it. On ten
/// thousand steps the interior-point method takes seconds, and memory that the estimate for a
/// bang-bang plan does not include (`cargo run --release -p evidence -- best_known fuel_price_rod
/// 1000`).
const MOST_EQUAL_STEPS: usize = 10_000;

/// Returns the bang-bang plan, or the plan of the interior-point method on a uniform grid if it is
/// cheaper. The uniform grid is tried in three cases: no arcs were found, their cost exceeds the
/// part that their certificate and the grid explain, or the body spins at an end. With singular
/// inputs, arcs that fit the grid may not exist, and an initial path may fail.
fn or_on_equal_steps(
    problem: &Problem,
    context: &Context,
    found: Solution,
    guess: Option<&Guess>,
) -> Solution {
    let converged = |solution: &Solution| solution.outcome == Outcome::Converged;
    // If arcs miss the end only by round-off, they are the plan; no plan is faster than the
    // quickest extremal.
    let settled =
        if found.trajectory.time.is_empty() { found.shortest.is_some() } else { !switching::is_dear(&found) };
    let settings = context.settings;
    let asked = settings.method == Method::Auto && settings.search != Thoroughness::Quick;
    // If the motion without inputs turns the body by more than half a turn, smoothed extremals
    // rarely find all homotopy classes.
    let fastest =
        [&problem.start, &problem.end].map(|end| end.angular_velocity.norm()).into_iter().fold(0.0, f64::max);
    let spins = fastest * found.trajectory.time.last().copied().unwrap_or(0.0) > PI;
    let may = asked && problem.shortest_pulse().is_none() && problem.steps <= MOST_EQUAL_STEPS;
    if settled && !spins || !may || context.interrupt().is_some() {
        return found;
    }
    let tried = found.ladder.clone();
    let equal = problem.clone().planned_by(Method::InteriorPoint);
    let known = guess.and_then(Guess::motion).and_then(|motion| known::along(&equal, context, &motion));
    let other = known.unwrap_or_else(|| cheapest::solve(&equal, context, &found.trajectory));
    // A stopped solve is reported as such, with its best iterate.
    let stopped = context.interrupt().is_some() && !converged(&found);
    // The grid makes arcs cost more than in continuous time. Another plan must be cheaper by more
    // than this difference.
    let least = if settled { found.cost * (1.0 - switching::OF_THE_GRID) } else { found.cost };
    let better = stopped || converged(&other) && !(converged(&found) && least <= other.cost);
    let mut chosen = if better { other } else { Solution { solve_time: other.solve_time, ..found } };
    chosen.ladder.splice(0..0, tried);
    chosen
}

/// Solves a minimum-effort maneuver with a given duration, by shooting, by the interior-point
/// method, or by SCP if requested.
fn in_given_duration(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check_guess(problem, guess)?;
    let obstacle = check_for_shooting(problem);
    if settings.method == Method::Shooting {
        obstacle.clone()?;
    }
    let shooting = !settings.method.is_on_equal_steps() && obstacle.is_ok();
    let fits = check_for_scp(problem);
    if !shooting {
        fits.clone()?;
    }
    let convex = settings.method != Method::Shooting && fits.is_ok();
    // The time limit is measured from here.
    let context = Context::new(settings, observer);
    Ok(searched(
        problem,
        &context,
        Ask { shooting, convex, guess, advise: true, lands: context.lands(), ..Ask::of_goal(None, settings) },
    ))
}

/// Solves a maneuver with switching inputs by the smoothed law alone, without switching times.
///
/// # Errors
/// [`PlanError`] if the problem or the settings cannot be used.
#[doc(hidden)]
pub fn solve_smoothed(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    Ok(switching::solve_smoothed(problem, &Context::new(settings, observer)))
}

/// Solves a maneuver by SCP, with or without limits, from its own initial paths or from a
/// trajectory on the same grid.
///
/// Without `polish` the iteration on the requested grid continues to its own convergence, and
/// Newton does not change its result. The costates are the dual variables of the last subproblem,
/// and [`Solution::optimality`] holds the residual of all conditions.
///
/// # Errors
/// [`PlanError`] if the problem or the settings cannot be used.
#[doc(hidden)]
pub fn solve_convex(
    problem: &Problem,
    settings: &Settings,
    polish: bool,
    along: Option<&Trajectory>,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    let settings = Settings { method: Method::Scp, ..settings.clone() };
    check(problem, &settings)?;
    check_for_effort(problem)?;
    check_for_scp(problem)?;
    let context = Context::new(&settings, observer);
    let last = if polish { ScpOptions::default() } else { ScpOptions::unpolished() };
    let last = last.within(settings.max_iterations);
    let ask = Ask { along, last, ..Ask::of_goal(None, &settings) };
    Ok(searched(problem, &context, ask))
}
