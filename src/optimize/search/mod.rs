//! The search: every sense and winding, each up the ladder, what it finds compared.

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
    #[error("the shooting cannot plan this maneuver: {reason}; use method = \"interior_point\" or \"auto\"")]
    NotForShooting {
        /// What it cannot take.
        reason: Obstacle,
    },
    /// SCP minimises the effort alone, in a given duration.
    #[error(
        "SCP plans least effort in a given duration only; leave `method` out or use method = \"interior_point\""
    )]
    NotForScp,
    /// What cannot be asked of a maneuver whose inputs switch or whose duration is sought.
    #[error("this maneuver does not go with the settings: {0}")]
    Unsuited(Misfit),
    /// A grid beyond the memory of SCP.
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

/// What is asked of a maneuver that it does not go with.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Misfit {
    /// A guess, where none is used.
    #[error("it takes no guess: leave it out")]
    Guess,
    /// Costates to polish, where effort in a given duration is not what is minimised.
    #[error("only a maneuver of least effort in a given duration has costates to polish")]
    Polish,
    /// One method by itself, of a maneuver with sets of cones that hold in turns.
    #[error("which set of cones holds when is what a plan finds: no method has it by itself")]
    Turns,
    /// A comparison of the ways to plan inputs that switch.
    #[error("ways are compared on maneuvers whose inputs switch")]
    Ways,
    /// A comparison of shooting and SCP.
    #[error("methods are compared on maneuvers of least effort")]
    Methods,
}

/// Most steps of a plan on the chain: its methods hold all of them at once, in some gigabytes of
/// memory.
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

/// Checks that costates and path of a guess are of use.
fn check_guess(problem: &Problem, guess: Option<&Guess>) -> Result<(), PlanError> {
    let Some(guess) = guess else { return Ok(()) };
    // A path alone is a guess too.
    if !guess.costates.is_empty() || guess.quaternion.is_empty() {
        check_costates(problem, &guess.costates)?;
    }
    if guess.path_is_sound() { Ok(()) } else { Err(PlanError::GuessPath) }
}

fn check_for_scp(problem: &Problem) -> Result<(), PlanError> {
    let steps = problem.steps;
    if steps <= MAX_CONVEX_STEPS { Ok(()) } else { Err(PlanError::TooManySteps { steps }) }
}

/// Whether nothing is to be begun from but the plan of a search that is done.
fn check_for_no_guess(guess: Option<&Guess>) -> Result<(), PlanError> {
    let given = guess.filter(|guess| !guess.is_known());
    given.map_or(Ok(()), |_| Err(PlanError::Unsuited(Misfit::Guess)))
}

/// Checks that settings and guess are such that least time or fuel, or a duration, can be sought on
/// the chain.
fn check_for_chain(problem: &Problem, settings: &Settings, guess: Option<&Guess>) -> Result<(), PlanError> {
    match settings.method {
        Method::Shooting => return Err(PlanError::NotForShooting { reason: Obstacle::EqualSteps }),
        Method::Scp => return Err(PlanError::NotForScp),
        Method::Auto | Method::InteriorPoint => {}
    }
    check_for_no_guess(guess)?;
    check_for_scp(problem)
}

/// Whether the effort is what is minimised, in a given duration.
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

/// Whether the shooting can take what limits a maneuver.
fn check_for_shooting(problem: &Problem) -> Result<(), PlanError> {
    control_law::obstacle(problem).map_or(Ok(()), |reason| Err(PlanError::NotForShooting { reason }))
}

/// Polishes a costate guess, as [`Solution::costates_0`] gives it (SI units; `λ_0` for Lie–Euler,
/// `λ_{−1}` for Lie–Verlet), by the shooting's Newton alone, without the ladder: what the duals of
/// another method need.
///
/// Limits of the inputs act through the saturated control law, so that a guess within Newton's
/// reach is brought to the tolerance in a step or two.
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

/// Polishes `λ_{−1}`, SI units, by Newton alone in `most` steps, without the ladder: what is near
/// an extremal already. The plan is recorded and tested, made to land where `settings` ask for it,
/// and held to the way round that `problem` asks for.
///
/// # Errors
/// [`PlanError`] when problem or settings cannot be used. A Newton that stops is no error.
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

