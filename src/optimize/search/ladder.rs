//! One search for free, limited and constrained maneuvers: what is asked, and what a rung of its
//! ladder is.
//!
//! Every rung improves candidates, most of them on a coarse grid; what it finds is carried to the
//! requested grid. Cheap rungs that nearly always work come first (`rungs`).

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

/// What a search may do, and what it begins from.
#[derive(Clone)]
pub(super) struct Ask<'a> {
    /// Whether the shooting may be tried.
    pub shooting: bool,
    /// Whether the interior point may be, or SCP where the settings request it.
    pub convex: bool,
    pub guess: Option<&'a Guess>,
    /// A motion to begin from, instead of all other paths.
    pub along: Option<&'a Trajectory>,
    /// How SCP ends on the requested grid.
    pub last: ScpOptions,
    /// Whether a maneuver for which no plan is found is told the duration for which there is one.
    pub advise: bool,
    /// What is minimised in place of the effort (`cheapest`).
    pub goal: Option<Goal>,
    /// The longest duration of a plan with a goal \[s\].
    pub longest: f64,
    /// The paths that it begins from for a goal.
    pub paths: &'a [Candidate],
    /// Whether what is written is made to land.
    pub lands: bool,
    /// The ends, where the end is one of a family.
    pub family: Option<&'a Family>,
}

impl Ask<'_> {
    /// What is asked of the same maneuver without limits.
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

    /// The chain alone, for a goal or the effort, from its own seeds.
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

/// A step of the ladder: a rung, or several that belong together.
pub(super) trait Climb<const N: usize>: Sync {
    /// Whether it is climbed, after what is known.
    fn applies(&self, search: &Search<N>, found: &Found<N>) -> bool;

    /// Adds what it finds to what is known.
    fn climb(&self, search: &Search<N>, found: &mut Found<N>);
}

/// All steps, from the first to the last.
pub(super) type Ladder<const N: usize> = &'static [&'static dyn Climb<N>];

/// A search: what is asked of which maneuver. Nothing of it changes while the ladder is climbed;
/// what is found is [`Found`].
pub(super) struct Search<'a, 'c, const N: usize> {
    pub problem: &'a Problem,
    pub context: &'a Context<'c>,
    pub ask: Ask<'a>,
    /// Turns to try, in order.
    pub turns: Vec<i32>,
    /// On the requested grid.
    pub fine: BoundaryValueProblem<'a, N>,
    /// Where the shooting searches.
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

    /// Another question to the same ladder, whose answer is part of the way to this one.
    pub fn of<'b>(&self, problem: &'b Problem, ask: Ask<'b>) -> Search<'b, 'c, N>
    where
        'a: 'b,
    {
        Search::new(problem, self.context, ask, self.ladder)
    }

    /// Climbs the ladder.
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

    /// Whether the shooting looks for extremals without limits.
    pub fn is_free(&self) -> bool {
        self.ask.shooting && !self.fine.dynamics.is_limited()
    }

    /// The chain of the maneuver on `steps` steps, with the duration that it states or the one that
    /// is sought.
    pub fn chain(&self, steps: usize) -> Chain {
        match &self.ask.goal {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, goal),
        }
    }

    /// The same chain where the duration is the one that is stated: its rows are those of the chain
    /// that seeks it.
    pub fn chain_of_given_duration(&self, steps: usize) -> Chain {
        match self.ask.goal.as_ref().and_then(Goal::in_given_duration) {
            None => Chain::new(self.problem, steps),
            Some(goal) => Chain::with_goal(self.problem, steps, &goal),
        }
    }
}
