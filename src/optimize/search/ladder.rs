//! The search for unconstrained, limited and constrained maneuvers: the request of a search, and
//! the interface of its strategies.
//!
//! Every strategy improves candidates, most of them on a coarse grid, and its results are
//! transferred to the requested grid. Fast strategies that nearly always succeed run first
//! (`strategies`).

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::Trajectory;
use crate::optimize::chain::Chain;
use crate::optimize::chain::model::Goal;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::methods::interior_point::chain::family::Family;
use crate::optimize::methods::scp::ScpOptions;
use crate::optimize::search::context::Context;
use crate::optimize::search::found::Found;
use crate::optimize::search::guess::Guess;
use crate::optimize::search::starts::coarse::search_grid;
use crate::optimize::search::starts::wanted_turns;

/// Request of a search: the methods that it may use, and its initial data.
#[derive(Clone)]
pub(super) struct Ask<'a> {
    /// True if shooting may be tried.
    pub shooting: bool,
    /// True if the interior-point method may be tried, or SCP if the settings request it.
    pub convex: bool,
    pub guess: Option<&'a Guess>,
    /// Options of SCP for the last solve, on the requested grid.
    pub along: Option<&'a Trajectory>,
    /// Options of SCP on the requested grid.
    pub last: ScpOptions,
    /// True if a sufficient duration is reported when no plan is found.
    pub advise: bool,
    /// Longest duration of a plan with the objective `goal` \[s\].
    pub goal: Option<Goal>,
    /// Initial paths for the objective `goal`.
    pub longest: f64,
    /// True if the true motion of the result must meet the end (landing).
    pub paths: &'a [Candidate],
    /// True if the result must land.
    pub lands: bool,
    /// Family of terminal states, if the end is not fixed.
    pub family: Option<&'a Family>,
}

impl Ask<'_> {
    /// Returns the request for the same maneuver without limits.
    pub fn of_relaxed(&self) -> Self {
        Self {
            shooting: true,
            convex: false,
            guess: None,
            along: None,
            goal: None,
            paths: &[],
            lands: false,
            family: None,
            ..self.clone()
        }
    }

    /// Returns the request for the interior-point method or SCP alone, with their own initial
    /// paths. `goal` is the objective; `None` for minimum effort.
    pub fn of_goal(goal: Option<Goal>, settings: &Settings) -> Self {
        let last = ScpOptions::default().within(settings.max_iterations);
        Self {
            shooting: false,
            convex: true,
            guess: None,
            along: None,
            last,
            advise: false,
            goal,
            longest: f64::INFINITY,
            paths: &[],
            lands: false,
            family: None,
        }
    }
}

/// A step of the fallback sequence: one strategy, or several that belong together.
pub(super) trait Climb<const N: usize>: Sync {
    /// Returns whether the step applies, given the results so far.
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool;

    /// Runs the step and adds its results.
    fn climb(&self, search: &Search<N>, found: &mut Found<N>);
}

/// All steps of the fallback sequence, in order.
pub(super) type Ladder<const N: usize> = &'static [&'static dyn Climb<N>];

/// A search: a maneuver and a request. It does not change while the strategies run; their results
/// are in [`Found`].
pub(super) struct Search<'a, 'c, const N: usize> {
    pub problem: &'a Problem,
    pub context: &'a Context<'c>,
    pub ask: Ask<'a>,
    /// Numbers of additional full turns to try, in order.
    pub turns: Vec<i32>,
    /// Boundary value problem on the requested grid.
    pub fine: BoundaryValueProblem<'a, N>,
    /// Boundary value problem on the coarse grid, on which shooting searches.
    pub coarse: BoundaryValueProblem<'a, N>,
    ladder: Ladder<N>,
}

impl<'a, 'c, const N: usize> Search<'a, 'c, N> {
    pub fn new(problem: &'a Problem, context: &'a Context<'c>, ask: Ask<'a>, ladder: Ladder<N>) -> Self {
        let turns = wanted_turns(problem);
        let most = turns.iter().copied().max_by_key(|turns| turns.abs()).unwrap_or(0);
        let fine = BoundaryValueProblem::new(problem, problem.steps);
        let coarse = fine.on_steps(search_grid(problem, most, fine.dynamics.is_even()));
        let (fine, coarse) = (fine.heard_by(context), coarse.heard_by(context));
        Self { problem, context, ask, turns, fine, coarse, ladder }
    }

    /// Creates a search for another maneuver and request, with the same context. This search uses
    /// its result.
    pub fn of<'b>(&self, problem: &'b Problem, ask: Ask<'b>) -> Search<'b, 'c, N>
    where
        'a: 'b,
    {
        Search::new(problem, self.context, ask, self.ladder)
    }

    /// Runs the strategies in order, and returns the results.
    pub fn climb(&self) -> Found<N> {
        let mut found = Found::default();
        for step in self.ladder {
            if step.applies(self, &found) {
                step.climb(self, &mut found);
            }
        }
        found
    }

    pub fn stopped(&self) -> bool {
        self.context.interrupt().is_some()
    }

    /// Returns whether shooting searches for extremals without limits.
    pub fn is_free(&self) -> bool {
        self.ask.shooting && !self.fine.dynamics.is_limited()
    }

    /// Returns the chain of the maneuver on `steps` steps, with the given duration, or with a free
    /// duration if the objective requires it.
    pub fn chain(&self, steps: usize) -> Chain {
        match &self.ask.goal {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, goal),
        }
    }

    /// Returns the chain with the given duration. It has the same limit rows as the chain with a
    /// free duration.
    pub fn chain_of_given_duration(&self, steps: usize) -> Chain {
        match self.ask.goal.as_ref().and_then(Goal::in_given_duration) {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, &goal),
        }
    }
}
