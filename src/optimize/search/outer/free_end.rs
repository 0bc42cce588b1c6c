//! The best terminal states of a maneuver on a target. The roll, and the arrival time for a moving
//! target, are unknowns of the interior-point method
//! ([`crate::optimize::methods::interior_point::chain`]).
//!
//! A plan found in this way is stationary in roll and time, because its terminal equations contain
//! these unknowns. The minimum cost over the roll has several minima; paths to three rolls are
//! therefore tried, each with its bends and detours. One solve from each path finds a cheaper end
//! than a solve to each of 24 given rolls (`cargo run --release -p evidence -- rolls`).

use crate::Matrix3;
use crate::maneuver::aim::{Aim, Ends};
use crate::maneuver::constraint::{Constraint, Rule};
use crate::maneuver::objective::Objective;
use crate::maneuver::problem::{Motion, Problem};
use crate::maneuver::settings::{Settings, Thoroughness};
use crate::maneuver::solution::{Outcome, Rival, Trajectory};
use crate::optimize::chain::model::Goal;
use crate::optimize::chain::{Chain, path};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::methods::interior_point::chain::family::Family;
use crate::optimize::methods::interior_point::method::worst_violation;
use crate::optimize::methods::interior_point::tuning::Tuning;
use crate::optimize::methods::method::Attempt;
use crate::optimize::search::asked::{goes_round_as_asked, way};
use crate::optimize::search::context::Context;
use crate::optimize::search::found::Found;
use crate::optimize::search::given_duration::search_of;
use crate::optimize::search::ladder::{Ask, Search};
use crate::optimize::search::outer::of_discrete_optima;
use crate::optimize::search::starts::coarse::chain_steps;
use crate::optimize::search::starts::detour::detours;
use crate::optimize::search::starts::first_duration;
use crate::optimize::search::strategies::chains::{
    carry, descend, distinct, optimised_along, unlimited_paths,
};
use crate::optimize::search::strategies::seeds;
use crate::optimize::search::{Guess, Observer};

/// Rolls of the initial paths, as fractions of the allowed roll to either side. If the roll is free
/// they are 120° apart. If the roll is limited to a band, they are inside it.
const ROLLS: [f64; 3] = [0.0, 2.0 / 3.0, -2.0 / 3.0];

/// A terminal state that a plan has found, and the cost of the plan.
#[derive(Clone, Debug)]
pub struct Reached {
    /// Arrival time of the plan \[s\].
    pub time: f64,
    /// Attitude at the end of the plan.
    pub attitude: Matrix3,
    /// The plan in its form as a rival of another plan.
    pub rival: Rival,
    /// The path of the plan as a guess; `None` if the plan is not on the requested grid.
    pub known: Option<Guess>,
}

/// Result of a search for terminal states: the states, the cheapest first, and the reason if the
/// search was stopped.
pub struct FreeEnd {
    pub reached: Vec<Reached>,
    pub stopped: Option<Outcome>,
}

/// Finds the minimum-cost terminal states on `aim`, on the steps of `problem`. The search starts
/// from the rolls of `ends`, or only near the end of the motion `known`, which is almost the plan.
pub fn found(
    problem: &Problem,
    (aim, ends): (&Aim, &Ends),
    known: Option<&Trajectory>,
    settings: &Settings,
    observer: &mut dyn Observer,
) -> FreeEnd {
    // Terminal states are compared by their discrete optima; the plan to the best one lands.
    let settings = of_discrete_optima(settings);
    let context = Context::new(&settings, observer);
    let reached = match problem.motion {
        Motion::Attitude => of_dimension::<6>(problem, (aim, ends), known, &context),
        Motion::RigidBody => of_dimension::<12>(problem, (aim, ends), known, &context),
    };
    FreeEnd { reached, stopped: context.interrupt() }
}

/// A maneuver as the interior-point method optimises it, with the free part of its terminal state
/// as unknowns.
pub struct Posed {
    /// The maneuver to the end of each initial path, with a given duration as the unit of time. Its
    /// objective is effort; any other objective is in `goal`.
    pub faced: Vec<Problem>,
    pub goal: Option<Goal>,
    pub family: Option<Family>,
}