/// Solves a maneuver. The solution says how the solve ended; it is not yet verified.
///
/// The shooting takes limits of the size of the inputs, or of the norm of what they give, through
/// the saturated control law. By default ([`Method::Auto`]) it is tried first wherever it applies;
/// where it finds nothing the interior point does, whose costates then start the shooting once
/// more. Everything else (constraints on pointing or rates, limits of how fast inputs change,
/// reaction wheels) takes the interior point.
///
/// `guess` is tried first: its costates by the shooting, its path by the interior point.
///
/// A plan that is to land takes more steps than [`Problem::steps`] where it needs them and none
/// were given ([`Problem::with_steps`]); how many stands in [`Solution::steps`], and why in
/// [`Solution::chosen`].
///
/// # Errors
/// [`PlanError`] when problem, settings or guess cannot be used. A solver that stops is no error.
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

/// Solves a maneuver, and leaves what it is in continuous time for its best plan.
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

/// A plan that lands, with the true motion at its nodes on record, which is what flies.
fn with_true_motion(problem: &Problem, settings: &Settings, mut found: Solution) -> Solution {
    if settings.target == Target::Discrete {
        // Its discrete motion is at the end that it met.
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
            // A motion that cannot be followed lands nowhere.
            None => found.trajectory.target = None,
        }
    }
    found
}

/// Solves a maneuver on its own number of steps.
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

/// Most steps on which equal steps are tried unasked: ten thousand take the interior point seconds,
/// and memory that is told of no plan of arcs (`cargo run --release -p evidence -- best_known
/// fuel_price_rod 1000`).
const MOST_EQUAL_STEPS: usize = 10_000;

/// The plan of arcs, or that of the interior point on equal steps if it is cheaper. This is tried
/// where there are no arcs, where they are dearer than their certificate and the grid account for,
/// and where the body spins at an end: where inputs are singular no arcs that the grid can hold may
/// be near, and a first path may lead nowhere.
fn or_on_equal_steps(
    problem: &Problem,
    context: &Context,
    found: Solution,
    guess: Option<&Guess>,
) -> Solution {
    let converged = |solution: &Solution| solution.outcome == Outcome::Converged;
    // Arcs that miss the end by round-off alone are the plan, and in less time than the quickest
    // extremal takes there is none.
    let settled =
        if found.trajectory.time.is_empty() { found.shortest.is_some() } else { !switching::is_dear(&found) };
    let settings = context.settings;
    let asked = settings.method == Method::Auto && settings.search != Thoroughness::Quick;
    // Where the motion without inputs turns the body by more than half a turn, there are ways round
    // that smoothed extremals rarely find.
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
    // What was stopped is told as such, with its best iterate.
    let stopped = context.interrupt().is_some() && !converged(&found);
    // Arcs are dearer on their grid than in continuous time: what is another plan is cheaper by
    // more.
    let least = if settled { found.cost * (1.0 - switching::OF_THE_GRID) } else { found.cost };
    let better = stopped || converged(&other) && !(converged(&found) && least <= other.cost);
    let mut chosen = if better { other } else { Solution { solve_time: other.solve_time, ..found } };
    chosen.ladder.splice(0..0, tried);
    chosen
}

/// Solves a maneuver of least effort in a known duration, by shooting, by the interior point, or by
/// SCP where it is requested.
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
    // From here on the clock runs.
    let context = Context::new(settings, observer);
    Ok(searched(
        problem,
        &context,
        Ask { shooting, convex, guess, advise: true, lands: context.lands(), ..Ask::of_goal(None, settings) },
    ))
}

/// Solves a maneuver whose inputs switch by the smoothed law alone: no switching times.
///
/// # Errors
/// [`PlanError`] when problem or settings cannot be used.
#[doc(hidden)]
pub fn solve_smoothed(
    problem: &Problem,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> Result<Solution, PlanError> {
    check(problem, settings)?;
    Ok(switching::solve_smoothed(problem, &Context::new(settings, observer)))
}

/// Solves a maneuver by SCP, limited or not, from its own seeds or along a trajectory on the
/// same grid.
///
/// Without `polish` the iteration on the requested grid goes on to its own convergence, and Newton
/// does not touch what it returns: the costates are the duals of the last subproblem, and
/// [`Solution::optimality`] has the residual of all the conditions.
///
/// # Errors
/// [`PlanError`] when problem or settings cannot be used.
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