impl Posed {
    /// Poses a maneuver to one end, or to a family of ends; `None` if the directions do not
    /// determine the family.
    pub fn of(problem: &Problem, on: Option<(&Aim, &Ends)>) -> Option<Self> {
        let Some((aim, ends)) = on else {
            let (stated, goal) = stated(problem);
            return Some(Self { faced: vec![stated], goal, family: None });
        };
        let rolls = if ends.has_roll() { &ROLLS[..] } else { &ROLLS[..1] };
        let (stated, goal) = stated(&problem.facing(ends, 0.0));
        let faced: Vec<Problem> =
            rolls.iter().map(|part| stated.facing(ends, part * ends.within())).collect();
        let family = Family::of(problem, aim, &faced[0].end.attitude)?;
        Some(Self { faced, goal, family: Some(family) })
    }

    /// Returns the request of a search for the posed maneuver.
    pub fn ask(&self, settings: &Settings) -> Ask<'_> {
        Ask { family: self.family.as_ref(), ..Ask::of_goal(self.goal.clone(), settings) }
    }

    /// Returns the number of steps of the grid on which optima are compared.
    pub fn steps(&self) -> usize {
        self.faced.iter().map(chain_steps).max().unwrap_or(Problem::MIN_STEPS)
    }

    /// Returns initial paths to its ends, on the grid of a chain.
    pub fn paths<const N: usize>(&self, search: &Search<N>, coarse: &Chain) -> Vec<Candidate> {
        if search.problem.ends_in_any_attitude() {
            return unlimited_paths(search, coarse);
        }
        // Different rolls lead to different optima, as bends do, so the paths to other rolls are
        // not bent.
        let bends = |index: usize| match search.context.settings.search {
            Thoroughness::Default if index > 0 => Thoroughness::Quick,
            asked => asked,
        };
        let to_each = |(index, faced): (usize, &Problem)| {
            let to = Problem { end: faced.end, ..search.problem.clone() };
            seeds::of(&search.of(&to, search.ask.clone()), coarse.model.steps, bends(index))
        };
        self.faced.iter().enumerate().flat_map(to_each).collect()
    }
}

/// Finds the terminal states, in the tangent dimension `N` of the motion.
fn of_dimension<const N: usize>(
    problem: &Problem,
    (aim, ends): (&Aim, &Ends),
    known: Option<&Trajectory>,
    context: &Context,
) -> Vec<Reached> {
    let Some(posed) = Posed::of(problem, Some((aim, ends))) else { return Vec::new() };
    let search = search_of::<N>(&posed.faced[0], context, posed.ask(context.settings));
    let mut found = Found::default();
    if let Some(known) = known {
        let fine = search.chain(problem.steps);
        if let Some(attempt) = optimised_along(&search, &fine, known) {
            found.keep(attempt);
        }
    } else {
        let coarse = search.chain(posed.steps());
        let mut paths = posed.paths(&search, &coarse);
        if search.problem.constraints.iter().any(is_cone) {
            paths = past_cones(&search, &coarse, paths);
        }
        paths.into_iter().for_each(|path| descend(&search, &mut found, &coarse, path));
        carry(&search, &mut found, &coarse);
    }
    let told = |plan: Attempt| reached(problem, aim, &search, plan);
    let mut reached: Vec<_> = found.take_plans().into_iter().filter_map(told).collect();
    // Plans in the requested homotopy class come first, and coarse plans last, because their costs
    // are from another grid.
    let rank = |end: &(Kind, Reached)| (!end.0.as_asked, !end.0.fine);
    reached.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.1.rival.cost.total_cmp(&b.1.rival.cost)));
    if reached.first().is_none_or(|(kind, _)| !kind.fine) {
        return Vec::new();
    }
    reached.into_iter().map(|(_, end)| end).collect()
}

/// Returns whether a constraint is a cone.
fn is_cone(constraint: &Constraint) -> bool {
    matches!(constraint.rule, Rule::Pointing(_))
}

/// Returns the paths of the optima without cones and the initial paths, with their detours around
/// the cones. If the cheapest optimum satisfies the cones, nothing costs less, and it is the only
/// path.
fn past_cones<const N: usize>(search: &Search<N>, coarse: &Chain, paths: Vec<Candidate>) -> Vec<Candidate> {
    let mut relaxed = search.problem.clone();
    relaxed.constraints.retain(|constraint| !is_cone(constraint));
    let without = search.of(&relaxed, search.ask.clone());
    let (chain, mut found) = (without.chain(coarse.model.steps), Found::default());
    paths.iter().for_each(|path| descend(&without, &mut found, &chain, path.clone()));
    found.reorder(|plans| distinct(plans, search.context.tuning.one));
    let grid = &coarse.model.dynamics.grid;
    let along = |plan: &Attempt| {
        let candidate = &plan.candidate;
        path(&candidate.provenance.start, grid, candidate.states.iter().map(Point::pose))
    };
    let least = Tuning::roughly().tolerance;
    let keeps =
        |plan: &Attempt| worst_violation(coarse, &plan.candidate).is_some_and(|violation| violation <= least);
    match found.plans() {
        [best, ..] if keeps(best) => vec![along(best)],
        plans => {
            let optima = plans.iter().map(along);
            optima.chain(paths).flat_map(|path| detours(search.problem, path)).collect()
        }
    }
}

/// Properties of a plan: whether it is on the requested grid, and in the requested homotopy class.
struct Kind {
    fine: bool,
    as_asked: bool,
}

/// Returns the maneuver with a given duration and minimum effort as its objective, and the
/// objective that is minimised instead; `None` if that is effort in a given duration.
pub fn stated(given: &Problem) -> (Problem, Option<Goal>) {
    let objective = &given.objective;
    let goal = Goal { objective: objective.clone() };
    match given.duration.known() {
        known if objective.switches() => {
            let duration = known.unwrap_or_else(|| first_duration::of_time(given));
            let effort = Objective::default();
            (Problem { objective: effort, ..given.clone().with_duration(duration) }, Some(goal))
        }
        Some(_) => (given.clone(), None),
        None => {
            let longest = given.duration.at_most().unwrap_or(f64::INFINITY);
            let duration = first_duration::of_effort(given, objective.time_price()).min(longest);
            let effort = objective.with_time_price(None);
            (given.clone().with_duration(duration).with_objective(effort), Some(goal))
        }
    }
}

/// Returns the terminal state of a plan, and whether the plan is on the requested grid and in the
/// requested homotopy class.
fn reached<const N: usize>(
    problem: &Problem,
    aim: &Aim,
    search: &Search<N>,
    plan: Attempt,
) -> Option<(Kind, Reached)> {
    let candidate = &plan.candidate;
    let stated = search.problem.seconds();
    let time = problem.duration.known().unwrap_or(stated * candidate.grid.duration());
    let attitude = candidate.states.last()?.attitude.value;
    let ends = problem.ends_on(aim, time).ok()?;
    let faced = search.problem.facing(&ends, ends.nearest(&attitude));
    let own = search.of(&faced, search.ask.clone());
    let cost = match &search.ask.goal {
        None => plan.cost * search.fine.dynamics.units.cost,
        Some(_) => search.chain(candidate.steps()).price(candidate),
    };
    let told = way(&own, candidate);
    let start = format!("roll {:+.1} deg", ends.nearest(&attitude).to_degrees());
    let rival = Rival::new(&start, told.sense, cost, told.turned_deg);
    let fine = candidate.steps() == problem.steps;
    let known = fine.then(|| Guess::of_plan(&search.fine.dynamics, stated, candidate));
    let kind = Kind { fine, as_asked: goes_round_as_asked(&own, candidate) };
    Some((kind, Reached { time, attitude, rival, known }))
}
